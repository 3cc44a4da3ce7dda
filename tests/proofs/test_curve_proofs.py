"""Proofs of motions along polynomials, with tubes: honest ones by hand are confirmed, and false ones are refused."""

import itertools
import json
from dataclasses import replace

import curve_oracle
import mpmath
import numpy as np
import pytest
from curve_oracle import curve
from flint import arb
from proof_cases import CUBE, STILL, at, plane, point, turn

from plannercheck.common.errors import PlannercheckError
from plannercheck.proofs import Entry, Joint, Motion, load_proofs, save_proofs
from plannercheck.proofs.chains import Chains
from plannercheck.proofs.jets import ball_between
from plannercheck.proofs.polynomials import polynomial

FREE = Joint("base", "free", -1, STILL, (0.0, 0.0, 0.0), tuple(range(7)), (1.0,) * 7, (0.0,) * 7)


# ----- polynomials in ball arithmetic


@pytest.mark.parametrize("degree", range(2, 21))
def test_enclosures_hold_values_and_derivatives_and_are_tight(degree):
    generator = np.random.default_rng(degree)
    for _ in range(5):
        control = generator.normal(size=degree + 1).tolist()
        factor, offset = generator.normal(size=2).tolist()
        low = float(generator.uniform(0, 1))
        high = min(1.0, low + float(10.0 ** -generator.uniform(0, 6)))
        balls = polynomial(control, factor, offset)(ball_between(low, high))
        for order, ball in enumerate(balls):

            def exact(t, order=order, control=control, factor=factor, offset=offset):
                differences = [mpmath.mpf(c) for c in control]
                n = len(control) - 1
                for k in range(order):
                    differences = [(b - a) * (n - k) for a, b in itertools.pairwise(differences)]
                return mpmath.mpf(factor) * curve_oracle.value(differences, t) + (offset if order == 0 else 0)

            sampled = [exact(t) for t in np.linspace(low, high, 9).tolist()]
            lower, upper = (
                mpmath.mpf(str(x)) for x in (ball.lower().str(40, radius=False), ball.upper().str(40, radius=False))
            )
            assert min(sampled) >= lower - mpmath.mpf(10) ** -17 * (1 + abs(lower))
            assert max(sampled) <= upper + mpmath.mpf(10) ** -17 * (1 + abs(upper))
            if high - low < 1e-4 / degree**2 and abs(sampled[0] - sampled[-1]) > 0:
                assert upper - lower <= 1.2 * abs(sampled[0] - sampled[-1]) + 20 * degree**6 * (high - low) ** 2 + 1e-15


def test_a_polynomial_at_a_point_is_exact():
    values = polynomial([0.0, 1.0, 0.0])(arb(0.5))
    assert [float(x) for x in values] == [0.5, 0.0, -4.0]


# ----- single joints whose middle touches though their ends are apart


def bump(inner, wall, kind="turn", tube=(), entries=None, **options):
    """A point on an arm along x turns, or slides along y, by a polynomial from 0 to 0 below a wall at y = `wall`."""
    joint = turn() if kind == "turn" else turn(axis=(0.0, 1.0, 0.0), kind="slide")
    bodies = [point("wall", -1, at(x=1.0, y=wall)), point("tip", 0, at(x=1.0))]
    control = [(0.0,), *((x,) for x in inner), (0.0,)]
    return curve([joint], bodies, control, entries or [plane()], tube, **options)


@pytest.mark.parametrize("kind", ["turn", "slide"])
@pytest.mark.parametrize("inner", [(0.4,), (0.1, 0.4), (0.3, -0.3, 0.5), (0.2, 0.2, 0.2, 0.2)])
def test_what_overshoots_in_the_middle_is_refused_and_what_passes_confirmed(kind, inner):
    control = [0.0, *inner, 0.0]
    highest = max(curve_oracle.value(control, t) for t in np.linspace(0, 1, 2001).tolist())
    highest = float(highest if kind == "slide" else mpmath.sin(highest))
    assert bump(inner, highest + 1e-4, kind).verify()
    assert not bump(inner, highest - 1e-7, kind).verify()
    assert not bump((), highest - 1e-7, kind).verify() or highest > 1e-7  # the ends alone are far away


def test_ends_that_are_apart_say_nothing_of_the_middle():
    straight = bump((), 0.15)
    assert straight.verify()
    bent = replace(straight, motion=replace(straight.motion, inner=(0.4,)))
    assert not bent.verify()
    assert curve_oracle.least_gap(bent, 11) < -0.04


def test_the_rate_and_the_second_derivative_of_a_turns_angle_count():
    # By a peak of the angle the tip leaves its chords by p'' alone; on a swing through the top by p'^2.
    for inner, wall in (((0.01,), 0.005), ((0.02, 0.0), None)):
        highest = max(mpmath.sin(curve_oracle.value([0, *inner, 0], t)) for t in np.linspace(0, 1, 1001).tolist())
        assert bump(inner, float(highest) + 1e-6).verify()
        assert not bump(inner, float(highest) - 1e-9).verify(), wall


