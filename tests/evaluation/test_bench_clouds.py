"""`plannercheck bench clouds` and `maps`: tiny runs write files; other libraries get the same cells and ground."""

import json

import coal
import fcl
import numpy as np
import pytest
from poses import at

import plannercheck as pc
from plannercheck.cli.main import main
from plannercheck.evaluation.bench import clouds
from plannercheck.evaluation.bench.sensed_peers import coal_map, fcl_map
from plannercheck.evaluation.sensing.buildings import building
from plannercheck.evaluation.sensing.moving_camera import STATES, STEPS, Frame, frames, step_rows
from plannercheck.evaluation.sensing.terrains import terrain

pytestmark = pytest.mark.usefixtures("hasty")


def boxes(n, low, high):
    rng = np.random.default_rng(0)
    return zip(rng.uniform(0.02, 0.3, (n, 3)), rng.uniform(low, high, (n, 3)), strict=True)


def coal_meets(found, edges, centre):
    shape, own = found
    asked = coal.CollisionRequest()
    where = [coal.Transform3s(own[:3, :3], own[:3, 3]), coal.Transform3s(np.eye(3), centre)]
    return coal.collide(shape, where[0], coal.Box(*edges), where[1], asked, coal.CollisionResult()) > 0


def fcl_meets(tree, edges, centre):
    pair = fcl.CollisionObject(tree), fcl.CollisionObject(fcl.Box(*edges), fcl.Transform(np.eye(3), centre))
    return fcl.collide(*pair, fcl.CollisionRequest(), fcl.CollisionResult()) > 0


def test_libraries_get_the_cells_of_a_cloud_and_of_a_map():
    points = np.random.default_rng(1).uniform(-0.5, 0.5, (200, 3))
    cells = building(4, 3, 1, 0.1, seed=0)
    tree = pc.Octree.from_cells(cells.keys, 0.1, cells.sizes)
    of_cloud = np.unique(np.floor(points / 0.04), axis=0) * 0.04
    cases = (
        (pc.PointCloud(points, 0.02), (of_cloud, of_cloud + 0.04), (-0.6, 0.6)),
        (tree, (cells.keys * 0.1, (cells.keys + cells.sizes[:, None]) * 0.1), (0, 3)),
    )
    for shape, (lows, highs), where in cases:
        others, found = (coal_map(shape), fcl_map(shape)), []
        for edges, centre in boxes(200, *where):
            expected = ((lows <= centre + edges / 2) & (highs >= centre - edges / 2)).all(axis=1).any()
            assert coal_meets(others[0], edges, centre) == fcl_meets(others[1], edges, centre) == expected
            found.append(expected)
        assert 10 < sum(found) < 190


def test_coal_gets_the_ground():
    heights = terrain(30, 0, 1.0)[:, :25]
    field = pc.HeightField(heights, 0.1, -1.0, (2.0, 3.0))
    found, met = coal_map(field), 0
    for edges, centre in boxes(300, (2.2, 3.2, -0.2), (4.6, 5.2, 1.2)):
        box = pc.Box(tuple(edges))
        pose = at(*centre)
        assert coal_meets(found, edges, centre) == pc.intersects(field, box, None, pose)
        met += coal_meets(found, edges, centre)
    assert 30 < met < 270


def test_what_libraries_lack_is_refused():
    with pytest.raises(pc.PlannercheckError, match="balls need one radius"):
        coal_map(pc.PointCloud(np.zeros((2, 3)), [0.1, 0.2]))
    with pytest.raises(pc.PlannercheckError, match="python-fcl has nothing like HeightField"):
        fcl_map(pc.HeightField(np.zeros((3, 3)), 0.1, -1.0))
    with pytest.raises(pc.PlannercheckError, match="no holes"):
        coal_map(pc.HeightField([[0, 0], [0, np.nan], [0, 0]], 0.1, -1.0))


def test_tiny_runs_write_their_files(tmp_path, capsys, monkeypatch):
    some = {name: clouds.HOLDERS[name] for name in ("plannercheck, balls", "plannercheck, cells", "coal's octree")}
    monkeypatch.setattr(clouds, "HOLDERS", some)
    tiny = ["--states", "20", "--motions", "5", "--rounds", "1", "--output", str(tmp_path)]
    assert main(["bench", "clouds", "--points", "300", *tiny]) == 0
    assert main(["bench", "maps", "--length", "8", "--storeys", "1", "--ground", "64", *tiny]) == 0
    shown = capsys.readouterr().out
    assert "panda before bookshelf, 300 points: 20 random states" in shown
    assert "changed in ms" in shown
    rows = json.loads((tmp_path / "clouds_costs.json").read_text())["rows"]
    assert {"plannercheck, balls", "plannercheck, cells", "coal's octree"} <= {row["method"] for row in rows}
    rows = json.loads((tmp_path / "maps_costs.json").read_text())["rows"]
    assert [row["name"].split(",")[0] for row in rows] == ["building", "ground"]
    for name in ("clouds_states", "clouds_motions", "maps_states", "maps_motions"):
        rows = json.loads((tmp_path / f"{name}.json").read_text())["rows"]
        assert any("coal" in row["method"] for row in rows), name
        assert all(row["microseconds"] > 0 for row in rows)


def test_a_moving_camera_is_followed(capsys):
    seen = list(frames(pc.Robot.load("panda"), pc.Scene.load("table"), 4, 3000, 0))
    assert [frame.points for frame in seen] == [3000] * 4
    assert all(0 < frame.kept < 3000 for frame in seen)
    assert all(0 < frame.free < 1 for frame in seen)
    assert any(frame.states >= 2 for frame in seen)
    assert STATES == 1000
    assert main(["demo", "--camera", "--frames", "2", "--points", "2000"]) == 0
    shown = capsys.readouterr()
    assert "frame 2 of 2: own points" in shown.err
    assert "in time for 30 frames a second" in shown.out


def test_steps_are_summed_up():
    seen = [Frame(10, 8, (0.001, 0, 0.002, 0.003, 0.001 * k), 0.5, 3 if k else 0) for k in range(31)]
    *steps, whole = step_rows(seen)
    assert [row.step for row in steps] == list(STEPS)
    assert (steps[0].median, steps[2].most) == pytest.approx((1, 2))
    assert (whole.median, whole.late, whole.most) == pytest.approx((21, 34.5, 36))
    assert (whole.kept, whole.frames, whole.planned) == pytest.approx((8, 31, 30 / 31))
    assert whole.in_time == pytest.approx(28 / 31)


def test_the_camera_is_measured(tmp_path, capsys):
    assert main(["bench", "camera", "--frames", "2", "--points", "2000", "--output", str(tmp_path)]) == 0
    assert "frame 2 of 2: own points" in capsys.readouterr().err
    rows = json.loads((tmp_path / "camera.json").read_text())["rows"]
    assert [row["step"] for row in rows] == [*STEPS, "all"]
    assert all(0 < row["median"] <= row["most"] for row in rows)


def test_options_of_the_camera_count_only_with_it(capsys):
    assert main(["demo", "--frames", "2"]) == 2
    assert main(["demo", "--camera", "--frames", "0"]) == 2
    assert "--frames and --points must be at least 1" in capsys.readouterr().err
