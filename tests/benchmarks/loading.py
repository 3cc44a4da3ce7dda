"""How loading a robot and building its checker grow: `python tests/benchmarks/loading.py --links 100 300 1000`.

A chain of bars on revolute joints, all self pairs but those of neighbours, beside some obstacles. Each size runs in a
process of its own; told are seconds and the largest memory, step by step.
"""

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

_JOINT = (
    '<joint name="j{k}" type="revolute"><parent link="l{k}"/><child link="l{next}"/><origin xyz="0.1 0 0"/>'
    '<axis xyz="{axis}"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>'
)
_LINK = (
    '<link name="l{k}"><collision><origin xyz="0.05 0 0"/><geometry><box size="0.08 0.03 0.03"/></geometry></collision>'
    "</link>"
)


def chain(links: int) -> str:
    """The URDF of a chain."""
    axes = ("0 0 1", "0 1 0")
    parts = [_LINK.format(k=k) for k in range(links)]
    parts += [_JOINT.format(k=k, next=k + 1, axis=axes[k % 2]) for k in range(links - 1)]
    return f'<robot name="chain">{"".join(parts)}</robot>'


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--links", type=int, nargs="+", default=[30, 100])
    parser.add_argument("--obstacles", type=int, default=10)
    parser.add_argument("--profile", action="store_true", help="show which functions take the time")
    options = parser.parse_args()
    if len(options.links) == 1:
        measure(options.links[0], options.obstacles, options.profile)
        return
    for links in options.links:
        rest = ["--profile"] if options.profile else []
        command = [sys.executable, __file__, "--links", str(links), "--obstacles", str(options.obstacles), *rest]
        subprocess.run(command, check=False, env=os.environ)


def measure(links: int, obstacles: int, profile: bool) -> None:
    """One size: prints a line a step."""
    import cProfile
    import pstats

    import plannercheck as pc

    began = memory()
    scene = pc.Scene()
    for k in range(obstacles):
        pose = [[1, 0, 0, 0.5 * k], [0, 1, 0, 1], [0, 0, 1, 0], [0, 0, 0, 1]]
        scene.add_box(f"box {k}", [0.1, 0.1, 0.1], pose)
    with tempfile.TemporaryDirectory() as folder:
        urdf = Path(folder) / "chain.urdf"
        urdf.write_text(chain(links), encoding="utf-8")
        with cProfile.Profile() if profile else Nothing() as profiler:
            clock = time.perf_counter()
            robot = pc.Robot.from_urdf(urdf)
            loaded = time.perf_counter()
            checker = pc.Checker(robot, scene)
            built = time.perf_counter()
            valid = checker.check_states(robot.random_configurations(10, 0) * 0.01)
            judged = time.perf_counter()
    print(
        f"{links:6} links: {len(checker.pairs):8} pairs, {checker.unreachable.sum()} unreachable, {valid.sum()} valid; "
        f"load {loaded - clock:7.2f} s, build {built - loaded:7.2f} s, 10 states {judged - built:7.2f} s, "
        f"{memory() - began:7.0f} MB",
        flush=True,
    )
    if profile:
        pstats.Stats(profiler).sort_stats("cumulative").print_stats(35)


class Nothing:
    """No profiler."""

    def __enter__(self) -> None:
        return None

    def __exit__(self, *stop: object) -> None:
        return None


def memory() -> float:
    """The most that this process has had, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


if __name__ == "__main__":
    main()
