"""Everything in plannercheck that reads a file or an array, and mutated inputs for it.

In: a folder, a loader's name, a number. Out: what the loader made of that mutated input, which the number alone
determines (with the seed): `accepted`, or the PlannercheckError that refuses it; anything else is a fault.
"""

import contextlib
import io
import os
import signal
import subprocess
import sys
import zlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

import plannercheck as pc
from long_runs import forked, seed_files
from long_runs.mutations import damaged, mutated_text
from plannercheck.bodies.mesh_files import read_mesh
from plannercheck.evaluation.campaign.cases import load as load_case
from plannercheck.evaluation.stress import campaign as stress
from plannercheck.evaluation.stress_motions import campaign as stress_motions
from plannercheck.ompl.plans import Plan
from plannercheck.proofs import load_proofs
from plannercheck.proofs.urdf_joints import read_tree
from plannercheck.robots import urdf_messages
from plannercheck.scenes.motion_bench_maker import load_problems
from plannercheck.scenes.moveit_request import read_request
from plannercheck.trajectories import joint_limits
from plannercheck.validation.formats.chunks import STANDARD_INPUT, read_chunks
from plannercheck.validation.formats.paths import read_path

ACCEPTED = "accepted"
JOINTS = seed_files.JOINTS

Read = Callable[[Path], object]
Mutation = Callable[[bytes, np.random.Generator], bytes]


@dataclass(frozen=True)
class Loader:
    """What reads a file.

    Attributes:
        read: Reads it, and uses what it read.
        suffixes: Of the seed files that are mutated; others stand beside them. Empty: all.
        mutations: What is done to texts, and to bytes.
    """

    read: Read
    suffixes: tuple[str, ...] = ()
    mutations: tuple[Mutation, ...] = (mutated_text,)


def _urdf(path: Path) -> None:
    robot = pc.Robot.from_urdf(path, package_dirs=[path.parent])
    pc.Checker(robot).is_valid(robot.reference)


def _srdf(path: Path) -> None:
    robot = pc.Robot.from_urdf(path.with_suffix(".urdf"), path, package_dirs=[path.parent], group="g")
    pc.Checker(robot).is_valid(robot.reference)


def _robot(path: Path) -> None:
    robot = pc.Robot.load(path)
    pc.Checker(robot).is_valid(robot.reference)


def _planar_robot(path: Path) -> None:
    robot = pc.planar.Robot.load(path)
    pc.planar.Checker(robot, pc.planar.Scene()).is_valid(np.zeros(robot.nq))


def _scene(path: Path) -> None:
    again = path.with_name("again.yaml")
    pc.Scene.load(path).save(again)
    pc.Scene.load(again)


def _scene_text(path: Path) -> None:
    again = path.with_name("again.scene")
    pc.Scene.load(path).save(again)
    pc.Scene.load(again)


def _pose_request(path: Path) -> None:
    read_request(path, lambda goal: {"j": float(goal.pose[0, 3]), "k": 0.5})


def _planar_scene(path: Path) -> None:
    again = path.with_name("again.yaml")
    pc.planar.Scene.load(path).save(again)
    pc.planar.Scene.load(again)


def _problems(path: Path) -> None:
    for _ in load_problems(path):
        pass


def _problem_folder(path: Path) -> None:
    _problems(path.parent)


def _proofs(path: Path) -> None:
    for proof in load_proofs(path):
        bool(proof.verify())


def _rows(path: Path) -> None:
    for _ in read_chunks(path, JOINTS, len(JOINTS)):
        pass


def _stream(path: Path) -> None:
    with path.open("rb") as file, _standard_input(file):
        _rows(STANDARD_INPUT)


@contextlib.contextmanager
def _standard_input(file: io.BufferedReader) -> Iterator[None]:
    before = sys.stdin
    sys.stdin = io.TextIOWrapper(file)
    try:
        yield
    finally:
        sys.stdin = before