# ----- jets against differences at many digits


def random_arm(generator, free=False):
    """A chain of turns and slides, on a free base if asked for, with two bodies."""
    joints = [FREE] if free else []
    column = 7 if free else 0
    for _ in range(3):
        axis = np.eye(3)[generator.integers(3)] if generator.random() < 0.5 else generator.normal(size=3)
        axis = axis / np.linalg.norm(axis)
        kind = "slide" if generator.random() < 0.3 else "turn"
        joints.append(
            turn(
                len(joints) - 1,
                at(*generator.uniform(-0.4, 0.4, 3)),
                tuple(axis.tolist()),
                column,
                float(generator.choice([1.0, -1.0, 0.7])),
                float(generator.uniform(-0.2, 0.2)),
                kind,
            )
        )
        column += 1
    return joints, column


def random_control(generator, width, degree, free=False):
    control = generator.uniform(-0.6, 0.6, (degree + 1, width)) * generator.uniform(0.2, 1.5)
    if free:
        for row in control:
            row[3:7] = generator.normal(size=4)
            row[3:7] /= np.linalg.norm(row[3:7])
    return control


@pytest.mark.parametrize("seed", range(8))
def test_jets_hold_poses_and_derivatives_all_over_an_interval(seed):
    generator = np.random.default_rng(seed)
    free = seed % 3 == 0
    joints, width = random_arm(generator, free)
    degree = int(generator.integers(2, 8))
    proof = curve(
        joints, [point("a", -1), point("b", 0)], random_control(generator, width, degree, free), [], path="slerp"
    )
    chains = Chains(proof.model, proof.motion)
    step = mpmath.mpf(2) ** -40
    for span in ((0.0, 0.125), (0.5, 0.53125), (0.9, 1.0)):
        for k in range(len(joints)):
            jet = chains.jet(span, -1, k)
            for t in np.linspace(*span, 4).tolist():
                below, here, above = (
                    curve_oracle.link_maps(proof, curve_oracle.state(proof, t + s))[k] for s in (-step, 0, step)
                )
                for ball, exact in (
                    (jet.value, here),
                    (jet.first, (above - below) / (2 * step)),
                    (jet.second, (above - 2 * here + below) / step**2),
                ):
                    for i, j in itertools.product(range(3), range(4)):
                        value, slack = exact[i, j], mpmath.mpf(10) ** -13
                        if ball is None:
                            assert abs(value) < slack
                        else:
                            lower, upper = (
                                mpmath.mpf(x.str(30, radius=False)) for x in (ball[i, j].lower(), ball[i, j].upper())
                            )
                            assert lower - slack <= value <= upper + slack


# ----- contact built in, with planes found by brute force


def brute_planes(proof, parts):
    """Entries of equal parts, each by the sampled best of many directions in two frames, in doubles."""
    directions = [*np.eye(3), *-np.eye(3), *np.random.default_rng(0).normal(size=(40, 3))]
    a, b = proof.model.pairs[0]
    found = []
    for k in range(parts):
        start, end = k / parts, (k + 1) / parts
        seen = [curve_oracle.seen(proof, t) for t in (start, (start + end) / 2, end)]
        best = max(
            (
                (min(((m[frame][a] @ d).min() - (m[frame][b] @ d).max()) / np.linalg.norm(d) for m in seen), frame, j)
                for frame in (-1, len(proof.model.links) - 1)
                for j, d in enumerate(directions)
            )
        )
        found.append(plane(directions[best[2]], best[1], start, end))
    return found


@pytest.mark.parametrize("seed", range(16))
def test_contact_at_a_corner_of_the_tube_is_refused(seed):
    # A post stands where the tip is at one instant, at a corner of the tube: nothing may be proved, by any plane.
    generator = np.random.default_rng(seed)
    free = seed % 4 == 3
    joints, width = random_arm(generator, free)
    control = random_control(generator, width, int(generator.integers(2, 8)), free) * (1.0 if free else 0.3)
    tube = generator.uniform(0, 0.05, width) * (generator.random(width) < 0.8)
    tube[3:7] *= not free
    bodies = [point("post", -1), point("tip", len(joints) - 1, at(0.3, 0.1, 0.2), CUBE * 0.05)]
    proof = curve(joints, bodies, control, [], tube, "slerp")
    t, corner = float(generator.random()), generator.choice([-1, 1], width) * tube
    touching = curve_oracle.points(proof, 1, curve_oracle.link_maps(proof, curve_oracle.state(proof, t, corner)))[0]
    post = point("post", -1, at(*(float(x) for x in touching[:3])))
    touched = curve(joints, [post, bodies[1]], control, [], tube, "slerp")
    for parts in (1, 8):
        forged = replace(touched, entries=tuple(brute_planes(touched, parts)))
        assert not forged.verify()


