"""MJCF files as MuJoCo's own compiler reads them.

In: a path. Out: `MjcfFile`, the numbers of the compiled model that decide about kinematics and collisions, under the
names that mjModel gives them. MuJoCo resolves includes, frames, replicas, attached models, classes of defaults,
orientations, and primitives fitted to meshes. It runs in a separate process (`mjcf_worker.py`). Compiled models are
cached by the content of all their files (`mjcf_inputs.py`).
"""

from __future__ import annotations

import importlib.util
import io
import json
import signal
import warnings
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.mjcf_inputs import compiled_file
from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import distinct
from plannercheck.common.cache import read_cached, write_to_cache
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.isolated_process import run_isolated
from plannercheck.common.optional_imports import extra_module
from plannercheck.common.progress import reported
from plannercheck.common.transforms import Matrix, pose_of_quaternion

Integers = NDArray[np.int64]

# mjtJoint, mjtGeom and mjtEq of mjmodel.h.
FREE, BALL, SLIDE, HINGE = range(4)
PLANE, HFIELD, SPHERE, CAPSULE, ELLIPSOID, CYLINDER, BOX, MESH, SDF = range(9)
EQUAL_JOINTS = 2

# The flags that decide something here, as mjtDisableBit names them; their bits differ between versions.
FLAGS = ("CONSTRAINT", "CONTACT", "EQUALITY", "FILTERPARENT")

# The kinds of elements that have names, and mjModel's count of each.
NAMED = {"body": "nbody", "joint": "njnt", "geom": "ngeom", "equality": "neq", "flex": "nflex"}

# The name of a model that its file gives none.
_NAMELESS = "MuJoCo Model"

_LONGEST_ERROR = 400
_REPEATED = ": does a count repeat something too often?"

# The arrays of each kind of element whose numbers are used as they are.
_FINITE = {
    "body": ("body_pos", "body_quat"),
    "joint": ("jnt_pos", "jnt_axis", "jnt_range"),
    "geom": ("geom_pos", "geom_quat", "geom_size"),
}


@dataclass(frozen=True, eq=False)
class MjcfFile:
    """What a compiled MJCF file says of bodies, joints, geoms and pairs; arrays are mjModel's, lengths in m, rad.

    Attributes:
        path: The file.
        name: The model's name; empty if the file gives none.
        names: By kind of element, a name for each, all of one kind different: elements without names are called
            "body3", and joints and geoms after their body, "base/joint1", "base/geom3".
        disabled: The `FLAGS` that the file disables.
    """

    path: Path
    name: str
    names: dict[str, tuple[str, ...]]
    disabled: frozenset[str]
    qpos0: Floats
    body_parentid: Integers
    body_weldid: Integers
    body_dofnum: Integers
    body_jntadr: Integers
    body_jntnum: Integers
    body_mocapid: Integers
    body_pos: Floats
    body_quat: Floats
    jnt_type: Integers
    jnt_bodyid: Integers
    jnt_qposadr: Integers
    jnt_limited: Integers
    jnt_range: Floats
    jnt_pos: Floats
    jnt_axis: Floats
    geom_type: Integers
    geom_bodyid: Integers
    geom_contype: Integers
    geom_conaffinity: Integers
    geom_dataid: Integers
    geom_size: Floats
    geom_pos: Floats
    geom_quat: Floats
    mesh_vertadr: Integers
    mesh_vertnum: Integers
    mesh_vert: Floats
    mesh_faceadr: Integers
    mesh_facenum: Integers
    mesh_face: Integers
    hfield_nrow: Integers
    hfield_ncol: Integers
    hfield_adr: Integers
    hfield_size: Floats
    hfield_data: Floats
    flex_contype: Integers
    flex_conaffinity: Integers
    pair_geom1: Integers
    pair_geom2: Integers
    exclude_signature: Integers
    eq_type: Integers
    eq_obj1id: Integers
    eq_obj2id: Integers
    eq_active0: Integers
    eq_data: Floats

    @property
    def body_count(self) -> int:
        """How many bodies there are, the world included."""
        return len(self.body_parentid)

    @property
    def roots(self) -> Integers:
        """(bodies,) the child of the world that each body hangs on; 0 for the world."""
        roots = np.arange(self.body_count)
        for body in range(1, self.body_count):  # parents come first
            if self.body_parentid[body]:
                roots[body] = roots[self.body_parentid[body]]
        return roots

    @property
    def is_of_robot(self) -> NDArray[np.bool_]:
        """(bodies,) which bodies are links: those on a child of the world on which a joint moves something."""
        roots = self.roots
        return np.asarray(np.isin(roots, roots[self.jnt_bodyid]) & (roots > 0))

    def body_pose(self, body: int) -> Matrix:
        """(4, 4) pose of a body on its parent where no joint moves it, m."""
        return _pose(self.body_pos[body], self.body_quat[body])

    def geom_pose(self, geom: int) -> Matrix:
        """(4, 4) pose of a geom on its body, m."""
        return _pose(self.geom_pos[geom], self.geom_quat[geom])

    def world_pose(self, body: int) -> Matrix:
        """(4, 4) pose in the world of a body that no joint moves, m."""
        pose = np.eye(4)
        while body:
            pose, body = self.body_pose(body) @ pose, int(self.body_parentid[body])
        return pose

    def refused(self, kind: str, number: int, why: str) -> PlannercheckError:
        """The error for an element of the file."""
        return PlannercheckError(f"MJCF {self.path}: {kind} {self.names[kind][number]!r} {why}")


