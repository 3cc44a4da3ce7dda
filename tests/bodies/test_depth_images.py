"""Clouds of depth images: REP 118's units and values without a return, and back-projection against exact fractions."""

import warnings
from fractions import Fraction

import numpy as np
import pytest

import plannercheck as pc

FX, FY, CX, CY = 612.3, 610.9, 320.25, 239.5
K = np.array([[FX, 0, CX], [0, FY, CY], [0, 0, 1]])
# A camera 1.3 m above the origin that looks along x: z of the optical frame is forward, x right, y down.
FORWARD = np.array([[0, 0, 1, -0.3], [-1, 0, 0, 0.2], [0, -1, 0, 1.3], [0, 0, 0, 1.0]])
EPS = Fraction(1, 2**52)


def turned(rng: np.random.Generator) -> np.ndarray:
    """A random pose, m."""
    pose = np.eye(4)
    pose[:3, :3] = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    pose[:3, 0] *= np.sign(np.linalg.det(pose[:3, :3]))
    pose[:3, 3] = rng.uniform(-2, 2, 3)
    return pose


def exact(depth: Fraction, u: int, v: int, pose: np.ndarray) -> list[Fraction]:
    """The definition, of the given doubles."""
    fx, fy, cx, cy = map(Fraction, (FX, FY, CX, CY))
    local = [(u - cx) / fx * depth, (v - cy) / fy * depth, depth, Fraction(1)]
    return [sum(Fraction(a) * b for a, b in zip(row, local, strict=True)) for row in pose[:3].tolist()]


@pytest.mark.parametrize("kind", [np.float32, np.float64, np.float16, np.uint16])
def test_points_are_those_of_exact_fractions(kind: type) -> None:
    rng = np.random.default_rng(0)
    depth = (rng.uniform(200, 9000, (7, 9)) if kind is np.uint16 else rng.uniform(0.2, 9, (7, 9))).astype(kind)
    pose = turned(rng)
    cloud = pc.PointCloud.from_depth(depth, (FX, FY, CX, CY), pose, 0.01)
    assert (cloud.count, cloud.dropped) == (63, 0)
    for (v, u), point in zip(np.ndindex(depth.shape), cloud.points.tolist(), strict=True):
        metres = Fraction(int(depth[v, u]), 1000) if kind is np.uint16 else Fraction(float(depth[v, u]))
        for found, true in zip(point, exact(metres, u, v, pose), strict=True):
            assert abs(Fraction(found) - true) <= 8 * EPS * (10 + 3 * metres)


def test_points_project_onto_their_pixels() -> None:
    rng = np.random.default_rng(1)
    depth, pose = rng.uniform(0.3, 5, (48, 64)), turned(rng)
    cloud = pc.PointCloud.from_depth(depth, K, pose, 0.01)
    seen = np.linalg.solve(pose, np.column_stack([cloud.points, np.ones(cloud.count)]).T)[:3]
    image = K @ seen / seen[2]
    v, u = np.divmod(np.arange(cloud.count), 64)
    assert np.abs(image[:2] - [u, v]).max() < 1e-9
    assert np.abs(seen[2] - depth.reshape(-1)).max() < 1e-12


def test_the_optical_frame_looks_along_z_with_y_down() -> None:
    depth = np.full((480, 640), 2.0)
    points = pc.PointCloud.from_depth(depth, K, FORWARD, 0.01).points.reshape(480, 640, 3)
    assert points[240, 320] == pytest.approx([1.7, 0.2, 1.3], abs=0.005)  # straight ahead
    assert points[240, 639, 1] < 0.2 - 1  # right of the camera is -y of a world that it looks at along x
    assert points[479, 320, 2] < 1.3 - 0.7  # the last row is below
    assert np.all(points[..., 0] == 1.7)  # depth is along z, not along the ray


def test_without_a_pose_points_are_in_the_optical_frame() -> None:
    depth = np.full((2, 2), 1.5)
    assert np.array_equal(
        pc.PointCloud.from_depth(depth, K, None, 0.1).points, pc.PointCloud.from_depth(depth, K, np.eye(4), 0.1).points
    )


@pytest.mark.parametrize("nothing", [np.nan, 0.0, np.inf])
def test_no_return_is_no_point(nothing: float) -> None:
    depth = np.full((3, 4), 2.0)
    depth[1, 2] = depth[2, 0] = nothing
    cloud = pc.PointCloud.from_depth(depth, K, None, 0.01)
    assert (cloud.count, cloud.dropped) == (10, 2)
    assert cloud.source.tolist() == [0, 1, 2, 3, 4, 5, 7, 9, 10, 11]
    assert np.array_equal(
        cloud.points, pc.PointCloud.from_depth(np.full((3, 4), 2.0), K, None, 0.01).points[cloud.source]
    )


def test_an_image_without_returns_is_an_empty_cloud() -> None:
    for depth in (np.zeros((4, 5), dtype=np.uint16), np.full((4, 5), np.nan), np.zeros((0, 5))):
        assert pc.PointCloud.from_depth(depth, K, None, 0.01).count == 0


