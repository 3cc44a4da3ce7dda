"""Honest proofs, none of which may be refused: `python tests/benchmarks/honest_proofs.py --count 1000`.

Of each kind (random trees, shipped robots, solids, clouds, curves in the plane) files of some motions are made, saved,
loaded, verified, and compared with the robot's and the scene's files. The URDF's shapes and meshes are read by the
verifier's own reader. Printed are the number of proofs, how many are refused, and the time of it.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import plannercheck as pc
from plannercheck.common.package_data import shipped_folder
from plannercheck.proofs import Proof, load_proofs, save_proofs
from plannercheck.proofs.verify import model_confirmed

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))
import planar_proof_cases
import proof_cases

# Motions of a file.
_MOTIONS = 10

ROBOTS = ("panda", "ur5", "ur10", "pr2", "talos", "tiago", "go2", "xarm7", "g1", "baxter", "ur3", "kinova")

# A robot, a scene, what else its files are read by, and the proofs.
Made = tuple[str, str, dict[str, Any], list[Proof]]


def certified(checker: pc.Checker, seed: int) -> list[Proof]:
    """The proofs of free motions, some short, some long."""
    q0, q1 = proof_cases.free_motions(checker, _MOTIONS, seed, 200)
    return [proof for proof in checker.certify_motions(q0, q1) if proof is not None]


def of_tree(seed: int, folder: Path) -> Made:
    """A random tree among boxes and balls."""
    rng = np.random.default_rng(seed)
    robot, scene = proof_cases.random_tree(rng, folder, links=int(rng.integers(2, 8))), proof_cases.scattered(rng)
    scene.save(folder / "scene.yaml")
    return str(robot), str(folder / "scene.yaml"), {}, certified(pc.Checker(pc.Robot.load(robot), scene), seed)


def of_robot(seed: int, folder: Path) -> Made:
    """A shipped robot, in turns."""
    name = ROBOTS[seed % len(ROBOTS)]
    scene = proof_cases.scattered(np.random.default_rng(seed), 8)
    scene.save(folder / "scene.yaml")
    return name, str(folder / "scene.yaml"), {}, certified(pc.Checker(pc.Robot.load(name), scene), seed)


def of_solid(seed: int, folder: Path) -> Made:
    """A body of a puzzle near another one."""
    robot, scene = (("hook", "ring"), ("key", "lock"))[seed % 2]
    files = [str(shipped_folder("configs") / "puzzles" / f"{name}.yaml") for name in (robot, scene)]
    checker = pc.Checker(pc.Robot.load(files[0]), pc.Scene.load(files[1], meshes="solid"))
    rng = np.random.default_rng(seed)
    q0 = np.tile(checker.scene.start(robot), (_MOTIONS, 1))
    q1 = q0 + rng.normal(size=q0.shape) * ([0.03] * 3 + [0.03] * 4)
    q1[:, 3:] /= np.linalg.norm(q1[:, 3:], axis=1)[:, None]
    return *files, {"meshes": "solid"}, [proof for proof in checker.certify_motions(q0, q1) if proof is not None]


def of_cloud(seed: int, folder: Path) -> Made:
    """An arm before a cloud."""
    rng = np.random.default_rng(seed)
    scene = pc.Scene("cloud")
    points = rng.normal(size=(300, 3))
    points *= (rng.uniform(0.6, 1.2, 300) / np.linalg.norm(points, axis=1))[:, None]
    scene.add("cloud", pc.PointCloud(points, 0.01))
    scene.save(folder / "scene.yaml")
    name = ("panda", "ur5")[seed % 2]
    return name, str(folder / "scene.yaml"), {}, certified(pc.Checker(pc.Robot.load(name), scene), seed)


def of_curve(seed: int, folder: Path) -> Made:
    """A vehicle, straight or on curves."""
    robot, scene, radius = planar_proof_cases.SHIPPED[seed % len(planar_proof_cases.SHIPPED)]
    kind = planar_proof_cases.kinds(radius)[seed % 3 if robot == "forklift" else seed // 3 % 3]
    found = planar_proof_cases.free_motions(planar_proof_cases.shipped(robot, scene), _MOTIONS, seed, **kind)
    return robot, scene, {}, [proof for _, _, proof in found]


KINDS = {"trees": of_tree, "robots": of_robot, "solids": of_solid, "clouds": of_cloud, "curves": of_curve}


def counted(kind: str, seeds: Iterator[int], count: int) -> int:
    """Makes and verifies proofs of a kind; prints them, and returns how many were refused."""
    proofs, refused, spent = 0, 0, dict.fromkeys(("make", "save and load", "verify", "compare"), 0.0)
    while proofs < count:
        seed = next(seeds)
        with tempfile.TemporaryDirectory() as folder:
            began = [time.perf_counter()]
            robot, scene, how, made = KINDS[kind](seed, Path(folder))
            began.append(time.perf_counter())
            if not made:
                continue
            file = Path(folder) / ("x.npz" if seed % 2 else "x.json")
            save_proofs(made, file)
            loaded = load_proofs(file)
            began.append(time.perf_counter())
            faults = [found.fault for found in (proof.verify() for proof in loaded) if not found]
            began.append(time.perf_counter())
            model = model_confirmed(loaded[0], robot, scene, **how)
            faults += [model.fault] * len(loaded) if not model else []
            began.append(time.perf_counter())
        for fault in faults:
            print(f"REFUSED {kind} {seed} {robot}: {fault}", flush=True)
        proofs, refused = proofs + len(loaded), refused + len(faults)
        spent = {name: old + b - a for (name, old), a, b in zip(spent.items(), began[:-1], began[1:], strict=True)}
    times = ", ".join(f"{name} {seconds:.1f} s" for name, seconds in spent.items())
    print(f"{kind}: {proofs} proofs, {refused} refused; {times}", flush=True)
    return refused


def main() -> None:
    """Measures all kinds."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    refused = [counted(kind, iter(range(options.seed, 10**9)), -(-options.count // len(KINDS))) for kind in KINDS]
    sys.exit(1 if any(refused) else 0)


if __name__ == "__main__":
    main()
