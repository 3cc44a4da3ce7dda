"""Whether the core gives the same bits on another processor, from the same inputs.

    python tests/package/digest_of_given_inputs.py write inputs.npz    # on one machine: inputs, and a line of hashes
    python tests/package/digest_of_given_inputs.py read inputs.npz     # on the other: the line has to be the same

level_digest.py draws its inputs where it runs, and NumPy's linear algebra rounds differently on other processors.
"""

import json
import sys
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from level_digest import DRAWS, METHODS, ROBOTS, STATES, core, digest, pair_options, stress_draws

import plannercheck as pc
from plannercheck.robots.kinematics import JointTable


def written_inputs(path: Path) -> None:
    arrays: dict[str, np.ndarray] = {}
    for k, d in enumerate(stress_draws()):
        arrays |= {f"{k}.p": d.p.polytope.vertices, f"{k}.r": d.r.polytope.vertices}
        arrays |= {f"{k}.poses_p": d.poses_p, f"{k}.poses_r": d.poses_r}
    for name in ROBOTS:
        robot = pc.Robot.load(name)
        assert robot.joint_table is not None
        arrays |= {f"{name}.{field}": np.asarray(value) for field, value in robot.joint_table._asdict().items()}
        arrays[f"{name}.q"] = robot.random_configurations(STATES, 1)
    np.savez(path, **arrays)


def hashes(path: Path) -> dict[str, str]:
    """Of bodies built from the vertices, of verdicts and stages of these bodies at the poses, and of links' poses."""
    given = np.load(path)
    bodies, verdicts = [], []
    for k in range(DRAWS):
        p, r = (core.Polytope.from_points(np.ascontiguousarray(given[f"{k}.{name}"]), 0.0) for name in "pr")
        bodies += [p.serialise(), r.serialise()]
        for method in METHODS:
            found = core.intersect_batch(p, given[f"{k}.poses_p"], r, given[f"{k}.poses_r"], pair_options(method))
            verdicts += [found[0].tobytes(), found[1].tobytes()]
    return {"bodies": digest(bodies), "pairs": digest(verdicts), "poses": digest([poses(given, n) for n in ROBOTS])}


def poses(given: Mapping[str, np.ndarray], robot: str) -> bytes:
    table = [given[f"{robot}.{field}"] for field in JointTable._fields]
    kernel = core.Kinematics(*(value.item() if value.ndim == 0 else value for value in table))
    needed = np.ones(len(given[f"{robot}.link_joints"]), dtype=np.uint8)
    q = given[f"{robot}.q"]
    together_and_alone = [q, *q[:200, None]]  # one configuration is posed by code of its own
    return b"".join(np.asarray(kernel.link_poses(some, needed)).tobytes() for some in together_and_alone)


if __name__ == "__main__":
    how, file = sys.argv[1], Path(sys.argv[2])
    if how == "write":
        written_inputs(file)
    print(json.dumps(hashes(file)))
