"""Configurations as users have them: rows of sets, tensors of other libraries, values by names of joints."""

from fractions import Fraction

import numpy as np
import pytest

import plannercheck as pc

WHEELED = """<robot name="wheeled">
<link name="base"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
<link name="wheel"/><link name="left"/>
<link name="right"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
<joint name="spin" type="continuous"><parent link="base"/><child link="wheel"/><axis xyz="0 0 1"/></joint>
<joint name="open" type="prismatic"><parent link="wheel"/><child link="left"/>
  <axis xyz="1 0 0"/><limit lower="0" upper="2" effort="1" velocity="1"/></joint>
<joint name="partner" type="prismatic"><parent link="left"/><child link="right"/>
  <axis xyz="1 0 0"/><limit lower="-2" upper="2" effort="1" velocity="1"/>
  <mimic joint="open" multiplier="0.5"/></joint>
</robot>"""


class Tensor:
    """What PyTorch and JAX offer to NumPy."""

    def __init__(self, values):
        self._values = np.asarray(values, dtype=np.float32)

    def __array__(self, dtype=None, copy=None):
        return self._values.astype(dtype or np.float32)


class Exchanged:
    """An array that offers DLPack and nothing else."""

    def __init__(self, values):
        self._values = np.asarray(values)

    def __dlpack__(self, **options):
        return self._values.__dlpack__(**options)

    def __dlpack_device__(self):
        return self._values.__dlpack_device__()


@pytest.fixture(scope="module")
def samples(checker):
    return checker.robot.random_configurations(40, 5).astype(np.float32).astype(np.float64)


def by_name(checker, q):
    return dict(zip(reversed(checker.robot.joint_names), reversed(q.tolist()), strict=True))


@pytest.mark.parametrize("form", [lambda q: q[None], lambda q: [q.tolist()], Tensor, Exchanged])
def test_one_configuration_in_forms_of_others(checker, samples, form):
    expected = checker.check_states(samples).tolist()
    assert [checker.is_valid(form(q)) for q in samples] == expected
    assert [checker.explain(form(q)).valid for q in samples] == expected
    free = [checker.check_motion(q, q) for q in samples]
    assert [checker.check_motion(form(q), form(q)) for q in samples] == free
    assert checker.explain_motion(form(samples[0]), form(samples[1])).free in (True, False)


@pytest.mark.parametrize("form", [Tensor, Exchanged])
def test_sets_in_forms_of_others(checker, samples, form):
    assert np.array_equal(checker.check_states(form(samples)), checker.check_states(samples))


FORMS_OF_ROWS = {
    "array": lambda q: q,
    "list": lambda q: q.tolist(),
    "tuple": lambda q: tuple(q.tolist()),
    "list of NumPy's": list,
    "list of floats32": lambda q: list(q.astype(np.float32)),
    "strided": lambda q: np.repeat(q, 2)[::2],
    "float32": lambda q: q.astype(np.float32),
    "read only": lambda q: np.frombuffer(q.tobytes()),
    "other byte order": lambda q: q.astype(">f8"),
    "odd address": lambda q: np.frombuffer(b"0" + q.tobytes(), dtype=np.uint8)[1:].view(np.float64),
    "matrix": lambda q: q.view(type("Matrix", (np.ndarray,), {})),
    "row of a set": lambda q: np.tile(q, (3, 1))[1],
    "column of a set": lambda q: np.tile(q, (3, 1)).T.copy()[:, 1],
}


@pytest.mark.parametrize("form", FORMS_OF_ROWS)
def test_rows_in_any_form_get_the_verdict_of_their_numbers(checker, samples, form):
    beyond = samples.copy()
    beyond[::2] = 1.5 * checker.robot.upper  # judged by all pairs, whatever the form
    for rows in (samples, beyond, np.round(samples)):
        expected = checker.check_states(rows.astype(np.float32) if "32" in form else rows).tolist()
        assert [checker.is_valid(FORMS_OF_ROWS[form](q)) for q in rows] == expected
        assert all(type(checker.is_valid(FORMS_OF_ROWS[form](q))) is bool for q in rows[:4])


def test_whole_numbers_in_lists(checker):
    for row in ([0] * 7, [0, -1.5, 1, -2, 0, 2.5, 1], (0, 0, 1.5, -2, 0, 1, 0)):
        assert checker.is_valid(row) == bool(checker.check_states(np.array([row], dtype=np.float64))[0])
    for huge in (2**53 + 1, -(2**60), 2**64, -(2**70)):
        with pytest.raises(pc.PlannercheckError):
            checker.is_valid([0.0] * 6 + [huge])


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, None, "0", 1j, [0.0], {}, True, np.False_])
def test_lists_with_something_else_are_refused_as_arrays_are(checker, samples, bad):
    within = samples[0].tolist()
    for row in ([*within[:5], bad, 1.0], [bad, *within[1:]], (*within[:4], bad, *within[5:])):
        with pytest.raises(pc.PlannercheckError) as of_list:
            checker.is_valid(row)
        with pytest.raises(pc.PlannercheckError) as of_checks:
            checker.robot.check_configurations(checker._single(row))
        assert str(of_list.value) == str(of_checks.value)


@pytest.mark.parametrize("count", [0, 1, 6, 8])
def test_lists_of_another_length_are_refused(checker, samples, count):
    numbers = [*samples[0].tolist(), 0.0][:count]
    checker.is_valid(samples[0].tolist())  # leaves numbers within the limits where the next ones go
    for row in (numbers, tuple(numbers), np.array(numbers)):
        with pytest.raises(pc.PlannercheckError, match=r"shape \(7,\)"):
            checker.is_valid(row)


