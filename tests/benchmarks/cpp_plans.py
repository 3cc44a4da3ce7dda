"""Plans MotionBenchMaker's problems from C++, from Python, and by VAMP where it is installed.

    python tests/benchmarks/cpp_plans.py SETS... --library PREFIX [--every 1] [--rounds 3]

SETS are folders or archives of problems, PREFIX is where the C++ library is installed (cpp_library.py --folder F leaves
it in F/installed); OMPL's headers are needed. Searches by the same seed are repeated, and the least processor time of
each counts. RRTConnect in C++ samples near start and goal first, as in Python. RRT* ends with its first path; PRM and
RRT* get OMPL's own settings but for the range. VAMP samples motions of its spheres, by its own clock; the others prove.
Prints for each set and planner: problems solved, median, mean and 95 % quantile, ms.
"""

import argparse
import subprocess
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from cpp_library import PROGRAMS, run
from ompl import base, geometric

import plannercheck as pc
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.bench.planners import PLANNERS, Settings
from plannercheck.evaluation.bench.problems import Task, name_of_set, tasks
from plannercheck.ompl import LONGEST_MOTION
from plannercheck.ompl.joint_space import JointSpace
from plannercheck.ompl.planning import OMPL_SILENCE, seed_ompl

IN_CPP = ("RRTConnect", "PRM", "RRTstar")

Times = dict[str, list[float | None]]  # by planner: of each problem the seconds, or None


def built(prefix: Path, folder: Path) -> Path:
    """The C++ program that plans."""
    (folder / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.19)\nproject(plans LANGUAGES CXX)\nfind_package(plannercheck REQUIRED)\n"
        "find_package(ompl REQUIRED)\n"
        f"add_executable(plan_problems {PROGRAMS / 'plan_problems.cpp'})\n"
        "target_include_directories(plan_problems SYSTEM PRIVATE ${OMPL_INCLUDE_DIRS})\n"
        "target_link_libraries(plan_problems PRIVATE plannercheck::plannercheck ${OMPL_LIBRARIES})\n"
    )
    options = (f"-DCMAKE_PREFIX_PATH={prefix.absolute()}", "-DCMAKE_BUILD_TYPE=Release")
    run("cmake", "-S", str(folder), "-B", str(folder / "build"), *options)
    run("cmake", "--build", str(folder / "build"))
    return folder / "build" / "plan_problems"


def in_cpp(program: Path, ready: list[Task], folder: Path, options: argparse.Namespace) -> Times:
    """The C++ searches' times."""
    lines = []
    for k, task in enumerate(ready):
        task.checker.save(folder / f"{k}.plannercheck")
        numbers = " ".join(repr(float(x)) for x in (*task.start, *task.goal))
        lines.append(f"{folder / f'{k}.plannercheck'} {numbers}\n")
    (folder / "problems").write_text("".join(lines))
    command = [program, folder / "problems", *map(str, (options.range, options.time, options.rounds)), *IN_CPP]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    found: Times = {f"C++ {name}": [] for name in IN_CPP}
    for line in done.stdout.splitlines():
        _, name, seconds, states = line.split()
        found[f"C++ {name}"].append(float(seconds) if int(states) else None)
    return found


def in_python(task: Task, name: str, options: argparse.Namespace) -> Iterator[float | None]:
    """Times of some searches by PRM or RRT* of OMPL's bindings, as the C++ program has them."""
    space = JointSpace(task.checker.robot)
    for _ in range(options.rounds):
        setup = pc.ompl.setup(task.checker)
        information = setup.getSpaceInformation()
        with OMPL_SILENCE():
            seed_ompl(1)
            setup.setStartAndGoalStates(space.state(information, task.start), space.state(information, task.goal))
            planner = getattr(geometric, name)(information)
            if name == "RRTstar":
                planner.setRange(options.range)
            setup.setPlanner(planner)
            setup.setup()
            began = time.process_time()
            setup.solve(
                base.plannerOrTerminationCondition(
                    base.timedPlannerTerminationCondition(options.time),
                    base.exactSolnPlannerTerminationCondition(setup.getProblemDefinition()),
                )
            )
            yield time.process_time() - began if setup.haveExactSolutionPath() else None


def least(found: Iterator[float | None]) -> float | None:
    """The least time of those searches that found a path."""
    return min((seconds for seconds in found if seconds is not None), default=None)


def searched(task: Task, make: Callable, options: argparse.Namespace) -> Iterator[float | None]:
    """Times of searches by a planner of `plannercheck bench plans`."""
    search = make(task, Settings(options.range, options.time))
    for _ in range(options.rounds):
        found = search(1)
        yield found.search if found.path is not None else None


def measured(path: Path, program: Path, options: argparse.Namespace) -> Times:
    """The times of all planners on a set."""
    ready = list(tasks(path, pc.Robot.load("panda"), options.every))
    with tempfile.TemporaryDirectory() as folder:
        found = in_cpp(program, ready, Path(folder), options)
    peers = {"plannercheck": "Python RRTConnect", "VAMP": "VAMP"}
    for name, make in PLANNERS:
        if name not in peers:
            continue
        try:
            found[peers[name]] = [least(searched(task, make, options)) for task in ready]
        except PlannercheckError as error:
            print(f"{name} is left out: {error}")
    for name in IN_CPP[1:]:
        found[f"Python {name}"] = [least(in_python(task, name, options)) for task in ready]
    return found


def main() -> None:
    """Runs it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("sets", type=Path, nargs="+")
    parser.add_argument("--library", type=Path, required=True)
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--range", type=float, default=LONGEST_MOTION)
    parser.add_argument("--time", type=float, default=10.0)
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    with tempfile.TemporaryDirectory() as folder:
        program = built(options.library, Path(folder))
        for path in options.sets:
            print(f"\n{name_of_set(path)}\n{'planner':<20}{'solved':>10}{'median ms':>12}{'mean':>10}{'95 %':>10}")
            for name, times in measured(path, program, options).items():
                ms = 1e3 * np.array([each for each in times if each is not None])
                shown = (np.median(ms), ms.mean(), np.quantile(ms, 0.95)) if len(ms) else (np.nan,) * 3
                print(f"{name:<20}{f'{len(ms)}/{len(times)}':>10}{shown[0]:>12.3f}{shown[1]:>10.3f}{shown[2]:>10.3f}")


if __name__ == "__main__":
    main()
