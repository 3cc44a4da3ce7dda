"""YAML that is written holds plain texts and numbers, whatever library they came from."""

import numpy as np
import pytest
import yaml

import plannercheck as pc
from plannercheck.common.checked_yaml import parse_yaml
from plannercheck.common.written_yaml import yaml_of


def test_texts_and_numbers_of_numpy_are_plain():
    assert yaml_of({np.str_("a"): [np.float64(0.1), "ü", 1]}) == "a: [0.1, ü, 1]\n"
    with pytest.raises(yaml.representer.RepresenterError):
        yaml_of({"a": object()})


def test_numbers_of_a_file_stay_as_they_are_written():
    """They may be names."""
    for scalar in ("1.10", "+1", "0x1F", "-0", "1.0e+3", "5", ".inf"):
        assert yaml_of(parse_yaml(f"a: {scalar}")) == f"{{a: {scalar}}}\n"


def test_files_whose_names_are_numpys_are_read_back(tmp_path):
    names = np.array(["panda", "box", *(f"panda_joint{k}" for k in range(1, 8))])
    scene = pc.Scene(names[0])
    scene.add_box(names[1], (1, 1, 1), np.eye(4))
    scene.save(tmp_path / "scene.yaml")
    assert pc.Scene.load(tmp_path / "scene.yaml").objects[0].name == "box"
    panda = pc.Robot.load("panda").with_group(names[:1:-1])
    pc.Robot.together({names[0]: panda}).save(tmp_path / "cell.yaml")
    assert pc.Robot.load(tmp_path / "cell.yaml").joint_names[0] == "panda/panda_joint7"
    trajectory = pc.Trajectory([0, 1], np.zeros((2, 7)), joint_names=names[:1:-1])
    trajectory.save(tmp_path / "way.yaml")
    assert pc.Trajectory.load(tmp_path / "way.yaml", panda).duration == 1
