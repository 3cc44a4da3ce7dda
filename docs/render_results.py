"""Fills the tables of the documentation from docs/results: `python docs/render_results.py`.

In: `docs/results/*.json`, written by `plannercheck bench ... --output` and by `tests/benchmarks/*.py --output`. Out:
README.md and the pages of docs/, in which the lines between `<!-- table: NAME -->` and `<!-- end of table -->` are
rendered again; a test holds that no page is stale. `result_tables*.py` say what each table shows. No page shows the
records in `docs/results/history`.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import result_tables as peers
import result_tables_inside as inside
import result_tables_planning as planning
import result_tables_sensed as sensed
import result_tables_solids as solids
from result_markdown import ROOT

_MARKED = re.compile(r"(<!-- table: (?P<name>\w+) -->\n).*?(<!-- end of table -->)", re.DOTALL)

# What a name between marks stands for.
TABLES: dict[str, Callable[[], str]] = {
    make.__name__: make
    for make in (
        *(peers.summary, peers.states, peers.pairs),
        *(planning.motions, planning.plans, planning.plan_sampling, planning.waiting, planning.changing_scenes),
        planning.rounded_plans,
        *(inside.clearance_of_motions, inside.hierarchies, inside.stages),
        *(inside.planar, inside.clearance, inside.scale, inside.ndim_rounds, inside.ndim_speed),
        *(inside.motions_missed, inside.kinematic_rounding, inside.disabled_pairs),
        *(inside.long_runs, inside.hard_pairs, inside.hard_solids),
        *(sensed.sensed_scenes, sensed.sensed_camera),
        *(sensed.sensed_proofs, solids.solid_states),
        *(solids.solid_fidelity, solids.pieces),
    )
}


def main() -> None:
    """Writes all pages that have tables."""
    for page in pages():
        text = page.read_text(encoding="utf-8")
        page.write_text(rendered(text), encoding="utf-8")


def pages() -> list[Path]:
    """README.md and the pages of the documentation."""
    return [ROOT / "README.md", *sorted((ROOT / "docs").glob("*/*.md"))]


def rendered(text: str) -> str:
    """A page with its tables rendered again."""
    return _MARKED.sub(lambda found: f"{found[1]}\n{content(found['name'])}\n{found[3]}", text)


def content(name: str) -> str:
    """What stands between the marks of one name, ending in a line break."""
    return TABLES[name]()


if __name__ == "__main__":
    main()
