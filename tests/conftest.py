"""Fixtures of several modules."""

import gc
import os

# Workers of pytest-xdist are on all cores already. OpenBLAS would start as many threads again in each of them and in
# each process that a test starts, which wait for work in loops: a third of the time that importing numpy takes.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# Else argparse looks for translations of each of its words in the file system, again for each command that is called.
os.environ.setdefault("LANGUAGE", "C")

import pytest
from sample_robots import SRDF, URDF

import plannercheck as pc

# Processor time of a test, its processes included, s. What needs more is a run of its own, see tests/README.md.
MOST_SECONDS = 30.0

gc.disable()  # while tests are collected


def pytest_collection_finish():
    """Tests live until the end. Garbage collection, which benchmarks ask for often, need not go through all of them."""
    gc.collect()
    gc.freeze()
    gc.enable()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item):
    """A test that takes too long fails: ten thousand of them have to end within ten minutes."""
    before = sum(os.times()[:4])
    result = yield
    taken = sum(os.times()[:4]) - before
    if taken > MOST_SECONDS and not item.get_closest_marker("agreement") and "LD_PRELOAD" not in os.environ:
        pytest.fail(f"takes {taken:.0f} s of processor time, more than {MOST_SECONDS:.0f} s")
    return result


@pytest.fixture(scope="module", autouse=True)
def settings_are_left_as_they_were():
    """A run that turned the cache off for its whole process made all tests after it slower, and none failed."""

    def settings():
        return {name: value for name, value in os.environ.items() if name.startswith("PLANNERCHECK")}

    before = settings()
    yield
    assert settings() == before


@pytest.fixture(scope="session")
def panda():
    """The shipped Panda."""
    return pc.Robot.load("panda")


@pytest.fixture(scope="module")
def checker(panda):
    """The Panda before the bookshelf, unless a module has another."""
    return pc.Checker(panda, pc.Scene.load("bookshelf"))


@pytest.fixture
def arm(tmp_path):
    """Paths of a small URDF and its SRDF."""
    (tmp_path / "arm.urdf").write_text(URDF)
    (tmp_path / "arm.srdf").write_text(SRDF)
    return tmp_path / "arm.urdf", tmp_path / "arm.srdf"
