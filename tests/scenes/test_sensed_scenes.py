"""Clouds, octrees, voxel grids and height fields in scene files: read, refused, and written back."""

import shutil
from pathlib import Path

import numpy as np
import pytest
import yaml

import plannercheck as pc
from plannercheck.bodies.part_sets import PartSet
from plannercheck.common.atomic_files import write_atomically
from plannercheck.scenes.scene_table import scene_html
from plannercheck.scenes.sensed_shapes import sensed_kind

RNG = np.random.default_rng(5)
POINTS = RNG.normal(size=(40, 3))
OCCUPIED = RNG.random((3, 4, 5)) < 0.4
HEIGHTS = RNG.uniform(0.0, 0.3, size=(4, 6))
KEYS = np.unique(RNG.integers(-5, 5, size=(20, 3)), axis=0)
RADII = RNG.uniform(0.01, 0.1, size=len(POINTS))
IS_FULL = RNG.random(len(KEYS)) < 0.5
POSE = np.array([[0.8, -0.6, 0, 0.1], [0.6, 0.8, 0, 0.2], [0, 0, 1, 0.3], [0, 0, 0, 1.0]])


def shapes() -> dict[str, PartSet]:
    dropped = POINTS.copy()
    dropped[[0, 7, 8]] = np.nan
    holes = HEIGHTS.copy()
    holes[1, 2] = np.nan
    return {
        "cloud": pc.PointCloud(POINTS, 0.1 / 3),
        "radii": pc.PointCloud(POINTS, RADII),
        "dropped": pc.PointCloud(dropped, RADII, invalid="drop"),
        "dropping": pc.PointCloud(POINTS, 0.01, invalid="drop"),
        "thinned": pc.PointCloud(np.repeat(POINTS, 2, axis=0), 0.02).without_covered(),
        "no return": pc.PointCloud(np.zeros((0, 3)), 0.01),
        "map": pc.Octree.from_cells(KEYS, 0.1 / 3, occupied=IS_FULL),
        "unknown/map": pc.Octree.from_cells(KEYS, 0.05, unknown="occupied"),
        "no map": pc.Octree.from_cells(np.zeros((0, 3), dtype=int), 0.05),
        "grid": pc.VoxelGrid(OCCUPIED, 0.1 / 3, (0.1, 0.2, 0.7)),
        "ground": pc.HeightField(holes, (0.1 / 3, 0.2), -1.0, (0.3, 0.1)),
    }


def shape_of(scene: pc.Scene, name: str) -> PartSet:
    (part,) = scene.object(name).parts
    assert isinstance(part.shape, PartSet)
    return part.shape


def written(folder: Path, **given: object) -> Path:
    path = folder / "scene.yaml"
    path.write_text(yaml.safe_dump({"objects": [{"name": "it", **given}]}))
    return path


@pytest.mark.parametrize("name", shapes())
def test_a_saved_shape_is_read_back(tmp_path: Path, name: str) -> None:
    scene, shape = pc.Scene("kitchen"), shapes()[name]
    scene.add(name, shape, POSE)
    scene.save(tmp_path / "kitchen.yaml")
    again = pc.Scene.load(tmp_path / "kitchen.yaml")
    found = shape_of(again, name)
    assert found.digest == shape.digest
    assert [found.part_name(k) for k in range(found.count)] == [shape.part_name(k) for k in range(shape.count)]
    assert getattr(found, "invalid", "") == ("drop" if name == "thinned" else getattr(shape, "invalid", ""))
    assert np.array_equal(again.object(name).pose, POSE)
    beside = sorted(path.name for path in tmp_path.iterdir())
    assert len(beside) == 2
    assert all(path.startswith("kitchen.") for path in beside)
    again.save(tmp_path / "again.yaml")  # names the file, as for meshes
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([*beside, "again.yaml"])
    assert shape_of(pc.Scene.load(tmp_path / "again.yaml"), name).digest == shape.digest


def test_all_of_a_scene_moves_with_its_folder(tmp_path: Path) -> None:
    scene = pc.Scene("all")
    for name, shape in shapes().items():
        scene.add(name, shape)
    scene.add("two", [pc.Part(shapes()["cloud"], POSE), pc.Part(pc.Box((1, 1, 1)))])
    scene.attach("held", "hand", POSE, ("finger",), shapes()["grid"])
    (tmp_path / "old").mkdir()
    scene.save(tmp_path / "old" / "all.yaml")
    shutil.move(tmp_path / "old", tmp_path / "new")
    found = pc.Scene.load(tmp_path / "new" / "all.yaml")
    assert {name: shape_of(found, name).digest for name in shapes()} == {
        name: shape.digest for name, shape in shapes().items()
    }
    assert shape_of(found, "held").digest == shapes()["grid"].digest
    assert found.object("held").touch_links == ("finger",)
    assert [sensed_kind(shape) for shape in shapes().values()] == ["cloud"] * 6 + ["octree"] * 3 + ["voxels"] + [
        "height_field"
    ]
    assert "PointCloud of 40 parts" in scene_html(found)


