"""Progress of long work of the library, reported to a listener.

In: from the work, the part that is done. Out: nothing, unless the caller has named a listener; the command line names a
`TerminalLine`. A listener hears its own context only, so other threads stay silent. The listener does not hear of the
end of work that is part of other work, only of the progress of the whole: a hundred parts of a tenth of a second are
ten seconds of work.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TextIO, TypeAlias

from plannercheck.common.escaping import on_terminal

Listener: TypeAlias = Callable[[int, int, str], None]

_WIDTH = 79  # characters: a line that wraps can't be taken away

_listener: ContextVar[Listener | None] = ContextVar("progress listener", default=None)

# The pieces of work that are under way, from the whole to its part.
_open: ContextVar[tuple[str, ...]] = ContextVar("work under way", default=())


def report(done: int, total: int, what: str) -> None:
    """Says that `done` of `total` steps of some work are done; the work begins with 0 and ends with all of them."""
    listener = _listener.get()
    if listener is None:
        return
    around = _open.get()
    if done >= total and around:
        listener(0, 1, around[-1])
    else:
        listener(done, total, what)


def is_heard() -> bool:
    """Whether anybody hears reports."""
    return _listener.get() is not None


@contextmanager
def reported(what: str) -> Iterator[None]:
    """Reports a piece of work that is one step, and may have parts."""
    report(0, 1, what)
    token = _open.set((*_open.get(), what))
    try:
        yield
    finally:
        _open.reset(token)
        report(1, 1, what)


@contextmanager
def reported_to(listener: Listener) -> Iterator[None]:
    """Names who hears reports meanwhile."""
    token = _listener.set(listener)
    try:
        yield
    finally:
        _listener.reset(token)


class TerminalLine:
    """A line on a terminal about work that takes longer than `patience` s, also while nothing is reported."""

    def __init__(self, stream: TextIO, patience: float = 1.0) -> None:
        self._stream, self._patience, self._lock = stream, patience, threading.Lock()
        self._text, self._is_shown, self._timer = "", False, threading.Timer(0, self._show)

    def __call__(self, done: int, total: int, what: str) -> None:
        """Hears a report."""
        if done >= total:
            self.clear()
            return
        if not self._text:
            self._began = time.monotonic()
            self._timer = threading.Timer(self._patience, self._show)
            self._timer.daemon = True
            self._timer.start()
        self._text = on_terminal(f"{what}: {done} of {total}")[:_WIDTH]
        if time.monotonic() - self._began >= self._patience:
            self._show()

    def _show(self) -> None:
        with self._lock:
            if self._text:
                self._stream.write(f"\r\033[K{self._text}")
                self._stream.flush()
                self._is_shown = True

    def clear(self) -> None:
        """Takes the line away: the work is done, or something else is to be written."""
        self._timer.cancel()
        with self._lock:
            if self._is_shown:
                self._stream.write("\r\033[K")
                self._stream.flush()
            self._text, self._is_shown = "", False
