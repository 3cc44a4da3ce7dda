"""Reads planar robots: robots/<name>.yaml with `kind: planar`.

In: a path. Out: the arguments of `Robot`. Lengths are in m, angles in rad:

    kind: planar
    name: truck_trailer            # default: the file's name
    links:                         # parents first; the first one is the root
      - name: truck
        joint: free                # x, y and theta; or fixed
        footprint: [[-1, -1], [5, -1], [5, 1], [-1, 1]]   # or footprints: several; concave ones are split
      - name: trailer
        parent: truck
        anchor: [-0.5, 0, 0]       # x, y and angle of its frame on the parent's
        joint: revolute            # or fixed, the default
        limits: [-1.2, 1.2]        # optional
        footprint: [[-8, -1.2], [0.5, -1.2], [0.5, 1.2], [-8, 1.2]]
    disabled_pairs: [[truck, trailer]]   # optional; neighbours are not tested anyway
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from plannercheck.common.checked_yaml import (
    Node,
    check_keys,
    error_context,
    mapping,
    numbers,
    parse_yaml,
    read_bytes,
    required,
    sequence,
    text,
)
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.package_data import is_planar_file, shipped_folder
from plannercheck.planar.links import Link

_KEYS = ("kind", "name", "links", "disabled_pairs")
_LINK_KEYS = ("name", "parent", "anchor", "joint", "limits", "footprint", "footprints")


def shipped_planar(folder: str) -> list[str]:
    """Names of the planar robots ("robots") or scenes ("configs") that come with plannercheck."""
    return sorted(path.stem for path in shipped_folder(folder).glob("*.yaml") if is_planar_file(path))


def planar_file(name_or_path: str | Path, folder: str) -> Path:
    """The path itself, or the file of a shipped planar robot ("robots") or scene ("configs") for a bare name."""
    path = Path(name_or_path)
    if path.suffix or len(path.parts) != 1:
        return path
    if str(name_or_path) not in shipped_planar(folder):
        raise unknown_name(f"planar {folder.rstrip('s')}", str(name_or_path), shipped_planar(folder))
    return shipped_folder(folder) / f"{name_or_path}.yaml"


def is_planar(name_or_path: str | Path, folder: str) -> bool:
    """Whether a robot ("robots") or scene ("configs") is planar, by the file behind its name or path."""
    path = Path(name_or_path)
    if not path.suffix and len(path.parts) == 1:
        path = shipped_folder(folder) / f"{name_or_path}.yaml"
    return path.suffix in (".yaml", ".yml") and is_planar_file(path)


def read_robot(path: Path) -> tuple[list[Link], str, list[tuple[str, str]]]:
    """Reads a planar robot from YAML: links, name, and pairs of links that are not tested against each other."""
    content = planar_document(path, _KEYS)
    links = [_link(mapping(item, f"link {k}"), k) for k, item in enumerate(sequence(content.get("links"), "'links'"))]
    if not links:
        raise PlannercheckError("'links' must list at least one link")
    pairs = [_names(pair) for pair in sequence(content.get("disabled_pairs"), "'disabled_pairs'")]
    return links, text(content.get("name", path.stem), "name"), pairs


def planar_document(path: Path, keys: tuple[str, ...]) -> Node:
    """The content of a file that says `kind: planar`."""
    content = parse_yaml(read_bytes(path))
    if content.get("kind") != "planar":
        raise PlannercheckError("it is not planar: 'kind: planar' is missing")
    check_keys(content, keys)
    return content


def outline(value: Any, key: str) -> list[list[float]]:
    """The vertices of a polygon."""
    return [numbers(row, f"{key} vertex {k}", 2) for k, row in enumerate(sequence(value, repr(key)))]


def _link(node: Node, index: int) -> Link:
    with error_context(f"link {index}"):
        check_keys(node, _LINK_KEYS)
        name = text(required(node, "name"), "name")
    with error_context(f"link {name!r}"):
        if ("footprint" in node) == ("footprints" in node):
            raise PlannercheckError("needs a footprint, or footprints")
        given = [node["footprint"]] if "footprint" in node else sequence(node["footprints"], "'footprints'")
        x, y, angle = numbers(node.get("anchor", [0, 0, 0]), "anchor", 3)
        low, high = numbers(node["limits"], "limits", 2) if "limits" in node else (-math.inf, math.inf)
        return Link(
            name,
            [outline(polygon, "footprint") for polygon in given],
            text(node["parent"], "parent") if node.get("parent") is not None else None,
            (x, y, angle),
            text(node.get("joint", "fixed"), "joint"),  # type: ignore[arg-type]  # the robot checks it
            (low, high),
        )


def _names(pair: Any) -> tuple[str, str]:
    names = [text(name, "disabled_pairs") for name in sequence(pair, "a disabled pair")]
    if len(names) != 2:
        raise PlannercheckError(f"a disabled pair must be two links, not {names}")
    return names[0], names[1]
