"""Runs a campaign: draws without end, each judged by itself, in any number of processes.

In: a campaign, how much is to be judged. Out: its tally, which does not depend on the number of processes, since every
draw has random numbers of its own.
"""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Callable
from typing import Any, Protocol, TypeVar

from plannercheck.common.cache import uncached
from plannercheck.evaluation.campaign.tallies import Tally
from plannercheck.evaluation.worker_processes import workers

Case = TypeVar("Case")


class Campaign(Protocol[Case]):
    """What is drawn, and how it is judged."""

    @property
    def name(self) -> str:
        """By which files of cases tell their campaign."""

    @property
    def unit(self) -> str:
        """What is counted: pairs or motions."""

    @property
    def is_of_one_use(self) -> bool:
        """Whether no one meets its bodies again, so that the cache of bodies is left alone."""

    def judge(self, number: int, tally: Tally[Case]) -> None:
        """Makes the `number`-th draw, and counts all outcomes on it."""

    def lines(self, tally: Tally[Case]) -> list[str]:
        """The tables."""

    def case_of(self, document: dict[str, Any]) -> Case:
        """The case of a document."""

    def faults(self, case: Case) -> dict[str, str]:
        """What is wrong with a case, by contestant or kind."""

    def shrunk(self, case: Case) -> Case:
        """A smaller case that still fails; the same if it does not fail."""


def run(
    campaign: Campaign[Case],
    wanted: int,
    processes: int = 1,
    progress: Callable[[Tally[Case]], object] | None = None,
) -> Tally[Case]:
    """Runs a campaign until so many pairs or motions are judged; a longer run starts with the draws of a shorter one.

    `progress` is called after each draw.
    """
    tally = Tally[Case]()
    with uncached() if campaign.is_of_one_use else contextlib.nullcontext(), workers(processes) as some:
        for found in some.results(judged, ((campaign, number) for number in itertools.count())):
            tally.merge(found)
            if progress is not None:
                progress(tally)
            if tally.judged >= wanted:
                break
    return tally


def judged(task: tuple[Campaign[Case], int]) -> Tally[Case]:
    """What is found on one draw; an exception breaks it."""
    campaign, number = task
    tally = Tally[Case](draws=1)
    try:
        campaign.judge(number, tally)
    except Exception as error:
        tally.broken[f"draw {number}: {error!r}"] += 1
    tally.judged = max(tally.judged, 1)
    return tally
