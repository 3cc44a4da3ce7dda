"""Runs over sets: the verdicts of `check_states` in every format, and the same bytes even if broken off."""

import csv
import io
import json
import os
import signal
import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

import plannercheck as pc
from plannercheck import planar
from plannercheck.bodies.certificates import Separation, SharedPoint
from plannercheck.cli import validate as command
from plannercheck.cli.main import main
from plannercheck.cli.validate import JOURNAL_SUFFIX
from plannercheck.motions.checker import Checker
from plannercheck.robots.robot import Robot
from plannercheck.scenes.scene import Scene
from plannercheck.validation.fingerprint import content_hash
from plannercheck.validation.journal import Journal
from plannercheck.validation.progress import Progress, duration

PANDA = ["validate", "--robot", "panda", "--scene", "bookshelf"]
ROWS = 300


@pytest.fixture(scope="module")
def samples(checker) -> np.ndarray:
    """Some of which are beyond the limits."""
    rows = checker.robot.random_configurations(ROWS, 5)
    rows[::50, 0] += 7
    return rows


@pytest.fixture
def small_chunks(monkeypatch) -> None:
    monkeypatch.setattr(command, "CHUNK_ROWS", 64)
    monkeypatch.setattr(command, "_SLOW_CHUNK_ROWS", 64)


@pytest.fixture
def file(tmp_path, samples) -> Path:
    np.save(tmp_path / "q.npy", samples)
    return tmp_path / "q.npy"


def run(*arguments: object) -> int:
    return main([*PANDA, *map(str, arguments)])


def expected_first_pair(checker: Checker, samples: np.ndarray) -> np.ndarray:
    first = checker.first_colliding_pair(samples)
    assert np.array_equal(first < 0, checker.check_states(samples))
    return first


def test_all_outputs_have_the_verdicts_of_check_states(file, tmp_path, small_chunks, checker, samples):
    parquet = pytest.importorskip("pyarrow.parquet")
    first = expected_first_pair(checker, samples)
    beyond = ((samples < checker.robot.lower) | (samples > checker.robot.upper)).any(axis=1)
    names = [checker.pair_names(k) if k >= 0 else ("", "") for k in first.tolist()]
    for name in ("v.npz", "v.csv", "v.parquet"):
        assert run(file, file, "--output", tmp_path / name, "--summary", tmp_path / "s.json") == 1
    with np.load(tmp_path / "v.npz") as arrays:
        assert np.array_equal(arrays["valid"], np.tile(first < 0, 2))
        assert np.array_equal(arrays["first_pair"], np.tile(first, 2))
        assert np.array_equal(arrays["beyond_limits"], np.tile(beyond, 2))
        assert arrays["files"].tolist() == [str(file)] * 2
        assert arrays["file_rows"].tolist() == [ROWS, ROWS]
    with (tmp_path / "v.csv").open() as text:
        lines = list(csv.DictReader(text))
    assert [(line["first"], line["second"]) for line in lines] == names * 2
    assert [line["valid"] for line in lines] == [str(pair < 0).lower() for pair in first] * 2
    assert [int(line["row"]) for line in lines] == [*range(ROWS)] * 2
    table = parquet.read_table(tmp_path / "v.parquet")
    assert table["valid"].to_pylist() == (first < 0).tolist() * 2
    assert table["beyond_limits"].to_pylist() == beyond.tolist() * 2
    assert [second or "" for second in table["second"].to_pylist()] == [second for _, second in names] * 2
    summary = json.loads((tmp_path / "s.json").read_text())
    assert (summary["states"], summary["valid"], summary["beyond_limits"]) == (2 * ROWS, 2 * (first < 0).sum(), 12)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["q.npy", "s.json", "v.csv", "v.npz", "v.parquet"]


def test_only_failures_with_their_rows(file, tmp_path, small_chunks, checker, samples):
    first = expected_first_pair(checker, samples)
    beyond = np.zeros(ROWS, dtype=bool)
    beyond[::50] = True
    for limits, failed in (("error", (first >= 0) | beyond), ("warn", first >= 0), ("ignore", first >= 0)):
        run(file, "--output", tmp_path / "v.npz", "--only-invalid", "--limits", limits)
        with np.load(tmp_path / "v.npz") as arrays:
            assert np.array_equal(arrays["row"], np.flatnonzero(failed))
            assert np.array_equal(arrays["first_pair"], first[failed])
            assert ("beyond_limits" in arrays) == (limits != "ignore")


