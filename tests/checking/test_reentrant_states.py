"""Verdicts for planners while reading a state runs Python, which switches threads or asks again from within.

A state is whatever answers `state[k]`; OMPL's own do so in C++, but `__getitem__` and `__float__` may be Python's, and
a garbage collection may run a finaliser anywhere. No call may see another one's numbers.
"""

import subprocess
import sys
import threading
import time
from itertools import pairwise

import numpy as np
import pytest

import plannercheck as pc
from plannercheck import planar
from plannercheck.ompl.planar_space import PlanarSpace
from plannercheck.planar import curves as curves_module

THREADS, STATES = 6, 60


class Asking:
    """A state that does something else before it gives its number k."""

    def __init__(self, q, k, something):
        self.q, self.k, self.something = q.tolist(), k, something

    def __getitem__(self, k):
        if k == self.k:
            self.something()
        return self.q[k]


class Number:
    """A number that does something else before it says which."""

    def __init__(self, value, something):
        self.value, self.something = value, something

    def __float__(self):
        self.something()
        return self.value


@pytest.fixture(scope="module")
def states(checker):
    q = checker.robot.random_configurations(2 * STATES, 7)
    q[::9] = checker.robot.upper + 0.1  # the full table judges these
    valid = np.array([checker.is_valid(row) for row in q])
    assert valid.any()
    assert not valid.all()
    return q, valid


@pytest.fixture(scope="module")
def motions(checker, states):
    q0 = states[0][1::2]
    q1 = q0 + 0.2 * np.roll(q0, 1, axis=0) - 0.2 * q0
    q1[::11] = checker.robot.upper + 0.2
    free = checker.check_motions(q0, q1)
    assert free.any()
    assert not free.all()
    return q0, q1, free


@pytest.mark.parametrize("k", [0, 3, 6])
def test_a_state_whose_numbers_ask_for_another_state(checker, states, k):
    judge, (q, valid) = checker.state_validity(), states
    within = []
    for i, row in enumerate(q):
        other = -1 - i
        found = judge(Asking(row, k, lambda other=other: within.append(judge(q[other].tolist()) == valid[other])))
        assert found == valid[i]
    assert len(within) == len(q)
    assert all(within)


def test_a_state_of_numbers_that_ask_for_another_state(checker, states):
    judge, (q, valid) = checker.state_validity(), states
    for i, row in enumerate(q):
        numbers = row.tolist()
        numbers[-1] = Number(numbers[-1], lambda i=i: judge(q[-1 - i].tolist()))
        assert judge(numbers) == valid[i]


@pytest.mark.parametrize("k", [0, 6])
def test_a_motion_whose_numbers_ask_for_another_motion(checker, motions, k):
    judge, (q0, q1, free) = checker.motion_certifier.motion_validity(1e-4), motions
    for i in range(len(q0)):
        other = -1 - i

        def ask(other=other):
            assert judge(q0[other].tolist(), q1[other].tolist()) == free[other]

        assert judge(Asking(q0[i], k, ask), q1[i].tolist()) == free[i]
        assert judge(q0[i].tolist(), Asking(q1[i], k, ask)) == free[i]


