"""Files of prepared bodies and their cache: whole or refused, and a second start that reads them."""

import hashlib
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from body_layout import fields

import plannercheck as pc
from plannercheck.bodies import polytope as hull
from plannercheck.bodies import polytope_files as body_files
from plannercheck.bodies.polytope import Polytope, prepared
from plannercheck.bodies.shapes import Cylinder
from plannercheck.common.cache import cache_folder, write_to_cache
from plannercheck.common.core import core
from plannercheck.evaluation.stress.body_families import family

POINTS = family("round", 200, seed=1)


@pytest.fixture
def cache(tmp_path, monkeypatch):
    folder = tmp_path / "cache"
    monkeypatch.setenv("PLANNERCHECK_CACHE", str(folder))
    return folder


@pytest.mark.parametrize("name", ["box", "cone", "prism"])
def test_saved_bodies_keep_every_bit(tmp_path, name):
    polytope = pc.Polytope(family(name, 300, seed=1))
    polytope.save(tmp_path / "a.body")
    again = pc.Polytope.load(str(tmp_path / "a.body"))
    assert again.core.serialise() == polytope.core.serialise()
    again.save(tmp_path / "b.body")
    assert (tmp_path / "a.body").read_bytes() == (tmp_path / "b.body").read_bytes()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.body", "b.body"]  # nothing left aside


def test_the_header_tells_version_and_hash(tmp_path):
    polytope = pc.Polytope(POINTS)
    polytope.save(tmp_path / "a.body")
    header, rest = (tmp_path / "a.body").read_bytes().split(b"\n", 1)
    assert header.startswith(b"plannercheck body ")
    assert rest[32:] == polytope.core.serialise()
    assert rest[:32] == hashlib.sha256(rest[32:]).digest()


