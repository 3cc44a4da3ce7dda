"""Proofs of motions in files: the same bits back, errors for what is no proof, and both commands."""

import dataclasses
import json
import shutil
import sys
import typing
from dataclasses import fields, is_dataclass, replace

import numpy as np
import pytest
from proof_cases import free_motions, random_tree, scattered

import plannercheck as pc
from plannercheck.cli.main import main
from plannercheck.motions.proof_builder import Builder
from plannercheck.motions.proof_confirmation import confirm_model
from plannercheck.proofs import Proof, load_proofs, save_proofs
from plannercheck.proofs.exact_placements import off_placement
from plannercheck.proofs.faults import UnprovedError
from plannercheck.proofs.hashing import content_hash
from plannercheck.proofs.plain_data import from_plain
from plannercheck.proofs.urdf_joints import read_tree


@pytest.fixture(scope="module")
def checker():
    return pc.Checker(pc.Robot.load("ur5"), pc.Scene.load("table"))


@pytest.fixture(scope="module")
def proofs(checker):
    return checker.certify_motions(*free_motions(checker, 3, 1))


def same(a, b):
    """Whether two values are of the same types and bits, all the way down."""
    if type(a) is not type(b):
        return False
    if isinstance(a, np.ndarray):
        return a.shape == b.shape and a.tobytes() == b.tobytes()
    if is_dataclass(a):
        return all(same(getattr(a, field.name), getattr(b, field.name)) for field in fields(a))
    if isinstance(a, tuple):
        return len(a) == len(b) and all(same(x, y) for x, y in zip(a, b, strict=True))
    return a.hex() == b.hex() if isinstance(a, float) else a == b


@pytest.mark.parametrize("suffix", ["json", "npz"])
def test_a_proof_comes_back_with_the_same_bits(proofs, tmp_path, suffix):
    path = tmp_path / f"one.{suffix}"
    proofs[0].save(path)
    assert same(Proof.load(path), proofs[0])
    assert Proof.load(path).verify()
    odd = replace(
        proofs[0], margin=np.nextafter(1e-300, 1), motion=replace(proofs[0].motion, start=(-0.0, 5e-324, 0.1))
    )
    odd = replace(odd, margin=float(odd.margin))
    odd.save(path)
    assert same(Proof.load(path), odd)


@pytest.mark.parametrize("suffix", ["json", "npz"])
def test_several_motions_share_a_file(proofs, tmp_path, suffix):
    path = tmp_path / f"all.{suffix}"
    save_proofs(proofs, path)
    loaded = load_proofs(path)
    assert same(loaded, proofs)
    assert all(proof.model is loaded[0].model for proof in loaded)
    with pytest.raises(pc.PlannercheckError, match="3 motions"):
        Proof.load(path)


def test_proofs_of_two_models_do_not_share_a_file(proofs, tmp_path):
    other = pc.Checker(pc.Robot.load("ur5"))
    with pytest.raises(pc.PlannercheckError, match="one robot in one scene"):
        save_proofs([proofs[0], *other.certify_motions(*free_motions(other, 1, 1))], tmp_path / "x.json")
    with pytest.raises(pc.PlannercheckError, match="at least one"):
        save_proofs([], tmp_path / "x.json")
    with pytest.raises(pc.PlannercheckError, match=r"\.json or \.npz"):
        proofs[0].save(tmp_path / "x.txt")
    with pytest.raises(pc.PlannercheckError, match="can't be written"):
        proofs[0].save(tmp_path / "no" / "x.json")


@pytest.mark.parametrize("suffix", ["json", "npz"])
@pytest.mark.parametrize("part", [0.0, 0.001, 0.3, 0.9, 0.999])
def test_files_that_are_cut_off_are_errors(proofs, tmp_path, suffix, part):
    path = tmp_path / f"cut.{suffix}"
    proofs[0].save(path)
    content = path.read_bytes()
    path.write_bytes(content[: int(part * len(content))])
    with pytest.raises(pc.PlannercheckError, match="cut"):
        load_proofs(path)


