"""Small mesh files for readers, right ones and broken ones: those of the tests, and some more.

For mesh_readers.py. In: a folder to write into. Out: `Case`, a file's content and what is to be read from it.
"""

import base64
import json
import struct
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

sys.path += [str(Path(__file__).parents[1] / folder) for folder in ("bodies", "support")]

import mesh_samples as samples
import mutated_meshes
import test_collada_files as collada
import test_gltf_files as gltf_files
import test_mesh_files as every
import test_stl_obj_ply as words

from plannercheck.bodies.mesh_files import read_mesh
from plannercheck.common.errors import PlannercheckError

WHOLE = samples.CORNERS[samples.TRIANGLES]
# From y up and from x up to z up.
Y_UP, _X_UP = [[1, 0, 0], [0, 0, -1], [0, 1, 0]], [[0, -1, 0], [0, 0, -1], [1, 0, 0]]

# Corners (m, 3, 3) by object.
Objects = dict[str, np.ndarray]


class Case(NamedTuple):
    """A file: its bytes, and what has to be read from it (None if it is broken).

    Of a broken file, `triangles` says how many it lists, where a reader may drop some.
    """

    name: str
    demand: str
    content: bytes
    wanted: Objects | None
    triangles: int = 0


def parameters(test: Any, mark: int = 0) -> list[Any]:
    """The values of a test's parameter."""
    return list(test.pytestmark[mark].args[1])


def all_files(folder: Path) -> Iterator[Case]:
    """Right files, broken ones, and those to be mutated."""
    yield from right_files(folder)
    yield from broken_files(folder)
    for name in samples.FORMATS:
        yield Case(name, "mutated", _one_file(folder, name, samples.CORNERS), None)


def right_files(folder: Path) -> Iterator[Case]:
    """Files that are to be read: corners, scene graphs, names, units, primitives, and blank lines and comments."""
    for name in samples.FORMATS:
        single = name in ("bytes.stl", "m.gltf", "m.glb")
        for at, size in ((0, 1), (100, 1e-5), (100, 1e4)):
            corners = samples.CORNERS * size + at
            content = _one_file(folder, name, corners)
            corners = corners.astype(np.float32).astype(np.float64) if single else corners
            corners = corners @ np.transpose(Y_UP) if name in ("m.gltf", "m.glb") else corners
            yield Case(name, "corners", content, {"": corners[samples.TRIANGLES]})
    single_corners = samples.CORNERS.astype(np.float32).astype(np.float64)
    part = single_corners[samples.TRIANGLES]
    to_z_up = np.transpose(Y_UP)
    for name in ("m.gltf", "m.glb"):
        for root in gltf_files.ROOTS:
            nodes = [{"name": "root", "children": [1], **root}, {"name": "part", "mesh": 0, "translation": [5, 6, 7]}]
            content = _gltf(name, *samples.gltf(samples.CORNERS, samples.TRIANGLES, nodes))
            yield Case(name, "transforms", content, {"part": _posed(root, part + np.array([5, 6, 7])) @ to_z_up})
        pair = [{"name": n, "mesh": 0, "translation": [x, 0, 0]} for n, x in (("left", -0.5), ("right", 0.5))]
        content = _gltf(name, *samples.gltf(samples.CORNERS, samples.TRIANGLES, [{"children": [1, 2]}, *pair]))
        yield Case(name, "names", content, _pair(part @ to_z_up))
        for mode, triangles in ((5, samples.STRIP), (6, [[0, 1, 2], [0, 2, 3]])):
            file, body = samples.gltf(samples.CORNERS, np.arange(4), [{"mesh": 0}])
            file["meshes"][0]["primitives"][0]["mode"] = mode
            yield Case(name, "primitives", _gltf(name, file, body), {"": single_corners[triangles] @ to_z_up})
        yield from _accessors(name)
    yield from _strips_of_ply()
    yield from _collada()
    yield from _texts(folder)


