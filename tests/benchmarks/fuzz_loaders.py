"""A bounded fuzzer over everything that reads input: `python tests/benchmarks/fuzz_loaders.py --seconds 3600`.

Mutated scenes, MoveIt scenes, robot descriptions, URDFs, prepared bodies, configuration files, and random arrays for
`Polytope` and poses. Whatever is given, only a PlannercheckError may come out, in time. Each round of inputs runs in a
process of its own; the input at hand is on disk before it is read, so that a crash leaves what caused it behind.
"""

from __future__ import annotations

import argparse
import faulthandler
import json
import os
import re
import subprocess
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pyarrow.parquet

import plannercheck as pc
from plannercheck.errors import PlannercheckError
from plannercheck.motion_requests import read_request
from plannercheck.paths import example_robot_data, shipped_folder
from plannercheck.scene import shipped_scenes
from plannercheck.sets.chunks import read_chunks

ROUND = 200  # inputs a process
TIME_LIMIT = 20  # s for one input
MOVEIT = """name: s
robot_state: {is_diff: true, attached_collision_objects: []}
fixed_frame_transforms:
  - {child_frame_id: base, transform: {translation: [1.0, 0, 0], rotation: [0, 0, 0, 1]}}
allowed_collision_matrix:
  entry_names: [can, hand]
  entry_values: [[false, true], [true, false]]
world:
  collision_objects:
    - id: can
      header: {frame_id: base}
      primitives: [{type: cylinder, dimensions: [0.14, 0.03]}, {type: 1, dimensions: [1, 2, 3]}]
      primitive_poses:
        - {position: [0.25, -1.07, 0.3], orientation: [0, 0, -0.5, 0.8660254037844386]}
        - {position: {x: 1, y: 2, z: 3}, orientation: {x: 0, y: 0, z: 0, w: 1}}
      meshes:
        - vertices: [{x: 0, y: 0, z: 0}, {x: 1, y: 0, z: 0}, {x: 0, y: 1, z: 0}, {x: 0, y: 0, z: 1}]
          triangles: []
      mesh_poses: [{position: [0, 0, 0], orientation: [0, 0, 0, 1]}]
"""
REQUEST = """start_state:
  joint_state: {name: [panda_joint1, panda_joint2], position: [0.1, -0.5]}
goal_constraints:
  - joint_constraints: [{joint_name: panda_joint1, position: 0.3, tolerance_above: 0.001, tolerance_below: 0.001}]
group_name: panda_arm
workspace_parameters: {min_corner: [-1, -1, -1], max_corner: [1, 1, 1]}
"""
URDF = """<robot name="r"><link name="a"><collision><origin xyz="0 0 0.1" rpy="0 0 0.2"/><geometry><box size="1 2 3"/>
</geometry></collision></link><link name="b"><collision><geometry><cylinder radius="0.1" length="0.4"/></geometry>
</collision><collision><geometry><sphere radius="0.2"/></geometry></collision></link>
<joint name="j" type="revolute"><parent link="a"/><child link="b"/><origin xyz="0 0 1" rpy="0 1 0"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>
"""
SRDF = """<robot name="r"><group name="g"><joint name="j"/></group><group_state name="home" group="g">
<joint name="j" value="0.5"/></group_state><disable_collisions link1="a" link2="b" reason="Adjacent"/></robot>
"""
# What numbers and words are replaced by.
VALUES = [
    "0",
    "-0",
    "-1",
    "1",
    "1e-320",
    "1e308",
    "-1e308",
    "1e400",
    "nan",
    ".nan",
    "inf",
    "-.inf",
    "9999999999999999999999",
    "0x10",
    "1_0",
    "null",
    "true",
    "[]",
    "{}",
    "''",
    "~",
    "[1,2]",
    "{x:",
    "1}",
    "-",
    ":",
    "&",
    "*",
    "!",
    "world",
    "name",
    "é",
    "\\",
]


