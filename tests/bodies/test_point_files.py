"""Files of points: those of PCL, Open3D, plyfile and numpy as these read them; cut short, damaged or lying."""

import resource
import struct
import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from sensed_files import FOLDER, clouds, listed_points

import plannercheck as pc
from plannercheck.bodies.lzf import unpacked
from plannercheck.bodies.point_files import points_of_file
from plannercheck.common.input_limits import INPUT_LIMITS

CLOUDS = clouds()
# PCL's readers take numbers of text as floats where the header says so; here, and in Open3D, they are doubles.
AS_FLOATS = ("pcl_ascii.ply", "pcl_grid_ascii.ply", "pcl_coloured_ascii.pcd", "pcl_plain_ascii.pcd")
# One file of each encoding, the smallest that the libraries wrote.
SMALL = [
    *("open3d_rich_ascii.pcd", "open3d_plain_binary.pcd", "open3d_rich_packed.pcd", "pcl_doubles_ascii.pcd"),
    *("open3d_plain_ascii.ply", "open3d_mesh.ply", "plyfile_little.ply", "plyfile_big.ply", "pcl_grid_binary.ply"),
]

pytestmark = pytest.mark.filterwarnings("ignore:cloud file .* has a VIEWPOINT")


@pytest.mark.parametrize("name", CLOUDS)
def test_points_are_those_that_the_library_reads(name: str) -> None:
    listed, points = listed_points(name), points_of_file(FOLDER / name)
    if "grid" in name:  # the file has the points that there are; PCL puts them back into their scan
        assert np.isnan(listed).any()
        listed = listed[~np.isnan(listed).any(axis=1)]
    if name in AS_FLOATS:
        points = points.astype(np.float32).astype(np.float64)
    assert points.shape == listed.shape
    assert np.array_equal(points, listed, equal_nan=True)
    cloud = pc.PointCloud.load(FOLDER / name, 0.01, invalid="drop")
    assert cloud.dropped == np.count_nonzero(np.isnan(listed).any(axis=1))
    if cloud.dropped:
        with pytest.raises(pc.PlannercheckError, match=f'{cloud.dropped - 1} more are so: .* invalid="drop"'):
            pc.PointCloud.load(FOLDER / name, 0.01)


def test_one_cloud_is_the_same_in_all_encodings() -> None:
    for stem in ("pcl_coloured", "pcl_plain", "open3d_plain", "open3d_rich"):
        binary, packed = (points_of_file(FOLDER / f"{stem}_{kind}.pcd") for kind in ("binary", "packed"))
        text = points_of_file(FOLDER / f"{stem}_ascii.pcd").astype(np.float32)
        assert np.array_equal(binary, packed, equal_nan=True)
        assert np.array_equal(binary, text, equal_nan=True)


@pytest.mark.parametrize("name", ["pcl_doubles_ascii.pcd", "open3d_plain_ascii.ply"])
def test_underscores_are_part_of_no_number(tmp_path: Path, name: str) -> None:
    head, _, rest = (FOLDER / name).read_text().rstrip("\n").rpartition("\n")
    (tmp_path / name).write_text(f"{head}\n1_0{rest[rest.index(' ') :]}\n")
    with pytest.raises(pc.PlannercheckError, match="1_0"):
        points_of_file(tmp_path / name)


def test_a_viewpoint_is_told() -> None:
    with pytest.warns(RuntimeWarning, match="VIEWPOINT"):
        points_of_file(FOLDER / "pcl_moved.pcd")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        points_of_file(FOLDER / "pcl_plain_binary.pcd")


@pytest.mark.parametrize("name", SMALL)
def test_a_file_cut_short_anywhere_is_refused(name: str, tmp_path: Path) -> None:
    content, path = (FOLDER / name).read_bytes(), tmp_path / name
    for size in range(len(content)):
        path.write_bytes(content[:size])
        with pytest.raises(pc.PlannercheckError, match="cloud file"):
            points_of_file(path)


