"""What a proof of a motion is: plain data, nothing computed.

In: names and numbers. Out: `Proof`, frozen, which saves, loads and verifies itself. The claim of a proof in space, word
for word: while the parameter t goes from 0 to 1, every joint of `model.joints` goes its own way from `motion.start` to
`motion.end`:

- "turn" and "slide": the value goes linearly from multiplier * start + offset to multiplier * end + offset;
- "circle" (cosine and sine): about its axis the short way round, at constant speed;
- "ball" (a unit quaternion x, y, z, w): by slerp, the short way;
- "planar" (x, y, cosine, sine) and "free" (x, y, z, quaternion): along the one screw that leads from start to end, the
  turn being the short way;

and all the way the convex hulls of `vertices` of the two bodies of every pair of `model.pairs`, each swollen by its
`radius`, are more than `margin` apart. Links are where exact kinematics of the given numbers puts them: placements as
the affine maps that they are, axes as they are, the true sine and cosine. The paddings are parts of the radii. The
margin is there for what computed poses and states may be off by, so that what is proved holds for `check_states` as
well. Whoever makes a proof chooses it: that it is enough for that is not proved, nor that the configurations are within
limits, nor, without `robot=` and `scene=`, whose joints, bodies and pairs these are.

The same classes serve the plane, where `kind` is "plane", and model and motion are of `planar_proof`.
"""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from plannercheck.proofs.planar_proof import PlanarModel, PlanarMotion  # type: ignore[import-not-found,unused-ignore]

Floats = NDArray[np.float64]

FORMAT, VERSION = "plannercheck motion proof", 1

# The kinds of joints, and how many numbers each takes.
JOINT_VALUES = {"turn": 1, "slide": 1, "circle": 2, "planar": 4, "ball": 4, "free": 7}

# The world, where an index of a joint, link or frame is expected.
WORLD = -1


