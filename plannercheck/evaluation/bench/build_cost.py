"""The cost of a construction: seconds and resident memory, without the disk cache of prepared bodies.

In: a function that builds. Out: `Built`. Wall time is the user's waiting time; processor time is comparable on a loaded
machine. Memory is the growth of the process's resident set; freed memory is given back to the system before and after.
The figure is coarse below some hundred kB, and 0 where freed memory was used again.
"""

from __future__ import annotations

import contextlib
import ctypes
import gc
import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeVar

from plannercheck.common.cache import uncached

T = TypeVar("T")

_STATM = Path("/proc/self/statm")  # Linux: sizes in pages, the second is the resident set


@dataclass(frozen=True)
class Built(Generic[T]):
    """A built object and the cost of building it.

    Attributes:
        value: The object that was built.
        seconds: Wall time.
        busy: Seconds of the processor, in all threads of this process.
        resident: Bytes that the resident set grew by; None where the system does not tell.
    """

    value: T
    seconds: float
    busy: float
    resident: int | None


def built(build: Callable[[], T]) -> Built[T]:
    """Builds something without the disk cache."""
    with uncached():
        before = resident_bytes()
        start, busy = time.perf_counter(), time.process_time()
        value = build()
        seconds, busy = time.perf_counter() - start, time.process_time() - busy
        after = resident_bytes()
    return Built(value, seconds, busy, None if before is None or after is None else max(after - before, 0))


def resident_bytes() -> int | None:
    """The process's resident set, garbage and freed memory left out; None where the system does not tell."""
    if not _STATM.exists():
        return None
    gc.collect()
    with contextlib.suppress(OSError, AttributeError):  # of the GNU C library
        ctypes.CDLL(None).malloc_trim(0)
    return int(_STATM.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