def test_limits_and_exit_codes(tmp_path, checker, samples, capsys):
    valid = samples[checker.check_states(samples)]
    np.save(tmp_path / "q.npy", valid[: (np.arange(len(valid)) < 40).sum()])
    for limits, code, told in (("error", 1, False), ("warn", 0, True), ("ignore", 0, False)):
        assert run(tmp_path / "q.npy", "--limits", limits) == code
        printed = capsys.readouterr()
        assert ("beyond the limits" in printed.err) == told
        assert ("beyond limits" in printed.out) == (limits != "ignore")


def test_degrees_and_standard_input(tmp_path, checker, samples, monkeypatch, capsys):
    text = io.BytesIO()
    np.savetxt(text, np.rad2deg(samples), header=",".join(checker.robot.joint_names), delimiter=",", comments="")
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(text.getvalue())))
    assert run("-", "--degrees", "--output", tmp_path / "v.npz") == 1
    with np.load(tmp_path / "v.npz") as arrays:
        assert np.array_equal(arrays["valid"], checker.check_states(np.deg2rad(np.rad2deg(samples))))
    np.save(tmp_path / "q.npy", np.rad2deg(samples))
    run(tmp_path / "q.npy")
    assert "--degrees" in capsys.readouterr().err


def test_certificates(file, tmp_path, small_chunks, checker, samples):
    first = expected_first_pair(checker, samples)
    run(file, "--output", tmp_path / "v.npz", "--explain")
    run(file, "--output", tmp_path / "v.csv", "--explain", "--only-invalid", "--limits", "ignore")
    with np.load(tmp_path / "v.npz") as arrays:
        found = {name: arrays[name] for name in arrays.files}
    with (tmp_path / "v.csv").open() as text:
        lines = {int(line["row"]): line for line in csv.DictReader(text)}
    assert sorted(lines) == np.flatnonzero(first >= 0).tolist()
    nearest = checker.nearest_pair(samples)
    for row in range(0, ROWS, 25):
        pair = first[row] if first[row] >= 0 else nearest[row]
        assert found["explained_pair"][row] == pair
        certificate = checker.explain_pair(int(pair), samples[row]).certificate
        if first[row] >= 0:
            assert isinstance(certificate, SharedPoint)
            assert found["point"][row].tolist() == certificate.point.tolist()
            assert [float(lines[row][f"point_{axis}"]) for axis in "xyz"] == certificate.point.tolist()
            assert lines[row]["gap"] == ""
            assert np.isnan(found["gap"][row])
        else:
            assert isinstance(certificate, Separation)
            assert found["normal"][row].tolist() == certificate.normal.tolist()
            assert (found["offset"][row], found["gap"][row]) == (certificate.offset, certificate.gap)


def test_planar_sets(tmp_path):
    robot, scene = planar.Robot.load("truck_trailer"), planar.Scene.load("parking")
    rows = planar.Checker(robot, scene).robot.random_configurations(200, 1)
    np.save(tmp_path / "q.npy", rows)
    where = ["validate", "--robot", "truck_trailer", "--scene", "parking", str(tmp_path / "q.npy"), "--explain"]
    assert main([*where, "--output", str(tmp_path / "v.npz")]) == 1
    with np.load(tmp_path / "v.npz") as arrays:
        assert np.array_equal(arrays["valid"], planar.Checker(robot, scene).check_states(rows))
        assert np.array_equal(np.isnan(arrays["point"]).any(axis=1), arrays["valid"])


@pytest.mark.parametrize("name", ["v.npz", "v.csv", "v.parquet"])
def test_sets_without_rows(tmp_path, name):
    pytest.importorskip("pyarrow")
    np.save(tmp_path / "q.npy", np.empty((0, 7)))
    assert run(tmp_path / "q.npy", "--output", tmp_path / name) == 0
    assert (tmp_path / name).stat().st_size


@pytest.mark.parametrize("name", ["q.npy", "q.csv", "header.csv"])
def test_an_empty_set_is_the_same_in_every_format(tmp_path, capsys, name):
    np.save(tmp_path / "q.npy", np.empty((0, 7)))
    np.savetxt(tmp_path / "q.csv", np.empty((0, 7)), delimiter=",")
    (tmp_path / "header.csv").write_text(",".join(f"panda_joint{k}" for k in range(1, 8)) + "\n")
    assert run(tmp_path / name) == 0
    assert "0 configurations" in capsys.readouterr().out


class Stopped(KeyboardInterrupt):
    """Ctrl-C."""


