"""Every public call about a solid and a set of parts, held against the truth of the two.

In: a `Nested`, a folder for its files. Out: what is wrong, in words; nothing if all agrees. The solid is a link of a
robot. It moves beside the set, its joint is held, or both are on one link.
"""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from nested_parts import Nested

import plannercheck as pc
from plannercheck.cli.main import main
from plannercheck.validation.certification import certify_verdicts

MODES = ("moving", "held", "one link")
_CONTACTS = (pc.SharedPoint, pc.Enclosure)

_URDF = """<robot name="nested">
<link name="base"/><link name="hand"/>
<joint name="turn" type="revolute"><parent link="base"/><child link="hand"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
<joint name="mount" type="{mount}"><parent link="{parent}"/><child link="hollow"/><axis xyz="1 0 0"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<link name="hollow"><collision><geometry><mesh filename="hollow.obj"/></geometry></collision></link>
<link name="arm"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
<joint name="aside" type="revolute"><parent link="base"/><child link="arm"/><origin xyz="0 0 20"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
</robot>"""


def faults_of_bodies(case: Nested) -> Iterator[str]:
    """What is wrong with calls about the two bodies alone."""
    for at in (np.eye(4), case.at):
        for swapped in (False, True):
            sides = [(case.solid, at), (case.parts, at @ case.pose)]
            (p, pose_p), (r, pose_r) = sides[::-1] if swapped else sides
            meets = pc.intersects(p, r, pose_p, pose_r)
            if meets != case.meets and (case.is_clear or at is not case.at):
                yield f"intersects says {meets}"
            certificate = pc.certify(p, r, pose_p, pose_r)
            if isinstance(certificate, _CONTACTS) != meets or not certificate.verify():
                yield f"certify gives a {type(certificate).__name__} where intersects says {meets}"


def checker_of(case: Nested, mode: str, folder: Path) -> pc.Checker:
    """A checker of the solid on a link beside the set."""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in case.solid.vertices.tolist()]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in case.solid.triangles.tolist()]
    (folder / "hollow.obj").write_text("\n".join(lines))
    is_fixed = mode == "one link"
    text = _URDF.format(mount="fixed" if is_fixed else "prismatic", parent="hand" if is_fixed else "base")
    (folder / "nested.urdf").write_text(text)
    group = ["aside", "turn"] if mode != "moving" else ["mount", "aside"]
    robot = pc.Robot.from_urdf(folder / "nested.urdf", geometry="solid", group=group)
    scene = pc.Scene("nested")
    if is_fixed:
        scene.attach("set", "hand", case.pose, parts=case.parts)
    else:
        scene.add("set", case.parts, case.pose)
    return pc.Checker(robot, scene)


def faults_of_checker(case: Nested, mode: str, folder: Path, thorough: bool = False) -> Iterator[str]:
    """What is wrong with calls of a checker, `thorough`: and of a planner and the command line."""
    checker = checker_of(case, mode, folder)
    q, free = np.zeros(checker.robot.nq), not case.meets
    end = q + 1 / 32
    if checker.is_valid(q) != free or checker.check_states(q[None])[0] != free or checker.explain(q).valid != free:
        yield "is_valid, check_states or explain is wrong"
    for pair in range(len(checker.pairs)):
        if not checker.explain_pair(pair, q).certificate.verify():
            yield "the certificate of explain_pair is wrong"
    if (checker.clearance(q) > 0) != free:
        yield "clearance has the wrong sign"
    if not certify_verdicts(checker, q[None], checker.first_colliding_pair(q[None])).passed:
        yield "the verdict is not certified"
    moves = checker.check_motion(q, end)
    if moves > free or (mode != "moving" and moves != free):
        yield f"check_motion says {moves}"
    if checker.check_motions([q], [end])[0] != moves or checker.explain_motion(q, end).free != moves:
        yield "check_motions or explain_motion differ from check_motion"
    (proof,) = checker.certify_motions([q], [end])
    if (proof is not None) != moves or not (proof is None or proof.verify().proved):
        yield "certify_motions differs, or its proof is refused"
    if thorough:
        yield from _planned(checker, q, end, moves)
        yield from _commands(checker, folder)


def _planned(checker: pc.Checker, q: np.ndarray, end: np.ndarray, moves: bool) -> Iterator[str]:
    if moves and not pc.ompl.plan(checker, q, end, time_limit=1.0, seed=1).solved:
        yield "no plan along a free motion"


def _commands(checker: pc.Checker, folder: Path) -> Iterator[str]:
    joints = ",".join(checker.robot.joint_names)
    (folder / "robot.yaml").write_text(f"urdf: nested.urdf\ngeometry: solid\ngroup: {{name: g, joints: [{joints}]}}\n")
    checker.scene.save(folder / "nested.yaml")
    np.save(folder / "set.npy", np.zeros((1, checker.robot.nq)))
    names = ["--robot", str(folder / "robot.yaml"), "--scene", str(folder / "nested.yaml"), str(folder / "set.npy")]
    code = main(["validate", *names, "--output", str(folder / "out.csv"), "--explain"])
    if code != (0 if checker.is_valid(np.zeros(checker.robot.nq)) else 1):
        yield f"validate --explain ends with {code}"


def told(calls: Callable[[], Iterator[str]]) -> list[str]:
    """What is wrong, errors among it."""
    found: list[Any] = []
    try:
        found += calls()
    except Exception as error:
        found.append(f"{type(error).__name__}: {error}")
    return found
