"""Ctrl-C ends every long call within half a second, from Python and in commands; outputs are whole or not there."""

import contextlib
import gc
import os
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import plannercheck as pc

# s: before the signal comes, and from then to the end. Half a second is meant, the machine may be busy.
BEGUN, AT_MOST, COMMAND_AT_MOST = 0.5, 1.0, 1.5


@pytest.fixture(autouse=True)
def _alarm_as_ctrl_c():
    """A timer of the system, which needs no thread that waits for the GIL.

    An interrupt that comes while a callback of the garbage collector runs, as Hypothesis has one, is lost there.
    """
    before, callbacks = signal.signal(signal.SIGALRM, signal.default_int_handler), gc.callbacks[:]
    gc.callbacks.clear()
    yield
    signal.setitimer(signal.ITIMER_REAL, 0)
    gc.callbacks.extend(callbacks)
    signal.signal(signal.SIGALRM, before)


def ends_by_ctrl_c(call, clocks=(time.perf_counter, time.process_time)):
    """Late is what is late by all clocks: of the clock on the wall, a busy machine gives this process little."""
    began = [clock() for clock in clocks]
    signal.setitimer(signal.ITIMER_REAL, BEGUN, AT_MOST / 2)  # again, as Python loses an interrupt in a destructor
    with pytest.raises(KeyboardInterrupt):
        call()
    signal.setitimer(signal.ITIMER_REAL, 0)
    assert min(clock() - start for clock, start in zip(clocks, began, strict=True)) - BEGUN < AT_MOST


@pytest.fixture(scope="module")
def checker():
    """One that takes its time: some 20 µs a state."""
    switches = dict.fromkeys(["bounds", "boxes", "overlaps", "cached_plane", "centre_axis"], False)
    return pc.Checker(pc.Robot.load("panda"), pc.Scene.load("bookshelf"), tuning=pc.Tuning(**switches))


@pytest.fixture(scope="module")
def q(checker):
    return checker.robot.random_configurations(600_000, 0)


@pytest.fixture(scope="module")
def free(checker, q):
    few = q[:500]
    return few[checker.check_states(few)]


@pytest.mark.parametrize("threads", [1, 3])
@pytest.mark.parametrize("name", ["check_states", "first_colliding_pair"])
def test_sets(checker, q, name, threads):
    ends_by_ctrl_c(lambda: getattr(checker, name)(q, threads=threads))


@pytest.mark.parametrize("threads", [1, 3])
def test_motions(checker, q, threads):
    ends_by_ctrl_c(lambda: checker.check_motions(q[:-1], q[1:], threads=threads))


def test_one_motion_of_very_many_states(checker, free):
    ends_by_ctrl_c(lambda: checker.check_motion(free[0], free[0] + 1e-4, resolution=1e-12))


def test_proofs(checker, free):
    pytest.importorskip("flint")
    starts = np.tile(free, (200, 1))
    ends_by_ctrl_c(lambda: checker.certify_motions(starts, starts + 1e-3))


def test_clearances(checker, q):
    ends_by_ctrl_c(lambda: checker.clearances(q[:50_000]))


