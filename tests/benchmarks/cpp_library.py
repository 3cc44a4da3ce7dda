"""Builds, installs and runs the C++ library, and compares its verdicts with Python's, in a folder outside the checkout.

    python tests/benchmarks/cpp_library.py                        # minutes of a core: all levels, shared
    python tests/benchmarks/cpp_library.py --installed            # the file that Python's modules link
    python tests/benchmarks/cpp_library.py --levels v3 --static
    python tests/benchmarks/cpp_library.py --levels v3 --sanitize address,undefined --fuzz 10000
    python tests/benchmarks/cpp_library.py --levels v3 --static --compiler clang++ --face 3600 \\
        --sanitize fuzzer-no-link,address,undefined               # libFuzzer
    python tests/benchmarks/cpp_library.py --levels v2 --quick    # not optimised, one cell: as the suite has it
    python tests/benchmarks/cpp_library.py --cross aarch64 --states 20000 --motions 2000  # GCC's cross compiler, QEMU

Out: the library's size, and an error if its levels are not apart; the examples' output (docs/examples/cpp); for each
robot and each level that this machine runs, the time of loading, of a state and of a motion, and whether the verdicts
are the bits of Python's; with --fuzz what became of damaged cells. The exit code is 1 if verdicts differ.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import plannercheck as pc
from plannercheck.common.core import core

ROOT = Path(__file__).parents[2]
CELLS = (("panda", "bookshelf"), ("ur5", "table"), ("baxter", "kitchen"))
# Planar, prismatic, turning and floating joints.
LIFT = """<robot name="lift"><link name="floor"/>
<link name="sled"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
<link name="lift"/><link name="arm"><collision><origin xyz="0.2 0 0"/><geometry><box size="0.4 0.1 0.1"/></geometry>
</collision></link><link name="hand"><collision><geometry><cylinder radius="0.05" length="0.2"/></geometry></collision>
</link><link name="kite"><collision><origin xyz="0.4 0 0"/><geometry><box size="0.2 0.2 0.1"/></geometry></collision>
</link><joint name="slide" type="planar"><parent link="floor"/><child link="sled"/><axis xyz="0 0 1"/></joint>
<joint name="rise" type="prismatic"><parent link="sled"/><child link="lift"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint><joint name="turn" type="revolute"><parent link="lift"/>
<child link="arm"/><origin xyz="0 0 0.2"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/>
</joint><joint name="wrist" type="continuous"><parent link="arm"/><child link="hand"/><origin xyz="0.5 0 0"/>
<axis xyz="1 0 0"/></joint><joint name="fly" type="floating"><parent link="hand"/><child link="kite"/></joint>
</robot>"""

# kEdited, kMeasured, kExplained and kSeparated in judge.cpp.
EDITED, MEASURED, EXPLAINED, SEPARATED = 2000, 500, 200, 10
MOVED = 3  # the first edits of edit_scene.cpp
PROGRAMS = ROOT / "tests" / "support" / "cpp"
MOVEIT = ROOT / "ros" / "plannercheck_moveit"


def target(options: argparse.Namespace) -> list[str]:
    """What CMake is told of the compiler, and of the processor if that is another one."""
    compiler = options.compiler or (f"{options.cross}-linux-gnu-g++" if options.cross else "")
    other = ["-DCMAKE_SYSTEM_NAME=Linux", f"-DCMAKE_SYSTEM_PROCESSOR={options.cross}"] if options.cross else []
    ours_alone = ["-DCMAKE_DISABLE_FIND_PACKAGE_ompl=ON"] if options.cross else []  # a library of this machine
    return [*([f"-DCMAKE_CXX_COMPILER={compiler}"] if compiler else []), *other, *ours_alone]


def emulator(options: argparse.Namespace) -> list[str]:
    """What runs a program of the target."""
    return [f"qemu-{options.cross}-static", "-L", f"/usr/{options.cross}-linux-gnu"] if options.cross else []


def built(options: argparse.Namespace, folder: Path) -> Path:
    """Where the library is installed; it is built if need be."""
    if options.installed:
        print(f"libplannercheck.so: beside {Path(core.__file__).name}")
        return Path(core.__file__).parents[1]
    build, prefix = folder / "build", folder / "installed"
    choices = [
        "-DPLANNERCHECK_PYTHON=OFF",
        f"-DPLANNERCHECK_LEVELS={options.levels}",
        f"-DBUILD_SHARED_LIBS={'OFF' if options.static else 'ON'}",
        f"-DPLANNERCHECK_SANITIZE={options.sanitize}",
        *debugging(options),
        *target(options),
    ]
    before = os.times()
    run("cmake", "-S", str(ROOT / "plannercheck/cpp"), "-B", str(build), "-G", "Ninja", *choices)
    run("cmake", "--build", str(build), "--parallel", str(options.jobs))
    shutil.rmtree(prefix, ignore_errors=True)  # of the other kind
    run("cmake", "--install", str(build), "--prefix", str(prefix))
    spent = os.times()
    took = spent.children_user + spent.children_system - before.children_user - before.children_system
    (library,) = [path for path in prefix.glob("lib*/**/libplannercheck.*") if not path.is_symlink()]
    strip = f"{options.cross}-linux-gnu-strip" if options.cross else "strip"
    stripped = subprocess.run([strip, "-o", folder / "stripped", library], check=False).returncode == 0
    sizes = f"{library.stat().st_size / 1e6:.1f} MB" + (
        f", stripped {(folder / 'stripped').stat().st_size / 1e6:.1f} MB" if stripped else ""
    )
    print(f"{library.name}: {sizes}, built in {took:.0f} s of processor time")
    return prefix


def debugging(options: argparse.Namespace) -> list[str]:
    """CMake's options for builds that are not optimised, or little."""
    flags = "-O0" if options.quick else "-O1"
    return ["-DCMAKE_BUILD_TYPE=Debug", f"-DCMAKE_CXX_FLAGS_DEBUG={flags}"] if options.quick or options.sanitize else []


