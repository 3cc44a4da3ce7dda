"""Sphere models of others, audited; plans with them; and the Panda fitted.

None of their files is ours: give checkouts of CoMMALab/vamp, NVlabs/curobo and fishbotics/robometrics, and
MotionBenchMaker's sets of the Panda. Times are processor time.

- `python tests/benchmarks/coverings.py audit --vamp DIR --curobo DIR --robometrics DIR [--links]`: every model in these
  repositories against the meshes of the URDF beside it, as they are. Meshes that a checkout lacks are named, and their
  bodies left out.
- `python tests/benchmarks/coverings.py plans SET.tar.bz2 ... --vamp DIR [--every 4]`: plans of problems whose ends are
  free of the Panda's meshes: VAMP's own (pip install vamp-planner), and plans of RRTConnect whose motions are proved
  free for spheres: VAMP's as they are, these inflated, and 64 fitted ones. How many collide by the exact checker: at
  VAMP's own samples, or anywhere on their motions.
- `python tests/benchmarks/coverings.py fit --vamp DIR [--spheres 64]`: the Panda fitted, beside VAMP's inflated.
"""

import argparse
import tempfile
import time
import warnings
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
import yaml

import plannercheck as pc
from plannercheck.cli.common import table
from plannercheck.common.array_types import Floats
from plannercheck.common.package_files import folders_above, package_file
from plannercheck.coverings.audits import HEADER
from plannercheck.evaluation.bench.problems import Task, checker_of, name_of_set
from plannercheck.evaluation.bench.vamp_model import VampModel
from plannercheck.ompl.start_and_goal import check_end_state
from plannercheck.scenes.motion_bench_maker import Problem, load_problems

VAMP_ROBOTS = ("panda", "ur5", "fetch", "baxter")
LIMIT = 2.0  # s, a search
SPHERES = 64
STATES = 32  # a radian, VAMP's resolution of the Panda


class Model(NamedTuple):
    """A model of a repository, and the robot that it stands for."""

    repository: str
    path: Path
    urdf: Path
    package_dirs: tuple[Path, ...]


def vamp_models(root: Path) -> Iterator[Model]:
    """The spherized URDFs of VAMP, beside the robots' own."""
    for name in VAMP_ROBOTS:
        folder = root / "resources" / name
        yield Model("VAMP", folder / f"{name}_spherized.urdf", folder / f"{name}.urdf", (folder,))


def curobo_models(root: Path) -> Iterator[Model]:
    """The configurations of cuRobo that have spheres."""
    content = root / "curobo" / "content"
    for path in sorted((content / "configs" / "robot").glob("*")):
        document = yaml.safe_load(path.read_text())
        urdf = "robot/ur_description/ur10e.urdf"  # which its XRDF does not name
        if path.suffix == ".yml":
            inner = document.get("robot_cfg", document)["kinematics"]
            if not inner.get("collision_spheres"):
                continue
            urdf = inner["urdf_path"]
        yield Model("cuRobo", path, content / "assets" / urdf, (content / "assets", (content / "assets" / urdf).parent))


def robometrics_models(root: Path, curobo: Path) -> Iterator[Model]:
    """The spheres of robometrics, which name the links of cuRobo's Panda."""
    folder = curobo / "curobo" / "content" / "assets" / "robot" / "franka_description"
    for path in sorted((root / "robometrics" / "content" / "robot").glob("*spheres.yml")):
        yield Model("robometrics", path, folder / "franka_panda.urdf", (folder,))


def without_missing_meshes(model: Model, folder: Path) -> tuple[pc.Robot, list[str]]:
    """The robot, and the files of meshes that are not there, whose bodies are left out."""
    tree = ElementTree.parse(model.urdf)
    missing = []
    for link in tree.getroot().iterfind("link"):
        for element in link.findall("collision"):
            mesh = element.find("geometry/mesh")
            if mesh is None:
                continue
            found = package_file(mesh.get("filename", ""), model.package_dirs, folders_above(model.urdf))
            if found is None:
                missing.append(Path(mesh.get("filename", "")).name)
                link.remove(element)
            else:
                mesh.set("filename", str(found.resolve()))
    path = folder / model.urdf.name
    tree.write(path)
    return pc.Robot.from_urdf(path), missing


