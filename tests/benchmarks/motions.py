"""Certified motions against dense sampling, and what they cost: `python tests/benchmarks/motions.py missed|cost`.

`missed`: random and adversarial motions, judged by the certifier, by states 1e-4 rad apart (1e-5 where an adversary put
its obstacle), by states 1 % of the space's extent apart (OMPL's default), and at 32 states a radian. Every refusal is
held against coal's distance of the pair at the state that the certifier names.

`cost`: time of a certified motion of 1 rad beside our own check of 32 states a radian, in the shipped scenes and those
of MotionBenchMaker (--problems), in turns (A B B A), the least process time of each; and how it grows as the clearance
shrinks.
"""

import argparse
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from poses import at

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

import coal
import numpy as np
import pinocchio as pin
from motion_timing import least_times, print_misses

import plannercheck as pc
from plannercheck.bodies.shapes import GeometryObject
from plannercheck.common.package_data import example_robot_data
from plannercheck.evaluation.bench.other_libraries import coal_shape
from plannercheck.evaluation.bench.records import write_record
from plannercheck.motions.sampling import coarse_to_fine
from plannercheck.robots.description import find_description, read_description
from plannercheck.scenes.motion_bench_maker import load_problems
from plannercheck.validation.problem_sets import robot_of

SCENES = ("bookshelf", "cage", "table", "bin", "kitchen")
DENSE, DENSER = 1e-4, 1e-5  # rad
NEAR = 5e-3  # rad, on both sides of an adversary's state
COAL_ERROR = 2e-6  # m
TOLERANCE = 1e-4  # m
VARIANTS = 25  # motions per obstacle
GRAZING_TRIES = 60
BLOCKS = (200, 2000, 20000)  # where states to be sampled are split
PROBLEM_STRIDE = 10  # every tenth problem of a set


@dataclass
class Case:
    """Motions (n, nq) to (n, nq) of one checker; part: where an adversary's obstacle is."""

    family: str
    checker: pc.Checker
    q0: np.ndarray
    q1: np.ndarray
    part: float | None = None


# ----- motions


def free_states(checker: pc.Checker, n: int, generator: np.random.Generator) -> np.ndarray:
    """n valid configurations."""
    found = np.zeros((0, checker.robot.nq))
    while len(found) < n:
        q = checker.robot.random_configurations(4 * n, generator)
        found = np.vstack([found, q[checker.check_states(q)]])
    return found[:n]


def moved(robot: pc.Robot, q: np.ndarray, way: np.ndarray) -> np.ndarray:
    """Configurations moved by tangent vectors, within limits where the configuration is a vector."""
    if robot.group is not None:
        return np.clip(q + way, robot.lower, robot.upper)
    return np.array([pin.integrate(robot.model, a, b) for a, b in zip(q, way, strict=True)])


def tangents(robot: pc.Robot, n: int, lengths: tuple[float, float], generator: np.random.Generator) -> np.ndarray:
    """Random directions of random lengths, rad and m."""
    way = generator.normal(size=(n, robot.nq if robot.group is not None else robot.model.nv))
    return way / np.linalg.norm(way, axis=1)[:, None] * generator.uniform(*lengths, (n, 1))


def random_case(
    family: str, checker: pc.Checker, n: int, lengths: tuple[float, float], generator: np.random.Generator
) -> Case:
    q0 = free_states(checker, n, generator)
    return Case(family, checker, q0, moved(checker.robot, q0, tangents(checker.robot, n, lengths, generator)))


