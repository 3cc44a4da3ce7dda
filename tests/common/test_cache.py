"""The disk cache holds what this user has left there and nothing else, whoever else can write to it."""

import ctypes
import os
import pwd
import signal
import subprocess
import sys
import time
import warnings
from pathlib import Path

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.bodies.polytope import prepared
from plannercheck.common import cache
from plannercheck.common.cache import cache_folder, read_cached, uncached, write_to_cache

OTHER_USER = 12345
IS_ROOT = os.geteuid() == 0
needs_others = pytest.mark.skipif(not IS_ROOT, reason="only root can give files to others, or become another user")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("PLANNERCHECK_CACHE", str(tmp_path / "cache"))
    cache._warn_of.cache_clear()
    (tmp_path / "cache").mkdir(0o700)
    return tmp_path / "cache"


@pytest.fixture
def file(folder):
    write_to_cache(folder / "a.cells", b"content")
    return folder / "a.cells"


@pytest.mark.parametrize("setting", [None, "0", "somewhere"])
def test_the_cache_is_off_for_a_while_alone(setting, monkeypatch):
    if setting is None:
        monkeypatch.delenv("PLANNERCHECK_CACHE", raising=False)
    else:
        monkeypatch.setenv("PLANNERCHECK_CACHE", setting)
    with uncached():
        assert cache_folder() is None
    assert os.environ.get("PLANNERCHECK_CACHE") == setting


def test_the_cache_is_in_the_platforms_folder_by_default(monkeypatch):
    monkeypatch.delenv("PLANNERCHECK_CACHE", raising=False)
    folder = cache_folder()
    assert folder is not None
    assert folder.name == "plannercheck"


