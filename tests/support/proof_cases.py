"""What tests of proofs are about: random trees with every kind of joint, free motions, and proofs written by hand."""

from dataclasses import replace

import numpy as np
import pinocchio as pin

import plannercheck as pc
from plannercheck.common.package_data import example_robot_data
from plannercheck.proofs import Entry, Joint, Link, Model, Motion, PosedBody, Proof
from plannercheck.proofs.well_formed import hashes_of
from plannercheck.robots.description import find_description, read_description

KINDS = ("revolute", "continuous", "prismatic", "planar", "floating")


def random_tree(generator, folder, links=6, kinds=KINDS, mimics=True):
    """A URDF of random joints with boxes, balls and cylinders; some joints mimic others. Returns its path."""
    parts, leaders = ["<robot name='tree'>"], []
    for k in range(links):
        size = generator.uniform(0.02, 0.2, 3)
        shape = (
            f"<box size='{size[0]} {size[1]} {size[2]}'/>",
            f"<sphere radius='{size[0] / 2}'/>",
            f"<cylinder radius='{size[0] / 2}' length='{size[1]}'/>",
        )[generator.integers(3)]
        parts.append(
            f"<link name='l{k}'><collision><origin xyz='{numbers(generator.uniform(-0.1, 0.1, 3))}' "
            f"rpy='{numbers(generator.uniform(-3, 3, 3))}'/><geometry>{shape}</geometry></collision></link>"
        )
    for k in range(1, links):
        kind = kinds[generator.integers(len(kinds))]
        tag = ""
        if mimics and leaders and kind in ("revolute", "prismatic") and generator.random() < 0.4:
            leader = leaders[generator.integers(len(leaders))]
            tag = (
                f"<mimic joint='{leader}' multiplier='{generator.uniform(-2, 2)}' offset='{generator.uniform(-1, 1)}'/>"
            )
        elif kind in ("revolute", "prismatic"):
            leaders.append(f"j{k}")
        parent = int(generator.integers(max(0, k - 2), k))
        parts.append(
            f"<joint name='j{k}' type='{kind}'><parent link='l{parent}'/><child link='l{k}'/>"
            f"<origin xyz='{numbers(generator.uniform(-0.5, 0.5, 3))}' rpy='{numbers(generator.uniform(-3, 3, 3))}'/>"
            f"<axis xyz='{'0 0 1' if kind == 'planar' else numbers(axis(generator))}'/>{tag}"
            f"<limit lower='-2' upper='2' effort='1' velocity='1'/></joint>"
        )
    path = folder / "tree.urdf"
    path.write_text("\n".join([*parts, "</robot>"]))
    return path


def axis(generator):
    if generator.random() < 0.3:
        return np.eye(3)[generator.integers(3)] * generator.choice([-1, 1])
    direction = generator.normal(size=3)
    return direction / np.linalg.norm(direction)


def numbers(values):
    return " ".join(repr(float(x)) for x in values)


def whole_robot(name, floating=False):
    """A robot in Pinocchio's own numbers."""
    description = read_description(find_description(name))
    return pc.Robot.from_urdf(description.urdf, description.srdf, package_dirs=example_robot_data(), floating=floating)


def scattered(generator, count=5, reach=1.2):
    """A scene of small bodies around the robot."""
    scene = pc.Scene("scattered")
    for k in range(count):
        pose = np.eye(4)
        pose[:3, :3] = pin.exp3(generator.normal(size=3))
        pose[:3, 3] = generator.uniform(-reach, reach, 3)
        if k % 3:
            scene.add_box(f"box{k}", generator.uniform(0.001, 0.2, 3), pose)
        else:
            scene.add_sphere(f"ball{k}", float(generator.uniform(0.01, 0.1)), pose)
    return scene


def free_motions(checker, count, seed, tries=400):
    """Starts and ends (k, nq) of at most `count` free motions, some short, some long."""
    generator = np.random.default_rng(seed)
    q = checker.robot.random_configurations(tries, generator)
    q = q[checker.check_states(q)]
    q0, q1 = q[: len(q) // 2], q[len(q) // 2 : 2 * (len(q) // 2)]
    if len(checker.robot.joint_names) == checker.robot.nq:
        q1 = q0 + (q1 - q0) * generator.uniform(0.05, 1.0, (len(q0), 1))
    free = np.flatnonzero(checker.check_motions(q0, q1))[:count]
    return q0[free], q1[free]


STILL = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0)
CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / 2.0


def sealed(proof, **changes):
    """A proof with changes, whose hashes are made to fit."""
    changed = replace(proof, **changes)
    return replace(changed, hashes=hashes_of(changed.model))


def at(x=0.0, y=0.0, z=0.0):
    return (1.0, 0.0, 0.0, x, 0.0, 1.0, 0.0, y, 0.0, 0.0, 1.0, z)


def point(name, link, pose=STILL, vertices=((0.0, 0.0, 0.0),), radius=0.0, reach=1e-200):
    return PosedBody(name, name, link, pose, np.array(vertices, dtype=np.float64), radius, 0.0, (0.0, 0.0, 0.0), reach)


def turn(parent=-1, placement=STILL, axis=(0.0, 0.0, 1.0), column=0, multiplier=1.0, offset=0.0, kind="turn"):
    return Joint(f"j{column}", kind, parent, placement, axis, (column,), (multiplier,), (offset,))


def claim(joints, bodies, start, end, entries, margin=0.0, links=None, pairs=((0, 1),), asked=None, whole=()):
    """A proof of what is given, link k on joint k."""
    links = links or tuple(Link(f"l{k}", k, STILL) for k in range(len(joints)))
    model = Model(tuple(joints), tuple(links), tuple(bodies), tuple(pairs), tuple(whole), len(start))
    motion = Motion(tuple(start), tuple(end), tuple(end if asked is None else asked))
    return Proof("space", "r", "s", hashes_of(model), model, motion, margin, tuple(entries))


def plane(direction=(0.0, 1.0, 0.0), frame=-1, start=0.0, end=1.0, pair=0):
    return Entry(pair, start, end, "plane", frame, tuple(map(float, direction)))


def middle(matrix):
    return np.array([float(x) for x in matrix.entries()]).reshape(4, 4)


def proofs_where_free(checker, start, end, least):
    """The proofs of the motions that are free, of which there are more than `least`; every one is confirmed."""
    free = checker.check_motions(start, end)
    assert free.sum() > least
    proofs = checker.certify_motions(start, end)
    assert [proof is not None for proof in proofs] == free.tolist()
    found = [proof for proof in proofs if proof is not None]
    for proof in found:
        assert proof.verify(), proof.verify().fault
    return found
