"""Failing cases in files, and how they are made smaller.

In and out: JSON with the name of the campaign; doubles are read back as the same bits.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

from plannercheck.common.checked_yaml import BROKEN_FILE
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.file_kinds import kind_of
from plannercheck.evaluation.campaign.campaign import Campaign

_T = TypeVar("_T")


def save(path: Path, campaign: str, document: Mapping[str, Any]) -> None:
    """Writes a case; its document may hold arrays."""
    path.write_text(
        json.dumps({"campaign": campaign, **document}, default=lambda array: array.tolist()), encoding="utf-8"
    )


def load(path: Path, campaigns: Mapping[str, Callable[[], Campaign[_T]]]) -> tuple[Campaign[_T], _T]:
    """Reads a case from a file: its campaign, made by its name, and the case."""
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
        campaign = campaigns[document["campaign"]]()
        return campaign, campaign.case_of(document)
    except (*BROKEN_FILE, AttributeError, PlannercheckError) as error:  # the second for lists in place of mappings
        told = f"{error!s:.200}" if isinstance(error, OSError | ValueError) else "`stress --cases` writes them"
        raise PlannercheckError(f"file {str(path)!r} is no case of a stress: {kind_of(path) or told}") from None


def shrink(parts: Sequence[_T], fails: Callable[[list[_T]], bool]) -> list[_T]:
    """As few parts as still fail: runs of them are dropped, all of them at first, then half as many."""
    kept, size = list(parts), len(parts)
    while size:
        before, first = len(kept), 0
        while first < len(kept):
            fewer = kept[:first] + kept[first + size :]
            if fewer and fails(fewer):
                kept = fewer
            else:
                first += size
        if len(kept) == before:
            size //= 2
    return kept
