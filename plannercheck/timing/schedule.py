"""`pc.schedule`: robots in a given order, each of which waits for those before it.

In: a checker of a cell, trajectories in order of priority. Out: a `Schedule`: when each starts, how much its delay may
lose, and a picture of bars on the clock.
"""

from __future__ import annotations

import html
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from plannercheck.common.errors import PlannercheckError
from plannercheck.common.public_names import set_module
from plannercheck.common.shown_times import shown_seconds
from plannercheck.motions.certifier import DEFAULT_TOLERANCE
from plannercheck.motions.checker import Checker
from plannercheck.motions.trajectory_verdict import TrajectoryVerdict
from plannercheck.timing.conflicts import Tubes, cell_of, first_conflict
from plannercheck.timing.least_delay import LeastDelay, least_delay
from plannercheck.trajectories.one_clock import Run, check_runs
from plannercheck.trajectories.trajectory import Trajectory

# The picture: its width and the margin for names, and the height of a row, px.
_WIDTH, _MARGIN, _ROW = 640, 110, 24


@set_module("plannercheck")
@dataclass(frozen=True, repr=False)
class Schedule:
    """When robots start that wait in a given order.

    Attributes:
        delays: By robot, s; None where no delay is proved free. Robots that stand are not in it.
        steps: The search for each place in the order after the first, as far as it went.
        spans: By robot, when its trajectory begins and ends without its delay, s.
        verdict: The verdict on the cell's trajectory at these delays; None unless all are found.
    """

    delays: Mapping[str, float | None]
    steps: tuple[LeastDelay, ...] = field(repr=False)
    spans: Mapping[str, tuple[float, float]] = field(repr=False)
    verdict: TrajectoryVerdict | None = field(repr=False)

    def __repr__(self) -> str:
        told = ", ".join(
            f"{name} {'never' if d is None else f'{shown_seconds(d)} s'}" for name, d in self.delays.items()
        )
        return f"Schedule({told}; {'proved free' if self.verdict else 'not free'})"

    def _repr_html_(self) -> str:
        ends = [self.spans[name][1] + (delay or 0.0) for name, delay in self.delays.items()]
        scale = (_WIDTH - _MARGIN) / max(ends)
        rows = "".join(mark for k, name in enumerate(self.delays) for mark in self._row(k, name, scale))
        height = _ROW * len(self.delays)
        sizes = f'width="{_WIDTH}" height="{height}" font-size="12"'
        words = f"<p>{html.escape(repr(self))}; red: starts that are refuted</p>"
        return f'{words}<svg xmlns="http://www.w3.org/2000/svg" {sizes}>{rows}</svg>'

    def _row(self, k: int, name: str, scale: float) -> Iterator[str]:
        """A robot's name, the bar of its trajectory, and the starts at which it would collide."""
        top, (begin, end), delay = k * _ROW, self.spans[name], self.delays[name]
        yield f'<text x="0" y="{top + 16}">{html.escape(name)}</text>'
        if delay is not None:
            yield _bar(begin + delay, end + delay, top + 4, 12, "#4477aa", scale)
        refuted = [each for step in self.steps if name in step.waiting for each in step.intervals]
        for each in refuted:
            if each.settled == "refuted":
                yield _bar(begin + each.start, begin + each.end, top + 18, 3, "#cc3311", scale)


def _bar(begin: float, end: float, top: float, height: float, colour: str, scale: float) -> str:
    x, width = _MARGIN + begin * scale, (end - begin) * scale
    return f'<rect x="{x:.2f}" y="{top}" width="{width:.2f}" height="{height}" fill="{colour}"/>'


@set_module("plannercheck")
def schedule(
    checker: Checker,
    order: Sequence[Mapping[str, Run]],
    at_most: float = 10.0,
    resolution: float = 1e-3,
    tube: Tubes = 0.0,
    tolerance: float = DEFAULT_TOLERANCE,
) -> Schedule:
    """The least delay of each robot, one after the other: it waits for all before it, and those after it stand.

    Robots that are yet to start stand at their first points, where they may be in the way. The delays are least for
    this order and one after the other; a robot that waits longer may let another one start earlier.

    Args:
        checker: The checker of a cell (`pc.Robot.together`).
        order: Trajectories by robot, in order of priority; those of one mapping wait together, the first not at all. A
            robot that always stands has its configuration (k,).
        at_most: As for `least_delay`, for each.
        resolution: Likewise.
        tube: Likewise.
        tolerance: Likewise.

    Returns:
        The delays. From the first place on that has none, they are None.

    Raises:
        PlannercheckError: As of `least_delay`.
    """
    groups = _checked(checker, order)
    runs = {name: run for group in groups for name, run in group.items()}
    moving = {name: run for name, run in runs.items() if isinstance(run, Trajectory)}
    spans = {name: (float(run.curve.breaks[0]), float(run.curve.breaks[-1])) for name, run in moving.items()}
    now: dict[str, Run] = {name: run.curve.pieces[0][0] for name, run in moving.items()} | dict(groups[0])
    delays: dict[str, float | None] = {name: 0.0 if name in groups[0] else None for name in moving}
    steps = list[LeastDelay]()
    for group in groups[1:]:
        waiting = {name: run for name, run in group.items() if name in moving}
        first = {name: run for name, run in now.items() if name not in waiting}
        starts = {name: delay for name, delay in delays.items() if delay is not None}
        steps.append(least_delay(checker, first, waiting, at_most, resolution, starts, tube, tolerance))
        if steps[-1].delay is None:
            return Schedule(delays, tuple(steps), spans, None)
        now.update(waiting)
        delays.update(dict.fromkeys(waiting, steps[-1].delay))
    verdict = steps[-1].verdict if steps else first_conflict(checker, now, None, tube, tolerance).verdict
    return Schedule(delays, tuple(steps), spans, verdict)


def _checked(checker: Checker, order: Sequence[Mapping[str, Run]]) -> list[Mapping[str, Run]]:
    """The groups in which something moves, of all robots of the cell; the first one also has all that stand."""
    cell = cell_of(checker)
    if not isinstance(order, Sequence) or not all(isinstance(group, Mapping) for group in order):
        raise PlannercheckError("an order is a list of trajectories by robot: [{'left': first}, {'right': second}]")
    names = [name for group in order for name in group]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise PlannercheckError(f"{', '.join(twice)} can't have two places in the order: give each robot one")
    check_runs(cell, {name: run for group in order for name, run in group.items()})
    standing = {name: run for group in order for name, run in group.items() if not isinstance(run, Trajectory)}
    moving = [{name: run for name, run in group.items() if name not in standing} for group in order]
    first, *later = [group for group in moving if group]
    return [{**first, **standing}, *later]