def broken_off(monkeypatch: pytest.MonkeyPatch, after: int, *arguments: object) -> None:
    """A run that ends by Ctrl-C after some chunks."""
    progress = Progress.advance

    def advance(self, rows, part):
        self.count = getattr(self, "count", 0) + 1
        if self.count == after:
            raise Stopped
        progress(self, rows, part)

    with monkeypatch.context() as patched:
        patched.setattr(Progress, "advance", advance)
        assert run(*arguments) == 130


@pytest.mark.parametrize("name", ["v.npz", "v.csv", "v.parquet"])
def test_an_interrupted_run_goes_on(file, tmp_path, small_chunks, monkeypatch, capsys, name):
    pytest.importorskip("pyarrow")
    output, journal = tmp_path / name, tmp_path / f"{name}{JOURNAL_SUFFIX}"
    run(file, "--output", output, "--explain", "--pairs", "all", "--summary", tmp_path / "s.json")
    whole, summary = output.read_bytes(), json.loads((tmp_path / "s.json").read_text())
    output.unlink()
    broken_off(monkeypatch, 3, file, "--output", output, "--explain", "--pairs", "all")
    assert "192 judged configurations are kept" in capsys.readouterr().err
    assert not output.exists()
    journal.write_bytes(journal.read_bytes()[:-10])  # a kill may cut a record off
    run(file, "--output", output, "--explain", "--pairs", "all", "--resume", "--summary", tmp_path / "s.json")
    assert output.read_bytes() == whole
    assert not journal.exists()
    again = json.loads((tmp_path / "s.json").read_text())
    assert again["resumed"] == 128
    assert {**again, "pairs": 0}.keys() == summary.keys()
    assert [again[key] for key in ("states", "valid", "pairs")] == [
        summary[key] for key in ("states", "valid", "pairs")
    ]


def test_a_journal_is_only_taken_up_by_the_same_run(file, tmp_path, small_chunks, monkeypatch, capsys, samples):
    output = tmp_path / "v.npz"
    broken_off(monkeypatch, 3, file, "--output", output)
    kept = (tmp_path / "v.npz.progress").read_bytes()
    (tmp_path / "scene.yaml").write_text("objects: [{name: box, box: {size: [1, 1, 1]}, position: [1, 0, 0]}]\n")
    np.save(tmp_path / "other.npy", np.concatenate([samples[:100], samples[99:]]))
    np.save(tmp_path / "short.npy", samples[:128])

    def refused(*arguments: object) -> str:
        capsys.readouterr()
        assert main(["validate", *map(str, arguments), "--output", str(output), "--resume"]) == 2
        assert (tmp_path / "v.npz.progress").read_bytes() == kept
        return capsys.readouterr().err

    panda = PANDA[1:]
    assert "robot: panda, now ur5" in refused("--robot", "ur5", "--scene", "bookshelf", file)
    assert "scene: bookshelf, now scene" in refused("--robot", "panda", "--scene", tmp_path / "scene.yaml", file)
    assert "pairs of bodies: " in refused(*panda, file, "--no-self-collision")
    assert "limits: error, now warn" in refused(*panda, file, "--limits", "warn")
    assert "all_pairs: False, now True" in refused(*panda, file, "--pairs", "all")
    assert "rows 64 to 127 are not those" in refused(*panda, tmp_path / "other.npy")
    assert "rows 0 to 63 are not those" in refused(*panda, file, "--degrees")
    assert "judged more than these files hold (file 1, from row 128 on)" in refused(*panda, tmp_path / "short.npy")
    monkeypatch.setattr(command, "CHUNK_ROWS", 32)
    assert "rows of a chunk: 64, now 32" in refused(*panda, file)
    (tmp_path / "v.npz.progress").write_bytes(kept := b"something else\n")
    assert "is no journal of a run" in refused(*panda, file)


def test_the_hash_of_a_checker_depends_on_what_verdicts_do(checker):
    robot, scene = checker.robot, Scene.load("bookshelf")
    assert content_hash(Checker(robot, scene)) == content_hash(checker)
    scene.add_sphere("ball", 0.1, np.array([[1, 0, 0, 0.9], [0, 1, 0, 0], [0, 0, 1, 0.9], [0, 0, 0, 1.0]]))
    held = robot.holding({"panda_finger_joint1": 0.01})
    others = [Checker(robot, scene), Checker(held, checker.scene), Checker(robot, checker.scene, padding=0.01)]
    assert len({content_hash(other) for other in [checker, *others]}) == 4


def test_the_hash_of_a_checker_depends_on_how_obstacles_move(checker):
    def scene(end=1.0, last=4.0, **how):
        poses = np.array([np.eye(4)] * 2)
        poses[:, 1, 3] = -1.0, end
        made = Scene("belt")
        made.add("pallet", pc.Box((0.4, 0.3, 0.2)), pc.Moving([0, last], poses, **how))
        return made

    scenes = scene(), scene(2.0), scene(last=5.0), scene(path="screw"), scene(outside="stand")
    assert len({content_hash(Checker(checker.robot, each)) for each in scenes}) == len(scenes)


