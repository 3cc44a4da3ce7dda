"""Clouds that Open3D and plyfile write, and the points that they read: `python open3d_clouds.py FOLDER`.

README.md has the commands; neither package is needed to run the tests.
"""

import sys
from pathlib import Path

import numpy as np
import open3d
from plyfile import PlyData, PlyElement


def written_by_open3d(folder: Path) -> None:
    rng = np.random.default_rng(23)
    plain = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(rng.normal(size=(12, 3))))
    rich = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(np.round(rng.normal(size=(11, 3)), 1)))
    rich.colors = open3d.utility.Vector3dVector(rng.random((11, 3)))
    rich.normals = open3d.utility.Vector3dVector(np.tile([0.0, 0.0, 1.0], (11, 1)))
    for name, cloud in (("plain", plain), ("rich", rich)):
        for encoding, ascii_, packed in (("ascii", True, False), ("binary", False, False), ("packed", False, True)):
            path = folder / f"open3d_{name}_{encoding}.pcd"
            open3d.io.write_point_cloud(str(path), cloud, write_ascii=ascii_, compressed=packed)
        for encoding in ("ascii", "binary"):
            path = folder / f"open3d_{name}_{encoding}.ply"
            open3d.io.write_point_cloud(str(path), cloud, write_ascii=encoding == "ascii")
    mesh = open3d.geometry.TriangleMesh.create_tetrahedron()
    open3d.io.write_triangle_mesh(str(folder / "open3d_mesh.ply"), mesh)
    open3d.io.write_point_cloud(str(folder / "open3d.xyz"), rich)


def written_by_plyfile(folder: Path) -> None:
    rng = np.random.default_rng(24)
    kinds = [("id", "u1"), ("z", "f8"), ("x", "f4"), ("y", "f8"), ("label", "i2")]
    vertices = np.zeros(10, dtype=kinds)
    for axis in "xyz":
        vertices[axis] = rng.normal(size=10)
    vertices["id"] = np.arange(10)
    for name, order in (("little", "<"), ("big", ">"), ("ascii", "=")):
        element = PlyElement.describe(vertices, "vertex", comments=["a comment"])
        data = PlyData([element], text=name == "ascii", byte_order=order, obj_info=["other information"])
        data.write(str(folder / f"plyfile_{name}.ply"))


def list_points(path: Path, points: np.ndarray) -> None:
    """Writes points beside their file, as hexadecimal floats."""
    lines = [" ".join(float(number).hex() for number in point) + "\n" for point in points]
    path.with_name(path.name + ".points").write_text("".join(lines))


def list_all(folder: Path) -> None:
    """Each file's points as the library that wrote it reads them."""
    for path in sorted([*folder.glob("open3d*.p[cl][dy]"), *folder.glob("open3d*.xyz")]):
        list_points(path, np.asarray(open3d.io.read_point_cloud(str(path)).points))
    for path in sorted(folder.glob("plyfile*.ply")):
        vertices = PlyData.read(str(path))["vertex"]
        list_points(path, np.column_stack([np.asarray(vertices[axis], dtype=np.float64) for axis in "xyz"]))


if __name__ == "__main__":
    target = Path(sys.argv[1])
    written_by_open3d(target)
    written_by_plyfile(target)
    list_all(target)
