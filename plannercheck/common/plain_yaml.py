"""YAML without anchors and tags in a fraction of PyYAML's time.

In: the text of one document. Out: the values that `yaml.safe_load` gives. Most files are read line by line by the core
(cpp/bindings/bind_plain_yaml.cpp), in a tenth of the time. Most others are built from the parser's events, in half the
time of PyYAML's nodes and constructors. What is not plain (anchors, aliases, tags, merged keys, several documents,
broken texts) is left to PyYAML itself: values and errors are always its own.
"""

from __future__ import annotations

import re
from functools import lru_cache
from typing import Any

import yaml

# libyaml's loader is ten times faster; PyYAML comes without it on some platforms.
LOADER: type[Any] = getattr(yaml, "CSafeLoader", yaml.SafeLoader)

# Numbers as nearly all files write them; YAML 1.1 has more kinds, which PyYAML reads.
_WHOLE = re.compile(r"-?(?:0|[1-9][0-9]{0,15})\Z")
_DECIMAL = re.compile(r"-?[0-9]+\.[0-9]*(?:[eE][-+][0-9]+)?\Z")

# Levels of documents that are read line by line, at most (see cpp/bindings/bind_plain_yaml.cpp).
DEEPEST_LINES = 64

# Longer texts are not kept.
_LONGEST_WORD = 64

_PLAIN_TAGS = frozenset(f"tag:yaml.org,2002:{kind}" for kind in ("null", "bool", "int", "float", "timestamp", "str"))


class NotPlainError(Exception):
    """The document needs PyYAML's own constructors."""


def load_yaml(text: bytes | str) -> Any:
    """The value of a document.

    Args:
        text: The document.

    Raises:
        yaml.YAMLError, UnicodeDecodeError, ValueError: As `yaml.safe_load` does.
    """
    value = value_of_lines(text)
    if value is not None:
        return value
    try:
        return _value_of_events(text)
    except (NotPlainError, yaml.YAMLError, ValueError, TypeError):
        return yaml.load(text, Loader=LOADER)  # a safe one, chosen above


def value_of_lines(text: bytes | str) -> Any:
    """The value of a document of plain lines; None if it may be anything else, or is nested deeper than that."""
    from plannercheck.common.core import core  # here, since proofs are verified without the core

    if not text.isascii():
        return None
    try:
        return core.plain_yaml(text.encode() if isinstance(text, str) else text, _resolved)
    except (NotPlainError, ValueError):  # of a word
        return None


def _value_of_events(text: bytes | str) -> Any:
    loader = LOADER(text)
    try:
        next_event = loader.get_event
        next_event()  # the stream's start
        if type(next_event()) is not yaml.DocumentStartEvent:
            raise NotPlainError
        value = _node(next_event)
        next_event()  # the document's end
        if type(next_event()) is not yaml.StreamEndEvent:
            raise NotPlainError
        return value
    finally:
        loader.dispose()


def _node(next_event: Any) -> Any:
    """The value of the next node; nodes within nodes are kept on a list, so that depth costs no recursion."""
    root: list[Any] = []
    # The open collections: the list or mapping, and the key that waits for its value.
    values: Any = root
    key: Any = _NO_KEY
    outer: list[tuple[Any, Any]] = []
    while True:
        event = next_event()
        kind = type(event)
        if kind is yaml.ScalarEvent:
            if event.anchor is not None or event.tag is not None:
                raise NotPlainError
            value = event.value if event.style else _plain(event.value)
        elif kind is yaml.MappingStartEvent or kind is yaml.SequenceStartEvent:
            if event.anchor is not None or event.tag is not None:
                raise NotPlainError
            outer.append((values, key))
            values, key = ({} if kind is yaml.MappingStartEvent else []), _NO_KEY
            continue
        elif kind is yaml.MappingEndEvent or kind is yaml.SequenceEndEvent:
            value = values
            values, key = outer.pop()
        else:
            raise NotPlainError
        if type(values) is list:
            values.append(value)
            if values is root:
                return value
        elif key is _NO_KEY:
            if type(value) is list or type(value) is dict:
                raise NotPlainError  # PyYAML says that it can't be a key
            key = value
        else:
            values[key] = value
            key = _NO_KEY


_NO_KEY = object()


def _plain(text: str) -> Any:
    """The value of a scalar without quotes."""
    if _DECIMAL.match(text):
        return float(text)
    if _WHOLE.match(text):
        return int(text)
    return _resolved(text) if len(text) <= _LONGEST_WORD else _resolved.__wrapped__(text)


@lru_cache(maxsize=4096)
def _resolved(text: str) -> Any:
    """The same by PyYAML's own resolver and constructor; words repeat, so results are kept."""
    known = LOADER.yaml_implicit_resolvers
    tags = (*known.get(text[:1], ()), *known.get(None, ()))
    tag = next((tag for tag, pattern in tags if pattern.match(text)), "tag:yaml.org,2002:str")
    if tag not in _PLAIN_TAGS:
        raise NotPlainError
    return yaml.constructor.SafeConstructor().construct_object(yaml.ScalarNode(tag, text))
