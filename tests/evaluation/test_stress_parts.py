"""A sample of the stress of sets of parts, what it counts and keeps. `plannercheck stress --parts` runs more of it."""

import math
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.bodies import exact_reference
from plannercheck.bodies.posed_half_spaces import PosedHalfSpace
from plannercheck.evaluation.campaign.campaign import run
from plannercheck.evaluation.campaign.cases import load, save
from plannercheck.evaluation.campaign.pairs import PairCase, smaller
from plannercheck.evaluation.campaign.posed_pairs import UNFIT
from plannercheck.evaluation.campaign.tallies import Tally, total
from plannercheck.evaluation.stress.random_cases import GAPS
from plannercheck.evaluation.stress_parts import campaign as stress
from plannercheck.evaluation.stress_parts import judges
from plannercheck.evaluation.stress_parts.bodies import Body
from plannercheck.evaluation.stress_parts.campaign import MOTION_DRAWS, MOTIONS, campaign
from plannercheck.evaluation.stress_parts.draws import OTHERS, WITH_HALF_SPACE, Draw, least_excess, numbered_draw
from plannercheck.evaluation.stress_parts.ellipsoid_truth import decide_ellipsoids
from plannercheck.evaluation.stress_parts.given import Balls, Cells, Columns, Given, Hull, Mesh, Oval, Under
from plannercheck.evaluation.stress_parts.half_space_placing import lowered
from plannercheck.evaluation.stress_parts.motions import FREE, MISSED, REFUSED, judge_motions, shape_of
from plannercheck.evaluation.stress_parts.set_families import SETS, random_set
from plannercheck.evaluation.stress_parts.truth import decide

SAMPLE = 2000  # pairs


SUITE = campaign(2028)
SUITES = {"parts": lambda: SUITE}


@pytest.fixture(scope="module")
def tally() -> Tally[PairCase[Body]]:
    return run(SUITE, SAMPLE)


def test_nothing_fails_on_a_sample(tally: Tally[PairCase[Body]]) -> None:
    assert tally.failures == 0, "\n".join(SUITE.lines(tally))
    assert not tally.cases
    assert tally.judged >= SAMPLE


def test_every_way_of_asking_was_asked(tally: Tally[PairCase[Body]]) -> None:
    unasked = UNFIT
    asked = {who: total(tally.counts, who=who) - total(tally.counts, who=who, outcome=unasked) for who in judges.OURS}
    assert asked["batch"] == asked["swapped"] == asked["shuffled"] == tally.judged
    assert min(asked.values()) > 10


def test_the_tables_count_every_pair(tally: Tally[PairCase[Body]]) -> None:
    sums = [line.split() for line in SUITE.lines(tally) if line.startswith("all")]
    assert len(sums) == 3
    assert sum(map(int, sums[2][1:])) == total(tally.counts, who=MOTIONS) > 0
    for each in sums[:2]:
        assert each[1:] == [str(tally.judged), sums[0][2], "0", "0", "0"]


def test_the_shares_of_other_bodies_add_up() -> None:
    assert sum(other.share for other in OTHERS.values()) == pytest.approx(1)


@pytest.mark.parametrize("family", list(SETS))
def test_pieces_are_the_parts_of_the_core(family: str) -> None:
    """Corners and radii, bit for bit, whichever way both were computed."""
    for seed in range(5):
        body = random_set(family, 20, 10.0 ** (seed - 2), np.random.default_rng(seed))
        parts, padding = body.polytope.parts, body.given.padding
        ours = sorted((sorted(map(tuple, piece.corners.tolist())), piece.radius) for piece in body.pieces)
        found = (parts.part(place)[:2] for place in range(parts.places))
        theirs = [(sorted(map(tuple, each.tolist())), radius + padding) for each, radius in found if len(each)]
        assert ours == sorted(theirs)


def test_the_truth_is_that_of_integers() -> None:
    """With and without the pieces that are left out, against arithmetic in Python."""
    shared = 0
    for number in range(12):
        drawn = numbered_draw(31, number)
        if not drawn.r.pieces or len(drawn.p.pieces) * len(drawn.r.pieces) > 60 or len(drawn.r.corners) > 60:
            continue
        some = slice(number % 5, None, 9)
        found = decide(drawn.p, drawn.poses_p[some], drawn.r, drawn.poses_r[some])
        for verdict, at, there in zip(found, drawn.poses_p[some], drawn.poses_r[some], strict=True):
            expected = any(
                exact_reference.intersects(p.corners, r.corners, at, there, p.radius, r.radius)
                for p in drawn.p.pieces
                for r in drawn.r.pieces
            )
            assert verdict == expected
            shared += expected
    assert shared > 5


