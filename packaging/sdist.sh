#!/usr/bin/env bash
# The source distribution, and its installation without a network from its declared requirements.
#
#   packaging/sdist.sh FOLDER [OPTIONS OF PIP]       e.g. --config-settings=cmake.define.PLANNERCHECK_LEVELS=native
#
# Out: FOLDER/plannercheck-*.tar.gz, its size, and the time of compiling and installing it in a network namespace of its
# own, from files that pip has downloaded before: what [build-system] requires, what scikit-build-core adds (CMake and
# Ninja, where the machine has none), and the dependencies. Then the demo runs, there too.
set -euo pipefail
mkdir -p "$1"
folder=$(cd "$1" && pwd)
here=$(cd "$(dirname "$0")/.." && pwd)
python=${PYTHON:-$(command -v python3)}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
TIMEFORMAT='%lR, %lU of processor time'

"$python" -m venv "$work/tools"
"$work/tools/bin/pip" install -qq build
"$work/tools/bin/python" -m build -q --sdist --outdir "$work/sdist" "$here" > /dev/null
sdist=$(ls "$work"/sdist/*.tar.gz)
echo "$(basename "$sdist"): $(du -k "$sdist" | cut -f1) kB in $(tar -tzf "$sdist" | wc -l) files"

tar -xzf "$sdist" -C "$work" --strip-components=1 --wildcards '*/pyproject.toml'
"$work/tools/bin/pip" install -qq tomli
"$work/tools/bin/python" - "$work" > "$work/requirements.txt" << 'END'
import pathlib, sys
import tomli

project = tomli.loads(pathlib.Path(sys.argv[1], "pyproject.toml").read_text("utf-8"))
print(*project["build-system"]["requires"], "cmake", "ninja", *project["project"]["dependencies"], sep="\n")
END
"$work/tools/bin/pip" download -qq --only-binary :all: --dest "$work/files" --requirement "$work/requirements.txt"
echo "downloaded: $(ls "$work/files" | wc -l) files, $(du -sm "$work/files" | cut -f1) MB"

"$python" -m venv "$work/fresh"
[ "$(id -u)" = 0 ] && alone=(unshare --net) || alone=(unshare --net --map-root-user)
offline() { "${alone[@]}" "$@"; }
if offline "$python" -c 'import socket; socket.create_connection(("192.0.2.1", 80), 1)' 2> /dev/null; then exit 1; fi
printf 'pip install --no-index: '
{ time offline "$work/fresh/bin/pip" install -q --no-index --find-links "$work/files" "${@:2}" "$sdist"; } 2>&1
printf 'plannercheck demo: '
{ time offline "$work/fresh/bin/plannercheck" demo > "$work/demo.log" 2>&1; } 2>&1 || { cat "$work/demo.log"; exit 1; }
mv "$sdist" "$folder"
echo "$folder/$(basename "$sdist")"