def aimed_case(family: str, robot: pc.Robot, generator: np.random.Generator) -> Case:
    """One obstacle at a vertex of a link on a motion: across its way, or along it at a small distance; and variants."""
    q0 = robot.random_configurations(1, generator)
    q1 = moved(robot, q0, tangents(robot, 1, (0.3, 1.5), generator))
    part = float(generator.uniform(0.2, 0.8))
    state = states_at(robot, q0[0], q1[0], part + np.array([-1e-3, 0, 1e-3]))
    moving = [body for body in robot.bodies if body.link is not None]
    chosen = moving if family == "grazing" else [moving[generator.integers(len(moving))]]
    before, here, after = (
        np.vstack([posed_vertices(robot, body, poses) for body in chosen]) for poses in robot.link_poses(state)
    )
    thickness, normal = 10.0 ** generator.uniform(-4, -2), generator.normal(size=3)
    if family == "grazing":  # a wall in front of the robot's furthest vertex, which comes nearest here
        for _ in range(GRAZING_TRIES):
            k = int(np.argmax(here @ normal))
            bend = before[k] + after[k] - 2 * here[k]
            if abs((after - before)[k] @ normal) < 1e-9 and bend @ normal < 0:
                break
            normal = generator.normal(size=3) if bend @ normal > 0 else normal
            normal = across(normal, (after - before)[int(np.argmax(here @ normal))])
        centre = here[np.argmax(here @ normal)]
        offset = thickness / 2 + float(generator.choice([-1, 1, 1])) * 10.0 ** generator.uniform(-6, -2.5)
    else:  # a wall across the way of some vertex
        k = int(generator.integers(len(here)))
        centre, offset = here[k], 0.0
        if np.linalg.norm(after[k] - before[k]) > 0:
            normal = after[k] - before[k]
    normal /= np.linalg.norm(normal)
    normal /= np.linalg.norm(normal)  # once more for ways so short that doubles have few digits there
    side = np.linalg.qr(np.column_stack([normal, generator.normal(size=(3, 2))]))[0][:, 1]
    pose = at(*centre + offset * normal)
    pose[:3, :3] = np.column_stack([normal, side, np.cross(normal, side)])
    scene = pc.Scene(family)
    scene.add_box("wall", [thickness, *generator.uniform(0.002, 0.05, 2)], pose)
    scatter = 10.0 ** generator.uniform(-6, -1.3, (VARIANTS, 1))
    nv = robot.nq if robot.group is not None else robot.model.nv
    shift = generator.normal(size=(VARIANTS, nv)) * scatter
    shift[0] = 0
    many0, many1 = np.repeat(q0, VARIANTS, axis=0), np.repeat(q1, VARIANTS, axis=0)
    return Case(
        family,
        pc.Checker(robot, scene, self_collision=False),
        moved(robot, many0, shift),
        moved(robot, many1, shift),
        part,
    )


def posed_vertices(robot: pc.Robot, body: GeometryObject, link_poses: np.ndarray) -> np.ndarray:
    """(n, 3) in the world."""
    pose = link_poses[robot.link_index(str(body.link))] @ body.pose
    return body.shape.vertices_and_faces()[0] @ pose[:3, :3].T + pose[:3, 3]


def across(normal: np.ndarray, way: np.ndarray) -> np.ndarray:
    """The part of a vector at right angles to another, of length 1."""
    square = float(way @ way)
    rest = normal - (normal @ way / square) * way if square > 0 else normal
    return rest / np.linalg.norm(rest)


def states_at(robot: pc.Robot, q0: np.ndarray, q1: np.ndarray, parameters: np.ndarray) -> np.ndarray:
    """States of a motion, by Pinocchio where numbers are no vector."""
    if robot.group is not None:
        return (1 - parameters)[:, None] * q0 + parameters[:, None] * q1
    return np.array([pin.interpolate(robot.model, q0, q1, float(t)) for t in parameters])


NEEDLES = """<robot name="needles"><link name="base"/>{}</robot>"""
NEEDLE = """<link name="l{k}"><collision><origin xyz="0.2 0 0"/><geometry><box size="0.4 0.0002 0.0002"/></geometry>
</collision></link><joint name="j{k}" type="{kind}"><parent link="{parent}"/><child link="l{k}"/>
<origin xyz="{x} 0 0"/><axis xyz="{axis}"/><limit lower="-6" upper="6" effort="1" velocity="1"/></joint>"""


