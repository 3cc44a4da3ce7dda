"""The data of proofs about pairs of links: never or always in collision within the limits, or at a state.

In: names and numbers. Out: `PairProofs`, frozen, and its parts. The claim, word for word: for every configuration whose
numbers are within `lower` and `upper`, joints that are held at where the model holds them, the bodies of both links

- "never": are more than `margin` apart, each with each;
- "always": overlap, some body of one with some body of the other;
- "collides": overlap at `state`.

A pair's `cells` are a tree in preorder. Its root is the box of all configurations within the limits. A cell with a
column is cut at `value`: the half below comes next, then the half above. One without is a leaf: all of its box is
proved by one plane for each pair of bodies, or by one overlap. Only columns that move joints between both links count,
and only they may be cut.

An overlap is a closed surface of triangles around 0, whose corners are differences of vertices: a point of the first
body less one of the second, in the middle of the box. If each triangle's plane has 0 more than d behind it, the bodies
are d deep in each other along every direction, and share a point as long as they are displaced by less. Radii of balls
and capsules add to d. Where they are enough, one point does: the corners' mean by `weights`, which is e away from 0, so
that the bodies are their radii less e deep in each other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, TypeAlias

from plannercheck.common.checked_yaml import error_context
from plannercheck.common.errors import PlannercheckError
from plannercheck.proofs.data import VERSION, WORLD, Hashes, Model
from plannercheck.proofs.files import checked_version, read_document, write_document
from plannercheck.proofs.optional_fields import OPTIONAL
from plannercheck.proofs.plain_data import from_plain, to_plain

PAIR_FORMAT = "plannercheck pair proof"

Answer: TypeAlias = Literal["never", "always", "collides"]


@dataclass(frozen=True)
class Plane:
    """What keeps two bodies apart all over a box.

    Attributes:
        first: Index of a body of the first link.
        second: Index of a body of the second link.
        frame: Index of a link on a joint between both, in whose frame the direction is fixed; -1 for the frame of the
            lowest joint that carries both.
        direction: Three numbers of any length but 0, from the second body to the first.
    """

    first: int
    second: int
    frame: int
    direction: tuple[float, ...]


@dataclass(frozen=True)
class Overlap:
    """How deep two hulls are in each other in the middle of a box.

    Attributes:
        first: Index of a body of the first link.
        second: Index of a body of the second link.
        points: Corners: a vertex of the first body, and one of the second.
        facets: Triangles, counter-clockwise seen from outside: indices of `points`; none with weights.
        weights: A positive number a corner, of any sum; none with facets.
    """

    first: int
    second: int
    points: tuple[tuple[int, int], ...]
    facets: tuple[tuple[int, int, int], ...] = field(default=(), metadata=OPTIONAL)
    weights: tuple[float, ...] = field(default=(), metadata=OPTIONAL)


@dataclass(frozen=True)
class Cell:
    """A box of joint values.

    Attributes:
        column: Where it is cut; -1 for a leaf.
        value: At which number, rad or m.
        planes: Of a leaf that is free: one for each pair of bodies.
        overlaps: Of a leaf that is not: one.
    """

    column: int = field(default=WORLD, metadata=OPTIONAL)
    value: float = field(default=0.0, metadata=OPTIONAL)
    planes: tuple[Plane, ...] = field(default=(), metadata=OPTIONAL)
    overlaps: tuple[Overlap, ...] = field(default=(), metadata=OPTIONAL)


@dataclass(frozen=True)
class PairProof:
    """The proof about one pair.

    Attributes:
        link_a: A link.
        link_b: Another link.
        answer: What is proved.
        cells: The tree; for "collides" one leaf.
        state: (columns,) where they collide, rad and m.
    """

    link_a: str
    link_b: str
    answer: Answer
    cells: tuple[Cell, ...]
    state: tuple[float, ...] = field(default=(), metadata=OPTIONAL)


@dataclass(frozen=True, eq=False)
class PairProofs:
    """Proofs about pairs of links of one robot.

    Attributes:
        robot: Its name.
        hashes: Hashes of the model.
        model: The robot; its bodies are all of the links that are named.
        lower: (columns,) the limits, rad and m.
        upper: (columns,).
        margin: m; covers the error of computed poses.
        pairs: The proofs.
    """

    robot: str
    hashes: Hashes
    model: Model
    lower: tuple[float, ...]
    upper: tuple[float, ...]
    margin: float
    pairs: tuple[PairProof, ...]


def save_pair_proofs(proofs: PairProofs, path: str | Path) -> None:
    """Writes proofs to a .json or .npz, whole or not at all.

    Raises:
        PlannercheckError: If the file can't be written.
    """
    write_document({"format": PAIR_FORMAT, "version": VERSION, **to_plain(proofs)}, path)


def load_pair_proofs(path: str | Path) -> PairProofs:
    """Reads a file of proofs, without verifying them.

    Raises:
        PlannercheckError: If it is none, is cut off, or of another version.
    """
    with error_context(f"proof file {str(path)!r}"):
        return pairs_from_document(read_document(path))


def is_of_pairs(content: Any) -> bool:
    """Whether a document is one of proofs about pairs of links."""
    return isinstance(content, dict) and content.get("format") == PAIR_FORMAT


def pairs_from_document(content: Any) -> PairProofs:
    """The proofs of a document.

    Raises:
        PlannercheckError: If it is none, or of another version.
    """
    if not is_of_pairs(content):
        raise PlannercheckError(f"is no pair proof: 'format' must be {PAIR_FORMAT!r}")
    checked_version(content)
    if content.get("pairs") == []:
        raise PlannercheckError("has no pairs")
    given = {key: value for key, value in content.items() if key not in ("format", "version")}
    return from_plain(PairProofs, given, "document")


def bodies_of(model: Model, link: str) -> list[int]:
    """The indices of a link's bodies."""
    return [k for k, body in enumerate(model.bodies) if body.link != WORLD and model.links[body.link].name == link]


def columns_of(model: Model, joints: Sequence[int]) -> list[int]:
    """The columns that move some joints, ascending."""
    return sorted({column for k in joints for column in model.joints[k].columns if column >= 0})


def joints_between(model: Model, first: int, second: int) -> tuple[int, list[int]]:
    """The lowest joint that carries two links, -1 for the world, and the joints below it that carry one of them."""
    chains = []
    for link in (first, second):
        joint, chain = model.links[link].joint, set[int]()
        while joint != WORLD:
            chain.add(joint)
            joint = model.joints[joint].parent
        chains.append(chain)
    return max(chains[0] & chains[1], default=WORLD), sorted(chains[0] ^ chains[1])