def test_files_name_clouds(tmp_path: Path) -> None:
    np.save(tmp_path / "points.npy", POINTS)
    np.savetxt(tmp_path / "points.xyz", POINTS, fmt="%.17g")
    np.savez(tmp_path / "all.npz", points=POINTS, radius=0.02)
    np.savez(tmp_path / "points.npz", points=POINTS)
    for file in ("points.npy", "points.xyz", "points.npz"):
        cloud = shape_of(pc.Scene.load(written(tmp_path, cloud={"file": file, "radius": 0.02})), "it")
        assert cloud.digest == pc.PointCloud(POINTS, 0.02).digest
    for given in ("all.npz", {"file": "all.npz"}, {"file": "all.npz", "invalid": "drop"}):
        cloud = shape_of(pc.Scene.load(written(tmp_path, cloud=given)), "it")
        assert cloud.digest == pc.PointCloud(POINTS, 0.02).digest


def test_files_name_maps_grids_and_heights(tmp_path: Path) -> None:
    tree = pc.Octree.from_cells(KEYS, 0.05)
    tree.save(tmp_path / "map.bt")
    np.save(tmp_path / "grid.npy", OCCUPIED)
    np.savez(tmp_path / "grid.npz", occupied=OCCUPIED, resolution=0.05)
    np.save(tmp_path / "heights.npy", HEIGHTS)
    np.savez(tmp_path / "heights.npz", heights=HEIGHTS, base=-1.0)
    grid, field = pc.VoxelGrid(OCCUPIED, 0.05, (1, 2, 3)), pc.HeightField(HEIGHTS, (0.1, 0.2), -1)
    assert shape_of(pc.Scene.load(written(tmp_path, octree="map.bt")), "it").digest == tree.digest
    known = pc.Scene.load(written(tmp_path, octree={"file": "map.bt", "unknown": "occupied", "threshold": 0.6}))
    assert shape_of(known, "it").digest == tree.with_unknown("occupied").digest
    for given in ({"file": "grid.npz"}, {"file": "grid.npy", "resolution": 0.05}):
        found = pc.Scene.load(written(tmp_path, voxels={**given, "origin": [1, 2, 3]}))
        assert shape_of(found, "it").digest == grid.digest
    assert (
        shape_of(pc.Scene.load(written(tmp_path, voxels="grid.npz")), "it").digest
        == pc.VoxelGrid(OCCUPIED, 0.05).digest
    )
    for given in ({"file": "heights.npz"}, {"file": "heights.npy", "base": -1}):
        found = pc.Scene.load(written(tmp_path, height_field={**given, "resolution": [0.1, 0.2]}))
        assert shape_of(found, "it").digest == field.digest


def test_files_are_found_as_those_of_meshes(tmp_path: Path) -> None:
    (tmp_path / "sensors" / "frames").mkdir(parents=True)
    (tmp_path / "sensors" / "package.xml").write_text("<package><name>sensors</name></package>")
    np.savez(tmp_path / "sensors" / "frames" / "a.npz", points=POINTS, radius=0.02)
    for address in ("sensors/frames/a.npz", "package://sensors/frames/a.npz", str(tmp_path / "sensors/frames/a.npz")):
        assert shape_of(pc.Scene.load(written(tmp_path, cloud=address)), "it").count == len(POINTS)


BAD = [
    ({"cloud": "none.npy"}, "'radius' is missing"),
    ({"cloud": {"file": "points.npy", "invalid": "drop"}}, "'radius' is missing; given are file, invalid$"),
    ({"cloud": {"file": "none.npy", "radius": 0.1}}, r"cloud: cloud file .*none\.npy' does not exist"),
    ({"cloud": {"radius": 0.1}}, "cloud: key 'file' is missing"),
    ({"cloud": {"file": "points.npy", "radius": -1}}, "radius of a cloud must be finite and above 0"),
    ({"cloud": {"file": "points.npy", "radius": "thick"}}, "'radius' must be a number"),
    ({"cloud": {"file": "points.npy", "radius": 0.1, "size": 3}}, "unknown key 'size'"),
    ({"cloud": {"file": "points.npy", "radius": 0.1, "invalid": "keep"}}, "unknown choice for invalid points 'keep'"),
    ({"cloud": {"file": "all.npz", "radius": 0.1}}, "has an array 'radius' itself: leave the key out"),
    ({"cloud": {"file": "cut.npz", "radius": 0.1}}, r"cut\.npz' can't be read"),
    ({"cloud": {"file": "nan.npy", "radius": 0.1}}, "row 3 is .*drop"),
    ({"cloud": [1, 2]}, "cloud: it must be a mapping"),
    ({"octree": "none.bt"}, r"octree: octomap file .*none\.bt' does not exist"),
    ({"octree": "points.npy"}, r"octomap file .*points\.npy'"),
    ({"octree": "cut.bt"}, r"octomap file .*cut\.bt': .*cut short"),
    ({"octree": {"file": "map.bt", "unknown": "full"}}, "unknown meaning of unknown space 'full'"),
    ({"octree": {"file": "map.bt", "threshold": [0.5]}}, "'threshold' must be a number"),
    ({"octree": {"file": "map.bt", "threshold": 2}}, "threshold must be a probability"),
    ({"voxels": "points.npy"}, "'resolution' is missing; given are file$"),
    ({"voxels": {"file": "points.npy", "origin": [0, 0, 0]}}, "'resolution' is missing; given are file, origin$"),
    ({"voxels": {"file": "points.npy", "resolution": 0.1}}, "must be truth values of shape"),
    ({"voxels": {"file": "all.npz", "resolution": 0.1}}, "needs an array 'occupied'; its arrays are points, radius"),
    ({"voxels": "odd.npz"}, r"unknown array of file .*odd\.npz' 'Orgin': did you mean 'origin'\?"),
    ({"voxels": {"file": "none.npz", "resolution": 0.1}}, r"voxel file .*none\.npz' does not exist"),
    ({"height_field": {"file": "points.npy", "resolution": 0.1}}, "'base' is missing"),
    ({"height_field": {"file": "points.npy", "resolution": 0, "base": -9}}, "resolution of a height field must be"),
    ({"height_field": {"file": "points.npy", "resolution": 1, "base": 9}}, "base of a height field must be at most"),
    ({"height_field": {"file": "pickled.npy", "resolution": 1, "base": 9}}, r"height file .*pickled\.npy' can't be"),
    ({"cloud": "all.npz", "octree": "map.bt"}, "exactly one of the keys .*; given are cloud and octree"),
]


