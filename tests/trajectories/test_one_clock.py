"""Trajectories of several robots on one clock, held against rational and 50-digit arithmetic."""

from fractions import Fraction
from itertools import pairwise

import mpmath
import numpy as np
import pytest

import plannercheck as pc
from plannercheck.trajectories.curve import Curve
from plannercheck.trajectories.one_clock import on_one_clock

F = Fraction
mpmath.mp.dps = 50
pytestmark = pytest.mark.filterwarnings("ignore:.*nothing will ever collide")

_SLIDES = """<robot name="slides"><link name="base"/><link name="a"/><link name="b"/>
<joint name="x" type="prismatic"><parent link="base"/><child link="a"/><axis xyz="1 0 0"/>
  <limit lower="-9" upper="9" effort="1" velocity="1"/></joint>
<joint name="y" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/>
  <limit lower="-9" upper="9" effort="1" velocity="1"/></joint></robot>"""
_FREE = """<robot name="box"><link name="base"/><link name="body"/>
<joint name="root" type="floating"><parent link="base"/><child link="body"/></joint></robot>"""
_WHEEL = """<robot name="wheel"><link name="base"/><link name="rim"/>
<joint name="hub" type="continuous"><parent link="base"/><child link="rim"/><axis xyz="0 0 1"/></joint></robot>"""


@pytest.fixture(name="cell", scope="module")
def _cell(tmp_path_factory) -> pc.Robot:
    folder, robots = tmp_path_factory.mktemp("one_clock"), {}
    for name, text in (("left", _SLIDES), ("right", _SLIDES), ("box", _FREE), ("wheel", _WHEEL)):
        (folder / f"{name}.urdf").write_text(text)
        robots[name] = pc.Robot.from_urdf(folder / f"{name}.urdf"), np.eye(4)
    return pc.Robot.together(robots)


def together(cell: pc.Robot, names) -> pc.Robot:
    return pc.Robot.together({name: (cell.parts[name].robot, np.eye(4)) for name in names})


def polynomial(points, s: Fraction) -> Fraction:
    rows = [F(x) for x in points]
    while len(rows) > 1:
        rows = [a + (b - a) * s for a, b in pairwise(rows)]
    return rows[0]


def turned(a, b, s: Fraction) -> list:
    """Slerp at 50 digits."""
    a, b = ([mpmath.mpf(x) / mpmath.sqrt(mpmath.fsum(mpmath.mpf(y) ** 2 for y in q)) for x in q] for q in (a, b))
    dot = mpmath.fsum(x * y for x, y in zip(a, b, strict=True))
    if len(a) == 4 and dot < 0:
        b, dot = [-x for x in b], -dot
    across = [y - dot * x for x, y in zip(a, b, strict=True)]
    length = mpmath.sqrt(mpmath.fsum(x * x for x in across))
    angle = mpmath.atan2(length, dot) * (mpmath.mpf(s.numerator) / s.denominator)
    if length == 0:
        return a
    return [mpmath.cos(angle) * x + mpmath.sin(angle) * y / length for x, y in zip(a, across, strict=True)]


def exact_times(breaks) -> list[Fraction]:
    """A message's are whole nanoseconds."""
    stamps = [round(x * 1e9) for x in breaks.tolist()]
    is_message = all(k / 1e9 == x for k, x in zip(stamps, breaks.tolist(), strict=True))
    return [F(k, 10**9) for k in stamps] if is_message else [F(x) for x in breaks.tolist()]


def exact_state(curve: Curve, knots: list[Fraction], t: Fraction) -> list:
    """Of a curve at exact knots, standing before and after."""
    t = min(max(t, knots[0]), knots[-1])
    k = next(k for k in range(len(curve.pieces)) if t <= knots[k + 1])
    s = (t - knots[k]) / (knots[k + 1] - knots[k])
    q = [polynomial(column, s) for column in curve.pieces[k].T.tolist()]
    for a, b in curve.units:
        q[a:b] = turned(*curve.pieces[k][[0, -1], a:b].tolist(), s)
    return q


