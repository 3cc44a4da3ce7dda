"""Options that would change nothing in a use of a command are an error, instead of being silently ignored.

In: parsed options, the names of options without effect, and the condition of their effect. Out: an error that names the
given ones.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from plannercheck.common.errors import PlannercheckError


def check_used(options: argparse.Namespace, names: Sequence[str], when: str) -> None:
    """Raises if some of these options, e.g. "--frames", are given, which count only `when`, e.g. "with --path"."""
    given = [name for name in names if _is_given(options, name)]
    if given:
        one = len(given) == 1
        raise PlannercheckError(
            f"{' and '.join(given)} {'counts' if one else 'count'} only {when}: leave {'it' if one else 'them'} out"
        )


def _is_given(options: argparse.Namespace, name: str) -> bool:
    """Whether an option has another value than its default."""
    target = name.lstrip("-").replace("-", "_")
    return bool(getattr(options, target) != options.default_of(target))
