"""What users get wrong in Python: one error, which names the input and the remedy."""

import warnings

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.common.package_data import example_robot_data

URDF = example_robot_data() / "example-robot-data/robots/panda_description/urdf/panda.urdf"
PANDA = pc.Robot.load("panda")
HOME = PANDA.reference
TURNED = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0.5, 0, 0, 1.0]])

TILDES = {
    "robot file ~/arm.yaml": pc.Robot.load,
    "URDF ~/arm.urdf": pc.Robot.from_urdf,
    "SRDF ~/arm.srdf": lambda path: pc.Robot.from_urdf(URDF, path),
    "scene file '~/cell.yaml'": pc.Scene.load,
    "mesh file '~/tap.stl'": lambda path: pc.Scene().add_mesh("tap", path),
    "cloud file '~/frame.ply'": lambda path: pc.PointCloud.load(path, 0.01),
    "octomap file '~/map.bt'": pc.Octree.load,
    "trajectory file '~/t.yaml':": lambda path: pc.Trajectory.load(path, PANDA, controller="jtc"),
}

CALLS = {
    "n must be a number of configurations, 0 or more, not -1": lambda: PANDA.random_configurations(-1),
    "n must be a number of configurations, 0 or more, not 10.0": lambda: PANDA.random_configurations(10.0),
    "n must be a number of configurations, 0 or more, not '1'": lambda: pc.planar.Robot(
        [[0, 0], [1, 0], [0, 1]]
    ).random_configurations("1"),
    "a trajectory must be a pc.Trajectory, not ndarray: pc.Trajectory(times, positions) makes one": lambda: pc.Checker(
        PANDA
    ).check_trajectory(np.array([HOME, HOME])),
    "poses of Moving must be matrices (n, 4, 4) in metres, not of shape (4, 4)": lambda: pc.Moving([0, 8], np.eye(4)),
    "(4, 4), not (7,): the rotation is [:3, :3], the position [:3, 3]": lambda: pc.Scene().add_box(
        "b", (1, 1, 1), [0.5, 0, 0, 0, 0, 0, 1]
    ),
    "last row must be 0 0 0 1, not [0.5, 0.0, 0.0, 1.0]; it looks transposed": lambda: pc.Scene().add_box(
        "b", (1, 1, 1), TURNED
    ),
    "unknown link 'hand': did you mean 'panda_hand' or 'panda_hand_tcp'? valid are": lambda: PANDA.link_index("hand"),
}


@pytest.mark.parametrize("named", TILDES)
def test_a_tilde_is_not_expanded(named):
    path = named[named.index("~") :].strip("':")
    with pytest.raises(pc.PlannercheckError) as raised:
        TILDES[named](path)
    assert str(raised.value) == f"{named} does not exist: ~ is not expanded, give the whole path"


def test_a_folder_in_place_of_a_file_is_named(tmp_path):
    with pytest.raises(pc.PlannercheckError, match=f"URDF {tmp_path} is a folder: give the path of a file in it"):
        pc.Robot.from_urdf(tmp_path)


@pytest.mark.parametrize("message", CALLS)
def test_calls(message):
    with pytest.raises(pc.PlannercheckError) as raised:
        CALLS[message]()
    assert message in str(raised.value)


def test_a_mesh_whose_triangles_enclose_nothing_gets_no_warning_of_numpy(tmp_path):
    corners = 15 * np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    faces = [corners[list(face)] for face in ((0, 1, 3), (0, 3, 1), (0, 2, 3), (0, 3, 2))]
    loops = "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join(f"vertex {x} {y} {z}\n" for x, y, z in face)
        + "endloop\nendfacet\n"
        for face in faces
    )
    (tmp_path / "fan.stl").write_text(f"solid fan\n{loops}endsolid fan\n")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pc.Scene().add_mesh("fan", tmp_path / "fan.stl")