def test_the_truth_over_half_spaces_is_that_of_fractions(monkeypatch: pytest.MonkeyPatch) -> None:
    """With and without the corners that are left out, corner by corner."""
    for name, other in OTHERS.items():
        monkeypatch.setitem(OTHERS, name, other._replace(share=float(name == WITH_HALF_SPACE)))
    counts = [0, 0]
    for number in range(14):
        drawn = numbered_draw(8, number)
        under = drawn.r.half_space
        assert under is not None
        if len(drawn.p.corners) > 60:
            continue
        some = slice(number % 5, None, 6)
        poses, poses_under = drawn.poses_p[some], drawn.poses_r[some]
        found = decide(drawn.p, poses, drawn.r, poses_under)
        np.testing.assert_array_equal(found, decide(drawn.p, poses, drawn.r, poses_under, every=True))
        for verdict, pose, pose_under in zip(found, poses, poses_under, strict=True):
            plane = PosedHalfSpace(under.normal, under.offset, pose_under, under.padding)
            expected = any(is_within(plane, *ball, pose) for ball in zip(drawn.p.corners, drawn.p.radii, strict=True))
            assert verdict == expected
            counts[expected] += 1
    assert min(counts) > 5


def is_within(plane: PosedHalfSpace, corner: np.ndarray[Any, Any], radius: float, pose: np.ndarray[Any, Any]) -> bool:
    """Whether a ball about a corner shares a point with a half-space, in fractions."""
    x, y, z = (
        sum((Fraction(m) * Fraction(c) for m, c in zip(row[:3], corner.tolist(), strict=True)), Fraction(row[3]))
        for row in pose[:3].tolist()
    )
    normal, height = plane.plane()[0], plane.height((x, y, z))
    reach = Fraction(float(radius)) + Fraction(plane.inflation_radius)
    return height <= 0 or height**2 <= reach**2 * sum(g * g for g in normal)


@pytest.mark.parametrize("padding", [0.0, 0.5])
def test_an_ellipsoid_is_told_from_the_next_double_over_a_plane(padding: float) -> None:
    """Of radii 1, 1, 2 along (3, 4, 0): it reaches 5, and 5 times its padding more."""
    oval, reach = Body("", Oval(padding, np.array([1.0, 1.0, 2.0]), 0.5)), 5 + 5 * padding
    for offset, shared in ((-reach, True), (np.nextafter(-reach, -9), False), (0.0, True), (1.0, True), (-20, False)):
        under = Body("", Under(0.0, np.array([3.0, 4.0, 0.0]), float(offset)))
        found = decide_ellipsoids(oval, np.eye(4)[None], under, np.eye(4)[None])
        assert found is not None
        assert found.tolist() == [shared]


def test_an_ellipsoid_is_told_from_the_next_double_at_a_point() -> None:
    oval, pose = Body("", Oval(0.0, np.array([3.0, 2.0, 1.0]), 0.5)), np.eye(4)
    pose[:3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]  # its x along the world's y
    for place, shared in (
        ((0, 3, 0), True),
        ((0, math.nextafter(3, 4), 0), False),
        ((-2, 0, 0), True),
        ((3, 0, 0), False),
    ):
        point = Body("", Balls(0.0, np.array([place], dtype=np.float64), np.zeros(1)))
        found = decide_ellipsoids(point, np.eye(4)[None], oval, pose[None])
        assert found is not None
        assert found.tolist() == [shared]
        ball = Body("", Balls(0.0, np.zeros((1, 3)), np.ones(1)))
        assert decide_ellipsoids(ball, np.eye(4)[None], oval, pose[None]) is None


