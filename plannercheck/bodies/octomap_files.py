"""OctoMap's trees: .bt and .ot files, and the data of its messages.

In: bytes. Out: the leaves of the tree, as cells of a lattice: low corner and size in steps of the resolution, and the
log-odds of each (for binary trees, OctoMap's clamping values). Also the bytes of a .bt file of leaves.

A tree has 16 levels; its root reaches from step -32768 to 32768 along each axis, and the bits 1, 2 and 4 of a child's
number say in which halves of x, y and z it is. A binary tree lists its inner nodes in preorder, 16 bits each, two for
each child: 0 unknown, 1 a free leaf, 2 an occupied one, 3 an inner node. A full tree lists all nodes in preorder: a
float with the log-odds, three bytes of colour in a ColorOcTree, and a byte with a bit for each existing child. (OctoMap
1.10: OccupancyOcTreeBase.hxx, OcTreeBaseImpl.hxx, AbstractOccupancyOcTree.cpp.)

The tree is not walked node by node. Sum up the number of children less one along the preorder: where this sum first
falls below its value before a node, the node's subtree ends. So sorting finds all ends, and then all levels at once.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.array_types import Bools, Ints, Ints64
from plannercheck.common.arrays import distinct_values
from plannercheck.common.errors import PlannercheckError, shortened, unknown_name

LEVELS = 16
# The root's size in steps, and the lattice's step at the root's low corner.
ROOT_SIZE, ROOT_LOW = 1 << LEVELS, -(1 << (LEVELS - 1))

# To what OctoMap clamps log-odds by default, as floats: what a binary tree's leaves have.
_FREE, _OCCUPIED = np.float32(math.log(0.1192 / (1 - 0.1192))), np.float32(math.log(0.971 / (1 - 0.971)))

_BINARY_START, _FULL_START = b"# Octomap OcTree binary file", b"# Octomap OcTree file"
_DEPRECATED_ID, _PLAIN_ID = "1", "OcTree"

OCTREE_SUFFIXES = (".bt", ".ot")

# Bytes between a node's log-odds and the byte of its children, by the tree's id. Time stamps are not in files.
_FILLINGS = {"OcTree": 0, "ColorOcTree": 3, "OcTreeStamped": 0}

_LONGEST_HEADER = 1 << 16
_LONGEST_SIZE = 15
_LEGACY_TYPE = 3


@dataclass(frozen=True)
class OctomapLeaves:
    """The leaves of a tree.

    Attributes:
        keys: (n, 3) low corner in steps of the resolution.
        sizes: (n,) in steps, powers of two.
        log_odds: (n,) of being occupied.
        resolution: Edge of the smallest cells, m.
    """

    keys: Ints
    sizes: Ints
    log_odds: NDArray[np.float32]
    resolution: float

    def occupied(self, threshold: float) -> Bools:
        """(n,) whether a leaf's probability is at least a threshold, as OctoMap compares them: log-odds as floats."""
        return np.asarray(self.log_odds >= np.float32(math.log(threshold / (1 - threshold))))


@dataclass(frozen=True)
class _Header:
    kind: str
    nodes: int
    resolution: float
    end: int


def read_octomap(content: bytes) -> OctomapLeaves:
    """The leaves of a .bt or .ot file's content, told by its first line.

    Raises:
        PlannercheckError: If it is neither, is cut short, or has another number of nodes than its header says.
    """
    if content.startswith(_BINARY_START):
        header, is_binary = _header(content), True
    elif content.startswith(_FULL_START):
        header, is_binary = _header(content), False
    else:
        header, is_binary = _legacy_header(content), True
    if header.nodes == 0:
        if len(content) > header.end:
            raise PlannercheckError("its header says that it has no nodes, but data follows")
        return _leaves(_no_nodes(), header.resolution)
    nodes = tree_of_data(content[header.end :], header.kind, is_binary)
    if len(nodes.sizes) != header.nodes:
        raise PlannercheckError(f"its header says {header.nodes} nodes, but its tree has {len(nodes.sizes)}")
    return _leaves(nodes, header.resolution)


