"""The octomap of MoveIt's planning scenes: read as MoveIt reads it, under MoveIt's name for it.

Messages are written here as OctoMap writes them, node by node (OcTreeBaseImpl.hxx `writeNodesRecurs`,
OccupancyOcTreeBase.hxx `writeBinaryNode`), not by the library.
"""

import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from moveit_messages import MAP, OFFSET, STATE, fixed, pose_node, se3
from poses import at

import plannercheck as pc

RESOLUTION = 0.1
RNG = np.random.default_rng(3)
# Cells of one step about the origin, and whether they are occupied.
KEYS, IS_FULL = RNG.integers(-6, 6, (60, 3)), RNG.random(60) < 0.6
CELLS = {tuple(key): full for key, full in zip(KEYS.tolist(), IS_FULL.tolist(), strict=True)}
FREE, OCCUPIED = -0.4, 0.85
Cells = dict[tuple[int, ...], bool]


def halves(cells: Cells, low: tuple[int, ...], size: int) -> list[tuple[tuple[int, ...], Cells]]:
    """The eight children of a node: their low corners, and the cells in each."""
    found = []
    for child in range(8):
        corner = tuple(low[axis] + size // 2 * (child >> axis & 1) for axis in range(3))
        inside = {
            key: full for key, full in cells.items() if all(0 <= key[k] - corner[k] < size // 2 for k in range(3))
        }
        found.append((corner, inside))
    return found


def full_data(cells: Cells, low: tuple[int, ...] = (-32768,) * 3, size: int = 65536) -> bytes:
    if size == 1:
        return struct.pack("<fB", OCCUPIED if cells[low] else FREE, 0)
    children = halves(cells, low, size)
    mask = sum(1 << k for k, (_, inside) in enumerate(children) if inside)
    own = OCCUPIED if any(cells.values()) else FREE
    below = b"".join(full_data(inside, corner, size // 2) for corner, inside in children if inside)
    return struct.pack("<fB", own, mask) + below


def binary_data(cells: Cells, low: tuple[int, ...] = (-32768,) * 3, size: int = 65536) -> bytes:
    children = halves(cells, low, size)
    word, below = 0, b""
    for k, (corner, inside) in enumerate(children):
        if inside and size > 2:
            word |= 3 << 2 * k
            below += binary_data(inside, corner, size // 2)
        elif inside:
            word |= (2 if inside[corner] else 1) << 2 * k
    return struct.pack("<H", word) + below


def signed(data: bytes) -> list[int]:
    """As ROS prints int8."""
    return np.frombuffer(data, np.int8).tolist()


def octomap(**more: Any) -> dict[str, Any]:
    tree = {"header": {"frame_id": "ignored"}, "binary": True, "id": "OcTree", "resolution": RESOLUTION}
    tree |= {"data": signed(binary_data(CELLS))}
    return {"header": {"frame_id": "world"}, "origin": pose_node([0, 0, 0, 0, 0, 0, 1]), "octomap": tree | more}


def loaded(folder: Path, octomap_: dict[str, Any], **more: Any) -> pc.Scene:
    path = folder / "scene.yaml"
    path.write_text(yaml.safe_dump({"world": {"collision_objects": [], "octomap": octomap_}, **more}))
    return pc.Scene.load(path)


def cells_of(scene: pc.Scene) -> tuple[set[tuple[int, ...]], pc.Octree]:
    (part,) = scene.object("<octomap>").parts
    assert isinstance(part.shape, pc.Octree)
    tree = part.shape
    keys, sizes = tree.cells
    assert (sizes == 1).all()
    return {tuple(key) for key in keys.tolist()}, tree


WANTED = {key for key, full in CELLS.items() if full}


@pytest.mark.parametrize("form", ["binary", "full", "unsigned", "bytes"])
def test_trees_are_read_in_either_form(tmp_path: Path, form: str) -> None:
    data: Any = binary_data(CELLS)
    given = {
        "binary": {"data": signed(data)},
        "full": {"data": signed(full_data(CELLS)), "binary": False},
        "unsigned": {"data": list(data), "binary": 1},
        "bytes": {"data": data},
    }[form]
    found, tree = cells_of(loaded(tmp_path, octomap(**given)))
    assert found == WANTED
    assert tree.resolution == RESOLUTION
    assert tree.unknown == "free"
    assert len(tree.keys) == len(CELLS)


def test_bytes_may_be_hexadecimal(tmp_path: Path) -> None:
    path = tmp_path / "scene.yaml"
    data = binary_data(CELLS)
    content = yaml.safe_dump({"world": {"octomap": octomap(data="DATA")}})
    path.write_text(content.replace("DATA", f"[{', '.join(f'0x{byte:02X}' for byte in data)}]"))
    assert cells_of(pc.Scene.load(path))[0] == WANTED


def test_no_data_is_no_octomap(tmp_path: Path) -> None:
    for empty in ({"data": []}, {"data": None}, {"data": [], "id": "cleared", "resolution": 0.0}):
        assert loaded(tmp_path, octomap(**empty)).object_names == ()
    assert loaded(tmp_path, {}).object_names == ()


def test_it_stands_at_its_origin_in_the_frame_of_the_outer_header(tmp_path: Path) -> None:
    there = {**octomap(), "header": {"frame_id": "map"}, "origin": pose_node(OFFSET)}
    scene = loaded(tmp_path, there, fixed_frame_transforms=[fixed("map", MAP)])
    np.testing.assert_allclose(scene.object("<octomap>").pose, se3(MAP) @ se3(OFFSET), atol=1e-15)
    unset = {**octomap(), "origin": {"position": [0, 0, 0], "orientation": [0, 0, 0, 0]}}
    np.testing.assert_array_equal(loaded(tmp_path, unset).object("<octomap>").pose, np.eye(4))


def test_it_may_stand_in_the_frame_of_a_link_or_an_object(tmp_path: Path) -> None:
    state = {"joint_state": {"name": list(STATE), "position": list(STATE.values())}}
    in_hand = {**octomap(), "header": {"frame_id": "panda_hand"}}
    robot = pc.Robot.load("panda")
    scene = pc.Checker(robot, loaded(tmp_path, in_hand, robot_state=state)).scene
    q = np.array([STATE[name] for name in robot.joint_names])
    np.testing.assert_allclose(
        scene.object("<octomap>").pose, robot.link_poses(q)[robot.link_index("panda_hand")], atol=1e-14
    )
    box = {"id": "table", "header": {"frame_id": "panda_link0"}, "pose": pose_node(OFFSET)}
    box |= {"primitives": [{"type": "box", "dimensions": [1, 1, 1]}], "primitive_poses": [pose_node(MAP)]}
    world = {"collision_objects": [box], "octomap": {**octomap(), "header": {"frame_id": "table"}}}
    (tmp_path / "w.yaml").write_text(yaml.safe_dump(world))
    np.testing.assert_allclose(pc.Scene.load(tmp_path / "w.yaml").object("<octomap>").pose, se3(OFFSET), atol=1e-15)


def test_verdicts_are_those_of_its_boxes(tmp_path: Path) -> None:
    robot = pc.Robot.load("panda")
    scene, boxes = loaded(tmp_path, {**octomap(), "origin": pose_node([0.3, 0, 0.4, 0, 0, 0.6, 0.8])}), pc.Scene()
    for key in WANTED:
        centre = at(*(np.array(key) + 0.5) * RESOLUTION)
        boxes.add_box(f"cell {key}", (RESOLUTION,) * 3, scene.object("<octomap>").pose @ centre)
    q = robot.random_configurations(600, seed=2)
    ours, theirs = (pc.Checker(robot, each).check_states(q) for each in (scene, boxes))
    assert 0.1 < theirs.mean() < 0.9
    assert (ours == theirs).mean() > 0.998  # the boxes' faces are rounded
    padded = pc.Checker(robot, scene, padding={"<octomap>": 0.05})
    assert padded.check_states(q).sum() < ours.sum()


@pytest.mark.filterwarnings("ignore:'panda_link0' of panda, which is fixed")
def test_the_allowed_collision_matrix_knows_its_name(tmp_path: Path) -> None:
    robot = pc.Robot.load("panda")
    q = robot.random_configurations(300, seed=2)
    matrix = {"default_entry_names": ["<octomap>"], "default_entry_values": [True]}
    scene = loaded(tmp_path, octomap(), allowed_collision_matrix=matrix)
    assert np.array_equal(pc.Checker(robot, scene).check_states(q), pc.Checker(robot, pc.Scene()).check_states(q))
    rows = [[False, True], [True, False]]
    named = {"entry_names": ["<octomap>", "panda_link5"], "entry_values": [{"enabled": row} for row in rows]}
    checker = pc.Checker(robot, loaded(tmp_path, octomap(), allowed_collision_matrix=named))
    links = {checker.pair_names(k)[0] for k in range(len(checker.pairs)) if "<octomap>" in checker.pair_names(k)}
    assert "panda_link5" not in links
    assert "panda_link4" in links


def test_a_saved_scene_has_it_and_moveits_text_has_not(tmp_path: Path) -> None:
    scene = loaded(tmp_path, octomap())
    scene.save(tmp_path / "own.yaml")
    assert cells_of(pc.Scene.load(tmp_path / "own.yaml"))[0] == WANTED
    scene.add_box("table", (1, 1, 1))
    with pytest.warns(UserWarning, match="the scene's octomap are not in it"):
        scene.save(tmp_path / "text.scene")
    assert pc.Scene.load(tmp_path / "text.scene").object_names == ("table",)


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"id": "ColorOcTree"}, "id must be 'OcTree', the only type that MoveIt takes, not 'ColorOcTree'"),
        ({"id": ""}, "id must be 'OcTree'"),
        ({"resolution": None}, "'resolution' is missing"),
        ({"resolution": 0.0}, "resolution.* 0.0"),
        ({"binary": "yes"}, "'binary' must be true or false"),
        ({"binary": False}, "its tree"),
        ({"data": signed(binary_data(CELLS))[:-2]}, "its tree is cut short"),
        ({"data": [0, 300]}, "'data' must be bytes, but entry 1 is '300'"),
        ({"data": [0, 1.5]}, "'data' must be bytes, but entry 1 is '1.5'"),
        ({"data": "AAAA"}, "'data' must be a list of bytes"),
        ({"size": 3}, "unknown key 'size'"),
    ],
)
def test_bad_octomaps_are_named(tmp_path: Path, given: dict[str, Any], says: str) -> None:
    with pytest.raises(pc.PlannercheckError, match=rf"^scene file .*scene\.yaml': world: octomap: .*{says}"):
        loaded(tmp_path, octomap(**given))


def test_no_other_object_may_have_its_name(tmp_path: Path) -> None:
    ball = {"id": "<octomap>", "primitives": [{"type": "sphere", "dimensions": [1]}]}
    (tmp_path / "w.yaml").write_text(yaml.safe_dump({"collision_objects": [ball]}))
    with pytest.raises(pc.PlannercheckError, match="'<octomap>': this id is the octomap's, and refused by MoveIt"):
        pc.Scene.load(tmp_path / "w.yaml")
