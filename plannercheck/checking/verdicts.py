"""The results of a checker: the verdict of one configuration, and the summary of a set."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.arrays import OwnsArrays
from plannercheck.common.counters import sum_fields
from plannercheck.common.html_tables import html_table
from plannercheck.common.public_names import set_module

if TYPE_CHECKING:
    from plannercheck.proofs.proof import Proof


# A verdict's line names so many colliding pairs.
_NAMED = 3


class PairCertificate(Protocol):
    """The proof of a pair's verdict: a `Separation`, a `SharedPoint` (in space or in the plane) or an `Enclosure`."""

    def verify(self) -> bool:
        """Whether exact arithmetic with all vertices confirms the proof."""


@dataclass(frozen=True, repr=False)
class PairVerdict:
    """The verdict of one pair of bodies.

    Attributes:
        first: Name of the robot's link.
        second: Name of the other link or of the obstacle.
        first_body: Name of the first collision body; of a cloud or map that collides, with the part: "camera[17]".
        second_body: Name of the second collision body.
        colliding: Whether the bodies share a point.
        certificate: The proof in world coordinates: a `Separation` (normal from second to first), a `SharedPoint`, or
            an `Enclosure` where a body is inside a solid.
    """

    first: str
    second: str
    first_body: str
    second_body: str
    colliding: bool
    certificate: PairCertificate

    @property
    def names(self) -> tuple[str, str]:
        """`first` and `second`; of a cloud or map that collides with the part that does: "camera[17]"."""
        return _with_part(self.first, self.first_body), _with_part(self.second, self.second_body)

    def __repr__(self) -> str:
        return f"PairVerdict({_named(self)}, {_words(self)})"


@set_module("plannercheck")
@dataclass(frozen=True, repr=False)
class Verdict:
    """The verdict of one configuration.

    Attributes:
        valid: Whether no pair collides.
        collisions: All colliding pairs, in the order of the checker's pair table.
        separations: All other pairs with their separating planes, if asked for; else empty.
        kinematic_error: No point of a body is further than this from where exact kinematics of the same numbers puts
            it, in m. Infinite if Pinocchio itself posed the robot: then nothing is proved.
    """

    valid: bool
    collisions: tuple[PairVerdict, ...]
    separations: tuple[PairVerdict, ...]
    kinematic_error: float

    def __repr__(self) -> str:
        found = "valid" if self.valid else f"{_counted(len(self.collisions), 'colliding pair')}: {_first_names(self)}"
        planes = f"; {_counted(len(self.separations), 'separation')}" if self.separations else ""
        return f"Verdict({found}{planes})"

    def _repr_html_(self) -> str:
        rows = [
            (pair.first, pair.second, pair.first_body, pair.second_body, _words(pair), type(pair.certificate).__name__)
            for pair in (*self.collisions, *self.separations)
        ]
        return html_table(repr(self), ("link", "with", "body", "with body", "verdict", "certificate"), rows)


@dataclass(frozen=True, eq=False)
class MotionProof(OwnsArrays):
    """The proof that two bodies are apart on an interval of a motion.

    Seen from the frame, the points of both bodies leave the chords of their paths by at most `chord_deviation`
    together. So a plane that keeps the bodies further apart than this at both ends separates them on the whole
    interval.

    Attributes:
        first: Name of the robot's link.
        second: Name of the other link or of the obstacle.
        first_body: Index of the first body into the checker's bodies.
        second_body: Index of the second.
        start: Parameter of the motion, 0 to 1.
        end: Parameter of the motion, 0 to 1.
        frame: Name of the link in whose frame the normal is fixed; None for the world.
        normal: (3,) unit vector in the frame, (2,) in the plane, from second to first.
        gap: Along it the bodies are at least this far apart at both ends, m.
        chord_deviation: How far their points leave their chords at most, both bodies together, m; less than the gap.
    """

    first: str
    second: str
    first_body: int
    second_body: int
    start: float
    end: float
    frame: str | None
    normal: NDArray[np.float64]
    gap: float
    chord_deviation: float


def _named(pair: PairVerdict) -> str:
    return " – ".join(pair.names)


def _with_part(name: str, body: str) -> str:
    """The body's name if that has a part in brackets, which a set of parts is given where one is met."""
    return body if body.endswith("]") and body.startswith((f"{name}[", f"{name}/")) else name


def _words(pair: PairVerdict) -> str:
    return "colliding" if pair.colliding else "apart"


