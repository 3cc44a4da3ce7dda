"""What is read once is not read anew: compiled MJCF models and large meshes, by the content of all that went in."""

import io
import multiprocessing
import os
import shutil
import subprocess
import warnings
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from plannercheck.bodies import mesh_cache, mesh_files, mjcf_files, mjcf_inputs, mjcf_worker
from plannercheck.bodies.mesh_files import read_mesh
from plannercheck.common.errors import PlannercheckError

TETRA = np.array([[0.0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])

MAIN = """<mujoco model="arm"><compiler meshdir="meshes" texturedir="pictures"/>
<asset><mesh name="tetra" file="tetra.obj"/><hfield name="hills" file="../hills.bin" size="1 1 1 .1"/>
<model name="tool" file="tool/tool.xml"/><model name="hand" file="hand.urdf"/></asset>
<worldbody><geom type="hfield" hfield="hills"/>
<body name="base"><joint type="slide" axis="0 0 1"/><geom type="mesh" mesh="tetra"/>
<frame pos="0 0 1"><attach model="tool" body="grip" prefix="t/"/></frame>
<attach model="hand" body="palm" prefix="h/"/></body></worldbody>
<include file="more.xml"/></mujoco>"""
MORE = """<mujoco><worldbody><body name="more" pos="0 0 3"><joint type="slide"/><geom size="SIZE"/></body></worldbody>
</mujoco>"""
TOOL = """<mujoco><asset><mesh name="part" file="part.obj"/></asset>
<worldbody><body name="grip"><geom type="mesh" mesh="part"/></body></worldbody></mujoco>"""

HAND = """<robot name="hand"><link name="rest"/><joint name="j" type="fixed"><parent link="rest"/>
<child link="palm"/></joint><link name="palm"><collision><geometry>
<mesh filename="palm.obj"/></geometry></collision></link></robot>"""


def obj_text(points) -> str:
    corners = "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in np.asarray(points).tolist())
    return corners + "".join(f"f {a} {b} {c}\n" for a, b, c in (FACES + 1).tolist())


@pytest.fixture
def cache(tmp_path, monkeypatch):
    folder = tmp_path / "cache"
    monkeypatch.setenv("PLANNERCHECK_CACHE", str(folder))
    return folder


@pytest.fixture
def model(tmp_path) -> Path:
    folder = tmp_path / "model"
    for sub in ("meshes", "tool", "pictures"):
        (folder / sub).mkdir(parents=True)
    (folder / "main.xml").write_text(MAIN)
    (folder / "more.xml").write_text(MORE.replace("SIZE", "0.1"))
    (folder / "tool" / "tool.xml").write_text(TOOL)
    (folder / "tool" / "part.obj").write_text(obj_text(TETRA))
    (folder / "hand.urdf").write_text(HAND)
    (folder / "palm.obj").write_text(obj_text(TETRA))
    (folder / "meshes" / "tetra.obj").write_text(obj_text(TETRA))
    (folder / "hills.bin").write_bytes(np.array([2, 2], "<i4").tobytes() + np.array([0, 1, 2, 3], "<f4").tobytes())
    return folder / "main.xml"


def content(path):
    """What the worker would write."""
    out = io.BytesIO()
    np.savez(out, said=np.array(""), **mjcf_worker.compiled(Path(path)))
    return out.getvalue()


def in_a_fork(module, arguments):
    """Starting the worker takes longer than all of a test; this process itself would have MuJoCo's cache of meshes."""
    with ProcessPoolExecutor(1, multiprocessing.get_context("fork")) as pool:
        return subprocess.CompletedProcess(arguments, 0, pool.submit(content, arguments[0]).result(), b"")


@pytest.fixture(params=[in_a_fork])
def compilations(request, monkeypatch):
    """The files that were compiled."""
    compiled = []

    def counted(module, arguments):
        compiled.append(arguments[0])
        return request.param(module, arguments)

    monkeypatch.setattr(mjcf_files, "run_isolated", counted)
    return compiled


def same(a, b) -> bool:
    return a.names == b.names and all(np.array_equal(getattr(a, f), getattr(b, f)) for f in mjcf_files.FIELDS)


def test_a_model_is_compiled_once(model, cache, compilations):
    first = mjcf_files.read_mjcf(model)
    assert same(mjcf_files.read_mjcf(model), first)
    moved = model.parent.with_name("moved")
    shutil.copytree(model.parent, moved)
    assert same(mjcf_files.read_mjcf(moved / "main.xml"), first)
    assert mjcf_files.read_mjcf(moved / "main.xml").path == moved / "main.xml"
    assert compilations == [str(model)]


@pytest.mark.parametrize(
    "where", ["main.xml", "more.xml", "tool/tool.xml", "tool/part.obj", "meshes/tetra.obj", "palm.obj", "hills.bin"]
)
def test_a_change_of_any_file_compiles_anew(model, cache, compilations, where):
    """The content decides, not the time."""
    file = model.parent / where
    first = mjcf_files.read_mjcf(model)
    content, stat = file.read_bytes(), file.stat()
    changes = {
        "main.xml": (b"0 0 1", b"0 0 2"),
        "more.xml": (b"0.1", b"0.2"),
        "tool/tool.xml": (b"</mujoco>", b"</mujoco>\n"),
        "hills.bin": (content[-1:], b"\x41"),
    }
    old, new = changes.get(where, (b"0.1", b"0.2"))
    file.write_bytes(content.replace(old, new))
    os.utime(file, ns=(stat.st_atime_ns, stat.st_mtime_ns))
    second = mjcf_files.read_mjcf(model)
    assert len(compilations) == 2
    assert same(first, second) == (where == "tool/tool.xml")
    mjcf_files.read_mjcf(model)
    assert len(compilations) == 2


def test_a_file_that_takes_the_place_of_another_compiles_anew(model, cache, compilations):
    """The mesh is found in `meshdir`; a file that comes to lie elsewhere may be the one that counts."""
    mjcf_files.read_mjcf(model)
    (model.parent / "tetra.obj").write_text(obj_text(2 * TETRA))
    mjcf_files.read_mjcf(model)
    assert len(compilations) == 2


def test_another_version_of_mujoco_compiles_anew(model, cache, compilations, monkeypatch):
    mjcf_files.read_mjcf(model)
    monkeypatch.setattr(mjcf_inputs.importlib.metadata, "version", lambda name: "99.0")
    mjcf_files.read_mjcf(model)
    assert len(compilations) == 2


@pytest.mark.parametrize("compilations", [mjcf_files.run_isolated], indirect=True)
def test_what_mujoco_says_is_said_again_and_errors_are_found_again(tmp_path, cache, compilations):
    path = tmp_path / "odd.xml"
    path.write_text(
        '<mujoco><worldbody><body><joint name="a"/><geom size="1"/></body></worldbody>'
        '<keyframe><key name="k" qpos="0"/></keyframe></mujoco>'
    )
    said = []
    for _ in range(2):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            mjcf_files.read_mjcf(path)
        said.append([str(each.message) for each in caught])
    assert said[0] == said[1]
    path.write_text('<mujoco><worldbody><geom size="nonsense"/></worldbody></mujoco>')
    before = len(compilations)
    for _ in range(2):
        with pytest.raises(PlannercheckError, match="does not compile"):
            mjcf_files.read_mjcf(path)
    assert len(compilations) == before + 2


def test_where_it_is_not_sure_what_goes_in_nothing_is_cached(tmp_path, cache, compilations, monkeypatch):
    path = tmp_path / "entity.xml"
    body = '<worldbody><body><joint/><geom size="1"/></body></worldbody>'
    path.write_text(f"<!DOCTYPE mujoco><mujoco>{body}</mujoco>")
    assert mjcf_inputs.compiled_file(path, "") is None
    path.write_text(f'<mujoco><asset><mesh name="m" file="nowhere.obj"/></asset>{body}</mujoco>')
    assert mjcf_inputs.compiled_file(path, "") is None
    path.write_text(f"<mujoco>{body}</mujoco>")
    assert mjcf_inputs.compiled_file(path, "") is not None
    monkeypatch.setenv("PLANNERCHECK_CACHE", "0")
    assert mjcf_inputs.compiled_file(path, "") is None
    for _ in range(2):
        mjcf_files.read_mjcf(path)
    assert len(compilations) == 2


def test_a_circle_of_includes_ends(tmp_path, cache):
    (tmp_path / "a.xml").write_text('<mujoco><include file="b.xml"/></mujoco>')
    (tmp_path / "b.xml").write_text('<mujoco><include file="a.xml"/></mujoco>')
    assert mjcf_inputs.compiled_file(tmp_path / "a.xml", "") is not None


# ----- meshes

DAE = """<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="inch" meter="0.0254"/><up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="12">POINTS</float_array><technique_common>
<accessor source="#a" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/><p>FACES</p></triangles></mesh></geometry>
</library_geometries><library_visual_scenes><visual_scene id="s"><node><instance_geometry url="#g"/></node>
</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>"""


def numbers(rows) -> str:
    return "\n".join(" ".join(map(repr, row)) for row in np.asarray(rows).tolist()) + "\n"


def text_of(ending: str) -> str:
    triples = "".join(f"3 {row}\n" for row in numbers(FACES).splitlines())
    if ending == ".obj":
        return obj_text(TETRA)
    if ending == ".off":
        return f"OFF\n4 4 0\n{numbers(TETRA)}{triples}"
    if ending == ".ply":
        head = "".join(f"property double {axis}\n" for axis in "xyz")
        return (
            f"ply\nformat ascii 1.0\nelement vertex 4\n{head}element face 4\n"
            f"property list uchar int vertex_indices\nend_header\n{numbers(TETRA)}{triples}"
        )
    if ending == ".stl":
        facets = ["".join(f"vertex {row}\n" for row in numbers(TETRA[face]).splitlines()) for face in FACES]
        return (
            "solid s\n"
            + "".join(f"facet normal 0 0 0\nouter loop\n{f}endloop\nendfacet\n" for f in facets)
            + "endsolid s\n"
        )
    return DAE.replace("POINTS", numbers(TETRA)).replace("FACES", numbers(FACES))


@pytest.mark.parametrize("ending", [".obj", ".off", ".ply", ".stl", ".dae"])
def test_a_large_mesh_is_read_once(tmp_path, cache, monkeypatch, ending):
    monkeypatch.setattr(mesh_cache, "_LARGE", 10)
    calls = []
    if ending == ".dae":
        read = mesh_files.objects_of_collada
        monkeypatch.setattr(mesh_files, "objects_of_collada", lambda content: calls.append(ending) or read(content))
    else:
        plain = mesh_files._PLAIN[ending]
        monkeypatch.setitem(mesh_files._PLAIN, ending, lambda content: calls.append(ending) or plain(content))
    path = tmp_path / f"mesh{ending}"
    path.write_text(text_of(ending))
    given = [{"units": "file"}, {"units": "metre"}, {"units": "file", "scale": [1.0, 2.0, -3.0]}]
    first = [read_mesh(path, **each) for each in given]
    assert len(calls) == 1
    monkeypatch.setenv("PLANNERCHECK_CACHE", "0")
    for mesh, each in zip(first, given, strict=True):
        uncached = read_mesh(path, **each)
        assert mesh.conversion == uncached.conversion
        assert [o.name for o in mesh.objects] == [o.name for o in uncached.objects]
        np.testing.assert_array_equal(mesh.points, uncached.points)
        np.testing.assert_array_equal(mesh.triangles, uncached.triangles)
        assert mesh.points.dtype == uncached.points.dtype
        assert mesh.triangles.dtype == uncached.triangles.dtype
    monkeypatch.setenv("PLANNERCHECK_CACHE", str(cache))
    path.write_text(text_of(ending).replace("0.1", "0.2", 1))
    before = len(calls)
    changed = read_mesh(path)
    assert len(calls) == before + 1
    assert not np.array_equal(changed.points, first[0].points)


def test_small_meshes_and_faulty_ones_are_not_cached(tmp_path, cache, monkeypatch):
    (tmp_path / "small.obj").write_text(obj_text(TETRA))
    read_mesh(tmp_path / "small.obj")
    assert not list(cache.glob("*.mesh"))
    monkeypatch.setattr(mesh_cache, "_LARGE", 10)
    (tmp_path / "bad.obj").write_text(obj_text(TETRA) + "f 1 2 9\n")
    for _ in range(2):
        with pytest.raises(PlannercheckError, match=r"bad\.obj"):
            read_mesh(tmp_path / "bad.obj")
    assert not list(cache.glob("*.mesh"))
