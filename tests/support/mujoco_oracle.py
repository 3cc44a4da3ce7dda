"""MuJoCo itself as the oracle of MJCF files: poses of geoms, and the pairs that `mj_collision` tests.

Nothing here knows the rules by which pairs are left out: all geoms become spheres with margins of 1,000 km, so that
MuJoCo makes a contact of every pair that it tests.
"""

import mujoco
import numpy as np

_EVERYWHERE = 1e6  # m

mujoco.set_mju_user_warning(lambda message: None)  # else they are written to a file in the current folder


def model_of(path, memory=None):
    """The compiled model; `memory` is the room for contacts, in bytes."""
    if memory is None:
        return mujoco.MjModel.from_xml_path(str(path))
    spec = mujoco.MjSpec.from_file(str(path))
    spec.memory = memory
    return spec.compile()


def geom_names(model):
    """The documented names: the file's, else body/geom3 by the place on the body, body3 by the number of the body."""
    names = []
    for geom in range(model.ngeom):
        body = int(model.geom_bodyid[geom])
        owner = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, body) or f"body{body}"
        own = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_GEOM, geom)
        names.append(own or f"{owner}/geom{geom - model.body_geomadr[body]}")
    return names


def random_qpos(model, rng):
    """Values of all joints within their ranges, with quaternions of length 1."""
    qpos = np.array(model.qpos0)
    for joint in range(model.njnt):
        first, kind = int(model.jnt_qposadr[joint]), int(model.jnt_type[joint])
        if kind in (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE):
            low, high = model.jnt_range[joint] if model.jnt_limited[joint] else (-3.0, 3.0)
            qpos[first] = rng.uniform(low, high)
            continue
        if kind == mujoco.mjtJoint.mjJNT_FREE:
            qpos[first : first + 3] = rng.uniform(-1, 1, 3)
            first += 3
        turn = rng.standard_normal(4)
        qpos[first : first + 4] = turn / np.linalg.norm(turn)
    return qpos


def as_q(model, qpos):
    """MuJoCo's configuration as ours: quaternions end in w."""
    q = np.array(qpos)
    for joint in range(model.njnt):
        kind, first = int(model.jnt_type[joint]), int(model.jnt_qposadr[joint])
        if kind in (mujoco.mjtJoint.mjJNT_FREE, mujoco.mjtJoint.mjJNT_BALL):
            first += 3 * (kind == mujoco.mjtJoint.mjJNT_FREE)
            q[first : first + 4] = np.roll(q[first : first + 4], -1)
    return q


def geom_poses(model, data, qpos):
    """(geoms, 4, 4) in the world, m, without the shortcut by which MuJoCo takes frames less than 1e-6 apart for one."""
    model.geom_sameframe[:] = 0
    data.qpos[:] = qpos
    mujoco.mj_kinematics(model, data)
    poses = np.tile(np.eye(4), (model.ngeom, 1, 1))
    poses[:, :3, :3], poses[:, :3, 3] = data.geom_xmat.reshape(-1, 3, 3), data.geom_xpos
    return poses


def tested_pairs(path):
    """The names of geoms that MuJoCo tests against each other."""
    try:
        return _contacts(model_of(path))
    except (MemoryError, mujoco.FatalError):  # of contacts, of their pairs
        return _contacts(model_of(path, memory=1 << 31))


def _contacts(model):
    """The names of geoms between which there is a contact once all are everywhere."""
    names = geom_names(model)
    surfaces = np.isin(model.geom_type, [mujoco.mjtGeom.mjGEOM_PLANE])
    model.geom_type[~surfaces] = mujoco.mjtGeom.mjGEOM_SPHERE
    model.geom_rbound[~surfaces] = model.geom_size[~surfaces] = 1.0
    model.geom_margin[:], model.geom_gap[:] = _EVERYWHERE, 0.0
    if model.npair:
        model.pair_margin[:], model.pair_gap[:] = _EVERYWHERE, 0.0
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_MIDPHASE
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_collision(model, data)
    if data.warning[mujoco.mjtWarning.mjWARN_CONTACTFULL].number:
        raise MemoryError
    return {frozenset((names[contact.geom1], names[contact.geom2])) for contact in data.contact[: data.ncon]}


def overlapping(model, data, qpos):
    """The names of geoms between which MuJoCo finds a contact below 0 m."""
    data.qpos[:] = qpos
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_collision(model, data)
    names = geom_names(model)
    found = data.contact[: data.ncon]
    return {frozenset((names[contact.geom1], names[contact.geom2])) for contact in found if contact.dist < 0}
