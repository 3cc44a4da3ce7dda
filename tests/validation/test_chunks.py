"""Sets are read as they were written, chunk by chunk, and bad files are named with their row."""

from pathlib import Path

import numpy as np
import pytest

from plannercheck.common.errors import PlannercheckError
from plannercheck.validation.formats import chunks
from plannercheck.validation.formats import csv as text
from plannercheck.validation.formats.chunks import read_chunks

JOINTS = ("a", "b", "c")


@pytest.fixture
def rows() -> np.ndarray:
    return np.random.default_rng(0).normal(size=(25, 3))


def read(path: Path) -> np.ndarray:
    chunks = list(read_chunks(path, JOINTS, 3))
    firsts = np.cumsum([0, *(len(chunk.rows) for chunk in chunks)])[:-1]
    assert [chunk.first_row for chunk in chunks] == firsts.tolist()
    return np.concatenate([np.empty((0, 3)), *(chunk.rows for chunk in chunks)])


@pytest.mark.parametrize("order", ["C", "F"])
@pytest.mark.parametrize("dtype", [np.float64, np.float32, np.int64])
def test_npy(tmp_path, rows, monkeypatch, order, dtype):
    monkeypatch.setattr(chunks, "CHUNK_ROWS", 7)
    values = np.array(10 * rows, dtype=dtype, order=order)
    np.save(tmp_path / "q.npy", values)
    assert np.array_equal(read(tmp_path / "q.npy"), values.astype(np.float64))


def test_a_single_configuration_is_one_row(tmp_path, rows):
    np.save(tmp_path / "q.npy", rows[0])
    assert np.array_equal(read(tmp_path / "q.npy"), rows[:1])


def test_an_empty_set_has_no_rows(tmp_path):
    np.save(tmp_path / "q.npy", np.empty((0, 3)))
    assert read(tmp_path / "q.npy").shape == (0, 3)


@pytest.mark.parametrize("arrays", [("anything",), ("q", "time"), ("configurations", "time")])
def test_npz(tmp_path, rows, arrays):
    np.savez(tmp_path / "q.npz", **{arrays[0]: rows}, **dict.fromkeys(arrays[1:], np.zeros(2)))
    assert np.array_equal(read(tmp_path / "q.npz"), rows)


@pytest.mark.parametrize("separator", [",", ";", "\t", " "])
@pytest.mark.parametrize("header", [None, ["c", "time", "a", "b"]])
def test_csv(tmp_path, rows, monkeypatch, separator, header):
    monkeypatch.setattr(chunks, "CHUNK_ROWS", 7)
    columns = rows if header is None else np.column_stack([rows[:, 2], rows[:, 0] * 0, rows[:, 0], rows[:, 1]])
    lines = [separator.join(map(repr, row)) for row in columns.tolist()]
    text = "\n".join(["# a comment", *([separator.join(header)] if header else []), *lines, ""])
    (tmp_path / "q.csv").write_text(text)
    assert np.array_equal(read(tmp_path / "q.csv"), rows)


@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_csv_by_arrow(tmp_path, monkeypatch, separator):
    arrow = pytest.importorskip("pyarrow.csv")
    called: list[int] = []
    monkeypatch.setattr(text, "MANY_LINES", 2)
    monkeypatch.setattr(arrow, "read_csv", lambda *args, read=arrow.read_csv: called.append(1) or read(*args))
    values = np.random.default_rng(1).integers(0, 2**64, size=(600, 3), dtype=np.uint64).view(np.float64)
    values = values[np.isfinite(values).all(axis=1) & (np.abs(values).max(axis=1) < 1e300)]  # of every exponent
    lines = [separator.join(map(repr, row)) for row in values.tolist()]
    (tmp_path / "q.csv").write_text("\n".join(lines))
    assert read(tmp_path / "q.csv").tobytes() == values.tobytes()
    assert called
    for bad in ("1,2", "1,,3", "1,2,x", "1,2,NA", '"1",2,3'):
        (tmp_path / "q.csv").write_text("1,2,3\n1,2,3\n" + bad)
        with pytest.raises(PlannercheckError, match=r"row 2 must have 3 numbers|are no table of numbers"):
            read(tmp_path / "q.csv")