@pytest.mark.parametrize("seed", range(6))
def test_honest_proofs_by_brute_force_are_confirmed_and_never_contradicted(seed):
    generator = np.random.default_rng(50 + seed)
    free = seed % 4 == 3
    joints, width = random_arm(generator, free)
    control = random_control(generator, width, int(generator.integers(2, 8)), free) * (1.0 if free else 0.4)
    if free:  # turned a little
        control[-1, 3:7] = control[0, 3:7] + 0.1
        control[-1, 3:7] /= np.linalg.norm(control[-1, 3:7])
    tube = generator.uniform(0, 0.01, width)
    tube[3:7] *= not free
    far = at(*(generator.choice([-1, 1], 3) * 1.6))
    bodies = [point("post", -1, far, CUBE * 0.2), point("tip", len(joints) - 1, at(0.1), CUBE * 0.1, 0.01)]
    proof = curve(joints, bodies, control, [], tube, "slerp")
    honest = replace(proof, entries=tuple(brute_planes(proof, 16)))
    found = honest.verify()
    assert found, found.fault
    assert curve_oracle.least_gap(honest, 2, 2) > 0


# ----- forgeries of one honest proof


def elbow(tube=(0.02, 0.01, 0.005)):
    """Two turns and a slide: the tip goes up and down below a bar, by degree 4."""
    joints = [turn(), turn(0, at(x=0.5), column=1), turn(1, at(x=0.4), axis=(1.0, 0.0, 0.0), column=2, kind="slide")]
    bodies = [point("bar", -1, at(y=0.62), CUBE * (4.0, 0.1, 0.1)), point("tip", 2, at(), CUBE * 0.1)]
    control = [(0.0, 0.0, 0.0), (0.3, 0.2, 0.1), (0.5, 0.6, 0.1), (0.2, 0.1, 0.3), (-0.1, 0.0, 0.05)]
    entries = [plane(start=k / 8, end=(k + 1) / 8) for k in range(8)]
    return curve(joints, bodies, control, entries, tube)


def moved(proof, **changes):
    return replace(proof, motion=replace(proof.motion, **changes))


def test_the_proof_to_be_forged_is_honest():
    assert elbow().verify()
    assert elbow(()).verify()
    assert curve_oracle.least_gap(elbow(), 5) > 0


NAN = float("nan")
FORGERIES = {
    "inner numbers moved": lambda p: moved(p, inner=(*p.motion.inner[:3], 1.6, 1.6, *p.motion.inner[5:])),
    "inner rows in another order, one too far": lambda p: moved(
        p, inner=(p.motion.inner[0] + 1.5, *p.motion.inner[1:])
    ),
    "an inner number that is no number": lambda p: moved(p, inner=(NAN, *p.motion.inner[1:])),
    "an inner number without end": lambda p: moved(p, inner=(float("inf"), *p.motion.inner[1:])),
    "an inner number too few": lambda p: moved(p, inner=p.motion.inner[1:]),
    "an inner number too many": lambda p: moved(p, inner=(*p.motion.inner, 0.0)),
    "inner numbers that are integers": lambda p: moved(p, inner=tuple(int(x) for x in p.motion.inner)),
    "a degree beyond the largest": lambda p: moved(p, inner=(0.0,) * 3 * 20),
    "another end asked for": lambda p: moved(p, asked_end=(0.0, 0.0, 0.05)),
    "another end, by a whole turn": lambda p: moved(
        replace(p, model=replace(p.model, whole_turns=(0,))), asked_end=(p.motion.end[0] + 2 * np.pi, *p.motion.end[1:])
    ),
    "a tube of too few numbers": lambda p: moved(p, tube=(0.02,)),
    "a tube of too many numbers": lambda p: moved(p, tube=(0.02,) * 4),
    "a tube narrower than 0": lambda p: moved(p, tube=(0.02, -0.01, 0.0)),
    "a tube that is no number": lambda p: moved(p, tube=(0.02, NAN, 0.0)),
    "a tube without end": lambda p: moved(p, tube=(0.02, float("inf"), 0.0)),
    "a wider tube": lambda p: moved(p, tube=(0.3, 0.3, 0.3)),
    "a tube and another end, by a whole turn": lambda p: moved(
        replace(p, model=replace(p.model, whole_turns=(0,))),
        inner=(),
        asked_end=(p.motion.end[0] + 2 * np.pi, *p.motion.end[1:]),
    ),
    "entries with a gap": lambda p: replace(p, entries=(*p.entries[:3], *p.entries[4:])),
    "entries that end too early": lambda p: replace(p, entries=p.entries[:-1]),
    "entries with a gap of one bit": lambda p: replace(
        p, entries=(*p.entries[:3], replace(p.entries[3], start=np.nextafter(0.375, 1)), *p.entries[4:])
    ),
    "a direction turned round": lambda p: replace(
        p, entries=(replace(p.entries[0], direction=(0.0, -1.0, 0.0)), *p.entries[1:])
    ),
    "a margin beyond the gap": lambda p: replace(p, margin=0.5),
    "balls of no size": lambda p: replace(p, entries=(Entry(0, 0.0, 1.0, "balls"),)),
}


