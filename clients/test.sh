#!/usr/bin/env bash
# Test the clients against the service's program.
#
#   clients/test.sh BINARY VENV_DIR
#
# BINARY is landmarkd; VENV_DIR is made, or made anew if the packages' needs changed. Needs Python 3.10 or newer, and for
# the types in TypeScript Node 20 or newer with npm; without npm these are left out, and it says so. ROS isn't needed.
set -euo pipefail

clients="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
[[ $# -eq 2 ]] || { sed -n '2,7p' "$0" >&2; exit 2; }
tests="$(realpath "$clients/../tests")"
binary="$(realpath "$1")"
mkdir -p "$2"
venv="$(realpath "$2")"
export LANDMARKD_BINARY="$binary" PYTHONDONTWRITEBYTECODE=1

# A copy, so that nothing is built or written in the tree.
work="$(mktemp --directory)"
trap 'rm -rf "$work"' EXIT
cp -r "$clients" "$work/clients"
rm -rf "$work/clients/typescript/node_modules" "$work/clients/typescript/landmarkd.d.ts"
rm -rf "$work/clients/python/build" "$work/clients/python/landmarkd/_generated"
export LANDMARKD_DOCUMENT="${LANDMARKD_DOCUMENT:-$clients/../openapi/landmarkd.json}"
[[ -f "$LANDMARKD_DOCUMENT" ]] || { echo "the service's document isn't at $LANDMARKD_DOCUMENT" >&2; exit 1; }
cd "$work/clients"

# What writes and reads bags, beside the program.
bags=(rosbags==0.11.9 mcap==1.6.0 mcap-ros2-support==0.6.0)
wants="$(cat python/pyproject.toml ros2/landmarkd_ros/setup.py vda5050/pyproject.toml - <<<"${bags[*]}" | sha256sum)"
if [[ "$(cat "$venv/.wants" 2>/dev/null)" != "$wants" ]]; then
    python3 -m venv --clear "$venv"
    "$venv/bin/pip" install --quiet --disable-pip-version-check "./python[test,lint]" "./ros2/landmarkd_ros[test]" "./vda5050[test]" "${bags[@]}"
    echo "$wants" >"$venv/.wants"
fi
# The package as it is installed, not as it lies here.
"$venv/bin/pip" install --quiet --disable-pip-version-check --force-reinstall --no-deps ./python
rm -rf python/build ros2/landmarkd_ros/build vda5050/build
mv python/landmarkd "$work/source"

failed=0
(cd python && "$venv/bin/python" -m pytest -p no:cacheprovider tests) || failed=1
(cd ros2/landmarkd_ros && "$venv/bin/python" -m pytest -p no:cacheprovider test) || failed=1
(cd vda5050 && "$venv/bin/python" -m pytest -p no:cacheprovider tests) || failed=1
(cd "$tests/bags" && PYTHONPATH="$work/clients/python/tests" "$venv/bin/python" -m pytest -p no:cacheprovider -c /dev/null --rootdir . .) || failed=1

# Lints and types of the sources, beside the generated part.
mv "$work/source" python/landmarkd
installed="$("$venv/bin/python" -c 'import landmarkd; print(landmarkd.__path__[0])')"
cp -r "$installed/_generated" python/landmarkd/_generated
"$venv/bin/ruff" check --no-cache python document.py ros2 vda5050 || failed=1
"$venv/bin/ruff" format --no-cache --check python document.py ros2 vda5050 || failed=1
"$venv/bin/ruff" check --no-cache --config ruff.toml --extend-ignore D103 "$tests/bags" || failed=1
"$venv/bin/ruff" format --no-cache --config ruff.toml --check "$tests/bags" || failed=1
(cd python && "$venv/bin/mypy" --cache-dir "$venv/.mypy") || failed=1
(cd vda5050 && "$venv/bin/mypy" --cache-dir "$venv/.mypy") || failed=1
# ROS isn't here: what comes from it may be anything.
(cd ros2/landmarkd_ros && "$venv/bin/mypy" --cache-dir "$venv/.mypy" --strict --ignore-missing-imports landmarkd_ros) || failed=1

if command -v npm >/dev/null; then
    (cd typescript && npm ci --no-progress --loglevel error && npm run --silent check && echo "typescript: compiles") || failed=1
else
    echo "typescript: npm isn't here, so its types were NOT checked"
fi
exit "$failed"
