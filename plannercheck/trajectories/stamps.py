"""Times of messages: whole nanoseconds.

In: times in s. Out: nanoseconds, if the times are a message's times.
"""

from __future__ import annotations

import numpy as np

from plannercheck.common.array_types import Bools, Floats

# Nanoseconds beyond which doubles skip whole numbers, 104 days.
_MOST = 2.0**53


def nanoseconds(times: Floats) -> tuple[Floats, Bools]:
    """(n,) the nearest whole nanoseconds, as doubles, and which times are the doubles nearest to them."""
    stamps = np.rint(times * 1e9)
    return stamps, (stamps / 1e9 == times) & (np.abs(stamps) < _MOST)


def durations(times: Floats) -> Floats:
    """(n - 1,) s from each time to the next, each the double nearest to that of the message.

    Differences of the doubles themselves are off by the rounding of the times, which is large beside a short segment
    late in a long trajectory.
    """
    stamps, exact = nanoseconds(times)
    return np.diff(stamps) / 1e9 if exact.all() else np.diff(times)
