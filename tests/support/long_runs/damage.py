"""Damaged journals, cached bodies and files of bodies: each is refused with one error, or harmless; no other verdict.

In: how many of each. Out: counts of what was refused, rebuilt or the same. All run in forks within 2 GB and 10 s each.
"""

import contextlib
import io
import os
import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np

import plannercheck as pc
from long_runs import forked
from long_runs.counts import BrokenPromiseError, Counts
from long_runs.mutations import damaged
from plannercheck.bodies import polytope_files as body_files
from plannercheck.bodies.polytope import prepared
from plannercheck.cli import main as cli
from plannercheck.common.cache import read_cached
from plannercheck.validation import outputs

_FILES, _ROWS = 5, 300  # of a set whose journal is damaged: a record a file
_HEAD = struct.Struct("<III")  # before each record of a journal: its lengths and checksum
_BAD_INPUT = 2
_KINDS = ("bodies", "cache files", "journals")


def run(folder: Path, trials: int, seed: int) -> Counts:
    """Makes trials of each kind.

    Raises:
        BrokenPromiseError: If a damaged file gave another body or verdict, or anything but one clear error.
    """
    os.environ["PLANNERCHECK_CACHE"] = str(folder / "cache")
    counts: Counts = {}
    makers: tuple[Callable[[Path, int], Callable[[int], str]], ...] = (_bodies, _cached, _journals)
    for kind, make in zip(_KINDS, makers, strict=True):
        tally = forked.run(make(folder, seed), trials, folder, batch=100)
        if tally.faults:
            number, what = tally.faults[0]
            raise BrokenPromiseError(
                f"{len(tally.faults)} of {tally.trials} damaged {kind}, first number {number}: {what}"
            )
        counts |= {kind: tally.trials, **{f"{kind} {word}": n for word, n in sorted(tally.outcomes.items())}}
        counts[f"ms for one of {kind}"] = round(1e3 * tally.seconds / trials, 1)
    return counts


def _bodies(folder: Path, seed: int) -> Callable[[int], str]:
    """Files of bodies: refused, or the body's own."""
    right = pc.Polytope(np.random.default_rng(0).normal(size=(60, 3)))
    saved = folder / "whole.body"
    right.save(saved)
    whole, path = saved.read_bytes(), folder / "damaged.body"

    def trial(number: int) -> str:
        content = damaged(whole, np.random.default_rng([seed, 1, number]))
        path.write_bytes(content)
        other = pc.Polytope.load(path)
        if other.core.serialise() != right.core.serialise():
            raise AssertionError("another body was taken")
        return "the same" if content == whole else "harmless"

    return trial


def _cached(folder: Path, seed: int) -> Callable[[int], str]:
    """Files of the cache, one of which may stand in another's place: the body is that of the points."""
    points = [np.random.default_rng(k).normal(size=(20, 3)) for k in range(3)]
    bodies = [prepared(each).core.serialise() for each in points]
    paths = [path for each in points if (path := body_files.cache_file(each, None, 0.0)) is not None]
    wholes = [path.read_bytes() for path in paths]

    def trial(number: int) -> str:
        rng = np.random.default_rng([seed, 2, number])
        k = int(rng.integers(len(points)))
        other = rng.integers(8) == 0
        paths[k].write_bytes(wholes[k - 1] if other else damaged(wholes[k], rng))
        taken = read_cached(paths[k]) is not None
        if prepared(points[k]).core.serialise() != bodies[k]:
            raise AssertionError("another body came out of the cache")
        paths[k].write_bytes(wholes[k])
        return "harmless" if taken else "rebuilt"

    return trial


def _journals(folder: Path, seed: int) -> Callable[[int], str]:
    """Journals, whole and partial, of this run and of another: the same output, or refused and nothing written."""
    robot = pc.Robot.load("panda")
    sources = [folder / f"q{k}.npy" for k in range(_FILES)]
    for k, source in enumerate(sources):
        np.save(source, robot.random_configurations(_ROWS, k))
    output = folder / "o.npz"
    journal = Path(f"{output}.progress")
    kept: dict[str, tuple[bytes, bytes]] = {}
    for scene in ("bookshelf", "table"):
        forked.apart(lambda scene=scene: _keep_journal(scene, sources, output, folder / scene), folder)  # type: ignore[misc]
        kept[scene] = (folder / scene).read_bytes(), output.read_bytes()
        output.unlink()
    (mine, right), (others, _) = kept["bookshelf"], kept["table"]
    records = _records(mine)

    def trial(number: int) -> str:
        rng = np.random.default_rng([seed, 3, number])
        journal.write_bytes(_damaged_journal(mine, others, records, rng))
        output.unlink(missing_ok=True)
        said = io.StringIO()
        with contextlib.redirect_stderr(said), contextlib.redirect_stdout(io.StringIO()):
            code = cli.main(_command("bookshelf", sources, output))
        if code == _BAD_INPUT:
            if output.exists() or said.getvalue().count("\n") != 1:
                raise AssertionError(f"refused, but not by one clear error alone: {said.getvalue()}")
            return forked.REFUSED
        if code not in (0, 1) or output.read_bytes() != right:
            raise AssertionError(f"exit code {code}, or other verdicts: {said.getvalue()}")
        return "resumed"

    return trial


def _command(scene: str, sources: list[Path], output: Path) -> list[str]:
    files = [*map(str, sources), "--output", str(output), "--resume"]
    return ["validate", "--robot", "panda", "--scene", scene, *files]


def _keep_journal(scene: str, sources: list[Path], output: Path, kept: Path) -> None:
    """Runs `validate`, and keeps the journal that it removes when the output is whole."""
    write = outputs.write_atomically

    def keep(path: Path, *arguments: object) -> None:
        kept.write_bytes(Path(f"{output}.progress").read_bytes())
        write(path, *arguments)  # type: ignore[arg-type]

    outputs.write_atomically = keep  # type: ignore[attr-defined, assignment]
    with contextlib.redirect_stdout(io.StringIO()):
        cli.main(_command(scene, sources, output))


def _records(journal: bytes) -> list[tuple[int, int]]:
    """Where each record begins and ends."""
    places, at = [], journal.index(b"\n") + 1
    while at < len(journal):
        told, size, _ = _HEAD.unpack_from(journal, at)
        places.append((at, at + _HEAD.size + told + size))
        at = places[-1][1]
    return places


def _damaged_journal(mine: bytes, others: bytes, records: list[tuple[int, int]], rng: np.random.Generator) -> bytes:
    """A journal of some of the records, in some order, damaged; or with parts of another run's."""
    parts = [mine[slice(*place)] for place in records]
    first = mine[: records[0][0]]
    match int(rng.integers(5)):
        case 0:
            return others if rng.integers(2) else damaged(others, rng)
        case 1:  # another run's records under this run's first line
            return first + others[_records(others)[0][0] :]
        case 2:  # in another order, some of them twice
            return first + b"".join(parts[k] for k in rng.integers(len(parts), size=len(parts)))
        case 3:
            return damaged(first + b"".join(parts[: int(rng.integers(len(parts) + 1))]), rng)
        case _:
            return damaged(mine, rng)
