"""Proofs of motions in the plane: right ones are confirmed; each with one number changed beyond its slack is not."""

import cmath
import math
from dataclasses import replace

import flint
import numpy as np
import pytest
from ompl import base
from planar_cases import chain, cluttered
from planar_contacts import contact_with_obstacle, link_frames, some_tree
from test_planar_motion_certifier import arm, states_of

import plannercheck as pc
from plannercheck.cli.main import main
from plannercheck.motions.certifier_answers import Passage
from plannercheck.motions.certifier_answers import Proof as Line
from plannercheck.planar.curves import Curves
from plannercheck.planar.proof_builder import planar_model
from plannercheck.planar.proof_confirmation import confirm_model
from plannercheck.proofs import Entry, Proof, load_proofs, save_proofs
from plannercheck.proofs.faults import UnprovedError
from plannercheck.proofs.planar_paths import Paths
from plannercheck.proofs.planar_proof import Piece, PlanarBody, PlanarLink, PlanarModel, PlanarMotion
from plannercheck.proofs.planar_well_formed import hashes_of, least_margin

P = pc.planar
STRAIGHT = {}
SHIPPED = [("forklift", "warehouse", 1.5), ("forklift", "parking", 1.5), ("truck_trailer", "parking", 6.0)]
CURVES = {"dubins": base.DubinsStateSpace, "reeds_shepp": base.ReedsSheppStateSpace}


def kinds(radius):
    return [STRAIGHT, *({"curve": curve, "turning_radius": radius} for curve in CURVES)]


def free_motions(checker, n, seed, scale=1.0, **kind):
    """Motions that are free, and their proofs."""
    generator, found = np.random.default_rng(seed), []
    for _ in range(60):
        q = checker.robot.random_configurations(200, generator)
        q0 = q[checker.check_states(q)][: 2 * n]
        ways = generator.normal(size=q0.shape) * generator.uniform(0.05, scale, (len(q0), 1))
        if kind:  # mostly ahead, so that curves are short
            ahead = np.array([np.cos(q0[:, 2]), np.sin(q0[:, 2])]).T * generator.uniform(0.2, 6, (len(q0), 1))
            if kind["curve"] == "reeds_shepp":
                ahead *= generator.choice([-1, 1], (len(q0), 1))
            ways[:, :2] = (ways[:, :2] * 0.1 + ahead) / 2
        q1 = q0 + ways * ([2, 2, 0.7, *[0.3] * (q0.shape[1] - 3)] if checker.robot.is_free else 0.5)
        proofs = checker.certify_motions(q0, q1, **kind)
        found += [(a, b, proof) for a, b, proof in zip(q0, q1, proofs, strict=True) if proof is not None]
        if len(found) >= n:
            return found[:n]
    raise AssertionError("too few free motions")


def shipped(robot, scene):
    return P.Checker(P.Robot.load(robot), P.Scene.load(scene))


# ----- proofs are confirmed


@pytest.mark.parametrize(("robot", "scene", "radius"), SHIPPED)
def test_shipped_robots_are_proved(robot, scene, radius, tmp_path):
    checker = shipped(robot, scene)
    for kind in kinds(radius):
        cases = free_motions(checker, 12, 1, 0.6, **kind)
        for q0, q1, proof in cases:
            found = proof.verify()
            assert found, found.fault
            assert found.entries == len(proof.entries)
            again = checker.explain_motion(q0, q1, **kind).proof
            assert again.entries == proof.entries
        for suffix in ("json", "npz"):
            path = tmp_path / f"proof.{suffix}"
            save_proofs([proof for _, _, proof in cases], path)
            loaded = load_proofs(path)
            assert [p.entries for p in loaded] == [p.entries for _, _, p in cases]
            assert [p.motion for p in loaded] == [p.motion for _, _, p in cases]
            assert all(loaded)
            assert loaded[0].verify()
    cases[0][2].save(tmp_path / "one.json")
    assert Proof.load(tmp_path / "one.json").verify()


@pytest.mark.parametrize(
    "make",
    [lambda: P.Checker(chain(), cluttered(count=25)), lambda: P.Checker(arm(), cluttered(seed=1, count=7, reach=4.0))],
)
def test_chains_and_arms_are_proved(make):
    checker = make()
    for kind in kinds(2.0) if checker.robot.is_free else [STRAIGHT]:
        for _, _, proof in free_motions(checker, 8, 2, 0.5, **kind):
            found = proof.verify()
            assert found, found.fault
            assert {proof.model.pairs[entry.pair] for entry in proof.entries} == set(map(tuple, checker.pairs.tolist()))


