"""Threads that calls leave to later calls: in a process of their own, where no other test has started any."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

PREPARED = """
import os, resource, signal, time
import plannercheck as pc

checker = pc.Checker(pc.Robot.load("panda"), pc.Scene.load("bookshelf"))
q = checker.robot.random_configurations(2000, 1)
alone = checker.check_states(q).tobytes()

def threads():
    return len(os.listdir("/proc/self/task"))

def judged(count):
    return checker.check_states(q, threads=count).tobytes() == alone
"""


def run(script: str, folder: Path) -> None:
    """Runs Python code after what is prepared, in a process without OpenBLAS's threads; it fails by its exit code."""
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1"}
    # From a folder without sources: Python would take these for the installed package.
    done = subprocess.run(
        [sys.executable, "-c", PREPARED + script],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr


def test_no_more_threads_are_kept_than_there_are_cores(tmp_path: Path) -> None:
    run(
        """
before = threads()
assert all(judged(count) for count in (2, 3, 64, 2, 64, 64))
end = time.monotonic() + 10
while threads() > before + os.cpu_count() and time.monotonic() < end:
    time.sleep(0.01)
kept = threads() - before
assert 1 <= kept <= os.cpu_count(), kept
assert all(judged(2) for _ in range(50))
assert threads() - before <= os.cpu_count()
""",
        tmp_path,
    )


def test_forks_start_threads_of_their_own(tmp_path: Path) -> None:
    run(
        """
assert judged(3)
child = os.fork()
if child == 0:
    signal.alarm(30)  # a call that waited for a thread of the parent's would never end
    os._exit(0 if judged(3) and judged(2) and threads() > 1 else 1)
assert os.waitpid(child, 0)[1] == 0
assert judged(3)
""",
        tmp_path,
    )


def test_kept_threads_take_no_signals(tmp_path: Path) -> None:
    run(
        """
assert judged(3) and threads() > 1
signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGUSR1])  # where another thread took it, it would end the process
for _ in range(20):
    os.kill(os.getpid(), signal.SIGUSR1)
    assert signal.sigtimedwait([signal.SIGUSR1], 10).si_signo == signal.SIGUSR1
""",
        tmp_path,
    )


def test_a_call_that_gets_no_more_threads_says_so_and_the_next_one_may(tmp_path: Path) -> None:
    run(
        """
assert judged(2)
used = int(open("/proc/self/statm").read().split()[0]) * os.sysconf("SC_PAGE_SIZE")
free = resource.getrlimit(resource.RLIMIT_AS)
resource.setrlimit(resource.RLIMIT_AS, (used + (16 << 20), free[1]))  # a thread takes 8 MiB of addresses for its stack
try:
    checker.check_states(q, threads=64)
except RuntimeError as error:
    assert "unavailable" in str(error), error
else:
    raise AssertionError("threads without memory for their stacks")
resource.setrlimit(resource.RLIMIT_AS, free)
assert judged(64) and judged(2)
""",
        tmp_path,
    )
