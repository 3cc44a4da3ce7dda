"""Maps of the OctoMap library: the cells that it lists itself, files that are cut short or damaged, and saved maps."""

import itertools
import re
import struct
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sensed_files import FOLDER, listed_map, octomaps, saved_octrees

import plannercheck as pc
from plannercheck.bodies import unknown_cells as unknown
from plannercheck.bodies.octomap_files import leaves_of_data, morton_codes, read_octomap
from plannercheck.bodies.unknown_cells import unknown_cells

MAPS = octomaps()
SMALL = [name for name in MAPS if (FOLDER / name).stat().st_size < 700]
WITH_BOX = [name for name in MAPS if listed_map(name).states.size]


def data_of(name: str) -> bytes:
    content = (FOLDER / name).read_bytes()
    return content[content.index(b"\ndata\n") + 6 :]


def rows_of(octree: pc.Octree) -> list[tuple[int, ...]]:
    return sorted((*key, size, bool(on)) for key, size, on in zip(*map(np.ndarray.tolist, parts(octree)), strict=True))


def parts(octree: pc.Octree) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return octree.keys, octree.sizes, octree.occupied


@pytest.mark.parametrize("name", MAPS)
def test_leaves_are_those_that_octomap_lists(name: str) -> None:
    listed, leaves = listed_map(name), read_octomap((FOLDER / name).read_bytes())
    assert leaves.resolution == listed.resolution
    ours = np.column_stack([leaves.keys, leaves.sizes])
    assert len(ours) == len(listed.rows)
    order, others = np.lexsort(ours.T), np.lexsort(listed.rows.T)
    assert np.array_equal(ours[order], listed.rows[others])
    assert np.array_equal(leaves.log_odds[order], listed.log_odds[others])
    for threshold, occupied in listed.occupied.items():
        octree = pc.Octree.load(FOLDER / name, threshold=threshold)
        assert rows_of(octree) == sorted(
            (*row, bool(on)) for row, on in zip(listed.rows.tolist(), occupied, strict=True)
        )
        assert octree.resolution == listed.resolution
        assert octree.count == np.count_nonzero(occupied)


def test_the_maps_have_what_maps_can_have() -> None:
    """Else the test above would say little."""
    listed = [listed_map(name) for name in MAPS]
    assert {size for each in listed for size in each.rows[:, 3].tolist()} >= {1, 2, 4, 8, 16, 32768, 65536}
    assert len({each.resolution for each in listed}) >= 6
    assert any(0.0 in each.log_odds for each in listed)
    assert {state for each in listed for state in each.states.ravel().tolist()} == {"#", ".", "?"}
    assert min(len(each.rows) for each in listed) == 0


@pytest.mark.parametrize("name", WITH_BOX)
@pytest.mark.parametrize("unknown", ["free", "occupied"])
def test_cells_are_what_a_search_of_octomap_says(name: str, unknown: str) -> None:
    listed, octree = listed_map(name), pc.Octree.load(FOLDER / name).with_unknown(unknown)  # type: ignore[arg-type]
    shape = listed.states.shape
    assert octree.unknown == unknown
    steps = np.indices(shape).reshape(3, -1).T + listed.box
    states = octree.query((steps + 0.5) * octree.resolution)
    assert np.array_equal(np.array(["?", ".", "#"])[states + 1], listed.states.ravel())
    held = np.zeros(shape, dtype=np.int64)
    for key, size in zip(*octree.cells, strict=True):
        low = key - listed.box
        held[tuple(slice(start, start + size) for start in low)] += 1
    expected = (listed.states == "#") | ((listed.states == "?") & (unknown == "occupied"))
    assert np.array_equal(held, expected.astype(int))  # each once
    around = octree.query([(listed.box - 0.5) * octree.resolution, (listed.box + shape + 0.5) * octree.resolution])
    assert (around == -1).all()


def test_a_point_is_in_the_cell_that_holds_it_exactly() -> None:
    rng = np.random.default_rng(1)
    keys = rng.integers(-40, 40, size=(500, 3))
    for resolution in (0.1, 0.05, 1 / 3, 0.7e-3):
        octree = pc.Octree.from_cells(np.unique(keys, axis=0), resolution)
        corners = octree.corners(keys)
        points = np.concatenate([corners, np.nextafter(corners, np.inf), np.nextafter(corners, -np.inf)])
        known = set(map(tuple, keys.tolist()))
        for point, state in zip(points, octree.query(points), strict=True):
            steps = []
            for value in point:  # the last step that begins at the value or before it, at the doubles that are tested
                step = int(Fraction(value) / Fraction(resolution))
                step = max(k for k in range(step - 3, step + 4) if k * resolution <= value)
                steps.append(step)
            assert state == (1 if tuple(steps) in known else -1)


