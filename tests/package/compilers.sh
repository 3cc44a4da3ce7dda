#!/usr/bin/env bash
# The oldest compilers that the documentation names, GCC 11 and Clang 14, as far as they are installed; and each source
# on its own, so that none leans on what another one includes.
#
#   tests/package/compilers.sh           all sources of a target as one through each of these compilers, without code:
#                                        in .ci/run
#   tests/package/compilers.sh --alone   each source through the machine's own compiler, without code: minutes of a core,
#                                        for changes of what is included
#   tests/package/compilers.sh --build   builds with each for level v3 and compares the hashes of verdicts
#                                        (level_digest.py) with those of the build that is imported: minutes
#
# Warnings are errors. PYTHON names the interpreter, whose environment has plannercheck's dependencies and nanobind.
set -euo pipefail
cd "$(dirname "$0")/../.."

python=${PYTHON:-$(command -v python)}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

configure() {  # compiler, level, folder, other options
  cmake -S plannercheck/cpp -B "$3" -DCMAKE_CXX_COMPILER="$1" -DPLANNERCHECK_LEVELS="$2" -DPLANNERCHECK_WERROR=ON \
    -DCMAKE_EXPORT_COMPILE_COMMANDS=ON -DPython_EXECUTABLE="$python" "${@:4}" > /dev/null
}

# The build's own commands, with the output replaced; nanobind's own sources are not ours to check.
check_sources() {  # folder
  "$python" - "$1/compile_commands.json" << 'CODE'
import json, pathlib, shlex, subprocess, sys

for entry in json.loads(pathlib.Path(sys.argv[1]).read_text()):
    command = shlex.split(entry["command"])
    output = command.index("-o")
    if "nanobind-static" in command[output + 1]:
        continue
    command[output : output + 2] = ["-fsyntax-only"]
    subprocess.run(command, cwd=entry["directory"], check=True)
CODE
}

# Where headers choose by the instruction set, their branches for AVX have to stand alone as well.
check_branches() {  # level
  for header in $(grep -lE '__(AVX|FMA)' plannercheck/cpp/*/*.hpp); do
    c++ -std=c++20 -march=x86-64-"$1" -Wall -Wextra -Wconversion -Werror -fsyntax-only -I plannercheck/cpp \
      -include "$header" -x c++ /dev/null
  done
}

digest() {  # folder of the package
  PYTHONPATH=$1 PLANNERCHECK_CACHE=0 "$python" tests/package/level_digest.py
}

build_and_compare() {  # compiler, folder
  cmake --build "$2" --parallel "${JOBS:-1}" > /dev/null
  mkdir "$2/package"
  cp -r plannercheck robots configs "$2/package"
  rm -f "$2"/package/plannercheck/*.so
  cp "$2"/*.so "$2/package/plannercheck"
  [ "$(digest "$2/package")" = "$(digest "${REFERENCE:-$PWD}")" ] || { echo "$1: other verdicts" >&2; exit 1; }
}

if [ "${1:-}" = --alone ]; then
  case $(uname -m) in x86_64 | amd64) level=v2 ;; *) level=plain ;; esac
  # The lowest level: reading the intrinsics of higher ones takes as long as reading all else, in each source again.
  configure c++ "$level" "$work/alone" -DCMAKE_UNITY_BUILD=OFF
  check_sources "$work/alone"
  if [ "$level" = v2 ]; then
    check_branches v3
    check_branches v4
  fi
  echo "c++: takes each source on its own"
  exit
fi
for compiler in g++-11 clang++-14; do
  command -v "$compiler" > /dev/null || { echo "$compiler is not installed"; continue; }
  if [ "${1:-}" = --build ]; then
    configure "$compiler" v3 "$work/$compiler"
    build_and_compare "$compiler" "$work/$compiler"
    echo "$compiler: builds, the same verdicts"
  else
    configure "$compiler" "v4;plain" "$work/$compiler"  # AVX-512's lanes, and what other processors have
    check_sources "$work/$compiler"
    echo "$compiler: takes every source"
  fi
done