def wrong_of_threads(count, work):
    """Runs work(k), which yields what went wrong, on so many threads at once."""
    wrong, start = [], threading.Barrier(count)

    def run(k):
        start.wait()
        wrong.extend(work(k))

    threads = [threading.Thread(target=run, args=(k,)) for k in range(count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return wrong


def test_states_whose_numbers_switch_threads(checker, states):
    judge, (q, valid) = checker.state_validity(), states

    def work(k):
        for i in np.random.default_rng(k).permutation(len(q)).tolist():
            if judge(Asking(q[i], i % 7, lambda: time.sleep(0))) != valid[i]:
                yield i

    assert wrong_of_threads(THREADS, work) == []


def test_motions_whose_numbers_switch_threads(checker, motions):
    judge, (q0, q1, free) = checker.motion_certifier.motion_validity(1e-4), motions

    def work(k):
        for i in np.random.default_rng(k).permutation(len(q0)).tolist():
            ends = (Asking(q[i], i % 7, lambda: time.sleep(0)) for q in (q0, q1))
            if judge(*ends) != free[i]:
                yield i

    assert wrong_of_threads(THREADS, work) == []


def test_states_of_more_numbers_than_the_stack_holds(tmp_path):
    joints = "".join(
        f'<link name="l{k}"/><joint name="j{k}" type="prismatic"><parent link="l{k}"/><child link="l{k + 1}"/>'
        f'<axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
        for k in range(99)
    )
    box = '<link name="l99"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>'
    (tmp_path / "slide.urdf").write_text(f'<robot name="slide">{joints}{box}</robot>')
    scene, wall = pc.Scene("wall"), np.eye(4)
    wall[0, 3] = 0.5
    scene.add_box("wall", [0.1, 1, 1], wall)
    checker = pc.Checker(pc.Robot.from_urdf(tmp_path / "slide.urdf"), scene)
    judge, prove = checker.state_validity(), checker.motion_certifier.motion_validity(1e-4)
    rows = 0.5 * np.eye(99)
    for k in (0, 63, 64, 98):  # each number counts
        assert not judge(rows[k].tolist())
    still = np.zeros(99)
    assert judge(Asking(still, 70, lambda: judge(rows[0].tolist())))
    assert prove(Asking(still, 70, lambda: judge(rows[0].tolist())), still.tolist())
    assert not prove(still.tolist(), Asking(rows[98], 98, lambda: prove(still.tolist(), still.tolist())))


@pytest.fixture
def curved():
    space = PlanarSpace(planar.Robot.load("forklift").with_bounds([-5, -5], [5, 5]), "reeds_shepp", 1.5)
    ompls = space.ompl_space()
    rng = np.random.default_rng(3)
    q = rng.uniform([-3, -3, -3], [3, 3, 3], (40, 3))
    states = [ompls.allocState() for _ in q]
    for state, row in zip(states, q, strict=True):
        space.write(state, row)
    return space, q, states


def test_sampled_curves_that_are_asked_for_within_one_another(curved, monkeypatch):
    space, _, states = curved
    parameters = np.linspace(0, 1, 9)
    plain = [space.curve_states(a, b, parameters) for a, b in pairwise(states)]
    read, deep = space.read, []

    def asking(state):  # between OMPL's writing a state and our reading it
        if not deep:
            deep.append(True)
            space.curve_states(states[-1], states[0], parameters)
            deep.clear()
        return read(state)

    monkeypatch.setattr(space, "read", asking)
    for (a, b), expected in zip(pairwise(states), plain, strict=True):
        np.testing.assert_array_equal(space.curve_states(a, b, parameters), expected)


def test_curves_taken_apart_within_one_another(curved, monkeypatch):
    space, q, _ = curved
    curves, plain = space.curves, [space.curves.pieces(a, b, 1.0) for a, b in pairwise(q)]
    place, deep = curves_module._Cells.cell, []

    def asking(self, a, b):
        if not deep:
            deep.append(True)
            curves.pieces(q[-1], q[0], 1.0)
            deep.clear()
        return place(self, a, b)

    monkeypatch.setattr(curves_module._Cells, "cell", asking)
    for (a, b), expected in zip(pairwise(q), plain, strict=True):
        np.testing.assert_array_equal(curves.pieces(a, b, 1.0), expected)


def test_sampled_curves_of_many_threads(curved):
    space, _, states = curved
    parameters = np.linspace(0, 1, 30)
    plain = [space.curve_states(a, b, parameters) for a, b in pairwise(states)]

    def work(k):
        for i in np.random.default_rng(k).permutation(len(plain)).tolist():
            if not np.array_equal(space.curve_states(states[i], states[i + 1], parameters), plain[i]):
                yield i

    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        assert wrong_of_threads(THREADS, work) == []
    finally:
        sys.setswitchinterval(before)


COLLECTING = """
import gc
import numpy as np
import plannercheck as pc
from plannercheck import planar

space = pc.Checker(pc.Robot.load("panda"), pc.Scene.load("bookshelf"))
plane = planar.Checker(planar.Robot.load("forklift"), planar.Scene.load("warehouse"))
asked, kept = [], []
for checker in (space, plane):
    q = checker.robot.random_configurations(4, 1)
    free = checker.check_motion(q[0], q[1])
    counts = (checker.statistics, checker.motion_certifier.statistics)

    def ask(phase, info):
        if phase == "start":
            asked.append(checker.check_states(q))
            asked.append(checker.check_motion(q[0], q[1]) == free)
            kept.extend({} for _ in range(1000))  # none is left over that Python would use again

    gc.callbacks.append(ask)
    kept.extend({} for _ in range(1000))
    for count in counts:
        gc.set_threshold(1)  # any object that Python makes may now collect, and so ask
        count()
        gc.set_threshold(0)
    gc.callbacks.remove(ask)
print("done", len(asked), flush=True)
"""


def test_counters_while_a_collection_asks_for_states():
    # The core's counters become a dict, which may collect, which may run any finaliser: no lock is held meanwhile.
    run = subprocess.run([sys.executable, "-c", COLLECTING], capture_output=True, text=True, timeout=60, check=False)
    assert run.returncode == 0, run.stderr
    assert run.stdout.startswith("done")


COMPILING = """
import plannercheck as pc
from plannercheck.checking import compiled_tables

robot = pc.Robot.load("panda")
checker = pc.Checker(robot, pc.Scene.load("bookshelf"))
beyond = robot.upper[None] + 0.1  # needs the full table, which the first caller compiles
compiled, asked = compiled_tables.CompiledPairs, []

def asking(*arguments):  # as a finaliser may while it compiles
    if not asked:
        asked.append(None)
        asked[0] = bool(checker.check_states(beyond)[0])
    return compiled(*arguments)

compiled_tables.CompiledPairs = asking
assert [bool(checker.check_states(beyond)[0])] == asked
"""


def test_a_state_beyond_the_limits_while_the_full_table_is_compiled():
    run = subprocess.run([sys.executable, "-c", COMPILING], capture_output=True, text=True, timeout=60, check=False)
    assert run.returncode == 0, run.stderr