def run_audit(options: argparse.Namespace) -> None:
    """The table of all models."""
    models = [*vamp_models(options.vamp), *curobo_models(options.curobo)]
    models += robometrics_models(options.robometrics, options.curobo)
    rows = []
    for model in models:
        with tempfile.TemporaryDirectory() as folder:
            robot, missing = without_missing_meshes(model, Path(folder))
            covering = pc.Covering.load(model.path, robot)
            spent = [time.process_time()]
            alone = covering.audit()
            spent.append(time.process_time())
            together = covering.audit(neighbours=True)
            if options.links:
                print(model.path.name)
                print(table(HEADER, alone.rows()))
        rows.append(_audit_row(model, len(covering), alone, together, spent[1] - spent[0]))
        if missing:
            print(f"{model.path.name}: without {', '.join(missing)}, which the checkout lacks")
    header = (
        "model",
        "of",
        "spheres",
        "links",
        "bare",
        "covered",
        "with neighbours",
        "share %",
        "outside mm",
        "link",
        "s",
    )
    print(table(header, rows))


def _audit_row(model: Model, count: int, alone: pc.Audit, together: pc.Audit, seconds: float) -> tuple[object, ...]:
    """One model: links with bodies, those without spheres, those covered; of the others what is outside."""
    links = [link for link in alone.links if not (link.covered and not np.isfinite(link.excess))]
    bare = [link for link in links if not link.primitives]
    rest = [link for link in links if link.primitives and not link.covered]
    worst = max(rest, key=lambda link: link.outside[1], default=None)
    shares = [100 * link.share for link in rest]
    return (
        model.path.name,
        model.repository,
        count,
        len(links),
        len(bare),
        sum(link.covered for link in links),
        sum(a.covered for a in together.links if a.name in {link.name for link in links}),
        f"{min(shares):.0f}-{max(shares):.0f}" if shares else "-",
        "-" if worst is None else f"{1e3 * worst.outside[1]:.1f}",
        "-" if worst is None else worst.name,
        f"{seconds:.1f}",
    )


def run_fit(options: argparse.Namespace) -> None:
    """The Panda fitted, beside VAMP's spheres inflated, against VAMP's meshes."""
    model = next(vamp_models(options.vamp))
    with tempfile.TemporaryDirectory() as folder:
        robot, _ = without_missing_meshes(model, Path(folder))
        theirs = pc.Covering.load(model.path, robot)
        rows = [_fit_row("VAMP's", theirs, 0.0)]
        began = time.process_time()
        grown = theirs.inflated()
        rows.append(_fit_row("VAMP's inflated", grown, time.process_time() - began))
        began = time.process_time()
        grown = theirs.inflated(by_link=True)
        rows.append(_fit_row("VAMP's inflated by link", grown, time.process_time() - began))
        began = time.process_time()
        fitted = pc.Covering.fit(robot, spheres=options.spheres)
        rows.append(_fit_row("fitted", fitted, time.process_time() - began))
        print(table(("spheres", "number", "covers", "growth mm", "mean excess mm", "worst mm", "s"), rows))


def _fit_row(name: str, covering: pc.Covering, seconds: float) -> tuple[object, ...]:
    found = covering.audit()
    worst = max(link.excess for link in found.links if np.isfinite(link.excess))
    growth = f"{1e3 * covering.growth:.2f}"
    mean = f"{1e3 * found.mean_excess:.2f}"
    return (
        name,
        len(covering),
        "proved" if found.covered else "no",
        growth,
        mean,
        f"{1e3 * worst:.1f}",
        f"{seconds:.1f}",
    )


class Count(NamedTuple):
    """Plans of a set by one model: tried, ends free for the model, solved, colliding at samples, colliding at all."""

    tried: int = 0
    ends: int = 0
    solved: int = 0
    at_samples: int = 0
    anywhere: int = 0

    def with_plan(self, ends: bool, path: Floats | None, task: Task) -> "Count":
        """One problem more."""
        at_samples = anywhere = False
        if path is not None:
            at_samples = not task.checker.check_states(samples(path)).all()
            anywhere = not task.checker.check_motions(path[:-1], path[1:]).all()
        more = (1, ends, path is not None, at_samples, anywhere)
        return Count(*(a + int(b) for a, b in zip(self, more, strict=True)))


