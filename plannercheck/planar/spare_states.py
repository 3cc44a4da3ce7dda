"""OMPL states to work with, for one call at a time.

In: an OMPL space. Out: `SpareStates.taken`, which hands out as many states as a call needs. Another thread, or a
finaliser that runs within the call, gets other states, so no call overwrites the states of another.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any


class SpareStates:
    """States of one space, a few for each running call.

    They are allocated by a `SpaceInformation`: such states free themselves, states of the space do not.
    """

    def __init__(self, space: Any, count: int) -> None:
        """Takes the space, and how many states a call needs."""
        from ompl import base  # an optional part of what planar robots need

        self._information, self._count = base.SpaceInformation(space), count
        self._spare: list[tuple[Any, ...]] = []  # pop and append are single steps for other threads

    @contextmanager
    def taken(self) -> Iterator[tuple[Any, ...]]:
        """The states, of any values, until the end of the block."""
        try:
            states = self._spare.pop()
        except IndexError:
            states = tuple(self._information.allocState() for _ in range(self._count))
        try:
            yield states
        finally:
            self._spare.append(states)