def test_truncated_files_are_refused(tmp_path):
    path = tmp_path / "a.body"
    pc.Polytope(POINTS).save(path)
    whole = path.read_bytes()
    for end in (0, 5, len("plannercheck body"), 20, 30, 60, len(whole) // 2, len(whole) - 1):
        path.write_bytes(whole[:end])
        with pytest.raises(pc.PlannercheckError, match=r"a\.body"):
            pc.Polytope.load(path)


def test_changed_files_are_refused(tmp_path):
    path = tmp_path / "a.body"
    pc.Polytope(POINTS).save(path)
    whole = path.read_bytes()
    for place in (len(whole) - 1, len(whole) // 2, 40):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 1]) + whole[place + 1 :])
        with pytest.raises(pc.PlannercheckError, match="does not match its hash"):
            pc.Polytope.load(path)
    path.write_bytes(whole + b"\0")
    with pytest.raises(pc.PlannercheckError, match="does not match its hash"):
        pc.Polytope.load(path)


def test_other_versions_and_kinds_are_refused(tmp_path):
    path = tmp_path / "a.body"
    path.write_bytes(b"plannercheck body 999999 little\n" + b"\0" * 100)
    with pytest.raises(pc.PlannercheckError, match=r"'plannercheck body 999999 little'.*prepare it again"):
        pc.Polytope.load(path)
    path.write_bytes(b"plannercheck body" + b"x" * 5000)
    with pytest.raises(pc.PlannercheckError, match="prepare it again") as caught:
        pc.Polytope.load(path)
    assert len(str(caught.value)) < 500
    path.write_bytes(b"solid teapot")
    with pytest.raises(pc.PlannercheckError, match="no file of a prepared body"):
        pc.Polytope.load(path)


def test_missing_files_and_folders_are_named(tmp_path):
    with pytest.raises(pc.PlannercheckError, match=r"missing\.body"):
        pc.Polytope.load(tmp_path / "missing.body")
    with pytest.raises(pc.PlannercheckError, match="nowhere"):
        pc.Polytope(POINTS).save(tmp_path / "nowhere" / "a.body")


def test_a_whole_file_with_damaged_data_is_refused(tmp_path):
    data = pc.Polytope(POINTS).core.serialise()
    body_files.write(tmp_path / "a.body", data[: len(data) // 2])
    with pytest.raises(pc.PlannercheckError, match="not a prepared body"):
        pc.Polytope.load(tmp_path / "a.body")


def altered(data, name, dtype, change):
    """The bytes of a body with one field, a flat array, changed in place."""
    first, end = fields(data)[name]
    array = np.frombuffer(data[first:end], dtype=dtype).copy()
    assert len(array) > 0
    change(array)
    return data[:first] + array.tobytes() + data[end:]


def at(place, value):
    """A change of one entry; of the value before if `value` is a function."""

    def change(array):
        array[place] = value(array[place]) if callable(value) else value

    return change


def without_marks(words):
    """Takes the marks from all last blocks: the complements among words 24 to 27 of the 32 of each."""
    vertices = words.reshape(-1, 32)[:, 24:28]
    np.copyto(vertices, np.where(vertices < 0, ~vertices, vertices))


CELLS = {
    "another number of cells": ("edge", "i4", at(0, 5)),
    "a negative number of cells": ("edge", "i4", at(0, -4)),
    "far too many cells": ("edge", "i4", at(0, 2**31 - 1)),
    "no cells": ("edge", "i4", at(0, 0)),
    "a block that is none": ("cells", "u2", at(8 * 7 + 3, 1000)),
    "groups beyond the end": ("cells", "u4", at(4 * 7 + 2, 10**6)),
    "more groups than there are": ("cells", "u4", at(4 * 95 + 3, 15)),
    "more groups than any cell has": ("cells", "u4", at(4 * 7 + 3, 2**32 - 1)),
    "a further block that is none": ("cell_groups", "u2", at(1, 1000)),
    "a vertex that is none": ("cell_blocks", "i4", at(24, 150)),
    "a negative vertex": ("cell_blocks", "i4", at(31, -1)),
}
BLOCKS = {
    "another chain": ("i4", at(28, lambda chain: chain + 1)),
    "no chain": ("i4", at(slice(28, None, 32), -1)),
    "a chain beyond the end": ("i4", at(28, 2**31 - 1)),
    "a walk by wedges": ("i4", at(29, -2)),
    "no mark on the last block": ("i4", at(slice(-8, -4), lambda vertices: ~vertices)),
    "no marks at all": ("i4", without_marks),
    "a mark on one lane": ("i4", at(24, lambda vertex: ~vertex)),
    "a vertex that is none": ("i4", at(24, 10**6)),
    "another point": ("f8", at(0, lambda x: x + 1)),
    "no number": ("f8", at(0, np.nan)),
}
LEVELS = {
    "levels that rise along chains": ("level", at(0, 10**6)),
    "a removed vertex that stays": ("level", at(3, lambda level: level + 100)),
    "a negative level": ("level", at(0, -1)),
    "a ring of all vertices": ("ring_start", lambda starts: starts[1:].fill(starts[-1])),
    "a vertex twice at the top": ("top", at(1, lambda _: 0)),
    "a neighbour that is none": ("rings", at(0, 10**6)),
}


def refuses(data):
    with pytest.raises(core.HullError, match="the data are damaged"):
        core.Polytope.parse(data)


@pytest.mark.parametrize("case", CELLS)
def test_cells_that_lead_astray_are_refused(case):
    name, dtype, change = CELLS[case]
    refuses(altered(pc.Polytope(family("round", 150, seed=1)).core.serialise(), f"inner.{name}", dtype, change))


@pytest.mark.parametrize("part", ["inner", "top_levels", "polar"])
@pytest.mark.parametrize("case", BLOCKS)
def test_blocks_that_lead_astray_are_refused(case, part):
    dtype, change = BLOCKS[case]
    refuses(altered(pc.Polytope(family("cone", 1000, seed=1)).core.serialise(), f"{part}.blocks", dtype, change))


@pytest.mark.parametrize("part", ["inner", "top_levels", "polar"])
@pytest.mark.parametrize("case", LEVELS)
def test_levels_that_lead_nowhere_are_refused(case, part):
    name, change = LEVELS[case]
    refuses(altered(pc.Polytope(family("round", 1000, seed=1)).core.serialise(), f"{part}.{name}", "i4", change))


# Bytes of any field, and small fields as often as large ones: most of a body's bytes are blocks, which are all checked.
FLIPPED = """
import sys
import numpy as np
import plannercheck as pc
from body_layout import fields
from plannercheck.common.core import core
from plannercheck.bodies.tuning import METHODS, pair_options
from plannercheck.common.cache import cache_folder, read_cached, uncached, write_to_cache
from plannercheck.evaluation.stress.body_families import family

sound = pc.Polytope(family(sys.argv[1], int(sys.argv[2]), seed=1)).core
data, rng = sound.serialise(), np.random.default_rng(1)
spans = [(first, end) for first, end in fields(data).values() if end > first]
directions = rng.normal(size=(8, 3))
poses = np.repeat(np.eye(4)[None], 4, axis=0)
poses[:, :3, 3] = rng.normal(size=(4, 3)) * np.array([0, 0.1, 0.3, 0.9])[:, None]
accepted = 0
for k in range(2000):
    first, end = (0, len(data)) if k % 2 else spans[rng.integers(len(spans))]
    damaged = bytearray(data)
    damaged[rng.integers(first, end)] ^= 1 << int(rng.integers(8)) if k % 4 < 2 else int(rng.integers(1, 256))
    try:
        body = core.Polytope.parse(bytes(damaged))
    except core.HullError:
        continue
    accepted += 1
    body.extremes(directions, False)
    if len(body.polar_points()) > 0:
        body.extremes(directions, True)
    for method in METHODS:
        for pair in ((body, sound), (sound, body)):
            core.intersect_batch(pair[0], poses, pair[1], poses[:1], pair_options(method))
assert 0 < accepted < 2000, accepted
"""


@pytest.mark.parametrize("name", ["round", "cone"])
@pytest.mark.parametrize("n", [150, 1000])
def test_bodies_of_flipped_bytes_are_refused_or_harmless(name, n):
    tests = os.pathsep.join([str(Path(__file__).parents[1] / "support"), os.environ.get("PYTHONPATH", "")])
    run = subprocess.run(
        [sys.executable, "-c", FLIPPED, name, str(n)],
        env={**os.environ, "PYTHONPATH": tests},
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    assert run.returncode == 0, run.stderr


def test_the_cache_holds_what_was_prepared(cache, monkeypatch):
    first = prepared(POINTS)
    assert len(list(cache.glob("*.body"))) == 1
    monkeypatch.setattr(hull.Polytope, "__init__", lambda *_: pytest.fail("prepared anew"))
    again = prepared(POINTS.copy())
    assert again.core.serialise() == first.core.serialise()


def test_the_cache_tells_contents_apart(cache):
    moved = POINTS.copy()
    moved[3, 1] = np.nextafter(moved[3, 1], 2)
    vertices, faces = Cylinder(0.1, 1).vertices_and_faces(1e-2)
    for arguments in ((POINTS,), (moved,), (POINTS[::-1],), (vertices,), (vertices, faces)):
        prepared(*arguments)
    assert len(list(cache.glob("*.body"))) == 5
    np.testing.assert_array_equal(prepared(moved).vertices[3], moved[3])


def test_a_damaged_cache_is_prepared_anew(cache):
    first = prepared(POINTS)
    (path,) = cache.glob("*.body")
    whole = path.read_bytes()
    for damaged in (b"", whole[:-1], whole[:-1] + b"\x7f", b"plannercheck body 0 little\n"):
        path.write_bytes(damaged)
        assert prepared(POINTS).core.serialise() == first.core.serialise()
        assert path.read_bytes() == whole


def test_the_cache_can_be_turned_off(tmp_path, monkeypatch):
    monkeypatch.setenv("PLANNERCHECK_CACHE", "0")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "home"))
    prepared(POINTS)
    assert cache_folder() is None
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(os.name == "nt", reason="a file in place of a folder, as on POSIX")
def test_a_cache_that_cannot_be_written_is_no_error(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("not a folder")
    monkeypatch.setenv("PLANNERCHECK_CACHE", str(tmp_path / "file" / "cache"))
    assert len(prepared(POINTS).vertices) == 200


def test_a_second_start_of_a_robot_prepares_nothing_but_what_has_few_points(cache):
    start = "import plannercheck as pc; pc.Checker(pc.Robot.load('ur5'), pc.Scene.load('table'))"
    forbid = (
        "from plannercheck.bodies import polytope as hull\nanew = hull.Polytope.__init__\n"
        "def few(self, points, *a):\n assert len(points) <= 32, 'prepared anew'\n anew(self, points, *a)\n"
        "hull.Polytope.__init__ = few\n"
    )
    subprocess.run([sys.executable, "-c", start], check=True)
    written = {path: path.stat().st_mtime_ns for path in cache.iterdir()}
    assert written
    subprocess.run([sys.executable, "-c", forbid + start], check=True)
    assert {path: path.stat().st_mtime_ns for path in cache.iterdir()} == written


@pytest.fixture
def shared_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("PLANNERCHECK_CACHE", str(tmp_path))
    return tmp_path


def _two_bodies() -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(8)
    return rng.normal(size=(100, 3)), 0.1 * rng.normal(size=(100, 3))


def test_a_body_of_other_points_in_the_cache_is_not_taken(shared_cache):
    mine, other = _two_bodies()
    prepared(mine)
    (file,) = shared_cache.glob("*.body")
    content = file.read_bytes()
    file.unlink()
    prepared(other)
    (of_other,) = shared_cache.glob("*.body")
    file.write_bytes(of_other.read_bytes())  # whole, of this version, but under another name
    assert prepared(mine).vertices.tobytes() == Polytope(mine).vertices.tobytes()
    write_to_cache(file, Polytope(other).core.serialise())  # with a digest that fits as well: its vertices tell
    assert prepared(mine).vertices.tobytes() == Polytope(mine).vertices.tobytes()
    assert content


def test_what_is_no_file_in_the_cache_neither_hangs_nor_fails(shared_cache):
    mine, other = _two_bodies()
    for points, make in ((mine, lambda p: os.mkfifo(p)), (other, lambda p: p.symlink_to("/dev/zero"))):
        file = body_files.cache_file(points, None, 0.0)
        make(file)
        assert prepared(points).vertices.tobytes() == Polytope(points).vertices.tobytes()
