#!/usr/bin/env bash
# A wheel of this machine's Python, and what auditwheel says of it: `tests/package/wheel.sh FOLDER`. auditwheel is PyPI's.
set -euo pipefail
mkdir -p "$1"
folder=$(cd "$1" && pwd)
cd "$(dirname "$0")/../.."
python=${PYTHON:-$(command -v python)}
"$python" -m pip wheel -q --no-deps --wheel-dir "$folder" "${@:2}" .
for wheel in "$folder"/plannercheck-*.whl; do "$python" -m auditwheel show "$wheel"; done
