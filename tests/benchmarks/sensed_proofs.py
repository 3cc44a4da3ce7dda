"""Proofs of a planned path before what cameras see: `python tests/benchmarks/sensed_proofs.py`.

The Panda goes from a shelf to another one (OMPL's RRTConnect) before clouds of the bookshelf, before an octomap of it
and over a terrain. What counts: the time to build a motion's proof and to verify it, the size of the file, and how many
entries and directions it has. A proof holds every point, so that the file is about as large as the cloud.
"""

import argparse
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

import plannercheck as pc
from plannercheck.evaluation.bench.clouds import NAME, sensed_scene
from plannercheck.evaluation.bench.records import write_record
from plannercheck.evaluation.sensing.terrains import terrain
from plannercheck.proofs import Proof, save_proofs

# Edge of the octomap's cells, m.
_CELL = 0.02


def cloud_scene(count: int) -> pc.Scene:
    """The bookshelf as cameras see it."""
    return sensed_scene(pc.Scene.load("bookshelf"), count, 0)


def map_scene(count: int) -> pc.Scene:
    """The cells in which a cloud of it has points."""
    cloud = cloud_scene(count)
    points = cloud.object(NAME).parts[0].shape.points
    scene = pc.Scene("octomap")
    scene.add(NAME, pc.Octree.from_cells(np.unique(np.floor(points / _CELL).astype(int), axis=0), _CELL))
    return scene


def ground_scene(count: int) -> pc.Scene:
    """Hills under the robot's table, count x count heights."""
    heights = terrain(count, seed=0)
    scene = pc.Scene("ground")
    low, high = heights.min(), heights.max()
    heights = 0.2 * (heights - high) / (high - low) - 0.05
    scene.add(NAME, pc.HeightField(heights, 3 / (count - 1), -1.0, (-1.5, -1.5)))
    return scene


def measured(name: str, scene: pc.Scene) -> dict[str, object]:
    """What the proofs of a path before a set take."""
    for link in ("panda_link0", "panda_link1"):
        scene.allow(NAME, link)
    known = pc.Scene.load("bookshelf")
    checker = pc.Checker(pc.Robot.load("panda"), scene)
    path = pc.ompl.plan(checker, known.start("panda"), known.goal("panda"), seed=1).path
    began = time.process_time()
    proofs = checker.certify_motions(path[:-1], path[1:])
    built = time.process_time() - began
    proved = [proof for proof in proofs if proof is not None]
    began = time.process_time()
    confirmed = sum(bool(proof.verify()) for proof in proved)
    verified = time.process_time() - began
    entries = [entry for proof in proved for entry in proof.entries]
    count = len(proofs)
    return {
        "scene": name,
        "parts": scene.object(NAME).parts[0].shape.count,
        "motions": count,
        "confirmed": confirmed,
        "build": built / count,
        "verify": verified / count,
        "entries": len(entries) / count,
        "directions": sum(len(entry.direction) // 3 for entry in entries) / count,
        **megabytes(proved),
    }


def megabytes(proofs: Sequence[Proof]) -> dict[str, float]:
    """Sizes of both kinds of files."""
    with tempfile.TemporaryDirectory() as folder:
        files = {suffix: Path(folder) / f"path.{suffix}" for suffix in ("json", "npz")}
        for file in files.values():
            save_proofs(proofs, file)
        return {suffix: file.stat().st_size / 1e6 for suffix, file in files.items()}


def main() -> None:
    """Prints a row of each scene."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=int, nargs="+", default=[10_000, 100_000, 1_000_000])
    parser.add_argument("--heights", type=int, default=200, help="along each side of the terrain")
    parser.add_argument("--output", type=Path, metavar="FILE", help="write the rows as JSON")
    options = parser.parse_args()
    scenes = [("cloud", cloud_scene(count)) for count in options.points]
    scenes += [("octomap", map_scene(options.points[0])), ("height field", ground_scene(options.heights))]
    rows = []
    for name, scene in scenes:
        rows.append(measured(name, scene))
        shown = (
            f"{key} {value:,.4g}" if isinstance(value, float) else f"{key} {value}" for key, value in rows[-1].items()
        )
        print(", ".join(shown), flush=True)
    if options.output:
        write_record(options.output, rows)


if __name__ == "__main__":
    main()
