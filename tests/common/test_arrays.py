"""Groups of equal values, beside numpy's; masked arrays and truth values, which NumPy reads, are refused everywhere."""

import ast
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.common.arrays import distinct, distinct_rows, distinct_values, grouped, named_numbers
from plannercheck.ompl import plan

PACKAGE = Path(pc.__file__).parent
RNG = np.random.default_rng(0)
ARRAYS = {
    "whole numbers": RNG.integers(-3, 4, size=(40, 3)),
    "one column": RNG.integers(0, 5, size=(17, 1)).astype(np.int32),
    "floats with both zeros": RNG.choice([-0.0, 0.0, 1.5, -2.0, np.inf], size=(30, 2)),
    "truth values": RNG.random((20, 4)) > 0.5,
    "large numbers": RNG.integers(0, 2, size=(20, 2)) * 2**62,
    "rows that ascend": np.array([[-1, 7], [0.0, 1], [0, 2], [3, -1]]),
    "rows that ascend by their last column": np.array([[1, 0], [0, 1]]),
    "one row": np.zeros((1, 3)),
    "no row": np.zeros((0, 3)),
}


@pytest.mark.parametrize("name", ARRAYS)
def test_groups_are_numpys(name):
    rows = ARRAYS[name]
    values, first, places, counts = np.unique(rows, axis=0, return_index=True, return_inverse=True, return_counts=True)
    found = grouped(rows)
    assert (found.first.tolist(), found.places.tolist(), found.counts.tolist()) == (
        first.tolist(),
        places.reshape(-1).tolist(),
        counts.tolist(),
    )
    assert np.array_equal(distinct_rows(rows)[0], values)
    assert distinct_rows(rows)[1].tolist() == places.reshape(-1).tolist()
    flat, index, counts = np.unique(rows.reshape(-1), return_inverse=True, return_counts=True)
    assert np.array_equal(distinct(rows), flat)
    assert distinct(rows).dtype == rows.dtype
    assert np.array_equal(distinct_values(rows)[0], flat)
    assert distinct_values(rows)[1].tolist() == index.reshape(-1).tolist()
    assert grouped(rows.reshape(-1)).counts.tolist() == counts.tolist()


def test_nothing_in_the_package_calls_numpys_unique():
    """Found by an audit: processes whose daemon threads asked for clearances aborted at their end, one of twelve.

    NumPy's `unique` waits for Python in C++; when the interpreter ends, Python ends a thread that comes back to it.
    """
    forbidden = {"unique", "unique_values", "union1d", "intersect1d", "setxor1d"}
    calls = [
        f"{path.relative_to(PACKAGE)}:{node.lineno}"
        for path in PACKAGE.rglob("*.py")
        if any(name in (text := path.read_text(encoding="utf-8")) for name in forbidden)
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Attribute) and node.attr in forbidden and ast.unparse(node.value) in ("np", "numpy")
    ]
    assert calls == []


DAEMON = """
import sys, threading, time
import plannercheck as pc
checker = pc.Checker(pc.Robot.load("panda"), pc.Scene.load("bookshelf"))
q = checker.robot.random_configurations(1, seed=0)[0]

def ask():
    while True:
        checker.clearance(q)

for _ in range(4):
    threading.Thread(target=ask, daemon=True).start()
time.sleep(float(sys.argv[1]))
sys.exit(7)
"""


def test_processes_end_while_daemon_threads_ask_for_clearances():
    for k in range(0, 6, 2):
        ran = subprocess.run(
            [sys.executable, "-c", DAEMON, str(0.05 + 0.03 * k)],
            capture_output=True,
            text=True,
            check=False,
            timeout=60,
        )
        assert (ran.returncode, ran.stderr) == (7, "")


def masked(values: object) -> np.ma.MaskedArray:
    """An array whose first number is masked."""
    array = np.ma.masked_array(np.array(values))
    array[(0,) * array.ndim] = np.ma.masked
    return array


