"""The verifier's own reader: faults of loading do not confirm themselves."""

import struct
from dataclasses import replace
from pathlib import Path

import coal
import exact_verdicts
import numpy as np
import pytest

import plannercheck as pc
from plannercheck.bodies import mesh_files
from plannercheck.motions.proof_builder import Builder
from plannercheck.motions.proof_confirmation import confirm_model
from plannercheck.proofs.faults import UnprovedError
from plannercheck.proofs.hull_containment import FlatError, point_outside
from plannercheck.proofs.mesh_triangles import NotReadError, mesh_triangles
from plannercheck.robots import geometry_elements, link_bodies

# ----- hulls


@pytest.mark.parametrize("seed", range(6))
def test_points_are_inside_exactly_where_whole_numbers_say_so(seed):
    rng = np.random.default_rng(seed)
    for _ in range(6):
        vertices = rng.integers(-3, 4, (12, 3)) * 0.1 if seed % 2 else rng.normal(size=(10, 3))
        weights = rng.dirichlet(np.full(3, 0.5), 8)
        on_hull = np.array([w @ vertices[rng.choice(len(vertices), 3, False)] for w in weights])
        around = np.concatenate([np.nextafter(on_hull, 9), np.nextafter(on_hull, -9), on_hull])
        for point in around:
            try:
                found = point_outside(vertices, point[None])
            except FlatError:
                break
            assert (found is None) == exact_verdicts.intersects(vertices, point)


def test_the_hull_is_closed_and_one_bit_counts():
    cube = np.array([[x, y, z] for x in (0, 0.1) for y in (0, 0.1) for z in (0, 0.1)])
    faces = np.array([[0.1, 0.03, 0.07], [0.0, 0.1, 0.05], [0.05, 0.05, 0.05], [-0.0, 0.0, 0.1]])
    assert point_outside(cube, faces) is None
    for k in range(3):
        beyond = np.full((1, 3), 0.05)
        beyond[0, k] = np.nextafter(0.1, 1)
        assert point_outside(cube, np.concatenate([faces, beyond])) == len(faces)
    with pytest.raises(FlatError):
        point_outside(cube * [1, 1, 0], faces)


# ----- meshes


# With a dent in its floor.
TETRAHEDRON = np.array([[0, 0, 0], [0.3, 0, 0], [0, 0.4, 0], [0.1, 0.1, 0.5], [0.1, 0.1, 0.1]])
FACES = np.array([[0, 2, 4], [2, 1, 4], [1, 0, 4], [0, 1, 3], [1, 2, 3], [2, 0, 3]])


def binary_stl(triangles):
    rows = [struct.pack("<12fH", 0, 0, 0, *each.ravel(), 0) for each in triangles]
    return bytes(80) + struct.pack("<I", len(rows)) + b"".join(rows)


def ascii_stl(triangles):
    facets = "".join(
        "facet normal 0 0 0\nouter loop\n" + "".join(f"vertex {x!r} {y!r} {z!r}\n" for x, y, z in each.tolist())
        + "endloop\nendfacet\n"
        for each in triangles
    )  # fmt: skip
    return f"solid x\n{facets}endsolid x\n".encode()


def obj(points, faces):
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in points.tolist()] + [
        "f " + " ".join(f"{k + 1}//1" for k in face) for face in faces
    ]
    return "\n".join(lines).encode()


def dae(points, faces, node="<instance_geometry url='#g'/>"):
    params = "".join(f"<param name='{name}' type='float'/>" for name in "XYZ")
    numbers = " ".join(map(repr, points.ravel().tolist()))
    corners = " ".join(str(k) for face in faces for k in face)
    return (
        "<COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema' version='1.4.1'><asset><up_axis>Z_UP</up_axis>"
        "</asset><library_geometries><geometry id='g'><mesh><source id='p'>"
        f"<float_array id='a' count='{points.size}'>{numbers}</float_array><technique_common><accessor source='#a' "
        f"count='{len(points)}' stride='3'>{params}</accessor></technique_common></source><vertices id='v'>"
        "<input semantic='POSITION' "
        f"source='#p'/></vertices><triangles count='{len(faces)}'><input semantic='VERTEX' source='#v' offset='0'/>"
        f"<p>{corners}</p></triangles></mesh></geometry></library_geometries><library_visual_scenes>"
        f"<visual_scene id='s'><node>{node}</node></visual_scene></library_visual_scenes><scene>"
        "<instance_visual_scene url='#s'/></scene></COLLADA>"
    ).encode()


