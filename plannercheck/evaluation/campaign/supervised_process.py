"""Another library in processes of its own, which can be stopped: libccd, which FCL uses, hangs on some pairs.

In: another library, a draw. Out: its outcomes, TIMEOUT where it does not return; the next process continues after
that pair.
"""

from __future__ import annotations

import os
import select
import signal
from collections.abc import Callable, Iterator
from functools import cache
from typing import Any, Generic, Protocol, TypeVar

from plannercheck.evaluation.campaign.posed_pairs import UNFIT, Outcome, PosedPairs
from plannercheck.evaluation.campaign.tallies import EXCEPTION, TIMEOUT

# Longest time for one pair, s: thousands of times what FCL and coal take; preparing the bodies is part of the first.
PAIR_LIMIT = 2.0

_CODES: dict[Outcome, bytes] = {False: b"0", True: b"1", EXCEPTION: b"e", UNFIT: b"u"}
_OUTCOMES = {code: outcome for outcome, code in _CODES.items()}


Drawn = TypeVar("Drawn", bound=PosedPairs[Any], contravariant=True)


class Peer(Protocol[Drawn]):
    """Another library."""

    name: str

    def outcomes(self, drawn: Drawn, first: int = 0) -> Iterator[Outcome]:
        """Its verdicts from a pair on, EXCEPTION where it throws, UNFIT where it has no shape for a body."""


@cache
def loaded(peer: Callable[[], Peer[Drawn]]) -> Peer[Drawn]:
    """The one peer of a process; PlannercheckError if it is not installed."""
    return peer()


class Supervised(Generic[Drawn]):
    """A peer that can be stopped."""

    def __init__(self, peer: Peer[Drawn], limit: float = PAIR_LIMIT) -> None:
        """Waits no longer than `limit` s for a pair."""
        self.name = peer.name
        self._peer, self._limit = peer, limit

    def outcomes(self, drawn: Drawn) -> list[Outcome]:
        """See `Peer`."""
        count, found = len(drawn.poses_p), list[Outcome]()
        while len(found) < count:
            found += self._some(drawn, len(found))
            if len(found) < count:
                found.append(TIMEOUT)
        return found

    def _some(self, drawn: Drawn, first: int) -> list[Outcome]:
        """Outcomes from a pair on, up to the first that takes too long."""
        read, write = os.pipe()
        child = os.fork()
        if child == 0:
            self._work(drawn, first, write)
        os.close(write)
        found: list[Outcome] = []
        try:
            while select.select([read], [], [], self._limit)[0] and (code := os.read(read, 1)):
                found.append(_OUTCOMES[code])
        finally:
            os.close(read)
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
        return found

    def _work(self, drawn: Drawn, first: int, write: int) -> None:
        """In the child: one byte an outcome, then the end, whatever happens."""
        try:
            for outcome in self._peer.outcomes(drawn, first):
                os.write(write, _CODES[outcome])
        finally:
            os._exit(0)
