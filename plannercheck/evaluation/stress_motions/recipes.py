"""Robots and scenes of the motion stress as plain data, which can be kept as JSON, and how to build them.

In: a recipe, nested lists and numbers. Out: a checker, in space or in the plane. Python writes and reads doubles
without loss.

Trees are built in code, not from a URDF. So they need no files, may have what no URDF can describe (ball joints,
screws, any axis), and list the tested pairs.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal, TypeAlias, TypedDict

import numpy as np
import pinocchio as pin

from plannercheck import planar
from plannercheck.bodies.moving import Moving
from plannercheck.bodies.point_clouds import PointCloud
from plannercheck.bodies.shapes import Box, Capsule, Cylinder, GeometryObject, Hull, Shape, Sphere, inflated_hull
from plannercheck.bodies.tuning import DEFAULT_TUNING, Tuning
from plannercheck.common.array_types import Floats
from plannercheck.common.motion_paths import MotionPath
from plannercheck.common.package_data import shipped_folder
from plannercheck.motions.checker import Checker
from plannercheck.robots.description import find_description, read_description
from plannercheck.robots.link_geometry import GeometryKind
from plannercheck.robots.loading import RobotParts
from plannercheck.robots.robot import Robot
from plannercheck.robots.urdf import Mimic, link_tree
from plannercheck.scenes.scene import Scene

Matrix: TypeAlias = list[list[float]]

# Pinocchio's bindings make continuous joints of any axis from a URDF alone.
_UNBOUNDED = """<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="continuous"><parent link="a"/>
<child link="b"/><axis xyz="{} {} {}"/></joint></robot>"""

# Radius of the points of a cloud of corners, m.
_CORNER = 1e-7

# Joints by kind: made of an axis and, for screws, a pitch in m/rad.
JOINTS: dict[str, Any] = {
    "revolute x": lambda axis, pitch: pin.JointModelRX(),
    "revolute y": lambda axis, pitch: pin.JointModelRY(),
    "revolute z": lambda axis, pitch: pin.JointModelRZ(),
    "revolute": lambda axis, pitch: pin.JointModelRevoluteUnaligned(axis),
    "continuous x": lambda axis, pitch: pin.JointModelRUBX(),
    "continuous y": lambda axis, pitch: pin.JointModelRUBY(),
    "continuous z": lambda axis, pitch: pin.JointModelRUBZ(),
    "continuous": lambda axis, pitch: _unbounded(axis),
    "prismatic x": lambda axis, pitch: pin.JointModelPX(),
    "prismatic z": lambda axis, pitch: pin.JointModelPZ(),
    "prismatic": lambda axis, pitch: pin.JointModelPrismaticUnaligned(axis),
    "planar": lambda axis, pitch: pin.JointModelPlanar(),
    "ball": lambda axis, pitch: pin.JointModelSpherical(),
    "floating": lambda axis, pitch: pin.JointModelFreeFlyer(),
    "helical": lambda axis, pitch: pin.JointModelHelicalUnaligned(axis, pitch),
}


def _unbounded(axis: Floats) -> Any:
    return pin.buildModelFromXML(_UNBOUNDED.format(*(repr(float(x)) for x in axis))).joints[1]


class JointRecipe(TypedDict):
    """A joint and the link on it, which has the joint's name; parent: an earlier joint, -1 for the base."""

    name: str
    kind: str
    parent: int
    placement: Matrix  # (4, 4) on the parent's frame, m
    axis: list[float]
    pitch: float  # m/rad
    limits: list[float]  # least and largest of each number, rad or m
    link: Matrix  # (4, 4) of the link on the joint, m
    mimic: list[Any] | None  # the leader's name, multiplier, offset


class BodyRecipe(TypedDict):
    """A shape on a link, or in the world; pose (4, 4), m."""

    link: str
    shape: list[Any]  # name and sizes, m
    pose: Matrix


class SpaceRecipe(TypedDict):
    """A robot in a scene: a tree of joints, or a shipped one."""

    kind: Literal["space"]
    shipped: str  # its name, or a file of the shipped scenes' folder
    whole: bool  # Pinocchio's own numbers; for shipped robots with a floating base
    joints: list[JointRecipe]
    bodies: list[BodyRecipe]
    pairs: list[list[int]]  # of bodies
    group: list[str] | None
    held: dict[str, list[float]]
    scene: str  # a shipped one, to which obstacles are added
    obstacles: list[BodyRecipe]
    self_collision: bool
    padding: float  # m
    path: MotionPath
    geometry: GeometryKind  # what meshes are, of links and of the scene
    curved: bool  # whether motions are curves


