"""`plannercheck view`: a robot in its scene, colliding bodies in red, with proofs.

In: a robot, a scene, a configuration, a set of them or a path. Out: a page for the browser, served or as a file.
"""

from __future__ import annotations

import argparse
import warnings
from pathlib import Path
from typing import NamedTuple

import numpy as np

from plannercheck.checking.input_hints import degrees_hint
from plannercheck.checking.protocols import AnyChecker
from plannercheck.cli.common import (
    add_checker_arguments,
    check_folder,
    joint_vector,
    load_checker,
)
from plannercheck.cli.robot_options import described
from plannercheck.cli.trajectory_files import add_controller_argument, add_start_time_argument, trajectory_of
from plannercheck.cli.unused_options import check_used
from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.atomic_files import is_stream
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.motion_paths import PATHS, MotionPath
from plannercheck.motions.checker import Checker
from plannercheck.ompl.start_and_goal import checked_end
from plannercheck.planar.robot_files import is_planar
from plannercheck.validation.formats.chunks import read_states
from plannercheck.validation.formats.paths import read_robot_path
from plannercheck.view.frames import DEFAULT_FRAMES, along_path, along_trajectory
from plannercheck.view.joints import joints_of
from plannercheck.view.page import write_page
from plannercheck.view.picture import picture
from plannercheck.view.server import DEFAULT_PORT, serve
from plannercheck.view.surfaces import delivered_meshes, visual_meshes

_EPILOG = """\
Without FILE, --path and --q, the scene's start for the robot is shown, or else the robot's reference.

Colliding bodies are red, with the points that they share; separating planes are blue, with the nearest points of their
two bodies. The page that --html writes needs no network: drag turns, shift-drag moves, the wheel comes nearer, a click
names a body, ? lists the keys. Its address may set the view: page.html#frame=3&azimuth=-60&elevation=20&hide=plane and
theme=dark or theme=light, which otherwise the browser chooses.

Examples:
  plannercheck view --robot panda --scene bookshelf --html panda.html
  plannercheck view --robot panda --scene bookshelf --path plan.json
  plannercheck view --robot panda --scene bookshelf --path trajectory.yaml --controller jtc
  plannercheck view --robot talos --meshes --only-invalid samples.npy --html talos.html
"""

# Frames of a set that are shown by default.
_DEFAULT_STATES = 50

# The last port of TCP.
_LAST_PORT = 65535


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's options."""
    parser.epilog = _EPILOG
    add_checker_arguments(parser)
    parser.add_argument(
        "file", nargs="?", metavar="FILE", type=Path, help="set to show, one configuration after another"
    )
    parser.add_argument("--q", metavar="A,B,...", help="configuration to show, rad and m")
    parser.add_argument("--path", type=Path, metavar="PATH", help="plan or other path to animate")
    parser.add_argument(
        "--frames",
        type=int,
        help=f"number of frames of a path; default: {DEFAULT_FRAMES}, more of a trajectory that takes longer than 4 s",
    )
    add_controller_argument(parser, "show, in real time,")
    add_start_time_argument(parser)
    parser.add_argument(
        "--time", type=float, metavar="S", help="the scene's clock, for configurations where something in it moves"
    )
    parser.add_argument(
        "--motion-path",
        choices=PATHS,
        help="how planar and floating joints move on a path; default: as the file says, as plans of free bodies do, "
        "or screw",
    )
    parser.add_argument(
        "--first",
        type=int,
        default=_DEFAULT_STATES,
        metavar="N",
        help="show the first N of a set; default: %(default)s",
    )
    parser.add_argument("--only-invalid", action="store_true", help="show only what collides of a set")
    parser.add_argument(
        "--planes",
        type=int,
        metavar="N",
        help="planes of the nearest pairs in each frame; default: 3 for one configuration, else 1",
    )
    parser.add_argument(
        "--meshes", action="store_true", help="also draw the robot's visual and collision meshes as delivered"
    )
    parser.add_argument("--html", type=Path, metavar="FILE", help="write one page that needs no network, and stop")
    parser.add_argument("--port", type=int, default=DEFAULT_PORT, help="port to serve at; default: %(default)s")
    parser.add_argument(
        "--host", default="localhost", help="address to serve on; default: %(default)s, this machine alone"
    )


def run(options: argparse.Namespace) -> int:
    """Runs the command."""
    _check(options)
    checker = load_checker(options)
    shown = _frames(options, checker)
    if _moves(checker) and shown.times is None and options.time is None:
        raise PlannercheckError("something in the scene moves: give --time, or a trajectory by --path and --controller")
    rows = shown.rows
    robot = described(options) if options.meshes else None
    meshes, visuals = (None, ()) if robot is None else (delivered_meshes(robot), visual_meshes(robot))
    is_path = options.path is not None
    drawn = picture(
        checker,
        rows,
        labels=shown.labels,
        animated=is_path,
        times=shown.times,
        time=options.time,
        planes=options.planes,
        meshes=meshes,
        visuals=visuals,
    )
    frames = "1 frame" if drawn.frames == 1 else f"{drawn.frames} frames"
    if options.html is not None:
        write_page(drawn, options.html)
        if is_stream(options.html):  # standard output may be the page
            return 0
        size = options.html.stat().st_size / 1e6
        print(f"{drawn.title}, {frames}: written to {options.html} ({size:.1f} MB)")
        return 0
    has_sliders = not _moves(checker) and len(checker.robot.joint_names) == checker.robot.nq > 0
    joints = joints_of(checker, rows, meshes, visuals) if has_sliders else None
    stage = serve(drawn, options.port, options.host, joints)
    address = f"http://{options.host}:{stage.server.get_port()}"
    print(f"{drawn.title}, {frames}: {address}, until Ctrl-C", flush=True)
    try:
        stage.play()
    finally:
        stage.server.stop()
    return 0


