"""The campaign of solids: pairs of concave bodies, whose truth is the oracle's of meshes.

In: a seed, peers. Out: a `PairCampaign`.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from plannercheck.evaluation.campaign.pairs import INSIDE, PairCampaign, Truth
from plannercheck.evaluation.campaign.posed_pairs import ANY_OFFSET
from plannercheck.evaluation.campaign.supervised_process import Peer
from plannercheck.evaluation.stress_solids.bodies import Body, body_of, decided
from plannercheck.evaluation.stress_solids.draws import FAMILY_NAMES, Draw, numbered_draw
from plannercheck.evaluation.stress_solids.judges import questions
from plannercheck.evaluation.stress_solids.placing import OFFSETS
from plannercheck.evaluation.stress_solids.robot_links import link_draw
from plannercheck.robots.description import shipped_robots

# Every so many draws of few pairs of triangles, some of the oracle's verdicts are held against whole numbers alone, all
# pairs of triangles and every vertex.
THOROUGH_DRAWS, _THOROUGH_PAIRS, _THOROUGH_STEP = 16, 2000, 7
# The reasons of the oracle that a part of one body is inside the other (cpp/oracle/mesh_pairs.hpp).
_INSIDE = (3, 4)


def campaign(seed: int, peers: tuple[Callable[[], Peer[Draw]], ...] = (), of_links: bool = False) -> PairCampaign[Body]:
    """The campaign of a seed: of bodies of families, or of links of the shipped robots; peers are counted, too."""
    return PairCampaign(
        "solids",
        partial(link_draw if of_links else numbered_draw, seed),
        _truth,
        questions,
        body_of,
        (*FAMILY_NAMES, *shipped_robots()),
        (*OFFSETS, ANY_OFFSET),
        peers,
    )


def _truth(drawn: Draw, number: int) -> Truth:
    reasons = reasons_of(drawn, number).tolist()
    return Truth([reason != 0 for reason in reasons], [INSIDE if reason in _INSIDE else "" for reason in reasons])


def reasons_of(drawn: Draw, number: int) -> Any:
    """The oracle's reasons (k,); AssertionError where it contradicts itself."""
    found = decided(drawn.p, drawn.poses_p, drawn.r, drawn.poses_r)
    few = len(drawn.p.surface.triangles) * len(drawn.r.surface.triangles) <= _THOROUGH_PAIRS
    if number % THOROUGH_DRAWS == 0 and few:
        some = slice(number // THOROUGH_DRAWS % _THOROUGH_STEP, None, _THOROUGH_STEP)
        again = decided(drawn.p, drawn.poses_p[some], drawn.r, drawn.poses_r[some], every=True)
        if ((again != 0) != (found[some] != 0)).any():
            raise AssertionError(f"the oracle contradicts itself: {drawn.label}")
    return found
