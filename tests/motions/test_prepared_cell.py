"""Prepared cells: what is in the file, what can't be saved, and what the C++ reader of the container refuses.

`python tests/benchmarks/cpp_library.py` builds the library and compares its verdicts with Python's, in minutes.
"""

import random
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from section_reader import read_sections

import plannercheck as pc
from plannercheck.cli.main import main
from plannercheck.common.core import core
from plannercheck.common.section_files import Section, file_of, texts
from plannercheck.motions.added_obstacles import added_obstacles
from plannercheck.motions.prepared_cell import CELL_FORMAT

ROOT = Path(__file__).parents[2]
CPP = ROOT / "plannercheck" / "cpp"


@pytest.fixture(scope="module")
def checker():
    return pc.Checker(pc.Robot.load("panda"), pc.Scene.load("bookshelf"))


@pytest.fixture(scope="module")
def cell(checker, tmp_path_factory):
    path = tmp_path_factory.mktemp("cell") / "panda.plannercheck"
    checker.save(path)
    return path


def only(sections, name):
    (found,) = (values for each, values in sections if each == name)
    return found


def test_a_cell_holds_the_checker(checker, cell):
    sections, robot = read_sections(cell.read_bytes()), checker.robot
    assert only(sections, "robot").tobytes() == b"panda"
    names = only(sections, "joint names").tobytes().decode().split("\0")
    assert tuple(names) == (*robot.joint_names, "")
    for name in ("parents", "kinds", "axes", "placements", "columns", "multipliers", "offsets", "link_placements"):
        given = getattr(robot.joint_table, name)
        assert np.array_equal(only(sections, name.replace("_", " ")).reshape(given.shape), given)
    assert np.array_equal(only(sections, "pairs"), checker.pairs)
    assert np.array_equal(only(sections, "unreachable").ravel(), checker.unreachable)
    assert np.array_equal(only(sections, "paddings").ravel(), checker.paddings)
    shapes = [core.Polytope.parse(values.tobytes()) for name, values in sections if name == "hull"]
    for index, polytope in zip(only(sections, "shapes").ravel().tolist(), checker.polytopes, strict=True):
        assert (index < 0) == (polytope is None)
        assert polytope is None or np.array_equal(shapes[index].vertices(), polytope.vertices)


def test_a_cell_is_the_same_each_time_and_on_the_command_line(checker, cell, tmp_path):
    checker.save(str(tmp_path / "again"))
    assert (tmp_path / "again").read_bytes() == cell.read_bytes()
    assert main(["export", "--robot", "panda", "--scene", "bookshelf", "--output", str(tmp_path / "told")]) == 0
    assert (tmp_path / "told").read_bytes() == cell.read_bytes()


def test_every_kind_of_body_is_saved_as_it_was_made(tmp_path):
    points = np.random.default_rng(0).uniform(0.5, 1.5, (40, 3))
    scene = pc.Scene("sensed")
    scene.add("cloud", pc.PointCloud(points, 0.01))
    scene.add("map", pc.Octree.from_cells(np.array([[20, 0, 1], [21, 3, 5]], dtype=np.int32), 0.05))
    scene.add("ground", pc.HeightField(np.array([[-0.3, -0.2], [-0.25, -0.3]]), 1.0, -0.5))
    scene.add("floor", pc.HalfSpace((0, 0, 1), -1.0))
    scene.add("tetrahedra", pc.Solid(*two_tetrahedra()))
    pc.Checker(pc.Robot.load("ur5"), scene, self_collision=False).save(tmp_path / "cell")
    sections = read_sections((tmp_path / "cell").read_bytes())
    assert sorted(set(only(sections, "shape kinds").ravel().tolist())) == [0, 1, 2, 3, 4, 5]
    named = [values for name, values in sections if name == "points"]
    assert any(values.shape == points.shape and np.array_equal(values, points) for values in named)


def two_tetrahedra():
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=np.float64) + 0.7
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    return np.concatenate([corners, corners + 2]), np.concatenate([faces, faces + 4])


def test_what_a_cell_does_not_hold_is_refused(tmp_path):
    robot = pc.Robot.load("ur5")
    with pytest.raises(pc.PlannercheckError, match=r"'ur5' in 'empty' can't be saved .*: Pinocchio itself poses"):
        pc.Checker(robot, kinematics="pinocchio").save(tmp_path / "cell")
    belt = pc.Scene("belt")
    belt.add("pallet", pc.Box((0.1, 0.1, 0.1)), pc.Moving([0.0, 1.0], np.stack([np.eye(4)] * 2)))
    with pytest.raises(pc.PlannercheckError, match="pallet moves, and a cell's scene stands still"):
        pc.Checker(robot, belt).save(tmp_path / "cell")
    with pytest.raises(pc.PlannercheckError, match="can't be written"):
        pc.Checker(robot).save(tmp_path / "missing" / "cell")
    assert list(tmp_path.iterdir()) == []


