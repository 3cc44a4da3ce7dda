"""Checked reading of YAML: every error says which file, object and key is wrong, and what would be right.

In: YAML text, or nodes from PyYAML. Out: plain Python values. `error_context` puts a place before the message of any
error raised inside it, so that readers of files need not pass names on.
"""

from __future__ import annotations

import lzma
import math
import re
import struct
import tarfile
import tokenize
import zipfile
import zlib
from collections.abc import Collection
from contextvars import ContextVar
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

import yaml

from plannercheck.common.errors import PlannercheckError, shortened, unknown_name
from plannercheck.common.file_kinds import file_kind
from plannercheck.common.input_limits import YAML_LOADER, check_yaml
from plannercheck.common.user_warnings import warn
from plannercheck.common.yaml_loader import WrittenFloat, WrittenInt, YamlLoader

Node: TypeAlias = dict[str, Any]

# What numpy, zipfile, tarfile and the decompressors below them raise for files that are broken.
BROKEN_FILE = (
    OSError,
    ValueError,
    EOFError,
    TypeError,
    KeyError,  # of a broken header, or a member that is missing
    OverflowError,  # numbers beyond all doubles
    RecursionError,  # nested too deep
    MemoryError,  # a header that claims more than there is
    RuntimeError,  # of zipfile, for encryption
    NotImplementedError,  # of zipfile, for an unknown compression
    tokenize.TokenError,  # of a broken npy header
    struct.error,
    zipfile.BadZipFile,
    tarfile.TarError,
    zlib.error,
    lzma.LZMAError,
)

_PLAIN_NUMBERS = frozenset({float, int, WrittenFloat, WrittenInt})

# What PyYAML calls a text that it was handed; whoever read it from a file names the file.
_NAMELESS = re.compile('in "<(?:byte|unicode) string>", ')


# What PyYAML says of a text of several documents.
_SEVERAL = "expected a single document in the stream"


class error_context:  # noqa: N801  # used as a function; a generator would take four times as long
    """Puts a place, e.g. "object 'can'", before the message of a PlannercheckError, which keeps its type."""

    __slots__ = ("place",)

    def __init__(self, place: str) -> None:
        self.place = place

    def __enter__(self) -> None:
        _open_contexts.set((*_open_contexts.get(), self))

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        # The one, not the last one: generators leave theirs at any time, in any thread.
        _open_contexts.set(tuple(each for each in _open_contexts.get() if each is not self))
        if isinstance(error, PlannercheckError):
            raise type(error)(f"{self.place}: {error}") from error.__cause__


# The contexts that are open, the outer ones first.
_open_contexts: ContextVar[tuple[error_context, ...]] = ContextVar("open contexts", default=())


def warn_here(sentence: str) -> None:
    """Warns of what is read, with the places of the open contexts before the sentence, as errors have them."""
    warn(": ".join((*(each.place for each in _open_contexts.get()), sentence)))


def read_bytes(path: Path) -> bytes:
    """The content of a file, or an error that says why it can't be read; the caller's context names the file."""
    try:
        return path.read_bytes()
    except OSError as error:
        raise PlannercheckError(f"can't be read: {error.strerror or error}") from None


def parse_yaml(text: bytes | str, as_written: str | None = None) -> Node:
    """Parses a YAML document whose top level maps keys to values.

    Dashes at the end belong to the one document before them: `ros2 topic echo` ends each message so. The scalars of
    mappings under the key `as_written`, wherever it stands, are texts as the file has them.
    """
    text = _without_last_dashes(text)
    check_yaml(text)
    kind = file_kind(text if isinstance(text, bytes) else text.encode(errors="replace"))
    if kind and text.strip():
        raise PlannercheckError(f"no valid YAML: {kind}")
    try:
        document = yaml.load(text, Loader=partial(YamlLoader, as_written=as_written))  # type: ignore[arg-type]  # a safe one
    except PlannercheckError:
        raise
    except (yaml.YAMLError, UnicodeDecodeError, ValueError) as error:  # the last of numbers and dates that are none
        if getattr(error, "context", None) == _SEVERAL:
            raise PlannercheckError(_of_several(text)) from None
        words = _NAMELESS.sub("at ", " ".join(str(error).split()))
        raise PlannercheckError(f"no valid YAML: {words}") from None
    return mapping(document, "the document")


