"""Clouds and maps in pictures: every point and every outer square is drawn once, where it is; a browser shows them."""

import base64
import dataclasses
import json
import re
import subprocess

import numpy as np
import pytest
from browser import BROWSER, browser_flags

import plannercheck as pc
from plannercheck.evaluation.sensing.buildings import building, pruned
from plannercheck.evaluation.sensing.clouds import cloud, scene_bodies
from plannercheck.view import drawn_parts, picture, write_page
from plannercheck.view.cell_faces import outside
from plannercheck.view.drawn_parts import drawn_balls, drawn_cells
from plannercheck.view.page import data_of, page_of
from plannercheck.view.surfaces import surface_of

WHERE = {"name": "camera", "owner": "camera", "poses": np.eye(4)[None], "colliding": np.zeros(1, dtype=bool)}


def random_cells(seed, edge=16):
    full = np.random.default_rng(seed).random((edge, edge, edge)) < 0.7
    full[: edge // 2, : edge // 2, : edge // 2] = True
    return full, *pruned(np.argwhere(full).astype(np.int32))


def unit_squares(rectangles, axis):
    """The unit squares that rectangles cover, one row each."""
    u, v = (axis + 1) % 3, (axis + 2) % 3
    found = []
    for row in rectangles.tolist():
        for a in range(row[3]):
            for b in range(row[4]):
                place = list(row[:3])
                place[u] += a
                place[v] += b
                found.append(tuple(place))
    return found


@pytest.mark.parametrize("seed", range(3))
def test_rectangles_are_the_outside(seed):
    full, keys, sizes = random_cells(seed)
    assert sizes.max() == 8
    padded = np.pad(full, 1)
    sides = iter(outside(keys.astype(np.int64), sizes.astype(np.int64)))
    for axis in range(3):
        for towards in (1, -1):
            beside = np.roll(padded, -towards, axis=axis)[1:-1, 1:-1, 1:-1]
            expected = np.argwhere(full & ~beside)
            expected[:, axis] += towards == 1
            covered = unit_squares(next(sides), axis)
            assert len(covered) == len(set(covered)) == len(expected)
            assert set(covered) == set(map(tuple, expected.tolist()))


def test_rectangles_are_fewer_than_squares():
    rectangles = outside(np.zeros((1, 3), dtype=np.int64), np.array([64]))
    assert [len(side) for side in rectangles] == [1] * 6
    assert [row.tolist() for side in rectangles for row in side][:2] == [[64, 0, 0, 64, 64], [0, 0, 0, 64, 64]]


def test_balls_are_where_they_are():
    points = np.random.default_rng(0).uniform(-2, 3, (5000, 3))
    drawn = drawn_balls(points, np.linspace(0.01, 0.05, 5000), **WHERE)
    (group,) = drawn.groups
    np.testing.assert_allclose(drawn.corner + drawn.step * group[:, :3], points, atol=drawn.step)
    np.testing.assert_allclose(drawn.step * group[:, 3], np.linspace(0.01, 0.05, 5000), atol=drawn.step)
    assert drawn.step < 1e-4
    assert drawn.title == "camera"


def test_one_point_alone_is_drawn():
    drawn = drawn_balls(np.array([[1.0, 2, 3]]), np.array([0.1]), **WHERE)
    np.testing.assert_allclose(drawn.corner + drawn.step * drawn.groups[0][:, :3], [[1, 2, 3]])
    np.testing.assert_allclose(drawn.step * drawn.groups[0][0, 3], 0.1)


def test_of_too_many_some_are_drawn_and_the_name_says_so(monkeypatch):
    monkeypatch.setattr(drawn_parts, "MOST_DRAWN", 100)
    drawn = drawn_balls(np.random.default_rng(0).random((1000, 3)), np.array([0.01]), **WHERE)
    assert len(drawn.groups[0]) == 100
    assert drawn.title == "camera: 100 of 1,000 balls drawn"
    _, keys, sizes = random_cells(0)
    coarse = drawn_cells(keys, sizes, 0.1, np.array([1.0, 2, 3]), **WHERE)
    assert coarse.step > 0.1
    assert coarse.drawn < coarse.count == len(keys)
    assert f"of {len(keys):,} cells drawn" in coarse.title


def test_coarser_cells_hold_the_cells():
    full, keys, sizes = random_cells(1)
    places, edges = drawn_parts._coarser(keys.astype(np.int64), sizes.astype(np.int64))
    held = np.zeros((8, 8, 8), dtype=int)
    for (x, y, z), edge in zip(places.tolist(), edges.tolist(), strict=True):
        held[x : x + edge, y : y + edge, z : z + edge] += 1
    assert np.array_equal(held, full.reshape(8, 2, 8, 2, 8, 2).any(axis=(1, 3, 5)))


def test_cells_far_from_the_lattices_corner_are_drawn():
    cells = drawn_cells(np.array([[-40000, 7, 5]]), np.array([1]), 0.1, np.array([1.0, 0, 0]), **WHERE)
    np.testing.assert_allclose(cells.corner, [-3999, 0.7, 0.5])
    assert [len(group) for group in cells.groups] == [1] * 6


def test_a_height_field_is_drawn_as_its_upper_side():
    heights = np.random.default_rng(0).random((7, 5))
    points, triangles = surface_of(pc.HeightField(heights, (0.1, 0.2), -1.0, (3.0, 4.0)), "ground")
    assert len(points) == 35
    assert len(triangles) == 2 * 6 * 4
    np.testing.assert_allclose(points[5 * 2 + 3], [3.2, 4.6, heights[2, 3]])
    corners = points[triangles]
    assert (np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] > 0).all()
    heights[3, 2] = np.nan
    points, triangles = surface_of(pc.HeightField(heights, (0.1, 0.2), -1.0), "ground")
    assert len(triangles) == 2 * 6 * 4 - 6
    assert np.isfinite(points).all()
    points, _ = surface_of(pc.HeightField(np.zeros((1000, 900)), 0.1, -1.0), "ground")
    assert len(points) < 330**2
    np.testing.assert_allclose(points.max(axis=0), [99.9, 89.9, 0])


