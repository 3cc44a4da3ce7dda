"""Mutated URDFs and SRDFs are loaded or refused: `python tests/benchmarks/mutated_urdfs.py --count 10000 --seed 0`.

The files are those of the shipped robots, with a box for each mesh, and small ones. Elements are removed, repeated,
nested and renamed, attributes get odd numbers and names of others, bytes change, texts end early, entities grow. Each
file is loaded in a fork with 10 s and 2 GB. A file that loads must have all collision elements and all joints that
Python's XML finds in it, finite poses, and a verdict for five random configurations. Out: how many were loaded and
refused; a line for each fault, its file kept with --keep. Exit code: 0 without faults, else 1.
"""

import argparse
import collections
import copy
import sys
import tempfile
import warnings
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from xml.etree.ElementTree import Element

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

import numpy as np
from long_runs import forked, loaders

import plannercheck as pc
from plannercheck.robots import urdf_messages
from plannercheck.robots.description import description_of, shipped_robots

NUMBERS = (
    *("nan", "inf", "-inf", "1e400", "-1e400", "1e308", "-1e308", "1e155", "1e60", "1e-320", "1e-160", "0", "-0", ""),
    *("0 0 0", "1 2", "1 2 3 4", "1,2,3", "1;2;3", "0x10", "1_0", "1e", "--1", "٣", "1e5", "nan nan nan", "0 0 1e-320"),
    *("1e200 1e200 1e200", "inf 0 0", "1e16", "0 0 -1", "1 0 0", "0.6 0 0.8", " 1  2   3 ", "1\t2\t3", "true", "é"),
)
TYPES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar", "spherical", "", "Revolute", "ball")
TAGS = (
    "link",
    "joint",
    "collision",
    "visual",
    "origin",
    "axis",
    "limit",
    "mimic",
    "geometry",
    "Origin",
    "gazebo",
    "box",
)
SMALL = (
    """<robot name="r"><material name="grey"><color rgba="1 1 1 1"/></material>
<link name="a"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
<visual><origin xyz="0 0 0"/><geometry><sphere radius="1"/></geometry><material name="grey"/></visual>
<collision name="c"><origin xyz="0 0 1" rpy="0 1 0"/><geometry><box size="1 1 1"/></geometry></collision>
<collision><geometry><sphere radius="0.5"/></geometry></collision></link>
<link name="b"><collision><geometry><cylinder radius="0.1" length="2"/></geometry></collision></link>
<link name="c"><collision><geometry><box size="0.1 0.2 0.3"/></geometry></collision></link>
<link name="d"><collision><geometry><sphere radius="0.2"/></geometry></collision></link><link name="e"/>
<joint name="j" type="revolute"><parent link="a"/><child link="b"/><origin xyz="0 0 3" rpy="0 0 1"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/><dynamics damping="1"/></joint>
<joint name="k" type="prismatic"><parent link="b"/><child link="c"/><axis xyz="0 0.6 0.8"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/><mimic joint="j" multiplier="-2" offset="0.1"/></joint>
<joint name="l" type="continuous"><parent link="c"/><child link="d"/><origin xyz="1 0 0"/><axis xyz="1 0 0"/></joint>
<joint name="m" type="fixed"><parent link="d"/><child link="e"/></joint>
<transmission name="t"><joint name="j"/></transmission></robot>""",
    """<robot name="r" version="1.2">
<link name="a"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
<link name="b"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
<link name="c"><collision><geometry><sphere radius="1"/></geometry></collision></link>
<joint name="p" type="planar"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/></joint>
<joint name="f" type="floating"><parent link="b"/><child link="c"/><origin xyz="1 1 1" quat_xyzw="0 0 0 1"/></joint>
</robot>""",
)
# Copies of each small file among the files that are drawn: the twelve shipped robots take ten times as long.
_SMALL_SHARE = 40

