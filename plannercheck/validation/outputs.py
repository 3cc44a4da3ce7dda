"""Verdicts in files: npz, csv or parquet, one entry for each configuration, written chunk by chunk.

In: a complete journal. Out: a file that appears whole or not at all. Its bytes do not depend on interruptions of the
run, nor on the machines.

npz: `valid` (n,), `first_pair` (n,) row of `pairs` or -1, `beyond_limits` (n,), `pairs` (k, 2) names, `files` and
`file_rows`; with certificates `explained_pair`, `point`, `normal`, `offset`, `gap`; if only failures are written,
`file` and `row` of each. csv and parquet: one line for each configuration, with the names of file, links and obstacles.
"""

from __future__ import annotations

import math
import zipfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plannercheck.checking.protocols import AnyChecker
from plannercheck.common.atomic_files import write_atomically
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.escaping import csv_cell
from plannercheck.common.optional_imports import extra_module
from plannercheck.common.package_data import is_folder
from plannercheck.validation.journal import Journal
from plannercheck.validation.judging import Arrays, Judge

SUFFIXES = (".npz", ".csv", ".parquet")

_AXES = "xyz"


@dataclass(frozen=True, eq=False)
class Results:
    """The rows to write.

    Attributes:
        journal: All findings.
        judge: The judge with the options of the run.
        only_failed: Whether rows that pass are left out.
        files: Names of the files that were judged.
        pairs: Names of link and link or obstacle of each of the checker's pairs.
    """

    journal: Journal
    judge: Judge
    only_failed: bool
    files: tuple[str, ...]
    pairs: tuple[tuple[str, str], ...]

    @classmethod
    def of(
        cls, journal: Journal, judge: Judge, only_failed: bool, files: Sequence[str], checker: AnyChecker
    ) -> Results:
        """The results of a run."""
        pairs = tuple(checker.pair_names(k) for k in range(len(checker.pairs)))
        return cls(journal, judge, only_failed, tuple(files), pairs)

    @property
    def count(self) -> int:
        """Rows to write."""
        records = self.journal.records.values()
        return sum(record.failed if self.only_failed else record.rows for record in records)

    def file_rows(self) -> NDArray[np.int64]:
        """Rows of each file."""
        counts = np.zeros(len(self.files), dtype=np.int64)
        for record in self.journal.records.values():
            counts[record.file] += record.rows
        return counts

    def parts(self) -> Iterator[Arrays]:
        """Arrays of the rows to write, chunk by chunk, with `file` and `row` in it."""
        for record, arrays in self.journal.in_order():
            arrays["file"] = np.full(record.rows, record.file, dtype=np.int32)
            arrays["row"] = record.first_row + np.arange(record.rows, dtype=np.int64)
            if self.only_failed:
                failed = self.judge.fails(arrays)
                arrays = {name: array[failed] for name, array in arrays.items()}
            yield arrays

    def sample(self) -> Arrays:
        """Arrays of some of the rows, for their names and types; of none, if there is none."""
        return next(self.parts(), None) or self._no_rows()

    def _no_rows(self) -> Arrays:
        arrays: Arrays = {"first_pair": np.zeros(0, dtype=np.int32)}
        if self.judge.limits != "ignore":
            arrays["beyond_limits"] = np.zeros(0, dtype=bool)
        return {**arrays, "file": np.zeros(0, dtype=np.int32), "row": np.zeros(0, dtype=np.int64)}


def check_output(path: Path) -> None:
    """Raises, before long work, if an output's suffix is not supported, or its library is missing."""
    if path.suffix not in SUFFIXES:
        raise PlannercheckError(f"--output must be one of {', '.join(SUFFIXES)}, not {str(path)!r}")
    if is_folder(path):
        raise PlannercheckError(f"--output {str(path)!r} is a folder: give the name of a file")
    if path.suffix == ".parquet":
        extra_module("pyarrow.parquet", "parquet", "parquet files")


def write_results(path: Path, results: Results) -> None:
    """Writes verdicts; the suffix tells the format."""
    writers: dict[str, Callable[[Path, Results], None]] = {".npz": _npz, ".csv": _csv, ".parquet": _parquet}
    write_atomically(path, lambda aside: writers[path.suffix](aside, results))


def _npz(path: Path, results: Results) -> None:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED, allowZip64=True) as archive:
        for name, array in _constants(results).items():
            _write_member(archive, name, array.dtype, array.shape, iter([array]))
        for name, sample in _columns(results, results.sample()).items():
            shape = (results.count, *sample.shape[1:])
            parts = (_columns(results, arrays)[name] for arrays in results.parts())
            _write_member(archive, name, sample.dtype, shape, parts)


def _constants(results: Results) -> dict[str, NDArray[Any]]:
    return {
        "pairs": np.array(results.pairs, dtype=np.str_).reshape(-1, 2),
        "files": np.array(results.files, dtype=np.str_),
        "file_rows": results.file_rows(),
    }


def _columns(results: Results, arrays: Arrays) -> Arrays:
    """What npz has for each row; where all are written, they need no file and row."""
    implied = () if results.only_failed else ("file", "row")
    return {"valid": arrays["first_pair"] < 0, **{k: array for k, array in arrays.items() if k not in implied}}


