"""Functions that compare the model in a proof with the files of robot and scene, by kind of proof, and read paths.

In: a comparison for each kind and three readers, from the package's face, above all folders. Out: these, for
`plannercheck.proofs`. Loading the files takes all of the package, while proofs stand on `common` alone.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, TypeAlias

# Takes a proof's model (or proofs of pairs), a robot, a scene (None for the empty one), the kinds of the scene's and of
# the robot's meshes, how mesh files are read (None for what the files say), and of a model its motions; raises at the
# first difference. Returns sentences: what was compared with which file.
Comparison: TypeAlias = Callable[..., tuple[str, ...]]

# Takes a path, the names of its joints, the length of a configuration, and the robot or None; see `read_proved_path` in
# `validation.formats.paths`.
PathReader: TypeAlias = Callable[[Any, Sequence[str], int, Any], Any]

# Joints by name that follow others: the leader, the multiplier and the offset.
Followers: TypeAlias = Mapping[str, tuple[str, float, float]]

# Takes a file of JointTrajectories, the names of its joints, which of several it is (None: the file holds one), and the
# joints that follow these (None: they are not known); returns its points, see `trajectories.messages`.
MessageReader: TypeAlias = Callable[[Any, Sequence[str], int | None, Followers | None], Any]


class RobotJoints(NamedTuple):
    """The joints of a robot: the names in their order, the numbers of a configuration, and who follows them."""

    names: tuple[str, ...]
    columns: int
    followers: Followers


# Takes a robot as `Proof.verify` does.
JointReader: TypeAlias = Callable[[Any], RobotJoints]

_comparisons: dict[str, Comparison] = {}
_path_readers: list[PathReader] = []
_message_readers: list[MessageReader] = []
_joint_readers: list[JointReader] = []


def set_model_comparison(kind: str, comparison: Comparison) -> None:
    """Sets what compares the models of proofs of a kind, "space", "pairs" or "plane"."""
    _comparisons[kind] = comparison


def model_comparison(kind: str) -> Comparison:
    """What compares the models of proofs of a kind, "space", "pairs" or "plane"."""
    return _comparisons[kind]


def set_path_reader(reader: PathReader) -> None:
    """Sets what reads path files."""
    _path_readers[:] = [reader]


def path_reader() -> PathReader:
    """What reads path files."""
    return _path_readers[0]


def set_message_reader(reader: MessageReader) -> None:
    """Sets what reads files of trajectories."""
    _message_readers[:] = [reader]


def message_reader() -> MessageReader:
    """What reads files of trajectories."""
    return _message_readers[0]


def set_joint_reader(reader: JointReader) -> None:
    """Sets what reads a robot's joints."""
    _joint_readers[:] = [reader]


def joint_reader() -> JointReader:
    """What reads a robot's joints."""
    return _joint_readers[0]
