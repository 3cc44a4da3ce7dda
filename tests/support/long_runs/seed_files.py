"""Sound files of every format that plannercheck reads, to be mutated.

In: a folder. Out: the files in it, in a folder each for every loader. Robots are small, so that an input takes
milliseconds; texts use every key of their formats.
"""

import json
import shutil
import tarfile
from pathlib import Path

import h5py
import numpy as np
import pyarrow.parquet
import yaml
from bags import bag_of, message_of
from rosbags.rosbag2 import StoragePlugin
from sensed_files import FOLDER as SENSED_FILES

import plannercheck as pc
from plannercheck.common.package_data import shipped_folder
from plannercheck.evaluation.campaign.cases import save
from plannercheck.evaluation.campaign.pairs import PairCase
from plannercheck.evaluation.stress.sample_bodies import Specimen
from plannercheck.ompl.plans import Plan
from plannercheck.proofs.files import save_proofs
from plannercheck.scenes.scene import shipped_scenes

JOINTS = ("a", "b", "c")
ARM = ("panda_joint1", "panda_joint2", "panda_joint3")
URDF = """<?xml version="1.0" encoding="utf-8"?>
<robot name="r"><link name="a"><collision><origin xyz="0 0 0.1" rpy="0 0 0.2"/><geometry><box size="1 2 3"/>
</geometry></collision></link><link name="b"><collision><geometry><cylinder radius="0.1" length="0.4"/></geometry>
</collision><collision><geometry><sphere radius="0.2"/></geometry></collision></link>
<link name="c"><collision><geometry><mesh filename="part.stl" scale="0.1 0.1 0.1"/></geometry></collision></link>
<joint name="j" type="revolute"><parent link="a"/><child link="b"/><origin xyz="0 0 1" rpy="0 1 0"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="k" type="prismatic"><parent link="b"/><child link="c"/><origin xyz="2 0 0"/><axis xyz="1 0 0"/>
<limit lower="0" upper="1" effort="1" velocity="1"/><mimic joint="j" multiplier="0.5" offset="0.1"/></joint></robot>
"""
SRDF = """<?xml version="1.0"?>
<robot name="r"><group name="h"><joint name="j"/></group><group name="g"><group name="h"/><joint name="k"/></group>
<group name="chain"><chain base_link="a" tip_link="c"/></group>
<group_state name="home" group="g"><joint name="j" value="0.5"/></group_state>
<virtual_joint name="v" type="fixed" parent_frame="world" child_link="a"/>
<disable_collisions link1="a" link2="b" reason="Adjacent"/></robot>
"""
ROBOT = """name: r
urdf: r.urdf
srdf: r.srdf
package_dirs: [.]
floating: false
group: {name: arm, joints: [j]}
reference: {j: 0.5}
held: {k: 0.35}
disabled_pairs:
  - reason: adjacent
    pairs: [[a, b], [b, c]]
"""
MOVEIT = """name: s
robot_model_name: r
robot_state:
  is_diff: true
  joint_state: {name: [j], position: [0.25]}
  attached_collision_objects:
    - link_name: b
      touch_links: [b, c]
      object:
        id: held
        header: {frame_id: b}
        pose: {position: {x: 0.1, y: 0, z: 0}, orientation: {x: 0, y: 0, z: 0, w: 1}}
        primitives: [{type: sphere, dimensions: [0.05]}]
        primitive_poses: [{position: [0, 0, 0.1], orientation: [0, 0, 0, 1]}]
fixed_frame_transforms:
  - {child_frame_id: base, header: {frame_id: world}, transform: {translation: [1.0, 0, 0], rotation: [0, 0, 0, 1]}}
link_padding: [{link_name: b, padding: 0.01}]
link_scale: [{link_name: b, scale: 1.0}]
world:
  collision_objects:
    - id: can
      header: {frame_id: base}
      operation: 0
      subframe_names: [tip]
      subframe_poses: [{position: [0, 0, 1], orientation: [0, 0, 0, 1]}]
      primitives: [{type: cylinder, dimensions: [0.14, 0.03]}, {type: 1, dimensions: [1, 2, 3]}]
      primitive_poses:
        - {position: [0.25, -1.07, 0.3], orientation: [0, 0, -0.5, 0.8660254037844386]}
        - {position: {x: 1, y: 2, z: 3}, orientation: {x: 0, y: 0, z: 0, w: 1}}
      meshes:
        - vertices: [{x: 0, y: 0, z: 0}, {x: 1, y: 0, z: 0}, {x: 0, y: 1, z: 0}, {x: 0, y: 0, z: 1}]
          triangles: [{vertex_indices: [0, 2, 1]}, {vertex_indices: [0, 1, 3]}, [0, 3, 2], [1, 2, 3]]
      mesh_poses: [{position: [0, 0, 0], orientation: [0, 0, 0, 1]}]
"""
ARRAYS = """name: s
objects: [{name: a, hull: {file: hull.npy}, position: [1, 0, 0]}]
states: {panda: {samples: samples.npy}}
"""
MATRIX = """world:
  collision_objects:
    - {id: can, primitives: [{type: sphere, dimensions: [1]}], primitive_poses: [{position: [0, 0, 1]}]}
    - {id: shelf, primitives: [{type: sphere, dimensions: [1]}], primitive_poses: [{position: [0, 0, 2]}]}
allowed_collision_matrix:
  entry_names: [can, hand, shelf]
  entry_values: [[false, true, true], [true, false, false], {enabled: [true, false, false]}]
  default_entry_names: [floor]
  default_entry_values: [true]
"""
REQUEST = """start_state:
  joint_state: {name: [j, k], position: [0.1, 0.5]}
  attached_collision_objects: []
goal_constraints:
  - joint_constraints: [{joint_name: j, position: 0.3, tolerance_above: 0.001, tolerance_below: 0.001}]
group_name: arm
workspace_parameters: {min_corner: [-1, -1, -1], max_corner: [1, 1, 1]}
"""
POSE_REQUEST = """start_state:
  joint_state: {name: [j, k], position: [0.1, 0.5]}
goal_constraints:
  - position_constraints:
      - header: {frame_id: base}
        link_name: b
        target_point_offset: {x: 0, y: 0, z: 0.1}
        constraint_region:
          primitives: [{type: 2, dimensions: [0.001]}]
          primitive_poses: [{position: {x: 0.5, y: 0, z: 1}, orientation: {x: 0, y: 0, z: 0, w: 0}}]
        weight: 1.0
    orientation_constraints:
      - header: {frame_id: base}
        link_name: b
        orientation: {x: 0, y: 0, z: 0.6, w: 0.8}
        absolute_x_axis_tolerance: 0.01
        weight: 1.0
  - joint_constraints: [{joint_name: j, position: 0.3}, {joint_name: k, position: 0.1}]
group_name: arm
"""
WORLD = """collision_objects:
  - id: can
    pose: {position: {x: 0.1, y: 0, z: 0}, orientation: {x: 0, y: 0, z: 0, w: 1}}
    primitives: [{type: 3, dimensions: [0.14, 0.03]}, {type: sphere, dimensions: [0.1]}]
    primitive_poses: [{position: [0, 0, 1], orientation: [0, 0, 0, 1]}, {position: [0, 0, 0]}]
    operation: 0
octomap: {header: {frame_id: ''}, octomap: {data: []}}
---
"""
OBJECT = """id: can
header: {frame_id: world}
meshes: [{vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], triangles: [[0, 2, 1], [1, 2, 3]]}]
mesh_poses: [{position: [0, 0, 1], orientation: [0, 0, 0, 1]}]
subframe_names: [tip]
subframe_poses: [{position: [0, 0, 1], orientation: [0, 0, 0, 1]}]
"""
SCENE_TEXT = """(noname)
* Box on the left
1 2 3
0 0 0.6 0.8
3
box
0.1 0.2 0.3
0.5 0 0
0.6 0 0 0.8
0 0 0 0
cylinder
0.03 0.14
0 0 1e-3
0 0 0 1
0.5 0.5 0.5 1
mesh
4 4
0 0 0
1 0 0
0 1 0
0 0 1
0 2 1
0 1 3
0 3 2
1 2 3
0 0 -1
0 0 0 1
0 0 0 0
1
tip
0 0 0.5
0 0 0 1
* can
0 0 0
0 0 0 1
1
cone
0.1 0.2
0 0 0
0 0 0 1
0 0 0 0
0
.
"""
OLD_SCENE_TEXT = """old
* foo
2
sphere
0.77
0 0 0.025
0 0 0 1
0.82 0.75 0.60 1
box
.77 0.39 0.05
0 0 1.445
0 0 0 1
0 0 0 0
.
"""
OMPL_PATH = "Geometric path with 2 states\nRealVectorState [0.1 0.2 0.3]\nRealVectorState [0.5 0.2 -0.3]\n"
CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
TRIANGLES = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))


