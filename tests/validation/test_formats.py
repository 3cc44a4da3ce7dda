"""Every format gives the same rows: by position or by name, in rad or degrees, in bounded memory."""

import io
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from plannercheck.common.errors import PlannercheckError
from plannercheck.common.optional_imports import extra_module
from plannercheck.planar import Robot as PlanarRobot
from plannercheck.robots.robot import Robot
from plannercheck.validation.formats.chunks import STANDARD_INPUT, files_of, read_sets
from plannercheck.validation.formats.columns import Columns, angle_columns, columns_of

JOINTS = ("a", "b", "c")
# Columns of a file in another order than the joints', with one that is none.
SHUFFLED = ("c", "time", "a", "b")


@pytest.fixture
def rows() -> np.ndarray:
    return np.random.default_rng(0).normal(size=(25, 3))


def read(path: Path, columns: Columns | None = None, key: str | None = None) -> np.ndarray:
    """All rows, read 7 at a time."""
    chunks = list(read_sets([path], columns or Columns(JOINTS, 3), key, size=7))
    assert all(len(chunk.rows) == 7 for chunk in chunks[:-1])
    parts = [chunk.part for chunk in chunks]
    assert parts == sorted(parts)
    assert not parts or parts[-1] == 1.0
    return np.concatenate([np.empty((0, 3)), *(chunk.rows for chunk in chunks)])


def shuffled(rows: np.ndarray) -> dict[str, np.ndarray]:
    return {"c": rows[:, 2], "time": np.arange(len(rows)), "a": rows[:, 0], "b": rows[:, 1]}


def write_npy(path: Path, rows: np.ndarray) -> None:
    np.save(path, rows)


def write_npz(path: Path, rows: np.ndarray) -> None:
    np.savez_compressed(path, rows)


def write_csv(path: Path, rows: np.ndarray) -> None:
    np.savetxt(path, rows, delimiter=",", fmt="%.17g")


def write_parquet(path: Path, rows: np.ndarray) -> None:
    arrow, parquet = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    parquet.write_table(arrow.table({"q": list(rows)}), path, row_group_size=4)


def write_fixed_lists(path: Path, rows: np.ndarray) -> None:
    arrow, parquet = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    lists = arrow.FixedSizeListArray.from_arrays(arrow.array(rows.ravel()), rows.shape[1])
    parquet.write_table(arrow.table({"other": np.arange(len(rows)), "anything": lists}), path)


def write_hdf5(path: Path, rows: np.ndarray) -> None:
    with pytest.importorskip("h5py").File(path, "w") as file:
        file["group/q"] = rows


BY_POSITION = {
    "q.npy": write_npy,
    "q.npz": write_npz,
    "q.csv": write_csv,
    "q.parquet": write_parquet,
    "lists.parquet": write_fixed_lists,
    "q.h5": write_hdf5,
}


@pytest.mark.parametrize("name", BY_POSITION)
def test_by_position(tmp_path, rows, name):
    BY_POSITION[name](tmp_path / name, rows)
    assert np.array_equal(read(tmp_path / name), rows)


def name_npy(path: Path, rows: np.ndarray) -> None:
    records = np.zeros(len(rows), dtype=[(name, "f8") for name in SHUFFLED])
    for name, values in shuffled(rows).items():
        records[name] = values
    np.save(path, records)


def name_npz(path: Path, rows: np.ndarray) -> None:
    np.savez(path, configurations=np.column_stack(list(shuffled(rows).values())), joint_names=SHUFFLED)


def name_csv(path: Path, rows: np.ndarray) -> None:
    table = np.column_stack(list(shuffled(rows).values()))
    np.savetxt(path, table, delimiter=";", fmt="%.17g", header=";".join(SHUFFLED), comments="")


def name_parquet(path: Path, rows: np.ndarray) -> None:
    pytest.importorskip("pyarrow.parquet").write_table(pytest.importorskip("pyarrow").table(shuffled(rows)), path)


def name_hdf5(path: Path, rows: np.ndarray) -> None:
    with pytest.importorskip("h5py").File(path, "w") as file:
        file["q"] = np.column_stack(list(shuffled(rows).values()))
        file["q"].attrs["joint_names"] = SHUFFLED


