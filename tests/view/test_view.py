"""Pictures: poses are Pinocchio's, what collides is red, and both back ends draw exactly the model."""

import base64
import json
import re
import subprocess
import sys
import urllib.request

import numpy as np
import pinocchio as pin
import pytest
from browser import BROWSER, browser_flags
from pinocchio_geometry import pinocchio_geometry

from plannercheck.cli.main import main
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.package_data import shipped_folder
from plannercheck.motions.checker import Checker
from plannercheck.planar.checker import Checker as PlanarChecker
from plannercheck.planar.robot import Robot as PlanarRobot
from plannercheck.planar.scene import Scene as PlanarScene
from plannercheck.robots.description import find_description, read_description
from plannercheck.robots.robot import Robot
from plannercheck.robots.urdf import read_model
from plannercheck.scenes.scene import Scene
from plannercheck.view import along_path, delivered_meshes, picture, serve, write_page
from plannercheck.view.model import COLLIDING, COLOURS
from plannercheck.view.page import data_of, page_of

SAMPLES = shipped_folder("configs") / "bookshelf_panda.npy"
BROWSER_FLAGS = browser_flags(500, 400)


@pytest.fixture(scope="module")
def rows(checker):
    """A valid configuration, then one that collides."""
    samples = np.load(SAMPLES)
    valid = checker.check_states(samples)
    return np.stack([samples[valid][0], samples[~valid][0]])


@pytest.fixture(scope="module")
def drawn(checker, rows):
    return picture(checker, rows, planes=2)


def test_what_is_no_picture_is_one_error(checker, rows, drawn, tmp_path):
    for call in (write_page, serve):
        with pytest.raises(
            PlannercheckError, match=r"not a Checker: plannercheck.view.picture\(checker, q\) makes one"
        ):
            call(checker, tmp_path / "page.html")
    assert not list(tmp_path.iterdir())
    with pytest.raises(PlannercheckError, match="a picture is of a checker, not of a Robot"):
        picture(checker.robot, rows)


def test_poses_are_pinocchios(checker, rows, drawn):
    description = read_description(find_description("panda"))
    model = read_model(description.urdf)
    geometry = pinocchio_geometry(model, description.urdf, description.package_dirs)
    for frame, q in enumerate(rows):
        placements = pin.GeometryData(geometry)
        pin.updateGeometryPlacements(model, model.createData(), geometry, placements, checker.robot.expand(q))
        expected = {g.name: m.homogeneous for g, m in zip(geometry.geometryObjects, placements.oMg, strict=True)}
        shown = {mesh.name: mesh.pose(frame) for mesh in drawn.meshes if mesh.layer == "hull"}
        assert shown.keys() == expected.keys()
        for name, pose in shown.items():
            np.testing.assert_allclose(pose, expected[name], atol=1e-12)
    for mesh, body in zip(drawn.meshes[len(checker.robot.bodies) :], checker.scene.bodies, strict=True):
        assert mesh.layer == ("floor" if body.name == "floor" else "obstacle")
        assert np.array_equal(mesh.pose(1), body.pose)


def test_what_collides_is_red(checker, rows, drawn):
    for frame, q in enumerate(rows):
        hit = {name for v in checker.explain(q).collisions for name in (v.first_body, v.second_body)}
        assert {mesh.name for mesh in drawn.meshes if mesh.colour(frame) == COLLIDING} == hit
        assert {mesh.colour(frame) for mesh in drawn.meshes if mesh.name not in hit} <= set(COLOURS.values())
    assert drawn.verdict(0) == "free of collision"
    assert drawn.verdict(1).startswith("collision: ")


