"""The JSON of glTF files, with each value's kind checked as it is taken.

In: bytes. Out: `Table`, a JSON object that knows its place in the file, for errors.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any, NoReturn

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError, shortened
from plannercheck.common.unique_keys import object_of

_LARGEST = 2**53  # of whole numbers: up to it, JSON's numbers are exact everywhere


@dataclass(frozen=True, eq=False)
class Table:
    """A JSON object and its place in the file, e.g. "nodes[3]"; `top` is the file's outermost one, None for itself."""

    items: dict[str, Any]
    name: str = "the file"
    top: Table | None = None

    def root(self) -> Table:
        """The file's outermost object."""
        return self.top or self

    def table(self, key: str, default: dict[str, Any] | None = None) -> Table:
        """An object in it."""
        value = self._get(key, default)
        if not isinstance(value, dict):
            self._refuse(key, "an object", value)
        return Table(value, self._place(key), self.root())

    def tables(self, key: str) -> list[Table]:
        """A list of objects in it; none if there is no list."""
        value = self.items.get(key, [])
        if not isinstance(value, list) or not all(isinstance(each, dict) for each in value):
            self._refuse(key, "a list of objects", value)
        return [Table(each, f"{self._place(key)}[{k}]", self.root()) for k, each in enumerate(value)]

    def pick(self, key: str, index: int) -> Table:
        """One object of a list in it."""
        value = self.items.get(key, [])
        if not isinstance(value, list) or not 0 <= index < len(value):
            raise PlannercheckError(f"names {key}[{index}], but has no such entry")
        if not isinstance(value[index], dict):
            self._refuse(key, "a list of objects", value[index])
        return Table(value[index], f"{self._place(key)}[{index}]", self.root())

    def integer(self, key: str, default: int | None = None) -> int:
        """A whole number that is not negative."""
        value = self._get(key, default)
        if not _is_index(value):
            self._refuse(key, "a whole number, at least 0", value)
        return int(value)

    def integers(self, key: str) -> list[int]:
        """A list of whole numbers; empty if there is none."""
        value = self.items.get(key, [])
        if not isinstance(value, list) or not all(map(_is_index, value)):
            self._refuse(key, "a list of whole numbers, at least 0", value)
        return [int(each) for each in value]

    def floats(self, key: str, count: int | None, default: list[float] | None = None) -> Floats:
        """So many finite numbers; any number of them if `count` is None."""
        value = self._get(key, default)
        if not isinstance(value, list) or (count is not None and len(value) != count) or not all(map(_is_float, value)):
            self._refuse(key, f"{'some' if count is None else count} finite numbers", value)
        return np.array(value, dtype=np.float64)

    def text(self, key: str, default: str | None = None) -> str:
        """A text."""
        value = self._get(key, default)
        if not isinstance(value, str):
            self._refuse(key, "a text", value)
        return value

    def texts(self, key: str) -> list[str]:
        """A list of texts; empty if there is none."""
        value = self.items.get(key, [])
        if not isinstance(value, list) or not all(isinstance(each, str) for each in value):
            self._refuse(key, "a list of texts", value)
        return list(value)

    def _get(self, key: str, default: Any) -> Any:
        if key not in self.items and default is None:
            raise PlannercheckError(f"{self.name} has no {key!r}")
        return self.items.get(key, default)

    def _place(self, key: str) -> str:
        return key if self.top is None else f"{self.name}.{key}"

    def _refuse(self, key: str, wanted: str, value: Any) -> NoReturn:
        raise PlannercheckError(f"{self._place(key)} must be {wanted}, not {shortened(repr(value))}")


def root_of(text: bytes) -> Table:
    """The outermost object of a glTF file's JSON."""
    try:
        found = json.loads(text, parse_constant=_no_constant, object_pairs_hook=object_of)
    except (ValueError, RecursionError) as error:  # of texts and of encodings
        raise PlannercheckError(f"has no valid JSON: {error}") from None
    if not isinstance(found, dict):
        raise PlannercheckError("its JSON must be an object")
    return Table(found)


def _no_constant(word: str) -> NoReturn:
    raise ValueError(f"{word} is no number of JSON")


def _is_index(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < _LARGEST


def _is_float(value: Any) -> bool:
    if not isinstance(value, int | float) or isinstance(value, bool):
        return False
    return bool(abs(value) < 1e300)  # and so a double that is finite, and whose products are
