"""Proofs loaded in a process of their own: verified without the checker, compared with files on request."""

import subprocess
import sys

import numpy as np
from proof_cases import free_motions

import plannercheck as pc

ALONE = """
import sys
from plannercheck.proofs import Proof

proof = Proof.load(sys.argv[1])
assert proof.verify()
own = {name.split(".")[1] for name in sys.modules if name.startswith("plannercheck.")}
assert own == {"common", "proofs"}, own
right, wrong = sys.argv[2:4], sys.argv[4:6]
assert proof.verify(*right), proof.verify(*right).fault
assert proof.verify(right[0], scene=right[1])
print(proof.verify(*wrong).fault)
"""


def verified_alone(proof, folder, right, wrong):
    """What a process that imports nothing but the proofs finds wrong with another robot and scene."""
    proof.save(folder / "alone.json")
    command = [sys.executable, "-c", ALONE, str(folder / "alone.json"), *right, *wrong]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_a_proof_in_space_finds_its_files(tmp_path):
    checker = pc.Checker(pc.Robot.load("ur5"), pc.Scene.load("table"))
    proof = checker.certify_motions(*free_motions(checker, 1, 1))[0]
    assert "links" in verified_alone(proof, tmp_path, ("ur5", "table"), ("panda", "table"))


def test_a_proof_in_the_plane_finds_its_files(tmp_path):
    checker = pc.planar.Checker(pc.planar.Robot.load("truck_trailer"), pc.planar.Scene.load("parking"))
    q = checker.robot.random_configurations(500, 5)
    free = q[checker.check_states(q)][:1]
    proof = checker.certify_motions(free, free + 1e-3 * np.eye(q.shape[1])[0])[0]
    wrong = ("truck_trailer", "warehouse")
    assert "bodies" in verified_alone(proof, tmp_path, ("truck_trailer", "parking"), wrong)
