"""Hashes of motions' verdicts, explanations, proofs and samples, of each kind of joint and path.

    PLANNERCHECK_LEVEL=v2 python tests/package/motion_digest.py

Out: JSON with a hash a robot: arms in scenes, whole robots with continuous and following joints, and planar, floating
and ball joints on both paths.
"""

import hashlib
import json
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from poses import at

import plannercheck as pc
from plannercheck.common.errors import PlannercheckError
from plannercheck.proofs.files import document
from plannercheck.robots.description import description_of

MOTIONS, EXPLAINED, PROVED = 80, 6, 1

# A ball that moves on a floor, a lift on it, and a body that flies from there.
PAIR = """<robot name="pair"><link name="floor"/>
<link name="sled"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
<link name="kite"><collision><origin xyz="0.4 0 0"/><geometry><box size="2 0.6 0.1"/></geometry></collision></link>
<joint name="slide" type="planar"><parent link="floor"/><child link="sled"/><origin xyz="0.1 0 0" rpy="0.3 0.2 0.1"/>
<axis xyz="0 0 1"/></joint>
<link name="lift"/><joint name="rise" type="prismatic"><parent link="sled"/><child link="lift"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="fly" type="floating"><parent link="lift"/><child link="kite"/><origin xyz="0 0 0.2"/></joint></robot>"""

# A floating brick with a wheel that turns without limits about an axis of its own.
BRICK = """<robot name="brick"><link name="brick"><collision><geometry><box size="0.4 0.2 0.1"/></geometry></collision>
</link><link name="wheel"><collision><geometry><cylinder radius="0.1" length="0.05"/></geometry></collision></link>
<joint name="turn" type="continuous"><parent link="brick"/><child link="wheel"/><origin xyz="0.4 0 0"/>
<axis xyz="0.6 0 0.8"/></joint></robot>"""

# An arm on ball joints.
ARM = """<mujoco model="arm"><worldbody><body name="upper" pos="0 0 0.2"><joint name="shoulder" type="ball"/>
<geom type="capsule" size="0.05" fromto="0 0 0.1 0 0 0.4"/><body name="lower" pos="0 0 0.5">
<joint name="elbow" type="ball"/><geom type="box" size="0.05 0.04 0.2" pos="0 0 0.25"/></body></body></worldbody>
</mujoco>"""


def spheres() -> pc.Scene:
    """A few balls around the origin."""
    scene = pc.Scene("spheres")
    for k, position in enumerate(np.random.default_rng(0).uniform(-1.5, 1.5, (6, 3))):
        pose = at(*position)
        scene.add_sphere(f"ball{k}", 0.12, pose)
    return scene


def checkers(folder: Path) -> Iterator[tuple[str, pc.Checker]]:
    """Named checkers."""
    for robot, scene in (("panda", "bookshelf"), ("ur5", "table"), ("baxter", "kitchen")):
        yield robot, pc.Checker(pc.Robot.load(robot), pc.Scene.load(scene))
    for robot in ("panda", "kinova"):
        files = description_of(robot)
        yield f"whole {robot}", pc.Checker(pc.Robot.from_urdf(files.urdf, files.srdf), pc.Scene.load("table"))
    for name, text, floating in (("pair", PAIR, False), ("brick", BRICK, True), ("brick on ground", BRICK, False)):
        (folder / f"{name}.urdf").write_text(text)
        yield name, pc.Checker(pc.Robot.from_urdf(folder / f"{name}.urdf", floating=floating), spheres())
    (folder / "arm.xml").write_text(ARM)
    yield "ball joints", pc.Checker(pc.Robot.load(folder / "arm.xml"), spheres())


def ends_of(checker: pc.Checker) -> tuple[np.ndarray, np.ndarray]:
    """Starts and ends; some beyond the limits, and with angles some turns away."""
    starts, ends = np.split(checker.robot.random_configurations(2 * MOTIONS, 1), 2)
    far = np.ones(checker.robot.nq, dtype=bool)
    for start, stop in checker.robot.configuration_map.units:
        far[start:stop] = False
        near = ends[::2, start:stop] * 0.3 + starts[::2, start:stop]
        ends[::2, start:stop] = near / np.linalg.norm(near, axis=1, keepdims=True)
    ends[::2, far] = 0.9 * starts[::2, far] + 0.1 * ends[::2, far]
    ends[4::20, far] *= 3.0
    ends[9::50, far] *= 20.0
    return starts, ends


def told(answer: object) -> bytes:
    """Any answer as text."""
    return repr(answer).encode()


def of_motion(checker: pc.Checker, start: np.ndarray, end: np.ndarray, path: str) -> list[bytes]:
    """One motion, proved, sampled and explained."""
    parts = []
    for how in ({}, {"resolution": 0.05}, {"tolerance": 1e-3}):
        try:
            parts.append(told(checker.check_motion(start, end, **how, path=path)))
        except PlannercheckError as error:
            parts.append(told(error))
    verdict = checker.explain_motion(start, end, proofs=True, path=path)
    parts.append(told((verdict.free, verdict.free_until, verdict.near_at, verdict.collides_at, verdict.pair)))
    for proof in verdict.proofs:
        parts.append(told((proof.first_body, proof.second_body, proof.start, proof.end, proof.frame)))
        parts.append(told((proof.normal.tolist(), proof.gap, proof.chord_deviation)))
    return parts


def of_checker(checker: pc.Checker) -> str:
    """Of all paths of one checker."""
    starts, ends = ends_of(checker)
    parts = []
    for path in ("screw", "slerp"):
        parts.append(checker.check_motions(starts, ends, path=path).tobytes())
        parts.append(checker.check_motions(starts, ends, tolerance=1e-2, threads=2, path=path).tobytes())
        if not checker.robot.group or checker.motion_sampler.is_vector_space:
            parts.append(checker.check_motions(starts[:20], ends[:20], resolution=0.02, path=path).tobytes())
        for start, end in zip(starts[:EXPLAINED], ends, strict=False):
            parts += of_motion(checker, start, end, path)
        free = np.flatnonzero(checker.check_motions(starts, ends, path=path))[:PROVED]
        for proof in checker.certify_motions(starts[free], ends[free], path=path):
            parts.append(told(proof and json.dumps(document([proof]), default=lambda array: array.tolist())))
    return hashlib.sha256(b"".join(parts)).hexdigest()


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as made:
        print(json.dumps({name: of_checker(checker) for name, checker in checkers(Path(made))}, indent=1))
