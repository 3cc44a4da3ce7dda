"""The solids of the stress: closed or open as they are said to be, right side out, on the lattice; and their poses."""

import numpy as np
import pytest

from plannercheck import _oracle
from plannercheck.evaluation.stress_solids import placing, variations
from plannercheck.evaluation.stress_solids.bodies import CONVEX_FAMILIES, Body, decided, random_convex
from plannercheck.evaluation.stress_solids.common_frames import PARTNERS
from plannercheck.evaluation.stress_solids.draws import FAMILY_NAMES, draw, numbered_draw
from plannercheck.evaluation.stress_solids.placing import OFFSETS, Place, around_contact, turn
from plannercheck.evaluation.stress_solids.solid_families import LATTICE_FAMILIES, SOLID_FAMILIES
from plannercheck.evaluation.stress_solids.surfaces import Surface, ball, octahedron

OPEN = {"triangle soup", "Klein bottle", "terrain"}
# With an outside everywhere, so that the signed volume is that of the solid.
OUTWARD = {"heap of cells", "comb", "square ring", "torus", "chain", "spring", "screw", "bowl", "star", "spikes"}


def oracles(surface: Surface) -> _oracle.Mesh:
    return _oracle.Mesh(surface.points, surface.triangles, 0.0)


def volume(surface: Surface) -> float:
    a, b, c = (surface.points[surface.triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


@pytest.mark.parametrize("name", SOLID_FAMILIES)
@pytest.mark.parametrize("n", [12, 60, 700])
def test_families_are_what_they_say(name: str, n: int) -> None:
    for seed in range(3):
        found = SOLID_FAMILIES[name](n, np.random.default_rng(seed))
        assert found.points.dtype == np.float64
        assert found.triangles.dtype == np.int32
        assert np.isfinite(found.points).all()
        mesh = oracles(found)  # refuses indices that are none
        if name not in {"one triangle", "robot mesh"}:
            assert mesh.is_closed == (name not in OPEN)
            assert len(found.triangles) < 4 * n + 200
            assert 0.3 < np.ptp(found.points, axis=0).max() < 1.6
        if name in OUTWARD:
            assert volume(found) > 0
        if name in LATTICE_FAMILIES:
            assert (found.points * 2.0**10 % 1 == 0).all()


def test_families_have_the_insides_that_they_are_for() -> None:
    """A cavity, a middle that is wound around twice, halves of either sign, and rings through each other's holes."""
    middle = np.zeros(3)
    rng = np.random.default_rng(1)
    shells = {oracles(SOLID_FAMILIES["nested boxes"](48, rng)).winding_number(middle, False) for _ in range(8)}
    assert 0 in shells
    assert oracles(SOLID_FAMILIES["star"](20, rng)).winding_number(np.array([0.01, 0.02, 0.03]), False) == 2
    eight = oracles(SOLID_FAMILIES["figure of eight"](400, rng))
    around = [eight.winding_number(np.array([0.3 + x, 0.001, z]), False) for x in (-0.14, 0.14) for z in (-0.05, 0.05)]
    assert {-1, 1} <= set(around)
    assert oracles(SOLID_FAMILIES["chain"](300, rng)).components > 1
    assert not oracles(SOLID_FAMILIES["Klein bottle"](300, rng)).is_closed


def test_variations_do_what_they_say() -> None:
    body, rng, middle = ball(60), np.random.default_rng(2), np.array([0.01, 0.02, 0.03])
    closed = {name: oracles(change(body, rng)).is_closed for name, change in variations.VARIATIONS.items()}
    assert not closed["opened"]
    assert all(closed[name] for name in ("inverted", "doubled", "separate", "with needles", "flattened", "shuffled"))
    assert oracles(variations.inverted(body, rng)).winding_number(middle, False) == -1
    wound = {oracles(variations.doubled(body, rng)).winding_number(middle, False) for _ in range(8)}
    assert wound == {0, 2}
    assert {oracles(variations.split(body, rng)).is_closed for _ in range(12)} == {True, False}
    assert {oracles(variations.with_repeats(body, rng)).is_closed for _ in range(12)} == {True, False}
    names = {variations.varied(body, rng)[1] for _ in range(300)}
    assert {"", *(f" {name}" for name in variations.VARIATIONS)} <= names


@pytest.mark.parametrize("family", CONVEX_FAMILIES)
def test_convex_bodies_are_their_surfaces(family: str) -> None:
    """What the core takes as a hull is what the oracle takes as a closed mesh, right side out."""
    for seed in range(5):
        body = random_convex(family, 40, 2.0, np.random.default_rng(seed))
        assert body.truth.is_closed
        if family not in {"segment", "point"}:
            assert volume(body.surface) > 0
            assert sorted(map(tuple, body.polytope.vertices)) == sorted(map(tuple, body.surface.used_points))


def test_contacts_are_the_last_shared_place_and_the_next_one_free() -> None:
    rng, seen = np.random.default_rng(3), 0
    ring = Body("square ring", SOLID_FAMILIES["square ring"](60, rng))
    for _ in range(12):
        place = Place(turn("axis-aligned", rng), np.eye(4))
        poses_p, poses_r = around_contact(ring, ring, place, rng)
        shared = dict(zip(OFFSETS, decided(ring, poses_p, ring, poses_r) != 0, strict=True))
        if shared["0"]:
            seen += not shared["next"]
            touching = poses_p[list(OFFSETS).index("0"), :3, 3]
            assert (touching * 2.0**10 % 1 == 0).sum() >= 1
    assert seen > 8


def test_bodies_of_one_frame_touch_at_any_pose() -> None:
    """Cells of one lattice share corners, which no pose of both takes from them."""
    for seed in range(10):
        rng = np.random.default_rng(seed)
        p, r = (Body("cells", surface) for surface in PARTNERS["neighbouring cells"](60, rng))
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = turn("random", rng), rng.normal(size=3)
        aside = pose.copy()
        aside[:3, 3] += 3
        shares_corner = bool({tuple(x) for x in p.surface.points} & {tuple(x) for x in r.surface.points})
        found = decided(p, np.stack([pose, aside]), r, np.stack([pose, pose]))
        assert found[0] == 1 or not shares_corner
        assert found[1] == 0


def test_a_filling_box_is_in_its_cavity() -> None:
    """It touches the walls where there is no room, and is free where there is some on all sides."""
    seen = set()
    for seed in range(30):
        p, r = (Body("box", surface) for surface in PARTNERS["in a cavity"](12, np.random.default_rng(seed)))
        low, high = p.surface.points.min(axis=0), p.surface.points.max(axis=0)
        is_free = bool((low > -0.25).all() and (high < 0.25).all())
        assert decided(p, np.eye(4)[None], r, np.eye(4)[None])[0] == (0 if is_free else 1)
        seen.add(is_free)
    assert seen == {True, False}


def test_draws_can_be_made_again_and_are_of_all_families() -> None:
    families = set()
    for number in range(60):
        drawn, again = (numbered_draw(7, number) for _ in range(2)) if number < 4 else (numbered_draw(7, number),) * 2
        assert drawn.label == again.label
        np.testing.assert_array_equal(drawn.poses_p, again.poses_p)
        assert len(drawn.poses_p) == len(drawn.poses_r) == len(drawn.offsets)
        families.add(drawn.family)
    assert families <= set(FAMILY_NAMES)
    assert len(families) > 15


def test_draws_share_points_in_half_of_the_cases_and_lie_inside_in_some() -> None:
    reasons: list[int] = []
    for number in range(100):
        drawn = draw(np.random.default_rng([11, number]))
        reasons += decided(drawn.p, drawn.poses_p, drawn.r, drawn.poses_r).tolist()
    shares = np.bincount(reasons, minlength=5) / len(reasons)
    assert 0.3 < shares[0] < 0.7
    assert (shares[1:] > 0.002).all()


def test_rotations_are_rotations() -> None:
    for name in placing.ROTATIONS:
        found = turn(name, np.random.default_rng(4))
        np.testing.assert_allclose(found @ found.T, np.eye(3), atol=1e-9)
        assert np.linalg.det(found) > 0
    assert (octahedron().points ** 2).sum(axis=1).tolist() == [0.25] * 6