def test_random_trees_are_proved_or_refused():
    """Roots of all kinds, fixed links, bodies far off; a motion is free only if its proof is confirmed."""
    generator, counts = np.random.default_rng(3), [0, 0]
    for _ in range(150):
        case = contact_with_obstacle(generator, 0.3, 3.0, 10.0 ** generator.uniform(-1.5, 0))
        if case is None:
            continue
        checker = P.Checker(case.robot, case.scene)
        away = generator.normal(size=case.robot.nq) * 0.3
        (proof,) = checker.certify_motions((case.q0 + away)[None], (case.q1 + away)[None])
        assert (proof is not None) == checker.check_motion(case.q0 + away, case.q1 + away)
        counts[proof is not None] += 1
        if proof is not None:
            found = proof.verify()
            assert found, found.fault
    assert min(counts) > 10


def test_colliding_motions_have_no_proof():
    checker = shipped("forklift", "parking")
    verdict = checker.explain_motion([10, 10, 0], [10, 40, 0])
    assert not verdict.free
    assert verdict.proof is None
    assert checker.certify_motions([[10, 10, 0]], [[10, 40, 0]]) == (None,)


def test_motions_of_many_turns_are_proved():
    """Whole turns that are taken off lose bits: the margin has room for them."""
    robot = P.Robot([[8, -0.1], [12, -0.1], [12, 0.1], [8, 0.1]])
    scene = P.Scene()
    scene.add_polygon("post", [[-5.0, 5.0]])
    checker = P.Checker(robot, scene)
    for far in (0.0, 1e3, -1e6, 1e8):
        turn = math.remainder(far, 2 * math.pi)
        q0, q1 = [-20, 0, turn - 0.3], [-25, 0, far]
        for kind in kinds(30.0):
            for a, b in ((q0, q1), (q1, q0)):
                if checker.check_motion(a, b, tolerance=1.0, **kind):
                    proof = checker.explain_motion(a, b, tolerance=1.0, **kind).proof
                    found = proof.verify()
                    assert found, found.fault
                    small = replace(proof, margin=1e-14)
                    assert "margin" in small.verify().fault


# ----- what proofs are about


def test_the_verifiers_poses_are_those_of_verdicts():
    """Within half the least margin: exact kinematics, computed poses, and kinematics of our own by complex numbers."""
    generator, flint.ctx.prec = np.random.default_rng(4), 192
    for _ in range(40):
        links = some_tree(generator, 0.5, 10.0 ** generator.uniform(-1, 2))
        robot = P.Robot(links)
        if robot.nq == 0:
            continue
        checker = P.Checker(robot, P.Scene())
        scale = 10.0 ** generator.uniform(-1, 4)
        q0, q1 = generator.uniform(-scale, scale, (2, robot.nq))
        (start,), (end,), (given,) = checker._motion_ends(q0[None], q1[None])
        builder = checker._prover
        motion = PlanarMotion(*(tuple(q.tolist()) for q in (start, end, given)))
        paths, margin = Paths(builder._model, motion), least_margin(builder._model, motion)
        for t in (0.0, 0.3, 0.8125, 1.0):
            state = states_of(checker, q0, q1, np.array([t]), ("straight", None))
            poses = checker.body_poses(state)[0]
            frames = link_frames(links, (1 - t) * start + t * end)
            for body, pose in zip(checker.bodies, poses, strict=True):
                place = paths.places(0, t)[body.link]
                for x, y in body.vertices.tolist():
                    exact = place.origin + place.turn * flint.acb(x, y)
                    ours = complex(*(pose[:2, :2] @ [x, y] + pose[:2, 2]))
                    turn, origin = frames[robot.link_names[body.link]]
                    for other in (ours, origin + turn * complex(x, y)):
                        assert abs(exact - flint.acb(other.real, other.imag)) <= margin / 4