def _write_member(
    archive: zipfile.ZipFile, name: str, dtype: np.dtype[Any], shape: tuple[int, ...], parts: Iterator[NDArray[Any]]
) -> None:
    """Writes an array of an npz file part by part; it has no date, so that equal content gives equal bytes."""
    with archive.open(zipfile.ZipInfo(f"{name}.npy"), "w", force_zip64=True) as member:
        header = {"descr": np.lib.format.dtype_to_descr(dtype), "fortran_order": False, "shape": shape}
        np.lib.format.write_array_header_2_0(member, header)
        for part in parts:
            member.write(np.ascontiguousarray(part).tobytes())


def _csv(path: Path, results: Results) -> None:
    """A line a row; texts that only depend on the verdict are made once."""
    tails: dict[tuple[int, int], str] = {}
    with path.open("w", encoding="utf-8", newline="") as file:
        file.write(_line(_csv_header(results)) + "\n")
        for arrays in results.parts():
            if not len(arrays["row"]):
                continue
            start = _line([results.files[arrays["file"][0]]])  # a chunk is of one file
            rows = arrays["row"].tolist()
            verdicts = list(zip(_reported_pairs(arrays).tolist(), _codes(arrays), strict=True))
            for pair, code in set(verdicts) - set(tails):
                tails[pair, code] = _line([*_flags(code, results), *(("", "") if pair < 0 else results.pairs[pair])])
            numbers = _certificate_texts(arrays)
            file.write(
                "".join(
                    f"{start},{row},{tails[verdict]}{text}\n"
                    for row, verdict, text in zip(rows, verdicts, numbers, strict=True)
                )
            )


def _reported_pairs(arrays: Arrays) -> NDArray[Any]:
    """(n,) the pair whose names a row gets."""
    return arrays.get("explained_pair", arrays["first_pair"])


def _csv_header(results: Results) -> list[str]:
    limits = [] if results.judge.limits == "ignore" else ["beyond_limits"]
    header = ["file", "row", "valid", *limits, "first", "second"]
    if results.judge.explain == "none":
        return header
    vectors = [f"{name}_{axis}" for name in ("point", "normal") for axis in _AXES[: _dimension(results)]]
    return [*header, *vectors, "offset", "gap"]


def _dimension(results: Results) -> int:
    """The dimension, 3 or 2, by the certificates."""
    points = results.sample().get("point")
    return len(_AXES) if points is None else int(points.shape[1])


def _line(fields: Sequence[object]) -> str:
    return ",".join(csv_cell(str(field)) for field in fields)


def _codes(arrays: Arrays) -> list[int]:
    """For each row 2 if it is valid, and 1 more if it is beyond the limits."""
    valid = arrays["first_pair"] < 0
    codes = 2 * valid.astype(np.int8)
    if "beyond_limits" in arrays:
        codes += arrays["beyond_limits"].astype(np.int8)
    return list(codes.tolist())


def _flags(code: int, results: Results) -> list[str]:
    flags = [code >= 2] if results.judge.limits == "ignore" else [code >= 2, code % 2 == 1]
    return [str(flag).lower() for flag in flags]


def _certificate_texts(arrays: Arrays) -> list[str]:
    """The numbers of each row's certificate, each after a comma; empty where there is none."""
    if "point" not in arrays:
        return [""] * len(arrays["row"])
    table = np.column_stack([arrays[name] for name in ("point", "normal", "offset", "gap")])
    return ["".join("," if math.isnan(x) else f",{x!r}" for x in row) for row in table.tolist()]


def _parquet(path: Path, results: Results) -> None:
    """A row group a chunk; names are dictionaries."""
    arrow = extra_module("pyarrow", "parquet", "parquet files")
    parquet = extra_module("pyarrow.parquet", "parquet", "parquet files")
    with parquet.ParquetWriter(path, _table(arrow, results, results.sample()).schema) as writer:
        for arrays in results.parts():
            writer.write_table(_table(arrow, results, arrays))


def _table(arrow: Any, results: Results, arrays: Arrays) -> Any:
    pairs = _reported_pairs(arrays)
    columns = {
        "file": _texts(arrow, arrays["file"], results.files),
        "row": arrow.array(arrays["row"]),
        "valid": arrow.array(arrays["first_pair"] < 0),
        "first": _texts(arrow, pairs, [first for first, _ in results.pairs]),
        "second": _texts(arrow, pairs, [second for _, second in results.pairs]),
    }
    for name in ("beyond_limits", "offset", "gap"):
        if name in arrays:
            columns[name] = _optional(arrow, arrays[name])
    for name in ("point", "normal"):
        if name in arrays:
            vectors = arrays[name]
            columns |= {
                f"{name}_{axis}": _optional(arrow, vectors[:, k]) for k, axis in enumerate(_AXES[: vectors.shape[1]])
            }
    return arrow.table(columns)


def _texts(arrow: Any, places: NDArray[Any], names: Sequence[str]) -> Any:
    """A column of names; nothing where the place is negative.

    Each name stands once in the dictionary: of repeated ones pyarrow writes memory that nobody has set.
    """
    unique = list(dict.fromkeys(names))
    position = {name: k for k, name in enumerate(unique)}
    of_place = np.array([position[name] for name in names] or [0], dtype=np.int32)
    missing = places < 0
    indices = arrow.array(of_place[np.where(missing, 0, places)], mask=missing)
    return arrow.DictionaryArray.from_arrays(indices, arrow.array(unique, arrow.string()))


def _optional(arrow: Any, values: NDArray[Any]) -> Any:
    """A column of numbers; nothing where there is none."""
    return arrow.array(values, mask=np.isnan(values)) if values.dtype.kind == "f" else arrow.array(values)
