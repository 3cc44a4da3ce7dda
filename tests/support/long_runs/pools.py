"""Pools of forked workers, whose parent has called on threads before: each worker's verdicts are the parent's.

In: how many pools. Out: counts. Between pools, the parent goes on with its threads, and a worker calls on threads of
its own. A pool that has not answered after `_LIMIT` hangs.
"""

import multiprocessing
import os
from pathlib import Path

import numpy as np

import plannercheck as pc
from long_runs.counts import BrokenPromiseError, Counts

_WORKERS, _TASKS = 4, 40  # of a pool
_ROWS, _MOTIONS = 100, 10
_LIMIT = 120.0  # s


def run(folder: Path, pools: int, rng: np.random.Generator) -> Counts:
    """Starts pools, one after the other.

    Raises:
        BrokenPromiseError: At a pool that hangs, dies or has other verdicts.
    """
    work = _Work()
    tasks = range(_TASKS)
    wanted = [work.digest(k, threads=1) for k in tasks]
    workers = set[int]()
    for number in range(pools):
        threads = int(rng.integers(2, 5))
        if [work.digest(k, threads) for k in tasks[:4]] != wanted[:4]:
            raise BrokenPromiseError(f"pool {number}: other verdicts in the parent on {threads} threads")
        with multiprocessing.get_context("fork").Pool(_WORKERS, _inherit, (work,)) as pool:
            try:
                found = pool.starmap_async(_in_worker, [(k, threads) for k in tasks], 1).get(_LIMIT)
            except multiprocessing.TimeoutError:
                raise BrokenPromiseError(f"pool {number} hangs: no answer after {_LIMIT:g} s") from None
        if [digest for _, digest in found] != wanted:
            raise BrokenPromiseError(f"pool {number}: other verdicts in workers on {threads} threads")
        workers.update(pid for pid, _ in found)
    return {"pools": pools, "workers": len(workers), "calls": 2 * pools * _TASKS}


class _Work:
    """Sets of states and of motions of a robot in a scene, and their verdicts."""

    def __init__(self) -> None:
        self._checker = pc.Checker(pc.Robot.load("panda"), pc.Scene.load("bookshelf"))
        self._rows = [self._checker.robot.random_configurations(_ROWS, k) for k in range(_TASKS)]

    def digest(self, k: int, threads: int) -> bytes:
        """The verdicts of the k-th set, of its states and of motions between them."""
        rows = self._rows[k]
        states = self._checker.check_states(rows, threads=threads)
        near = self._checker.check_motions(rows[:_MOTIONS], rows[:_MOTIONS] + 0.02, threads=threads)
        return np.packbits(np.concatenate([states, near])).tobytes()


_inherited: list[_Work] = []


def _inherit(work: _Work) -> None:
    """Keeps what a fork has from its parent: tasks that carried it would be about pickled checkers."""
    _inherited[:] = [work]


def _in_worker(k: int, threads: int) -> tuple[int, bytes]:
    """Who it was, and the verdicts of the k-th set."""
    return os.getpid(), _inherited[0].digest(k, threads)
