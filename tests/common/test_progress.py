"""Reports of long work reach who listens, and nobody else; a terminal shows them only where the work is long."""

from __future__ import annotations

import io
import threading
import time
import warnings

import pytest

import plannercheck.cli.main as command
from plannercheck.common.progress import TerminalLine, report, reported_to


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
