"""Batches of poses of the same two bodies, against the same pairs alone, in other orders and without cached planes."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from solids import random_poses

import plannercheck as pc
from plannercheck.bodies.certificates import separation
from plannercheck.bodies.exact_planes import PosedBody, direction_of
from plannercheck.bodies.tuning import pair_options
from plannercheck.common.core import core
from plannercheck.evaluation.stress.body_families import family
from plannercheck.evaluation.stress.contact_poses import Solid, contact_poses

GAPS = (1e-1, 1e-4, 1e-9, 1e-15, 0.0, -1e-12, -1e-2)
EACH = 12

# Scanned, walked by wedges at hubs, flat, a box, inflated.
BODIES = {
    "round": pc.Polytope(family("round", 3500, 1)),
    "ellipsoid": pc.Polytope(family("round", 4000, 2) * [1.0, 0.7, 0.5]),
    "cone": pc.Polytope(family("cone", 4500, 3)),
    "fan": pc.Polytope(family("fan", 3500, 4)),
    "lattice": pc.Polytope(family("lattice", 4500, 5)),
    "box": pc.Polytope(family("box", 8, 6)),
    "swollen": pc.Polytope(family("round", 3000, 7), inflation_radius=0.05),
    "round by hierarchies": pc.Polytope(family("round", 3000, 8)).without_cells(),
    "ellipsoid by hierarchies": pc.Polytope(family("round", 3500, 9) * [1.0, 0.7, 0.5]).without_cells(),
    "cone by hierarchies": pc.Polytope(family("cone", 4500, 3)).without_cells(),
}
PAIRS = [
    ("round", "ellipsoid"),
    ("ellipsoid", "ellipsoid"),
    ("cone", "round"),
    ("cone", "cone"),
    ("fan", "ellipsoid"),
    ("lattice", "round"),
    ("box", "ellipsoid"),
    ("swollen", "round"),
    ("box", "box"),
    ("round by hierarchies", "ellipsoid by hierarchies"),
    ("cone by hierarchies", "round by hierarchies"),
    ("ellipsoid by hierarchies", "round"),
]


SIZES = (1, 2, 3, 5, 6, 7, 50)


def posed(first, second):
    """Near contact and at random: poses (n, 4, 4) of both bodies."""
    p, r = (Solid("", b.vertices, b.faces.astype(np.int64)) for b in (first, second))
    rng = np.random.default_rng(1)
    near, anywhere = contact_poses(p, r, np.repeat(GAPS, EACH), rng), random_poses(p, r, 4 * EACH, rng)
    return tuple(np.concatenate([a, b]) for a, b in zip(near, anywhere, strict=True))


def certified(first, second, poses_p, poses_r, options):
    """Verdict, stage and certificate of each pair; arrays as bytes."""
    found = core.certify_batch(first.core, poses_p, second.core, poses_r, options)
    return [{key: v.tobytes() if isinstance(v, np.ndarray) else v for key, v in pair.items()} for pair in found]


def judged(first, second, poses_p, poses_r, options):
    """Verdicts, stages and counters."""
    shared, stages, counters = core.intersect_batch(first.core, poses_p, second.core, poses_r, options)
    return shared.tolist(), stages.tolist(), counters


def test_batches_of_any_size_and_order():
    P, R = BODIES["round"], BODIES["ellipsoid"]
    poses_p, poses_r = posed(P, R)
    options = pair_options(cached_plane=False)
    whole = certified(P, R, poses_p, poses_r, options)
    for size in SIZES:
        parts = [slice(k, k + size) for k in range(0, len(whole), size)]
        assert [pair for s in parts for pair in certified(P, R, poses_p[s], poses_r[s], options)] == whole
    order = np.random.default_rng(2).permutation(len(whole))
    assert certified(P, R, poses_p[order], poses_r[order], options) == [whole[k] for k in order]
    assert certified(P, R, poses_p[:0], poses_r[:0], options) == []


def test_a_pose_for_all():
    P, R = BODIES["ellipsoid"], BODIES["round"]
    poses_p, poses_r = posed(P, R)
    options = pair_options(cached_plane=False)
    alone = [certified(P, R, pose[None], poses_r[:1], options)[0] for pose in poses_p]
    assert certified(P, R, poses_p, poses_r[:1], options) == alone


def walk(poses_p, poses_r, step, each):
    """Each pose of P followed by a walk of `each` steps in rad and m; R stays meanwhile."""
    rng = np.random.default_rng(3)
    walks = []
    for pose in poses_p:
        turns, shifts = (rng.normal(size=3) * step / 2 for _ in range(2))
        for k in range(each):
            moved = pose.copy()
            moved[:3, :3] = Rotation.from_rotvec(k * turns).as_matrix() @ pose[:3, :3]
            moved[:3, 3] += k * shifts
            walks.append(moved)
    return np.array(walks), np.repeat(poses_r, each, axis=0)


@pytest.mark.parametrize(("first", "second"), PAIRS)
@pytest.mark.parametrize("step", [0.0, 1e-3, 3e-2, None])
def test_verdicts_do_not_depend_on_which_planes_are_cached(first, second, step):
    P, R = BODIES[first], BODIES[second]
    poses = posed(P, R)
    if step is not None:
        poses = walk(*(rows[:: EACH // 3] for rows in poses), step, 8)
    cached = judged(P, R, *poses, pair_options())
    assert cached[0] == judged(P, R, *poses, pair_options(cached_plane=False))[0]
    assert judged(P, R, *poses, pair_options()) == cached


@pytest.mark.parametrize(("first", "second"), [("round", "ellipsoid"), ("fan", "ellipsoid")])
@pytest.mark.parametrize("step", [1e-3, 2e-2])
def test_planes_that_poses_nearby_have_left_separate(first, second, step):
    P, R = BODIES[first], BODIES[second]
    poses_p, poses_r = walk(*(rows[:: EACH // 2] for rows in posed(P, R)), step, 8)
    options = pair_options(turned_axis=False)  # which leaves planes little to do
    found = core.certify_batch(P.core, poses_p, R.core, poses_r, options)
    assert "cached plane" in {pair["stage"] for pair in found}
    for pair, pose_p, pose_r in zip(found, poses_p, poses_r, strict=True):
        if pair["stage"] == "cached plane":
            bodies = (
                PosedBody(P.vertices, pose_p, P.inflation_radius),
                PosedBody(R.vertices, pose_r, R.inflation_radius),
            )
            assert separation(direction_of(pair["normal"]), bodies) is not None


def test_the_better_conditioned_body_bs():
    """Planes are kept in its frame, so that the first one separates the other body at all of its turns."""
    P, R = BODIES["round"], BODIES["ellipsoid"]  # the first one B
    poses = np.repeat(np.eye(4)[None], 40, axis=0)
    poses[:, :3, :3] = Rotation.random(40, random_state=3).as_matrix()
    poses[:, 0, 3] = 10
    shared, stages, _ = core.intersect_batch(P.core, np.eye(4)[None], R.core, poses, pair_options(centre_axis=False))
    assert not shared.any()
    assert (stages[1:] == 0).all()


@pytest.mark.parametrize("vertices", [32, 4000])
def test_far_pairs_without_certificates(vertices):
    """Of balls that are apart a batch of verdicts takes none: as with certificates, and as the solver says."""
    P, R = (pc.Polytope(family("round", vertices, seed)) for seed in (1, 2))
    poses = np.repeat(np.eye(4)[None], 40, axis=0)
    poses[:, 0, 3] = np.linspace(0.9, 1.1, 40)  # the balls touch at 1
    away = np.eye(4)[None]
    shared, stages, _ = core.intersect_batch(P.core, poses, R.core, away, pair_options(cached_plane=False))
    certified = core.certify_batch(P.core, poses, R.core, away, pair_options(cached_plane=False))
    assert [verdict["shared"] for verdict in certified] == shared.astype(bool).tolist()
    assert (stages[-15:] == 2).all()  # the axis between the centres
    assert {verdict["stage"] for verdict in certified[-15:]} == {"centre axis"}
    plain, _, _ = core.intersect_batch(P.core, poses, R.core, away, pair_options(centre_axis=False))
    assert plain.tolist() == shared.tolist()
    assert 0 < shared.sum() < 40