@pytest.mark.parametrize("name", FORGERIES)
def test_a_forged_curve_is_refused(name):
    from plannercheck.proofs.well_formed import hashes_of

    forged = FORGERIES[name](elbow())
    found = replace(forged, hashes=hashes_of(forged.model)).verify()
    assert not found
    assert found.fault


def test_a_tube_is_of_no_quaternion_and_a_curve_of_no_screw():
    control = np.tile([0.0, 0, 0, 0, 0, 0, 1], (3, 1))
    control[1, 1], bodies = 0.3, [point("wall", -1, at(y=1.0)), point("base", 0)]
    assert curve([FREE], bodies, control, [plane()], (0.01,) * 3 + (0.0,) * 4, "slerp").verify()
    for tube, path in (((0.0,) * 3 + (0.01,) + (0.0,) * 3, "slerp"), ((0.0,) * 6 + (0.01,), "slerp"), ((), "screw")):
        found = curve([FREE], bodies, control, [plane()], tube, path).verify()
        assert not found
        assert "base" in found.fault
    circle = Joint("c", "circle", -1, STILL, (0.0, 0.0, 1.0), (0, 1), (1.0, 1.0), (0.0, 0.0))
    ends = [(1.0, 0.0), (0.5, 0.5), (1.0, 0.0)]
    assert curve([circle], bodies, ends, [plane()]).verify()
    assert not curve([circle], bodies, ends, [plane()], (0.01, 0.0)).verify()
    assert not curve([circle], bodies, [(1.0, 0.0), (NAN, 0.0), (1.0, 0.0)], [plane()]).verify()


def test_the_position_of_a_free_base_bends():
    bodies = [point("wall", -1, at(y=0.2)), point("base", 0)]
    control = np.tile([0.0, 0, 0, 0, 0, 0, 1], (3, 1))
    for height, holds in ((0.39, True), (0.41, False)):  # in the middle it is half as high
        control[1, 1] = height
        assert bool(curve([FREE], bodies, control, [plane()], path="slerp").verify()) == holds


def test_a_joint_may_turn_further_than_half_a_turn_along_a_curve():
    bodies = [point("post", -1, at(z=0.5)), point("tip", 0, at(x=0.5))]
    control = [(-5.0,), (0.0,), (9.0,)]
    assert curve([turn()], bodies, control, [plane((0, 0, 1))], whole=(0,)).verify()
    straight = curve([turn()], bodies, control[::2], [plane((0, 0, 1))], whole=(0,)).verify()
    assert not straight
    assert "half a turn" in straight.fault


def test_files_keep_curves_and_straight_ones_keep_their_bytes(tmp_path):
    proof = elbow()
    for name in ("x.json", "x.npz"):
        save_proofs([proof], tmp_path / name)
        (read,) = load_proofs(tmp_path / name)
        assert (read.motion, read.hashes) == (proof.motion, proof.hashes)
        assert read.verify()
    straight = moved(proof, inner=(), tube=())
    save_proofs([straight], tmp_path / "straight.json")
    document = json.loads((tmp_path / "straight.json").read_text())
    assert set(document["motions"][0]["motion"]) == {"start", "end", "asked_end"}
    document = json.loads((tmp_path / "x.json").read_text())
    for key, wrong in (("inner", 3.0), ("inner", ["x"]), ("inner", None), ("tube", [True]), ("tube", {"a": 1})):
        changed = json.loads(json.dumps(document))
        changed["motions"][0]["motion"][key] = wrong
        (tmp_path / "wrong.json").write_text(json.dumps(changed))
        with pytest.raises(PlannercheckError, match=key):
            load_proofs(tmp_path / "wrong.json")


def test_control_points_are_rows():
    assert Motion((0.0, 1.0), (4.0, 5.0), (4.0, 5.0)).control == ((0.0, 1.0), (4.0, 5.0))
    bent = Motion((0.0, 1.0), (4.0, 5.0), (4.0, 5.0), inner=(2.0, 3.0, 7.0, 8.0))
    assert bent.control == ((0.0, 1.0), (2.0, 3.0), (7.0, 8.0), (4.0, 5.0))
