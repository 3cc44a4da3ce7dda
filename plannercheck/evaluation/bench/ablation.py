"""The effect of each stage of a check: the checker with one switch off, compared with the checker with all on.

In: a robot and a scene. Out: a row for each switch and kind of states. Verdicts do not depend on switches; they are
compared nevertheless. A second checker with all on is the null control: it shows the difference between equal checkers.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

from plannercheck.bodies.tuning import Tuning, tuning_table
from plannercheck.common.array_types import Floats
from plannercheck.evaluation.bench.motion_sets import along_motions
from plannercheck.evaluation.bench.timing import Contender, measured
from plannercheck.motions.checker import Checker
from plannercheck.robots.robot import Robot
from plannercheck.scenes.scene import Scene

ALL_ON, ALL_ON_AGAIN = "all on", "all on, again"
WALK = "walk for oracle"


@dataclass(frozen=True)
class SwitchRow:
    """The effect of one switch on one kind of states.

    Attributes:
        states: "random", or "along motions".
        off: The switch that is off.
        microseconds: The least time for each state.
        ratio: The time over that with all switches on.
        noise: How many times longer the same code took when it ran twice: a smaller ratio says nothing.
        wrong: Verdicts that differ from those with all on.
    """

    states: str
    off: str
    microseconds: float
    ratio: float
    noise: float
    wrong: int


def measure(robot: Robot, scene: Scene, states: int, rounds: int, seed: int) -> list[SwitchRow]:
    """Times checkers with one switch off by turns.

    A row for each kind of states and switch, the first of each with all on. States are random, of this seed, and along
    motions.
    """
    checkers = {off: Checker(robot, scene, tuning=tuning) for off, tuning in _variants().items()}
    random = robot.random_configurations(states, seed)
    return [
        *_rows("random", checkers, random, rounds),
        *_rows("along motions", checkers, along_motions(random), rounds),
    ]


def _variants() -> dict[str, Tuning]:
    switches = [row.name for row in tuning_table() if row.type == "bool"]
    variants = {ALL_ON: Tuning(), ALL_ON_AGAIN: Tuning(), **{switch: Tuning().without(switch) for switch in switches}}
    return variants | {WALK: Tuning(method="walk")}


def _rows(states: str, checkers: Mapping[str, Checker], q: Floats, rounds: int) -> list[SwitchRow]:
    works = {off: Contender([partial(checker.check_states, q)], len(q)) for off, checker in checkers.items()}
    times = measured(works, rounds)
    seconds = times.seconds
    equal = seconds[ALL_ON_AGAIN] / seconds[ALL_ON]
    truth = checkers[ALL_ON].check_states(q)
    return [
        SwitchRow(
            states,
            off,
            1e6 * seconds[off],
            seconds[off] / seconds[ALL_ON],
            max(times.noise(ALL_ON, off), equal, 1 / equal),
            int((checker.check_states(q) != truth).sum()),
        )
        for off, checker in checkers.items()
    ]
