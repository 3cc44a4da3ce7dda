"""Mutated robot files: each is loaded or refused, in a process of its own with a limit of time and memory.

Run: `python tests/benchmarks/mutated_robots.py FORMAT [--count 5000] [--seed 0] [--folder FOLDER] [--keep FOLDER]`.
FORMAT is a key of `SEEDS`. Files of that format below the folder are mutated as well, beside the files that they name.

MuJoCo compiles a file in the process that loads it, which takes a hundredth of the time of a process of its own; what
ends there by a signal or not at all is loaded once more as users load it, and that counts.

Out: how many were loaded, refused, and how many ended in any other way: an error that is no PlannercheckError, a
signal, or no end within the limit. Those are kept and named, and the exit code is 1.
"""

import argparse
import os
import random
import re
import resource
import shutil
import signal
import sys
import tempfile
import warnings
from collections import Counter
from pathlib import Path

import mujoco
import numpy as np

import plannercheck as pc
from plannercheck.bodies import mjcf_files, mjcf_worker

# Processor time in s, by the clock six times as long, as the machine may be busy; bytes.
SECONDS, MEMORY = 10, 2 << 30

_MJCF = (
    """<mujoco><compiler angle="radian" eulerseq="XYZ"/><default><geom size=".1"/><default class="z">
<joint range="-1 1" type="slide"/></default></default><asset>
<mesh name="m" vertex="0 0 0 .5 0 0 0 .1 0 0 0 .1 .2 .2 .3"/>
<hfield name="h" nrow="2" ncol="3" size="1 1 .2 .1" elevation="0 1 0 1 0 1"/></asset>
<worldbody>
<geom name="floor" type="plane" size="1 1 1"/><geom type="hfield" hfield="h" pos="0 0 -1"/>
<replicate count="3" offset=".5 0 0" euler="0 0 .3"><body name="r" pos="0 2 0"><freejoint/><geom type="mesh" mesh="m"/>
</body></replicate><frame pos="0 0 1"><body name="a" childclass="z"><joint name="j"/>
<geom type="capsule" fromto="0 0 0 1 0 0" size=".05"/><body name="b" pos="1 0 0" euler="0 .2 .1">
<joint name="k" type="ball" range="0 2"/><geom type="box" mesh="m"/><geom type="cylinder" size=".1 .2" zaxis="1 0 1"/>
</body></body></frame></worldbody><contact><exclude body1="a" body2="b"/></contact>
<equality><joint joint1="j"/></equality><keyframe/></mujoco>""",
    """<mujoco><worldbody><flexcomp name="f" type="grid" count="4 4 2"
spacing=".1 .1 .1" radius=".01" dim="3" mass="1">
<contact contype="0" conaffinity="0"/><edge equality="true"/></flexcomp>
<body name="x" mocap="true"><geom size=".1"/></body></worldbody></mujoco>""",
    """<mujoco><worldbody><body name="a"><geom name="ga" size=".1"/><body name="b" pos="0 0 .3">
<joint name="j" axis="0 1 0" ref=".2" range="-2 2"/><joint name="i" type="slide"/><geom name="gb" contype="3"
size=".1"/><body name="c"><joint name="k"/><geom name="gc" size=".1"/></body></body></body></worldbody>
<contact><pair geom1="ga" geom2="gc"/></contact>
<equality><joint joint1="k" joint2="j" polycoef=".1 -2"/><weld body1="c"/></equality></mujoco>""",
)

# Each format's own seeds, the ending of its files, and what its files begin with.
SEEDS: dict[str, tuple[tuple[str, ...], str, str]] = {"mjcf": (_MJCF, ".xml", "<mujoco")}

_NUMBERS = ("0", "-1", "1e308", "nan", "inf", "1e9", "1000000000", "1e-320", "", "-0.5 0.5", "99999999999999999999")
_VALUES = (
    *_NUMBERS,
    "x",
    "0 0 0",
    "1 2 3 4 5 6 7 8",
    "../../x",
    "mesh",
    "box",
    "plane",
    "hfield",
    "sdf",
    "true",
    "auto",
)
_ATTRIBUTE = re.compile(r'([\w-]+)\s*=\s*"([^"]*)"')
_ELEMENT = re.compile(r"<(\w+)[^<>]*/>")
_NUMBER = re.compile(r"[-\d.eE]+")


