"""What notebooks and consoles show of robots, verdicts and reports: one line, or a table."""

from html.parser import HTMLParser

import numpy as np
import pytest

import plannercheck as pc
from plannercheck import view
from plannercheck.checking.verdicts import PairCount, ValidityReport
from plannercheck.ompl.plans import Plan


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


@pytest.fixture(scope="module")
def plan(checker):
    start, goal = (checker.scene.states["panda"].start, checker.scene.states["panda"].goal)
    return pc.ompl.plan(checker, start, goal, seed=1)


def test_whatever_a_console_prints_is_one_short_line(checker, colliding, plan):
    cloud, points = pc.Scene("cloud"), np.random.default_rng(0).normal(size=(500, 3))
    cloud.add("seen", pc.PointCloud(points + 9, 0.01))
    drawn = view.picture(checker, colliding)
    sensed = view.picture(pc.Checker(checker.robot, cloud), colliding)
    proof = checker.explain_motion(plan.path[0], plan.path[1], proofs=True).proof
    shown = [
        *(drawn, sensed, plan, proof),
        *(*drawn.meshes, *sensed.parts, *drawn.witnesses, *checker.bodies),
        *(*checker.scene.objects, *checker.scene.objects[0].parts, pc.Hull(points)),
    ]
    for each in shown:
        assert len(repr(each)) < 160, type(each)
        assert "\n" not in repr(each), type(each)
    assert repr(drawn) == f"Picture('panda in bookshelf', 1 frames, 1 in collision, {len(checker.bodies)} bodies)"
    assert repr(plan).startswith(f"Plan({len(plan.path)} states, length {plan.length:.4g}, ")


def test_pictures_as_pages_in_a_frame(checker, colliding, tmp_path):
    drawn = view.picture(checker, colliding, labels=['</iframe><script>"&'])
    view.write_page(drawn, tmp_path / "page.html")
    tags = []
    parser = HTMLParser()
    parser.handle_starttag = lambda tag, attributes: tags.append((tag, dict(attributes)))
    parser.feed(drawn._repr_html_())
    ((tag, attributes),) = tags
    assert (tag, attributes["sandbox"]) == ("iframe", "allow-scripts")
    assert attributes["srcdoc"] == (tmp_path / "page.html").read_text("utf-8")


def test_plans_as_tables(plan):
    shown = plan._repr_html_()
    assert shown.count("<tr>") == 1 + len(plan.path)
    assert "<th>panda_joint4</th>" in shown
    assert f"<td>{plan.path[-1, 3]:.4f}</td>" in shown
    failed = Plan(False, np.zeros((0, 2)), 0.0, 1.0, 0.0, "RRT", "<b>no time", ("a", "b"))
    assert failed._repr_html_() == "<p>Plan(no path: &lt;b&gt;no time, RRT, 1 s)</p>"


def test_scenes_in_space_and_in_the_plane_as_tables(checker):
    for scene in (checker.scene, pc.planar.Scene.load("parking")):
        shown = scene._repr_html_()
        assert shown.count("<tr>") == 1 + len(scene.object_names)
        assert f"<td>{scene.object_names[-1]}</td>" in shown