@pytest.fixture(scope="module")
def seen():
    """A robot before a cloud, and a map under the same robot."""
    robot, shelf = pc.Robot.load("panda"), pc.Scene.load("bookshelf")
    scene = pc.Scene("what a camera sees")
    scene.add("camera", pc.PointCloud(cloud(scene_bodies(shelf), 20_000, 0, base=(0.3, 0.1)), 0.01))
    cells, pose = building(12, 8, 1, 0.1, seed=0), np.eye(4)
    pose[:3, 3] = -2.5, -2.5, -0.25
    scene.add("map", pc.Octree.from_cells(cells.keys, cells.resolution, cells.sizes), pose)
    return picture(pc.Checker(robot, scene), robot.reference, planes=0)


def test_a_picture_holds_clouds_and_maps(seen):
    assert [(each.name, each.kind) for each in seen.parts] == [("camera", "balls"), ("map", "cells")]
    assert {mesh.layer for mesh in seen.meshes} == {"hull"}
    shown = data_of(seen)["parts"]
    numbers = np.frombuffer(base64.b64decode(shown[0]["groups"][0]), "<u2").reshape(-1, 4)
    assert np.array_equal(numbers, seen.parts[0].groups[0])
    assert len(shown[1]["groups"]) == 6
    for each in shown:
        assert all(low < high for low, high in each["ranges"])


def test_a_million_take_less_than_20_mb(seen):
    rng = np.random.default_rng(0)
    balls = drawn_balls(rng.random((1_000_000, 3)), np.array([0.01]), **WHERE)
    assert len(page_of(dataclasses.replace(seen, parts=(balls,)))) < 20e6


@pytest.mark.skipif(BROWSER is None, reason="no Chromium: apt-get install chromium")
@pytest.mark.parametrize("which", ["camera", "map"])
def test_a_browser_draws_them(seen, tmp_path, which):
    from matplotlib.image import imread

    only = dataclasses.replace(seen, parts=tuple(each for each in seen.parts if each.name == which))
    write_page(only, tmp_path / "page.html")
    shares = []
    for wish in ("hide=hull,axes", "hide=hull,axes&moving=1", "hide=hull,axes,sensed"):
        image = tmp_path / "page.png"
        address = f"{(tmp_path / 'page.html').as_uri()}#bare=1&theme=light&distance=9&elevation=40&{wish}"
        profile = f"--user-data-dir={tmp_path / 'profile'}"
        command = [BROWSER, *browser_flags(400, 300), profile, f"--screenshot={image}", address]
        subprocess.run(command, check=True, capture_output=True, timeout=120)
        pixels = imread(image)[..., :3]
        shares.append(float((pixels.min(axis=2) < 0.8).mean()))
    assert shares[0] > 0.05
    assert shares[1] > 0.8 * shares[0]
    assert shares[2] < 0.005


