"""Times in sentences keep microseconds, whatever the clock."""

import numpy as np
import pytest

from plannercheck.common.shown_times import shown_seconds, shown_span


@pytest.mark.parametrize(
    ("time", "shown"),
    [(0.0, "0"), (2.0, "2"), (1e-9, "1e-09"), (-0.7, "-0.7"), (0.1 + 0.2, "0.3"), (1.7e9 + 0.25, "1700000000.25")],
)
def test_examples(time, shown):
    assert shown_seconds(time) == shown
    assert shown_span(time, 3) == f"{shown} to 3 s"


def test_any_time_is_shown_to_the_microsecond_and_to_six_digits():
    rng = np.random.default_rng(0)
    for time in rng.choice([-1, 1], 2000) * 10 ** rng.uniform(-12, 10, 2000):
        off = abs(float(shown_seconds(time)) - time)
        assert off <= 0.5e-6 + 2**-53 * abs(time)
        assert off <= 0.5e-5 * abs(time)
