"""Honest proofs, none of which may be refused: `python tests/benchmarks/honest_proofs.py --count 1000`.

Of each kind (random trees, shipped robots, solids, clouds, curves in the plane; trajectories with tubes of random trees
and small arms, among solids and sets of parts, and through contacts of the motion stress) files of some motions are
made, saved, loaded, verified, and compared with the robot's and the scene's files, where these are files. The URDF's
shapes and meshes are read by the verifier's own reader. Printed are the number of proofs, how many are refused, and the
time of it; of trajectories how many are free and how many of these have no proof, and why.
"""

import argparse
import sys
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import plannercheck as pc
from plannercheck.common.array_types import Floats
from plannercheck.common.package_data import shipped_folder
from plannercheck.evaluation.stress_motions.campaign import draw
from plannercheck.evaluation.stress_motions.cases import subject_of
from plannercheck.evaluation.stress_motions.curve_numbers import numbers_of
from plannercheck.evaluation.stress_motions.curves import curved
from plannercheck.evaluation.stress_motions.draws import FAMILIES
from plannercheck.evaluation.stress_motions.judges import together
from plannercheck.evaluation.stress_motions.outcomes import FREE, Judged
from plannercheck.evaluation.stress_motions.subjects import CurveSubject
from plannercheck.proofs import Proof, load_proofs, save_proofs
from plannercheck.proofs.verify import model_confirmed

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))
import planar_proof_cases
import proof_cases
import trajectory_proof_cases
from trajectory_proof_cases import Certified

# Motions of a file; trajectories of one, and through contacts.
_MOTIONS, _TRAJECTORIES, _THROUGH_CONTACTS = 10, 25, 50

ROBOTS = ("panda", "ur5", "ur10", "pr2", "talos", "tiago", "go2", "xarm7", "g1", "baxter", "ur3", "kinova")
# Whose meshes are small enough to be taken as they are.
SMALL_SOLIDS = ("ur3", "ur10", "pr2")


class Made(NamedTuple):
    """The robot and the scene, empty if they are no files, what else their files are read by, and the proofs.

    Of trajectories also how many there are, by outcome.
    """

    robot: str
    scene: str
    how: dict[str, Any]
    proofs: list[Proof]
    outcomes: Counter[str] | None = None


def certified(checker: pc.Checker, seed: int) -> list[Proof]:
    """The proofs of free motions, some short, some long."""
    q0, q1 = proof_cases.free_motions(checker, _MOTIONS, seed, 200)
    return [proof for proof in checker.certify_motions(q0, q1) if proof is not None]


def of_tree(seed: int, folder: Path) -> Made:
    """A random tree among boxes and balls."""
    rng = np.random.default_rng(seed)
    robot, scene = proof_cases.random_tree(rng, folder, links=int(rng.integers(2, 8))), proof_cases.scattered(rng)
    scene.save(folder / "scene.yaml")
    return Made(str(robot), str(folder / "scene.yaml"), {}, certified(pc.Checker(pc.Robot.load(robot), scene), seed))


def of_robot(seed: int, folder: Path) -> Made:
    """A shipped robot, in turns."""
    name = ROBOTS[seed % len(ROBOTS)]
    scene = proof_cases.scattered(np.random.default_rng(seed), 8)
    scene.save(folder / "scene.yaml")
    return Made(name, str(folder / "scene.yaml"), {}, certified(pc.Checker(pc.Robot.load(name), scene), seed))


def of_solid(seed: int, folder: Path) -> Made:
    """A body of a puzzle near another one."""
    files, checker = puzzle(seed)
    rng = np.random.default_rng(seed)
    q0 = np.tile(checker.scene.start(checker.robot.name), (_MOTIONS, 1))
    q1 = q0 + rng.normal(size=q0.shape) * ([0.03] * 3 + [0.03] * 4)
    q1[:, 3:] /= np.linalg.norm(q1[:, 3:], axis=1)[:, None]
    proofs = [proof for proof in checker.certify_motions(q0, q1) if proof is not None]
    return Made(*files, {"meshes": "solid"}, proofs)


