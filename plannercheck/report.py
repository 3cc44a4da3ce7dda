"""What a checker says: the verdict of one configuration, and the summary of a set of them."""

from __future__ import annotations

from dataclasses import dataclass

from plannercheck.certificates import Certificate


@dataclass(frozen=True)
class PairVerdict:
    """The verdict of one pair of bodies.

    Attributes:
        first: Name of the robot's link.
        second: Name of the other link or of the obstacle.
        first_body: Name of the first collision body.
        second_body: Name of the second collision body.
        colliding: Whether the bodies share a point.
        certificate: The proof in world coordinates: a `Separation` (normal from second to first) or a `SharedPoint`.
    """

    first: str
    second: str
    first_body: str
    second_body: str
    colliding: bool
    certificate: Certificate


@dataclass(frozen=True)
class Verdict:
    """The verdict of one configuration.

    Attributes:
        valid: Whether no pair collides.
        collisions: All colliding pairs, in the order of the checker's pair table.
        separations: All other pairs with their separating planes, if asked for; else empty.
    """

    valid: bool
    collisions: tuple[PairVerdict, ...]
    separations: tuple[PairVerdict, ...] = ()
