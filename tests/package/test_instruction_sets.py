"""Every bit is the same on every instruction set, in any order and in batches of any size."""

import itertools
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.bodies.tuning import METHODS, Method, pair_options
from plannercheck.common.core import available_levels, core
from plannercheck.evaluation.stress.random_cases import draws

DIGEST = Path(__file__).with_name("level_digest.py")


def digest(level: str) -> dict[str, str]:
    # Without the cache, so that every level prepares the bodies itself.
    environment = {**os.environ, "PLANNERCHECK_LEVEL": level, "PLANNERCHECK_CACHE": "0"}
    folder = str(Path(pc.__file__).parents[1])
    environment["PYTHONPATH"] = os.pathsep.join([folder, environment.get("PYTHONPATH", "")])
    run = subprocess.run([sys.executable, str(DIGEST)], capture_output=True, text=True, check=True, env=environment)
    return dict(json.loads(run.stdout))


def test_all_levels_give_the_same_bits() -> None:
    levels = available_levels()
    if len(levels) < 2:
        pytest.skip(f"only {levels} can run here")
    first, *others = (digest(level) for level in levels)
    assert all(other == first for other in others)


@pytest.mark.parametrize("method", METHODS)
def test_pairs_in_any_order_and_alone(method: Method) -> None:
    options = pair_options(method)
    for drawn in itertools.islice(draws(7), 20):
        p, r = drawn.p.polytope.core, drawn.r.polytope.core
        poses = np.stack([drawn.poses_p, drawn.poses_r])
        verdicts = core.intersect_batch(p, poses[0], r, poses[1], options)[0]
        order = np.random.default_rng(1).permutation(len(verdicts))
        shuffled = core.intersect_batch(p, poses[0][order], r, poses[1][order], options)[0]
        alone = [core.intersect_batch(p, a[None], r, b[None], options)[0][0] for a, b in zip(*poses, strict=True)]
        turned_round = core.intersect_batch(r, poses[1], p, poses[0], options)[0]
        np.testing.assert_array_equal(shuffled, verdicts[order])
        np.testing.assert_array_equal(alone, verdicts)
        np.testing.assert_array_equal(turned_round, verdicts)


def test_states_in_any_order_and_batch_size(checker: pc.Checker) -> None:
    q = checker.robot.random_configurations(1001, 3)
    first, pairs = checker.first_colliding_pair(q), checker.colliding_pairs(q)
    order = np.random.default_rng(2).permutation(len(q))
    np.testing.assert_array_equal(checker.first_colliding_pair(q[order]), first[order])
    np.testing.assert_array_equal(checker.colliding_pairs(q[order]), pairs[order])
    for size in (1, 3, 64):
        some = [checker.first_colliding_pair(q[k : k + size]) for k in range(0, 300, size)]
        np.testing.assert_array_equal(np.concatenate(some)[:300], first[:300])
    np.testing.assert_array_equal(checker.first_colliding_pair(q, threads=3), first)


@pytest.mark.parametrize("name", ["panda", "talos"])
def test_link_poses_in_batches_of_any_size(name: str) -> None:
    robot = pc.Robot.load(name)
    q = robot.random_configurations(67, 4)
    poses = robot.link_poses(q)
    np.testing.assert_array_equal(poses[::-1], robot.link_poses(np.ascontiguousarray(q[::-1])))
    for k in (0, 1, 13, 66):
        np.testing.assert_array_equal(robot.link_poses(q[k]), poses[k])
    np.testing.assert_array_equal(np.concatenate([robot.link_poses(q[k : k + 3]) for k in range(0, 67, 3)]), poses)
