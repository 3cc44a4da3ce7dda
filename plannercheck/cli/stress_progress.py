"""Lines of progress of the stress of pairs of bodies, on the error stream.

In: the number of pairs that are wished, tallies. Out: a line now and then.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sized
from typing import Any, Protocol

# Seconds between two lines of progress.
_REPORT_SECONDS = 10.0


class PairsTally(Protocol):
    """What has been found so far."""

    @property
    def pairs(self) -> Any:
        """Pairs that were judged: a counter."""
        ...

    @property
    def broken(self) -> Sized:
        """Draws that could not be made or judged."""
        ...

    @property
    def cases(self) -> Sized:
        """Failures that are kept."""
        ...


class PairsProgress:
    """A line now and then."""

    def __init__(self, pairs: int) -> None:
        """Begins to count the time.

        Args:
            pairs: How many pairs are wished.
        """
        self._pairs, self._began = pairs, time.monotonic()
        self._next = self._began + _REPORT_SECONDS

    def __call__(self, tally: PairsTally) -> None:
        """Writes a line if the last one is long ago."""
        now = time.monotonic()
        if now < self._next:
            return
        self._next = now + _REPORT_SECONDS
        pairs = tally.pairs.total()
        rate = pairs / (now - self._began)
        failures = len(tally.cases) + len(tally.broken)
        print(f"{pairs} of {self._pairs} pairs, {rate:.0f} a second, {failures} failures", file=sys.stderr, flush=True)
