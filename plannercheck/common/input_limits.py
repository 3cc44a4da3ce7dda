"""Limits of what files may hold, so that a hostile one gives an error instead of a crash, a hang or a full memory.

In: bytes of YAML, the path of an XML file, sizes of archives' members. Out: nothing, or an error that names the limit.
Parsers of both formats are recursive in native code and crash on a file nested some ten thousand deep. Aliases of YAML
stand for copies, whose number can double with every line. Event parsers count both first.

The limits are far beyond the needs of robots and scenes; they can be changed: `INPUT_LIMITS.depth = 500`. PyYAML from
6.0.4 on goes no deeper than `PARSERS_DEPTH` itself.
"""

from __future__ import annotations

import xml.parsers.expat
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from plannercheck.common.errors import PlannercheckError

# libyaml's loader is ten times faster; PyYAML comes without it on some platforms.
YAML_LOADER: type[Any] = getattr(yaml, "CSafeLoader", yaml.SafeLoader)

# Levels at which PyYAML's parser gives up (from 6.0.4 on), and what it says then. It reads ahead, so it may say so
# before any event tells of a level.
PARSERS_DEPTH = 1000
_PARSER_SAYS = "maximum nesting depth"


@dataclass
class InputLimits:
    """What files may hold.

    Attributes:
        depth: Levels of nesting in YAML and XML; for JSON Python has a limit of its own.
        nodes: Values of a YAML document, each as often as aliases repeat it.
        archive_bytes: That an archive's files may take when unpacked, all together.
    """

    depth: int = 200
    nodes: int = 20_000_000
    archive_bytes: int = 1 << 30


INPUT_LIMITS = InputLimits()


def check_yaml(text: bytes | str) -> None:
    """Raises if YAML is nested too deep, or repeats too much by aliases; of what is no YAML nothing is said here."""
    raw = text.encode(errors="replace") if isinstance(text, str) else text
    if not (_may_be_deep(raw) or (b"&" in raw and b"*" in raw) or raw[:2] in (b"\xff\xfe", b"\xfe\xff")):
        return
    try:
        _check_events(text)
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        if _PARSER_SAYS in str(getattr(error, "problem", None)) and INPUT_LIMITS.depth <= PARSERS_DEPTH:
            raise _too_deep() from None
        # Who parses it will say what is wrong.


def _too_deep() -> PlannercheckError:
    return PlannercheckError(f"is nested deeper than {INPUT_LIMITS.depth} levels (INPUT_LIMITS.depth)")


def _may_be_deep(raw: bytes) -> bool:
    """Whether brackets or indentation could nest beyond the limit; False proves that they do not."""
    opened = raw.count(b"[") + raw.count(b"{")
    if opened < INPUT_LIMITS.depth // 2:
        marks = raw.count(b"- ") + raw.count(b"-\n") + raw.count(b"? ") + raw.count(b": ") + raw.count(b":\n")
        return marks >= INPUT_LIMITS.depth // 2 and _widest_line_start(raw) >= INPUT_LIMITS.depth // 2
    return True


# By byte: whether it is neither a blank nor a mark with which a line begins.
_IS_OTHER = np.ones(256, dtype=bool)
_IS_OTHER[list(b" -?:\t\r")] = False


def _widest_line_start(raw: bytes) -> int:
    """Most spaces and marks of sequences and keys at the beginning of a line: blocks nest by one column at least."""
    codes = np.frombuffer(raw, dtype=np.uint8)
    starts = np.concatenate([[0], np.flatnonzero(codes == ord("\n")) + 1])
    others = np.flatnonzero(_IS_OTHER[codes])
    if not len(others):
        return len(codes)
    first = others[np.minimum(np.searchsorted(others, starts), len(others) - 1)]
    return int(np.maximum(first - starts, 0).max(initial=0))


def _check_events(text: bytes | str) -> None:
    """Follows the document's events: depth, and values with aliases counted as what they stand for."""
    sizes: dict[str, int] = {}
    open_nodes: list[list[Any]] = [[None, 0]]  # anchor and size so far
    for event in yaml.parse(text, Loader=YAML_LOADER):
        if isinstance(event, yaml.CollectionStartEvent):
            open_nodes.append([event.anchor, 1])
            if len(open_nodes) > INPUT_LIMITS.depth + 1:
                raise _too_deep()
            continue
        if isinstance(event, yaml.ScalarEvent):
            anchor, size = event.anchor, 1
        elif isinstance(event, yaml.AliasEvent):
            anchor, size = None, sizes.get(str(event.anchor), 1)
        elif isinstance(event, yaml.CollectionEndEvent):
            anchor, size = open_nodes.pop()
        else:
            continue
        if anchor is not None:
            sizes[anchor] = size
        open_nodes[-1][1] += size
        if open_nodes[-1][1] > INPUT_LIMITS.nodes:
            raise PlannercheckError(
                f"stands for more than {INPUT_LIMITS.nodes} values, since its aliases repeat them (INPUT_LIMITS.nodes)"
            )


def check_xml(path: Path, what: str) -> None:
    """Raises if the elements of a URDF or SRDF (`what`) are nested too deep; short files are not looked at."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise PlannercheckError(f"{what} {path} can't be read: {error.strerror or error}") from None
    check_xml_text(content, f"{what} {path}")


def check_xml_text(content: bytes, what: str) -> None:
    """The same of what has been read already; `what` also names the file."""
    if content.count(b"<") <= INPUT_LIMITS.depth:
        return
    depth, deepest = 0, 0

    def start(name: str, attributes: Any) -> None:
        nonlocal depth, deepest
        depth += 1
        deepest = max(deepest, depth)

    def end(name: str) -> None:
        nonlocal depth
        depth -= 1

    parser = xml.parsers.expat.ParserCreate()
    parser.StartElementHandler, parser.EndElementHandler = start, end
    try:
        parser.Parse(content, True)
    except xml.parsers.expat.ExpatError as error:
        raise PlannercheckError(f"{what} is not well-formed XML: {error}") from None
    if deepest > INPUT_LIMITS.depth:
        raise PlannercheckError(f"{what} is nested deeper than {INPUT_LIMITS.depth} levels (INPUT_LIMITS.depth)")
