"""What notebooks and consoles show of robots, verdicts and reports: one line, or a table."""

from __future__ import annotations

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.checking.verdicts import PairCount, ValidityReport


@pytest.fixture(scope="module")
def checker():
    return pc.Checker(pc.Robot.load("panda"), pc.Scene.load("bookshelf"))


@pytest.fixture(scope="module")
def colliding(checker):
    q = checker.robot.random_configurations(500, 1)
    rows = q[~checker.check_states(q)]
    return next(row for row in rows if len(checker.explain(row).collisions) > 4)


def test_a_verdict_is_one_line(checker, colliding):
    found = checker.explain(colliding, separations=True)
    shown = repr(found)
    assert shown.count("\n") == 0
    assert len(shown) < 250
    assert shown.startswith(f"Verdict({len(found.collisions)} colliding pairs: {found.collisions[0].first} – ")
    assert f"; {len(found.separations)} separations)" in shown
    assert len(repr(found.collisions[0])) < 120
    home = np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])
    assert repr(pc.Checker(checker.robot).explain(home)) == "Verdict(valid)"


def test_the_verdict_of_a_motion_is_one_line(checker, colliding):
    home = np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])
    alone = pc.Checker(checker.robot)
    assert repr(alone.explain_motion(home, home)).startswith("MotionVerdict(free, all pairs further than ")
    stopped = repr(checker.explain_motion(home, colliding, proofs=True))
    assert stopped.startswith("MotionVerdict(free until ")
    assert " – " in stopped
    assert len(stopped) < 200
    assert alone.explain_motion(home, home, proofs=True)._repr_html_().count("<tr>") > 2


def test_verdicts_as_tables(checker, colliding):
    found = checker.explain(colliding)
    shown = found._repr_html_()
    assert shown.count("<tr>") == 1 + len(found.collisions)
    assert found.collisions[0].first in shown
    assert "SharedPoint" in shown


def test_robots_as_tables():
    shown = pc.Robot.load("panda")._repr_html_()
    assert shown.count("<tr>") == 8
    assert "<td>panda_joint4</td><td>-3.0718</td><td>-0.0698</td>" in shown
    planar = pc.planar.Robot.load("truck_trailer")
    assert planar._repr_html_().count("<tr>") == 1 + planar.nq


def test_reports_as_tables():
    report = ValidityReport(10, 7, 1, (PairCount("<b>link", "shelf", 3),), duration=0.1)
    shown = report._repr_html_()
    assert "10 configurations: 7 valid, 3 colliding, 1 beyond the limits" in shown
    assert "<td>&lt;b&gt;link</td><td>shelf</td><td>3</td>" in shown