def check_levels_apart(build: Path) -> None:
    """No level has a symbol that others see but its entry, nor code that runs when the library is loaded."""
    for joined in build.glob("level_??.o"):
        seen = subprocess.run(
            ["nm", "--defined-only", "--extern-only", joined], capture_output=True, text=True, check=True
        )
        names = [line.split()[-1] for line in seen.stdout.splitlines()]
        assert names == [f"plannercheck_engine_{joined.stem.removeprefix('level_')}"], names
        sections = subprocess.run(["objdump", "-h", joined], capture_output=True, text=True, check=True).stdout
        assert ".init_array" not in sections, joined


def consumer(prefix: Path, folder: Path, options: argparse.Namespace) -> Path:
    """Builds the examples and this script's programs against the installed package; returns their folder."""
    source, build = folder / "consumer", folder / "consumer-build"
    source.mkdir(exist_ok=True)
    for path in (*(ROOT / "docs/examples/cpp").iterdir(), *PROGRAMS.glob("*.?pp"), *MOVEIT.glob("test/*.cpp")):
        (source / path.name).write_bytes(path.read_bytes())
    with (source / "CMakeLists.txt").open("a") as lines:
        lines.write(f"include_directories({MOVEIT / 'include'})\n")
        for name in (
            "judge",
            "edit_scene",
            "say_faults",
            "refuse_calls",
            "test_execution_proof",
            *(() if options.quick else ("share", "fuzz_cell")),
        ):
            lines.write(f"add_executable({name} {name}.cpp)\n")
            lines.write(f"target_link_libraries({name} PRIVATE plannercheck::plannercheck Threads::Threads)\n")
        if options.face:
            lines.write("add_executable(fuzz_face fuzz_face.cpp)\n")
            lines.write("target_link_libraries(fuzz_face PRIVATE plannercheck::plannercheck -fsanitize=fuzzer)\n")
    flags = "-Wall -Wextra -Wconversion -Werror" + (f" -fsanitize={options.sanitize}" if options.sanitize else "")
    run(
        *("cmake", "-S", str(source), "-B", str(build), "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={prefix}"),
        *("-Uplannercheck_DIR", f"-DCMAKE_CXX_FLAGS={flags}"),
        *(debugging(options) or ["-DCMAKE_BUILD_TYPE=Release"]),
        *target(options),
        *(["-DCMAKE_DISABLE_FIND_PACKAGE_ompl=ON"] if options.quick else []),
    )
    run("cmake", "--build", str(build))
    return build


