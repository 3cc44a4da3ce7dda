"""A run: judges chunks of files and keeps the findings, which are written when all chunks are done.

In: chunks, an engine, a journal. Out: the summary. Chunks that the journal has from an earlier run are compared by
their checksums and not judged again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from plannercheck.checking.verdicts import ValidityReport, merged
from plannercheck.common.errors import PlannercheckError
from plannercheck.validation.engines import Engine
from plannercheck.validation.formats.chunks import Chunk
from plannercheck.validation.journal import Journal
from plannercheck.validation.judging import Findings, Judge
from plannercheck.validation.progress import Progress

Watcher = Callable[[Chunk, Findings], None]


class Run:
    """One pass over a set.

    Attributes:
        report: The summary so far.
        resumed: Rows that were judged by an earlier run.
        checking: Time that this run spent in checkers, all workers together, s.
    """

    def __init__(self, judge: Judge, journal: Journal | None = None, progress: Progress | None = None) -> None:
        """Nothing is done yet. Without a journal of the findings only the summary is kept.

        Each chunk's rows go to `progress`.
        """
        self._judge, self._journal = judge, journal
        self._progress = Progress("none") if progress is None else progress
        self._met: set[tuple[int, int]] = set()
        self.report = merged([])
        self.resumed, self.checking = 0, 0.0

    def over(self, chunks: Iterable[Chunk], engine: Engine, watchers: Iterable[Watcher] = ()) -> ValidityReport:
        """Judges all chunks, which are in order; watchers are called with each chunk and its findings.

        Returns:
            The summary of all rows, those of earlier runs included.

        Raises:
            PlannercheckError: If a chunk can't be judged, or the journal has rows that are not among these.
        """
        watchers = tuple(watchers)
        try:
            for chunk, findings in engine.findings(self._unknown(chunks)):
                self._keep(chunk, findings)
                for watcher in watchers:
                    watcher(chunk, findings)
                self._progress.advance(len(chunk.rows), chunk.part)
        finally:
            self._progress.close()
        self._check_all_met()
        return self.report

    def _unknown(self, chunks: Iterable[Chunk]) -> Iterator[Chunk]:
        """Chunks that the journal does not have."""
        for chunk in chunks:
            record = None if self._journal is None else self._journal.knows(chunk)
            self._met.add((chunk.file, chunk.first_row))
            if record is None:
                yield chunk
                continue
            self._add(record.report)
            self.resumed += record.rows
            self._progress.skip(record.rows, chunk.part)

    def _keep(self, chunk: Chunk, findings: Findings) -> None:
        if self._journal is not None:
            self._journal.append(chunk, findings, int(self._judge.fails(findings.arrays).sum()))
        self.checking += findings.report.duration
        self._add(findings.report)

    def _add(self, report: ValidityReport) -> None:
        self.report = merged([self.report, report]) if self.report.states else report

    def _check_all_met(self) -> None:
        left = set() if self._journal is None else set(self._journal.records) - self._met
        if left and self._journal is not None:
            file, row = min(left)
            raise PlannercheckError(
                f"the run in {str(self._journal.path)!r} judged more than these files hold (file {file + 1}, from row "
                f"{row} on): resume with the same files, or leave --resume out to begin anew"
            )