@pytest.mark.parametrize("name", SMALL)
def test_a_map_cut_short_anywhere_is_refused(name: str, tmp_path: Path) -> None:
    content, path = (FOLDER / name).read_bytes(), tmp_path / name
    for size in range(len(content)):
        path.write_bytes(content[:size])
        with pytest.raises(pc.PlannercheckError, match="octomap file"):
            pc.Octree.load(path)
    for more in (b"\0", b"\n", b"\xff" * 40):
        path.write_bytes(content + more)
        with pytest.raises(pc.PlannercheckError, match="follow"):
            pc.Octree.load(path)


@pytest.mark.parametrize("name", [name for name in MAPS if name.startswith(("room", "colours", "first"))])
def test_flipped_bits_give_another_map_or_an_error(name: str, tmp_path: Path) -> None:
    content, path = (FOLDER / name).read_bytes(), tmp_path / name
    rng, said = np.random.default_rng(5), list[str]()
    for _ in range(120):
        data = bytearray(content)
        for place in rng.integers(len(data), size=int(rng.integers(1, 4))):
            data[place] ^= 1 << int(rng.integers(8))
        path.write_bytes(data)
        try:
            octree = pc.Octree.load(path)
        except pc.PlannercheckError as error:
            said.append(str(error))
        else:
            assert len(octree.digest) == 32
            assert octree.count <= len(octree.keys)
    assert all(f"octomap file {str(path)!r}" in words for words in said)
    assert 20 < len(said) < 117


HEADER = "# Octomap OcTree binary file\nid OcTree\nsize {size}\nres {res}\ndata\n"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ({"res": "0"}, "resolution is 0"),
        ({"res": "-0.1"}, "resolution is -0.1"),
        ({"res": "nan"}, "resolution is nan"),
        ({"res": "inf"}, "resolution is inf"),
        ({"res": "1e308"}, "resolution"),
        ({"res": "x"}, "res 'x'"),
        ({"res": "0.1 0.2"}, "line 'res 0.1 0.2'"),
        ({"size": "2"}, "2 nodes, but its tree has 4"),
        ({"size": "999999999999999"}, "999999999999999 nodes, but its tree has 4"),
        ({"size": "9" * 400}, "must be a number of nodes"),
        ({"size": "-4"}, "must be a number of nodes"),
        ({"size": "0"}, "no nodes, but data follows"),
    ],
)
def test_headers_that_lie(words: dict[str, str], said: str, tmp_path: Path) -> None:
    path, data = tmp_path / "m.bt", bytes([0b10010010, 0])
    path.write_bytes(HEADER.format(**{"size": "4", "res": "0.1"}).encode() + data)
    assert pc.Octree.load(path).count == 2
    path.write_bytes(HEADER.format(**{"size": "4", "res": "0.1", **words}).encode() + data)
    with pytest.raises(pc.PlannercheckError, match=said):
        pc.Octree.load(path)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "no octomap"),
        (b"ply\n", "no octomap"),
        (b"# Octomap OcTree file\nid CountingOcTree\nsize 1\nres 1\ndata\n\0\0\0\0\0", "type of octree"),
        (b"# Octomap OcTree file\nsize 1\nres 1\ndata\n\0\0\0\0\0", "does not say 'id'"),
        (b"# Octomap OcTree file\nid OcTree\nid OcTree\nsize 1\nres 1\ndata\n\0\0\0\0\0", "line 'id OcTree'"),
        (b"# Octomap OcTree file\nid OcTree\nsize 1\nres 1\ndata\n\0\0\xc0\x7f\0", "no number"),
        (
            b"# Octomap OcTree file\nid OcTree\nsize 18\nres 1\ndata\n" + b"\0\0\0\0\1" * 17 + b"\0" * 5,
            "deeper than 16",
        ),
        (b"# Octomap OcTree binary file\nid OcTree\nsize 2\nres 1\ndata\n\3\0\0\0", "without children"),
        (struct.pack("<idI", 3, 0.0, 4) + bytes([0b10010010, 0]), "resolution is 0"),
        (struct.pack("<idI", 4, 0.1, 4) + bytes([0b10010010, 0]), "no octomap"),
    ],
)
def test_what_is_no_map(content: bytes, said: str, tmp_path: Path) -> None:
    path = tmp_path / "m.bt"
    path.write_bytes(content)
    with pytest.raises(pc.PlannercheckError, match=said):
        pc.Octree.load(path)
    with pytest.raises(pc.PlannercheckError, match="does not exist"):
        pc.Octree.load(tmp_path / "other.bt")


def test_the_deepest_tree_is_read() -> None:
    header = b"# Octomap OcTree file\nid OcTree\nsize 17\nres 1\ndata\n"
    leaves = read_octomap(header + b"\0\0\0\0\1" * 16 + b"\0\0\0\0\0")
    assert (leaves.keys.tolist(), leaves.sizes.tolist()) == ([[-32768] * 3], [1])


