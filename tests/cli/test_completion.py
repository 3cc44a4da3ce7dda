"""`plannercheck --print-completion SHELL`."""

import subprocess
import sys

import pytest

from plannercheck.cli.main import COMMANDS, SHELLS, main


@pytest.mark.parametrize("shell", SHELLS)
def test_completions_know_all_commands_and_their_options(shell, capsys):
    pytest.importorskip("shtab")
    assert main(["--print-completion", shell]) == 0
    shown = capsys.readouterr().out
    assert all(command in shown for command in COMMANDS)
    assert "only-invalid" in shown
    assert "turning-radius" in shown


def test_bash_takes_it(capsys):
    pytest.importorskip("shtab")
    main(["--print-completion", "bash"])
    script = capsys.readouterr().out
    ran = subprocess.run(["bash", "-n"], input=script, capture_output=True, text=True, check=False)
    assert (ran.returncode, ran.stderr) == (0, "")


def test_without_the_library(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "shtab", None)
    assert main(["--print-completion", "bash"]) == 2
    said = capsys.readouterr().err
    assert "plannercheck[completion]" in said
    assert "Traceback" not in said
