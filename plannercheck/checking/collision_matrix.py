"""Pairs of a robot's links that may be left untested: proposes or audits an allowed collision matrix.

In: a robot. Out: for each pair of links with collision bodies, how many random configurations it collides in, and the
reason, if any, to leave it out. The reasons are as in MoveIt's setup assistant: the links are adjacent; the pair
collides at the reference, or in (almost) all configurations; it never collided. Pairs that unreachable_pairs.py proves
apart within the limits are not sampled. All others are judged exactly, for the robot's geometry: hulls, convex pieces
or solids. All joints but mimic joints are moved, whatever the robot's group.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.shapes import DEFAULT_EXCESS
from plannercheck.bodies.tuning import core_tuning
from plannercheck.checking.compiled_pairs import CompiledPairs, PairSource
from plannercheck.checking.pair_proofs import MeetingProofs
from plannercheck.checking.prepared_bodies import Preparation
from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.arrays import OwnsArrays
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.progress import report
from plannercheck.robots.configurations import joint_width
from plannercheck.robots.link_tree import LinkTree
from plannercheck.robots.robot import Robot
from plannercheck.robots.srdf import DisabledPair

# From this share of colliding configurations on, MoveIt's assistant says that a pair always collides.
ALWAYS = 0.95

# Configurations judged at once: the poses of a humanoid's links then take some 10 MB.
_BATCH = 1000

Reason: TypeAlias = Literal["adjacent", "default", "always", "never", "proved never"]
REASONS: tuple[Reason, ...] = ("adjacent", "default", "always", "never", "proved never")


@dataclass(frozen=True)
class LinkPair:
    """Two links with collision bodies.

    Attributes:
        link_a: The link that comes first among the robot's links.
        link_b: The other link.
        reason: Why the pair may be left untested; None if it has to be tested.
        states: How many configurations were judged.
        collisions: In how many of them they collide.
        first: The first of these configurations, by row; None if there is none.
        at_reference: Whether they collide at the robot's reference.
    """

    link_a: str
    link_b: str
    reason: Reason | None
    states: int
    collisions: int
    first: int | None
    at_reference: bool

    @property
    def links(self) -> frozenset[str]:
        """The names of both links."""
        return frozenset((self.link_a, self.link_b))

    @property
    def share(self) -> float:
        """The share of the configurations in which they collide."""
        return self.collisions / self.states

    @property
    def words(self) -> str:
        """The reason, and how many configurations support it."""
        if self.reason in ("always", "default"):
            return f"{self.reason}: collide in {self.collisions} of {self.states} random configurations"
        return f"never in {self.states} random configurations" if self.reason == "never" else self.reason or ""


@dataclass(frozen=True, eq=False)
class CollisionMatrix(OwnsArrays):
    """All pairs of links of a robot.

    Attributes:
        robot: The robot; its group has all joints that do not follow another one.
        configurations: (n, nq) the configurations that were judged, rad and m.
        pairs: All pairs of links.
    """

    robot: Robot
    configurations: Floats
    pairs: tuple[LinkPair, ...]

    def disabled(self) -> list[LinkPair]:
        """The proposal: pairs with a reason to leave them untested, by reason."""
        return [pair for reason in REASONS for pair in self.pairs if pair.reason == reason]

    def colliding_rows(self, pair: LinkPair) -> NDArray[np.int64]:
        """The rows of `configurations` in which a pair collides, ascending."""
        return colliding_rows(self.robot, self.configurations, pair.link_a, pair.link_b)

    def example(self, pair: LinkPair) -> dict[str, float]:
        """Values by joint name, rad and m, of the first configuration in which a pair collides."""
        if pair.first is None:
            raise PlannercheckError(f"{pair.link_a!r} and {pair.link_b!r} were not seen to collide")
        row = self.configurations[pair.first].tolist()
        return dict(zip(self.robot.joint_names, row, strict=True))


def colliding_rows(robot: Robot, q: Floats, link_a: str, link_b: str) -> NDArray[np.int64]:
    """The rows of configurations (n, nq) in which two links of a robot collide, ascending, decided exactly."""
    bodies = [[k for k, body in enumerate(robot.bodies) if body.link == link] for link in (link_a, link_b)]
    pairs = np.array([(min(i, j), max(i, j)) for i in bodies[0] for j in bodies[1]], dtype=np.int32)
    preparation = Preparation(robot.bodies, DEFAULT_EXCESS, np.zeros(len(robot.bodies)))
    compiled = CompiledPairs(PairSource(robot, robot.bodies, preparation, core_tuning()), pairs)
    return np.flatnonzero(_collide(robot, compiled, q, [range(len(pairs))])[:, 0])


def with_all_joints(robot: Robot) -> Robot:
    """The robot without carried objects, with a group of all joints of one value that do not follow others."""
    joints = [
        name
        for name, joint in zip(list(robot.model.names)[1:], list(robot.model.joints)[1:], strict=True)
        if name not in robot.mimics and joint_width(joint) == 1
    ]
    if not joints:
        raise PlannercheckError(f"robot {robot.name!r} has no joint that moves on its own")
    return robot.carrying(()).with_group(joints, "all joints")


def collision_matrix(robot: Robot, states: int = 10_000, seed: int = 0, always: float = ALWAYS) -> CollisionMatrix:
    """Samples all pairs of links.

    Args:
        robot: The robot. Its group, self pairs and disabled pairs do not matter; joints of several values stay at the
            reference.
        states: Number of random configurations within the limits.
        seed: Seed of the random configurations.
        always: A pair that collides in at least this share of them counts as always colliding.

    Returns:
        The matrix.
    """
    if states < 1 or not 0 < always <= 1:
        raise PlannercheckError(f"states must be at least 1 and always within (0, 1], not {states} and {always}")
    robot = with_all_joints(robot)
    q = robot.random_configurations(states, seed)
    pairs, rows_of_links = _pairs_of_bodies(robot)
    preparation = Preparation(robot.bodies, DEFAULT_EXCESS, np.zeros(len(robot.bodies)))
    apart, _ = MeetingProofs(robot, robot.bodies, preparation, robot.kinematics is not None).of(pairs)
    compiled = CompiledPairs(PairSource(robot, robot.bodies, preparation, core_tuning()), pairs, np.flatnonzero(~apart))
    columns = {int(row): k for k, row in enumerate(compiled.rows)}
    groups = {links: [columns[r] for r in rows if r in columns] for links, rows in rows_of_links.items()}
    counts, first = _counted(robot, compiled, q, list(groups.values()))
    reference = _collide(robot, compiled, robot.reference[None], list(groups.values()))[0]
    adjacent = adjacent_links(robot.link_tree, {str(body.link) for body in robot.bodies})
    found = []
    for k, ((a, b), near) in enumerate(groups.items()):
        count, at_reference = int(counts[k]), bool(reference[k])
        reason = _reason(frozenset((a, b)) in adjacent, at_reference, count / states, always, bool(near))
        found.append(LinkPair(a, b, reason, states, count, int(first[k]) if count else None, at_reference))
    return CollisionMatrix(robot, q, tuple(found))


def _reason(adjacent: bool, at_reference: bool, share: float, always: float, near: bool) -> Reason | None:
    """The reason to leave a pair untested, in the order in which MoveIt's assistant looks for one."""
    if adjacent:
        return "adjacent"
    if at_reference:
        return "default"
    if share >= always:
        return "always"
    if not near:
        return "proved never"
    return None if share else "never"


