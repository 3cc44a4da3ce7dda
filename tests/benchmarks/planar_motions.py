"""Certified planar motions against dense sampling, and what they cost: `planar_motions.py missed|cost`.

`missed`: random and adversarial motions, straight and on Dubins and Reeds-Shepp curves, judged by the certifier, by
states of which no point moves over 1 mm between two (10 µm where an adversary put its obstacle), and by states 1 cm and
1 % of the space's extent apart (OMPL's default). Every refusal is held against shapely's distance of the pair at the
state that the certifier names.

`cost`: time of a certified motion beside our own check sampled at 1 and 10 cm, in turns (A B B A), the least process
time of each; and how it grows as the clearance shrinks.
"""

import argparse
import sys
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

import numpy as np
import shapely
from motion_timing import least_times, print_misses

import plannercheck as pc
from plannercheck.evaluation.bench.records import write_record
from plannercheck.planar.curves import Curve

P = pc.planar
TOLERANCE = 1e-4  # m
DENSE, DENSER, NEAR = 1e-3, 1e-5, 5e-3  # m of motion: all along; within NEAR of an adversary's state
SAMPLED = 1e-2  # m, the sampled check's default
VARIANTS = 10  # motions per obstacle
GRAZING_TRIES = 60
SHIPPED = (("warehouse", "forklift"), ("parking", "forklift"), ("parking", "truck_trailer"))
RADII = {"forklift": 1.5, "truck_trailer": 6.0, "needle": 0.8, "chain": 4.0}


@dataclass
class Case:
    """Motions (n, nq) to (n, nq) of one checker; part: where an adversary's obstacle is."""

    family: str
    checker: P.Checker
    q0: np.ndarray
    q1: np.ndarray
    curve: Curve = "straight"
    part: float | None = None

    @property
    def how(self) -> dict[str, object]:
        """Arguments of `check_motion`."""
        radius = None if self.curve == "straight" else RADII[self.checker.robot.name]
        return {"curve": self.curve, "turning_radius": radius}

    def states(self, q0: np.ndarray, q1: np.ndarray, parameters: np.ndarray) -> np.ndarray:
        """States of a motion."""
        pieces = self.checker._motions.pieces(q0, q1, *self.how.values())
        return self.checker.motion_certifier.states(q0, q1, parameters, pieces)

    def way(self, q0: np.ndarray, q1: np.ndarray) -> float:
        """No point travels further, m."""
        if self.curve == "straight":
            return float(self.checker.motion_sampler.way((q1 - q0)[None])[0])
        return self.checker._curves_of(*self.how.values()).way(q0, q1, self.checker.motion_sampler)


# ----- motions


def needle() -> P.Robot:
    """2 m long, 0.1 mm thick."""
    return P.Robot([[-0.2, -5e-5], [1.8, -5e-5], [1.8, 5e-5], [-0.2, 5e-5]], name="needle")


def chain() -> P.Robot:
    """A concave truck with two trailers that turn freely."""
    truck = [[-1, -1], [5, -1], [5, 1], [3, 1], [3, 0.2], [-1, 1]]
    return P.Robot(
        [
            P.Link("truck", truck, joint="free"),
            P.Link("one", [[-6, -1], [0.5, -1], [0.5, 1], [-6, 1]], "truck", (-0.5, 0.1, 0.2), "revolute", (-1.2, 1.2)),
            P.Link("two", [[-4, -1], [0.5, -1], [0.5, 1], [-4, 1]], "one", (-6, 0, 0), "revolute"),
        ],
        name="chain",
    )


def free_states(checker: P.Checker, n: int, generator: np.random.Generator) -> np.ndarray:
    """n valid configurations."""
    found = np.zeros((0, checker.robot.nq))
    while len(found) < n:
        q = checker.robot.random_configurations(10 * n, generator)
        found = np.vstack([found, q[checker.check_states(q)]])
    return found[:n]


