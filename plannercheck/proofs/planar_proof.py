"""The data of a proof of a motion in the plane: plain numbers and names, nothing computed.

In: names and numbers. Out: `PlanarModel` and `PlanarMotion`, the model and the motion of a `Proof` whose kind is
"plane". The claim, word for word: while the parameter t goes from 0 to 1, every angle of a revolute joint goes linearly
from `start` to `end`, and the root, if it is free,

- "straight": has x, y and heading go linearly from `start` to `end`;
- "dubins", "reeds_shepp": is, up to t = 1, where the pieces put it, or anywhere else as long as no point of the robot
  is further than the piece's `slip` from where the piece puts it; and at t = 1 it is at `end`;

and at every t the convex hulls of the two bodies of every pair of `model.pairs` are more than `margin` apart, at exact
kinematics of the given numbers: the true sine and cosine of the sum of the angles along the chain, bodies in the world
as the affine maps that their poses are. The margin is at least the error of computed poses and states; the verifier
confirms that (`least_margin`).

On a curve every piece is an arc of the turning radius, which the root's heading touches, or a line along its heading,
forwards alone for "dubins", and is gone through at one speed; pieces meet, begin at `start` and lead to `end`. The
verifier confirms that up to the pieces' slips, the margin, and at the end 4e-6 of the turning radius and the robot's
size: within these a piece may also go aside or backwards, and between the last piece and `end` nothing is claimed. That
these pieces are the curve that OMPL's DubinsStateSpace or ReedsSheppStateSpace takes between both ends, up to the slip,
is not proved: `planar/curves.py` reads them off OMPL's own interpolation, and tests hold samples of it against them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from plannercheck.common.array_types import Floats


@dataclass(frozen=True)
class PlanarLink:
    """A link: its frame sits at `x`, `y` on its parent's, turned by `angle` and by its joint.

    Attributes:
        name: Name of the link.
        parent: Index of the link before it that it hangs on; -1 for the first one, which is in the world.
        joint: "free": x, y and an angle are added to the anchor's (the first link alone); "revolute": an angle.
        column: Column of the first number of a configuration that moves it.
        x: m.
        y: m.
        angle: rad.
    """

    name: str
    parent: int
    joint: Literal["free", "revolute", "fixed"]
    column: int
    x: float
    y: float
    angle: float


@dataclass(frozen=True, eq=False)
class PlanarBody:
    """A convex polygon on a link, or in the world.

    Attributes:
        name: Name of the polygon.
        label: The link or obstacle that it belongs to.
        link: Index of the link, -1 for the world.
        pose: Rows of the (2, 3) pose in the world, 6 numbers, m; the identity for a body on a link.
        vertices: (n, 2) whose hull it is, in the link's frame, or in its own, m.
        centre: (2,) of a circle in the same frame that holds all vertices, m.
        reach: Its radius, m.
    """

    name: str
    label: str
    link: int
    pose: tuple[float, ...]
    vertices: Floats
    centre: tuple[float, ...]
    reach: float


@dataclass(frozen=True, eq=False)
class PlanarModel:
    """A robot in a scene: everything that a claim depends on except the motion.

    Attributes:
        links: Parents first.
        bodies: The robot's, then the scene's.
        pairs: Pairs of indices of bodies: every pair that the checker tests.
        whole_turns: Columns of angles that a whole turn does not change.
        columns: How many numbers a configuration has.
    """

    links: tuple[PlanarLink, ...]
    bodies: tuple[PlanarBody, ...]
    pairs: tuple[tuple[int, int], ...]
    whole_turns: tuple[int, ...]
    columns: int


@dataclass(frozen=True)
class Piece:
    """A part of a curve: with s from 0 to 1 on it, the root is at origin + s way + R(heading + s turn) arm.

    Attributes:
        start: Parameter of the motion.
        end: Parameter; the next piece starts at the same double.
        origin: (2,) m.
        way: (2,) m; zeros on an arc.
        heading: rad.
        turn: rad; 0 on a line.
        arm: (2,) from an arc's centre to the root, in the frame of the heading, m; zeros on a line.
        slip: No point of the robot is further than this from where the piece puts it, m.
    """

    start: float
    end: float
    origin: tuple[float, float]
    way: tuple[float, float]
    heading: float
    turn: float
    arm: tuple[float, float]
    slip: float


@dataclass(frozen=True)
class PlanarMotion:
    """A motion in the plane.

    Attributes:
        start: (columns,) m and rad.
        end: (columns,) the end that is gone to: angles of `whole_turns` by the short way, but for a curve's heading.
        asked_end: (columns,) the end that was asked for, which differs by whole turns alone.
        curve: How a free root moves.
        turning_radius: Turning radius of curves, m; 0 for straight motions.
        pieces: Pieces of curves, tiling [0, 1]; none for straight motions.
    """

    start: tuple[float, ...]
    end: tuple[float, ...]
    asked_end: tuple[float, ...]
    curve: Literal["straight", "dubins", "reeds_shepp"] = "straight"
    turning_radius: float = 0.0
    pieces: tuple[Piece, ...] = ()
