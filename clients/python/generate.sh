#!/usr/bin/env bash
# Make landmarkd/_generated from the service's OpenAPI document.
#
#   ./generate.sh            writes landmarkd/_generated
#   ./generate.sh FOLDER     writes FOLDER instead
#
# The generator and the formatter stand in pyproject.toml, pinned, as the extra "generate": pip install '.[generate]' into
# the environment whose python is the first on the PATH, or the one that PYTHON names.
set -euo pipefail

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
target="${1:-$here/landmarkd/_generated}"
document="${LANDMARKD_DOCUMENT:-$here/../../openapi/landmarkd.json}"
python="${PYTHON:-python3}"
PATH="$("$python" -c 'import sysconfig; print(sysconfig.get_path("scripts"))'):$PATH"

work="$(mktemp --directory)"
trap 'rm -rf "$work"' EXIT
"$python" "$here/../document.py" "$document" "$work/document.json"
log="$work/log"
openapi-python-client generate --path "$work/document.json" --meta none --config "$here/generate.yaml" \
    --output-path "$work/_generated" --fail-on-warning >"$log" 2>&1 || { cat "$log" >&2; exit 1; }
rm -rf "$work/_generated/.ruff_cache" "$target"
mkdir -p "$(dirname "$target")"
cp -r "$work/_generated" "$target"