def main() -> int:
    options = _parser().parse_args()
    seeds, ending, begin = SEEDS[options.format]
    files = sorted(options.folder.rglob(f"*{ending}")) if options.folder else []
    files = [file for file in files if begin in file.read_text(errors="replace") and file.stat().st_size < 60_000]
    mujoco.set_mju_user_warning(lambda message: None)  # else they are written to a file in the current folder
    rng, counts = random.Random(options.seed), Counter[str]()
    with tempfile.TemporaryDirectory() as name:
        first = Path(name) / f"first{ending}"
        first.write_text(seeds[0], encoding="utf-8")
        _load(first)  # so that the copies of this process import nothing
        for k in range(options.count):
            file = rng.choice(files) if files and rng.random() < 0.5 else None
            text = rng.choice(seeds) if file is None else file.read_text(errors="replace")
            folder = _folder(Path(name), file)
            path = folder / f"mutated{ending}"
            path.write_text(mutated(text, rng), encoding="utf-8", errors="surrogateescape")
            end = ending_of(path, is_quick=True)
            if end.startswith("ended by"):
                counts["ended in one process"] += 1
                end = ending_of(path, is_quick=False)
            counts[end] += 1
            if end not in ("loaded", "refused"):
                kept = options.keep / f"{options.format}_{options.seed}_{k}{ending}"
                shutil.copy(path, kept)
                print(f"{end}: {kept} of {file or 'a seed'}", flush=True)
            if k % 200 == 199:
                print(k + 1, dict(counts), flush=True)
    print(dict(counts))
    return 0 if set(counts) <= {"loaded", "refused", "ended in one process"} else 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("format", choices=SEEDS)
    parser.add_argument("--count", type=int, default=5000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--folder", type=Path, help="more files to mutate")
    parser.add_argument("--keep", type=Path, default=Path(), help="where files go that end in any other way")
    return parser


def _folder(where: Path, file: Path | None) -> Path:
    """A folder with links to all that is beside a file."""
    if file is None:
        return where
    folder = where / str(abs(hash(file.parent)))
    if not folder.exists():
        folder.mkdir()
        for each in file.parent.iterdir():
            (folder / each.name).symlink_to(each)
    return folder


def mutated(text: str, rng: random.Random) -> str:
    """The text with one or two changes: of a number in most cases, a value, an attribute, an element, or characters."""
    for _ in range(rng.choice((1, 1, 1, 2))):
        attributes, elements = list(_ATTRIBUTE.finditer(text)), list(_ELEMENT.finditer(text))
        kind = rng.choice(("number",) * 6 + ("value", "attribute", "element", "element", "characters"))
        if not attributes or not elements:
            kind = "characters"
        if kind == "number":
            found = rng.choice(attributes)
            numbers = list(_NUMBER.finditer(text, *found.span(2)))
            if numbers:
                text = _replaced(text, rng.choice(numbers).span(), rng.choice(_NUMBERS))
        elif kind == "value":
            text = _replaced(text, rng.choice(attributes).span(2), rng.choice(_VALUES))
        elif kind == "attribute":
            text = _replaced(text, rng.choice(attributes).span(1), rng.choice(attributes)[1])
        elif kind == "element":
            one, other = rng.choice(elements), rng.choice(elements)
            text = _replaced(text, one.span(), rng.choice(("", other[0], one[0] * 2, one[0] * 300)))
        else:
            place = rng.randrange(len(text))
            added = rng.choice(("", "<", ">", '"', "\0", "é", "</body>", "<body>"))
            text = _replaced(text, (place, place + rng.randrange(3)), added)
    return text


def _replaced(text: str, span: tuple[int, int], by: str) -> str:
    return text[: span[0]] + by + text[span[1] :]


def ending_of(path: Path, is_quick: bool) -> str:
    """How loading a file ends, in a copy of this process; a quick one compiles MJCF files itself."""
    sys.stdout.flush()
    child = os.fork()
    if not child:
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS))
        signal.alarm(6 * SECONDS)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
        if is_quick:
            mjcf_files._compiled = lambda path: {"said": np.array(""), **mjcf_worker.compiled(path)}
        os._exit(_load(path))
    status = os.waitpid(child, 0)[1]
    if os.WIFSIGNALED(status):
        return f"ended by {signal.Signals(os.WTERMSIG(status)).name}"
    return {0: "loaded", 1: "refused"}.get(os.WEXITSTATUS(status), "another error")


def _load(path: Path) -> int:
    warnings.simplefilter("ignore")
    try:
        robot = pc.Robot.load(path)
        if not _has_poses(robot):
            return 3
    except pc.PlannercheckError:
        return 1
    except BaseException:
        return 2
    return 0


def _has_poses(robot: pc.Robot) -> bool:
    """Whether the links of a robot have poses at its reference."""
    poses = robot.link_poses(robot.reference)
    return bool((poses == poses).all())


if __name__ == "__main__":
    raise SystemExit(main())
