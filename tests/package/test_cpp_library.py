"""The C++ library, used by a project in a folder of its own: shared, the installed one if there is one, and static.

The library is built not optimised here.

`tests/benchmarks/cpp_library.py` does so, and compares verdicts, trajectories and distances with Python's.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from plannercheck.common.core import core

SCRIPT = Path(__file__).parents[1] / "benchmarks" / "cpp_library.py"


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """What the script prints: of the shared library, then of the static one."""
    missing = [name for name in ("cmake", "ninja", "c++", "objcopy") if shutil.which(name) is None]
    if missing:
        pytest.skip(f"there is no {', '.join(missing)}")
    folder = tmp_path_factory.mktemp("library")
    sizes = ["--levels", "v2", "--quick", "--states", "2000", "--motions", "200", "--folder", str(folder)]
    environment = {name: value for name, value in os.environ.items() if name != "PLANNERCHECK_LEVEL"}  # Python's own
    out = []
    installed = (Path(core.__file__).parent / "cmake").is_dir()
    for kind in (["--installed"] if installed else [], ["--static"]):
        command = [sys.executable, SCRIPT, *sizes, *kind]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
        out.append(done.stdout)
    return out


@pytest.mark.parametrize("kind", [0, 1], ids=["shared", "static"])
def test_a_project_of_its_own_gets_the_bits_of_python(told, kind):
    assert told[kind].startswith(("libplannercheck.so", "libplannercheck.a")[kind])
    assert "2000 states, 200 motions and the rest: the same bits" in told[kind]
    assert "thread 3: " in told[kind]
    assert "check: panda in bookshelf" in told[kind]
    assert "edits of 2000 states: as they have to be" in told[kind]
    assert "92 faults: the same sentences" in told[kind]