@pytest.mark.parametrize("home", [None, "", "relative"])
def test_without_a_home_there_is_no_cache(home, tmp_path, monkeypatch):
    """Found by an audit: a container's user without HOME and passwd entry, in whose folder "~" was made."""

    def nobody(user):
        raise KeyError(f"getpwuid(): uid not found: {user}")

    for name in ("PLANNERCHECK_CACHE", "HOME", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    if home is not None:
        monkeypatch.setenv("HOME", home)
    monkeypatch.setattr(pwd, "getpwuid", nobody)
    monkeypatch.chdir(tmp_path)
    assert cache_folder() is None
    assert len(prepared(np.random.default_rng(0).normal(size=(50, 3))).vertices) > 3
    assert not list(tmp_path.iterdir())


def test_what_is_written_is_read_and_private(file):
    assert read_cached(file) == b"content"
    assert {path.name: path.stat().st_mode & 0o777 for path in file.parent.iterdir()} == {
        "a.cells": 0o600,
        "key": 0o600,
    }
    write_to_cache(file, b"")
    assert read_cached(file) == b""
    assert read_cached(file.with_name("b.cells")) is None


def test_every_changed_byte_is_seen(file):
    whole = file.read_bytes()
    for place in range(len(whole)):
        file.write_bytes(whole[:place] + bytes([whole[place] ^ 1]) + whole[place + 1 :])
        assert read_cached(file) is None
    for content in (b"", whole[:-1], whole[:20], whole + b"\0"):
        file.write_bytes(content)
        assert read_cached(file) is None
    write_to_cache(file, b"content")
    assert file.read_bytes() == whole


def test_a_file_under_another_name_is_not_believed(file):
    file.with_name("b.cells").write_bytes(file.read_bytes())
    assert read_cached(file.with_name("b.cells")) is None


def test_a_file_of_another_key_is_not_believed(file, tmp_path):
    """What another user can do: the key is theirs, the name and the content are right."""
    write_to_cache(tmp_path / "a.cells", b"\xff" * 7)
    (tmp_path / "a.cells").replace(file)
    assert read_cached(file) is None
    write_to_cache(file, b"content")
    assert read_cached(file) == b"content"


@pytest.mark.parametrize("fault", ["missing", "short", "long", "readable", "link", "pipe"])
def test_a_key_that_others_may_know_is_replaced(file, fault):
    key, before = file.parent / "key", (file.parent / "key").read_bytes()
    if fault in ("short", "long"):
        key.write_bytes(before[:-1] if fault == "short" else before + b"\0")
    elif fault == "readable":
        key.chmod(0o640)
    else:
        key.rename(file.parent / "elsewhere")
        {"missing": lambda: None, "link": lambda: key.symlink_to("elsewhere"), "pipe": lambda: os.mkfifo(key)}[fault]()
    assert read_cached(file) is None
    write_to_cache(file, b"new")
    assert read_cached(file) == b"new"
    assert key.stat().st_mode & 0o777 == 0o600
    assert not key.is_symlink()
    assert len(key.read_bytes()) == 32
    assert key.read_bytes() != before


@pytest.mark.parametrize("mode", [0o777, 0o770, 0o775, 0o707])
def test_a_folder_in_which_others_may_rename_is_not_used(file, mode):
    file.parent.chmod(mode)
    with pytest.warns(RuntimeWarning, match=r"cache folder '.*' is not used, since others may change what is in it"):
        assert read_cached(file) is None
    before = {path: path.read_bytes() for path in file.parent.iterdir()}
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # said once
        write_to_cache(file, b"new")
        write_to_cache(file.with_name("b.cells"), b"new")
    assert {path: path.read_bytes() for path in file.parent.iterdir()} == before


@pytest.mark.parametrize("mode", [0o1777, 0o755, 0o700])
def test_a_folder_in_which_others_may_not_rename_is_used(file, mode):
    file.parent.chmod(mode)
    assert read_cached(file) == b"content"


@pytest.mark.parametrize("mode", [0o620, 0o602, 0o666])
def test_a_file_that_others_may_write_is_not_believed(file, mode):
    file.chmod(mode)
    assert read_cached(file) is None


@needs_others
@pytest.mark.parametrize("what", ["file", "key", "folder"])
def test_what_others_own_is_not_believed(file, what):
    os.chown({"file": file, "key": file.parent / "key", "folder": file.parent}[what], OTHER_USER, -1)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert read_cached(file) is None


@pytest.mark.parametrize("other", ["pipe", "link", "link to a device", "folder", "socket"])
def test_what_is_no_file_is_not_read_and_does_not_hang(file, other):
    whole = file.read_bytes()
    file.unlink()
    if other == "pipe":
        os.mkfifo(file)
    elif other == "folder":
        file.mkdir()
    elif other == "socket":
        import socket

        with socket.socket(socket.AF_UNIX) as made:
            made.bind(os.path.relpath(file))
    else:
        (file.parent / "real").write_bytes(whole)
        file.symlink_to("real" if other == "link" else "/dev/zero")
    assert read_cached(file) is None
    write_to_cache(file, b"new")
    assert read_cached(file) == (None if other == "folder" else b"new")


@pytest.mark.parametrize("other", ["pipe", "other content"])
def test_what_is_swapped_in_at_the_last_moment_is_looked_at(file, monkeypatch, other):
    """Between any look at a name and its opening, another one may stand there: what counts is what was opened."""
    real = os.open

    def swapped(path, *args, **options):
        if path == file.name:
            file.unlink(missing_ok=True)
            if other == "pipe":
                os.mkfifo(file)
            else:
                file.write_bytes(b"\xff" * 39)
        return real(path, *args, **options)

    monkeypatch.setattr(os, "open", swapped)
    assert read_cached(file) is None


@needs_others
@pytest.mark.parametrize("mode", [0o777, 0o1777])
def test_a_race_with_another_user_is_never_lost(folder, mode):
    """Another user's process exchanges a file for its own, or for a pipe, as fast as it can."""
    for above in (folder, *folder.parents):
        if "pytest" in str(above):
            above.chmod(mode if above == folder else 0o755)
    name = folder / "a.cells"
    folder.chmod(0o700)
    write_to_cache(name, b"content")
    folder.chmod(mode)
    attacker = os.fork()
    if attacker == 0:
        try:
            _exchange_for_ever(name)
        finally:
            os._exit(0)
    found: set[bytes | None] = set()
    end = time.monotonic() + 0.7
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        while time.monotonic() < end:
            found.add(read_cached(name))
            write_to_cache(name, b"content")
    os.kill(attacker, signal.SIGKILL)
    os.waitpid(attacker, 0)
    assert found == ({None} if mode == 0o777 else {b"content"})


def _exchange_for_ever(name: Path) -> None:
    os.setuid(OTHER_USER)
    libc, mine, is_pipe = ctypes.CDLL(None), name.with_name("mine"), False
    while True:
        try:
            mine.unlink(missing_ok=True)
            os.mkfifo(mine) if is_pipe else mine.write_bytes(b"\xff" * 39)
            is_pipe = not is_pipe
        except OSError:
            pass
        for _ in range(4):
            libc.renameat2(-100, bytes(name), -100, bytes(mine), 2)  # RENAME_EXCHANGE


def test_cells_of_another_user_change_no_verdict(folder):
    """Found by an audit: swapped cells gave 4,432 wrong verdicts of 200,000."""
    robot = pc.Robot.load("panda")
    q = robot.random_configurations(20_000, seed=0)

    def verdicts() -> bytes:
        fresh = pc.Robot.load("panda")
        fresh._parts.memory.__init__()
        return pc.Checker(fresh).check_states(q).tobytes()

    right, files = verdicts(), sorted(folder.glob("*.cells"))
    assert files
    key = (folder / "key").read_bytes()
    (folder / "key").unlink()
    for file in files:  # all cells apart, under a key of theirs
        write_to_cache(file, b"\xff" * (file.stat().st_size - 32))
    (folder / "key").write_bytes(key)
    assert verdicts() == right


def test_two_processes_that_fill_a_cache_at_once_both_end_with_it(folder):
    script = """
import sys
from pathlib import Path
from plannercheck.common.cache import read_cached, write_to_cache
for k in range(200):
    write_to_cache(Path(sys.argv[1]) / f"{k}.cells", b"%d" % k)
    assert read_cached(Path(sys.argv[1]) / f"{k}.cells") in (b"%d" % k, None)
"""
    runs = [subprocess.Popen([sys.executable, "-c", script, str(folder)]) for _ in range(3)]
    assert [run.wait(60) for run in runs] == [0, 0, 0]
    assert all(read_cached(folder / f"{k}.cells") == b"%d" % k for k in range(150, 200))