def test_a_page_that_pcl_has_reserved_may_be_cut(tmp_path: Path) -> None:
    """After the points are zeros, as many as the header is shorter than a page: only they may be missing."""
    for name in ("pcl_doubles_binary.pcd", "pcl_doubles_packed.pcd"):
        content, path, read = (FOLDER / name).read_bytes(), tmp_path / name, 0
        for size in [*range(1, 700), len(content) - 1]:
            path.write_bytes(content[:size])
            try:
                assert np.array_equal(points_of_file(path), listed_points(name))
                assert not any(content[size:])
                read += 1
            except pc.PlannercheckError:
                pass
        assert 100 < read < 500
        for wrong in (content[:-1] + b"\1", content + bytes(1 << 16)):
            path.write_bytes(wrong)
            with pytest.raises(pc.PlannercheckError, match="cut short or broken"):
                points_of_file(path)


@pytest.mark.parametrize("name", SMALL)
def test_what_follows_the_points_is_refused(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_bytes((FOLDER / name).read_bytes() + b"1 2 3\n")
    with pytest.raises(pc.PlannercheckError, match="cloud file"):
        points_of_file(path)


@pytest.mark.parametrize("name", [*SMALL, "pcl_coloured_packed.pcd", "open3d.xyz"])
def test_flipped_bits_give_other_points_or_an_error(name: str, tmp_path: Path) -> None:
    content, path = (FOLDER / name).read_bytes(), tmp_path / name
    rng, said = np.random.default_rng(6), set()
    for _ in range(150):
        data = bytearray(content)
        for place in rng.integers(min(len(data), 700), size=int(rng.integers(1, 4))):
            data[place] ^= 1 << int(rng.integers(8))
        path.write_bytes(data)
        try:
            cloud = pc.PointCloud.load(path, 0.1, invalid="drop")
        except pc.PlannercheckError as error:
            said.add(str(error))
        else:
            assert len(cloud.points) + cloud.dropped <= len(content)
    assert all(str(path) in words for words in said)
    assert len(said) > 5


@pytest.fixture
def little_memory() -> Iterator[None]:
    """Reserving gigabytes fails, as it would without virtual memory."""
    before = resource.getrlimit(resource.RLIMIT_AS)
    with Path("/proc/self/statm").open() as pages:
        used = int(pages.read().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + (1 << 29), before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_AS, before)


PCD = {
    **{"FIELDS": "x y z", "SIZE": "4 4 4", "TYPE": "F F F", "COUNT": "1 1 1", "WIDTH": "2", "HEIGHT": "1"},
    **{"VIEWPOINT": "0 0 0 1 0 0 0", "POINTS": "2", "DATA": "ascii"},
}
TWO = struct.pack("<6f", *range(6))


def pcd(body: bytes, **words: str | None) -> bytes:
    return "".join(f"{key} {word}\n" for key, word in {**PCD, **words}.items() if word is not None).encode() + body


@pytest.mark.parametrize("count", ["0", "1", "3", "4", "1000000000", "999999999999999", "9" * 300])
@pytest.mark.parametrize("encoding", ["ascii", "binary", "binary_compressed"])
def test_pcd_headers_that_lie_about_the_points(count: str, encoding: str, tmp_path: Path, little_memory: None) -> None:
    path = tmp_path / "c.pcd"
    packed = b"\x17" + struct.pack("<6f", 0, 3, 1, 4, 2, 5)  # field after field
    body = {"ascii": b"0 1 2\n3 4 5\n", "binary": TWO}.get(encoding, struct.pack("<II", len(packed), 24) + packed)
    path.write_bytes(pcd(body, DATA=encoding))
    assert points_of_file(path).tolist() == [[0, 1, 2], [3, 4, 5]]
    for words in ({"POINTS": count}, {"WIDTH": count}, {"WIDTH": count, "POINTS": count}, {"HEIGHT": count}):
        if words == {"HEIGHT": "1"}:
            continue
        path.write_bytes(pcd(body, **{"DATA": encoding, **words}))
        with pytest.raises(pc.PlannercheckError, match="cloud file"):
            points_of_file(path)
    for key in ("SIZE", "COUNT"):
        path.write_bytes(pcd(body, **{"DATA": encoding, key: f"4 {count} 4"}))
        if (key, count) == ("COUNT", "1") or (key, encoding, count) == ("SIZE", "ascii", "4"):
            continue
        if (key, count) == ("SIZE", "4"):
            assert len(points_of_file(path)) == 2
            continue
        with pytest.raises(pc.PlannercheckError, match="cloud file"):
            points_of_file(path)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ({"SIZE": "4 4"}, "3 FIELDS, but 2 entries of SIZE"),
        ({"TYPE": "F F X"}, "TYPE 'X' of SIZE 4|TYPE X of SIZE 4"),
        ({"TYPE": "F F F F"}, "3 FIELDS, but 4 entries of TYPE"),
        ({"SIZE": "4 4 0"}, "of SIZE 0"),
        ({"SIZE": "4 4 3"}, "of SIZE 3"),
        ({"SIZE": "4 4 -4"}, "must be a whole number"),
        ({"COUNT": "1 1 2"}, "one field 'z' of COUNT 1"),
        ({"FIELDS": "x y y"}, "one field 'y'"),
        ({"FIELDS": "x y w"}, "one field 'z'"),
        ({"DATA": "other"}, "valid are ascii, binary, binary_compressed"),
        ({"DATA": ""}, "valid are ascii, binary, binary_compressed"),
        ({"WIDTH": None, "POINTS": None}, "neither POINTS nor WIDTH"),
        ({"WIDTH": "-2"}, "must be a whole number"),
        ({"WIDTH": "1 2"}, "must be one number"),
        ({"VIEWPOINT": "0 0 0"}, "seven numbers"),
        ({"VIEWPOINT": "0 0 0 nan 0 0 0"}, "seven numbers"),
        ({"OTHER": "1"}, "DATA|OTHER"),
    ],
)
def test_pcd_headers_that_contradict_themselves(words: dict[str, str | None], said: str, tmp_path: Path) -> None:
    path = tmp_path / "c.pcd"
    content = pcd(b"0 1 2\n3 4 5\n", **words)
    path.write_bytes(content if "OTHER" not in words else b"OTHER 1\n" + content)
    with pytest.raises(pc.PlannercheckError, match=said):
        points_of_file(path)