def test_sets_of_installed_tensors(checker, samples):
    torch = pytest.importorskip("torch")
    assert np.array_equal(checker.check_states(torch.tensor(samples)), checker.check_states(samples))


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("values", [[1j] * 7, np.full(7, 1 + 1j), np.zeros(7, dtype=np.complex64)])
def test_complex_numbers_are_refused(checker, values):
    for call in (checker.is_valid, checker.explain, checker.check_states, checker.robot.link_poses):
        with pytest.raises(pc.PlannercheckError, match=r"must be .*numbers.* not .*(complex|j)"):
            call(values)


@pytest.mark.parametrize(
    "values",
    [
        [Fraction(1, 2)] * 7,
        np.zeros(7, dtype=object),
        [0.0] * 6 + [None],
        ["0"] * 7,
        np.zeros(7, dtype="datetime64[s]"),
    ],
)
def test_arrays_of_objects_are_refused(checker, values):
    for call in (checker.is_valid, checker.explain, checker.check_states):
        with pytest.raises(pc.PlannercheckError, match=r"must be .*numbers"):
            call(values)


def test_a_tensor_that_refuses_is_refused(checker):
    class Recorded(Tensor):
        def __array__(self, dtype=None, copy=None):
            raise RuntimeError("Can't call numpy() on Tensor that requires grad")

    for call in (checker.is_valid, checker.check_states):
        with pytest.raises(pc.PlannercheckError, match=r"must be .*numbers"):
            call(Recorded(np.zeros(7)))


def test_values_by_names_of_joints(checker, samples):
    rows = [by_name(checker, q) for q in samples]
    expected = checker.check_states(samples).tolist()
    assert [checker.is_valid(row) for row in rows] == expected
    assert [checker.explain(row).valid for row in rows] == expected
    assert [checker.check_motion(row, row) for row in rows] == expected
    assert checker.explain_motion(rows[0], rows[1]).free == checker.check_motion(*samples[:2])
    assert checker.clearance(rows[0]) == checker.clearance(samples[0])


def test_names_that_are_missing_or_unknown(checker, samples):
    row = by_name(checker, samples[0])
    with pytest.raises(pc.PlannercheckError, match=r"missing: panda_joint3$"):
        checker.is_valid({name: value for name, value in row.items() if name != "panda_joint3"})
    with pytest.raises(pc.PlannercheckError, match=r"unknown joint 'panda_joint9': did you mean"):
        checker.explain({**row, "panda_joint9": 0.0})
    with pytest.raises(pc.PlannercheckError, match=r"'panda_joint2' takes one real number, not \[1, 2\]"):
        checker.check_motion(row, {**row, "panda_joint2": [1, 2]})
    with pytest.raises(pc.PlannercheckError, match=r"'panda_joint2' takes one real number, not 'a'"):
        checker.is_valid({**row, "panda_joint2": "a"})


def test_continuous_joints_are_one_angle_and_followers_may_be_left_out(tmp_path):
    (tmp_path / "wheeled.urdf").write_text(WHEELED)
    checker = pc.Checker(pc.Robot.load(tmp_path / "wheeled.urdf"))
    assert not checker.is_valid({"spin": 0.3, "open": 0.1})
    assert checker.is_valid({"open": 1.0, "spin": 0.3})
    assert not checker.is_valid({"open": 1.0, "spin": 0.3, "partner": -0.9})
    with pytest.raises(pc.PlannercheckError, match="missing: spin"):
        checker.is_valid({"open": 1.0})


def test_planar_robots_too():
    checker = pc.planar.Checker(pc.planar.Robot.load("truck_trailer"), pc.planar.Scene.load("parking"))
    q = checker.robot.random_configurations(20, 3)
    expected = checker.check_states(q).tolist()
    assert [checker.is_valid(by_name(checker, row)) for row in q] == expected
    assert [checker.is_valid(row[None]) for row in q] == expected
    with pytest.raises(pc.PlannercheckError, match=r"must be .*numbers"):
        checker.is_valid([1j] * checker.robot.nq)


def test_links_are_posed_by_names_of_joints(checker, samples, tmp_path):
    (tmp_path / "wheeled.urdf").write_text(WHEELED)
    wheeled = pc.Robot.load(tmp_path / "wheeled.urdf")
    followed = wheeled.link_poses({"open": 0.5, "spin": 0.3})
    assert followed.ndim == 3
    assert np.array_equal(followed, wheeled.link_poses(wheeled.joint_values.named({"spin": 0.3, "open": 0.5})[0]))
    for q in samples[:5]:
        poses = checker.robot.link_poses(by_name(checker, q))
        assert np.array_equal(poses, checker.robot.link_poses(q))
    with pytest.raises(pc.PlannercheckError, match=r"missing: panda_joint1$"):
        checker.robot.link_poses(dict(list(by_name(checker, samples[0]).items())[:-1]))
    plane = pc.planar.Robot.load("truck_trailer").with_bounds([-5, -5], [5, 5])
    q = plane.random_configurations(1, 2)[0]
    assert np.array_equal(plane.link_poses(dict(zip(plane.joint_names, q, strict=True))), plane.link_poses(q))
    with pytest.raises(pc.PlannercheckError, match="unknown joint 'z'"):
        plane.link_poses({"z": 0.0})