def _counted(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"


def _first_names(verdict: Verdict) -> str:
    """The first colliding pairs by name."""
    names = [_named(pair) for pair in verdict.collisions[:_NAMED]]
    return ", ".join([*names, *["…"] * (len(verdict.collisions) > _NAMED)])


@dataclass(frozen=True, repr=False)
class MotionVerdict:
    """The verdict of one motion; parameters go from 0 at its start to 1 at its end.

    Attributes:
        free: Whether the motion is proved free.
        tolerance: A motion that stays further than this from collisions is free, m.
        free_until: The last parameter known free: everything before it is proved free.
        collides_at: The first parameter known to collide; None if none was found.
        near_at: The parameter at which the motion was refused, since the pair is within the tolerance; None if it is
            free.
        pair: The pair that stops the motion, with its certificate at `collides_at`, or, if nothing collides, at
            `near_at`; None if the motion is free.
        proofs: If asked for, the proofs of the part up to `free_until`.
        prover: Computes `proof`; None if there is none.
    """

    free: bool
    tolerance: float
    free_until: float
    collides_at: float | None
    near_at: float | None
    pair: PairVerdict | None
    proofs: tuple[MotionProof, ...] = ()
    prover: Callable[[], Proof | None] | None = field(default=None, repr=False, compare=False)

    def __repr__(self) -> str:
        if self.free:
            found = f"free, all pairs further than {self.tolerance:g} m apart"
        elif self.collides_at is not None:
            found = f"free until {self.free_until:.6g}, collides at {self.collides_at:.6g}"
        else:
            found = f"free until {self.free_until:.6g}, within {self.tolerance:g} m at {self.near_at:.6g}"
        pair = f": {_named(self.pair)}" if self.pair is not None else ""
        proofs = f"; {_counted(len(self.proofs), 'proof')}" if self.proofs else ""
        return f"MotionVerdict({found}{pair}{proofs})"

    def _repr_html_(self) -> str:
        rows = [
            (
                each.first,
                each.second,
                f"{each.start:.6g} to {each.end:.6g}",
                each.frame or "the world",
                f"{each.gap:.4g}",
            )
            for each in self.proofs
        ]
        return html_table(repr(self), ("link", "with", "parameters", "plane in the frame of", "gap, m"), rows)

    @cached_property
    def proof(self) -> Proof | None:
        """The proof of the motion that anyone can check (`Proof.verify`), computed when first asked for.

        None unless the motion is free.

        Raises:
            PlannercheckError: If python-flint is not installed, or no proof is found for a solid or a set of parts.
        """
        return self.prover() if self.free and self.prover is not None else None


@dataclass(frozen=True)
class PairCount:
    """How often a pair collides.

    Attributes:
        first: Name of the robot's link.
        second: Name of the other link or of the obstacle.
        states: How many configurations count for this pair.
    """

    first: str
    second: str
    states: int


@set_module("plannercheck")
@dataclass(frozen=True)
class ValidityReport:
    """The summary of a set of configurations.

    Attributes:
        states: How many configurations were checked.
        valid: How many configurations have no colliding pair, within the limits or beyond.
        beyond_limits: How many configurations are beyond a joint limit, valid or not.
        pairs: Colliding links and obstacles, most frequent first.
        all_pairs: Whether a configuration counts for all its colliding pairs; else for the first found.
        duration: Time spent on checking, s.
    """

    states: int
    valid: int
    beyond_limits: int
    pairs: tuple[PairCount, ...]
    all_pairs: bool = False
    duration: float = 0.0

    def _repr_html_(self) -> str:
        beyond = f", {self.beyond_limits} beyond the limits" if self.beyond_limits else ""
        title = f"{_counted(self.states, 'configuration')}: {self.valid} valid, {self.invalid} colliding{beyond}"
        rows = [(pair.first, pair.second, pair.states) for pair in self.pairs]
        counted = "all colliding pairs" if self.all_pairs else "the first pair found"
        return html_table(title, ("link", "with", f"configurations ({counted})"), rows)

    @property
    def invalid(self) -> int:
        """How many configurations have a colliding pair."""
        return self.states - self.valid

    @property
    def rate(self) -> float:
        """Configurations checked per second."""
        return self.states / self.duration if self.duration > 0 else float("nan")

    @property
    def passed(self) -> bool:
        """Whether every configuration is valid and within the limits."""
        return self.invalid == 0 and self.beyond_limits == 0


def merged(reports: Iterable[ValidityReport]) -> ValidityReport:
    """The sum of reports of several sets, all with the same `all_pairs`; all zero if there are no reports."""
    reports = list(reports)
    counts: Counter[tuple[str, str]] = Counter()
    for report in reports:
        counts.update({(pair.first, pair.second): pair.states for pair in report.pairs})
    return ValidityReport(
        **sum_fields(reports, "states", "valid", "beyond_limits", "duration"),
        pairs=pair_counts(counts),
        all_pairs=any(report.all_pairs for report in reports),
    )


def pair_counts(counts: Counter[tuple[str, str]]) -> tuple[PairCount, ...]:
    """Counts by names, most frequent first, then by name."""
    ordered = sorted(counts.items(), key=lambda item: (-item[1], item[0]))
    return tuple(PairCount(first, second, n) for (first, second), n in ordered if n)
