"""How many threads a call may use."""

from __future__ import annotations

from plannercheck.errors import PlannercheckError

# More than any machine has cores for; beyond it the system may refuse to start them.
MOST_THREADS = 1024


def checked_threads(threads: int, rows: int) -> int:
    """How many threads are of use for so many rows, at least one.

    Args:
        threads: What was asked for.
        rows: Each thread takes at least one.

    Returns:
        1 to `threads`.

    Raises:
        PlannercheckError: If it is no whole number, or one that no machine has use for.
    """
    if not isinstance(threads, int) or not 1 <= threads <= MOST_THREADS:
        raise PlannercheckError(f"threads must be a whole number from 1 to {MOST_THREADS}, not {threads!r}")
    return max(1, min(threads, rows))