def inputs(checker: pc.Checker, states: int, motions: int) -> list[np.ndarray]:
    """States, starts and ends; some are beyond the limits."""
    q = checker.robot.random_configurations(states, 1)
    q[::97] *= 1.3
    starts, ends = (checker.robot.random_configurations(motions, seed) for seed in (2, 3))
    ends = starts + (ends - starts) * np.random.default_rng(4).uniform(0, 0.3, (motions, 1))
    ends[::53] *= 1.2
    far = out_of_reach(checker)
    for rows in (q, ends):
        some = rows[1::53][: len(far)]
        some[:] = far[: len(some)]
    return [q, starts, ends]


def out_of_reach(checker: pc.Checker) -> np.ndarray:
    """States at which only pairs collide that can't within the limits, if there are such."""
    q = 2 * checker.robot.random_configurations(5000, 5)
    colliding, unreachable = checker.colliding_pairs(q), np.asarray(checker.unreachable)
    return q[colliding.any(axis=1) & ~colliding[:, ~unreachable].any(axis=1)]


def of_edits(checker: pc.Checker) -> Iterator[pc.Checker]:
    """Checkers of the scenes that `edited` of judge.cpp makes."""
    here, there = np.eye(4), np.eye(4)
    here[:3, 3] = 0.5, 0.25, 0.5
    there[:2, :2], there[:3, 3] = [[0, -1], [1, 0]], (-0.25, 0.5, 0.75)
    ball = np.eye(4)
    ball[:3, 3] = 0.25, -0.5, 0.625
    i, j = np.indices((16, 16)).reshape(2, -1)
    cloud = pc.PointCloud(np.stack([0.0625 * i, 0.0625 * j, 0.03125 * (i ^ j)], axis=1), 0.03125)
    edits = [
        ((), ("new ball", pc.Sphere(0.125), ball)),
        ((), ("new crate", pc.Box((0.25, 0.5, 0.125)), here)),
        (("new crate",), ("new crate", pc.Box((0.25, 0.5, 0.125)), there)),
        ((), ("new cloud", cloud, here)),
        (("new ball",), None),
        (("new crate",), ("new crate", pc.Box((0.125, 0.125, 0.125)), here)),
    ]
    for removed, added in edits:
        scene = checker.scene.copy()
        for name in removed:
            scene.remove(name)
        if added is not None:
            scene.add(*added)
        yield (checker := checker.with_scene(scene))


def answers(checker: pc.Checker, given: list[np.ndarray]) -> Iterator[np.ndarray]:
    """What judge.cpp finds, after the states and motions."""
    others = list(of_edits(checker))
    for other in others:
        yield other.check_states(given[0][:EDITED])
        yield other.check_motions(given[1][:EDITED], given[2][:EDITED])
    for k, q in enumerate(given[0][:EXPLAINED]):
        found = checker.explain(q, k < SEPARATED)
        yield from (each.certificate.point for each in found.collisions)
        yield from (plane_of(each.certificate) for each in found.separations)
    for each in (checker, others[0]):  # of a box that C++ has made, distances differ by rounding
        yield from of_trajectories(each, given)
        for nearest in (None, 2):
            table = each.distances(given[0][:MEASURED], 0.125, nearest)
            columns = (table.state, table.distance, table.lower, table.gap, table.unique)
            points = table.points.reshape(-1, 6)
            yield np.column_stack([*columns, points, table.normal, table.gradient]).astype(np.float64)


def plane_of(certificate: pc.Separation | pc.SolidSeparation | pc.PartSeparation) -> np.ndarray:
    """Whether one plane separates a pair, and the plane: its normal, its offset, and the gap.

    It is verified in exact arithmetic with all vertices of both bodies.
    """
    if not isinstance(certificate, pc.Separation):
        return np.zeros(6)
    assert certificate.verify()
    return np.array([1.0, *certificate.normal, certificate.offset, certificate.gap])


