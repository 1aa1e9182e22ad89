#!/bin/sh
# The console as a person uses it, in a real browser: tests/browser/run.sh BINARY [file.test.mjs …]
#
# Needs Node 20 and a Chromium (/usr/bin/chromium, or CHROMIUM says where). Each file starts the binary over a folder of its
# own on a port that the system chooses, and ends it. LANDMARKD_SCREENSHOTS names a folder for pictures of all pages.
set -eu
[ $# -ge 1 ] || { sed -n '2,5s/^# \{0,1\}//p' "$0"; exit 2; }
LANDMARKD_BINARY=$(realpath "$1")
shift
[ -x "$LANDMARKD_BINARY" ] || { echo "$LANDMARKD_BINARY can't be run" >&2; exit 2; }
export LANDMARKD_BINARY
[ -z "${LANDMARKD_SCREENSHOTS:-}" ] || { mkdir -p "$LANDMARKD_SCREENSHOTS"; LANDMARKD_SCREENSHOTS=$(realpath "$LANDMARKD_SCREENSHOTS"); export LANDMARKD_SCREENSHOTS; }
cd "$(dirname "$0")"
[ node_modules/.package-lock.json -nt package-lock.json ] || npm ci --no-audit --no-fund
[ $# -ge 1 ] || set -- *.test.mjs
exec node --test --test-concurrency=2 --test-timeout=120000 --test-reporter=spec "$@"
