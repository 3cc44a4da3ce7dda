"""A tetrahedron in every mesh format, parts of Collada and glTF files, and assimp's reading (through coal)."""

import json
import struct
from collections.abc import Sequence
from pathlib import Path

import coal
import numpy as np

FORMATS = ("text.stl", "bytes.stl", "m.obj", "text.ply", "little.ply", "big.ply", "m.off", "m.dae", "m.gltf", "m.glb")


TEXTS = ("text.stl", "m.obj", "text.ply", "m.off", "m.dae")


CORNERS = np.array([[0, 0, 0], [0.7, 0, 0], [0, 0.1, 0], [0, 0, 1 / 3]])


TRIANGLES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def dae(places: str, primitives: str, nodes: str = "", asset: str = "", count: int = 4) -> str:
    """A Collada file with one geometry."""
    params = "".join(f'<param name="{axis}" type="float"/>' for axis in "XYZ")
    nodes = nodes or '<node id="n"><instance_geometry url="#g"/></node>'
    return f"""<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset>{asset or '<unit meter="1"/><up_axis>Z_UP</up_axis>'}</asset><library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="{3 * count}">{places}</float_array><technique_common>
<accessor source="#pa" count="{count}" stride="3">{params}</accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>{primitives}</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s">{nodes}</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"""


def primitive(kind: str, lists: Sequence[Sequence[int]], count: int, counts: str = "") -> str:
    words = "".join(f"<p>{' '.join(map(str, each))}</p>" for each in lists)
    vcount = f"<vcount>{counts}</vcount>" if counts else ""
    return f'<{kind} count="{count}"><input semantic="VERTEX" source="#v" offset="0"/>{vcount}{words}</{kind}>'


def gltf(corners: np.ndarray, triangles: np.ndarray, nodes: list[dict], more: dict | None = None) -> tuple[dict, bytes]:
    body = corners.astype("<f4").tobytes() + triangles.astype("<u4").tobytes()
    views = [(0, corners.size * 4), (corners.size * 4, triangles.size * 4)]
    file = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": nodes,
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": len(body)}],
        "bufferViews": [{"buffer": 0, "byteOffset": a, "byteLength": n} for a, n in views],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(corners), "type": "VEC3"},
            {"bufferView": 1, "componentType": 5125, "count": triangles.size, "type": "SCALAR"},
        ],
    }
    return {**file, **(more or {})}, body


def glb(file: dict, body: bytes) -> bytes:
    text = json.dumps(file).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(body), b"BIN\0") + body
    return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks


def write(path: Path, corners: np.ndarray = CORNERS, triangles: np.ndarray = TRIANGLES) -> Path:
    """Writes a mesh in the format of a name in FORMATS, texts with all digits."""
    lines = ["".join(f"{x!r} " for x in c) for c in corners.tolist()]
    faces = triangles.tolist()
    head = f"element vertex {len(lines)}\nproperty double x\nproperty double y\nproperty double z\n"
    head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    match path.name:
        case "text.stl":
            facets = [
                f"facet normal 0 0 0\nouter loop\n{''.join(f'vertex {lines[k]}{chr(10)}' for k in f)}" for f in faces
            ]
            path.write_text("solid s\n" + "".join(f"{f}endloop\nendfacet\n" for f in facets) + "endsolid s\n")
        case "bytes.stl":
            body = b"".join(struct.pack("<12fH", 0, 0, 0, *corners[f].ravel(), 0) for f in faces)
            path.write_bytes(b"solid".ljust(80) + struct.pack("<I", len(faces)) + body)
        case "m.obj":
            path.write_text(
                "".join(f"v {c}\n" for c in lines) + "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in faces)
            )
        case "text.ply":
            rows = "".join(f"{c}\n" for c in lines) + "".join(f"3 {a} {b} {c}\n" for a, b, c in faces)
            path.write_text("ply\nformat ascii 1.0\n" + head + rows)
        case "little.ply" | "big.ply":
            order = "<" if path.name == "little.ply" else ">"
            body = corners.astype(f"{order}f8").tobytes()
            body += b"".join(b"\3" + np.array(f, dtype=f"{order}i4").tobytes() for f in faces)
            path.write_bytes(f"ply\nformat binary_{path.stem}_endian 1.0\n{head}".encode() + body)
        case "m.off":
            rows = "".join(f"{c}\n" for c in lines) + "".join(f"3 {a} {b} {c}\n" for a, b, c in faces)
            path.write_text(f"OFF\n{len(lines)} {len(faces)} 0\n{rows}")
        case "m.dae":
            indices = primitive("triangles", [triangles.ravel().tolist()], len(faces))
            path.write_text(dae(" ".join(lines), indices, count=len(lines)))
        case "m.gltf":
            file, body = gltf(corners, triangles, [{"mesh": 0}])
            file["buffers"][0]["uri"] = "b.bin"
            path.with_name("b.bin").write_bytes(body)
            path.write_text(json.dumps(file))
        case "m.glb":
            path.write_bytes(glb(*gltf(corners, triangles, [{"mesh": 0}])))
    return path


def assimp(path: Path) -> tuple[np.ndarray, np.ndarray]:
    shape = coal.MeshLoader().load(str(path), np.ones(3))
    triangles = [[t[0], t[1], t[2]] for t in map(shape.tri_indices, range(shape.num_tris))]
    return np.array(shape.vertices()), np.array(triangles)


def rows(points: np.ndarray) -> list[tuple[float, ...]]:
    return sorted(set(map(tuple, (points + 0.0).tolist())))


STRIP = [[0, 1, 2], [2, 1, 3]]


TETRAHEDRON = primitive("triangles", [[0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]], 4)


PLACES = "0 0 0 100 0 0 0 200 0 0 0 300"
