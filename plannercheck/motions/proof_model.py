"""A checker's robot, scene and pairs as the plain data of a proof.

In: a checker in space. Out: `Model`: the kernel's joint table in the URDF's terms, the bodies of all pairs with the
vertices of their hulls, of solids their triangles, and all of the checker's pairs, unreachable ones included. A set of
parts has the numbers of its shape: points and radii, corners of cells, triangles of a surface.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.height_fields import HeightField
from plannercheck.bodies.kinds import Kind
from plannercheck.bodies.lattice_cells import LatticeCells
from plannercheck.bodies.part_sets import PartSet
from plannercheck.bodies.point_clouds import PointCloud
from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.shapes import GeometryObject
from plannercheck.common.array_types import Floats, Ints
from plannercheck.common.arrays import distinct
from plannercheck.common.errors import PlannercheckError
from plannercheck.motions.sampling import MotionSampler
from plannercheck.proofs.data import WORLD, Joint, Link, Model, PosedBody
from plannercheck.proofs.parts import parts_of
from plannercheck.robots.joints import KINDS
from plannercheck.robots.kinematics import JointTable
from plannercheck.robots.robot import Robot

# Rounds in which a ball's centre moves towards the furthest vertex, by a shrinking step.
_BALL_ROUNDS = 200

# Balls are enlarged by this part: far above the rounding of doubles.
_BALL_ROOM = 1 + 1e-12
_NO_TRIANGLES = np.empty((0, 3), dtype=np.int64)


class PosedPairs(Protocol):
    """The attributes of a checker from which its model is made; see `Checker`."""

    robot: Robot
    bodies: tuple[GeometryObject, ...]
    pairs: Ints
    paddings: Floats

    @property
    def motion_sampler(self) -> MotionSampler:
        """Whose whole turns a motion leaves out."""

    @property
    def polytopes(self) -> tuple[Polytope | None, ...]:
        """The hulls of `bodies`, None where no pair needs one."""


def space_model(checker: PosedPairs) -> Model:
    """The model of a checker whose robot the compiled kernel poses."""
    robot, table = checker.robot, checker.robot.joint_table
    assert table is not None
    used = distinct(checker.pairs)
    pairs = np.searchsorted(used, checker.pairs).tolist()
    names = list(robot.model.names)[1:]
    return Model(
        tuple(_joint(table, k, names[k]) for k in range(len(table.parents))),
        tuple(
            Link(name, joint, _rows(placement))
            for name, joint, placement in zip(
                robot.link_names, table.link_joints.tolist(), table.link_placements, strict=True
            )
        ),
        tuple(_body(checker, k) for k in used.tolist()),
        tuple((a, b) for a, b in pairs),
        tuple(checker.motion_sampler.whole_turns.tolist()),
        robot.nq,
    )


def _joint(table: JointTable, k: int, name: str) -> Joint:
    kind = KINDS[table.kinds[k]]
    count = kind.numbers
    return Joint(
        name,
        kind.name,
        int(table.parents[k]),
        _rows(table.placements[k]),
        tuple(table.axes[k].tolist()),
        tuple(table.columns[k, :count].tolist()),
        tuple(table.multipliers[k, :count].tolist()),
        tuple(table.offsets[k, :count].tolist()),
    )


_MadeOf: TypeAlias = tuple[Floats, NDArray[np.int64], dict[str, Any]]  # vertices, triangles, fields of its kind


def _of_solid(shape: Any, polytope: Polytope) -> _MadeOf:
    vertices, faces = shape.used
    return vertices, faces.astype(np.int64)[spatial_order(vertices, faces)], {}


def _of_part_set(shape: Any, polytope: Polytope) -> _MadeOf:
    vertices, own = _parts(shape)
    return vertices, _NO_TRIANGLES, own


def _of_half_space(shape: Any, polytope: Polytope) -> _MadeOf:
    normal, offset = shape.scaled
    return np.zeros(0), _NO_TRIANGLES, {"half_space": (*normal, offset)}


_MADE_OF: dict[Kind, Callable[[Any, Polytope], _MadeOf]] = {
    "hull": lambda _, polytope: (polytope.vertices, _NO_TRIANGLES, {}),
    "solid": _of_solid,
    "part_set": _of_part_set,
    "half_space": _of_half_space,
}


def _body(checker: PosedPairs, k: int) -> PosedBody:
    body, polytope = checker.bodies[k], checker.polytopes[k]
    assert polytope is not None
    shape, radius = body.shape, polytope.inflation_radius
    link = WORLD if body.link is None else checker.robot.link_index(body.link)
    vertices, triangles, own = _MADE_OF[polytope.kind](shape, polytope)
    made = PosedBody(
        body.name,
        body.label,
        link,
        _rows(body.pose[:3]),
        vertices,
        radius,
        min(float(checker.paddings[k]), radius),
        (0.0, 0.0, 0.0),
        0.0,
        tuple((int(a), int(b), int(c)) for a, b, c in triangles.tolist()),
        **own,
    )
    if not len(vertices):
        return made
    centre, reach = ball_around(parts_of(made).box if made.parts else vertices)
    return replace(made, centre=tuple(centre.tolist()), reach=reach)


def _parts(shape: PartSet) -> tuple[Floats, dict[str, Any]]:
    """The vertices of a set's parts, m, and what else a proof says of it; in the order of the shape's own numbers."""
    own: dict[str, Any]
    match shape:
        case PointCloud():
            vertices, own = shape.points, {"parts": "balls", "radii": shape.radius}
        case LatticeCells():
            vertices, own = np.stack(shape.boxes(), axis=1).reshape(-1, 3), {"parts": "boxes"}
        case HeightField():
            vertices, own = shape.triangles().reshape(-1, 3), {"parts": "prisms", "base": shape.base}
        case _:
            raise PlannercheckError(f"proofs are not about shapes of type {type(shape).__name__}")
    return (vertices if len(vertices) else np.zeros(0)), own


def spatial_order(vertices: Floats, triangles: NDArray[np.integer[Any]]) -> NDArray[np.int64]:
    """An order (n,) of triangles in which every half of a half lies close together: cut across the longest side."""
    centres = vertices[triangles].mean(axis=1)
    order, parts = np.arange(len(triangles)), [(0, len(triangles))]
    while parts:
        low, high = parts.pop()
        if high - low > 1:
            own = centres[order[low:high]]
            axis = int(np.argmax(np.ptp(own, axis=0)))
            order[low:high] = order[low:high][np.argsort(own[:, axis], kind="stable")]
            middle = (low + high) // 2
            parts += [(low, middle), (middle, high)]
    return order


def _rows(matrix: Floats) -> tuple[float, ...]:
    return tuple(np.asarray(matrix, dtype=np.float64).ravel().tolist())


def ball_around(points: Floats) -> tuple[Floats, float]:
    """Centre (3,) and radius of a small ball that holds points (n, 3), m."""
    centre = (points.min(axis=0) + points.max(axis=0)) / 2
    best, least = centre, np.inf
    for step in range(2, _BALL_ROUNDS):
        offsets = points - centre
        distances = np.linalg.norm(offsets, axis=1)
        furthest = int(np.argmax(distances))
        if distances[furthest] < least:
            best, least = centre, float(distances[furthest])
        centre = centre + offsets[furthest] / step**1.5
    return best, least * _BALL_ROOM + 1e-280
