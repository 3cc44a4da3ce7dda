"""Solids in scenes: in files of our own, in MoveIt's where that is asked for, and back."""

import warnings

import numpy as np
import pytest
import trimesh
import yaml

import plannercheck as pc
from plannercheck.cli.main import main
from plannercheck.scenes.scene_table import scene_html

TORUS = trimesh.creation.torus(1, 0.25, major_sections=12, minor_sections=6)
POINTS, TRIANGLES = np.asarray(TORUS.vertices), np.asarray(TORUS.faces)
SMALL = pc.Sphere(0.1)

OPEN = {"vertices": POINTS.tolist(), "triangles": TRIANGLES[1:].tolist()}


@pytest.fixture
def folder(tmp_path):
    TORUS.export(tmp_path / "ring.stl")
    trimesh.Trimesh(POINTS, TRIANGLES[1:], process=False).export(tmp_path / "open.stl")
    return tmp_path


def written(folder, *objects, **more):
    path = folder / "scene.yaml"
    path.write_text(yaml.safe_dump({"objects": list(objects), **more}))
    return path


def shape_of(scene, name="ring"):
    (part,) = scene.object(name).parts
    return part.shape


def has_a_hole(scene, name="ring"):
    return not pc.intersects(shape_of(scene, name), SMALL)


def test_solids_are_shapes_of_objects():
    scene = pc.Scene("rings")
    scene.add("ring", pc.Solid(POINTS, TRIANGLES), None)
    scene.add("pair", [pc.Part(pc.Solid(POINTS, TRIANGLES)), pc.Part(pc.Box((0.1, 0.1, 0.1)))])
    scene.attach("held", "hand", None, (), pc.Solid(POINTS, TRIANGLES))
    assert has_a_hole(scene)
    assert [body.name for body in scene.bodies] == ["ring", "pair/0", "pair/1"]
    assert f"solid of {len(TRIANGLES)} triangles" in scene_html(scene)


@pytest.mark.parametrize("given", ["ring.stl", {"file": "ring.stl"}, {"file": "ring.stl", "scale": [1, 1, 1]}])
def test_files_name_meshes_as_solids(folder, given):
    scene = pc.Scene.load(written(folder, {"name": "ring", "solid": given, "position": [1, 0, 0]}))
    assert has_a_hole(scene)
    assert shape_of(scene).is_closed
    assert scene.object("ring").pose[0, 3] == 1
    assert not has_a_hole(pc.Scene.load(written(folder, {"name": "ring", "mesh": {"file": "ring.stl"}})))


def test_files_have_scales(folder):
    scene = pc.Scene.load(written(folder, {"name": "ring", "solid": {"file": "ring.stl", "scale": 0.1}}))
    np.testing.assert_allclose(np.abs(shape_of(scene).vertices).max(), 0.125, rtol=1e-6)


def test_files_may_have_triangles_themselves(folder):
    given = {"vertices": POINTS.tolist(), "triangles": TRIANGLES.tolist()}
    scene = pc.Scene.load(written(folder, {"name": "ring", "parts": [{"solid": given, "position": [0, 0, 0.5]}]}))
    assert shape_of(scene).vertices.tolist() == POINTS.tolist()
    assert shape_of(scene).triangles.tolist() == TRIANGLES.tolist()


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ("nothing.stl", r"object 'ring': solid: mesh file .*nothing\.stl.* does not exist"),
        ({"vertices": POINTS.tolist()}, "solid: .*'triangles'"),
        ({"vertices": [[0, 0, 0]], "triangles": [[0, 0, 1]]}, r"row 0 is \[0, 0, 1\], but there are 1 vertices"),
        ({"vertices": [[0, 0, 0]], "triangles": [[0, 0, 0.5]]}, "whole numbers"),
        ({"vertices": [[0, 0, 0]], "triangles": []}, "at least one triangle"),
        ({"vertices": [[0, 0, 0]], "triangles": [[0, 0]]}, "triangles row 0"),
        ({"vertices": [[0, 0, 0]], "triangles": [[0, 0, 0]], "file": "a.stl"}, "file"),
        ({"fil": "ring.stl"}, "fil"),
        ({"file": "ring.stl", "open": "caps"}, "unknown way to take an open mesh 'caps': did you mean 'cap'"),
        ({"file": "ring.stl", "open": True}, "open"),
        (7, "solid"),
    ],
)
def test_mistakes_are_named(folder, given, says):
    with pytest.raises(pc.PlannercheckError, match=says):
        pc.Scene.load(written(folder, {"name": "ring", "solid": given}))


@pytest.mark.parametrize(
    ("given", "words", "kind"),
    [
        ("open.stl", "caps close", "capped"),
        ({"file": "open.stl", "open": "cap"}, "caps close", "capped"),
        ({"file": "open.stl", "open": "triangles"}, "triangles alone", "open"),
        ({"file": "open.stl", "open": "hull"}, "are their hulls", "hull"),
        ({**OPEN, "open": "triangles"}, "triangles alone", "open"),
        (OPEN, "caps close", "capped"),
    ],
)
def test_an_open_mesh_is_taken_as_asked_with_one_warning(folder, given, words, kind):
    path = written(folder, {"name": "ring", "solid": given}, {"name": "held", "solid": given})
    with pytest.warns(RuntimeWarning, match=rf"{words}.*: ring \(1 loop of 3 edges.*, held \(") as caught:
        scene = pc.Scene.load(path)
    assert len(caught) == 1
    assert shape_of(scene).kind == kind
    scene.save(folder / "again.yaml")
    with pytest.warns(RuntimeWarning, match=words):
        again = pc.Scene.load(folder / "again.yaml")
    assert shape_of(again).digest == shape_of(scene).digest
    assert shape_of(again).open == shape_of(scene).open


