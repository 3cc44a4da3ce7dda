"""Puts small faults into the package and its core, one at a time, and says which of them no test notices.

    python tests/mutants/mutation.py                        # all of tests/mutants/*.yaml; by hand, and before a release
    python tests/mutants/mutation.py --area reach --jobs 2  # one list
    python tests/mutants/mutation.py --only NAME --results build/mutation.jsonl

In: the lists that `mutants.py` reads. Out: one line a mutant (killed, SURVIVED, equivalent and why, stale if its old
text is not found), a table, and the exit code 1 if any survived, is stale, does not compile, or has a test that fails
without it.

The idea. Each worker has a copy of the checkout in a folder for temporary files, kept for the next run with its build,
so that a C++ mutant compiles only what it changes; Python mutants build nothing. The checkout itself is never written
to. Bodies are not cached, since a mutant would leave wrong ones behind. A test that does not end within the time limit
has noticed its mutant, one that crashes too.
"""

import argparse
import hashlib
import json
import queue
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

from mutants import CHECKOUT, LISTS, BadMutantError, Mutant, fault_of, faults_of, read_mutants
from mutated_checkout import CheckoutCopy, Ran

TIME_LIMIT = 300.0  # s for the tests of one mutant; the longest needs a minute
FINE = {"killed", "killed (time-out)", "killed (crash)", "killed (not collected)", "equivalent"}
NOT_FINE = ("SURVIVED", "stale", "does not compile", "fails without it")


class Outcome(NamedTuple):
    """What became of a mutant: the verdict in words of FINE or NOT_FINE, more about it, and how long it took, s."""

    verdict: str
    detail: str = ""
    seconds: float = 0.0


def try_out(copy: CheckoutCopy, mutant: Mutant, limit: float) -> Outcome:
    """What a mutant's tests say of it."""
    start = time.monotonic()
    with copy.with_mutant(mutant) as said:
        if said:
            errors = [line for line in said.splitlines() if "error" in line]
            verdict, detail = "does not compile", (errors or ["no error named"])[0]
        else:
            verdict, detail = judged(copy.test(mutant.tests, limit, "-x"))
    return Outcome(verdict, detail, time.monotonic() - start)


def failed(ran: Ran) -> list[str]:
    """The tests that a run says failed."""
    lines = [line for line in ran.text.splitlines() if line.startswith(("FAILED ", "ERROR "))]
    return [line.split(" ", 1)[1].split(" - ")[0] for line in lines]


def judged(ran: Ran) -> tuple[str, str]:
    """What a run of a mutant's tests says of it, and by which test."""
    by = (failed(ran) or [""])[0]
    if ran.code is None:
        return "killed (time-out)", ""
    if ran.code == 0:
        return "SURVIVED", ""
    if ran.code == 1:
        return "killed", by
    return ("killed (crash)", "") if ran.code < 0 or ran.code > 5 else ("killed (not collected)", by)


class Results:
    """Outcomes kept in a file of JSON lines, so that a run can be taken up again."""

    def __init__(self, path: Path | None) -> None:
        """Reads what is there; an unfinished last line is left out."""
        self._path, self._lock = path, threading.Lock()
        self._known: dict[str, Outcome] = {}
        for line in path.read_text().splitlines() if path and path.exists() else []:
            try:
                record = json.loads(line)
                self._known[record["key"]] = Outcome(record["verdict"], record["detail"], record["seconds"])
            except (ValueError, KeyError):
                continue

    def get(self, key: str) -> Outcome | None:
        """What is known for a key, see `Mutant.key`."""
        return self._known.get(key)

    def add(self, name: str, key: str, outcome: Outcome) -> None:
        """Keeps an outcome."""
        with self._lock:
            self._known[key] = outcome
            if self._path:
                with self._path.open("a") as file:
                    print(json.dumps({"name": name, "key": key} | outcome._asdict()), file=file, flush=True)


def failing_without_mutants(copy: CheckoutCopy, mutants: Sequence[Mutant], results: Results, limit: float) -> set[str]:
    """Tests, among those that mutants name, that fail as things are; each is run once."""
    tests = sorted({test for mutant in mutants for test in mutant.tests})
    if not tests:
        return set()
    copy.build_original()
    sources = sorted(path for path in copy.root.rglob("*") if path.suffix in {".py", ".cpp", ".hpp", ".yaml"})
    parts = [*(test.encode() for test in tests), *(path.read_bytes() for path in sources)]
    key = hashlib.sha256(b"\0".join(parts)).hexdigest()[:16]
    if (known := results.get(key)) is None:
        ran = copy.test(tests, limit * len(tests))
        if ran.code not in (0, 1) or (ran.code == 1 and not failed(ran)):
            raise SystemExit(f"The tests do not run without any mutant:\n{ran.text[-3000:]}")
        known = Outcome("without mutants", json.dumps(failed(ran)))
        results.add("", key, known)
    return set(json.loads(known.detail))


def fails_without(mutant: Mutant, failing: Iterable[str]) -> str:
    """The first of a mutant's tests that fails without it; empty if none does."""
    for test in mutant.tests:
        if any(found == test or found.startswith((f"{test}[", f"{test}::")) for found in failing):
            return test
    return ""


def first_level() -> str:
    """The best SIMD level of this processor."""
    info = Path("/proc/cpuinfo")
    flags = info.read_text() if info.exists() else ""
    return "v4" if "avx512vl" in flags else "v3" if "avx2" in flags else "plain"


def folder_of_copies() -> Path:
    """Where the copies of this checkout are kept."""
    name = hashlib.sha256(str(CHECKOUT).encode()).hexdigest()[:8]
    return Path(tempfile.gettempdir()) / f"plannercheck-mutation-{name}"