Q = np.zeros((3, 7))
TETRAHEDRON = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
TRIANGLE = np.array([[0, 0], [1, 0], [0, 1.0]])
BODY = pc.Polytope(TETRAHEDRON)
BODY4 = pc.ndim.Polytope(np.eye(4))
CHECKER = pc.Checker(pc.Robot.load("panda"), pc.Scene("empty"))
NAMES = CHECKER.robot.joint_names
TAKES: dict[str, Callable[[], object]] = {
    "check_states": lambda: CHECKER.check_states(masked(Q)),
    "check_states, rows in a list": lambda: CHECKER.check_states([Q[0], masked(Q[1])]),
    "check_states, columns": lambda: CHECKER.check_states({name: masked(Q[:, 0]) for name in NAMES}),
    "is_valid": lambda: CHECKER.is_valid(masked(Q[0])),
    "is_valid, one number": lambda: CHECKER.is_valid([np.ma.masked, *Q[0, 1:]]),
    "check_motion": lambda: CHECKER.check_motion(Q[0], masked(Q[1])),
    "check_motions": lambda: CHECKER.check_motions(masked(Q), Q),
    "certify_motions": lambda: list(CHECKER.certify_motions(Q, masked(Q))),
    "clearance": lambda: CHECKER.clearance(masked(Q[0])),
    "explain": lambda: CHECKER.explain(masked(Q[0])),
    "plan": lambda: plan(CHECKER, masked(Q[0]), Q[1]),
    "link_poses": lambda: CHECKER.robot.link_poses(masked(Q)),
    "expand": lambda: CHECKER.robot.expand(masked(Q[0])),
    "vertices": lambda: pc.Polytope(masked(TETRAHEDRON)),
    "faces": lambda: pc.Polytope(TETRAHEDRON, faces=masked(FACES)),
    "pose of a pair": lambda: pc.intersects(BODY, BODY, masked(np.eye(4))),
    "poses of a pair": lambda: pc.intersects(BODY, BODY, masked(np.tile(np.eye(4), (2, 1, 1)))),
    "pose of a certificate": lambda: pc.certify(BODY, BODY, masked(np.eye(4))),
    "size of a box": lambda: pc.Box(masked(np.ones(3))),
    "pose of an obstacle": lambda: pc.Scene("s").add_box("a", (1, 1, 1), masked(np.eye(4))),
    "hull": lambda: pc.Scene("s").add_hull("a", masked(TETRAHEDRON)),
    "normal": lambda: pc.HalfSpace(masked(np.ones(3))),
    "points": lambda: pc.PointCloud(masked(TETRAHEDRON), 0.1),
    "radii": lambda: pc.PointCloud(TETRAHEDRON, masked(np.ones(4))),
    "cells of an octree": lambda: pc.Octree.from_cells(masked(np.zeros((1, 3), dtype=np.int32)), 0.1),
    "cells of a grid": lambda: pc.VoxelGrid(masked(np.ones((2, 2, 2), dtype=bool)), 0.1),
    "origin of a grid": lambda: pc.VoxelGrid(np.ones((2, 2, 2), dtype=bool), 0.1, masked(np.zeros(3))),
    "heights": lambda: pc.HeightField(masked(np.ones((3, 3))), 0.1, 0.0),
    "vertices of a solid": lambda: pc.Solid(masked(TETRAHEDRON), FACES),
    "triangles of a solid": lambda: pc.Solid(TETRAHEDRON, masked(FACES)),
    "polygon": lambda: pc.planar.intersects(masked(TRIANGLE), TRIANGLE),
    "pose in the plane": lambda: pc.planar.intersects(TRIANGLE, TRIANGLE, masked(np.eye(3))),
    "outline": lambda: pc.planar.Scene("s").add("a", [masked(TRIANGLE)]),
    "points in any dimension": lambda: pc.ndim.Polytope(masked(np.eye(4))),
    "pose in any dimension": lambda: pc.ndim.intersects(BODY4, BODY4, masked(np.eye(5))),
}


@pytest.mark.parametrize("name", TAKES)
def test_masked_numbers_are_refused(name):
    with pytest.raises(pc.PlannercheckError, match=r"masked"):
        TAKES[name]()


def test_arrays_in_which_nothing_is_masked_are_arrays():
    q = np.ma.masked_array(Q)
    assert CHECKER.check_states(q).tolist() == CHECKER.check_states(Q).tolist()
    assert (
        CHECKER.check_states(np.ma.masked_array(Q, mask=np.zeros(Q.shape))).tolist() == CHECKER.check_states(Q).tolist()
    )


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ([0.0, True], r"a truth value at \[1\]: write 1 or 0"),
        ([[1, 2.5], (0.0, np.False_)], r"a truth value at \[1, 1\]"),
        ([np.zeros(2), np.ones(2) > 0], r"a truth value at \[1\]"),
        ([[False]], r"a truth value at \[0, 0\]"),
        (np.ones(2) > 0, "an array of dtype bool"),
        (True, "True"),
    ],
)
def test_truth_values_are_no_numbers(values, words):
    with pytest.raises(pc.PlannercheckError, match=f"waypoints must be numbers, not {words}"):
        named_numbers(values, "waypoints")


def test_truth_values_are_no_lengths_and_no_times():
    still = np.tile(np.eye(4), (2, 1, 1))
    for call, words in (
        (lambda: pc.Moving([0, True], still), "times of Moving must be numbers .* a truth value"),
        (lambda: pc.Moving.along(None, "hand", None, start_time=True), "start_time must be a number of seconds"),
        (lambda: pc.Gate(CHECKER, acceleration=1, margin=True), "margin must be a length of at least 0, m, not True"),
        (lambda: pc.time_path(CHECKER, [Q[0], Q[0] + 0.1], 1, 1, blend=True), "blend must be"),
    ):
        with pytest.raises(pc.PlannercheckError, match=words):
            call()
