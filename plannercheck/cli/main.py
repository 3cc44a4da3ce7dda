"""The command line: `plannercheck COMMAND ...`.

In: arguments. Out: text on the terminal and an exit code: 0 for success, 1 only if something is invalid or unsolved, 2
for bad input, 3 if the command could not do its work. Each command is a module in this folder, imported only when
needed, so that help is instant.
"""

from __future__ import annotations

import argparse
import importlib
import os
import sys
import traceback
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext, redirect_stdout, suppress
from typing import Any, NoReturn, TextIO, cast

from plannercheck.cli.ending_signals import Terminated, ended_by_signals, is_handled_outside
from plannercheck.cli.suggestions import SuggestingParser
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.escaping import TerminalText, on_terminal
from plannercheck.common.optional_imports import extra_module
from plannercheck.common.progress import TerminalLine, reported_to
from plannercheck.common.version import __version__

# Exit codes beyond a command's own 0 and 1.
BAD_INPUT = 2
FAILED = 3
INTERRUPTED = 130
BROKEN_PIPE = 141
TERMINATED = 143

COMMANDS = {
    "validate": "check sets of configurations of any size: npy, npz, csv, parquet or hdf5 files",
    "plan": "plan with OMPL, one problem or a whole problem set",
    "verify": "confirm proofs of motions that validate --path --certify wrote, without the checker",
    "gate": "judge chunks of waypoints before a controller runs them, one a line of standard input",
    "replay": "judge again what a gate has recorded, and say what differs",
    "demo": "validate a shipped set and plan in a shipped scene",
    "view": "show a robot in its scene, what collides, and what proves it, in the browser",
    "robots": "list the shipped robots",
    "stress": "hold verdicts on hard pairs of bodies against exact arithmetic",
    "bench": "measure run time against error, beside other methods and libraries",
    "acm": "propose which pairs of a robot's links to leave untested, or audit those that are",
    "cover": "prove that a sphere model covers a robot's links, grow it until it does, or fit one",
    "export": "write a robot in a scene as a prepared cell, which the C++ library reads",
    "inspect": "show the bodies and pairs of a robot in a scene, and what checking them takes",
}

# Shells for which `--print-completion` writes.
SHELLS = ("bash", "zsh", "tcsh")

# The descriptor of the error stream.
_LAST_STREAM = 2

# Options whose value may start with a minus sign.
_VECTOR_OPTIONS = ("--start", "--goal", "--q")


def main(argv: Sequence[str] | None = None) -> int:
    """Runs a command, by default of the process's arguments, and returns its exit code."""
    arguments = _joined_vectors(list(sys.argv[1:] if argv is None else argv))
    if argv is None:
        _fill_closed_streams()
    try:
        with ended_by_signals() as signals:
            is_program = argv is None
            with signals.ending_the_process(_interrupted) if is_program else nullcontext():
                options = parser_for(arguments).parse_args(arguments)
            with warnings.catch_warnings(), _safe_output():
                warnings.showwarning = _show_warning
                return _run(options)
    except SystemExit as stop:  # argparse has said why, or has printed what was asked for
        return int(stop.code or 0) or _flushed()
    except OSError as error:  # of help, version or completion
        return _unwritten(error)
    except KeyboardInterrupt as stop:
        if is_handled_outside():  # `demo` runs commands: it ends as well
            raise
        return _interrupted(stop)


def _fill_closed_streams() -> None:
    """Opens what was closed of the three standard streams: else a file of ours would be taken for one by libraries."""
    while (descriptor := os.open(os.devnull, os.O_RDWR)) <= _LAST_STREAM:
        os.set_inheritable(descriptor, True)
    os.close(descriptor)


@contextmanager
def _safe_output() -> Iterator[None]:
    """Names of files, links and objects reach the terminal as text, whatever is in them."""
    if sys.stdout is None:
        yield
        return
    with redirect_stdout(cast(TextIO, TerminalText(sys.stdout))):
        yield


@contextmanager
def _progress_line() -> Iterator[None]:
    """Long work of the library is told of on a terminal; a warning takes the line away first."""
    if sys.stderr is None or not sys.stderr.isatty():
        yield
        return
    line, show = TerminalLine(sys.stderr), warnings.showwarning

    def show_alone(*about: Any, **more: Any) -> None:
        line.clear()
        show(*about, **more)

    warnings.showwarning = show_alone
    try:
        with reported_to(line):
            yield
    finally:
        warnings.showwarning = show
        line.clear()


