"""What other libraries leave in a thread's floating-point unit changes no verdict; large angles ask no C library.

Directions of rounding, and denormals taken for zero, are set from here by way of the C library, in the main thread and
in another; all that the core gives must have the same bits. Sines and cosines are held against mpmath.
"""

import ctypes
import platform
import re
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import mpmath
import numpy as np
import pytest

import plannercheck as pc
from plannercheck import planar

SOURCES = Path(__file__).parents[2] / "plannercheck" / "cpp"

# Bits of MXCSR: towards minus and plus infinity, towards 0; denormal results, and operands, are zero.
MODES = {"down": 0x2000, "up": 0x4000, "cut": 0x6000, "flush": 0x8040, "flush up": 0xC040}
MXCSR = 28  # bytes into fenv_t of x86-64 Linux

needs_mxcsr = pytest.mark.skipif(
    sys.platform != "linux" or platform.machine() != "x86_64", reason="sets MXCSR through glibc"
)


@contextmanager
def mode(bits: int) -> Iterator[None]:
    libm = ctypes.CDLL("libm.so.6")
    before, other = (ctypes.create_string_buffer(64) for _ in range(2))
    libm.fegetenv(before)
    libm.fegetenv(other)
    word = ctypes.c_uint32.from_buffer(other, MXCSR)
    word.value |= bits
    libm.fesetenv(other)
    try:
        yield
    finally:
        libm.fesetenv(before)


def control() -> int:
    """The bits of MXCSR that are set, exceptions that have happened aside."""
    now = ctypes.create_string_buffer(64)
    ctypes.CDLL("libm.so.6").fegetenv(now)
    return ctypes.c_uint32.from_buffer(now, MXCSR).value & ~0x3F


class Everything:
    """One query of each kind, for robots in space and in the plane."""

    def __init__(self) -> None:
        self.checker = pc.Checker(pc.Robot.load("panda"), pc.Scene.load("bookshelf"))
        self.rows = self.checker.robot.random_configurations(300, 3)
        self.beyond = self.rows * 1e7
        self.planar = planar.Checker(planar.Robot.load("truck_trailer"), planar.Scene.load("parking"))
        self.drives = self.planar.robot.random_configurations(200, 3)
        self.judge = self.checker.state_validity()
        self.body, self.other = (pc.Polytope(self.rows[k : k + 40, :3]) for k in (0, 50))

    def asked(self) -> list[bytes]:
        """Bits of all answers."""
        q, checker = self.rows, self.checker
        answers = [
            checker.robot.link_poses(q),
            checker.robot.link_poses(self.beyond),
            checker.check_states(q),
            checker.check_states(q, threads=2),
            checker.first_colliding_pair(self.beyond),
            np.array([checker.is_valid(row) for row in q]),
            checker.clearances(q[:20]),
            checker.check_motions(q[:20], q[20:40]),
            checker.body_poses(q[:20]),
            self.planar.check_states(self.drives),
            self.planar.robot.link_poses(self.drives),
            np.array([pc.intersects(self.body, self.other), pc.intersects(self.body, self.body)]),
        ]
        return [np.asarray(answer).tobytes() for answer in answers]


@pytest.fixture(scope="module")
def everything() -> Everything:
    return Everything()


@needs_mxcsr
@pytest.mark.parametrize("name", MODES)
@pytest.mark.parametrize("elsewhere", [False, True])
def test_what_a_thread_has_set_changes_no_bit(everything, name, elsewhere):
    right, found = everything.asked(), []

    def ask() -> None:
        with mode(MODES[name]):
            one, tiny = np.float64(1.0), np.float64(2.0**-53)
            assert control() & MODES[name] == MODES[name]
            if name in ("up", "flush up"):
                assert one + tiny > 1.0  # the mode acts, also on NumPy
            found.append(everything.asked())
            found.append(control() & MODES[name])

    if elsewhere:
        thread = threading.Thread(target=ask)
        thread.start()
        thread.join()
    else:
        ask()
    answers, after = found
    assert [k for k, (a, b) in enumerate(zip(answers, right, strict=True)) if a != b] == []
    assert after == MODES[name]  # what the thread had is given back
    assert control() == 0x1F80


@needs_mxcsr
@pytest.mark.parametrize("name", MODES)
def test_bodies_of_denormal_size_are_told_apart_whatever_is_flushed(name):
    """Integers times 2^-1060 are exact, and what they share does not depend on the scale."""
    rng = np.random.default_rng(0)
    verdicts = []
    for _ in range(60):
        flat = [corners.astype(float) for corners in rng.integers(-4, 5, (2, 3, 2))]
        flat = [corners for corners in flat if np.linalg.matrix_rank(corners[1:] - corners[0]) == 2]
        solid = [corners + np.array([0.0, 0.0, 3.0 * k]) for k, corners in enumerate(rng.integers(-4, 5, (2, 6, 3)))]
        flat = [np.vstack([each, each[:1]]) for each in flat]  # the last vertex repeats the first
        tiny, bodies = [each * 2.0**-1060 for each in flat], [pc.Polytope(each * 2.0**-1060) for each in solid]
        with mode(MODES[name]):
            found = pc.intersects(*bodies), planar.intersects(*tiny) if len(tiny) == 2 else None
        right = pc.intersects(*map(pc.Polytope, solid)), planar.intersects(*flat) if len(flat) == 2 else None
        verdicts.append(found)
        assert found == right
    assert len(set(verdicts)) > 3