class LinkRecipe(TypedDict):
    """A link of a planar robot."""

    name: str
    footprint: Matrix  # (n, 2), m
    parent: str | None
    anchor: list[float]  # x, y, angle
    joint: str
    limits: list[float] | None


class PolygonRecipe(TypedDict):
    """A polygon (n, 2) in the world at a pose (3, 3), m."""

    vertices: Matrix
    pose: Matrix


class PlaneRecipe(TypedDict):
    """A planar robot in a scene, and how its root moves."""

    kind: Literal["plane"]
    shipped: str
    links: list[LinkRecipe]
    scene: str
    obstacles: list[PolygonRecipe]
    self_collision: bool
    curve: str
    radius: float | None  # m


class PlacedRecipe(TypedDict):
    """A robot of a cell, and the pose (4, 4) of its base, m."""

    robot: SpaceRecipe
    pose: Matrix


class MovingRecipe(TypedDict):
    """A body that moves: poses (m, 4, 4) at times (m,), s and m; whether it stands still before and after these."""

    shape: list[Any]
    times: list[float]
    poses: list[Matrix]
    stands: bool


class CellRecipe(TypedDict):
    """Robots by name, bodies that move, and obstacles."""

    kind: Literal["cell"]
    robots: dict[str, PlacedRecipe]
    moving: list[MovingRecipe]
    obstacles: list[BodyRecipe]
    padding: float  # m


Recipe: TypeAlias = SpaceRecipe | PlaneRecipe | CellRecipe


def tree_recipe() -> SpaceRecipe:
    """A tree of no joints in an empty scene."""
    return {
        "kind": "space",
        "shipped": "",
        "whole": False,
        "joints": [],
        "bodies": [],
        "pairs": [],
        "group": None,
        "held": {},
        "scene": "",
        "obstacles": [],
        "self_collision": True,
        "padding": 0.0,
        "path": "screw",
        "geometry": "hull",
        "curved": False,
    }


def robot_of(recipe: SpaceRecipe) -> Robot:
    """The robot of a recipe."""
    if recipe["shipped"]:
        return _shipped(recipe)
    model, links = _model(recipe)
    bodies = tuple(_body(body, str(k), links) for k, body in enumerate(recipe["bodies"]))
    group = recipe["group"]
    mimics = {joint["name"]: Mimic(*joint["mimic"]) for joint in recipe["joints"] if joint["mimic"] is not None}
    parts = RobotParts(
        name="tree",
        model=model,
        tree=link_tree(model),
        bodies=bodies,
        pairs=np.array(recipe["pairs"], dtype=np.int64).reshape(-1, 2),
        disabled_pairs=(),
        mimics=mimics,
        values={name: np.array(value) for name, value in recipe["held"].items()},
        group=None if group is None else "group",
        joints=None if group is None else tuple(group),
    )
    return Robot(parts)


def _shipped(recipe: SpaceRecipe) -> Robot:
    if not recipe["whole"]:
        return Robot.load(_file_or_name(recipe["shipped"]), geometry=geometry_of(recipe))
    description = read_description(find_description(recipe["shipped"]))
    return Robot.from_urdf(description.urdf, description.srdf, package_dirs=description.package_dirs, floating=True)


def is_of_solids(recipe: Recipe) -> bool:
    """Whether meshes are as they are."""
    return recipe["kind"] == "space" and geometry_of(recipe) == "solid"


def is_curved(recipe: Recipe) -> bool:
    """Whether motions are curves; cases from before there were curves do not tell."""
    return recipe["kind"] == "space" and recipe.get("curved", False)


def geometry_of(recipe: SpaceRecipe) -> GeometryKind:
    """What meshes are; cases from before there were solids name nothing."""
    return recipe.get("geometry", "hull")


def _file_or_name(shipped: str) -> str | Path:
    """A robot or a scene: where it is, if it is a file of the shipped scenes' folder."""
    return shipped_folder("configs") / shipped if shipped.endswith(".yaml") else shipped