@pytest.mark.parametrize(("given", "says"), BAD)
def test_bad_files_and_keys_are_named(tmp_path: Path, given: dict[str, object], says: str) -> None:
    np.save(tmp_path / "points.npy", POINTS)
    np.save(tmp_path / "nan.npy", np.where(np.arange(40)[:, None] == 3, np.nan, POINTS))
    np.save(tmp_path / "pickled.npy", np.array([{}, []], dtype=object), allow_pickle=True)
    np.savez(tmp_path / "all.npz", points=POINTS, radius=0.02)
    np.savez(tmp_path / "odd.npz", occupied=OCCUPIED, resolution=0.05, Orgin=np.ones(3), stamp=1)
    (tmp_path / "cut.npz").write_bytes((tmp_path / "all.npz").read_bytes()[:-200])
    pc.Octree.from_cells(KEYS, 0.05).save(tmp_path / "map.bt")
    (tmp_path / "cut.bt").write_bytes((tmp_path / "map.bt").read_bytes()[:-4])
    with pytest.raises(pc.PlannercheckError, match=rf"^scene file .*scene\.yaml': object 'it': .*{says}"):
        pc.Scene.load(written(tmp_path, **given))


def test_a_scene_that_can_not_be_written_leaves_what_was_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "scene.yaml"
    scene = pc.Scene("scene")
    scene.add("camera", shapes()["cloud"])
    scene.save(path)
    before = {file.name: file.read_bytes() for file in tmp_path.iterdir()}
    scene.update("camera", POINTS + 1)
    scene.add("map", shapes()["map"])
    scene.save(path)
    assert {name: (tmp_path / name).read_bytes() for name in before if name != "scene.yaml"}.items() <= before.items()

    for name in {file.name for file in tmp_path.iterdir()} - set(before):
        (tmp_path / name).unlink()
    path.write_bytes(before["scene.yaml"])
    written_files = 0

    def fails_at_last(target: Path, *given: object) -> None:
        nonlocal written_files
        written_files += 1
        if target.suffix == ".bt":
            raise pc.PlannercheckError(f"file {str(target)!r} can't be written: no space")
        write_atomically(target, *given)  # type: ignore[arg-type]

    monkeypatch.setattr("plannercheck.scenes.files_beside.write_atomically", fails_at_last)
    with pytest.raises(pc.PlannercheckError, match=r"^scene file .*\.bt' can't be written: no space"):
        scene.save(path)
    assert written_files == 2
    assert {file.name: file.read_bytes() for file in tmp_path.iterdir()} == before
    assert shape_of(pc.Scene.load(path), "camera").digest == shapes()["cloud"].digest


def test_a_folder_in_place_of_the_scene_leaves_no_files(tmp_path: Path) -> None:
    scene = pc.Scene()
    scene.add("camera", shapes()["cloud"])
    (tmp_path / "scene.yaml").mkdir()
    with pytest.raises(pc.PlannercheckError, match=r"scene file .*scene\.yaml' can't be written"):
        scene.save(tmp_path / "scene.yaml")
    assert [file.name for file in tmp_path.iterdir()] == ["scene.yaml"]


def test_moveits_text_has_no_clouds(tmp_path: Path) -> None:
    scene = pc.Scene()
    scene.add("camera", shapes()["cloud"])
    with pytest.raises(pc.PlannercheckError, match="object 'camera': MoveIt has no PointCloud"):
        scene.save(tmp_path / "a.scene")
