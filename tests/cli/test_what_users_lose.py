"""The command line and the user's own files: nothing is replaced, mixed or left behind; 1 means "not valid" alone."""

import multiprocessing
import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.cli import main as cli
from plannercheck.common.atomic_files import write_atomically
from plannercheck.validation.formats.chunks import read_chunks

NAMES = [f"panda_joint{k}" for k in range(1, 8)]
COMMAND = [sys.executable, "-m", "plannercheck", "validate", "--robot", "panda", "--scene", "bookshelf"]
Validate = Callable[..., tuple[int, str]]


@pytest.fixture
def configurations(tmp_path: Path) -> Path:
    file = tmp_path / "q.npy"
    np.save(file, pc.Robot.load("panda").random_configurations(300_000, seed=3))
    return file


@pytest.fixture
def validate(capsys: pytest.CaptureFixture[str]) -> Validate:
    """Calls the command in this process: its exit code and its messages."""
    return lambda *arguments: (cli.main([*COMMAND[3:], *map(str, arguments)]), capsys.readouterr().err)


def _overwrite(path: Path) -> None:
    with path.open("r+b") as file:
        file.seek(-(8 * 7), os.SEEK_END)
        file.write(np.full(7, 0.25).tobytes())
    os.utime(path, (1, 1))  # even within the clock's resolution


def _replace(path: Path) -> None:
    other = path.with_name("other.npy")
    np.save(other, np.zeros((300_000, 7)))
    other.replace(path)


def _cut(path: Path) -> None:
    os.truncate(path, 4096)


@pytest.mark.parametrize("change", [_overwrite, _replace, _cut])
@pytest.mark.parametrize("turned", [False, True])
def test_an_input_that_changes_while_it_is_read_is_refused(
    configurations: Path, change: Callable[[Path], None], turned: bool
) -> None:
    if turned:
        np.save(configurations, np.asfortranarray(np.load(configurations)))
    truth = np.load(configurations)
    chunks = read_chunks(configurations, NAMES, 7)
    read = [next(chunks).rows]
    change(configurations)
    with pytest.raises(pc.PlannercheckError, match=r"changed while it was read|cut short"):  # noqa: PT012
        for chunk in chunks:
            read.append(chunk.rows)
    if change is _replace:  # what was read is of one set all the same
        assert np.array_equal(np.concatenate(read), truth)


@pytest.mark.parametrize("option", ["--output", "--summary"])
@pytest.mark.parametrize("link", ["same", "hard", "symbolic", "journal"])
def test_an_output_never_replaces_an_input(tmp_path: Path, validate: Validate, option: str, link: str) -> None:
    suffix = ".npz" if option == "--output" else ".json"
    file = tmp_path / "set.npz"
    np.savez(file, q=np.zeros((2, 7)))
    output = file
    if link == "hard":
        output = tmp_path / f"link{suffix}"
        output.hardlink_to(file)
    elif link == "symbolic":
        output = tmp_path / f"link{suffix}"
        output.symlink_to(file)
    elif link == "journal":
        output = tmp_path / f"out{suffix}"
        (tmp_path / f"out{suffix}.progress").hardlink_to(file)
    before = file.read_bytes()
    code, said = validate(file, option, output)
    assert (code, "would replace the input" in said) == (2, True)
    assert file.read_bytes() == before


def test_output_and_summary_are_two_files(tmp_path: Path, validate: Validate) -> None:
    np.save(tmp_path / "q.npy", np.zeros((2, 7)))
    code, said = validate(tmp_path / "q.npy", "--output", tmp_path / "o.npz", "--summary", tmp_path / "o.npz")
    assert (code, "one file" in said) == (2, True)


@pytest.mark.parametrize("resume", [(), ("--resume",)])
def test_a_file_that_is_no_journal_is_left_alone(tmp_path: Path, validate: Validate, resume: tuple[str, ...]) -> None:
    np.save(tmp_path / "q.npy", np.zeros((2, 7)))
    mine = tmp_path / "o.npz.progress"
    mine.write_text("my notes")
    code, said = validate(tmp_path / "q.npy", "--output", tmp_path / "o.npz", *resume)
    assert (code, "is no journal" in said) == (2, True)
    assert mine.read_text() == "my notes"
    assert not (tmp_path / "o.npz").exists()


