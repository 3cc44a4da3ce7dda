"""Files as strangers hand them over: of the wrong kind, cut short, of another robot, not fetched, empty.

In: a folder. Out: in it the small arm that commands get else, and `BROKEN`, files by name, none of which is what any
command asks for, unless `FITTING` says for what it is right.
"""

import io
import json
import zipfile
from pathlib import Path

import numpy as np

BOX = '<collision><geometry><box size="0.1 0.1 0.2"/></geometry></collision>'
ARM = (
    f'<robot name="arm"><link name="base">{BOX}</link><link name="tip">{BOX}</link>'
    '<joint name="hinge" type="revolute"><parent link="base"/><child link="tip"/><origin xyz="0 0 0.3"/>'
    '<axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint></robot>'
)
SRDF = '<robot name="arm"><group name="all"><joint name="hinge"/></group></robot>'
SCENE = "objects:\n- {name: crate, box: {size: [1, 1, 1]}, position: [3, 0, 0]}\n"
PLAN = json.dumps({"joint_names": ["hinge"], "path": [[0.0], [0.5]]})
POINTER = "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n"
PNG = b"\x89PNG\r\n\x1a\n" + bytes(40)


def _saved(*arrays: np.ndarray, **named: np.ndarray) -> bytes:
    file = io.BytesIO()
    if arrays:
        np.save(file, *arrays)
    else:
        np.savez(file, **named)
    return file.getvalue()


def _zip() -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("readme.txt", "hello")
    return file.getvalue()


_SUFFIXES = ("urdf", "srdf", "xacro", "yaml", "scene", "npy", "npz", "csv", "parquet", "h5", "json", "proof.json")
_EMPTY = {f"empty.{suffix}": b"" for suffix in _SUFFIXES if suffix != "csv"}  # a csv of no lines is a set of none
_POINTERS = {f"pointer.{suffix}": POINTER.encode() for suffix in _SUFFIXES}

# Files by name.
BROKEN: dict[str, bytes] = {
    **_EMPTY,
    **_POINTERS,
    "cut.urdf": ARM[:150].encode(),
    "cut.srdf": SRDF[:30].encode(),
    "cut.yaml": SCENE[:40].encode(),
    "cut.npy": _saved(np.zeros((50, 1)))[:-30],
    "cut.npz": _saved(q=np.zeros((50, 1)))[:-30],
    "cut.json": PLAN[:20].encode(),
    "tabs.yaml": b"objects:\n\t- name: a\n",
    "list.yaml": b"- 1\n- 2\n",
    "number.yaml": b"3\n",
    "number.json": b"3\n",
    "list.json": b"[1, 2]\n",
    "binary.yaml": PNG,
    "picture.urdf": PNG,
    "picture.npy": PNG,
    "picture.csv": PNG,
    "picture.json": PNG,
    "picture.png": PNG,
    "page.urdf": b"<html><body>404</body></html>",
    "model.sdf": b'<sdf version="1.6"><model name="m"><link name="a"/></model></sdf>',
    "model.xml": b'<mujoco model="m"><worldbody><geom type="box"/></worldbody></mujoco>',
    "sdf_as.urdf": b'<sdf version="1.6"><model name="m"><link name="a"/></model></sdf>',
    "mjcf_as.urdf": b'<mujoco model="m"><worldbody><geom type="box"/></worldbody></mujoco>',
    "srdf_as.urdf": SRDF.encode(),
    "scene_as.urdf": SCENE.encode(),
    "urdf_as.srdf": ARM.encode(),
    "urdf_as.yaml": ARM.encode(),
    "xacro_as.urdf": b'<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arm side="left"/></robot>',
    "broken.urdf.xacro": b'<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arm/></robot>',
    "zip.npz": _zip(),
    "zip.urdf": _zip(),
    "npz.npy": _saved(q=np.zeros((3, 1))),
    "npy.npz": _saved(np.zeros((3, 1))),
    "texts.npy": _saved(np.array([["a"]])),
    "wide.npy": _saved(np.zeros((3, 9))),
    "deep.npy": _saved(np.zeros((2, 2, 2))),
    "nan.npy": _saved(np.array([[0.0], [np.nan]])),
    "words.csv": b"hello\nworld\n",
    "wide.csv": b"0,0,0\n0,0,0\n",
    "semicolons.csv": b"0,1;0,2\n",
    "other_joint.csv": b"elbow\n0.1\n",
    "text.txt": b"hello\n",
    "no_suffix": b"hello\n",
    "other.json": b'{"name": "x"}',
    "other_joints.json": json.dumps({"joint_names": ["elbow"], "path": [[0.0], [0.5]]}).encode(),
    "meshless.urdf": ARM.replace(BOX, BOX.replace('<box size="0.1 0.1 0.2"/>', '<mesh filename="no.stl"/>')).encode(),
    "lost_package.urdf": ARM.replace('<box size="0.1 0.1 0.2"/>', '<mesh filename="package://no/m.stl"/>').encode(),
    "rootless.urdf": ARM.replace('<parent link="base"/>', '<parent link="bsae"/>').encode(),
    "nameless.urdf": ARM.replace(' name="arm"', "").encode(),
    "words.urdf": ARM.replace("0.1 0.1 0.2", "big").encode(),
    "twice.urdf": ARM.replace('link name="tip"', 'link name="base"').encode(),
}


