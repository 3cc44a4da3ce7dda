"""Sets of rows that need no care go to the core at once; all others pass NumPy's checks: verdicts are the same."""

import numpy as np
import pytest

import plannercheck as pc

N = 40


@pytest.fixture(scope="module")
def rows(checker):
    return checker.robot.random_configurations(N, 5)


def forms_of(q):
    """The same numbers in arrays that are laid out otherwise, and as lists."""
    wide = np.zeros((len(q), q.shape[1] + 2))
    wide[:, 1:-1] = q
    turned = np.frombuffer(q.astype(">f8").tobytes(), dtype=">f8").reshape(q.shape)
    return {
        "Fortran's order": np.asfortranarray(q),
        "columns of a wider array": wide[:, 1:-1],
        "every second row": np.repeat(q, 2, axis=0)[::2],
        "upside down": np.ascontiguousarray(q[::-1])[::-1],
        "other bytes first": turned,
        "lists": q.tolist(),
    }


def test_every_form_of_a_set_gets_the_same_verdicts(checker, rows):
    states = checker.check_states(rows)
    assert states.dtype == bool
    assert 0 < states.sum() < N
    assert states.tolist() == [checker.is_valid(q) for q in rows]
    starts, ends = rows[:-1], rows[:-1] + 0.1 * (rows[1:] - rows[:-1])
    motions = checker.check_motions(starts, ends)
    assert motions.dtype == bool
    assert 0 < motions.sum() < N - 1
    assert motions.tolist() == [checker.check_motion(*pair) for pair in zip(starts, ends, strict=True)]
    for name, form in forms_of(rows).items():
        assert checker.check_states(form).tolist() == states.tolist(), name
        assert checker.check_states(form, threads=2).tolist() == states.tolist(), name
    for name, form in forms_of(ends).items():
        assert checker.check_motions(starts, form).tolist() == motions.tolist(), name
        assert checker.check_motions(starts, form, threads=2).tolist() == motions.tolist(), name


@pytest.mark.parametrize("k", [0, N - 1])
def test_one_row_that_needs_care_changes_no_other_verdict(checker, rows, k):
    states, ends = checker.check_states(rows), rows + 0.01
    motions = checker.check_motions(rows, ends)
    beyond = rows.copy()
    beyond[k, 0] = checker.robot.upper[0] + 0.3
    others = np.arange(N) != k
    found = checker.check_states(beyond)
    assert found[others].tolist() == states[others].tolist()
    assert found[k] == checker.is_valid(beyond[k])
    found = checker.check_motions(beyond, ends)
    assert found[others].tolist() == motions[others].tolist()
    assert found[k] == checker.check_motion(beyond[k], ends[k])


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_rows_that_are_not_finite_are_refused(checker, rows, value):
    wrong = rows.copy()
    wrong[-1, -1] = value
    for call in (
        lambda: checker.check_states(wrong),
        lambda: checker.check_motions(wrong, rows),
        lambda: checker.check_motions(rows, wrong),
    ):
        with pytest.raises(pc.PlannercheckError):
            call()


def test_sets_of_other_shapes(checker, rows):
    assert checker.check_states(rows[:0]).shape == checker.check_motions(rows[:0], rows[:0]).shape == (0,)
    assert checker.check_states(rows[0]).shape == (1,)
    for call in (
        lambda: checker.check_states(rows[:, :-1].copy()),
        lambda: checker.check_motions(rows, rows[:-1]),
        lambda: checker.check_motions(rows, rows, tolerance=0.0),
        lambda: checker.check_motions(rows, rows, threads=1.0),
        lambda: checker.check_states(rows, threads=0),
    ):
        with pytest.raises(pc.PlannercheckError):
            call()


WHEEL = """<robot name="wheel"><link name="base"/>
<link name="arm"><collision><origin xyz="0.5 0 0"/><geometry><box size="0.8 0.1 0.1"/></geometry></collision></link>
<joint name="turn" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/></joint></robot>"""


def test_angles_take_the_short_way_in_sets(tmp_path):
    """An obstacle stands at angle 0: ways over half a turn pass it only if they count the other way round."""
    (tmp_path / "wheel.urdf").write_text(WHEEL)
    robot = pc.Robot.from_urdf(tmp_path / "wheel.urdf").with_group(["turn"], "one")
    scene, pose = pc.Scene("one"), np.eye(4)
    pose[0, 3] = 0.6
    scene.add_box("post", [0.1, 0.1, 0.1], pose)
    checker = pc.Checker(robot, scene)
    starts, ends = np.array([[2.0], [3.0], [2.5], [-2.8], [-1.0]]), np.array([[-2.0], [-3.0], [3.1], [2.9], [1.0]])
    found = checker.check_motions(starts, ends)
    assert found.tolist() == [True, True, True, True, False]
    assert found.tolist() == [checker.check_motion(*pair) for pair in zip(starts, ends, strict=True)]


def test_sets_beyond_the_limits_are_tested_with_all_pairs(tmp_path):
    """The obstacle is out of reach within the limits, so that its pair is left out there."""
    limited = WHEEL.replace('"continuous"', '"revolute"').replace(
        '<axis xyz="0 0 1"/>', '<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/>'
    )
    (tmp_path / "wheel.urdf").write_text(limited)
    robot = pc.Robot.from_urdf(tmp_path / "wheel.urdf")
    scene, pose = pc.Scene("one"), np.eye(4)
    pose[0, 3] = -0.6
    scene.add_box("post", [0.1, 0.1, 0.1], pose)
    checker = pc.Checker(robot, scene)
    assert checker.unreachable.all()
    assert checker.check_states([[0.0], [3.1]]).tolist() == [True, False]
    rows = np.array([[0.0], [3.1]])
    assert checker.check_states(rows).tolist() == [True, False]
    for starts, ends in ((rows[:1], rows[1:]), (rows[1:], rows[:1])):
        assert not checker.check_motions(starts, ends)[0]
    assert checker.check_motions(rows[:1], rows[:1] + 0.5)[0]


def test_a_motion_that_is_too_large_to_prove_raises_in_a_set_as_well(checker, rows):
    with pytest.raises(pc.PlannercheckError, match="tolerance"):
        checker.check_motions(rows, 0.9 * rows + 0.1 * rows[::-1], tolerance=1e-14)
