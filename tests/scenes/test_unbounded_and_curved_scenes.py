"""Half-spaces and ellipsoids in scenes: in files of our own and back, in tables and pictures."""

import re

import numpy as np
import pytest
import yaml
from poses import at

import plannercheck as pc
from plannercheck.cli.main import main
from plannercheck.scenes.scene_hints import scale_hint
from plannercheck.scenes.scene_table import scene_html
from plannercheck.validation.fcl_agreement import compare_with_fcl
from plannercheck.view.picture import picture
from plannercheck.view.surfaces import surface_of


def written(folder, *objects, **more):
    path = folder / "scene.yaml"
    path.write_text(yaml.safe_dump({"objects": list(objects), **more}))
    return path


def shape_of(scene, name):
    (part,) = scene.object(name).parts
    return part.shape


def test_files_have_both(tmp_path):
    path = written(
        tmp_path,
        {"name": "egg", "ellipsoid": {"radii": [0.3, 0.2, 0.1]}, "position": [1, 0, 0]},
        {"name": "fine", "ellipsoid": {"radii": [0.3, 0.2, 0], "excess": 0.01}},
        {"name": "floor", "half_space": {"normal": [0, 0, 2]}},
        {"name": "corner", "parts": [{"half_space": {"normal": [1, 0, 0], "offset": -1.5}, "rpy": [0, 0, 0.3]}]},
    )
    scene = pc.Scene.load(path)
    assert shape_of(scene, "egg") == pc.Ellipsoid((0.3, 0.2, 0.1))
    assert shape_of(scene, "fine") == pc.Ellipsoid((0.3, 0.2, 0.0), 0.01)
    assert shape_of(scene, "floor") == pc.HalfSpace((0, 0, 2), 0.0)
    assert shape_of(scene, "corner") == pc.HalfSpace((1, 0, 0), -1.5)
    scene.save(tmp_path / "again.yaml")
    again = pc.Scene.load(tmp_path / "again.yaml")
    for name in scene.object_names:
        assert shape_of(again, name) == shape_of(scene, name)
        assert np.array_equal(again.object(name).bodies[0].pose, scene.object(name).bodies[0].pose)
    assert "half-space of normal 0, 0, 2, offset 0" in scene_html(again)
    assert scale_hint(again) == ""


@pytest.mark.parametrize(
    ("shape", "words"),
    [
        ({"half_space": {"offset": 1}}, "half_space: .*normal"),
        ({"half_space": {"normal": [0, 0, 0]}}, "half_space: normal of a half-space must be finite and not 0"),
        ({"half_space": {"normal": [0, 1], "offset": 0}}, "half_space: .*normal"),
        ({"half_space": {"normal": [0, 0, 1], "offset": "low"}}, "half_space: .*offset"),
        ({"half_space": {"normal": [0, 0, 1], "height": 0}}, "half_space: .*height"),
        ({"ellipsoid": {"radii": [1, 1]}}, "ellipsoid: .*radii"),
        ({"ellipsoid": {"radii": [1, 1, -1]}}, "ellipsoid: ellipsoid radius z"),
        ({"ellipsoid": {"radii": [1, 1, 1], "excess": 0}}, "ellipsoid: excess must be within"),
        ({"ellipsoid": {"radii": [1, 1, 1], "excess": 1e-9}}, "ellipsoid: excess 1e-09 needs about a million points"),
    ],
)
def test_wrong_entries_are_told(tmp_path, shape, words):
    with pytest.raises(pc.PlannercheckError, match=f"object 'it': {words}"):
        pc.Scene.load(written(tmp_path, {"name": "it", **shape}))


def test_attached_half_spaces_are_refused_in_files(tmp_path):
    shape = {"half_space": {"normal": [0, 0, 1]}}
    path = written(tmp_path, attached=[{"name": "shield", "link": "panda_hand", **shape}])
    with pytest.raises(pc.PlannercheckError, match="'shield' has a half-space, which no link can carry"):
        pc.Scene.load(path)


def test_moveits_text_holds_neither(tmp_path):
    for shape, words in ((pc.HalfSpace((0, 0, 1)), "no halfspace"), (pc.Ellipsoid((1, 2, 3)), "no ellipsoid")):
        scene = pc.Scene("s")
        scene.add("it", shape)
        with pytest.raises(pc.PlannercheckError, match=words):
            scene.save(tmp_path / "s.scene")


def room():
    scene = pc.Scene("room")
    pose = at(0.5, 0.2, 0.3)
    scene.add("egg", pc.Ellipsoid((0.1, 0.15, 0.3), 0.02), pose)
    scene.add("floor", pc.HalfSpace((0, 0, 1), -0.02))
    return scene


def test_pictures_draw_a_piece_of_the_plane():
    points, triangles = surface_of(pc.HalfSpace((0, 3, 4), -10.0), "wall")
    np.testing.assert_allclose(points @ [0, 0.6, 0.8], -2.0, atol=1e-12)
    np.testing.assert_allclose(points.mean(axis=0), [0, -1.2, -1.6], atol=1e-12)
    assert len(triangles) == 4  # both sides
    checker = pc.Checker(pc.Robot.load("panda"), room())
    q = checker.robot.random_configurations(20, 0)
    drawn = picture(checker, q, planes=3)
    assert {"egg", "floor"} <= {mesh.name for mesh in drawn.meshes}
    assert all(np.isfinite(mesh.vertices).all() and np.abs(mesh.vertices).max() < 10 for mesh in drawn.meshes)
    assert {witness.frame for witness in drawn.witnesses} == set(np.flatnonzero(~checker.check_states(q)).tolist())
    assert any("floor" in pair for frame in drawn.collisions for pair in frame)
    assert drawn.planes


def test_the_command_line_takes_both(tmp_path, capsys):
    room().save(tmp_path / "room.yaml")
    robot = pc.Robot.load("panda")
    np.save(tmp_path / "q.npy", robot.random_configurations(60, 2))
    options = ["--robot", "panda", "--scene", str(tmp_path / "room.yaml"), str(tmp_path / "q.npy")]
    assert main(["validate", *options, "--certify"]) == 1
    told = capsys.readouterr().out
    valid = pc.Checker(robot, room()).check_states(np.load(tmp_path / "q.npy"))
    assert re.search(rf"valid +{int(valid.sum())} ", told)
    assert re.search(r"floor", told)
    assert re.search(r"not proved +0", told)
    assert main(["inspect", "--robot", "panda", "--scene", str(tmp_path / "room.yaml")]) == 0
    assert "halfspace" in capsys.readouterr().out


def test_fcl_is_not_compared_with_half_spaces():
    checker = pc.Checker(pc.Robot.load("panda"), room())
    with pytest.raises(pc.PlannercheckError, match=r"floor.* something else"):
        compare_with_fcl(checker, checker.robot.random_configurations(3, 0))
