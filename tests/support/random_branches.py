"""Random robots of two branches with every kind of joint anywhere, and where their links are at any parameter of a
motion: by Pinocchio and closed forms, without plannercheck."""

from dataclasses import dataclass, field, replace

import numpy as np
import pinocchio as pin

KINDS = ("revolute", "continuous", "prismatic", "planar", "floating")
LEADERS = ("revolute", "prismatic", "continuous")


@dataclass(frozen=True)
class Joint:
    """A joint of a tree.

    Attributes:
        kind: URDF's type.
        parent: Link before it.
        child: Link after it.
        xyz: Of its placement, m.
        rpy: rad.
        axis: Unit vector.
        mimic: (leader, multiplier, offset), None for a joint of its own.
    """

    kind: str
    parent: str
    child: str
    xyz: tuple
    rpy: tuple
    axis: tuple
    mimic: tuple | None = None

    @property
    def name(self):
        return f"to_{self.child}"

    @property
    def numbers(self):
        """In a group's configuration."""
        if self.mimic is not None:
            return 0
        return {"planar": 4, "floating": 7}.get(self.kind, 1)

    def urdf(self):
        followed = self.mimic and '<mimic joint="{}" multiplier="{!r}" offset="{!r}"/>'.format(*self.mimic)
        axis = "0 0 1" if self.kind == "planar" else words(self.axis)
        limit = '<limit lower="-50" upper="50" effort="1" velocity="1"/>' if self.kind != "continuous" else ""
        return (
            f'<joint name="{self.name}" type="{self.kind}"><parent link="{self.parent}"/><child link="{self.child}"/>'
            f'<origin xyz="{words(self.xyz)}" rpy="{words(self.rpy)}"/><axis xyz="{axis}"/>'
            f"{limit}{followed or ''}</joint>"
        )


@dataclass(frozen=True)
class Tree:
    """A robot.

    Attributes:
        joints: Parents before children.
        bodies: By link: half edges and centre of a box in the link's frame, m.
    """

    joints: tuple
    bodies: dict = field(default_factory=dict)

    @property
    def group(self):
        """Names of the joints that follow none."""
        return [joint.name for joint in self.joints if joint.mimic is None]

    def urdf(self):
        links = ["base", *(joint.child for joint in self.joints)]
        return "".join(
            ['<robot name="tree">', *map(self._link, links), *(joint.urdf() for joint in self.joints), "</robot>"]
        )

    def _link(self, name):
        if name not in self.bodies:
            return f'<link name="{name}"/>'
        half, centre = self.bodies[name]
        return (
            f'<link name="{name}"><collision><origin xyz="{words(centre)}"/>'
            f'<geometry><box size="{words(2 * np.asarray(half))}"/></geometry></collision></link>'
        )

    def with_body(self, link, half, centre):
        return replace(self, bodies={**self.bodies, link: (np.broadcast_to(half, 3), np.asarray(centre))})

    def motion(self, rng, far=2.0, way=1.5):
        """Both ends of a motion of the group; positions up to `far` m, turns and slides of about `way`."""
        ends = [self._joint_motion(joint, rng, far, way) for joint in self.joints if joint.mimic is None]
        return tuple(np.concatenate([end[k] for end in ends]) for k in range(2))

    @staticmethod
    def _joint_motion(joint, rng, far, way):
        if joint.kind not in ("planar", "floating"):
            start = rng.uniform(-far, far)
            return [start], [start + rng.normal() * way]
        model, n = SINGLE[joint.kind], 2 if joint.kind == "planar" else 3
        start = pin.randomConfiguration(model, -np.ones(model.nq), np.ones(model.nq))
        start = np.concatenate([rng.uniform(-far, far, n), unit(rng, model.nq - n)])
        step = rng.normal(size=model.nv) * way * rng.choice([0.1, 1.0], model.nv)
        step[n:] *= min(1.0, 2.8 / max(np.linalg.norm(step[n:]), 1e-9))
        return start, pin.integrate(model, start, step)

    def poses(self, q0, q1, t):
        """By link, its pose at parameter t: {name: (4, 4)}."""
        values, first = {}, 0
        for joint in self.joints:
            if joint.mimic is None:
                part = slice(first, first + joint.numbers)
                values[joint.name] = between(joint.kind, q0[part], q1[part], t, self._wraps(joint))
                first += joint.numbers
        poses = {"base": np.eye(4)}
        for joint in self.joints:
            if joint.mimic is not None:
                leader, multiplier, offset = joint.mimic
                value = multiplier * values[leader] + offset
            else:
                value = values[joint.name]
            poses[joint.child] = poses[joint.parent] @ placement(joint.xyz, joint.rpy) @ moved(joint, value)
        return poses

    def _wraps(self, joint):
        """Whether a whole turn changes nothing."""
        followers = [other for other in self.joints if other.mimic is not None and other.mimic[0] == joint.name]
        return joint.kind == "continuous" and all(
            other.kind == "continuous" and float(other.mimic[1]).is_integer() for other in followers
        )


