"""Proofs about pairs of links: geometry that is known, forgeries, files, and the commands around them."""

import json
from dataclasses import replace

import flint
import numpy as np
import pytest
from pointers import arm, disc

import plannercheck as pc
from plannercheck.checking.collision_matrix import colliding_rows, with_all_joints
from plannercheck.cli.main import main
from plannercheck.motions import pair_proof_builder
from plannercheck.motions.pair_decisions import PairDecider
from plannercheck.motions.pair_proof_builder import pair_proofs, point_near_0, surface_around_0
from plannercheck.proofs import load_pair_proofs, save_pair_proofs, verify_pairs
from plannercheck.proofs.faults import UnprovedError
from plannercheck.proofs.link_pairs import Cell, Overlap
from plannercheck.proofs.overlaps import is_deeper
from plannercheck.proofs.pair_checks import pair_model_confirmed
from plannercheck.proofs.well_formed import hashes_of

INSIDE = 0.1 + 0.05 - 0.03  # the tip begins 3 cm inside of the post's faces


def proofs_of(robot, *links):
    decider = PairDecider(robot)
    proofs = pair_proofs(decider, [decider.decide(*links, 5)], 60)
    assert len(proofs.pairs) == 1
    return proofs


@pytest.fixture(scope="module")
def never(tmp_path_factory):
    return proofs_of(arm(tmp_path_factory.mktemp("never"), 2e-5), "post", "pointer")


@pytest.fixture(scope="module")
def always(tmp_path_factory):
    return proofs_of(disc(tmp_path_factory.mktemp("always"), INSIDE), "post", "tip")


@pytest.fixture(scope="module")
def collides(tmp_path_factory):
    return proofs_of(arm(tmp_path_factory.mktemp("collides"), -1e-4), "post", "pointer")


def fault_of(proofs):
    (found,) = verify_pairs(proofs)
    assert bool(found) == (found.fault is None)
    return found.fault


def test_what_is_known_is_proved(never, always, collides, tmp_path):
    for proofs, answer in ((never, "never"), (always, "always"), (collides, "collides")):
        assert proofs.pairs[0].answer == answer
        assert fault_of(proofs) is None
    (found,) = verify_pairs(never)
    assert found.entries == sum(cell.column < 0 for cell in never.pairs[0].cells) > 10
    turning = proofs_of(arm(tmp_path, 2e-5, "continuous"), "post", "pointer")
    assert fault_of(turning) is None
    assert turning.upper[0] > np.pi
    slid = proofs_of(disc(tmp_path, 0.0, slide=True, height=2 * (3 - 0.01 + 1e-3)), "post", "tip")
    assert slid.pairs[0].answer == "always"
    assert fault_of(slid) is None


def boxes_of(proofs):
    """The boxes of all leaves, (n, columns) each."""
    waiting, found = [(np.array(proofs.lower), np.array(proofs.upper))], []
    for cell in proofs.pairs[0].cells:
        low, high = waiting.pop()
        if cell.column < 0:
            found.append((low, high))
            continue
        below, above = high.copy(), low.copy()
        below[cell.column] = above[cell.column] = cell.value
        waiting += [(above, high), (low, below)]
    return (np.array(side) for side in zip(*found, strict=True))


def test_leaves_tell_the_truth_at_their_corners(never, always, tmp_path):
    rng = np.random.default_rng(0)
    for proofs, robot in ((never, arm(tmp_path, 2e-5)), (always, disc(tmp_path, INSIDE))):
        lows, highs = boxes_of(proofs)
        q = np.where(rng.random((20, *lows.shape)) < 0.5, lows, highs).reshape(-1, lows.shape[1])
        colliding = colliding_rows(with_all_joints(robot), q, proofs.pairs[0].link_a, proofs.pairs[0].link_b)
        assert len(colliding) == (0 if proofs is never else len(q))


def test_files_keep_the_bits(never, always, tmp_path):
    for proofs in (never, always):
        for name in ("a.json", "a.npz"):
            save_pair_proofs(proofs, tmp_path / name)
            read = load_pair_proofs(tmp_path / name)
            assert read.pairs == proofs.pairs
            assert (read.lower, read.upper, read.margin, read.hashes) == (
                proofs.lower,
                proofs.upper,
                proofs.margin,
                proofs.hashes,
            )
            assert hashes_of(read.model) == proofs.hashes
            assert fault_of(read) is None
    document = json.loads((tmp_path / "a.json").read_text())
    for change, why in (({"version": 2}, "version"), ({"pairs": []}, "no pairs"), ({"format": "x"}, "no pair proof")):
        (tmp_path / "b.json").write_text(json.dumps(document | change))
        with pytest.raises(pc.PlannercheckError, match=why):
            load_pair_proofs(tmp_path / "b.json")


