"""Proofs of motions before sets of parts: each part counts, and what is changed beyond its slack is refused."""

from __future__ import annotations

import itertools
import warnings
from dataclasses import replace
from fractions import Fraction

import flint
import numpy as np
import pytest
from flint import arb, arb_mat
from proof_cases import CUBE, STILL, at, claim, point, turn

import plannercheck as pc
from plannercheck.cli.main import main
from plannercheck.motions import part_covers
from plannercheck.proofs import Entry, Joint, PosedBody, load_proofs
from plannercheck.proofs.data import WORLD
from plannercheck.proofs.entries import EntryChecker
from plannercheck.proofs.faults import UnprovedError
from plannercheck.proofs.nesting import check_not_nested
from plannercheck.proofs.parts import part_count, parts_of
from plannercheck.proofs.verify import model_confirmed
from plannercheck.proofs.well_formed import hashes_of

START = np.array([0, -0.785, 0, -2.356, 0, 1.571, 0.785])
END = START + np.array([0.3, 0.1, 0, 0.1, 0, 0, 0])


def shell(count, seed=4):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(count, 3))
    return 1.2 * points / np.linalg.norm(points, axis=1)[:, None] + [0, 0, 0.4]


def hollow():
    full = np.zeros((20, 20, 16), dtype=bool)
    full[[0, -1]] = full[:, [0, -1]] = full[:, :, [-1]] = True
    return full


def valley():
    heights = np.full((20, 20), -0.5)
    heights[0] = heights[:, -1] = 1.5
    heights[3, 4] = np.nan
    return heights


SETS = {
    "balls": lambda: pc.PointCloud(shell(300), np.random.default_rng(1).uniform(0.005, 0.03, 300)),
    "one radius": lambda: pc.PointCloud(shell(200), 0.01),
    "boxes": lambda: pc.VoxelGrid(hollow(), 0.1, (-1, -1, 0.2)),
    "leaves": lambda: pc.Octree.from_cells(np.unique(np.floor(shell(200) / 0.06).astype(int), axis=0), 0.06),
    "prisms": lambda: pc.HeightField(valley(), 0.1, -1, (-1, -1)),
}


def tilted():
    pose = np.eye(4)
    pose[:3, :3] = [[np.cos(0.02), 0, np.sin(0.02)], [0, 1, 0], [-np.sin(0.02), 0, np.cos(0.02)]]
    pose[:3, 3] = 0.02, 0.01, 0.03
    return pose


def scene_of(shape):
    scene = pc.Scene("sensed")
    scene.add("camera", shape, tilted())
    return scene


@pytest.fixture(scope="module")
def panda():
    return pc.Robot.load("panda")


@pytest.fixture(scope="module", params=SETS)
def case(request, panda):
    """A shape, and the proof of a motion before it."""
    shape = SETS[request.param]()
    (proof,) = pc.Checker(panda, scene_of(shape)).certify_motions(START[None], END[None])
    return shape, proof


def replaced(proof, **changes):
    fields = ("kind", "robot", "scene", "hashes", "model", "motion", "margin", "entries")
    return type(proof)(*(changes.get(name, getattr(proof, name)) for name in fields))


def with_set(proof, **changes):
    """A proof whose set is another one, with hashes that fit."""
    bodies = tuple(replace(body, **changes) if body.parts else body for body in proof.model.bodies)
    model = replace(proof.model, bodies=bodies)
    return replaced(proof, model=model, hashes=hashes_of(model))


def set_of(proof):
    return next(body for body in proof.model.bodies if body.parts)


def of_set(proof):
    """Indices of the entries of planes before the set."""
    return [k for k, entry in enumerate(proof.entries) if len(entry.direction) > 3]


def with_entry(proof, k, *entries):
    return replaced(proof, entries=(*proof.entries[:k], *entries, *proof.entries[k + 1 :]))


def refused(proof, words):
    found = proof.verify()
    assert not found
    assert words in found.fault, found.fault


