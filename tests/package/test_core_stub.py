"""The core's types for type checkers: plannercheck/common/_core.pyi is what `nanobind.stubgen` makes of the core.

After a change of the bindings: `python tests/package/test_core_stub.py`.
"""

import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

from plannercheck.common.core import core

STUB = Path(__file__).parents[2] / "plannercheck" / "common" / "_core.pyi"


def write_stub(path: Path) -> None:
    options = ["-i", str(Path(str(core.__file__)).parent), "-m", core.__name__.rpartition(".")[2]]
    subprocess.run(
        [sys.executable, "-m", "nanobind.stubgen", *options, "--exclude-values", "-q", "-o", str(path)], check=True
    )


@pytest.mark.skipif(importlib.util.find_spec("nanobind") is None, reason="needs nanobind, of the extra `dev`")
def test_the_stub_is_that_of_the_core(tmp_path: Path) -> None:
    write_stub(tmp_path / "made.pyi")
    assert (tmp_path / "made.pyi").read_text() == STUB.read_text()


if __name__ == "__main__":
    write_stub(STUB)
