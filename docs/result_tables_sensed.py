"""Tables of figures on clouds and maps, in Markdown, from docs/results.

In: files of results. Out: text for `render_results.py`, under each table the command, the date, the commit and the
machine that its figures come from.
"""

from __future__ import annotations

import re

from result_markdown import beside, number, paragraph, provenance, record, table
from result_tables import MOTION_TREE, ONE_BY_ONE, OURS, TREE, VAMP


def sensed_scenes() -> str:
    """µs a random state, and a motion that RRTConnect asks for, before clouds and maps; a row a scene."""
    files = [record(name) for name in ("clouds_states", "maps_states", "clouds_motions", "maps_motions")]
    states = {(row["scene"], row["method"]): row["microseconds"] for found in files[:2] for row in found["rows"]}
    motions = {(row["where"], row["method"]): row["microseconds"] for found in files[2:] for row in found["rows"]}
    lines = [
        (scene, *_cells(states, scene, TREE), *_cells(motions, scene, MOTION_TREE))
        for scene in dict.fromkeys(scene for scene, _ in states)
        if not re.search(r"\b100?,000 points", scene)
    ]
    header = ("scene", "state: batch", "a call each", "coal", "VAMP", "motion: batch", "a call each", "coal", "VAMP")
    return table(header, lines) + "".join("\n" + provenance(found) for found in files[:2])


def _cells(spent: dict[tuple[str, str], float], scene: str, coal: str) -> list[str]:
    """Ours in a batch and a call each, coal's beside the first, VAMP's beside the second."""
    ours, single = spent[scene, OURS], spent[scene, ONE_BY_ONE]
    peers = ((spent.get((scene, coal)), ours), (spent.get((scene, VAMP)), single))
    return [number(ours), number(single), *("–" if value is None else beside(value, mine) for value, mine in peers)]


def sensed_camera() -> str:
    """What all steps after a frame of a moving camera take."""
    found = record("camera")
    whole = found["rows"][-1]
    said = (
        f"{whole['frames']:,} frames of {whole['points']:,.0f} points and {whole['states']:,} states each: "
        f"{number(whole['median'])} ms in the median, {number(whole['late'])} at 95 %, {number(whole['most'])} at most."
    )
    return f"{paragraph(said)}\n{provenance(found)}"


def sensed_proofs() -> str:
    """What proofs of a path before sets of parts take."""
    found = record("sensed_proofs")
    fields = ("build", "verify", "entries", "json", "npz")
    lines = [
        (row["scene"], f"{row['parts']:,}", row["motions"], *(number(row[field]) for field in fields))
        for row in found["rows"]
        if row["parts"] != 10_000
    ]
    header = ("scene", "parts", "motions", "s to build", "s to verify", "entries", "MB, JSON", "MB, npz")
    return table(header, lines) + "\n" + provenance(found)
