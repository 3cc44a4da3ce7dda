#!/usr/bin/env bash
# The C++ library as a package of colcon (plannercheck/cpp/package.xml), and the examples as a package that needs it.
#
#   packaging/colcon.sh FOLDER [OPTIONS OF COLCON]       e.g. --packages-select plannercheck
#
# colcon is PyPI's; no ROS is needed.
set -euo pipefail
mkdir -p "$1"
folder=$(cd "$1" && pwd)
here=$(cd "$(dirname "$0")/.." && pwd)
python3 -m venv "$folder/tools"
"$folder/tools/bin/pip" install -qq cmake colcon-cmake colcon-ros colcon-metadata colcon-package-selection
export PATH=$folder/tools/bin:$PATH
cd "$folder"
colcon build --base-paths "$here" "${@:2}"
find install -name 'libplannercheck.so' -o -name 'checker.hpp' -o -name plannercheck-config.cmake
