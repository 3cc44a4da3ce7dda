"""The layers of a picture: the floor, what links look like; and the page's legend, scale, axes, keys and colours."""

import re
import subprocess

import numpy as np
import pinocchio as pin
import pytest
from browser import BROWSER, browser_flags
from poses import at

from plannercheck.cli.main import main
from plannercheck.motions.checker import Checker
from plannercheck.planar.checker import Checker as PlanarChecker
from plannercheck.planar.robot import Robot as PlanarRobot
from plannercheck.planar.scene import Scene as PlanarScene
from plannercheck.robots.description import find_description, read_description
from plannercheck.robots.robot import Robot
from plannercheck.robots.urdf import read_model
from plannercheck.scenes.scene import Scene
from plannercheck.view import picture, visual_meshes, write_page
from plannercheck.view.page import data_of, page_of

BROWSER_FLAGS = browser_flags(900, 600)


@pytest.fixture(scope="module")
def start(checker):
    return checker.scene.start("panda")


def layers(shown):
    return {mesh.owner: mesh.layer for mesh in shown.meshes if mesh.layer in ("obstacle", "floor")}


def test_the_floor_differs_from_the_furniture(checker, start):
    shown = picture(checker, start, planes=0)
    assert {owner for owner, layer in layers(shown).items() if layer == "floor"} == {"floor"}
    colours = {mesh.layer: mesh.colour(0) for mesh in shown.meshes}
    assert colours["floor"] != colours["obstacle"]


@pytest.mark.parametrize(
    ("name", "size", "position", "layer"),
    [
        ("plate", [4, 4, 0.1], (0, 0, -0.2), "floor"),
        ("plate", [4, 4, 0.1], (2.5, 0, 0.4), "obstacle"),  # a table's top: the robot goes further down
        ("block", [1, 1, 1], (0, 0, -1.0), "obstacle"),  # not flat: a base
        ("Ground_1", [1, 1, 1], (0, 0, -1.0), "floor"),
        ("underground_map", [1, 1, 1], (0, 0, -1.0), "obstacle"),
    ],
)
def test_a_floor_is_known_by_its_name_or_by_lying_below_all(name, size, position, layer):
    scene = Scene("one")
    scene.add_box(name, size, at(*position))
    scene.add_box("cup", [0.1, 0.1, 0.1], at(3, 0, 0.8))
    found = layers(picture(Checker(Robot.load("ur5"), scene), np.zeros(6), planes=0))
    assert found == {name: layer, "cup": "obstacle"}


def test_links_look_as_their_urdf_says(checker, start):
    visuals = visual_meshes("panda")
    shown = [mesh for mesh in picture(checker, start, planes=0, visuals=visuals).meshes if mesh.layer == "visual"]
    description = read_description(find_description("panda"))
    model = read_model(description.urdf)
    folders = [str(folder) for folder in (*description.package_dirs, *description.urdf.resolve().parents)]
    geometry = pin.buildGeomFromUrdf(model, str(description.urdf), pin.VISUAL, package_dirs=folders)
    placements = pin.GeometryData(geometry)
    q = checker.robot.expand(start)
    pin.updateGeometryPlacements(model, model.createData(), geometry, placements, q)
    assert [mesh.name for mesh in shown] == [each.name for each in geometry.geometryObjects]
    for mesh, each, placement in zip(shown, geometry.geometryObjects, placements.oMg, strict=True):
        np.testing.assert_allclose(mesh.pose(0), placement.homogeneous, atol=1e-12)
        corners = mesh.vertices.astype(np.float32)
        areas = np.linalg.norm(
            np.cross(*(corners[mesh.faces[:, k]] - corners[mesh.faces[:, 0]] for k in (1, 2))), axis=1
        )
        assert (areas > 0).sum() <= each.geometry.num_tris <= len(mesh.faces)  # assimp drops those of no area
        theirs = each.geometry.vertices()
        for side in (np.min, np.max):
            np.testing.assert_allclose(side(corners, axis=0), side(theirs, axis=0), atol=1e-6)


