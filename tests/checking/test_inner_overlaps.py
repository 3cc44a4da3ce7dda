"""Balls and boxes inside bodies: inside in exact arithmetic, and no verdict depends on them."""

from fractions import Fraction

import numpy as np
import pinocchio as pin
import pytest
from poses import at
from solids import solid_of

import plannercheck as pc
from plannercheck.bodies import shapes
from plannercheck.evaluation.stress import contact_poses as contacts

FREE_LINK = """<robot name="free">
<link name="hand"><collision><origin xyz="0.3 -0.1 0.2" rpy="0.4 -1 2"/>
  <geometry><sphere radius="0.1"/></geometry></collision></link>
</robot>"""
GAPS = np.array([0.1, 1e-3, 1e-5, 1e-6, 1e-8, 1e-12, 0, -1e-12, -1e-8, -1e-6, -1e-5, -1e-3, -0.1, -0.3])


def exactly(values):
    return [Fraction(x) for x in values]


def facets_of(polytope):
    """A point and the outward normal of each triangle, exact."""
    for triangle in polytope.faces:
        a, b, c = (exactly(polytope.vertices[v].tolist()) for v in triangle)
        u, v = ([p - q for p, q in zip(other, a, strict=True)] for other in (b, c))
        yield a, [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]


def is_inside(point, radius, polytope):
    """Whether a ball is within the hull; `point` and `radius` exact."""
    for corner, normal in facets_of(polytope):
        depth = sum(n * (c - p) for n, c, p in zip(normal, corner, point, strict=True))
        if depth < 0 or depth * depth < radius * radius * sum(n * n for n in normal):
            return False
    return True


@pytest.mark.parametrize(
    ("name", "n"),
    [("round", 4), ("round", 60), ("needle", 30), ("flat", 30), ("box", 8), ("lattice", 40), ("cone", 25)],
)
@pytest.mark.parametrize("scale", [1e-140, 1e-3, 1, 1e6])
def test_inner_shapes_are_inside(name, n, scale):
    points = solid_of(name, n, 5)[1].vertices
    polytope = pc.Polytope((points + 3) * scale, inflation_radius=0.5 * scale)
    balls, boxes = polytope.core.inner_shapes()
    assert 1 <= len(balls) <= 4
    assert len(boxes) == 1
    for ball in balls:
        *centre, radius = exactly(ball.tolist())
        assert radius > 0
        assert is_inside(centre, radius, polytope)
    box = exactly(boxes[0].tolist())
    for corner in np.ndindex(2, 2, 2):
        assert is_inside([box[3 * side + axis] for axis, side in enumerate(corner)], box[6], polytope)
    if name == "box":
        np.testing.assert_array_equal(boxes[0, :6], np.ravel([polytope.vertices.min(0), polytope.vertices.max(0)]))


ULP = 2.0**-52
RIM = np.pi / 6 * np.arange(12)


@pytest.mark.parametrize(
    "points",
    [
        np.vstack([np.eye(3), -np.eye(3)]) * 50 * ULP + 1.5,
        np.column_stack([np.cos(RIM) / 100, np.sin(RIM) / 100, 1.3 + 4 * ULP * (np.arange(12) % 3 - 1)]),
    ],
)
def test_inner_shapes_as_thin_as_rounding(points):
    """Found by a review: steps that rounding swallows grew a box for ever."""
    polytope = pc.Polytope(points)
    assert len(polytope.core.polar_points()) > 0
    for ball in polytope.core.inner_shapes()[0]:
        *centre, radius = exactly(ball.tolist())
        assert is_inside(centre, radius, polytope)


@pytest.mark.parametrize(
    ("points", "balls", "boxes"),
    [
        ([[1, 2, 3]], 1, 1),
        ([[1, 2, 3], [1, 2, 5]], 4, 1),
        ([[1, 2, 3], [2, 2, 5]], 4, 0),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], 0, 0),
    ],
)
def test_inner_shapes_without_volume(points, balls, boxes):
    polytope = pc.Polytope(points, inflation_radius=0.1)
    found = polytope.core.inner_shapes()
    assert [len(part) for part in found] == [balls, boxes]
    assert not found[0][:, 3].any()
    assert not found[1][:, 6].any()