def test_the_hash_of_a_checker_depends_on_what_obstacles_ride_on(checker):
    """A run must not be resumed though the ride of an obstacle is another one."""
    robot, other, base = checker.robot, Robot.load("panda"), np.eye(4)
    base[0, 3] = 1.0

    def ride(last=3.0, way=0.5, link="panda_hand", carrier=(other, base), start=1.0, **how):
        ends = np.stack([other.reference, other.reference + way])
        trajectory = pc.Trajectory([0.0, last], ends, controller="linear")
        made = Scene("belt")
        made.add("tool", pc.Box((0.1, 0.1, 0.1)), pc.Moving.along(trajectory, link, carrier, start, **how))
        return Checker(robot, made)

    ridden = other.holding({"panda_finger_joint1": 0.02})
    further = base.copy()
    further[0, 3] = np.nextafter(1.0, 2)
    others = [ride(last=4.0), ride(way=0.6), ride(link="panda_link7"), ride(carrier=other), ride(start=2.0)]
    others += [ride(carrier=(other, further)), ride(outside="stand"), ride(link="panda_leftfinger")]
    others += [ride(link="panda_leftfinger", carrier=(ridden, base))]
    hashes = [content_hash(each) for each in (ride(), *others)]
    assert len(set(hashes)) == len(hashes)
    assert content_hash(ride()) == hashes[0]


def test_the_hash_of_a_checker_depends_on_where_bodies_are_and_on_limits(checker, tmp_path):
    """Obstacles moved by one step of a double, links' bodies moved, limits by one step: each is another run."""
    robot, box = checker.robot, np.eye(4)
    hashes = set()
    for x in (0.5, np.nextafter(0.5, 1)):
        scene = Scene("box")
        box[0, 3] = x
        scene.add_box("box", (0.1, 0.1, 0.1), box)
        hashes.add(content_hash(Checker(robot, scene)))
    assert len(hashes) == 2
    balls = [Scene("ball"), Scene("ball")]
    for ball, radius in zip(balls, (0.1, np.nextafter(0.1, 1)), strict=True):
        ball.add_sphere("ball", radius, box)
    assert len({content_hash(Checker(robot, ball)) for ball in balls}) == 2
    hashes = set()
    for placed, upper in (("0 0 0", "1"), ("0 0 1e-16", "1"), ("0 0 0", "1.0000000000000002"), ("1 0 0", "1")):
        (tmp_path / "one.urdf").write_text(
            f'''<robot name="one"><link name="base"/><link name="tip"><collision><origin xyz="{placed}"/><geometry>
<box size="1 1 1"/></geometry></collision></link><joint name="slide" type="prismatic"><parent link="base"/>
<child link="tip"/><axis xyz="0 0 1"/><limit lower="-1" upper="{upper}" effort="1" velocity="1"/></joint></robot>'''
        )
        hashes.add(content_hash(Checker(Robot.from_urdf(tmp_path / "one.urdf"), scene)))
    assert len(hashes) == 4


def test_a_damaged_record_and_what_follows_it_is_judged_again(file, tmp_path, small_chunks, monkeypatch, capsys):
    """A byte turned over within a record's arrays: its checksum says so."""
    output, journal = tmp_path / "v.npz", tmp_path / "v.npz.progress"
    run(file, "--output", output)
    whole = output.read_bytes()
    output.unlink()
    broken_off(monkeypatch, 3, file, "--output", output)
    damaged = bytearray(journal.read_bytes())
    damaged[-300] ^= 1
    journal.write_bytes(bytes(damaged))
    # The number of threads is not part of what a run is.
    run(file, "--output", output, "--resume", "--threads", 2, "--summary", tmp_path / "s.json")
    assert json.loads((tmp_path / "s.json").read_text())["resumed"] == 128
    assert output.read_bytes() == whole


