"""Trajectories in pictures: played in real time, with the checker's clearances below."""

import json
import re
import subprocess

import numpy as np
import pytest
from browser import BROWSER, browser_flags

import plannercheck as pc
from plannercheck.cli.main import main
from plannercheck.view import picture, serve, write_page
from plannercheck.view.frames import along_trajectory
from plannercheck.view.page import page_of

ROBOT = pc.Robot.load("panda")
HOME = ROBOT.reference
V = np.array([[0.0] * 7, [0.4] * 7, [0.0] * 7])


@pytest.fixture(scope="module")
def checker():
    return pc.Checker(ROBOT, pc.Scene.load("bookshelf"))


@pytest.fixture(scope="module")
def trajectory():
    return pc.Trajectory([0, 1, 2.5], np.array([HOME, HOME + 0.2, HOME]), V, joint_names=ROBOT.joint_names)


@pytest.fixture(scope="module")
def drawn(checker, trajectory):
    rows, times = along_trajectory(trajectory, 20)
    return picture(checker, rows, times=times, planes=0)


def data_in(page: str) -> dict:
    assert not re.search(r"https?://|<link|src=|import ", page)
    return json.loads(re.search(r'id="data">(.*?)</script>', page, re.DOTALL)[1])


def test_a_page_has_times_and_clearances(checker, trajectory, drawn):
    data = data_in(page_of(drawn))
    assert data["times"] == np.linspace(0, 2.5, 20).tolist()
    assert data["clearances"] == checker.clearances(trajectory.position(data["times"])).tolist()
    assert data["animated"]


def test_times_grow_one_a_frame(checker):
    for times in ([0.0], [0.0, 0.0], [0.0, np.nan]):
        with pytest.raises(pc.PlannercheckError, match="times must be 2 numbers that grow"):
            picture(checker, [HOME, HOME], times=times)


def test_the_command_shows_what_the_controller_runs(capsys, tmp_path, trajectory):
    trajectory.save(tmp_path / "t.yaml")
    words = ["view", "--robot", "panda", "--scene", "bookshelf", "--path", str(tmp_path / "t.yaml")]
    page = ["--html", str(tmp_path / "page.html"), "--planes", "0"]
    assert main([*words, *page]) == 0
    assert "120 frames" in capsys.readouterr().out
    data = data_in((tmp_path / "page.html").read_text())
    assert (data["labels"][0], data["labels"][-1]) == ("0.000 s", "2.500 s")
    assert main([*words, *page, "--controller", "linear", "--frames", "7"]) == 0
    data = data_in((tmp_path / "page.html").read_text())
    assert len(data["times"]) == 7
    assert main([*words, *page, "--motion-path", "screw", "--frames", "4"]) == 0  # straight motions are asked for
    assert data_in((tmp_path / "page.html").read_text())["times"] is None
    capsys.readouterr()


def test_long_trajectories_have_a_bounded_number_of_frames():
    for duration, count in ((1.0, 120), (10.0, 300), (100.0, 600)):
        rows, times = along_trajectory(pc.Trajectory([0, duration], [[0.0], [1.0]]))
        assert (len(rows), times[-1]) == (count, duration)


def test_the_server_plays_in_real_time(drawn):
    pytest.importorskip("viser")
    stage = serve(drawn, port=0)
    try:
        assert "least clearance" in stage.verdict.content
        frame, shown = 0, []
        for _ in range(8):  # steps of 0.5 s of frames 2.5 / 19 s apart
            frame = stage.next_frame(frame, 0.5)
            shown.append(frame)
        assert shown == [3, 7, 11, 15, 19, 19, 19, 0]
        assert stage.next_frame(10, 0.5) == drawn.frame_at(float(drawn.times[10]) + 0.5)  # moved by hand
    finally:
        stage.server.stop()


@pytest.mark.skipif(BROWSER is None, reason="no Chromium: apt-get install chromium")
def test_the_plot_in_a_browser(drawn, tmp_path):
    write_page(drawn, tmp_path / "page.html")
    address = (tmp_path / "page.html").as_uri() + "#frame=5"
    command = [BROWSER, *browser_flags(500, 400), f"--user-data-dir={tmp_path / 'p'}", "--dump-dom", address]
    page = subprocess.run(command, check=True, capture_output=True, timeout=120, text=True).stdout
    assert f"least clearance {float(f'{1000 * drawn.clearances[5]:.3g}'):g} mm" in page