@pytest.mark.parametrize("name", [name for name in MAPS if not name.startswith("first")])
def test_a_message_has_the_cells_of_the_file(name: str) -> None:
    loaded = pc.Octree.load(FOLDER / name)
    kind = {"colours": "ColorOcTree", "stamped": "OcTreeStamped"}.get(name[:7], "OcTree")
    octree = pc.Octree.from_message(data_of(name), kind, name.endswith(".bt"), loaded.resolution)
    assert rows_of(octree) == rows_of(loaded)
    assert octree.digest == loaded.digest


def test_messages_that_are_none() -> None:
    data = data_of("room.bt")
    for wrong in (0.0, -1.0, np.nan, "x", None):
        with pytest.raises(pc.PlannercheckError, match="resolution"):
            pc.Octree.from_message(data, "OcTree", True, wrong)  # type: ignore[arg-type]
    for threshold in (0.0, 1.0, -1, 2, np.nan, "x"):
        with pytest.raises(pc.PlannercheckError, match="threshold"):
            pc.Octree.from_message(data, "OcTree", True, 0.1, threshold=threshold)  # type: ignore[arg-type]
    with pytest.raises(pc.PlannercheckError, match="type of octree"):
        pc.Octree.from_message(data, "OcTre", True, 0.1)
    with pytest.raises(pc.PlannercheckError):
        pc.Octree.from_message(data[:-1], "OcTree", True, 0.1)
    assert pc.Octree.from_message(b"", "OcTree", True, 0.1).count == 0
    assert len(leaves_of_data(b"", "ColorOcTree", False, 0.1).sizes) == 0


@pytest.mark.parametrize("name", [name for name in MAPS if name.startswith("saved")])
def test_octomap_reads_what_is_saved(name: str, tmp_path: Path) -> None:
    """The file is the one from which OctoMap listed these cells."""
    octree = saved_octrees()[name]
    octree.save(tmp_path / name)
    assert (tmp_path / name).read_bytes() == (FOLDER / name).read_bytes()
    listed = listed_map(name)
    if name == "saved_whole.bt":  # the format has no leaf as its root
        assert sorted(listed.rows[:, :3].tolist()) == [list(key) for key in itertools.product((-32768, 0), repeat=3)]
        assert listed.occupied[0.5].all()
    else:
        expected = sorted((*row, bool(on)) for row, on in zip(listed.rows.tolist(), listed.occupied[0.5], strict=True))
        assert rows_of(octree) == expected


@pytest.mark.parametrize("name", MAPS)
def test_saved_maps_are_loaded_again(name: str, tmp_path: Path) -> None:
    octree = pc.Octree.load(FOLDER / name)
    octree.save(tmp_path / "again.bt")
    again = pc.Octree.load(tmp_path / "again.bt")
    if name not in ("root.bt", "saved_whole.bt"):
        assert rows_of(again) == rows_of(octree)
    assert again.resolution == octree.resolution
    assert np.array_equal(again.bounds, octree.bounds) if octree.count else again.count == 0


@pytest.mark.parametrize("name", ["map.ot", "map.xyz", "map"])
def test_no_other_endings_are_saved(name: str, tmp_path: Path) -> None:
    with pytest.raises(pc.PlannercheckError, match=rf"octomap file '.*{re.escape(name)}' must end in \.bt"):
        saved_octrees()["saved_ends.bt"].save(tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_no_more_cells_are_looked_at_than_may_be(monkeypatch: pytest.MonkeyPatch) -> None:
    keys, sizes, looked_at = np.array([[-5, -5, -5], [25, 20, 30]]), np.array([1, 1]), [0]

    def counted(nodes: Any) -> Any:
        looked_at.append(len(nodes))
        return morton_codes(nodes)

    monkeypatch.setattr(unknown, "morton_codes", counted)
    unknown_cells(keys, sizes)
    most = max(looked_at)
    monkeypatch.setattr(unknown, "_MOST_CELLS", most)
    unknown_cells(keys, sizes)
    monkeypatch.setattr(unknown, "_MOST_CELLS", most - 1)
    looked_at[:] = [0]
    with pytest.raises(pc.PlannercheckError, match="takes too many cells"):
        unknown_cells(keys, sizes)
    assert 64 < max(looked_at) < most


def test_unknown_space_of_far_cells_takes_no_memory() -> None:
    few = pc.Octree.from_cells([[-32768] * 3, [32767] * 3], 0.05, unknown="occupied")
    assert few.count < 1000
    sizes = few.cells[1].astype(object)
    assert sum(sizes**3) == 65536**3
    with pytest.raises(pc.PlannercheckError, match="65534 x 65534 x 65534 steps takes too many cells"):
        unknown_cells(np.array([[-32767] * 3, [32766] * 3]), np.array([1, 1]))
