"""The kinds of bodies, as keys of tables, and what follows from them; the core's are in cpp/bodies/polytope.hpp.

In: a prepared body, two of them, or a shape. Out: its kind, or its traits, which are all that most code asks for. A
pair has the later of its bodies' kinds.
"""

from __future__ import annotations

from typing import Any, Literal, NamedTuple, Protocol, TypeAlias

from plannercheck.common.errors import PlannercheckError

Kind: TypeAlias = Literal["hull", "solid", "part_set", "half_space"]

_KINDS: tuple[Kind, ...] = ("hull", "solid", "part_set", "half_space")


class KindTraits(NamedTuple):
    """What follows from a body's kind.

    Attributes:
        is_convex: Whether it is convex.
        is_bounded: Whether it is bounded, so that it may be carried.
        has_parts: Whether it is tested part by part: its hull is a box that says nothing.
    """

    is_convex: bool
    is_bounded: bool
    has_parts: bool

    @property
    def fills_hull(self) -> bool:
        """Whether the body is its hull."""
        return self.is_convex and self.is_bounded

    @property
    def has_hull(self) -> bool:
        """Whether its vertices are those of its hull."""
        return self.is_bounded and not self.has_parts


_TRAITS: dict[Kind, KindTraits] = {
    "hull": KindTraits(True, True, False),
    "solid": KindTraits(False, True, False),
    "part_set": KindTraits(False, True, True),
    "half_space": KindTraits(True, False, False),
}


class _Body(Protocol):
    @property
    def kind(self) -> Kind: ...

    @property
    def traits(self) -> KindTraits: ...


def traits_of(kind: Kind) -> KindTraits:
    """What follows from a kind."""
    return _TRAITS[kind]


def are_bounded(p: _Body, r: _Body) -> bool:
    """Whether neither of two bodies is a half-space.

    Raises:
        PlannercheckError: If both are.
    """
    if not (p.traits.is_bounded or r.traits.is_bounded):
        raise PlannercheckError("P and R are two half-spaces: a half-space is tested against bodies that are bounded")
    return p.traits.is_bounded and r.traits.is_bounded


def have_parts(p: _Body, r: _Body) -> bool:
    """Whether at least one of two bodies is a set of parts."""
    return p.traits.has_parts or r.traits.has_parts


def pair_kind(p: _Body, r: _Body) -> Kind:
    """The kind of a pair.

    Raises:
        PlannercheckError: If both are half-spaces.
    """
    are_bounded(p, r)
    return max(p.kind, r.kind, key=_KINDS.index)


def kind_of_shape(shape: Any) -> Kind:
    """The kind of a shape's body; most become hulls."""
    return getattr(shape, "body_kind", "hull")
