"""Models are read as the programs that they are of read them, and written so that they read the same numbers."""

import json

import numpy as np
import pytest
import yaml
from covering_oracle import element, write_robot

import plannercheck as pc
from plannercheck.coverings.primitives import Primitives

MESH = element('<mesh filename="a.stl"/>')
SPHERE = element('<sphere radius="0.2"/>')


@pytest.fixture
def robot(tmp_path):
    return write_robot(tmp_path, {"base": SPHERE, "arm": SPHERE, "hand": SPHERE})


def curobo(**changes):
    kinematics = {
        "collision_link_names": ["base", "arm", "attached"],
        "collision_sphere_buffer": 0.0,
        "collision_spheres": {
            "base": [{"center": [0.0, 0.1, 0.0], "radius": 0.25}],
            "arm": [{"center": [0.0, 0.0, 0.0], "radius": 0.2}, {"center": [0.1, 0.0, 0.0], "radius": -10.0}],
            "hand": [{"center": [0.0, 0.0, 0.0], "radius": 9.0}],
        },
        "extra_collision_spheres": {"attached": 4},
        "extra_links": {
            "attached": {
                "parent_link_name": "hand",
                "joint_type": "FIXED",
                "fixed_transform": [0.5, 0, 0, 0.5**0.5, 0, 0, 0.5**0.5],
            }
        },
        "cspace": {"joint_names": ["base_arm"]},
        **changes,
    }
    return {"robot_cfg": {"kinematics": {k: v for k, v in kinematics.items() if v is not None}}}


def load(robot, tmp_path, document, name="model.yml"):
    path = tmp_path / name
    path.write_text(document if isinstance(document, str) else yaml.safe_dump(document))
    return pc.Covering.load(path, robot)


def single(x):
    return float(np.float32(x))


def test_curobo_counts_listed_links_and_leaves_out_what_is_off(robot, tmp_path):
    with pytest.warns(RuntimeWarning, match="1 spheres have a negative radius"):
        model = load(robot, tmp_path, curobo())
    assert set(model.links) == {"base", "arm"}
    assert model.spheres("base").tolist() == [[0, single(0.1), 0, 0.25]]
    assert model.spheres("arm").tolist() == [[0, 0, 0, single(0.2)]]
    assert len(model.spheres("hand")) == 0


@pytest.mark.filterwarnings("ignore:.*negative radius")
@pytest.mark.parametrize(
    ("buffer", "base", "arm"),
    [(0.01, 0.26, 0.21), ({"arm": 0.05}, 0.25, 0.25), ({"base": -0.05}, 0.2, 0.2), (1, 1.25, 1.2)],
)
def test_curobo_adds_its_buffer(robot, tmp_path, buffer, base, arm):
    model = load(robot, tmp_path, curobo(collision_sphere_buffer=buffer))
    assert model.spheres("base")[0, 3] == single(base) == np.float32(base)
    assert model.spheres("arm")[0, 3] == single(arm)


def test_a_radius_of_zero_is_a_point(robot, tmp_path):
    spheres = {"base": [{"center": [0, 0, 0], "radius": 0.5}], "arm": [{"center": [0, 0, 0], "radius": 0}]}
    model = load(robot, tmp_path, curobo(collision_spheres=spheres))
    assert model.spheres("arm").tolist() == [[0, 0, 0, 0]]


@pytest.mark.filterwarnings("ignore:.*negative radius")
def test_curobo_moves_spheres_of_fixed_extra_links_to_their_parent(robot, tmp_path):
    spheres = {"base": [], "arm": [], "attached": [{"center": [0.125, 0.0, 0.0], "radius": 0.25}]}
    model = load(robot, tmp_path, curobo(collision_spheres=spheres, extra_collision_spheres=None))
    # A quarter turn about z, then 0.5 along x.
    np.testing.assert_allclose(model.spheres("hand"), [[0.5, 0.125, 0, 0.25]], atol=1e-12)
    assert set(model.links) == {"hand"}


