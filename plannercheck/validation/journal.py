"""The journal of a run: all findings so far, so that an interrupted run can resume.

In: findings of chunks, in any order. Out: the same, chunk by chunk, in the order of the rows. The first line of the
file has the fingerprint of its run. Records follow, each with its length and checksum, so that a record cut off by a
kill is recognised. Nothing is rewritten, and each chunk is written by one call.
"""

from __future__ import annotations

import contextlib
import fcntl
import io
import json
import os
import struct
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from plannercheck.checking.verdicts import PairCount, ValidityReport
from plannercheck.common.errors import PlannercheckError
from plannercheck.validation.formats.chunks import Chunk
from plannercheck.validation.judging import Arrays, Findings

_MAGIC = b"plannercheck journal 2 "

# Before each record: lengths of its description and of its arrays, and their checksum, which begins with that of the
# journal's first line: a record of another run is none of this one's.
_HEAD = struct.Struct("<III")


@dataclass(frozen=True)
class Record:
    """A chunk in the journal.

    Attributes:
        file: The index of its file.
        first_row: Its first row in that file.
        checksum: The checksum of its rows.
        failed: How many of its rows did not pass.
        report: The summary.
        place: Position of its arrays in the journal.
        size: Bytes of its arrays.
    """

    file: int
    first_row: int
    checksum: int
    failed: int
    report: ValidityReport
    place: int = 0
    size: int = 0

    @property
    def rows(self) -> int:
        """How many."""
        return self.report.states