def make(folder: Path) -> None:
    """Writes all files."""
    rng = np.random.default_rng(0)
    for part in (_robots, _scenes, _paths, _trajectories, _proofs, _bodies, _configurations, _meshes, _sensed):
        part(_Files(folder), rng)


class _Files:
    """Files by the loader that reads them."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def of(self, loader: str, name: str, content: str | bytes = b"") -> Path:
        """The path of a loader's file, with this content."""
        path = self.folder / loader / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return path


def _robots(files: _Files, rng: np.random.Generator) -> None:
    for loader in ("urdf", "srdf", "robot_yaml", "urdf_of_proof"):
        files.of(loader, "r.urdf", URDF)
        files.of(loader, "r.srdf", SRDF)
        files.of(loader, "r.yaml", ROBOT)
        files.of(loader, "part.stl", _stl())
    for name in ("forklift", "truck_trailer"):
        files.of("planar_robot", f"{name}.yaml", (shipped_folder("robots") / f"{name}.yaml").read_bytes())


def _scenes(files: _Files, rng: np.random.Generator) -> None:
    for name in shipped_scenes():
        files.of("scene_yaml", f"{name}.yaml", (shipped_folder("configs") / f"{name}.yaml").read_bytes())
    for name in ("parking", "warehouse"):
        files.of("planar_scene", f"{name}.yaml", (shipped_folder("configs") / f"{name}.yaml").read_bytes())
    for sample in shipped_folder("configs").glob("*.npy"):
        shutil.copy(sample, files.of("planar_scene" if "fork" in sample.name else "scene_yaml", sample.name))
    files.of("scene_arrays", "s.yaml", ARRAYS)
    np.save(files.of("scene_arrays", "hull.npy"), rng.normal(size=(8, 3)))
    np.save(files.of("scene_arrays", "samples.npy"), rng.normal(size=(8, 7)))
    files.of("moveit_scene", "s.yaml", MOVEIT)
    files.of("moveit_world", "w.yaml", WORLD)
    files.of("moveit_world", "o.yaml", OBJECT)
    files.of("scene_text", "new.scene", SCENE_TEXT)
    files.of("scene_text", "old.scene", OLD_SCENE_TEXT)
    files.of("moveit_request", "r.yaml", REQUEST)
    files.of("pose_request", "r.yaml", POSE_REQUEST)
    files.of("collision_matrix", "s.yaml", MATRIX)
    for kind in ("problem_folder", "problem_archive"):
        members = {"scene0001.yaml": MOVEIT, "request0001.yaml": REQUEST}
        paths = [files.of(kind, f"set/{name}", text) for name, text in members.items()]
    for mode in ("", "gz", "bz2", "xz"):
        with tarfile.open(files.of("problem_archive", f"set.tar.{mode}".rstrip(".")), f"w:{mode}") as archive:  # type: ignore[call-overload]
            for path in paths:
                archive.add(path, f"set/{path.name}")
    shutil.rmtree(files.folder / "problem_archive" / "set")