def with_pair(proofs, **changes):
    return replace(proofs, pairs=(replace(proofs.pairs[0], **changes),))


def with_cell(proofs, k, **changes):
    cells = list(proofs.pairs[0].cells)
    cells[k] = replace(cells[k], **changes)
    return with_pair(proofs, cells=tuple(cells))


def first_leaf(proofs):
    return next(k for k, cell in enumerate(proofs.pairs[0].cells) if cell.column < 0)


def with_model(proofs, **changes):
    model = replace(proofs.model, **changes)
    return replace(proofs, model=model, hashes=hashes_of(model))


def moved(proofs, name, by):
    """The bodies of a link, lifted."""
    bodies = tuple(
        replace(body, vertices=body.vertices + np.array([0, 0, by])) if body.label == name else body
        for body in proofs.model.bodies
    )
    return with_model(proofs, bodies=bodies)


def with_plane(proofs, **changes):
    k = first_leaf(proofs)
    (plane,) = proofs.pairs[0].cells[k].planes
    return with_cell(proofs, k, planes=(replace(plane, **changes),))


FORGED_NEVER = {
    "no cells": lambda p: with_pair(p, cells=()),
    "a leaf less": lambda p: with_pair(p, cells=p.pairs[0].cells[:-1]),
    "a leaf more": lambda p: with_pair(p, cells=(*p.pairs[0].cells, p.pairs[0].cells[-1])),
    "leaves exchanged": lambda p: with_pair(p, cells=p.pairs[0].cells[::-1]),
    "one leaf for all": lambda p: with_pair(p, cells=(p.pairs[0].cells[first_leaf(p)],)),
    "cut beyond the box": lambda p: with_cell(p, 0, value=4.0),
    "cut at no number": lambda p: with_cell(p, 0, value=float("nan")),
    "cut in a column that does not matter": lambda p: with_cell(p, 0, column=1),
    "cut in a column that there is not": lambda p: with_cell(p, 0, column=7),
    "a leaf without planes": lambda p: with_cell(p, first_leaf(p), planes=()),
    "no direction": lambda p: with_plane(p, direction=(0.0, 0.0, 0.0)),
    "a direction that is none": lambda p: with_plane(p, direction=(0.0, 0.0, float("nan"))),
    "two numbers": lambda p: with_plane(p, direction=(0.0, 1.0)),
    "the other way round": lambda p: with_plane(p, direction=tuple(-x for x in planes_of(p)[0].direction)),
    "bodies exchanged": lambda p: with_plane(p, first=planes_of(p)[0].second, second=planes_of(p)[0].first),
    "a frame elsewhere": lambda p: with_plane(p, frame=3),
    "a body that touches": lambda p: moved(p, "post", 2.1e-5),
    "another answer": lambda p: with_pair(p, answer="always"),
    "an answer that is none": lambda p: with_pair(p, answer="seldom"),
    "one link twice": lambda p: with_pair(p, link_b=p.pairs[0].link_a),
    "a link without bodies": lambda p: with_pair(p, link_b="hub"),
    "a link that there is not": lambda p: with_pair(p, link_b="moon"),
    "limits exchanged": lambda p: replace(p, lower=p.upper, upper=p.lower),
    "limits of no number": lambda p: replace(p, lower=(float("nan"), *p.lower[1:])),
    "too few limits": lambda p: replace(p, lower=p.lower[1:]),
    "a model without its hashes": lambda p: replace(p, model=replace(p.model, bodies=p.model.bodies[::-1])),
    "another margin": lambda p: replace(p, margin=1e-3),
    "a faster joint": lambda p: with_model(
        p, joints=tuple(replace(joint, multipliers=(2.0,)) for joint in p.model.joints)
    ),
}


def planes_of(proofs):
    return proofs.pairs[0].cells[first_leaf(proofs)].planes


@pytest.mark.parametrize("name", FORGED_NEVER)
def test_what_is_not_proved_free_is_refused(never, name):
    assert fault_of(FORGED_NEVER[name](never)) is not None


def with_overlap(proofs, change):
    k = first_leaf(proofs)
    (overlap,) = proofs.pairs[0].cells[k].overlaps
    return with_cell(proofs, k, overlaps=(change(overlap),))