def of_trajectories(checker: pc.Checker, given: list[np.ndarray]) -> Iterator[np.ndarray]:
    """Of the trajectories of `judge_trajectories` of judge.cpp: whether it is free, its control points and error."""
    for i, (start, end) in enumerate(zip(*(rows[:EDITED] for rows in given[1:]), strict=True)):
        q, zero = np.stack([start, end, start]), np.zeros_like(start)
        v, a = (np.stack([zero, factor * (end - start), zero]) for factor in (0.5, 0.25))
        trajectory = pc.Trajectory([0.0, 1.0, 2.5], q, v if i % 3 else None, a if i % 3 == 2 else None)
        yield np.array(checker.check_trajectory(trajectory, 2.0**-10 if i % 2 else 0.0))
        yield np.concatenate([*trajectory.curve.pieces, trajectory.curve.error[None]])


def check_edits(programs: Path, folder: Path, options: argparse.Namespace) -> None:
    """Compares edits of a cell, by edit_scene.cpp, with Python's: verdicts, and where bodies move, distances' bits."""
    checker, q = padded_checker(), pc.Robot.load("panda").random_configurations(2000, 6)
    cell, states, out = folder / "padded.plannercheck", folder / "padded_q", folder / "padded_out"
    checker.save(cell)
    q.tofile(states)
    subprocess.run([*emulator(options), programs / "edit_scene", cell, states, out], check=True)
    scenes = [*edited_scenes(checker.scene)]
    python = b"".join(
        each.tobytes() for k, scene in enumerate(scenes) for each in told_of(checker.with_scene(scene), q, k < MOVED)
    )
    for far in (1e60, 1e150):
        scene = scenes[-1].copy()
        scene.move("rack", shifted(far, -far, 0.5))
        moved = checker.with_scene(scene)
        python += moved.check_states(q).tobytes() + moved.check_motions(q[:200], q[1:201]).tobytes()
    if out.read_bytes() != python:
        sys.exit("edits give OTHER VERDICTS than Python's")


def check_sentences(programs: Path, folder: Path, options: argparse.Namespace) -> None:
    """Compares the sentences of faults with Python's."""
    sys.path.insert(0, str(PROGRAMS.parent))
    from cell_faults import sentences, stand_ins_of

    cells = [folder / f"{name}.plannercheck" for name in ("padded", "lift", "stand_ins")]
    checker, lift = padded_checker(), checker_of_all_kinds(folder)
    for each, cell in zip((checker, lift, checker.with_bodies(stand_ins_of(checker))), cells, strict=True):
        each.save(cell)
    command = [*emulator(options), str(programs / "say_faults"), *map(str, cells)]
    said = subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()
    wanted = sentences(checker, lift)
    for cpp, python in zip(said, wanted, strict=True):
        if cpp != python or cpp.endswith("no fault"):
            sys.exit(f"OTHER SENTENCES:\n{cpp}\n{python}")
    print(f"{len(said)} faults: the same sentences")
    scene, folder = pc.Scene(), Path(tempfile.mkdtemp(dir=folder))
    scene.add("tool", pc.Sphere(0.05))
    scene.attach("tool", "panda_hand")
    pc.Checker(pc.Robot.load("panda"), scene).save(folder / "carried.plannercheck")
    subprocess.run([*emulator(options), programs / "refuse_calls", folder / "carried.plannercheck", folder], check=True)


def padded_checker() -> pc.Checker:
    """A Panda among what has paddings, may be touched, has several bodies, or one that has a pose in its object."""
    scene = pc.Scene("padded")
    turn = np.array([[0.28, 0, 0.96, 0.07], [0, 1, 0, 0.05], [-0.96, 0, 0.28, 0.21], [0, 0, 0, 1]])
    scene.add("crate", pc.Box((0.25, 0.5, 0.125)), shifted(0.5, 0.25, 0.5))
    scene.add("sign", pc.Part(pc.Sphere(0.125), shifted(0, 0, 0.25)), shifted(0.25, -0.5, 0.5))
    scene.add("rack", [pc.Part(pc.Box((0.3, 0.05, 0.2)), turn), pc.Part(pc.Sphere(0.1))], shifted(-0.4, 0.3, 0.4))
    scene.add("pad", pc.Box((0.3, 0.3, 0.3)), shifted(-0.3, -0.4, 0.3))
    scene.add("seen", pc.PointCloud(np.zeros((0, 3)), 0.01))
    scene.add("mapped", pc.Octree.from_cells(np.zeros((0, 3), dtype=np.int32), 0.1))
    scene.add("dug", pc.HeightField(np.full((3, 3), np.nan), 0.5, -0.8))
    scene.allow("pad", "panda_hand")
    padding = {"crate": 0.125, ("panda_link5", "pad"): 0.25, ("panda_link0", "pad"): 0.05}
    padding |= {"rack/0": 0.0625, ("panda_hand", "rack"): 0.25, ("panda_link6", "rack/1"): 0.125}
    padding |= {("panda_hand", f"rack/{part}"): 0.03125 for part in (0, 1)}
    return pc.Checker(pc.Robot.load("panda"), scene, self_collision=False, padding=padding)


