"""Proofs of motions among sets of parts, as checkers and commands make them: near parts, carried, in cavities."""

import itertools
import warnings
from dataclasses import replace

import flint
import numpy as np
import pytest
from flint import arb_mat
from proof_cases import proofs_where_free
from set_proof_cases import END, SETS, START, replaced, scene_of, set_of, with_set

import plannercheck as pc
from plannercheck.cli.main import main
from plannercheck.motions import part_covers
from plannercheck.proofs.entries import EntryChecker
from plannercheck.proofs.faults import UnprovedError
from plannercheck.proofs.nesting import check_not_nested
from plannercheck.proofs.well_formed import hashes_of


def test_free_motions_near_parts_are_proved(panda):
    rng = np.random.default_rng(3)
    points = rng.uniform((0.25, -0.6, 0.0), (0.8, 0.6, 1.0), size=(80, 3))
    scene = pc.Scene("near")
    scene.add("camera", pc.PointCloud(points, rng.uniform(0.002, 0.03, 80)))
    checker = pc.Checker(panda, scene, padding={"panda_hand": 0.003})
    start = panda.random_configurations(60, seed=5)
    end = np.clip(start + 0.2 * rng.normal(size=start.shape), panda.lower, panda.upper)
    proofs_where_free(checker, start, end, least=6)


def proof_with_carried(panda, scene, name, cloud):
    """Of the motion from START to END with a cloud on the hand, which may touch the hand and its neighbours."""
    scene.attach(name, "panda_hand", parts=cloud)
    for link in ("panda_hand", "panda_leftfinger", "panda_rightfinger", "panda_link7", "panda_link8"):
        scene.allow(name, link)
    checker = pc.Checker(panda, scene)
    assert checker.check_motion(START, END)
    (proof,) = checker.certify_motions(START[None], END[None])
    assert proof.verify()
    return proof


def test_two_sets_are_proved_apart(panda):
    rng = np.random.default_rng(3)
    scene = scene_of(SETS["balls"]())
    proof = proof_with_carried(panda, scene, "held", pc.PointCloud(rng.normal(size=(12, 3)) * 0.05 + [0, 0, 0.2], 0.01))
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
    proof = proof_with_carried(panda, scene, "row", pc.PointCloud(row, np.linspace(0.001, 0.01, 30)))
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
        with pytest.raises(UnprovedError, match="is inside 'shell'"):
            check_not_nested(held, identity, small, identity)


def test_solids_before_a_cloud_are_proved():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of open meshes
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


@pytest.mark.parametrize("kind", SETS)
def test_commands_prove_and_verify_before_a_cloud(kind, tmp_path, capsys):
    scene_of(SETS[kind]()).save(tmp_path / "sensed.yaml")
    np.save(tmp_path / "path.npy", np.array([START, END]))
    where = ["--robot", "panda", "--scene", str(tmp_path / "sensed.yaml")]
    path = ["--path", str(tmp_path / "path.npy"), "--proof", str(tmp_path / "path.proof.npz")]
    assert main(["validate", *where, *path, "--certify"]) == 0
    assert "certified" in capsys.readouterr().out
    assert main(["verify", str(tmp_path / "path.proof.npz")]) == 0
    assert main(["verify", str(tmp_path / "path.proof.npz"), *where]) == 0
    assert "confirmed" in capsys.readouterr().out
    assert main(["verify", str(tmp_path / "path.proof.npz"), "--robot", "panda", "--scene", "table"]) == 1
