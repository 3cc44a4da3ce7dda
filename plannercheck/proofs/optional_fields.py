"""Fields that files and hashes leave out where they hold their default.

In: a dataclass. Out: its fields without those. So what was written before a field was known is read as it was meant,
and keeps its hash.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import Field, fields
from types import MappingProxyType
from typing import Any

import numpy as np

# Metadata of such a field.
OPTIONAL: Mapping[str, bool] = MappingProxyType({"optional": True})


def optional_names(kind: Any) -> set[str]:
    """The names of a dataclass's optional fields."""
    return {field.name for field in fields(kind) if field.metadata.get("optional")}


def given_fields(value: Any) -> list[Field[Any]]:
    """The fields of an object that are written."""
    optional = optional_names(value)
    return [field for field in fields(value) if field.name not in optional or _is_given(value, field)]


def _is_given(value: Any, field: Field[Any]) -> bool:
    given = getattr(value, field.name)
    return isinstance(given, np.ndarray) or given != field.default
