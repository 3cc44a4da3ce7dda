"""The kinds of bodies, as keys of tables; the core's `Kind` is in cpp/bodies/polytope.hpp.

In: a prepared body, two of them, or a shape. Out: its kind. A pair has the later of its bodies' kinds.
"""

from __future__ import annotations

from typing import Any, Literal, Protocol, TypeAlias

from plannercheck.common.errors import PlannercheckError

Kind: TypeAlias = Literal["hull", "solid", "part_set", "half_space"]

_KINDS: tuple[Kind, ...] = ("hull", "solid", "part_set", "half_space")


class _Body(Protocol):
    @property
    def kind(self) -> Kind: ...


def pair_kind(p: _Body, r: _Body) -> Kind:
    """The kind of a pair.

    Raises:
        PlannercheckError: If both are half-spaces.
    """
    if p.kind == r.kind == "half_space":
        raise PlannercheckError("P and R are two half-spaces: a half-space is tested against bodies that are bounded")
    return max(p.kind, r.kind, key=_KINDS.index)


def kind_of_shape(shape: Any) -> Kind:
    """The kind of a shape's body; most become hulls."""
    kind: Kind = getattr(shape, "body_kind", "hull")
    return kind