def needle_robot(folder: Path) -> pc.Robot:
    """Five links 0.4 m long and 0.2 mm thick, revolute and continuous."""
    axes = ("0 0 1", "0 1 0", "0 0 1", "1 0 0", "0 1 0")
    links = [
        NEEDLE.format(
            k=k,
            kind="continuous" if k == 3 else "revolute",
            parent=f"l{k - 1}" if k else "base",
            x=0.4 * (k > 0),
            axis=a,
        )
        for k, a in enumerate(axes)
    ]
    (folder / "needles.urdf").write_text(NEEDLES.format("".join(links)))
    return pc.Robot.from_urdf(folder / "needles.urdf", group=[f"j{k}" for k in range(len(axes))])


def floating_robot() -> pc.Robot:
    description = read_description(find_description("go2"))
    return pc.Robot.from_urdf(description.urdf, description.srdf, package_dirs=example_robot_data(), floating=True)


def cases(n: int, generator: np.random.Generator, folder: Path) -> Iterator[Case]:
    """About n motions: three tenths random, the rest adversarial."""
    panda, ur5, kinova = (pc.Robot.load(name) for name in ("panda", "ur5", "kinova"))
    needles, floating = needle_robot(folder), floating_robot()
    for scene in SCENES:
        for robot in (panda, ur5):
            checker = pc.Checker(robot, pc.Scene.load(scene))
            yield random_case("random", checker, n * 25 // 1000, (0.05, 1.5), generator)
            yield random_case("long", checker, n * 5 // 1000, (3.0, 6.0), generator)
    robots = (panda, panda, ur5, kinova, needles, needles, floating)
    for k in range(n * 7 // 10 // VARIANTS):
        yield aimed_case(("walls", "grazing")[k % 2], robots[k // 2 % len(robots)], generator)


# ----- judges


def coal_body(checker: pc.Checker, k: int) -> coal.CollisionGeometry:
    """Spheres and capsules as such, all else as the hull that the checker has."""
    body, polytope = checker.bodies[k], checker.polytopes[k]
    assert polytope is not None  # of a pair that was judged
    if polytope.inflation_radius > 0:
        return coal_shape(body, polytope)
    points = coal.StdVec_Vec3s()
    points.extend(list(polytope.vertices))
    return coal.ConvexBase.convexHull(points, True, "Qt")


class CoalDistance:
    """Distance of a pair of one checker at a state, by coal, m."""

    def __init__(self, checker: pc.Checker) -> None:
        self._checker = checker
        self._shapes: dict[int, coal.CollisionGeometry] = {}

    def __call__(self, pair: int, state: np.ndarray) -> float:
        poses = self._checker.body_poses(state[None])[0]
        bodies = [int(k) for k in self._checker.pairs[pair]]
        items = []
        for k in bodies:
            if k not in self._shapes:
                self._shapes[k] = coal_body(self._checker, k)
            items += [self._shapes[k], coal.Transform3s(poses[k][:3, :3], poses[k][:3, 3])]
        return float(coal.distance(*items, coal.DistanceRequest(), coal.DistanceResult()))


def sampled_free(case: Case, q0: np.ndarray, q1: np.ndarray, steps: int) -> bool:
    """All states of so many steps, coarse to fine and some at a time, so that a collision is met early."""
    for part in np.split(coarse_to_fine(steps), BLOCKS):
        states = case.checker.motion_certifier.states(q0, q1, part)
        if len(part) and not case.checker.check_states(states).all():
            return False
    return True


def densely_free(case: Case, q0: np.ndarray, q1: np.ndarray, length: float) -> bool:
    if not sampled_free(case, q0, q1, int(np.ceil(length / DENSE)) + 1):
        return False
    if case.part is None or length == 0:
        return True
    reach = NEAR / length
    parameters = np.clip(case.part + np.arange(-reach, reach, DENSER / length), 0, 1)
    return bool(case.checker.check_states(case.checker.motion_certifier.states(q0, q1, parameters)).all())


def extent(robot: pc.Robot) -> float:
    """Largest distance of two configurations as OMPL has it: of limits, half a turn for continuous joints."""
    spans = np.where(np.isfinite(robot.upper - robot.lower), robot.upper - robot.lower, np.pi)
    return float(np.linalg.norm(spans))


def judge(case: Case, counts: Counter[tuple[str, str]]) -> None:
    """Adds a case's verdicts to the counts."""
    checker, family = case.checker, case.family
    starts, ends, _ = checker._motion_ends(case.q0, case.q1)
    free = checker.check_motions(starts, ends)
    distance = CoalDistance(checker)
    for q0, q1, accepted in zip(starts, ends, free.tolist(), strict=True):
        if checker.robot.group is not None:
            length = float(np.linalg.norm(q1 - q0))
        else:
            length = float(np.linalg.norm(pin.difference(checker.robot.model, q0, q1)))
        counts[family, "motions"] += 1
        counts[family, "accepted"] += accepted
        if accepted:
            counts[family, "missed"] += not densely_free(case, q0, q1, length)
            continue
        result = checker.motion_certifier.motion_result(q0, q1, TOLERANCE)
        state = checker.motion_certifier.states(q0, q1, np.array([result.near]))[0]
        apart = checker.is_valid(state) and distance(result.pair, state) > TOLERANCE + COAL_ERROR
        counts[family, "refused with clearance"] += result.free or apart
        collides = not densely_free(case, q0, q1, length)
        counts[family, "collide (dense)"] += collides
        steps = max(1, int(np.ceil(length / (0.01 * extent(checker.robot)))))
        if collides:
            counts[family, "missed at 1 % of the extent"] += sampled_free(case, q0, q1, steps)
            counts[family, "missed at 32 a radian"] += sampled_free(case, q0, q1, max(1, int(np.ceil(32 * length))))


def missed(options: argparse.Namespace) -> None:
    """Prints the table of misses."""
    counts: Counter[tuple[str, str]] = Counter()
    began = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        for case in cases(options.motions, np.random.default_rng(options.seed), Path(folder)):
            judge(case, counts)
    rows = (
        *("motions", "accepted", "missed", "refused with clearance"),
        *("collide (dense)", "missed at 1 % of the extent", "missed at 32 a radian"),
    )
    print_misses(counts, rows)
    print(f"{time.perf_counter() - began:.0f} s")
    if options.output:
        families = sorted({family for family, _ in counts})
        found = [{"family": family, **{row: counts[family, row] for row in rows}} for family in families]
        write_record(options.output, found)


# ----- cost


def steps_of(q0: np.ndarray, q1: np.ndarray) -> np.ndarray:
    return np.maximum(1, np.ceil(32 * np.linalg.norm(q1 - q0, axis=1))).astype(np.int64)


def sampled(checker: pc.Checker, q0: np.ndarray, q1: np.ndarray) -> np.ndarray:
    """Our own check of 32 states a radian."""
    return np.asarray(
        checker._tables.within_limits.core.motions_are_free(checker._kernel, q0, q1, steps_of(q0, q1))
    ).astype(bool)


def unit_motions(checker: pc.Checker, n: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Motions of 1 rad from valid states to within the limits."""
    generator = np.random.default_rng(seed)
    q0 = free_states(checker, 4 * n, generator)
    q1 = q0 + tangents(checker.robot, len(q0), (1.0, 1.0), generator)
    inside = ((q1 >= checker.robot.lower) & (q1 <= checker.robot.upper)).all(axis=1)
    return q0[inside][:n], q1[inside][:n]


def compare_cost(name: str, checkers: list[pc.Checker], n: int) -> list[dict[str, object]]:
    """Prints a line: all motions, then those that are free; and gives a row for each."""
    rows: list[dict[str, object]] = []
    motions = [(checker, *unit_motions(checker, n, k)) for k, checker in enumerate(checkers)]
    free = [checker.check_motions(q0, q1) for checker, q0, q1 in motions]
    text, differ = f"{name:18s}", 0
    for which in ("all", "free"):
        chosen = [
            (c, q0[f | (which == "all")], q1[f | (which == "all")])
            for (c, q0, q1), f in zip(motions, free, strict=True)
        ]
        count = sum(len(q0) for _, q0, _ in chosen)
        best = least_times(
            {
                "ours": lambda chosen=chosen: [c.check_motions(q0, q1) for c, q0, q1 in chosen],
                "sampled": lambda chosen=chosen: [sampled(c, q0, q1) for c, q0, q1 in chosen],
            }
        )
        ours, theirs = best["ours"] / count * 1e6, best["sampled"] / count * 1e6
        text += f" | {which:4s} {ours:7.1f} us, sampled {theirs:7.1f} us, ratio {ours / theirs:5.2f}"
        rows.append({"scene": name, "which": which, "motions": count, "ours": ours, "sampled": theirs})
        if which == "all":
            differ = sum(int((sampled(c, a, b) != f).sum()) for (c, a, b), f in zip(motions, free, strict=True))
            text = f"{text} ({differ} of {count} verdicts differ)"
    print(text, flush=True)
    return rows


def growth(robot: pc.Robot) -> list[dict[str, object]]:
    """Prints how the time of a motion grows as its clearance shrinks: a turning arm under a plate. Gives the rows."""
    rows: list[dict[str, object]] = []
    q0, q1 = np.zeros(robot.nq), np.zeros(robot.nq)
    q0[:] = q1[:] = robot.reference
    q0[0], q1[0] = -0.5, 0.5
    poses = pc.Checker(robot).body_poses(robot.reference[None])[0]
    polytopes = pc.Checker(robot).polytopes
    tops = [
        (polytopes[k].vertices @ poses[k][:3, :3].T + poses[k][:3, 3])[:, 2].max() + polytopes[k].inflation_radius
        for k, b in enumerate(robot.bodies)
        if b.link is not None and polytopes[k] is not None
    ]
    for clearance in (0.3, 0.1, 0.03, 0.01, 3e-3, 1e-3, 5e-4, 2e-4, 1.1e-4):
        pose, scene = np.eye(4), pc.Scene("plate")
        pose[2, 3] = max(tops) + clearance + 0.005
        scene.add_box("plate", [3.0, 3.0, 0.01], pose)
        checker = pc.Checker(robot, scene)
        ends = np.repeat(q0[None], 200, axis=0), np.repeat(q1[None], 200, axis=0)
        free = checker.check_motions(*ends).all()
        best = least_times({"ours": lambda c=checker, e=ends: c.check_motions(*e)})
        sampled_time = least_times({"s": lambda c=checker, e=ends: sampled(c, *e)})["s"]
        print(
            f"clearance {clearance * 1e3:7.2f} mm: {best['ours'] / 200 * 1e6:7.1f} us, free: {free}; 32 states "
            f"{sampled_time / 200 * 1e6:7.1f} us"
        )
        times = {"ours": best["ours"] / 200 * 1e6, "sampled": sampled_time / 200 * 1e6}
        rows.append({"scene": "plate", "clearance": clearance, "free": bool(free), **times})
    return rows


def cost(options: argparse.Namespace) -> None:
    """Prints the times."""
    robot = pc.Robot.load("panda")
    print("motions of 1 rad, one thread, us a motion")
    rows: list[dict[str, object]] = []
    for scene in SCENES:
        rows += compare_cost(scene, [pc.Checker(robot, pc.Scene.load(scene))], options.motions)
    for archive in options.problems:
        problems = list(load_problems(archive))[::PROBLEM_STRIDE]
        checkers = [pc.Checker(robot_of(problem, robot), problem.scene) for problem in problems]
        rows += compare_cost(Path(archive).name.split(".")[0], checkers, options.motions // len(checkers))
    rows += growth(robot)
    if options.output:
        write_record(options.output, rows)


def main() -> None:
    """Runs one part."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("part", choices=("missed", "cost"))
    parser.add_argument("--motions", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--problems", nargs="*", default=(), help="MotionBenchMaker archives")
    parser.add_argument("--output", type=Path, metavar="FILE", help="write the rows as JSON")
    options = parser.parse_args()
    (missed if options.part == "missed" else cost)(options)


if __name__ == "__main__":
    main()
