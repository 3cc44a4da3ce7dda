"""The joints and units of a file's columns.

In: a robot, and the names of a file's columns if it has them. Out: `Columns`, which finds each joint's column and
brings rows to the robot's order, in rad and m.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from difflib import get_close_matches

import numpy as np

from plannercheck import planar
from plannercheck.checking.protocols import AnyRobot
from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.errors import PlannercheckError, shortened
from plannercheck.robots.configurations import PLAIN, ConfigurationMap
from plannercheck.robots.joints import SLIDE, kind_of
from plannercheck.robots.robot import Robot

# Names of columns that an error lists.
_SHOWN_NAMES = 20


class WidthError(PlannercheckError):
    """A file has other columns than expected; perhaps it gives configurations in another way."""


class HeaderError(WidthError):
    """A file names its columns, though joints take several numbers."""


@dataclass(frozen=True, eq=False)
class Columns:
    """The columns that a configuration needs.

    Attributes:
        joints: A name for each joint, in the robot's order.
        width: Numbers in a configuration, nq; more than joints if some take several.
        named: The file's names of the joints, in the same order; None if they are the robot's.
        held: Held joints of the robot, which configurations do not have.
        ignored: Columns to ignore though they have the name of a held joint.
        degrees: (nq,) which numbers are given in degrees; None if none is.
        described: A sentence about which joint takes which columns.
        spread: Turns rows into configurations; None if they already are configurations.
        others: The same robot's configurations by fewer numbers, see `JointValues`.
    """

    joints: tuple[str, ...]
    width: int
    named: tuple[str, ...] | None = None
    held: frozenset[str] = frozenset()
    ignored: frozenset[str] = frozenset()
    degrees: Bools | None = None
    described: str = ""
    spread: Callable[[Floats], Floats] | None = None
    others: tuple[Columns, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """What a file has to call its columns, in the robot's order."""
        return self.joints if self.named is None else self.named

    def places(self, header: Sequence[str]) -> list[int]:
        """The index in a file's header of each joint's column, (nq,).

        Raises:
            PlannercheckError: If a joint has no column or several, or a column is of a joint that is held.
        """
        if len(self.joints) != self.width:
            raise HeaderError(
                f"has a header, but {len(self.joints)} joints take {self.width} numbers: leave the header out"
            )
        for name in self.names:
            if header.count(name) > 1:
                raise PlannercheckError(f"has {header.count(name)} columns named {name!r}")
        self._check_complete(header)
        self._check_others([name for name in header if name not in self.names])
        return [header.index(name) for name in self.names]

    def _check_complete(self, header: Sequence[str]) -> None:
        missing = [name for name in self.names if name not in header]
        if not missing:
            return
        if len(missing) == len(self.names):
            raise WidthError(
                f"begins with neither numbers nor names of joints: {_listed(header)!r:.60}; write decimal points, not "
                f"commas, or a header of {', '.join(self.names)}; or say by --columns what the joints are called, in "
                "the robot's order"
            )
        unknown = [name for name in header if name not in self.names]
        close = get_close_matches(missing[0], unknown, n=1)
        hint = f"is it {close[0]!r}? " if close else ""
        raise WidthError(
            f"has no column for joint {missing[0]!r}; its header is {_listed(header)}; {hint}--columns says what the "
            "joints are called, in the robot's order"
        )

    def _check_others(self, others: Sequence[str]) -> None:
        """Columns that no configuration takes are left out, but those of held joints would change verdicts."""
        held = [name for name in others if name in self.held and name not in self.ignored]
        if held:
            raise PlannercheckError(
                f"column {held[0]!r} is of a joint that is held, not read: choose a group with it, or leave its values "
                f"out by --ignore-columns {','.join(held)}"
            )
        left_out = [name for name in others if name not in self.ignored]
        if left_out:
            warnings.warn(f"columns that are no joints are left out: {_listed(left_out)}", RuntimeWarning, stacklevel=2)

    @property
    def listed(self) -> str:
        """Words for which joint takes which columns, and for how else configurations may be given."""
        listed = self.described or f"the joints are {', '.join(self.joints) or 'none'}"
        fewer = [f"{each.width} ({', '.join(each.joints)})" for each in self.others if each.width == len(each.joints)]
        return f"{listed}; or a number a joint: {' or '.join(fewer)}" if fewer else listed

    def check_width(self, width: int) -> None:
        """Raises unless rows without names have as many numbers as a configuration."""
        if width != self.width:
            raise WidthError(f"must have {self.width} columns ({self.listed}), not {width}")
        self.check_nameless()

    def check_nameless(self) -> None:
        """Raises if columns are to be found by names, in a file that has none."""
        if self.named is not None:
            raise PlannercheckError(
                "names no columns, so that --columns finds none: leave it out if its columns are in the robot's order"
            )
        if self.ignored and self.spread is None:
            raise PlannercheckError("names no columns, so that --ignore-columns leaves none out: leave it out")

    def configurations(self, rows: Floats) -> Floats:
        """Configurations (n, nq) of rows: degrees turned into radians, joint values into what the robot takes."""
        if self.degrees is not None:
            rows = np.where(self.degrees, np.deg2rad(rows), rows)
        return rows if self.spread is None else self.spread(rows)


