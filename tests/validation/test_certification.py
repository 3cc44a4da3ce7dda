"""Every verdict on a set is proved, and one that is wrong is not."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from poses import at

import plannercheck as pc
from plannercheck.bodies.exact_planes import PosedBody
from plannercheck.cli.main import main
from plannercheck.validation.certification import _Certification, certify_verdicts, exact_box


@pytest.fixture(scope="module")
def checker() -> pc.Checker:
    scene = pc.Scene("test")
    pose = at(0.5, 0.1, 0.4)
    scene.add_sphere("ball", 0.2, pose)
    pose[2, 3] = -0.2
    scene.add_box("table", (2.0, 2.0, 0.1), pose)
    return pc.Checker(pc.Robot.load("panda"), scene)


def test_all_verdicts_are_proved(checker: pc.Checker) -> None:
    q = checker.robot.random_configurations(40, seed=5)
    first = checker.first_colliding_pair(q)
    report = certify_verdicts(checker, q, first)
    assert report.passed
    assert (report.states, report.shared_points) == (40, int((first >= 0).sum()))
    assert report.planes + report.boxes == int((first < 0).sum()) * len(checker.pairs)
    assert min(report.planes, report.boxes, report.shared_points) > 0


def test_wrong_verdicts_are_not_proved(checker: pc.Checker) -> None:
    q = checker.robot.random_configurations(20, seed=6)
    first = checker.first_colliding_pair(q)
    report = certify_verdicts(checker, q, np.where(first < 0, 0, -1).astype(np.int32))
    assert not report.passed
    assert {found.row for found in report.unproved} == set(range(20))
    assert report.shared_points == 0
    free, colliding = int(np.flatnonzero(first < 0)[0]), int(np.flatnonzero(first >= 0)[0])
    assert [found.colliding for found in report.unproved if found.row == free] == [True]
    pairs = [(found.first, found.second) for found in report.unproved if found.row == colliding]
    assert tuple(checker.bodies[k].name for k in checker.pairs[first[colliding]]) in pairs


def test_a_hull_without_one_of_its_points_does_not_pass(checker: pc.Checker) -> None:
    q = checker.robot.random_configurations(20, seed=5)
    q = q[checker.check_states(q)][:3]
    certification = _Certification(checker)
    index = next(k for k, body in enumerate(checker.bodies) if body.name.startswith("table"))
    given = certification._given[index]
    assert given is not None
    # A point that the shape gives, but the core forgot: above the robot.
    certification._given[index] = replace(given, vertices=np.vstack([given.vertices, [0, 0, 3.0]]))
    reports = [certification.valid(k, checker.body_poses(row)[0]) for k, row in enumerate(q)]
    assert all(report.unproved for report in reports)


def test_another_excess_is_certified_too() -> None:
    scene = pc.Scene()
    pose = at(0.5)
    scene.add_cylinder("pole", 0.1, 1.0, pose)
    checker = pc.Checker(pc.Robot.load("panda"), scene, excess=0.01)
    q = checker.robot.random_configurations(2, seed=7)
    first = checker.first_colliding_pair(q)
    assert certify_verdicts(checker, q, first).passed


def test_boxes_are_exact_outward_to_the_grid() -> None:
    pose = at(1, 2.0**-70, -3)
    box = exact_box(PosedBody(np.array([[0, 0, 0], [1, 0, 0.5]]), pose, inflation_radius=0.25))
    one = 1 << 60
    assert box == ((one * 3 // 4, -one // 4, -one * 13 // 4), (one * 9 // 4, one // 4 + 1, -one * 9 // 4))


def test_the_command_proves_and_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    q = pc.Robot.load("panda").random_configurations(10, seed=1)
    np.save(tmp_path / "q.npy", q)
    arguments = ["validate", "--robot", "panda", "--scene", "table", str(tmp_path / "q.npy"), "--certify"]
    assert main([*arguments, "--format", "json"]) in (0, 1)
    counts = json.loads(capsys.readouterr().out)["certificates"]
    assert (counts["configurations"], counts["not proved"], counts["passed"]) == (10, 0, True)
    assert main(arguments) in (0, 1)
    assert "separating planes" in capsys.readouterr().out


def test_the_command_reports_what_is_not_proved(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    np.save(tmp_path / "q.npy", pc.Robot.load("panda").random_configurations(3, seed=1))
    monkeypatch.setattr("plannercheck.bodies.certificates.Separation.verify", lambda self: False)
    monkeypatch.setattr("plannercheck.bodies.certificates.SharedPoint.verify", lambda self: False)
    assert main(["validate", "--robot", "panda", "--scene", "table", str(tmp_path / "q.npy"), "--certify"]) == 2
    assert "not proved" in capsys.readouterr().err
