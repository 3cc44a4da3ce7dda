"""The contenders of `bench motions`: the checker by three calls, and other libraries.

In: the cases of a set of motions. Out: the work to time, case by case. The checker proves every state on a motion. The
others judge states: coal and FCL as many as VAMP would, from coarse to fine or one after the other, until one collides.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.bench import other_libraries
from plannercheck.evaluation.bench.coal_loop import VARIANTS, CoalLoop, CoalStates, Variant
from plannercheck.evaluation.bench.motion_sets import MotionCase
from plannercheck.evaluation.bench.pair_peers import COAL_AT_BEST
from plannercheck.evaluation.bench.timing import one_by_one
from plannercheck.evaluation.bench.vamp_model import VampModel
from plannercheck.motions.sampling import coarse_to_fine
from plannercheck.ompl import setup as ompl_setup
from plannercheck.ompl.joint_space import JointSpace

# States a radian of a sampled motion, and how many of them are judged at once: those of VAMP for an arm.
STATES_A_RADIAN, LANES = 32, 8
# A sampled motion in calls of libraries that judge some states at once: both ends, then up to here, then the rest.
_SPLITS = (2, 9)
# States whose poses, about 1 kB each, stay in a processor's second cache.
_CACHED_STATES = 1024
# Motions that slow libraries judge in a round.
_FEW = 40


class Ready(NamedTuple):
    """Motions that one method is ready to judge.

    Attributes:
        works: Functions that judge the motions of each case, or of parts of it, in order; True is free.
        overheads: Work beside each of these that is timed apart and taken off; empty for most.
        note: What is timed.
    """

    works: Sequence[Callable[[], Bools]]
    overheads: Sequence[Callable[[], object]] = ()
    note: str = ""


class MotionMethod(NamedTuple):
    """A judge of motions.

    Attributes:
        name: Name in tables.
        ready: Prepares the cases, outside the timing.
        most: Motions that it judges in a round; None for all.
    """

    name: str
    ready: Callable[[Sequence[MotionCase]], Ready]
    most: int | None = None


def _by_batch(cases: Sequence[MotionCase]) -> Ready:
    works = [partial(case.checker.check_motions, case.starts, case.ends) for case in cases]
    return Ready(works, note="check_motions: every state on a motion is proved free")


def _one_by_one(cases: Sequence[MotionCase]) -> Ready:
    works = [partial(one_by_one, case.checker.check_motion, list(case.starts), list(case.ends)) for case in cases]
    return Ready(works, note="check_motion, called from Python")


def _by_ompl(cases: Sequence[MotionCase]) -> Ready:
    works = []
    for case in cases:
        space, information = JointSpace(case.checker.robot), ompl_setup(case.checker).getSpaceInformation()
        starts, ends = ([space.state(information, row) for row in rows] for rows in (case.starts, case.ends))
        works.append(partial(one_by_one, information.checkMotion, starts, ends))
    return Ready(works, note="SpaceInformation.checkMotion of pc.ompl.setup, called from Python")


def _coal_at_best(cases: Sequence[MotionCase]) -> Ready:
    """Tries all variants in both orders on all cases."""
    orders = {"coarse to fine": coarse_to_fine, "one after the other": _in_order}
    parts = [(loop, part) for case in cases for loop in [CoalLoop.of_checker(case.checker)] for part in _parts(case)]
    loops = [loop for loop, _ in parts]
    posed = {name: [_posed(loop, part, order) for loop, part in parts] for name, order in orders.items()}
    spent: dict[tuple[str, Variant], float] = {}
    for name, variant in ((name, variant) for name in orders for variant in VARIANTS):
        items = zip(loops, posed[name], strict=True)
        spent[name, variant] = sum(loop.fastest(*given, variants=(variant,))[1] for loop, given in items)
    order, variant = min(spent, key=spent.__getitem__)
    works = [partial(loop.check, given[0], variant, given[1]) for loop, given in zip(loops, posed[order], strict=True)]
    return Ready(works, note=f"C++ loop over poses given beforehand: {variant}, states {order}")


def _parts(case: MotionCase) -> list[MotionCase]:
    """Motions whose poses stay in the processor's cache, as they would if each motion were posed on its own."""
    states = sum(len(_sampled(a, b)) for a, b in zip(case.starts, case.ends, strict=True))
    n = min(len(case.starts), -(-states // _CACHED_STATES))
    starts, ends = np.array_split(case.starts, n), np.array_split(case.ends, n)
    return [MotionCase(case.checker, *part) for part in zip(starts, ends, strict=True)]


def _posed(loop: CoalLoop, case: MotionCase, order: Callable[[int], Floats]) -> tuple[CoalStates, NDArray[np.int64]]:
    """All sampled states of all motions, and where each motion ends."""
    sampled = [_sampled(a, b, order) for a, b in zip(case.starts, case.ends, strict=True)]
    return loop.states(np.concatenate(sampled)), np.cumsum([len(states) for states in sampled])


def _in_order(steps: int) -> Floats:
    return np.arange(steps + 1) / steps


def _sampled(start: Floats, end: Floats, order: Callable[[int], Floats] = coarse_to_fine) -> Floats:
    """The states (k, nq) of one motion."""
    blocks = np.ceil(np.linalg.norm(end - start) * STATES_A_RADIAN / LANES)
    part = order(LANES * max(int(blocks), 1))[:, None]
    return (1 - part) * start + part * end


def _by_states(make: Callable[[Any], other_libraries.Judge], note: str, cases: Sequence[MotionCase]) -> Ready:
    """By a judge of states, some at a time: a call costs it something, and a collision ends a motion."""

    def judged(judge: other_libraries.Judge, motions: list[list[Floats]]) -> Bools:
        return np.array([all(judge(part).all() for part in parts) for parts in motions], dtype=bool)

    works = []
    for case in cases:
        motions = [_sampled(a, b) for a, b in zip(case.starts, case.ends, strict=True)]
        works.append(partial(judged, make(case.checker), [np.split(states, _SPLITS) for states in motions]))
    return Ready(works, note=note)


def _vamp(taken_off: bool, cases: Sequence[MotionCase]) -> Ready:
    models = [VampModel(case.checker) for case in cases]
    if any(model.states_a_radian != STATES_A_RADIAN for model in models):
        raise PlannercheckError(f"VAMP samples this robot otherwise than by {STATES_A_RADIAN} states a rad")
    pairs = list(zip(models, cases, strict=True))
    works = [partial(model.free, model.paths(case.starts, case.ends)) for model, case in pairs]
    if not taken_off:
        return Ready(works, note=f"Path.validate, {STATES_A_RADIAN} states a rad; each call copies the obstacles")
    overheads = [partial(model.copying, len(case.starts)) for model, case in pairs]
    return Ready(works, overheads, "Path.validate, less what a call with nothing to judge takes")


OURS = "plannercheck, batch"
METHODS: Sequence[MotionMethod] = (
    MotionMethod(OURS, _by_batch),
    MotionMethod("plannercheck, one by one", _one_by_one),
    MotionMethod("plannercheck, OMPL validator", _by_ompl),
    MotionMethod("VAMP, in C++", partial(_vamp, True)),
    MotionMethod("VAMP, from Python", partial(_vamp, False)),
    MotionMethod(COAL_AT_BEST, _coal_at_best),
    MotionMethod(
        "Pinocchio + coal, AABB tree",
        partial(_by_states, other_libraries.coal, "computeCollisions from Python, coarse to fine"),
        _FEW,
    ),
    MotionMethod(
        "python-fcl",
        partial(_by_states, other_libraries.fcl, "loop in Python, coarse to fine, on boxes that meet"),
        _FEW,
    ),
)
