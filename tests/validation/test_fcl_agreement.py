"""The comparison with FCL finds a checker's errors, and blames FCL for its own."""

from types import SimpleNamespace
from typing import Any

import exact_verdicts
import numpy as np
import pytest
from numpy.typing import NDArray

import plannercheck as pc
from plannercheck.evaluation.stress import body_families as families
from plannercheck.validation.fcl_agreement import compare_with_fcl

VERTICES, FACES = families.degree_doubling(2)
# Two bodies that move along x, m, and one that stands far off.
STATES = np.array([[0.0, 0.5], [0.0, 5.0], [0.0, 0.3], [0.0, 2.0 + 1e-9]])


class SlidingBodies:
    """A checker of three bodies on a line, with verdicts that a test can falsify."""

    def __init__(
        self, lies: dict[tuple[int, int], bool] | None = None, invert_states: bool = False, scale: float = 1.0
    ) -> None:
        self.bodies = [SimpleNamespace(name=name) for name in ("left", "right", "far")]
        hull = SimpleNamespace(
            vertices=VERTICES * scale, faces=FACES, inflation_radius=0.0, solid=None, parts=None, half_space=None
        )
        self.polytopes = [hull] * 3
        self.pairs = np.array([[0, 1], [0, 2]])
        self._vertices = VERTICES * scale
        self._lies = lies or {}
        self._invert_states = invert_states

    def body_poses(self, q: NDArray[np.float64]) -> NDArray[np.float64]:
        poses = np.tile(np.eye(4), (len(q), 3, 1, 1))
        poses[:, :2, 0, 3] = q
        poses[:, 2, 2, 3] = 100.0
        return poses

    def colliding_pairs(self, q: NDArray[np.float64]) -> NDArray[np.bool_]:
        verdicts = [self._verdicts(poses) for poses in self.body_poses(q)]
        for (row, pair), verdict in self._lies.items():
            verdicts[row][pair] = verdict
        return np.array(verdicts)

    def _verdicts(self, poses: NDArray[np.float64]) -> list[bool]:
        return [exact_verdicts.intersects(self._vertices, self._vertices, poses[p], poses[r]) for p, r in self.pairs]

    def check_states(self, q: NDArray[np.float64]) -> NDArray[np.bool_]:
        return ~self.colliding_pairs(q).any(axis=1) ^ self._invert_states


def compare(checker: Any) -> Any:
    return compare_with_fcl(checker, STATES)


def test_a_right_checker_passes() -> None:
    report = compare(SlidingBodies())
    assert report.passed
    assert (report.states, report.pairs, report.agreements, report.collisions) == (4, 8, 8, 2)
    assert report.fcl_calls < report.pairs


def test_a_missed_collision_goes_against_the_checker() -> None:
    report = compare(SlidingBodies({(0, 0): False}))
    (found,) = report.against_us
    assert (found.row, found.bodies) == (0, ("left", "right"))
    assert (found.ours, found.fcl, found.exact) == (False, True, True)
    assert not report.passed
    assert report.contradictions == ()


def test_a_false_collision_of_far_bodies_goes_against_the_checker() -> None:
    report = compare(SlidingBodies({(1, 1): True}))
    (found,) = report.against_us
    assert found.bodies == ("left", "far")
    assert not found.exact
    assert found.distance > 90


def test_states_that_contradict_their_pairs_are_listed() -> None:
    report = compare(SlidingBodies(invert_states=True))
    assert report.contradictions == (0, 1, 2, 3)
    assert not report.passed


def test_an_error_of_fcl_is_not_ours() -> None:
    # Bodies of 10 µm overlapping by a part of 1e-6: FCL's tolerance is coarser than that.
    tiny = SlidingBodies(scale=1e-5)
    extent = np.ptp(VERTICES[:, 0]) * 1e-5
    q = np.array([[0.0, extent * (1 - part)] for part in np.geomspace(1e-7, 1e-2, 50)])
    report = compare_with_fcl(tiny, q)
    assert report.passed
    assert report.errors_of_fcl
    assert report.agreements == report.pairs - len(report.disagreements)


def test_progress_counts_every_state() -> None:
    counts: list[int] = []
    compare_with_fcl(SlidingBodies(), np.tile(STATES, (100, 1)), counts.append)
    assert sum(counts) == 400


def test_flat_and_inflated_bodies_are_compared_too() -> None:
    # A plate and a ball that slide along x, and a capsule above.
    shapes = [
        ([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], 0.0),
        ([[0, 0.5, 0]], 0.25),
        ([[0, 0.5, 1], [1, 0.5, 1]], 0.75),
    ]
    checker = SlidingBodies()
    checker.polytopes = [
        pc.Polytope(np.array(points, dtype=float), inflation_radius=inflation_radius)
        for points, inflation_radius in shapes
    ]
    checker.pairs = np.array([[0, 1], [0, 2], [1, 2]])
    q = np.array([[0.0, -0.25], [0.0, -0.25 - 1e-12], [0.0, 2.0]])

    def poses(rows: NDArray[np.float64]) -> NDArray[np.float64]:
        placed = np.tile(np.eye(4), (len(rows), 3, 1, 1))
        placed[:, :2, 0, 3] = rows
        return placed

    verdicts = np.array([[True, False, True], [False, False, True], [False, False, False]])
    verdicts[:, 2] = np.hypot([0.25, 0.25 + 1e-12, 1.0], 1) <= 1.0
    checker.body_poses = poses  # type: ignore[method-assign]
    checker.colliding_pairs = lambda rows: verdicts  # type: ignore[method-assign]
    report = compare_with_fcl(checker, q)  # type: ignore[arg-type]
    assert report.passed
    assert report.disagreements == ()
    assert (report.pairs, report.exact_calls) == (9, 2)
    verdicts[1, 0] = True
    (found,) = compare_with_fcl(checker, q).against_us  # type: ignore[arg-type]
    assert found.distance == pytest.approx(1e-12, rel=1e-3)
