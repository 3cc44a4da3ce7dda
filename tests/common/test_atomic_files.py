"""Output files appear whole or not at all, and nothing else appears."""

import errno
import os
import stat
import threading
from pathlib import Path

import pytest

from plannercheck.common import atomic_files
from plannercheck.common.atomic_files import replace_atomically, write_atomically
from plannercheck.common.errors import PlannercheckError


def test_a_first_file_needs_no_other_name(tmp_path, monkeypatch):
    """Found by a run of kills: a process that was killed between two names left the first one behind."""

    def never(self: Path, target: Path) -> None:
        raise AssertionError(f"{self} was to be renamed")

    if not Path("/proc/self/fd").is_dir():
        pytest.skip("this system has no files without a name")
    monkeypatch.setattr(Path, "replace", never)
    write_atomically(tmp_path / "out.csv", lambda file: file.write_text("first"))
    assert [file.name for file in tmp_path.iterdir()] == ["out.csv"]


@pytest.fixture(params=["unnamed", "named"])
def way(request, monkeypatch):
    """Both ways to a file: without a name until it is whole, and by another name where systems have no such files."""
    if request.param == "named":
        monkeypatch.delattr(os, "O_TMPFILE", raising=False)


@pytest.mark.parametrize("chain", [0, 1, 3])
@pytest.mark.parametrize("before", ["before", None])
def test_links_stay_and_the_file_that_they_name_is_written(tmp_path, way, before, chain):
    (tmp_path / "far").mkdir()
    target = out = tmp_path / "far" / "target"
    if before is not None:
        target.write_text(before)
    for k in range(chain):
        link = tmp_path / f"link{k}"
        link.symlink_to(os.path.relpath(out, tmp_path) if k % 2 else out)
        out = link
    write_atomically(out, lambda file: file.write_text("after"))
    assert target.read_text() == "after"
    assert not target.is_symlink()
    assert [path.name for path in target.parent.iterdir()] == ["target"]
    assert {path.name for path in tmp_path.iterdir() if path.is_symlink()} == {f"link{k}" for k in range(chain)}


def test_a_circle_of_links_is_an_error(tmp_path):
    for a, b in ("ab", "ba"):
        (tmp_path / a).symlink_to(tmp_path / b)
    with pytest.raises(PlannercheckError, match=r"/a' can't be written: Too many levels of symbolic links"):
        write_atomically(tmp_path / "a", lambda file: file.write_text("x"))
    assert (tmp_path / "a").is_symlink()


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o666, 0o444, 0o755])
def test_the_mode_of_a_file_stays(tmp_path, way, mode):
    out = tmp_path / "out.csv"
    out.write_text("before")
    out.chmod(mode)
    seen = []

    def write(file):
        seen.append(file.stat().st_mode & 0o777)
        file.write_text("after")

    write_atomically(out, write)
    assert (out.read_text(), stat.S_IMODE(out.stat().st_mode)) == ("after", mode)
    assert seen == [0o600]  # nobody reads a private file before it is one


def test_a_new_file_has_the_rights_that_the_user_gives_new_files(tmp_path, way):
    before = os.umask(0o027)
    try:
        write_atomically(tmp_path / "new", lambda file: file.write_text("x"))
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "new").stat().st_mode) == 0o640


def test_a_pipe_stays_and_its_reader_gets_everything(tmp_path):
    pipe, content = tmp_path / "pipe", os.urandom(1 << 20)  # more than a pipe holds
    os.mkfifo(pipe)
    got = []
    reader = threading.Thread(target=lambda: got.append(pipe.read_bytes()))
    later = threading.Timer(0.3, reader.start)
    later.start()
    write_atomically(pipe, lambda file: file.write_bytes(content))
    later.join()
    reader.join()
    assert got == [content]
    assert pipe.is_fifo()


def test_a_pipe_that_nobody_reads_is_an_error_after_a_while(tmp_path, monkeypatch):
    monkeypatch.setattr(atomic_files, "_PATIENCE", 0.1)
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(PlannercheckError, match=r"pipe' can't be written: nobody has read this pipe for 0\.1 s"):
        write_atomically(tmp_path / "pipe", lambda file: file.write_text("x"))
    assert (tmp_path / "pipe").is_fifo()


@pytest.mark.parametrize("is_linked", [False, True])
def test_a_device_stays_and_gets_what_is_written(tmp_path, is_linked):
    """A terminal, which nobody needs to be root for."""
    controller, terminal = os.openpty()
    device = Path(os.ttyname(terminal))
    out = tmp_path / "link"
    out.symlink_to(device)
    write_atomically(out if is_linked else device, lambda file: file.write_text("written"))
    assert os.read(controller, 100) == b"written"
    assert device.is_char_device()
    assert out.is_symlink()
    os.close(controller)
    os.close(terminal)


@pytest.mark.parametrize("folder", ["/dev/fd", "/proc/self/fd"])
def test_descriptors_get_what_is_written_after_what_they_have(tmp_path, folder):
    log = tmp_path / "log"
    log.write_text("first ")
    with log.open("a") as file:
        path = Path(folder) / str(file.fileno())
        write_atomically(path, lambda aside: aside.write_text("second "))
        (tmp_path / "link").symlink_to(path)
        write_atomically(tmp_path / "link", lambda aside: aside.write_text("third"))
    assert log.read_text() == "first second third"
    with pytest.raises(PlannercheckError, match="can't be written: Bad file descriptor"):
        write_atomically(path, lambda aside: aside.write_text("x"))


def test_what_fails_writes_nothing_into_a_stream(tmp_path):
    ours, theirs = os.pipe()

    def fail(file):
        file.write_text("half")
        raise OSError(errno.ENOSPC, "No space left on device")

    with pytest.raises(PlannercheckError, match="No space left"):
        write_atomically(Path(f"/dev/fd/{theirs}"), fail)
    os.close(theirs)
    assert os.read(ours, 10) == b""
    os.close(ours)


def test_files_of_ours_replace_whatever_is_there(tmp_path):
    """As in a cache, where a link may be somebody's trap."""
    (tmp_path / "target").write_text("precious")
    (tmp_path / "link").symlink_to(tmp_path / "target")
    os.mkfifo(tmp_path / "pipe")
    for name in ("link", "pipe"):
        replace_atomically(tmp_path / name, lambda file: file.write_text("ours"), 0o600)
        assert stat.S_ISREG((tmp_path / name).lstat().st_mode)
    assert (tmp_path / "target").read_text() == "precious"