def test_counts_of_fields_beyond_all_integers(tmp_path: Path, little_memory: None) -> None:
    path, many = tmp_path / "c.pcd", 2500
    words = {"FIELDS": "x y z" + " f" * many, "SIZE": "4 4 4" + " 8" * many, "TYPE": "F F F" + " F" * many}
    for encoding in ("binary", "binary_compressed"):
        for points in ("0", "1"):
            count = "1 1 1" + " 999999999999999" * many
            path.write_bytes(pcd(bytes(8), **words, COUNT=count, WIDTH=points, POINTS=points, DATA=encoding))
            if points == "0":
                assert points_of_file(path).shape == (0, 3)
            else:
                with pytest.raises(pc.PlannercheckError, match="1 points"):
                    points_of_file(path)


@pytest.mark.parametrize(
    "packed",
    [b"\x05abc", b"\xff", b"\x20", b"\x20\x00", b"\x00a\x3f", b"\x00a\xe0\xff", b"\x00a\x20\x05", b"\xe0\xff\x00"],
)
def test_packed_bytes_that_end_or_copy_what_is_not_there(packed: bytes) -> None:
    with pytest.raises(pc.PlannercheckError, match="packed data is broken"):
        unpacked(packed, 300)


def test_packed_bytes_unpack_to_no_more_than_they_say() -> None:
    bomb = b"\x00a" + b"\xe0\xff\x00" * 1_000_000
    with pytest.raises(pc.PlannercheckError, match="does not unpack to 1000 bytes"):
        unpacked(bomb, 1000)


