"""The tree of a robot's links and joints, as data."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class LinkTree:
    """How links hang together.

    Attributes:
        names: The URDF's links in the order of Pinocchio's body frames.
        frames: Pinocchio's frame of each link.
        parents: For each link that has one, its parent link.
        joints: For each link that has one, the URDF joint to its parent, fixed ones included.
    """

    names: tuple[str, ...]
    frames: tuple[int, ...]
    parents: dict[str, str]
    joints: dict[str, str]
