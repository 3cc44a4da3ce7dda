"""Another library in processes of its own, which can be stopped: libccd, which FCL uses, hangs on some pairs.

In: another library, a draw. Out: its outcomes, "timeout" where it does not return; the next process continues after
that pair.
"""

from __future__ import annotations

import os
import select
import signal
from typing import Generic

from plannercheck.evaluation.stress.other_libraries import Drawn, Peer

# Longest time for one pair, s: thousands of times what FCL and coal take; preparing the bodies is part of the first.
PAIR_LIMIT = 2.0

_CODES: dict[bool | str, bytes] = {False: b"0", True: b"1", "exception": b"e", "unfit": b"u"}
_OUTCOMES = {code: outcome for outcome, code in _CODES.items()}


class Supervised(Generic[Drawn]):
    """A peer that can be stopped."""

    def __init__(self, peer: Peer[Drawn], limit: float = PAIR_LIMIT) -> None:
        """Waits no longer than `limit` s for a pair."""
        self.name = peer.name
        self._peer, self._limit = peer, limit

    def outcomes(self, drawn: Drawn) -> list[bool | str]:
        """See `Peer`."""
        count, found = len(drawn.poses_p), list[bool | str]()
        while len(found) < count:
            found += self._some(drawn, len(found))
            if len(found) < count:
                found.append("timeout")
        return found

    def _some(self, drawn: Drawn, first: int) -> list[bool | str]:
        """Outcomes from a pair on, up to the first that takes too long."""
        read, write = os.pipe()
        child = os.fork()
        if child == 0:
            self._work(drawn, first, write)
        os.close(write)
        found: list[bool | str] = []
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