@pytest.mark.parametrize("curve", CURVES)
def test_pieces_of_proofs_are_ompls_curves(curve):
    """OMPL's own interpolation stays within the slip of the pieces that a proof claims, whole robot and trailers."""
    checker, generator, worst = shipped("truck_trailer", "parking"), np.random.default_rng(5), 0.0
    space, lever = CURVES[curve](6.0), 20.0
    states = [space.allocState() for _ in range(3)]
    for q0, q1, proof in free_motions(checker, 15, 6, 0.5, curve=curve, turning_radius=6.0):
        for state, q in zip(states, (q0, q1), strict=False):
            state.setX(q[0])
            state.setY(q[1])
            state.setYaw(math.remainder(q[2], 2 * math.pi))
        for t in (0.0, *generator.uniform(0, 1, 40), 1 - 1e-12):
            piece = next(piece for piece in proof.motion.pieces if t <= piece.end)
            s = (t - piece.start) / (piece.end - piece.start)
            heading = piece.heading + s * piece.turn
            at = complex(*piece.origin) + s * complex(*piece.way) + cmath.exp(1j * heading) * complex(*piece.arm)
            space.interpolate(*states[:2], t, states[2])
            off = abs(at - complex(states[2].getX(), states[2].getY()))
            off += lever * abs(math.remainder(heading - states[2].getYaw(), 2 * math.pi))
            assert off <= piece.slip * lever / 10 + proof.margin + 1e-12
            worst = max(worst, off)
    assert worst > 0


def dubins_length(q0, q1):
    """The shortest of Dubins' six words for a turning radius of 1, by the circles that the arcs are on.

    Dubins, "On curves of minimal length with a constraint on average curvature", 1957.
    """
    best, turn = math.inf, 2 * math.pi
    start, end = complex(q0[0], q0[1]), complex(q1[0], q1[1])
    for first in (1, -1):
        for last in (1, -1):
            one = start + first * 1j * cmath.exp(1j * q0[2])  # centres: to the left for 1
            two = end + last * 1j * cmath.exp(1j * q1[2])
            between, course = abs(two - one), cmath.phase(two - one) if two != one else 0.0
            if first == last:
                arcs = (first * (course - q0[2])) % turn + (first * (q1[2] - course)) % turn
                best = min(best, between + arcs)
                if between <= 4:  # by a third circle that touches both
                    for side in (1, -1):
                        opening = math.acos(min(1.0, between / 4))
                        third = one + 2 * cmath.exp(1j * (course + side * opening))
                        # Headings where circles touch: across the way from centre to centre.
                        leave = cmath.phase((third - one) * first * 1j)
                        reach = cmath.phase((two - third) * -first * 1j)
                        arcs = (first * (leave - q0[2])) % turn + (-first * (reach - leave)) % turn
                        best = min(best, arcs + (first * (q1[2] - reach)) % turn)
            elif between >= 2:
                straight = math.sqrt(between**2 - 4)
                heading = course + first * math.asin(2 / between)
                arcs = (first * (heading - q0[2])) % turn + (last * (q1[2] - heading)) % turn
                best = min(best, straight + arcs)
    return best


def test_lengths_of_proved_curves_are_dubins_and_no_longer_for_reeds_and_shepp():
    """The pieces of a proof are a shortest curve, by formulas of our own; driving both ways is never longer."""
    checker, generator, both = P.Checker(P.Robot([[0, 0], [0.1, 0], [0, 0.1]]), P.Scene()), np.random.default_rng(15), 0
    for _ in range(150):
        q0, q1 = generator.uniform(-1, 1, (2, 3)) * [3, 3, 3.1]
        lengths = {}
        for curve in CURVES:
            proof = checker.explain_motion(q0, q1, curve=curve, turning_radius=1.0).proof
            assert proof.verify()
            lengths[curve] = sum(math.hypot(*p.way) + abs(p.turn) * math.hypot(*p.arm) for p in proof.motion.pieces)
        assert lengths["dubins"] == pytest.approx(dubins_length(q0, q1), abs=1e-5)
        assert math.dist(q0[:2], q1[:2]) - 1e-9 <= lengths["reeds_shepp"] <= lengths["dubins"] + 1e-5
        both += lengths["reeds_shepp"] < lengths["dubins"] - 0.1
    assert both > 30


# ----- one number changed


def changed(items, k, item):
    return (*items[:k], item, *items[k + 1 :])


def rehashed(proof, model):
    return replace(proof, model=model, hashes=hashes_of(model))


def seen_from(proof, frame, body, q):
    """Vertices (n,) as complex numbers from a frame, by kinematics of our own."""
    given = proof.model.bodies[body]
    points = given.vertices @ [1, 1j]
    if given.link < 0:
        m = np.reshape(given.pose, (2, 3))
        points = (given.vertices @ m[:, :2].T + m[:, 2]) @ [1, 1j]
        turn, origin = 1, 0
    else:
        turn, origin = frames_of(proof, q)[given.link]
    world = origin + turn * points
    if frame < 0:
        return world
    turn, origin = frames_of(proof, q)[frame]
    return (world - origin) / turn


