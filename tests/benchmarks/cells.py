"""What a cell costs beside one robot, and that its verdicts are those of one URDF merged by hand.

Run: `python tests/benchmarks/cells.py [--states 1000000] [--rounds 9] [--scene table] [--output FILE.json]`.

Out: for two Pandas, and a Panda and a UR5, each at ten places, how many of the states are valid, and how many verdicts
differ from those of the merged URDF with the same disabled pairs (tests/support/merged_robots.py). Then process time of
one thread, in turns, the median of the rounds: of one Panda, of the same once more in a checker of its own (the null
control), of one at the other place, and of both, on random states, free ones, states along motions, and motions.
"two/mean" is beside the mean of both places. The time and the bytes of the bodies that building takes: of one Panda, of
two, and of two and a UR5.
"""

import argparse
import json
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import plannercheck as pc
from plannercheck.common.package_data import example_robot_data

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from merged_robots import Placed, merged

_ROBOTS = example_robot_data() / "example-robot-data" / "robots"
_FILES = {
    "panda": (_ROBOTS / "panda_description/urdf/panda.urdf", _ROBOTS / "panda_description/srdf/panda.srdf"),
    "ur5": (_ROBOTS / "ur_description/urdf/ur5_robot.urdf", _ROBOTS / "ur_description/srdf/ur5.srdf"),
}
_PLACES = 10
_BATCH = 50_000
# How far apart the arms stand whose times are taken: they face each other over a table, m.
_ACROSS = 1.1