def leaves_of_data(data: bytes, kind: str, is_binary: bool, resolution: float) -> OctomapLeaves:
    """The leaves of the data of an octomap message, which has no header; nothing is no leaves.

    The kind is the tree's id, e.g. "OcTree"; it is binary (.bt) or full (.ot). The resolution is the edge of the
    smallest cells, m.
    """
    _check_resolution(resolution)
    nodes = tree_of_data(data, kind, is_binary) if data else _no_nodes()
    return _leaves(nodes, resolution)


@dataclass(frozen=True)
class _Nodes:
    """The nodes of a tree, in any order: as `OctomapLeaves`, and which are leaves."""

    keys: Ints64
    sizes: Ints64
    log_odds: NDArray[np.float32]
    is_leaf: Bools


def _no_nodes() -> _Nodes:
    none = np.zeros(0, dtype=np.int64)
    return _Nodes(np.zeros((0, 3), dtype=np.int64), none, none.astype(np.float32), none.astype(np.bool_))


def _leaves(nodes: _Nodes, resolution: float) -> OctomapLeaves:
    chosen = nodes.is_leaf
    keys, sizes = nodes.keys[chosen].astype(np.int32), nodes.sizes[chosen].astype(np.int32)
    return OctomapLeaves(keys, sizes, nodes.log_odds[chosen], resolution)


def tree_of_data(data: bytes, kind: str, is_binary: bool) -> _Nodes:
    """All nodes of a tree's data."""
    if kind not in _FILLINGS:
        raise unknown_name("type of octree (a tree with occupancies is needed)", kind, _FILLINGS)
    return _binary_nodes(data) if is_binary else _full_nodes(data, _FILLINGS[kind])


def _header(content: bytes) -> _Header:
    """The lines up to "data": id, size and res, in any order."""
    found: dict[str, str] = {}
    at = 0
    while True:
        end = content.find(b"\n", at, _LONGEST_HEADER)
        if end < 0:
            raise PlannercheckError("its header is cut short: it ends with a line 'data'")
        words = content[at:end].decode("latin-1").split()
        at = end + 1
        if not words or words[0].startswith("#"):
            continue
        if words == ["data"]:
            break
        if len(words) != 2 or words[0] not in ("id", "size", "res") or words[0] in found:
            raise PlannercheckError(
                f"its header has a line {shortened(' '.join(words))!r}: valid are id, size, res, data"
            )
        found[words[0]] = words[1]
    for key in ("id", "size", "res"):
        if key not in found:
            raise PlannercheckError(f"its header does not say {key!r}")
    if not (found["size"].isdecimal() and found["size"].isascii() and len(found["size"]) <= _LONGEST_SIZE):
        raise PlannercheckError(f"its header has size {shortened(found['size'])!r}, it must be a number of nodes")
    try:
        resolution = float(found["res"])
    except ValueError:
        raise PlannercheckError(f"its header has res {shortened(found['res'])!r}, it must be a length in m") from None
    _check_resolution(resolution)
    kind = _PLAIN_ID if found["id"] == _DEPRECATED_ID else found["id"]
    return _Header(kind, int(found["size"]), resolution, at)


def _legacy_header(content: bytes) -> _Header:
    """OctoMap's first binary files: a type, the resolution, the number of nodes."""
    legacy = np.dtype([("kind", "<i4"), ("resolution", "<f8"), ("nodes", "<u4")])
    if len(content) < legacy.itemsize or int.from_bytes(content[:4], "little") != _LEGACY_TYPE:
        raise PlannercheckError(
            f"is no octomap, or is cut short: it must begin with {_BINARY_START.decode()!r} or {_FULL_START.decode()!r}"
        )
    values = np.frombuffer(content, legacy, 1)[0]
    _check_resolution(float(values["resolution"]))
    return _Header(_PLAIN_ID, int(values["nodes"]), float(values["resolution"]), legacy.itemsize)


