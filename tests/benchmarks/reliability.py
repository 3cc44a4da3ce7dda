"""Long runs of what docs/reliability.md promises: `python tests/benchmarks/reliability.py [PART ...] --scale 100`.

Each part tells how many trials it made and stops at the first broken promise. Without --scale they are small; with
--scale 100 they are those that a release needs (hours): 100 kills and resumes over all formats, 1,000 damaged journals,
cache files and body files, 10,000 mutated inputs of all loaders within 2 GB and 10 s each, a million changed scenes and
100,000 plans at constant memory, eight threads that load, check, plan and write at once for ten minutes.
"""

from __future__ import annotations

import argparse
import os
import resource
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import plannercheck as pc
from plannercheck.errors import PlannercheckError

FORMATS = ("npz", "csv", "parquet")
COMMAND = [sys.executable, "-m", "plannercheck", "validate", "--robot", "panda", "--scene", "bookshelf"]
ROWS = 2_000_000  # of a run that is killed
MEMORY = 2 << 30  # bytes that a process of mutated inputs may take
ROOM = 8 << 20  # bytes by which memory may grow between the middle and the end of many trials


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"of {', '.join(PARTS)}; default: all")
    parser.add_argument("--scale", type=float, default=0.1, help="100: as many trials as a release needs")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    unknown = set(options.parts) - PARTS.keys()
    if unknown:
        parser.error(f"no such part: {', '.join(sorted(unknown))}")
    for name in options.parts or PARTS:
        began = time.perf_counter()
        with tempfile.TemporaryDirectory() as folder:
            done = PARTS[name](Path(folder), options.scale, np.random.default_rng(options.seed))
        print(f"{name}: {done}, in {time.perf_counter() - began:.0f} s", flush=True)
    return 0


def kills(folder: Path, scale: float, rng: np.random.Generator) -> str:
    """Runs that are killed at random and resumed give the bytes of those that are not; nothing else stays behind."""
    source = folder / "q.npy"
    np.save(source, pc.Robot.load("panda").random_configurations(ROWS, 0))
    trials = max(1, round(scale))
    killed = 0
    for trial in range(trials):
        output = folder / f"o.{FORMATS[trial % len(FORMATS)]}"
        whole = output.with_name(f"whole{output.suffix}")
        if not whole.exists():
            subprocess.run([*COMMAND, source, "--output", whole], check=False, capture_output=True)
        patience = 1.0  # which grows: writing alone may take longer than the first kills allow
        while not output.exists():
            patience *= 1.2
            process = subprocess.Popen(
                [*COMMAND, source, "--output", output, "--resume"],
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
            )
            try:
                process.wait(rng.uniform(0.4, 1.5) * patience)
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGKILL if rng.random() < 0.7 else signal.SIGTERM)
                process.wait()
                killed += 1
        require(output.read_bytes() == whole.read_bytes(), f"{output.name}: other bytes after a kill")
        output.unlink()
        left = {path.name for path in folder.iterdir()} - {"q.npy"} - {f"whole.{each}" for each in FORMATS}
        require(not left, f"left behind: {left}")
    return f"{trials} runs with {killed} kills gave the same bytes"