def frames_of(proof, q):
    links = [
        P.Link(
            link.name, [[0, 0]], None if link.parent < 0 else str(link.parent), (link.x, link.y, link.angle), link.joint
        )
        for link in (replace(link, name=str(k)) for k, link in enumerate(proof.model.links))
    ]
    return list(link_frames(links, q).values())


def separates(proof, entry, direction, states):
    """Whether a direction keeps a pair apart at states of the motion."""
    a, b = proof.model.pairs[entry.pair]
    d = complex(*direction).conjugate()
    gaps = [
        (d * seen_from(proof, entry.frame, a, q)).real.min() - (d * seen_from(proof, entry.frame, b, q)).real.max()
        for q in states
    ]
    return min(gaps) > 0


def with_other_direction(proof, generator, checker, states_at):
    rows = [k for k, entry in enumerate(proof.entries) if entry.by == "plane"]
    for _ in range(40):
        k = int(generator.choice(rows))
        entry, axis = proof.entries[k], int(generator.integers(2))
        direction = changed(entry.direction, axis, entry.direction[axis] + float(generator.normal() * 2))
        states = states_at(np.linspace(entry.start, entry.end, 5))
        if not separates(proof, entry, direction, states):
            assert separates(proof, entry, entry.direction, states)
            return replace(proof, entries=changed(proof.entries, k, replace(entry, direction=direction)))
    return None


def with_other_interval(proof, generator, *_):
    k = int(generator.integers(len(proof.entries)))
    entry, side = proof.entries[k], str(generator.choice(["start", "end"]))
    moved = getattr(entry, side) + float(generator.choice([1e-3, -1e-3, 2.0**-50, -(2.0**-50), 1.0]))
    return replace(proof, entries=changed(proof.entries, k, replace(entry, **{side: moved})))


def with_other_frame(proof, generator, *_):
    rows = [k for k, entry in enumerate(proof.entries) if entry.by == "plane"]
    k = int(generator.choice(rows))
    others = [frame for frame in range(-2, len(proof.model.links) + 1) if frame != proof.entries[k].frame]
    entry = replace(proof.entries[k], frame=int(generator.choice(others)))
    return replace(proof, entries=changed(proof.entries, k, entry))


def with_other_pair(proof, generator, *_):
    k = int(generator.integers(len(proof.entries)))
    others = [pair for pair in range(-1, len(proof.model.pairs) + 1) if pair != proof.entries[k].pair]
    return replace(
        proof, entries=changed(proof.entries, k, replace(proof.entries[k], pair=int(generator.choice(others))))
    )


def without_a_pair(proof, generator, *_):
    pair = int(generator.integers(len(proof.model.pairs)))
    return replace(proof, entries=tuple(entry for entry in proof.entries if entry.pair != pair))


def without_an_entry(proof, generator, *_):
    k = int(generator.integers(len(proof.entries)))
    return replace(proof, entries=(*proof.entries[:k], *proof.entries[k + 1 :]))


def with_other_pair_table(proof, generator, *_):
    """Fewer pairs than the hashes say."""
    pairs = proof.model.pairs[:-1]
    entries = tuple(entry for entry in proof.entries if entry.pair < len(pairs))
    return replace(proof, model=replace(proof.model, pairs=pairs), entries=entries)


def with_other_vertex(proof, generator, *_):
    """Unnoticed by the hashes: only these tell."""
    k = int(generator.integers(len(proof.model.bodies)))
    vertices = np.array(proof.model.bodies[k].vertices)
    vertices[tuple(generator.integers(vertices.shape))] += 1e-9
    bodies = changed(proof.model.bodies, k, replace(proof.model.bodies[k], vertices=vertices))
    return replace(proof, model=replace(proof.model, bodies=bodies))


def with_a_vertex_in_another_body(proof, generator, checker, states_at):
    """Model and hashes agree, but two bodies meet on the motion."""
    k = int(generator.integers(len(proof.model.pairs)))
    a, b = proof.model.pairs[k]
    body, (q,) = proof.model.bodies[a], states_at(generator.uniform(0, 1, 1))
    turn, origin = frames_of(proof, q)[body.link]
    point = (seen_from(proof, -1, b, q).mean() - origin) / turn
    vertices = np.vstack([body.vertices, [point.real, point.imag]])
    reach = float(np.hypot(*(vertices - body.centre).T).max()) * (1 + 1e-9)
    bodies = changed(proof.model.bodies, a, replace(body, vertices=vertices, reach=reach))
    return replace(rehashed(proof, replace(proof.model, bodies=bodies)), margin=proof.margin * 100)