def puzzle(seed: int) -> tuple[tuple[str, str], pc.Checker]:
    """Files of a body and of its puzzle, in turns, and their checker."""
    robot, scene = (
        str(shipped_folder("configs") / "puzzles" / f"{name}.yaml")
        for name in (("hook", "ring"), ("key", "lock"))[seed % 2]
    )
    return (robot, scene), pc.Checker(pc.Robot.load(robot), pc.Scene.load(scene, meshes="solid"))


def of_cloud(seed: int, folder: Path) -> Made:
    """An arm before a cloud."""
    rng = np.random.default_rng(seed)
    scene = pc.Scene("cloud")
    points = rng.normal(size=(300, 3))
    points *= (rng.uniform(0.6, 1.2, 300) / np.linalg.norm(points, axis=1))[:, None]
    scene.add("cloud", pc.PointCloud(points, 0.01))
    scene.save(folder / "scene.yaml")
    name = ("panda", "ur5")[seed % 2]
    return Made(name, str(folder / "scene.yaml"), {}, certified(pc.Checker(pc.Robot.load(name), scene), seed))


def of_curve(seed: int, folder: Path) -> Made:
    """A vehicle, straight or on curves."""
    robot, scene, radius = planar_proof_cases.SHIPPED[seed % len(planar_proof_cases.SHIPPED)]
    kind = planar_proof_cases.kinds(radius)[seed % 3 if robot == "forklift" else seed // 3 % 3]
    found = planar_proof_cases.free_motions(planar_proof_cases.shipped(robot, scene), _MOTIONS, seed, **kind)
    return Made(robot, scene, {}, [proof for _, _, proof in found])


# ----- trajectories


def around(checker: pc.Checker, rng: np.random.Generator, starts: Floats | None = None) -> Certified:
    """Proofs of free trajectories with tubes."""
    free = trajectory_proof_cases.free_ones(checker, _TRAJECTORIES, rng, starts)
    return trajectory_proof_cases.certified(checker, trajectory_proof_cases.with_tubes(checker, free, rng))


def of_moving_tree(seed: int, folder: Path, is_sensed: bool = False) -> Made:
    """Trajectories of a small random tree or arm, a third of them on a free base; among sets of parts if asked for."""
    rng = np.random.default_rng(seed)
    kinds = proof_cases.KINDS if seed % 2 else ("revolute", "prismatic")
    file = proof_cases.random_tree(rng, folder, int(rng.integers(2, 5 if seed % 5 == 0 else 4)), kinds)
    scene = proof_cases.scattered(rng, 2)
    if is_sensed:
        scene = trajectory_proof_cases.sensed(scene, rng)
    scene.save(folder / "scene.yaml")
    floating = seed % 3 == 0
    checker = pc.Checker(pc.Robot.from_urdf(file, floating=floating), scene)
    named = ("", "") if floating else (str(file), str(folder / "scene.yaml"))
    return Made(*named, {}, *around(checker, rng))


def of_moving_robot(seed: int, folder: Path) -> Made:
    """Trajectories of a shipped robot, in turns, hulls or solids, among boxes, balls, and sets of parts."""
    rng, name = np.random.default_rng(seed), ROBOTS[seed % len(ROBOTS)]
    how = {"geometry": "solid"} if name in SMALL_SOLIDS and rng.random() < 0.5 else {}
    scene = proof_cases.scattered(rng, 4)
    if seed // len(ROBOTS) % 2:
        scene = trajectory_proof_cases.sensed(scene, rng)
    scene.save(folder / "scene.yaml")
    return Made(name, str(folder / "scene.yaml"), how, *around(pc.Checker(pc.Robot.load(name, **how), scene), rng))


def of_moving_solid(seed: int, folder: Path) -> Made:
    """Trajectories of a body of a puzzle near another one."""
    files, checker = puzzle(seed)
    rng = np.random.default_rng(seed)
    starts = np.tile(checker.scene.start(checker.robot.name), (4 * _TRAJECTORIES, 1))
    return Made(*files, {"meshes": "solid"}, *around(checker, rng, starts))


def of_contact(seed: int, folder: Path) -> Made:
    """Curves of the motion stress that pass contacts, those that are free; half of those without a tube get one."""
    rng = np.random.default_rng(seed)
    made = curved(draw(str(rng.choice([*FAMILIES])), rng), rng)
    subject, motions = subject_of(made.recipe), made.motions
    assert isinstance(subject, CurveSubject)
    rows = np.arange(len(motions.at))
    free = rng.permutation(rows[together(subject, made, rows, Judged()) == FREE])[:_THROUGH_CONTACTS]
    drawn = [
        (subject.trajectory(*row), numbers_of(*row).tube)
        for row in zip(motions.q0[free], motions.q1[free], strict=True)
    ]
    if not any(tube.any() for _, tube in drawn):
        drawn = [*trajectory_proof_cases.with_tubes(subject.checker, [each for each, _ in drawn], rng, made.tolerance)]
    return Made("", "", {}, *trajectory_proof_cases.certified(subject.checker, drawn, made.tolerance))


KINDS = {
    "trees": of_tree,
    "robots": of_robot,
    "solids": of_solid,
    "clouds": of_cloud,
    "curves": of_curve,
    "trajectories of trees": of_moving_tree,
    "trajectories among sets": partial(of_moving_tree, is_sensed=True),
    "trajectories of robots": of_moving_robot,
    "trajectories of solids": of_moving_solid,
    "trajectories past contacts": of_contact,
}


def counted(kind: str, seeds: Iterator[int], count: int, seconds: float) -> int:
    """Makes and verifies proofs of a kind, for so long at most; prints them, and returns how many were refused."""
    until = time.perf_counter() + seconds
    proofs, refused, spent = 0, 0, dict.fromkeys(("make", "save and load", "verify", "compare"), 0.0)
    outcomes = Counter[str]()
    while (outcomes["proved"] or proofs) < count and time.perf_counter() < until:
        seed = next(seeds)
        with tempfile.TemporaryDirectory() as folder:
            began = [time.perf_counter()]
            robot, scene, how, made, own = KINDS[kind](seed, Path(folder))
            outcomes += own or {}
            began.append(time.perf_counter())
            if not made:
                continue
            file = Path(folder) / ("x.npz" if seed % 2 else "x.json")
            save_proofs(made, file)
            loaded = load_proofs(file)
            began.append(time.perf_counter())
            faults = [found.fault for found in (proof.verify() for proof in loaded) if not found]
            began.append(time.perf_counter())
            if robot:
                model = model_confirmed(loaded[0], robot, scene, **how)
                faults += [model.fault] * len(loaded) if not model else []
            began.append(time.perf_counter())
        for fault in faults:
            print(f"REFUSED {kind} {seed} {robot}: {fault}", flush=True)
        proofs, refused = proofs + len(loaded), refused + len(faults)
        spent = {name: old + b - a for (name, old), a, b in zip(spent.items(), began[:-1], began[1:], strict=True)}
    refused += outcomes[trajectory_proof_cases.NOT_AS_RUN]
    times = ", ".join(f"{name} {seconds:.1f} s" for name, seconds in spent.items())
    print(f"{kind}: {proofs} proofs, {refused} refused; {times}", flush=True)
    for what, number in outcomes.most_common():
        print(f"  {what}: {number}", flush=True)
    return refused


def main() -> None:
    """Measures all kinds."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--seconds", type=float, default=float("inf"), help="of each kind, at most")
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=[*KINDS])
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    refused = [
        counted(kind, iter(range(options.seed, 10**9)), -(-options.count // len(options.kinds)), options.seconds)
        for kind in options.kinds
    ]
    sys.exit(1 if any(refused) else 0)


if __name__ == "__main__":
    main()