def words(numbers):
    return " ".join(repr(float(x)) for x in numbers)


def unit(rng, n):
    vector = rng.normal(size=n)
    return vector / np.linalg.norm(vector)


def single(kind):
    model = pin.Model()
    joint = pin.JointModelPlanar() if kind == "planar" else pin.JointModelFreeFlyer()
    model.addJoint(0, joint, pin.SE3.Identity(), "joint")
    return model


SINGLE = {kind: single(kind) for kind in ("planar", "floating")}


def between(kind, a, b, t, wraps):
    """A joint's numbers at parameter t."""
    if kind in SINGLE:
        return pin.interpolate(SINGLE[kind], np.array(a), np.array(b), float(t))
    way = b - a
    if wraps:
        way = way - 2 * np.pi * np.round(way / (2 * np.pi))
    return a + t * way


def placement(xyz, rpy):
    return pin.SE3(pin.rpy.rpyToMatrix(*rpy), np.array(xyz, dtype=float)).homogeneous


def moved(joint, value):
    """The motion of a joint, (4, 4)."""
    out = np.eye(4)
    if joint.kind in SINGLE:
        data = SINGLE[joint.kind].createData()
        pin.forwardKinematics(SINGLE[joint.kind], data, np.asarray(value))
        return data.oMi[1].homogeneous
    if joint.kind == "prismatic":
        out[:3, 3] = float(value[0]) * np.array(joint.axis)
    else:
        out[:3, :3] = pin.exp3(float(value[0]) * np.array(joint.axis))
    return out


def random_tree(rng, kinds=KINDS, mimics=True, reach=0.5):
    """A trunk of up to two joints and two branches, a and b, of one to three; followers may be anywhere."""
    joints = []
    last = "base"
    for k in range(rng.integers(0, 3)):
        joints.append(_joint(rng, joints, kinds, mimics, last, f"trunk{k}", reach))
        last = joints[-1].child
    for branch in "ab":
        parent = last
        for k in range(rng.integers(1, 4)):
            joints.append(_joint(rng, joints, kinds, mimics, parent, f"{branch}{k}", reach))
            parent = joints[-1].child
    return Tree(tuple(joints))


def tips(tree):
    """The last links of both branches."""
    return tuple([joint.child for joint in tree.joints if joint.child.startswith(branch)][-1] for branch in "ab")


def _joint(rng, joints, kinds, mimics, parent, child, reach):
    leaders = [joint for joint in joints if joint.mimic is None and joint.kind in LEADERS]
    kind, mimic = rng.choice(kinds), None
    if mimics and leaders and rng.random() < 0.4:
        kind = rng.choice(LEADERS)
        mimic = leaders[rng.integers(len(leaders))].name, float(rng.choice([-5, 2, 0.5, -1.3])), rng.uniform(-1, 1)
    xyz, rpy = rng.uniform(-reach, reach, 3), rng.uniform(-3, 3, 3)
    return Joint(str(kind), parent, child, tuple(xyz), tuple(rpy), tuple(unit(rng, 3)), mimic)
