"""Trials in forks of a warm process, each within limits of memory and time; what dies or hangs is charged to its trial.

In: a function of a trial's number, which returns a word for what happened, or raises. Out: a `Tally`.

A fork does a batch of trials, with its address space limited (RLIMIT_AS) and a timer that kills it when one trial takes
too long (SIGALRM, which no native code can hold up). It writes the number of the trial at hand to memory that it shares
with its parent, so the parent knows which one it died of, and goes on with the next in a new fork.
"""

import faulthandler
import gc
import json
import mmap
import os
import resource
import signal
import struct
import sys
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from plannercheck.common.errors import PlannercheckError

MEMORY = 2 << 30  # bytes of address space
TIME_LIMIT = 10.0  # s for one trial
BATCH = 500  # trials a fork
LONGEST_MESSAGE = 4000  # characters of an error: more is a file that is printed, not an error
REFUSED = "refused"

_AT_HAND = struct.Struct("q")


@dataclass
class Tally:
    """What happened.

    Attributes:
        outcomes: Trials by what they returned; `REFUSED` for a PlannercheckError.
        faults: For each trial that broke a promise, its number and what happened.
        slowest: Time of the trial that took longest and did not hang, s.
        seconds: All trials together, s.
    """

    outcomes: Counter[str] = field(default_factory=Counter)
    faults: list[tuple[int, str]] = field(default_factory=list)
    slowest: float = 0.0
    seconds: float = 0.0

    @property
    def trials(self) -> int:
        """How many were made."""
        return self.outcomes.total() + len(self.faults)


def run(
    trial: Callable[[int], str],
    count: int,
    folder: Path,
    memory: int = MEMORY,
    time_limit: float = TIME_LIMIT,
    batch: int = BATCH,
) -> Tally:
    """Makes trials.

    Args:
        trial: Of its number; returns a word, raises PlannercheckError where the input is refused, anything else is a
            fault.
        count: Numbers 0 to count - 1 are tried.
        folder: For the forks' reports.
        memory: Address space of a fork, bytes.
        time_limit: For one trial, s.
        batch: Trials a fork.

    Returns:
        The counts: every trial is in `outcomes` or in `faults`.
    """
    tally, began = Tally(), time.perf_counter()
    report, crash = folder / "report", folder / "crash"
    at_hand = mmap.mmap(-1, _AT_HAND.size)
    gc.collect()
    gc.freeze()
    first = 0
    while first < count:
        last = min(first + batch, count)
        _AT_HAND.pack_into(at_hand, 0, first)
        report.write_bytes(b"")
        sys.stdout.flush()
        child = os.fork()
        if child == 0:
            _work(trial, range(first, last), at_hand, report, crash, memory, time_limit)
        _, status = os.waitpid(child, 0)
        for line in report.read_text(encoding="utf-8").splitlines():
            _count(tally, *json.loads(line))
        (number,) = _AT_HAND.unpack_from(at_hand)
        if status:
            tally.faults.append((number, _death(status, crash, time_limit)))
            first = number + 1
        else:
            first = last
    gc.unfreeze()
    tally.seconds = time.perf_counter() - began
    return tally


def _count(tally: Tally, number: int, word: str, fault: str, seconds: float) -> None:
    tally.slowest = max(tally.slowest, seconds)
    if fault:
        tally.faults.append((number, fault))
    else:
        tally.outcomes[word] += 1


def _death(status: int, crash: Path, time_limit: float) -> str:
    code = os.waitstatus_to_exitcode(status)
    if code == -signal.SIGALRM:
        return f"hangs: longer than {time_limit:g} s"
    name = signal.Signals(-code).name if code < 0 else f"exit code {code}"
    return f"dies of {name}: {crash.read_text(errors='replace')[-3000:]}"


def _work(
    trial: Callable[[int], str],
    numbers: range,
    at_hand: mmap.mmap,
    report: Path,
    crash: Path,
    memory: int,
    time_limit: float,
) -> None:
    """A fork's life."""
    code = 70
    try:
        log = crash.open("w+", encoding="utf-8")
        for stream in (1, 2):  # parsers in native code write there what they think
            os.dup2(log.fileno(), stream)
        faulthandler.enable(log)
        warnings.simplefilter("ignore")
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
        with report.open("a", encoding="utf-8", buffering=1) as lines:
            for number in numbers:
                _AT_HAND.pack_into(at_hand, 0, number)
                signal.setitimer(signal.ITIMER_REAL, time_limit)
                began = time.perf_counter()
                word, fault = _tried(trial, number)
                took = time.perf_counter() - began
                signal.setitimer(signal.ITIMER_REAL, 0.0)
                lines.write(json.dumps([number, word, fault, took]) + "\n")
        code = 0
    finally:
        os._exit(code)


def _tried(trial: Callable[[int], str], number: int) -> tuple[str, str]:
    """The trial's word, and what is wrong with it, if anything."""
    try:
        return trial(number), ""
    except PlannercheckError as error:
        words = str(error)
        if not words.strip() or len(words) > LONGEST_MESSAGE:
            return REFUSED, f"an error of {len(words)} characters: {words[:200]}"
        return REFUSED, ""
    except BaseException:
        return "", traceback.format_exc(limit=-6)


def apart(function: Callable[[], object], folder: Path) -> None:
    """Calls a function in a fork, so that threads that it starts are not in this process.

    Raises:
        RuntimeError: If it fails; what it says is in the message.
    """
    log = folder / "apart"
    sys.stdout.flush()
    child = os.fork()
    if child == 0:
        code = 70
        try:
            function()
            code = 0
        except BaseException:
            log.write_text(traceback.format_exc(), encoding="utf-8")
        finally:
            os._exit(code)
    _, status = os.waitpid(child, 0)
    if status:
        raise RuntimeError(log.read_text(encoding="utf-8") if log.exists() else f"died with {status}")
