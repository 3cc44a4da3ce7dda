"""Mesh files against what their formats define: places, sizes, names, and what is refused.

The oracles are the numbers that the files are written from, exact decimals, assimp (through coal), and trimesh.
"""

import contextlib
import json
import struct
from collections.abc import Sequence
from pathlib import Path

import coal
import numpy as np
import pytest
import trimesh

import plannercheck as pc
from plannercheck.bodies.mesh_files import read_mesh
from plannercheck.bodies.polygons import triangles_of_polygons
from plannercheck.common.progress import reported_to

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


@pytest.mark.parametrize("name", FORMATS)
@pytest.mark.parametrize("at", [0.0, 100.0])
@pytest.mark.parametrize("size", [1e-5, 1.0, 1e4])
def test_places_are_the_written_numbers(tmp_path: Path, name: str, at: float, size: float) -> None:
    """Doubles where the format has them; single precision in binary STL and glTF."""
    corners = CORNERS * size + at
    if name in ("bytes.stl", "m.gltf", "m.glb"):
        corners = corners.astype(np.float32).astype(np.float64)
    mesh = read_mesh(write(tmp_path / name, corners), units="metre")
    assert mesh.points[mesh.triangles].tolist() == corners[TRIANGLES].tolist()


FACET = "facet normal 0 0 1|outer loop|vertex {}|vertex {}|vertex {}|endloop|endfacet|"


def stl_text(layout: str) -> bytes:
    """Facets of the mesh as text STL: a line a part, indented, in capitals, on one line, with blank lines, or with two
    corners of the first facet on one line and none on the next."""
    corners = ["".join(f" {x!r}" for x in c) for c in CORNERS.tolist()]
    text = "".join(FACET.format(*(corners[k] for k in f)) for f in TRIANGLES.tolist())
    shared = text.replace("|vertex", "|Vertex", 1).replace("|vertex", " vertex", 1).replace("|vertex", "||vertex", 1)
    text = shared if layout == "shared" else text
    text = {"words": text.replace("|", " "), "blank": text.replace("|", "\n\n")}.get(layout, text.replace("|", "\n"))
    text = {"capitals": text.upper(), "indented": text.replace("\n", "\n\t  ")}.get(layout, text)
    ends = {"mac": "\r", "dos": "\r\n"}.get(layout, "\n")
    return f"solid endsolid_a\n{text}\nendsolid x\n".replace("\n", ends).encode()


LAYOUTS = ("lines", "indented", "capitals", "words", "blank", "mac", "dos", "shared")


@pytest.mark.parametrize("layout", LAYOUTS)
def test_stl_is_words_on_any_lines(tmp_path: Path, layout: str) -> None:
    (tmp_path / "a.stl").write_bytes(stl_text(layout))
    mesh = read_mesh(tmp_path / "a.stl")
    assert mesh.points[mesh.triangles].tolist() == CORNERS[TRIANGLES].tolist()


@pytest.mark.parametrize("layout", LAYOUTS[:3])
@pytest.mark.parametrize("fault", ["less", "more", "moved", "word", "name", "loop"])
def test_a_broken_facet_of_a_long_stl_is_named(tmp_path: Path, layout: str, fault: str) -> None:
    """Numbers that move from one corner's line to the next keep their count."""
    lines = stl_text(layout).split(b"\n")
    lines[3:5] = {
        "less": [lines[3].rsplit(None, 1)[0], lines[4]],
        "more": [lines[3] + b" 1", lines[4]],
        "moved": [lines[3].rsplit(None, 1)[0], lines[4] + b" 1"],
        "word": [lines[3] + b"x", lines[4]],
        "name": [lines[3].replace(b"vertex", b"vertices").replace(b"VERTEX", b"vertices"), lines[4]],
        "loop": [lines[4], b"outer loop"],
    }[fault]
    (tmp_path / "a.stl").write_bytes(b"\n".join(lines))
    with pytest.raises(pc.PlannercheckError, match=r"a\.stl.*facet 1 of the solid"):
        read_mesh(tmp_path / "a.stl")


