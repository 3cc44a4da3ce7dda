"""Two Pandas over a table on one clock: `python tests/benchmarks/one_clock.py [--seed 0] [--trips 10]`.

Each arm goes from its home to a random place above the table and back, in 3 s, as joint_trajectory_controller runs it.
Printed are the medians of the times of `first_conflict` and `least_delay` (resolution 1 ms, at most 10 s), what the
delays may lose, and beside them dense sampling by Pinocchio and coal at 1 kHz: forward kinematics, placements and the
collisions of all pairs between the arms, with the table, and within each arm, of the same convex hulls, up to the first
that collides. A sampled delay needs such a run for each delay that is tried.
"""

import argparse
import statistics
import time

import coal
import numpy as np
import pinocchio as pin

import plannercheck as pc

HOME = np.array([0, -0.785, 0, -2.356, 0, 1.571, 0.785])
RATE = 1000  # Hz


def cell() -> pc.Checker:
    """Two Pandas that face each other over a table."""
    panda, opposite, place = pc.Robot.load("panda"), np.diag([-1.0, -1.0, 1.0, 1.0]), np.eye(4)
    opposite[0, 3], place[:3, 3] = 1.15, (0.575, 0, -0.06)
    scene = pc.Scene("table")
    scene.add_box("table", (2.5, 1.5, 0.1), place)
    return pc.Checker(pc.Robot.together({"left": (panda, np.eye(4)), "right": (panda, opposite)}), scene)


def trip(checker: pc.Checker, name: str, rng: np.random.Generator) -> pc.Trajectory:
    """From home to a place over the table and back, free while the other arm stays at home."""
    other = "right" if name == "left" else "left"
    while True:
        out = HOME + rng.uniform(-1, 1, 7) * [0.5, 0.3, 0.3, 0.3, 0.3, 0.3, 0.3] + [0, 1.1, 0, 0.45, 0, 0.65, 0]
        made = pc.Trajectory([0.0, 1.5, 3.0], [HOME, out, HOME], np.zeros((3, 7)))
        if not pc.first_conflict(checker, {name: made, other: HOME}):
            return made


class Sampler:
    """Collisions of the same bodies by Pinocchio and coal."""

    def __init__(self, checker: pc.Checker) -> None:
        """Makes coal's hulls of all bodies in pairs."""
        robot = self.robot = checker.robot
        self.data = robot.model.createData()
        self.bodies, self.placements = {}, {}
        identity, still = checker.body_poses(robot.reference[None])[0], robot.link_poses(robot.reference[None])[0]
        for body in np.unique(checker.pairs).tolist():
            polytope, link = checker.polytopes[body], checker.bodies[body].link
            points = coal.StdVec_Vec3s()
            points.extend([np.array(point) for point in polytope.vertices])
            shape = coal.Convex.convexHull(points, False, "Qt")
            shape.setSweptSphereRadius(polytope.inflation_radius)
            frame = robot.model.getBodyId(link) if link in robot.link_names else 0
            above = still[robot.link_index(link)] if frame else np.eye(4)
            self.bodies[body] = coal.CollisionObject(shape)
            self.placements[body] = frame, pin.SE3(np.linalg.inv(above) @ identity[body])
        self.pairs = checker.pairs.tolist()
        self.request, self.result = coal.CollisionRequest(), coal.CollisionResult()

    def collides(self, q: np.ndarray) -> bool:
        """Whether any pair collides at a configuration."""
        pin.framesForwardKinematics(self.robot.model, self.data, self.robot.expand(q))
        for body, (frame, placement) in self.placements.items():
            pose = self.data.oMf[frame] * placement if frame else placement
            self.bodies[body].setTransform(coal.Transform3s(pose.rotation, pose.translation))
            self.bodies[body].computeAABB()
        for a, b in self.pairs:
            if self.bodies[a].getAABB().overlap(self.bodies[b].getAABB()):
                self.result.clear()
                if coal.collide(self.bodies[a], self.bodies[b], self.request, self.result):
                    return True
        return False

    def first(self, trajectory: pc.Trajectory) -> float | None:
        """The first sampled instant that collides, s."""
        times = np.arange(0, trajectory.duration, 1 / RATE)
        return next((t for t, q in zip(times, trajectory.position(times), strict=True) if self.collides(q)), None)


def main() -> None:
    """Measures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--trips", type=int, default=10)
    options = parser.parse_args()
    checker, rng = cell(), np.random.default_rng(options.seed)
    sampler, rows = Sampler(checker), []
    for _ in range(options.trips):
        runs = {name: trip(checker, name, rng) for name in ("left", "right")}
        row = {}
        begin = time.perf_counter()
        found = pc.first_conflict(checker, runs)
        row["first_conflict"] = time.perf_counter() - begin
        begin = time.perf_counter()
        first = sampler.first(found.trajectory)
        row["sampled"] = time.perf_counter() - begin
        assert first is None or (found.free_until <= first + 1e-9 and not found.free)
        begin = time.perf_counter()
        waits = pc.least_delay(checker, {"left": runs["left"]}, {"right": runs["right"]})
        row["least_delay"] = time.perf_counter() - begin
        if waits.delay is not None:
            begin = time.perf_counter()
            assert sampler.first(waits.trajectory) is None
            row["sampled_free"] = time.perf_counter() - begin
        rows.append(row | {"loss": waits.loss or 0.0, "delay": waits.delay})
        print(found, "sampled:", first, "|", waits, flush=True)
    for key in ("first_conflict", "sampled", "least_delay", "sampled_free", "loss"):
        values = sorted(row[key] for row in rows if key in row)
        print(
            f"{key}: median {statistics.median(values):.4g} s, {values[0]:.3g} to {values[-1]:.3g} s, n = {len(values)}"
        )


if __name__ == "__main__":
    main()