FORGED_ALWAYS = {
    "a facet less": lambda o: replace(o, facets=o.facets[1:]),
    "no facets": lambda o: replace(o, facets=()),
    "a facet turned": lambda o: replace(o, facets=(o.facets[0][::-1], *o.facets[1:])),
    "inside out": lambda o: replace(o, facets=tuple(facet[::-1] for facet in o.facets)),
    "a facet twice": lambda o: replace(o, facets=(o.facets[0], *o.facets)),
    "a corner that there is not": lambda o: replace(o, facets=tuple((a, b, c + 900) for a, b, c in o.facets)),
    "a negative corner": lambda o: replace(o, facets=tuple((a - 400, b - 400, c - 400) for a, b, c in o.facets)),
    "a vertex that there is not": lambda o: replace(o, points=((99, 0), *o.points[1:])),
    "a negative vertex": lambda o: replace(o, points=((-1, 0), *o.points[1:])),
    "one corner for all": lambda o: replace(o, points=(o.points[0],) * len(o.points)),
    "bodies exchanged": lambda o: replace(o, first=o.second, second=o.first),
    "bodies that there are not": lambda o: replace(o, first=7),
}


@pytest.mark.parametrize("name", FORGED_ALWAYS)
def test_what_is_not_proved_to_overlap_is_refused(always, collides, name):
    for proofs in (always, collides):
        assert fault_of(with_overlap(proofs, FORGED_ALWAYS[name])) is not None


def test_overlaps_hold_as_far_as_boxes_reach(always, collides, tmp_path):
    """A leaf of an eighth of the box does not prove all of it; a body that is lifted by its depth is not deep."""
    leaf = always.pairs[0].cells[first_leaf(always)]
    assert fault_of(with_pair(always, cells=(leaf,))) is not None
    decider = PairDecider(disc(tmp_path, INSIDE))
    middle = replace(decider.decide("post", "tip", 5), answer="collides", example=np.zeros(decider.robot.nq))
    at_middle = pair_proofs(decider, [middle], 60)
    assert fault_of(at_middle) is None
    assert fault_of(with_pair(always, cells=at_middle.pairs[0].cells)) is not None
    assert fault_of(with_pair(always, cells=(Cell(),))) is not None
    assert fault_of(with_pair(always, answer="never")) is not None
    assert fault_of(moved(collides, "pointer", 9e-5)) is None
    assert fault_of(moved(collides, "pointer", 1.01e-4)) is not None
    state = collides.pairs[0].state
    assert fault_of(with_pair(collides, state=(9.0, *state[1:]))) is not None
    assert fault_of(with_pair(collides, state=(0.0, *state[1:]))) is not None
    assert fault_of(with_pair(collides, state=state[1:])) is not None
    assert fault_of(with_pair(collides, state=())) is not None


def test_surfaces_are_as_deep_as_hulls_are():
    cube = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
    assert surface_around_0(cube, cube + np.array([1.5, 0, 0]), 0.49) is not None
    assert surface_around_0(cube, cube + np.array([1.5, 0, 0]), 0.51) is None
    assert surface_around_0(cube, cube + np.array([2.5, 0, 0]), 0.0) is None
    flat = cube * [1, 1, 0]
    assert surface_around_0(flat, flat, 0.0) is None


def test_the_model_and_the_limits_are_those_of_the_files(never, tmp_path):
    arm(tmp_path, 2e-5)
    path = str(tmp_path / "arm.urdf")
    assert pair_model_confirmed(never, path)
    cut = replace(never, upper=tuple(2.5 for _ in never.upper))
    assert "may go beyond" in pair_model_confirmed(cut, path).fault
    text = (tmp_path / "arm.urdf").read_text()
    (tmp_path / "arm.urdf").write_text(text.replace('lower="-3"', 'lower="-3.0000001"'))
    assert "may go beyond" in pair_model_confirmed(never, path).fault
    (tmp_path / "arm.urdf").write_text(text.replace("revolute", "continuous"))
    assert pair_model_confirmed(never, path).fault is not None
    arm(tmp_path, 3e-5)
    assert "pointer_0" in pair_model_confirmed(never, path).fault
    robot = arm(tmp_path, 2e-5, "continuous")
    turning = proofs_of(robot, "post", "pointer")
    assert pair_model_confirmed(turning, path)
    short = replace(turning, upper=(np.pi, *turning.upper[1:]), lower=(-np.pi, *turning.lower[1:]))
    assert "may go beyond" in pair_model_confirmed(short, path).fault