def test_every_function_for_python_sees_to_the_mode():
    opening = re.compile(r"(?:\.def|\.def_static|\bcpp_function)\(")
    found, bare = 0, []
    for path in sorted(SOURCES.glob("bindings/bind*.cpp")):
        text = path.read_text()
        for match in opening.finditer(text):
            depth, end = 1, match.end()
            while depth:
                depth += {"(": 1, ")": -1}.get(text[end], 0)
                end += 1
            found += 1
            if not re.search(r"\bplain_floats\)$", text[match.end() : end]):
                bare.append(f"{path.name}: {text[match.start() : match.end() + 40]}")
    assert found > 60
    assert bare == []


@pytest.fixture(scope="module")
def wheel(tmp_path_factory) -> pc.Robot:
    """One joint that turns a bodiless link about z, by up to 1e15 rad."""
    urdf = tmp_path_factory.mktemp("wheel") / "wheel.urdf"
    joint = (
        '<joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>'
        '<limit lower="-1e15" upper="1e15" effort="1" velocity="1"/></joint>'
    )
    urdf.write_text(f'<robot name="wheel"><link name="a"/><link name="b"/>{joint}</robot>')
    with pytest.warns(RuntimeWarning, match="no <collision> elements"):
        return pc.Robot.from_urdf(urdf)


def angles() -> np.ndarray:
    """Of all sizes up to 1e15 rad: at random, next to multiples of pi/2, and at the ends of each reduction."""
    rng = np.random.default_rng(0)
    spread = 10 ** rng.uniform(5.9, 15, 2000) * rng.choice([-1, 1], 2000)
    with mpmath.workprec(300):
        close = [float(mpmath.pi / 2 * int(k)) for k in rng.integers(10**6, 6 * 10**14, 2000)]
    ends = [1e6, np.nextafter(1e6, 2e6), 1e15, 2.0**40, 2.0**49, 6381956970095103.0 * 2.0**-4]
    return np.clip(np.concatenate([spread, close, np.negative(close), ends, np.negative(ends)]), -1e15, 1e15)


def sine_and_cosine(wheel: pc.Robot, q: np.ndarray) -> np.ndarray:
    assert wheel.kinematics is not None  # else Pinocchio poses, by the C library
    poses = wheel.link_poses(q[:, None])[:, wheel.link_index("b")]
    assert np.array_equal(poses[:, 1, 0], -poses[:, 0, 1])
    return poses[:, [1, 0], 0]


def test_large_angles_err_by_no_more_than_is_counted(wheel):
    from plannercheck.robots.kinematic_error import _SINCOS

    assert _SINCOS > 0.8
    q = angles()
    found = sine_and_cosine(wheel, q)
    with mpmath.workprec(300):
        for angle, (sine, cosine) in zip(q.tolist(), found.tolist(), strict=True):
            exact = mpmath.mpf(angle)
            for value, true in ((sine, mpmath.sin(exact)), (cosine, mpmath.cos(exact))):
                assert abs(value - true) <= 0.8 * 2.0**-53, angle  # 0.72 is the largest found; 1.00 without the tail
                assert abs(value - true) <= 2.0**-50 * abs(true) + 2.0**-110, angle  # also where it is nearly 0


def test_a_large_angle_has_the_same_bits_in_all_company(wheel):
    q = angles()
    alone = np.array([sine_and_cosine(wheel, q[k : k + 1])[0] for k in range(0, len(q), 7)])
    assert np.array_equal(sine_and_cosine(wheel, q)[::7], alone)
    mixed = np.stack([q[::7], np.full(len(alone), 0.3)], axis=1).ravel()
    assert np.array_equal(sine_and_cosine(wheel, mixed)[::2], alone)


def test_large_angles_are_the_same_on_every_machine(wheel):
    """Nearest doubles of exact values, computed once in 300 bits; a C library may round them another way."""
    q = np.array([1e15, 999999999999999.9, 123456789012345.6, 2.0**49, 1e6 + 0.5])
    with mpmath.workprec(300):
        exact = [[float(mpmath.sin(mpmath.mpf(a))), float(mpmath.cos(mpmath.mpf(a)))] for a in q.tolist()]
    assert np.abs(sine_and_cosine(wheel, q) - exact).max() <= 2.0**-53


def test_no_angle_is_handed_to_the_c_library():
    for name in ("sincos.hpp", "lane_pose.hpp", "kinematics_2d.cpp", "motion_grid_2d.cpp", "large_angle.cpp"):
        text = re.sub(r"//.*", "", next(SOURCES.glob(f"*/{name}")).read_text())
        assert not re.search(r"\bstd::(sin|cos|tan|fmod|remainder)\b", text), name
