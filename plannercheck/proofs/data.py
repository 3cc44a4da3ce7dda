"""The data of a proof of a motion: plain numbers and names, nothing computed.

In: names and numbers. Out: `ProofData`, frozen, and its parts. The claim of a proof in space, word for word: while the
parameter t goes from 0 to 1, every joint of `model.joints` moves by itself from `motion.start` to `motion.end`. Let p
be the polynomial of degree n whose control points in Bernstein form are start, `motion.inner` and end, for each column;
without inner ones it is the straight line, of degree 1.

- "turn" and "slide": the value is multiplier * p(t) + offset;
- "circle" (cosine and sine): about its axis the short way round, at constant speed;
- "ball" (a unit quaternion x, y, z, w): by slerp, the short way;
- "planar" (x, y, cosine, sine) and "free" (x, y, z, quaternion), where `motion.path` is "screw": along the one screw
  that leads from start to end, the turn being the short way; where it is "slerp": the position is p(t), and the turn
  goes about one axis the short way at constant speed;

and at every t the two bodies of every pair of `model.pairs`, each inflated by its `radius`, are more than `margin`
apart. With a `motion.tube` they are so at every configuration whose numbers differ from these, at any t, by at most the
tube's number of their column. A body is the convex hull of its `vertices`. One with `triangles` is these triangles and,
if their directed edges cancel, all points around which they wind. One with `parts` is their union. One with a
`half_space` is that, and has no vertices. Links are where exact kinematics of the given numbers puts them: placements
as the affine maps that they are, axes as they are, the true sine and cosine. The paddings are parts of the radii. The
margin covers the error of computed poses and states, so that the claim holds for `check_states` as well. The maker of a
proof chooses the margin. Not proved are: that the margin is large enough for this; that the configurations are within
limits; and, without `robot=` and `scene=`, that joints, bodies and pairs are those of a certain robot and scene.

The same classes serve the plane, where `kind` is "plane", and model and motion are of `planar_proof`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from plannercheck.common.array_types import Floats
from plannercheck.common.motion_paths import MotionPath
from plannercheck.proofs.optional_fields import OPTIONAL
from plannercheck.proofs.planar_proof import PlanarModel, PlanarMotion

FORMAT, VERSION = "plannercheck motion proof", 1

# The world, where an index of a joint, link or frame is expected.
WORLD = -1


@dataclass(frozen=True)
class JointForm:
    """What the verifier knows of a kind of joints: all of `proofs/` reads it here, by `JOINTS[kind]`.

    Attributes:
        numbers: How many numbers a joint takes.
        lengths: How many of its first numbers are lengths, m, by which it slides.
        has_axis: Whether it turns about an axis, or slides along one.
        has_unit: Whether its other numbers have the length 1: a cosine and a sine, or a quaternion.
    """

    numbers: int
    lengths: int
    has_axis: bool
    has_unit: bool

    @property
    def is_pose(self) -> bool:
        """Whether it both slides and turns, so that `Motion.path` names its way."""
        return self.lengths > 0 and self.has_unit


# The kinds of joints.
JOINTS = {
    "turn": JointForm(numbers=1, lengths=0, has_axis=True, has_unit=False),
    "slide": JointForm(numbers=1, lengths=1, has_axis=True, has_unit=False),
    "circle": JointForm(numbers=2, lengths=0, has_axis=True, has_unit=True),
    "planar": JointForm(numbers=4, lengths=2, has_axis=False, has_unit=True),
    "ball": JointForm(numbers=4, lengths=0, has_axis=False, has_unit=True),
    "free": JointForm(numbers=7, lengths=3, has_axis=False, has_unit=True),
}


@dataclass(frozen=True)
class Joint:
    """A joint that is not fixed.

    Attributes:
        name: Its name in the URDF.
        kind: One of `JOINTS`.
        parent: Index of the joint before it in the tree, less than its own; -1 for the world.
        placement: Rows of the (3, 4) placement on the parent joint's frame, 12 numbers, m: fixed joints are part of it.
        axis: (3,) unit vector about which it turns or along which it slides; zeros for the other kinds.
        columns: For each of its numbers the column of the configuration, -1 where it is held.
        multipliers: Factors of the column's value.
        offsets: Added to the product; where the number is held, its value.
    """

    name: str
    kind: str
    parent: int
    placement: tuple[float, ...]
    axis: tuple[float, ...]
    columns: tuple[int, ...]
    multipliers: tuple[float, ...]
    offsets: tuple[float, ...]


@dataclass(frozen=True)
class Link:
    """A link of the robot.

    Attributes:
        name: Its name in the URDF.
        joint: Index of the joint that it is on, -1 for the world.
        placement: Rows of the (3, 4) placement on the joint's frame, 12 numbers, m.
    """

    name: str
    joint: int
    placement: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class PosedBody:
    """A convex body, or a solid, at its pose.

    Attributes:
        name: Name of the collision geometry.
        label: The link, carried object or obstacle that it belongs to.
        link: Index of the link, -1 for the world.
        pose: Rows of the (3, 4) pose on the link or in the world, 12 numbers, m.
        vertices: (n, 3) points whose hull it is, in its own frame, m; of a solid the corners of its triangles; of a
            half-space none (0,).
        radius: How far around the hull it reaches, m: the radius of balls and capsules, plus padding.
        padding: The part of the radius that is padding, m.
        centre: (3,) of a ball in the body's frame that holds all vertices, m.
        reach: The ball's radius without `radius`, m.
        triangles: For a solid: indices of vertices. Entries name ranges of them.
        half_space: For a half-space: four numbers (n, d), for all points x of its frame with n . x <= d, m times the
            length of n. It is in the world.
        parts: For a set of parts: "balls" about the vertices; "boxes" along the axes of its frame, of which each two
            vertices are opposite corners; "prisms", each the hull of three vertices and of where these are at z =
            `base`. The body is their union, empty if there are no vertices (0,). Entries name ranges of parts.
        radii: For balls: their radii (n,), or one for all (1,), m; `radius` is added.
        base: For prisms: the z where they end, m.
    """

    name: str
    label: str
    link: int
    pose: tuple[float, ...]
    vertices: Floats
    radius: float
    padding: float
    centre: tuple[float, ...]
    reach: float
    triangles: tuple[tuple[int, int, int], ...] = field(default=(), metadata=OPTIONAL)
    half_space: tuple[float, ...] = field(default=(), metadata=OPTIONAL)
    parts: Literal["", "balls", "boxes", "prisms"] = field(default="", metadata=OPTIONAL)
    radii: Floats | None = field(default=None, metadata=OPTIONAL)
    base: float = field(default=0.0, metadata=OPTIONAL)


@dataclass(frozen=True, eq=False)
class Model:
    """A robot in a scene: everything that a claim depends on except the motion.

    Attributes:
        joints: Parents first.
        links: The robot's.
        bodies: All of them.
        pairs: Pairs of indices of bodies: every pair that the checker tests at any configuration.
        whole_turns: Columns of angles that a whole turn does not change.
        columns: How many numbers a configuration has.
    """

    joints: tuple[Joint, ...]
    links: tuple[Link, ...]
    bodies: tuple[PosedBody, ...]
    pairs: tuple[tuple[int, int], ...]
    whole_turns: tuple[int, ...]
    columns: int


@dataclass(frozen=True)
class Motion:
    """A motion in space: straight, or along polynomials.

    Attributes:
        start: (columns,) rad and m.
        end: (columns,) the end of the motion: angles of `whole_turns` take the short way.
        asked_end: (columns,) the end that was asked for. It differs by whole turns and by rounding. Every gap exceeds
            the margin plus the motion of bodies by this rounding, so the claim holds for either end.
        path: How planar and free joints move.
        inner: (degree - 1, columns) row after row, the control points between start and end; none of a straight motion.
            Then the end is the one that was asked for, and planar and free joints move by "slerp". Those of a cosine, a
            sine or a quaternion mean nothing.
        tube: (columns,) rad and m, at least 0, and 0 of cosines, sines and quaternions; none for zeros. With a tube,
            too, the end is the one that was asked for.
        clock: When the motion begins and ends on the clock of a scene in which something moves, s; else none.
    """

    start: tuple[float, ...]
    end: tuple[float, ...]
    asked_end: tuple[float, ...]
    path: MotionPath = "screw"
    inner: tuple[float, ...] = field(default=(), metadata=OPTIONAL)
    tube: tuple[float, ...] = field(default=(), metadata=OPTIONAL)
    clock: tuple[float, ...] = field(default=(), metadata=OPTIONAL)

    @property
    def control(self) -> tuple[tuple[float, ...], ...]:
        """(degree + 1, columns) all control points, of a well-formed motion."""
        columns = len(self.start)
        return (self.start, *(self.inner[k : k + columns] for k in range(0, len(self.inner), columns)), self.end)


@dataclass(frozen=True)
class Entry:
    """The proof that one pair is apart on an interval.

    Attributes:
        pair: Index into the pairs.
        start: Parameter.
        end: Parameter; the next entry of the pair starts at the same double.
        by: "plane": along `direction`, fixed in `frame`, the first body is beyond the second, by more than the margin;
            "balls": the balls around both bodies are that far apart;
            "half-space": one body is a half-space, and the other one is beyond its plane, by more than the margin.
        frame: Index of the link in whose frame the direction is fixed, -1 for the world.
        direction: Against a set of parts three numbers each for one direction or more: each part is beyond the other
            body along one of them. Else three numbers (two in the plane) of any length but 0, from the second body to
            the first; none for balls and half-spaces.
        first: Which triangles or parts of the first body, from the first index to before the second; empty for the hull
            of all vertices, or all parts. Only planes hold some of them apart.
        second: The same for the second body.
    """

    pair: int
    start: float
    end: float
    by: Literal["plane", "balls", "half-space"]
    frame: int = WORLD
    direction: tuple[float, ...] = ()
    first: tuple[int, ...] = field(default=(), metadata=OPTIONAL)
    second: tuple[int, ...] = field(default=(), metadata=OPTIONAL)


@dataclass(frozen=True)
class Hashes:
    """SHA-256 of what a proof is about, hexadecimal (`hashing.py`).

    Attributes:
        robot: Hash of joints, links, and the bodies on links.
        scene: Hash of the bodies in the world.
        model: Hash of the whole model, pairs included.
    """

    robot: str
    scene: str
    model: str


@dataclass(frozen=True)
class Verification:
    """The verifier's result; true if and only if the claim is proved.

    Attributes:
        proved: Whether every entry was confirmed, and the entries prove the claim.
        fault: If not: which entry or number fails and why, in one sentence.
        entries: How many entries were confirmed.
        seconds: Time taken, s.
        compared: What was compared with which file, sentence by sentence; empty if nothing was.
    """

    proved: bool
    fault: str | None
    entries: int
    seconds: float
    compared: tuple[str, ...] = ()

    def __bool__(self) -> bool:
        return self.proved


@dataclass(frozen=True, eq=False)
class ProofData:
    """A motion and the proof that it is free; `proof.Proof` can verify, save and load itself.

    Attributes:
        kind: "space" or "plane".
        robot: The robot's name.
        scene: The scene's name.
        hashes: Hashes of the model.
        model: The robot in its scene.
        motion: The motion.
        margin: Every gap exceeds this, m; it covers the error of computed poses and states.
        entries: For every pair, intervals that tile [0, 1]; or, where some are of parts of solids, intervals and parts
            that together cover [0, 1] and all pairs of triangles.
    """

    kind: Literal["space", "plane"]
    robot: str
    scene: str
    hashes: Hashes
    model: Model | PlanarModel
    motion: Motion | PlanarMotion
    margin: float
    entries: tuple[Entry, ...]
