"""Reads every mesh below folders with plannercheck and with assimp (through coal), and says where the two differ.

In: folders. Out: a table of differences by kind, each with who is right by the format's specification; the exit code 1
if a difference has no explanation. Numbers are read as metres ("metre"), as coal's loader does. Two meshes agree if
their points, rounded to single precision, are the same sets, and triangles, bounds and volume are the same.

    python tests/benchmarks/mesh_folders.py FOLDER …
"""

import argparse
import re
import sys
from collections import defaultdict
from pathlib import Path

import coal
import numpy as np
import trimesh

from plannercheck.bodies.mesh_files import MeshFile, read_mesh
from plannercheck.bodies.triangle_meshes import corners_of_coal
from plannercheck.common.errors import PlannercheckError

ENDINGS = (".stl", ".obj", ".ply", ".off", ".dae", ".gltf", ".glb")

SCENES = (".dae", ".gltf", ".glb", ".obj")  # formats that assimp reads into nodes

# Steps of single precision by which a point under transforms may differ: assimp rounds every product.
_STEPS = 16

NOTHING = "trimesh reads no triangles"
SAME = "the same points, triangles, bounds and volume"
EXPLAINED = {
    "posed": "points under transforms differ by roundings: assimp multiplies in single precision, we in double",
    "nested": "coal numbers the triangles of nested nodes wrongly (src/mesh_loader/assimp.cpp passes the count of a"
    " level, not of all before); its points are ours, and the triangles are those of trimesh",
    "nested, trimesh reads nothing": "the same, but trimesh gives up its nodes without a word; points are ours",
    "root": "the only root node has the mesh: coal keeps its transform, which it drops for nodes below the root;"
    " here it is the identity, as in MoveIt",
    "refused by both": "neither reads the file",
    "not finite": "the file has vertices that are no numbers: refused here; assimp keeps them, and no hull has them",
    "two corners": "faces with two corners, where the format demands three: here triangles of no area, in assimp lines",
    "stray": "vertices that no face uses: no part of the surface; assimp keeps them",
    "degenerate": "triangles without area: here as in the file; assimp drops or merges some",
    "concave": "polygons with other diagonals: both are right where a polygon is plane; where it is not, no format says"
    " which diagonal",
    "text": "a decimal that assimp's own parser rounds one step of single precision away: the nearest double is right",
}


def compared(path: Path) -> tuple[str, str]:
    """The kind of difference of one file ("" for one without an explanation), and details."""
    try:
        mesh: MeshFile | None = read_mesh(path, units="metre")
    except PlannercheckError as error:
        mesh, said = None, str(error).partition(": ")[2]
    try:
        theirs = corners_of_coal(coal.MeshLoader().load(str(path), np.ones(3)))
    except Exception as error:  # coal raises several unrelated types
        theirs, reason = None, str(error)
    if mesh is None:
        if theirs is None:
            return "refused by both", said
        return ("not finite" if not np.isfinite(theirs[0]).all() or "nan" in said else ""), said
    if theirs is None:
        return "", f"coal: {reason:.200}"
    kind, details = _difference(path, mesh, *theirs)
    if not kind and path.suffix.lower() in SCENES:
        return _scene_difference(path, mesh, *theirs, details)
    return kind, details


def _scene_difference(
    path: Path, mesh: MeshFile, points: np.ndarray, triangles: np.ndarray, details: str
) -> tuple[str, str]:
    """Explains what coal makes of nodes."""
    limit = _STEPS * np.spacing(np.abs(points).max().astype(np.float32))
    flat = int(_flat(mesh.points[mesh.triangles]).sum())
    if not len(triangles) <= len(mesh.triangles) <= len(triangles) + flat:
        return "", details
    if path.suffix.lower() in (".gltf", ".glb") and _farthest(_as_in_gltf(read_mesh(path)), points) <= limit:
        return "root", details
    faces = mesh.points[mesh.triangles]
    if _farthest(faces[~_same_corner(faces)], points) > limit:  # faces of two corners are lines in assimp
        return "", details
    if len(triangles) == len(mesh.triangles) and _has_polygons(path):
        return "concave", details
    other = _unlike_trimesh(path, mesh)
    if other == NOTHING:
        return "nested, trimesh reads nothing", details
    return ("" if other else "nested"), other or details


def _flat(triangles: np.ndarray) -> np.ndarray:
    """Which triangles have two corners that are the same in single precision."""
    single = triangles.astype(np.float32)
    return (single == np.roll(single, 1, axis=1)).all(axis=2).any(axis=1)


def _as_in_gltf(mesh: MeshFile) -> np.ndarray:
    """The points with y up again."""
    return mesh.points[:, [0, 2, 1]] * [1, 1, -1]


