"""Proofs of motions before half-spaces: an extreme vertex stays over the plane; no other plane counts."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from flint import arb, arb_mat
from proof_cases import STILL, at, claim, plane, point, proofs_where_free, turn
from set_proof_cases import refused, replaced, with_bodies

import plannercheck as pc
from plannercheck.bodies.posed_half_spaces import PosedHalfSpace
from plannercheck.cli.main import main
from plannercheck.proofs import Entry, Joint, PosedBody, load_proofs
from plannercheck.proofs.half_spaces import plane_of
from plannercheck.proofs.verify import model_confirmed

OVER = Entry(0, 0.0, 1.0, "half-space")


def floor(normal=(0.0, 0.0, 1.0), offset=0.0, pose=STILL, radius=0.0):
    return PosedBody(
        "floor", "floor", -1, pose, np.zeros(0), radius, 0.0, (0.0, 0.0, 0.0), 0.0, half_space=(*normal, offset)
    )


def room(height=0.1, pose=None):
    scene = pc.Scene("room")
    scene.add("floor", pc.HalfSpace((0.0, 0.0, 2.0), 2 * height), pose)
    scene.add("wall", pc.HalfSpace((2.0, 1.0, 0.0), -0.8))
    for name in ("floor", "wall"):
        scene.allow(name, "panda_link0")
    return scene


@pytest.mark.parametrize("padding", [0.0, 0.02])
def test_motions_over_half_spaces_are_proved(panda, padding):
    checker, rng = pc.Checker(panda, room(), padding=padding), np.random.default_rng(0)
    start = panda.random_configurations(60, seed=1)
    end = np.clip(start + 0.3 * rng.normal(size=start.shape), panda.lower, panda.upper)
    for proof in proofs_where_free(checker, start, end, least=10):
        assert any(entry.by == "half-space" for entry in proof.entries)


def test_solids_over_half_spaces_are_proved():
    robot = pc.Robot.load("ur10", geometry={"forearm_link": "solid"})
    scene = pc.Scene("floor")
    scene.add("floor", pc.HalfSpace((0.0, 0.0, 1.0), -0.2))
    q = np.array([0.0, -1.5, 1.5, 0.0, 0.0, 0.0])
    (proof,) = pc.Checker(robot, scene).certify_motions(q[None], q[None] + 0.2)
    assert any(body.triangles for body in proof.model.bodies)
    assert proof.verify(), proof.verify().fault


def tip_over(height, flipped=False, floors=None, **options):
    """A point at the end of an arm of 1 m swings about y; its lowest point is in the middle, 1 m below the axis."""
    bodies = [point("tip", 0, at(z=-1.0)), floor(offset=height) if floors is None else floors]
    bodies = bodies[::-1] if flipped else bodies
    return claim([turn(axis=(0.0, 1.0, 0.0))], bodies, (-0.3,), (0.3,), [OVER], **options)


@pytest.mark.parametrize("flipped", [False, True])
def test_a_swing_into_the_floor_is_refused_and_over_it_confirmed(flipped):
    assert tip_over(-1 - 1e-4, flipped).verify()
    refused(tip_over(-1 + 1e-6, flipped), "the half-space's plane")


def test_margins_and_radii_count_along_normals_of_any_length():
    for length in (1e-6, 1.0, 1e6):
        floors = floor((0.0, 0.0, length), -1.001 * length)
        assert tip_over(0, floors=floors, margin=0.0009).verify()
        assert not tip_over(0, floors=floors, margin=0.0011).verify()
        assert tip_over(0, floors=replace(floors, radius=0.0009)).verify()
        assert not tip_over(0, floors=replace(floors, radius=0.0011)).verify()


def test_what_is_under_the_floor_is_in_it():
    assert tip_over(-1.001).verify()
    assert not tip_over(0, floors=floor((0.0, 0.0, -1.0), 2.0)).verify()  # all below z = 2, seen from below
    assert not tip_over(5.0).verify()


def test_only_the_plane_of_a_half_space_keeps_a_body_from_it():
    """The verifier sees a half-space as a point along its own normal: no other entry may use that."""
    proof = tip_over(-1.5)
    for entry in (plane((0.0, 0.0, 1.0)), plane((1.0, 0.0, 0.0)), Entry(0, 0.0, 1.0, "balls")):
        refused(replaced(proof, entries=(entry,)), "only a half-space's own plane")
    parts = replace(plane((0.0, 0.0, 1.0)), first=(0, 1))
    refused(replaced(proof, entries=(parts,)), "only a half-space's own plane")
    hulls = claim([turn()], [point("a", 0), point("b", -1, at(y=3.0))], (0.0,), (0.1,), [OVER])
    refused(hulls, "only a half-space's own plane")


def test_malformed_half_spaces_are_refused():
    proof = tip_over(-1.5)
    tip, good = proof.model.bodies
    for changed, words in (
        ({"half_space": (0.0, 0.0, 0.0, -1.5)}, "normal is 0"),
        ({"half_space": (0.0, 0.0, 1.0)}, "numbers"),
        ({"half_space": (0.0, 0.0, float("nan"), 0.0)}, "not finite"),
        ({"half_space": (0.0, 0.0, 1.0, -1e40)}, "beyond"),
        ({"vertices": np.zeros((1, 3))}, "vertices"),
        ({"link": 0}, "on a link"),
    ):
        refused(with_bodies(proof, (tip, replace(good, **changed))), words)
    refused(with_bodies(proof, (replace(good, name="other"), good)), "two half-spaces")


def test_missing_intervals_are_refused():
    whole = tip_over(-1.2)
    halves = (replace(OVER, end=0.5), replace(OVER, start=0.5))
    assert replaced(whole, entries=halves).verify()
    for entries in (halves[:1], halves[1:], ()):
        assert not replaced(whole, entries=entries).verify()


def test_planes_are_those_of_posed_half_spaces():
    """Against fractions, at poses that are off rigid as far as they may be."""
    rng = np.random.default_rng(3)
    for _ in range(40):
        pose = np.eye(4)
        q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        pose[:3, :3] = (q * np.sign(np.linalg.det(q))) * (1 + 2e-7 * rng.uniform(-1, 1, (3, 3)))
        pose[:3, 3] = rng.normal(size=3)
        numbers = rng.normal(size=4) * 10.0 ** rng.uniform(-3, 3)
        body = floor(tuple(numbers[:3].tolist()), float(numbers[3]), tuple(pose[:3].ravel().tolist()))
        normal, offset = PosedHalfSpace(numbers[:3], float(numbers[3]), pose).plane()
        seen, direction = plane_of(body)
        for x, true in zip(direction.column.entries(), (*normal, 0), strict=True):
            assert x.contains(ball(true))
        height = (direction.row * seen.place * arb_mat(4, 1, [0, 0, 0, 1]))[0, 0]
        assert height.contains(ball(offset))
        assert float(height.rad()) < 1e-10 * (1 + abs(float(offset)))


def ball(true):
    return arb(0) if true == 0 else arb(Fraction(true).numerator) / arb(Fraction(true).denominator)


def test_posed_half_spaces_are_compared_with_files(panda, tmp_path):
    tilted = np.eye(4)
    tilted[:3, :3] = [[1, 0, 0], [0, np.cos(0.1), -np.sin(0.1)], [0, np.sin(0.1), np.cos(0.1)]]
    checker = pc.Checker(panda, room(-0.3, tilted))
    q = np.array([0, -0.785, 0, -2.356, 0, 1.571, 0.785])
    (proof,) = checker.certify_motions(q[None], q[None] + 0.1)
    assert proof.verify()
    checker.scene.save(tmp_path / "room.yaml")
    room(-0.3).save(tmp_path / "level.yaml")
    room(-0.31, tilted).save(tmp_path / "lower.yaml")
    for suffix in (".json", ".npz"):
        proof.save(tmp_path / f"proof{suffix}")
        (again,) = load_proofs(tmp_path / f"proof{suffix}")
        assert again.entries == proof.entries
        assert again.verify("panda", str(tmp_path / "room.yaml"))
        assert not again.verify("panda", str(tmp_path / "level.yaml"))
        assert not again.verify("panda", str(tmp_path / "lower.yaml"))
    bodies = [
        replace(b, half_space=(*b.half_space[:3], b.half_space[3] - 0.5)) if b.half_space else b
        for b in proof.model.bodies
    ]
    lower = with_bodies(proof, bodies)
    assert lower.verify()  # true, but not of the file
    assert "another shape" in model_confirmed(lower, "panda", str(tmp_path / "room.yaml")).fault


def test_commands_prove_and_verify_motions_over_a_floor(panda, tmp_path, capsys):
    room(-0.1).save(tmp_path / "room.yaml")
    q = np.array([0, -0.785, 0, -2.356, 0, 1.571, 0.785])
    np.save(tmp_path / "path.npy", np.array([q, q + 0.1]))
    where = ["--robot", "panda", "--scene", str(tmp_path / "room.yaml")]
    assert main(["validate", *where, "--path", str(tmp_path / "path.npy"), "--certify"]) == 0
    assert main(["verify", str(tmp_path / "path.proof.json"), *where]) == 0
    assert "confirmed" in capsys.readouterr().out


def test_slides_towards_a_half_space_are_proved_up_to_it():
    slide = Joint("x", "slide", -1, STILL, (1.0, 0.0, 0.0), (0,), (1.0,), (0.0,))
    wall = floor((-3.0, 0.0, 0.0), -3.0)  # x >= 1
    for end, expected in ((0.999, True), (1.001, False)):
        assert bool(claim([slide], [point("tip", 0), wall], (0.0,), (end,), [OVER]).verify()) == expected