def _without_last_dashes(text: bytes | str) -> bytes | str:
    """The text without a last line of dashes; at the start of a line they end a document whatever is before them."""
    stripped = text.rstrip()
    if isinstance(stripped, bytes):
        return stripped[:-3] if stripped.endswith(b"\n---") else text
    return stripped[:-3] if stripped.endswith("\n---") else text


def _of_several(text: bytes | str) -> str:
    """What is wrong with a text of several documents."""
    try:
        count = sum(isinstance(event, yaml.DocumentStartEvent) for event in yaml.parse(text, Loader=YAML_LOADER))
    except yaml.YAMLError:  # a later one is broken
        return "holds several YAML documents, parted by lines of dashes (---): give a file with one of them"
    return f"holds {count} YAML documents, parted by lines of dashes (---): give a file with one of them"


def mapping(value: Any, what: str) -> Node:
    """The value, if it maps keys to values; nothing at all counts as an empty mapping."""
    if value is None:
        return {}
    if not isinstance(value, dict):
        raise PlannercheckError(f"{what} must be a mapping of keys to values, not {_shortened(value)}")
    return value


def sequence(value: Any, what: str) -> list[Any]:
    """The value, if it is a list; nothing at all counts as an empty list."""
    if value is None:
        return []
    if not isinstance(value, list):
        raise PlannercheckError(f"{what} must be a list, not {_shortened(value)}")
    return value


def check_keys(node: Node, valid: Collection[str]) -> None:
    """Raises for the first key that is not one of the valid ones."""
    for key in node:
        if key not in valid:
            raise unknown_name("key", key, valid)


def required(node: Node, key: str) -> Any:
    """The value of a key that must be there."""
    if node.get(key) is None:
        null = " (it is null; as a text it needs quotes)" if key in node else ""
        raise PlannercheckError(f"key {key!r} is missing{null}; given are {', '.join(map(shortened, node)) or 'none'}")
    return node[key]


def text(value: Any, key: str) -> str:
    """A name, path or word; numbers pass as they are written.

    What YAML 1.1 reads as something else, e.g. on, ~ and 2026-01-02, is refused: it could stand for several words.
    """
    if isinstance(value, str) or (isinstance(value, int | float) and not isinstance(value, bool)):
        return getattr(value, "written", str(value))
    hint = "" if isinstance(value, dict | list) else ": put it in quotes"
    raise PlannercheckError(f"{key!r} must be a text, not {_shortened(value)}{hint}")


def text_or_empty(node: Node, key: str) -> str:
    """The text of a key, empty if it is left out or null."""
    return "" if node.get(key) is None else text(node[key], key)


def number(value: Any, key: str) -> float:
    """A finite number. YAML 1.1 reads `1e-5` as a text: such texts pass as numbers."""
    if type(value) is float and math.isfinite(value):  # most of all
        return value
    try:
        result = math.nan if isinstance(value, bool) else float(value)
    except (TypeError, ValueError, OverflowError):  # the last of whole numbers beyond all doubles
        raise PlannercheckError(f"{key!r} must be a number, not {_shortened(value)}") from None
    if not math.isfinite(result):
        raise PlannercheckError(f"{key!r} must be a finite number, not {_shortened(value)}")
    return result


def numbers(value: Any, key: str, count: int | None = None) -> list[float]:
    """A list of finite numbers, of the given length if one is given."""
    items = _plain_numbers(value)
    if items is None:
        items = [number(v, key) for v in sequence(value, repr(key))]
    if count is not None and len(items) != count:
        raise PlannercheckError(f"{key!r} needs {count} numbers, not {len(items)}: {_shortened(value)}")
    return items


def _plain_numbers(value: Any) -> list[float] | None:
    """What most lists of numbers are, in a third of the time that a look at each takes; None for any other value."""
    if type(value) is not list or not _PLAIN_NUMBERS.issuperset(map(type, value)):
        return None
    try:
        items = [*map(float, value)]
    except OverflowError:
        return None
    return items if all(map(math.isfinite, items)) else None


def _shortened(value: Any) -> str:
    """The value as text, cut to what fits an error message."""
    shown = repr(value)
    return shown if len(shown) <= 60 else shown[:57] + "..."