@pytest.mark.parametrize(("factor", "is_right"), [(1.0, True), (1 + 1e-9, False)])
def test_an_inner_polytope_that_sticks_out_is_found(
    factor: float, is_right: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By a billionth, laid on a plane by a corner."""
    told = pc.Ellipsoid.inner
    monkeypatch.setattr(pc.Ellipsoid, "inner", lambda self: (told(self)[0] * factor, told(self)[1]))
    drawn = ellipsoid_on_a_plane()
    truth = decide(drawn.p, drawn.poses_p, drawn.r, drawn.poses_r).tolist()
    assert (judges._between(drawn, truth, "oracle") == truth) == is_right


@pytest.mark.parametrize(("factor", "is_right"), [(1.0, True), (0.5, False)])
def test_an_outer_polytope_that_is_too_small_is_found(
    factor: float, is_right: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    told = pc.Ellipsoid.vertices_and_faces
    monkeypatch.setattr(pc.Ellipsoid, "vertices_and_faces", lambda self: (told(self)[0] * factor, told(self)[1]))
    drawn = ellipsoid_on_a_plane()
    truth = decide(drawn.p, drawn.poses_p, drawn.r, drawn.poses_r).tolist()
    assert (judges._between(drawn, truth, "oracle") == truth) == is_right


def ellipsoid_on_a_plane() -> Draw:
    """Its inner polytope at each gap over the ground."""
    oval, ground = (
        Body("", Oval(0.0, np.array([0.3, 0.2, 0.1]), least_excess(0.5))),
        Under(0.0, np.array([0.0, 0.0, 1.0]), 0.0),
    )
    poses = np.tile(np.eye(4), (len(GAPS), 1, 1))
    assert oval.inner is not None
    on_plane = lowered(oval.inner, poses, ground, poses, 0.1)
    return Draw("", "", oval, Body("", ground), on_plane, poses, tuple(GAPS))


def test_motions_that_meet_a_set_and_are_passed_are_missed(monkeypatch: pytest.MonkeyPatch) -> None:
    refused = judge_motions(4, 1)
    assert {outcome for _, outcome in refused if refused[_, outcome]} == {FREE, REFUSED}
    monkeypatch.setattr(pc.Checker, "check_motions", lambda self, start, end: np.ones(len(start), dtype=bool))
    missed = judge_motions(4, 1)
    assert missed.total() == refused.total()
    assert sum(missed[key] for key in missed if key[1] == MISSED) > 0
    tally = Tally[PairCase[Body]]()
    stress._motions(4, MOTION_DRAWS, tally)
    assert tally.failures == total(tally.counts, outcome=MISSED) > 0


def test_sets_that_are_too_far_away_for_motions_are_left_out() -> None:
    assert judge_motions(1, 1440).total() == 0


@pytest.mark.parametrize("family", list(SETS))
def test_shapes_of_users_have_the_same_parts(family: str) -> None:
    body = random_set(family, 30, 1.0, np.random.default_rng(3))
    ours, theirs = body.polytope.parts, shape_of(body.given).core
    assert ours.places == theirs.places
    for place in range(ours.places):
        for one, other in zip(ours.part(place), theirs.part(place), strict=True):
            np.testing.assert_array_equal(one, other)


def padded_clouds(gap: float) -> tuple[pc.Polytope, pc.Polytope, np.ndarray[Any, Any]]:
    """Two balls each, whose radii and padding add up to 1.2 m, their nearest centres 1.2 m and a gap apart."""
    made = (Balls(0.5, np.array([[0.0, 0.0, 0.0], [sign * 3.0, 0.0, 0.0]]), np.array([0.1])) for sign in (-1, 1))
    pose = np.eye(4)
    pose[0, 3] = 1.2 + gap
    p, r = (given.prepare() for given in made)
    return p, r, pose


def test_padded_sets_meet_where_their_parts_do() -> None:
    for gap, shared in ((-1e-9, True), (1e-9, False), (-0.3, True), (0.3, False)):
        p, r, pose = padded_clouds(gap)
        ball = pc.Polytope([[0.0, 0.0, 0.0]], inflation_radius=0.6)
        assert pc.intersects(p, r, np.eye(4), pose) == shared
        assert pc.intersects(p, ball, np.eye(4), pose) == shared


def test_padded_sets_are_as_far_as_their_nearest_parts() -> None:
    """The padding is as large as the gaps between boxes of the tree."""
    rng = np.random.default_rng(7)
    for _ in range(60):
        given = Balls(1.5, rng.normal(size=(60, 3)), np.array([1e-3]))
        direction = rng.normal(size=3)
        point = 6.5 * direction / np.linalg.norm(direction)
        least = np.linalg.norm(given.points - point, axis=1).min() - (1.5 + 1e-3)
        found = pc.distance(given.prepare(), pc.Polytope(point[None]))
        assert found.distance == pytest.approx(least, rel=1e-8)
        assert least * (1 - 1e-8) <= found.lower_bound <= least * (1 + 1e-8)


def apart_and_touching() -> Draw:
    """A ball and a cell, 1 m apart and in contact."""
    ball = Body("ball", Balls(0.0, np.zeros((1, 3)), np.ones(1)))
    cell = Body("cell", Cells(0.0, np.array([[2, 0, 0]]), np.ones(1), 1.0, np.zeros(3)))
    poses = np.tile(np.eye(4), (2, 1, 1))
    poses[1, 0, 3] = 1.0
    return Draw("ball", "", ball, cell, poses, np.tile(np.eye(4), (2, 1, 1)), ("any",) * 2)


def test_distances_that_are_wrong_are_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """A millionth too long or short, a lower bound above it, 0 where nothing is shared and the other way round."""
    drawn, truth, told = apart_and_touching(), [False, True], judges.distance
    number = judges.MEASURED_DRAWS // 2
    assert judges._distances(drawn, truth, [0, 1], number) == truth
    for change in (
        lambda d: replace(d, distance=d.distance * (1 + 1e-6)),
        lambda d: replace(d, distance=d.distance * (1 - 1e-6), lower_bound=0.0),
        lambda d: replace(d, lower_bound=d.lower_bound + 1e-6),
        lambda d: replace(d, distance=0.0 if d.distance else 1.0),
    ):
        monkeypatch.setattr(judges, "distance", lambda *a, change=change: change(told(*a)))
        assert judges._distances(drawn, truth, [0], number)[0] != truth[0]


def test_distances_of_solids_over_a_plane_are_judged() -> None:
    corners = np.vstack([np.zeros(3), np.eye(3)])
    solid = Body("", Mesh(0.1, corners, np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])))
    poses = np.tile(np.eye(4), (2, 1, 1))
    poses[1, 2, 3] = 0.2
    ground = Body("", Under(0.0, np.array([0.0, 0.0, 2.0]), 0.0))
    drawn = Draw("", "", solid, ground, poses, np.tile(np.eye(4), (2, 1, 1)), ("any",) * 2)
    truth = decide(drawn.p, drawn.poses_p, drawn.r, drawn.poses_r).tolist()
    assert truth == [True, False]
    assert judges._distances(drawn, truth, [0, 1], judges.MEASURED_DRAWS // 2) == truth


def of_all_kinds() -> list[Given]:
    third, rng = 1 / 3, np.random.default_rng(1)
    heights = rng.random((3, 4))
    heights[1, 2] = np.nan
    corners = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
    return [
        Balls(third, rng.random((5, 3)), rng.random(5)),
        Cells(0.0, np.array([[1, 2, 3], [-4, 5, 6]]), np.array([1, 4]), third, np.array([0.1, 0.2, 0.3])),
        Columns(0.0, heights, np.array([third, 0.1]), np.zeros(2), -third),
        Hull(0.1, corners * third),
        Mesh(0.0, corners, pc.Polytope(corners).faces),
        Under(third, np.array([third, -2.0, 1e-9]), -third),
        Oval(third, np.array([third, 1.0, 0.1]), 0.5),
    ]


@pytest.mark.parametrize("given", of_all_kinds(), ids=lambda given: given.kind)
def test_a_case_keeps_every_bit(given: Given, tmp_path: Path) -> None:
    pose = np.eye(4)
    pose[0, 3] = 1e-17 / 3
    case = PairCase("a name", Body("", of_all_kinds()[0]), Body("", given), pose, np.eye(4))
    save(tmp_path / "case.json", "parts", case.document())
    _, again = load(tmp_path / "case.json", SUITES)
    assert (again.name, type(again.r.given)) == ("a name", type(given))
    for name, value in vars(given).items():
        np.testing.assert_array_equal(value, getattr(again.r.given, name))
    for ours, theirs in zip(given.pieces(), again.r.pieces, strict=True):
        np.testing.assert_array_equal(ours.corners, theirs.corners)
    np.testing.assert_array_equal(case.pose_p, again.pose_p)
    assert SUITE.faults(again) == {}


def test_files_that_hold_no_case_are_refused(tmp_path: Path) -> None:
    of_parts = '{"campaign": "parts"'
    for text in (of_parts + "}", of_parts + ', "p": {"kind": "none"}}', "[]", of_parts + ', "p": 3}'):
        (tmp_path / "none.json").write_text(text)
        with pytest.raises(pc.PlannercheckError, match="no case of a stress"):
            load(tmp_path / "none.json", SUITES)


@pytest.mark.parametrize("given", of_all_kinds()[:3], ids=lambda given: given.kind)
def test_a_failure_is_shrunk_to_the_parts_that_it_takes(given: Given) -> None:
    """Taken for failing while a part comes close to its middle: that part is left."""
    middle = given.pieces()[1].centre

    def fails(tried: PairCase[Body]) -> bool:
        return any(np.linalg.norm(piece.centre - middle) < 1e-9 for piece in tried.p.pieces)

    case = PairCase("", Body("", given), Body("", Hull(0.0, np.zeros((1, 3)))), np.eye(4), np.eye(4))
    left = smaller(case, fails)
    assert fails(left)
    assert len(left.p.pieces) == 1