def test_what_links_look_like_is_red_where_they_collide(checker):
    rows = checker.scene.samples("panda")
    q = rows[~checker.check_states(rows)][0]
    hit = {name for v in checker.explain(q).collisions for name in (v.first, v.second)}
    shown = picture(checker, q, planes=0, visuals=visual_meshes("panda"))
    assert {mesh.owner for mesh in shown.meshes if mesh.layer == "visual" and mesh.colliding[0]} == {
        name for name in hit if name in checker.robot.link_names
    }
    assert all(mesh.opacity < 1 for mesh in shown.meshes if mesh.layer == "hull")


SHAPES = """<robot name="shapes"><link name="base">
<visual><geometry><box size="1 2 3"/></geometry></visual>
<visual><origin xyz="0 0 1"/><geometry><sphere radius="0.5"/></geometry></visual>{more}
<collision><geometry><box size="1 1 1"/></geometry></collision></link></robot>"""


def test_visuals_may_be_shapes_and_missing_ones_are_only_warned_of(tmp_path):
    urdf = tmp_path / "shapes.urdf"
    urdf.write_text(SHAPES.format(more=""))
    box, ball = visual_meshes(urdf)
    assert np.ptp(box.surface[0], axis=0).tolist() == [1, 2, 3]
    assert ball.pose[2, 3] == 1
    urdf.write_text(
        SHAPES.format(more='<visual><geometry><mesh filename="package://no/such.dae"/></geometry></visual>')
    )
    with pytest.warns(RuntimeWarning, match="what its links look like is left out"):
        assert visual_meshes(urdf) == ()


def test_the_command_draws_them_on_request(tmp_path):
    page = tmp_path / "page.html"
    assert main(["view", "--robot", "panda", "--scene", "bookshelf", "--html", str(page), "--meshes"]) == 0
    assert len(re.findall(r'"layer": ?"visual"', page.read_text("utf-8"))) == len(visual_meshes("panda"))


def test_a_page_knows_the_colours_of_its_legend_and_dark_mode(checker, start):
    shown = picture(checker, start, planes=0)
    colours = data_of(shown)["colours"]
    assert {mesh.layer for mesh in shown.meshes} <= colours.keys()
    page = page_of(shown)
    assert "color-scheme: light dark" in page
    assert "prefers-color-scheme: dark" in page


def in_browser(page, tmp_path, wishes, what):
    """What Chromium makes of a page: its elements after its script, or a picture of it."""
    profile = f"--user-data-dir={tmp_path / 'profile'}"
    command = [BROWSER, *BROWSER_FLAGS, profile, what, f"{page.as_uri()}#{wishes}"]
    return subprocess.run(command, check=True, capture_output=True, timeout=120, text=True).stdout


@pytest.mark.skipif(BROWSER is None, reason="no Chromium: apt-get install chromium")
def test_a_browser_shows_legend_scale_axes_and_keys(checker, start, tmp_path):
    write_page(picture(checker, start, planes=1), tmp_path / "page.html")
    seen = in_browser(tmp_path / "page.html", tmp_path, "", "--dump-dom")
    legend = re.search(r'<div id="legend">(.*?)</div>', seen, re.DOTALL)[1]
    for words in ("hulls", "obstacles", "floor", "separating planes", "axes x, y, z"):
        assert words in legend
    assert "visual" not in legend, "there are none"
    assert re.search(r'<span id="length">\d+ (cm|m)</span><div id="rule" style="width: \d+', seen)
    assert re.findall(r'<span class="axis"[^>]*>(.)</span>', seen) == ["x", "y", "z"]
    assert re.search(r'<div id="keys">.*drag: turn.*R: first view', seen)


@pytest.mark.skipif(BROWSER is None, reason="no Chromium: apt-get install chromium")
@pytest.mark.parametrize(("theme", "background"), [("dark", (21, 25, 29)), ("light", (255, 255, 255))])
def test_a_browser_shows_dark_and_light(checker, start, tmp_path, theme, background):
    from matplotlib.image import imread

    write_page(picture(checker, start, planes=0), tmp_path / "page.html")
    image = tmp_path / "page.png"
    in_browser(tmp_path / "page.html", tmp_path, f"theme={theme}&bare=1&hide=obstacle,floor", f"--screenshot={image}")
    assert tuple((255 * imread(image)[2, 2, :3]).round().astype(int).tolist()) == background


def test_pictures_of_the_plane_have_no_floor():
    checker = PlanarChecker(PlanarRobot.load("forklift"), PlanarScene.load("parking"))
    assert "floor" not in layers(picture(checker, checker.scene.start("forklift"))).values()