def edited_scenes(scene: pc.Scene) -> Iterator[pc.Scene]:
    """The scenes that edit_scene.cpp makes, one after the other."""
    there = np.array([[0.36, 0.48, -0.8, 0.31], [-0.8, 0.6, 0, -0.37], [0.48, 0.64, 0.6, 0.43], [0, 0, 0, 1]])
    for name in ("sign", "rack", "pad"):
        scene = scene.copy()
        scene.move(name, there)
        yield scene
    for name, shape, pose in (
        ("crate", pc.Box((0.25, 0.5, 0.125)), shifted(0.5, 0.25, 0.5)),
        ("pad", pc.Box((0.5, 0.25, 0.25)), shifted(-0.5, -0.25, 0.25)),
        ("rack", pc.Box((0.5, 0.25, 0.25)), shifted(-0.25, 0.5, 0.5)),
    ):
        scene = scene.copy()
        scene.remove(name)
        yield scene
        scene = scene.copy()
        scene.add(name, shape, pose)
        yield scene
    scene = scene.copy()
    scene.move("rack", there)
    yield scene


def told_of(checker: pc.Checker, q: np.ndarray, is_measured: bool) -> Iterator[np.ndarray]:
    """What edit_scene.cpp writes of a scene; of a box that C++ has made, distances differ by rounding."""
    yield checker.check_states(q)
    yield checker.check_motions(q[:200], q[:200] + 0.05)
    if is_measured:
        table = checker.distances(q[:MEASURED], 0.125)
        yield np.column_stack([table.state, table.distance, table.points.reshape(-1, 6)]).astype(np.float64)


def checker_of_all_kinds(folder: Path) -> pc.Checker:
    """A small checker with all kinds of bodies, and joints of several kinds."""
    (folder / "lift.urdf").write_text(LIFT)
    return pc.Checker(pc.Robot.from_urdf(folder / "lift.urdf"), scene_of_all_kinds())


def scene_of_all_kinds() -> pc.Scene:
    """All kinds of bodies, around the origin."""
    rng = np.random.default_rng(0)
    ball = rng.standard_normal((120, 3))
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]) * 0.3
    scene = pc.Scene("all kinds")
    scene.add("hull", pc.Hull(0.2 * ball / np.linalg.norm(ball, axis=1, keepdims=True)), shifted(0.9, 0, 0.3))
    scene.add(
        "solid",
        pc.Solid(
            np.concatenate([corners, corners + 0.5]),
            np.array([[k + i for i in face] for k in (0, 4) for face in ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))]),
        ),
        shifted(-0.6, -0.2, 0),
    )
    scene.add("cloud", pc.PointCloud(rng.uniform(-1, 1, (20, 3)), 0.02), shifted(0, 1.2, 0))
    scene.add("map", pc.Octree.from_cells(np.array([[0, 0, 0], [2, 1, 3]], dtype=np.int32), 0.1), shifted(0, -1, 0))
    scene.add("ground", pc.HeightField(rng.uniform(-0.6, -0.5, (4, 5)), 0.5, -0.8))
    scene.add("plane", pc.HalfSpace((0.0, 0.1, 1.0), -0.5), shifted(0.3, 0, -0.2))
    return scene


def shifted(x: float, y: float, z: float) -> np.ndarray:
    """A pose without a turn, m."""
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


