"""Proofs of cells: the verifier reads robots and their places by itself, so that no other cell passes for the one."""

import numpy as np
import pytest
from sample_robots import URDF

import plannercheck as pc
from plannercheck.cli.main import main
from plannercheck.common.errors import PlannercheckError
from plannercheck.motions.proof_builder import Builder
from plannercheck.motions.proof_confirmation import confirm_model
from plannercheck.proofs import Proof
from plannercheck.proofs.cell_places import base_placements
from plannercheck.proofs.faults import UnprovedError
from plannercheck.robots import cells, description

FILE = """robots:
  left: {load: ur5}
  right: {load: ur5, pose: {position: [0.4, 0.5, 0.05], rpy: [0.1, -0.2, 2.5]}}
"""
MJCF = """<mujoco model="swing"><worldbody><body name="bar"><joint name="hinge" type="hinge" axis="0 1 0"/>
<geom name="g" type="box" size="0.1 0.1 0.1"/></body></worldbody></mujoco>"""


@pytest.fixture
def write(tmp_path):
    def written(text, name="cell.yaml"):
        (tmp_path / name).write_text(text)
        return str(tmp_path / name)

    return written


def model_of(path):
    return Builder(pc.Checker(pc.Robot.load(path)))._model


def free_motion(cell):
    """A motion of both robots that is free."""
    checker = pc.Checker(cell, pc.Scene.load("table"))
    q = cell.random_configurations(500, 3)
    start = q[checker.check_states(q)][:1]
    return checker, start, start + 1e-3


# ---- from one end to the other


def test_proofs_of_a_cell_are_compared_with_its_file(write, tmp_path, capsys):
    path = write(FILE)
    checker, start, end = free_motion(pc.Robot.load(path))
    (certificate,) = checker.certify_motions(start, end)
    certificate.save(tmp_path / "proof.json")
    proof = Proof.load(tmp_path / "proof.json")
    found = proof.verify(robot=path, scene="table")
    assert found, found.fault
    assert sum("of 'left/'" in each or "of 'right/'" in each for each in found.compared) == 2
    assert main(["verify", str(tmp_path / "proof.json"), "--robot", path, "--scene", "table"]) == 0
    assert "'right/" in capsys.readouterr().out
    other = write(FILE.replace("0.4, 0.5", "0.4, 0.6"), "other.yaml")
    assert not proof.verify(robot=other, scene="table")
    assert main(["verify", str(tmp_path / "proof.json"), "--robot", other, "--scene", "table"]) == 1
    assert not proof.verify(robot="ur5", scene="table")


def test_trajectories_of_a_cell_are_proved_and_compared_with_its_file(write):
    path = write(FILE)
    checker, start, end = free_motion(pc.Robot.load(path))
    trajectory = pc.Trajectory([0.0, 1.0], [start[0], end[0]], joint_names=checker.robot.joint_names)
    proofs = checker.certify_trajectory(trajectory)
    assert all(proof.verify(robot=path, scene="table") for proof in proofs)


# ---- other cells


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ("0.4, 0.5", "0.4, 0.500000000001", "'right/.*' is not where the URDF has it"),
        ("2.5]", "2.500000000001]", "'right/.*' is not where the URDF has it"),
        ("left: {load: ur5}", "left: {load: ur5, pose: {position: [0, 0, 1.0e-12]}}", "'left/.*' is not where"),
        ("right: {load: ur5", "right: {load: ur3", "not where the URDF|differ"),
        ("right: {load: ur5", "right: {load: panda", "links of the proof and of the URDF differ"),
        ("left: {load: ur5}\n  right", "other: {load: ur5}\n  right", "'left/.*' is of no robot of the files"),
        ("  left: {load: ur5}\n", "", "'left/.*' is of no robot of the files"),
        ("robots:\n", "robots:\n  third: {load: ur3, pose: {position: [9, 9, 9]}}\n", "links of the proof"),
    ],
)
def test_no_other_cell_passes(write, old, new, fault):
    model = model_of(write(FILE))
    assert confirm_model(model, write(FILE), None)
    with pytest.raises(UnprovedError, match=f"(?s){fault}"):
        confirm_model(model, write(FILE.replace(old, new), "other.yaml"), None)


def test_robots_that_have_changed_places_are_refused(write):
    path = write(FILE)
    pose = "pose: {position: [0.4, 0.5, 0.05], rpy: [0.1, -0.2, 2.5]}"
    swapped = write(f"robots:\n  left: {{load: ur5, {pose}}}\n  right: {{load: ur5}}\n", "swapped.yaml")
    for one, other in ((path, swapped), (swapped, path)):
        with pytest.raises(UnprovedError, match="is not where the URDF has it"):
            confirm_model(model_of(one), other, None)


