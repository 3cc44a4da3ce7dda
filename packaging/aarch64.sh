#!/usr/bin/env bash
# The core and the C++ library for aarch64, built and run on an x86-64 machine with Debian 12, as root.
#
#   packaging/aarch64.sh FOLDER            FOLDER is made, holds 1.5 GB, and can be given again
#   packaging/aarch64.sh FOLDER library    the C++ library alone, which needs no arm64 Python
#
# The library judges states and motions of prepared cells, with the bits of this machine's Python (cpp_library.py).
# Python takes GCC's cross compiler, QEMU's user mode, Debian's arm64 Python 3.11 (unpacked, never installed) and the arm64
# wheels of plannercheck's dependencies. It compares the core's hashes from the same inputs with those of this machine, and
# shows those of level_digest.py, whose inputs come from NumPy and Pinocchio on each machine. PYTHON has to be 3.11.
set -euo pipefail
here=$(cd "$(dirname "$0")/.." && pwd)
mkdir -p "$1"
work=$(cd "$1" && pwd)
python=${PYTHON:-$(command -v python)}
root=$work/root site=$work/site package=$work/package suffix=cpython-311-aarch64-linux-gnu

apt-get install -y -qq g++-aarch64-linux-gnu qemu-user-static debootstrap > /dev/null
PYTHONPATH=$here "$python" "$here/tests/benchmarks/cpp_library.py" --cross aarch64 --states "${STATES:-20000}" \
  --motions "${MOTIONS:-2000}" --folder "$work/library"
[ "${2:-}" = library ] && exit

if [ ! -e "$root/usr/bin/python3.11" ]; then
  debootstrap --foreign --arch=arm64 --variant=minbase --include=python3.11,libpython3.11-dev,libstdc++6,libgomp1 \
    bookworm "$root" > "$work/debootstrap.log"
  for deb in "$root"/var/cache/apt/archives/*.deb; do dpkg -x "$deb" "$root"; done
fi
if [ ! -d "$site" ]; then
  platforms=(--platform manylinux_2_28_aarch64 --platform manylinux_2_27_aarch64 --platform manylinux_2_17_aarch64 --platform manylinux2014_aarch64)
  "$python" -m pip install -q --target "$site" --only-binary=:all: "${platforms[@]}" --python-version 3.11 \
    --implementation cp --abi cp311 --abi abi3 --abi none numpy pin example-robot-data ompl pyyaml platformdirs shapely
fi

cmake -S "$here/plannercheck/cpp" -B "$work/build" -DCMAKE_SYSTEM_NAME=Linux -DCMAKE_SYSTEM_PROCESSOR=aarch64 \
  -DCMAKE_CXX_COMPILER=aarch64-linux-gnu-g++ -DCMAKE_CXX_FLAGS="-idirafter $root/usr/include" -DPLANNERCHECK_WERROR=ON \
  -DPython_EXECUTABLE="$python" -DPython_INCLUDE_DIR="$root/usr/include/python3.11" > /dev/null
cmake --build "$work/build" --parallel "${JOBS:-1}" > /dev/null
rm -rf "$package" && mkdir "$package"
cp -r "$here/plannercheck" "$here/robots" "$here/configs" "$package"
rm -f "$package"/plannercheck/*.so
cp "$work/build/libplannercheck.so" "$package/plannercheck"
for name in _core_plain _oracle; do  # the build names them after this machine's Python
  cp "$work/build/$name".*.so "$package/plannercheck/$name.$suffix.so"
done

export PLANNERCHECK_CACHE=0
emulated() {
  PYTHONHOME=/usr PYTHONPATH=$package:$site:$site/cmeel.prefix/lib/python3.11/site-packages \
    qemu-aarch64-static -L "$root" "$root/usr/bin/python3.11" "$@"
}
ours=$(PYTHONPATH=$here "$python" "$here/tests/package/digest_of_given_inputs.py" write "$work/inputs.npz")
theirs=$(emulated "$here/tests/package/digest_of_given_inputs.py" read "$work/inputs.npz")
PYTHONPATH=$here "$python" "$here/tests/package/level_digest.py"
emulated "$here/tests/package/level_digest.py"
[ "$ours" = "$theirs" ] && echo "from the same inputs: the same bits" || { echo "from the same inputs: $ours, $theirs"; exit 1; }