@pytest.mark.parametrize("name", FORMATS)
def test_rounded_to_single_precision_they_are_those_of_assimp(tmp_path: Path, name: str) -> None:
    corners = np.random.default_rng(1).uniform(-3, 3, (60, 3))
    triangles = np.array([[k, k + 1, k + 2] for k in range(58)])
    path = write(tmp_path / name, corners, triangles)
    mesh, (points, faces) = read_mesh(path, units="metre"), assimp(path)
    near = np.abs(mesh.points[:, None] - points[None]).max(axis=2)
    step = 2.0**-22  # of single precision at 3; assimp's parser of texts rounds up to one step away
    assert near.min(axis=0).max() <= step
    assert near.min(axis=1).max() <= step
    assert len(mesh.triangles) == len(faces)


@pytest.mark.parametrize("name", FORMATS)
def test_scale_and_mirror(tmp_path: Path, name: str) -> None:
    path = write(tmp_path / name)
    plain = read_mesh(path)
    assert (read_mesh(path, (0.001, -2, 3)).points == plain.points * [0.001, -2, 3]).all()
    for scale in (0, float("nan"), (1, 2), "big"):
        with pytest.raises(pc.PlannercheckError, match="scale"):
            read_mesh(path, scale)


@pytest.mark.parametrize("name", FORMATS)
def test_files_that_are_cut_short_are_refused_or_whole(tmp_path: Path, name: str) -> None:
    """At every byte: an error that names the file, or no fewer faces than it lists."""
    path = write(tmp_path / name)
    content = path.read_bytes()
    for end in range(len(content)):
        path.write_bytes(content[:end])
        # OBJ has no counts; the others have lost at most an end of line, or a digit of the last index.
        listed = content[:end].count(b"f ") if name == "m.obj" else 4
        assert _faces_or_error(path) in (listed, name)


def _faces_or_error(path: Path) -> int | str:
    """How many triangles a file has, or its name if an error says it."""
    try:
        return len(read_mesh(path).triangles)
    except pc.PlannercheckError as error:
        return path.name if path.name in str(error) else str(error)


@pytest.mark.parametrize("name", TEXTS)
@pytest.mark.parametrize("word", ["nan", "inf", "x", "1e999", "0x1", "1_0", "1,5"])
def test_a_word_among_places_is_refused(tmp_path: Path, name: str, word: str) -> None:
    path = write(tmp_path / name)
    path.write_text(path.read_text().replace("0.7", word))
    with pytest.raises(pc.PlannercheckError, match=name):
        read_mesh(path)


@pytest.mark.parametrize("name", ["m.obj", "text.ply", "m.off", "m.dae", "little.ply", "big.ply", "m.glb"])
@pytest.mark.parametrize("index", [-1, 5, 2**31 - 1])
def test_an_index_of_no_vertex_is_refused(tmp_path: Path, name: str, index: int) -> None:
    triangles = TRIANGLES.copy()
    triangles[2, 1] = index if name != "m.obj" or index > 0 else -6
    with pytest.raises(pc.PlannercheckError, match=name):
        read_mesh(write(tmp_path / name, triangles=triangles))


@pytest.mark.parametrize("name", ["m.obj", "text.ply", "m.off"])
@pytest.mark.parametrize("blank", ["\n", " \n", "\t\r\n"])
def test_blank_lines_anywhere_change_nothing(tmp_path: Path, name: str, blank: str) -> None:
    """Named case: mesh_texts.py, of whose places for a blank line 15 of 27 lost geometry."""
    path = write(tmp_path / name)
    lines = path.read_text().splitlines(keepends=True)
    for at in range(1, len(lines) + 1):
        path.write_text("".join([*lines[:at], blank, *lines[at:]]))
        mesh = read_mesh(path)
        assert mesh.points[mesh.triangles].tolist() == CORNERS[TRIANGLES].tolist()


