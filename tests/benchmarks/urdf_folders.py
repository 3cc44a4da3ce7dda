"""Loads every URDF below folders and says what became of each: `python tests/benchmarks/urdf_folders.py FOLDER …`.

Each file is loaded as a stranger would, without an SRDF, in a process of its own with a time limit; self pairs are all
pairs of links that no joint connects. Then random configurations are judged. Out: a line for each file that is refused
or has no valid configuration, with the reason; a table of how many loaded; the exit code 1 if any file crashed, ran out
of time, or raised anything but a `PlannercheckError`.
"""

import argparse
import json
import multiprocessing
import sys
import time
import warnings
from collections import Counter
from collections.abc import Iterator
from multiprocessing.connection import Connection
from pathlib import Path
from typing import NamedTuple

import numpy as np

LOADED, NEVER_VALID, REFUSED = "loaded", "0 % valid", "refused"
FAULTS = ("traceback", "crashed", "out of time")


class Outcome(NamedTuple):
    """What became of a file: how it ended, the reason if it was not loaded, the part of random states that is valid."""

    ended: str
    reason: str = ""
    valid: float = 0.0
    seconds: float = 0.0
    hints: tuple[str, ...] = ()


def judged(urdf: Path, packages: list[Path], states: int) -> Outcome:
    """Loads a URDF and judges random configurations."""
    import plannercheck as pc
    from plannercheck.checking.input_hints import always_hint

    began = time.perf_counter()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            robot = pc.Robot.from_urdf(urdf, package_dirs=packages)
            checker = pc.Checker(robot)
            q = robot.random_configurations(states, np.random.default_rng(0))
            valid = float(checker.check_states(q).mean())
        except pc.PlannercheckError as error:
            return Outcome(REFUSED, str(error))
        except Exception as error:
            return Outcome("traceback", repr(error))
    reason = (always_hint(checker, q) or "no pair collides always") if valid == 0.0 else ""
    hints = tuple(str(warning.message) for warning in caught)
    return Outcome(NEVER_VALID if valid == 0.0 else LOADED, reason, valid, time.perf_counter() - began, hints)


def _send(pipe: Connection, urdf: Path, packages: list[Path], states: int) -> None:
    pipe.send(judged(urdf, packages, states))


def apart(urdf: Path, packages: list[Path], states: int, limit: float) -> Outcome:
    """`judged` in a process of its own."""
    context = multiprocessing.get_context("fork")
    ours, theirs = context.Pipe(duplex=False)
    process = context.Process(target=_send, args=(theirs, urdf, packages, states))
    process.start()
    theirs.close()
    try:
        return ours.recv() if ours.poll(limit) else Outcome("out of time", f"more than {limit:g} s")
    except EOFError:
        process.join()
        return Outcome("crashed", f"exit code {process.exitcode}")
    finally:
        process.kill()
        process.join()


def found(folders: list[Path]) -> Iterator[tuple[Path, Path]]:
    """Each folder with the URDFs below it, in order."""
    for folder in folders:
        for urdf in sorted(folder.rglob("*.urdf")):
            yield folder, urdf


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--package-dirs", nargs="*", type=Path, default=[], help="where package:// paths start")
    parser.add_argument("--states", type=int, default=200, help="random configurations of each robot")
    parser.add_argument("--limit", type=float, default=60.0, help="s for a file")
    parser.add_argument("--every", type=int, default=1, help="only every so many files of a folder")
    parser.add_argument("--output", type=Path, help="a line of JSON for each file")
    options = parser.parse_args()
    counts: dict[Path, Counter[str]] = {folder: Counter() for folder in options.folders}
    import plannercheck as pc  # once, before the forks

    del pc
    lines = []
    for k, (folder, urdf) in enumerate(found(options.folders)):
        if k % options.every:
            continue
        outcome = apart(urdf, options.package_dirs, options.states, options.limit)
        counts[folder][outcome.ended] += 1
        lines.append(json.dumps({"file": str(urdf), **outcome._asdict()}))
        if outcome.ended != LOADED:
            print(f"{outcome.ended}: {urdf.relative_to(folder)}: {outcome.reason[:600]}", flush=True)
    columns = (LOADED, NEVER_VALID, REFUSED, *FAULTS)
    print(f"{'':40s}" + "".join(f"{name:>12s}" for name in columns))
    for folder, count in counts.items():
        print(f"{str(folder)[-40:]:40s}" + "".join(f"{count[name]:12d}" for name in columns))
    if options.output is not None:
        options.output.write_text("".join(line + "\n" for line in lines), encoding="utf-8")
    return int(any(count[name] for count in counts.values() for name in FAULTS))


if __name__ == "__main__":
    sys.exit(main())