def edited(proof, tmp_path, change):
    """A JSON file of a proof with its document changed."""
    path = tmp_path / "edited.json"
    proof.save(path)
    document = json.loads(path.read_text())
    change(document)
    path.write_text(json.dumps(document))
    return path


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d.update(version=2), "version 2"),
        (lambda d: d.update(version="1"), "version '1'"),
        (lambda d: d.update(format="plan"), "no motion proof"),
        (lambda d: d.update(kind="time"), "'kind' must be"),
        (lambda d: d.pop("model"), "lacks 'model'"),
        (lambda d: d.update(motions=[]), "no motions"),
        (lambda d: d.update(robot=7), "must be a str"),
        (lambda d: d["motions"][0].update(margin="small"), "'margin'"),
        (lambda d: d["motions"][0].update(margin=True), "'margin'"),
        (lambda d: d["motions"][0]["entries"][0].update(pair=0.5), "pair must be a int"),
        (lambda d: d["motions"][0]["entries"][0].update(start=True), "start must be a float"),
        (lambda d: d["motions"][0]["entries"][0].update(start=None), "start must be a float"),
        (lambda d: d["motions"][0]["entries"][0].update(by="magic"), "by must be one of"),
        (lambda d: d["motions"][0]["entries"][0].pop("by"), "must have"),
        (lambda d: d["motions"][0]["motion"].update(start="zero"), "start must be a list"),
        (lambda d: d["model"]["pairs"].append([0, 1, 2]), "must have 2 items"),
        (lambda d: d["model"]["bodies"][0].update(vertices=[["a"]]), "array of numbers"),
        (lambda d: d["model"]["bodies"][0].update(vertices=[[0, 0, 0], [1]]), "array of numbers"),
        (lambda d: d["model"]["bodies"][0].update(vertices=[["0", "0", "0"]]), "array of numbers"),
        (lambda d: d["model"]["bodies"][0].update(vertices=[[True, False, True]]), "array of numbers"),
        (lambda d: d["model"]["bodies"][0].update(vertices=[[10**400, 0, 0]]), "array of numbers"),
        (lambda d: d["motions"][0].update(margin=10**400), "'margin'"),
        (lambda d: d.update(kind=[]), "'kind' must be"),
    ],
)
def test_documents_that_are_no_proofs_are_errors(proofs, tmp_path, change, message):
    with pytest.raises(pc.PlannercheckError, match=message):
        load_proofs(edited(proofs[0], tmp_path, change))


def test_a_key_that_stands_twice_is_an_error(proofs, tmp_path):
    # Other readers may take the first value, and show a claim that is not the one that is verified.
    path = tmp_path / "twice.json"
    proofs[0].save(path)
    path.write_text(path.read_text().replace('"margin":', '"margin":9.0,"margin":', 1))
    with pytest.raises(pc.PlannercheckError, match="an object has the key 'margin' twice"):
        load_proofs(path)
    text = path.read_text()
    with (tmp_path / "twice.npz").open("wb") as file:
        np.savez(file, document=np.array(text))
    with pytest.raises(pc.PlannercheckError, match="an object has the key 'margin' twice"):
        load_proofs(tmp_path / "twice.npz")


def test_arrays_that_are_no_npz_of_doubles_are_errors(proofs, tmp_path):
    path = tmp_path / "x.npz"
    with path.open("wb") as file:
        np.save(file, np.zeros(3))
    with pytest.raises(pc.PlannercheckError, match="no npz"):
        load_proofs(path)
    proofs[0].save(path)
    with np.load(path) as file:
        arrays = dict(file)
    for array, message in (
        (arrays["array_0"] + 1j, "array of numbers"),
        (arrays["array_0"].astype(str), "array of numbers"),
        (arrays["array_0"].astype(object), "pickle"),
    ):
        with path.open("wb") as file:
            np.savez(file, **{**arrays, "array_0": array})
        with pytest.raises(pc.PlannercheckError, match=message):
            load_proofs(path)


def test_numbers_that_json_can_say_but_no_proof_may_have_are_refused(proofs, tmp_path):
    for value in (float("nan"), float("inf"), 1e300, 0):
        path = edited(proofs[0], tmp_path, lambda d, v=value: d["model"]["joints"][0]["placement"].__setitem__(0, v))
        assert not load_proofs(path)[0].verify()


def test_hashes_tell_types_and_places_apart():
    values = [
        1,
        1.0,
        "1",
        (1,),
        ((1,),),
        (1, 1),
        None,
        np.ones(1),
        np.ones((1, 1)),
        ("a", "bc"),
        ("ab", "c"),
        0.0,
        -0.0,
    ]
    assert len({content_hash(value) for value in values}) == len(values)


# ----- the model beside files


@pytest.mark.filterwarnings("ignore:.*fixed to the world")
@pytest.mark.parametrize("name", ["panda", "pr2", "tiago", "go2", "xarm7"])
def test_models_of_shipped_robots_are_those_of_their_files(name):
    model = Builder(pc.Checker(pc.Robot.load(name), pc.Scene.load("bin")))._model
    confirm_model(model, name, "bin")
    with pytest.raises(UnprovedError, match="not in the files"):
        confirm_model(model, name, "empty")