CONTENTS = {
    "x.stl": binary_stl(TETRAHEDRON[FACES]),
    "words.stl": ascii_stl(TETRAHEDRON[FACES]),
    "x.obj": obj(TETRAHEDRON, FACES),
    "x.dae": dae(TETRAHEDRON, FACES),
}


@pytest.mark.parametrize("name", CONTENTS)
def test_triangles_are_those_of_the_file(tmp_path, name):
    path = tmp_path / name
    path.write_bytes(CONTENTS[name])
    found = mesh_triangles(path)
    wanted = TETRAHEDRON.astype(np.float32).astype(np.float64) if name == "x.stl" else TETRAHEDRON
    np.testing.assert_array_equal(found, wanted[FACES])
    # assimp reads single precision.
    mesh = coal.MeshLoader().load(str(path), np.ones(3))
    np.testing.assert_allclose(
        np.unique(mesh.vertices(), axis=0), np.unique(TETRAHEDRON, axis=0).astype(np.float32), atol=1e-7
    )


@pytest.mark.parametrize(
    ("name", "content", "why"),
    [
        ("x.ply", b"ply\n", "reads no .ply"),
        ("x.stl", CONTENTS["x.stl"][:-1], ""),
        ("x.stl", b"solid x\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\nendfacet", "other corners"),
        ("x.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4", "out of bounds"),
        ("x.obj", b"v 0 0 0\nv 1 0 0\nf 1 2", "fewer corners"),
        ("x.obj", b"v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3", "not finite"),
        ("x.obj", b"", "no triangles"),
        ("x.dae", dae(TETRAHEDRON, FACES, "<translate>0 0 1</translate><instance_geometry url='#g'/>"), "moved"),
        ("x.dae", dae(TETRAHEDRON, FACES, "<lookat/><instance_geometry url='#g'/>"), "moved"),
        ("x.dae", dae(TETRAHEDRON, FACES, "<instance_geometry url='#h'/>"), "h"),
        ("x.dae", b"<COLLADA>", ""),
    ],
)
def test_what_is_not_read_says_why(tmp_path, name, content, why):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(NotReadError, match=why):
        mesh_triangles(tmp_path / name)


# ----- robots


@pytest.fixture(params=["x.stl", "x.obj", "x.dae"])
def arm(request, tmp_path):
    """A robot of a mesh, a box, a ball and a cylinder, with a YAML; its path."""
    (tmp_path / request.param).write_bytes(CONTENTS[request.param])
    parts = [
        f"<mesh filename='{tmp_path / request.param}' scale='0.7 0.9 1.1'/>",
        "<box size='0.1 0.2 0.3'/>",
        "<sphere radius='0.1'/>",
        "<cylinder radius='0.05' length='0.2'/>",
    ]
    links = "".join(
        f"<link name='l{k}'><collision><origin xyz='0.1 0.2 0.3' rpy='0.4 0.5 {k}'/><geometry>{part}</geometry>"
        "</collision></link>"
        for k, part in enumerate(parts)
    )
    joints = "".join(
        f"<joint name='j{k}' type='revolute'><origin xyz='0 0 {k + 1}'/><parent link='l{k}'/><child link='l{k + 1}'/>"
        "<axis xyz='0 1 0'/><limit lower='-1' upper='1' effort='1' velocity='1'/></joint>"
        for k in range(3)
    )
    (tmp_path / "arm.urdf").write_text(f"<robot name='arm'>{links}{joints}</robot>")
    return str(tmp_path / "arm.urdf")


def model_of(path, **how):
    return Builder(pc.Checker(pc.Robot.load(path, **how)))._model


def test_robots_are_compared_by_the_verifiers_own_reader(arm):
    for geometry in ("hull", "solid"):
        compared = confirm_model(model_of(arm, geometry=geometry), arm, None, geometry=geometry)
        assert any("shapes of 4 bodies on links, to the last bit" in each for each in compared)
        assert not any("not read" in each for each in compared)


def scaled_meshes(monkeypatch):
    real = link_bodies.read_mesh
    monkeypatch.setattr(link_bodies, "read_mesh", lambda path, scale, units: real(path, [1.0, 1.0, 1.0], units))


