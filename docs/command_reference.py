"""Writes docs/reference/commands.md from the parsers of the command line: `python docs/command_reference.py`.

In: `plannercheck.cli.main`. Out: a page with every command and subcommand: what it does, its arguments, its own
options, and the notes below them without the examples. Options that several commands share stand once, at the head. The
page is made whenever the documentation is built, so it can't fall behind.
"""

from __future__ import annotations

import argparse
import os
from collections import Counter
from collections.abc import Iterator
from itertools import groupby
from pathlib import Path

from plannercheck.cli.main import COMMANDS, parser_for

_Key = tuple[str, str | None]
_WIDTH = "120"
_SHARED = 3  # commands that have an option word for word: then it stands at the head

_HEAD = """\
# Command reference

Made from the parsers; `plannercheck COMMAND --help` prints the same, with examples. Subcommands stand here by name;
`plannercheck bench NAME --help` has their options. [Command line](command_line.md) has an overview, exit codes and
environment variables.

## Options of several commands
"""


def write_reference(path: Path) -> None:
    """Writes the page."""
    os.environ["COLUMNS"] = _WIDTH
    every = list(parsers())
    counted = Counter(key for parser in every for key in {_key(action) for action in _arguments(parser)})
    options = {_key(action): action for parser in every for action in _arguments(parser)}
    common = {key: action for key, action in options.items() if counted[key] >= _SHARED}
    shared = {key: place for place, key in enumerate(common)}
    head = _listed(every[0], list(common.values()))
    path.write_text(
        "\n".join([_HEAD, head, *(_section(parser, shared, list(common.values())) for parser in every)]),
        encoding="utf-8",
    )


def parsers() -> Iterator[argparse.ArgumentParser]:
    """The main parser, then those of all commands, each followed by its subcommands'."""
    yield parser_for([])
    for name in COMMANDS:
        command = _subparsers(parser_for([name]))[name]
        yield command
        yield from _subparsers(command).values()


def _section(parser: argparse.ArgumentParser, shared: dict[_Key, int], common: list[argparse.Action]) -> str:
    """One command: its own options in full, the names of the shared ones, its notes."""
    own = [action for action in _arguments(parser) if _key(action) not in shared]
    also = [shared[_key(action)] for action in _arguments(parser) if _key(action) in shared]
    parts = [f"## {parser.prog}\n", f"{parser.description}\n"]
    parts += [_listed(parser, own)] if own else []
    parts += [f"Also {', '.join(_runs(also, common))}.\n"] if also else []
    notes = ((_arguments(parser) and parser.epilog) or "").partition("Example")[0].strip()
    parts += [f"```text\n{notes}\n```\n"] if notes else []
    return "\n".join(parts)


def _arguments(parser: argparse.ArgumentParser) -> list[argparse.Action]:
    """A command's arguments; of a subcommand none, since its `--help` has them."""
    return [] if len(parser.prog.split()) > 2 else [action for action in parser._actions if action.dest != "help"]


def _runs(places: list[int], common: list[argparse.Action]) -> Iterator[str]:
    """Shared options by name; several in a row by the first and the last."""
    for _, run in groupby(enumerate(sorted(places)), key=lambda pair: pair[1] - pair[0]):
        names = [f"`{common[place].option_strings[-1]}`" for _, place in run]
        yield f"{names[0]} to {names[-1]}" if len(names) > 2 else ", ".join(names)


def _key(action: argparse.Action) -> _Key:
    """What tells options apart: the same names with the same help are the same option."""
    return " ".join(action.option_strings) or str(action.dest), action.help


def _listed(parser: argparse.ArgumentParser, actions: list[argparse.Action]) -> str:
    """Arguments as `--help` lists them."""
    formatter = parser._get_formatter()
    formatter.add_arguments(actions)
    return f"```text\n{formatter.format_help().rstrip()}\n```\n"


def _subparsers(parser: argparse.ArgumentParser) -> dict[str, argparse.ArgumentParser]:
    """By name; argparse has no public access to them."""
    found = (action.choices for action in parser._actions if isinstance(action, argparse._SubParsersAction))
    return next(iter(found), {})


if __name__ == "__main__":
    write_reference(Path(__file__).with_name("reference") / "commands.md")