def with_a_small_circle(proof, generator, *_):
    k = int(generator.integers(len(proof.model.bodies)))
    body = proof.model.bodies[k]
    smaller = replace(body, reach=body.reach * 0.999) if body.reach > 0 else replace(body, reach=-1.0)
    return rehashed(proof, replace(proof.model, bodies=changed(proof.model.bodies, k, smaller)))


def with_other_end(proof, generator, *_):
    column = int(generator.integers(proof.model.columns))
    value = proof.motion.end[column] + float(generator.choice([1e-6, -1e-3, 0.1, math.pi]))
    return replace(proof, motion=replace(proof.motion, end=changed(proof.motion.end, column, value)))


def with_colliding_start(proof, generator, checker, *_):
    """Another start, from which the motion collides."""
    for _ in range(200):
        column = int(generator.integers(proof.model.columns))
        value = proof.motion.start[column] + float(generator.normal() * 3)
        start = changed(proof.motion.start, column, value)
        parts = np.linspace(0, 1, 101)[:, None]
        states = (1 - parts) * np.array(start) + parts * np.array(proof.motion.end)
        if proof.motion.curve != "straight" or not checker.check_states(states).all():
            return replace(proof, motion=replace(proof.motion, start=start))
    return None


def with_other_margin(proof, generator, *_):
    return replace(proof, margin=float(generator.choice([proof.margin / 4, 0.0, -1.0, 1e3, math.nan, math.inf])))


def with_other_piece(proof, generator, *_):
    if not proof.motion.pieces:
        return None
    k = int(generator.integers(len(proof.motion.pieces)))
    piece = proof.motion.pieces[k]
    name = str(generator.choice(["start", "end", "origin", "way", "heading", "turn", "arm", "slip"]))
    value, by = getattr(piece, name), float(generator.choice([-1, 1]) * 10.0 ** generator.uniform(-2, 0))
    if name == "slip":
        value += 1e3
    elif isinstance(value, tuple):
        axis = int(generator.integers(2))
        value = changed(value, axis, value[axis] + by)
    else:
        value += by
    return replace(
        proof, motion=replace(proof.motion, pieces=changed(proof.motion.pieces, k, replace(piece, **{name: value})))
    )


def with_other_radius(proof, generator, *_):
    radius = proof.motion.turning_radius * 1.001 if proof.motion.pieces else 1.0
    return replace(proof, motion=replace(proof.motion, turning_radius=radius))


MUTATIONS = [
    with_other_direction,
    with_other_interval,
    with_other_frame,
    with_other_pair,
    without_a_pair,
    without_an_entry,
    with_other_pair_table,
    with_other_vertex,
    with_a_vertex_in_another_body,
    with_a_small_circle,
    with_other_end,
    with_colliding_start,
    with_other_margin,
    with_other_piece,
    with_other_radius,
]


@pytest.fixture(scope="module")
def proved():
    """Checkers with proofs of all kinds."""
    out = []
    for robot, scene, radius in SHIPPED:
        checker = shipped(robot, scene)
        for kind in kinds(radius):
            out += [(checker, kind, *case) for case in free_motions(checker, 5, 7, 0.4, **kind)]
    return out


@pytest.mark.parametrize("mutation", MUTATIONS)
def test_a_changed_number_is_refused(proved, mutation):
    generator, refused = np.random.default_rng(8), 0
    for checker, kind, q0, q1, proof in proved:
        how = (kind.get("curve", "straight"), kind.get("turning_radius"))
        mutant = mutation(proof, generator, checker, lambda t, *a: states_of(checker, q0, q1, np.asarray(t), how))  # noqa: B023
        if mutant is None:
            continue
        found = mutant.verify()
        assert not found, (mutation.__name__, how)
        assert found.fault
        refused += 1
    assert refused >= (25 if mutation is with_other_piece else 40)


def test_malformed_proofs_are_refused_not_crashed(proved):
    proof = proved[0][-1]
    entry = proof.entries[0]
    bad = [
        replace(proof, entries=()),
        replace(proof, entries=changed(proof.entries, 0, replace(entry, by="magic"))),
        replace(proof, entries=changed(proof.entries, 0, replace(entry, by="plane", direction=(0.0, 0.0)))),
        replace(proof, entries=changed(proof.entries, 0, replace(entry, by="plane", direction=(math.nan, 1.0)))),
        replace(proof, entries=changed(proof.entries, 0, replace(entry, by="plane", direction=(1.0,)))),
        replace(proof, motion=replace(proof.motion, start=proof.motion.start[:-1])),
        replace(proof, motion=replace(proof.motion, start=(math.inf, *proof.motion.start[1:]))),
        replace(proof, motion=replace(proof.motion, curve="clothoid")),
        rehashed(proof, replace(proof.model, pairs=((0, 0),))),
        rehashed(proof, replace(proof.model, links=())),
        rehashed(proof, replace(proof.model, whole_turns=(0,))),
    ]
    for mutant in bad:
        assert not mutant.verify()
        assert mutant.verify().fault