def name_hdf5_beside(path: Path, rows: np.ndarray) -> None:
    with pytest.importorskip("h5py").File(path, "w") as file:
        file["group/q"] = np.column_stack(list(shuffled(rows).values()))
        file["group/joint_names"] = SHUFFLED


def name_csv_comment(path: Path, rows: np.ndarray) -> None:
    np.savetxt(path, rows[:, [2, 0, 1]], delimiter=",", fmt="%.17g", header="run 7\nc,a,b")


def name_hdf5_joints(path: Path, rows: np.ndarray) -> None:
    with pytest.importorskip("h5py").File(path, "w") as file:
        for name, values in shuffled(rows).items():
            file[name] = values


BY_NAME = {
    "q.npy": name_npy,
    "q.npz": name_npz,
    "q.csv": name_csv,
    "q.parquet": name_parquet,
    "q.hdf5": name_hdf5,
    "joints.hdf5": name_hdf5_joints,
    "beside.hdf5": name_hdf5_beside,
    "comment.csv": name_csv_comment,
}


@pytest.mark.filterwarnings("ignore:columns that are no joints")
@pytest.mark.parametrize("name", BY_NAME)
def test_by_name(tmp_path, rows, name):
    BY_NAME[name](tmp_path / name, rows)
    assert np.array_equal(read(tmp_path / name), rows)


@pytest.mark.parametrize("suffix", ["npz", "hdf5", "attribute.hdf5"])
@pytest.mark.parametrize("order", [("c", "a", "b"), JOINTS])
def test_joints_under_another_key_are_never_passed_over(tmp_path, rows, suffix, order):
    file = tmp_path / f"q.{suffix}"
    if suffix == "npz":
        np.savez(file, q=rows, joints=order)
    else:
        with pytest.importorskip("h5py").File(file, "w") as out:
            out["q"] = rows
            if suffix == "hdf5":
                out["joints"] = order
            else:
                out.attrs["joints"] = order
    if order == JOINTS:
        assert np.array_equal(read(file), rows)
        return
    with pytest.raises(PlannercheckError, match="names joints in 'joints', which is not read: call it 'joint_names'"):
        read(file)


def test_numbers_in_quotes_are_named(tmp_path):
    (tmp_path / "q.csv").write_text('1,2,3\n"1","2","3"\n')
    with pytest.raises(PlannercheckError, match="row 1 must have 3 numbers, without quotes, not"):
        read(tmp_path / "q.csv")


def test_other_names_for_the_joints(tmp_path, rows):
    name_csv(tmp_path / "q.csv", rows)
    with pytest.warns(RuntimeWarning, match="left out: time"):
        assert np.array_equal(read(tmp_path / "q.csv", Columns(("x", "y", "z"), 3, named=JOINTS)), rows)
    with pytest.raises(PlannercheckError, match=r"no column for joint 'd'; its header is c, time, a, b; --columns"):
        read(tmp_path / "q.csv", Columns(("a", "b", "d"), 3))
    with pytest.raises(PlannercheckError, match=r"neither numbers nor names of joints: 'c, time, a, b'; write decimal"):
        read(tmp_path / "q.csv", Columns(("x", "y", "z"), 3))
    with pytest.raises(PlannercheckError, match="--columns must name 7 columns"):
        columns_of(Robot.load("panda"), named=JOINTS)


def test_a_column_of_a_held_joint_is_not_left_out_in_silence(tmp_path):
    robot = Robot.load("panda")
    names = (*robot.joint_names, "panda_finger_joint1")
    (tmp_path / "q.csv").write_text(",".join(names) + "\n" + ",".join("0" * 8) + "\n")
    with pytest.raises(PlannercheckError, match="'panda_finger_joint1' is of a joint that is held"):
        list(read_sets([tmp_path / "q.csv"], columns_of(robot)))
    columns = columns_of(robot, ignored=["panda_finger_joint1"])
    assert next(read_sets([tmp_path / "q.csv"], columns)).rows.tolist() == [[0.0] * 7]


def test_a_column_that_is_there_twice_is_refused():
    for header in (["a", "b", "a"], ["b", "a", "a"]):
        with pytest.raises(PlannercheckError, match="2 columns named 'a'"):
            Columns(("a", "b"), 2).places(header)
    assert Columns(("a", "b"), 2).places(["b", "a"]) == [1, 0]


