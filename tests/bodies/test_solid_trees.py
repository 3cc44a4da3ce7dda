"""Boxes of the trees of triangles hold what is below them, in fractions; and what saves time changes no verdict."""

from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from poses import random_pose
from solid_meshes import inflated, meshes, prepared, ring

from plannercheck.bodies.tuning import pair_options
from plannercheck.common.core import core

SWITCHES = ("boxes", "nearest_first", "lanes", "reaching_out")


def slivers():
    """Triangles that are hardly ones, segments and points, off the axes."""
    rng = np.random.default_rng(4)
    ends = rng.normal(size=(30, 2, 3))
    between = ends[:, 0] + rng.random((30, 1)) * (ends[:, 1] - ends[:, 0])
    between[::3] = ends[::3, 1]
    ends[::9, 1] = ends[::9, 0]
    points = np.concatenate([ends.reshape(-1, 3), between])
    return points, np.array([[2 * k, 2 * k + 1, 60 + k] for k in range(30)])


def surfaces():
    points, triangles = ring(40, 20, 0.4)
    return {**meshes(), "smooth ring": (points, triangles), "far ring": (points + 1e6, triangles), "slivers": slivers()}


def exact(rows):
    return [[Fraction(float(each)) for each in row] for row in rows]


def along(axes, vector):
    """The exact solution t of vector = Σ t_j axes_j."""

    def det(a, b, c):
        return sum(a[i] * (b[i - 2] * c[i - 1] - b[i - 1] * c[i - 2]) for i in range(3))

    whole = det(*axes)
    replaced = [[vector if k == j else axes[k] for k in range(3)] for j in range(3)]
    return [det(*each) / whole for each in replaced]


@pytest.mark.parametrize("name", surfaces())
@pytest.mark.parametrize("scale", [1e-6, 1.0])
def test_boxes_hold_their_triangles(name, scale):
    points, triangles = surfaces()[name]
    solid = core.Solid(np.ascontiguousarray(scale * points), triangles.astype(np.int32))
    frame, boxes, ranges = solid.boxes()
    units, *middle = (Fraction(each) for each in frame.tolist())
    corners = [
        [units * (x - m) for x, m in zip(row, middle, strict=True)]
        for row in exact(solid.points()[solid.triangles()[solid.order()]].reshape(-1, 3))
    ]
    covered = np.zeros(len(triangles), dtype=int)
    chosen = np.random.default_rng(3).permutation(len(boxes))[:150]
    for box, (first, last) in zip(exact(boxes[chosen]), ranges[chosen], strict=True):
        centre, axes, half = box[:3], [box[3:6], box[6:9], box[9:12]], box[12:]
        for corner in corners[3 * first : 3 * min(last, first + 8)]:
            place = along(axes, [x - c for x, c in zip(corner, centre, strict=True)])
            assert all(abs(t) <= h for t, h in zip(place, half, strict=True))
    for first, last in ranges:
        covered[first:last] += 1
    assert (covered >= 2).all()  # the root's and its own


def small_triangles(places, sizes):
    """A triangle of its size at each place (n, 3)."""
    corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.3], [0.0, 1.0, 0.5]])
    points = (places[:, None] + sizes[:, None, None] * corners).reshape(-1, 3)
    return core.Solid(points, np.arange(len(points), dtype=np.int32).reshape(-1, 3))


@pytest.mark.parametrize("few", [24, 160], ids=["every place", "bins"])
def test_groups_that_are_far_apart_have_boxes_of_their_own(few):
    """Even cuts would have groups of 72 and 480 begin within a child."""
    rng = np.random.default_rng(7)
    places = rng.random((4 * few, 3))
    places[3 * few :, 1] += 100
    _, boxes, ranges = small_triangles(places, np.full(len(places), 0.01)).boxes()
    below_root = ranges[:, 1] - ranges[:, 0] < len(places)
    assert boxes[below_root][:, 12:].max() < 0.1


def test_trees_are_not_too_deep():
    """Triangles ever nearer to the middle, of which cuts by surface take a few off at a time."""
    shrinking = 0.8 ** np.arange(1000.0) * np.array([[1.0], [-1.0]])
    shrinking = shrinking.ravel()
    _, _, ranges = small_triangles(np.outer(shrinking, [1.0, 0.5, 0.2]), 0.1 * shrinking).boxes()
    around = [((ranges[:, 0] <= k) & (k < ranges[:, 1])).sum() for k in range(len(shrinking))]
    assert max(around) <= 12  # the root's, a triangle's, and those of ten levels between: TriangleTree::kMostLevels


@pytest.mark.parametrize("name", surfaces())
def test_axes_are_orthonormal_up_to_their_bound(name):
    points, triangles = surfaces()[name]
    axes = core.Solid(np.ascontiguousarray(points), triangles.astype(np.int32)).boxes()[1][:, 3:12].reshape(-1, 3, 3)
    assert np.abs(axes @ axes.transpose(0, 2, 1) - np.eye(3)).max() <= 2.0**-13


