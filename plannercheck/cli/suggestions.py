"""A parser of arguments that suggests corrections of misspelt commands, options and values.

In: argparse's error message. Out: the message with "did you mean".
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Iterable, Iterator, Sequence
from difflib import get_close_matches
from typing import Any, NoReturn

# How argparse words its errors; newer versions of Python list choices without quotes.
_CHOICE = re.compile(r"invalid choice: '(?P<given>.*)' \(choose from (?P<choices>.*)\)", re.DOTALL)
_UNKNOWN = "unrecognized arguments: "
_MISSING = "the following arguments are required: "


class SuggestingParser(argparse.ArgumentParser):
    """argparse's parser, whose errors suggest names; those of commands are of this class, too."""

    _given: Sequence[str] = ()

    def parse_known_args(  # type: ignore[override]  # argparse has an overload for each kind of namespace
        self, args: Sequence[str] | None = None, namespace: Any = None
    ) -> Any:
        """argparse's, which keeps what it was given."""
        self._given = list(sys.argv[1:] if args is None else args)
        return super().parse_known_args(self._given, namespace)

    def _print_message(self, message: str, file: Any = None) -> None:
        """Writes help or version; that it can't be written is an error, which argparse would drop."""
        if file is not None and file is sys.stdout:
            file.write(message)
        else:
            super()._print_message(message, file)

    def error(self, message: str) -> NoReturn:
        """Says what is wrong and ends the process with exit code 2."""
        super().error("; ".join([message, *self._suggestions(message)]))

    def _suggestions(self, message: str) -> Iterator[str]:
        choice = _CHOICE.search(message)
        if choice is not None:
            yield from _close(choice["given"], [each.strip("'") for each in choice["choices"].split(", ")])
        if message.startswith(_UNKNOWN):
            yield from self._options_like(message.removeprefix(_UNKNOWN).split())
        if message.startswith(_MISSING):  # it may be there, but misspelt
            yield from self._options_like(self._given)

    def _options_like(self, words: Iterable[str]) -> Iterator[str]:
        """Suggestions for the words that look like options, but are none, nor their beginnings."""
        known = set(_options(self))
        for word in (each.partition("=")[0] for each in words if each.startswith("--")):
            if not any(option.startswith(word) for option in known):
                yield from _close(word, known)


def _close(given: str, known: Iterable[str]) -> Iterator[str]:
    near = get_close_matches(given, sorted(known), n=3)
    if near:
        yield f"did you mean {' or '.join(near)}?"


def _options(parser: argparse.ArgumentParser) -> Iterator[str]:
    """The options of a parser and of its commands; only the command that is asked for has all of its own."""
    for action in parser._actions:  # argparse does not list them otherwise
        yield from action.option_strings
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                yield from _options(command)