def test_witnesses_and_planes_are_those_of_the_certificates(checker, rows, drawn):
    expected = [v.certificate.point.tolist() for v in checker.explain(rows[1]).collisions]
    assert [each.point.tolist() for each in drawn.witnesses] == expected
    assert {each.frame for each in drawn.witnesses} == {1}
    for frame, q in enumerate(rows):
        planes = [plane for plane in drawn.planes if plane.frame == frame]
        assert len(planes) == 2
        if frame == 0:
            assert planes[0].gap == pytest.approx(checker.clearance(q), rel=1e-9)
        for plane in planes:
            sides = (plane.nearest - plane.centre) @ plane.normal
            assert sides[0] > 0 > sides[1]
            assert np.linalg.norm(plane.nearest[0] - plane.nearest[1]) >= plane.gap * (1 - 1e-9)


def test_a_path_is_shown_with_all_its_configurations(checker, rows):
    path = np.concatenate([rows, rows[:1] + 0.3])
    frames, labels = along_path(checker, path, 10)
    assert len(frames) == len(labels)
    assert 10 <= len(frames) <= 13
    for q in path:
        assert (frames == q).all(axis=1).any()
    assert np.abs(np.diff(frames, axis=0)).max() < np.abs(np.diff(path, axis=0)).max() / 3
    with pytest.raises(PlannercheckError, match="at least 1 frame"):
        along_path(checker, path, 0)


def test_delivered_meshes_are_within_their_hulls(checker, rows):
    meshes = delivered_meshes("panda")
    shown = picture(checker, rows[0], meshes=meshes, planes=0)
    hulls = {mesh.name: mesh for mesh in shown.meshes if mesh.layer == "hull"}
    inner = [mesh for mesh in shown.meshes if mesh.layer == "mesh"]
    assert inner
    for mesh in inner:
        hull = hulls[mesh.name]
        assert hull.opacity < 1 == mesh.opacity
        np.testing.assert_allclose(mesh.vertices.max(axis=0), hull.vertices.max(axis=0))


def test_plates_have_two_sides():
    scene, away = Scene("plates"), np.eye(4)
    away[0, 3] = 5.0
    corners = [[0, 0, 0], [1, 1, 0], [1, 0, 0], [0, 1, 0], [0.5, -0.5, 0]]
    scene.add_hull("plate", corners, away)
    scene.add_hull("rod", [[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]], away)
    plate, rod = picture(Checker(Robot.load("ur5"), scene), np.zeros(6), planes=0).meshes[-2:]
    assert len(rod.faces) == 0
    a, b, c = (plate.vertices[plate.faces[:, k]] for k in range(3))
    areas = np.cross(b - a, c - a)[:, 2] / 2
    assert areas[areas > 0].sum() == pytest.approx(1.25)
    assert areas[areas < 0].sum() == pytest.approx(-1.25)


def test_pictures_of_the_plane():
    checker = PlanarChecker(PlanarRobot.load("truck_trailer"), PlanarScene.load("parking"))
    rows = checker.robot.random_configurations(200, 0)
    rows = rows[np.argsort(checker.check_states(rows))][:3]
    shown = picture(checker, rows)
    for frame, q in enumerate(rows):
        found = checker.explain(q)
        hit = {name for v in found.collisions for name in (v.first_body, v.second_body)}
        assert {mesh.name for mesh in shown.meshes if mesh.colliding[frame]} == hit
        points = [each.point[:2].tolist() for each in shown.witnesses if each.frame == frame]
        assert points == [v.certificate.point.tolist() for v in found.collisions]


def test_a_page_holds_everything(drawn):
    page = page_of(drawn)
    assert not re.search(r"https?://|<link|src=|import ", page)
    data = json.loads(re.search(r'id="data">(.*?)</script>', page, re.DOTALL)[1])
    assert data == json.loads(json.dumps(data_of(drawn)))
    for mesh, given in zip(drawn.meshes, data["meshes"], strict=True):
        vertices = np.frombuffer(base64.b64decode(given["vertices"]), "<f4").reshape(-1, 3)
        np.testing.assert_allclose(vertices, mesh.vertices, rtol=1e-6, atol=1e-9)
        poses = np.frombuffer(base64.b64decode(given["poses"]), "<f4").reshape(-1, 4, 3)
        np.testing.assert_allclose(poses[-1].T, mesh.pose(1)[:3], rtol=1e-6, atol=1e-7)
        assert given["colliding"] == np.flatnonzero(mesh.colliding).tolist()


