"""Results of measurements as Markdown: tables, numbers, and where they come from.

In: files of docs/results. Out: text for the tables of `result_tables.py`.
"""

from __future__ import annotations

import json
import re
import textwrap
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
RESULTS = ROOT / "docs" / "results"
WIDTH = 120
_BLANK = "\x01"  # stands for a blank that no line may end at

Record = dict[str, Any]


def record(name: str) -> Record:
    """A file of results."""
    found: Record = json.loads((RESULTS / f"{name}.json").read_text(encoding="utf-8"))
    return found


def table(columns: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table in Markdown."""
    lines = [columns, ["---"] * len(columns), *rows]
    return "".join(f"| {' | '.join(map(str, line))} |\n" for line in lines)


def paragraph(text: str, first: str = "", rest: str = "") -> str:
    """Text in lines of the usual length; code is never broken."""
    whole = re.sub(r"`[^`]+`", lambda code: code[0].replace(" ", _BLANK), text)
    lines = textwrap.wrap(
        whole, WIDTH, initial_indent=first, subsequent_indent=rest, break_long_words=False, break_on_hyphens=False
    )
    return "".join(f"{line}\n" for line in lines).replace(_BLANK, " ")


def items(texts: Iterable[str]) -> str:
    """A list."""
    return "".join(paragraph(text, "- ", "  ") for text in texts)


def source(found: Record) -> str:
    """The command, the date, the commit and the machine."""
    machine = found["machine"]
    if not isinstance(machine, str):
        load = machine["load"]
        busy = ", busy" if load and float(load) > 1.2 else ""
        machine = f"{machine['processor']} {machine['instruction set']}{busy}"
    return f"`{found['command']}` ({found['date']}, {found['commit']}, {machine})"


def provenance(found: Record) -> str:
    """`source` as a paragraph."""
    return paragraph(source(found))


def number(value: float | None) -> str:
    """Two digits that count, or all before the point."""
    if value is None:
        return "–"
    if value == 0 or abs(value) >= 100:
        return f"{value:,.0f}"
    text = f"{value:.2g}"
    return f"{float(text):g}" if "e" in text else text


def times(value: float, ours: float) -> str:
    """A time, and how many times ours it is."""
    return f"{number(value)} ({number(value / ours)} ×)"


def beside(value: float, ours: float) -> str:
    """A peer's time, and how many times ours it is; bold where the peer is faster."""
    return f"**{times(value, ours)}**" if value < ours else times(value, ours)
