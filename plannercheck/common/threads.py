"""How many threads a call may use."""

from __future__ import annotations

from plannercheck.common.whole_numbers import whole_number

# Never more than this: no machine has as many cores, and systems refuse to start very many.
MOST_THREADS = 1024


def checked_threads(threads: int, rows: int) -> int:
    """How many threads are useful for this many rows: 1 to `threads`, each with a row at least.

    Raises:
        PlannercheckError: If `threads` is no whole number of at least 1.
    """
    return max(1, min(whole_number(threads, "threads must be a whole number of at least 1"), rows, MOST_THREADS))