def test_proofs_are_read_and_compared_with_files(case, tmp_path):
    shape, proof = case
    assert proof.verify()
    assert of_set(proof)
    scene_of(shape).save(tmp_path / "sensed.yaml")
    for suffix in (".json", ".npz"):
        proof.save(tmp_path / f"proof{suffix}")
        (again,) = load_proofs(tmp_path / f"proof{suffix}")
        assert again.entries == proof.entries
        assert again.hashes == hashes_of(again.model) == proof.hashes
        assert again.verify("panda", str(tmp_path / "sensed.yaml"))
    body = set_of(proof)
    width = len(body.vertices) // part_count(body)
    changes = [
        {"vertices": np.concatenate([body.vertices[width:], body.vertices[:width]])},  # another order
        {"vertices": body.vertices[width:], **({} if body.radii is None else {"radii": body.radii[-1:]})},
        {"vertices": np.where(np.arange(len(body.vertices))[:, None] == 0, body.vertices + 1e-9, body.vertices)},
    ]
    changes += [{"radii": body.radii * 0.999}] if body.parts == "balls" else []
    changes += [{"base": body.base - 0.1}] if body.parts == "prisms" else []
    for change in changes:
        other = with_set(proof, **change)
        found = model_confirmed(other, "panda", str(tmp_path / "sensed.yaml"))
        assert "another shape" in found.fault
        unsealed = replaced(other, hashes=proof.hashes)
        refused(unsealed, "content hashes")