def ply(lines: str, body: bytes, form: str = "ascii") -> bytes:
    return f"ply\nformat {form} 1.0\n{lines}end_header\n".encode() + body


VERTEX = "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n"


@pytest.mark.parametrize("count", ["0", "1", "3", "1000000000", "999999999999999", "9" * 300, "-2", "x"])
@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_ply_headers_that_lie_about_the_points(count: str, form: str, tmp_path: Path, little_memory: None) -> None:
    path = tmp_path / "c.ply"
    order = ">" if "big" in form else "<"
    body = b"0 1 2\n3 4 5\n" if form == "ascii" else struct.pack(f"{order}6f", *range(6))
    path.write_bytes(ply(VERTEX.format(2), body, form))
    assert points_of_file(path).tolist() == [[0, 1, 2], [3, 4, 5]]
    path.write_bytes(ply(VERTEX.format(count), body, form))
    with pytest.raises(pc.PlannercheckError, match="cloud file"):
        points_of_file(path)
    for others in (f"element face {count}\n", f"element face {count}\nproperty list uchar int vertex_indices\n"):
        path.write_bytes(ply(VERTEX.format(2) + others, body, form))
        if count == "0" or (form != "ascii" and count.isdecimal() and len(count) < 16 and "list" not in others):
            assert len(points_of_file(path)) == 2  # rows without properties take no bytes
        else:
            with pytest.raises(pc.PlannercheckError, match="cloud file"):
                points_of_file(path)