def test_pairs_without_a_proof_are_left_out(tmp_path):
    decider = PairDecider(arm(tmp_path, 2e-5))
    free = replace(decider.decide("pointer", "flag", 5), answer="collides", example=np.zeros(decider.robot.nq))
    proofs = pair_proofs(decider, [free, decider.decide("post", "pointer", 5)], 60)
    assert [pair.link_a for pair in proofs.pairs] == ["post"]
    assert fault_of(proofs) is None
    assert pair_model_confirmed(proofs, str(tmp_path / "arm.urdf"))
    fewer = with_model(proofs, pairs=proofs.model.pairs[:1])
    assert "not in the proof" in pair_model_confirmed(fewer, str(tmp_path / "arm.urdf")).fault


def test_commands_write_and_verify(tmp_path, capsys):
    arm(tmp_path, 2e-5)
    robot, srdf, proofs = (str(tmp_path / name) for name in ("arm.urdf", "arm.srdf", "arm.pairs.npz"))
    (tmp_path / "arm.srdf").write_text(
        '<robot name="arm"><disable_collisions link1="post" link2="pointer" reason="Never"/>'
        '<disable_collisions link1="pointer" link2="flag" reason="Never"/></robot>'
    )
    told = str(tmp_path / "told.srdf")
    command = ["acm", "--robot", robot, "--audit", srdf, "--states", "100", "--prove"]
    assert main([*command, "--proofs", proofs, "--output", told]) == 0
    assert "2 proofs written" in capsys.readouterr().out
    assert (tmp_path / "told.srdf").read_text().count("<!-- proved never to collide") == 2
    assert main(["verify", proofs, "--robot", robot]) == 0
    text = capsys.readouterr().out
    assert "2 of 2 pairs of links of 'arm' proved" in text
    assert "'post' and 'pointer': never collide" in text
    assert main(["verify", proofs, "--format", "json"]) == 0
    assert json.loads(capsys.readouterr().out)[0]["pairs"][1]["answer"] == "never"
    assert main(["verify", proofs, "--path", robot]) == 2
    assert "pairs of links" in capsys.readouterr().err
    save_pair_proofs(moved(load_pair_proofs(proofs), "post", 3e-5), proofs)
    assert main(["verify", proofs]) == 1
    assert "not proved: cell" in capsys.readouterr().out
    assert main([*command[:-1], "--proofs", proofs]) == 2
    assert "--prove" in capsys.readouterr().err
    assert main([*command, "--srdf", srdf]) == 2
    assert "both name an SRDF" in capsys.readouterr().err


def wheel(tmp_path, above: float):
    """A ball of 1 mm on an axis, its centre at a height above a box's top; the box is cut where edges cross."""
    path = tmp_path / "wheel.urdf"
    path.write_text(
        '<robot name="wheel"><link name="box"><collision><geometry><box size="0.2 0.1 0.06"/></geometry></collision>'
        '</link><joint name="turn" type="revolute"><parent link="box"/><child link="ball"/><axis xyz="0.6 0 0.8"/>'
        f'<origin xyz="0.01 0.02 {0.03 + above}"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>'
        '<link name="ball"><collision><geometry><sphere radius="0.001"/></geometry></collision></link></robot>'
    )
    return pc.Robot.from_urdf(path)


@pytest.mark.parametrize("above", [0.0, 5e-9, 9.99e-4, -5e-4, -0.02])
def test_radii_count_for_overlaps(tmp_path, above):
    """TIAGo's fingers are such balls: their centres are next to the faces that hold them."""
    proofs = proofs_of(wheel(tmp_path, above), "box", "ball")
    assert proofs.pairs[0].answer == "always"
    assert fault_of(proofs) is None
    assert bool(proofs.pairs[0].cells[0].overlaps[0].weights)
    save_pair_proofs(proofs, tmp_path / "a.npz")
    assert load_pair_proofs(tmp_path / "a.npz").pairs == proofs.pairs


FORGED_MEANS = {
    "a weight less": lambda o: replace(o, weights=o.weights[1:]),
    "a weight more": lambda o: replace(o, weights=(*o.weights, 1.0)),
    "a negative weight": lambda o: replace(o, weights=(-1.0, *o.weights[1:])),
    "no weight": lambda o: replace(o, weights=(0.0, *o.weights[1:])),
    "a weight that is no number": lambda o: replace(o, weights=(float("nan"), *o.weights[1:])),
    "an endless weight": lambda o: replace(o, weights=(float("inf"),) * len(o.weights)),
    "triangles, too": lambda o: replace(o, facets=((0, 1, 2), (2, 1, 0))),
    "neither": lambda o: replace(o, weights=()),
    "another mean": lambda o: replace(o, weights=(9.0, *o.weights[1:])),
    "a vertex that there is not": lambda o: replace(o, points=((9, 9), *o.points[1:])),
}


