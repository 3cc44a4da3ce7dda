"""The campaign of sets of parts, half-spaces and ellipsoids, whose truth is the oracle's, part by part.

In: a seed. Out: a `PairCampaign`, which judges motions before sets, too.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from plannercheck.evaluation.campaign.pairs import PairCampaign, PairCase, Truth
from plannercheck.evaluation.campaign.tallies import Column, Entry, Tally, table
from plannercheck.evaluation.stress_parts.bodies import Body, body_of
from plannercheck.evaluation.stress_parts.draws import FAMILY_NAMES, OFFSET_NAMES, Draw, numbered_draw
from plannercheck.evaluation.stress_parts.judges import ASK_ALL, questions
from plannercheck.evaluation.stress_parts.motions import MISSED, OUTCOMES, judge_motions
from plannercheck.evaluation.stress_parts.truth import decide

# Every so many draws of few pairs of parts, some of the oracle's verdicts are held against whole numbers alone, all
# pairs of parts.
THOROUGH_DRAWS, _THOROUGH_PAIRS, _THOROUGH_STEP = 16, 100, 7
# Every so many draws, motions are judged, too.
MOTION_DRAWS = 20
MOTIONS = "motions"


def campaign(seed: int) -> PairCampaign[Body]:
    """The campaign of a seed."""
    return PairCampaign(
        "parts",
        partial(numbered_draw, seed),
        _truth,
        questions,
        body_of,
        FAMILY_NAMES,
        OFFSET_NAMES,
        ask_all=ASK_ALL,
        besides=partial(_motions, seed),
        more_lines=_more_lines,
    )


def _truth(drawn: Draw, number: int) -> Truth:
    return Truth(truth_of(drawn, number), [""] * len(drawn.poses_p))


def truth_of(drawn: Draw, number: int) -> list[bool]:
    """The oracle's verdicts (k,); AssertionError where it contradicts itself."""
    found = decide(drawn.p, drawn.poses_p, drawn.r, drawn.poses_r)
    of_second = 1 if drawn.r.half_space is not None else len(drawn.r.pieces)
    few = 0 < len(drawn.p.pieces) * of_second <= _THOROUGH_PAIRS
    if number % THOROUGH_DRAWS == 0 and few:
        some = slice(number // THOROUGH_DRAWS % _THOROUGH_STEP, None, _THOROUGH_STEP)
        again = decide(drawn.p, drawn.poses_p[some], drawn.r, drawn.poses_r[some], every=True)
        if not np.array_equal(again, found[some]):
            raise AssertionError(f"the oracle contradicts itself: {drawn.label}")
    return list(found.tolist())


def _motions(seed: int, number: int, tally: Tally[PairCase[Body]]) -> None:
    """Those that were proved free and have a state that collides are faults."""
    if number % MOTION_DRAWS:
        return
    for (family, outcome), count in judge_motions(seed, number).items():
        entry = Entry(MOTIONS, outcome, family)
        tally.counts[entry] += count
        if outcome == MISSED and count:
            tally.faults[entry] += count


def _more_lines(tally: Tally[Any], peers: list[str]) -> list[str]:
    """Motions, by what they go past."""
    columns = [Column(outcome, tally.counts, partial(_is_motion, outcome)) for outcome in OUTCOMES]
    return ["", *table("motions before", lambda entry: entry.family, FAMILY_NAMES, columns)]


def _is_motion(outcome: str, entry: Entry) -> bool:
    return entry.who == MOTIONS and entry.outcome == outcome