SMALL_SRDF = """<robot name="r"><group name="g"><joint name="j"/><chain base_link="a" tip_link="d"/></group>
<group_state name="home" group="g"><joint name="j" value="0.5"/></group_state>
<virtual_joint name="v" type="fixed" parent_frame="w" child_link="a"/><disable_default_collisions link="d"/>
<enable_collisions link1="a" link2="d"/><disable_collisions link1="a" link2="b" reason="Adjacent"/></robot>"""


class Seeds:
    """The files that are mutated, and the mutation of each number."""

    def __init__(self, seed: int, folder: Path) -> None:
        self.seed, self.urdf, self.srdf = seed, folder / "r.urdf", folder / "r.srdf"
        self.files = [
            (ElementTree.fromstring(text), ElementTree.fromstring(SMALL_SRDF)) for text in SMALL
        ] * _SMALL_SHARE
        for name in shipped_robots():
            description = description_of(name)
            srdf = SMALL_SRDF if description.srdf is None else description.srdf.read_text()
            self.files.append((_without_meshes(description.file.root), ElementTree.fromstring(srdf)))

    def content(self, number: int) -> tuple[bytes, bytes, bool]:
        """URDF and SRDF of a number, and whether the SRDF is used; one of both is mutated, or both."""
        rng = np.random.default_rng((self.seed, number))
        urdf, srdf = self.files[rng.integers(len(self.files))]
        which = rng.integers(4)
        texts = [_mutated(urdf, rng) if which != 0 else ElementTree.tostring(urdf)]
        texts.append(_mutated(srdf, rng) if which in (0, 1) else ElementTree.tostring(srdf))
        return texts[0], texts[1], bool(which < 2)

    def trial(self, number: int) -> str:
        """Loads the files of a number and compares them with what Python's XML finds."""
        urdf, srdf, used = self.content(number)
        self.urdf.write_bytes(urdf)
        self.srdf.write_bytes(srdf)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            robot = pc.Robot.from_urdf(self.urdf, self.srdf if used else None)
            checker = pc.Checker(robot)
            q = robot.random_configurations(5, number)
            verdicts = checker.check_states(q)
        poses = robot.link_poses(q)
        if verdicts.shape != (5,) or not np.isfinite(poses).all():
            raise AssertionError(f"verdicts {verdicts}, poses finite: {np.isfinite(poses).all()}")
        _compare(urdf, robot)
        if used and robot.nq:
            _with_group(self.urdf, self.srdf, number)
        return "loaded"


def _with_group(urdf: Path, srdf: Path, number: int) -> None:
    """The groups of an SRDF load, or are refused."""
    for name in [group.get("name") for group in ElementTree.parse(srdf).getroot().findall("group")][:2]:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                robot = pc.Robot.from_urdf(urdf, srdf, group=name)
            except pc.PlannercheckError:
                continue
            pc.Checker(robot).check_states(robot.random_configurations(5, number))


def _compare(text: bytes, robot: pc.Robot) -> None:
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError:
        return  # a fault that is mended: a comment, a prefix
    collisions = sum(1 for link in root.iterfind("link") for _ in link.iter("collision"))
    collisions += len(root.findall("collision")) + sum(
        1 for each in root.iterfind("joint") for _ in each.iter("collision")
    )
    joints = {str(each.get("name")) for each in root.iterfind("joint") if each.get("type") != "fixed"}
    found = {name for name in robot.model.names if name != "universe"}
    if len(robot.bodies) != collisions or found != joints:
        raise AssertionError(f"{len(robot.bodies)} of {collisions} bodies, joints {sorted(found ^ joints)[:5]}")


def _without_meshes(root: Element) -> Element:
    root = copy.deepcopy(root)
    for geometry in root.iter("geometry"):
        for mesh in geometry.findall("mesh"):
            geometry.remove(mesh)
            ElementTree.SubElement(geometry, "box", size="0.1 0.1 0.1")
    return root


