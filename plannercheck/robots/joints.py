"""What a joint is: one description a kind, which all code about joints reads; the verifier (proofs/) has its own.

In: a joint of Pinocchio's. Out: its `JointKind`. Idea: a joint slides by its first numbers, along its axis if it has
one, else along x, y and z of its placement; then it turns by the other numbers, about its axis, or about z without one.
So numbers, limits, bounds of rates and of rounding, and states of OMPL follow from how many lengths and which turn it
has.

The kinds are numbered as in `JointKind` of cpp/robots/joints.hpp, where joints about x, y, z and about any axis
have numbers of their own. docs/explanation/add_a_part.md lists what a new kind needs.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import pinocchio as pin

Name = Literal["turn", "circle", "slide", "planar", "ball", "free"]

# How a joint turns: by an angle, by the angle's cosine and sine, or by a quaternion x, y, z, w; "" if it only slides.
Turn = Literal["", "angle", "pair", "quaternion"]

_TURN_NUMBERS: dict[Turn, int] = {"": 0, "angle": 1, "pair": 2, "quaternion": 4}

# How far from the origin a motion may take a joint between its ends, as a multiple of the larger one's distance. A
# slide goes straight. A pose follows a screw of at most half a turn, on which the distance from the start only grows,
# up to that of the ends; or its position goes straight.
_STRAIGHT, _ON_A_SCREW = 1.0, 3.0


@dataclass(frozen=True, eq=False)
class JointKind:
    """A kind of joints.

    Attributes:
        name: Its name, which it has in proofs as well (proofs/data.py).
        first: The least of its numbers.
        pinocchio: Pinocchio's names without "JointModel", in the order of the numbers.
        lengths: How many of a joint's first numbers are lengths, m.
        turn: What its other numbers are.
        has_axis: Whether it turns about an axis, or slides along one.
        part: `PartKind` of cpp/motions/path.hpp, by which its numbers change together on a motion; None for one that
            takes one number.
    """

    name: Name
    first: int
    pinocchio: tuple[str, ...]
    lengths: int
    turn: Turn
    has_axis: bool
    part: int | None

    @property
    def numbers(self) -> int:
        """How many numbers a joint takes in Pinocchio's configurations."""
        return self.lengths + _TURN_NUMBERS[self.turn]

    @property
    def state_numbers(self) -> int:
        """How many numbers a state of OMPL has for it: one angle in place of a pair."""
        return self.lengths + {"": 0, "angle": 1, "pair": 1, "quaternion": 4}[self.turn]

    @property
    def unit(self) -> tuple[int, int] | None:
        """(start, stop) of the numbers that form a unit vector: cosine and sine, or a quaternion."""
        return (self.lengths, self.numbers) if self.turn in ("pair", "quaternion") else None

    @property
    def is_pose(self) -> bool:
        """Whether it both slides and turns, along a screw or each by itself."""
        return self.lengths > 0 and self.turn != ""

    @property
    def turn_part(self) -> int | None:
        """`part` of its turn, where that moves by itself."""
        return {"pair": CIRCLE.part, "quaternion": BALL.part}.get(self.turn)

    @property
    def stretch(self) -> float:
        """How far from the origin a motion may take it, as a multiple of the larger distance of both ends."""
        return _ON_A_SCREW if self.is_pose else _STRAIGHT

    @property
    def unaligned(self) -> int:
        """The number of joints with an axis that is none of the frame's."""
        return self.first + self.pinocchio.index(next(name for name in self.pinocchio if name.endswith("Unaligned")))


TURN = JointKind("turn", 0, ("RX", "RY", "RZ", "RevoluteUnaligned"), 0, "angle", True, None)
CIRCLE = JointKind("circle", 4, ("RUBX", "RUBY", "RUBZ", "RevoluteUnboundedUnaligned"), 0, "pair", True, 0)
SLIDE = JointKind("slide", 8, ("PX", "PY", "PZ", "PrismaticUnaligned"), 1, "", True, None)
PLANAR = JointKind("planar", 9, ("Planar",), 2, "pair", False, 2)
BALL = JointKind("ball", 10, ("Spherical",), 0, "quaternion", False, 1)
FREE = JointKind("free", 11, ("FreeFlyer",), 3, "quaternion", False, 3)

# By number.
KINDS: tuple[JointKind, ...] = (*[TURN] * 4, *[CIRCLE] * 4, SLIDE, PLANAR, BALL, FREE)

_BY_NAME = {name: kind for kind in KINDS for name in kind.pinocchio}


def kind_of(joint: pin.JointModel) -> JointKind | None:
    """The kind of one of Pinocchio's joints; None for one that is not known here."""
    return _BY_NAME.get(str(joint.shortname()).removeprefix("JointModel"))


def number_of(joint: pin.JointModel) -> int | None:
    """Its number in the compiled kernel."""
    kind, name = kind_of(joint), str(joint.shortname()).removeprefix("JointModel")
    if kind is None:
        return None
    return kind.first + (kind.pinocchio.index(name) if KINDS.count(kind) > 1 else 0)