@pytest.mark.parametrize("name", FORGED_MEANS)
def test_means_that_show_nothing_are_refused(tmp_path, name):
    proofs = proofs_of(wheel(tmp_path, 9.99e-4), "box", "ball")
    assert fault_of(proofs) is None
    assert fault_of(with_overlap(proofs, FORGED_MEANS[name])) is not None
    body = next(k for k, each in enumerate(proofs.model.bodies) if each.radius > 0)
    bodies = list(proofs.model.bodies)
    bodies[body] = replace(bodies[body], radius=bodies[body].radius * 0.998)
    assert fault_of(with_model(proofs, bodies=tuple(bodies))) is not None


def test_corners_in_a_row_leave_no_sliver():
    """Of two links of TIAGo's ring finger a surface has a triangle of 1e-18 m2: it has no plane in ball arithmetic."""
    robot = pc.Robot.load("tiago")
    proofs = proofs_of(robot, "hand_ring_virtual_3_link", "hand_ring_flex_3_link")
    assert proofs.pairs[0].answer == "collides"
    assert fault_of(proofs) is None


def test_points_near_0_are_as_near_as_hulls_are():
    rng = np.random.default_rng(1)
    for _ in range(50):
        first, second = rng.normal(size=(12, 3)), rng.normal(size=(9, 3)) + np.array([4.0, 0, 0])
        apart = pc.distance(pc.Polytope(first), pc.Polytope(second)).distance
        points, _, weights = point_near_0(first, second, apart * 1.0001) or pytest.fail("no point")
        mean = np.average([first[a] - second[b] for a, b in points], axis=0, weights=weights)
        assert apart * 0.999999 < np.linalg.norm(mean) < apart * 1.0001
        assert min(weights) > 0
        assert point_near_0(first, second, apart * 0.9999) is None


def test_the_search_for_a_point_near_0_ends_where_rounding_takes_the_new_corner_out_again(monkeypatch):
    """Named case: the test above never ended with NumPy 2.5, which rounds otherwise than 2.4."""
    forgetful = [(np.arange(1), np.ones(1))] * 9
    monkeypatch.setattr(pair_proof_builder, "_next_to_0", lambda points, weights: forgetful.pop())
    rng = np.random.default_rng(1)
    first, second = rng.normal(size=(12, 3)), rng.normal(size=(9, 3)) + np.array([4.0, 0, 0])
    assert point_near_0(first, second, 1e-3) is None


@pytest.fixture
def still():
    bits, flint.ctx.prec = flint.ctx.prec, 64
    yield flint.arb_mat(4, 4, [int(k % 5 == 0) for k in range(16)])
    flint.ctx.prec = bits


def test_a_needle_that_points_at_0_is_not_around_it(still):
    """Its planes pass 0 by 2 mm, its tip by 5 cm: radii of 4 mm do not reach."""
    needle = np.array([[0.05, 0, 0], [1.05, 0.04, 0], [1.05, -0.02, 0.035], [1.05, -0.02, -0.035]])
    hull = pc.Polytope(needle)
    rows = [int(np.flatnonzero((needle == vertex).all(axis=1))[0]) for vertex in hull.vertices]
    surface = Overlap(0, 1, tuple((k, 0) for k in rows), tuple(tuple(map(int, facet)) for facet in hull.faces))
    origin = np.zeros((1, 3))
    assert not is_deeper(surface, (needle, still), (origin, still), 1e-9, (0.004, 0.0))
    assert is_deeper(surface, (needle, still), (origin + np.array([1.0, 0, 0]), still), 1e-9, (0.004, 0.0))


def test_means_lie_between_their_corners(still):
    """By weights below 0 a point 1 cm beyond a segment is a mean of its ends."""
    segment, point = np.array([[0.0, 0, 0], [1, 0, 0]]), np.array([[1.01, 0, 0]])
    beyond = Overlap(0, 1, ((0, 0), (1, 0)), weights=(-0.01, 1.01))
    with pytest.raises(UnprovedError, match="weights"):
        is_deeper(beyond, (segment, still), (point, still), 1e-9, (0.001, 0.001))
    inside = replace(beyond, weights=(0.25, 0.75))
    assert is_deeper(inside, (segment, still), (point - [0.2605, 0, 0], still), 1e-9, (0.001, 0.0))
    assert not is_deeper(inside, (segment, still), (point - [0.262, 0, 0], still), 1e-9, (0.001, 0.0))
