"""A cluster of two processes, one of which is killed: complete, and the same bytes as from one process."""

import os
import pickle
import signal
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from plannercheck import planar
from plannercheck.cli.main import main
from plannercheck.common.errors import PlannercheckError
from plannercheck.motions.checker import Checker
from plannercheck.robots.robot import Robot
from plannercheck.scenes.scene import Scene
from plannercheck.validation.engines import LocalEngine
from plannercheck.validation.fingerprint import fingerprint
from plannercheck.validation.formats.chunks import Chunk
from plannercheck.validation.journal import Journal
from plannercheck.validation.judging import Judge
from plannercheck.validation.outputs import Results, write_results
from plannercheck.validation.run import Run

CHUNKS, ROWS = 12, 2000


@pytest.mark.parametrize("name", ["panda", "truck_trailer", "talos"])
def test_a_checker_travels_with_its_prepared_bodies(name, monkeypatch):
    if name == "truck_trailer":
        checker = planar.Checker(planar.Robot.load(name), planar.Scene.load("parking"))
    else:
        checker = Checker(Robot.load(name), Scene.load("bookshelf"), padding=0.001)
    packed = pickle.dumps(checker)
    if name != "truck_trailer":
        monkeypatch.setattr("plannercheck.bodies.polytope.Polytope.__init__", lambda *_: pytest.fail("prepared again"))
    there = pickle.loads(packed)
    rows = checker.robot.random_configurations(300, 0)
    if name == "panda":
        rows[::7] *= 3  # beyond the limits
    assert np.array_equal(there.first_colliding_pair(rows), checker.first_colliding_pair(rows))
    assert there.is_valid(rows[1]) == checker.is_valid(rows[1])


def killing(rows: np.ndarray, pids: dict[str, int]) -> Iterator[Chunk]:
    """Chunks; the first worker is killed while they are judged."""
    for k in range(CHUNKS):
        if k == CHUNKS // 2 and pids:
            os.kill(min(pids.values()), signal.SIGKILL)
        yield Chunk(k * ROWS, rows[k * ROWS : (k + 1) * ROWS])


def written(path: Path, checker: Checker, judge: Judge, engine: LocalEngine, chunks: Iterator[Chunk]) -> bytes:
    journal = Journal(path.with_suffix(".journal"), fingerprint(checker, judge, ROWS))
    report = Run(judge, journal).over(chunks, engine)
    assert report.states == CHUNKS * ROWS
    write_results(path, Results.of(journal, judge, False, ["q"], checker))
    journal.remove()
    return path.read_bytes()


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="needs SIGKILL")
def test_a_lost_worker_is_made_up_for(tmp_path, checker):
    pytest.importorskip("distributed")
    from plannercheck.validation.cluster import ClusterEngine

    judge, rows = Judge(), checker.robot.random_configurations(CHUNKS * ROWS, 2)
    alone = written(tmp_path / "a.npz", checker, judge, LocalEngine(checker, judge), killing(rows, {}))
    with ClusterEngine(checker, judge, workers=2) as engine:
        pids = engine.client.run(os.getpid)
        assert len(pids) == 2
        assert written(tmp_path / "b.npz", checker, judge, engine, killing(rows, pids)) == alone
        address, security = engine.client.scheduler.address, engine.client.security
        with ClusterEngine(checker, judge, scheduler=address, security=security) as second:
            ((_, findings),) = second.findings([Chunk(0, rows[:100])])
            assert np.array_equal(findings.arrays["first_pair"], checker.first_colliding_pair(rows[:100]))
        held = engine.client.run(lambda dask_worker: [name for name in dask_worker.plugins if "plannercheck" in name])
        assert [len(names) for names in held.values()] == [1] * len(held)  # the second one has left nothing
        bad = [Chunk(70, np.full((2, 7), np.nan), 0)]
        with pytest.raises(PlannercheckError, match="rows from 70 on: configurations must be finite"):
            list(engine.findings(bad))


def test_no_scheduler(tmp_path, capsys, monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr("plannercheck.validation.cluster._PATIENCE", 0.2)
    np.save(tmp_path / "q.npy", np.zeros((1, 7)))
    options = ["--engine", "dask", "--scheduler", "tcp://127.0.0.1:9"]
    assert main(["validate", "--robot", "panda", str(tmp_path / "q.npy"), *options]) == 2
    assert "no cluster at tcp://127.0.0.1:9" in capsys.readouterr().err
