"""Planar robots: links of convex polygons that move in the plane.

In: footprints, and for a chain (a tractor with trailers, an arm on a floor) the parent of each link. Out: `Robot`,
immutable, which has joints and limits and poses its links.

A link's frame is at its anchor on its parent, turned by the anchor's angle and by its joint. The root is free (x, y,
theta) or fixed to the world. Angles are added along the chain before sine and cosine are computed, so every pose is as
exact a rotation as doubles allow.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plannercheck.common.array_types import Floats, Ints
from plannercheck.common.arrays import Configuration, axes, configuration_rows, named_numbers, read_only
from plannercheck.common.checked_yaml import error_context
from plannercheck.common.core import core
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.public_names import set_module
from plannercheck.common.whole_numbers import whole_number
from plannercheck.planar.links import GeometryObject, Link
from plannercheck.planar.pieces import convex_pieces
from plannercheck.planar.robot_files import planar_file, read_robot
from plannercheck.robots.joint_values import row_of_named
from plannercheck.robots.robot_table import robot_html

# How many numbers each kind of joint takes, and the core's code for it.
_WIDTHS: dict[str, int] = {"fixed": 0, "revolute": 1, "free": 3}
_CODES: dict[str, int] = {"fixed": 0, "revolute": 1, "free": 2}

# Without bounds, positions are sampled within 1 m of zero, as in space.
_UNLIMITED_RANGE = 1.0

# Beyond this, sums of lengths could overflow; no robot gets there.
_LARGEST_VALUE = 1e15


@set_module("plannercheck.planar")
class Robot:
    """A planar robot, posed by configurations: x, y, theta of a free root, then the angles of the revolute joints.

    Attributes:
        name: The robot's name.
        links: Its links, parents first.
        bodies: The links' convex pieces.
        joint_names: A name for each number of a configuration.
        lower: (nq,) lower limits in m and rad, -inf where there is none.
        upper: (nq,) upper limits.
        disabled_pairs: Pairs of links that are not tested against each other, besides neighbours.
    """

    def __init__(
        self,
        footprint: ArrayLike | Sequence[ArrayLike] | Sequence[Link],
        *,
        name: str = "robot",
        disabled_pairs: Iterable[tuple[str, str]] = (),
        _bounds: tuple[ArrayLike, ArrayLike] = ((-math.inf, -math.inf), (math.inf, math.inf)),
    ) -> None:
        """Builds a robot.

        Args:
            footprint: The outline (n, 2) of a robot that moves freely, m, or several outlines; or its links.
            name: The robot's name.
            disabled_pairs: Names of links that are not tested against each other.
        """
        self.name = name
        self.links = _checked_links(footprint)
        self.disabled_pairs = tuple(map(_pair, disabled_pairs))
        self._indices = {link.name: k for k, link in enumerate(self.links)}
        for pair in self.disabled_pairs:
            for link in pair:
                self.link_index(link)
        self._parents = [-1 if link.parent is None else self._indices[link.parent] for link in self.links]
        self._columns = np.cumsum([0, *(_WIDTHS[link.joint] for link in self.links)])
        self.joint_names = tuple(name for link in self.links for name in _column_names(link))
        self.bodies = tuple(body for k, link in enumerate(self.links) for body in _bodies(link, k))
        self.lower, self.upper = (read_only(np.array(side)) for side in self._limits(_bounds))
        self._kinematics = core.PlanarChecker(
            core.PlanarModel(*(*self.core_links(), *_no_bodies())), True, core.Precision.filtered
        )

    @classmethod
    def load(cls, name_or_path: str | Path) -> Robot:
        """Loads a planar robot: a name from robots/ such as "forklift", or a YAML file."""
        path = planar_file(name_or_path, "robots")
        with error_context(f"robot file {str(path)!r}"):
            links, name, disabled_pairs = read_robot(path)
            return cls(links, name=name, disabled_pairs=disabled_pairs)

    @property
    def nq(self) -> int:
        """Numbers in a configuration."""
        return int(self._columns[-1])

    @property
    def link_names(self) -> tuple[str, ...]:
        """Names of the links."""
        return tuple(link.name for link in self.links)

    @property
    def is_free(self) -> bool:
        """Whether the root moves: the first three numbers are x, y and theta."""
        return self.links[0].joint == "free"

    @property
    def angles(self) -> NDArray[np.bool_]:
        """(nq,) which numbers are angles without limits."""
        lengths = np.zeros(self.nq, dtype=bool)
        lengths[: 2 if self.is_free else 0] = True
        return np.asarray(~lengths & np.isinf(self.lower) & np.isinf(self.upper))

    def link_index(self, name: str) -> int:
        """The index of a link."""
        if name not in self._indices:
            raise unknown_name("link", name, self._indices)
        return self._indices[name]

    def parent_index(self, link: int) -> int:
        """The index of a link's parent; -1 for the root."""
        return self._parents[link]

    def column(self, link: int) -> int:
        """The column of the first number of a configuration that moves a link."""
        return int(self._columns[link])

    def with_bounds(self, lower: ArrayLike, upper: ArrayLike) -> Robot:
        """The same robot with limits of x and y, m; a fixed root stays as it is."""
        low, high = named_numbers(lower, "bounds"), named_numbers(upper, "bounds")
        if low.shape != (2,) or high.shape != (2,) or not (low < high).all():
            raise PlannercheckError(f"bounds must be the least and the largest x and y, not {lower!r} and {upper!r}")
        if not self.is_free:
            return self
        return Robot(self.links, name=self.name, disabled_pairs=self.disabled_pairs, _bounds=(lower, upper))

    def random_configurations(self, n: int, seed: int | np.random.Generator | None = None) -> Floats:
        """Uniform configurations (n, nq) within the limits; free angles in [-pi, pi), other free numbers within 1 m."""
        n = whole_number(n, "n must be a number of configurations, 0 or more", 0)
        unlimited = np.where(self.angles, math.pi, _UNLIMITED_RANGE)
        low = np.where(np.isinf(self.lower), np.minimum(-unlimited, self.upper - unlimited), self.lower)
        high = np.where(np.isinf(self.upper), np.maximum(unlimited, self.lower + unlimited), self.upper)
        return np.random.default_rng(seed).uniform(low, high, size=(n, self.nq))

    def check_configurations(self, q: ArrayLike) -> Floats:
        """Configurations (n, nq) or (nq,) as (n, nq) float64 in C order, or an error that says what is wrong."""
        rows = configuration_rows(q, self.nq, lambda: f"the numbers are {', '.join(self.joint_names)}")
        usable = np.abs(rows) <= _LARGEST_VALUE  # false for NaN
        if not usable.all():
            row = int(np.flatnonzero(~usable.all(axis=1))[0])
            raise PlannercheckError(f"configurations must be finite; row {row} is {rows[row].tolist()}")
        return rows

    def link_poses(self, q: Configuration) -> Floats:
        """World poses of all links: the very doubles that verdicts use.

        Args:
            q: (nq,) or (n, nq), m and rad, or the values of one by names of joints.

        Returns:
            (links, 3, 3) or (n, links, 3, 3), m.
        """
        if isinstance(q, Mapping):
            return self.link_poses(row_of_named(q, self.joint_names, [1] * self.nq))
        poses = np.asarray(self._kinematics.link_poses(self.check_configurations(q)))
        return poses[0] if np.ndim(q) == 1 else poses

    def core_links(self) -> tuple[NDArray[np.int32], Floats, int]:
        """The chain as the core takes it: parent, joint and column; anchors; numbers in a configuration."""
        rows = [
            (parent, _CODES[link.joint], column)
            for link, parent, column in zip(self.links, self._parents, self._columns.tolist(), strict=False)
        ]
        anchors = np.array([link.anchor for link in self.links], dtype=np.float64)
        return np.array(rows, dtype=np.int32), anchors, self.nq

    def self_pairs(self) -> list[tuple[int, int]]:
        """Pairs of bodies on links that move relative to each other and are not neighbours."""
        disabled = {frozenset(self.link_index(name) for name in pair) for pair in self.disabled_pairs}
        group = self._rigid_groups()
        near = {frozenset((group[k], group[parent])) for k, parent in enumerate(self._parents) if parent >= 0}
        return [
            (a, b)
            for b, second in enumerate(self.bodies)
            for a, first in enumerate(self.bodies[:b])
            if frozenset((first.link, second.link)) not in disabled
            and group[first.link] != group[second.link]
            and frozenset((group[first.link], group[second.link])) not in near
        ]

    def _rigid_groups(self) -> list[int]:
        """For each link the first one that it is fixed to."""
        groups: list[int] = []
        for k, (link, parent) in enumerate(zip(self.links, self._parents, strict=True)):
            groups.append(groups[parent] if link.joint == "fixed" and parent >= 0 else k)
        return groups

    def _limits(self, bounds: tuple[ArrayLike, ArrayLike]) -> tuple[list[float], list[float]]:
        sides = []
        for side, infinity in ((0, -math.inf), (1, math.inf)):
            values: list[float] = []
            for link in self.links:
                if link.joint == "free":
                    values += [*np.asarray(bounds[side], dtype=np.float64).tolist(), infinity]
                elif link.joint == "revolute":
                    values.append(link.limits[side])
            sides.append(values)
        return sides[0], sides[1]

    def __reduce__(self) -> tuple[Any, ...]:
        bounds = (self.lower[:2], self.upper[:2]) if self.is_free else None
        return _rebuilt, (self.links, self.name, self.disabled_pairs, bounds)

    def __repr__(self) -> str:
        return f"Robot({self.name!r}, {len(self.links)} links, {len(self.bodies)} bodies, nq={self.nq})"

    def _repr_html_(self) -> str:
        return robot_html(repr(self), self.joint_names, range(self.nq), self.lower, self.upper)