_OWN = ("path", "name", "names", "disabled")

# The arrays that the worker takes from mjModel.
FIELDS = tuple(each.name for each in fields(MjcfFile) if each.name not in _OWN)


def read_mjcf(path: Path) -> MjcfFile:
    """Compiles an MJCF file.

    Raises:
        PlannercheckError: If MuJoCo is not installed or refuses the file; the message is MuJoCo's.
    """
    found = _compiled(path)
    if "error" in found:
        why = _one_line(str(found["error"]))
        hint = _REPEATED if "unknown exception" in why else ""  # as MuJoCo says where memory ends
        raise PlannercheckError(f"MJCF {path}: MuJoCo does not compile it: {why}{hint}")
    said = _one_line(str(found["said"]))
    if said:
        warnings.warn(f"MJCF {path}: MuJoCo says: {said}", RuntimeWarning, stacklevel=6)
    names = json.loads(str(found["names"]))
    arrays = {field: _widened(found[field]) for field in FIELDS}
    given = names["model"][0]
    file = MjcfFile(
        path,
        "" if given == _NAMELESS else given,
        _all_names(names, arrays),
        frozenset(found["disabled"].tolist()),
        **arrays,
    )
    _check_finite(file)
    return file


def _compiled(path: Path) -> dict[str, NDArray[Any]]:
    """What the worker says of a file, see `mjcf_worker.py`; known from an earlier time if its files are the same."""
    if importlib.util.find_spec("mujoco") is None:
        extra_module("mujoco", "mjcf", "MJCF files")
    cache = compiled_file(path, "\n".join(FIELDS))
    known = None if cache is None else read_cached(cache)
    if known is not None:
        return _arrays_of(known)
    with reported(f"compiling {path.name}"):
        ran = run_isolated("plannercheck.bodies.mjcf_worker", [str(path.absolute())])
    if ran.returncode:
        raise PlannercheckError(f"MJCF {path}: MuJoCo's compiler {_how_it_ended(ran.returncode, ran.stderr)}")
    found = _arrays_of(ran.stdout)
    if cache is not None and "error" not in found and cache == compiled_file(path, "\n".join(FIELDS)):
        write_to_cache(cache, ran.stdout)  # of files that have not changed meanwhile
    return found


def _arrays_of(content: bytes) -> dict[str, NDArray[Any]]:
    with np.load(io.BytesIO(content), allow_pickle=False) as arrays:
        return {key: arrays[key] for key in arrays.files}


def _widened(array: NDArray[Any]) -> NDArray[Any]:
    """Doubles of floats, which are exact; 64 bits of integers and truths."""
    return np.asarray(array, dtype=np.float64 if array.dtype.kind == "f" else np.int64)


def _all_names(given: Mapping[str, list[str]], arrays: Mapping[str, NDArray[Any]]) -> dict[str, tuple[str, ...]]:
    """The names of all elements; those without one are named after their body and their place on it."""
    names = {"body": _with_names(given["body"], [f"body{k}" for k in range(len(given["body"]))])}
    for kind, owners in (("joint", arrays["jnt_bodyid"]), ("geom", arrays["geom_bodyid"])):
        counts: Counter[int] = Counter()
        made = []
        for owner in owners.tolist():
            made.append(f"{names['body'][owner]}/{kind}{counts[owner]}")
            counts[owner] += 1
        names[kind] = _with_names(given[kind], made)
    for kind in ("equality", "flex"):
        names[kind] = _with_names(given[kind], [f"{kind}{k}" for k in range(len(given[kind]))])
    return names


def _with_names(given: Sequence[str], made: Sequence[str]) -> tuple[str, ...]:
    """The names that are given, in place of empty ones those that are made, all different."""
    taken, found = set(given), []
    for name, other in zip(given, made, strict=True):
        while not name:
            name, other = ("" if other in taken else other), f"{other}'"
        taken.add(name)
        found.append(name)
    return tuple(found)


def _pose(position: Floats, quaternion: Floats) -> Matrix:
    """The pose (4, 4) of MuJoCo's numbers, whose quaternions begin with w."""
    w, x, y, z = quaternion.tolist()
    return pose_of_quaternion(position.tolist(), (x, y, z, w))


def _check_finite(file: MjcfFile) -> None:
    """Raises for numbers that MuJoCo lets pass although no body can have them."""
    for kind, arrays in _FINITE.items():
        for name in arrays:
            array: NDArray[Any] = getattr(file, name)
            bad = distinct(np.argwhere(~np.isfinite(array))[:, 0])
            if len(bad):
                raise file.refused(kind, int(bad[0]), f"has {name} {array[bad[0]].tolist()}: numbers must be finite")


def _how_it_ended(code: int, said: bytes) -> str:
    """Why there is no compiled model, in words."""
    if code < 0:
        return f"was ended by {signal.Signals(-code).name}{_REPEATED}"
    return f"fails: {_one_line(said.decode(errors='replace'))[-_LONGEST_ERROR:]}"


def _one_line(text: str) -> str:
    words = " ".join(text.replace("\0", " ").split())
    return words if len(words) <= _LONGEST_ERROR else f"{words[: _LONGEST_ERROR - 3]}..."