def test_balls_of_a_segment_lie_evenly_on_it():
    """Up to rounding, and a point's at the point: held against the ends that were given, exactly."""
    rng = np.random.default_rng(13)
    for scale in (1e-3, 1.0, 1e6):
        ends = scale * rng.normal(size=(2, 3))
        balls = pc.Polytope(ends, inflation_radius=0.1 * scale).core.inner_shapes()[0]
        first, second = (exactly(end) for end in ends.tolist())
        along = [b - a for a, b in zip(first, second, strict=True)]
        square, parts = sum(x * x for x in along), []
        for *centre, radius in balls.tolist():
            assert radius == 0
            from_first = [c - a for c, a in zip(exactly(centre), first, strict=True)]
            parts.append(sum(x * y for x, y in zip(from_first, along, strict=True)) / square)
            off = sum((x - parts[-1] * y) ** 2 for x, y in zip(from_first, along, strict=True))
            assert off <= Fraction(4 * ULP * scale) ** 2
        np.testing.assert_allclose(sorted(map(float, parts)), [1 / 8, 3 / 8, 5 / 8, 7 / 8], rtol=1e-14)
        np.testing.assert_array_equal(pc.Polytope(ends[:1]).core.inner_shapes()[0], [[*ends[0], 0.0]])


@pytest.fixture(scope="module")
def free_link(tmp_path_factory):
    path = tmp_path_factory.mktemp("free") / "free.urdf"
    path.write_text(FREE_LINK)
    return pc.Robot.from_urdf(path, floating=True)


def checkers(robot, shape, obstacle, pose, padding):
    """With overlaps and without, of a link of one shape and one obstacle."""
    scene = pc.Scene("one")
    scene.add("obstacle", obstacle, pose)
    hand = shapes.GeometryObject("hand", "hand", robot.bodies[0].pose, shape)
    bodies = [hand, *scene.bodies]
    return [
        pc.Checker(robot, scene, padding=padding, tuning=pc.Tuning(overlaps=on)).with_bodies(bodies)
        for on in (True, False)
    ]


def configuration(robot, pose):
    """That brings the link's body to a pose."""
    link = pose @ np.linalg.inv(robot.bodies[0].pose)
    return np.array(pin.SE3ToXYZQUATtuple(pin.SE3(link)))


def hold_verdicts(with_overlaps, without, q, counted):
    truth = without.check_states(q)
    assert truth.any()
    assert not truth.all()
    np.testing.assert_array_equal(with_overlaps.check_states(q), truth)
    np.testing.assert_array_equal([with_overlaps.is_valid(row) for row in q], truth)
    np.testing.assert_array_equal(with_overlaps.first_colliding_pair(q) < 0, truth)
    np.testing.assert_array_equal(without.colliding_pairs(q)[:, 0], ~truth)
    found = with_overlaps.statistics()["overlaps"]
    assert 2 * counted <= found <= 2 * (~truth).sum()
    assert without.statistics()["overlaps"] == 0


@pytest.mark.parametrize("padding", [0.0, 0.05])
@pytest.mark.parametrize("scale", [1e-3, 1, 1e3])
@pytest.mark.parametrize(("first", "second"), [("round", "box"), ("box", "round"), ("flat", "cone"), ("box", "box")])
def test_near_contact(free_link, first, second, scale, padding):
    """No overlap is seen where bodies only nearly touch; deep ones are."""
    rng = np.random.default_rng(7)
    (solid_p, _), (solid_r, _) = solid_of(first, 30, 8), solid_of(second, 40, 9)
    gaps = np.tile(padding + GAPS, 6)
    poses_p, poses_r = contacts.contact_poses(solid_p, solid_r, gaps, rng)
    relative, pose = np.linalg.inv(poses_r) @ poses_p, poses_r[0].copy()
    relative[:, :3, 3] *= scale
    pose[:3, 3] *= scale
    pair = shapes.Hull(solid_p.vertices * scale), shapes.Hull(solid_r.vertices * scale)
    with_overlaps, without = checkers(free_link, *pair, pose, padding * scale)
    q = np.array([configuration(free_link, pose @ p) for p in relative])
    hold_verdicts(with_overlaps, without, q, 6 if first != "flat" else 0)