def damage(folder: Path, scale: float, rng: np.random.Generator) -> str:
    """Journals, cached bodies and files of bodies with flipped, cut, added and zeroed bytes never change a verdict."""
    trials = max(3, round(10 * scale))
    os.environ["PLANNERCHECK_CACHE"] = str(folder / "cache")
    points = rng.normal(size=(60, 3))
    body = pc.Polytope(points)
    saved = folder / "seed.body"
    body.save(saved)
    whole, refused = saved.read_bytes(), 0
    for _ in range(trials):
        saved.write_bytes(damaged(whole, rng))
        try:
            other = pc.Polytope.load(saved)
        except PlannercheckError:
            refused += 1
            continue
        require(np.array_equal(other.vertices, body.vertices), "a damaged body was taken")
    source, output = folder / "q.npy", folder / "o.npz"
    np.save(source, pc.Robot.load("panda").random_configurations(40_000, 0))
    command = [*COMMAND, source, "--output", output]
    right = ran(command).stdout, output.read_bytes()
    journal = interrupted_journal(command, output)
    cached = sorted((folder / "cache").glob("*.body"))
    for trial in range(max(2, trials // 10)):  # each is a process
        output.unlink(missing_ok=True)
        Path(f"{output}.progress").write_bytes(damaged(journal, rng))
        victim = cached[trial % len(cached)]
        sound = victim.read_bytes()
        victim.write_bytes(damaged(sound, rng))
        done = ran([*command, "--resume"])
        if done.returncode == 2:
            Path(f"{output}.progress").unlink()
            done = ran(command)
        require(done.returncode in (0, 1) and output.read_bytes() == right[1], f"other verdicts: {done.stderr[-500:]}")
        victim.write_bytes(sound)
    return f"{trials} damaged bodies ({refused} refused), {max(2, trials // 10)} journals with cache files"


def damaged(content: bytes, rng: np.random.Generator) -> bytes:
    """Content with one kind of damage."""
    data, at = bytearray(content), int(rng.integers(len(content)))
    match int(rng.integers(5)):
        case 0:
            data[at] ^= 1 << int(rng.integers(8))
        case 1:
            del data[at:]
        case 2:
            data += rng.bytes(int(rng.integers(1, 100)))
        case 3:
            data[at : at + 64] = bytes(len(data[at : at + 64]))
        case _:
            data[at:at] = rng.bytes(8)
    return bytes(data)


def interrupted_journal(command: list[object], output: Path) -> bytes:
    """What a run that was killed has left, or, if it was too fast, nothing but the beginning of one."""
    output.unlink()
    process = subprocess.Popen(list(map(str, command)), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    journal, content = Path(f"{output}.progress"), b"plannercheck journal 1 {}\n"
    while process.poll() is None:
        if journal.exists() and journal.stat().st_size > len(content):
            content = journal.read_bytes()
    return content


def mutants(folder: Path, scale: float, rng: np.random.Generator) -> str:
    """Mutated inputs of all loaders, by fuzz_loaders.py, in a process whose memory is limited."""
    seconds = max(5.0, 6.0 * scale)
    command = [sys.executable, Path(__file__).with_name("fuzz_loaders.py"), "--seconds", str(seconds)]

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_DATA, (MEMORY, MEMORY))

    done = subprocess.run(list(map(str, command)), preexec_fn=limit, capture_output=True, text=True, check=False)
    require(done.returncode == 0, f"{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return " ".join(done.stdout.split()[-40:])


def scenes(folder: Path, scale: float, rng: np.random.Generator) -> str:
    """Checkers for changing scenes, with things attached and let go of, take constant memory."""
    trials = max(200, round(10_000 * scale))
    checker = pc.Checker(pc.Robot.load("panda"), pc.Scene.load("bookshelf"))
    q = checker.robot.reference

    def one(k: int) -> None:
        scene = pc.Scene.load("bookshelf") if k % 1000 == 0 else checker.scene.copy()
        scene.add_box("moving", [0.1, 0.1, 0.1], placed(rng.uniform(1, 2, 3)))
        changed = checker.with_scene(scene)
        if k % 5 == 0:
            changed = changed.attach("can", pc.shapes.Sphere(0.03), "panda_hand", placed([0, 0, 0.15]), ["panda_hand"])
            changed.is_valid(q)
            changed = changed.detach("can")
        changed.is_valid(q)

    return f"{trials} changed scenes, memory grew by {growth(one, trials) / 1e6:.1f} MB"


def plans(folder: Path, scale: float, rng: np.random.Generator) -> str:
    """Plans take constant memory."""
    trials = max(20, round(1000 * scale))
    robot = pc.Robot.load("panda")
    checker = pc.Checker(robot, pc.Scene())
    start = robot.reference

    def one(k: int) -> None:
        setup = pc.ompl.setup(checker)
        space = setup.getStateSpace()
        for put, q in ((setup.setStartState, start), (setup.setGoalState, start + 0.1)):
            state = space.allocState()
            for joint, value in enumerate(q.tolist()):
                state[joint] = value
            put(state)
        setup.solve(0.05)

    return f"{trials} plans, memory grew by {growth(one, trials) / 1e6:.1f} MB"


def growth(one: Callable[[int], object], trials: int) -> int:
    """By how many bytes memory grows in the second half of the trials."""
    for k in range(trials // 2):
        one(k)
    before = resident()
    for k in range(trials // 2, trials):
        one(k)
    grown = resident() - before
    require(grown < ROOM, f"memory grew by {grown / 1e6:.1f} MB in {trials // 2} trials")
    return grown


def resident() -> int:
    """Bytes of memory that this process has now."""
    return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * resource.getpagesize()


def threads(folder: Path, scale: float, rng: np.random.Generator) -> str:
    """Eight threads that load, check, plan and write at once give what one gives."""
    rows = pc.Robot.load("panda").random_configurations(500, 0)
    right = pc.Checker(pc.Robot.load("panda"), pc.Scene.load("bookshelf")).check_states(rows)
    end, faults, rounds = time.monotonic() + max(5.0, 6.0 * scale), [], [0] * 8

    def work(number: int) -> None:
        try:
            while time.monotonic() < end:
                checker = pc.Checker(pc.Robot.load("panda"), pc.Scene.load("bookshelf"))
                require(np.array_equal(checker.check_states(rows, threads=2), right), "other verdicts in a thread")
                body = pc.Polytope(rows[:40, :3])
                body.save(folder / f"{number}.body")
                require(np.array_equal(pc.Polytope.load(folder / f"{number}.body").vertices, body.vertices), "a body")
                pc.ompl.setup(checker)
                rounds[number] += 1
        except BaseException as error:
            faults.append(error)

    pool = [threading.Thread(target=work, args=(k,)) for k in range(8)]
    for thread in pool:
        thread.start()
    for thread in pool:
        thread.join()
    require(not faults, f"{faults[:1]!r}")
    os.fstat(1), os.fstat(2)
    return f"{sum(rounds)} rounds of 8 threads"


def placed(position: object) -> np.ndarray:
    """A pose (4, 4) at a position, m."""
    pose = np.eye(4)
    pose[:3, 3] = position
    return pose


def ran(command: list[object]) -> subprocess.CompletedProcess[str]:
    return subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False)


def require(holds: bool, otherwise: str) -> None:
    """Ends the run at a broken promise."""
    if not holds:
        raise SystemExit(f"broken: {otherwise}")


PARTS: dict[str, Callable[[Path, float, np.random.Generator], str]] = {
    part.__name__: part for part in (kills, damage, mutants, scenes, plans, threads)
}

if __name__ == "__main__":
    sys.exit(main())