def _rebuilt(
    links: tuple[Link, ...],
    name: str,
    disabled_pairs: tuple[tuple[str, str], ...],
    bounds: tuple[Floats, Floats] | None,
) -> Robot:
    """A robot from a pickle."""
    robot = Robot(links, name=name, disabled_pairs=disabled_pairs)
    return robot if bounds is None else robot.with_bounds(*bounds)


def _checked_links(given: ArrayLike | Sequence[ArrayLike] | Sequence[Link]) -> tuple[Link, ...]:
    if isinstance(given, Sequence) and given and all(isinstance(link, Link) for link in given):
        links = tuple(link for link in given if isinstance(link, Link))
    else:
        links = (Link("base", given, joint="free"),)  # type: ignore[arg-type]  # no links: a footprint
    known: set[str] = set()
    for k, link in enumerate(links):
        _check_link(link, k, known)
        known.add(link.name)
    return tuple(_own(link) for link in links)


def _pair(names: tuple[str, str]) -> tuple[str, str]:
    if isinstance(names, str) or np.shape(names) != (2,):
        raise PlannercheckError(f"a disabled pair must be two links, not {names!r:.80}")
    return names[0], names[1]


def _own(link: Link) -> Link:
    """A copy of the link that the caller can't change."""
    x, y, angle = (float(value) for value in link.anchor)
    limits = float(link.limits[0]), float(link.limits[1])
    return replace(link, footprint=_outlines(link), anchor=(x, y, angle), limits=limits)