@pytest.mark.parametrize("name", ["m.obj", "m.off"])
def test_comments_anywhere_change_nothing(tmp_path: Path, name: str) -> None:
    path = write(tmp_path / name)
    lines = path.read_text().splitlines(keepends=True)
    for at in range(1, len(lines) + 1):
        path.write_text("".join([*lines[:at], "# v 1 2 3\n", *lines[at:]]))
        assert read_mesh(path).points[read_mesh(path).triangles].tolist() == CORNERS[TRIANGLES].tolist()


@pytest.mark.parametrize("index", ["3.5", "x", "-1", "4"])
def test_indices_of_a_ply_are_whole(tmp_path: Path, index: str) -> None:
    path = write(tmp_path / "text.ply")
    path.write_text(path.read_text().replace("3 1 2 3\n", f"3 1 2 {index}\n"))
    with pytest.raises(pc.PlannercheckError, match="face"):
        read_mesh(path)
    path.write_text(path.read_text().replace(f"3 1 2 {index}\n", "3 1 2 3.0\n"))
    assert len(read_mesh(path).triangles) == 4


@pytest.mark.parametrize("word", ["x", "-1", "4", "1.0", ""])
def test_indices_of_a_collada_file_are_whole(tmp_path: Path, word: str) -> None:
    """Named case: mesh_texts.py, where assimp never returns."""
    path = tmp_path / "m.dae"
    path.write_text(dae("0 0 0 1 0 0 0 2 0 0 0 3", primitive("triangles", [[0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]], 4)))
    path.write_text(path.read_text().replace("0 2 1 0", f"0 2 {word} 0"))
    with pytest.raises(pc.PlannercheckError, match=r"geometry 'g' has <triangles>"):
        read_mesh(path)


STRIP = [[0, 1, 2], [2, 1, 3]]


