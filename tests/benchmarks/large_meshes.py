"""How long meshes of a million triangles take to load, beside trimesh: `python tests/benchmarks/large_meshes.py`.

In: a count of triangles. Out: a line a format: the file's size, and processor seconds of `pc.Solid.load`, which merges
equal points and adds caps, and of trimesh's own load, which leaves the mesh as it is. The mesh is a wavy sheet, so it
is open; texts have all digits of doubles, and STL is indented. Nothing is cached.
"""

import argparse
import os
import tempfile
import time
import warnings
from collections.abc import Callable
from pathlib import Path

os.environ["PLANNERCHECK_CACHE"] = "0"

import numpy as np
import trimesh

import plannercheck as pc

_FACET = " facet normal 0 0 0\n  outer loop\n{}  endloop\n endfacet\n"
_HEAD = "ply\nformat {} 1.0\nelement vertex {}\n{}element face {}\nproperty list uchar int vertex_indices\nend_header\n"
_AXES = "property double x\nproperty double y\nproperty double z\n"


def sheet(triangles: int) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3) and at least so many triangles (m, 3) of a wavy sheet."""
    side = int(np.ceil(np.sqrt(triangles / 2)))
    x, y = np.meshgrid(*[np.linspace(0, 1, side + 1)] * 2)
    points = np.column_stack([x.ravel(), y.ravel(), (0.1 * np.sin(7 * x) * np.cos(5 * y)).ravel()])
    corner = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).ravel()
    right, across, above = corner + 1, corner + side + 2, corner + side + 1
    return points, np.concatenate([np.column_stack([corner, right, across]), np.column_stack([corner, across, above])])


def write(folder: Path, points: np.ndarray, triangles: np.ndarray) -> list[Path]:
    """The mesh in each format."""
    places = [f"{x!r} {y!r} {z!r}\n" for x, y, z in points.tolist()]
    faces = "".join(f"3 {a} {b} {c}\n" for a, b, c in triangles.tolist())
    texts = {
        "text.stl": "solid\n"
        + "".join(_FACET.format("".join(f"   vertex {places[k]}" for k in t)) for t in triangles.tolist())
        + "endsolid\n",
        "sheet.obj": "".join(f"v {place}" for place in places)
        + "".join(f"f {a} {b} {c}\n" for a, b, c in (triangles + 1).tolist()),
        "text.ply": _HEAD.format("ascii", len(points), _AXES, len(triangles)) + "".join(places) + faces,
        "sheet.off": f"OFF\n{len(points)} {len(triangles)} 0\n" + "".join(places) + faces,
    }
    for name, text in texts.items():
        (folder / name).write_text(text)
    rows = np.zeros(len(triangles), [("count", "u1"), ("corners", "<i4", 3)])
    rows["count"], rows["corners"] = 3, triangles
    head = _HEAD.format("binary_little_endian", len(points), _AXES, len(triangles)).encode()
    (folder / "binary.ply").write_bytes(head + points.astype("<f8").tobytes() + rows.tobytes())
    (folder / "binary.stl").write_bytes(trimesh.Trimesh(points, triangles, process=False).export(file_type="stl"))
    return [folder / name for name in ("text.stl", "binary.stl", "sheet.obj", "text.ply", "binary.ply", "sheet.off")]


def seconds(load: Callable[[], object]) -> float:
    """Processor time of a call, s."""
    began = time.process_time()
    load()
    return time.process_time() - began


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--triangles", type=int, default=1_000_000)
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    points, triangles = sheet(options.triangles)
    print(f"{len(triangles)} triangles; processor time, s")
    print(f"{'file':12}{'MB':>6}{'plannercheck':>14}{'trimesh':>9}")
    with tempfile.TemporaryDirectory() as folder:
        for path in write(Path(folder), points, triangles):
            ours = seconds(lambda path=path: pc.Solid.load(path))
            theirs = seconds(lambda path=path: trimesh.load(path, process=False))
            print(f"{path.name:12}{path.stat().st_size / 1e6:6.0f}{ours:14.1f}{theirs:9.1f}", flush=True)


if __name__ == "__main__":
    main()