def test_lists_that_are_longer_than_the_file(tmp_path: Path, little_memory: None) -> None:
    lines = VERTEX.format(1) + "element face 1\nproperty list uint double vertex_indices\n"
    path = tmp_path / "c.ply"
    path.write_bytes(ply(lines, bytes(12) + struct.pack("<I", 0xFFFFFFF0), "binary_little_endian"))
    with pytest.raises(pc.PlannercheckError, match="a list of 4294967280 numbers"):
        points_of_file(path)


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        ("element point 2\nproperty float x\n", "one element 'vertex' with x, y and z"),
        ("element other 0\n" + VERTEX.format(2), "'vertex' as its first element"),
        (VERTEX.format(2) + "property list uchar int k\n", "without lists"),
        (VERTEX.format(2) + "property float x\n", "twice"),
        (VERTEX.format(2) + "property half w\n", "property 'half w'"),
        ("property float x\n" + VERTEX.format(2), "line 'property float x'"),
    ],
)
def test_ply_files_of_other_things(lines: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "c.ply"
    path.write_bytes(ply(lines, b"0 1 2\n3 4 5\n" if "other" in lines else b"0 1 2 0\n3 4 5 0\n"))
    with pytest.raises(pc.PlannercheckError, match=said):
        points_of_file(path)


POINTS = np.random.default_rng(3).normal(size=(6, 3))


def records(kind: str = "f8") -> np.ndarray:
    table = np.zeros(6, dtype=[("z", kind), ("ring", "u2"), ("x", kind), ("y", kind)])
    for axis in range(3):
        table["xyz"[axis]] = POINTS[:, axis]
    return table


@pytest.mark.parametrize(
    "array",
    [
        POINTS,
        np.asfortranarray(POINTS),
        POINTS.astype(">f8"),
        POINTS.astype("<f4"),
        POINTS.reshape(2, 3, 3),
        (POINTS * 100).astype(np.int16),
        records(),
        records(">f4"),
        POINTS[:0],
    ],
)
def test_arrays_of_numpy(array: np.ndarray, tmp_path: Path) -> None:
    expected = array if array.dtype.names is None else np.stack([array[axis] for axis in "xyz"], axis=-1)
    expected = expected.astype(np.float64).reshape(-1, 3)
    for name in ("c.npy", "c.npz", "packed.npz"):
        path = tmp_path / name
        {"c.npy": np.save, "c.npz": np.savez}.get(name, np.savez_compressed)(path, array)
        assert np.array_equal(points_of_file(path), expected)


@pytest.mark.parametrize("name", ["c.npy", "c.npz", "packed.npz"])
def test_arrays_cut_short_anywhere_are_refused(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    {"c.npy": np.save, "c.npz": np.savez}.get(name, np.savez_compressed)(path, POINTS)
    content = path.read_bytes()
    for size in range(len(content)):
        path.write_bytes(content[:size])
        with pytest.raises(pc.PlannercheckError, match="cloud file"):
            points_of_file(path)


@pytest.mark.parametrize(
    "array",
    [
        POINTS[:, :2],
        POINTS[0],
        POINTS * 1j,
        POINTS > 0,
        np.array(["a", "b", "c"]),
        POINTS.astype("M8[s]"),
        POINTS[None, None],
    ],
)
def test_arrays_that_are_no_points(array: np.ndarray, tmp_path: Path) -> None:
    np.save(tmp_path / "c.npy", array)
    with pytest.raises(pc.PlannercheckError, match="must have numbers of shape"):
        points_of_file(tmp_path / "c.npy")


def test_npy_headers_that_lie_and_archives_that_unpack_to_gigabytes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, little_memory: None
) -> None:
    npy, npz = tmp_path / "c.npy", tmp_path / "c.npz"
    np.save(npy, POINTS)
    content = npy.read_bytes()
    npy.write_bytes(content.replace(b"(6, 3), }      ", b"(666666666, 3),}"[:15]))
    assert npy.read_bytes() != content
    with pytest.raises(pc.PlannercheckError, match="cloud file"):
        points_of_file(npy)
    np.savez_compressed(npz, points=np.zeros((100_000, 3)))
    assert points_of_file(npz).shape == (100_000, 3)
    monkeypatch.setattr(INPUT_LIMITS, "archive_bytes", 1_000_000)
    with pytest.raises(pc.PlannercheckError, match=r"unpacks to 2400128 bytes, more than INPUT_LIMITS\.archive_bytes"):
        points_of_file(npz)


def test_files_under_another_name(tmp_path: Path) -> None:
    np.save(tmp_path / "c.npy", POINTS)
    np.savez(tmp_path / "d.npz", points=POINTS, colours=POINTS)
    assert np.array_equal(points_of_file(tmp_path / "d.npz"), POINTS)
    for source, name in (
        ("c.npy", "e.npz"),
        ("d.npz", "f.npy"),
        ("c.npy", "g.pcd"),
        ("c.npy", "h.ply"),
        ("c.npy", "i.csv"),
    ):
        (tmp_path / name).write_bytes((tmp_path / source).read_bytes())
        with pytest.raises(pc.PlannercheckError, match=f"cloud file '.*{name}'"):
            points_of_file(tmp_path / name)
    for name in ("c.abc", "c", "missing.ply"):
        with pytest.raises(pc.PlannercheckError, match="cloud file"):
            points_of_file(tmp_path / name)
    (tmp_path / "folder.npy").mkdir()
    with pytest.raises(pc.PlannercheckError, match="cloud file"):
        points_of_file(tmp_path / "folder.npy")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("1 2 3\n4 5\n", "line 2 has 2 columns, the lines before have 3"),
        ("1 2 3\n4 5 6 7\n", "line 2 has 4 columns"),
        ("1 2\n", "line 1 is '1 2', it must be numbers, with x, y and z first"),
        ("1 2 3_0\n", "line 1 is '1 2 3_0', it must be numbers"),
        ("a,b,c\n1,2,3\n", "line 1 is 'a,b,c', it must begin with x, y and z, or name each of them once"),
        ("x (mm),y (mm),z (mm)\n1,2,3\n", "line 1 .* or name each of them once, as a heading in m"),
        ("x,y,z,x\n1,2,3,4\n", "line 1 .* as a heading"),
        ("1 2 3\nx,y,z\n", "line 2 is 'x,y,z', it must be numbers"),
        ("x,y,z\n1,2,3,4\n", "line 2 has 4 columns, the lines before have 3"),
        ("1,5;2,0;3,5\n", "line 1 is '1,5;2,0;3,5': decimal commas are not read"),
        ("1,5 2,0 3,5\n", "decimal commas are not read"),
        ("0,5;1;2\n", "line 1 is '0,5;1;2': decimal commas are not read"),
        ("0,5 1 2\n", "decimal commas are not read"),
        ("1;2,5;3\n", "decimal commas are not read"),
        ("# x [mm], y [mm], z [mm]\n0,0,500\n", "line 1 is 'x .mm., y .mm., z .mm.': points must be in m"),
        ("# z [cm] y [cm] x [cm]\n0 0 500\n", "points must be in m"),
        ("// x y z (mm)\n0 0 500\n", "points must be in m"),
        ("3\n1 2 3\n4 5 6\n", "is cut short: its count says 1 more points"),
        ("1\n1 2 3\n4 5 6\n", "line 3 is one point more than the count says"),
        ("version: 1\nn_points: 2\n{\n1 2\n3 4\n}\n", "line 1 is 'version: 1'"),
        ("1 2 3\n4 5 6", None),
        ("# comment\n\n1, 2, 3\n4; 5; 6\n", None),
        ("x,y,z\n1,2,3\n4,5,6\n", None),
        ("\ufeffX;Y;Z;label\n1;2;3;0\n4;5;6;0\n", None),
        ('"x [m]","y [m]","z [m]"\n1,2,3\n4,5,6\n', None),
        ("time,z,y,x\n0,3,2,1\n1,6,5,4\n", None),
        ("//X Y Z R G B\n1 2 3 0 0 0\n4 5 6 0 0 0\n", None),
        ("// made by a scanner\n2\n1 2 3 -900 0 0 0\n4 5 6 -900 0 0 0\n", None),
        ("1\n1 2 3\n1\n4 5 6\n", None),
        ("# z y x\n3 2 1\n6 5 4\n", None),
        ("# z [m] y [m] x [m]\n3 2 1\n6 5 4\n", None),
        ("# x, y, z, range [mm]\n1,2,3,4\n4,5,6,4\n", None),
        ("# x y z (of the scanner)\n1, 2,3\n4, 5,6\n", None),
        ("# the order is z y x\n1 2 3\n4 5 6\n", None),
        ("", None),
    ],
)
@pytest.mark.parametrize("suffix", ["csv", "txt", "xyz", "pts"])
def test_text(text: str, said: str | None, suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"c.{suffix}"
    path.write_text(text, encoding="utf-8")
    if said is None:
        assert points_of_file(path).tolist() == ([[1, 2, 3], [4, 5, 6]] if text else [])
    else:
        with pytest.raises(pc.PlannercheckError, match=said):
            points_of_file(path)


@pytest.mark.parametrize("shape", [(5, 4), (5, 6), (4, 5, 4)])
@pytest.mark.parametrize("suffix", ["npy", "npz"])
def test_arrays_with_more_columns_say_which_to_save(shape: tuple[int, ...], suffix: str, tmp_path: Path) -> None:
    array, path = np.arange(np.prod(shape), dtype=float).reshape(shape), tmp_path / f"c.{suffix}"
    {"npy": np.save, "npz": np.savez}[suffix](path, array)
    with pytest.raises(pc.PlannercheckError, match=r"save array\[\.\.\., :3\] if x, y and z are its first columns"):
        points_of_file(path)
    np.save(tmp_path / "d.npy", array[..., :3])
    assert np.array_equal(points_of_file(tmp_path / "d.npy"), array[..., :3].reshape(-1, 3))
