"""Threads that calls leave to later calls: in a process of their own, where no other test has started any."""

import os
import subprocess
import sys
from pathlib import Path

PREPARED = '''
import os, resource, signal, time
import plannercheck as pc

checker = pc.Checker(pc.Robot.load("panda"), pc.Scene.load("bookshelf"))
q = checker.robot.random_configurations(2000, 1)
alone = checker.check_states(q).tobytes()

def threads():
    return len(os.listdir("/proc/self/task"))

def settled(most):
    """How many threads there are, once those that end have ended."""
    end = time.monotonic() + 20
    while threads() > most and time.monotonic() < end:
        time.sleep(0.01)
    time.sleep(0.3)
    return threads()

def judged(count):
    return checker.check_states(q, threads=count).tobytes() == alone
'''


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
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr


def test_no_more_threads_are_kept_than_there_are_cores(tmp_path: Path) -> None:
    run(
        """
before = threads()
most = before + os.cpu_count()
assert all(judged(count) for count in (2, 3, 64, 2, 64, 64))
assert before < settled(most) <= most
assert all(judged(2) for _ in range(50))
assert before < settled(most) <= most
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


def test_forks_with_their_parents_pid_start_threads_of_their_own(tmp_path: Path) -> None:
    """Found by an audit: each of the two is the first process of its namespace, as in containers."""
    run(
        """
import ctypes, sys

def first_process_of_a_namespace(work, flags):
    libc = ctypes.CDLL(None, use_errno=True)
    assert libc.unshare(flags) == 0, os.strerror(ctypes.get_errno())
    child = os.fork()
    if child == 0:
        try:
            assert os.getpid() == 1
            work()
        except BaseException as error:
            print(repr(error), file=sys.stderr, flush=True)
            os._exit(1)
        os._exit(0)
    end = time.monotonic() + 30
    while (ended := os.waitpid(child, os.WNOHANG)) == (0, 0):
        if time.monotonic() > end:  # it waits for a thread of its parent's
            os.kill(child, signal.SIGKILL)
        time.sleep(0.01)
    assert ended[1] == 0

def judge():
    assert judged(2) and threads() > 1

def judge_and_fork():
    judge()
    first_process_of_a_namespace(judge, NEW_PIDS)

NEW_PIDS, NEW_USERS = 0x20000000, 0x10000000  # CLONE_NEWPID; CLONE_NEWUSER, in which anyone may make others
first_process_of_a_namespace(judge_and_fork, NEW_PIDS if os.geteuid() == 0 else NEW_PIDS | NEW_USERS)
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
    said = str(error).split()
    assert str(error) == f"the system has {said[3]} of the {said[6]} threads asked for: ask for fewer", error
    assert 1 < int(said[3]) < int(said[6]) <= 64, error
else:
    raise AssertionError("threads without memory for their stacks")
resource.setrlimit(resource.RLIMIT_AS, free)
assert judged(64) and judged(2)
""",
        tmp_path,
    )


def test_threads_run_on_the_processors_of_their_caller_and_as_nice(tmp_path: Path) -> None:
    run(
        """
def others():
    rows = [int(name) for name in os.listdir("/proc/self/task") if int(name) not in before]
    return [(os.sched_getaffinity(row), os.getpriority(os.PRIO_PROCESS, row)) for row in rows]

before = {int(name) for name in os.listdir("/proc/self/task")}
most = len(before) + os.cpu_count()
everywhere = os.sched_getaffinity(0)
for processors, nicer in (({min(everywhere)}, 0), (everywhere, 0), (everywhere, 3), ({max(everywhere)}, 0)):
    os.sched_setaffinity(0, processors)
    nice = os.nice(nicer)
    assert judged(2) and judged(2)
    settled(most)
    assert others() and all(each == (processors, nice) for each in others()), (processors, nice, others())
""",
        tmp_path,
    )


def test_threads_have_the_scheduling_policy_of_their_caller(tmp_path: Path) -> None:
    """Found by an audit: threads of a real-time call kept its policy after the process had given it up."""
    run(
        """
def others():
    rows = [int(name) for name in os.listdir("/proc/self/task") if int(name) not in before]
    return [(os.sched_getscheduler(row), os.sched_getparam(row).sched_priority) for row in rows]

before = {int(name) for name in os.listdir("/proc/self/task")}
most = len(before) + os.cpu_count()
wanted = [(os.SCHED_FIFO, 1), (os.SCHED_FIFO, 2), (os.SCHED_RR, 1), (os.SCHED_BATCH, 0), (os.SCHED_OTHER, 0)]
seen = []
for policy, priority in wanted:
    try:
        os.sched_setscheduler(0, policy, os.sched_param(priority))
    except PermissionError:  # real-time policies are for root
        continue
    assert judged(2) and judged(2)
    settled(most)
    assert others() and all(each == (policy, priority) for each in others()), (policy, priority, others())
    seen.append((policy, priority))
assert seen[-2:] == wanted[-2:]
""",
        tmp_path,
    )
