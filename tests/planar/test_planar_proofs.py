"""Proofs of motions in the plane: they are confirmed, are about motions of verdicts, and name their files' model."""

import cmath
import math
from dataclasses import replace

import flint
import numpy as np
import pytest
from planar_cases import chain, cluttered
from planar_contacts import contact_with_obstacle, link_frames, some_tree
from planar_motions import arm, states_of
from planar_proof_cases import CURVES, SHIPPED, STRAIGHT, P, free_motions, kinds, shipped

from plannercheck.cli.main import main
from plannercheck.common.errors import PlannercheckError
from plannercheck.planar.proof_builder import planar_model
from plannercheck.planar.proof_confirmation import confirm_model
from plannercheck.proofs import Entry, Proof, load_proofs, save_proofs
from plannercheck.proofs.faults import UnprovedError
from plannercheck.proofs.planar_paths import Paths
from plannercheck.proofs.planar_proof import PlanarBody, PlanarLink, PlanarModel, PlanarMotion
from plannercheck.proofs.planar_well_formed import hashes_of, least_margin

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


# ----- the model beside files


def test_models_of_shipped_robots_are_those_of_their_files(tmp_path):
    checker = shipped("truck_trailer", "parking")
    (_, _, proof) = free_motions(checker, 1, 1, 0.4)[0]
    assert proof.verify("truck_trailer", "parking")
    assert not proof.verify("forklift", "parking")
    assert "bodies" in proof.verify("truck_trailer", "warehouse").fault
    for given in ({"meshes": "solid"}, {"geometry": "solid"}):
        with pytest.raises(PlannercheckError, match="in the plane have no meshes"):
            proof.verify("truck_trailer", "parking", **given)
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