def _model(recipe: SpaceRecipe) -> tuple[pin.Model, set[str]]:
    model = pin.Model()
    model.name = "tree"
    frames = [model.addBodyFrame("base", 0, pin.SE3.Identity(), 0)]
    for joint in recipe["joints"]:
        made = JOINTS[joint["kind"]](np.array(joint["axis"]), joint["pitch"])
        low, high = np.array(joint["limits"]).reshape(2, -1)
        many = np.full(made.nv, 1e3)
        parent = joint["parent"] + 1
        index = model.addJoint(parent, made, _se3(joint["placement"]), joint["name"], many, many, low, high)
        frame = model.addJointFrame(index, frames[parent])
        frames.append(model.addBodyFrame(joint["name"] + " link", index, _se3(joint["link"]), frame))
    return model, {"base", *(joint["name"] + " link" for joint in recipe["joints"])}


def _se3(pose: Matrix) -> pin.SE3:
    matrix = np.array(pose)
    return pin.SE3(matrix[:3, :3].copy(), matrix[:3, 3].copy())


def shape_of(shape: list[Any]) -> Shape:
    """A shape from its name and sizes."""
    name, *sizes = shape
    if name == "corners":
        vertices, _, _ = inflated_hull(shape_of(sizes[0]))
        return PointCloud(vertices, np.array([_CORNER]))
    if name == "box":
        return Box(tuple(sizes[0]))
    if name == "hull":
        return Hull(np.array(sizes[0]))
    curved: Shape = {"sphere": Sphere, "capsule": Capsule, "cylinder": Cylinder}[name](*sizes)
    return curved


def _body(body: BodyRecipe, name: str, links: set[str]) -> GeometryObject:
    assert body["link"] in links
    return GeometryObject(name, body["link"], np.array(body["pose"]), shape_of(body["shape"]))


def scene_of(recipe: SpaceRecipe) -> Scene:
    """The scene of a recipe, without the obstacles that are added."""
    if not recipe["scene"]:
        return Scene("obstacles")
    return Scene.load(_file_or_name(recipe["scene"]), meshes="solid" if geometry_of(recipe) == "solid" else "hull")


def space_checker(recipe: SpaceRecipe, robot: Robot | None = None) -> Checker:
    """A new checker of a recipe; `robot` if it was built already."""
    scene = scene_of(recipe)
    for k, body in enumerate(recipe["obstacles"]):
        scene.add(f"obstacle {k}", shape_of(body["shape"]), np.array(body["pose"]))
    made = robot if robot is not None else robot_of(recipe)
    return Checker(made, scene, self_collision=recipe["self_collision"], padding=recipe["padding"])


def cell_of(recipe: CellRecipe) -> Robot:
    """The robots of a recipe as one."""
    return Robot.together({name: (robot_of(one["robot"]), one["pose"]) for name, one in recipe["robots"].items()})


def cell_checker(recipe: CellRecipe, cell: Robot | None = None, tuning: Tuning = DEFAULT_TUNING) -> Checker:
    """A new checker of a recipe; `cell` if it was built already."""
    scene = Scene("obstacles")
    for k, body in enumerate(recipe["obstacles"]):
        scene.add(f"obstacle {k}", shape_of(body["shape"]), np.array(body["pose"]))
    for k, item in enumerate(recipe["moving"]):
        moving = Moving(item["times"], np.array(item["poses"]), outside="stand" if item["stands"] else "refuse")
        scene.add(f"moving {k}", shape_of(item["shape"]), moving)
    robot = cell if cell is not None else cell_of(recipe)
    return Checker(robot, scene, padding=recipe["padding"], tuning=tuning)


def planar_robot_of(recipe: PlaneRecipe) -> planar.Robot:
    """The planar robot of a recipe."""
    if recipe["shipped"]:
        return planar.Robot.load(recipe["shipped"])
    return planar.Robot([_link(link) for link in recipe["links"]], name="chain")


def _link(link: LinkRecipe) -> planar.Link:
    limits = (-np.inf, np.inf) if link["limits"] is None else (link["limits"][0], link["limits"][1])
    x, y, angle = link["anchor"]
    joint: Any = link["joint"]
    return planar.Link(link["name"], np.array(link["footprint"]), link["parent"], (x, y, angle), joint, limits)


def planar_checker(recipe: PlaneRecipe, robot: planar.Robot | None = None) -> planar.Checker:
    """A new checker of a recipe; `robot` if it was built already."""
    scene = planar.Scene.load(recipe["scene"]) if recipe["scene"] else planar.Scene("obstacles")
    for k, body in enumerate(recipe["obstacles"]):
        scene.add_polygon(f"obstacle {k}", np.array(body["vertices"]), np.array(body["pose"]))
    made = robot if robot is not None else planar_robot_of(recipe)
    return planar.Checker(made, scene, recipe["self_collision"])