# Goes before the end of a page: what it finds, it leaves in the page, which the browser is asked for.
_WATCH = """
function copied() {
  const bytes = new Uint8Array(4 * canvas.width * canvas.height);
  gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
  return bytes;
}
const same = (a, b) => a.every((byte, i) => byte === b[i]), found = {};
function dragged(type, x) {
  canvas.dispatchEvent(new PointerEvent(type, { clientX: x, clientY: 100, buttons: 1 }));
}
canvas.setPointerCapture = () => {};  // which refuses made-up pointers
WHAT
document.documentElement.innerHTML = `<pre>${JSON.stringify(found)}</pre>`;
</script>
</body>"""
# One portion a slice, as if each took long.
_SLOW = """
pace.whole = Infinity;
pace.first = [1, 1];
layer.key = "";
const go = () => { layer.count = 1; prepare(); drawLayer(false); };"""


def found_in_browser(shown, tmp_path, what):
    """What a script finds in a page."""
    page = page_of(shown)
    head, _, _ = page.rpartition("</script>\n</body>")
    (tmp_path / "page.html").write_text(head + _WATCH.replace("WHAT", what), encoding="utf-8")
    flags, profile = browser_flags(400, 300), f"--user-data-dir={tmp_path / 'profile'}"
    address = (tmp_path / "page.html").as_uri() + "#distance=9&elevation=40"
    command = [str(BROWSER), *flags, profile, "--dump-dom", address]
    seen = subprocess.run(command, check=True, capture_output=True, timeout=120, text=True).stdout
    return json.loads(re.search(r"<pre>(.*?)</pre>", seen, re.DOTALL)[1])


@pytest.mark.skipif(BROWSER is None, reason="no Chromium: apt-get install chromium")
def test_slices_give_what_one_draw_gives(seen, tmp_path):
    found = found_in_browser(
        seen,
        tmp_path,
        f"""
        draw(true);
        const whole = copied();
        {_SLOW}
        found.first = (go(), prepare(), paintAll(), same(copied(), whole));
        while (unfinished()) go();
        prepare();
        paintAll();
        Object.assign(found, {{ slices: layer.slices, portions: pieces.length, last: same(copied(), whole) }});
        found.colours = new Set(new Uint32Array(whole.buffer)).size;""",
    )
    assert found["slices"] == found["portions"] > 5
    assert found["last"]
    assert not found["first"]
    assert found["colours"] > 300


@pytest.mark.skipif(BROWSER is None, reason="no Chromium: apt-get install chromium")
def test_a_drag_ends_the_slices_and_rest_goes_on_with_them(seen, tmp_path):
    found = found_in_browser(
        seen,
        tmp_path,
        f"""
        const frames = [];
        requestAnimationFrame = (next) => frames.push(next);  // frame by frame, as told
        const frame_ = () => frames.shift()();
        waiting = false;
        {_SLOW}
        go();
        const width = canvas.width, before = {{ key: layer.key, next: layer.next, asked: frames.length }};
        dragged("pointerdown", 100); dragged("pointermove", 160); dragged("pointermove", 190);
        found.asked = [before.asked, frames.length];
        frame_();
        Object.assign(found, {{ before: before.next, other: layer.key !== before.key, moving: layer.next }});
        Object.assign(found, {{ coarse: layer.width < width, quiet: frames.length === 0 }});
        found.portions = pieces.length;
        moving = false;
        drawSoon();
        for (let k = 0; frames.length && k < 1000; k++) frame_();
        found.drawn = [layer.next, layer.chosen.length, layer.width - width];
        const rested = copied();
        layer.key = "";
        draw(true);
        found.same = same(rested, copied());""",
    )
    assert found["before"] == 1
    assert found["asked"] == [1, 1]
    assert found["other"]
    assert found["coarse"]
    assert found["quiet"]
    assert found["moving"] < found["portions"] == found["drawn"][0] == found["drawn"][1]
    assert found["drawn"][2] == 0
    assert found["same"]


@pytest.mark.skipif(BROWSER is None, reason="no Chromium: apt-get install chromium")
def test_a_click_names_bodies_without_drawing_their_parts_again(seen, tmp_path):
    found = found_in_browser(
        seen,
        tmp_path,
        """
        draw(true);
        const before = copied();
        drawPieces = () => { found.again = true; };
        const named = (_, k) => nameAt(10 * (k % 40) + 3, 10 * Math.floor(k / 40) + 5);
        found.names = [...new Set(Array.from({ length: 1200 }, named))];
        found.kept = same(before, copied());""",
    )
    assert {"camera", "map", ""} <= set(found["names"])
    assert "again" not in found
    assert found["kept"]