def _accessors(name: str) -> Iterator[Case]:
    """A glTF with a sparse place, and one whose places are whole numbers."""
    corners, indices = samples.CORNERS.astype("<f4"), samples.TRIANGLES.astype("<u4").tobytes()
    file, body = samples.gltf(corners, samples.TRIANGLES, [{"mesh": 0}])
    file["bufferViews"] += [{"buffer": 0, "byteOffset": len(body) + a, "byteLength": n} for a, n in ((0, 2), (4, 12))]
    file["buffers"][0]["byteLength"] = len(body) + 16
    sparse = {"indices": {"bufferView": 2, "componentType": 5123}, "values": {"bufferView": 3}}
    file["accessors"][0]["sparse"] = {"count": 1, **sparse}
    wanted = corners.astype(np.float64)
    wanted[1] = 9, 8, 7
    content = _gltf(name, file, body + struct.pack("<H2x3f", 1, 9, 8, 7))
    yield Case(name, "primitives", content, {"": wanted[samples.TRIANGLES] @ np.transpose(Y_UP)})
    steps = np.round(samples.CORNERS * 32767).astype("<i2")
    body = np.column_stack([steps, np.zeros(4, "<i2")]).astype("<i2").tobytes() + indices
    file, _ = samples.gltf(corners, samples.TRIANGLES, [{"mesh": 0}], {"extensionsRequired": ["KHR_mesh_quantization"]})
    file["bufferViews"] = [
        {"buffer": 0, "byteLength": 32, "byteStride": 8},
        {"buffer": 0, "byteOffset": 32, "byteLength": len(indices)},
    ]
    file["accessors"][0] |= {"componentType": 5122, "normalized": True}
    file["buffers"][0] = {"byteLength": len(body)}
    wanted = (steps / 32767)[samples.TRIANGLES] @ np.transpose(Y_UP)
    yield Case(name, "primitives", _gltf(name, file, body), {"": wanted})


def _strips_of_ply() -> Iterator[Case]:
    """Quadrilaterals, a triangle and strips, with further properties; y and z of binary files in single precision."""
    corners = np.array(mutated_meshes.CORNERS)
    faces = [t for a, b, c, d in mutated_meshes.QUADS for t in ((a, b, c), (a, c, d))]
    faces += [(0, 1, 2), (0, 1, 2), (2, 1, 3), (4, 5, 6)]
    for name in ("text.ply", "little.ply", "big.ply"):
        yield Case(name, "primitives", mutated_meshes.BASES[name], {"": corners[faces]})
        corners[:, 1:] = corners[:, 1:].astype(np.float32)


def _collada() -> Iterator[Case]:
    places = np.array(samples.PLACES.split(), dtype=float).reshape(-1, 3)[samples.TRIANGLES]
    for transform, matrix in _TRANSFORMS.items():
        node = f'<node id="n">{transform}<node id="m"><translate>0 0 7</translate><instance_geometry url="#g"/></node>'
        content = samples.dae(samples.PLACES, samples.TETRAHEDRON, f"{node}</node>").encode()
        yield Case(
            "m.dae", "transforms", content, {"m": (places + np.array([0, 0, 7])) @ matrix[:, :3].T + matrix[:, 3]}
        )
    nodes = "".join(
        f'<node id="{n}"><translate>{x} 0 0</translate><instance_geometry url="#g"/></node>'
        for n, x in (("left", -0.5), ("right", 0.5))
    )
    yield Case("m.dae", "names", samples.dae(samples.PLACES, samples.TETRAHEDRON, nodes).encode(), _pair(places))
    for asset, unit, turn in _ASSETS:
        content = samples.dae(samples.PLACES, samples.TETRAHEDRON, asset=asset).encode()
        yield Case("m.dae", "units and axes", content, {"": places * unit @ np.array(turn).T})
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    for primitive, triangles in parameters(collada.test_primitives_of_collada):
        content = samples.dae("0 0 0 1 0 0 1 1 0 0 1 0", primitive).encode()
        yield Case("m.dae", "primitives", content, {"": square[triangles]})