# For what files are right that are wrong for all else: by name, what stands before them.
FITTING: dict[str, tuple[str, ...]] = {
    "list.json": ("--path",),
    "srdf_as.urdf": ("--srdf",),
    "scene_as.urdf": ("--scene",),
}


def commands(file: str) -> list[list[str]]:
    """Every command with the file in every place that takes one, all else in order."""
    robot, scene = ["--robot", "arm.urdf"], ["--scene", "cell.yaml"]
    states = ["--states", "20"]
    return [
        ["validate", "--robot", file, "q.npy"],
        ["validate", *robot, "--srdf", file, "q.npy"],
        ["validate", *robot, "--scene", file, "q.npy"],
        ["validate", *robot, file],
        ["validate", *robot, "--path", file],
        ["plan", "--robot", file, *scene, "--start", "0", "--goal", "1"],
        ["plan", *robot, "--srdf", file, *scene, "--start", "0", "--goal", "1"],
        ["plan", *robot, "--scene", file, "--start", "0", "--goal", "1", "--seed", "1"],
        ["plan", *robot, "--problems", file],
        ["verify", file],
        ["verify", "sound.proof.json", "--robot", file],
        ["verify", "sound.proof.json", *robot, "--scene", file],
        ["view", "--robot", file, "--q", "0", "--html", "page.html"],
        ["view", *robot, "--scene", file, "--q", "0", "--html", "page.html"],
        ["view", *robot, file, "--html", "page.html"],
        ["view", *robot, "--path", file, "--html", "page.html"],
        ["robots", file],
        ["stress", "--case", file],
        ["acm", "--robot", file, *states],
        ["acm", *robot, "--srdf", file, *states],
        ["inspect", "--robot", file, *states],
        ["inspect", *robot, "--srdf", file, *states],
        ["inspect", *robot, "--scene", file, *states],
        ["bench", "states", "--robot", file, "--scene", "none", *states],
        ["bench", "states", *robot, "--scene", file, *states],
    ]


def write_all(folder: Path) -> None:
    """Writes the broken files, and beside them what is in order: arm.urdf, cell.yaml, q.npy and sound.proof.json."""
    from plannercheck.cli.main import main

    for name, content in BROKEN.items():
        (folder / name).write_bytes(content)
    (folder / "folder").mkdir()
    (folder / "arm.urdf").write_text(ARM)
    (folder / "cell.yaml").write_text(SCENE)
    (folder / "plan.json").write_text(PLAN)
    np.save(folder / "q.npy", np.zeros((3, 1)))
    place = ["--robot", str(folder / "arm.urdf"), "--scene", str(folder / "cell.yaml")]
    main(
        [
            "validate",
            *place,
            "--path",
            str(folder / "plan.json"),
            "--certify",
            "--proof",
            str(folder / "sound.proof.json"),
        ]
    )