# ----- faults put back


def test_a_certifier_with_long_directions_is_found_out(monkeypatch):
    """A gap times a direction of 2 m, compared with metres: the bar through the post is called free, the proof not."""
    scene = P.Scene()
    scene.add_polygon("post", [[12 - 0.02, 0.0]])
    checker = P.Checker(P.Robot([[8, -0.005], [12, -0.005], [12, 0.005], [8, 0.005]]), scene)
    q0, q1 = [0, 0, -0.09], [0, 0, 0.09]
    line = Line(0, 0.0, 1.0, -1, False, np.array([-2.03, 0.0]), 0.056, 0.0486)
    monkeypatch.setattr(
        type(checker.motion_certifier), "passage", lambda *_: Passage(True, 1.0, -1.0, -1, (line,), 1.0)
    )
    proof = checker._prover.proof(
        *(np.array(q, dtype=float) for q in (q0, q1, q1)), 1e-4, np.zeros((0, 11)), "straight", None
    )
    found = proof.verify()
    assert not found
    assert "post" in found.fault


def test_circles_count_all_the_way():
    """Far apart at both ends of a turn, and in the middle of it."""
    scene = P.Scene()
    scene.add_polygon("post", [[10.0, 0.0]])
    scene.add_polygon("other", [[-30.0, 0.0]])
    checker = P.Checker(P.Robot([[9.9, -0.1], [10.1, -0.1], [10.1, 0.1], [9.9, 0.1]]), scene)
    (proof,) = checker.certify_motions([[0, 0, 0.5]], [[0, 0, 1.5]])
    balls = tuple(Entry(pair, 0.0, 1.0, "balls") for pair in range(2))
    assert replace(proof, entries=balls).verify()
    for ends in ([0, 0, -1.0], [0, 0, 1.5]), ([0, 0, -1.4], [0, 0, 1.4]), ([0, 0, -0.5], [0, 0, 0.1]):
        q0, q1 = (tuple(map(float, q)) for q in ends)
        found = replace(proof, motion=replace(proof.motion, start=q0, end=q1, asked_end=q1), entries=balls).verify()
        assert "post" in found.fault


def test_a_curves_end_counts_by_itself():
    checker = shipped("truck_trailer", "parking")
    for _, _, proof in free_motions(checker, 3, 12, 0.4, curve="dubins", turning_radius=6.0):
        for pair in (0, len(proof.model.pairs) - 1):
            entries = tuple(e for e in proof.entries if (e.pair, e.start) != (pair, 1.0))
            assert len(entries) == len(proof.entries) - 1
            assert "not to the end" in replace(proof, entries=entries).verify().fault


def test_pieces_that_do_not_meet_are_found_out():
    checker, seen = shipped("forklift", "parking"), 0
    for _, _, proof in free_motions(checker, 20, 13, 0.4, curve="reeds_shepp", turning_radius=1.5):
        pieces = proof.motion.pieces
        for k in range(1, len(pieces) - 1):
            shifted = replace(pieces[k], origin=(pieces[k].origin[0] + 1e-6, pieces[k].origin[1]))
            found = replace(proof, motion=replace(proof.motion, pieces=changed(pieces, k, shifted))).verify()
            assert pieces[k].slip > 1e-7 or "do not meet" in found.fault
            seen += 1
    assert seen > 10


