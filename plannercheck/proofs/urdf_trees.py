"""Compares the links and joints in a proof with a URDF, read by the verifier itself in exact numbers.

In: a model, the URDF's text. Out: a sentence that says how far the proof's doubles are from the exact numbers, a proved
bound; or an `UnprovedError` that names the first difference. Doubles may be off by the rounding of those who made them
and no more: placements by `Placement.allowance`, axes by `ROUNDING`, multipliers and offsets by `ROUNDING` of their
size for each joint that is followed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from operator import itemgetter
from pathlib import Path
from typing import TypeAlias

from flint import arb

from plannercheck.common.errors import PlannercheckError
from plannercheck.proofs.data import JOINTS, WORLD, Joint, Link, Model
from plannercheck.proofs.exact_placements import (
    ROUNDING,
    Placement,
    at_rest,
    decimals,
    enough_digits,
    furthest,
    off_placement,
)
from plannercheck.proofs.faults import UnprovedError
from plannercheck.proofs.urdf_joints import UrdfJoint, UrdfTree, read_tree

# By the URDF's type, the kinds that a joint may have in a proof.
_KINDS = {
    "revolute": ("turn",),
    "continuous": ("turn", "circle"),
    "prismatic": ("slide",),
    "planar": ("planar",),
    "floating": ("free",),
}


Named: TypeAlias = Joint | Link


@dataclass(frozen=True, eq=False)
class RobotPlace:
    """A robot of a cell in a model.

    Attributes:
        prefix: What the names of its links and joints begin with; empty if the model has one robot.
        base: Where its base stands in the world; None for the origin.
    """

    prefix: str = ""
    base: Placement | None = None

    def named(self, items: Sequence[Named]) -> dict[str, int]:
        """By name without the prefix, which of some links or joints are the robot's."""
        found = ((k, item.name) for k, item in enumerate(items))
        return {name[len(self.prefix) :]: k for k, name in found if name.startswith(self.prefix)}


ALONE = RobotPlace()


@enough_digits()
def confirm_tree(
    model: Model, urdf: str | Path, content: str | None, floating: bool, whole: bool, place: RobotPlace = ALONE
) -> str:
    """Compares the links and joints of a model with those of a URDF.

    Args:
        model: The well-formed model of a proof.
        urdf: The file.
        content: What to read in its place: what a xacro expands to.
        floating: Whether the robot's first joint, which is not the URDF's, moves the root freely.
        whole: Whether no joint follows another one.
        place: Which links and joints of the model are compared: those of one robot, and where it stands.

    Returns:
        What was compared.

    Raises:
        UnprovedError: If they differ.
        PlannercheckError: If the file can't be read.
    """
    comparison = _TreeComparison(model, read_tree(urdf, content), floating, whole, place)
    comparison.run()
    of_robot = f" of {place.prefix!r}" if place.prefix else ""
    return (
        f"links and joints{of_robot} with {str(urdf)!r}, read by itself in exact numbers, from which the proof's are "
        f"at most {comparison.most:.2g} away"
    )


@enough_digits()
def confirm_limits(
    model: Model,
    limits: tuple[Sequence[float], Sequence[float]],
    urdf: str | Path,
    content: str | None,
    place: RobotPlace = ALONE,
) -> set[int]:
    """Checks that limits hold all that a URDF's joints can take, or one turn of those without limits.

    The model's tree is that of the URDF; limits are (columns,) each, rad and m; other arguments as of `confirm_tree`.

    Returns:
        The columns of these joints.

    Raises:
        UnprovedError: If the limits do not.
        PlannercheckError: If the file can't be read.
    """
    joints, columns = place.named(model.joints), set[int]()
    for found in read_tree(urdf, content).above.values():
        joint = model.joints[joints[found.name]] if found.name in joints else None
        if joint is None or len(joint.columns) > 1 or joint.columns[0] < 0 or found.mimic is not None:
            continue
        column = joint.columns[0]
        low, high = (side[column] for side in limits)
        if found.kind == "continuous":
            holds = arb(high) - arb(low) >= 2 * arb.pi()
        else:
            texts = found.limits or ("", "")
            try:
                lowest, highest = (float(decimals(text, 1, "a limit")[0]) for text in texts)
            except ValueError as error:
                raise PlannercheckError(f"URDF {str(urdf)!r}: joint {found.name!r}: {error}") from None
            holds = low <= lowest and highest <= high
        if not holds:
            raise UnprovedError(f"joint {joint.name!r} may go beyond [{low!r}, {high!r}], by the URDF")
        columns.add(column)
    return columns


