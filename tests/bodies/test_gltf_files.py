"""glTF files against what the format defines: nodes, sparse places, modes, and what is refused."""

import struct
from pathlib import Path

import numpy as np
import pytest
import trimesh
from mesh_samples import CORNERS, STRIP, TRIANGLES, assimp, glb, gltf, rows

import plannercheck as pc
from plannercheck.bodies.mesh_files import read_mesh

UPRIGHT = [-0.7071067690849304, 0, 0, 0.7071067690849304]  # single precision


ROOTS = [
    {"translation": [1, 2, 3]},
    {"rotation": UPRIGHT},
    {"rotation": [0.5, 0.5, 0.5, 0.5]},
    {"scale": [0.001, 0.002, 3]},
    {"matrix": [*np.eye(4).ravel()[:12], 7, 8, 9, 1]},
]


@pytest.mark.parametrize("root", ROOTS)
def test_the_root_of_a_gltf_scene(tmp_path: Path, root: dict) -> None:
    """Named case: glb_root.py. Trimesh has the file's own axes; z up is (x, -z, y). Coal leaves out the root."""
    nodes = [{"name": "root", "children": [1], **root}, {"name": "part", "mesh": 0, "translation": [5, 6, 7]}]
    path = tmp_path / "m.glb"
    path.write_bytes(glb(*gltf(CORNERS, TRIANGLES, nodes)))
    theirs = trimesh.load(path, force="scene").to_mesh().vertices
    mesh = read_mesh(path)
    np.testing.assert_allclose(rows(mesh.points), rows(theirs[:, [0, 2, 1]] * [1, -1, 1]), atol=1e-6)
    assert mesh.conversion == (
        "" if root == {"rotation": UPRIGHT} else "its root node has a transform and its y axis is up"
    )
    np.testing.assert_allclose(rows(read_mesh(path, units="metre").points), rows(assimp(path)[0]), atol=1e-6)


def test_sparse_places_of_gltf(tmp_path: Path) -> None:
    file, body = gltf(CORNERS, TRIANGLES, [{"mesh": 0}])
    more = struct.pack("<H2x3f", 1, 9, 8, 7)
    file["bufferViews"] += [{"buffer": 0, "byteOffset": len(body) + a, "byteLength": n} for a, n in ((0, 2), (4, 12))]
    file["buffers"][0]["byteLength"] = len(body) + len(more)
    file["accessors"][0]["sparse"] = {
        "count": 1, "indices": {"bufferView": 2, "componentType": 5123}, "values": {"bufferView": 3}
    }  # fmt: skip
    (tmp_path / "m.glb").write_bytes(glb(file, body + more))
    wanted = CORNERS.astype(np.float32).astype(float)
    wanted[1] = 9, 8, 7
    mesh = read_mesh(tmp_path / "m.glb", units="metre")
    assert mesh.points[mesh.triangles].tolist() == wanted[TRIANGLES].tolist()


@pytest.mark.parametrize(("mode", "triangles"), [(5, STRIP), (6, [[0, 1, 2], [0, 2, 3]]), (4, None)])
def test_modes_of_gltf(tmp_path: Path, mode: int, triangles: list[list[int]] | None) -> None:
    file, body = gltf(CORNERS, np.arange(4), [{"mesh": 0}])
    file["meshes"][0]["primitives"] += [{"attributes": {"POSITION": 0}, "mode": 1}]
    file["meshes"][0]["primitives"][0]["mode"] = mode
    (tmp_path / "m.glb").write_bytes(glb(file, body))
    if triangles is None:
        with pytest.raises(pc.PlannercheckError, match="4 corners"):
            read_mesh(tmp_path / "m.glb")
        return
    mesh = read_mesh(tmp_path / "m.glb", units="metre")
    assert mesh.points[mesh.triangles].tolist() == CORNERS.astype(np.float32)[triangles].tolist()


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"extensionsRequired": ["KHR_draco_mesh_compression"]}, "KHR_draco_mesh_compression"),
        ({"extensionsRequired": ["EXT_meshopt_compression"]}, "EXT_meshopt_compression"),
        ({"scenes": [{"nodes": [0]}, {"nodes": []}], "scene": 1}, "no faces"),
        ({"scenes": [{"nodes": [0]}], "scene": 1}, "no such entry"),
        ({"scenes": []}, "scenes"),
        ({"nodes": [{"mesh": 0, "children": [0]}]}, "two parents"),
        ({"nodes": [{"mesh": 0, "skin": 0}]}, "skeleton"),
        ({"nodes": [{"mesh": 0, "rotation": [0, 0, 0, 0]}]}, "quaternion"),
        ({"nodes": [{"mesh": 0, "rotation": [90, 0, 0, 1]}]}, "quaternion of length 1, not 90.0"),
        ({"nodes": [{"mesh": 1}]}, r"meshes\[1\]"),
        ({"asset": {"version": "1.0"}}, "glTF 2"),
        ({"asset": {"version": "2.1", "minVersion": "2.1"}}, "must be of glTF 2.0, not '2.1'"),
        ({"buffers": [{"byteLength": 9999}]}, "9999"),
        ({"buffers": [{"byteLength": 96, "uri": "gone.bin"}]}, "does not exist"),
        ({"buffers": [{"byteLength": 96, "uri": "data:x;base64,!"}]}, "can't be read"),
    ],
)
def test_what_gltf_files_are_refused_for(tmp_path: Path, more: dict, said: str) -> None:
    (tmp_path / "m.glb").write_bytes(glb(*gltf(CORNERS, TRIANGLES, [{"mesh": 0}], more)))
    with pytest.raises(pc.PlannercheckError, match=said):
        read_mesh(tmp_path / "m.glb")