def test_deviations_hold_by_sampling():
    """Points of random trees leave their chords by no more than said, on lines and arcs, seen from any link."""
    generator, tight = np.random.default_rng(14), 0
    flint.ctx.prec = 192
    for _ in range(60):
        links = some_tree(generator, 0.2, 10.0 ** generator.uniform(-2, 1))
        robot = P.Robot(links)
        if robot.nq == 0:
            continue
        model = P.Checker(robot, P.Scene())._prover._model
        q0 = generator.uniform(-1, 1, robot.nq)
        q1 = q0 + generator.normal(size=robot.nq) * 10.0 ** generator.uniform(-2, -0.5)
        pieces, radius = (), 0.0
        if robot.is_free and generator.random() < 0.6:
            radius = 10.0 ** generator.uniform(-1, 1)
            turn = float(generator.normal() * 0.3)
            pieces = (Piece(0.0, 1.0, (0.1, 0.2), (0.0, 0.0), float(q0[2]), turn, (0.0, radius), 0.0),)
        ends = tuple(q0.tolist()), tuple(q1.tolist())
        motion = PlanarMotion(*ends, ends[1], "dubins" if pieces else "straight", radius, pieces)
        paths, (low, high) = Paths(model, motion), np.sort(generator.uniform(0, 1, 2)).tolist()
        (span,) = paths.spans(low, high)
        for body in model.bodies:
            extent = float(np.hypot(*body.vertices.T).max())
            frame = body.link
            while frame >= 0:
                frame = model.links[frame].parent
                seen = []
                for t in np.linspace(low, high, 9):
                    q = (1 - t) * q0 + t * q1
                    if pieces:
                        q[2] = q0[2] + t * turn
                        root = complex(0.1, 0.2) + cmath.exp(1j * q[2]) * radius * 1j
                        q[:2] = root.real, root.imag
                    frames = list(link_frames(links, q).values())
                    world = frames[body.link][1] + frames[body.link][0] * (body.vertices @ [1, 1j])
                    seen.append(world if frame < 0 else (world - frames[frame][1]) / frames[frame][0])
                seen = np.array(seen)
                parts = np.linspace(0, 1, 9)[:, None]
                off = np.abs(seen - (1 - parts) * seen[0] - parts * seen[-1]).max()
                said = paths.deviation(span, frame, body.link, extent)
                assert off <= said + 1e-12
                tight += off > 0.5 * said > 1e-9
    assert tight > 40


def test_circles_count_with_both_radii():
    """Circles that overlap by less than either radius prove nothing."""
    scene = P.Scene()
    scene.add_box("post", [0.2, 0.2], P.pose_of([10.0, 0.0]))
    checker = P.Checker(P.Robot([[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]]), scene)
    (proof,) = checker.certify_motions([[9.0, 0, 0]], [[9.0, 0, 0.01]])
    balls = (Entry(0, 0.0, 1.0, "balls"),)
    radius = proof.model.bodies[0].reach
    for gap, expected in ((1e-3, True), (-1e-3, False), (-0.9 * radius, False)):
        q = 10.0 - 2 * radius - gap, 0.0, 0.0
        found = replace(proof, motion=replace(proof.motion, start=q, end=q, asked_end=q), entries=balls).verify()
        assert bool(found) == expected, found.fault


def test_pieces_are_gone_through_at_one_speed():
    """Another share of the parameter for a piece: the hinges would be elsewhere."""
    checker, seen = shipped("truck_trailer", "parking"), 0
    for _, _, proof in free_motions(checker, 15, 11, 0.4, curve="reeds_shepp", turning_radius=6.0):
        pieces = proof.motion.pieces
        for k in range(len(pieces) - 1):
            middle = pieces[k].end + 0.3 * (pieces[k + 1].end - pieces[k].end)
            moved = (
                *pieces[:k],
                replace(pieces[k], end=middle),
                replace(pieces[k + 1], start=middle),
                *pieces[k + 2 :],
            )
            found = replace(proof, motion=replace(proof.motion, pieces=moved)).verify()
            assert (pieces[k + 1].end - pieces[k].end < 1e-4) or "speed" in found.fault
            seen += 1
    assert seen > 10


def test_a_curve_without_its_joints_way_is_found_out(monkeypatch):
    """Where the root stands, a curve of no pieces leaves out what the hinge sweeps."""
    scene = P.Scene()
    scene.add_polygon("post", [[-6.0, 0.0]])
    checker = P.Checker(P.Robot.load("truck_trailer"), scene)
    end = np.array([[1.0, 1.0, 0, 0, 0, 0, 0.0, 0, 0, 0, 0]])
    monkeypatch.setattr(Curves, "pieces", lambda *_: end)
    (proof,) = checker.certify_motions([[0, 0, 0, -1.0, 0]], [[0, 0, 0, 1.0, 0]], curve="dubins", turning_radius=6.0)
    assert not proof.verify()


def test_a_curve_without_slip_or_with_another_kind_is_found_out():
    """Arcs that turn too tightly, lines across the heading, and driving backwards on a Dubins curve."""
    checker = shipped("forklift", "parking")
    kind = {"curve": "reeds_shepp", "turning_radius": 1.5}
    backwards = 0
    for _, _, proof in free_motions(checker, 20, 9, 0.5, **kind):
        forwards = [
            piece.way[0] * math.cos(piece.heading) + piece.way[1] * math.sin(piece.heading) - piece.turn * piece.arm[1]
            for piece in proof.motion.pieces
        ]
        dubins = replace(proof, motion=replace(proof.motion, curve="dubins"))
        assert bool(dubins.verify()) == (min(forwards) > -1e-9)
        backwards += min(forwards) < -1e-3
        straight = replace(proof, motion=replace(proof.motion, curve="straight"))
        assert not straight.verify()
        tight = replace(proof, motion=replace(proof.motion, turning_radius=1.6))
        assert not any(any(p.arm) for p in proof.motion.pieces) or not tight.verify()
    assert backwards > 3


