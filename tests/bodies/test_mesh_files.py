"""Mesh files against what their formats define: places, sizes, names, and what is refused.

The oracles are the numbers that the files are written from, exact decimals, assimp (through coal), and trimesh.
"""

import struct
from pathlib import Path

import numpy as np
import pytest
from mesh_samples import CORNERS, FORMATS, TETRAHEDRON, TEXTS, TRIANGLES, assimp, dae, glb, gltf, rows, write

import plannercheck as pc
from plannercheck.bodies.mesh_files import read_mesh
from plannercheck.common.progress import reported_to


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