def test_which_numbers_are_angles():
    assert angle_columns(Robot.load("panda")).tolist() == [True] * 7
    hand = Robot.load("panda").with_group(["panda_joint1", "panda_finger_joint1"])
    assert angle_columns(hand).tolist() == [True, False]
    assert angle_columns(PlanarRobot.load("truck_trailer"))[:3].tolist() == [False, False, True]


def test_degrees(tmp_path, rows):
    np.save(tmp_path / "q.npy", rows)
    columns = Columns(JOINTS, 3, degrees=np.array([True, False, True]))
    expected = np.column_stack([np.deg2rad(rows[:, 0]), rows[:, 1], np.deg2rad(rows[:, 2])])
    assert np.array_equal(read(tmp_path / "q.npy", columns), expected)


class Trickle(io.RawIOBase):
    """A pipe whose writer is slow: a few bytes come at a time."""

    def __init__(self, content: bytes) -> None:
        self._content = io.BytesIO(content)

    def readable(self) -> bool:
        return True

    def readinto(self, buffer) -> int:
        part = self._content.read(min(5, len(buffer)))
        buffer[: len(part)] = part
        return len(part)


def standard_input(monkeypatch: pytest.MonkeyPatch, content: bytes) -> np.ndarray:
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BufferedReader(Trickle(content))))
    return np.concatenate([chunk.rows for chunk in read_sets([STANDARD_INPUT], Columns(JOINTS, 3), size=7)])


@pytest.mark.parametrize("name", ["q.npy", "q.csv"])
@pytest.mark.parametrize("order", ["C", "F"])
def test_standard_input(tmp_path, monkeypatch, rows, name, order):
    BY_POSITION[name](tmp_path / name, np.asarray(rows, order=order))
    content = (tmp_path / name).read_bytes()
    assert np.array_equal(standard_input(monkeypatch, content), rows)
    if name == "q.npy":
        with pytest.raises(PlannercheckError, match="standard input: is cut short: 80 bytes are missing"):
            standard_input(monkeypatch, content[:-80])


@pytest.mark.parametrize("order", ["C", "F"])
def test_what_is_behind_an_array_is_not_passed_over(tmp_path, monkeypatch, rows, order):
    with (tmp_path / "q.npy").open("wb") as file:
        for _ in range(2):
            np.save(file, np.asarray(rows, order=order))
    with pytest.raises(PlannercheckError, match=r"q.npy.*holds more behind its array"):
        read(tmp_path / "q.npy")
    with pytest.raises(PlannercheckError, match="standard input: holds more behind its array"):
        standard_input(monkeypatch, (tmp_path / "q.npy").read_bytes())


def test_what_standard_input_cannot_be(tmp_path, monkeypatch, rows):
    write_npz(tmp_path / "q.npz", rows)
    with pytest.raises(PlannercheckError, match="holds npz, which can't be read as a stream"):
        standard_input(monkeypatch, (tmp_path / "q.npz").read_bytes())
    with pytest.raises(PlannercheckError, match="only once"):
        list(read_sets([STANDARD_INPUT, STANDARD_INPUT], Columns(JOINTS, 3)))


@pytest.mark.parametrize("name", ["q.parquet", "q.h5", "q.npz"])
@pytest.mark.parametrize("kept", [0, 3, 0.3, 0.9])
def test_truncated_files(tmp_path, rows, name, kept):
    BY_POSITION[name](tmp_path / name, np.tile(rows, (40, 1)))
    content = (tmp_path / name).read_bytes()
    (tmp_path / name).write_bytes(content[: int(kept if kept >= 1 else kept * len(content))])
    with pytest.raises(PlannercheckError, match=rf"{name}.*is no whole"):
        read(tmp_path / name)


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({"q": [[1.0, 2.0, 3.0], [1.0, 2.0]]}, "row 1 must have 3 numbers, not 2"),
        ({"q": [[1.0, 2.0, 3.0], None]}, "row 1 must have 3 numbers, not nothing"),
        ({"q": [[1.0, 2.0, 3.0], [1.0, None, 2.0]]}, "row 1 has no number in the column of lists"),
        ({"a": [0.0, 1.0], "b": [0.0, None], "c": [0.0, 1.0]}, "row 1 has no number in column 'b'"),
        ({"a": [0.0], "b": ["x"], "c": [0.0]}, "column 'b' must hold real numbers, not string"),
        ({"a": [0.0], "B": [0.0], "c": [0.0]}, r"no column for joint 'b'"),
        ({"x": [[1.0] * 3], "y": [[2.0] * 3]}, "must hold one column of lists, or one named q or configurations"),
    ],
)
def test_bad_parquet(tmp_path, columns, message):
    arrow, parquet = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    parquet.write_table(arrow.table(columns), tmp_path / "q.parquet")
    with pytest.raises(PlannercheckError, match=message):
        read(tmp_path / "q.parquet")