def shifted(rows):
    return (*rows[:3], rows[3] + 1e-9, *rows[4:])


@pytest.fixture(scope="module")
def model():
    """That of a padded checker, as its files say it is."""
    checker = pc.Checker(pc.Robot.load("panda"), pc.Scene.load("table"), padding=0.002)
    model = Builder(checker)._model
    confirm_model(model, "panda", "table")
    return model


@pytest.mark.parametrize(
    ("part", "change"),
    [
        ("joints", lambda joint: replace(joint, placement=shifted(joint.placement))),
        ("joints", lambda joint: replace(joint, axis=tuple(-x for x in joint.axis))),
        ("joints", lambda joint: replace(joint, axis=(1.0, 0.0, 0.0))),
        ("joints", lambda joint: replace(joint, multipliers=(2.0,))),
        ("joints", lambda joint: replace(joint, offsets=(1e-6,))),
        ("joints", lambda joint: replace(joint, kind="slide")),
        ("joints", lambda joint: replace(joint, name="other")),
        ("joints", lambda joint: replace(joint, parent=-1)),
        ("links", lambda link: replace(link, placement=shifted(link.placement))),
        ("links", lambda link: replace(link, name="other")),
        ("links", lambda link: replace(link, joint=-1)),
        ("bodies", lambda body: replace(body, pose=shifted(body.pose))),
        ("bodies", lambda body: replace(body, vertices=body.vertices[:-1])),
        ("bodies", lambda body: replace(body, radius=body.radius + 1e-6)),
        ("bodies", lambda body: replace(body, link=-1)),
        ("bodies", lambda body: replace(body, name="other")),
        ("pairs", lambda pair: (0, 1)),
    ],
)
def test_models_that_differ_from_their_files_are_refused(model, part, change):
    items = list(getattr(model, part))
    k = 3 if part != "pairs" else next(k for k, pair in enumerate(items) if pair[1] > 5)
    items[k] = change(items[k])
    with pytest.raises(UnprovedError):
        confirm_model(replace(model, **{part: tuple(items)}), "panda", "table")


@pytest.mark.parametrize(
    "columns",
    [
        (1, 0, 2, 3, 4, 5, 6),  # two joints have changed places
        (6,) * 7,  # all joints follow the last one's number
        (-1,) * 7,  # nothing moves
        (0, 1, 2, 3, 4, 5, -1),
    ],
)
def test_a_configuration_has_to_mean_what_it_means_to_the_checker(columns):
    model = Builder(pc.Checker(pc.Robot.load("panda"), pc.Scene.load("table")))._model
    joints = [replace(joint, columns=(k,)) for joint, k in zip(model.joints, columns, strict=False)]
    with pytest.raises(UnprovedError, match="takes the columns"):
        confirm_model(replace(model, joints=(*joints, *model.joints[7:])), "panda", "table")
    for change in ({"columns": 8}, {"whole_turns": (0,)}):
        with pytest.raises(UnprovedError, match="configurations have"):
            confirm_model(replace(model, **change), "panda", "table")


def test_joints_that_are_held_have_their_axes(checker):
    model = Builder(pc.Checker(pc.Robot.load("panda"), pc.Scene.load("table")))._model
    finger = replace(model.joints[7], axis=(1.0, 0.0, 0.0))
    assert finger.columns == (-1,)
    with pytest.raises(UnprovedError, match="has the axis"):
        confirm_model(replace(model, joints=(*model.joints[:7], finger, *model.joints[8:])), "panda", "table")


@pytest.fixture
def floating(tmp_path):
    """A robot with a free base in a scene: the YAML's path, the scene's path, the model."""
    (tmp_path / "base.urdf").write_text(
        "<robot name='base'><link name='base'><collision><geometry><sphere radius='0.1'/></geometry></collision></link>"
        "<link name='arm'><collision><origin xyz='0 0 0.5'/><geometry><sphere radius='0.1'/></geometry></collision>"
        "</link><joint name='j' type='revolute'><parent link='base'/><child link='arm'/><axis xyz='1 0 0'/>"
        "<limit lower='-1' upper='1' effort='1' velocity='1'/></joint>"
        "<link name='hand'><collision><origin xyz='0 0 1'/><geometry><sphere radius='0.1'/></geometry></collision>"
        "</link><joint name='k' type='continuous'><parent link='arm'/><child link='hand'/><axis xyz='0 1 0'/></joint>"
        "</robot>"
    )
    (tmp_path / "base.yaml").write_text("urdf: base.urdf\nfloating: true\n")
    scene = pc.Scene("named")
    scene.add_box("base_0", (0.1, 0.1, 0.1), np.array(pc.Scene.load("table").bodies[0].pose))
    scene.save(tmp_path / "named.yaml")
    files = str(tmp_path / "base.yaml"), str(tmp_path / "named.yaml")
    return *files, Builder(pc.Checker(pc.Robot.load(files[0]), pc.Scene.load(files[1])))._model