def test_what_is_too_close_to_measure_is_told() -> None:
    depth = np.full((3, 4), 2.0)
    depth[0, :2] = -np.inf
    with pytest.warns(RuntimeWarning, match="2 pixels are -inf, for something too close to measure") as caught:
        assert pc.PointCloud.from_depth(depth, K, None, 0.01).count == 10
    assert caught[0].filename == __file__


def test_radii_may_grow_with_the_depth() -> None:
    depth = np.linspace(0.5, 3, 12).reshape(3, 4)
    depth[1, 1] = np.nan
    cloud = pc.PointCloud.from_depth(depth, K, None, depth * 0.71 / FX)
    kept = depth[np.isfinite(depth)]
    assert np.array_equal(cloud.radius, kept * 0.71 / FX)
    wall = np.full((3, 4), 1.5)
    balls = pc.PointCloud.from_depth(wall, K, None, wall * 0.71 / min(FX, FY))
    centre = balls.points[[0, 1, 4, 5]].mean(axis=0)
    assert pc.intersects(balls, [centre, centre, centre, centre])  # between four pixels
    with pytest.raises(pc.PlannercheckError, match="radius 3 of a cloud must be finite and above 0"):
        pc.PointCloud.from_depth(wall, K, None, np.where(np.arange(12).reshape(3, 4) == 3, -1.0, 0.01))


def test_a_frame_in_a_scene() -> None:
    robot = pc.Robot.load("panda")
    scene = pc.Scene("seen")
    depth = np.full((60, 80), 1200, dtype=np.uint16)
    small = (FX / 8, FY / 8, CX / 8, CY / 8)
    scene.add("camera", pc.PointCloud.from_depth(depth, small, FORWARD, 0.02))
    assert not pc.Checker(robot, scene).check_states(robot.random_configurations(200, 0)).all()
    scene.update("camera", pc.PointCloud.from_depth(np.zeros_like(depth), small, FORWARD, 0.02))
    assert pc.Checker(robot, scene).check_states(robot.random_configurations(200, 0)).any()


@pytest.mark.parametrize(
    ("depth", "says"),
    [
        (np.full((2, 2), 1200, dtype=np.int32), r"floats \(m\) or uint16 \(mm\), not int32: convert it to m"),
        (np.full((2, 2), 12, dtype=np.uint8), r"not uint8"),
        (np.full((2, 2), True), r"not an array of dtype bool"),
        (np.full((2, 2, 1), 1.0), r"must have shape \(h, w\), not \(2, 2, 1\)"),
        (np.full(4, 1.0), r"must have shape \(h, w\)"),
        (np.full((2, 2), 1j), r"must be an array \(h, w\)"),
        ("depth.png", r"must be an array \(h, w\)"),
        (np.array([[1.0, 1.0], [1.0, -0.25]]), r"row 1, column 1 is -0.25 m; depths must not be negative"),
    ],
)
def test_images_that_are_none(depth: object, says: str) -> None:
    with pytest.raises(pc.PlannercheckError, match=says):
        pc.PointCloud.from_depth(depth, K, None, 0.01)


@pytest.mark.parametrize(
    ("intrinsics", "says"),
    [
        (K.T, r"must be \[\[fx, 0, cx\], \[0, fy, cy\], \[0, 0, 1\]\]"),
        (K + np.eye(3, k=1)[:3] * 0.5, r"must be \[\[fx, 0, cx\]"),  # skew
        (K.reshape(-1), r"K \(3, 3\) or \(fx, fy, cx, cy\), not an array \(9,\)"),
        (np.hstack([K, np.zeros((3, 1))]), r"not an array \(3, 4\)"),
        ((0.0, FY, CX, CY), "fx and fy above 0"),
        ((-FX, FY, CX, CY), "fx and fy above 0"),
        ((FX, FY, np.nan, CY), "must be finite"),
        ("K", "intrinsics 'K' must be numbers"),
    ],
)
def test_intrinsics_that_are_none(intrinsics: object, says: str) -> None:
    with pytest.raises(pc.PlannercheckError, match=says):
        pc.PointCloud.from_depth(np.ones((2, 2)), intrinsics, None, 0.01)


def test_poses_that_are_none() -> None:
    with pytest.raises(pc.PlannercheckError, match="pose of a depth image is not rigid"):
        pc.PointCloud.from_depth(np.ones((2, 2)), K, np.diag([2.0, 1, 1, 1]), 0.01)


def test_images_of_other_layouts_are_the_same() -> None:
    depth = np.linspace(0.5, 3, 12).reshape(3, 4)
    expected = pc.PointCloud.from_depth(depth, K, FORWARD, 0.01).points
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for image in (np.asfortranarray(depth), depth.astype(">f8"), depth.tolist(), depth[::-1][::-1]):
            assert np.array_equal(pc.PointCloud.from_depth(image, K, FORWARD, 0.01).points, expected)
        big = (depth * 1000).astype(">u2")
        assert np.array_equal(
            pc.PointCloud.from_depth(big, K, FORWARD, 0.01).points,
            pc.PointCloud.from_depth(big.astype(np.uint16), K, FORWARD, 0.01).points,
        )
