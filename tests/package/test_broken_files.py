"""Broken files that once ended in a traceback, a full memory or another run's verdicts: one error each."""

import json
import struct
import warnings
import zipfile
from pathlib import Path

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.bodies.mesh_files import read_mesh
from plannercheck.cli import main as cli
from plannercheck.common.checked_yaml import parse_yaml
from plannercheck.evaluation.campaign.cases import load
from plannercheck.evaluation.stress.campaign import campaign
from plannercheck.ompl.plans import Plan
from plannercheck.proofs import load_proofs
from plannercheck.proofs.urdf_joints import read_tree
from plannercheck.scenes.motion_bench_maker import load_problems
from plannercheck.validation import outputs
from plannercheck.validation.formats.chunks import read_chunks
from plannercheck.validation.formats.paths import read_path

HUGE = "9" * 400  # a whole number beyond all doubles
DEEP = "[" * 100_000 + "]" * 100_000
URDF = '<robot name="r"><link name="a"/></robot>'


def test_whole_numbers_beyond_all_doubles(tmp_path: Path) -> None:
    scene, path, plan = (tmp_path / name for name in ("s.yaml", "path.json", "plan.json"))
    scene.write_text(f"objects: [{{name: a, sphere: {{radius: {HUGE}}}}}]")
    path.write_text(f"[[{HUGE}, 0]]")
    plan.write_text(f'{{"joint_names": ["a"], "path": [[{HUGE}]]}}')
    with pytest.raises(pc.PlannercheckError, match="must be a number"):
        pc.Scene.load(scene)
    with pytest.raises(pc.PlannercheckError, match="no table of numbers"):
        read_path(path, ("a", "b"), 2)
    with pytest.raises(pc.PlannercheckError, match="no plan"):
        Plan.load(plan)
    with pytest.raises(pc.PlannercheckError, match="must be 7 numbers"):
        pc.Checker(pc.Robot.load("panda")).is_valid([10**400] * 7)


def test_a_plan_that_is_nested_deep(tmp_path: Path) -> None:
    (tmp_path / "p.json").write_text(DEEP)
    with pytest.raises(pc.PlannercheckError, match="no plan"):
        Plan.load(tmp_path / "p.json")


@pytest.mark.parametrize("content", ["{", "[]", "{}", DEEP, '{"campaign": "pairs", "p": [1]}', '{"campaign": [1]}'])
def test_kept_cases(tmp_path: Path, content: str) -> None:
    (tmp_path / "c.json").write_text(content)
    with pytest.raises(pc.PlannercheckError, match="no case of a stress"):
        load(tmp_path / "c.json", {"pairs": lambda: campaign(0)})


@pytest.mark.parametrize("method", [99, zipfile.ZIP_DEFLATED])
def test_an_npz_whose_compression_is_broken(tmp_path: Path, method: int) -> None:
    """Of another method, and of bytes that can't be unpacked."""
    path = tmp_path / "p.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("document.npy", bytes(1000))
    content = path.read_bytes()
    if method == 99:
        wrong = struct.pack("<H", method)
        content = content.replace(struct.pack("<H", zipfile.ZIP_DEFLATED), wrong)
    else:
        at = content.index(b"document.npy") + len("document.npy")
        content = content[:at] + b"\xff" * 4 + content[at + 4 :]
    path.write_bytes(content)
    for read in (load_proofs, lambda file: list(read_chunks(file, ("a",), 1))):
        with pytest.raises(pc.PlannercheckError):
            read(path)


@pytest.mark.parametrize("encoding", ["no-such-encoding", "utf-32", "base64"])
def test_xml_in_an_encoding_that_is_none(tmp_path: Path, encoding: str) -> None:
    urdf, srdf = tmp_path / "r.urdf", tmp_path / "r.srdf"
    urdf.write_text(URDF)
    srdf.write_text(f'<?xml version="1.0" encoding="{encoding}"?>{URDF}')
    with pytest.raises(pc.PlannercheckError, match="does not parse"):
        pc.Robot.from_urdf(urdf, srdf)
    with pytest.raises(pc.PlannercheckError, match="can't be read"):
        read_tree(srdf)
    with pytest.raises(pc.PlannercheckError, match=r"r\.srdf does not parse: it is no XML"):
        pc.Robot.from_urdf(srdf)