def test_entries_are_few():
    """What verifying takes depends on that."""
    cases = free_motions(shipped("truck_trailer", "parking"), 10, 10)
    assert np.mean([len(proof.entries) for _, _, proof in cases]) < 300


# ----- the model beside files


def test_models_of_shipped_robots_are_those_of_their_files(tmp_path):
    checker = shipped("truck_trailer", "parking")
    (_, _, proof) = free_motions(checker, 1, 1, 0.4)[0]
    assert proof.verify("truck_trailer", "parking")
    assert not proof.verify("forklift", "parking")
    assert "bodies" in proof.verify("truck_trailer", "warehouse").fault
    proof.save(tmp_path / "x.json")
    files = ["--robot", "truck_trailer", "--scene"]
    assert main(["verify", str(tmp_path / "x.json"), *files, "parking"]) == 0
    assert main(["verify", str(tmp_path / "x.json"), *files, "warehouse"]) == 1


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda m: {"links": (replace(m.links[0], x=1e-9), *m.links[1:])}, "links"),
        (lambda m: {"bodies": (replace(m.bodies[0], vertices=m.bodies[0].vertices * 0.999), *m.bodies[1:])}, "bodies"),
        (lambda m: {"bodies": (m.bodies[1], m.bodies[0], *m.bodies[2:])}, "bodies"),
        (lambda m: {"bodies": m.bodies[:-1]}, "bodies"),
        (lambda m: {"whole_turns": ()}, "configurations"),
        (lambda m: {"pairs": m.pairs[1:]}, "1 pairs"),
        (lambda m: {"pairs": (m.pairs[1], *m.pairs[1:])}, "1 pairs"),
    ],
)
def test_models_that_differ_from_their_files_are_refused(change, message):
    model = planar_model(shipped("truck_trailer", "parking"))
    confirm_model(model, "truck_trailer", "parking")
    with pytest.raises(UnprovedError, match=message):
        confirm_model(replace(model, **change(model)), "truck_trailer", "parking")


@pytest.mark.parametrize("vertices", [np.array([[-(2**63), 0], [0, 0]]), np.zeros((1, 2), dtype=np.float32)])
def test_vertices_that_are_no_doubles_are_refused(vertices):
    (_, _, proof) = free_motions(shipped("forklift", "parking"), 1, 1, 0.4)[0]
    bodies = (replace(proof.model.bodies[0], vertices=vertices), *proof.model.bodies[1:])
    model = replace(proof.model, bodies=bodies)
    assert "array of doubles" in replace(proof, model=model, hashes=hashes_of(model)).verify().fault


def test_deviations_below_the_range_of_doubles_count():
    """Two thousand links of the least length swing through a post: what each leaves its chord by rounds to 0."""
    least, links, swing = 5e-324, 2000, 0.35
    chain = [PlanarLink("link0", -1, "revolute", 0, 0.0, 0.0, 0.0)]
    chain += [PlanarLink(f"link{k}", k - 1, "fixed", 1, least, 0.0, 0.0) for k in range(1, links + 1)]
    # The post reaches from beyond the tip's arc into it; its circle is clear of the arc's chord.
    outside = np.array([round(links * math.cos(swing)) + 100, -round(links * math.sin(swing))])
    inside = np.round(outside * (links - 1) / np.hypot(*outside))
    assert np.hypot(*inside) < links < np.hypot(*outside)
    assert math.atan2(-inside[1], inside[0]) < swing
    rows, centre = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0), tuple((outside * least).tolist())
    bodies = (
        PlanarBody("tip", "tip", links, rows, np.zeros((1, 2)), (0.0, 0.0), 0.0),
        PlanarBody("post", "post", -1, rows, np.array([outside, inside]) * least, centre, 97 * least),
    )
    model = PlanarModel(tuple(chain), bodies, ((0, 1),), (), 1)
    motion = PlanarMotion((-swing,), (swing,), (swing,))
    entries = (Entry(0, 0.0, 1.0, "balls"),)
    assert not Proof("plane", "r", "s", hashes_of(model), model, motion, 0.0, entries).verify()
