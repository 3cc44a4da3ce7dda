"""Whether a wheel holds what it should, and nothing else: `python packaging/check_wheel.py WHEEL`.

Out: its size and that of its largest files; an error that names what is missing or too much.
"""

import re
import sys
import zipfile
from pathlib import Path, PurePosixPath

LEVELS = {"x86_64": ("v2", "v3", "v4"), "aarch64": ("plain",)}
LIBRARY = "plannercheck/libplannercheck"
NEEDED = (
    "plannercheck/py.typed",
    "plannercheck/common/_core.pyi",
    "plannercheck/include/plannercheck/checker.hpp",
    "plannercheck/cmake/plannercheck-config.cmake",
    "plannercheck/view/viewer.html",
    "plannercheck/data/robots/panda.yaml",
    "plannercheck/data/robots/pieces/LICENSE-baxter",
    "plannercheck/data/configs/bookshelf.yaml",
    "*.dist-info/licenses/LICENSE",
    "*.dist-info/licenses/packaging/licenses/nanobind.txt",
    "*.dist-info/licenses/packaging/licenses/robin-map.txt",
    "*.dist-info/entry_points.txt",
)
STRANGE = re.compile(r"\.(o|a|pyc)$|^(tests|docs|packaging|build)/|^plannercheck/cpp/")


def main(path: Path) -> int:
    """Prints sizes, or what is wrong."""
    with zipfile.ZipFile(path) as wheel:
        files = {PurePosixPath(member.filename): member for member in wheel.infolist()}
    (processor,) = [name for name in LEVELS if path.stem.endswith(name)]
    modules = {str(name).split(".")[0] for name in files if name.suffix == ".so"}
    wanted = {f"plannercheck/_core_{level}" for level in LEVELS[processor]} | {"plannercheck/_oracle", LIBRARY}
    missing = [each for each in NEEDED if not any(name.match(each) for name in files)] + sorted(wanted - modules)
    too_much = [str(name) for name in files if STRANGE.search(str(name))] + sorted(modules - wanted)
    print(f"{path.name}: {path.stat().st_size / 1e6:.1f} MB in {len(files)} files; unpacked, the largest:")
    for name in sorted(files, key=lambda name: -files[name].file_size)[:6]:
        print(f"  {files[name].file_size / 1e6:6.2f} MB  {name}")
    for what, names in (("missing", missing), ("too much", too_much)):
        if names:
            print(f"{what}: {', '.join(names)}")
    return 1 if missing or too_much else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
