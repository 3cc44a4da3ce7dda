"""Faults put back into what makes or confirms proofs of planar motions: each is found out."""

import cmath
import math
from dataclasses import replace

import flint
import numpy as np
from planar_contacts import link_frames, some_tree
from planar_proof_cases import P, changed, free_motions, shipped

from plannercheck.motions.certifier_answers import MotionResult
from plannercheck.motions.certifier_answers import Proof as Line
from plannercheck.planar.curves import Curves
from plannercheck.proofs import Entry
from plannercheck.proofs.planar_paths import Paths
from plannercheck.proofs.planar_proof import Piece, PlanarMotion


def test_a_certifier_with_long_directions_is_found_out(monkeypatch):
    """A gap times a direction of 2 m, compared with metres: the bar through the post is called free, the proof not."""
    scene = P.Scene()
    scene.add_polygon("post", [[12 - 0.02, 0.0]])
    checker = P.Checker(P.Robot([[8, -0.005], [12, -0.005], [12, 0.005], [8, 0.005]]), scene)
    q0, q1 = [0, 0, -0.09], [0, 0, 0.09]
    line = Line(0, 0.0, 1.0, -1, False, np.array([-2.03, 0.0]), 0.056, 0.0486)
    monkeypatch.setattr(
        type(checker.motion_certifier), "motion_result", lambda *_: MotionResult(True, 1.0, -1.0, -1, (line,), 1.0)
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