def _check_link(link: Link, index: int, known: set[str]) -> None:
    if not (isinstance(link.name, str) and isinstance(link.joint, str) and isinstance(link.parent, str | None)):
        raise PlannercheckError(
            f"link {link.name!r}: name, joint and parent must be texts, not {link.joint!r} and {link.parent!r}"
        )
    if not link.name or link.name in known:
        raise PlannercheckError(f"link {link.name!r} needs a name of its own")
    if link.joint not in _WIDTHS:
        raise unknown_name(f"joint of link {link.name!r}", link.joint, _WIDTHS)
    if (link.parent is None) != (index == 0) or (link.parent is not None and link.parent not in known):
        raise PlannercheckError(
            f"link {link.name!r}: the first link has no parent, every other one hangs on one before it; "
            f"parent is {link.parent!r}, before it are {', '.join(sorted(known)) or 'none'}"
        )
    if link.joint == "free" and index > 0:
        raise PlannercheckError(f"link {link.name!r}: only the first link can be free")
    anchor = named_numbers(link.anchor, f"link {link.name!r}: anchor")
    limits = named_numbers(link.limits, f"link {link.name!r}: limits")
    if anchor.shape != (3,) or not np.isfinite(anchor).all():
        raise PlannercheckError(f"link {link.name!r}: anchor must be x, y and angle, not {link.anchor}")
    if link.joint != "revolute" and np.isfinite(limits).any():
        raise PlannercheckError(f"link {link.name!r}: limits go with a revolute joint, not with a {link.joint} one")
    if limits.shape != (2,) or not limits[0] < limits[1]:
        raise PlannercheckError(f"link {link.name!r}: limits must be least and largest angle, not {link.limits}")


def _outlines(link: Link) -> tuple[Floats, ...]:
    """The link's outlines, split into convex pieces."""
    given = link.footprint
    several = isinstance(given, list | tuple) and len(given) > 0 and axes(given[0]) not in (0, 1)
    outlines: Sequence[ArrayLike] = given if several else [given]  # type: ignore[assignment,list-item]
    return tuple(
        piece
        for k, outline in enumerate(outlines)
        for piece in convex_pieces(outline, f"footprint {k} of {link.name!r}")
    )


def _bodies(link: Link, index: int) -> list[GeometryObject]:
    pieces: Sequence[Floats] = link.footprint  # type: ignore[assignment]  # split by now
    names = [link.name] if len(pieces) == 1 else [f"{link.name}/{k}" for k in range(len(pieces))]
    return [GeometryObject(name, index, piece, read_only(np.eye(3))) for name, piece in zip(names, pieces, strict=True)]


def _column_names(link: Link) -> tuple[str, ...]:
    return {"free": ("x", "y", "theta"), "revolute": (f"{link.name}_joint",), "fixed": ()}[link.joint]


def _no_bodies() -> tuple[list[Any], Ints, Floats, Floats, Floats, Ints]:
    """The arguments of a core checker without bodies, which only poses links."""
    return (
        [],
        np.zeros(0, dtype=np.int32),
        np.zeros((0, 3, 3)),
        np.zeros((0, 3)),
        np.zeros((0, 4)),
        np.zeros((0, 2), dtype=np.int32),
    )
