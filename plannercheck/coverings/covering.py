"""Coverings: spheres, capsules and boxes that stand for a robot's links.

In: a model's file and a robot, or a robot alone. Out: `Covering`, which is audited against the robot's links, grown
until it covers them, fitted to them, and saved.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from plannercheck.bodies.shapes import GeometryObject
from plannercheck.common.array_types import Floats
from plannercheck.common.atomic_files import write_atomically
from plannercheck.common.checked_yaml import error_context
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.progress import reported
from plannercheck.common.public_names import set_module
from plannercheck.common.real_numbers import check_length
from plannercheck.coverings import curobo_files, plain_files, urdf_files
from plannercheck.coverings.audits import Audit, audited
from plannercheck.coverings.curobo_files import SUFFIXES as CUROBO_SUFFIXES
from plannercheck.coverings.fitting import fitted
from plannercheck.coverings.neighbours import of_neighbours
from plannercheck.coverings.primitives import Primitives
from plannercheck.coverings.regions import regions_of
from plannercheck.coverings.search import TOLERANCE, outside
from plannercheck.robots.link_geometry import KINDS
from plannercheck.robots.robot import Robot
from plannercheck.robots.urdf_file import MJCF_ROOT, UrdfFile

# m: how far the growth of `inflated` may be above the least one.
_GROWTH_TOLERANCE = 1e-6

_FORMATS = (curobo_files, urdf_files, plain_files)
_WORDS = "cuRobo's .yml or .xrdf, a .urdf as foam and VAMP have it, or .json"


@set_module("plannercheck")
class Covering:
    """Spheres, capsules and boxes that stand for the links of a robot.

    Attributes:
        robot: The robot.
        links: By link, its primitives; links without any may be missing. Read-only.
        growth: m, what `inflated` has added to all radii; 0 otherwise.
    """

    def __init__(
        self, robot: Robot, links: Mapping[str, Primitives], growth: float = 0.0, source: Path | None = None
    ) -> None:
        for link, cover in links.items():
            if link not in robot.link_names:
                raise unknown_name("link", link, robot.link_names)
            _check(link, cover)
        self.robot, self.growth, self._source = robot, growth, source
        self.links: Mapping[str, Primitives] = MappingProxyType(dict(links))

    @classmethod
    def load(cls, path: str | Path, robot: Robot) -> Covering:
        """Loads a model.

        Args:
            path: A robot's configuration of cuRobo (.yml; also its .xrdf and robometrics' spheres), a URDF whose
                collision elements are spheres as foam writes and VAMP has it (.urdf), or .json, foam's as well.
            robot: The robot whose links it names.

        Returns:
            The covering. A warning counts spheres that cuRobo leaves out, since their radius is negative.

        Raises:
            PlannercheckError: If the file can't be read, has another format, unknown links or faulty numbers, or is
                empty.
        """
        path = Path(path)
        source = path if path.suffix in CUROBO_SUFFIXES and path.suffix != ".xrdf" else None
        return cls(robot, _read_model(path, robot.link_names), source=source)

    @classmethod
    def fit(
        cls, robot: Robot, spheres: int = 64, excess: float | None = None, geometry: str | None = "solid"
    ) -> Covering:
        """Fits spheres that cover all links, proved.

        Args:
            robot: The robot.
            spheres: How many at most; exactly so many if `excess` is not given.
            excess: m, how far spheres may stick out of their link; as few spheres as reach it are used.
            geometry: As for `audit`.

        Returns:
            The covering. Centres and radii are the same numbers in 32 bits.

        Raises:
            PlannercheckError: If there are fewer spheres than links with bodies, or too few to reach the excess.
        """
        bodies = _bodies_by_link(robot, geometry)
        with reported(f"fitting {spheres} spheres"):
            return cls(robot, fitted({link: each for link, each in bodies.items() if each}, spheres, excess))

    def __len__(self) -> int:
        return sum(map(len, self.links.values()))

    def __repr__(self) -> str:
        return f"Covering({self.robot.name!r}, {len(self)} primitives of {len(self.links)} links)"

    def spheres(self, link: str) -> Floats:
        """(n, 4) centres and radii, m, of a link's spheres in its frame."""
        if link not in self.robot.link_names:
            raise unknown_name("link", link, self.robot.link_names)
        cover = self.links.get(link, Primitives.of())
        own = (cover.ends[:, 0] == cover.ends[:, 1]).all(axis=1)
        return np.column_stack([cover.ends[own, 0], cover.radii[own]])

    def audit(
        self,
        robot: Robot | None = None,
        geometry: str | None = "solid",
        neighbours: bool = False,
        tolerance: float = TOLERANCE,
    ) -> Audit:
        """Proves for each link that it is covered, or finds the point that is furthest outside.

        Args:
            robot: A robot with the same links; None for the covering's own.
            geometry: What meshes of links are taken as: "solid", "hull", "pieces" or "triangles", as for `Robot.load`;
                None for the robot's own geometry. What it carries does not count.
            neighbours: Whether primitives of other links count as far as they hold their place at all values of the
                one joint between, within its limits.
            tolerance: m, by which both bounds of what is outside may differ.

        Returns:
            The findings, link by link.
        """
        check_length(tolerance, "tolerance")
        of = self._robot(robot)
        rows = []
        for link, bodies in _bodies_by_link(of, geometry).items():
            own = self.links.get(link, Primitives.of())
            if bodies or len(own):
                others = of_neighbours(of, self.links, link) if neighbours else Primitives.of()
                rows.append(audited(link, bodies, own, others, tolerance))
        return Audit(tuple(rows), geometry, neighbours)

    def inflated(
        self, robot: Robot | None = None, geometry: str | None = "solid", *, by_link: bool = False
    ) -> Covering:
        """All primitives grown by the least common length at which they are proved to cover all links, within 1e-6 m.

        Args:
            robot: As for `audit`.
            geometry: As for `audit`.
            by_link: Whether the primitives of each link grow by their own least length in place of the common one.

        Returns:
            The covering; its `growth` says the largest length. Its radii are rounded up to numbers of 32 bits.

        Raises:
            PlannercheckError: If a link with bodies has no primitives.
        """
        bodies = _bodies_by_link(self._robot(robot), geometry)
        bare = [link for link, each in bodies.items() if each and not len(self.links.get(link, Primitives.of()))]
        if bare:
            raise PlannercheckError(f"no growth covers links that have no primitives: {', '.join(bare)}")
        growths = {
            link: outside(regions_of(each), self.links[link], _GROWTH_TOLERANCE).upper
            for link, each in bodies.items()
            if each
        }
        most = max(growths.values(), default=0.0)
        grown = {link: cover.grown(growths.get(link, 0.0) if by_link else most) for link, cover in self.links.items()}
        return Covering(self.robot, grown, most, self._source)

    def verify(self, robot: Robot | None = None, geometry: str | None = "solid") -> bool:
        """Whether all links are proved to be covered; arguments as for `audit`."""
        return all(
            outside(regions_of(bodies), self.links.get(link, Primitives.of())).is_covered
            for link, bodies in _bodies_by_link(self._robot(robot), geometry).items()
        )

    def save(self, path: str | Path) -> None:
        """Writes the model.

        Args:
            path: .yml for cuRobo, with the other entries of the file that it was loaded from; .urdf for VAMP and foam,
                the robot's URDF with primitives as its collision elements; or .json.

        Raises:
            PlannercheckError: If the format lacks what the covering has, or the file can't be written.
        """
        description = self.robot.parts_of_files().description
        file = None if description is None or description.robots else description.file
        _write_model(Path(path), self.links, file, self._source)

    def _robot(self, robot: Robot | None) -> Robot:
        if robot is None:
            return self.robot
        for link in self.links:
            if link not in robot.link_names:
                raise unknown_name("link", link, robot.link_names)
        return robot


