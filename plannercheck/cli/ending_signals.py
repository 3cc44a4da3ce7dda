"""Ctrl-C and SIGTERM end a command wherever it is: with an exception that is raised until it is handled.

In: a scope. Out: `KeyboardInterrupt`, or `Terminated`, out of it. Idea: compiled modules of other libraries do not
expect that a signal's handler raises. While they load, they turn the exception into an ImportError or end the process;
elsewhere they may drop it, and the command would go on. So the handler does not raise during an import: a program that
has only begun to load ends at once, with nothing to lose; others wait. After a signal the handler is called again and
again until the scope has ended: it raises unless the exception is being handled.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

# s: between two calls of the handler. Far below what a person notices, far above what a call takes.
_IN_IMPORTS, _ONCE_RAISED = 0.02, 0.2
# Where Python's own machinery of imports says that it comes from.
_IMPORTING = "<frozen importlib._bootstrap>"


class Terminated(KeyboardInterrupt):
    """SIGTERM: handled as Ctrl-C is, so that what is kept for later is said."""


@contextmanager
def ended_by_signals() -> Iterator[EndingSignals]:
    """Raises `KeyboardInterrupt` where Ctrl-C comes, `Terminated` where SIGTERM does.

    Only the main thread may ask for that. A Ctrl-C that is ignored, as in the background of a shell, stays ignored, and
    a handler of the caller's own is kept.
    """
    handler = EndingSignals()
    if threading.current_thread() is not threading.main_thread():
        yield handler
        return
    numbers = [signal.SIGTERM]
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        numbers.append(signal.SIGINT)
    before = {number: signal.signal(number, handler) for number in numbers}
    said = sys.unraisablehook
    sys.unraisablehook = _but_interruptions(said)
    try:
        yield handler
    finally:
        handler.stop()
        sys.unraisablehook = said
        for number, previous in before.items():
            signal.signal(number, previous)


class EndingSignals:
    """The handler of both signals."""

    def __init__(self) -> None:
        self._ended = False
        self._sending = threading.Lock()
        self._say: Callable[[KeyboardInterrupt], int] | None = None

    @contextmanager
    def ending_the_process(self, say: Callable[[KeyboardInterrupt], int]) -> Iterator[None]:
        """As long as this lasts, a signal in an import ends the process: what loads can't be stopped otherwise.

        `say` says why, and returns the exit code.
        """
        self._say = say
        try:
            yield
        finally:
            self._say = None

    def __call__(self, number: int, frame: FrameType | None) -> None:
        """Raises, where it may, and comes again."""
        if self._ended:
            return
        stop = Terminated() if number == signal.SIGTERM else KeyboardInterrupt()
        importing = _is_importing(frame)
        if importing and self._say is not None:
            os._exit(self._say(stop))
        self._come_again(number, _IN_IMPORTS if importing else _ONCE_RAISED)
        if not importing and not isinstance(sys.exc_info()[1], KeyboardInterrupt):
            raise stop

    def stop(self) -> None:
        """Raises nothing from now on, nor comes again."""
        self._ended = True
        with self._sending:  # a signal that is under way has been sent
            signal.sigpending()  # and is delivered before the next line

    def _come_again(self, number: int, seconds: float) -> None:
        later = threading.Timer(seconds, self._send, (number,))
        later.daemon = True
        later.start()

    def _send(self, number: int) -> None:
        with self._sending:
            if not self._ended:
                signal.pthread_kill(threading.main_thread().ident or 0, number)


def _but_interruptions(say: Callable[[Any], object]) -> Callable[[Any], object]:
    """Says nothing of an interruption that Python drops, in a weak reference's callback for one: it comes again."""

    def say_others(dropped: Any) -> None:
        if not isinstance(dropped.exc_value, KeyboardInterrupt):
            say(dropped)

    return say_others


def _is_importing(frame: FrameType | None) -> bool:
    """Whether an import is among the calls that led to a frame."""
    while frame is not None:
        if frame.f_code.co_filename == _IMPORTING:
            return True
        frame = frame.f_back
    return False


def is_handled_outside() -> bool:
    """Whether a scope around this one raises on Ctrl-C."""
    return isinstance(signal.getsignal(signal.SIGINT), EndingSignals)