def test_a_new_obstacle_would_meet_what_another_one_meets(checker):
    paddings, pairs = added(checker).treatments[""]
    shelf = checker.pairs[(checker.pairs == len(checker.robot.bodies)).any(axis=1)]
    assert sorted(pairs) == [(body, 0) for body in sorted(shelf.min(axis=1).tolist())]
    assert paddings == (0.0,)
    assert added(pc.Checker(checker.robot, padding={"panda_hand": 0.01})).treatments[""][0] == (0.0,)
    assert added(pc.Checker(checker.robot, padding=0.02)).treatments[""][0] == (0.01,)
    assert added(checker.with_bodies(checker.bodies)) == ({}, (), {})


def test_an_obstacle_that_replaces_one_has_the_padding_of_its_name_and_none_of_parts(checker):
    scene, far = pc.Scene("parts"), np.zeros((4, 4))
    far[2, 3] = 2.0
    scene.add("rack", [pc.Part(pc.Box((0.1, 0.1, 0.1)), name=name) for name in ("top", "foot")], np.eye(4) + far)
    scene.add("gone", pc.Sphere(0.1), np.eye(4) + far)
    padding = {"rack/top": 0.2, "rack/foot": 0.3, "gone": 0.05, ("panda_link5", "rack"): 0.5}
    padding |= {("panda_link5", f"rack/{part}"): 0.4 for part in ("top", "foot")}
    with_all = pc.Checker(checker.robot, scene, self_collision=False, padding=padding)
    scene.remove("gone")
    scene.allow("later", "panda_hand")
    found = added(with_all.with_scene(scene))
    assert found.treatments["rack"][0] == (0.0, 0.25)
    assert found.treatments["gone"] == ((0.05,), found.treatments[""][1])
    link = {found.bases[body] for body, of_rack in found.treatments["rack"][1] if of_rack == 1}
    assert link == {body for body, _ in found.copies} == {5}
    assert [share for _, share in found.copies] == [0.25]
    hand = set(found.treatments[""][1]) - set(found.treatments["later"][1])
    assert {checker.robot.bodies[body].link for body, _ in hand} == {"panda_hand"}


def added(checker):
    return added_obstacles(checker._settings, checker.robot, checker.scene, checker.bodies, checker.paddings)


def test_planar_robots_are_not_exported(tmp_path, capsys):
    assert main(["export", "--robot", "truck_trailer", "--output", str(tmp_path / "cell")]) == 2
    assert "no planar robots" in capsys.readouterr().err


@pytest.fixture(scope="module")
def list_sections(tmp_path_factory):
    """A program of the C++ reader of the container alone."""
    compiler = shutil.which("c++")
    if compiler is None:
        pytest.skip("there is no C++ compiler")
    program = tmp_path_factory.mktemp("cpp") / "list_sections"
    sources = [ROOT / "tests/support/cpp/list_sections.cpp", CPP / "library/cell_file.cpp"]
    flags = ["-std=c++20", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-fsanitize=address,undefined"]
    subprocess.run([compiler, *flags, f"-I{CPP}", *map(str, sources), "-o", str(program)], check=True)

    def run(*files: Path) -> list[str]:
        done = subprocess.run([program, *map(str, files)], capture_output=True, text=True, check=True)
        return done.stdout.splitlines()

    return run


def test_the_examples_use_the_face_as_it_is():
    compiler = shutil.which("c++")
    if compiler is None:
        pytest.skip("there is no C++ compiler")
    flags = ["-std=c++20", "-Wall", "-Wextra", "-Wconversion", "-Werror", f"-I{CPP / 'library/include'}"]
    for name in ("check", "threads"):
        source = ROOT / "docs/examples/cpp" / f"{name}.cpp"
        subprocess.run([compiler, *flags, "-fsyntax-only", source], check=True)


def test_the_library_reads_the_container(cell, list_sections, tmp_path):
    (line,) = list_sections(cell)
    assert line.split(";")[:-1] == [name for name, _ in read_sections(cell.read_bytes())]
    content = cell.read_bytes()
    for version in (b"\0\0\0\0", b"\5\0\0\0"):
        (tmp_path / "other").write_bytes(content[:16] + version + content[20:])
        (line,) = list_sections(tmp_path / "other")
        assert "this version reads 6 with bodies of format" in line
        assert line.endswith("save the cell again")


def test_damaged_containers_are_refused(list_sections, tmp_path):
    arrays = [Section("a", np.arange(9.0)), Section("none", np.zeros((0, 7))), Section("b", np.ones((5, 3), np.int32))]
    content, draw = file_of([*arrays, texts("names", ["one", "two"])], CELL_FORMAT, core.body_format), random.Random(0)
    files = [tmp_path / "whole"]
    files[0].write_bytes(content)
    assert list_sections(*files) == ["a;none;b;names;"]
    for k in range(500):
        damaged = bytearray(content if k % 3 else content[: draw.randrange(len(content))])
        for _ in range(draw.randrange(1, 3)):
            place = draw.randrange(min(len(damaged), draw.choice((48, len(content))))) if damaged else 0
            damaged[place : place + 1] = bytes([draw.randrange(256)])
        files.append(tmp_path / str(k))
        files[-1].write_bytes(damaged)
    changed = [path for path in files if path.read_bytes() != content]
    for line in list_sections(*changed):
        assert line.startswith("error: is ")
