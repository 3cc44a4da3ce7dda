"""Trajectories of all forms around free states of a checker; proofs of them with tubes; what came of each.

In: a checker, trajectories, a random generator. Out: proofs, piece by piece, and counts by outcome. Tubes are none, or
parts of the largest that is proved, 0.999 of it among them, for all numbers or for some.
"""

import tempfile
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import set_proof_cases

import plannercheck as pc
from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.stress_motions.curve_numbers import unit_columns
from plannercheck.proofs import Proof
from plannercheck.proofs.executed_messages import trajectory_proved

MOST_DEGREE, PIECES = 7, (1, 1, 1, 2, 3)
# How far control points are apart, rad and m, as powers of ten.
_STEPS = (-2.0, 0.0)
# Who runs points, and up to which derivative points say something.
_CONTROLLERS = {"jtc": (0, 1, 2), "jtc-upsampled": (0,), "ur": (0, 1, 2), "motoros2": (1,), "linear": (0,)}


# The outcome of a message whose proofs are of another curve.
NOT_AS_RUN = "REFUSED as run"


class Certified(NamedTuple):
    """Proofs of trajectories, and how many trajectories were asked for, proved, and not, by reason."""

    proofs: list[Proof]
    outcomes: Counter[str]


def certified(checker: pc.Checker, asked: Iterable[tuple[pc.Trajectory, Floats]], tolerance: float = 1e-4) -> Certified:
    """Proofs of trajectories that are free with the tubes (nq,) they come with."""
    proofs, outcomes = list[Proof](), Counter[str]()
    for trajectory, tube in asked:
        outcomes["free"] += 1
        outcomes["with a tube"] += bool(tube.any())
        try:
            found, why = checker.certify_trajectory(trajectory, tube, tolerance), "None"
        except PlannercheckError as error:
            found, why = None, str(error).rsplit(": ", 1)[-1]
        if found is None:
            outcomes[f"no proof: {why}"] += 1
            continue
        outcomes["proved"] += 1
        proofs += found
        if trajectory.points is not None:
            outcomes["messages proved as run" if _is_proved_as_run(found, trajectory, tube) else NOT_AS_RUN] += 1
    return Certified(proofs, outcomes)


def _is_proved_as_run(proofs: Sequence[Proof], trajectory: pc.Trajectory, tube: Floats) -> bool:
    """Whether the proofs are of the curve of the message that is written."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "message.json"
        trajectory.save(file)
        return bool(trajectory_proved(proofs, file, str(trajectory.controller), tube.tolist()))


def with_tubes(
    checker: pc.Checker, trajectories: Iterable[pc.Trajectory], rng: np.random.Generator, tolerance: float = 1e-4
) -> Iterable[tuple[pc.Trajectory, Floats]]:
    """Trajectories that are free, each with a tube with which it is free."""
    units = unit_columns(checker.robot)
    for trajectory in trajectories:
        tube = np.zeros(checker.robot.nq)
        if rng.random() < 0.6:
            largest = checker.explain_trajectory(trajectory, 0.0, tolerance).largest_tube
            tube[:] = largest * (0.999 if rng.random() < 0.5 else rng.random())
            tube[units] = 0.0
            if rng.random() < 0.3:
                tube *= rng.integers(0, 2, len(tube))
        yield trajectory, tube


def free_ones(
    checker: pc.Checker, count: int, rng: np.random.Generator, starts: Floats | None = None
) -> list[pc.Trajectory]:
    """At most so many random trajectories that are free, from random states or given ones (n, nq)."""
    q = checker.robot.random_configurations(8 * count, rng) if starts is None else starts
    q = q[checker.check_states(q)][: 4 * count]
    made = [random_trajectory(checker.robot, start, rng) for start in q]
    free = checker.check_trajectories(made) if made else []
    return [each for each, is_free in zip(made, free, strict=True) if is_free][:count]


def random_trajectory(robot: pc.Robot, start: Floats, rng: np.random.Generator) -> pc.Trajectory:
    """Bézier curves from a state, or of robots without unit vectors a spline or what a controller runs."""
    degree, pieces = int(rng.integers(1, MOST_DEGREE + 1)), int(rng.choice(PIECES))
    step = 10.0 ** rng.uniform(*_STEPS)
    form = rng.integers(3) if not robot.configuration_map.units else 0
    if form == 1:
        points = _walk(robot, start, degree + pieces, step, rng)
        knots = np.concatenate([np.zeros(degree), np.arange(pieces + 1.0), np.full(degree, float(pieces))])
        return pc.Trajectory.bspline(knots, points)
    if form == 2:
        return _message(robot, _walk(robot, start, pieces + 1, step, rng), step, rng)
    points = _walk(robot, start, degree * pieces + 1, step / degree, rng)
    rows = [points[degree * k : degree * (k + 1) + 1] for k in range(pieces)]
    return pc.Trajectory.bezier(np.arange(pieces + 1.0), np.array(rows)).of_robot(robot)


def _walk(robot: pc.Robot, start: Floats, count: int, step: float, rng: np.random.Generator) -> Floats:
    """Configurations (count, nq), each about a step from the one before."""
    steps = rng.normal(size=(count, len(start))) * step
    steps[0] = 0.0
    points = start + steps.cumsum(axis=0)
    for first, past in robot.configuration_map.units:
        points[:, first:past] /= np.linalg.norm(points[:, first:past], axis=1, keepdims=True)
    return np.asarray(points)


def _message(robot: pc.Robot, points: Floats, step: float, rng: np.random.Generator) -> pc.Trajectory:
    """What a controller runs between points (n, nq), whose stamps are whole ms, or not."""
    controller = str(rng.choice(list(_CONTROLLERS)))
    times = np.round(rng.uniform(0.1, 1.0, len(points)).cumsum(), int(rng.integers(3, 10)))
    derivatives = [rng.normal(size=points.shape) * step for _ in range(2)]
    for each in derivatives:
        each[-1] = 0.0
    said = derivatives[: int(rng.choice(_CONTROLLERS[controller]))]
    return pc.Trajectory(times, points, *said, controller=controller, joint_names=robot.joint_names)


def sensed(scene: pc.Scene, rng: np.random.Generator, count: int = 2) -> pc.Scene:
    """The scene with a half-space and some sets of parts in it."""
    normal = rng.normal(size=3)
    scene.add("plane", pc.HalfSpace(tuple(normal.tolist()), float(rng.uniform(-1.5, -0.5) * np.linalg.norm(normal))))
    for name in rng.permutation(list(set_proof_cases.SETS))[:count]:
        scene.add(str(name), set_proof_cases.SETS[name](), set_proof_cases.tilted())
    return scene