def main() -> int:
    """Runs the command."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--states", type=int, default=1_000_000, help="of each cell")
    parser.add_argument("--rounds", type=int, default=21)
    parser.add_argument("--scene", default="table", help="of the times")
    parser.add_argument("--output", type=Path, metavar="FILE.json")
    options = parser.parse_args()
    found = {"verdicts": [], "times": [], "building": []}
    for second in ("panda", "ur5"):
        row = verdicts(second, options.states)
        found["verdicts"].append(row)
        print("panda and {second}: {states} states, {valid} valid, {differ} verdicts differ".format(**row), flush=True)
    heads = ("one", "again", "other", "two", "again/one", "two/one", "two/mean")
    print(f"\n{'in ' + options.scene:<22}" + "".join(f"{head:>10}" for head in heads) + "  free of one, two")
    for row in times(options.scene, options.rounds):
        found["times"].append(row)
        line = "{work:<22}{one:10.2e}{again:10.2e}{other:10.2e}{two:10.2e}{null:10.3f}{ratio:10.3f}{mean:10.3f}"
        print((line + "  {free_one:.3f}, {free_two:.3f}").format(**row), flush=True)
    print()
    for row in building():
        found["building"].append(row)
        print(
            "{robots:<24} loaded in {load:.3f} s, checker in {build:.3f} s, {bodies} bodies, {bytes} bytes".format(
                **row
            )
        )
    if options.output is not None:
        options.output.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    return 1 if any(row["differ"] for row in found["verdicts"]) else 0


def verdicts(second: str, states: int) -> dict[str, object]:
    """A Panda and another robot at places where they may meet, against one URDF."""
    rng, valid, differ = np.random.default_rng(48), 0, 0
    robots = pc.Robot.load("panda"), pc.Robot.load(second)
    for _ in range(_PLACES):
        xyz = (*rng.uniform(-0.8, 0.8, 2).tolist(), rng.uniform(-0.3, 0.3))
        rpy = (*rng.uniform(-0.4, 0.4, 2).tolist(), rng.uniform(-3, 3))
        with tempfile.TemporaryDirectory() as folder:
            placed = {"left": Placed(*_FILES["panda"]), "right": Placed(*_FILES[second], xyz, rpy)}
            urdf, srdf = merged(placed, Path(folder))
            one = pc.Robot.from_urdf(urdf, srdf, package_dirs=example_robot_data())
        base = one.link_poses(one.reference)[one.link_index(f"right/{robots[1].link_names[0]}")]
        cell = pc.Robot.together({"left": robots[0], "right": (robots[1], base)})
        fingers = {name: 0.04 for name in one.joint_names if "finger" in name}
        checkers = pc.Checker(cell), pc.Checker(one.with_group(cell.joint_names).holding(fingers))
        for k in range(0, states // _PLACES, _BATCH):
            q = cell.random_configurations(min(_BATCH, states // _PLACES - k), rng)
            ours, theirs = (checker.check_states(q) for checker in checkers)
            valid += int(ours.sum())
            differ += int((ours != theirs).sum())
    return {"second": second, "states": states // _PLACES * _PLACES, "valid": valid, "differ": differ}


def times(scene: str, rounds: int) -> list[dict[str, object]]:
    """Process time of a state and of a motion, s: one Panda, the same again, one at the other place, and both."""
    robot, pose = pc.Robot.load("panda"), np.diag([-1.0, -1.0, 1.0, 1.0])
    pose[0, 3] = _ACROSS
    cell = pc.Robot.together({"left": robot, "right": (robot, pose)})
    robots = robot, pc.Robot.load("panda"), pc.Robot.together({"right": (robot, pose)}), cell
    columns = [*(cell.parts[name].columns for name in ("left", "left", "right")), np.arange(cell.nq)]
    checkers = [pc.Checker(each, pc.Scene.load(scene)) for each in robots]
    q = cell.random_configurations(100_000, 1)
    free = q[checkers[-1].check_states(q)]
    starts = free[:400]
    step = np.random.default_rng(3).normal(size=starts.shape)
    ends = starts + 0.5 * step / np.linalg.norm(step, axis=1)[:, None] * np.sqrt(2)  # 0.5 rad a robot
    along = (starts[:, None] + np.linspace(0, 1, 50)[:, None] * (ends - starts)[:, None]).reshape(-1, cell.nq)
    rows = []
    for work, states in (("random states", q), ("free states", free), ("states along motions", along)):
        rows.append(
            _row(work, [_call(c.check_states, k, states) for c, k in zip(checkers, columns, strict=True)], rounds)
        )
    passed = checkers[-1].check_motions(starts, ends)
    for work, chosen in (("motions of 0.5 rad", slice(None)), ("of these free", passed)):
        both = starts[chosen], ends[chosen]
        rows.append(
            _row(work, [_call(c.check_motions, k, *both) for c, k in zip(checkers, columns, strict=True)], rounds)
        )
    return rows


def _call(check: Callable[..., np.ndarray], columns: np.ndarray, *rows: np.ndarray) -> Callable[[], np.ndarray]:
    own = [np.ascontiguousarray(each[:, columns]) for each in rows]
    return lambda: check(*own)


def _row(work: str, calls: list[Callable[[], np.ndarray]], rounds: int) -> dict[str, object]:
    """The median time of each call over rounds in turns, a row of its arguments."""
    spent: list[list[float]] = [[] for _ in calls]
    found = [call() for call in calls]
    for turn in range(rounds):
        for k in (range(len(calls)), reversed(range(len(calls))))[turn % 2]:
            began = time.process_time()
            calls[k]()
            spent[k].append(time.process_time() - began)
    one, again, other, two = (float(np.median(each)) / len(found[0]) for each in spent)
    row = {"work": work, "one": one, "again": again, "other": other, "two": two, "null": again / one}
    shares = {"free_one": float(found[0].mean()), "free_two": float(found[-1].mean())}
    return row | {"ratio": two / one, "mean": 2 * two / (one + other), **shares}


def building() -> list[dict[str, object]]:
    """How long loading and preparing takes once it is in the cache, and what the distinct bodies take."""
    kinds = (["panda"], ["ur5"], ["panda", "panda"], ["panda", "panda", "ur5"])
    turns = [[_built(names) for names in kinds] for _ in range(6)]  # the first fills the disk cache
    rows = []
    for row in zip(*turns[1:], strict=True):
        rows.append(row[0] | {key: min(each[key] for each in row) for key in ("load", "build")})
    return rows


def _built(names: list[str]) -> dict[str, object]:
    began = time.process_time()
    text = "robots:\n" + "".join(
        f"  r{k}: {{load: {name}, pose: {{position: [{k}, 0, 0]}}}}\n" for k, name in enumerate(names)
    )
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "cell.yaml").write_text(text, encoding="utf-8")
        robot = pc.Robot.load(Path(folder) / "cell.yaml")
    loaded = time.process_time()
    checker = pc.Checker(robot)
    distinct = {id(each): each for each in checker.polytopes if each is not None}
    built = time.process_time()
    return {
        "robots": " and ".join(names),
        "load": loaded - began,
        "build": built - loaded,
        "bodies": len(distinct),
        "bytes": sum(each.nbytes for each in distinct.values()),
    }


if __name__ == "__main__":
    raise SystemExit(main())
