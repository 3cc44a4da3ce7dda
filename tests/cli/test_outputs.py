"""Outputs that are links, devices, pipes or private files, of every command and every `save`: they stay what they are.

Found by an audit: as root, `--summary /dev/null` put a file in the place of /dev/null. Devices here are terminals of
the test's own.
"""

import json
import os
import stat
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.cli.main import main
from plannercheck.ompl.plans import Plan
from plannercheck.planar import Scene as PlanarScene

VALIDATE = "validate --robot panda --scene bookshelf set.npy --progress none "
COMMANDS = {
    "csv": (VALIDATE + "--output {}", ".csv"),
    "npz": (VALIDATE + "--output {}", ".npz"),
    "parquet": (VALIDATE + "--output {}", ".parquet"),
    "summary": (VALIDATE + "--summary {}", ".json"),
    "plan": ("plan --robot panda --scene bookshelf --time 5 --seed 1 --output {}", ".json"),
    "page": ("view --robot panda --scene table --html {}", ".html"),
    "cell": ("export --robot ur5 --output {}", ".plannercheck"),
    "pairs": ("acm --robot ur5 --states 500 --output {}", ".srdf"),
}
SAVED: dict[str, tuple[Callable[[Path], object], str]] = {
    "scene": (pc.Scene("s").save, ".yaml"),
    "planar scene": (PlanarScene("s").save, ".yaml"),
    "plan": (Plan(False, np.zeros((0, 2)), 0, 0, 0, "RRT").save, ".npy"),
    "body": (pc.Polytope(np.eye(3)).save, ".body"),
    "octree": (pc.Octree.from_cells(np.array([[0, 0, 0]], dtype=np.int32), 0.1).save, ".bt"),
}


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    np.save("set.npy", pc.Robot.load("panda").random_configurations(300, seed=0))
    return tmp_path


@pytest.fixture(params=[*COMMANDS, *SAVED])
def written(request) -> tuple[Callable[[Path], object], str]:
    """Something that writes to a path, and the path's suffix."""
    if request.param in SAVED:
        return SAVED[request.param]
    command, suffix = COMMANDS[request.param]

    def run(path: Path) -> None:
        assert main(command.format(path).split()) in (0, 1)

    return run, suffix


def test_links_lead_to_private_files_that_stay_private(folder, written):
    write, suffix = written
    target, link = folder / "deep" / f"target{suffix}", folder / f"link{suffix}"
    target.parent.mkdir()
    target.touch(0o600)
    link.symlink_to(target)
    before = {*folder.iterdir()}
    write(link)
    assert link.readlink() == target
    assert len(target.read_bytes()) > 0
    assert stat.S_IMODE(target.stat().st_mode) == 0o600
    assert {*folder.iterdir()} == before


def test_pipes_get_everything(folder, written):
    write, suffix = written
    pipe = folder / f"pipe{suffix}"
    os.mkfifo(pipe)
    got: list[bytes] = []
    reader = threading.Thread(target=lambda: got.append(pipe.read_bytes()))
    reader.start()
    write(pipe)
    reader.join(60)
    assert pipe.is_fifo()
    assert len(got[0]) > 0
    assert {path.name for path in folder.iterdir()} == {"set.npy", pipe.name}


@pytest.mark.parametrize("option", ["--output", "--summary"])
def test_a_device_gets_what_is_written(folder, option):
    controller, terminal = os.openpty()
    device = Path(os.ttyname(terminal))
    link = folder / f"device{'.csv' if option == '--output' else '.json'}"
    link.symlink_to(device)
    got: list[bytes] = []

    def read() -> None:
        while b"\x04" not in b"".join(got):
            got.append(os.read(controller, 4096))

    reader = threading.Thread(target=read, daemon=True)
    reader.start()
    assert main([*VALIDATE.split(), option, str(link)]) == 1
    os.write(terminal, b"\x04")
    reader.join(60)
    text = b"".join(got).decode()
    assert ("file,row,valid" if option == "--output" else '"states": 300') in text
    assert device.is_char_device()
    assert link.is_symlink()


def _in_a_shell(command: str) -> subprocess.CompletedProcess[str]:
    run = command.replace("plannercheck", f"{sys.executable} -m plannercheck")
    return subprocess.run(["bash", "-c", run], capture_output=True, text=True, check=False, timeout=120)


def test_process_substitution(folder):
    ran = _in_a_shell(
        f"set -o pipefail; plannercheck {VALIDATE} --summary >(cat > got.json) > table; code=$?; wait; exit $code"
    )
    assert ran.returncode == 1, ran.stderr
    assert json.loads(Path("got.json").read_text())["states"] == 300
    assert sorted(path.name for path in folder.iterdir()) == ["got.json", "set.npy", "table"]