def _run(options: argparse.Namespace) -> int:
    try:
        with _progress_line():
            code = int(options.run(options))
        if sys.stdout is not None:
            sys.stdout.flush()
        return code
    except PlannercheckError as error:
        _say(str(error))
        return BAD_INPUT
    except BrokenPipeError:  # the reader, e.g. `head`, has seen enough
        _drop_output()
        return BROKEN_PIPE
    except Exception as error:  # 1 means that something is not valid, and nothing else
        if options.debug:
            traceback.print_exc()
        _flush_or_drop()
        hint = "" if options.debug else " (plannercheck --debug shows where)"
        _say(f"could not finish: {type(error).__name__}: {error or 'no more is known'}{hint}")
        return FAILED


def _interrupted(stop: KeyboardInterrupt) -> int:
    """Says that the command was ended, and what it has kept; the exit code."""
    is_terminated = isinstance(stop, Terminated)
    words = "terminated" if is_terminated else "interrupted"
    _say("; ".join([words, *map(str, stop.args)]), kind="")
    _flush_or_drop()
    return TERMINATED if is_terminated else INTERRUPTED


def _say(message: str, kind: str = "error: ") -> None:
    """One line on the error stream."""
    with suppress(OSError, ValueError, AttributeError):  # full, closed or none
        print(f"plannercheck: {kind}{on_terminal(' '.join(message.split()))}", file=sys.stderr)


def _flushed() -> int:
    """Writes what is still to be written of help, version or completion; the exit code."""
    try:
        if sys.stdout is not None:
            sys.stdout.flush()
    except OSError as error:
        return _unwritten(error)
    return 0


def _unwritten(error: OSError) -> int:
    """Says that standard output can't be written, unless its reader has gone; the exit code."""
    _drop_output()
    if isinstance(error, BrokenPipeError):
        return BROKEN_PIPE
    _say(f"could not finish: {error.strerror}")
    return FAILED


def _flush_or_drop() -> None:
    try:
        sys.stdout.flush()
    except (OSError, ValueError, AttributeError):
        _drop_output()


def _drop_output() -> None:
    """What is still to be written has no reader, or no room; at exit Python would fail on it once more."""
    with suppress(OSError, ValueError, AttributeError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def parser_for(arguments: Sequence[str]) -> argparse.ArgumentParser:
    """The parser, complete for the command that is asked for."""
    parser = SuggestingParser(
        prog="plannercheck",
        description="Exact collision verdicts for motion planning.",
        epilog="Exit codes: 0 all valid or solved, 1 something is not, 2 bad input, 3 the command could not finish.",
    )
    parser.add_argument("--debug", action="store_true", help="show where a command fails")
    parser.add_argument(
        "--print-completion", choices=SHELLS, action=_PrintCompletion, help="print what completes commands in a shell"
    )
    parser.add_argument("--version", action="version", version=f"plannercheck {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    chosen = next((argument for argument in arguments if not argument.startswith("-")), None)
    is_whole = any(argument.startswith("--print-completion") for argument in arguments)
    for name, summary in COMMANDS.items():
        command = commands.add_parser(
            name,
            help=summary,
            description=summary[0].upper() + summary[1:] + ".",
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        if is_whole or name == chosen:
            module = importlib.import_module(f"plannercheck.cli.{name}")
            module.add_arguments(command)
            command.set_defaults(run=module.run, default_of=command.get_default)
    return parser


class _PrintCompletion(argparse.Action):
    """Prints a shell's completion and ends."""

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, values: Any, option: str | None = None
    ) -> NoReturn:
        """Called where the option is met."""
        try:
            shtab = extra_module("shtab", "completion", "shell completions")
        except PlannercheckError as error:
            parser.exit(BAD_INPUT, f"plannercheck: error: {error}\n")
        print(shtab.complete(parser, shell=values))
        parser.exit(0)


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
    print(f"plannercheck: warning: {on_terminal(' '.join(str(message).split()))}", file=sys.stderr)