def test_names_of_files_that_no_file_can_have(tmp_path: Path) -> None:
    long = "a" * 5000
    (tmp_path / "r.yaml").write_text(f"urdf: {long}.urdf")
    (tmp_path / "s.yaml").write_text(f"objects: [{{name: a, mesh: {{file: {long}.stl}}}}]")
    readers = (
        lambda: pc.Robot.load(tmp_path / "r.yaml"),
        lambda: pc.Scene.load(tmp_path / "s.yaml"),
        lambda: pc.Scene.load(long),
        lambda: pc.Robot.load(f"{long}.yaml"),
        lambda: load_problems(tmp_path / long),
        lambda: list(read_chunks(tmp_path / f"{long}.npy", ("a",), 1)),
    )
    for read in readers:
        with pytest.raises(pc.PlannercheckError):
            read()


def test_an_error_does_not_repeat_a_name_of_any_length(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(f"{'a' * 100_000}: 1")
    (tmp_path / "q.csv").write_text(f"a,{'b' * 100_000}\n1,2\n")
    for read in (
        lambda: pc.Scene.load(tmp_path / "s.yaml"),
        lambda: list(read_chunks(tmp_path / "q.csv", ("a", "c"), 2)),
    ):
        with pytest.raises(pc.PlannercheckError) as caught:
            read()
        assert len(str(caught.value)) < 1000


def test_a_robot_without_joints() -> None:
    robot = pc.planar.Robot([[0, 0], [1, 0], [0, 1]])
    fixed = pc.planar.Robot([pc.planar.Link("base", [[0, 0], [1, 0], [0, 1]])])
    assert robot.nq == 3
    assert fixed.check_configurations(np.zeros(0)).shape == (1, 0)
    assert fixed.check_configurations(np.zeros((4, 0))).shape == (4, 0)
    assert pc.planar.Checker(fixed, pc.planar.Scene()).is_valid(np.zeros(0))


def test_a_scene_whose_matrix_is_about_links_is_read_as_it_was_written(tmp_path: Path) -> None:
    scene = pc.Scene()
    scene.allow("panda_link1", "panda_link3")
    scene.save(tmp_path / "s.yaml")
    assert pc.Scene.load(tmp_path / "s.yaml").allowed.pairs == scene.allowed.pairs


def _run(folder: Path, scene: str, output: str, monkeypatch: pytest.MonkeyPatch) -> tuple[int, bytes]:
    """A run of `validate`: its exit code, and its journal as it was at the end."""
    place = folder / output
    journal: list[bytes] = []
    write = outputs.write_atomically

    def keep(path: Path, *arguments: object) -> None:
        journal.append(Path(f"{place}.progress").read_bytes())
        write(path, *arguments)  # type: ignore[arg-type]

    with monkeypatch.context() as patch, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        patch.setattr(outputs, "write_atomically", keep)
        code = cli.main(
            [
                "validate",
                "--robot",
                "panda",
                "--scene",
                scene,
                str(folder / "q.npy"),
                "--output",
                str(place),
                "--resume",
            ]
        )
    return code, journal[0] if journal else b""


def test_records_of_another_run_are_none_of_this_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Their rows are the same, so that only the journal's first line tells the runs apart."""
    np.save(tmp_path / "q.npy", pc.Robot.load("panda").random_configurations(300, 0))
    _, mine = _run(tmp_path, "bookshelf", "mine.npz", monkeypatch)
    _, others = _run(tmp_path, "table", "others.npz", monkeypatch)
    first, rest = mine[: mine.index(b"\n") + 1], others[others.index(b"\n") + 1 :]
    (tmp_path / "again.npz.progress").write_bytes(first + rest)
    _run(tmp_path, "bookshelf", "again.npz", monkeypatch)
    assert (tmp_path / "again.npz").read_bytes() == (tmp_path / "mine.npz").read_bytes()
    assert (tmp_path / "again.npz").read_bytes() != (tmp_path / "others.npz").read_bytes()


def test_a_damaged_length_in_a_journal_takes_no_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import tracemalloc

    np.save(tmp_path / "q.npy", pc.Robot.load("panda").random_configurations(300, 0))
    _, journal = _run(tmp_path, "bookshelf", "a.npz", monkeypatch)
    at = journal.index(b"\n") + 1
    (tmp_path / "b.npz.progress").write_bytes(journal[:at] + struct.pack("<II", 2**31, 2**31) + journal[at + 8 :])
    tracemalloc.start()
    try:
        _run(tmp_path, "bookshelf", "b.npz", monkeypatch)
        assert tracemalloc.get_traced_memory()[1] < 1 << 28
    finally:
        tracemalloc.stop()
    assert (tmp_path / "b.npz").read_bytes() == (tmp_path / "a.npz").read_bytes()


def test_yaml_of_huge_numbers_is_read() -> None:
    assert parse_yaml(json.dumps({"a": 10**400})) == {"a": 10**400}


def _ply(form: str, corners: int = 4, last: int = 3, kept: int = -1) -> bytes:
    """A tetrahedron; `corners` and `last` are those of its last face, `kept` the bytes that are left of it."""
    head = f"ply\nformat {form} 1.0\ncomment x\nelement vertex 4\nproperty float x\nproperty float y\n"
    head += "property float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n"
    points = [[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [*[1, 2, 3, 0][: corners - 1], last]]
    if form == "ascii":
        lines = [*points, *([len(face), *face] for face in faces)]
        body = "".join(" ".join(map(str, line)) + "\n" for line in lines).encode()
    else:
        order = "<" if "little" in form else ">"
        body = np.array(points, dtype=f"{order}f4").tobytes()
        body += b"".join(bytes([len(face)]) + np.array(face, dtype=f"{order}i4").tobytes() for face in faces)
    return head.encode() + (body if kept < 0 else body[:kept])


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_ply_files_that_crash_their_readers(tmp_path: Path, form: str) -> None:
    """Faces of vertices that are not there, and files that are cut short, are refused before assimp sees them."""

    path, urdf = tmp_path / "m.ply", tmp_path / "r.urdf"
    urdf.write_text(
        '<robot name="r"><link name="a"><collision><geometry><mesh filename="m.ply"/></geometry></collision></link>'
        "</robot>"
    )
    for corners in (3, 4):
        path.write_bytes(_ply(form, corners))
        assert set(map(tuple, read_mesh(path).points.tolist())) == {(0, 0, 0), (0, 0, 1), (0, 1, 0), (1, 0, 0)}
        assert len(pc.Robot.from_urdf(urdf).bodies) == 1
    broken = [_ply(form, 3, last) for last in (4, -1, 2**31 - 1)] + [_ply(form, kept=kept) for kept in (0, 2, 40, 45)]
    broken += [_ply(form, 1), _ply(form).replace(b"vertex 4", b"vertex 9"), _ply(form).replace(b"float z", b"float y")]
    for content in broken:
        path.write_bytes(content)
        with pytest.raises(pc.PlannercheckError):
            read_mesh(path)
        with pytest.raises(pc.PlannercheckError, match=r"m\.ply"):
            pc.Robot.from_urdf(urdf)


def test_an_error_about_a_urdf_does_not_repeat_a_number_of_any_length(tmp_path: Path) -> None:
    urdf = tmp_path / "r.urdf"
    joint = f'<joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 {400 * "9"}"/></joint>'
    urdf.write_text(URDF.replace("</robot>", f'<link name="b"/>{joint}</robot>'))
    with pytest.raises(pc.PlannercheckError, match="must be 3 numbers") as caught:
        read_tree(urdf)
    assert len(str(caught.value)) < 500


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("ompl.txt", f"Geometric path with {5000 * '9'} states\nRealVectorState [0 0]\n", "states hold 2 numbers"),
        ("plan.json", json.dumps({"joint_names": ["a", 5000 * "9"], "path": [[0, 0]]}), "has no joint 'b'"),
        ("display.json", json.dumps({"header": {}, 5000 * "9": 0, "points": []}), "display"),
    ],
)
def test_paths_with_names_and_numbers_of_any_length(tmp_path: Path, name: str, content: str, said: str) -> None:
    (tmp_path / name).write_text(content)
    with pytest.raises(pc.PlannercheckError, match=said) as caught:
        read_path(tmp_path / name, ("a", "b"), 2)
    assert len(str(caught.value)) < 1000


def test_parquet_with_a_name_twice(tmp_path: Path) -> None:
    arrow, parquet = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    table = arrow.Table.from_arrays([arrow.array([0.0])] * 3, names=["a", "b", "a"])
    parquet.write_table(table, tmp_path / "q.parquet")
    with pytest.raises(pc.PlannercheckError):
        list(read_chunks(tmp_path / "q.parquet", ("a", "b"), 1))


def test_meshes_whose_words_are_of_any_length(tmp_path: Path) -> None:
    (tmp_path / "a.stl").write_text(f"solid a\nfacet normal 0 0 1\nouter loop\nvertex [ {6000 * '9'} 0\n")
    (tmp_path / "a.ply").write_bytes(
        b"ply\nformat ascii 1.0\nelement " + 5000 * b"9" + b" 3\nproperty float x\nend_header\n"
    )
    for name in ("a.stl", "a.ply"):
        with pytest.raises(pc.PlannercheckError) as caught:
            read_mesh(tmp_path / name)
        assert len(str(caught.value)) < 1000
