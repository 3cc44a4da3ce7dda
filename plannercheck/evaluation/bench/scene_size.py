"""The cost of a check against the size of the scene: boxes near the robot, and thousands out of its reach.

In: a robot and numbers of boxes. Out: a row for each scene, with its checker's times and memory. Every scene has the
same number of boxes near the robot; all others are far out of reach.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.common.transforms import pose_of
from plannercheck.evaluation.bench.build_cost import Built, built, resident_bytes
from plannercheck.evaluation.bench.motion_sets import random_motions
from plannercheck.evaluation.bench.timing import Contender, Work, measured
from plannercheck.motions.checker import Checker
from plannercheck.robots.robot import Robot
from plannercheck.scenes.scene import Scene

# Boxes near the robot, in every scene.
NEAR = 100
# rad: of random motions, of which there are a tenth as many as states.
LENGTH = 0.4
_STATES_A_MOTION = 10
# Most times the cost of the smallest scene that are asked for.
ASKED = 3.0
# m: where boxes stand, as distances from the base, and their edges. The shipped arms reach 1.3 m.
_NEAR_DISTANCES, _FAR_DISTANCES = (0.4, 1.2), (4.0, 20.0)
_EDGES = (0.03, 0.1)


@dataclass(frozen=True)
class ScaleRow:
    """The cost of a scene of boxes.

    Attributes:
        boxes: Number of boxes in the scene.
        pairs: Number of pairs of a state.
        microseconds: The least time a state.
        ratio: The time over that of the first scene.
        noise: How many times longer the same code took when it ran twice: a smaller ratio says nothing.
        motion_microseconds: The least time a motion of `LENGTH`, proved or refused.
        motion_ratio: The time over that of the first scene.
        preparation: Seconds to build the checker, without the disk cache.
        resident: Bytes that building it took; None where the system does not tell.
        prepared: Bytes of the prepared bodies, equal ones once.
        bytes_a_vertex: Bytes of the robot's bodies over the number of their vertices.
        process: Bytes of the whole process after it was built, libraries and all; None where the system does not tell.
    """

    boxes: int
    pairs: int
    microseconds: float
    ratio: float
    noise: float
    motion_microseconds: float
    motion_ratio: float
    preparation: float
    resident: int | None
    prepared: int
    bytes_a_vertex: float
    process: int | None


def measure(robot: Robot, boxes: Sequence[int], states: int, rounds: int, seed: int) -> list[ScaleRow]:
    """Times scenes of these numbers of boxes, of which the first `NEAR` are near the robot, by turns: a row a scene.

    Random configurations are checked, and a tenth as many motions.
    """
    q = robot.random_configurations(states, seed)
    made: dict[str, Built[Checker]] = {}
    processes = []
    for count in boxes:
        made[str(count)] = built(partial(Checker, robot, boxes_around(count, seed)))
        processes.append(resident_bytes())
    checkers = {name: item.value for name, item in made.items()}
    of_states, noises = _timed(
        {name: partial(checker.check_states, q) for name, checker in checkers.items()}, len(q), rounds
    )
    nearest = next(iter(checkers.values()))  # what is near is alike in all
    starts, ends = random_motions(nearest, LENGTH, -(-states // _STATES_A_MOTION), np.random.default_rng(seed))
    proofs = {name: partial(checker.check_motions, starts, ends) for name, checker in checkers.items()}
    of_motions, noises_of_motions = _timed(proofs, len(starts), rounds)
    noises = np.maximum(noises, noises_of_motions).tolist()
    rows = zip(boxes, made.values(), of_states, of_motions, noises, processes, strict=True)
    return [
        _row(count, item, (state, state / of_states[0], motion, motion / of_motions[0]), noise, process)
        for count, item, state, motion, noise, process in rows
    ]


def _timed(works: Mapping[str, Work], count: int, rounds: int) -> tuple[list[float], list[float]]:
    """The least seconds of each, a piece, and the noise of its ratio to the first."""
    times = measured({name: Contender([work], count) for name, work in works.items()}, rounds)
    first = next(iter(works))
    return list(times.seconds.values()), [times.noise(first, name) for name in works]


def boxes_around(count: int, seed: int) -> Scene:
    """A scene of `count` boxes: those beyond the first `NEAR` are out of reach."""
    rng = np.random.default_rng(seed)
    scene = Scene(f"{count} boxes")
    for k in range(count):
        low, high = _NEAR_DISTANCES if k < NEAR else _FAR_DISTANCES
        direction = rng.normal(size=3)
        place = direction / np.linalg.norm(direction) * rng.uniform(low, high)
        pose = pose_of(place, _rotation(rng))
        scene.add_box(f"box {k}", tuple(rng.uniform(*_EDGES, 3)), pose)
    return scene


def _rotation(rng: np.random.Generator) -> Floats:
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return np.asarray(q * np.sign(np.linalg.det(q)))


def _row(
    count: int, item: Built[Checker], spent: tuple[float, float, float, float], noise: float, process: int | None
) -> ScaleRow:
    checker = item.value
    own = {id(p): p for p in checker.prepared[: len(checker.robot.bodies)] if p is not None}.values()
    every = {id(p): p for p in checker.prepared if p is not None}.values()
    return ScaleRow(
        count,
        len(checker.pairs),
        1e6 * spent[0],
        spent[1],
        noise,
        1e6 * spent[2],
        spent[3],
        item.seconds,
        item.resident,
        sum(p.nbytes for p in every),
        sum(p.nbytes for p in own) / sum(len(p.vertices) for p in own),
        process,
    )