@pytest.mark.parametrize(
    ("content", "triangles"),
    [
        (primitive("triangles", [[0, 1, 2, 1, 2, 3]], 2), [[0, 1, 2], [1, 2, 3]]),
        (primitive("polylist", [[0, 1, 2, 3, 0, 1, 2]], 2, "4 3"), [[0, 1, 2], [0, 2, 3], [0, 1, 2]]),
        (primitive("polygons", [[0, 1, 2, 3], [0, 1, 2]], 2), [[0, 1, 2], [0, 2, 3], [0, 1, 2]]),
        (primitive("tristrips", [[0, 1, 2, 3]], 1), STRIP),
        (primitive("trifans", [[0, 1, 2, 3]], 1), [[0, 1, 2], [0, 2, 3]]),
        (primitive("lines", [[0, 1]], 1) + primitive("triangles", [[0, 1, 2]], 1), [[0, 1, 2]]),
    ],
)
def test_primitives_of_collada(tmp_path: Path, content: str, triangles: list[list[int]]) -> None:
    corners = [[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    (tmp_path / "m.dae").write_text(dae(" ".join(str(x) for c in corners for x in c), content))
    mesh = read_mesh(tmp_path / "m.dae")
    assert mesh.points[mesh.triangles].tolist() == np.array(corners)[triangles].tolist()


TETRAHEDRON = primitive("triangles", [[0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]], 4)
PLACES = "0 0 0 100 0 0 0 200 0 0 0 300"


@pytest.mark.parametrize(
    ("asset", "corner", "said"),
    [
        ('<unit meter="1"/><up_axis>Z_UP</up_axis>', [100, 200, 300], ""),
        ('<unit name="mm" meter="0.001"/><up_axis>Z_UP</up_axis>', [0.1, 0.2, 0.3], "its <unit> is mm (0.001 m)"),
        ('<unit meter="1"/><up_axis>Y_UP</up_axis>', [100, -300, 200], "its up_axis is Y_UP"),
        ('<unit meter="1"/><up_axis>X_UP</up_axis>', [-200, -300, 100], "its up_axis is X_UP"),
        ("<created/>", [100, -300, 200], "its up_axis is Y_UP"),  # the specification's defaults
        (
            '<unit name="inch" meter="0.0254"/><up_axis>Y_UP</up_axis>',
            [2.54, -7.62, 5.08],
            "its <unit> is inch (0.0254 m) and its up_axis Y_UP",
        ),
    ],
)
def test_unit_and_axis_of_collada(tmp_path: Path, asset: str, corner: list[float], said: str) -> None:
    """Named case: collada_units.py. As metres, the numbers are those of the file, as MoveIt and coal have them."""
    (tmp_path / "m.dae").write_text(dae(PLACES, TETRAHEDRON, asset=asset))
    mesh, plain = (read_mesh(tmp_path / "m.dae", units=units) for units in ("file", "metre"))
    np.testing.assert_allclose(mesh.points.sum(axis=0), corner, rtol=1e-15)
    assert (mesh.conversion, plain.conversion) == (said, said)
    assert rows(plain.points) == rows(assimp(tmp_path / "m.dae")[0])


@pytest.mark.parametrize(
    "transform",
    [
        "<matrix>1 2 0 3 0 1 5 4 0.5 0 1 5 0 0 0 1</matrix>",
        "<translate>1 2 3</translate><rotate>0 0 1 30</rotate><scale>1 2 3</scale>",
        "<scale>1 2 3</scale><rotate>0.6 0.8 0 -90</rotate><translate>1 2 3</translate>",
        "<rotate>0 1 0 90</rotate><rotate>0 0 0 0</rotate>",
        "<lookat>1 2 3 4 2 3 0 0 1</lookat>",
    ],
)
def test_transforms_of_collada_nodes(tmp_path: Path, transform: str) -> None:
    """In their order, as assimp has them, which takes axes as of length 1 and up as upright."""
    node = (
        f'<node id="n">{transform}<node id="m"><translate>0 0 7</translate><instance_geometry url="#g"/></node></node>'
    )
    (tmp_path / "m.dae").write_text(dae(PLACES, TETRAHEDRON, node))
    ours, theirs = (np.array(rows(p)) for p in (read_mesh(tmp_path / "m.dae").points, assimp(tmp_path / "m.dae")[0]))
    near = np.linalg.norm(ours[:, None] - theirs[None], axis=2)
    assert near.min(axis=0).max() < 1e-4
    assert near.min(axis=1).max() < 1e-4


@pytest.mark.parametrize("name", ["m.dae", "m.glb"])
def test_nodes_that_mirror_keep_the_outer_side_of_triangles(tmp_path: Path, name: str) -> None:
    """A solid and its mirror image overlap: where they do is inside."""
    mirrored = "<matrix>-1 0 0 20 0 1 0 20 0 0 1 20 0 0 0 1</matrix>"
    nodes = "".join(f"<node>{pose}<instance_geometry url='#g'/></node>" for pose in ("", mirrored))
    (tmp_path / "m.dae").write_text(dae(PLACES, TETRAHEDRON, nodes))
    two = [{"children": [1, 2]}, {"mesh": 0}, {"mesh": 0, "scale": [-1, 1, 1], "translation": [20, 20, 20]}]
    (tmp_path / "m.glb").write_bytes(glb(*gltf(CORNERS * [100 / 0.7, 2000, 900], TRIANGLES, two)))
    volumes = [np.linalg.det(each.points[each.triangles]).sum() / 6 for each in read_mesh(tmp_path / name).objects]
    np.testing.assert_allclose(volumes, 100 * 200 * 300 / 6)
    z_up = [5.0, 20, 20] if name == "m.dae" else [5.0, -20, 20]
    inside = pc.Polytope(np.add(z_up, 0.1 * CORNERS))
    assert pc.intersects(pc.Solid.load(tmp_path / name, mesh_units="file"), inside)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("<instance_geometry", "<skew>1 0 0 1 0 1 0</skew><instance_geometry", "skew"),
        ('<instance_geometry url="#g"/>', '<instance_controller url="#g"/>', "skeleton"),
        ('url="#g"', 'url="#h"', "no such <geometry>"),
        ('url="#g"', 'url="other.dae#g"', "only parts of the file"),
        ('<instance_geometry url="#g"/>', '<instance_node url="#n"/>', "instance of itself"),
        ("<instance_visual_scene", "<instance_physics_scene", "instance_visual_scene"),
        ("Z_UP", "W_UP", "up_axis"),
        ('meter="1"', 'meter="-1"', "unit"),
        ('count="12"', 'count="13"', "12 numbers"),
        ('source="#pa" count="4"', 'source="#pa" count="5"', "accessor"),
        ('semantic="POSITION" source="#p"', 'semantic="POSITION" source="#q"', "no such <source>"),
        ('<triangles count="4"', '<triangles count="5"', "corners"),
        ("</vertices>", "</vertices><spline/>", "spline"),
        ("</p>", " -</p>", "no whole number"),
        ("</library_geometries>", '<geometry id="g"/></library_geometries>', "2 <geometry> of this id"),
        ("</vertices>", '</vertices><source id="p"/>', "2 <source> of this id"),
        ("</p>", "</p></triangles>", "XML"),
    ],
)
def test_what_collada_files_are_refused_for(tmp_path: Path, old: str, new: str, said: str) -> None:
    content = dae(PLACES, TETRAHEDRON)
    assert old in content
    (tmp_path / "m.dae").write_text(content.replace(old, new))
    with pytest.raises(pc.PlannercheckError, match=said):
        read_mesh(tmp_path / "m.dae")


