"""The cells of mr-shortcut (github.com/philip-huang/mr-shortcut, envs/): loaded as they are, planned in, built anew.

Run: `python tests/benchmarks/public_cells.py ENVS [--packages FOLDER] [--plans 20] [--output FILE.json]`. ENVS is the
folder `envs` of that repository, and FOLDER holds its package of meshes, moveit_resources_panda_description
(github.com/moveit/moveit_resources).

Out: for each URDF, with the SRDF of its cell, what loads and what is warned of; the time of a state and
of a motion of 0.5 rad, in one process and thread; RRTConnect's plans of all arms together. Then each cell of Pandas is
cut into one URDF a Panda and one for the rest, and built anew by a cell's YAML whose SRDF has the same pairs: how many
verdicts differ from those of the merged URDF.
"""

import argparse
import json
import re
import tempfile
import time
import warnings
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np

import plannercheck as pc

# Each cell's URDF and SRDF. panda_two has no SRDF of its own there, and gets that of the same arms with a rod.
CELLS = {
    "dual_gp4": ("dual_gp4/gazebo/urdf/dual_gp4.urdf.xacro", "dual_gp4/moveit_config/config/dual_gp4.srdf"),
    "dual_gp4, expanded": (
        "dual_gp4/moveit_config/config/gazebo_dual_gp4.urdf",
        "dual_gp4/moveit_config/config/dual_gp4.srdf",
    ),
    "panda_two": ("panda_two_description/urdf/panda_two.urdf", "panda_two_rod_moveit_config/config/panda.srdf"),
    "panda_two_rod": tuple(
        f"panda_two_rod_moveit_config/config/{name}" for name in ("gazebo_panda.urdf", "panda.srdf")
    ),
    "panda_three": tuple(f"panda_three_moveit_config/config/{name}" for name in ("gazebo_panda.urdf", "panda.srdf")),
    "panda_four": tuple(f"panda_four_moveit_config/config/{name}" for name in ("gazebo_panda.urdf", "panda.srdf")),
    "panda_four_bins": tuple(
        f"panda_four_bins_moveit_config/config/{name}" for name in ("gazebo_panda.urdf", "panda.srdf")
    ),
}
_STATES = 50_000
_PLAN_SECONDS = 10.0


def main() -> int:
    """Runs the command."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("envs", type=Path)
    parser.add_argument("--packages", type=Path, help="where moveit_resources_panda_description is")
    parser.add_argument("--plans", type=int, default=20, help="of each cell")
    parser.add_argument("--output", type=Path, metavar="FILE.json")
    options = parser.parse_args()
    folders = [options.envs, options.envs / "dual_gp4", *([options.packages] if options.packages else [])]
    rows = []
    for name, (urdf, srdf) in CELLS.items():
        files = options.envs / urdf, options.envs / srdf
        row = {"cell": name, **_cell(files, folders, options.plans)}
        rows.append(row)
        print(json.dumps(row), flush=True)
    if options.output is not None:
        options.output.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    return 1 if any(row.get("differ") for row in rows) else 0


def _cell(files: tuple[Path, Path], folders: list[Path], plans: int) -> dict[str, object]:
    """What a cell of the public ones does."""
    urdf, srdf = files
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        began = time.perf_counter()
        try:
            whole = pc.Robot.from_urdf(urdf, srdf, folders)
        except pc.PlannercheckError as error:
            return {"error": str(error)}
        moving = [joint for joint in whole.joint_names if "finger" not in joint and not joint.startswith("gripper")]
        robot = whole.with_group(moving, "all arms")
        checker = pc.Checker(robot)
        seconds = time.perf_counter() - began
    q = robot.random_configurations(_STATES, 1)
    valid = checker.check_states(q)
    row = {"warnings": [str(each.message) for each in said], "joints": robot.nq, "bodies": len(robot.bodies)}
    row |= {"pairs": len(checker.pairs), "loaded in, s": seconds, "valid": float(valid.mean())}
    free = q[valid]
    step = np.random.default_rng(2).normal(size=free.shape)
    ends = free + 0.5 * step / np.linalg.norm(step, axis=1)[:, None]
    row |= {"a state, s": _least(lambda: checker.check_states(q)) / len(q)}
    row |= {"a motion, s": _least(lambda: checker.check_motions(free[:400], ends[:400])) / len(free[:400])}
    row |= _plans(checker, free, plans)
    if re.search(r"panda\d_link0", " ".join(robot.link_names)):
        row |= _built_anew(checker, files, folders, q)
    return row


def _least(call: object) -> float:
    found = []
    for _ in range(5):
        began = time.process_time()
        call()  # type: ignore[operator]
        found.append(time.process_time() - began)
    return min(found)


def _plans(checker: pc.Checker, free: np.ndarray, plans: int) -> dict[str, object]:
    """RRTConnect's plans between free states."""
    seconds = []
    for k in range(plans):
        if 2 * k + 1 >= len(free):
            break
        began = time.perf_counter()
        plan = pc.ompl.plan(
            checker,
            free[2 * k],
            free[2 * k + 1],
            planner="RRTConnect",
            time_limit=_PLAN_SECONDS,
            simplify=False,
            seed=k + 1,
        )
        if plan.solved:
            seconds.append(time.perf_counter() - began)
            assert checker.check_motions(plan.path[:-1], plan.path[1:]).all()
    return {"plans": plans, "solved": len(seconds), "a plan, median s": float(np.median(seconds)) if seconds else None}


