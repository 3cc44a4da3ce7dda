"""Numbers of joint_trajectory_controller's own tests (ros2_controllers, test_trajectory.cpp), evaluated by us."""

import numpy as np
import pytest

import plannercheck as pc


def run(times, q, v=None, a=None, start=None, **options):
    rows = [None if x is None else np.array(x, dtype=float)[:, None] for x in (q, v, a)]
    return pc.Trajectory(times, *rows, start=start, **options)


@pytest.mark.parametrize(("time", "position"), [(0, 0), (0.5, 0.5), (1, 1), (1.5, 1.5), (2, 2), (2.5, 2.5), (3, 3)])
def test_positions(time: float, position: float):
    found = run([1, 2, 3], [1, 2, 3], start=[0.0])
    assert found.position(time) == pytest.approx(position)
    assert found.velocity(time) == pytest.approx(1)


def test_positions_and_velocities():
    """x³ − 2x from 0 to 2; the acceleration of one end alone does not count. A later point brings it to rest."""
    nan = np.nan
    found = run([1, 3, 4], [0, 4, 4], [-2, 10, 0], [nan, 0, nan])
    for x in (0.0, np.sqrt(2), 2 - 1e-12):
        assert found.position(1 + x) == pytest.approx(x**3 - 2 * x, abs=1e-8)
        assert found.velocity(1 + x) == pytest.approx(3 * x**2 - 2)
        assert found.acceleration(1 + x) == pytest.approx(6 * x, abs=1e-8)


def test_positions_velocities_and_accelerations():
    """The polynomial with zeros 0, 1, 2, 3, 4, from 0 to 2."""
    found = run([1, 3, 4], [0, 0, 0], [24, 4, 0], [-100, 0, 0])
    peer = np.polynomial.Polynomial.fromroots(range(5))
    for x in (0.0, 1.0, 2 - 1e-12):
        assert found.position(1 + x) == pytest.approx(peer(x), abs=1e-9)
        assert found.velocity(1 + x) == pytest.approx(peer.deriv()(x))
        assert found.acceleration(1 + x) == pytest.approx(peer.deriv(2)(x), abs=1e-8)


def test_the_state_before_gets_the_degree_of_the_first_point():
    found = run([1, 2], [1, 2], [0, 0], [0, 0], start=[0.0])
    assert [len(piece) for piece in found.curve.pieces] == [6, 6]
    assert found.velocity(0) == found.acceleration(0) == 0


@pytest.mark.parametrize("continuous", [(), (0,), (0, 1, 2)])
def test_whole_turns_before_the_first_point(continuous):
    found = pc.Trajectory([1.0, 2.0], np.full((2, 3), 1.5 * np.pi), start=np.zeros(3), continuous=continuous)
    np.testing.assert_allclose(found.position(0), [2 * np.pi * (k in continuous) for k in range(3)], atol=1e-15)
    there = pc.Trajectory([1.0, 2.0], np.full((2, 3), 1.5 * np.pi), start=np.full(3, 1.5 * np.pi), continuous=[0, 1, 2])
    np.testing.assert_allclose(there.position(0), 1.5 * np.pi)


def test_upsampling():
    found = run([0.1, 0.2, 0.3], [0, 0.1, 0.3], controller="jtc-upsampled")
    np.testing.assert_allclose(found.velocity([0.1, 0.2, 0.3])[:, 0], [0, 2.25, 0], atol=1e-9)
    times = np.arange(1, 8) * 0.1
    q = np.column_stack([0.1 + 0.4 * np.sin(np.pi * (times - 0.1)), 0.5 - times])
    smooth = pc.Trajectory(times, q, controller="jtc-upsampled")
    for t in times[1:-1]:
        np.testing.assert_allclose(smooth.acceleration(t - 1e-9), smooth.acceleration(t), atol=1e-6)