@pytest.mark.parametrize("kind", ["node", "material", "geometry"])
def test_elements_of_other_kinds_may_have_the_id_of_a_geometry(tmp_path: Path, kind: str) -> None:
    """Nor does a second geometry count that has another id."""
    other = f'<library_others><{kind} id="{"h" if kind == "geometry" else "g"}"/></library_others>'
    (tmp_path / "m.dae").write_text(dae(PLACES, TETRAHEDRON).replace("<scene>", f"{other}<scene>"))
    assert len(read_mesh(tmp_path / "m.dae").triangles) == 4


def test_the_visual_scene_that_is_named_counts(tmp_path: Path) -> None:
    content = dae(PLACES, TETRAHEDRON)
    nodes = "".join(f'<node id="{name}"><instance_geometry url="#g"/></node>' for name in "ab")
    other = f'<visual_scene id="t">{nodes}'
    content = content.replace("<library_visual_scenes>", f"<library_visual_scenes>{other}</visual_scene>")
    (tmp_path / "m.dae").write_text(content)
    assert [each.name for each in read_mesh(tmp_path / "m.dae").objects] == ["n"]
    (tmp_path / "m.dae").write_text(content.replace('scene url="#s"', 'scene url="#t"'))
    assert [each.name for each in read_mesh(tmp_path / "m.dae").objects] == ["a", "b"]


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