def test_a_nan_is_named_by_its_row_in_the_file(tmp_path, rows, monkeypatch):
    monkeypatch.setattr(chunks, "CHUNK_ROWS", 7)
    rows[16, 1] = np.nan
    np.save(tmp_path / "q.npy", rows)
    with pytest.raises(PlannercheckError, match=r"q\.npy.*row 16 is not finite"):
        read(tmp_path / "q.npy")


@pytest.mark.parametrize("kept", [0, 5, 60, 128, 300, 600])
def test_a_truncated_npy(tmp_path, rows, kept):
    np.save(tmp_path / "q.npy", rows)
    (tmp_path / "q.npy").write_bytes((tmp_path / "q.npy").read_bytes()[:kept])
    with pytest.raises(PlannercheckError, match=r"q\.npy"):
        read(tmp_path / "q.npy")


def test_an_npz_that_calls_itself_encrypted(tmp_path, rows):
    np.savez(tmp_path / "q.npz", rows)
    content = bytearray((tmp_path / "q.npz").read_bytes())
    content[content.rindex(b"PK\x01\x02") + 8] |= 1  # the flag in the central directory
    (tmp_path / "q.npz").write_bytes(content)
    with pytest.raises(PlannercheckError, match=r"q\.npz.*encrypted"):
        read(tmp_path / "q.npz")


@pytest.mark.parametrize("kept", [0, 5, 60, 400])
def test_a_truncated_npz(tmp_path, rows, kept):
    np.savez(tmp_path / "q.npz", rows)
    (tmp_path / "q.npz").write_bytes((tmp_path / "q.npz").read_bytes()[:kept])
    with pytest.raises(PlannercheckError, match=r"q\.npz"):
        read(tmp_path / "q.npz")


@pytest.mark.parametrize(
    ("array", "message"),
    [
        (np.zeros((4, 5)), r"must have shape \(n, 3\), not \(4, 5\)"),
        (np.zeros((4, 3, 1)), r"must have shape \(n, 3\)"),
        (np.zeros((4, 3), dtype=complex), "real numbers"),
        (np.full((4, 3), "x"), "real numbers"),
        (np.array([None, 1]), "no whole npy file"),
    ],
)
def test_an_npy_of_something_else(tmp_path, array, message):
    np.save(tmp_path / "q.npy", array, allow_pickle=True)
    with pytest.raises(PlannercheckError, match=message):
        read(tmp_path / "q.npy")


def test_an_npz_with_several_arrays_needs_the_usual_name(tmp_path, rows):
    np.savez(tmp_path / "q.npz", first=rows, second=rows)
    with pytest.raises(PlannercheckError, match=r"one named q or configurations; it holds first, second"):
        read(tmp_path / "q.npz")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("1,2\n3,4\n", r"must have 3 columns \(the joints are a, b, c\), not 2"),
        ("a,b,d\n1,2,3\n", r"no column for joint 'c'; its header is a, b, d"),
        ("a,b,c,c\n1,2,3,4\n", "2 columns named 'c'"),
        ("a,b,c\n1,2,3\n1,2,x\n", "row 1 must have 3 numbers, not '1,2,x'"),
        ("1,2,3\n1,2\n", "row 1 must have 3 numbers"),
        ("1,2,3\n1,2,nan\n", "row 1 is not finite"),
    ],
)
def test_bad_csv(tmp_path, content, message):
    (tmp_path / "q.csv").write_text(content)
    with pytest.raises(PlannercheckError, match=message):
        read(tmp_path / "q.csv")


def test_a_header_needs_one_number_a_joint(tmp_path):
    (tmp_path / "q.csv").write_text("a,b\n1,2\n")
    with pytest.raises(PlannercheckError, match="leave the header out"):
        list(read_chunks(tmp_path / "q.csv", ("a", "b"), 3))


def test_missing_files_and_other_formats(tmp_path):
    (tmp_path / "q.txt").write_text("1,2,3\n")
    (tmp_path / "folder.npy").mkdir()
    for name, message in (("q.txt", "must be one of"), ("no.npy", "does not exist"), ("folder.npy", "is a folder")):
        with pytest.raises(PlannercheckError, match=message):
            read(tmp_path / name)