def test_a_link_in_the_journals_place_is_not_followed(tmp_path: Path, validate: Validate) -> None:
    np.save(tmp_path / "q.npy", np.zeros((2, 7)))
    victim = tmp_path / "victim"
    for content in ("", "precious"):
        victim.write_text(content)
        (tmp_path / "o.npz.progress").symlink_to(victim)
        code, said = validate(tmp_path / "q.npy", "--output", tmp_path / "o.npz")
        assert (code, "in the way" in said) == (2, True)
        assert victim.read_text() == content
        (tmp_path / "o.npz.progress").unlink()
    os.mkfifo(tmp_path / "o.npz.progress")
    assert validate(tmp_path / "q.npy", "--output", tmp_path / "o.npz")[0] == 2


def test_parquet_holds_the_same_bytes_in_every_run_and_no_foreign_ones(tmp_path: Path) -> None:
    np.save(tmp_path / "q.npy", pc.Robot.load("panda").random_configurations(300, seed=5))
    marker = b"FOREIGN-MEMORY-" * 3
    found = set()
    for k in range(2):
        output = tmp_path / f"{k}.parquet"
        environment = {**os.environ, "FILLER": (marker * 2000).decode(), "MALLOC_PERTURB_": str(17 * k)}
        command = [*COMMAND, str(tmp_path / "q.npy"), "--output", str(output), "--explain"]
        subprocess.run(command, env=environment, capture_output=True, check=False)
        found.add(output.read_bytes())
    assert len(found) == 1
    assert marker not in found.pop()
    import pyarrow.parquet

    names = pyarrow.parquet.read_table(tmp_path / "0.parquet").column("first")
    dictionary = names.chunk(0).dictionary.to_pylist()
    assert len(set(dictionary)) == len(dictionary)


def test_sigterm_says_how_to_go_on_and_leaves_nothing_hidden(tmp_path: Path, configurations: Path) -> None:
    np.save(configurations, pc.Robot.load("panda").random_configurations(3_000_000, seed=3))
    output = tmp_path / "o.npz"
    process = subprocess.Popen([*COMMAND, configurations, "--output", output], stderr=subprocess.PIPE, text=True)
    journal = tmp_path / "o.npz.progress"
    # A record takes 332 kB: when the second one is begun, the first one is surely kept.
    while process.poll() is None and not (journal.exists() and journal.stat().st_size > 350_000):
        time.sleep(0.01)
    process.send_signal(signal.SIGTERM)
    _, messages = process.communicate()
    assert process.returncode == cli.TERMINATED
    assert "--resume goes on" in messages
    assert sorted(path.name for path in tmp_path.iterdir()) == ["o.npz.progress", "q.npy"]


def test_a_killed_process_leaves_no_hidden_file(tmp_path: Path) -> None:
    code = (
        "import os, signal, sys, pathlib\nfrom plannercheck.common.atomic_files import write_atomically\n"
        "def write(path):\n    path.write_bytes(bytes(10**6)); os.kill(os.getpid(), signal.SIGKILL)\n"
        "write_atomically(pathlib.Path(sys.argv[1]), write)"
    )
    assert subprocess.run([sys.executable, "-c", code, tmp_path / "o.npz"], check=False).returncode == -signal.SIGKILL
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("unnamed", [True, False])
def test_a_file_written_aside_has_the_rights_of_any_new_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, unnamed: bool
) -> None:
    if not unnamed:
        monkeypatch.delattr(os, "O_TMPFILE")
    before = os.umask(0o027)
    try:
        monkeypatch.setattr(os, "umask", lambda mask: pytest.fail("the mask of the whole process was changed"))
        write_atomically(tmp_path / "a.txt", lambda path: path.write_text("one"))
        write_atomically(tmp_path / "a.txt", lambda path: path.write_text("two"))
    finally:
        monkeypatch.undo()
        os.umask(before)
    assert (tmp_path / "a.txt").read_text() == "two"
    assert (tmp_path / "a.txt").stat().st_mode & 0o777 == 0o640
    assert len(list(tmp_path.iterdir())) == 1


def test_a_folder_as_output_fails_at_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    np.save(tmp_path / "q.npy", np.zeros((2, 7)))
    (tmp_path / "o.npz").mkdir()
    code = cli.main([*COMMAND[3:], str(tmp_path / "q.npy"), "--output", str(tmp_path / "o.npz")])
    assert (code, "is a folder" in capsys.readouterr().err) == (2, True)


def test_a_name_that_is_no_utf8_fails_at_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = Path(os.fsdecode(os.fsencode(tmp_path) + b"/q\xff.npy"))
    np.save(file, np.zeros((2, 7)))
    code = cli.main([*COMMAND[3:], str(file), "--output", str(tmp_path / "o.csv")])
    assert (code, "rename it" in capsys.readouterr().err) == (2, True)
    assert not (tmp_path / "o.csv.progress").exists()