def _paths(files: _Files, rng: np.random.Generator) -> None:
    states = rng.normal(size=(4, 3))
    plan = Plan(True, states, 1.0, 0.1, 0.1, "RRT", joint_names=JOINTS)
    for name in ("plan.json", "plan.npy", "plan.csv"):
        plan.save(files.of("path", name))
    plan.save(files.of("plan", "plan.json"))
    files.of("path", "list.json", json.dumps(states.tolist()))
    files.of("path", "ompl.path", OMPL_PATH)
    files.of("path", "table.txt", "\n".join(" ".join(map(repr, row)) for row in states.tolist()))
    points = [{"positions": row, "velocities": [0, 0, 0], "time_from_start": {"secs": 1}} for row in states.tolist()]
    joint = {"joint_trajectory": {"header": {"frame_id": ""}, "joint_names": list(JOINTS), "points": points}}
    state = {"joint_state": {"name": ["d"], "position": [1.0]}}
    for name, document in (
        ("robot", {**joint, "multi_dof_joint_trajectory": {"joint_names": []}}),
        ("display", {"model_id": "r", "trajectory": [joint, joint], "trajectory_start": state}),
    ):
        files.of("trajectory", f"{name}.json", json.dumps(document))
        files.of("trajectory", f"{name}.yaml", yaml.safe_dump(document))