class Fuzzer:
    """One process's worth of inputs."""

    def __init__(self, seed: int, folder: Path) -> None:
        self.rng = np.random.default_rng(seed)
        self.folder = folder
        body = pc.Polytope(self.rng.normal(size=(12, 3)))
        body.save(folder / "seed.body")
        self.body_file, self.body_bytes = (folder / "seed.body").read_bytes(), body.core.serialise()
        self.targets: tuple[Callable[[], object], ...] = (
            self.points,
            self.faces,
            self.poses,
            self.scene,
            self.moveit,
            self.request,
            self.robot,
            self.urdf,
            self.body,
            self.parsed_body,
            self.configurations,
        )

    def run(self) -> tuple[Counter[str], list[str]]:
        """All inputs of a round: outcomes by target, and descriptions of what should not have happened."""
        outcomes: Counter[str] = Counter()
        faults = []
        for _ in range(ROUND):
            target = self.targets[int(self.rng.integers(len(self.targets)))]
            name = target.__name__
            faulthandler.dump_traceback_later(TIME_LIMIT, exit=True)
            try:
                target()
                outcomes[f"{name} accepted"] += 1
            except PlannercheckError as error:
                outcomes[f"{name} refused"] += 1
                if not str(error).strip():
                    faults.append(f"{name}: an error without words")
            except Exception:
                faults.append(f"{name}: {traceback.format_exc(limit=-4)}\ninput: {self.kept()}")
            faulthandler.cancel_dump_traceback_later()
        return outcomes, faults

    def kept(self) -> str:
        """The input at hand, shortened."""
        return repr((self.folder / "input").read_bytes()[:1500])

    def keep(self, data: bytes) -> None:
        """Writes the input at hand."""
        (self.folder / "input").write_bytes(data)

    def array(self) -> np.ndarray:
        """Points (n, 3), or something like it."""
        rng = self.rng
        n = int(rng.choice([0, 1, 2, 3, 4, 5, 8, 20, 100]))
        points = rng.normal(size=(n, 3)) * 10.0 ** rng.choice([-320, -160, -30, -6, 0, 0, 6, 30, 49, 160, 307])
        if rng.integers(2):
            points = rng.integers(-2, 3, size=(n, 3)).astype(float)  # many coincide or are coplanar
        if n and rng.integers(3) == 0:
            points[rng.integers(n), rng.integers(3)] = rng.choice([np.nan, np.inf, -np.inf, 5e-324, 1e308, -0.0, 1e50])
        if rng.integers(8) == 0:
            points = [points.ravel(), points[:, :2], points[None], points.T, points * 1j][int(rng.integers(5))]
        return points

    def swell(self) -> object:
        return self.rng.choice([0.0, 0.1, 1e-300, 1e60, -1.0, np.nan, np.inf]) if self.rng.integers(2) else 0.0

    def points(self) -> None:
        points, swell = self.array(), self.swell()
        self.keep(repr((points.tolist(), swell)).encode())
        body = pc.Polytope(points, swell=swell)  # type: ignore[arg-type]
        if body.fault():
            raise AssertionError(body.fault())
        pc.intersects(body, pc.Polytope(np.eye(3)), np.eye(4))
        pc.certify(body, body)

    def faces(self) -> None:
        points = np.indices((2, 2, 2)).reshape(3, 8).T * 1.0
        sides = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
        for _ in range(int(self.rng.integers(1, 4))):
            side = sides[int(self.rng.integers(len(sides)))]
            side[int(self.rng.integers(len(side)))] = int(self.rng.choice([-1, 0, 1, 5, 7, 8, 2**40]))
            if self.rng.integers(3) == 0:
                points[self.rng.integers(8)] += self.rng.normal(size=3) * 10.0 ** self.rng.integers(-17, 1)
        self.keep(repr((points.tolist(), sides)).encode())
        pc.Polytope(points, sides)

    def poses(self) -> None:
        pose = np.eye(4)
        pose[self.rng.integers(4), self.rng.integers(4)] = self.rng.choice([0, -1, 1, 1 + 1e-7, np.nan, 1e308, 1e-320])
        pose = pose[: self.rng.integers(3, 5)]
        self.keep(repr(pose.tolist()).encode())
        cube = pc.Polytope(np.indices((2, 2, 2)).reshape(3, 8).T * 1.0)
        pc.intersects(cube, cube, pose)
        pc.certify(cube, cube, pose)

    def scene(self) -> None:
        sources = [shipped_folder("configs") / f"{name}.yaml" for name in shipped_scenes()]
        self.load_scene(sources[int(self.rng.integers(len(sources)))].read_bytes())

    def moveit(self) -> None:
        self.load_scene(MOVEIT.encode())

    def load_scene(self, text: bytes) -> None:
        path = self.file("scene.yaml", self.mutated(text))
        scene = pc.Scene.load(path)
        scene.save(self.folder / "again.yaml")
        pc.Scene.load(self.folder / "again.yaml")

    def request(self) -> None:
        read_request(self.file("request.yaml", self.mutated(REQUEST.encode())))

    def robot(self) -> None:
        text = (shipped_folder("robots") / "ur5.yaml").read_bytes()
        pc.Robot.load(self.file("robot.yaml", self.mutated(text)))

    def urdf(self) -> None:
        both = int(self.rng.integers(3))
        urdf = self.file("r.urdf", self.mutated(URDF.encode()) if both != 1 else URDF.encode())
        srdf = self.file("r.srdf", self.mutated(SRDF.encode()) if both != 0 else SRDF.encode())
        self.keep(urdf.read_bytes() + b"\n--\n" + srdf.read_bytes())
        robot = pc.Robot.from_urdf(urdf, srdf, package_dirs=example_robot_data(), group="g")
        pc.Checker(robot).is_valid(robot.reference)

    def body(self) -> None:
        pc.Polytope.load(self.file("some.body", self.mutated_bytes(self.body_file)))

    def parsed_body(self) -> None:
        data = self.mutated_bytes(self.body_bytes)
        self.keep(data)
        pc.Polytope._from_bytes(data)

    def configurations(self) -> None:
        rows = self.rng.normal(size=(5, 3))
        suffix = str(self.rng.choice(["npy", "npz", "csv", "txt", "parquet", "h5"]))
        path = self.folder / f"q.{suffix}"
        if suffix == "npy":
            np.save(path, rows)
        elif suffix == "npz":
            np.savez(path, q=rows)
        elif suffix == "parquet":
            pyarrow.parquet.write_table(pyarrow.table(dict(zip("abc", rows.T, strict=True))), path)
        elif suffix == "h5":
            with h5py.File(path, "w") as file:
                file["q"] = rows
        else:
            path.write_text("a,b,c\n" + "\n".join(",".join(map(str, row)) for row in rows))
        data = path.read_bytes()
        is_text = suffix in ("csv", "txt")
        path = self.file(path.name, self.mutated(data) if is_text else self.mutated_bytes(data))
        for _ in read_chunks(path, ("a", "b", "c"), 3):
            pass

    def file(self, name: str, data: bytes) -> Path:
        """A file with the input at hand."""
        self.keep(data)
        path = self.folder / name
        path.write_bytes(data)
        return path

    def mutated(self, text: bytes) -> bytes:
        """A text with some tokens replaced, lines dropped, doubled or indented, or bytes changed."""
        for _ in range(int(self.rng.integers(1, 4))):
            kind = self.rng.integers(10)
            if kind < 6:
                tokens = [match.span() for match in re.finditer(rb"[-+.\w]+", text)]
                if tokens:
                    start, end = tokens[int(self.rng.integers(len(tokens)))]
                    text = text[:start] + str(self.rng.choice(VALUES)).encode() + text[end:]
            elif kind < 9:
                lines = text.split(b"\n")
                k = int(self.rng.integers(len(lines)))
                lines[k : k + 1] = [[], [lines[k]] * 2, [b"  " + lines[k]]][int(kind) - 6]
                text = b"\n".join(lines)
            else:
                text = self.mutated_bytes(text)
        return text

    def mutated_bytes(self, data: bytes) -> bytes:
        """Data cut short, lengthened, or with some bytes changed."""
        changed = bytearray(data)
        kind = self.rng.integers(4)
        if kind == 0:
            return data[: int(self.rng.integers(len(data) + 1))]
        if kind == 1:
            return data + self.rng.bytes(int(self.rng.integers(1, 40)))
        for _ in range(int(self.rng.integers(1, 6))):
            if changed:
                changed[int(self.rng.integers(len(changed)))] = int(self.rng.choice([0, 1, 127, 128, 255]))
        return bytes(changed)