class _TreeComparison:
    """The joints and links of a model beside those of a URDF."""

    def __init__(self, model: Model, tree: UrdfTree, floating: bool, whole: bool, place: RobotPlace) -> None:
        self._model, self._tree, self._floating, self._whole = model, tree, floating, whole
        self._links, self._joints = place.named(model.links), place.named(model.joints)
        self._base = at_rest() if place.base is None else place.base
        self._root = min(self._joints.items(), key=itemgetter(1), default=("", WORLD))  # the joint of a floating root
        self._places = self._placed()
        self.most = 0.0  # how far any number is off

    def run(self) -> None:
        """Raises at the first difference."""
        if self._links.keys() != set(self._tree.links):
            names = sorted(self._links.keys() ^ set(self._tree.links))[:3]
            raise UnprovedError(f"links of the proof and of the URDF differ: {names}")
        for name, k in self._links.items():
            link = self._model.links[k]
            self._compare(f"link {link.name!r}", link.joint, link.placement, *self._places[name])
        moving = {joint.name for joint in self._tree.above.values() if joint.kind != "fixed"}
        known = moving | ({self._root[0]} if self._floating and self._joints else set())
        if self._joints.keys() != known:
            names = sorted(self._joints.keys() ^ known)[:3]
            raise UnprovedError(f"joints of the proof and of the URDF differ: {names}")
        if self._floating:
            root = self._model.joints[self._root[1]]
            self._compare(f"joint {root.name!r}", root.parent, root.placement, WORLD, self._base)
        for found in self._tree.above.values():
            if found.kind != "fixed":
                self._compare_joint(self._model.joints[self._joints[found.name]], found)

    def _placed(self) -> dict[str, tuple[int, Placement]]:
        """By link, the moving joint that it is on, by index, and its placement there."""
        on = (self._root[1], at_rest()) if self._floating else (WORLD, self._base)
        places = {self._tree.root: on}
        for link, above in self._tree.above.items():
            if above.kind == "fixed":
                joint, placement = places[above.parent]
                places[link] = joint, placement.times(above.placement)
            else:
                places[link] = self._joints.get(above.name, WORLD), at_rest()
        return places

    def _compare(self, what: str, joint: int, rows: tuple[float, ...], on: int, exact: Placement) -> None:
        off = off_placement(rows, exact)
        if joint != on or not off <= exact.allowance:
            raise UnprovedError(
                f"{what} is not where the URDF has it: off by {off:.3g}, where rounding explains {exact.allowance:.3g}"
            )
        self.most = max(self.most, off)

    def _compare_joint(self, joint: Joint, found: UrdfJoint) -> None:
        on, placement = self._places[found.parent]
        self._compare(f"joint {joint.name!r}", joint.parent, joint.placement, on, placement.times(found.placement))
        if joint.kind not in _KINDS.get(found.kind, ()):
            raise UnprovedError(f"joint {joint.name!r} is of kind {joint.kind!r}, in the URDF {found.kind!r}")
        sign = self._sign(joint, found) if JOINTS[joint.kind].has_axis else 1.0
        if max(joint.columns) >= 0:
            self._compare_value(joint, found, sign)
        elif joint.kind == "turn" and math.copysign(1.0, joint.multipliers[0]) != sign:
            raise UnprovedError(
                f"joint {joint.name!r} stands still, and the sign of its multiplier is not that of its axis in the URDF"
            )

    def _sign(self, joint: Joint, found: UrdfJoint) -> float:
        """-1 for a joint that is given about the opposite axis, so that its value has the opposite sign."""
        for sign in (1.0, -1.0):
            off = furthest([sign * part for part in joint.axis], found.axis)
            if off <= ROUNDING:
                self.most = max(self.most, off)
                return sign
        given = [float(part) for part in found.axis]
        raise UnprovedError(f"joint {joint.name!r} has the axis {list(joint.axis)}, in the URDF {given}")

    def _compare_value(self, joint: Joint, found: UrdfJoint, sign: float) -> None:
        """Checks that a joint's value is its own column, or that of its leader, times a multiplier plus an offset."""
        expected = (Fraction(1),) * len(joint.multipliers)
        given, form, count = joint.multipliers, JOINTS[joint.kind], 1
        if form.has_axis and form.has_unit:
            expected = (Fraction(1), Fraction(sign))
        elif form.numbers == 1:
            factor, offset, count = (Fraction(1), Fraction(0), 1) if self._whole else self._followed(found)
            expected, given = (int(sign) * factor, int(sign) * offset), (joint.multipliers[0], joint.offsets[0])
        off = max(abs(Fraction(a) - b) for a, b in zip(given, expected, strict=True))
        if not off <= count * Fraction(ROUNDING) * max(Fraction(1), *map(abs, expected)):
            wanted = tuple(map(float, expected))
            raise UnprovedError(f"joint {joint.name!r} takes its value by {given}, by the URDF it is {wanted}")

    def _followed(self, found: UrdfJoint) -> tuple[Fraction, Fraction, int]:
        """Multiplier and offset by which a joint follows the joint of its column, and by how many steps.

        1 and 0 for its own column.
        """
        factor, offset, count = Fraction(1), Fraction(0), 1
        column = self._model.joints[self._joints[found.name]].columns[0]
        joints = {joint.name: joint for joint in self._tree.above.values()}
        for _ in joints:
            if found.mimic is None:
                break
            leader, multiplier, shift = found.mimic
            if leader not in joints or self._model.joints[self._joints[leader]].columns[0] != column:
                raise UnprovedError(f"joint {found.name!r} does not follow {leader}, as the URDF says")
            factor, offset, found = factor * multiplier, factor * shift + offset, joints[leader]
            count += 1
        return factor, offset, count