def _built_anew(checker: pc.Checker, files: tuple[Path, Path], folders: list[Path], q: np.ndarray) -> dict[str, object]:
    """The cell of its single robots: how many verdicts differ from those of the merged URDF."""
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        owner = _cut(checker.robot, files[0], Path(folder), folders)
        cell = _loaded(files[1], owner, Path(folder))
        built = pc.Checker(cell)
    names = [joint.partition("/")[2] for joint in cell.joint_names]
    ours = built.check_states(q[:, [checker.robot.joint_names.index(name) for name in names]])
    theirs = checker.check_states(q)
    return {"robots": len(cell.parts), "own pairs": len(built.pairs), "differ": int((ours != theirs).sum())}


def _cut(robot: pc.Robot, urdf: Path, folder: Path, folders: list[Path]) -> dict[str, str]:
    """Writes one URDF for each Panda, and one for the rest; returns whose each link is."""
    root, parents = ElementTree.parse(urdf).getroot(), robot.link_tree.parents
    owner: dict[str, str] = {}
    for link in robot.link_names:  # parents first
        begun = re.fullmatch(r"(panda\d)_link0", link)
        owner[link] = begun[1] if begun else owner.get(parents.get(link, ""), "rest")
    texts = {name: ElementTree.Element("robot", name=name) for name in dict.fromkeys(owner.values())}
    for link in root.findall("link"):
        texts[owner[link.get("name", "")]].append(link)
    for joint in root.findall("joint"):
        parent, child = (joint.find(tag).get("link", "") for tag in ("parent", "child"))  # type: ignore[union-attr]
        if owner[parent] == owner[child]:
            texts[owner[child]].append(joint)
    for name, text in texts.items():
        (folder / f"{name}.urdf").write_text(ElementTree.tostring(text, encoding="unicode"), encoding="utf-8")
    poses = robot.link_poses(robot.reference)
    entries = {}
    for name in texts:
        base = poses[robot.link_index(f"{name}_link0")] if name != "rest" else np.eye(4)
        joints = [joint for joint in robot.joint_names if joint.startswith(f"{name}_")]
        entries[name] = {"load": f"{name}.urdf", "package_dirs": [str(each.resolve()) for each in folders]}
        entries[name] |= {"pose": {"matrix": base.tolist()}}
        entries[name] |= {"group": {"name": "arm", "joints": joints}} if joints else {}
    (folder / "cell.yaml").write_text(json.dumps({"robots": entries}), encoding="utf-8")  # JSON is YAML
    return owner


def _loaded(srdf: Path, owner: dict[str, str], folder: Path) -> pc.Robot:
    """The cell, whose SRDF has the pairs of the merged one."""
    named = {link: f"{name}/{link}" for link, name in owner.items()}
    text = ElementTree.Element("robot", name="cell")
    for pair in ElementTree.parse(srdf).getroot().findall("disable_collisions"):
        links = pair.get("link1", ""), pair.get("link2", "")
        if set(links) <= named.keys():
            ElementTree.SubElement(text, "disable_collisions", link1=named[links[0]], link2=named[links[1]], reason="")
    (folder / "cell.srdf").write_text(ElementTree.tostring(text, encoding="unicode"), encoding="utf-8")
    content = json.loads((folder / "cell.yaml").read_text(encoding="utf-8"))
    (folder / "cell.yaml").write_text(json.dumps({**content, "srdf": "cell.srdf"}), encoding="utf-8")
    return pc.Robot.load(folder / "cell.yaml")


if __name__ == "__main__":
    raise SystemExit(main())