def test_a_free_base_stands_where_its_numbers_say(floating):
    robot, scene, model = floating
    confirm_model(model, robot, scene)
    base = model.joints[0]
    for change in ({"placement": shifted(base.placement)}, {"columns": (-1,) * 7, "offsets": (9.0,) * 6 + (1.0,)}):
        changed = replace(model, joints=(replace(base, **change), *model.joints[1:]))
        with pytest.raises(UnprovedError):
            confirm_model(changed, robot, scene)


def test_pairs_of_bodies_that_share_a_name_are_told_apart(floating):
    # An obstacle has the name of the base's geometry: the pair of one with the arm does not stand for the other's.
    robot, scene, model = floating
    names = [sorted(model.bodies[k].name for k in pair) for pair in model.pairs]
    assert names.count(["base_0", "hand_0"]) == 2
    for pair in model.pairs:
        others = tuple(other for other in model.pairs if other != pair)
        with pytest.raises(UnprovedError, match="1 pairs of the checker's table"):
            confirm_model(replace(model, pairs=others), robot, scene)


@pytest.mark.parametrize("seed", range(6))
def test_the_verifiers_urdf_reader_agrees_with_pinocchio(seed, tmp_path):
    path = random_tree(np.random.default_rng(seed), tmp_path, links=8)
    robot = pc.Robot.from_urdf(path)
    model = Builder(pc.Checker(robot, scattered(np.random.default_rng(seed))))._model
    with pytest.raises(UnprovedError, match="not in the files"):  # its joints are, and the obstacles are not
        confirm_model(model, str(path), None)
    tree = read_tree(path)
    assert set(tree.links) == set(robot.link_names)
    moving = [joint for joint in tree.above.values() if joint.kind != "fixed"]
    assert {joint.name for joint in moving} == set(robot.joint_names)
    for joint in moving:
        placement = robot.model.jointPlacements[robot.model.getJointId(joint.name)].homogeneous
        assert off_placement(placement.ravel()[:12].tolist(), joint.placement) < 1e-14


def test_files_that_are_no_urdf_are_errors(tmp_path):
    path = tmp_path / "robot.urdf"
    for content, message in (
        ("<robot xmlns:xacro='http://www.ros.org/wiki/xacro'><xacro:include filename='x'/></robot>", "xacro"),
        ("<model/>", "begins with <model>"),
        ("<robot", "can't be read"),
        ("<robot><link name='a'/><link name='b'/></robot>", "no tree"),
        ("<robot><link name='a'/><joint name='j'><child link='a'/></joint></robot>", "no parent"),
        (
            "<robot><link name='a'/><link name='b'/><joint name='j' type='fixed'><parent link='a'/><child link='b'/>"
            "<origin xyz='1 2'/></joint></robot>",
            "xyz of <origin> must be 3 numbers",
        ),
    ):
        path.write_text(content)
        with pytest.raises(pc.PlannercheckError, match=message):
            read_tree(path)


# ----- commands


@pytest.fixture(scope="module")
def plan(checker, tmp_path_factory):
    """A path of three motions in a file."""
    path = tmp_path_factory.mktemp("plan") / "plan.json"
    q0, q1 = free_motions(checker, 1, 1)
    part = np.linspace(0, 1, 4)[:, None]
    path.write_text(json.dumps(((1 - part) * q0 + part * q1).tolist()))
    return path


ARGUMENTS = ["--robot", "ur5", "--scene", "table"]


