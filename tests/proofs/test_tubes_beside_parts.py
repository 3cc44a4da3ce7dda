"""Free trajectories with nearly the largest tube have a proof, also beside sets of parts."""

from pathlib import Path

import numpy as np
import pytest
from support.moving_scenes import arm_urdf, random_pose

import plannercheck as pc

_CORNERS = np.array([[x, y, z] for x in (0, 0.1) for y in (0, 0.1) for z in (0, 0.1)])


@pytest.mark.parametrize("seed", [2, 5, 11])
def test_what_is_free_has_a_proof(tmp_path: Path, seed: int) -> None:
    """The links between two bodies see a tube displace them less than the bodies themselves do."""
    pytest.importorskip("flint")
    rng = np.random.default_rng(seed)
    (tmp_path / "arm.urdf").write_text(arm_urdf(rng, 3))
    robot, scene = pc.Robot.from_urdf(tmp_path / "arm.urdf"), pc.Scene("cloud")
    scene.add("cloud", pc.PointCloud(_CORNERS + rng.uniform(-0.7, 0.7, 3), 0.01))
    scene.add_box("box", (0.1, 0.1, 0.1), random_pose(rng))
    checker = pc.Checker(robot, scene)
    q = robot.random_configurations(40, rng)
    for start in q[checker.check_states(q)][:4]:
        trajectory = pc.Trajectory.bezier([0, 1], (start + rng.normal(size=(3, 3)) * 0.02)[None])
        verdict = checker.explain_trajectory(trajectory)
        assert verdict
        proofs = checker.certify_trajectory(trajectory, tube=0.999 * verdict.largest_tube)
        assert proofs is not None
        assert all(proof.verify() for proof in proofs)