def _pairs_of_bodies(robot: Robot) -> tuple[NDArray[np.int32], dict[tuple[str, str], list[int]]]:
    """Pairs (k, 2) of bodies on different links, and for each pair of links its rows."""
    by_link: dict[str, list[int]] = {}
    for k, body in enumerate(robot.bodies):
        by_link.setdefault(str(body.link), []).append(k)
    links = sorted(by_link, key=robot.link_index)
    pairs: list[tuple[int, int]] = []
    rows: dict[tuple[str, str], list[int]] = {}
    for a, b in itertools.combinations(links, 2):
        new = [(min(i, j), max(i, j)) for i in by_link[a] for j in by_link[b]]
        rows[a, b] = list(range(len(pairs), len(pairs) + len(new)))
        pairs += new
    return np.array(pairs, dtype=np.int32).reshape(-1, 2), rows


def _counted(
    robot: Robot, compiled: CompiledPairs, q: Floats, groups: Sequence[Sequence[int]]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """(groups,) in how many configurations (n, nq) each collides, and which is the first."""
    counts, first = np.zeros(len(groups), dtype=np.int64), np.zeros(len(groups), dtype=np.int64)
    for start in range(0, len(q), _BATCH):
        report(start, len(q), "configurations")
        collide = _collide(robot, compiled, q[start : start + _BATCH], groups)
        new = (counts == 0) & collide.any(axis=0)
        first[new] = start + collide[:, new].argmax(axis=0)
        counts += collide.sum(axis=0)
    report(len(q), len(q), "configurations")
    return counts, first


def _collide(robot: Robot, compiled: CompiledPairs, q: Floats, groups: Sequence[Sequence[int]]) -> Bools:
    """(n, groups) whether some pair of bodies of each group collides at configurations (n, nq)."""
    if not len(compiled.rows):
        return np.zeros((len(q), len(groups)), dtype=bool)
    bodies = compiled.colliding(robot.link_poses(q))
    return np.stack([bodies[:, list(group)].any(axis=1) for group in groups], axis=1)


def adjacent_links(tree: LinkTree, with_bodies: Iterable[str]) -> set[frozenset[str]]:
    """Pairs of links that a joint connects; a link without bodies connects all its neighbours, as in MoveIt."""
    neighbours: dict[str, set[str]] = {name: set() for name in tree.names}
    for child, parent in tree.parents.items():
        neighbours[child].add(parent)
        neighbours[parent].add(child)
    for empty in set(tree.names).difference(with_bodies):
        around = neighbours.pop(empty)
        for link in around:
            neighbours[link] = (neighbours[link] | around) - {link, empty}
    return {frozenset((a, b)) for a, others in neighbours.items() for b in others}


@dataclass(frozen=True)
class AuditedPair:
    """A pair that is disabled, or that deserves a look.

    Attributes:
        declared: The pair as the SRDF or YAML has it.
        found: What sampling found; None if one of the names is no link with collision bodies.
    """

    declared: DisabledPair
    found: LinkPair | None

    @property
    def is_suspect(self) -> bool:
        """Whether the links are not adjacent and collide in some configurations, yet not in (almost) all of them."""
        found = self.found
        return found is not None and found.reason != "adjacent" and 0 < found.share < ALWAYS


@dataclass(frozen=True)
class Audit:
    """A comparison of declared pairs with a matrix.

    Attributes:
        disabled: The declared pairs, each once.
        hopeless: Tested pairs that collide in every configuration, so that no configuration is valid.
        spared: Tested pairs that are proved never to meet.
    """

    disabled: tuple[AuditedPair, ...]
    hopeless: tuple[LinkPair, ...]
    spared: tuple[LinkPair, ...]

    @property
    def suspects(self) -> list[AuditedPair]:
        """Disabled pairs that collide in some configurations, the most frequent first."""
        chosen = [pair for pair in self.disabled if pair.is_suspect]
        return sorted(chosen, key=lambda pair: -(pair.found.collisions if pair.found else 0))


def audit(matrix: CollisionMatrix, declared: Iterable[DisabledPair]) -> Audit:
    """Compares pairs that a robot's SRDF or YAML disables with what its matrix of the tested pairs found."""
    found = {pair.links: pair for pair in matrix.pairs}
    unique = {frozenset((pair.link_a, pair.link_b)): pair for pair in reversed(list(declared))}
    disabled = tuple(AuditedPair(pair, found.get(links)) for links, pair in reversed(unique.items()))
    bodies, self_pairs = matrix.robot.bodies, matrix.robot.self_pairs.tolist()
    kept = {frozenset((bodies[a].link, bodies[b].link)) for a, b in self_pairs}
    tested = [pair for pair in matrix.pairs if pair.links in kept]
    hopeless = tuple(pair for pair in tested if pair.collisions == pair.states)
    return Audit(disabled, hopeless, tuple(pair for pair in tested if pair.reason == "proved never"))