@pytest.mark.parametrize("offset", [0.0, 1e3])
def test_balls_that_are_the_body(free_link, offset):
    """A sphere beside a box, both the shapes themselves: all that keeps them apart is the room for rounding."""
    rng = np.random.default_rng(11)
    solid, _ = solid_of("box", 8, 3)
    pose = np.eye(4)
    pose[:3, :3] = pin.Quaternion(np.array([0.1, 0.7, -0.2, 0.6]) / np.sqrt(0.9)).matrix()
    pose[:3, 3] = offset
    with_overlaps, without = checkers(free_link, shapes.Sphere(0.2), shapes.Hull(solid.vertices), pose, 0.0)
    gaps = np.tile(GAPS, 20)
    points, normals = contacts.random_features(solid, len(gaps), rng)
    posed = np.repeat(np.eye(4)[None], len(gaps), axis=0)
    posed[:, :3, 3] = points + (0.2 + gaps)[:, None] * normals
    q = np.array([configuration(free_link, pose @ p) for p in posed])
    hold_verdicts(with_overlaps, without, q, 40)


@pytest.mark.parametrize("far", [1e3, 1e4])
def test_balls_far_from_their_links_overlap_only_what_they_do(free_link, far):
    """A ball above a box at the origin, its link far off: where floats put it, it is off by parts of that way."""
    rng = np.random.default_rng(12)
    radius, gaps = 0.2, np.tile(np.array([1e-8, 2e-7, 1e-6, -1e-8, -2e-5]) * far, 60)
    placement = at(*far * contacts.random_directions(1, rng)[0])
    scene = pc.Scene("one")
    scene.add("box", shapes.Box((1.0, 1.0, 1.0)))
    bodies = [shapes.GeometryObject("hand", "hand", placement, shapes.Sphere(radius)), *scene.bodies]
    with_overlaps, without = (
        pc.Checker(free_link, scene, tuning=pc.Tuning(overlaps=on)).with_bodies(bodies) for on in (True, False)
    )
    links = contacts.identities(len(gaps))
    links[:, :3, :3] = contacts.frames(contacts.random_directions(len(gaps), rng))
    centres = rng.uniform(-0.4, 0.4, (len(gaps), 3))
    centres[:, 2] = 0.5 + radius + gaps
    links[:, :3, 3] = centres - links[:, :3, :3] @ placement[:3, 3]
    q = np.array([pin.SE3ToXYZQUATtuple(pin.SE3(link)) for link in links])
    hold_verdicts(with_overlaps, without, q, 0)


def test_differences_that_overflow_floats(free_link):
    """Found by a review: a box beyond the floats' range was as near as one around the ball."""
    axes = np.column_stack([[1, 1, 1], [1, -1, 0], [1, 1, -2]]) / np.sqrt([3, 2, 6])
    pose = np.eye(4)
    pose[:3, :3], pose[0, 3] = axes.T, 3.3e38
    far = at(-3.3e38)
    scene = pc.Scene("huge")
    scene.add("box", shapes.Hull(3.41e38 * (2.0 * np.indices((2, 2, 2)).reshape(3, 8).T - 1)), pose)
    bodies = [shapes.GeometryObject("hand", "hand", far, shapes.Sphere(3e37)), *scene.bodies]
    checker = pc.Checker(free_link, scene).with_bodies(bodies)
    assert checker.check_states(np.tile([0, 0, 0, 0, 0, 0, 1.0], (8, 1))).all()
    assert checker.statistics()["overlaps"] == 0


@pytest.mark.parametrize(("robot", "scene"), [("baxter", "kitchen"), ("talos", None), ("panda", "cage")])
def test_robots(robot, scene):
    """The same verdicts; most collisions are found by overlaps, in blocks and one by one."""
    robot, scene = pc.Robot.load(robot), None if scene is None else pc.Scene.load(scene)
    q = robot.random_configurations(1003, 5)
    with_overlaps, without = (pc.Checker(robot, scene, tuning=pc.Tuning(overlaps=on)) for on in (True, False))
    truth = without.check_states(q)
    np.testing.assert_array_equal(with_overlaps.check_states(q), truth)
    assert with_overlaps.statistics()["overlaps"] > 0.5 * (~truth).sum()
    np.testing.assert_array_equal([with_overlaps.is_valid(row) for row in q[:100]], truth[:100])
    np.testing.assert_array_equal(with_overlaps.first_colliding_pair(q), without.first_colliding_pair(q))