@pytest.mark.parametrize("name", ["two.glb", "two.obj", "groups.obj", "two.stl", "two.dae"])
def test_objects_of_a_file(tmp_path: Path, name: str) -> None:
    """Named case: several_objects.py, where two boxes 1 m apart became one block."""
    path = tmp_path / name
    faces = ["".join(f"f {a - 4} {b - 4} {c - 4}\n" for a, b, c in TRIANGLES.tolist())] * 2
    vertices = [
        "".join(f"v {x} {y} {z}\n" for x, y, z in (CORNERS + np.array([at, 0, 0])).tolist()) for at in (-0.5, 0.5)
    ]
    match name:
        case "two.glb":
            nodes = [
                {"children": [1, 2]},
                *({"name": n, "mesh": 0, "translation": [x, 0, 0]} for n, x in (("left", -0.5), ("right", 0.5))),
            ]
            path.write_bytes(glb(*gltf(CORNERS, TRIANGLES, nodes)))
        case "two.obj":
            path.write_text(f"o left\n{vertices[0]}g a\n{faces[0]}o right\n{vertices[1]}g a\n{faces[1]}")
        case "groups.obj":
            first, second = faces[0].split("\n", 1)
            path.write_text(f"g left\n{vertices[0]}{first}\n{second}g right\n{vertices[1]}{faces[1]}g empty\n")
        case "two.stl":
            parts = [write(tmp_path / "text.stl", CORNERS + np.array([at, 0, 0])).read_text() for at in (-0.5, 0.5)]
            path.write_text(parts[0].replace("solid s", "solid left") + parts[1].replace("solid s", "solid right"))
        case "two.dae":
            nodes = "".join(
                f'<node id="{n}"><translate>{x} 0 0</translate><instance_geometry url="#g"/></node>'
                for n, x in (("left", -0.5), ("right", 0.5))
            )
            path.write_text(dae(" ".join(map(repr, CORNERS.ravel().tolist())), TETRAHEDRON, nodes))
    mesh = read_mesh(path, units="metre")
    assert [each.name for each in mesh.objects] == ["left", "right"]
    for each, at in zip(mesh.objects, (-0.5, 0.5), strict=True):
        assert len(each.triangles) == 4
        np.testing.assert_allclose(each.points[each.triangles], CORNERS[TRIANGLES] + [at, 0, 0], atol=1e-6)
    np.testing.assert_array_equal(mesh.points[mesh.triangles][4:], mesh.objects[1].points[mesh.objects[1].triangles])


def test_names_that_come_again_are_numbered(tmp_path: Path) -> None:
    vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
    (tmp_path / "m.obj").write_text(vertices + "".join(f"o {name}\nf 1 2 3\n" for name in ("a", "a_2", "a", "a")))
    assert [each.name for each in read_mesh(tmp_path / "m.obj").objects] == ["a", "a_2", "a_3", "a_4"]


@pytest.mark.parametrize(
    ("text", "triangles"),
    [
        ("f -4 -3 -2 -1", 2),
        ("f 1/1/1 2//1 3/1 4", 2),
        ("f 1 2 \\\n3", 1),
        ("f 1 2 3 # 4", 1),
        ("f\t1  2 3\r\n", 1),
        ("l 1 2\np 1\nf 1 2 3", 1),
        ("f 1 2", 1),
    ],
)
def test_faces_of_obj(tmp_path: Path, text: str, triangles: int) -> None:
    vertices = "v 0 0 0\nv 1 0 0 1\nv 1 1 0 0.5 0.5 0.5\nv 0 1 0 1.0 0.5 0.5 0.5\n"
    (tmp_path / "m.obj").write_text(f"{vertices}{text}\n")
    assert len(read_mesh(tmp_path / "m.obj").triangles) == triangles


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("f 1 2 x", "line 4"),
        ("f 1", "line 4"),
        ("f 0 1 2", "line 4.*vertex 0"),
        ("f 1 2 3\nf 1 2 4", "line 5.*vertex 4"),
        ("f 1 2 -4", "line 4"),
        ("f 1 2 /3", "line 4"),
        ("f 1 2-1 3", "line 4"),
        ("ff 1 2 3", "no statement"),
        ("v 1 2\nf 1 2 3", "line 4"),
        ("v 1 2 3 2\nf 1 2 3", "weight"),
        ("# a \\\nf 1 2 3", "hide the next line"),
        ("surf 0 1 0 1 1 2 3", "free-form"),
        ("l 1 2", "no faces"),
    ],
)
def test_what_obj_files_are_refused_for(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "m.obj").write_text(f"v 0 0 0\nv 1 0 0\nv 0 1 0\n{text}\n")
    with pytest.raises(pc.PlannercheckError, match=said):
        read_mesh(tmp_path / "m.obj")


