"""Files of prepared bodies and their cache: whole or refused, and a second start that reads them."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys

import numpy as np
import pytest

import plannercheck as pc
from plannercheck import body_files, hull
from plannercheck.hull import prepared
from plannercheck.shapes import Cylinder
from plannercheck.stress.families import family

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


def test_the_cache_holds_what_was_prepared(cache, monkeypatch):
    first = prepared(POINTS)
    assert len(list(cache.iterdir())) == 1
    monkeypatch.setattr(hull.Polytope, "__init__", lambda *_: pytest.fail("prepared anew"))
    again = prepared(POINTS.copy())
    assert again.core.serialise() == first.core.serialise()


def test_the_cache_tells_contents_apart(cache):
    moved = POINTS.copy()
    moved[3, 1] = np.nextafter(moved[3, 1], 2)
    vertices, faces = Cylinder(0.1, 1).vertices_and_faces(1e-2)
    for arguments in ((POINTS,), (moved,), (POINTS[::-1],), (vertices,), (vertices, faces)):
        prepared(*arguments)
    assert len(list(cache.iterdir())) == 5
    np.testing.assert_array_equal(prepared(moved).vertices[3], moved[3])


def test_a_damaged_cache_is_prepared_anew(cache):
    first = prepared(POINTS)
    (path,) = cache.iterdir()
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
    assert body_files.cache_folder() is None
    assert list(tmp_path.iterdir()) == []


def test_the_cache_is_in_the_platforms_folder_by_default(monkeypatch):
    monkeypatch.delenv("PLANNERCHECK_CACHE", raising=False)
    folder = body_files.cache_folder()
    assert folder is not None
    assert folder.name == "plannercheck"


@pytest.mark.skipif(os.name == "nt", reason="a file in place of a folder, as on POSIX")
def test_a_cache_that_cannot_be_written_is_no_error(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("not a folder")
    monkeypatch.setenv("PLANNERCHECK_CACHE", str(tmp_path / "file" / "cache"))
    assert len(prepared(POINTS).vertices) == 200


def test_a_second_start_of_a_robot_prepares_nothing_but_what_has_few_points(cache):
    start = "import plannercheck as pc; pc.Checker(pc.Robot.load('ur5'), pc.Scene.load('table'))"
    forbid = (
        "from plannercheck import hull\nanew = hull.Polytope.__init__\n"
        "def few(self, points, *a):\n assert len(points) <= 32, 'prepared anew'\n anew(self, points, *a)\n"
        "hull.Polytope.__init__ = few\n"
    )
    subprocess.run([sys.executable, "-c", start], check=True)
    written = {path: path.stat().st_mtime_ns for path in cache.iterdir()}
    assert written
    subprocess.run([sys.executable, "-c", forbid + start], check=True)
    assert {path: path.stat().st_mtime_ns for path in cache.iterdir()} == written