_TRANSFORMS = {
    "<matrix>1 2 0 3 0 1 5 4 0.5 0 1 5 0 0 0 1</matrix>": np.array([[1, 2, 0, 3], [0, 1, 5, 4], [0.5, 0, 1, 5]]),
    "<translate>1 2 3</translate><rotate>0 0 1 90</rotate><scale>1 2 3</scale>": np.array(
        [[0, -2, 0, 1], [1, 0, 0, 2], [0, 0, 3, 3]]
    ),
    "<scale>1 2 3</scale><translate>0.1 0.2 0.3</translate>": np.array(
        [[1, 0, 0, 0.1], [0, 2, 0, 0.4], [0, 0, 3, 0.9]]
    ),
    "<lookat>1 2 3 4 2 3 0 0 1</lookat>": np.array([[0, 0, -1, 1], [-1, 0, 0, 2], [0, 1, 0, 3]]),
}
_ASSETS = (
    ('<unit name="mm" meter="0.001"/><up_axis>Z_UP</up_axis>', 0.001, np.eye(3)),
    ('<unit meter="1"/><up_axis>Y_UP</up_axis>', 1, Y_UP),
    ('<unit meter="1"/><up_axis>X_UP</up_axis>', 1, _X_UP),
    ('<unit name="inch" meter="0.0254"/><up_axis>Y_UP</up_axis>', 0.0254, Y_UP),
)


def _texts(folder: Path) -> Iterator[Case]:
    left, right = (
        samples.write(folder / "text.stl", samples.CORNERS + np.array([x, 0, 0])).read_text() for x in (-0.5, 0.5)
    )
    two = left.replace("solid s", "solid left") + right.replace("solid s", "solid right")
    yield Case("text.stl", "names", two.encode(), _pair(WHOLE))
    for letter in "og":
        text = ""
        for name, at, first in (("left", -0.5, 1), ("right", 0.5, 5)):
            text += f"{letter} {name}\n" + "".join(
                f"v {x + at!r} {y!r} {z!r}\n" for x, y, z in samples.CORNERS.tolist()
            )
            text += "".join(f"f {a} {b} {c}\n" for a, b, c in (samples.TRIANGLES + first).tolist())
        yield Case("m.obj", "names", text.encode(), _pair(WHOLE))
    vertices = "v 0 0 0\nv 1 0 0 1\nv 1 1 0 0.5 0.5 0.5\nv 0 1 0 1.0 0.5 0.5 0.5\n"
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    for text, count in parameters(words.test_faces_of_obj):
        if text != "f 1 2":  # what two corners are is a matter of taste
            content = f"{vertices}{text}\n".encode()
            yield Case("m.obj", "primitives", content, {"": square[[[0, 1, 2], [0, 2, 3]][:count]]})
    for layout in parameters(words.test_stl_is_words_on_any_lines):
        yield Case("text.stl", "blanks, comments", words.stl_text(layout).replace(b"endsolid_a", b"a"), {"": WHOLE})
    for name, blanks in (("m.obj", ("\n", "# v 1 2 3\n")), ("text.ply", ("\n",)), ("m.off", ("\n", "# v 1 2 3\n"))):
        lines = samples.write(folder / name).read_text().splitlines(keepends=True)
        for blank in blanks:
            for at in range(1, len(lines) + 1):
                yield Case(name, "blanks, comments", "".join([*lines[:at], blank, *lines[at:]]).encode(), {"": WHOLE})