def test_a_path_is_certified_and_its_proof_verified(plan, capsys):
    assert main(["validate", *ARGUMENTS, "--path", str(plan), "--certify"]) == 0
    assert "plan.proof.json" in capsys.readouterr().out
    file = plan.with_suffix(".proof.json")
    assert len(load_proofs(file)) == 3
    assert main(["verify", str(file)]) == 0
    assert "3 motions in a row of 'ur5' in 'table' proved" in capsys.readouterr().out
    assert main(["verify", str(file), *ARGUMENTS, "--format", "json"]) == 0
    (result,) = json.loads(capsys.readouterr().out)
    assert result["proved"]
    assert result["joined"]
    assert result["model"] == "confirmed"
    assert [motion["fault"] for motion in result["motions"]] == [None] * 3
    assert main(["verify", str(file), "--robot", "ur5", "--scene", "bin"]) == 1
    assert "not in the files" in capsys.readouterr().out


def test_a_false_proof_is_told_with_its_motion(plan, tmp_path, capsys):
    file = tmp_path / "x.npz"
    assert main(["validate", *ARGUMENTS, "--path", str(plan), "--certify", "--proof", str(file)]) == 0
    first, second, third = load_proofs(file)
    save_proofs([first, replace(second, entries=second.entries[1:]), third], file)
    capsys.readouterr()
    assert main(["verify", str(file)]) == 1
    told = capsys.readouterr().out
    assert "2 of 3 motions" in told
    assert "motion 1: not proved" in told
    save_proofs([first, third], file)
    assert main(["verify", str(file)]) == 0
    assert "in a row" not in capsys.readouterr().out


def test_a_malformed_model_is_told_and_not_a_crash(proofs, tmp_path, capsys):
    for change in (
        lambda d: d["model"]["joints"][0].update(columns=[], multipliers=[], offsets=[]),
        lambda d: d["model"]["pairs"].append([0, 10**6]),
    ):
        assert main(["verify", str(edited(proofs[0], tmp_path, change))]) == 1
        assert "motion 0: not proved" in capsys.readouterr().out


def test_a_path_that_collides_gets_no_proof(tmp_path, capsys):
    scene = pc.Scene.load("bookshelf")
    path = tmp_path / "hit.json"
    path.write_text(json.dumps([scene.start("panda").tolist(), scene.goal("panda").tolist()]))
    code = main(["validate", "--robot", "panda", "--scene", "bookshelf", "--path", str(path), "--certify"])
    assert code == 1
    assert "collides at" in capsys.readouterr().out
    assert not path.with_suffix(".proof.json").exists()


def test_commands_say_what_is_wrong(plan, tmp_path, capsys):
    copy = str(shutil.copy(plan, tmp_path / "plan.json"))
    certify = ["validate", *ARGUMENTS, "--path", copy, "--certify"]
    for arguments, message in (
        ([*certify, "--proof", copy], "would replace"),
        ([*certify, "--proof", str(tmp_path / "x.txt")], ".json or .npz"),
        ([*certify, "--proof", str(tmp_path / "no" / "x.json")], "no folder"),
        (["validate", *ARGUMENTS, "--path", copy, "--proof", "x.json"], "--certify"),
        (["validate", *ARGUMENTS, copy, "--certify", "--proof", "x.json"], "--path"),
        (["verify", copy], "no motion proof"),
        (["verify", str(tmp_path / "none.json")], "can't be read"),
        (["verify", copy, "--scene", "table"], "--robot"),
    ):
        assert main(arguments) == 2
        assert message in capsys.readouterr().err


@pytest.mark.skipif(sys.version_info < (3, 12), reason="aliases with names of their own are new in Python 3.12")
def test_arrays_are_read_where_their_annotation_has_a_name_of_its_own():
    """NumPy's NDArray is such an alias from 2.5 on: no proof could be loaded."""
    element = typing.TypeVar("element")
    named = typing.TypeAliasType("named", np.ndarray[tuple[int, ...], np.dtype[element]], type_params=(element,))
    kind = dataclasses.make_dataclass("kind", [("rows", named[np.float64])], frozen=True)
    np.testing.assert_array_equal(from_plain(kind, {"rows": [[1.0, 2.0]]}, "it").rows, [[1.0, 2.0]])


def test_a_scene_is_compared_with_a_robot_only():
    checker = pc.Checker(pc.Robot.load("ur5"), pc.Scene.load("table"))
    q = checker.scene.start("ur5") if "ur5" in checker.scene.states else np.array([0.0, -1.2, 1.0, 0.0, 0.0, 0.0])
    proof = checker.certify_motions(q[None], q[None] + 0.01)[0]
    for given in ({"scene": "table"}, {"meshes": "solid"}, {"geometry": "hull"}, {"mesh_units": "file"}):
        with pytest.raises(pc.PlannercheckError, match="give the robot, too"):
            proof.verify(**given)