def _trajectories(files: _Files, rng: np.random.Generator) -> None:
    times, q = np.array([0.0, 0.5, 2.0]), rng.normal(size=(3, 3))
    made = pc.Trajectory(times, q, 0 * q, 0 * q, joint_names=ARM)
    for name in ("t.json", "t.yaml"):
        made.save(files.of("timed", name))
    header = ["time", *ARM, *(f"{name}.velocity" for name in ARM)]
    rows = np.column_stack([times, q, 0 * q]).tolist()
    files.of("timed", "t.csv", "\n".join([",".join(header), *(",".join(map(repr, row)) for row in rows)]))
    np.savez(files.of("timed_npz", "t.npz"), times=times, positions=q, velocities=0 * q, joint_names=ARM)
    for storage in StoragePlugin:
        bag = bag_of(files.folder / f"made_{storage.name}", storage, message_of(made))
        file = next(path for path in bag.iterdir() if path.suffix != ".yaml")
        files.of("bag", f"t{file.suffix}", file.read_bytes())
    limits = "{has_velocity_limits: true, max_velocity: 1.5, has_acceleration_limits: false}"
    files.of("joint_limits", "joint_limits.yaml", f"joint_limits:\n  {ARM[0]}: {limits}\n  {ARM[2]}: {limits}\n")


def _proofs(files: _Files, rng: np.random.Generator) -> None:
    robot = pc.Robot.from_urdf(files.folder / "urdf" / "r.urdf")
    scene = pc.Scene("s")
    scene.add_box("box", [0.1, 0.1, 0.1], np.block([[np.eye(3), np.full((3, 1), 5.0)], [np.zeros((1, 3)), 1.0]]))
    q = robot.reference
    proofs = pc.Checker(robot, scene).certify_motions(q, q + 0.01)
    planar = pc.planar.Checker(pc.planar.Robot([[-0.5, -0.3], [0.5, -0.3], [0.5, 0.3], [-0.5, 0.3]]), _one_box())
    in_plane = planar.certify_motions(np.zeros((1, 3)), np.full((1, 3), 0.1))
    for loader in ("json", "npz"):
        for name, found in (("space", proofs), ("plane", in_plane)):
            save_proofs(
                [proof for proof in found if proof is not None], files.of(f"proof_{loader}", f"{name}.{loader}")
            )


def _one_box() -> pc.planar.Scene:
    scene = pc.planar.Scene("s")
    scene.add_box("box", [0.4, 0.4], np.array([[1.0, 0, 3], [0, 1, 3], [0, 0, 1]]))
    return scene


def _bodies(files: _Files, rng: np.random.Generator) -> None:
    for k, inflation_radius in enumerate((0.0, 0.1)):
        pc.Polytope(rng.normal(size=(12, 3)), inflation_radius=inflation_radius).save(files.of("body", f"{k}.body"))
        data = pc.Polytope(rng.normal(size=(12, 3)), inflation_radius=inflation_radius).core.serialise()
        files.of("pickled_body", f"{k}.bin", data)
    case = PairCase("c", Specimen("p", CORNERS), Specimen("r", CORNERS, 0.1), np.eye(4), np.eye(4))
    save(files.of("stress_case", "pair.json"), "pairs", case.document())
    motion = next(
        iter(sorted((Path(__file__).parents[2] / "evaluation" / "hard_cases" / "motions").glob("*.json"))), None
    )
    if motion is not None:
        files.of("stress_motion", "motion.json", motion.read_bytes())


