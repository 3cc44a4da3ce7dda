"""What trimesh's readers (with pycollada) and ours make of small files: `python tests/benchmarks/mesh_readers.py`.

In: the files of the tests, right ones and broken ones, and mutated ones. Out: a line a format and demand, with how many
files each reader got right, rounded to single precision, lost triangles of, read otherwise, accepted though broken,
refused, or did not return from; and a table of trimesh's by format. Trimesh is asked for all
that it offers: its scene, nothing merged or reordered, OBJ objects apart, units converted, broken Collada an error. Any
exception of it is a refusal. A file that is cut short is broken if we refuse it: others lack the end of a line alone.

A mutated file has no known meaning. What a plain reading of its lines gives is right, a file that it can't read is
broken; binary and structured formats are held by their counts alone (mutated_meshes.py).
"""

import argparse
import logging
import signal
import tempfile
import warnings
from collections import Counter, defaultdict
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import mutated_meshes
import numpy as np
import trimesh
from mesh_reader_files import Y_UP, Case, Objects, all_files

from plannercheck.bodies.mesh_files import read_mesh
from plannercheck.common.errors import PlannercheckError

_SECONDS = 10
_EXACT, _SINGLE = 1e-13, 1e-6  # parts of the largest coordinate
# By file, demand and reader.
Counts = dict[tuple[str, str, str], Counter[str]]
_KINDS = ("right", "rounded", "dropped", "otherwise", "accepted", "refused", "crashed")


def ours(path: Path) -> Objects:
    mesh = read_mesh(path, units="file")
    return {each.name: each.points[each.triangles] for each in mesh.objects}


def theirs(path: Path) -> Objects:
    more: dict[str, Any] = {".dae": {"ignore_broken": False}}.get(path.suffix, {"merge_primitives": True})
    if path.suffix == ".obj":
        splits = b"\no " in b"\n" + path.read_bytes()
        more = {"maintain_order": True, "split_objects": splits, "split_groups": not splits, "group_material": False}
    scene = trimesh.load_scene(path, process=False, **more)
    if scene.units:
        scene = scene.convert_units("meters")
    turn = np.array(Y_UP if path.suffix in (".gltf", ".glb") else np.eye(3))  # glTF is always y up
    found = {}
    for node in scene.graph.nodes_geometry:
        matrix, key = scene.graph[node]
        mesh = scene.geometry[key]
        if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces):
            corners = mesh.vertices.view(np.ndarray)[mesh.faces].astype(np.float64)
            same = (matrix == np.eye(4)).all()
            found[node] = (corners if same else corners @ matrix[:3, :3].T + matrix[:3, 3]) @ turn.T
    if not found:
        raise ValueError("no triangles")
    return found


_READERS = {"trimesh": theirs, "ours": ours}


def judged(found: Objects, case: Case) -> str:
    """One of the kinds, for a file that has been read."""
    if case.wanted is None:
        return "dropped" if sum(map(len, found.values())) < case.triangles else "accepted"
    if case.demand == "names":
        if set(found) != set(case.wanted):
            return "otherwise"
        found = {name: found[name] for name in case.wanted}
    here, there = (np.concatenate(list(each.values())) for each in (found, case.wanted))
    if len(here) < len(there):
        return "dropped"
    if len(here) > len(there):
        return "otherwise"
    scale = np.abs(there).max()
    away = min(np.abs(a - b).max() for a, b in ((here, there), (_in_order(here), _in_order(there)))) / scale
    return "right" if away <= _EXACT else "rounded" if away <= _SINGLE else "otherwise"


def _in_order(corners: np.ndarray) -> np.ndarray:
    """Triangles from their least corner on, sorted."""
    rolled = [min([t[k:] + t[:k] for k in range(3)]) for t in corners.tolist()]
    return np.array(sorted(rolled))


def outcome(read: Callable[[Path], Objects], path: Path) -> Objects | str:
    """What a reader gives within a time limit, or "refused" or "crashed"."""
    signal.alarm(_SECONDS)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return read(path)
    except (MemoryError, RecursionError, _TimeLimitError):
        return "crashed"
    except PlannercheckError:
        return "refused"
    except Exception:
        return "refused" if read is theirs else "crashed"
    finally:
        signal.alarm(0)


class _TimeLimitError(Exception):
    pass


def _late(*_: object) -> None:
    raise _TimeLimitError


def mutated_kind(path: Path, content: bytes, found: Objects) -> str:
    """One of the kinds, for a mutated file that has been read: by a plain reading of its lines."""
    corners = np.concatenate(list(found.values())).reshape(-1, 3)
    mesh = _Corners(corners, np.arange(len(corners)).reshape(-1, 3))
    try:
        differs = mutated_meshes.difference(path.name, content, mesh)
    except (ValueError, IndexError, KeyError, OverflowError):
        return "accepted"
    if not differs:
        return "right"
    return "dropped" if "triangles" in differs else "otherwise"


class _Corners(NamedTuple):
    points: np.ndarray
    triangles: np.ndarray


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--mutated", type=int, default=300, help="mutated files a format")
    options = parser.parse_args()
    logging.disable()
    signal.signal(signal.SIGALRM, _late)
    counts: Counts = defaultdict(Counter)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for case in all_files(folder):
            for seed in range(options.mutated if case.demand == "mutated" else 1):
                count(case, seed, folder, counts)
    for (file, demand, who), kinds in sorted(counts.items()):
        print(f"{file:12}{demand:18}{who:9}" + ", ".join(f"{kind} {kinds[kind]}" for kind in _KINDS if kinds[kind]))
    print(table(counts))


def count(case: Case, seed: int, folder: Path, counts: Counts) -> None:
    """Counts what each reader makes of a file, or of its mutant with a seed."""
    mutated = case.demand == "mutated"
    content = mutated_meshes.mutated(case.content, seed) if mutated else case.content
    path = folder / case.name
    path.write_bytes(content)
    for who, read in _READERS.items():
        found = outcome(read, path)
        kind = (
            found if isinstance(found, str) else mutated_kind(path, content, found) if mutated else judged(found, case)
        )
        counts[case.name, case.demand, who][kind] += 1


def table(counts: Counts) -> str:
    """Markdown: what trimesh makes of files that are right, broken, and mutated."""
    lines = ["| file | right | rounded | lost or otherwise | refused | broken, accepted | mutated, accepted wrongly |"]
    lines.append("|" + " --- |" * 7)
    for name in dict.fromkeys(file for file, _, _ in counts):
        sums: dict[str, Counter[str]] = defaultdict(Counter)
        for (file, demand, who), kinds in counts.items():
            if (file, who) == (name, "trimesh"):
                sums[demand if demand == "mutated" else demand.partition(":")[0] if ":" in demand else "right"] += kinds
        right, broken, mutated = sums["right"], sums["broken"], sums["mutated"]
        cells = [f"{right['right']} of {right.total()}", right["rounded"], right["dropped"] + right["otherwise"]]
        cells += [right["refused"], f"{broken.total() - broken['refused']} of {broken.total()}"]
        cells += [f"{mutated.total() - mutated['refused'] - mutated['right']} of {mutated.total()}"]
        lines.append(f"| {name} | " + " | ".join(map(str, cells)) + " |")
    return "\n".join(lines)


if __name__ == "__main__":
    main()
