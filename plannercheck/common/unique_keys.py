"""Keys that stand once: of a key given twice, parsers take the last value in silence, others the first.

In: the keys of a mapping of YAML, or the pairs of an object of JSON. Out: the key that is given twice, or the object.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

from plannercheck.common.errors import PlannercheckError, shortened


def key_given_twice(names: Sequence[str]) -> str | None:
    """A key that stands more than once among those of a mapping, if there is one."""
    return Counter(names).most_common(1)[0][0] if len(set(names)) < len(names) else None


def object_of(pairs: Sequence[tuple[str, Any]]) -> dict[str, Any]:
    """An object of JSON, as `json.loads(…, object_pairs_hook=object_of)` makes it."""
    found = dict(pairs)
    if len(found) < len(pairs):
        twice = key_given_twice([key for key, _ in pairs])
        raise PlannercheckError(f"an object has the key {shortened(twice)!r} twice: give it once")
    return found
