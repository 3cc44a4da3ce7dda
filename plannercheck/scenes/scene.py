"""Scenes: the obstacles around a robot, by name, and where planning starts and ends.

In: `add_...` calls, a scene file of our own format, or one of MoveIt's (see moveit_scene.py, moveit_text.py). Out:
`bodies`, each a shape posed in the world, `attached` objects, and allowed collisions. A scene can be changed at any
time, in place. A checker copies the scene when it is built; `checker.with_scene` makes one for the changed scene
without preparing anything again.

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
        mesh: {file: tap.stl, scale: 0.001}    # its convex hull; scale is optional, one factor or three; the
                                               # file may be package://NAME/..., as in a URDF; a file of several
                                               # objects is as many bodies, object: NAME takes one;
                                               # mesh_units: file or metre, see Scene.load
      - name: mug
        solid: {file: mug.stl, scale: 0.001}   # the mesh as it is, concave; or solid: mug.stl, or vertices and
                                               # triangles, three indices of vertices each; open: cap, triangles or
                                               # hull says what an open mesh is taken as; open: surface leaves the
                                               # inside of any mesh free
      - name: camera                           # what sensors see; these may be the name of a file alone, of which an
        cloud: {file: frame.ply, radius: 0.01} # npz may hold the other keys, too; ply, pcd, npy, npz, xyz, pts,
                                               # txt, csv; invalid: drop leaves points out that are NaN
      - name: map
        octree: {file: map.bt, unknown: free}  # or occupied; OctoMap's .bt or .ot; threshold: 0.5
      - name: grid
        voxels: {file: grid.npy, resolution: 0.05, origin: [0, 0, 0]}   # in an npz, the array is `occupied`
      - name: ground
        height_field: {file: heights.npy, resolution: 0.1, base: -1, origin: [0, 0]}   # in an npz, `heights`
      - name: egg
        ellipsoid: {radii: [0.03, 0.03, 0.04]} # along x, y, z; excess: 0.001 is how far its polytope sticks out
      - name: floor
        half_space: {normal: [0, 0, 1], offset: 0}   # all points with normal · x <= offset; no link can carry it
      - name: wedge
        hull: {vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]}   # or {file: wedge.npy}
        matrix: [[1, 0, 0, 0.2], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]   # instead of the above
      - name: pallet
        box: {size: [0.4, 0.3, 0.2]}
        moving:                                # in place of a pose, see `Moving`
          times: [0, 4]                        # s, growing
          poses: [{position: [0.5, -1, 0.1]}, {position: [0.5, 1, 0.1], rpy: [0, 0, 1.57]}]
          outside: stand                       # optional: refuse (default) or stand; also path: slerp or screw
    attached:                                  # optional: objects that links carry, posed on the link
      - name: mug
        link: panda_hand
        touch_links: [panda_leftfinger, panda_rightfinger]   # optional; the link itself may always be touched
        cylinder: {radius: 0.03, length: 0.1}  # or any other shape, or parts
        position: [0.0, 0.0, 0.1]
    allowed: [[panda_link0, worktop]]          # optional: pairs of links or objects that may touch
    allowed_geometries: [[hand, hand/geom0, worktop]]   # optional: a link, a geometry of it, and an object
    allowed_by_default: {floor: true}          # optional: what may touch everything, less the forbidden pairs
    forbidden: [[panda_hand, floor]]           # optional
    allowed_links: [[panda_link5, panda_hand]] # optional: two links, for acm="scene"; also forbidden_links
    states:                                    # optional, by robot
      panda:
        start: [0, -0.785, 0, -2.356, 0, 1.571, 0.785]   # in the order of the robot's group
        goal: [0.5, 0.3, 0, -2.0, 0, 2.3, 0.785]
        samples: kitchen_panda.npy             # a set of configurations (n, nq)
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import get_args

from plannercheck.bodies.mesh_files import MeshUnits, checked_units
from plannercheck.bodies.solids import Solid, open_meshes
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.package_data import is_file, is_folder, is_planar_file, shipped_folder, why_no_file
from plannercheck.common.public_names import set_module
from plannercheck.scenes.contents import SceneContents
from plannercheck.scenes.mjcf_scene import read_mjcf_scene
from plannercheck.scenes.scene_files import read_scene
from plannercheck.scenes.scene_hints import scale_hint
from plannercheck.scenes.scene_paths import MeshKind
from plannercheck.scenes.scene_table import scene_html
from plannercheck.scenes.written_scenes import write_scene


@set_module("plannercheck")
class Scene(SceneContents):
    """Named obstacles posed in the world, objects attached to links, and allowed collisions.

    Attributes:
        name: The name that reports use.
        allowed: Which links and objects may touch.
        states: Start, goal and samples by robot name.
        link_padding: A MoveIt scene's padding of links, and of what they carry, by name, m; a checker takes it as
            `padding=`.
        frames: A MoveIt scene's frames besides links and objects.
    """

    @staticmethod
    def load(
        path: str | Path,
        package_dirs: Sequence[str | Path] = (),
        *,
        meshes: MeshKind = "hull",
        mesh_units: MeshUnits | None = None,
    ) -> Scene:
        """Loads a scene file.

        Args:
            path: A file of our own format; an MJCF file, as for `from_mjcf`; a planning scene, a planning scene's world
                or a collision object of MoveIt in YAML (recognised by their keys); MoveIt's text format (`.scene`); or
                the bare name of a shipped scene, e.g. "bookshelf".
            package_dirs: Folders in which `package://` meshes are searched, before the folders above the file.
            meshes: What meshes are taken as: their hulls; "solid", whose open meshes are closed by caps; or
                "triangles", where open meshes are their triangles alone. A file's `solid:` is one anyway. One warning
                names the solids of open meshes.
            mesh_units: How mesh files are read that do not say so: "file" converts them to metres, z up, as their
                format says; "metre" takes their numbers as MoveIt's planning scene does. Default: "file" for our own
                format, with a warning where the two differ, "metre" for MoveIt's messages.

        Returns:
            The scene.
        """
        scene, file = Scene(), _found(path)
        if meshes not in get_args(MeshKind):
            raise unknown_name("kind of meshes", str(meshes), get_args(MeshKind))
        read_scene(scene, file, [Path(p) for p in package_dirs], meshes, checked_units(mesh_units))
        hint = scale_hint(scene)
        if hint:
            warnings.warn(f"scene file {str(file)!r}: {hint}", RuntimeWarning, stacklevel=2)
        bodies = (body for item in (*scene.objects, *scene.attached) for body in item.bodies)
        words = open_meshes({body.name: body.shape for body in bodies if isinstance(body.shape, Solid)})
        if words:
            warnings.warn(f"scene file {str(file)!r}: {words}. {_OPEN_HINT}", RuntimeWarning, stacklevel=2)
        return scene

    @staticmethod
    def from_mjcf(path: str | Path, *, meshes: MeshKind = "hull") -> Scene:
        """The obstacles of an MJCF file: geoms of its world and of bodies that no joint moves, by the geoms' names.

        Where the file holds a robot as well, its geoms are tested against the obstacles by MuJoCo's rules.

        Args:
            path: The file, which MuJoCo compiles (`pip install 'plannercheck[mjcf]'`).
            meshes: What meshes are taken as: their hulls, as MuJoCo has them, or "solid".

        Returns:
            The scene.
        """
        if meshes not in get_args(MeshKind):
            raise unknown_name("kind of meshes", str(meshes), get_args(MeshKind))
        scene, file = Scene(), Path(path)
        if not is_file(file):
            raise PlannercheckError(f"MJCF {file} {why_no_file(file)}")
        read_mjcf_scene(scene, file, meshes)
        return scene

    def save(self, path: str | Path) -> None:
        """Writes the scene in our own format; reading it gives the same doubles.

        Clouds, octrees, voxel grids and height fields that are of no file are written beside it, each to a file of its
        own that no earlier scene names; then the scene. If anything fails, what was there stays.

        A path that ends in `.scene` gets MoveIt's text format, which holds obstacles only, with rotations as
        quaternions, and no capsules.
        """
        write_scene(self, Path(path))

    def _repr_html_(self) -> str:
        return scene_html(self)


_OPEN_HINT = "meshes='triangles', or open: triangles or hull of a file's solid, takes open meshes otherwise"


def shipped_scenes() -> list[str]:
    """Names of the scenes in space that come with plannercheck; those in the plane have functions of their own."""
    return sorted(path.stem for path in shipped_folder("configs").glob("*.yaml") if not is_planar_file(path))


def _found(path: str | Path) -> Path:
    """The path itself, or for a bare name the path of a shipped scene."""
    if not isinstance(path, str | PathLike):
        raise PlannercheckError(f"a scene is loaded by its name or from a file, not {path!r:.80}")
    given = Path(path)
    if (is_file(given) or is_folder(given)) or given.suffix or len(given.parts) != 1:
        return given
    shipped = shipped_folder("configs") / f"{path}.yaml"
    if not is_file(shipped) or is_planar_file(shipped):
        raise unknown_name("scene", str(path), [*shipped_scenes(), "or the path of a YAML file"])
    return shipped
