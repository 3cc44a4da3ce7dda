"""Results that depend on a robot alone, shared by all its checkers in any scene.

In: a key that holds all that a result depends on, and a function that computes it. Out: the result, computed once.
Robots that differ only in what they carry, or in the values of joints that they hold, share one memory, since planning
problems make such robots again and again; so keys have to tell them apart. Results are immutable, and so are keys: they
hold the bodies themselves, not their names, so that a robot whose attributes were replaced gets results of its own.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import Any, TypeVar, cast

Result = TypeVar("Result")

# Results that are kept; those that were asked for least recently are forgotten. One robot without carried objects needs
# about ten of them.
_MOST_RESULTS = 96


class RobotMemory:
    """Results by key. Threads may share it."""

    def __init__(self) -> None:
        """Starts with nothing."""
        self._results: OrderedDict[Hashable, Any] = OrderedDict()
        self._lock = threading.Lock()

    def recall(self, key: Hashable, compute: Callable[[], Result]) -> Result:
        """The result for a key, all that it depends on; computed if it is not known, or no longer.

        Two threads that ask at once may both compute it.
        """
        with self._lock:
            if key in self._results:
                self._results.move_to_end(key)
                return cast(Result, self._results[key])
        computed = compute()  # without the lock: it may ask for other results
        with self._lock:
            kept = self._results.setdefault(key, computed)
            self._results.move_to_end(key)
            while len(self._results) > _MOST_RESULTS:
                self._results.popitem(last=False)
        return cast(Result, kept)

    def __reduce__(self) -> tuple[Any, ...]:
        """Copies and pickles start with nothing: compiled results can't be written."""
        return RobotMemory, ()
