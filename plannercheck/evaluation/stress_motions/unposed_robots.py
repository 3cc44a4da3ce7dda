"""Robots that the compiled kernel does not pose (screws, i.e. helical joints): asking for proofs raises errors.

In: random numbers. Out: a `Judged`: every call for a proof has to raise a `PlannercheckError` that says why.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import partial

import numpy as np

from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.stress_motions.outcomes import EXCEPTION, Judged
from plannercheck.evaluation.stress_motions.recipes import robot_of, space_checker
from plannercheck.evaluation.stress_motions.trees import Wishes, random_tree

UNPOSED = "helical"
_MOTIONS = 10


def judge_unposed(rng: np.random.Generator) -> Judged:
    """A tree with a screw in it."""
    judged = Judged()
    recipe = random_tree(Wishes(("helical", "revolute", "prismatic"), (3.0, 1.0, 1.0), (1, 4), 0.0, 0.3, 1.0), rng)
    recipe["joints"][-1]["kind"] = "helical"
    recipe["bodies"].append({"link": "base", "shape": ["sphere", 0.1], "pose": np.eye(4).tolist()})
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        checker = space_checker(recipe, robot_of(recipe))
    q0, q1 = (checker.robot.random_configurations(_MOTIONS, rng) for _ in range(2))
    for row in range(_MOTIONS):
        ways: tuple[Callable[[], object], ...] = (
            partial(checker.check_motion, q0[row], q1[row]),
            partial(checker.explain_motion, q0[row], q1[row]),
            partial(checker.check_motions, q0[: row + 1], q1[: row + 1]),
        )
        judged.counts["motions"] += 1
        judged.counts["declined"] += 1
        for ask in ways:
            try:
                judged.add(EXCEPTION, -1, f"a screw's motion was answered: {ask()!r}")
            except PlannercheckError as error:
                if "can't be certified" not in str(error) and "proved free for the compiled" not in str(error):
                    judged.add(EXCEPTION, -1, repr(error))
            except Exception as error:
                judged.add(EXCEPTION, -1, repr(error))
    return judged