class Journal:
    """A journal that is open, with its records by file and first row."""

    def __init__(self, path: Path, fingerprint: Mapping[str, str], resume: bool = False) -> None:
        """Begins a run's journal; or resumes one, which goes on with what is there: if nothing is, the journal is new.

        Raises:
            PlannercheckError: If the journal is of another run, or can't be written.
        """
        self.path = path
        self.records: dict[tuple[int, int], Record] = {}
        with self._writing():
            self._file = _opened(path)
            was_empty = not path.stat().st_size
            try:
                _check_is_journal(path, self._file)
                if resume and not was_empty:
                    self._take_up(dict(fingerprint))
                else:
                    self._begin(dict(fingerprint))
            except BaseException:
                self.close()
                if was_empty:  # an empty file would pass for an unfinished run
                    path.unlink(missing_ok=True)
                raise

    def _begin(self, fingerprint: dict[str, str]) -> None:
        line = _MAGIC + json.dumps(fingerprint).encode() + b"\n"
        self._run = zlib.crc32(line)
        self._file.truncate(0)
        self._file.write(line)
        self._file.flush()

    def _take_up(self, fingerprint: dict[str, str]) -> None:
        """Reads what is there, and cuts off a record that is not whole."""
        line = self._file.readline()
        try:
            known = json.loads(line[len(_MAGIC) :]) if line.startswith(_MAGIC) and line.endswith(b"\n") else None
        except ValueError:
            known = None
        if not isinstance(known, dict):
            raise PlannercheckError(f"{str(self.path)!r} is no journal of a run: remove it, or leave --resume out")
        changed = [name for name in {**known, **fingerprint} if known.get(name) != fingerprint.get(name)]
        if changed:
            told = "; ".join(
                f"{name}: {known.get(name, 'none')!s:.40}, now {fingerprint.get(name, 'none')!s:.40}"
                for name in changed
            )
            raise PlannercheckError(
                f"the run in {str(self.path)!r} was another one ({told}): give the same robot, scene and options, or "
                "leave --resume out to begin anew"
            )
        self._run = zlib.crc32(line)
        end = self._file.tell()
        while (record := self._next()) is not None:
            self.records[record.file, record.first_row] = record
            end = record.place + record.size
        self._file.truncate(end)
        self._file.seek(end)

    def _next(self) -> Record | None:
        """The next record, or None if there is no whole one."""
        head = self._file.read(_HEAD.size)
        if len(head) < _HEAD.size:
            return None
        told, size, checksum = _HEAD.unpack(head)
        if told + size > os.fstat(self._file.fileno()).st_size - self._file.tell():
            return None  # not read: damaged lengths may ask for gigabytes
        description = self._file.read(told)
        place = self._file.tell()
        content = self._file.read(size)
        if len(content) < size or self._checksum(description, content) != checksum:
            return None
        return _record(json.loads(description), place, size)

    def _checksum(self, description: bytes, content: bytes) -> int:
        return zlib.crc32(content, zlib.crc32(description, self._run))

    def append(self, chunk: Chunk, findings: Findings, failed: int) -> None:
        """Writes what was found about a chunk."""
        record = Record(chunk.file, chunk.first_row, row_checksum(chunk), failed, findings.report)
        description = json.dumps(asdict(record)).encode()
        with io.BytesIO() as buffer:
            np.savez(buffer, **findings.arrays)  # type: ignore[arg-type]  # numpy's types know no dict here
            content = buffer.getvalue()
        head = _HEAD.pack(len(description), len(content), self._checksum(description, content))
        with self._writing():
            self._file.seek(0, io.SEEK_END)
            place = self._file.tell() + len(head) + len(description)
            self._file.write(head + description + content)
            self._file.flush()
        self.records[chunk.file, chunk.first_row] = _record(asdict(record), place, len(content))

    def knows(self, chunk: Chunk) -> Record | None:
        """The record of a chunk; None if it has none.

        Raises:
            PlannercheckError: If its rows are not those that were judged.
        """
        record = self.records.get((chunk.file, chunk.first_row))
        if record is not None and (record.rows, record.checksum) != (len(chunk.rows), row_checksum(chunk)):
            raise PlannercheckError(
                f"rows {chunk.first_row} to {chunk.first_row + len(chunk.rows) - 1} are not those that the run in "
                f"{str(self.path)!r} judged: resume with the same files, columns and units, or leave --resume out to "
                "begin anew"
            )
        return record

    def in_order(self) -> Iterator[tuple[Record, Arrays]]:
        """All records in the order of the rows, with their arrays."""
        for key in sorted(self.records):
            record = self.records[key]
            with self._writing():
                self._file.seek(record.place)
                content = self._file.read(record.size)
            with np.load(io.BytesIO(content), allow_pickle=False) as arrays:
                yield record, {name: arrays[name] for name in arrays.files}

    def close(self) -> None:
        """Closes the file, which stays."""
        with contextlib.suppress(OSError):  # the rest of a record for which the disk had no room; it counts for nothing
            self._file.close()

    def remove(self) -> None:
        """Closes the file and removes it: the run is done."""
        self.close()
        self.path.unlink(missing_ok=True)

    @contextlib.contextmanager
    def _writing(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise PlannercheckError(f"journal {str(self.path)!r} can't be written: {error.strerror or error}") from None


def _opened(path: Path) -> BinaryIO:
    """The file, for this process alone; links are not followed, and nothing but a file is opened."""
    if path.is_symlink() or (path.exists() and not path.is_file()):
        raise PlannercheckError(f"{str(path)!r} is in the way: the journal of a run is written there; remove it")
    file = os.fdopen(os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK, 0o666), "r+b")
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        file.close()
        raise PlannercheckError(
            f"another run is writing {str(path)!r}: wait for its end, or choose another --output"
        ) from None
    return file


def _check_is_journal(path: Path, file: BinaryIO) -> None:
    """Raises for a file that holds anything but a journal, or the beginning of one: it is somebody's."""
    start = file.read(len(_MAGIC))
    file.seek(0)
    if not _MAGIC.startswith(start):
        raise PlannercheckError(
            f"{str(path)!r} is no journal of a run, and would be overwritten: remove it, or choose another --output"
        )


def row_checksum(chunk: Chunk) -> int:
    """The checksum of a chunk's numbers."""
    return zlib.crc32(chunk.rows.data) if chunk.rows.size else 0


def _record(told: dict[str, Any], place: int, size: int) -> Record:
    report = told["report"]
    pairs = tuple(PairCount(**pair) for pair in report["pairs"])
    return Record(**{**told, "report": ValidityReport(**{**report, "pairs": pairs}), "place": place, "size": size})
