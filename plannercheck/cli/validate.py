"""`plannercheck validate`: sets of configurations of any size, in files or from standard input.

In: a robot, a scene, files. Out: a summary, and on request a verdict for each configuration. Files are read in chunks,
and findings go to a journal beside the output until all are there: memory stays bounded, and an interrupted run can
resume.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
import warnings
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np

from plannercheck.bodies.array_files import array_of_file
from plannercheck.checking.protocols import AnyChecker
from plannercheck.cli import validate_paths as validated_paths
from plannercheck.cli.common import check_at_rest, check_folder, load_checker, save_json
from plannercheck.cli.unused_options import check_used
from plannercheck.cli.validate_options import add_set_arguments, check_options
from plannercheck.cli.validate_proofs import Verification, check_proofs
from plannercheck.cli.validate_summary import Outcome, as_json, show_table
from plannercheck.common.atomic_files import is_stream
from plannercheck.common.errors import PlannercheckError
from plannercheck.validation.engines import Engine, LocalEngine
from plannercheck.validation.fingerprint import fingerprint
from plannercheck.validation.formats.chunks import (
    CHUNK_ROWS,
    KEYED_SUFFIXES,
    STANDARD_INPUT,
    Chunk,
    files_of,
    read_sets,
)
from plannercheck.validation.formats.columns import columns_of
from plannercheck.validation.journal import Journal
from plannercheck.validation.judging import Explained, Findings, Judge
from plannercheck.validation.outputs import Results, check_output, write_results
from plannercheck.validation.progress import Progress
from plannercheck.validation.run import Run

# Rows of a chunk if each takes a millisecond or more: a kill shall not lose minutes.
_SLOW_CHUNK_ROWS = 2048

# What is added to an output's name for the journal beside it.
JOURNAL_SUFFIX = ".progress"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's options."""
    add_set_arguments(parser)


def run(options: argparse.Namespace) -> int:
    """Runs the command."""
    check_options(options)
    if options.path:
        return validated_paths.run(options)
    for path in (options.output, options.summary):
        check_folder(path)
    if options.output is not None:
        check_output(options.output)
    options.files = files_of(options.files)
    if not any(path.suffix.lower() in KEYED_SUFFIXES for path in options.files):
        check_used(options, ("--key",), f"for {', '.join(KEYED_SUFFIXES)} files, which hold several arrays")
    _check_names(options)
    checker, judge = load_checker(options), _judge(options)
    if not judge.times or options.certify or options.reference:
        check_at_rest(checker.scene, "configurations are")
    with _journal(options, checker, judge) as journal:
        outcome = _outcome(options, checker, judge, journal)
        if options.summary is not None:
            save_json(options.summary, as_json(outcome))
        if journal is not None:
            journal.remove()
    return _report(options, outcome, judge)


def _check_names(options: argparse.Namespace) -> None:
    """Raises before long work if what is written would replace what is read, or a name can't be written down."""
    written = [path for path in (options.output, options.summary) if path is not None]
    read = [path for path in options.files if path != STANDARD_INPUT]
    for path in [*written, *(_journal_path(path) for path in written[:1])]:
        same = next((file for file in read if _is_same(file, path)), None)
        if same is not None:
            raise PlannercheckError(f"{str(path)!r} would replace the input {str(same)!r}: choose another name")
    if len(written) == 2 and (written[0] == written[1] or _is_same(*written)):
        raise PlannercheckError(f"--output and --summary are one file, {str(written[0])!r}: choose two")
    for file in read if written else []:
        try:
            str(file).encode()
        except UnicodeEncodeError:
            raise PlannercheckError(f"the name {str(file)!r} is no UTF-8, so it can't be written: rename it") from None


def _is_same(a: Path, b: Path) -> bool:
    """Whether two names are of one file, whatever links lead there."""
    try:
        return a.samefile(b)
    except OSError:
        return False


def _journal_path(written: Path) -> Path:
    return written.with_name(written.name + JOURNAL_SUFFIX)


def _judge(options: argparse.Namespace) -> Judge:
    explain: Explained = "none" if not options.explain else "invalid" if options.only_invalid else "all"
    return Judge(options.pairs == "all", options.limits, explain, options.threads, _times(options))


def _times(options: argparse.Namespace) -> tuple[float, ...]:
    """The scene's clock: one number, or one for each row."""
    if options.times is None:
        return () if options.time is None else (options.time,)
    if options.time is not None or len(options.files) > 1:
        raise PlannercheckError("--times is of the rows of one FILE, and stands in place of --time")
    found = array_of_file(options.times, "file of times")
    if found.ndim != 1 or not len(found) or found.dtype.kind not in "iuf":
        raise PlannercheckError(f"--times {str(options.times)!r} must hold numbers (n,), s, not {found.shape}")
    return tuple(found.astype(np.float64).tolist())