@pytest.mark.filterwarnings("ignore:.*negative radius")
def test_curobo_placeholders_replace_spheres(robot, tmp_path):
    spheres = {
        "base": [{"center": [0, 0, 0], "radius": 1}],
        "arm": [],
        "attached": [{"center": [0, 0, 0], "radius": 1}],
    }
    assert set(load(robot, tmp_path, curobo(collision_spheres=spheres)).links) == {"base"}


def test_other_files_of_curobo(robot, tmp_path):
    rows = {"base": [{"center": [0, 0, 0], "radius": 0.5}]}
    alone = load(robot, tmp_path, {"robot": "x", "collision_spheres": rows, "self_collision_buffer": {"base": 3}})
    xrdf = {
        "format": "xrdf",
        "collision": {"geometry": "g", "buffer_distance": {"base": 0.25}},
        "geometry": {"g": {"spheres": rows}},
    }
    (tmp_path / "spheres.yml").write_text(yaml.safe_dump({"collision_spheres": rows}))
    named = curobo(collision_spheres="spheres.yml", collision_link_names=["base"])
    assert alone.spheres("base").tolist() == [[0, 0, 0, 0.5]]
    assert load(robot, tmp_path, xrdf, "m.xrdf").spheres("base").tolist() == [[0, 0, 0, 0.75]]
    assert load(robot, tmp_path, named).spheres("base").tolist() == [[0, 0, 0, 0.5]]


def test_a_saved_configuration_keeps_the_rest(robot, tmp_path):
    with pytest.warns(RuntimeWarning, match="negative"):
        model = load(robot, tmp_path, curobo(collision_sphere_buffer=0.125))
    model.save(tmp_path / "saved.yml")
    again = pc.Covering.load(tmp_path / "saved.yml", robot)
    kinematics = yaml.safe_load((tmp_path / "saved.yml").read_text())["robot_cfg"]["kinematics"]
    assert {name: again.spheres(name).tolist() for name in again.links} == {
        name: model.spheres(name).tolist() for name in model.links
    }
    assert kinematics["cspace"] == {"joint_names": ["base_arm"]}
    assert kinematics["collision_sphere_buffer"] == 0.0
    assert kinematics["collision_link_names"] == ["base", "arm", "attached"]


def test_urdf_and_json_keep_all_numbers(robot, tmp_path):
    rng = np.random.default_rng(0)
    links = {
        "base": Primitives.of([(rng.normal(size=3).tolist(), 0.1), ((0, 0, 0), 1 / 3)]),
        "arm": Primitives.of(capsules=[((0, 0, -0.5), (0, 0, 0.25), 0.1)], boxes=[(np.eye(4), (0.1, 0.2, 0.3))]),
    }
    model = pc.Covering(robot, links)
    for name in ("m.urdf", "m.json"):
        model.save(tmp_path / name)
        again = pc.Covering.load(tmp_path / name, robot)
        for link, cover in links.items():
            for field in ("ends", "radii", "frames", "halves"):
                np.testing.assert_allclose(getattr(again.links[link], field), getattr(cover, field), atol=1e-15)
        np.testing.assert_array_equal(again.spheres("base"), model.spheres("base"))
    spherized = pc.Robot.from_urdf(tmp_path / "m.urdf")
    assert [body.link for body in spherized.bodies] == ["base", "base", "arm", "arm"]
    assert spherized.joint_names == robot.joint_names
    with pytest.raises(pc.PlannercheckError, match="'arm' has capsules or boxes"):
        model.save(tmp_path / "m.yml")


