"""The package's face: the public names are there, and importing it loads nothing that is not needed."""

import ast
import importlib
import importlib.metadata
import inspect
import pickle
import subprocess
import sys
from pathlib import Path

import pytest

import plannercheck as pc
from plannercheck.common.core import core

# Public names that the design fixes, with the parameters callers may name.
CALLABLES = {
    "Robot.load": ["name_or_path"],
    "Robot.from_urdf": ["urdf", "srdf", "package_dirs", "group", "reference", "floating"],
    "Robot.random_configurations": ["n", "seed"],
    "Robot.link_poses": ["q"],
    "Robot.expand": ["q"],
    "Scene.load": ["path"],
    "Scene.add_box": ["name", "size", "pose"],
    "Scene.add_sphere": ["name", "radius", "pose"],
    "Scene.add_cylinder": ["name", "radius", "length", "pose"],
    "Scene.add_mesh": ["name", "path", "pose"],
    "Scene.add_hull": ["name", "vertices", "pose"],
    "Checker": ["robot", "scene", "self_collision", "padding", "acm", "kinematics"],
    "Checker.is_valid": ["q"],
    "Checker.check_states": ["q", "threads"],
    "Checker.check_motion": ["q0", "q1"],
    "Checker.check_motions": ["q0", "q1"],
    "Checker.explain": ["q"],
    "Checker.clearance": ["q"],
    "Polytope": ["vertices", "faces"],
    "Polytope.save": ["path"],
    "Polytope.load": ["path"],
    "intersects": ["P", "R", "pose_p", "pose_r", "method"],
    "certify": ["P", "R", "pose_p", "pose_r", "method"],
    "ompl.setup": ["checker"],
    "ndim.Polytope": ["vertices", "memory"],
    "ndim.Polytope.from_halfspaces": ["A", "b", "memory"],
    "ndim.intersects": ["P", "R", "pose_p", "pose_r", "method"],
    "ndim.certify": ["P", "R", "pose_p", "pose_r", "method"],
    "ndim.overlap_graph": ["regions"],
}
PROPERTIES = ("nq", "lower", "upper", "joint_names", "link_names")
HEAVY = (
    "pinocchio",
    "ompl",
    "coal",
    "fcl",
    "yaml",
    "rich",
    "hypothesis",
    "matplotlib",
    "scipy",
    "plannercheck.ompl",
    "plannercheck.ndim",
)


def python(code):
    return subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout.strip()


@pytest.mark.parametrize("name", CALLABLES)
def test_public_callables_take_what_they_should(name):
    target = pc
    for part in name.split("."):
        target = getattr(target, part)
    parameters = inspect.signature(target).parameters
    assert [p for p in CALLABLES[name] if p not in parameters] == []


def test_public_attributes():
    assert [name for name in PROPERTIES if not hasattr(pc.Robot.load("panda"), name)] == []
    separation = pc.certify(*[pc.Polytope([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])] * 2, pose_p=_away()).__dict__
    assert {"normal", "offset", "gap"} <= set(separation)
    assert issubclass(pc.PlannercheckError, ValueError)


def _away():
    return [[1, 0, 0, 5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]


def test_every_listed_name_is_there():
    assert sorted(pc.__all__) == dir(pc)
    for name in pc.__all__:
        assert getattr(pc, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'Chekcer'"):
        _ = pc.Chekcer


@pytest.mark.parametrize("module", ["plannercheck", "plannercheck.planar", "plannercheck.ndim"])
def test_public_names_say_where_users_find_them(module):
    face = importlib.import_module(module)
    items = [getattr(face, name) for name in dir(face) if not name.startswith("_")]
    named = [item for item in items if inspect.isclass(item) or inspect.isfunction(item)]
    ours = [item for item in named if item.__module__.startswith("plannercheck")]
    assert len(ours) > 5
    assert {item.__module__ for item in ours} == {module}
    assert all(pickle.loads(pickle.dumps(item)) is item for item in ours)


def test_importing_the_package_loads_nothing_heavy():
    loaded = python(f"import sys, plannercheck; print([m for m in {HEAVY} if m in sys.modules])")
    assert loaded == "[]"


def test_a_polytope_needs_no_robotics():
    code = f"import sys, plannercheck; plannercheck.Polytope; print([m for m in {HEAVY} if m in sys.modules])"
    assert python(code) == "[]"


def test_submodules_load_on_first_use():
    for name in ("ndim", "ompl"):
        assert python(f"import plannercheck; print(plannercheck.{name}.__name__)") == f"plannercheck.{name}"


def test_versions_agree():
    try:
        installed = importlib.metadata.version("plannercheck")
    except importlib.metadata.PackageNotFoundError:
        pytest.skip("not installed, a checkout")
    assert installed == pc.__version__


def test_type_checkers_may_read_the_annotations():
    assert (Path(pc.__file__).parent / "py.typed").is_file()  # PEP 561


def test_modules_open_with_what_they_are_for():
    paths = Path(pc.__file__).parent.rglob("*.py")
    assert [path for path in paths if path.name != "__main__.py" and not path.read_text().startswith('"""')] == []


def test_the_core_says_what_it_is():
    assert importlib.import_module(f"plannercheck._core_{core.level}") is core
    assert core.body_format > 0


def test_named_tuples_have_no_other_base():
    """Named case: from Python 3.11 on a named tuple may be generic; under 3.10 nothing could be imported."""
    classes = [
        f"{file.name}: {node.name}"
        for file in sorted(Path(pc.__file__).parent.rglob("*.py"))
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.ClassDef) and len(node.bases) > 1 and "NamedTuple" in map(ast.unparse, node.bases)
    ]
    assert classes == []