def ways(n: int, nq: int, longest: float, turn: float, generator: np.random.Generator) -> np.ndarray:
    """Differences: up to `longest` m and `turn` rad, joints by up to half a radian."""
    out = generator.uniform(-0.5, 0.5, (n, nq))
    out[:, :2] = generator.uniform(-longest, longest, (n, 2))
    out[:, 2] = generator.uniform(-turn, turn, n)
    return out


def posed(checker: P.Checker, states: np.ndarray) -> np.ndarray:
    """(k, n, 2): all vertices of the robot at states (k, nq)."""
    poses = checker.body_poses(states)
    return np.concatenate(
        [
            body.vertices @ poses[:, k, :2, :2].transpose(0, 2, 1) + poses[:, k, None, :2, 2]
            for k, body in enumerate(checker.robot.bodies)
        ],
        axis=1,
    )


def aimed_case(family: str, robot: P.Robot, curve: Curve, generator: np.random.Generator) -> Case:
    """One obstacle at a vertex of the robot on a motion, across its way or along it a little off; and variants."""
    alone = P.Checker(robot, self_collision=False)
    for _ in range(GRAZING_TRIES):
        q0 = free_states(alone, 1, generator)
        q1 = q0 + ways(1, robot.nq, 3.0, 2.5, generator)
        case = Case(family, alone, q0, q1, curve)
        part = float(generator.uniform(0.1, 0.9))
        (start,), (end,), _ = alone._motion_ends(q0, q1)
        before, here, after = posed(alone, case.states(start, end, part + np.array([-1e-4, 0, 1e-4])))
        k = int(generator.integers(len(here)))
        way, bend = after[k] - before[k], before[k] + after[k] - 2 * here[k]
        normal = np.array([-way[1], way[0]]) * generator.choice([-1, 1])
        if np.linalg.norm(way) == 0:
            continue
        if family == "walls" or ((here @ normal).max() <= here[k] @ normal + 1e-12 and bend @ normal < 0):
            break
    normal /= np.linalg.norm(normal)
    thickness, scene = 10.0 ** generator.uniform(-4, -2), P.Scene("wall")
    if family == "grazing":  # along the way of the vertex that is furthest out, which comes nearest here
        offset = thickness / 2 + float(generator.choice([-1, 1, 1])) * 10.0 ** generator.uniform(-6, -2.5)
        pose = P.pose_of(here[np.argmax(here @ normal)] + offset * normal, float(np.arctan2(normal[1], normal[0])))
    else:  # across the way of some vertex
        pose = P.pose_of(here[k], float(np.arctan2(way[1], way[0])))
    scene.add_box("wall", [thickness, 10.0 ** generator.uniform(-3, 0)], pose)
    shifts = np.zeros((VARIANTS, robot.nq))
    shifts[1:] = generator.normal(size=(VARIANTS - 1, robot.nq)) * 10.0 ** generator.uniform(-5, -2, (VARIANTS - 1, 1))
    return Case(family, P.Checker(robot, scene, self_collision=False), q0 + shifts, q1 + shifts, curve, part)


