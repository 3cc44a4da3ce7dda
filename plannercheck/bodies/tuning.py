"""The filters and stages that may be turned off, in one record. Verdicts, pairs and proofs depend on none of them.

In: fields by name. Out: `Tuning`, whose table (name, type, default, purpose) is all that the core, `bench switches`,
`inspect`, the documentation and the test of independence know of the fields: a new field is a line here, a member of
`Tuning` in cpp/checking/checker.hpp and a line in cpp/bindings/bind_tuning.cpp. The core's record alone has `halves`,
which cuts curves: a verdict may depend on it where a curve comes within the tolerance, so only its test turns it off.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from functools import lru_cache
from typing import Any, Literal, NamedTuple, TypeAlias

from plannercheck.common.core import core
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.public_names import set_module

Method: TypeAlias = Literal["oracle", "walk", "exact"]

METHODS: tuple[Method, ...] = ("oracle", "walk", "exact")


class TuningField(NamedTuple):
    """A row of the table of fields.

    Attributes:
        name: The field's name, an argument of `Tuning`.
        type: Its type, "bool" or "Method".
        default: The value that is used unless another is given.
        purpose: What the field is for, in one sentence.
    """

    name: str
    type: str
    default: bool | str
    purpose: str


def _switch(purpose: str, compiled: bool = True) -> Any:
    """A field that is on by default; `compiled` where the core has a member of that name."""
    return field(default=True, metadata={"purpose": purpose, "compiled": compiled})


@set_module("plannercheck")
@dataclass(frozen=True, kw_only=True)
class Tuning:
    """What saves work in a check. Verdicts, pairs and proofs depend on none of the fields."""

    method: Method = field(
        default="oracle",
        metadata={
            "purpose": 'The solver of two hulls: "oracle" (small active sets on both sides), "walk" (the paper\'s '
            'coupled walk) or "exact" (exact arithmetic alone).',
            "compiled": True,
        },
    )
    # Stages of the pair test, before exact arithmetic decides.
    cached_plane: bool = _switch("First try the plane that separated the pair last time, also for an earlier motion.")
    box_face: bool = _switch("Try the face of a box around one body that comes nearest to separating both boxes.")
    centre_axis: bool = _switch("Try the axis between the centres, and balls around them, before the method.")
    turned_axis: bool = _switch("Turn that axis to where the bodies would face each other if they were ellipsoids.")
    nearest_points: bool = _switch("Try nearest points in doubles if the method does not decide.")
    double_double: bool = _switch("Try nearest points in double-double before exact arithmetic.")
    warm_start: bool = _switch(
        "Let double-double and exact arithmetic begin with the vertices where the stage before gave up."
    )
    trees_first: bool = _switch(
        "Test solids whose hulls met last time by their trees of triangles, before their hulls; in batches, where a "
        "checker knows what is inside of both bodies, by samples of that before all."
    )
    dents: bool = _switch(
        "Let hulls that meet deeper than the shallow dents of their solids be the last word; along motions, look at "
        "triangles only on intervals on which bodies go less far than such dents reach."
    )
    # Filters of states and motions.
    bounds: bool = _switch(
        "Bounding balls and a tree of the obstacles settle pairs that are far apart; bounds of speed do along motions."
    )
    boxes: bool = _switch("Planes along the faces of the bodies' boxes settle pairs that are apart.")
    overlaps: bool = _switch(
        "A ball inside one body that meets a box inside the other settles a pair, where any collision decides."
    )
    learning: bool = _switch("Pairs that collided lately are tested first, where any collision decides.")
    part_trees: bool = _switch(
        "Trees of boxes, and many parts at once or along one direction, settle sets of parts. Off, each part is tested "
        "by itself, as a body of its own."
    )
    sorted_states: bool = _switch("Like states of a set are judged together.")
    float_poses: bool = _switch("Filters of sets look at poses in floats, whose error is bounded.")
    thin_tubes: bool = _switch("Along curves, tubes as thin as rounding are covered as rounding is, at no cost.")
    covers: bool = _switch(
        "Several pieces of a trajectory, one after the other, are proved by one straight motion whose tube holds them."
    )
    hollows: bool = _switch(
        "Along motions, sets of parts in the hollow of a solid are settled where they are further from all of it than "
        "they go; off, on intervals on which they go less far than the tolerance."
    )
    reach: bool = _switch("Pairs that can't meet within the limits are left out there.", compiled=False)
    static_poses: bool = _switch(
        "Links that no joint of the group moves are posed once, as obstacles are.", compiled=False
    )
    middle_states: bool = _switch(
        "The middle states of several motions are judged first, together; then the ends, where these often collide.",
        compiled=False,
    )
    apart_cells: bool = _switch(
        "Pairs whose relative pose depends on one or two joints are looked up in cells proved apart.", compiled=False
    )

    def __post_init__(self) -> None:
        if self.method not in METHODS:
            raise unknown_name("method", self.method, METHODS)
        for row in tuning_table():
            if row.type == "bool" and not isinstance(getattr(self, row.name), bool):
                raise PlannercheckError(f"Tuning: {row.name} must be True or False, not {getattr(self, row.name)!r}")

    def without(self, *switches: str) -> Tuning:
        """The same with switches, given by name, off.

        Raises:
            PlannercheckError: If a name is none of a switch.
        """
        known = [row.name for row in tuning_table() if row.type == "bool"]
        for switch in switches:
            if switch not in known:
                raise unknown_name("switch", switch, known)
        return replace(self, **dict.fromkeys(switches, False))  # type: ignore[arg-type]


def tuning_table() -> tuple[TuningField, ...]:
    """The fields of `Tuning`, in their order."""
    return tuple(
        TuningField(each.name, str(each.type), each.default, each.metadata["purpose"])  # type: ignore[arg-type]
        for each in fields(Tuning)
    )


_LINES = "".join(f"        {row.name}: {row.purpose}\n" for row in tuning_table())
Tuning.__doc__ = f"{Tuning.__doc__}\n\n    Attributes:\n{_LINES}    "

DEFAULT_TUNING = Tuning()


@lru_cache(maxsize=256)
def core_tuning(tuning: Tuning = DEFAULT_TUNING) -> Any:
    """The same as the core's record, whose members have these names."""
    out = core.Tuning()
    for each in fields(tuning):
        if each.metadata["compiled"]:
            value = getattr(tuning, each.name)
            setattr(out, each.name, value if isinstance(value, bool) else getattr(core.Solver, value))
    return out


def pair_options(method: Method = "oracle", **switches: bool) -> Any:
    """The core's record of a method and of switches by name, for calls that judge pairs of bodies."""
    return core_tuning(Tuning(method=method, **switches))