def columns_of(
    robot: AnyRobot,
    named: Sequence[str] | None = None,
    ignored: Sequence[str] = (),
    degrees: bool = False,
) -> Columns:
    """The columns that a robot's configurations need; those `ignored` are left out though they are of held joints.

    `named` are the names of its joints in files, in its order; None for its own names. With `degrees`, angles are so.
    """
    if named is not None and len(named) != len(robot.joint_names):
        raise PlannercheckError(
            f"--columns must name {len(robot.joint_names)} columns, for {', '.join(robot.joint_names)}; "
            f"not {len(named)}: {', '.join(named)}"
        )
    every = tuple(robot.model.names)[1:] if isinstance(robot, Robot) else ()
    return Columns(
        joints=tuple(robot.joint_names),
        width=robot.nq,
        named=None if named is None else tuple(named),
        held=frozenset(every) - frozenset(robot.joint_names),
        ignored=frozenset(ignored),
        degrees=angle_columns(robot) if degrees else None,
        described=robot.configuration_map.described_columns() if isinstance(robot, Robot) else "",
        others=_by_joints(robot, named, frozenset(ignored), degrees) if isinstance(robot, Robot) else (),
    )


def _by_joints(
    robot: Robot, named: Sequence[str] | None, ignored: frozenset[str], degrees: bool
) -> tuple[Columns, ...]:
    """The columns of files that give one number a joint."""
    return tuple(
        Columns(
            joints=each.joint_names,
            width=each.width,
            named=tuple(named) if named is not None and len(named) == len(each.joint_names) else None,
            ignored=ignored | (frozenset(robot.joint_names) - frozenset(each.joint_names)),
            degrees=_angles(robot, each) if degrees else None,
            described=each.described_columns(),
            spread=each.expand,
        )
        for each in robot.joint_values.maps
    )


def angle_columns(robot: AnyRobot) -> Bools:
    """(nq,) which numbers of a configuration are angles; lengths and parts of unit vectors are none."""
    angles = np.zeros(robot.nq, dtype=bool)
    if isinstance(robot, planar.Robot):
        angles[2 if robot.is_free else 0 :] = True
    elif isinstance(robot, Robot):
        return _angles(robot, robot.configuration_map)
    return angles


def _angles(robot: Robot, used: ConfigurationMap) -> Bools:
    """(width,) which numbers that a map takes are angles."""
    angles, model = np.zeros(used.width, dtype=bool), robot.model
    for joint in range(1, model.njoints):
        entry = model.idx_qs[joint]
        turns = model.nqs[joint] == 1 and kind_of(model.joints[joint]) is not SLIDE
        if used.columns[entry] >= 0 and (turns or used.roles[entry] != PLAIN):
            angles[used.columns[entry]] = True
    return angles


def _listed(names: Sequence[str]) -> str:
    shown = ", ".join(map(shortened, names[:_SHOWN_NAMES]))
    return shown if len(names) <= _SHOWN_NAMES else f"{shown} and {len(names) - _SHOWN_NAMES} more"