def test_add_mesh_takes_open_meshes_as_asked(folder):
    scene = pc.Scene("rings")
    for geometry, kind in (("solid", "capped"), ("triangles", "open")):
        with pytest.warns(RuntimeWarning, match=r"open\.stl"):
            scene.add_mesh(geometry, folder / "open.stl", geometry=geometry)
        assert shape_of(scene, geometry).kind == kind
    with pytest.raises(pc.PlannercheckError, match="unknown geometry 'solids': did you mean 'solid'"):
        scene.add_mesh("other", folder / "open.stl", geometry="solids")


def test_all_meshes_of_a_scene_may_be_solids(folder):
    objects = [{"name": "ring", "mesh": {"file": "ring.stl"}}, {"name": "open", "mesh": {"file": "open.stl"}}]
    path = written(folder, *objects, attached=[{"name": "held", "link": "hand", "mesh": {"file": "ring.stl"}}])
    for meshes, words, kind in (("solid", "caps close", "capped"), ("triangles", "triangles alone", "open")):
        with pytest.warns(RuntimeWarning, match=rf"{words}.*: open \(1 loop of 3 edges") as caught:
            scene = pc.Scene.load(path, meshes=meshes)
        assert len(caught) == 1
        assert has_a_hole(scene)
        assert has_a_hole(scene, "held")
        assert shape_of(scene, "open").kind == kind
    with pytest.raises(pc.PlannercheckError, match="unknown kind of meshes 'solids': did you mean 'solid'"):
        pc.Scene.load(path, meshes="solids")


def test_saved_scenes_name_files_or_have_triangles(folder):
    scene = pc.Scene("rings")
    scene.add_mesh("file", folder / "ring.stl", geometry="solid", scale=0.5)
    scene.add_mesh("hull", folder / "ring.stl")
    scene.add("inline", pc.Solid(POINTS, TRIANGLES))
    scene.save(folder / "saved.yaml")
    nodes = {node["name"]: node for node in yaml.safe_load((folder / "saved.yaml").read_text())["objects"]}
    assert nodes["file"]["solid"] == {"file": "ring.stl", "scale": 0.5}
    assert nodes["hull"]["mesh"]["file"] == "ring.stl"
    assert set(nodes["inline"]["solid"]) == {"vertices", "triangles"}
    again = pc.Scene.load(folder / "saved.yaml")
    for name in ("file", "inline"):
        assert shape_of(again, name).digest == shape_of(scene, name).digest
    assert isinstance(shape_of(again, "hull"), pc.Hull)


# MoveIt.


def message(triangles=TRIANGLES, **mesh):
    given = mesh or {"vertices": POINTS.tolist(), "triangles": [{"vertex_indices": t} for t in triangles.tolist()]}
    return {"name": "s", "world": {"collision_objects": [{"id": "ring", "meshes": [given]}]}, "robot_state": {}}


def test_moveits_meshes_are_hulls_or_solids(folder):
    path = folder / "moveit.yaml"
    for mesh in ({}, {"resource": "ring.stl"}):
        path.write_text(yaml.safe_dump(message(**mesh)))
        assert not has_a_hole(pc.Scene.load(path))
        assert has_a_hole(pc.Scene.load(path, meshes="solid"))
    path.write_text(yaml.safe_dump(message(TRIANGLES[1:])))
    with pytest.warns(RuntimeWarning, match="caps close open meshes: ring"):
        assert has_a_hole(pc.Scene.load(path, meshes="solid"))
    with pytest.warns(RuntimeWarning, match="triangles alone"):
        assert shape_of(pc.Scene.load(path, meshes="triangles")).kind == "open"


def test_moveits_text_has_solids_as_meshes(folder):
    scene = pc.Scene("rings")
    scene.add("ring", pc.Solid(POINTS, TRIANGLES))
    scene.save(folder / "rings.scene")
    again = pc.Scene.load(folder / "rings.scene", meshes="solid")
    assert shape_of(again).digest == shape_of(scene).digest
    assert not has_a_hole(pc.Scene.load(folder / "rings.scene"))


def test_the_command_line_takes_meshes_as_solids(folder, capsys):
    path = str(written(folder, {"name": "ring", "mesh": {"file": "ring.stl"}, "position": [0, 0, 0.5]}))
    common = ("inspect", "--robot", "ur5", "--scene", path, "--states", "20")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert main([*common]) == 0
        assert "ring              (scene)         hull" in capsys.readouterr().out
        assert main([*common, "--scene-meshes", "solid"]) == 0
    assert "ring              (scene)         solid" in capsys.readouterr().out