def test_words_in_a_page_end_no_script(checker, rows):
    shown = picture(checker, rows[0], labels=["</script><b>"], planes=0)
    assert "</script><b>" not in page_of(shown)


@pytest.mark.skipif(BROWSER is None, reason="no Chromium: apt-get install chromium")
def test_a_page_in_a_browser(drawn, tmp_path):
    from matplotlib.image import imread

    write_page(drawn, tmp_path / "page.html")
    image = tmp_path / "page.png"
    address = (tmp_path / "page.html").as_uri() + "#frame=1&bare=1&hide=plane,witness"
    profile = f"--user-data-dir={tmp_path / 'profile'}"
    command = [BROWSER, *BROWSER_FLAGS, profile, f"--screenshot={image}", address]
    subprocess.run(command, check=True, capture_output=True, timeout=120)
    pixels = imread(image)[..., :3].reshape(-1, 3)
    red = (pixels[:, 0] > 0.4) & (pixels[:, 1:].max(axis=1) < 0.5 * pixels[:, 0])
    assert len(np.unique((255 * pixels).astype(int), axis=0)) > 100  # not blank
    assert 50 < red.sum() < len(pixels) / 2


def test_the_server_shows_the_model(drawn):
    pytest.importorskip("viser")
    stage = serve(drawn, port=0)
    try:
        for frame in (1, 0):
            stage.show(frame)
            for mesh, handle in zip(drawn.meshes, stage.meshes, strict=True):
                np.testing.assert_allclose(handle.position, mesh.pose(frame)[:3, 3], atol=1e-6)
                assert tuple(handle.color) == tuple(round(255 * part) for part in mesh.colour(frame))
        with urllib.request.urlopen(f"http://localhost:{stage.server.get_port()}", timeout=10) as answer:
            assert answer.status == 200
    finally:
        stage.server.stop()


def test_without_viser_one_is_told_what_to_do(drawn, monkeypatch):
    monkeypatch.setitem(sys.modules, "viser", None)
    with pytest.raises(PlannercheckError, match=r"pip install 'plannercheck\[view\]', or write a page by --html"):
        serve(drawn)


def test_view_on_the_command_line(tmp_path, capsys):
    page = tmp_path / "page.html"
    base = ["view", "--robot", "panda", "--scene", "bookshelf", "--html", str(page)]
    assert main([*base, str(SAMPLES), "--only-invalid", "--first", "2", "--planes", "0"]) == 0
    text = page.read_text(encoding="utf-8")
    assert text.count('"collision: ') == 2
    assert ", 2 frames: written to" in capsys.readouterr().out
    assert main([*base, "--q", "-0.1,-0.785,0,-2.356,0,1.571,0.785"]) == 0
    assert ", 1 frame: written to" in capsys.readouterr().out
    assert main([*base, str(SAMPLES), "--q", "0,0,0,0,0,0,0"]) == 2
    assert "exclude each other" in capsys.readouterr().err
    assert main([*base[:-1], str(tmp_path / "no" / "page.html")]) == 2
    assert "there is no folder" in capsys.readouterr().err


def test_a_configuration_by_names_of_joints(checker, rows):
    named = dict(zip(checker.robot.joint_names[::-1], rows[0][::-1], strict=True))
    assert data_of(picture(checker, named, planes=0)) == data_of(picture(checker, rows[0], planes=0))
    with pytest.raises(PlannercheckError, match="missing: panda_joint7"):
        picture(checker, {name: value for name, value in named.items() if name != "panda_joint7"})
    plane = PlanarChecker(PlanarRobot.load("forklift"), PlanarScene.load("parking"))
    q = plane.scene.start("forklift")
    assert data_of(picture(plane, {"x": q[0], "y": q[1], "theta": q[2]})) == data_of(picture(plane, q))
