"""Reports of long work reach who listens, and nobody else; a terminal shows them only where the work is long."""

import io
import signal
import threading
import time
import warnings
from functools import partial

import numpy as np
import pytest
import trimesh

import plannercheck as pc
import plannercheck.cli.main as command
from plannercheck.checking.collision_matrix import collision_matrix
from plannercheck.common.progress import TerminalLine, report, reported, reported_to
from plannercheck.evaluation.bench import fidelity


def test_reports_are_heard_in_their_own_context() -> None:
    heard: list[tuple[int, int, str]] = []
    report(0, 1, "nobody hears this")
    with reported_to(lambda *each: heard.append(each)):
        report(1, 2, "reading")
        other = threading.Thread(target=report, args=(1, 2, "elsewhere"))
        other.start()
        other.join()
    report(2, 2, "reading")
    assert heard == [(1, 2, "reading")]


def test_short_work_is_silent() -> None:
    line = TerminalLine(stream := io.StringIO())
    for done in range(4):
        line(done, 3, "reading")
    line.clear()
    assert stream.getvalue() == ""


def test_long_work_is_shown_without_a_second_report_and_taken_away() -> None:
    line = TerminalLine(stream := io.StringIO(), patience=0.05)
    line(0, 3, "reading \033[31mmesh.stl" + 100 * "x")
    until = time.monotonic() + 10
    while not stream.getvalue() and time.monotonic() < until:
        time.sleep(0.01)
    shown = stream.getvalue()
    assert shown.startswith("\r\033[Kreading \\x1b[31mmesh.stl")
    assert len(shown) < 90
    line(2, 3, "triangles")
    assert stream.getvalue().endswith("\r\033[Ktriangles: 2 of 3")
    line(3, 3, "triangles")
    assert stream.getvalue().endswith("\r\033[K")


def test_parts_go_on_with_the_whole() -> None:
    """A hundred meshes of a tenth of a second are ten seconds of silence, if each one begins anew."""
    heard: list[tuple[int, int, str]] = []
    with reported_to(lambda *each: heard.append(each)), reported("loading"):
        with reported("reading a"):
            pass
        report(1, 2, "states")
        report(2, 2, "states")
    expected = [(0, 1, "loading"), (0, 1, "reading a"), (0, 1, "loading"), (1, 2, "states"), (0, 1, "loading")]
    assert heard == [*expected, (1, 1, "loading")]

    line = TerminalLine(stream := io.StringIO(), patience=0.2)
    with reported_to(line), reported("loading"):
        for k in range(40):
            with reported(f"reading {k}"):
                time.sleep(0.01)
    assert "reading" in stream.getvalue()
    assert stream.getvalue().endswith("\r\033[K")


def said_by(work) -> set[str]:
    heard: list[str] = []
    with reported_to(lambda done, total, what: heard.append(what)):
        work()
    return set(heard)


def test_long_work_of_the_library_is_reported(tmp_path, monkeypatch) -> None:
    monkeypatch.setenv("PLANNERCHECK_CACHE", str(tmp_path / "cache"))
    corners = np.random.default_rng(0).normal(size=(60, 3))
    hull = trimesh.convex.convex_hull(corners / np.linalg.norm(corners, axis=1)[:, None])
    hull.export(tmp_path / "ball.stl")
    bodies = [
        f'<link name="{n}"><collision><geometry><mesh filename="ball.stl"/></geometry></collision></link>'
        for n in "abc"
    ]
    joints = [
        f'<joint name="{a}{b}" type="revolute"><parent link="{a}"/><child link="{b}"/><origin xyz="3 0 0"/>'
        '<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
        for a, b in ("ab", "bc")
    ]
    (tmp_path / "balls.urdf").write_text(f'<robot name="balls">{"".join(bodies + joints)}</robot>')
    robots: list[pc.Robot] = []
    assert {"loading robot balls", "reading mesh ball.stl"} <= said_by(
        lambda: robots.append(pc.Robot.load(tmp_path / "balls.urdf"))
    )
    checkers: list[pc.Checker] = []
    assert "preparing robot balls" in said_by(lambda: checkers.append(pc.Checker(robots[0])))
    assert "configurations" in said_by(lambda: collision_matrix(robots[0], 100))
    plan = partial(pc.ompl.plan, checkers[0], [0.0, 0.0], [1.0, 1.0], seed=1)
    assert {"auto searches, s"} <= said_by(plan)
    (tmp_path / "m.xml").write_text('<mujoco><worldbody><body><joint/><geom size="1"/></body></worldbody></mujoco>')
    assert "compiling m.xml" in said_by(lambda: pc.Robot.load(tmp_path / "m.xml"))


def test_fidelity_is_reported() -> None:
    assert {"preparing the meshes of panda", "states of panda against coal"} <= said_by(
        lambda: fidelity.measure("panda", 3, 0)
    )


@pytest.fixture
def sees_interrupts():
    """A shell's background job ignores SIGINT, and so would the tests in it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("sees_interrupts")
@pytest.mark.parametrize("planner", ["auto", "LBKPIECE1"])
def test_a_search_shows_its_seconds_and_is_interrupted(tmp_path, planner) -> None:
    """As Ctrl-C comes: a block before a wall has no way, so the search would take all of its 60 s."""
    (tmp_path / "slider.urdf").write_text(SLIDER)
    scene = pc.Scene("wall")
    scene.add_box("wall", [0.1, 0.5, 0.5])
    checker = pc.Checker(pc.Robot.load(tmp_path / "slider.urdf"), scene)
    stream = io.StringIO()
    timer = threading.Timer(1.5, signal.raise_signal, (signal.SIGINT,))
    timer.start()
    began = time.monotonic()
    with pytest.raises(KeyboardInterrupt), reported_to(TerminalLine(stream, 0.3)):
        pc.ompl.plan(checker, [-0.5], [0.5], planner, time_limit=60.0)
    assert time.monotonic() - began < 20
    assert stream.getvalue().count(f"{planner} searches, s: 1 of 60") == 1


SLIDER = """<robot name="slider"><link name="base"/><link name="block">
<collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
<joint name="slide" type="prismatic"><parent link="base"/><child link="block"/><axis xyz="1 0 0"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"""


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize("kind", [Terminal, io.StringIO])
def test_the_command_line_shows_them_on_a_terminal_alone(monkeypatch, kind) -> None:
    def run(_options: object) -> int:
        report(0, 2, "hull")
        time.sleep(0.05)
        report(1, 2, "hull")
        warnings.warn("a joint is odd", stacklevel=1)
        report(1, 2, "trees")
        raise command.PlannercheckError("a mesh is broken")

    stream = kind()
    monkeypatch.setattr("sys.stderr", stream)
    monkeypatch.setattr(command, "TerminalLine", lambda where: TerminalLine(where, 0.01))
    monkeypatch.setattr("plannercheck.cli.robots.run", run)
    assert command.main(["robots"]) == command.BAD_INPUT
    lines = stream.getvalue().split("\n")
    if kind is Terminal:
        assert lines[0].endswith("hull: 1 of 2\r\033[Kplannercheck: warning: a joint is odd")
        assert lines[1].startswith("\r\033[Kplannercheck: error") or lines[1].startswith("plannercheck: error")
    else:
        assert "hull" not in stream.getvalue()
        assert len(lines) == 3