# ---- faults of loading do not confirm themselves


def transposed(monkeypatch):
    def wrong(node):
        pose = real(node)
        pose[:3, :3] = pose[:3, :3].T
        return pose

    real = description.pose_of_node
    monkeypatch.setattr(description, "pose_of_node", wrong)


def all_at_the_origin(monkeypatch):
    real = cells.append
    monkeypatch.setattr(cells, "append", lambda model, part, named, pose: real(model, part, named, pose.Identity()))


def rounded(monkeypatch):
    real = description.pose_of_node
    monkeypatch.setattr(description, "pose_of_node", lambda node: real(node).astype(np.float32).astype(np.float64))


def swapped(monkeypatch):
    real = cells.cell_parts

    def wrong(members, name=""):
        poses = [member.pose for member in members.values()][::-1]
        each = zip(members.items(), poses, strict=True)
        return real({key: cells.Member(member.parts, pose) for (key, member), pose in each}, name)

    monkeypatch.setattr(cells, "cell_parts", wrong)


@pytest.mark.parametrize("fault", [transposed, all_at_the_origin, rounded, swapped])
def test_a_fault_of_loading_does_not_confirm_itself(write, monkeypatch, fault):
    path = write(FILE)
    fault(monkeypatch)
    try:
        model = model_of(path)
    except PlannercheckError:  # a pose in single precision is not rigid
        assert fault is rounded
        return
    with pytest.raises(UnprovedError, match="is not where the URDF has it"):
        confirm_model(model, path, None)


# ---- every form of a pose, and every kind of robot


@pytest.mark.parametrize("form", ["rpy", "quaternion", "matrix", "nested", "floating"])
def test_poses_of_every_form_are_read(write, form):
    rng = np.random.default_rng(7)
    write(URDF, "arm.urdf")
    for _ in range(6):
        numbers = {"position": rng.uniform(-3, 3, 3).tolist()}
        if form == "quaternion":
            numbers["quaternion"] = (rng.normal(size=4) * 3).tolist()
        else:
            numbers["rpy"] = rng.uniform(-7, 7, 3).tolist()
        if form == "matrix":
            numbers = {"matrix": description.pose_of_node(numbers).tolist()}
        load = {"nested": "inner.yaml", "floating": "arm.urdf, floating: true"}.get(form, "arm.urdf")
        write(f"robots: {{x: {{load: arm.urdf, pose: {numbers}}}}}", "inner.yaml")
        path = write(f"robots: {{a: {{load: {load}, pose: {numbers}}}, b: {{load: arm.urdf}}}}")
        assert confirm_model(model_of(path), path, None)


def test_a_robot_of_mjcf_is_compared_with_what_is_loaded(write):
    write(MJCF, "swing.xml")
    path = write("robots: {a: {load: swing.xml, pose: {position: [1, 2, 3]}}, b: {load: ur5}}")
    model = model_of(path)
    assert confirm_model(model, path, None)
    other = write("robots: {a: {load: swing.xml, pose: {position: [1, 2, 4]}}, b: {load: ur5}}", "other.yaml")
    with pytest.raises(UnprovedError, match=r"of the MJCF differ: in place|not as the MJCF"):
        confirm_model(model, other, None)


@pytest.mark.parametrize(
    "pose", ["{position: [1_0, 0, 0]}", "{position: [0x1, 0, 0]}", "{quaternion: [0, 0, 0, 0]}", "{turn: 1}", "[1]"]
)
def test_numbers_that_are_no_decimals_are_not_read(write, pose):
    with pytest.raises(PlannercheckError, match=r"cell.yaml.* can't be read by the verifier"):
        base_placements(write(f"robots: {{a: {{load: ur5, pose: {pose}}}}}"))


@pytest.mark.parametrize(
    ("robots", "message"),
    [
        ("{a: &a {load: ur5, pose: {position: [1, 0, 0]}}, b: {<<: *a}}", "<< could bring in poses: write them out"),
        ("{<<: {a: {load: ur5}}}", "<< could bring in poses"),
        ("{a: {load: ur5, pose: {position: [1, 0, 0]}, pose: {position: [2, 0, 0]}}}", "has the key 'pose' twice"),
    ],
)
def test_poses_that_a_plain_loader_would_miss_are_not_read(write, robots, message):
    with pytest.raises(PlannercheckError, match=rf"cell.yaml.* can't be read by the verifier: .*{message}"):
        base_placements(write(f"robots: {robots}"))
