"""Proofs of motions before sets of parts: each part counts, and what is changed beyond its slack is refused."""

import itertools
from dataclasses import replace
from fractions import Fraction

import flint
import numpy as np
import pytest
from flint import arb, arb_mat
from proof_cases import CUBE, STILL, at, claim, point, turn
from set_proof_cases import END, SETS, START, refused, replaced, scene_of, set_of, tilted, with_set

import plannercheck as pc
from plannercheck.proofs import Entry, Joint, PosedBody, load_proofs
from plannercheck.proofs.data import WORLD
from plannercheck.proofs.entries import EntryChecker
from plannercheck.proofs.parts import part_count, parts_of
from plannercheck.proofs.verify import model_confirmed
from plannercheck.proofs.well_formed import hashes_of


@pytest.fixture(scope="module", params=SETS)
def case(request, panda):
    """A shape, and the proof of a motion before it."""
    shape = SETS[request.param]()
    (proof,) = pc.Checker(panda, scene_of(shape)).certify_motions(START[None], END[None])
    return shape, proof


def of_set(proof):
    """Indices of the entries of planes before the set."""
    return [k for k, entry in enumerate(proof.entries) if len(entry.direction) > 3]


def with_entry(proof, k, *entries):
    return replaced(proof, entries=(*proof.entries[:k], *entries, *proof.entries[k + 1 :]))


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
    for _ in range(16):
        end = np.array(proof.motion.end) + rng.normal(size=7) * rng.choice([1e-4, 1e-2, 0.3])
        motion = replace(proof.motion, end=tuple(end.tolist()), asked_end=tuple(end.tolist()))
        proved = bool(replaced(proof, motion=motion).verify())
        free = checker.check_states(checker.motion_certifier.states(START, end, np.linspace(0, 1, 300))).all()
        assert free or not proved
        seen.add(proved)
    assert seen == {True, False}


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