def cases(n: int, generator: np.random.Generator) -> Iterator[Case]:
    """About n motions: three tenths random, the rest adversarial; half of them straight."""
    curves: tuple[Curve, ...] = ("straight", "straight", "dubins", "reeds_shepp")
    for scene, name in SHIPPED:
        checker = P.Checker(P.Robot.load(name), P.Scene.load(scene))
        for family, longest, turn in (("random", 3.0, 1.0), ("long", 15.0, 3.1)):
            q0 = free_states(checker, n // 20, generator)
            q1 = q0 + ways(len(q0), checker.robot.nq, longest, turn, generator)
            for k, curve in enumerate(curves):
                yield Case(family, checker, q0[k :: len(curves)], q1[k :: len(curves)], curve)
    robots = (P.Robot.load("forklift"), P.Robot.load("truck_trailer"), needle(), chain())
    for k in range(n * 7 // 10 // VARIANTS):
        yield aimed_case(("walls", "grazing")[k % 2], robots[k // 2 % 4], curves[k // 8 % 4], generator)


# ----- judges


def are_free(case: Case, q0: np.ndarray, q1: np.ndarray, parameters: np.ndarray) -> bool:
    return bool(case.checker.check_states(case.states(q0, q1, parameters)).all())


def sampled_free(case: Case, q0: np.ndarray, q1: np.ndarray, step: float) -> bool:
    steps = max(1, int(np.ceil(case.way(q0, q1) / step)))
    return are_free(case, q0, q1, np.linspace(0, 1, steps + 1))


def densely_free(case: Case, q0: np.ndarray, q1: np.ndarray) -> bool:
    if not sampled_free(case, q0, q1, DENSE):
        return False
    way = case.way(q0, q1)
    if case.part is None or way == 0:
        return True
    return are_free(case, q0, q1, np.clip(case.part + np.arange(-NEAR, NEAR, DENSER) / way, 0, 1))


def free_at_ompls_default(case: Case, q0: np.ndarray, q1: np.ndarray) -> bool:
    """States 1 % of the extent apart in the space's own distance: position and half the heading, of an area of 50 m."""
    robot, radius = case.checker.robot, case.how["turning_radius"]
    if radius is None:
        distance, extent = float(np.hypot(*(q1 - q0)[:2]) + 0.5 * abs(q1[2] - q0[2])), 50.0 * 2**0.5 + np.pi / 2
    else:
        lever = float(case.checker.motion_sampler.levers[2])
        distance, extent = case.way(q0, q1) / (1 + lever / radius), 50.0 * 2**0.5
    joints = np.abs(q1 - q0)[3:].sum() if robot.nq > 3 else 0.0
    steps = max(1, int(np.ceil((distance + joints) / (0.01 * extent))))
    return are_free(case, q0, q1, np.linspace(0, 1, steps + 1))


def shapelys_distance(checker: P.Checker, pair: int, state: np.ndarray) -> float:
    poses, shapes = checker.body_poses(state[None])[0], []
    for k in checker.pairs[pair].tolist():
        vertices = checker.bodies[k].vertices @ poses[k][:2, :2].T + poses[k][:2, 2]
        shapes.append(shapely.convex_hull(shapely.multipoints(vertices)))
    return float(shapely.distance(*shapes))


def judge(case: Case, counts: Counter[tuple[str, str]]) -> None:
    """Adds a case's verdicts to the counts."""
    checker, family = case.checker, case.family
    starts, ends, _ = checker._motion_ends(case.q0, case.q1)
    free = checker.check_motions(starts, ends, **case.how)
    for q0, q1, accepted in zip(starts, ends, free.tolist(), strict=True):
        counts[family, "motions"] += 1
        counts[family, "on curves"] += case.curve != "straight"
        counts[family, "accepted"] += accepted
        if accepted:
            counts[family, "missed"] += not densely_free(case, q0, q1)
            continue
        result = checker.motion_certifier.motion_result(
            q0, q1, TOLERANCE, pieces=checker._motions.pieces(q0, q1, *case.how.values())
        )
        state = case.states(q0, q1, np.array([result.near]))[0]
        apart = checker.is_valid(state) and shapelys_distance(checker, result.pair, state) > TOLERANCE
        counts[family, "refused with clearance"] += result.free or apart
        collides = not densely_free(case, q0, q1)
        counts[family, "collide (dense)"] += collides
        if collides:
            counts[family, "missed at 1 % of the extent"] += free_at_ompls_default(case, q0, q1)
            counts[family, "missed at 1 cm"] += sampled_free(case, q0, q1, SAMPLED)


def missed(options: argparse.Namespace) -> None:
    """Prints the table of misses."""
    counts: Counter[tuple[str, str]] = Counter()
    began = time.perf_counter()
    for case in cases(options.motions, np.random.default_rng(options.seed)):
        judge(case, counts)
    rows = (
        *("motions", "on curves", "accepted", "missed", "refused with clearance"),
        *("collide (dense)", "missed at 1 % of the extent", "missed at 1 cm"),
    )
    print_misses(counts, rows)
    print(f"{time.perf_counter() - began:.0f} s")
    if options.output:
        families = sorted({family for family, _ in counts})
        found = [{"family": family, **{row: counts[family, row] for row in rows}} for family in families]
        write_record(options.output, found)


# ----- cost


def compare_cost(scene: str, name: str, curve: Curve, n: int) -> list[dict[str, object]]:
    """Prints a line: all motions, then those that are free; and gives a row for each."""
    rows: list[dict[str, object]] = []
    checker = P.Checker(P.Robot.load(name), P.Scene.load(scene))
    generator = np.random.default_rng(0)
    q0 = free_states(checker, n, generator)
    q1 = q0 + ways(n, checker.robot.nq, 3.0, 1.0, generator)
    how = Case("", checker, q0, q1, curve).how
    free = checker.check_motions(q0, q1, **how)
    text = f"{scene:10s} {name:14s} {curve:12s}"
    for which, chosen in (("all", np.ones(n, dtype=bool)), ("free", free)):
        a, b = q0[chosen], q1[chosen]
        if not len(a):
            continue
        best = least_times(
            {
                "proved": lambda a=a, b=b: checker.check_motions(a, b, **how),
                "1 cm": lambda a=a, b=b: checker.check_motions(a, b, SAMPLED, **how),
                "10 cm": lambda a=a, b=b: checker.check_motions(a, b, 0.1, **how),
            }
        )
        us = {key: value / len(a) * 1e6 for key, value in best.items()}
        what = {"scene": scene, "robot": name, "curve": curve, "which": which, "motions": len(a)}
        rows.append({**what, **us})
        text += f" | {which:4s} {len(a):5d}: " + ", ".join(f"{key} {value:8.1f} us" for key, value in us.items())
    print(text, flush=True)
    return rows


def growth() -> list[dict[str, object]]:
    """Prints how the time of a motion grows as its clearance shrinks: a forklift that turns beside a wall."""
    rows: list[dict[str, object]] = []
    robot = P.Robot.load("forklift")
    radius = float(np.linalg.norm(np.vstack([body.vertices for body in robot.bodies[:1]]), axis=1).max())
    for clearance in (1.0, 0.1, 0.01, 3e-3, 1e-3, 5e-4, 2e-4, 1.1e-4):
        scene = P.Scene("wall")
        scene.add_box("wall", [0.1, 20.0], P.pose_of([-radius - 0.05 - clearance, 0]))
        checker = P.Checker(robot, scene)
        ends = np.tile([0.0, 0.0, -0.6], (200, 1)), np.tile([0.0, 0.0, 0.6], (200, 1))
        free = checker.check_motions(*ends).all()
        best = least_times(
            {
                "proved": lambda c=checker, e=ends: c.check_motions(*e),
                "1 cm": lambda c=checker, e=ends: c.check_motions(*e, SAMPLED),
            }
        )
        print(
            f"clearance {clearance * 1e3:7.2f} mm: {best['proved'] / 200 * 1e6:7.2f} us, free: {free}; sampled at 1 cm "
            f"{best['1 cm'] / 200 * 1e6:7.2f} us"
        )
        us = {name: spent / 200 * 1e6 for name, spent in best.items()}
        rows.append({"scene": "wall", "clearance": clearance, "free": bool(free), **us})
    return rows


def cost(options: argparse.Namespace) -> None:
    """Prints the times."""
    print("motions of up to 3 m each way and 1 rad, one thread, us a motion, batches")
    rows: list[dict[str, object]] = []
    for scene, name in SHIPPED:
        for curve in ("straight", "dubins", "reeds_shepp"):
            n = options.motions if curve == "straight" else options.motions // 10
            rows += compare_cost(scene, name, curve, n)
    rows += growth()
    if options.output:
        write_record(options.output, rows)


def main() -> None:
    """Runs one part."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("part", choices=("missed", "cost"))
    parser.add_argument("--motions", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--output", type=Path, metavar="FILE", help="write the rows as JSON")
    options = parser.parse_args()
    (missed if options.part == "missed" else cost)(options)


if __name__ == "__main__":
    main()