def samples(path: Floats) -> Floats:
    """The states of a path as VAMP samples it."""
    parts = [
        a + (b - a) * np.linspace(0, 1, max(2, int(np.ceil(np.linalg.norm(b - a) * STATES)) + 1))[:, None]
        for a, b in pairwise(path)
    ]
    return np.concatenate(parts) if parts else path


def run_plans(options: argparse.Namespace) -> None:
    """Plans by VAMP and by models of spheres, judged by the meshes."""
    robot = pc.Robot.load("panda", geometry="solid")
    theirs = pc.Covering.load(options.vamp / "resources" / "panda" / "panda_spherized.urdf", robot)
    models = {
        "VAMP's spheres": theirs,
        "VAMP's spheres inflated": theirs.inflated(),
        "VAMP's spheres inflated by link": theirs.inflated(by_link=True),
        f"{SPHERES} fitted spheres": pc.Covering.fit(robot, spheres=SPHERES),
    }
    srdf = robot.parts_of_files().description.srdf
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        robots = {}
        for k, (name, model) in enumerate(models.items()):
            path = Path(folder) / f"model{k}.urdf"
            model.save(path)
            robots[name] = pc.Robot.from_urdf(path, srdf)
        for path in options.problems:
            counts = {name: Count() for name in ("VAMP", *models)}
            for number, (task, problem) in enumerate(_tasks(path, robot)):
                found = VampModel(task.checker).search(task.start, task.goal, 1)()
                counts["VAMP"] = counts["VAMP"].with_plan(True, found.path, task)
                for name, other in robots.items() if number % options.every == 0 else ():
                    counts[name] = counts[name].with_plan(*_planned(checker_of(problem, other), task), task)
            rows += [(name_of_set(path), name, *count) for name, count in counts.items()]
    print(table(("set", "planner", "problems", "ends free", "plans", "collide at samples", "collide"), rows))


def _tasks(path: Path, robot: pc.Robot) -> Iterator[tuple[Task, Problem]]:
    """The problems whose ends are free of the meshes and within the limits."""
    for problem in load_problems(path):
        checker = checker_of(problem, robot)
        ends = problem.start, problem.goal
        if all(check_end_state(checker, q).accepted for q in ends):
            yield Task(checker, *ends), problem


def _planned(checker: pc.Checker, task: Task) -> tuple[bool, Floats | None]:
    """Whether both ends are free for the model, and the plan."""
    if not checker.check_states(np.array([task.start, task.goal])).all():
        return False, None
    plan = pc.ompl.plan(checker, task.start, task.goal, planner="RRTConnect", time_limit=LIMIT, seed=1)
    return True, np.asarray(plan.path) if plan.solved else None


def main() -> None:
    """Runs it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True)
    audit, fit, plans = (commands.add_parser(name) for name in ("audit", "fit", "plans"))
    for command, run in ((audit, run_audit), (fit, run_fit), (plans, run_plans)):
        command.add_argument("--vamp", type=Path, required=True, metavar="DIR", help="a checkout of CoMMALab/vamp")
        command.set_defaults(run=run)
    audit.add_argument("--curobo", type=Path, required=True, metavar="DIR", help="a checkout of NVlabs/curobo")
    audit.add_argument("--robometrics", type=Path, required=True, metavar="DIR", help="of fishbotics/robometrics")
    audit.add_argument("--links", action="store_true", help="each link of each model as well")
    fit.add_argument("--spheres", type=int, default=SPHERES)
    plans.add_argument("problems", nargs="+", type=Path, metavar="SET")
    plans.add_argument("--every", type=int, default=1, help="models plan every so-many-th problem, VAMP all")
    options = parser.parse_args()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of open meshes and of spheres that are off
        options.run(options)


if __name__ == "__main__":
    main()