def test_boxes_of_small_patches_are_as_thin_as_these():
    """Along their normals they reach by the square of their size; boxes along a frame's axes do by their size."""
    thickness = []
    for around in (40, 160):
        points, triangles = ring(around, around // 2, 0.4)
        _, boxes, ranges = core.Solid(points, triangles.astype(np.int32)).boxes()
        leaves = boxes[(ranges[:, 1] - ranges[:, 0]) == 8][:, 12:]
        thickness.append(np.median(leaves.min(axis=1) / leaves.max(axis=1)))
    assert thickness[1] < thickness[0] / 3


@pytest.mark.parametrize("radius", [0.0, 0.1])
def test_verdicts_do_not_depend_on_switches(radius):
    rng = np.random.default_rng(6)
    every = {name: meshes()[name] for name in ("ring", "fine ring", "hollow box", "one triangle", "small box")}
    bodies = {name: inflated(mesh, radius) if radius else prepared(mesh) for name, mesh in every.items()}
    kinds = set()
    for first, second in product(every, repeat=2):
        for _ in range(3):
            a, b = random_pose(rng, 0.4), random_pose(rng, 0.5)
            asked = bodies[first], a, bodies[second], b
            kind = core.solids_contact(*asked)[0]
            kinds.add(kind)
            for switch in SWITCHES:
                assert core.solids_contact(*asked, **{switch: False})[0] == kind, switch
            assert core.solids_contact(*asked, **dict.fromkeys(SWITCHES, False))[0] == kind
    assert {"apart", "triangles"} <= kinds
    assert radius or len(kinds) > 2


def test_switches_save_what_they_say():
    """Each turned off costs tests that it saves, else it would not be tested here."""
    ring_, small = prepared(ring(30, 12, 0.3)), prepared(ring(20, 8, 0.3))
    aside, over = np.eye(4), np.eye(4)
    aside[:3, 3], over[:3, 3] = (0.9, 0.2, 0.1), (0.0, 0.0, 0.7)
    boxes, triangles, exactly, _ = core.solids_contact(ring_, np.eye(4), small, aside)[3]
    plain = core.solids_contact(ring_, np.eye(4), small, aside, boxes=False)[3]
    assert triangles < plain[1]
    slow = core.solids_contact(ring_, np.eye(4), small, aside, lanes=False)[3]
    assert exactly < slow[2]
    assert boxes <= core.solids_contact(ring_, np.eye(4), small, aside, nearest_first=False)[3][0]
    assert core.solids_contact(ring_, np.eye(4), small, over)[3][3] == 0
    assert core.solids_contact(ring_, np.eye(4), small, over, reaching_out=False)[3][3] > 0


def test_axes_of_boxes_change_no_verdict():
    rng = np.random.default_rng(9)
    every = {name: meshes()[name] for name in ("ring", "fine ring", "hollow box", "small box")}
    bodies = {name: (prepared(mesh), prepared(mesh, own_axes=False)) for name, mesh in every.items()}
    kinds = set()
    for first, second in product(every, repeat=2):
        for _ in range(6):
            a, b = random_pose(rng, 0.4), random_pose(rng, 0.5)
            pairs = zip(bodies[first], bodies[second], strict=True)
            (kind, plain) = (core.solids_contact(p, a, r, b)[0] for p, r in pairs)
            assert kind == plain
            kinds.add(kind)
    assert len(kinds) > 2


def test_axes_of_their_own_save_boxes_of_surfaces_that_nearly_touch():
    """Two links of a chain, whose tubes fill each other's holes but for a hundredth."""
    link, turned = ring(100, 60, 0.49), np.eye(4)
    turned[:3, :3], turned[0, 3] = [[1, 0, 0], [0, 0, -1], [0, 1, 0]], 1.0
    tilted = random_pose(np.random.default_rng(2), 0.0)
    boxes = []
    for own_axes in (True, False):
        body = prepared(link, own_axes)
        kind, _, _, counts = core.solids_contact(body, tilted, body, tilted @ turned)
        assert kind == "apart"
        boxes.append(counts[0])
    assert boxes[0] < boxes[1] / 2


def test_trees_before_hulls_change_no_verdict_of_batches():
    rng = np.random.default_rng(8)
    every, kinds = meshes(), []
    for first, second in product(("fine ring", "nested boxes", "hollow box", "small box"), repeat=2):
        p, r = prepared(every[first]), prepared(every[second])
        poses = np.stack([random_pose(rng, spread) for spread in (0.4, 1.2, 3.0) for _ in range(20)])
        still = np.broadcast_to(np.eye(4), poses.shape).copy()
        verdicts = [
            core.intersect_batch(p, poses, r, still, pair_options(trees_first=each))[0] for each in (True, False)
        ]
        alone = [core.solids_contact(p, pose, r, np.eye(4))[0] for pose in poses]
        assert np.array_equal(verdicts[0], [kind != "apart" for kind in alone])
        assert np.array_equal(verdicts[1], verdicts[0])
        kinds += alone
    assert min(kinds.count(kind) for kind in ("apart", "triangles", "a in b", "b in a")) > 3


def test_solids_as_flat_as_a_billionth_are_not_searched_for_balls_inside():
    """Of `stress --solids`, seed 901, draw 9714: the search took minutes."""
    from plannercheck.evaluation.stress_solids.draws import numbered_draw

    flat = numbered_draw(901, 9714).r.polytope.core
    balls, *_ = flat.inner_shapes()
    assert len(balls) == 0