def broken_files(folder: Path) -> Iterator[Case]:
    """Files that are to be refused; those that are cut are whole where nothing but an end of line is missing."""
    for name in samples.FORMATS:
        content = _one_file(folder, name, samples.CORNERS)
        for end in range(len(content)):
            cut = content[:end]
            if name != "m.obj" and _is_refused(folder / name, cut):
                yield Case(name, "broken: cut short", cut, None, len(WHOLE))
        for nothing in parameters(every.test_files_of_nothing, 1):
            yield Case(name, "broken: words", nothing, None)
    for name in parameters(every.test_a_word_among_places_is_refused, 1):
        for word in parameters(every.test_a_word_among_places_is_refused):
            text = samples.write(folder / name).read_text().replace("0.7", word)
            yield Case(name, "broken: words", text.encode(), None)
    for name in parameters(every.test_an_index_of_no_vertex_is_refused, 1):
        for index in parameters(every.test_an_index_of_no_vertex_is_refused):
            triangles = samples.TRIANGLES.copy()
            triangles[2, 1] = index if name != "m.obj" or index > 0 else -6
            content = samples.write(folder / name, triangles=triangles).read_bytes()
            yield Case(name, "broken: indices", content, None, len(WHOLE))
    text = samples.write(folder / "text.ply").read_text()
    for index in parameters(words.test_indices_of_a_ply_are_whole):
        yield Case(
            "text.ply", "broken: indices", text.replace("3 1 2 3\n", f"3 1 2 {index}\n").encode(), None, len(WHOLE)
        )
    text = samples.dae(samples.PLACES, samples.TETRAHEDRON)
    for word in parameters(collada.test_indices_of_a_collada_file_are_whole):
        yield Case("m.dae", "broken: indices", text.replace("0 2 1 0", f"0 2 {word} 0").encode(), None)
    for old, new, _ in parameters(collada.test_what_collada_files_are_refused_for):
        yield Case("m.dae", "broken: elements", text.replace(old, new).encode(), None)
    for more, _ in parameters(gltf_files.test_what_gltf_files_are_refused_for):
        for name in ("m.gltf", "m.glb"):
            content = _gltf(name, *samples.gltf(samples.CORNERS, samples.TRIANGLES, [{"mesh": 0}], more))
            yield Case(name, "broken: elements", content, None)
    for text, _ in parameters(words.test_what_obj_files_are_refused_for):
        if "surf" not in text:
            yield Case("m.obj", "broken: elements", f"v 0 0 0\nv 1 0 0\nv 0 1 0\n{text}\n".encode(), None)


def _is_refused(path: Path, content: bytes) -> bool:
    """Whether we refuse a content: of files cut short, all that lack more than the end of a line."""
    path.write_bytes(content)
    try:
        read_mesh(path)
    except PlannercheckError:
        return True
    return False


def _one_file(folder: Path, name: str, corners: np.ndarray) -> bytes:
    """A mesh in a format, without a file beside it."""
    if name == "m.gltf":
        return _gltf(name, *samples.gltf(corners, samples.TRIANGLES, [{"mesh": 0}]))
    return samples.write(folder / name, corners).read_bytes()


def _gltf(name: str, file: dict[str, Any], body: bytes) -> bytes:
    if name == "m.glb":
        return samples.glb(file, body)
    if "uri" not in file["buffers"][0]:
        file["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(body).decode()
    return json.dumps(file).encode()


def _pair(corners: np.ndarray) -> Objects:
    return {name: corners + np.array([at, 0, 0]) for name, at in (("left", -0.5), ("right", 0.5))}


def _posed(root: dict[str, list[float]], corners: np.ndarray) -> np.ndarray:
    """Corners under a node's transform: scale, rotation, translation, or the matrix."""
    x, y, z, w = np.array(root.get("rotation", [0, 0, 0, 1])) / np.linalg.norm(root.get("rotation", [0, 0, 0, 1]))
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    matrix = np.array(root.get("matrix", np.eye(4).ravel())).reshape(4, 4).T
    turned = corners * root.get("scale", [1, 1, 1]) @ turn.T + root.get("translation", [0, 0, 0])
    return turned @ matrix[:3, :3].T + matrix[:3, 3]