def work(seed: int) -> None:
    """One round, in a process of its own; the outcomes as one line of JSON."""
    warnings.simplefilter("ignore")
    with tempfile.TemporaryDirectory() as folder:
        place = Path(os.environ.get("FUZZ_FOLDER", folder))
        outcomes, faults = Fuzzer(seed, place).run()
        print(json.dumps([outcomes, faults]))


def main() -> int:
    """Rounds until the time is over; the exit code is 1 if anything but a PlannercheckError came out."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--round", type=int, help="run only this round, in this process")
    options = parser.parse_args()
    if options.round is not None:
        work(options.round)
        return 0
    total: Counter[str] = Counter()
    faults: list[str] = []
    seed, end = options.seed, time.monotonic() + options.seconds
    while time.monotonic() < end:
        outcomes, found = one_round(seed)
        total.update(outcomes)
        faults += found
        seed += 1
    for name, count in sorted(total.items()):
        print(f"{name:24} {count}")
    print(f"{total.total()} inputs in {seed - options.seed} rounds, {len(faults)} faults")
    print("\n\n".join(faults[:20]))
    return 1 if faults else 0


def one_round(seed: int) -> tuple[dict[str, int], list[str]]:
    """A round in a process: its outcomes and faults, the death of the process among them."""
    with tempfile.TemporaryDirectory() as folder:
        environment = {**os.environ, "FUZZ_FOLDER": folder, "PLANNERCHECK_CACHE": "0"}
        command = [sys.executable, __file__, "--round", str(seed)]
        run = subprocess.run(command, capture_output=True, text=True, env=environment)
        if run.returncode == 0:
            outcomes, faults = json.loads(run.stdout.splitlines()[-1])
            return outcomes, [f"round {seed}: {fault}" for fault in faults]
        kept = Path(folder, "input")
        data = repr(kept.read_bytes()[:3000]) if kept.exists() else "none"
        return {}, [f"round {seed} died with {run.returncode}: {run.stderr[-1500:]}\ninput: {data}"]


if __name__ == "__main__":
    sys.exit(main())
