"""Coverings as plain JSON, and the JSON of foam.

In: a JSON file. Out: `Primitives` by link, from {"links": {LINK: {"spheres": [{"center", "radius"}], "capsules":
[{"ends", "radius"}], "boxes": [{"size", "pose"}]}}}, or without "links", or a list of spheres for a link. foam's
spheres have "origin" for "center", a mean, best and worst error beside them, and a list of levels, of which the last
is the finest.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from plannercheck.bodies.shapes import checked_pose
from plannercheck.common.checked_yaml import (
    Node,
    check_keys,
    error_context,
    mapping,
    number,
    numbers,
    read_bytes,
    required,
    sequence,
)
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.unique_keys import object_of
from plannercheck.coverings.primitives import Primitives

SUFFIXES = (".json",)
_FOAM = ("mean", "best", "worst")
_FIELDS = {"spheres": ("center", "origin", "radius"), "capsules": ("ends", "radius"), "boxes": ("size", "pose")}
_KEYS = (*_FIELDS, *_FOAM)


def read(path: Path, link_names: Sequence[str]) -> dict[str, Primitives]:
    """Reads a model; arguments and errors as of `curobo_files.read`."""
    try:
        document = json.loads(read_bytes(path), object_pairs_hook=object_of)
    except (ValueError, RecursionError) as error:
        raise PlannercheckError(f"no JSON: {error!s:.100}") from None
    if isinstance(document, list):
        raise PlannercheckError('spheres of one mesh name no link: put them as {"links": {LINK: [...]}}')
    node = mapping(document, "the document")
    if "links" in node:
        check_keys(node, ("links",))
    found: dict[str, Primitives] = {}
    for name, given in mapping(node.get("links", node), "links").items():
        link = name.split("::")[0]  # foam: LINK::MESH
        if link not in link_names:
            raise unknown_name("link", link, link_names)
        with error_context(f"link {name!r}"):
            found[link] = found.get(link, Primitives.of()) + _primitives(given)
    return found


def _primitives(given: Any) -> Primitives:
    if isinstance(given, list):
        levels = bool(given) and all(isinstance(each, dict) and "spheres" in each for each in given)
        given = given[-1] if levels else {"spheres": given}
    node = mapping(given, "the link's entry")
    check_keys(node, _KEYS)
    spheres = [(_three(each, "center", "origin"), _radius(each)) for each in _rows(node, "spheres")]
    capsules = [(*_ends(each), _radius(each)) for each in _rows(node, "capsules")]
    return Primitives.of(spheres, capsules, [_box(each) for each in _rows(node, "boxes")])


def _rows(node: Node, key: str) -> list[Node]:
    rows = [mapping(each, f"{key} {index}") for index, each in enumerate(sequence(node.get(key), key))]
    for row in rows:
        check_keys(row, _FIELDS[key])
    return rows


def _three(node: Node, *keys: str) -> list[float]:
    given = [key for key in keys if key in node] or [keys[0]]
    if len(given) > 1:
        raise PlannercheckError(f"one of {' and '.join(given)} is enough")
    return numbers(required(node, given[0]), given[0], 3)


def _radius(node: Node) -> float:
    return _length(required(node, "radius"), "radius")


def _length(value: Any, key: str) -> float:
    length = number(value, key)
    if length < 0:
        raise PlannercheckError(f"{key!r} must not be negative (m), not {length}")
    return length


def _ends(node: Node) -> tuple[list[float], list[float]]:
    ends = sequence(required(node, "ends"), "ends")
    if len(ends) != 2:
        raise PlannercheckError(f"'ends' needs 2 points, not {len(ends)}")
    return numbers(ends[0], "ends", 3), numbers(ends[1], "ends", 3)


def _box(node: Node) -> Any:
    size = [_length(each, "size") for each in numbers(required(node, "size"), "size", 3)]
    pose = np.eye(4)
    if node.get("pose") is not None:
        pose = np.array([numbers(row, "pose", 4) for row in sequence(node["pose"], "pose")])
    return checked_pose(pose, "box"), size


def model_text(covers: Mapping[str, Primitives]) -> str:
    """The JSON of primitives by link."""
    return json.dumps({"links": {link: _node(cover) for link, cover in covers.items()}}, indent=1) + "\n"


def _node(cover: Primitives) -> Node:
    rounded = list(zip(cover.ends.tolist(), cover.radii.tolist(), strict=True))
    node = {
        "spheres": [{"center": a, "radius": radius} for (a, b), radius in rounded if a == b],
        "capsules": [{"ends": [a, b], "radius": radius} for (a, b), radius in rounded if a != b],
        "boxes": [
            {"pose": frame, "size": size}
            for frame, size in zip(cover.frames.tolist(), (2 * cover.halves).tolist(), strict=True)
        ],
    }
    return {key: rows for key, rows in node.items() if rows}