def dropped_vertex(monkeypatch):
    real = link_bodies.Hull
    monkeypatch.setattr(link_bodies, "Hull", lambda points: real(points[points[:, 2] < points[:, 2].max()]))


def single_precision(monkeypatch):
    real = mesh_files._scaled
    monkeypatch.setattr(mesh_files, "_scaled", lambda p, f: real(p, f).astype(np.float32).astype(np.float64))


def diameters(monkeypatch):
    real = geometry_elements.Sphere
    monkeypatch.setattr(geometry_elements, "Sphere", lambda radius: real(radius / 2))


def half_boxes(monkeypatch):
    real = geometry_elements._three
    monkeypatch.setattr(
        geometry_elements, "_three", lambda e, key: tuple(x / (2 if key == "size" else 1) for x in real(e, key))
    )
    monkeypatch.setitem(geometry_elements._SHAPES_BY_TAG, "box", geometry_elements._box)


def thin_cylinders(monkeypatch):
    real = geometry_elements.Cylinder
    monkeypatch.setattr(geometry_elements, "Cylinder", lambda radius, length: real(radius * (1 - 1e-3), length))


def short_cylinders(monkeypatch):
    real = geometry_elements.Cylinder
    monkeypatch.setattr(geometry_elements, "Cylinder", lambda radius, length: real(radius, length * (1 - 1e-15)))


def moved_bodies(monkeypatch):
    real = link_bodies._placements

    def placements(model, file, kind):
        for name, pose, link, joint in real(model, file, kind):
            yield name, pose + 1e-9 * np.eye(4, k=3), link, joint

    monkeypatch.setattr(link_bodies, "_placements", placements)


FAULTS = (
    scaled_meshes,
    dropped_vertex,
    single_precision,
    diameters,
    half_boxes,
    thin_cylinders,
    short_cylinders,
    moved_bodies,
)


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_in_loading_does_not_confirm_itself(arm, monkeypatch, fault):
    # Both the maker of the proof and the comparison load with the fault.
    fault(monkeypatch)
    with pytest.raises(UnprovedError):
        confirm_model(model_of(arm), arm, None)


def changed(model, name, **changes):
    bodies = [replace(body, **changes) if body.name == name else body for body in model.bodies]
    return replace(model, bodies=tuple(bodies))


def test_triangles_of_solids_are_compared(arm, monkeypatch):
    # The comparison with what is loaded is left out: the verifier's own has to see it.
    monkeypatch.setattr("plannercheck.motions.proof_confirmation._compare_bodies", lambda *_: None)
    model = model_of(arm, geometry="solid")
    solid = next(body for body in model.bodies if body.triangles)
    turned = tuple(each[::-1] for each in solid.triangles)
    confirm_model(changed(model, solid.name, triangles=turned), arm, None, geometry="solid")
    for triangles in (solid.triangles[1:], (solid.triangles[0][::-1], *solid.triangles[1:])):
        with pytest.raises(UnprovedError, match="lacks triangles"):
            confirm_model(changed(model, solid.name, triangles=triangles), arm, None, geometry="solid")


@pytest.mark.parametrize("arm", ["x.obj"], indirect=True)
def test_what_is_not_compared_is_told(arm):
    folder = Path(arm).parent
    (folder / "x.off").write_text("OFF\n5 6 0\n" + "\n".join(" ".join(map(repr, p)) for p in TETRAHEDRON.tolist())
        + "\n" + "\n".join("3 " + " ".join(map(str, f)) for f in FACES.tolist()) + "\n")  # fmt: skip
    Path(arm).write_text(Path(arm).read_text().replace("x.obj", "x.off"))
    compared = confirm_model(model_of(arm), arm, None)
    assert any("not read by the verifier itself: 'l0_0': the verifier reads no .off" in each for each in compared)


@pytest.mark.filterwarnings("ignore:.*fixed to the world")
@pytest.mark.parametrize("name", ["panda", "pr2", "talos", "ur10", "go2"])
def test_shipped_robots_are_read_by_the_verifier_itself(name):
    compared = confirm_model(model_of(name), name, None)
    assert any("to the last bit, with" in each and "shapes of" in each for each in compared)
    assert not any("not read" in each or "own elements" in each for each in compared)