def _check_resolution(resolution: float) -> None:
    if not (resolution > 0 and resolution * ROOT_SIZE < math.inf):
        raise PlannercheckError(f"its resolution is {resolution}, it must be a length in m above 0")


def _binary_nodes(data: bytes) -> _Nodes:
    """Nodes of a binary tree: its inner ones from the data, its leaves from their parents' bits."""
    words = np.frombuffer(data, "<u2", len(data) // 2)
    kinds = (words[:, None] >> np.arange(0, 16, 2, dtype=np.uint16)).astype(np.uint8) & 3
    count = _count_of_nodes((kinds == 3).sum(axis=1), len(data), 2)
    kinds = kinds[:count]
    if count == 1 and not kinds.any():  # a root without children: OctoMap reads it as occupied
        low = np.full((1, 3), ROOT_LOW)
        return _Nodes(low, np.array([ROOT_SIZE]), np.array([_OCCUPIED]), np.ones(1, dtype=np.bool_))
    if not kinds.any(axis=1).all():
        raise PlannercheckError("its tree has an inner node without children")
    keys, sizes = _places(kinds == 3)
    parent, child = np.nonzero((kinds == 1) | (kinds == 2))
    half = sizes[parent] // 2
    leaf_keys = keys[parent] + _corners()[child] * half[:, None]
    log_odds = np.where(kinds[parent, child] == 2, _OCCUPIED, _FREE)
    inner = np.zeros(count, dtype=np.float32)
    is_leaf = np.repeat([False, True], [count, len(child)])
    return _Nodes(
        np.concatenate([keys, leaf_keys]), np.concatenate([sizes, half]), np.concatenate([inner, log_odds]), is_leaf
    )


def _full_nodes(data: bytes, filling: int) -> _Nodes:
    row = np.dtype(
        [("log_odds", "<f4"), ("filling", f"V{filling}"), ("children", "u1")]
        if filling
        else [("log_odds", "<f4"), ("children", "u1")]
    )
    table = np.frombuffer(data, row, len(data) // row.itemsize)
    children = (table["children"][:, None] >> np.arange(8, dtype=np.uint8)) & 1 != 0
    count = _count_of_nodes(children.sum(axis=1), len(data), row.itemsize)
    log_odds = table["log_odds"][:count].astype(np.float32)
    if np.isnan(log_odds).any():
        raise PlannercheckError(
            f"node {int(np.argmax(np.isnan(log_odds)))} of its tree has an occupancy that is no number"
        )
    keys, sizes = _places(children[:count])
    return _Nodes(keys, sizes, log_odds, ~children[:count].any(axis=1))


def _count_of_nodes(degrees: Ints64, size: int, step: int) -> int:
    """How many nodes a preorder of these degrees has, which must fill the data."""
    missing = 1 + np.cumsum(degrees.astype(np.int64) - 1)
    ends = np.flatnonzero(missing == 0)
    if not len(ends):
        raise PlannercheckError(f"its tree is cut short: after {size} bytes nodes are missing")
    count = int(ends[0]) + 1
    if size != count * step:
        raise PlannercheckError(f"{size - count * step} bytes follow its tree")
    return count


def _corners() -> Ints64:
    """(8, 3) in which half along x, y and z a child is."""
    return np.arange(8)[:, None] >> np.arange(3) & 1


def _places(is_inner: Bools) -> tuple[Ints64, Ints64]:
    """Low corners (n, 3) and sizes (n,) of the listed nodes, in steps.

    `is_inner` (n, 8) says of each node in preorder which of its children are listed, too.
    """
    count = len(is_inner)
    ends = _ends(is_inner.sum(axis=1))
    keys, sizes = np.empty((count, 3), dtype=np.int64), np.empty(count, dtype=np.int64)
    nodes, size = np.zeros(1, dtype=np.int64), ROOT_SIZE
    keys[0], sizes[0] = ROOT_LOW, ROOT_SIZE
    while len(nodes):
        size //= 2
        following, found = nodes + 1, []
        for child, corner in enumerate(_corners()):
            has = is_inner[nodes, child]
            children = following[has]
            keys[children], sizes[children] = keys[nodes[has]] + corner * size, size
            following[has] = ends[children] + 1
            found.append(children)
        nodes = np.concatenate(found)
        if len(nodes) and size == 0:
            raise PlannercheckError(f"its tree is deeper than {LEVELS} levels")
    return keys, sizes


def _ends(degrees: Ints64) -> Ints64:
    """(n,) the last node of each node's subtree in a preorder."""
    count = len(degrees)
    places = np.arange(count, dtype=np.int64)
    missing = 1 + np.cumsum(degrees.astype(np.int64) - 1)
    before = missing - (degrees - 1)
    marks = np.sort(missing * count + places)  # by what is missing, then by place
    return np.asarray(marks[np.searchsorted(marks, (before - 1) * count + places)] % count)


def binary_file(keys: Ints64, sizes: Ints64, occupied: Bools, resolution: float) -> bytes:
    """The content of a .bt file of disjoint cells; OctoMap reads the same cells from it.

    Low corners (n, 3) and sizes (n,), powers of two, are in steps of the resolution, m; cells that are not occupied are
    free.
    """
    if len(sizes) == 1 and sizes[0] == ROOT_SIZE:  # the format has no leaf as its root
        keys = keys + _corners() * (ROOT_SIZE // 2)
        sizes, occupied = np.full(8, ROOT_SIZE // 2), np.repeat(occupied, 8)
    codes, levels = morton_codes(keys.astype(np.int64) - ROOT_LOW), levels_of(sizes)
    places, depths, words, nodes = [], [], [], len(sizes)
    inner = np.zeros(0, dtype=np.int64)  # codes of the inner nodes of the level below
    for level in range(LEVELS):  # the level of the children: 0 the smallest cells
        mine = levels == level
        children = np.concatenate([inner, codes[mine] >> 3 * level])
        kinds = np.concatenate([np.full(len(inner), 3), np.where(occupied[mine], 2, 1)])
        inner, which = distinct_values(children >> 3)
        word = np.zeros(len(inner), dtype=np.int64)
        np.bitwise_or.at(word, which.reshape(-1), kinds << 2 * (children & 7))
        places.append(inner << 3 * (level + 1))
        depths.append(np.full(len(inner), LEVELS - level))
        words.append(word)
        nodes += len(inner)
    order = np.lexsort((np.concatenate(depths), np.concatenate(places)))
    data = np.concatenate(words)[order].astype("<u2").tobytes()
    start = f"{_BINARY_START.decode()}\n# (feel free to add / change comments, but leave the first line as it is!)\n#\n"
    return f"{start}id {_PLAIN_ID}\nsize {nodes}\nres {resolution!r}\ndata\n".encode() + data


def levels_of(sizes: Ints64) -> Ints64:
    """(n,) the logarithms of sizes that are powers of two."""
    return np.asarray(np.frexp(sizes.astype(np.float64))[1] - 1, dtype=np.int64)


def morton_codes(keys: Ints64) -> Ints64:
    """(n,) one number for each place (n, 3) of 0 to 65535 steps: the bits of z, y and x in turn."""
    codes = np.zeros(len(keys), dtype=np.int64)
    for axis in range(3):
        bits = np.array(keys[:, axis], dtype=np.int64)
        for shift, mask in ((16, 0x0000FF0000FF), (8, 0x00F00F00F00F), (4, 0x0C30C30C30C3), (2, 0x249249249249)):
            bits = (bits | bits << shift) & mask
        codes |= bits << axis
    return codes
