"""Chunks through contacts that are built in, judged by gates: `python tests/benchmarks/gate_chunks.py [--count N]`.

A state of a robot is drawn, and a body put where it touches the robot there, or misses it by less or more than the
margin. Chunks run through this state, or past it by no more than the tube, at a waypoint, between two, or on the stop
behind the last one. Counted are chunks that pass where the body is not there: else nothing is asked. Whether the state
keeps the margin is told by a checker of states with padding, which shares no proof with gates.

Out: how many chunks run through a contact, how many of these pass (a fault), how many of the others pass; and of chunks
that do not pass, how many have a safe prefix of which a sampled state, with a corner of the tube, on the prefix or its
stop, does not keep the margin (a fault). Exit code 1 if there is a fault.
"""

from __future__ import annotations

import argparse
import time
import warnings
from collections import Counter

import numpy as np

import plannercheck as pc
from plannercheck.evaluation.stress_motions.contacts import extent_of, random_contact, random_shape
from plannercheck.evaluation.stress_motions.recipes import shape_of

ROBOTS = ("panda", "ur5", "xarm7", "ur10")
CONTROLLERS = (*["jtc"] * 8, *["linear"] * 2, "ur", "jtc-upsampled")
# Chunks through each contact, and states that are sampled on a prefix and on a stop.
EACH, SAMPLES = 100, 12
RATES, LENGTHS = (10.0, 20.0, 30.0, 50.0, 100.0), (1, 2, 8, 16, 16, 50)
# Limits so wide that contacts decide, rad/s and rad/s².
SPEED = 20.0
BRAKES = (2.0, 30.0)


class Stage:
    """A robot that is posed at random, and its gate's settings."""

    def __init__(self, name: str) -> None:
        self.robot = pc.Robot.load(name)
        self.alone = pc.Checker(self.robot, pc.Scene())
        poses = self.alone.body_poses(self.robot.random_configurations(2, 0))
        self._moving = np.flatnonzero((poses[0] != poses[1]).any(axis=(1, 2)))

    def contact(self, rng: np.random.Generator) -> tuple[pc.Scene, np.ndarray]:
        """A scene of one body, and the state (nq,) at which it is close to the robot."""
        while True:
            q = self.robot.random_configurations(1, int(rng.integers(2**31)))
            k, shape = int(rng.choice(self._moving)), random_shape(rng)
            found = random_contact(extent_of(self.robot.bodies[k].shape), self.alone.body_poses(q)[0, k], shape, rng)
            if self.alone.check_states(q)[0] and np.isfinite(found.pose).all():  # no direction leads out of a ball
                break
        scene = pc.Scene("contact")
        scene.add("body", shape_of(shape), found.pose)
        return scene, q[0]


def chunk_through(
    q: np.ndarray, gate: pc.Gate, rate: float, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Waypoints, where the robot stands, its velocities, and the instant at which q is passed, to within the tube."""
    count, brake, nq = int(rng.choice(LENGTHS)), gate.settings.brake, len(q)
    after = np.arange(count + 1)[:, None] / rate
    speed = rng.normal(size=nq) * 10.0 ** rng.uniform(-2, 0.3)
    bend = rng.normal(size=nq) * 10.0 ** rng.uniform(-2, 0.5)
    rows = speed * after + bend * after**2 + rng.normal(size=(count + 1, nq)) * 10.0 ** rng.uniform(-6, -2.5)
    dq = speed * rng.choice([0.0, 1.0])
    controller, begun, end = gate.settings.controller, (rows[-1] - rows[-2]) * rate, count / rate
    curve = None
    if controller not in ("jtc", "linear"):
        run = pc.Trajectory(after[1:, 0], rows[1:], controller=controller, start=(rows[0], dq))
        curve, begun = run.position, run.velocity(run.curve.breaks[-1])
    kind = rng.random()
    if kind < 0.3:  # on the stop
        lasts = np.abs(begun) / brake
        passed = float(rng.uniform(0, 1) * lasts.max())
        t = np.minimum(passed, lasts)
        there = rows[-1] + begun * t - np.sign(begun) * brake * t * t / 2
        at = end + passed
    else:
        part = rng.integers(0, count + 1) if kind < 0.5 else rng.uniform(0, count)
        at, k = float(part / rate), min(int(part), count - 1)
        there = rows[k] + (part - k) * (rows[k + 1] - rows[k]) if curve is None else curve(min(at, after[-1, 0]))
    off = gate.settings.tube * rng.uniform(-0.999, 0.999, nq) * rng.choice([0.0, 1.0])
    moved = q + off - there
    return rows[1:] + moved, rows[0] + moved, dq, at


def is_safe(verdict: pc.GateVerdict, padded: pc.Checker, tube: np.ndarray, rng: np.random.Generator) -> bool:
    """Whether sampled states of the safe prefix and its stop keep the margin, with corners of the tube."""
    if verdict.safe_until is None:
        return True
    stop = verdict.stop
    assert stop is not None
    first, last = stop.curve.breaks[0], stop.curve.breaks[-1]
    states = [stop.position(rng.uniform(first, last, SAMPLES))]
    if verdict.safe_until > 0:
        states.append(verdict.trajectory.position(rng.uniform(0, verdict.safe_until, SAMPLES)))
    rows = np.concatenate(states)
    return bool(padded.check_states(rows + tube * rng.choice([-1.0, 1.0], rows.shape)).all())


def main() -> int:
    """Runs chunks and prints the counts."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--count", type=int, default=100_000, help="chunks that pass where no body is")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    warnings.filterwarnings("ignore", ".*fixed to the world")  # large bodies touch the base as well
    rng, began = np.random.default_rng(options.seed), time.process_time()
    stages = [Stage(name) for name in ROBOTS]
    counts: Counter[str] = Counter()
    while counts["asked"] < options.count:
        stage = stages[int(rng.integers(len(stages)))]
        scene, q = stage.contact(rng)
        checker = stage.alone.with_scene(scene)
        margin = float(rng.choice([0.0, 0.005, 0.02]))
        free = pc.Gate(
            stage.alone,
            str(rng.choice(CONTROLLERS)),
            velocity=SPEED,
            tube=float(rng.choice([0.0, 0.002, 0.01])),
            margin=margin,
            brake=rng.uniform(*BRAKES, stage.robot.nq),
        )
        gate, padded = free.of(checker), pc.Checker(stage.robot, scene, padding=margin)
        close = not padded.check_states(q[None])[0]
        for _ in range(EACH):
            rate = float(rng.choice(RATES))
            positions, stands, dq, at = chunk_through(q, gate, rate, rng)
            counts["drawn"] += 1
            if not free.judge(positions, rate, start=(stands, dq)):
                continue
            verdict = gate.judge(positions, rate, start=(stands, dq))
            counts["asked"] += 1
            counts["through a contact"] += close
            counts["through a contact, passed: FAULTS"] += close and verdict.ok
            counts["past a body, passed"] += not close and verdict.ok
            if not verdict.ok:
                reached = verdict.safe_until is not None and verdict.safe_until >= at
                counts["safe beyond a contact: FAULTS"] += close and reached
                counts["with a safe prefix or stop"] += verdict.safe_until is not None
                counts["of these with a state too close: FAULTS"] += not is_safe(
                    verdict, padded, gate.settings.tube, rng
                )
    for name, number in counts.items():
        print(f"{name}: {number}")
    print(f"{time.process_time() - began:.0f} s of processor time, seed {options.seed}")
    return 1 if any(number for name, number in counts.items() if "FAULTS" in name) else 0


if __name__ == "__main__":
    raise SystemExit(main())
