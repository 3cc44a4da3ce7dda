"""STL, OBJ and PLY files against what their formats define: words, faces, lists, and what is refused."""

import struct
from pathlib import Path

import numpy as np
import pytest
from mesh_samples import CORNERS, TRIANGLES, write

import plannercheck as pc
from plannercheck.bodies.mesh_files import read_mesh

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


@pytest.mark.parametrize("index", ["3.5", "x", "-1", "4"])
def test_indices_of_a_ply_are_whole(tmp_path: Path, index: str) -> None:
    path = write(tmp_path / "text.ply")
    path.write_text(path.read_text().replace("3 1 2 3\n", f"3 1 2 {index}\n"))
    with pytest.raises(pc.PlannercheckError, match="face"):
        read_mesh(path)
    path.write_text(path.read_text().replace(f"3 1 2 {index}\n", "3 1 2 3.0\n"))
    assert len(read_mesh(path).triangles) == 4


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