def test_an_open_descriptor_goes_on_behind_what_is_written(folder):
    ran = _in_a_shell(
        f"exec 3> log; echo first >&3; plannercheck {VALIDATE} --summary /dev/fd/3 > table; echo last >&3"
    )
    assert ran.returncode == 0, ran.stderr
    first, *text, last = Path("log").read_text().splitlines()
    assert (first, last) == ("first", "last")
    assert json.loads("\n".join(text))["states"] == 300


def test_a_page_on_standard_output_is_the_page_alone(folder):
    ran = _in_a_shell("plannercheck view --robot panda --html /dev/stdout > page.html")
    assert ran.returncode == 0, ran.stderr
    assert main(["view", "--robot", "panda", "--html", "other.html"]) == 0
    assert Path("page.html").read_bytes() == Path("other.html").read_bytes()


def test_a_full_device_is_an_error(folder):
    ran = _in_a_shell(f"plannercheck {VALIDATE} --summary /dev/fd/3 3> /dev/full")
    assert ran.returncode == 2
    assert ran.stderr.endswith("error: file '/dev/fd/3' can't be written: No space left on device\n")


def test_what_is_no_file_has_no_journal_to_go_on_with(folder):
    os.mkfifo("pipe.csv")
    ran = _in_a_shell(f"plannercheck {VALIDATE} --output pipe.csv --resume")
    assert (ran.returncode, "can't go on with 'pipe.csv', which is no file" in ran.stderr) == (2, True)


def test_a_link_into_a_folder_that_is_missing_is_told_before_the_work(folder):
    (folder / "link.csv").symlink_to("nowhere/target.csv")
    ran = _in_a_shell(f"plannercheck {VALIDATE} --output link.csv")
    assert ran.returncode == 2
    assert "file 'link.csv' can't be written: there is no folder" in ran.stderr
    assert "nowhere" in ran.stderr


@pytest.fixture
def full_disk(folder):
    """A disk without room, of the test's own; where nobody may mount one, a limit on the size of files."""
    disk = folder / "disk"
    disk.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=4k", "tmpfs", str(disk)], capture_output=True, check=False
    )
    (disk / "all").write_bytes(bytes(4096) if mounted.returncode == 0 else b"")
    yield disk, "" if mounted.returncode == 0 else "trap '' XFSZ; ulimit -f 0; "
    if mounted.returncode == 0:
        subprocess.run(["umount", str(disk)], check=True)


@pytest.mark.parametrize(("option", "resume"), [("--output {}/o.csv", ""), ("--summary {}/o.json", " --resume")])
def test_a_full_disk_leaves_no_journal_of_a_run_that_never_was(full_disk, option, resume):
    """Found by an audit: the empty journal was an unfinished run for the next one."""
    disk, limit = full_disk
    ran = _in_a_shell(f"{limit}plannercheck {VALIDATE} {option.format(disk)}{resume}")
    assert ran.returncode == 2
    assert "o.csv.progress' can't be written" in ran.stderr or "o.json.progress' can't be written" in ran.stderr
    assert "unfinished" not in ran.stderr
    assert [path.name for path in disk.iterdir()] == ["all"]


def test_an_empty_file_is_no_unfinished_run(folder):
    Path("o.csv.progress").touch()
    ran = _in_a_shell(f"plannercheck {VALIDATE} --output o.csv")
    assert (ran.returncode, ran.stderr) == (1, "")


@pytest.mark.parametrize(
    ("asked", "unbuffered"),
    [("--help", ""), ("--help", "1"), ("validate --help", "1"), ("--version", ""), ("--print-completion bash", "")],
)
def test_help_that_can_not_be_written_is_no_success(asked, unbuffered, monkeypatch):
    """Found by an audit: `--help > /dev/full` ended with 0."""
    monkeypatch.setenv("PYTHONUNBUFFERED", unbuffered)
    ran = _in_a_shell(f"plannercheck {asked} > /dev/full")
    assert (ran.returncode, ran.stderr) == (3, "plannercheck: error: could not finish: No space left on device\n")
    if asked.startswith("--help"):
        assert _in_a_shell(f"plannercheck {asked} | head -c 1; exit ${{PIPESTATUS[0]}}").returncode in (0, 141)
        assert _in_a_shell(f"plannercheck {asked} >&-").returncode == 0


def test_a_closed_standard_input_is_bad_input():
    ran = _in_a_shell("plannercheck validate --robot panda - --progress none <&-")
    assert (ran.returncode, ran.stderr) == (2, "plannercheck: error: standard input: is closed\n")


@pytest.mark.parametrize("closed", ["<&-", ">&-", "2>&-", "<&- >&- 2>&-"])
def test_no_file_takes_the_place_of_a_closed_stream(folder, closed):
    ran = _in_a_shell(f"plannercheck {VALIDATE} --output o.csv {closed}")
    assert ran.returncode == 1
    assert main([*VALIDATE.split(), "--output", "right.csv"]) == 1
    assert Path("o.csv").read_bytes() == Path("right.csv").read_bytes()