def test_foam_has_levels_and_origins(robot, tmp_path):
    level = {"mean": 0, "best": 0, "worst": 0}
    node = {
        "base::meshes/base.obj": [
            {**level, "spheres": [{"origin": [0, 0, 0], "radius": 9}]},
            {**level, "spheres": [{"origin": [1, 2, 3], "radius": 0.5}]},
        ],
        "arm": [{"origin": [0, 0, 0], "radius": 0.25}],
    }
    model = load(robot, tmp_path, json.dumps(node), "m.json")
    assert model.spheres("base").tolist() == [[1, 2, 3, 0.5]]
    assert model.spheres("arm").tolist() == [[0, 0, 0, 0.25]]


BAD = {
    "unknown.json": ('{"amr": []}', "unknown link 'amr': did you mean 'arm'"),
    "nan.json": ('{"arm": [{"center": [0, 0, 0], "radius": NaN}]}', "'radius' must be a finite number"),
    "negative.json": ('{"arm": [{"center": [0, 0, 0], "radius": -1}]}', "'radius' must not be negative"),
    "two.json": ('{"arm": [{"center": [0, 0], "radius": 1}]}', "'center' needs 3 numbers"),
    "key.json": ('{"arm": {"sphere": []}}', "unknown key 'sphere'"),
    "beside.json": ('{"links": {"arm": [{"center": [0, 0, 0], "radius": 1}]}, "hand": []}', "unknown key 'hand'"),
    "placed.json": ('{"arm": {"boxes": [{"size": [1, 1, 1], "position": [1, 0, 0]}]}}', "unknown key 'position'"),
    "both.json": ('{"arm": [{"center": [0, 0, 0], "origin": [1, 0, 0], "radius": 1}]}', "center and origin"),
    "empty.json": ('{"arm": []}', "it has no spheres"),
    "list.json": ('[{"spheres": []}]', "name no link"),
    "broken.json": ("{", "no JSON"),
    "model.txt": ("", "suffix '.txt' is of no model"),
    "none.yml": ("robot_cfg: {kinematics: {}}", "no 'collision_spheres'"),
    "link.yml": ("collision_spheres: {amr: [{center: [0, 0, 0], radius: 1}]}", "unknown link 'amr'"),
    "listed.yml": ("{collision_link_names: [arm], collision_spheres: {base: []}}", "unknown link with spheres"),
    "nan.yml": ("collision_spheres: {arm: [{center: [0, .nan, 0], radius: 1}]}", "link 'arm': sphere 0: 'center'"),
    "radius.yml": ("collision_spheres: {arm: [{center: [0, 0, 0]}]}", "key 'radius' is missing"),
    "off.yml": ("collision_spheres: {arm: [{center: [0, 0, 0], radius: -1}]}", "it has no spheres"),
    "turning.yml": (
        "{collision_spheres: {tip: [{center: [0, 0, 0], radius: 1}]}, "
        "extra_links: {tip: {joint_type: X_ROT, parent_link_name: arm}}}",
        "unknown link 'tip'",
    ),
    "mesh.urdf": (
        f'<robot name="r"><link name="arm">{MESH}</link></robot>',
        "is it the robot's own URDF",
    ),
    "link.urdf": (f'<robot name="r"><link name="amr">{SPHERE}</link></robot>', "unknown link 'amr'"),
    "negative.urdf": (
        f'<robot name="r"><link name="arm">{SPHERE.replace("0.2", "-0.2")}</link></robot>',
        "not negative",
    ),
    "empty.urdf": ('<robot name="r"><link name="arm"/></robot>', "it has no spheres"),
    "missing.urdf": (None, "does not exist"),
    "missing.yml": (None, "can't be read"),
}


@pytest.mark.filterwarnings("ignore:.*negative radius")
@pytest.mark.parametrize("name", BAD)
def test_bad_files_are_errors(robot, tmp_path, name):
    content, words = BAD[name]
    if content is not None:
        (tmp_path / name).write_text(content)
    with pytest.raises(pc.PlannercheckError, match=r"sphere model .*" + name) as error:
        pc.Covering.load(tmp_path / name, robot)
    assert words in str(error.value)