def _by_a_fork(
    module: str, arguments: Sequence[str] = (), content: bytes = b"", time_limit: float | None = None
) -> subprocess.CompletedProcess[bytes]:
    """What `run_isolated` does for a URDF that does not load, in a fork: starting Python takes half a second."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            signal.setitimer(signal.ITIMER_REAL, forked.TIME_LIMIT)
            for stream in (1, 2):
                os.dup2(writing, stream)
            urdf_messages.main(*arguments)
        finally:
            os._exit(0)
    os.close(writing)
    with os.fdopen(reading, "rb") as pipe:
        said = pipe.read()
    _, status = os.waitpid(child, 0)
    return subprocess.CompletedProcess([module], status, said, b"")


@cache
def _arm() -> pc.Robot:
    return pc.Robot.load("panda").with_group(seed_files.ARM)


def _timed(path: Path) -> None:
    arm = _arm()
    trajectory = pc.Trajectory.load(path, arm)
    middle = trajectory.curve.breaks.mean()
    trajectory.position(middle)
    trajectory.limits(arm, velocity=1.0, acceleration=1.0)


def _mesh(path: Path) -> None:
    read_mesh(path)


def _octomap(path: Path) -> None:
    octree = pc.Octree.load(path)
    octree.query(octree.boxes()[0][:10])
    if octree.count:
        _used(octree)
    again = path.with_name("again.bt")
    octree.save(again)
    pc.Octree.load(again)
    again.unlink()


def _cloud(path: Path) -> None:
    cloud = pc.PointCloud.load(path, 0.05, invalid="drop")
    if cloud.count:
        _used(cloud)
    cloud.without_covered()
    cloud.thinned(0.1)


def _used(shape: pc.PointCloud | pc.Octree | pc.VoxelGrid | pc.HeightField) -> None:
    """The shape as a body."""
    if not (np.diff(shape.bounds, axis=0) >= 0).all():
        raise AssertionError(f"bounds {shape.bounds.tolist()}")
    body = pc.Polytope(shape)
    if not pc.intersects(pc.Polytope(shape.core.part(0)[0]), body):
        raise AssertionError("a part and its own set share no point")


_BYTES = (damaged,)
_BOTH = (mutated_text, damaged)

FILES: dict[str, Loader] = {
    "urdf": Loader(_urdf, (".urdf",)),
    "srdf": Loader(_srdf, (".srdf",)),
    "robot_yaml": Loader(_robot, (".yaml",)),
    "urdf_of_proof": Loader(read_tree, (".urdf",)),
    "planar_robot": Loader(_planar_robot),
    "scene_yaml": Loader(_scene, (".yaml",)),
    "scene_arrays": Loader(lambda path: _scene(path.with_name("s.yaml")), (".npy",), _BOTH),
    "planar_scene": Loader(_planar_scene, (".yaml",)),
    "moveit_scene": Loader(_scene),
    "moveit_world": Loader(_scene),
    "scene_text": Loader(_scene_text, (".scene",), _BOTH),
    "collision_matrix": Loader(_scene),
    "moveit_request": Loader(read_request),
    "pose_request": Loader(_pose_request),
    "problem_folder": Loader(_problem_folder, (".yaml",)),
    "problem_archive": Loader(_problems, (), _BYTES),
    "path": Loader(lambda path: read_path(path, JOINTS, len(JOINTS)), (), _BOTH),
    "trajectory": Loader(lambda path: read_path(path, JOINTS, len(JOINTS))),
    "timed": Loader(_timed),
    "timed_npz": Loader(_timed, (), _BYTES),
    "bag": Loader(_timed, (), _BYTES),
    "joint_limits": Loader(lambda path: joint_limits.read(path, _arm())),
    "plan": Loader(Plan.load),
    "proof_json": Loader(_proofs),
    "proof_npz": Loader(_proofs, (), _BYTES),
    "body": Loader(pc.Polytope.load, (), _BYTES),
    "pickled_body": Loader(lambda path: pc.Polytope._from_bytes(path.read_bytes()), (), _BYTES),
    "npy": Loader(_rows, (), _BOTH),
    "npy_stream": Loader(_stream, (), _BOTH),
    "npz": Loader(_rows, (), _BYTES),
    "csv": Loader(_rows),
    "csv_stream": Loader(_stream),
    "parquet": Loader(_rows, (), _BYTES),
    "hdf5": Loader(_rows, (), _BYTES),
    "stl": Loader(_mesh, (), _BOTH),
    "obj": Loader(_mesh),
    "ply": Loader(_mesh, (), _BOTH),
    "dae": Loader(_mesh),
    "octomap": Loader(_octomap, (".bt", ".ot"), _BOTH),
    "cloud": Loader(_cloud, (), _BOTH),
    "voxels": Loader(lambda path: _used(pc.VoxelGrid.load(path, 0.1)), (), _BOTH),
    "heights": Loader(lambda path: _used(pc.HeightField.load(path, 0.1, -1.0)), (), _BOTH),
    "stress_case": Loader(lambda path: load_case(path, {"pairs": lambda: stress.campaign(0)})),
    "stress_motion": Loader(lambda path: load_case(path, {"motions": lambda: stress_motions.campaign(0)})),
}


def _points(rng: np.random.Generator) -> None:
    """A body of points (n, 3), or of something like it."""
    n = int(rng.choice([0, 1, 2, 3, 4, 5, 8, 20, 100]))
    points = rng.normal(size=(n, 3)) * 10.0 ** rng.choice([-320, -160, -30, -6, 0, 0, 6, 30, 49, 160, 307])
    if rng.integers(2):
        points = rng.integers(-2, 3, size=(n, 3)).astype(float)  # many coincide or are coplanar
    if n and rng.integers(3) == 0:
        points[rng.integers(n), rng.integers(3)] = rng.choice([np.nan, np.inf, -np.inf, 5e-324, 1e308, -0.0, 1e50])
    if rng.integers(8) == 0:
        points = [points.ravel(), points[:, :2], points[None], points.T, points * 1j][int(rng.integers(5))]
    inflation_radius = rng.choice([0.0, 0.1, 1e-300, 1e60, -1.0, np.nan, np.inf]) if rng.integers(2) else 0.0
    body = pc.Polytope(points, inflation_radius=inflation_radius)
    if body.fault():
        raise AssertionError(body.fault())
    pc.intersects(body, pc.Polytope(np.eye(3)), np.eye(4))
    if not pc.intersects(body, body):
        raise AssertionError(f"a body and itself share no point: {points.tolist()}")
    pc.certify(body, body)


def _faces(rng: np.random.Generator) -> None:
    """A cube whose corners or faces are not quite its own."""
    points = np.indices((2, 2, 2)).reshape(3, 8).T * 1.0
    sides = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    for _ in range(int(rng.integers(1, 4))):
        side = sides[int(rng.integers(len(sides)))]
        side[int(rng.integers(len(side)))] = int(rng.choice([-1, 0, 1, 5, 7, 8, 2**40]))
        if rng.integers(3) == 0:
            points[rng.integers(8)] += rng.normal(size=3) * 10.0 ** rng.integers(-17, 1)
    pc.Polytope(points, sides)


def _poses(rng: np.random.Generator) -> None:
    """A pose that is not quite rigid, or of another shape."""
    pose = np.eye(4)
    pose[rng.integers(4), rng.integers(4)] = rng.choice([0, -1, 1, 1 + 1e-7, np.nan, 1e308, 1e-320])
    pose = pose[: rng.integers(3, 5)]
    cube = pc.Polytope(np.indices((2, 2, 2)).reshape(3, 8).T * 1.0)
    pc.intersects(cube, cube, pose)
    pc.certify(cube, cube, pose)


ARRAYS: dict[str, Callable[[np.random.Generator], None]] = {"points": _points, "faces": _faces, "poses": _poses}
NAMES = (*FILES, *ARRAYS)


class Inputs:
    """Mutated inputs of all loaders, in a folder."""

    def __init__(self, folder: Path, seed: int) -> None:
        """Makes the seed files; in a fork, since pyarrow starts threads, with which one may not fork."""
        self._folder, self._seed = folder, seed
        forked.apart(lambda: seed_files.make(folder), folder)
        self._seeds = {name: self._seeds_of(name) for name in FILES}
        self._changed: tuple[Path, bytes] | None = None  # a file that is mutated now, and what it was

    def _seeds_of(self, name: str) -> list[tuple[Path, bytes]]:
        loader, root = FILES[name], self._folder / name
        files = sorted(path for path in root.rglob("*") if path.is_file())
        return [(path, path.read_bytes()) for path in files if not loader.suffixes or path.suffix in loader.suffixes]

    def trial(self, name: str) -> Callable[[int], str]:
        """A function that gives a loader the input of a number; to be called in a fork."""
        urdf_messages.run_isolated = _by_a_fork  # type: ignore[attr-defined]
        if name in ARRAYS:
            return lambda number: self._given(ARRAYS[name], number, name)
        return lambda number: self._read(name, number)

    def _given(self, function: Callable[[np.random.Generator], None], number: int, name: str) -> str:
        function(self._random(name, number))
        return ACCEPTED

    def _read(self, name: str, number: int) -> str:
        loader, rng = FILES[name], self._random(name, number)
        seeds = self._seeds[name]
        path, content = seeds[int(rng.integers(len(seeds)))]
        mutation = loader.mutations[int(rng.integers(len(loader.mutations)))]
        if self._changed is not None and self._changed[0] != path:
            self._changed[0].write_bytes(self._changed[1])
        path.write_bytes(mutation(content, rng))
        self._changed = path, content
        loader.read(path)
        return ACCEPTED

    def content(self, name: str, number: int) -> bytes:
        """The input of a number; nothing where it is an array."""
        if name in ARRAYS:
            return b""
        loader, rng = FILES[name], self._random(name, number)
        seeds = self._seeds[name]
        _, content = seeds[int(rng.integers(len(seeds)))]
        return loader.mutations[int(rng.integers(len(loader.mutations)))](content, rng)

    def restore(self, name: str) -> None:
        """Sound files again, after a fork died with a mutated one in place."""
        for path, content in self._seeds.get(name, []):
            path.write_bytes(content)

    def _random(self, name: str, number: int) -> np.random.Generator:
        return np.random.default_rng([self._seed, zlib.crc32(name.encode()), number])
