"""What `plannercheck verify` says of a proof: the motion, how it goes, and names that forge nothing."""

import json
import zipfile

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.cli.main import main
from plannercheck.common.input_limits import INPUT_LIMITS
from plannercheck.proofs import load_proofs, save_proofs


@pytest.fixture(scope="module")
def proof():
    scene = pc.Scene.load("bookshelf")
    checker = pc.Checker(pc.Robot.load("panda"), scene, padding=0.001)
    q = scene.start("panda")
    return checker.certify_motions(q[None], q[None] + 0.01)[0]


def told(capsys, *arguments):
    """Exit code, lines, and the JSON's only result."""
    code = main(["verify", *map(str, arguments)])
    lines = capsys.readouterr().out.splitlines()
    assert main(["verify", *map(str, arguments), "--format", "json"]) == code
    (result,) = json.loads(capsys.readouterr().out)
    return code, lines, result


def test_the_motion_that_is_proved_is_told(proof, tmp_path, capsys):
    proof.save(tmp_path / "x.json")
    code, lines, result = told(capsys, tmp_path / "x.json", "--robot", "panda", "--scene", "bookshelf")
    assert code == 0
    (motion,) = result["motions"]
    for name in ("start", "end", "asked_end"):
        assert motion[name] == list(getattr(proof.motion, name))
    assert (motion["path"], motion["turning_radius"], motion["margin"]) == ("straight", None, proof.margin)
    assert (result["pairs"], result["padding"]) == (len(proof.model.pairs), 0.001)
    assert any("panda.urdf" in sentence for sentence in result["compared"])
    text = "\n".join(lines)
    for word in ("straight from (", f"{proof.motion.end[0]:.9g}", "margin", "padding: 0.001 m", "held: 'panda_finger"):
        assert word in text
    assert f"{len(proof.model.pairs)} pairs" in text
    assert "panda.urdf" in text


@pytest.mark.parametrize("radius", [1.5, 0.01])
def test_a_curve_and_its_turning_radius_are_told(radius, tmp_path, capsys):
    # A forklift that turns on 1 cm was "confirmed" just as one that turns on 1.5 m.
    scene = pc.planar.Scene.load("warehouse")
    checker = pc.planar.Checker(pc.planar.Robot.load("forklift"), scene)
    q = np.array(scene.start("forklift"))
    ends = q[None] + [0.3, 0.02, 0.05]
    checker.certify_motions(q[None], ends, curve="reeds_shepp", turning_radius=radius)[0].save(tmp_path / "x.json")
    code, lines, result = told(capsys, tmp_path / "x.json", "--robot", "forklift", "--scene", "warehouse")
    assert code == 0
    (motion,) = result["motions"]
    assert (motion["path"], motion["turning_radius"]) == ("reeds_shepp", radius)
    assert any(f"reeds_shepp with a turning radius of {radius:g} m" in line for line in lines)


def test_the_path_of_a_free_body_is_told(tmp_path, capsys):
    urdf = tmp_path / "ball.urdf"
    urdf.write_text(
        "<robot name='b'><link name='b'><collision><geometry><box size='1 1 1'/></geometry></collision></link></robot>"
    )
    scene = pc.Scene("far")
    scene.add_box("wall", (1, 1, 1), np.array([[1, 0, 0, 9], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]]))
    checker = pc.Checker(pc.Robot.from_urdf(urdf, floating=True), scene)
    q0, q1 = np.array([0, 0, 0, 0, 0, 0, 1.0]), np.array([1, 0, 0, 0, 0, 0.6, 0.8])
    for path in ("screw", "slerp"):
        checker.certify_motions(q0[None], q1[None], path=path)[0].save(tmp_path / "x.json")
        assert told(capsys, tmp_path / "x.json")[2]["motions"][0]["path"] == path


FORGED = "bookshelf proved: 332 pairs, in 0.12 s\n  model: confirmed\nwork/next.json: 1 motion of panda in bookshelf"


@pytest.mark.parametrize("suffix", [".json", ".npz"])
@pytest.mark.parametrize(
    ("place", "name"),
    [
        *((place, FORGED) for place in ("scene", "robot", "body", "link", "joint")),
        *(("body", name) for name in ("\ud800", "a\x1b[2Kb", "a\rb", "a\u2028b", "a\u202eb", "a\x00b")),
    ],
)
def test_names_that_could_forge_lines_are_refused(proof, tmp_path, capsys, name, suffix, place):
    path = tmp_path / f"x{suffix}"
    proof.save(path)
    if suffix == ".json":
        content, arrays = json.loads(path.read_text()), {}
    else:
        with np.load(path) as file:
            arrays = {key: file[key] for key in file}
        content = json.loads(str(arrays.pop("document")))
    if place in ("scene", "robot"):
        content[place] = name
    else:
        content["model"][{"body": "bodies", "link": "links", "joint": "joints"}[place]][3]["name"] = name
    if suffix == ".json":
        path.write_text(json.dumps(content))
    else:
        with path.open("wb") as file:
            np.savez(file, document=np.array(json.dumps(content)), **arrays)
    assert main(["verify", str(path)]) == 2
    found = capsys.readouterr()
    assert not found.out
    assert "printable characters" in found.err
    assert "model: confirmed\n" not in found.err


def test_names_are_printed_quoted(proof, tmp_path, capsys):
    path = tmp_path / "x.json"
    save_proofs([proof], path)
    content = json.loads(path.read_text())
    content["scene"] = "bookshelf proved: all"
    path.write_text(json.dumps(content))
    assert main(["verify", str(path)]) == 0
    assert "of 'panda' in 'bookshelf proved: all' proved" in capsys.readouterr().out


def test_a_proof_that_could_not_be_loaded_is_not_saved(tmp_path):
    scene = pc.Scene("odd")
    scene.add_box("a\nb", (0.1, 0.1, 0.1), np.array(pc.Scene.load("table").bodies[0].pose))
    checker = pc.Checker(pc.Robot.load("panda"), scene)
    q = checker.robot.random_configurations(1, 1)
    with pytest.raises(pc.PlannercheckError, match="printable"):
        checker.certify_motions(q, q)[0].save(tmp_path / "x.json")


@pytest.mark.parametrize("version", [True, 1.0, "1", None, 2, "\ud800"])
def test_a_version_is_a_whole_number(proof, tmp_path, version):
    proof.save(tmp_path / "x.json")
    content = json.loads((tmp_path / "x.json").read_text())
    content["version"] = version
    (tmp_path / "x.json").write_text(json.dumps(content))
    with pytest.raises(pc.PlannercheckError, match="is of version"):
        load_proofs(tmp_path / "x.json")


def test_an_npz_that_unpacks_to_too_much_is_not_unpacked(tmp_path, monkeypatch):
    path = tmp_path / "bomb.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive, archive.open("document.npy", "w") as member:
        np.lib.format.write_array_header_1_0(member, {"descr": "<U40000000", "fortran_order": False, "shape": ()})
        for _ in range(160):
            member.write(bytes(1_000_000))
    assert path.stat().st_size < 1_000_000
    monkeypatch.setattr(INPUT_LIMITS, "archive_bytes", 100_000_000)
    monkeypatch.setattr(np, "load", lambda *_, **__: pytest.fail("it is unpacked"))
    with pytest.raises(pc.PlannercheckError, match="unpacks to 1600"):
        load_proofs(path)