def distance(a, b, is_unit: bool) -> float:
    as_mp = [[mpmath.mpf(x.numerator) / x.denominator if isinstance(x, F) else x for x in q] for q in (a, b)]
    apart = max(abs(x - y) for x, y in zip(*as_mp, strict=True))
    if is_unit:  # quaternions of both signs turn alike
        apart = min(apart, max(abs(x + y) for x, y in zip(*as_mp, strict=True)))
    return float(apart)


def random_breaks(rng) -> np.ndarray:
    count = int(rng.integers(1, 6))
    late = 0.0 if rng.random() < 0.5 else 10.0 ** rng.integers(-3, 4)
    if rng.random() < 0.5:  # a message's times, now and then 1 ns apart
        return (
            round(late * 1e9)
            + np.cumsum(rng.integers(1, 10 ** rng.integers(1 if rng.random() < 0.1 else 7, 10, count + 1)))
        ) / 1e9
    return late + np.cumsum(rng.uniform(1e-3, 2, count + 1))


def random_curve(rng, units: tuple[tuple[int, int], ...], width: int) -> Curve:
    breaks = random_breaks(rng)
    pieces, last = [], None
    for _ in breaks[1:]:
        points = rng.uniform(-1, 1, (int(rng.integers(2, 8)), width))
        for a, b in units:
            ends = rng.normal(size=(2, b - a))
            points[:, a:b] = ends[0] / np.linalg.norm(ends[0])
            points[-1, a:b] = ends[1] / np.linalg.norm(ends[1])
        if last is not None:
            points[0] = last
        last = points[-1]
        pieces.append(points)
    return Curve(breaks, tuple(pieces), np.abs(rng.normal(size=width)) * 1e-15, units)


def test_positions_at_any_instant_are_each_robots_own(cell):
    rng, tight, judged = np.random.default_rng(0), [], 0
    for _ in range(60):
        curves = {
            name: random_curve(rng, part.robot.configuration_map.units, len(part.columns))
            for name, part in cell.parts.items()
        }
        runs = {name: pc.Trajectory.of_curve(curve) for name, curve in curves.items()}
        starts = {name: float(rng.choice([0.0, 0.1, rng.uniform(0, 5)])) for name in runs if rng.random() < 0.7}
        try:
            merged = on_one_clock(cell, runs, starts)
        except pc.PlannercheckError:  # pieces of some ns that turn by a radian: 1e-10 is a tenth of an ns
            continue
        judged += 1
        clock = [F(x) for x in merged.curve.breaks.tolist()]
        assert clock[0] == 0
        own = {name: [F(starts.get(name, 0.0)) + x for x in exact_times(curves[name].breaks)] for name in runs}
        times = [x for knots in own.values() for x in knots] + [F(t) for t in rng.uniform(0, float(clock[-1]), 10)]
        for t in times:
            ours = exact_state(merged.curve, clock, t)
            for name, part in cell.parts.items():
                theirs = exact_state(curves[name], own[name], t)
                columns = part.columns.tolist()
                room = merged.curve.error[columns] - curves[name].error
                units = curves[name].units
                for a, b in units:
                    off = distance([ours[c] for c in columns[a:b]], theirs[a:b], True)
                    assert off <= room[a:b].min()
                for k in {*range(len(columns))} - {c for a, b in units for c in range(a, b)}:
                    off = distance([ours[columns[k]]], [theirs[k]], False)
                    assert off <= room[k]
                    tight.append(off / room[k])
    assert max(tight) > 0.02  # the bound is not idle
    assert judged > 40


def slide(*rows, times=None) -> pc.Trajectory:
    return pc.Trajectory(np.arange(len(rows)) if times is None else times, rows, controller="linear")


def test_a_robot_stands_before_and_after(cell):
    two = together(cell, ("left", "right"))
    merged = on_one_clock(two, {"left": slide([0, 0], [1, 0]), "right": slide([0, 0], [0, 2])}, {"right": 1.5})
    assert merged.curve.breaks.tolist() == [0, 1, 1.5, 2.5]
    assert merged.position([0.0, 0.5, 1.2, 2.0, 2.5]).tolist() == [
        [0, 0, 0, 0],
        [0.5, 0, 0, 0],
        [1, 0, 0, 0],
        [1, 0, 0, 1],
        [1, 0, 0, 2],
    ]
    first_point_later = on_one_clock(two, {"left": [3, 4], "right": slide([0, 0], [0, 2], times=[1.0, 2.0])})
    assert first_point_later.position([0.0, 1.5]).tolist() == [[3, 4, 0, 0], [3, 4, 0, 1]]
    assert first_point_later.curve.breaks.tolist() == [0, 1, 2]


