"""A robot in notebooks: a table of its configurations' numbers and their limits.

In: a robot's line of words, names, limits. Out: HTML.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.common.html_tables import html_table


def robot_html(title: str, joints: Sequence[str], starts: Sequence[int], lower: Floats, upper: Floats) -> str:
    """The table below a title; a joint has a row for each number from its column in `starts` on. Limits: (nq,)."""
    names = np.repeat(np.array(joints, dtype=object), np.diff([*starts, len(lower)]))
    rows = [
        (column, name, f"{low:.6g}", f"{high:.6g}")
        for column, (name, low, high) in enumerate(zip(names, lower, upper, strict=True))
    ]
    return html_table(title, ("column", "joint", "lower, rad or m", "upper"), rows)
