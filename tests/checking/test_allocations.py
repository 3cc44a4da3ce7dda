"""Nothing is allocated while configurations are judged, however many: counted by a library that replaces malloc.

Exact arithmetic may allocate: of a whole pair, and of two vertices that are equally far along a direction even for
doubled precision (the boxes of Baxter's torso meet such ties, once in some hundred states). The states here need none.
"""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

COUNTED = """
import ctypes
import json
import sys
import numpy as np
import plannercheck as pc

counter = ctypes.CDLL(None).allocations_so_far
counter.restype = ctypes.c_long
robot = pc.Robot.load(sys.argv[1])
checker = pc.Checker(robot, pc.Scene.load(sys.argv[2]))
core, kernel = checker._tables.within_limits.core, robot.kinematics
q = robot.random_configurations(1000, 1)
few, ends, steps = q[:8].copy(), q + 0.01, np.full(1000, 10)
states, judge = q.tolist(), checker.state_validity()


def allocated(call, *arguments):
    call(*arguments)  # warms up
    before = counter()
    call(*arguments)
    return counter() - before


found = {
    "check_states": [allocated(core.check_states, kernel, rows, 1) for rows in (few, q)],
    "first_of_states": [allocated(core.first_of_states, kernel, rows, 1) for rows in (few, q)],
    "motions": [allocated(core.motions_are_free, kernel, q[:n], ends[:n], steps[:n]) for n in (8, 1000)],
    "is_valid": [allocated(lambda: any(checker.is_valid(row) is None for row in rows)) for rows in (few, q)],
    "state_validity": [allocated(lambda: any(judge(row) is None for row in rows)) for rows in (states[:8], states)],
}
counted = checker.statistics()
assert counted["exact"] == 0, counted
assert counted["solver"] > 0, counted
print(json.dumps(found))
"""

PAIRS = """
import ctypes
import json
import sys
import numpy as np
import plannercheck as pc
from plannercheck.common.core import core
from plannercheck.bodies.tuning import pair_options
from plannercheck.evaluation.stress.contact_poses import Solid, contact_poses
from solids import random_poses
from plannercheck.evaluation.stress.body_families import family

counter = ctypes.CDLL(None).allocations_so_far
counter.restype = ctypes.c_long
bodies = [pc.Polytope(family("round", 2000, seed) * np.array([1, 0.7, 0.5])) for seed in (1, 2)]
solids = [Solid("", b.vertices, b.faces.astype(np.int64)) for b in bodies]
rng = np.random.default_rng(1)
both = [contact_poses(*solids, np.full(500, 1e-3), rng), random_poses(*solids, 500, rng)]
order = rng.permutation(1000)
order[500:] = order[499]  # these follow one another
poses_p, poses_r = (np.concatenate(rows)[order] for rows in zip(*both))
found = {}
for cached_plane in (False, True):
    options = pair_options(cached_plane=cached_plane)
    for n in (8, 1000):
        arguments = bodies[0].core, poses_p[:n].copy(), bodies[1].core, poses_r[:n].copy(), options
        core.intersect_batch(*arguments)  # warms up
        before = counter()
        _, stages, _ = core.intersect_batch(*arguments)
        found.setdefault(str(cached_plane), []).append(counter() - before)
assert {2, 3} <= set(stages.tolist()) <= {0, 2, 3}, stages  # none but planes, axes and the solver
print(json.dumps(found))
"""


@pytest.fixture(scope="module")
def counter(tmp_path_factory):
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None or not sys.platform.startswith("linux"):
        pytest.skip("needs a C compiler and glibc")
    library = tmp_path_factory.mktemp("counter") / "malloc_counter.so"
    source = Path(__file__).parents[1] / "support" / "malloc_counter.c"
    subprocess.run([compiler, "-shared", "-fPIC", "-O1", "-o", str(library), str(source)], check=True)
    return library


def counted(counter, program, *arguments):
    """What a program prints that runs with the counter: numbers of allocations for few and for many, by call."""
    support = os.pathsep.join([str(Path(__file__).parents[1] / "support"), os.environ.get("PYTHONPATH", "")])
    environment = {**os.environ, "LD_PRELOAD": str(counter), "PYTHONPATH": support}
    run = subprocess.run(
        [sys.executable, "-c", program, *arguments], env=environment, capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stderr
    return json.loads(run.stdout)


@pytest.mark.parametrize(("robot", "scene"), [("panda", "bookshelf"), ("ur5", "kitchen"), ("talos", "empty")])
def test_a_thousand_states_allocate_no_more_than_eight(counter, robot, scene):
    for call, (few, many) in counted(counter, COUNTED, robot, scene).items():
        assert few <= (0 if call in ("is_valid", "state_validity") else 2), call  # the result: the core's and NumPy's
        assert many == few, call


def test_a_thousand_pairs_of_large_bodies_allocate_no_more_than_eight(counter):
    for cached_plane, (few, many) in counted(counter, PAIRS).items():
        assert many == few, f"cached plane: {cached_plane}"
