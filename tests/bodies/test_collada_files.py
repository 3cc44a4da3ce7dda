"""Collada files against what the format defines: primitives, units, nodes, and what is refused."""

from pathlib import Path

import numpy as np
import pytest
from mesh_samples import CORNERS, PLACES, STRIP, TETRAHEDRON, TRIANGLES, assimp, dae, glb, gltf, primitive, rows

import plannercheck as pc
from plannercheck.bodies.mesh_files import read_mesh


@pytest.mark.parametrize("word", ["x", "-1", "4", "1.0", ""])
def test_indices_of_a_collada_file_are_whole(tmp_path: Path, word: str) -> None:
    """Named case: mesh_texts.py, where assimp never returns."""
    path = tmp_path / "m.dae"
    path.write_text(dae("0 0 0 1 0 0 0 2 0 0 0 3", primitive("triangles", [[0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]], 4)))
    path.write_text(path.read_text().replace("0 2 1 0", f"0 2 {word} 0"))
    with pytest.raises(pc.PlannercheckError, match=r"geometry 'g' has <triangles>"):
        read_mesh(path)


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