def _check(link: str, cover: Primitives) -> None:
    """Raises for numbers that are no sizes; those of files have been checked."""
    for what, sizes in (("radius", cover.radii), ("size", cover.halves.reshape(-1))):
        bad = sizes[~(np.isfinite(sizes) & (sizes >= 0))]
        if len(bad):
            raise PlannercheckError(f"link {link!r}: a {what} must be finite and not negative (m), not {bad[0]}")
    if not (np.isfinite(cover.ends).all() and np.isfinite(cover.frames).all()):
        raise PlannercheckError(f"link {link!r}: centres must be finite (m)")


def _bodies_by_link(robot: Robot, geometry: str | None) -> dict[str, list[GeometryObject]]:
    """The bodies of each link, in the order of links, without what is carried."""
    parts = robot.parts_of_files()
    bodies = parts.bodies
    if geometry is not None:
        if geometry not in KINDS:
            raise unknown_name("geometry", str(geometry), KINDS)
        if parts.description is None:
            raise PlannercheckError("a robot that was made in memory keeps its geometry: give geometry=None")
        description: Any = replace(parts.description, geometry=geometry, decomposition=None)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # of open meshes, and what loading the robot has said
            bodies = Robot.from_description(description).parts_of_files().bodies
    found: dict[str, list[GeometryObject]] = {link: [] for link in robot.link_names}
    for body in bodies:
        found[str(body.link)].append(body)
    return found


def _read_model(path: Path, link_names: Sequence[str]) -> dict[str, Primitives]:
    """The primitives of a model by link.

    Raises:
        PlannercheckError: If the file can't be read, has another format, unknown links or faulty numbers, or is empty.
    """
    with error_context(f"sphere model {path}"):
        reader = next((each for each in _FORMATS if path.suffix in each.SUFFIXES), None)
        if reader is None:
            raise PlannercheckError(f"suffix {path.suffix!r} is of no model: these are {_WORDS}")
        found: dict[str, Primitives] = reader.read(path, link_names)
        if not any(map(len, found.values())):
            raise PlannercheckError("it has no spheres, capsules or boxes that count for a link of the robot")
    return found


def _write_model(path: Path, covers: Mapping[str, Primitives], urdf: UrdfFile | None, source: Path | None) -> None:
    """Writes the primitives by link in the format of the path's suffix, for the robot's URDF, if it is made of one.

    The source is the file that the model was read from, if any.
    """
    if path.suffix in plain_files.SUFFIXES:
        content = plain_files.model_text(covers)
    elif path.suffix in (".yml", ".yaml"):
        content = curobo_files.model_text(covers, source)
    elif path.suffix in urdf_files.SUFFIXES:
        if urdf is None or urdf.kind == MJCF_ROOT:
            raise PlannercheckError(f"file {str(path)!r}: the robot has no URDF to put spheres into: save as .json")
        content = urdf_files.model_text(covers, urdf)
    else:
        raise PlannercheckError(f"file {str(path)!r}: a model is written as .yml, .urdf or .json")
    write_atomically(path, lambda aside: aside.write_text(content, encoding="utf-8"))
