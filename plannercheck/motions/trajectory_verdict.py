"""The verdict of a trajectory: up to when it is free, which pair stops it, its clearance and its largest tube.

In: the results of the checks. Out: `TrajectoryVerdict`, plain data, with a proof that is computed when it is asked for.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

from plannercheck.checking.verdicts import PairVerdict
from plannercheck.common.array_types import Floats
from plannercheck.common.html_tables import html_table
from plannercheck.common.public_names import set_module
from plannercheck.common.shown_times import shown_seconds
from plannercheck.proofs.proof import Proof
from plannercheck.trajectories.limits import Excess


@dataclass(frozen=True)
class Stop:
    """Where a trajectory stops to be proved free.

    Attributes:
        free_until: It is proved free from its start to here, s, with its tube.
        collides_at: The first instant that is found to collide on the curve itself, s; None if none is.
        near_at: The instant at which it was refused, s, since a pair is so near that the tube may touch; None if it is
            free.
        pair: The pair that stops it, with its certificate at `collides_at`, or, if nothing collides, at `near_at`.
    """

    free_until: float
    collides_at: float | None = None
    near_at: float | None = None
    pair: PairVerdict | None = None


@set_module("plannercheck")
@dataclass(frozen=True, repr=False)
class TrajectoryVerdict:
    """The verdict of one trajectory.

    Attributes:
        free: Whether every configuration within the tube is proved free, at every instant.
        stop: Where that ends; its fields are read as `free_until`, `collides_at`, `near_at` and `pair`.
        tube: (nq,) by how much each number may be off the curve, rad and m.
        tolerance: A trajectory that stays further than this from collisions, with its tube, is free, m.
        limits: Position limits of joints that it breaks.
        largest_tube: The largest common tube that is proved, rad and m, to within a hundredth; 0 if none is.
        clearance: Bodies are proved to keep further than this apart on the curve, paddings taken off, m; without
            pairs infinity.
        clearance_at: The instant, of some hundred, at which the clearance is least, s.
        prover: Computes `proof`; None if there is none.
        clock: Whose clock instants are on, in words; "" for the trajectory's own.
    """

    free: bool
    stop: Stop
    tube: Floats
    tolerance: float
    limits: tuple[Excess, ...]
    largest_tube: float
    clearance: float
    clearance_at: float
    prover: Callable[[], tuple[Proof, ...] | None] | None = field(default=None, compare=False)
    clock: str = ""

    @property
    def free_until(self) -> float:
        """It is proved free from its start to here, s."""
        return self.stop.free_until

    @property
    def collides_at(self) -> float | None:
        """The first instant that is found to collide, s; None if none is."""
        return self.stop.collides_at

    @property
    def near_at(self) -> float | None:
        """The instant at which it was refused, s; None if it is free."""
        return self.stop.near_at

    @property
    def pair(self) -> PairVerdict | None:
        """The pair that stops it, with its certificate."""
        return self.stop.pair

    @cached_property
    def proof(self) -> tuple[Proof, ...] | None:
        """The proofs of its pieces, in order, that anyone can check (`Proof.verify`); None unless it is free."""
        return self.prover() if self.free and self.prover is not None else None

    def __bool__(self) -> bool:
        return self.free

    def __repr__(self) -> str:
        return f"TrajectoryVerdict({'; '.join(self._sentences())})"

    def _sentences(self) -> list[str]:
        until = f"free until {shown_seconds(self.free_until)} s"
        if self.free:
            least = shown_seconds(self.clearance_at)
            out = [f"free, with {self.clearance:.3g} m of room, least at {least} s{self.clock}"]
        elif self.collides_at is not None:
            out = [f"{until}, collides at {shown_seconds(self.collides_at)} s{self.clock}"]
        else:
            near = "" if self.near_at is None else f", too near at {shown_seconds(self.near_at)} s"
            out = [f"{until}{near}{self.clock}"]
        if self.pair is not None:
            out[0] += f": {' – '.join(self.pair.names)}"
        if self.tube.any():
            out.append(f"tube {self.tube.max():.3g}")
        out.append(f"largest tube {self.largest_tube:.3g}")
        return out + [str(excess) for excess in self.limits]

    def _repr_html_(self) -> str:
        rows = [(e.joint, e.kind, shown_seconds(e.time), f"{e.value:.6g}", f"{e.limit:.6g}") for e in self.limits]
        return html_table(repr(self), ("joint", "limit of", "s", "value", "limit"), rows)