def _configurations(files: _Files, rng: np.random.Generator) -> None:
    rows = rng.normal(size=(5, 3))
    table = pyarrow.table(dict(zip(JOINTS, rows.T, strict=True)))
    text = ",".join(JOINTS) + "\n" + "\n".join(",".join(map(repr, row)) for row in rows.tolist()) + "\n"
    np.save(files.of("npy", "q.npy"), rows)
    np.save(files.of("npy", "turned.npy"), np.asfortranarray(rows.astype(np.float32)))
    np.save(files.of("npy_stream", "q.npy"), rows)
    np.savez(files.of("npz", "q.npz"), q=rows)
    np.savez_compressed(files.of("npz", "small.npz"), q=rows)
    for loader, name in (("csv", "q.csv"), ("csv", "q.tsv"), ("csv_stream", "q.csv")):
        files.of(loader, name, text.replace(",", "\t") if name.endswith("tsv") else text)
    pyarrow.parquet.write_table(table, files.of("parquet", "q.parquet"))
    lists = pyarrow.table({"q": pyarrow.array(rows.tolist())})
    pyarrow.parquet.write_table(lists, files.of("parquet", "lists.parquet"), compression="gzip")
    with h5py.File(files.of("hdf5", "q.h5"), "w") as file:
        file["q"] = rows
    with h5py.File(files.of("hdf5", "columns.hdf5"), "w") as file:
        for name, column in zip(JOINTS, rows.T, strict=True):
            file.create_dataset(name, data=column, compression="gzip")


def _meshes(files: _Files, rng: np.random.Generator) -> None:
    files.of("stl", "text.stl", _stl())
    data = np.zeros(len(TRIANGLES), dtype=[("n", "<f4", 3), ("p", "<f4", (3, 3)), ("a", "<u2")])
    data["p"] = CORNERS[np.array(TRIANGLES)]
    files.of("stl", "bytes.stl", bytes(80) + np.uint32(len(data)).tobytes() + data.tobytes())
    corners = "".join(f"v {x} {y} {z}\n" for x, y, z in CORNERS.tolist())
    faces = "".join("f " + " ".join(str(k + 1) for k in face) + "\n" for face in TRIANGLES)
    files.of("obj", "a.obj", f"o thing\nvn 0 0 1\nvt 0 0\n{corners}usemtl m\n{faces}")
    head = "ply\nformat {} 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    head += "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
    body = "".join(f"{x} {y} {z}\n" for x, y, z in CORNERS.tolist())
    body += "".join("3 {} {} {}\n".format(*face) for face in TRIANGLES)
    files.of("ply", "text.ply", head.format("ascii") + body)
    faces_in_bytes = b"".join(b"\x03" + np.array(face, dtype="<i4").tobytes() for face in TRIANGLES)
    files.of(
        "ply",
        "bytes.ply",
        head.format("binary_little_endian").encode() + CORNERS.astype("<f4").tobytes() + faces_in_bytes,
    )
    files.of("dae", "a.dae", _dae())


def _sensed(files: _Files, rng: np.random.Generator) -> None:
    for path in sorted(SENSED_FILES.iterdir()):
        loader = {".bt": "octomap", ".ot": "octomap", ".pcd": "cloud", ".ply": "cloud", ".xyz": "cloud"}.get(
            path.suffix
        )
        if loader and path.stat().st_size < 1000:
            files.of(loader, path.name, path.read_bytes())
    points = rng.normal(size=(5, 3))
    np.save(files.of("cloud", "c.npy"), points.astype(np.float32))
    np.savez_compressed(files.of("cloud", "c.npz"), points=points)
    np.save(files.of("voxels", "v.npy"), rng.integers(2, size=(3, 4, 5)).astype(np.uint8))
    np.save(files.of("heights", "h.npy"), rng.uniform(0, 1, size=(4, 3)))


def _stl() -> str:
    facets = "".join(
        "facet normal 0 0 1\nouter loop\n"
        + "".join("vertex {} {} {}\n".format(*CORNERS[k]) for k in face)
        + "endloop\nendfacet\n"
        for face in TRIANGLES
    )
    return f"solid thing\n{facets}endsolid thing\n"


def _dae() -> str:
    places = " ".join(map(str, CORNERS.ravel()))
    corners = " ".join(str(k) for face in TRIANGLES for k in face)
    return f"""<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="meter" meter="1"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g" name="g"><mesh>
<source id="p"><float_array id="pa" count="12">{places}</float_array><technique_common>
<accessor source="#pa" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/><p>{corners}</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><matrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</matrix>
<instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>
"""
