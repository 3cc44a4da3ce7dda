"""Writes docs/reference/commands.md from the parsers of the command line: `python docs/command_reference.py`.

In: `plannercheck.cli.main`. Out: a page with the help of every command and subcommand, as `--help` prints it. It is
made anew whenever the documentation is built, so it can't fall behind.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator
from pathlib import Path

from plannercheck.cli.main import COMMANDS, parser_for

_WIDTH = "100"

_HEAD = """\
# Command reference

Made from the parsers: what `plannercheck COMMAND --help` prints. [Command line](command_line.md) has an overview,
examples, exit codes and environment variables.
"""


def write_reference(path: Path) -> None:
    """Writes the page."""
    os.environ["COLUMNS"] = _WIDTH
    sections = [f"## {parser.prog}\n\n```text\n{parser.format_help()}```\n" for parser in parsers()]
    path.write_text("\n".join([_HEAD, *sections]), encoding="utf-8")


def parsers() -> Iterator[argparse.ArgumentParser]:
    """The main parser, then those of all commands, each followed by its subcommands'."""
    yield parser_for([])
    for name in COMMANDS:
        command = _subparsers(parser_for([name]))[name]
        yield command
        yield from _subparsers(command).values()


def _subparsers(parser: argparse.ArgumentParser) -> dict[str, argparse.ArgumentParser]:
    """By name; argparse has no public way to them."""
    found = (action.choices for action in parser._actions if isinstance(action, argparse._SubParsersAction))
    return next(iter(found), {})


if __name__ == "__main__":
    write_reference(Path(__file__).with_name("reference") / "commands.md")