def test_a_folder_of_parquet_files(tmp_path, rows):
    for first in (0, 10, 20):
        write_parquet(tmp_path / f"part-{first}.{'pq' if first else 'parquet'}", rows[first : first + 10])
    files = files_of([tmp_path, tmp_path / "other.npy"])
    assert [path.name for path in files] == ["part-0.parquet", "part-10.pq", "part-20.pq", "other.npy"]
    chunks = list(read_sets(files[:3], Columns(JOINTS, 3)))
    assert [chunk.file for chunk in chunks] == [0, 1, 2]
    assert np.array_equal(np.concatenate([chunk.rows for chunk in chunks]), rows)


@pytest.mark.parametrize("name", ["q.npz", "q.h5", "q.parquet"])
def test_a_key_says_which_of_several(tmp_path, rows, name):
    path = tmp_path / name
    if name == "q.npz":
        np.savez(path, first=rows, second=-rows)
    elif name == "q.h5":
        with pytest.importorskip("h5py").File(path, "w") as file:
            file["first"], file["second"] = rows, -rows
    else:
        table = pytest.importorskip("pyarrow").table({"first": list(rows), "second": list(-rows)})
        pytest.importorskip("pyarrow.parquet").write_table(table, path)
    assert np.array_equal(read(path, key="second"), -rows)
    for key, message in ((None, "--key says which"), ("third", "'third'; it holds first, second")):
        with pytest.raises(PlannercheckError, match=message):
            read(path, key=key)


def test_a_missing_library_is_named_with_the_command_that_installs_it():
    with pytest.raises(
        PlannercheckError, match=r"parquet files need no_such_library.*pip install 'plannercheck\[pq\]'"
    ):
        extra_module("no_such_library.parquet", "pq", "parquet files")


MEMORY = """
import resource, sys
from pathlib import Path
from plannercheck.validation.formats.chunks import read_sets
from plannercheck.validation.formats.columns import Columns
for path in map(Path, sys.argv[2:]):  # the first one is small: what is imported late counts for nothing
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    rows = sum(len(chunk.rows) for chunk in read_sets([path], Columns(tuple("abcdefg"), 7)))
    grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024
    assert rows == int(sys.argv[1]) or path.stem == "small", (path, rows)
    assert grown < 50 or path.stem == "small", f"{path.name}: {grown} MB"
"""


def test_memory_is_bounded(tmp_path):
    """Files of 112 MB (most of them sparse or compressed) are read in less than 50 MB."""
    arrow, parquet = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    count = 2_000_000
    np.lib.format.open_memmap(tmp_path / "q.npy", mode="w+", shape=(count, 7), dtype=np.float64)
    np.lib.format.open_memmap(tmp_path / "f.npy", mode="w+", shape=(count, 7), dtype=np.float64, fortran_order=True)
    np.savez_compressed(tmp_path / "q.npz", np.zeros((count, 7), dtype=np.int8))
    for name, rows in (("small", 10), ("q", count)):
        table = arrow.table({joint: np.zeros(rows) for joint in "abcdefg"})
        parquet.write_table(table, tmp_path / f"{name}.parquet", row_group_size=rows)
    names = ("small.parquet", "q.npy", "f.npy", "q.npz", "q.parquet")
    command = [sys.executable, "-c", MEMORY, str(count), *(str(tmp_path / name) for name in names)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