def _mutated(root: Element, rng: np.random.Generator) -> bytes:
    if rng.random() < 0.2:
        return _mutated_text(ElementTree.tostring(root), rng)
    root = copy.deepcopy(root)
    for _ in range(rng.integers(1, 4)):
        _mutate(root, rng)
    return ElementTree.tostring(root)


def _mutate(root: Element, rng: np.random.Generator) -> None:
    """Changes one element or attribute."""
    parents = [(parent, child) for parent in root.iter() for child in parent]
    if not parents:
        return
    parent, child = parents[rng.integers(len(parents))]
    other = parents[rng.integers(len(parents))][1]
    kind = rng.integers(8)
    if kind == 0:
        parent.remove(child)
    elif kind == 1:
        parent.append(copy.deepcopy(child))
    elif kind == 2:
        other.append(copy.deepcopy(child))
    elif kind == 3:
        child.tag = str(rng.choice(TAGS))
    elif child.attrib:
        key = str(rng.choice(list(child.attrib)))
        names = [str(each.get("name")) for _, each in parents if each.get("name")] or ["r"]
        pool = TYPES if key == "type" else tuple(names[:50]) if key in ("link", "joint", "name") else NUMBERS
        if kind == 4:
            del child.attrib[key]
        elif kind == 5:
            child.set(key + "s", child.attrib.pop(key))
        else:
            child.set(key, str(rng.choice(pool if rng.random() < 0.8 else NUMBERS)))


def _mutated_text(text: bytes, rng: np.random.Generator) -> bytes:
    kind, content = rng.integers(6), bytearray(text)
    if kind == 0:
        return text[: rng.integers(len(text))]
    if kind == 1:
        for at in rng.integers(len(content), size=rng.integers(1, 6)):
            content[at] = rng.integers(256)
        return bytes(content)
    if kind == 2:
        at, end = sorted(rng.integers(len(text), size=2))
        return text[:at] + text[end:]
    if kind == 3:
        deep = int(rng.choice([10, 150, 250, 100_000]))
        return text.replace(b"</robot>", b"<link>" * deep + b"</link>" * deep + b"</robot>")
    if kind == 4:
        lines = "".join(f'<!ENTITY e{k} "{f"&e{k - 1};" * 10}">' for k in range(1, int(rng.integers(2, 12))))
        last = lines.count("ENTITY")
        entities = f'<!DOCTYPE robot [<!ENTITY e0 "1">{lines}]>'.encode()
        return entities + text.replace(b'"1"', f'"&e{last};"'.encode(), 1)
    return text.replace(b"<robot", b"<!-- a -- b --><robot", 1) if rng.random() < 0.5 else b"\xff\xfe" + text


def main() -> int:
    """Runs the trials."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="files that break a promise are put there")
    options = parser.parse_args()
    # A process of its own for each message of native code takes half a second to start.
    urdf_messages.run_isolated = loaders._by_a_fork  # type: ignore[attr-defined]
    with tempfile.TemporaryDirectory() as folder:
        seeds = Seeds(options.seed, Path(folder))
        tally = forked.run(seeds.trial, options.count, Path(folder))
    print(f"seed {options.seed}: {dict(tally.outcomes)}, {len(tally.faults)} faults, {tally.seconds:.0f} s")
    print(f"slowest {tally.slowest:.2f} s")
    for number, what in tally.faults:
        print(f"{number}: {what.strip().splitlines()[-1]:.300}")
        if options.keep is not None:
            options.keep.mkdir(parents=True, exist_ok=True)
            urdf, srdf, _ = seeds.content(number)
            (options.keep / f"{number}.urdf").write_bytes(urdf)
            (options.keep / f"{number}.srdf").write_bytes(srdf)
            (options.keep / f"{number}.txt").write_text(what)
    kinds = collections.Counter(what.strip().splitlines()[-1][:60] for _, what in tally.faults)
    print("\n".join(f"{count} x {what}" for what, count in kinds.most_common(10)))
    return 1 if tally.faults else 0


if __name__ == "__main__":
    sys.exit(main())
