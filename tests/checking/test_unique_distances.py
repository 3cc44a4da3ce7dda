"""Where `unique` says that a distance has a gradient, and its derivatives along directions where it has none: before
solids and sets of parts, and where bodies overlap."""

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from part_oracle import PartOracle, parts_of
from solid_meshes import angle, dimpled, ring

import plannercheck as pc
from plannercheck.bodies.shapes import Box, Capsule

pytestmark = pytest.mark.filterwarnings("ignore:.*has no <collision> elements")

STEP = 1e-6  # m and rad


def on_a_free_joint(folder: Path, shape: str, **geometry) -> pc.Robot:
    """A robot of one body that floats."""
    path = folder / "one.urdf"
    body = f"<collision><geometry>{shape}</geometry></collision>" if shape else ""
    path.write_text(
        f'<robot name="one"><link name="base"/><link name="body">{body}</link>'
        '<joint name="j" type="floating"><parent link="base"/><child link="body"/></joint></robot>'
    )
    return pc.Robot.from_urdf(path, **geometry)


def write_mesh(folder: Path, mesh) -> str:
    """The element that names a mesh's file."""
    points, triangles = mesh
    lines = ["v {} {} {}".format(*p) for p in points] + ["f {} {} {}".format(*(t + 1)) for t in triangles]
    (folder / "mesh.obj").write_text("\n".join(lines))
    return f'<mesh filename="{folder}/mesh.obj"/>'


def grid(rng):
    occupied = rng.random((6, 6, 6)) < 0.4
    return pc.VoxelGrid(occupied, 0.1, (-0.3, -0.3, -0.3))


def octree(rng):
    cells = np.unique(rng.integers(-3, 3, size=(60, 3)), axis=0)
    return pc.Octree.from_cells(cells, 0.1)


def heights(rng):
    return pc.HeightField(rng.uniform(0, 0.3, size=(8, 8)), (0.1, 0.1), -0.2, (-0.35, -0.35))


def cloud(rng):
    return pc.PointCloud(rng.uniform(-0.3, 0.3, size=(80, 3)), rng.uniform(0.005, 0.02, size=80))


def stone(rng):
    return pc.Hull(rng.normal(size=(40, 3)) * 0.15)


OBSTACLES = {
    "ring": lambda _: pc.Solid(*ring(9, 5, 0.3)),
    "dimpled": lambda _: pc.Solid(*dimpled(0.6, 0.3)),
    "angle": lambda _: pc.Solid(0.2 * angle()[0], angle()[1]),
    "cloud": cloud,
    "grid": grid,
    "octree": octree,
    "heights": heights,
    "stone": stone,
    "box": lambda _: Box((0.4, 0.3, 0.2)),
    "capsule": lambda _: Capsule(0.1, 0.3),
    "floor": lambda _: pc.HalfSpace((0.0, 0.6, 0.8), 0.1),
}
CONVEX = ("stone", "box", "capsule")
SHAPES = {
    "box": '<box size="0.1 0.2 0.3"/>',
    "capsule": '<capsule radius="0.05" length="0.2"/>',
    "solid": (0.1 * angle()[0], angle()[1]),
    "cells": "",  # are carried
}


CONCAVE = ("solid", "cells")