@pytest.mark.parametrize("kinds", ["uchar int", "int uint", "ushort short", "char uchar"])
@pytest.mark.parametrize("form", ["little", "big", "ascii"])
def test_lists_of_ply(tmp_path: Path, kinds: str, form: str) -> None:
    """Triangles and quadrilaterals in turn, other properties around them, strips, and edges that are passed over."""
    sizes = {"uchar": "u1", "int": "i4", "uint": "u4", "ushort": "u2", "short": "i2", "char": "i1"}
    count, item = (sizes[kind] for kind in kinds.split())
    faces, strip = [[0, 1, 2], [0, 1, 2, 3], [1, 2, 3]], [0, 1, 2, 3, -1, 3, 2, 1]
    head = (
        "element edge 1\nproperty float v\nelement vertex 4\nproperty uchar c\nproperty double x\nproperty double y\n"
    )
    head += f"property double z\nelement face 3\nproperty list uchar short w\nproperty list {kinds} vertex_index\n"
    head += "property float q\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n"
    if form == "ascii":
        lines = ["1.5", *("7 " + " ".join(map(repr, c)) for c in CORNERS.tolist())]
        lines += [" ".join(map(str, [2, 8, 9, len(f), *f, 0.5])) for f in faces] + [" ".join(map(str, [8, *strip]))]
        body = "".join(f"{line}\n" for line in lines).encode()
    else:
        order = "<" if form == "little" else ">"
        body = struct.pack(f"{order}f", 1.5) + b"".join(struct.pack(f"{order}B3d", 7, *c) for c in CORNERS)
        for face in faces:
            body += struct.pack(f"{order}Bhh", 2, 8, 9) + np.array([len(face)], order + count).tobytes()
            body += np.array(face, order + item).tobytes() + struct.pack(f"{order}f", 0.5)
        body += struct.pack(f"{order}9i", 8, *strip)
    form = form if form == "ascii" else f"binary_{form}_endian"
    (tmp_path / "m.ply").write_bytes(f"ply\nformat {form} 1.0\n{head}".encode() + body)
    mesh = read_mesh(tmp_path / "m.ply")
    wanted = [[0, 1, 2], [0, 1, 2], [0, 2, 3], [1, 2, 3], [0, 1, 2], [2, 1, 3], [3, 2, 1]]
    assert mesh.points[mesh.triangles].tolist() == CORNERS[wanted].tolist()


@pytest.mark.parametrize(
    "content", [b"", b"solid", b"solid x\nendsolid x\n", b"OFF\n", b"ply\n", b"glTF", b"{}", b"<a/>"]
)
@pytest.mark.parametrize("name", FORMATS)
def test_files_of_nothing(tmp_path: Path, name: str, content: bytes) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(pc.PlannercheckError, match=name):
        read_mesh(tmp_path / name)


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("m.stl", b"version https://git-lfs.github.com/spec/v1\n", "git lfs pull"),
        ("m.3ds", b"x", r"\.stl, \.obj, \.ply, \.off, \.dae, \.gltf, \.glb"),
        ("m", b"x", "no ending"),
        ("m.stl", b"x" * 80 + struct.pack("<I", 1) + bytes(51), "135"),
        ("m.stl", b"x" * 80 + struct.pack("<I", 1) + struct.pack("<12fH", *[0] * 9, float("nan"), 0, 0, 0), "facet 1"),
        ("m.stl", b"solid a facet normal 0 0 1 endfacet\nendsolid\n", "line after"),
        ("m.off", b"4OFF\n1 1 1\n", "OFF"),
    ],
)
def test_files_that_are_refused(tmp_path: Path, name: str, content: bytes, said: str) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(pc.PlannercheckError, match=said):
        read_mesh(tmp_path / name)
    with pytest.raises(pc.PlannercheckError, match="does not exist"):
        read_mesh(tmp_path / "gone.stl")


