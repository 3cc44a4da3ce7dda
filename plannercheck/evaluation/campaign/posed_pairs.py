"""Pairs of bodies at poses, and what they are asked in all campaigns.

In: two bodies at poses. Out: outcomes (k,): a verdict, or how it failed. `limited` asks with patience that ends.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar

from plannercheck.bodies.intersection import intersects
from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.tuning import METHODS, pair_options
from plannercheck.common.array_types import Floats
from plannercheck.common.core import core
from plannercheck.evaluation.campaign.tallies import EXCEPTION, TIMEOUT

Outcome = bool | str  # a verdict, or the kind of failure

UNFIT = "unfit"
# Longest time for one draw's questions, s: large meshes included, hundreds of times what any takes.
LIMIT = 60.0
# The row of all poses that are not about a contact.
ANY_OFFSET = "any"
# Of a draw: single pairs that are asked one by one.
_SINGLES = 3


class HasPolytope(Protocol):
    """A body of a stress."""

    @property
    def polytope(self) -> Polytope:
        """The core's body."""


AnyBody = TypeVar("AnyBody", bound=HasPolytope)


@dataclass(frozen=True, eq=False)
class PosedPairs(Generic[AnyBody]):
    """Two bodies at poses.

    Attributes:
        family: The row of the table.
        label: Everything that was drawn.
        p: The first body; where sets are drawn, the set, or any body on a half-space.
        r: The second body.
        poses_p: (k, 4, 4), m.
        poses_r: (k, 4, 4), m.
        offsets: A name for each pose: how far it is from a contact, or ANY_OFFSET.
    """

    family: str
    label: str
    p: AnyBody
    r: AnyBody
    poses_p: Floats
    poses_r: Floats
    offsets: tuple[str, ...]


def method_of(number: int) -> Any:
    """The method by which the `number`-th draw is asked."""
    return METHODS[number % len(METHODS)]


def some_of(count: int, number: int) -> list[int]:
    """Which pairs of the `number`-th draw are asked one by one."""
    return [(number + i * (count // _SINGLES)) % count for i in range(_SINGLES)]


def batch(p: HasPolytope, poses_p: Floats, r: HasPolytope, poses_r: Floats, method: Any) -> list[Outcome]:
    """Verdicts of two bodies at all poses in one call."""
    shared, _, _ = core.intersect_batch(p.polytope.core, poses_p, r.polytope.core, poses_r, pair_options(method))
    return list(shared.astype(bool).tolist())


def one_by_one(drawn: PosedPairs[Any], some: list[int]) -> list[Outcome]:
    """Verdicts of some poses, a call each; UNFIT for the others."""
    outcomes: list[Outcome] = [UNFIT] * len(drawn.poses_p)
    for k in some:
        outcomes[k] = bool(intersects(drawn.p.polytope, drawn.r.polytope, drawn.poses_p[k], drawn.poses_r[k]))
    return outcomes


def limited(ask: Callable[[], list[Outcome]], count: int, limit: float = LIMIT) -> list[Outcome]:
    """Outcomes (count,) of a question, from a thread that is left behind when it takes too long."""
    answer: list[Outcome] = [TIMEOUT] * count

    def work() -> None:
        try:
            answer[:] = ask()
        except Exception:
            answer[:] = [EXCEPTION] * count

    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    thread.join(limit)
    return list(answer)
