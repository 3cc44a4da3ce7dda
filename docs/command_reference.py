"""Writes docs/reference/commands.md from the parsers of the command line: `python docs/command_reference.py`.

In: `plannercheck.cli.main`. Out: a page with every command and subcommand: what it does, its arguments, its own
options, and the notes below them. Options that several commands share stand once, at the head. The page is made
whenever the documentation is built, so it can't fall behind.
"""

from __future__ import annotations

import argparse
import os
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from plannercheck.cli.main import COMMANDS, parser_for

_WIDTH = "120"
_SHARED = 3  # commands that have an option word for word: then it stands at the head

_HEAD = """\
# Command reference

Made from the parsers; `plannercheck COMMAND --help` prints the same. [Command line](command_line.md) has an overview,
examples, exit codes and environment variables.

## Options of several commands
"""


def write_reference(path: Path) -> None:
    """Writes the page."""
    os.environ["COLUMNS"] = _WIDTH
    every = list(parsers())
    counted = Counter(key for parser in every for key in {_key(action) for action in parser._actions})
    shared = {key for key, count in counted.items() if count >= _SHARED}
    first = {_key(action): action for parser in reversed(every) for action in parser._actions}
    head = _listed(every[0], [action for key, action in first.items() if key in shared and "--help" not in key[0]])
    path.write_text("\n".join([_HEAD, head, *(_section(parser, shared) for parser in every)]), encoding="utf-8")


def parsers() -> Iterator[argparse.ArgumentParser]:
    """The main parser, then those of all commands, each followed by its subcommands'."""
    yield parser_for([])
    for name in COMMANDS:
        command = _subparsers(parser_for([name]))[name]
        yield command
        yield from _subparsers(command).values()


def _section(parser: argparse.ArgumentParser, shared: set[tuple[str, str | None]]) -> str:
    """One command: its own options in full, the names of the shared ones, its notes."""
    own = [action for action in parser._actions if _key(action) not in shared]
    also = [f"`{action.option_strings[-1]}`" for action in parser._actions if _key(action) in shared][1:]
    parts = [f"## {parser.prog}\n", f"{parser.description}\n"]
    parts += [_listed(parser, own)] if own else []
    parts += [f"Also {', '.join(also)}.\n"] if also else []
    parts += [f"```text\n{parser.epilog.strip()}\n```\n"] if parser.epilog else []
    return "\n".join(parts)


def _key(action: argparse.Action) -> tuple[str, str | None]:
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