@pytest.mark.parametrize("corners", [5, 6, 9, 30])
@pytest.mark.parametrize("times", [1, 2, 3])
@pytest.mark.parametrize("seed", range(5))
def test_concave_polygons_keep_their_area(corners: int, times: int, seed: int) -> None:
    """Stars in any plane: the triangles' areas add up to the polygon's, by the shoelace formula; a fan's do not.

    Nor does it matter how often each corner is given.
    """
    random = np.random.default_rng(seed)
    angles = np.sort(random.uniform(0, 2 * np.pi, corners))
    angles = 2 * np.pi * np.arange(corners) / corners + 0 * angles
    radii = np.where(np.arange(corners) % 2, random.uniform(0.2, 0.5, corners), 2)
    flat = np.column_stack([radii * np.cos(angles), radii * np.sin(angles), np.zeros(corners)])
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    points = flat @ turn.T
    given = np.repeat(np.roll(np.arange(corners), seed), times)
    triangles = triangles_of_polygons(points, np.array([corners * times]), given)
    a, b, c = (flat[triangles[:, k]] for k in range(3))
    areas = np.cross(b - a, c - a)[:, 2] / 2
    x, y = flat[:, 0], flat[:, 1]
    assert (areas >= -1e-12).all()
    assert areas.sum() == pytest.approx((x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2)


@pytest.mark.parametrize("depth", [0.0, 0.5])
def test_large_polygons_are_fans_where_fans_are_right(depth: float) -> None:
    """Rounded circles turn both ways, and so do circles with a notch that a fan would cover."""
    angles = 2 * np.pi * np.arange(3000) / 3000
    radii = np.where(np.arange(3000) == 1500, 1 - depth, 1.0)
    points = np.round(np.column_stack([radii * np.cos(angles), radii * np.sin(angles), 0 * angles]), 5)
    counts, corners = np.array([3000]), np.roll(np.arange(3000), 1400)
    if not depth:
        assert len(triangles_of_polygons(points, counts, corners)) == 2998
    else:
        with pytest.raises(pc.PlannercheckError, match=r"concave polygon of 3000 corners.*write triangles"):
            triangles_of_polygons(points, counts, corners)


@pytest.mark.parametrize(("height", "is_refused"), [(1.0, True), (0.0, False)])
def test_polygons_that_cross_themselves_are_refused(height: float, is_refused: bool) -> None:
    """One without area is next to nothing, and harmless."""
    corners = [[-2.0, 1], [1, 1], [2, -2], [0, 2], [-1, -2], [0, -2], [-1, 2]]
    points = np.array([[x, height * y, 0] for x, y in corners])
    with pytest.raises(pc.PlannercheckError, match="crosses itself") if is_refused else contextlib.nullcontext():
        triangles_of_polygons(points, np.array([7]), np.arange(7))


def test_points_that_no_triangle_uses_are_left_out(tmp_path: Path) -> None:
    for name in ("m.obj", "text.ply", "m.off", "m.dae"):
        mesh = read_mesh(
            write(tmp_path / name, np.vstack([CORNERS[:2], [[9, 9, 9]], CORNERS[2:]]), TRIANGLES + (TRIANGLES > 1))
        )
        assert rows(mesh.points) == rows(CORNERS)


def test_reading_is_reported_as_one_step(tmp_path: Path) -> None:
    said: list[tuple[int, int, str]] = []
    (tmp_path / "bad.stl").write_text("no mesh")
    with reported_to(lambda *report: said.append(report)):
        read_mesh(write(tmp_path / "m.off"))
        with pytest.raises(pc.PlannercheckError, match=r"bad\.stl"):
            read_mesh(tmp_path / "bad.stl")
    assert said == [(k, 1, f"reading mesh {name}") for name in ("m.off", "bad.stl") for k in (0, 1)]