def _chunk_rows(options: argparse.Namespace) -> int:
    return _SLOW_CHUNK_ROWS if options.explain or options.certify or options.reference else CHUNK_ROWS


@contextmanager
def _journal(options: argparse.Namespace, checker: AnyChecker, judge: Judge) -> Iterator[Journal | None]:
    """The journal beside the output; it stays if the run does not come to its end. None if nothing is written."""
    written = options.output or options.summary
    if written is None:
        yield None
        return
    run = fingerprint(checker, judge, _chunk_rows(options))
    if is_stream(written):  # beside which there may be no room for a file
        with (
            tempfile.TemporaryDirectory(prefix="plannercheck-") as folder,
            closing(Journal(Path(folder) / "journal", run)) as journal,
        ):
            yield journal
        return
    path = _journal_path(written)
    if path.exists() and path.stat().st_size and not options.resume:
        warnings.warn(f"an unfinished run in {str(path)!r} begins anew; --resume would go on", stacklevel=2)
    journal = Journal(path, run, options.resume)
    try:
        yield journal
    except BaseException as error:
        if not journal.records or STANDARD_INPUT in options.files:
            journal.remove()
        else:
            journal.close()
            rows = sum(record.rows for record in journal.records.values())
            kept = f"{rows:,} judged configurations are kept in {str(path)!r}; the same command with --resume goes on"
            if isinstance(error, KeyboardInterrupt):  # the one line that is said then
                error.args = (kept,)
            else:
                print(f"plannercheck: {kept}", file=sys.stderr)
        raise


def _outcome(options: argparse.Namespace, checker: AnyChecker, judge: Judge, journal: Journal | None) -> Outcome:
    """Judges all files and writes the verdicts."""
    verification = Verification(checker, bool(options.reference), options.certify)
    columns = columns_of(checker.robot, options.columns, options.ignore_columns, options.degrees)
    began = time.perf_counter()
    chunks = read_sets(options.files, columns, options.key, _chunk_rows(options))
    this = Run(judge, journal, Progress(options.progress))
    # A cluster's workers warn elsewhere; the local engine's warning says more.
    hints = [] if options.engine == "local" else [_warn_of_units]
    with _engine(options, checker, judge) as engine:
        report = replace(this.over(chunks, engine, [verification, *hints]), all_pairs=judge.all_pairs)
    if len(judge.times) > 1 and len(judge.times) != report.states:
        raise PlannercheckError(f"--times has {len(judge.times)} numbers, and {options.files[0]} {report.states} rows")
    if options.output is not None and journal is not None:
        files = [str(path) for path in options.files]
        write_results(options.output, Results.of(journal, judge, options.only_invalid, files, checker))
    elapsed = time.perf_counter() - began
    found = verification.agreement, verification.certification
    return Outcome(checker, report, judge.limits, elapsed, this.checking, this.resumed, *found)


def _warn_of_units(chunk: Chunk, findings: Findings) -> None:
    """Warns if a set begins with configurations most of which are beyond the limits."""
    if chunk.first_row == 0 and 2 * findings.report.beyond_limits > findings.report.states:
        warnings.warn(
            "most configurations are beyond the limits: are they in degrees (--degrees), or in another order "
            "(--columns)?",
            stacklevel=2,
        )


@contextmanager
def _engine(options: argparse.Namespace, checker: AnyChecker, judge: Judge) -> Iterator[Engine]:
    if options.engine == "local":
        yield LocalEngine(checker, judge)
        return
    from plannercheck.validation.cluster import ClusterEngine  # needs dask.distributed

    with ClusterEngine(checker, judge, options.scheduler, options.workers) as engine:
        yield engine


def _report(options: argparse.Namespace, outcome: Outcome, judge: Judge) -> int:
    """Shows the summary; the exit code."""
    if options.format == "json":
        print(json.dumps(as_json(outcome), indent=1))
    else:
        show_table(outcome)
    if judge.limits == "warn" and outcome.report.beyond_limits:
        warnings.warn(f"{outcome.report.beyond_limits} configurations are beyond the limits", stacklevel=2)
    check_proofs(outcome.certification)
    agrees = outcome.agreement is None or outcome.agreement.passed
    return 0 if judge.passes(outcome.report) and agrees else 1
