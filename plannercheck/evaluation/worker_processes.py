"""Processes that share out the tasks of a run, and end with it.

In: a function, tasks, a number of processes. Out: the results, in the order of the tasks. The processes are started
anew, not forked, and ignore Ctrl-C, which a terminal sends to all its processes: the parent ends them.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import signal
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from multiprocessing import resource_tracker
from typing import TypeVar

Task = TypeVar("Task")
Result = TypeVar("Result")

# Tasks of each process that are begun before their results are asked for: one may take as long as many others.
_UNDER_WAY = 64


class Workers:
    """Some processes, or this one alone."""

    def __init__(self, executor: ProcessPoolExecutor | None, processes: int) -> None:
        self._executor = executor
        self._most = _UNDER_WAY * processes

    def results(self, function: Callable[[Task], Result], tasks: Iterable[Task]) -> Iterator[Result]:
        """The results of a function of the module's own on tasks, in their order; there may be tasks without end."""
        if self._executor is None:
            yield from map(function, tasks)
            return
        under_way: deque[Future[Result]] = deque()
        for task in tasks:
            with ctrl_c_held_back():  # a process may begin here, and inherits that
                under_way.append(self._executor.submit(function, task))
            if len(under_way) >= self._most:
                yield under_way.popleft().result()
        while under_way:
            yield under_way.popleft().result()


@contextlib.contextmanager
def workers(processes: int) -> Iterator[Workers]:
    """Processes for as long as this lasts; what they have not ended by then is dropped. One is this process."""
    if processes == 1:
        yield Workers(None, 1)
        return
    resource_tracker.ensure_running()  # starting it lets Ctrl-C through again
    with ProcessPoolExecutor(processes, multiprocessing.get_context("spawn")) as executor:
        try:
            yield Workers(executor, processes)
        finally:
            executor.shutdown(wait=False, cancel_futures=True)
            for child in multiprocessing.active_children():
                child.terminate()


@contextlib.contextmanager
def ctrl_c_held_back() -> Iterator[None]:
    """A Ctrl-C that comes now comes afterwards; to processes that begin now it never comes."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