def _check(options: argparse.Namespace) -> None:
    check_folder(options.html)
    if sum(given is not None for given in (options.file, options.q, options.path)) > 1:
        raise PlannercheckError("FILE, --q and --path exclude each other: give one")
    if options.path is None:
        check_used(options, ("--frames", "--motion-path", "--controller", "--start-time"), "with --path")
    if options.file is None:
        check_used(options, ("--first", "--only-invalid"), "with FILE, a set")
    if options.html is not None:
        check_used(options, ("--port", "--host"), "without --html, which serves nothing")
    if (1 if options.frames is None else options.frames) < 1 or options.first < 1 or (options.planes or 0) < 0:
        raise PlannercheckError("--frames and --first must be at least 1, --planes at least 0")
    if not 0 < options.port <= _LAST_PORT:
        raise PlannercheckError(f"--port must be from 1 to {_LAST_PORT}, not {options.port}")
    if options.meshes and is_planar(options.robot, "robots"):
        raise PlannercheckError("--meshes is for robots in space")


class Shown(NamedTuple):
    """The configurations to show, what they are called, and when they are."""

    rows: Floats
    labels: tuple[str, ...]
    times: Floats | None = None


def _frames(options: argparse.Namespace, checker: AnyChecker) -> Shown:
    robot = checker.robot
    if options.path is not None:
        if options.controller is not None:
            return _in_time(options, checker)
        path = read_robot_path(options.path, robot)
        if path.bent_by and not options.motion_path:
            return _in_time(options, checker)
        motion_path: MotionPath = options.motion_path or path.motion_path or "screw"
        frames = options.frames or DEFAULT_FRAMES
        return Shown(*along_path(checker, path.states, frames, motion_path, path.pieces))
    if options.file is not None:
        return _of_set(options, checker)
    if options.q is not None:
        return Shown(_given(options.q, checker), ("--q",))
    return _declared(checker)


def _in_time(options: argparse.Namespace, checker: AnyChecker) -> Shown:
    """A trajectory as its controller runs it."""
    trajectory = trajectory_of(options.path, checker.robot, options.controller)
    rows, times = along_trajectory(trajectory, options.frames)
    if options.start_time is not None or _moves(checker):
        times = times + ((options.start_time or 0.0) - times[0])
    return Shown(rows, tuple(f"{time:.3f} s" for time in times.tolist()), times)


def _given(text: str, checker: AnyChecker) -> Floats:
    """One configuration (1, nq) from the command line."""
    q = checked_end(checker, joint_vector(text, "--q", checker.robot), "--q")
    hint = degrees_hint(checker.robot, q)
    if hint:
        warnings.warn(f"--q is beyond the limits; {hint}", RuntimeWarning, stacklevel=2)
    return q[None]


def _of_set(options: argparse.Namespace, checker: AnyChecker) -> Shown:
    """The first configurations of a file, or the first that collide."""
    found: list[Floats] = []
    labels: list[str] = []
    for chunk in read_states(options.file, checker.robot):
        wanted = (
            ~_free(checker, chunk.rows, options.time) if options.only_invalid else np.ones(len(chunk.rows), dtype=bool)
        )
        rows = np.flatnonzero(wanted)[: options.first - len(labels)]
        found.append(chunk.rows[rows])
        labels += [f"row {chunk.first_row + row}" for row in rows.tolist()]
        if len(labels) == options.first:
            break
    if not labels:
        what = "no configuration that collides" if options.only_invalid else "no configuration"
        raise PlannercheckError(f"file {str(options.file)!r} holds {what}")
    return Shown(np.concatenate(found), tuple(labels))


def _moves(checker: AnyChecker) -> bool:
    """Whether something in the scene moves."""
    return bool(getattr(checker.scene, "moving", ()))


def _free(checker: AnyChecker, rows: Floats, time: float | None) -> Bools:
    """(n,) which configurations are free, at a time of the scene's clock if it moves."""
    return checker.check_states(rows, times=time) if isinstance(checker, Checker) else checker.check_states(rows)


def _declared(checker: AnyChecker) -> Shown:
    """The start of the scene, else the robot's reference, else zeros."""
    robot, states = checker.robot, getattr(checker.scene, "states", {})
    if robot.name in states and states[robot.name].start is not None:
        return Shown(checker.scene.start(robot.name)[None], ("start of the scene",))
    reference = getattr(robot, "reference", np.zeros(robot.nq))
    return Shown(np.asarray(reference)[None], ("reference of the robot",))
