"""Maps and clouds of other libraries in tests/bodies/sensed_files, and what these libraries list of them.

In: names of files. Out: cells and points as the library has them. `python tests/support/sensed_files.py FOLDER` writes
the maps of `saved_octrees`, for OctoMap to list.
"""

import sys
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import plannercheck as pc

FOLDER = Path(__file__).parents[1] / "bodies" / "sensed_files"


def octomaps() -> list[str]:
    return sorted(path.name for path in FOLDER.glob("*.[bo]t"))


def clouds() -> list[str]:
    return sorted(path.name.removesuffix(".points") for path in FOLDER.glob("*.points"))


@dataclass
class ListedMap:
    """What OctoMap lists of a map.

    Attributes:
        resolution: In m.
        rows: (n, 4) low corners and edges of the leaves, in steps.
        log_odds: (n,) of the leaves.
        occupied: By threshold, (n,) which leaves are occupied.
        box: The low corner of the box around the leaves, in steps.
        states: (i, j, k) of the box's cells: "#" occupied, "." free, "?" unknown; empty for large boxes.
    """

    resolution: float
    rows: NDArray[np.int64]
    log_odds: NDArray[np.float64]
    occupied: dict[float, NDArray[np.bool_]] = field(default_factory=dict)
    box: NDArray[np.int64] = field(default_factory=lambda: np.zeros(3, dtype=np.int64))
    states: NDArray[np.str_] = field(default_factory=lambda: np.zeros((0, 0, 0), dtype=np.str_))


def listed_map(name: str) -> ListedMap:
    lines = [line.split() for line in (FOLDER / f"{name}.cells").read_text().splitlines()]
    count = int(lines[1][1])
    leaves = lines[2 : 2 + count]
    rows = np.array([[int(word) for word in words[:4]] for words in leaves], dtype=np.int64).reshape(-1, 4)
    found = ListedMap(float.fromhex(lines[0][1]), rows, np.array([float.fromhex(words[4]) for words in leaves]))
    for k, words in enumerate(lines[2 + count :]):
        if words[0] == "threshold":
            found.occupied[float(words[1])] = np.array([bit == "1" for bit in "".join(words[2:])], dtype=np.bool_)
        elif words[0] == "box":
            numbers = [int(word) for word in words[1:]]
            text = "".join(line for (line,) in lines[2 + count + k + 1 :])
            found.box, found.states = np.array(numbers[:3]), np.array(list(text)).reshape(numbers[3:])
            break
    return found


def listed_points(name: str) -> NDArray[np.float64]:
    """(n, 3) as the library that wrote the file reads them."""
    lines = (FOLDER / f"{name}.points").read_text().splitlines()
    return np.array([[float.fromhex(word) for word in line.split()] for line in lines]).reshape(-1, 3)


def saved_octrees() -> dict[str, pc.Octree]:
    """Octrees by the name of their file: cells of all sizes, those at the lattice's ends, and one that is all of it."""
    rng = np.random.default_rng(23)
    keys, sizes = [], []
    for place in range(40):  # blocks of 16 steps, each of which begins with a cell of some size
        keys.append(16 * np.array([place % 5, place // 5 % 4, place // 20]) - [32, 16, 16])
        sizes.append(int(rng.choice([1, 2, 4, 8, 16])))
    ends = [[-32768, -32768, -32768], [32767, 32767, 32767], [16384, -32768, 0]]
    return {
        "saved.bt": pc.Octree.from_cells(keys, 0.05, sizes, rng.random(40) < 0.6),
        "saved_ends.bt": pc.Octree.from_cells(ends, 1e-3, [1, 1, 16384], [True, False, True]),
        "saved_whole.bt": pc.Octree.from_cells([[-32768, -32768, -32768]], 0.1, 65536),
        "saved_empty.bt": pc.Octree.from_cells(np.zeros((0, 3), dtype=np.int64), 0.1),
    }


if __name__ == "__main__":
    for name, octree in saved_octrees().items():
        octree.save(Path(sys.argv[1], name))
