"""Scenes: the obstacles around a robot, by name, and where planning starts and ends.

In: `add_...` calls, a scene file of our own format, or a MoveIt planning scene (see moveit.py). Out:
`bodies`, each a shape posed in the world, and what may touch. A scene can be changed at any time; a checker
takes what is there when it is built.

A scene file is YAML; lengths are in m, angles in rad, paths relative to the file:

    name: kitchen                              # optional, else the file's name
    objects:
      - name: worktop                          # unique
        box: {size: [1.2, 0.6, 0.04]}          # full edge lengths
        position: [0.6, 0.0, 0.8]              # optional, as is the rotation
        rpy: [0.0, 0.0, 1.57]                  # roll, pitch, yaw about fixed axes, as in URDF
      - name: can
        cylinder: {radius: 0.03, length: 0.14} # along z, about its centre
        position: [0.5, 0.1, 0.89]
        quaternion: [0, 0, 0.707, 0.707]       # x, y, z, w; normalised when read
      - name: cup                              # several parts, posed on the object
        position: [0.5, -0.2, 0.9]
        parts:
          - sphere: {radius: 0.04}
          - capsule: {radius: 0.01, length: 0.05}   # length of the segment, without the caps
            position: [0.05, 0.0, 0.0]
          - cone: {radius: 0.03, length: 0.1}       # apex at z = +length / 2
      - name: tap
        mesh: {file: tap.stl, scale: 0.001}    # its convex hull; scale is optional, one factor or three
      - name: wedge
        hull: {vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]}   # or {file: wedge.npy}
        matrix: [[1, 0, 0, 0.2], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]   # instead of the above
    allowed: [[panda_link0, worktop]]          # optional: pairs of links or objects that may touch
    allowed_by_default: {floor: true}          # optional: what may touch everything, less the forbidden pairs
    forbidden: [[panda_hand, floor]]           # optional
    states:                                    # optional, by robot
      panda:
        start: [0, -0.785, 0, -2.356, 0, 1.571, 0.785]   # in the order of the robot's group
        goal: [0.5, 0.3, 0, -2.0, 0, 2.3, 0.785]
        samples: kitchen_panda.npy             # a set of configurations (n, nq)
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plannercheck.declared_states import DeclaredStates
from plannercheck.errors import PlannercheckError, unknown_name
from plannercheck.meshes import load_mesh
from plannercheck.paths import is_planar_file, shipped_folder
from plannercheck.shapes import Body, Box, Capsule, Cone, Cylinder, Hull, Shape, Sphere, checked_pose

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Part:
    """One shape of an object.

    Attributes:
        shape: What it is.
        pose: (4, 4) in the world, m; None is the identity.
        source: The file and scale of a mesh, so that a saved scene can name it.
    """

    shape: Shape
    pose: ArrayLike | None = None
    source: tuple[Path, float | Sequence[float]] | None = None


@dataclass
class AllowedCollisions:
    """Which links and objects may touch, as a MoveIt allowed collision matrix says it.

    Attributes:
        pairs: What is said of a pair of names: True if it may touch.
        defaults: What is said of a name with any other, where `pairs` says nothing.
    """

    pairs: dict[frozenset[str], bool] = field(default_factory=dict)
    defaults: dict[str, bool] = field(default_factory=dict)

    def __call__(self, a: str, b: str) -> bool:
        """Whether two links or objects may touch: their own entry, else the stricter of their defaults."""
        said = self.pairs.get(frozenset((a, b)))
        if said is not None:
            return said
        defaults = [self.defaults[name] for name in (a, b) if name in self.defaults]
        return bool(defaults) and all(defaults)


class Scene(DeclaredStates):
    """Named obstacles, posed in the world.

    Attributes:
        name: For reports.
        allowed: Which links and objects may touch.
        states: Start, goal and samples by robot name.
        link_padding: What a MoveIt scene asks to be kept from links, by name, m; a checker takes it as `padding=`.
    """

    def __init__(self, name: str = "") -> None:
        """Makes an empty scene."""
        super().__init__(name)
        self.allowed = AllowedCollisions()
        self.link_padding: dict[str, float] = {}
        self._bodies: dict[str, tuple[Body, ...]] = {}
        self._parts: dict[str, tuple[Part, ...]] = {}
        self._body_names: set[str] = set()

    def __repr__(self) -> str:
        return f"Scene({self.name!r}, {len(self._bodies)} objects, {len(self.bodies)} bodies)"

    @staticmethod
    def load(path: str | Path, package_dirs: Sequence[str | Path] = ()) -> Scene:
        """Loads a scene file.

        Args:
            path: A file of our own format, a MoveIt planning scene in YAML (told by its keys), or the bare
                name of a shipped scene, e.g. "bookshelf".
            package_dirs: Folders in which `package://` meshes of MoveIt scenes are looked for.

        Returns:
            The scene.
        """
        from plannercheck.scene_files import read_scene  # it builds scenes, so it imports this module

        return read_scene(_found(path), [Path(p) for p in package_dirs])

    def save(self, path: str | Path) -> None:
        """Writes the scene in our own format; poses and sizes are read back as the same doubles."""
        from plannercheck.scene_files import write_scene  # it reads scenes, so it imports this module

        write_scene(self, Path(path))

    def add(self, name: str, parts: Iterable[Part]) -> None:
        """Adds an object of one or several posed shapes; its bodies are "name", or "name/0", "name/1", ..."""
        if name in self._bodies:
            raise PlannercheckError(f"object {name!r} exists already: remove it first, or choose another name")
        parts = tuple(parts)
        if not name or not parts:
            raise PlannercheckError(f"object {name!r} needs a name and at least one shape")
        names = [name] if len(parts) == 1 else [f"{name}/{k}" for k in range(len(parts))]
        taken = self._body_names.intersection(names)
        if taken:
            raise PlannercheckError(f"object {name!r}: another object is named {min(taken)!r}, as its part would be")
        posed = (checked_pose(part.pose, f"object {n!r}") for n, part in zip(names, parts, strict=True))
        bodies = tuple(Body(n, None, pose, p.shape) for n, pose, p in zip(names, posed, parts, strict=True))
        self._bodies[name], self._parts[name] = bodies, parts
        self._body_names.update(names)

    def add_box(self, name: str, size: Sequence[float], pose: ArrayLike | None = None) -> None:
        """Adds a box of full edge lengths `size` (3,) in m."""
        self.add(name, [Part(Box(size), pose)])  # type: ignore[arg-type]  # Box checks it

    def add_sphere(self, name: str, radius: float, pose: ArrayLike | None = None) -> None:
        """Adds a sphere of a radius in m."""
        self.add(name, [Part(Sphere(radius), pose)])

    def add_cylinder(self, name: str, radius: float, length: float, pose: ArrayLike | None = None) -> None:
        """Adds a cylinder along z about its centre, sizes in m."""
        self.add(name, [Part(Cylinder(radius, length), pose)])

    def add_capsule(self, name: str, radius: float, length: float, pose: ArrayLike | None = None) -> None:
        """Adds a capsule along z about its centre; the length is its segment's, in m."""
        self.add(name, [Part(Capsule(radius, length), pose)])

    def add_cone(self, name: str, radius: float, length: float, pose: ArrayLike | None = None) -> None:
        """Adds a cone along z, its apex at +length/2 and its base at -length/2, sizes in m."""
        self.add(name, [Part(Cone(radius, length), pose)])

    def add_hull(self, name: str, vertices: ArrayLike, pose: ArrayLike | None = None) -> None:
        """Adds the convex hull of points (n, 3) in m."""
        self.add(name, [Part(Hull(np.asarray(vertices)), pose)])

    def add_mesh(
        self,
        name: str,
        path: str | Path,
        pose: ArrayLike | None = None,
        scale: float | Sequence[float] = 1.0,
    ) -> None:
        """Adds the convex hull of a mesh file (stl, dae, obj, ply, ...); `scale` takes its unit to m."""
        self.add(name, [Part(load_mesh(path, scale), pose, (Path(path), scale))])

    def remove(self, name: str) -> None:
        """Removes an object with all its parts."""
        if name not in self._bodies:
            raise unknown_name("object", name, self._bodies)
        self._body_names.difference_update(body.name for body in self._bodies[name])
        del self._bodies[name], self._parts[name]

    @property
    def object_names(self) -> tuple[str, ...]:
        """Names of the objects, in the order in which they were added."""
        return tuple(self._bodies)

    @property
    def bodies(self) -> tuple[Body, ...]:
        """All parts of all objects, with `link` None and their pose in the world."""
        return tuple(body for bodies in self._bodies.values() for body in bodies)

    @property
    def body_objects(self) -> tuple[str, ...]:
        """For each of `bodies`, the name of its object."""
        return tuple(name for name, bodies in self._bodies.items() for _ in bodies)

    @property
    def parts(self) -> dict[str, tuple[Part, ...]]:
        """The parts of each object, as they were added."""
        return dict(self._parts)

    @property
    def allowed_pairs(self) -> set[frozenset[str]]:
        """Pairs of names that are said to be allowed to touch; `is_allowed` knows the defaults, too."""
        return {pair for pair, allowed in self.allowed.pairs.items() if allowed}

    def is_allowed(self, a: str, b: str) -> bool:
        """Whether two links or objects may touch, by their own entry or by default."""
        return self.allowed(a, b)

    def allow(self, a: str, b: str, allowed: bool = True) -> None:
        """Says whether two links or objects may touch."""
        self.allowed.pairs[frozenset((a, b))] = allowed


def shipped_scenes() -> list[str]:
    """Names of the scenes in space that come with plannercheck; those in the plane have functions of their own."""
    return sorted(path.stem for path in shipped_folder("configs").glob("*.yaml") if not is_planar_file(path))


def _found(path: str | Path) -> Path:
    """The path itself, or that of a shipped scene for a bare name."""
    given = Path(path)
    if given.exists() or given.suffix or len(given.parts) != 1:
        return given
    if str(path) not in shipped_scenes():
        raise unknown_name("scene", str(path), [*shipped_scenes(), "or the path of a YAML file"])
    return shipped_folder("configs") / f"{path}.yaml"
