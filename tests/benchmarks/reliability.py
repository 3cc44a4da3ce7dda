"""Long runs of what docs/explanation/reliability.md promises.

Run: `python tests/benchmarks/reliability.py [PART ...] --scale 100`.

Each part counts its trials and says what broke, and the table of all is a line of JSON each in --output. With --scale
100 they are those that a release needs: 100 kills and resumes over all formats; 1,000 damaged journals, cache files and
body files each; 10,000 mutated inputs of each loader within 2 GB and 10 s each; a million changed scenes and 100,000
plans at constant memory; eight threads for ten minutes; 500 pools of forked workers. Exit code: 0 if every promise
held, 1 if one did not.
"""

import argparse
import json
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

import numpy as np
from long_runs.counts import BrokenPromiseError, Counts

FULL_SCALE = 100.0
# How many trials each part makes at full scale; seconds for threads.
FULL = {
    **{"kills": 100, "damage": 1_000, "mutants": 10_000, "scenes": 1_000_000, "plans": 100_000, "threads": 600},
    "forks": 500,
}
LEAST = {"kills": 2, "damage": 10, "mutants": 20, "scenes": 200, "plans": 40, "threads": 5, "forks": 2}
_SHOWN_FAULTS = 5  # of one loader
_MEMORY_FOLDER = Path("/dev/shm")


def main() -> int:
    options = _parser().parse_args()
    failed = False
    for part in options.parts or FULL:
        count = getattr(options, part)
        if count is None:
            count = max(LEAST[part], round(FULL[part] * options.scale / FULL_SCALE))
        began = time.perf_counter()
        for row in _rows(part, count, options):
            row = {"part": part, **row, "seconds": round(time.perf_counter() - began, 1)}
            failed |= "broken" in row
            print("  ".join(f"{name}: {value}" for name, value in row.items()), flush=True)
            if options.output is not None:
                with options.output.open("a", encoding="utf-8") as table:
                    table.write(json.dumps(row) + "\n")
            began = time.perf_counter()
    return 1 if failed else 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("parts", nargs="*", metavar="PART", choices=[*FULL, []], help=f"of {', '.join(FULL)}; all")
    parser.add_argument("--scale", type=float, default=0.1, help="100: as many trials as a release needs")
    for part, count in FULL.items():
        unit = "s" if part == "threads" else "trials"
        parser.add_argument(f"--{part}", type=int, metavar="N", help=f"{unit}, whatever the scale; 100 means {count}")
    parser.add_argument("--loaders", default="", metavar="A,B", help="only these, of mutated inputs")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="mutated inputs that broke a promise are put there")
    parser.add_argument("--output", type=Path, metavar="FILE.jsonl", help="results are added to this file")
    return parser


def _rows(part: str, count: int, options: argparse.Namespace) -> Iterable[Counts]:
    """What a part found, a row at a time; a broken promise is a row, too."""
    if part == "mutants":
        return _mutants(count, options)
    return [_row(part, count, options)]


def _row(part: str, count: int, options: argparse.Namespace) -> Counts:
    from long_runs import concurrent, damage, kills, memory, pools

    rng = np.random.default_rng(options.seed)
    runs: dict[str, Callable[[Path], Counts]] = {
        "kills": lambda folder: kills.run(folder, count, rng, rows=min(1.0, max(0.1, count / 20))),
        "damage": lambda folder: damage.run(folder, count, options.seed),
        "scenes": lambda folder: memory.scenes(folder, count, rng),
        "plans": lambda folder: memory.plans(folder, count, rng),
        "threads": lambda folder: concurrent.run(folder, count, rng),
        "forks": lambda folder: pools.run(folder, count, rng),
    }
    # Kills are of a real disk; what is damaged trial by trial is in memory, where opening a file takes no time.
    with tempfile.TemporaryDirectory(dir=_fast_folder() if part == "damage" else None) as folder:
        try:
            return runs[part](Path(folder))
        except BrokenPromiseError as broken:
            return {"broken": str(broken)}


def _mutants(count: int, options: argparse.Namespace) -> Iterator[Counts]:
    """A row a loader."""
    os.environ["PLANNERCHECK_CACHE"] = "0"
    from long_runs import forked, loaders

    names = options.loaders.split(",") if options.loaders else loaders.NAMES
    with tempfile.TemporaryDirectory(dir=_fast_folder()) as folder:
        inputs = loaders.Inputs(Path(folder), options.seed)
        for name in names:
            tally = forked.run(inputs.trial(name), count, Path(folder))
            inputs.restore(name)
            row: Counts = {"loader": name, "inputs": tally.trials, **dict(sorted(tally.outcomes.items()))}
            row |= {"faults": len(tally.faults), "slowest s": round(tally.slowest, 2)}
            row["ms an input"] = round(1e3 * tally.seconds / max(1, count), 2)
            if tally.faults:
                shown = tally.faults[:_SHOWN_FAULTS]
                row["broken"] = "; ".join(f"input {number}: {what[-600:]}" for number, what in shown)
                _keep(options.keep, name, tally.faults, inputs)
            yield row


def _keep(folder: Path | None, name: str, faults: list[tuple[int, str]], inputs: object) -> None:
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
        for number, what in faults:
            (folder / f"{name}-{number}").write_bytes(inputs.content(name, number))  # type: ignore[attr-defined]
            (folder / f"{name}-{number}.txt").write_text(what, encoding="utf-8")


def _fast_folder() -> Path | None:
    return _MEMORY_FOLDER if os.access(_MEMORY_FOLDER, os.W_OK) else None


if __name__ == "__main__":
    sys.exit(main())
