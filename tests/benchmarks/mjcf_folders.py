"""MJCF files of folders beside MuJoCo itself: poses of geoms, tested pairs, verdicts of the robot with its obstacles.

Run: `python tests/benchmarks/mjcf_folders.py FOLDER ... [--states 1000]`, for example with the folders of robosuite,
dm_control and gymnasium_robotics. Files that MuJoCo does not compile alone are left out.

Out: a row for each file: the largest difference of a geom's pose at random states in m (or of its matrix), pairs that
one of both tests alone, and how many of a fifth of the states collide for both or for one alone. These are settled by
our certificates: `ours apart` has a plane between all pairs that MuJoCo reports, with a gap of at least 0.1 mm, `ours
touch` a pair that still touches wherever one body is moved by 0.1 mm along an axis, `rim` is nearer than that, and
`open` is the rest. Exit code 1 unless poses agree to 1e-9, pairs are the same, and nothing is open.
"""

import argparse
import sys
import warnings
from collections import Counter
from pathlib import Path

import mujoco
import numpy as np

import plannercheck as pc
from plannercheck.checking.pair_table import pair_table

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))
import mujoco_oracle as oracle

# Nearer than this, m, neither the rims of our curved shapes nor MuJoCo's solvers, of 1e-6, tell.
_RIM = 1e-4


def main() -> int:
    options = _parser().parse_args()
    files = [path for folder in options.folders for path in sorted(folder.rglob("*.xml"))]
    print(f"{'file':<60} {'geoms':>6} {'pose, m':>9} {'pairs':>6} {'alone':>6} {'states':>7} verdicts")
    good, counts = True, Counter()
    for path in files:
        try:
            model = mujoco.MjModel.from_xml_path(str(path))
        except Exception:
            counts["not compiled by MuJoCo"] += 1
            continue
        try:
            scene = pc.Scene.from_mjcf(path)
            robot = pc.Robot.load(path) if model.njnt else None
        except pc.PlannercheckError as error:
            counts["refused"] += 1
            print(f"{_short(path):<60} refused: {error}")
            continue
        counts["compared" if robot else "obstacles alone"] += 1
        good &= robot is None or _compare(path, model, robot, scene, options.states)
    print(dict(counts))
    return 0 if good else 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folders", type=Path, nargs="+")
    parser.add_argument("--states", type=int, default=1000)
    return parser


def _short(path: Path) -> str:
    return "/".join(path.parts[-4:])[-60:]


def _compare(path: Path, model: mujoco.MjModel, robot: pc.Robot, scene: pc.Scene, states: int) -> bool:
    """Prints a file's row; whether all of it agrees."""
    data, names, rng = mujoco.MjData(model), oracle.geom_names(model), np.random.default_rng(0)
    bodies = [*robot.bodies, *scene.bodies]
    geoms = [names.index(body.name) for body in bodies]
    qpos = [oracle.random_qpos(model, rng) for _ in range(states)]
    q = np.array([oracle.as_q(model, each) for each in qpos])
    table = pair_table(robot, scene, True, "robot")
    pairs = [*table.pairs.tolist(), *table.static.tolist()]
    ours = {frozenset((bodies[a].name, bodies[b].name)): (a, b) for a, b in pairs}
    own = {body.name for body in robot.bodies}
    theirs = {pair for pair in oracle.tested_pairs(path) if pair & own}
    valid = pc.Checker(robot, scene).check_states(q)
    off, verdicts = 0.0, Counter()
    for k, each in enumerate(qpos):
        links = robot.link_poses(q[k])
        placed = [links[robot.link_index(b.link)] @ b.pose if b.link else b.pose for b in bodies]
        off = max(
            off,
            float(
                np.abs(np.reshape(placed, (-1, 4, 4)) - oracle.geom_poses(model, data, each)[geoms]).max(initial=0.0)
            ),
        )
        if k < states // 5:
            found = oracle.overlapping(model, data, each) & theirs
            verdicts += _verdicts(found, ours, bodies, placed, bool(valid[k]))
    alone = len(ours.keys() ^ theirs)
    row = f"{len(bodies):>6} {off:9.1e} {len(ours):>6} {alone:>6} {states:>7}"
    print(f"{_short(path):<60} {row} {dict(verdicts)}", flush=True)
    return off < 1e-9 and alone == 0 and not verdicts["open"]


def _verdicts(found: set, ours: dict, bodies: list, placed: list, valid: bool) -> Counter:
    """Whether a state collides for both; if for one alone, why, by the certificates of its pairs."""
    if valid == (not found):
        return Counter({"same": 1})
    if not valid:  # MuJoCo finds nothing
        touching = [pair for pair in ours.values() if _touch(bodies, placed, *pair)]
        return Counter({"ours touch" if any(_is_deep(bodies, placed, *pair) for pair in touching) else "rim": 1})
    gaps = []
    for a, b in (ours[name] for name in found):
        certificate = pc.certify(bodies[a].shape, bodies[b].shape, placed[a], placed[b])
        gaps.append(certificate.gap if isinstance(certificate, pc.Separation) else -1.0)
    return Counter({"open" if min(gaps) <= 0 else "rim" if min(gaps) < _RIM else "ours apart": 1})


def _touch(bodies: list, placed: list, a: int, b: int) -> bool:
    return bool(pc.intersects(bodies[a].shape, bodies[b].shape, placed[a], placed[b]))


def _is_deep(bodies: list, placed: list, a: int, b: int) -> bool:
    """Whether two bodies still touch when one is moved by the width of the rim along each axis, either way."""
    for axis in range(3):
        for side in (-_RIM, _RIM):
            moved = placed[b].copy()
            moved[axis, 3] += side
            if not pc.intersects(bodies[a].shape, bodies[b].shape, placed[a], moved):
                return False
    return True


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    raise SystemExit(main())