def compare(checker: pc.Checker, programs: Path, folder: Path, options: argparse.Namespace, most: int) -> bool:
    """Whether all levels give Python's verdicts, of so many states at most."""
    cell = folder / f"{checker.robot.name}.plannercheck"
    given = inputs(checker, min(options.states, most), min(options.motions, most // 10))
    for name, rows in zip("qab", given, strict=True):
        rows.tofile(folder / name)
    begin = time.process_time()
    states = checker.check_states(given[0])
    middle = time.process_time()
    motions = checker.check_motions(given[1], given[2])
    end = time.process_time()
    python = b"".join(each.tobytes() for each in (states, motions, *answers(checker, given)))
    per_state, per_motion = (middle - begin) / len(states) * 1e6, (end - middle) / len(motions) * 1e6
    print(f"  Python: a state {per_state:.3f} us, a motion {per_motion:.3f} us of processor time")
    same = True
    for level in ["plain"] if options.cross else ["v4", "v3", "v2"]:
        files = [str(folder / name) for name in ("q", "a", "b", "out")]
        command = [*emulator(options), str(programs / "judge"), str(cell), *files]
        environment = {**os.environ, "PLANNERCHECK_LEVEL": level}
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
        if "this machine and build have" in done.stderr:
            continue
        print("  C++:", done.stdout.strip().replace("\n", "; "), done.stderr.strip())
        equal = done.returncode == 0 and (folder / "out").read_bytes() == python
        found = "the same bits" if equal else "OTHER VERDICTS"
        print(f"  {len(states)} states, {len(motions)} motions and the rest: {found}")
        same &= equal
    return same


def run(*command: str) -> None:
    """Runs a command silently; its output appears if it fails."""
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"{' '.join(command)}\n{done.stdout}\n{done.stderr}")


def main() -> int:
    """Runs it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--levels", default="v2;v3;v4")
    parser.add_argument("--static", action="store_true")
    parser.add_argument("--installed", action="store_true", help="the library of the installed plannercheck")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--compiler")
    parser.add_argument("--cross", metavar="PROCESSOR", default="", help="for which GCC and QEMU's user mode are here")
    parser.add_argument("--sanitize", default="")
    parser.add_argument("--fuzz", type=int, default=0, help="how many damaged files")
    parser.add_argument("--face", type=int, default=0, help="s of libFuzzer's calls")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--states", type=int, default=10**6)
    parser.add_argument("--motions", type=int, default=10**5)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--folder", type=Path, help="keeps what is built there")
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.folder or Path(temporary)
        folder.mkdir(exist_ok=True)
        prefix = built(options, folder)
        if not options.sanitize and not options.installed:  # the former has code of its own that runs first
            check_levels_apart(folder / "build")
        programs = consumer(prefix, folder, options)
        same = True
        for robot, scene in CELLS[: 1 if options.quick else None]:
            checker = pc.Checker(pc.Robot.load(robot), pc.Scene.load(scene))
            cell = folder / f"{robot}.plannercheck"
            checker.save(cell)
            print(f"{robot} in {scene}: {cell.stat().st_size / 1e6:.1f} MB")
            if robot == "panda":
                subprocess.run([*emulator(options), programs / "test_execution_proof", cell], check=True)
            for name in ("check", "threads", "share", "plan"):  # the last where OMPL is installed
                if (programs / name).exists():
                    command = [*emulator(options), programs / name, cell]
                    done = subprocess.run(command, capture_output=True, text=True, check=name != "plan")
                    print(f"  {name}: " + "; ".join(done.stdout.strip().splitlines()[-4:]))
            same &= compare(checker, programs, folder, options, 10**7)
            if robot == "panda":
                check_edits(programs, folder, options)
                check_sentences(programs, folder, options)
        print("ur5 with a link as a solid among all kinds of bodies")
        checker = pc.Checker(pc.Robot.load("ur5", geometry={"forearm_link": "solid"}), scene_of_all_kinds())
        checker.save(folder / "ur5.plannercheck")
        same &= compare(checker, programs, folder, options, 200)
        if options.face or options.fuzz:
            cell = folder / "lift.plannercheck"  # to be damaged
        if options.face:
            corpus = folder / "corpus"
            corpus.mkdir(exist_ok=True)
            command = [programs / "fuzz_face", corpus, f"-max_total_time={options.face}", "-max_len=2048"]
            subprocess.run(command, env={**os.environ, "PLANNERCHECK_CELL": str(cell)}, check=True)
        if options.fuzz:
            print(f"damaged cells of {cell.stat().st_size / 1e3:.0f} kB:", flush=True)
            subprocess.run(
                [*emulator(options), programs / "fuzz_cell", cell, str(options.fuzz), str(options.seed)], check=True
            )
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())
