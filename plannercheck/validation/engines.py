"""Judges chunks in this process; `cluster` does the same on other machines.

In: chunks, in order. Out: chunks with findings; from a cluster in any order.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Protocol

from plannercheck.checking.protocols import AnyChecker
from plannercheck.common.checked_yaml import error_context
from plannercheck.validation.formats.chunks import Chunk
from plannercheck.validation.judging import Findings, Judge


class Engine(Protocol):
    """Judges chunks."""

    def findings(self, chunks: Iterable[Chunk]) -> Iterator[tuple[Chunk, Findings]]:
        """What is found about each chunk, as soon as it is known."""


class LocalEngine:
    """Judges in this process, on as many threads as the judge has."""

    def __init__(self, checker: AnyChecker, judge: Judge) -> None:
        self._checker, self._judge = checker, judge

    def findings(self, chunks: Iterable[Chunk]) -> Iterator[tuple[Chunk, Findings]]:
        """What is found about each chunk, in order."""
        for chunk in chunks:
            yield chunk, evaluate(self._judge, self._checker, chunk)


def evaluate(judge: Judge, checker: AnyChecker, chunk: Chunk) -> Findings:
    """What a judge finds about a chunk; errors say where in the file it is."""
    with error_context(f"rows from {chunk.first_row} on"):
        return judge(checker, chunk.rows, chunk.first_row)
