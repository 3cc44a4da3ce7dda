"""The contents of a scene: obstacles by name, objects that links carry, and allowed collisions.

In: `add_...` calls of users and file readers. Out: `bodies`, each a shape posed in the world, `attached` objects, and
allowed collisions. Contents can be changed at any time, in place.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeVar, get_args

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.bodies.half_spaces import check_stands_still
from plannercheck.bodies.mesh_files import MeshUnits, checked_units
from plannercheck.bodies.moving import Moving, Placement
from plannercheck.bodies.objects import Part, Parts, SceneFrames, SceneObject, scene_object, unplaced
from plannercheck.bodies.part_sets import PartSet
from plannercheck.bodies.shapes import Box, Capsule, Cone, Cylinder, GeometryObject, Hull, Shape, Sphere
from plannercheck.bodies.solids import OPEN_MESHES, Solid, open_meshes
from plannercheck.common.array_types import Bools
from plannercheck.common.arrays import unmasked
from plannercheck.common.checked_yaml import error_context
from plannercheck.common.errors import PlannercheckError, unknown_name, with_article
from plannercheck.scenes.declared_states import DeclaredStates
from plannercheck.scenes.scene_meshes import mesh_parts
from plannercheck.scenes.scene_paths import MeshKind
from plannercheck.scenes.sensor_frames import next_frame

Contents = TypeVar("Contents", bound="SceneContents")


@dataclass
class AllowedCollisions:
    """Which links and objects may touch, as a MoveIt allowed collision matrix says it.

    Attributes:
        pairs: By pair of names, whether the two may touch.
        defaults: By name, whether it may touch any other name, where `pairs` has no entry.
        geometries: (link, geometry of it, object) that may touch, where a link has geometries that may not.
        asked: The pairs that a user named one by one. A whole matrix names whatever there was when it was recorded.
    """

    pairs: dict[frozenset[str], bool] = field(default_factory=dict)
    defaults: dict[str, bool] = field(default_factory=dict)
    geometries: set[tuple[str, str, str]] = field(default_factory=set)
    asked: set[frozenset[str]] = field(default_factory=set)

    def __call__(self, a: str, b: str) -> bool:
        """Whether two links or objects may touch: by their own entry, else by the stricter of their defaults."""
        said = self.pairs.get(frozenset((a, b)))
        if said is not None:
            return said
        defaults = [self.defaults[name] for name in (a, b) if name in self.defaults]
        return bool(defaults) and all(defaults)

    def with_defaults(self, allowed: Iterable[str]) -> AllowedCollisions:
        """The same, where further names may touch any other by default; its own defaults come first."""
        return replace(self, defaults={**dict.fromkeys(allowed, True), **self.defaults})

    def table(self, first: Sequence[str], second: Sequence[str]) -> Bools:
        """(n, m) the same for all pairs of n and m names at once."""
        said = [
            np.array([self.defaults.get(name, _UNSAID) for name in names], dtype=np.int8) for names in (first, second)
        ]
        mine, theirs = said[0][:, None], said[1][None]
        allowed = np.asarray((mine != 0) & (theirs != 0) & ((mine == 1) | (theirs == 1)))
        if self.pairs:
            rows, columns = _places(first), _places(second)
            for pair, verdict in self.pairs.items():
                if columns.keys().isdisjoint(pair):  # most are of two links
                    continue
                a, b = (*pair, *pair)[:2]
                for here, there in ((a, b), (b, a)):
                    if here in rows and there in columns:
                        allowed[np.ix_(rows[here], columns[there])] = verdict
        return allowed

    def geometry_table(self, bodies: Sequence[GeometryObject], objects: Sequence[str]) -> Bools:
        """(n, m) which of n bodies of a robot and m objects may touch by `geometries`."""
        allowed = np.zeros((len(bodies), len(objects)), dtype=np.bool_)
        if self.geometries:
            rows: dict[tuple[str | None, str], list[int]] = {}
            for row, body in enumerate(bodies):  # pieces are named "body/piece 0"
                rows.setdefault((body.link, body.name.partition("/piece ")[0]), []).append(row)
            columns = _places(objects)
            for link, geometry, name in self.geometries:
                allowed[np.ix_(rows.get((link, geometry), []), columns.get(name, []))] = True
        return allowed


# Stands for a name without a default, beside False and True.
_UNSAID = 2


def _places(names: Sequence[str]) -> dict[str, list[int]]:
    """By name, where it stands in a list."""
    found: dict[str, list[int]] = {}
    for place, name in enumerate(names):
        found.setdefault(name, []).append(place)
    return found


class SceneContents(DeclaredStates):
    """Named obstacles, posed in the world, and carried objects; `Scene` adds files, and documents the attributes."""

    def __init__(self, name: str = "") -> None:
        """Makes an empty scene."""
        super().__init__(name)
        self.allowed = AllowedCollisions()
        self.link_padding: dict[str, float] = {}
        self.frames = SceneFrames()
        self._objects: dict[str, SceneObject] = {}
        self._attached: dict[str, SceneObject] = {}
        self._body_names: set[str] = set()

    def __repr__(self) -> str:
        attached = f", {len(self._attached)} attached" if self._attached else ""
        return f"Scene({self.name!r}, {len(self._objects)} objects{attached}, {len(self.body_objects)} bodies)"

    def copy(self: Contents) -> Contents:
        """A copy that can be changed by itself; both share the objects' shapes and bodies prepared from them."""
        other = type(self)(self.name)
        own = self.allowed
        other.allowed = AllowedCollisions(dict(own.pairs), dict(own.defaults), set(own.geometries), set(own.asked))
        other.states, other.link_padding, other.frames = dict(self.states), dict(self.link_padding), self.frames
        other._objects, other._attached = dict(self._objects), dict(self._attached)
        other._body_names = set(self._body_names)
        return other

    def add(self, name: str, parts: Parts, pose: Placement = None) -> None:
        """Adds an object: one shape, or several posed ones; its bodies are "name", or "name/0", "name/1", ...

        Args:
            name: The object's name.
            parts: A shape, or parts posed in the object's frame. A shape may also be points (n, 3) in m, a
                trimesh.Trimesh, or a geometry of coal or python-fcl: of points and meshes, the hull is taken.
            pose: (4, 4) of the object's frame in the world, m; None is the identity. Or a `Moving`.
        """
        self.put(scene_object(name, parts, pose))

    def put(self, item: SceneObject) -> None:
        """Adds an obstacle or an attached object of a new name."""
        if item.name in self._objects or item.name in self._attached:
            raise PlannercheckError(f"object {item.name!r} exists already: remove it first, or choose another name")
        names = [body.name for body in item.bodies]
        taken = self._body_names.intersection(names)
        if taken:
            raise PlannercheckError(
                f"object {item.name!r}: another object is named {min(taken)!r}, as its part would be"
            )
        (self._objects if item.link is None else self._attached)[item.name] = item
        self._body_names.update(names)
        if item.link in self.link_padding:  # as in MoveIt, where a link's padding is also that of what it carries
            self.link_padding.setdefault(item.name, self.link_padding[item.link])

    def add_box(self, name: str, size: Sequence[float], pose: Placement = None) -> None:
        """Adds a box of full edge lengths `size` (3,) in m."""
        self.add(name, Box(size), pose)  # type: ignore[arg-type]  # Box checks it

    def add_sphere(self, name: str, radius: float, pose: Placement = None) -> None:
        """Adds a sphere of a radius in m."""
        self.add(name, Sphere(radius), pose)

    def add_cylinder(self, name: str, radius: float, length: float, pose: Placement = None) -> None:
        """Adds a cylinder along z about its centre, sizes in m."""
        self.add(name, Cylinder(radius, length), pose)

    def add_capsule(self, name: str, radius: float, length: float, pose: Placement = None) -> None:
        """Adds a capsule along z about its centre; the length is its segment's, in m."""
        self.add(name, Capsule(radius, length), pose)

    def add_cone(self, name: str, radius: float, length: float, pose: Placement = None) -> None:
        """Adds a cone along z, its apex at +length/2 and its base at -length/2, sizes in m."""
        self.add(name, Cone(radius, length), pose)

    def add_hull(self, name: str, vertices: ArrayLike, pose: Placement = None) -> None:
        """Adds the convex hull of points (n, 3) in m."""
        self.add(name, Hull(np.asarray(unmasked(vertices))), pose)

    def add_mesh(
        self,
        name: str,
        path: str | Path,
        pose: Placement = None,
        scale: float | Sequence[float] = 1.0,
        *,
        geometry: MeshKind = "hull",
        mesh_units: MeshUnits | None = None,
    ) -> None:
        """Adds the convex hull of a mesh file (stl, dae, obj, ply, glb, ...), or a `Solid`.

        A file of several objects becomes as many bodies, "name/object".

        Args:
            name: The object's name.
            path: The file.
            pose: (4, 4) of the object's frame in the world, m; None is the identity.
            scale: One factor, or one along each axis, from the file's unit to m.
            geometry: "hull"; "solid", whose open meshes are closed by caps; or "triangles", where open meshes are their
                triangles alone.
            mesh_units: As for `Scene.load`.
        """
        if geometry not in get_args(MeshKind):
            raise unknown_name("geometry", str(geometry), get_args(MeshKind))
        units = checked_units(mesh_units)
        keys = {"scale": scale} if units is None else {"scale": scale, "mesh_units": units}
        parts = mesh_parts(Path(path), keys, OPEN_MESHES.get(geometry))
        words = open_meshes({f"mesh file {str(path)!r}": each.shape for each in parts if isinstance(each.shape, Solid)})
        if words:
            warnings.warn(words, RuntimeWarning, stacklevel=2)
        self.add(name, parts, pose)

    def move(self, name: str, pose: ArrayLike | None) -> None:
        """Moves an object with all its parts, in place; checkers that were built before keep it where it was.

        Args:
            name: The object's name; an attached object moves on its link.
            pose: (4, 4) new pose of its frame in the world, or on its link, m. The frame of an object of one shape is
                that of the shape; of several shapes, it is the frame in which they were posed.
        """
        table = self._table_of(name)
        table[name] = table[name].moved(pose)

    def update(self, name: str, frame: ArrayLike | PartSet) -> None:
        """Replaces what a sensor has seen, in place, where the object stands; the cost is the frame's, not the scene's.

        Checkers that were built before, and copies of the scene, keep the frame before. `checker.with_scene(scene)`
        then prepares nothing but the new frame.

        Args:
            name: An object of one shape, which is a cloud, an octree, a voxel grid or a height field.
            frame: Points (n, 3) in the object's frame, m, of a cloud, whose radius they get; cells (i, j, k) of a voxel
                grid; heights (i, j), m, of a height field; or another shape of the same kind.
        """
        table = self._table_of(name)
        item = table[name]
        if len(item.parts) != 1:
            raise PlannercheckError(f"object {name!r} has {len(item.parts)} shapes: only objects of one are updated")
        with error_context(f"object {name!r}"):
            shape = next_frame(item.parts[0].shape, frame)
        table[name] = item.reshaped((Part(shape, item.parts[0].pose),))

    def remove(self, name: str) -> None:
        """Removes an object with all its parts, from the world or from its link."""
        self._taken(name)

    def _taken(self, name: str) -> SceneObject:
        item = self._table_of(name).pop(name)
        if item.link is not None:
            self.link_padding.pop(name, None)
        self._body_names.difference_update(body.name for body in item.bodies)
        return item

    def attach(
        self,
        name: str,
        link: str,
        pose: ArrayLike | None = None,
        touch_links: Iterable[str] = (),
        parts: Parts | None = None,
    ) -> None:
        """Attaches an object to a link: it moves with the link, as a part of the robot.

        It is tested against obstacles and against all links but its own and the touch links.

        Args:
            name: The name of an obstacle to take, or of a new object.
            link: The robot's link.
            pose: (4, 4) of the object's frame in the link's, m; None is the identity.
            touch_links: Links, or other attached objects, that it may touch.
            parts: For a new object, its shape or posed shapes, as for `add`.
        """
        if isinstance(pose, Shape):  # `add` takes them in this place
            check_stands_still(name, link, [pose])
            raise PlannercheckError(f"pose of {name!r} is {with_article(type(pose).__name__)}: give shapes by parts=")
        if isinstance(pose, Moving):
            raise PlannercheckError(f"object {name!r} on link {link!r} moves with the link: give its pose on the link")
        if parts is None and name not in self._objects:
            raise unknown_name("object to attach", name, self._objects)
        item = self._objects[name] if parts is None else scene_object(name, parts)
        item = item.attached(link, pose, touch_links)
        if parts is None:
            self._taken(name)
        self.put(item)

    def detach(self, name: str, pose: ArrayLike | None) -> None:
        """Puts an attached object back into the world, with its frame at a pose (4, 4), m."""
        if name not in self._attached:
            raise unknown_name("attached object", name, self._attached)
        item = self._attached[name].released(pose)
        self._taken(name)
        self.put(item)

    def _table_of(self, name: str) -> dict[str, SceneObject]:
        if not isinstance(name, str) or (name not in self._objects and name not in self._attached):
            raise unknown_name("object", name, (*self._objects, *self._attached))
        return self._objects if name in self._objects else self._attached

    @property
    def object_names(self) -> tuple[str, ...]:
        """Names of the obstacles, in the order in which they were added."""
        return tuple(self._objects)

    def object(self, name: str) -> SceneObject:
        """An obstacle or an attached object."""
        return self._table_of(name)[name]

    def placed(self, items: Iterable[SceneObject]) -> None:
        """Replaces objects by copies whose places in the world or on their links are now known."""
        for item in items:
            self._table_of(item.name)[item.name] = item

    @property
    def objects(self) -> tuple[SceneObject, ...]:
        """The obstacles."""
        return tuple(self._objects.values())

    @property
    def attached(self) -> tuple[SceneObject, ...]:
        """The objects that links carry."""
        return tuple(self._attached.values())

    @property
    def moving(self) -> tuple[SceneObject, ...]:
        """The obstacles that move."""
        return tuple(item for item in self._objects.values() if item.moving is not None)

    @property
    def bodies(self) -> tuple[GeometryObject, ...]:
        """All parts of all obstacles, in the world with `link` None, or if they move as in `SceneObject`.

        Raises:
            PlannercheckError: If an object is posed in a link's frame, which only a robot can place.
        """
        for item in self._objects.values():
            if item.pose_frame is not None:
                raise unplaced(item)
        return tuple(body for item in self._objects.values() for body in item.bodies)

    @property
    def body_objects(self) -> tuple[str, ...]:
        """For each of `bodies`, the name of its object."""
        return tuple(name for name, item in self._objects.items() for _ in item.bodies)

    @property
    def allowed_pairs(self) -> set[frozenset[str]]:
        """Pairs of names with an entry that allows them to touch; `is_allowed` also applies the defaults."""
        return {pair for pair, allowed in self.allowed.pairs.items() if allowed}

    def is_allowed(self, a: str, b: str) -> bool:
        """Whether two links or objects may touch, by their own entry or by default."""
        return self.allowed(a, b)

    def allow(self, a: str, b: str, allowed: bool = True) -> None:
        """Sets whether two links or objects may touch; a checker warns of names that neither it nor the scene has.

        Raises:
            PlannercheckError: If a name is no text, or `allowed` neither True nor False.
        """
        if not (isinstance(a, str) and isinstance(b, str) and isinstance(allowed, bool | np.bool_)):
            raise PlannercheckError(
                f"allow takes two names, and True or False, not {a!r:.80}, {b!r:.80} and {allowed!r:.80}"
            )
        self.allowed.pairs[frozenset((a, b))] = bool(allowed)
        self.allowed.asked.add(frozenset((a, b)))
