"""MJCF files beside MuJoCo itself, one a rule of its reference: poses, shapes, pairs, obstacles."""

import warnings

import mjcf_rules
import mujoco
import mujoco_oracle as oracle
import numpy as np
import pytest

import plannercheck as pc
from plannercheck.bodies import mjcf_files, mjcf_worker
from plannercheck.checking.pair_table import pair_table

STATES = 200
PROBES, RADIUS = 30, 0.05  # m
PROBE = '<body name="probe"><freejoint/><geom name="probe" type="sphere" size="0.05" gap="0" quat="1 0 0 0"/></body>'


@pytest.fixture(autouse=True)
def _in_this_process(monkeypatch):
    """A process a file takes as long as all of the rest."""
    monkeypatch.setattr(mjcf_files, "_compiled", lambda path: {"said": np.array(""), **mjcf_worker.compiled(path)})


def loaded(path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return pc.Robot.load(path), pc.Scene.from_mjcf(path)


@pytest.mark.parametrize("rule", mjcf_rules.RULES)
def test_geoms_are_where_mujoco_has_them(rule, tmp_path):
    path = tmp_path / "rule.xml"
    path.write_text(mjcf_rules.mjcf(rule))
    robot, scene = loaded(path)
    model = oracle.model_of(path)
    data, names, rng = mujoco.MjData(model), oracle.geom_names(model), np.random.default_rng(1)
    qpos = [oracle.random_qpos(model, rng) for _ in range(STATES)]
    links = robot.link_poses(np.array([oracle.as_q(model, each) for each in qpos]))
    placed = np.stack([links[:, robot.link_index(body.link)] @ body.pose for body in robot.bodies], axis=1)
    own, still = ([names.index(body.name) for body in each] for each in (robot.bodies, scene.bodies))
    theirs = np.array([oracle.geom_poses(model, data, each) for each in qpos])
    assert np.abs(placed - theirs[:, own]).max() < 1e-9
    assert all(np.abs(body.pose - theirs[:, k]).max() < 1e-9 for body, k in zip(scene.bodies, still, strict=True))
    limits = np.array(oracle.as_q(model, model.qpos0)), np.array(oracle.as_q(model, model.qpos0))
    for joint in np.flatnonzero(model.jnt_limited):
        for side in (0, 1):
            limits[side][model.jnt_qposadr[joint]] = model.jnt_range[joint, side]
    bounded = np.isfinite(robot.lower)
    assert bounded.sum() == np.count_nonzero(model.jnt_limited)
    assert np.array_equal(robot.lower[bounded], limits[0][bounded])
    assert np.array_equal(robot.upper[bounded], limits[1][bounded])


@pytest.mark.parametrize("rule", mjcf_rules.RULES)
def test_pairs_are_those_that_mujoco_tests(rule, tmp_path):
    path = tmp_path / "rule.xml"
    path.write_text(mjcf_rules.mjcf(rule))
    robot, scene = loaded(path)
    bodies = [body.name for body in (*robot.bodies, *scene.bodies)]
    table = pair_table(robot, scene, True, "robot")
    ours = {frozenset(bodies[k] for k in pair) for pair in (*table.pairs.tolist(), *table.static.tolist())}
    of_robot = {body.name for body in robot.bodies}
    assert ours == {pair for pair in oracle.tested_pairs(path) if pair & of_robot}


@pytest.mark.parametrize("rule", mjcf_rules.RULES)
def test_shapes_are_those_that_mujoco_tests(rule, tmp_path):
    """A small ball touches a body where it touches MuJoCo's, a smaller one at most there, a larger one at least."""
    path = tmp_path / "rule.xml"
    before, world, after = mjcf_rules.RULES[rule]
    path.write_text(
        f"<mujoco>{before}<worldbody>{world}{PROBE}</worldbody>{after if 'key' not in after else ''}</mujoco>"
    )
    robot, scene = loaded(path)
    model = oracle.model_of(path)
    model.geom_contype[:] = model.geom_conaffinity[:] = model.body_contype[:] = model.body_conaffinity[:] = 1
    model.geom_margin[:] = model.geom_gap[:] = model.opt.disableflags = 0
    model.geom_size[-1] = RADIUS
    data, names, rng = mujoco.MjData(model), oracle.geom_names(model), np.random.default_rng(2)
    links = robot.link_poses(oracle.as_q(model, model.qpos0))
    posed = [(body, links[robot.link_index(body.link)] @ body.pose) for body in robot.bodies if body.name != "probe"]
    touched = 0
    probes = [pc.Polytope(pc.Sphere(RADIUS * factor)) for factor in (0.97, 1.03)]
    for body, pose in [*posed, *((body, body.pose) for body in scene.bodies)]:
        geom, prepared = names.index(body.name), pc.Polytope(body.shape)
        is_field = model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_HFIELD
        spread = model.hfield_size[model.geom_dataid[geom], :3] if is_field else model.geom_rbound[geom] or 1.0
        for _ in range(PROBES * (10 if is_field else 1)):
            place = pose[:3, 3] + pose[:3, :3] @ (rng.uniform(-1.1, 1.1, 3) * spread)
            data.qpos[-7:] = [*place, 1, 0, 0, 0]
            mujoco.mj_fwdPosition(model, data)
            pairs = {frozenset((contact.geom1, contact.geom2)) for contact in data.contact[: data.ncon]}
            theirs = frozenset((geom, model.ngeom - 1)) in pairs
            at = np.eye(4)
            at[:3, 3] = place
            inner, outer = (pc.intersects(prepared, probe, pose, at) for probe in probes)
            assert inner <= theirs <= outer, (body.name, place)
            touched += theirs
    assert touched