def test_a_run_broken_off_twice_keeps_what_came_after_a_cut_off_record(file, tmp_path, small_chunks, monkeypatch):
    """What a kill cut off goes, or all that is written after it would be taken for damaged."""
    output, journal = tmp_path / "v.npz", tmp_path / "v.npz.progress"
    run(file, "--output", output)
    whole = output.read_bytes()
    output.unlink()
    broken_off(monkeypatch, 3, file, "--output", output)
    journal.write_bytes(journal.read_bytes()[:-10])
    broken_off(monkeypatch, 2, file, "--output", output, "--resume")
    run(file, "--output", output, "--resume", "--summary", tmp_path / "s.json")
    assert json.loads((tmp_path / "s.json").read_text())["resumed"] == 256
    assert output.read_bytes() == whole


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="needs SIGKILL")
def test_a_killed_run_goes_on(tmp_path, checker):
    rows = checker.robot.random_configurations(400_000, 3)
    np.save(tmp_path / "q.npy", rows)
    arguments = [*PANDA, str(tmp_path / "q.npy"), "--output", str(tmp_path / "v.npz")]
    journal = tmp_path / "v.npz.progress"
    with subprocess.Popen([sys.executable, "-m", "plannercheck", *arguments], cwd=Path(__file__).parents[2]) as process:
        while process.poll() is None and not (journal.exists() and journal.stat().st_size > 400_000):
            time.sleep(0.005)
        os.kill(process.pid, signal.SIGKILL)
    assert process.returncode == -signal.SIGKILL
    assert [path.name for path in sorted(tmp_path.iterdir())] == ["q.npy", "v.npz.progress"]
    assert main([*arguments, "--resume", "--summary", str(tmp_path / "s.json")]) == 1
    assert 65_536 <= json.loads((tmp_path / "s.json").read_text())["resumed"] < len(rows)
    with np.load(tmp_path / "v.npz") as arrays:
        assert np.array_equal(arrays["first_pair"], checker.first_colliding_pair(rows))


def test_two_runs_at_once_are_refused(file, tmp_path, capsys):
    with closing(Journal(tmp_path / "v.npz.progress", {})):
        assert run(file, "--output", tmp_path / "v.npz") == 2
    assert "another run is writing" in capsys.readouterr().err


def test_an_unfinished_run_begins_anew_without_resume(file, tmp_path, small_chunks, monkeypatch, capsys):
    broken_off(monkeypatch, 3, file, "--output", tmp_path / "v.npz")
    capsys.readouterr()
    assert run(file, "--output", tmp_path / "v.npz", "--summary", tmp_path / "s.json") == 1
    assert "begins anew; --resume would go on" in capsys.readouterr().err
    assert json.loads((tmp_path / "s.json").read_text())["resumed"] == 0


def test_a_bad_row_in_the_middle_can_be_mended(file, tmp_path, small_chunks, samples, capsys):
    bad = samples.copy()
    bad[200, 2] = np.nan
    np.save(file, bad)
    assert run(file, "--output", tmp_path / "v.npz") == 2
    assert "row 200 is not finite" in capsys.readouterr().err
    np.save(file, samples)
    assert run(file, "--output", tmp_path / "v.npz", "--resume") == 1
    assert len(np.load(tmp_path / "v.npz")["valid"]) == ROWS


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["q.npy", "--resume"], "--resume needs --output"),
        (["-", "--resume", "--output", "v.npz"], "standard input, which is gone"),
        (["q.npy", "--resume", "--output", "v.npz", "--certify"], "not kept in the journal"),
        (["q.npy", "--explain"], "they need --output"),
        (["q.npy", "--output", "v.txt"], "--output must be one of .npz, .csv, .parquet"),
        (["q.npy", "--workers", "2"], "--engine dask"),
        (["q.npy", "--engine", "dask", "--workers", "2", "--scheduler", "tcp://1.2.3.4:5"], "give one of them"),
        (["--path", "p.json", "--output", "v.npz", "--degrees"], "--output and --degrees count only for sets"),
    ],
)
def test_options_that_do_not_go_together(capsys, arguments, message):
    assert run(*arguments) == 2
    assert message in capsys.readouterr().err


def test_progress_as_lines_and_as_a_bar(monkeypatch):
    now = iter(float(second) for second in range(0, 1000, 6))
    monkeypatch.setattr(time, "monotonic", lambda: next(now))
    for style, expected in (("lines", "plannercheck:  50%, 200 rows, 17 a second, 12 s left\n"), ("none", "")):
        stream = io.StringIO()
        progress = Progress(style, stream)
        progress.advance(100, 0.25)
        progress.advance(100, 0.5)
        progress.close()
        assert stream.getvalue() == expected
    stream = io.StringIO()
    bar = Progress("bar", stream)
    bar.skip(100, 0.25)
    bar.advance(100, 0.5)
    bar.close()
    assert "\r[############............]  50%, 200 rows, 17 a second, 12 s left\r" in stream.getvalue()
    assert [duration(seconds) for seconds in (3.2, 185, 7380)] == ["3 s", "3:05 min", "2:03 h"]