def test_a_body_of_very_many_vertices():
    points = np.random.default_rng(0).normal(size=(800_000, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    ends_by_ctrl_c(lambda: pc.Polytope(points))


def test_convex_decomposition(monkeypatch):
    pc.Robot.load("ur10")  # what it imports is there: it had better not be broken off
    pytest.importorskip("coacd")  # after Pinocchio, which reads no URDF otherwise
    monkeypatch.setenv("PLANNERCHECK_CACHE", "0")
    decompose = partial(pc.Robot.load, "ur10", pc.Decomposition(threshold=0.02))
    ends_by_ctrl_c(decompose, clocks=(time.perf_counter,))  # another process works


def test_planar_sets():
    robot = pc.planar.Robot.load("truck_trailer")
    checker = pc.planar.Checker(robot, pc.planar.Scene.load("parking"), bounds=False, method="exact")
    q = robot.random_configurations(400_000, 0)
    ends_by_ctrl_c(lambda: checker.check_states(q))
    ends_by_ctrl_c(lambda: checker.check_motions(q[:-1], q[1:]))


def test_a_plan(checker, free):
    ends_by_ctrl_c(lambda: pc.ompl.plan(checker, free[0], free[-1], planner="RRTstar", time_limit=30, seed=1))


def test_what_a_thread_learnt_before_serves_after(checker, q):
    ends_by_ctrl_c(lambda: checker.check_states(q))
    assert np.array_equal(checker.check_states(q[:500]), [checker.is_valid(row) for row in q[:500]])


COMMANDS = {
    "validate": ["validate", "--robot", "panda", "--scene", "bookshelf", "{set}", "--output", "{out}/v.csv"],
    "explained": [
        "validate",
        "--robot",
        "panda",
        "--scene",
        "kitchen",
        "{set}",
        "--explain",
        "--output",
        "{out}/v.npz",
    ],
    "threads": ["validate", "--robot", "panda", "{set}", "--threads", "3", "--explain", "--output", "{out}/v.csv"],
    "plan": ["plan", "--robot", "panda", "--scene", "bookshelf", "--planner", "RRTstar", "--time", "60"],
    "stress": ["stress", "--pairs", "10000000"],
    "processes": ["stress", "--pairs", "10000000", "--processes", "2"],
    "motions": ["stress", "--motions", "100000"],
    "solids": ["stress", "--solids", "10000000"],
    "solids in processes": ["stress", "--solids", "10000000", "--processes", "2"],
    "acm": ["acm", "--robot", "pr2", "--states", "300000"],
    "inspect": ["inspect", "--robot", "panda", "--scene", "kitchen", "--states", "3000000"],
    "bench": ["bench", "pairs", "--output", "{out}"],
    "view": ["view", "--robot", "panda", "--path", "{set}", "--frames", "1000000", "--html", "{out}/page.html"],
}


def begun_command(words):
    """A command in a process of its own, from where its program begins."""
    run = "import sys; from plannercheck.cli.main import main; sys.stderr.write('begun\\n'); sys.exit(main())"
    process = subprocess.Popen(
        [sys.executable, "-c", run, *words],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    assert process.stderr is not None
    assert process.stderr.readline() == "begun\n"
    return process


@pytest.mark.parametrize("name", COMMANDS)
def test_commands(name, tmp_path, q):
    given = tmp_path / "q.npy"
    if any("{set}" in word for word in COMMANDS[name]):
        np.save(given, np.tile(q, (5, 1)) if name in ("validate", "threads") else q)
    (tmp_path / "out").mkdir()
    words = [word.format(set=given, out=tmp_path / "out") for word in COMMANDS[name]]
    process = begun_command(words)
    time.sleep(1.0)
    assert process.poll() is None, process.stderr.read()
    sent = time.perf_counter()
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does
    try:
        _, said = process.communicate(timeout=20)
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
    assert time.perf_counter() - sent < COMMAND_AT_MOST
    assert process.returncode == 130
    assert [line for line in said.splitlines() if "warning" not in line][-1:] != []
    assert said.count("interrupted") == 1, said
    assert "Traceback" not in said
    left = [path.name for path in (tmp_path / "out").iterdir() if path.is_file()]
    assert all(path.endswith(".progress") for path in left)


@pytest.mark.parametrize("run", ["--pairs", "--motions"])
def test_processes_that_have_just_begun_say_nothing(run):
    """Ctrl-C reaches them, too, while they load their modules, where no handler of ours is known yet."""
    process = begun_command(["stress", run, "10000000", "--processes", "2"])
    while not (begun := children_of(process.pid)):
        assert process.poll() is None
    time.sleep(0.1)  # Python's own handler is there
    assert begun <= children_of(process.pid)
    os.killpg(process.pid, signal.SIGINT)
    try:
        _, said = process.communicate(timeout=20)
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
    assert (process.returncode, said) == (130, "plannercheck: interrupted\n")


def children_of(number):
    """Processes that multiprocessing has begun for a process."""
    found = set()
    for path in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            parent = int((path / "stat").read_text().rpartition(")")[2].split()[1])
            if parent == number and b"spawn_main" in (path / "cmdline").read_bytes():
                found.add(int(path.name))
    return found


DAEMONS = """
import threading, time
import numpy as np
import plannercheck as pc
from plannercheck import _oracle as oracle

robot = pc.Robot.load("panda")
checker, q = pc.Checker(robot, pc.Scene.load("bookshelf")), robot.random_configurations(20_000, 0)
points = np.random.default_rng(0).normal(size=(2000, 3))
cloud, poses = oracle.Points(points[:20], 0.0), np.tile(np.eye(4), (2000, 1, 1))

def forever(call):
    while True:
        call()

for call in (
    lambda: checker.check_states(q),
    lambda: checker.check_states(q, threads=2),
    lambda: robot.link_poses(q),
    lambda: pc.Polytope(points),
    lambda: oracle.decide(cloud, poses, cloud, poses, True),
):
    threading.Thread(target=forever, args=(call,), daemon=True).start()
time.sleep(0.3)
"""


def test_daemon_threads_do_not_abort_the_process(tmp_path):
    """Python ends them by unwinding their stacks where they ask for its lock: no destructor may be in the way."""
    for _ in range(3):
        # From a folder without sources: Python would take these for the installed package.
        ended = subprocess.run(
            [sys.executable, "-c", DAEMONS], capture_output=True, text=True, timeout=60, cwd=tmp_path, check=False
        )
        assert (ended.returncode, ended.stderr) == (0, "")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_while_the_program_loads(number, tmp_path):
    """Compiled modules that load do not expect an exception: they make another of it, lose it, or abort."""
    from plannercheck.cli.main import INTERRUPTED, TERMINATED

    code, said = (INTERRUPTED, "interrupted") if number == signal.SIGINT else (TERMINATED, "terminated")
    for delay in np.linspace(0.05, 0.65, 5):
        process = begun_command(["stress", "--pairs", "10000000"])
        time.sleep(delay)
        process.send_signal(number)
        _, error = process.communicate(timeout=20)
        assert (process.returncode, error) == (code, f"plannercheck: {said}\n"), delay


LOST = """
import ctypes, os, signal, sys, time
import plannercheck.cli.robots as robots
from plannercheck.cli.main import main

class Dropping:  # as a compiled module does that clears every error of what it calls
    def __getattr__(self, name):
        os.kill(os.getpid(), signal.SIGINT)
        for _ in range(1000):
            pass

def run(options):
    has = ctypes.pythonapi.PyObject_HasAttrString
    has.argtypes = [ctypes.py_object, ctypes.c_char_p]
    print("dropped" if not has(Dropping(), b"anything") else "odd", flush=True)
    time.sleep(20)
    return 0

robots.run = run
sys.exit(main(["robots"]))
"""


def test_a_ctrl_c_that_a_library_drops_comes_again():
    began = time.perf_counter()
    ended = subprocess.run(
        [sys.executable, "-c", LOST],
        capture_output=True,
        text=True,
        timeout=60,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    assert (ended.returncode, ended.stdout, ended.stderr) == (130, "dropped\n", "plannercheck: interrupted\n")
    assert time.perf_counter() - began < 10


def test_the_callers_handlers_are_back_afterwards(capsys):
    from plannercheck.cli.main import main

    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    assert main(["robots"]) == 0
    assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)] == before


IMPORTING = """
import os, signal, sys, time
import plannercheck.cli.robots as robots
from plannercheck.cli.main import main

sys.path.insert(0, sys.argv.pop())

def run(options):
    import loads_slowly
    print("imported", flush=True)
    time.sleep(20)
    return 0

robots.run = run
sys.exit(main(["robots"]))
"""


def test_a_signal_waits_until_an_import_has_ended(tmp_path):
    """As compiled modules do, this one makes an error of its own of whatever is raised in it."""
    (tmp_path / "loads_slowly.py").write_text(
        "import os, signal, time\ntry:\n    os.kill(os.getpid(), signal.SIGINT)\n    time.sleep(0.2)\n"
        "except BaseException:\n    raise ImportError('lost') from None\n"
    )
    ended = subprocess.run(
        [sys.executable, "-c", IMPORTING, str(tmp_path)],
        capture_output=True,
        text=True,
        timeout=60,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    assert (ended.returncode, ended.stderr) == (130, "plannercheck: interrupted\n")