def test_each_part_counts(case, panda):
    """Any part that is moved to where a link is makes the proof false."""
    _, proof = case
    body = set_of(proof)
    parts = body.vertices.reshape(part_count(body), -1, 3)
    inverse = np.linalg.inv(tilted())
    hand = (inverse @ panda.link_poses(START)[panda.link_index("panda_hand")])[:3, 3]
    for k in [0, len(parts) // 2, len(parts) - 1]:
        moved = parts.copy()
        moved[k] += hand - parts[k].mean(axis=0)
        refused(with_set(proof, vertices=moved.reshape(-1, 3)), "does not hold")


def test_larger_parts_are_refused(case):
    _, proof = case
    body = set_of(proof)
    if body.parts == "balls":
        refused(with_set(proof, radii=body.radii + 0.8), "does not hold")
    elif body.parts == "boxes":
        refused(
            with_set(proof, vertices=body.vertices + np.tile([[-0.5] * 3, [0.5] * 3], (part_count(body), 1))), "not"
        )
    else:
        refused(with_set(proof, base=3.0), "does not hold")
        refused(with_set(proof, vertices=body.vertices + np.array([0, 0, 1.5])), "does not hold")
    refused(with_set(proof, radius=1.0), "does not hold")


def test_changed_directions_are_refused(case):
    _, proof = case
    needed = 0
    for k in of_set(proof)[:6]:
        entry = proof.entries[k]
        directions = np.reshape(entry.direction, (-1, 3))
        same = replace(entry, direction=tuple(np.tile(directions[:1], (len(directions), 1)).ravel().tolist()))
        refused(with_entry(proof, k, same), "does not hold")
        refused(with_entry(proof, k, replace(entry, direction=())), "needs a direction")
        refused(with_entry(proof, k, replace(entry, direction=entry.direction[:-1])), "needs a direction")
        refused(with_entry(proof, k, replace(entry, direction=(float("nan"), *entry.direction[1:]))), "not finite")
        for row in range(len(directions)):
            fewer = tuple(np.delete(directions, row, axis=0).ravel().tolist())
            needed += not with_entry(proof, k, replace(entry, direction=fewer)).verify()
    assert needed > 3


def test_intervals_and_ranges_that_are_missing_are_refused(case):
    _, proof = case
    k = of_set(proof)[0]
    entry, count = proof.entries[k], part_count(set_of(proof))
    refused(replaced(proof, entries=proof.entries[:k] + proof.entries[k + 1 :]), f"pair {entry.pair}")
    if entry.end - entry.start > 1e-3:
        refused(with_entry(proof, k, replace(entry, end=entry.end - 1e-4)), f"pair {entry.pair}")
    side = "first" if proof.model.bodies[proof.model.pairs[entry.pair][0]].parts else "second"
    halves = [replace(entry, **{side: part}) for part in ((0, count // 2), (count // 2, count))]
    assert with_entry(proof, k, *halves).verify()
    assert with_entry(proof, k, *halves[::-1]).verify()
    refused(with_entry(proof, k, halves[0]), "is not proved on")
    refused(with_entry(proof, k, halves[1]), "is not proved on")
    short = replace(entry, **{side: (0, count - 1)})
    refused(with_entry(proof, k, short), "is not proved on")
    refused(with_entry(proof, k, replace(entry, **{side: (0, count + 1)})), "is of parts")


def test_a_range_is_all_of_its_parts(case):
    """A part of a range, moved to both sides, makes its entry false, and none before or after it."""
    _, proof = case
    flint.ctx.prec = 64
    entry, body = proof.entries[of_set(proof)[0]], set_of(proof)
    side = "first" if proof.model.bodies[proof.model.pairs[entry.pair][0]].parts else "second"
    low, high = 3, part_count(body) - 3
    some = replace(entry, **{side: (low, high)})
    assert EntryChecker(proof).holds(some)
    width = len(body.vertices) // part_count(body)
    for k, counts in ((low - 1, False), (low, True), (high - 1, True), (high, False)):
        vertices = body.vertices.copy()
        vertices[k * width : (k + 1) * width] += [0.4, 0.0, 0.4] - vertices[k * width]
        changed = with_set(proof, vertices=vertices, radii=None if body.radii is None else body.radii + 0.0)
        grown = with_set(changed, radii=np.full(part_count(body), 0.001)) if body.parts == "balls" else changed
        apart = [EntryChecker(grown).holds(some)]
        vertices[k * width : (k + 1) * width] += [0.0, 0.0, -50.0]
        apart.append(EntryChecker(with_set(grown, vertices=vertices)).holds(some))
        assert all(apart) or counts


def test_malformed_sets_are_refused(case):
    _, proof = case
    body = set_of(proof)
    for change, words in (
        ({"parts": "cones"}, "not known"),
        ({"parts": ""}, "and no parts" if body.radii is not None or body.base else "needs a direction"),
        ({"vertices": body.vertices[:-1]}, "vertices for" if body.parts != "balls" else "radii"),
        ({"triangles": ((0, 1, 2),)}, "of another kind"),
        ({"radii": np.array([-1.0])}, "radii"),
        ({"radii": np.array([np.nan])}, "radii"),
        ({"radii": np.ones((1, 1))}, "radii"),
        ({"base": float("inf")}, "not finite"),
        ({"base": -7.0}, "base" if body.parts != "prisms" else "another"),
    ):
        if body.parts == "prisms" and "base" in change and change["base"] == -7.0:
            continue
        if "vertices" in change and body.radii is not None and len(body.radii) == 1:
            continue
        refused(with_set(proof, **change), words)


def test_several_directions_are_for_sets_alone():
    """Of a hull each vertex would have its own, and their hull none."""
    pose = (1.0, 0.0, 0.0, 0.9, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0)
    corner = PosedBody("v", "v", -1, pose, np.array([[0.0, -1, 0], [-1, 0, 0.0]]), 0.0, 0.0, (0.0, 0.0, 0.0), 9.0)
    tip = PosedBody("p", "p", 0, STILL, 0.1 * CUBE, 0.0, 0.0, (0.0, 0.0, 0.0), 9.0)
    both = Entry(0, 0.0, 1.0, "plane", -1, (0.0, -1.0, 0.0, -1.0, 0.0, 0.0))
    refused(claim([turn()], [corner, tip], (0.0,), (0.1,), [both]), "needs a direction of three numbers")


def ball_set(points, radii=(0.0,), pose=STILL, reach=9.0):
    """Balls in the world."""
    given = {"parts": "balls", "radii": np.array(radii)}
    vertices = np.array(points, dtype=np.float64)
    return PosedBody("set", "set", -1, pose, vertices, 0.0, 0.0, (0.0, 0.0, 0.0), reach, **given)


def test_a_swing_past_a_ball_bends():
    """A point at the end of an arm of 1 m: between the ends it is further out than at both."""

    def proof(height, deepest):
        entry = Entry(0, 0.0, 1.0, "plane", -1, (0.0, 1.0, 0.0, 1.0, 0.0, 0.0))
        far = ball_set([[0.0, height, 0.0], [3.0, 0.5, 0.0]])
        bodies = [far, point("tip", 0, at(y=1.0))]
        return claim([turn()], bodies, (-0.3,), (0.3,), [entry])

    assert proof(1 + 1e-4, 7).verify()
    assert not proof(1 - 1e-6, 7).verify()
    flint.ctx.prec = 64
    inside = proof(1 - 0.01, 0)  # beyond the chord's ends, at y = cos 0.3
    assert not EntryChecker(inside).holds(inside.entries[0], 0)


TWICE = (0.0, 1.0, 0.0, 0.0, 1.0, 0.0)


@pytest.mark.parametrize("backwards", [False, True])
def test_both_ends_of_an_interval_count(backwards):
    slide = Joint("y", "slide", -1, STILL, (0.0, 1.0, 0.0), (0,), (1.0,), (0.0,))

    def proof(end):
        ends = ((end,), (0.0,)) if backwards else ((0.0,), (end,))
        bodies = [ball_set([[0.0, 1.0, 0.0], [1.0, 1.0, 0.0]]), point("tip", 0)]
        return claim([slide], bodies, *ends, [Entry(0, 0.0, 1.0, "plane", -1, TWICE)])

    assert proof(0.999).verify()
    assert not proof(1.001).verify()


def test_of_two_sets_all_parts_count():
    """Each part of the first one is beyond all of the second, and neither one alone is enough."""

    def proof(first, second):
        bodies = [ball_set([[0.0, y, 0.0] for y in first]), ball_set([[0.0, y, 0.0] for y in second])]
        entry = Entry(0, 0.0, 1.0, "plane", -1, TWICE)
        return claim([turn()], [bodies[0], replace(bodies[1], name="b")], (0.0,), (0.1,), [entry])

    assert proof([1.0, 2.0], [0.0, 0.5]).verify()
    for first, second in (([1.0, 2.0], [0.0, 1.5]), ([1.0, 2.0], [1.5, 0.0]), ([0.2, 2.0], [0.0, 0.5])):
        assert not proof(first, second).verify()
        assert not proof(first[::-1], second).verify()


def test_balls_around_a_set_hold_its_radii():
    def proof(radius, reach):
        far = ball_set([[3.0, 0.0, 0.0], [3.2, 0.0, 0.0]], (radius,), reach=reach)
        far = replace(far, centre=(3.1, 0.0, 0.0))
        bodies = [far, point("tip", 0, at(y=1.0))]
        return claim([turn()], bodies, (-0.1,), (0.1,), [Entry(0, 0.0, 1.0, "balls")])

    assert proof(0.5, 0.11).verify()
    assert not proof(3.2, 0.11).verify()
    assert not proof(0.5, 0.05).verify()


def test_motions_with_other_ends_hold_only_if_they_are_free(case, panda):
    shape, proof = case
    checker, rng, seen = pc.Checker(panda, scene_of(shape)), np.random.default_rng(8), set()
    for _ in range(30):
        end = np.array(proof.motion.end) + rng.normal(size=7) * rng.choice([1e-4, 1e-2, 0.3])
        motion = replace(proof.motion, end=tuple(end.tolist()), asked_end=tuple(end.tolist()))
        proved = bool(replaced(proof, motion=motion).verify())
        free = checker.check_states(checker.motion_certifier.states(START, end, np.linspace(0, 1, 300))).all()
        assert free or not proved
        seen.add(proved)
    assert seen == {True, False}


def test_free_motions_near_parts_are_proved(panda):
    rng = np.random.default_rng(3)
    points = rng.uniform((0.25, -0.6, 0.0), (0.8, 0.6, 1.0), size=(80, 3))
    scene = pc.Scene("near")
    scene.add("camera", pc.PointCloud(points, rng.uniform(0.002, 0.03, 80)))
    checker = pc.Checker(panda, scene, padding={"panda_hand": 0.003})
    start = panda.random_configurations(200, seed=5)
    end = np.clip(start + 0.2 * rng.normal(size=start.shape), panda.lower, panda.upper)
    free = checker.check_motions(start, end)
    assert free.sum() > 20
    proofs = checker.certify_motions(start, end)
    assert [proof is not None for proof in proofs] == free.tolist()
    for proof in proofs:
        assert proof is None or proof.verify()


def test_two_sets_are_proved_apart(panda):
    rng = np.random.default_rng(3)
    scene = scene_of(SETS["balls"]())
    scene.attach("held", "panda_hand", parts=pc.PointCloud(rng.normal(size=(12, 3)) * 0.05 + [0, 0, 0.2], 0.01))
    for link in ("panda_hand", "panda_leftfinger", "panda_rightfinger", "panda_link7", "panda_link8"):
        scene.allow("held", link)
    checker = pc.Checker(panda, scene)
    assert checker.check_motion(START, END)
    (proof,) = checker.certify_motions(START[None], END[None])
    assert proof.verify()
    k = next(k for k, body in enumerate(proof.model.bodies) if body.label == "held")
    for row in range(12):
        held = proof.model.bodies[k]
        vertices = held.vertices.copy()
        vertices[row] = [0.0, 0.0, 3.0]
        bodies = (*proof.model.bodies[:k], replace(held, vertices=vertices, reach=9.0), *proof.model.bodies[k + 1 :])
        model = replace(proof.model, bodies=bodies)
        assert not replaced(proof, model=model, hashes=hashes_of(model)).verify()


def test_a_carried_cloud_over_a_half_space_counts_ball_by_ball(panda):
    scene = pc.Scene("slope")
    scene.add("slope", pc.HalfSpace((0.0, 0.0, 1.0), -0.4))
    row = np.column_stack([np.zeros(30), np.zeros(30), np.linspace(0.12, 0.5, 30)])
    scene.attach("row", "panda_hand", parts=pc.PointCloud(row, np.linspace(0.001, 0.01, 30)))
    for link in ("panda_hand", "panda_leftfinger", "panda_rightfinger", "panda_link7", "panda_link8"):
        scene.allow("row", link)
    checker = pc.Checker(panda, scene)
    assert checker.check_motion(START, END)
    (proof,) = checker.certify_motions(START[None], END[None])
    assert proof.verify()
    body = set_of(proof)
    assert with_set(proof, radii=body.radii + 0.001).verify()
    longer = body.vertices.copy()
    longer[7, 2] += 1.5
    flint.ctx.prec = 64
    sets = [k for k, body in enumerate(proof.model.bodies) if body.parts]
    pair = max(k for k, bodies in enumerate(proof.model.pairs) if sets[0] in bodies)
    (over,) = [entry for entry in proof.entries if entry.pair == pair and entry.by == "half-space"]
    assert EntryChecker(proof).holds(over)
    assert not EntryChecker(with_set(proof, vertices=longer)).holds(over)
    assert not EntryChecker(with_set(proof, radii=body.radii + 0.8)).holds(over)


CARRIAGE = """<robot name="carriage"><link name="rail"/>
<link name="cube"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
<joint name="x" type="prismatic"><parent link="rail"/><child link="cube"/><axis xyz="1 0 0"/>
<limit lower="-9" upper="9" effort="1" velocity="1"/></joint></robot>"""
BOX = np.array(list(itertools.product([-1.0, 1.0], repeat=3)))
SIDES = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6]])
SIDES = np.vstack([SIDES, [[0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]])


@pytest.fixture
def in_a_cavity(tmp_path):
    """A cube with a cloud around it that moves in the cavity of a hollow solid."""
    (tmp_path / "carriage.urdf").write_text(CARRIAGE)
    scene = pc.Scene("shell")
    scene.add("shell", pc.Solid(np.vstack([3 * BOX, 2 * BOX]), np.vstack([SIDES, SIDES[:, ::-1] + 8])))
    scene.attach("held", "cube", parts=pc.PointCloud(0.3 * BOX, 0.02))
    (proof,) = pc.Checker(pc.Robot.from_urdf(tmp_path / "carriage.urdf"), scene).certify_motions([[0.0]], [[0.02]])
    return proof


def test_parts_in_a_cavity_are_outside(in_a_cavity):
    assert in_a_cavity.verify()
    pairs = {k: {in_a_cavity.model.bodies[b].label for b in pair} for k, pair in enumerate(in_a_cavity.model.pairs)}
    assert any(
        pairs[entry.pair] == {"held", "shell"} and (entry.first or entry.second) for entry in in_a_cavity.entries
    )


def test_each_part_inside_of_a_solid_is_found(in_a_cavity):
    """Around one part alone a surface that no plane was to keep away."""
    held = next(body for body in in_a_cavity.model.bodies if body.parts)
    shell_ = next(body for body in in_a_cavity.model.bodies if body.triangles)
    identity = arb_mat(4, 4, [int(k % 5 == 0) for k in range(16)])
    check_not_nested(held, identity, shell_, identity)
    for k in range(8):
        small = replace(shell_, vertices=0.1 * BOX + 0.3 * BOX[k], triangles=tuple(map(tuple, SIDES.tolist())))
        with pytest.raises(UnprovedError, match="is inside shell"):
            check_not_nested(held, identity, small, identity)


def test_solids_before_a_cloud_are_proved():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # an open mesh keeps its hull
        robot = pc.Robot.load("ur10", geometry={"upper_arm_link": "solid", "forearm_link": "solid"})
    rng = np.random.default_rng(0)
    scene = pc.Scene("sensed")
    scene.add("camera", pc.PointCloud(rng.uniform((-1, -1, -0.2), (1, 1, 1.2), size=(60, 3)), 0.02))
    checker = pc.Checker(robot, scene, self_collision=False)
    start = robot.random_configurations(100, seed=1)
    end = start + 0.1 * rng.normal(size=start.shape)
    free = np.flatnonzero(checker.check_motions(start, end))[:8]
    assert len(free) > 4
    for proof in checker.certify_motions(start[free], end[free]):
        assert proof.verify()


def test_pairs_without_a_proof_are_named(panda, monkeypatch):
    checker = pc.Checker(panda, scene_of(SETS["balls"]()))
    monkeypatch.setattr(part_covers, "_DEEPEST", 0)
    far = START + np.array([1.2, 0.2, 0, 0.3, 0.5, 0.5, 0])
    assert checker.check_motion(START, far)
    with pytest.raises(pc.PlannercheckError, match=r"no proof of it was found, since of panda_\w+ and camera: "):
        checker.certify_motions(START[None], far[None])


def exact_lowest(kind, vertices, base, row):
    """The least value on a part, in fractions."""
    points = [[Fraction(x) for x in point] for point in vertices.tolist()]
    if kind == "boxes":
        points = list(itertools.product(*zip(*points, strict=True)))
    if kind == "prisms":
        points += [(x, y, Fraction(base)) for x, y, _ in points]
    return min(sum(a * b for a, b in zip(row[:3], point, strict=True)) + row[3] for point in points)


@pytest.mark.parametrize(("kind", "width"), [("balls", 1), ("boxes", 2), ("prisms", 3)])
def test_heights_are_at_most_those_in_fractions(kind, width):
    rng = np.random.default_rng(width)
    for _ in range(40):
        vertices = rng.normal(size=(width * 7, 3)) * 10.0 ** rng.integers(-3, 4, 3)
        base = float(vertices[:, 2].min() - rng.random() * rng.integers(2))
        radii = np.ones(1) if kind == "balls" else None
        given = {"parts": kind, "radii": radii, "base": base if kind == "prisms" else 0.0}
        body = PosedBody("s", "s", WORLD, STILL, vertices, 0.0, 0.0, (0.0, 0.0, 0.0), 0.0, **given)
        middle = rng.normal(size=4) * 10.0 ** rng.integers(-3, 4, 4)
        wide = np.abs(middle) * 10.0 ** rng.integers(-18, -6, 4)
        row = arb_mat(1, 4, [arb(float(m), float(r)) for m, r in zip(middle, wide, strict=True)])
        parts = parts_of(body)
        found = parts.lowest(row)
        size = float((np.abs(middle[:3]) @ parts.sizes) + abs(middle[3]))
        slack = float(wide[:3] @ parts.sizes + wide[3])
        for value, own in zip(found.tolist(), vertices.reshape(7, width, 3), strict=True):
            for signs in itertools.product([-1, 1], repeat=4):
                both = middle.tolist(), signs, wide.tolist()
                exact = [Fraction(m) + s * Fraction(r) for m, s, r in zip(*both, strict=True)]
                assert Fraction(value) <= exact_lowest(kind, own, base, exact)
            least = exact_lowest(kind, own, base, [Fraction(x) for x in middle.tolist()])
            assert float(least - Fraction(value)) < 1e-14 * size + 1.01 * slack


def test_commands_prove_and_verify_before_a_cloud(case, tmp_path, capsys):
    shape, _ = case
    scene_of(shape).save(tmp_path / "sensed.yaml")
    np.save(tmp_path / "path.npy", np.array([START, END]))
    where = ["--robot", "panda", "--scene", str(tmp_path / "sensed.yaml")]
    path = ["--path", str(tmp_path / "path.npy"), "--proof", str(tmp_path / "path.proof.npz")]
    assert main(["validate", *where, *path, "--certify"]) == 0
    assert "certified" in capsys.readouterr().out
    assert main(["verify", str(tmp_path / "path.proof.npz")]) == 0
    assert main(["verify", str(tmp_path / "path.proof.npz"), *where]) == 0
    assert "confirmed" in capsys.readouterr().out
    assert main(["verify", str(tmp_path / "path.proof.npz"), "--robot", "panda", "--scene", "table"]) == 1