def configurations(robot, rng, count):
    """Near the origin; the second half turned along the axes and placed on a lattice, where ties are many."""
    q = robot.random_configurations(count, seed=int(rng.integers(1000)))
    q[:, :3] = rng.normal(size=(count, 3))
    q[:, :3] *= rng.uniform(0.1, 0.7, size=(count, 1)) / np.linalg.norm(q[:, :3], axis=1, keepdims=True)
    for k in range(count // 2, count):
        q[k, :3] = np.round(q[k, :3] / 0.05) * 0.05
        turns = [pin.Quaternion(pin.exp3(np.eye(3)[i] * n * np.pi / 2)) for i, n in enumerate(rng.integers(4, size=3))]
        q[k, 3:] = (turns[0] * turns[1] * turns[2]).coeffs()
    return q


def scene_of(folder, shape, obstacle, rng):
    """A robot of one body, its checker before an obstacle, and brute force, None before a half-space."""
    is_solid = shape == "solid"
    element = write_mesh(folder, SHAPES[shape]) if is_solid else SHAPES[shape]
    robot = on_a_free_joint(folder, element, geometry="solid" if is_solid else None)
    scene = pc.Scene("one")
    scene.add("obstacle", OBSTACLES[obstacle](rng))
    if shape == "cells":
        scene.add("carried", pc.VoxelGrid(rng.random((3, 2, 2)) < 0.6, 0.07, (-0.1, -0.07, -0.07)))
        scene.attach("carried", "body")
    checker = pc.Checker(robot, scene)
    if obstacle == "floor":
        return robot, checker, None
    return robot, checker, PartOracle(*(checker._preparation.polytope(k) for k in checker.pairs[0].tolist()))


def over_the_floor(body, poses):
    """(n,) how far a body is over the half-space of `OBSTACLES`."""
    normal = np.array((0.0, 0.6, 0.8))
    heights = [
        (np.einsum("nij,vj->nvi", poses[:, :3, :3], part.vertices) @ normal).min(axis=1) - part.inflation_radius
        for part in parts_of(body)
    ]
    return np.min(heights, axis=0) + poses[:, :3, 3] @ normal - 0.1


def brute_force(robot, checker, oracle, q, steps):
    """(n + 1,) distances at a configuration, and after steps (n, 6) in the tangent."""
    a, b = checker.pairs[0].tolist()
    poses = checker.body_poses(np.array([q, *(pin.integrate(robot.model, q, step) for step in steps)]))
    if oracle is None:
        return over_the_floor(checker._preparation.polytope(a), poses[:, a])
    return oracle.distances(poses[:, a], poses[:, b])


def judge_row(robot, checker, oracle, q, table, row, error):
    """One-sided derivatives agree, so there is no kink, and central ones are the gradient up to an error."""
    found = brute_force(robot, checker, oracle, q, [s * d for d in np.eye(6) for s in (STEP, -STEP)])
    assert table.distance[row] == pytest.approx(found[0], abs=1e-12)
    forward, backward = found[1::2] - found[0], found[0] - found[2::2]
    np.testing.assert_allclose(forward / STEP, backward / STEP, atol=3e-4 + 3 * STEP / abs(found[0]))
    np.testing.assert_allclose((forward + backward) / (2 * STEP), table.gradient[row], atol=error)


@pytest.mark.parametrize("obstacle", OBSTACLES)
@pytest.mark.parametrize("shape", SHAPES)
def test_unique_rows_have_the_derivatives_of_brute_force(tmp_path, obstacle, shape):
    rng = np.random.default_rng(sum(map(ord, obstacle + shape)))
    robot, checker, oracle = scene_of(tmp_path, shape, obstacle, rng)
    q = configurations(robot, rng, 20)
    table = checker.distances(q, np.inf)
    apart = table.distance > 0
    assert table.unique[apart & (table.state < 10)].mean() > 0.9
    if obstacle in CONVEX and shape not in CONCAVE:
        assert table.unique[~apart & (table.state < 10)].mean() > 0.9
    elif obstacle != "floor":
        assert not table.unique[~apart].any()
    for row in np.flatnonzero(table.unique):
        # On a lattice, both sides may differ in their curvature.
        curvature = 0 if table.state[row] < 10 else 1 / abs(table.distance[row])
        judge_row(robot, checker, oracle, q[table.state[row]], table, row, 1e-8 + curvature * STEP)


def judge_directions(robot, checker, oracle, q, table, row, directions):
    """One-sided derivatives of the second order are those along directions; how many were judged.

    Where they change within the step, as where another place is nearest then, nothing is judged.
    """
    found = brute_force(robot, checker, oracle, q, [s * dq for dq in directions for s in (0.5e-5, 1e-5, 2e-5)])
    half, one, two = found[1::3], found[2::3], found[3::3]
    coarse, fine = ((4 * near - far - 3 * found[0]) / (2 * s) for near, far, s in ((one, two, 1e-5), (half, one, 5e-6)))
    steady = np.abs(coarse - fine) < 1e-8
    for k in np.flatnonzero(steady):
        assert table.directional(row, directions[k]) == pytest.approx(fine[k], abs=1e-7)
    return steady.sum()


@pytest.mark.parametrize("obstacle", [name for name in OBSTACLES if name not in ("stone", "capsule")])
@pytest.mark.parametrize("shape", SHAPES)
def test_derivatives_along_directions_are_those_of_brute_force(tmp_path, obstacle, shape):
    rng = np.random.default_rng(sum(map(ord, obstacle + shape)) + 1)
    robot, checker, oracle = scene_of(tmp_path, shape, obstacle, rng)
    q = configurations(robot, rng, 14)[7:]
    if obstacle == "floor":  # above it
        q[:, :3] *= np.where(q[:, 1:3] @ (0.6, 0.8) < 0, -1, 1)[:, None]
    table = checker.distances(q, np.inf)
    judged = 0
    for row in np.flatnonzero(~table.unique & (table.distance > 1e-3)):
        directions = [*rng.normal(size=(2, 6)), *(np.eye(6)[k] * s for k in (0, 3, 4, 5) for s in (1, -1))]
        judged += judge_directions(robot, checker, oracle, q[table.state[row]], table, row, directions)
    assert judged or obstacle in ("cloud", "heights")  # where ties are seldom


def row_of(folder, shape, obstacle, place, turn=(0.0, 0.0, 0.0), **geometry):
    """The row of a body at a place, m, and a turn, rad, before an obstacle at the origin."""
    scene = pc.Scene("one")
    scene.add("obstacle", obstacle)
    checker = pc.Checker(on_a_free_joint(folder, shape, **geometry), scene)
    quaternion = pin.Quaternion(pin.exp3(np.array(turn))).coeffs()
    return checker.distances([*place, *quaternion], np.inf)


BALL, ROOM = '<sphere radius="0.05"/>', 0.001
VALLEY = (
    np.array([[x, y, abs(x)] for x in (-1.0, 0.0, 1.0) for y in (-1.0, 1.0)]),
    [[0, 2, 1], [1, 2, 3], [2, 4, 3], [3, 4, 5]],
)
TWO_BALLS = pc.PointCloud([[-0.2, 0.0, 0.0], [0.2, 0.0, 0.0]], 0.05)
CASES = {
    "two sides of a valley": (BALL, pc.Solid(*VALLEY, open="triangles"), (0.0, 0.1, 0.3), (ROOM, 0.1, 0.3)),
    "two balls of a cloud": (BALL, TWO_BALLS, (0.0, 0.1, 0.3), (ROOM, 0.1, 0.3)),
    "two cells": (
        BALL,
        pc.VoxelGrid(np.array([1, 0, 1], dtype=bool).reshape(3, 1, 1), 0.2, (-0.3, 0.0, 0.0)),
        (0.0, 0.1, 0.1),
        (ROOM, 0.1, 0.1),
    ),
    "two prongs at once": (
        '<box size="1 0.2 0.2"/>',
        TWO_BALLS,
        (0.0, 0.0, 0.3),
        (0.0, 0.0, 0.3, 0.0, 0.01, 0.0),
    ),
    "two faces as deep": (
        BALL,
        Box((0.4, 0.4, 1.0)),
        (0.1, 0.1, 0.05),
        (0.1 + ROOM, 0.1, 0.05),
    ),
    "parallel faces that overlap": (
        '<box size="0.2 0.2 0.2"/>',
        Box((1.0, 1.0, 1.0)),
        (0.05, 0.02, 0.55),
        (0.05, 0.02, 0.55, 0.1, 0.2, 0.0),
    ),
    "parallel edges that overlap": (
        '<capsule radius="0.05" length="0.2"/>',
        Box((0.3, 0.2, 0.25)),
        (0.02, 0.03, 0.12),
        (0.02, 0.03, 0.12, 0.1, 0.2, 0.0),
    ),
    "an edge along a half-space": (
        '<box size="0.2 0.2 0.2"/>',
        pc.HalfSpace((0.0, 0.0, 1.0), 0.0),
        (0.0, 0.0, 0.1, 0.0, 0.3, 0.0),
        (0.0, 0.0, 0.1, 0.1, 0.3, 0.0),
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_two_nearest_places_are_not_unique(tmp_path, case):
    """But are a little beside, where one is nearer."""
    shape, obstacle, tied, beside = CASES[case]
    first, second = (row_of(tmp_path, shape, obstacle, at[:3], at[3:] or (0.0, 0.0, 0.0)) for at in (tied, beside))
    assert not first.unique[0]
    assert first.gap[0] > 0.01
    assert second.unique[0]
    assert second.gap[0] <= 1e-12


# Levers from the body's origin and normals of all nearest pairs of points where places are tied.
S, T = np.sqrt(0.5), np.sqrt(0.14)
NEAREST = {
    "two sides of a valley": [((0, 0, 0), (S, 0, S)), ((0, 0, 0), (-S, 0, S))],
    "two balls of a cloud": [((0, 0, 0), (0.2 / T, 0.1 / T, 0.3 / T)), ((0, 0, 0), (-0.2 / T, 0.1 / T, 0.3 / T))],
    "two cells": [((0, 0, 0), (1, 0, 0)), ((0, 0, 0), (-1, 0, 0))],
    "two prongs at once": [((0.2, 0, -0.1), (0, 0, 1)), ((-0.2, 0, -0.1), (0, 0, 1))],
}


@pytest.mark.parametrize("case", NEAREST)
def test_each_nearest_place_has_its_rate(tmp_path, case):
    """The least one counts."""
    shape, obstacle, tied, _ = CASES[case]
    table = row_of(tmp_path, shape, obstacle, tied[:3])
    for dq in np.random.default_rng(0).normal(size=(20, 6)):
        rates = [np.dot(normal, dq[:3] + np.cross(dq[3:], lever)) for lever, normal in NEAREST[case]]
        assert table.directional(0, dq) == pytest.approx(min(rates), abs=1e-12)


def test_normals_that_rounding_leaves_open_are_no_derivatives(tmp_path):
    table = row_of(tmp_path, '<box size="0.2 0.2 0.2"/>', Box((1.0, 1.0, 1.0)), (0.0, 0.0, 0.6 + 1e-12))
    assert not table.unique[0]
    with pytest.raises(pc.PlannercheckError, match=r"row 0: the bodies are 1e-12 m apart, where rounding leaves"):
        table.directional(0, np.ones(6))


def test_solids_that_overlap_are_not_unique(tmp_path):
    """The depth is that of their hulls, which jumps where the solids part."""
    table = row_of(
        tmp_path, '<box size="0.1 0.1 0.1"/>', pc.Solid(*dimpled(0.6, 0.3)), (0.31, 0.02, 0.01), (0.1, 0.2, 0.3)
    )
    assert table.distance[0] < 0
    assert not table.unique[0]


def test_depths_below_two_nearly_parallel_faces_are_not_unique(tmp_path):
    """Rounding does not tell a roof's sides, whose slopes are a millionth."""
    roof = pc.Hull([[x, y, z - 1e-6 * abs(x)] for x in (-1.0, 0.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 0.0)])
    table = row_of(tmp_path, BALL, roof, (0.0, 0.1, -0.1))
    assert not table.unique[0]
    assert 1e-7 < table.gap[0] < 1e-4