def test_each_keeps_its_own_controller(cell):
    two = together(cell, ("left", "right"))
    cubic = pc.Trajectory([0, 1], [[0, 0], [1, 1]], [[0, 0], [0, 0]])
    quintic = pc.Trajectory([0, 2], [[0, 0], [1, 1]], [[0, 0], [0, 0]], [[0, 0], [0, 0]], controller="ur")
    merged = on_one_clock(two, {"left": cubic, "right": quintic})
    assert [len(piece) for piece in merged.curve.pieces] == [6, 6]
    times = np.linspace(0, 2, 41)
    assert np.abs(merged.position(times)[:, :2] - cubic.position(np.minimum(times, 1))).max() < 1e-14
    assert np.abs(merged.position(times)[:, 2:] - quintic.position(times)).max() < 1e-14


def test_knots_that_rounding_parts_are_one(cell):
    two = together(cell, ("left", "right"))
    right = slide([0, 0], [1, 0], times=[0.0, 0.2])
    merged = on_one_clock(two, {"left": slide([0, 0], [1, 0], times=[0.0, 0.3]), "right": right}, {"right": 0.1})
    assert 0.1 + 0.2 != 0.3
    assert merged.curve.breaks.tolist() == [0.0, 0.1, 0.3]
    assert (merged.curve.error < 1e-14).all()


@pytest.mark.parametrize(
    ("runs", "starts", "words"),
    [
        ({"left": slide([0, 0], [1, 0])}, None, "no trajectory of right: give one, or the configuration"),
        ({"left": [0, 0], "right": [0, 0]}, None, "no robot moves"),
        ({"left": slide([0, 0], [1, 0]), "rigth": [0, 0]}, None, "did you mean 'right'"),
        ({"left": slide([0, 0, 0], [1, 0, 0]), "right": [0, 0]}, None, "has 3 columns, but the robot has 2"),
        ({"left": slide([0, 0], [1, 0]), "right": [0, 0, 0]}, None, "robot 'right'"),
        ({"left": slide([0, 0], [1, 0]), "right": [0, 0]}, {"left": -1.0}, "the start of 'left' must be a time"),
        ({"left": slide([0, 0], [1, 0]), "right": [0, 0]}, {"left": np.nan}, "the start of 'left' must be a time"),
        ({"left": slide([0, 0], [1, 0]), "right": [0, 0]}, {"right": 1.0}, "'right' stands"),
        ({"left": slide([0, 0], [1, 0]), "right": [0, 0]}, {"up": 1.0}, "unknown robot with a start 'up'"),
        ([1, 2], None, "given by robot"),
        ({"left": slide([0, 0], [1, 0]), "right": [0, 0]}, 1.0, "starts are given by robot"),
    ],
)
def test_bad_input(cell, runs, starts, words: str):
    two = together(cell, ("left", "right"))
    with pytest.raises(pc.PlannercheckError, match=words):
        on_one_clock(two, runs, starts)


def test_the_clock_begins_at_0(cell):
    two = together(cell, ("left", "right"))
    early = pc.Trajectory.bezier([-1.0, 1.0], [[[0, 0], [1, 0]]])
    with pytest.raises(pc.PlannercheckError, match="give it a start of at least 1 s"):
        on_one_clock(two, {"left": early, "right": [0, 0]})
    assert on_one_clock(two, {"left": early, "right": [0, 0]}, {"left": 1.0}).duration == 2.0
    with pytest.raises(pc.PlannercheckError, match=r"see pc\.Robot\.together"):
        on_one_clock(cell.parts["left"].robot, {"left": early})
    runs = {"box": pc.Trajectory([0, 1], np.eye(7)[[6, 6]]), "wheel": [1.0, 0.0]}
    turning = together(cell, runs)
    with pytest.raises(pc.PlannercheckError, match="columns of 'box' form unit vectors"):
        on_one_clock(turning, runs)