def _difference(path: Path, mesh: MeshFile, points: np.ndarray, triangles: np.ndarray) -> tuple[str, str]:
    ours = mesh.points[mesh.triangles]
    theirs = points[triangles]
    two = path.suffix.lower() == ".obj" and _faces_of_two(path)
    if two:
        ours = ours[: len(ours)][~_same_corner(ours)]
    kinds = []
    single = ours.astype(np.float32).astype(np.float64)
    if not _same_sets(single, theirs):
        steps = np.spacing(np.abs(theirs).max().astype(np.float32)).astype(float)
        far = _farthest(single, theirs)
        if far > _STEPS * steps:
            if _same_sets(single[_area(single) > 0], theirs[_area(theirs) > 0]):
                kinds.append("degenerate")
            else:
                return "", f"a point is {far:.3g} from the other's"
        else:
            kinds.append("posed" if path.suffix.lower() in SCENES[:3] else "text")
    if two:
        kinds.append("two corners")
    if len(ours) != len(theirs):
        if (_area(ours) > 0).sum() != (_area(theirs) > 0).sum() and "posed" not in kinds:
            return "", f"{len(ours)} triangles, {len(theirs)} in assimp"
        kinds.append("degenerate")
    scale = max(float(np.ptp(theirs.reshape(-1, 3), axis=0).max()), float(np.abs(theirs).max()))
    tolerance = 2e-6 * max(scale, 1e-30)
    for ends in (np.min, np.max):
        if np.abs(ends(ours, axis=(0, 1)) - ends(theirs, axis=(0, 1))).max() > tolerance:
            return "", "other bounds"
    middle = theirs.reshape(-1, 3).mean(axis=0)
    volumes = [
        np.einsum("ij,ij->i", *(lambda t: (t[:, 0], np.cross(t[:, 1], t[:, 2])))(t - middle)) / 6
        for t in (ours, theirs)
    ]
    size = sum(np.abs(v).sum() for v in volumes)
    if abs(volumes[0].sum() - volumes[1].sum()) > 1e-4 * size + 1e-30:
        return "", f"volume {volumes[0].sum():.9g}, {volumes[1].sum():.9g} in assimp"
    strays = len(np.unique(points, axis=0)) - len(np.unique(theirs.reshape(-1, 3), axis=0))
    if strays:
        kinds.append("stray")
    if not kinds and _sorted(single) != _sorted(theirs):
        kinds.append("concave")
    return (kinds[0] if kinds else SAME), ", ".join(kinds)


def _unlike_trimesh(path: Path, mesh: MeshFile) -> str:
    """How triangles differ from those of trimesh, which turns no axes and keeps the root; "" if they don't."""
    theirs = trimesh.load_scene(
        str(path), file_type=path.suffix[1:].lower(), process=False, maintain_order=True
    ).to_mesh()
    ours = read_mesh(path) if path.suffix.lower() in (".gltf", ".glb") else mesh
    points = _as_in_gltf(ours) if path.suffix.lower() in (".gltf", ".glb") else ours.points
    a, b = points[ours.triangles], theirs.vertices[theirs.faces]
    if len(a) != len(b):  # trimesh drops faces of two corners
        a, b = (each[_area(each) > 0] for each in (a, b))
    if not len(b):
        return NOTHING
    if len(a) != len(b):
        return f"{len(a)} triangles, {len(b)} in trimesh"
    size = np.abs(b).max()
    centres = [each.mean(axis=1) for each in (a, b)]
    if _farthest(*centres) > 1e-5 * size:
        return "triangles that trimesh does not have"
    areas = [float(_area(each).sum()) for each in (a, b)]
    return "" if abs(areas[0] - areas[1]) < 1e-5 * areas[1] else f"areas {areas}"


def _faces_of_two(path: Path) -> bool:
    return re.search(rb"^\s*f[ \t]+\S+[ \t]+\S+[ \t]*\r?$", path.read_bytes(), re.MULTILINE) is not None


def _has_polygons(path: Path) -> bool:
    return (
        path.suffix.lower() == ".obj"
        and re.search(rb"^\s*f([ \t]+\S+){4}", path.read_bytes(), re.MULTILINE) is not None
    )


def _same_corner(triangles: np.ndarray) -> np.ndarray:
    """Which triangles have the same last two corners, as faces with two corners are read."""
    return (triangles[:, 1] == triangles[:, 2]).all(axis=1)


def _area(triangles: np.ndarray) -> np.ndarray:
    return np.linalg.norm(np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1)


def _same_sets(ours: np.ndarray, theirs: np.ndarray) -> bool:
    a, b = (np.unique(each.reshape(-1, 3) + 0.0, axis=0) for each in (ours, theirs))  # -0 is 0
    return a.shape == b.shape and bool((a == b).all())


def _farthest(ours: np.ndarray, theirs: np.ndarray) -> float:
    """The largest distance of a point of one from the nearest of the other."""
    from scipy.spatial import cKDTree

    a, b = ours.reshape(-1, 3), theirs.reshape(-1, 3)
    return float(max(cKDTree(a).query(b)[0].max(), cKDTree(b).query(a)[0].max()))


def _sorted(triangles: np.ndarray) -> list:
    return sorted(map(sorted, (triangles + 0.0).tolist()))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", type=Path, nargs="+")
    found: dict[str, list[tuple[Path, str]]] = defaultdict(list)
    for folder in parser.parse_args().folders:
        for path in sorted(folder.rglob("*")):
            if path.suffix.lower() in ENDINGS and path.is_file():
                kind, details = compared(path)
                found[kind].append((path, details))
                if not kind:
                    print(f"{path}: {details}", flush=True)
    for kind, files in sorted(found.items(), key=lambda item: -len(item[1])):
        print(f"{len(files):5} {kind or 'WITHOUT AN EXPLANATION'}: {EXPLAINED.get(kind, '')} (e.g. {files[0][0].name})")
    return int(bool(found[""]))


if __name__ == "__main__":
    sys.exit(main())