def test_a_stream_with_an_absurd_shape_is_refused(tmp_path: Path, validate: Validate) -> None:
    np.save(tmp_path / "q.npy", np.zeros((2, 7)))
    content = (tmp_path / "q.npy").read_bytes().replace(b"(2, 7)", b"(-1,7)")
    ran = subprocess.run([*COMMAND, "-"], input=content, capture_output=True, check=False)
    assert ran.returncode == 2
    (tmp_path / "q.npy").write_bytes(content)
    assert validate(tmp_path / "q.npy")[0] == 2


@pytest.mark.parametrize(
    ("error", "code"),
    [(MemoryError(), 3), (RuntimeError("no"), 3), (OSError(28, "No space left"), 3), (KeyboardInterrupt(), 130)],
)
def test_one_means_not_valid_and_nothing_else(
    error: BaseException, code: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(options: object) -> int:
        raise error

    monkeypatch.setattr("plannercheck.cli.robots.run", fail)
    assert cli.main(["robots"]) == code
    assert "Traceback" not in capsys.readouterr().err
    if code == 3:
        assert cli.main(["--debug", "robots"]) == code
        assert "Traceback" in capsys.readouterr().err


def test_a_full_and_a_closed_output(tmp_path: Path) -> None:
    np.save(tmp_path / "q.npy", pc.Robot.load("panda").random_configurations(5, seed=5))
    command = " ".join([*COMMAND, str(tmp_path / "q.npy")])
    full = subprocess.run(f"{command} > /dev/full", shell=True, capture_output=True, text=True, check=False)
    assert (full.returncode, full.stderr.count("Traceback")) == (3, 0)
    closed = subprocess.run(f"{command} >&-", shell=True, capture_output=True, text=True, check=False)
    assert (closed.returncode, closed.stderr.count("Traceback")) == (1, 0)


@pytest.mark.parametrize("name", ["out.npz", "out.csv", "out.parquet"])
def test_a_full_disk_leaves_what_was_there(tmp_path: Path, configurations: Path, name: str) -> None:
    """Files that may not grow beyond 10 kB stand for a disk that is full; the journal is the first to notice."""
    (tmp_path / name).write_bytes(b"an earlier one")
    limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, 10_000))  # noqa: E731
    command = [*COMMAND, str(configurations), "--output", str(tmp_path / name)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, preexec_fn=limit)
    assert done.returncode in (2, 3)
    assert name in done.stderr
    assert "Traceback" not in done.stderr
    assert (tmp_path / name).read_bytes() == b"an earlier one"
    assert {path.name for path in tmp_path.iterdir()} <= {"q.npy", name, f"{name}.progress"}


def _verdicts_of(checker: pc.Checker, q: np.ndarray) -> list[bool]:
    return checker.check_states(q).tolist()


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_processes_judge_as_their_parent_does(method: str) -> None:
    robot = pc.Robot.load("panda")
    checker = pc.Checker(robot, pc.Scene.load("bookshelf"))
    q = robot.random_configurations(200, 1)
    known = _verdicts_of(checker, q)  # so that there are workspaces to share
    with ProcessPoolExecutor(2, multiprocessing.get_context(method)) as pool:
        assert [*pool.map(_verdicts_of, [checker] * 2, [q] * 2)] == [known, known]


@pytest.mark.parametrize("encoding", ["latin-1", "utf-16"])
@pytest.mark.parametrize("name", ["q.csv", "path.json", "scene.yaml", "robot.yaml", "robot.urdf"])
def test_text_in_other_encodings(tmp_path: Path, validate: Validate, name: str, encoding: str) -> None:
    file, q = tmp_path / name, tmp_path / "good.npy"
    np.save(q, np.zeros((1, 7)))
    file.write_bytes("jö: {a: 1}\n".encode(encoding))
    arguments = {
        "q.csv": [file],
        "path.json": ["--path", file],
        "scene.yaml": [q, "--scene", file],
        "robot.yaml": [q, "--robot", file],
        "robot.urdf": [q, "--robot", file],
    }[name]
    code, said = validate(*arguments)
    assert (code, said.count("Traceback")) == (2, 0)
    assert name in said


def test_more_threads_than_a_system_starts() -> None:
    checker = pc.Checker(pc.Robot.load("panda"))
    q = checker.robot.random_configurations(200_000, seed=1)
    assert np.array_equal(checker.check_states(q, threads=100_000), checker.check_states(q))