def chosen_mutants(arguments: argparse.Namespace) -> list[Mutant]:
    """Those asked for."""
    mutants = read_mutants(arguments.lists)
    unknown = set(arguments.only) - {mutant.name for mutant in mutants}
    unknown |= set(arguments.area) - {mutant.area for mutant in mutants}
    if unknown:
        raise SystemExit(f"No such mutant or list: {', '.join(sorted(unknown))}")
    return [
        mutant
        for mutant in mutants
        if (not arguments.only or mutant.name in arguments.only)
        and (not arguments.area or mutant.area in arguments.area)
    ]


def report(mutant: Mutant, outcome: Outcome, done: int, of: int) -> None:
    """One line."""
    detail = f": {outcome.detail}" if outcome.detail else ""
    line = f"[{done}/{of}] {outcome.verdict} {mutant.area}/{mutant.name} ({outcome.seconds:.1f} s){detail}"
    print(line, flush=True)


def print_table(outcomes: dict[str, tuple[Mutant, Outcome]]) -> None:
    """How many of each list met which end, then what is not fine."""
    verdicts = [v for v in (*sorted(FINE), *NOT_FINE) if any(o.verdict == v for _, o in outcomes.values())]
    counts = Counter((mutant.area, outcome.verdict) for mutant, outcome in outcomes.values())
    print("", f"| list | mutants | {' | '.join(verdicts)} |", "| --- " * (len(verdicts) + 2) + "|", sep="\n")
    for area in sorted({area for area, _ in counts}):
        row = [counts[area, verdict] for verdict in verdicts]
        print(f"| {area} | {sum(row)} | {' | '.join(map(str, row))} |")
    row = [sum(counts[key] for key in counts if key[1] == verdict) for verdict in verdicts]
    print(f"| all | {sum(row)} | {' | '.join(map(str, row))} |")
    for mutant, outcome in outcomes.values():
        if outcome.verdict not in FINE:
            print(f"{outcome.verdict}: {mutant.area}/{mutant.name}, {mutant.file}. {outcome.detail}")


def try_all(mutants: Sequence[Mutant], arguments: argparse.Namespace) -> dict[str, tuple[Mutant, Outcome]]:
    """Outcomes by names: what needs no run first, then Python mutants, then those of one C++ file after another."""
    results = Results(arguments.results)
    outcomes: dict[str, tuple[Mutant, Outcome]] = {}

    def note(mutant: Mutant, outcome: Outcome) -> None:
        outcomes[mutant.name] = mutant, outcome
        report(mutant, outcome, len(outcomes), len(mutants))

    faults, waiting = faults_of(mutants), []
    for mutant in mutants:
        if mutant.name in faults:
            note(mutant, Outcome("stale", faults[mutant.name]))
        elif mutant.equivalent:
            note(mutant, Outcome("equivalent", " ".join(mutant.equivalent.split())))
        elif (known := results.get(mutant.key())) is not None:
            note(mutant, known)
        else:
            waiting.append(mutant)
    if (faults and not arguments.keep_going) or not waiting:
        return outcomes

    copies: queue.Queue[CheckoutCopy] = queue.Queue()
    for k in range(min(arguments.jobs, len(waiting))):
        copies.put(CheckoutCopy(arguments.work / str(k), arguments.level))
    failing = failing_without_mutants(copies.queue[0], waiting, results, arguments.time_limit)
    for mutant in list(waiting):
        if test := fails_without(mutant, failing):
            note(mutant, Outcome("fails without it", test))
            waiting.remove(mutant)
    if failing and not arguments.keep_going:
        return outcomes

    def run_one(mutant: Mutant) -> None:
        copy = copies.get()
        try:
            copy.build_original()
            outcome = try_out(copy, mutant, arguments.time_limit)
        finally:
            copies.put(copy)
        results.add(mutant.name, mutant.key(), outcome)
        note(mutant, outcome)

    with ThreadPoolExecutor(arguments.jobs) as pool:
        list(pool.map(run_one, sorted(waiting, key=lambda mutant: (mutant.is_compiled, mutant.file))))
    return outcomes


def main() -> int:
    """See the top."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", default=[], metavar="NAME", help="these mutants")
    parser.add_argument("--area", nargs="+", default=[], metavar="LIST", help="those of these lists")
    parser.add_argument("--list", action="store_true", help="say what there is, and end")
    parser.add_argument("--keep-going", action="store_true", help="also if some are stale or fail without a mutant")
    parser.add_argument("--jobs", type=int, default=1, help="copies at work at a time (1)")
    parser.add_argument("--level", default=first_level(), help=f"SIMD level of the core ({first_level()})")
    parser.add_argument("--results", type=Path, help="JSON lines: what is done is kept, and not done again")
    parser.add_argument("--time-limit", type=float, default=TIME_LIMIT, help=f"s for a mutant's tests ({TIME_LIMIT:g})")
    parser.add_argument("--work", type=Path, default=folder_of_copies(), help="folder of the copies, kept")
    parser.add_argument("--lists", type=Path, default=LISTS, help="folder of the lists")
    arguments = parser.parse_args()
    try:
        mutants = chosen_mutants(arguments)
    except BadMutantError as error:
        raise SystemExit(str(error)) from None
    if arguments.list:
        for mutant in mutants:
            print(f"{mutant.area}/{mutant.name}: {mutant.file} {fault_of(mutant)}")
        return 0
    outcomes = try_all(mutants, arguments)
    print_table(outcomes)
    return 0 if len(outcomes) == len(mutants) and all(o.verdict in FINE for _, o in outcomes.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
