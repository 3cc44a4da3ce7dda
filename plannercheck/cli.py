"""The command line: `plannercheck COMMAND ...`.

In: arguments. Out: text on the terminal and an exit code: 0 if all is well, 1 if something is invalid or
unsolved, 2 for bad input. Each command is a module in commands/, imported only when it is asked for, so that
help is instant.
"""

from __future__ import annotations

import argparse
import importlib
import os
import sys
import warnings
from collections.abc import Sequence
from typing import TextIO

from plannercheck import __version__
from plannercheck.errors import PlannercheckError

# Exit codes beyond a command's own 0 and 1.
BAD_INPUT = 2
INTERRUPTED = 130
BROKEN_PIPE = 141

COMMANDS = {
    "validate": "check sets of configurations of any size: npy, npz, csv, parquet or hdf5 files",
    "plan": "plan with OMPL, one problem or a whole problem set",
    "verify": "confirm proofs of motions that validate --path --certify wrote, without the checker",
    "demo": "validate a shipped set and plan in a shipped scene",
    "view": "show a robot in its scene, what collides, and what proves it, in the browser",
    "robots": "list the shipped robots",
    "stress": "hold verdicts on hard pairs of bodies against exact arithmetic",
    "bench": "measure run time against error, beside other methods and libraries",
    "acm": "propose which pairs of a robot's links to leave untested, or audit those that are",
    "inspect": "show the bodies and pairs of a robot in a scene, and what checking them takes",
}

# Options whose value may start with a minus sign.
_VECTOR_OPTIONS = ("--start", "--goal", "--q")


def main(argv: Sequence[str] | None = None) -> int:
    """Runs a command.

    Args:
        argv: Arguments without the program's name; None takes the process's.

    Returns:
        The exit code.
    """
    arguments = _joined_vectors(list(sys.argv[1:] if argv is None else argv))
    try:
        options = parser_for(arguments).parse_args(arguments)
    except SystemExit as stop:  # argparse has said why
        return int(stop.code or 0)
    with warnings.catch_warnings():
        warnings.showwarning = _show_warning
        return _run(options)


def _run(options: argparse.Namespace) -> int:
    try:
        code = int(options.run(options))
        sys.stdout.flush()
        return code
    except PlannercheckError as error:
        print(f"plannercheck: error: {' '.join(str(error).split())}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:  # the reader, e.g. `head`, has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return BROKEN_PIPE


def parser_for(arguments: Sequence[str]) -> argparse.ArgumentParser:
    """The parser, complete for the command that is asked for."""
    parser = argparse.ArgumentParser(
        prog="plannercheck",
        description="Exact collision verdicts for motion planning.",
        epilog="Exit codes: 0 all valid or solved, 1 something is not, 2 bad input.",
    )
    parser.add_argument("--version", action="version", version=f"plannercheck {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    chosen = next((argument for argument in arguments if not argument.startswith("-")), None)
    for name, summary in COMMANDS.items():
        command = commands.add_parser(
            name,
            help=summary,
            description=summary[0].upper() + summary[1:] + ".",
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        if name == chosen:
            module = importlib.import_module(f"plannercheck.commands.{name}")
            module.add_arguments(command)
            command.set_defaults(run=module.run)
    return parser


def _joined_vectors(arguments: list[str]) -> list[str]:
    """Joins `--start -0.1,0.2` to `--start=-0.1,0.2`: argparse would take the value for an option."""
    joined: list[str] = []
    for argument in arguments:
        if joined and joined[-1] in _VECTOR_OPTIONS and argument[:1] == "-" and argument[1:2] in "0123456789.":
            joined[-1] += f"={argument}"
        else:
            joined.append(argument)
    return joined


def _show_warning(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: TextIO | None = None,
    line: str | None = None,
) -> None:
    print(f"plannercheck: warning: {' '.join(str(message).split())}", file=sys.stderr)
