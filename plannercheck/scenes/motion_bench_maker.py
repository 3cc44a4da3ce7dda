"""MotionBenchMaker problem sets: numbered pairs of a planning scene and a motion-plan request.

In: a folder, or a .tar.bz2 (.tar, .tar.gz, ...) of one, with scene0001.yaml, request0001.yaml, and so on.
Out: one `Problem` after another, in the order of their names.
"""

from __future__ import annotations

import re
import tarfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.arrays import OwnsArrays
from plannercheck.common.checked_yaml import BROKEN_FILE, error_context, parse_yaml, read_bytes
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.file_kinds import kind_of
from plannercheck.common.input_limits import INPUT_LIMITS
from plannercheck.common.package_data import is_folder
from plannercheck.scenes.moveit_goals import InverseKinematics
from plannercheck.scenes.moveit_request import MotionRequest, motion_request
from plannercheck.scenes.moveit_scene import attach_from_state, read_planning_scene
from plannercheck.scenes.scene import Scene
from plannercheck.scenes.scene_paths import FindFile

# The role and the number in a file's name.
_MEMBER = re.compile(r"(scene|request)(\d+)\.ya?ml")


@dataclass(frozen=True)
class Problem(OwnsArrays):
    """One planning problem.

    Attributes:
        name: The set's and the problem's name, e.g. "cage_panda/0001".
        scene: The obstacles.
        joint_names: The joints that the goal constrains: those of the planning group.
        start: (nq,) in the order of `joint_names`, rad or m.
        goals: Goals (nq,), at least one.
        held: Values of the start state's other joints, by name, as given.
        group: The name of the group in the request.
    """

    name: str
    scene: Scene
    joint_names: tuple[str, ...]
    start: NDArray[np.float64]
    goals: tuple[NDArray[np.float64], ...]
    held: dict[str, float]
    group: str

    @property
    def goal(self) -> NDArray[np.float64]:
        """The first goal (nq,)."""
        return self.goals[0]


@dataclass(frozen=True)
class ProblemSet:
    """The problems of a set by its name, read one by one when iterated: names of scene and request files by number."""

    name: str
    members: dict[str, tuple[str, str]]
    _read: Callable[[str], bytes]
    _folder: Path
    _ik: InverseKinematics | None = None

    def __len__(self) -> int:
        return len(self.members)

    def __iter__(self) -> Iterator[Problem]:
        return (self.problem(number) for number in self.members)

    def problem(self, number: str) -> Problem:
        """Reads one problem, given its number in the files' names, e.g. "0001"."""
        scene_file, request_file = self.members[number]
        with error_context(f"{self.name}, {scene_file}"):
            scene, folder = Scene(), self._folder / Path(scene_file).parent
            read_planning_scene(scene, parse_yaml(self._read(scene_file)), FindFile(folder))
        with error_context(f"{self.name}, {request_file}"):
            request = motion_request(parse_yaml(self._read(request_file)), self._ik, scene.frames)
            name = f"{self.name}/{number}"
            scene.name = scene.name or name
            with error_context("start_state"):
                attach_from_state(scene, request.state, self._folder / Path(request_file).parent)
            return _problem(name, scene, request)


def load_problems(path: str | Path, ik: InverseKinematics | None = None) -> ProblemSet:
    """Opens a problem set.

    Args:
        path: The set's folder, a folder that contains only this folder, or a tar archive.
        ik: Finds joint values for goals that are poses, as for `moveit_request.read_request`; it gets poses that the
            scene gives in a fixed frame in the planning frame.

    Returns:
        The set; it has a length and can be iterated.
    """
    path = Path(path)
    if is_folder(path):
        names = [str(p.relative_to(path)) for p in sorted(path.rglob("*.y*ml"))]
        found = _problem_set(path, names, lambda name: read_bytes(path / name), path)
    else:
        contents = _archive(path)
        found = _problem_set(path, sorted(contents), contents.__getitem__, path.parent)
    return replace(found, _ik=ik)


def _archive(path: Path) -> dict[str, bytes]:
    """The YAML files of a tar archive by name."""
    try:
        with error_context(f"problem set {str(path)!r}"), tarfile.open(path) as archive:
            return _members(archive)
    except PlannercheckError:
        raise
    except BROKEN_FILE as error:
        raise PlannercheckError(
            f"problem set {str(path)!r} is neither a folder nor a readable tar archive: "
            f"{kind_of(path) or getattr(error, 'strerror', None) or 'no kind of tar can read it'}"
        ) from None


def _members(archive: tarfile.TarFile) -> dict[str, bytes]:
    """The scenes and requests, read as the archive is unpacked; sizes are checked before reading."""
    contents: dict[str, bytes] = {}
    seen = 0
    for member in archive:
        seen += member.size  # skipped members are unpacked as well
        if seen > INPUT_LIMITS.archive_bytes:
            raise PlannercheckError(
                f"the archive unpacks to more than {INPUT_LIMITS.archive_bytes} bytes (INPUT_LIMITS.archive_bytes)"
            )
        if member.isfile() and _MEMBER.fullmatch(PurePosixPath(member.name).name):
            file = archive.extractfile(member)
            contents[member.name] = b"" if file is None else file.read()
    return contents


def _problem_set(path: Path, names: list[str], read: Callable[[str], bytes], folder: Path) -> ProblemSet:
    """Pairs the scenes with the requests."""
    found: dict[str, dict[str, str]] = {}
    sets = set()
    for name in names:
        match = _MEMBER.fullmatch(PurePosixPath(name).name)
        if match:
            sets.add(PurePosixPath(name).parent)
            other = found.setdefault(match[2], {}).setdefault(match[1], name)
            if other != name and PurePosixPath(other).parent == PurePosixPath(name).parent:
                raise PlannercheckError(f"{str(path)!r}: {other} and {name} have one number: leave one out")
    if len(sets) != 1:
        listed = ", ".join(sorted(map(str, sets))) or "none with scene0001.yaml and request0001.yaml"
        raise PlannercheckError(f"{str(path)!r} must hold one problem set; found are {listed}")
    alone = [next(iter(files.values())) for files in found.values() if len(files) == 1]
    if alone:
        raise PlannercheckError(f"{str(path)!r}: {alone[0]} has no counterpart, each scene needs a request")
    members = {number: (files["scene"], files["request"]) for number, files in sorted(found.items())}
    name = sets.pop().name or path.resolve().name.split(".")[0]
    return ProblemSet(name, members, read, folder)


def _problem(name: str, scene: Scene, request: MotionRequest) -> Problem:
    """Splits the start state into the joints that the goals constrain and those that are held."""
    joints = tuple(request.goals[0])
    for k, goal in enumerate(request.goals):
        if set(goal) != set(joints):
            raise PlannercheckError(f"goal {k} constrains {', '.join(goal)}, goal 0 {', '.join(joints)}")
    missing = [joint for joint in joints if joint not in request.start]
    if missing:
        raise PlannercheckError(f"the start state has no value for {', '.join(missing)}")
    start, *goals = (np.array([state[j] for j in joints]) for state in (request.start, *request.goals))
    held = {joint: value for joint, value in request.start.items() if joint not in joints}
    return Problem(name, scene, joints, start, tuple(goals), held, request.group)