@dataclass(frozen=True)
class Joint:
    """A joint that is not fixed.

    Attributes:
        name: The URDF's.
        kind: One of `JOINT_VALUES`.
        parent: Index of the joint before it in the tree, less than its own; -1 for the world.
        placement: Rows of the (3, 4) placement on the parent joint's frame, 12 numbers, m: fixed joints are part of it.
        axis: (3,) unit vector, which it turns about or slides along; zeros for the other kinds.
        columns: For each number that it takes, the column of the configuration, -1 where it is held.
        multipliers: Applied to the column's value.
        offsets: Added to it; where it is held, the value.
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
        name: The URDF's.
        joint: Index of the joint that it is on, -1 for the world.
        placement: Rows of the (3, 4) placement on the joint's frame, 12 numbers, m.
    """

    name: str
    joint: int
    placement: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class PosedBody:
    """A convex body where it is.

    Attributes:
        name: Of the collision geometry.
        label: The link, carried object or obstacle that it belongs to.
        link: Index of the link, -1 for the world.
        pose: Rows of the (3, 4) pose on the link or in the world, 12 numbers, m.
        vertices: (n, 3) whose hull it is, in its own frame, m.
        radius: How far around the hull it reaches, m: of balls, capsules, and padding.
        padding: Which part of the radius is padding, m.
        centre: (3,) of a ball in the body's frame that holds all vertices, m.
        reach: The ball's radius without `radius`, m.
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


@dataclass(frozen=True, eq=False)
class Model:
    """A robot in a scene: all that a motion's claim depends on but the motion.

    Attributes:
        joints: Parents first.
        links: The robot's.
        bodies: All of them.
        pairs: Of bodies, as indices: every pair that the checker tests at any configuration.
        whole_turns: Columns that are angles of which a whole turn changes nothing.
        columns: Numbers in a configuration.
    """

    joints: tuple[Joint, ...]
    links: tuple[Link, ...]
    bodies: tuple[PosedBody, ...]
    pairs: tuple[tuple[int, int], ...]
    whole_turns: tuple[int, ...]
    columns: int


@dataclass(frozen=True)
class Motion:
    """A straight motion in space.

    Attributes:
        start: (columns,) rad and m.
        end: (columns,) the end that is gone to: angles of `whole_turns` by the short way.
        asked_end: (columns,) the end that was asked for, which differs by whole turns, and by a rest, for rounding:
            what it may move bodies by, every gap exceeds besides the margin, so that either end may be taken.
    """

    start: tuple[float, ...]
    end: tuple[float, ...]
    asked_end: tuple[float, ...]


@dataclass(frozen=True)
class Entry:
    """What proves one pair apart on an interval.

    Attributes:
        pair: Index into the pairs.
        start: Parameter.
        end: Parameter; the next entry of the pair starts at the same double.
        by: "plane": along `direction`, fixed in `frame`, the first body is beyond the second, by more than the margin;
            "balls": the balls around both bodies are that far apart.
        frame: Index of the link in whose frame the direction is fixed, -1 for the world.
        direction: Three numbers (two in the plane) of any length but 0, from the second body to the first; none for
            balls.
    """

    pair: int
    start: float
    end: float
    by: Literal["plane", "balls"]
    frame: int = WORLD
    direction: tuple[float, ...] = ()


@dataclass(frozen=True)
class Hashes:
    """SHA-256 of what a proof is about, hexadecimal (`hashing.py`).

    Attributes:
        robot: Of joints, links, and the bodies on links.
        scene: Of the bodies in the world.
        model: Of all of the model, pairs included.
    """

    robot: str
    scene: str
    model: str


@dataclass(frozen=True)
class Verification:
    """What the verifier says of a proof; true if and only if it is proved.

    Attributes:
        proved: Whether every entry was confirmed, and the entries prove the claim.
        fault: If not: which entry or number fails and why, in one sentence.
        entries: How many entries were confirmed.
        seconds: Time taken, s.
    """

    proved: bool
    fault: str | None
    entries: int
    seconds: float

    def __bool__(self) -> bool:
        return self.proved


@dataclass(frozen=True, eq=False)
class Proof:
    """A motion and what proves it free.

    Attributes:
        kind: "space" or "plane".
        robot: Its name.
        scene: Its name.
        hashes: Of the model.
        model: The robot in its scene.
        motion: The motion.
        margin: What every gap exceeds, m: for what computed poses and states are off by.
        entries: For every pair, intervals that tile [0, 1].
    """

    kind: Literal["space", "plane"]
    robot: str
    scene: str
    hashes: Hashes
    model: Model | PlanarModel
    motion: Motion | PlanarMotion
    margin: float
    entries: tuple[Entry, ...]

    def verify(self, robot: str | None = None, scene: str | None = None) -> Verification:
        """Confirms the claim in ball arithmetic, without the compiled core and without what made the proof.

        Args:
            robot: If given, the model has to be that of this robot: a shipped one's name, a YAML or a URDF file.
            scene: With `robot`: a shipped scene's name, or a file; None for the empty one.

        Returns:
            The verification; a proof whose numbers are malformed in whatever way is not proved.

        Raises:
            PlannercheckError: If python-flint is not installed, or the robot's or scene's files can't be read.
        """
        found: Verification = _verifier(self.kind).verified(self)
        if found and robot is not None:
            model = confirmed(self, robot, scene)
            return Verification(model.proved, model.fault, found.entries, found.seconds + model.seconds)
        return found

    def save(self, path: str | Path) -> None:
        """Writes the proof, whole or not at all.

        Args:
            path: Ends in .json or .npz.

        Raises:
            PlannercheckError: If the file can't be written.
        """
        from plannercheck.proofs.files import save_proofs

        save_proofs([self], path)

    @classmethod
    def load(cls, path: str | Path) -> Proof:
        """Reads a file of one proof.

        Args:
            path: Of a file that `save` wrote.

        Returns:
            The proof with the same bits; it is not verified.

        Raises:
            PlannercheckError: If the file is no proof, is cut off, of another version, or of several motions.
        """
        from plannercheck.proofs.files import load_one

        return load_one(path)


def confirmed(proof: Proof, robot: Any, scene: str | None) -> Verification:
    """Whether a proof's model is that of a robot in a scene (`proof_confirmation.py`); no entry is looked at."""
    found: Verification = _verifier(proof.kind).model_confirmed(proof, robot, scene)
    return found


def _verifier(kind: str) -> Any:
    """The module that verifies a kind of proof."""
    return importlib.import_module(f"plannercheck.proofs.{'verify' if kind == 'space' else 'planar_verify'}")
