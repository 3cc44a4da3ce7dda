"""URDFs of random trees of joints, mimics of mimics with offsets among them, and extra bodies where a test wants them.

In: a random generator. Out: `RandomTree`, which writes its URDF with any bodies added: a test can choose a state
first and then put a body where it touches there.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

import plannercheck as pc

KINDS = ("revolute", "prismatic", "continuous")


@dataclass(frozen=True)
class RandomTree:
    """Joints in text, each with its child link; link 0 is the root.

    Attributes:
        joints: The URDF's joint elements; joint k moves link k + 1.
        group: Names of the joints that mimic no other.
        reference: A value within the limits of each joint of the group; continuous ones at 0.
        sizes: Edges of the box on each link, m.
        places: Of these boxes on their links, in the URDF's words.
    """

    joints: tuple[str, ...]
    group: tuple[str, ...]
    reference: dict[str, float]
    sizes: tuple[float, float, float]
    places: tuple[str, ...]

    def robot(self, folder, extra: Mapping[int, Sequence[np.ndarray]] = {}, size: float = 1e-3) -> pc.Robot:
        """The robot with boxes on its links: their own, and a cube about each point (3,) in `extra`, m."""
        path = folder / "tree.urdf"
        links = "".join(self._link(k, extra.get(k, ()), size) for k in range(len(self.joints) + 1))
        path.write_text(f'<robot name="tree">{links}{"".join(self.joints)}</robot>')
        return pc.Robot.from_urdf(path, group=self.group, reference=self.reference)

    def _link(self, k: int, points: Sequence[np.ndarray], size: float) -> str:
        boxes = [box(self.places[k], self.sizes), *(box(f'xyz="{_text(point)}"', (size,) * 3) for point in points)]
        return f'<link name="link{k}">{"".join(boxes)}</link>'


def box(place: str, sizes) -> str:
    """A collision element, its numbers to the last bit."""
    return f'<collision><origin {place}/><geometry><box size="{_text(sizes)}"/></geometry></collision>'


def random_tree(
    rng, joints: int, sizes=(1e-3, 1e-3, 1e-3), reach: float = 1.0, kinds=KINDS, placed: bool = False
) -> RandomTree:
    """A tree of so many joints; every third or so mimics an earlier one, which may be a mimic too.

    Args:
        rng: Generator.
        joints: How many.
        sizes: Edges of the box about each link's origin, m.
        reach: About the length of a link, m.
        kinds: Of joints.
        placed: Whether the boxes are turned and off their links' origins; else they are about them.
    """
    texts, turning = [], []
    group: dict[str, float] = {}
    for k in range(joints):
        kind = str(rng.choice(kinds))
        leaders = [i for i in range(k) if turning[i] == (kind == "revolute")] if kind != "continuous" else []
        follows = bool(leaders) and rng.uniform() < 0.4
        parent = k if rng.uniform() < 0.6 else int(rng.integers(0, k + 1))
        low = rng.uniform(-1, 0)
        limits = (-99.0, 99.0) if follows else (low, low + rng.uniform(0.1, 1.5))
        texts.append(_joint(rng, k, kind, parent, int(rng.choice(leaders)) if follows else None, limits, reach))
        turning.append(kind == "revolute" if kind != "continuous" else None)
        if not follows:
            group[f"joint{k}"] = 0.0 if kind == "continuous" else float(rng.uniform(*limits))
    places = [
        f'xyz="{_text(rng.uniform(-0.3, 0.3, 3))}" rpy="{_text(rng.uniform(-3, 3, 3))}"' if placed else 'xyz="0 0 0"'
        for _ in range(joints + 1)
    ]
    return RandomTree(tuple(texts), tuple(group), group, tuple(sizes), tuple(places))


def _joint(rng, k: int, kind: str, parent: int, leader: int | None, limits, reach: float) -> str:
    axis = rng.normal(size=3)
    axis = np.eye(3)[rng.integers(3)] * rng.choice([-1, 1]) if rng.uniform() < 0.5 else axis / np.linalg.norm(axis)
    origin, turn = rng.uniform(-reach, reach, 3), rng.uniform(-3, 3, 3)
    limit = f'<limit lower="{limits[0]}" upper="{limits[1]}" effort="1" velocity="1"/>' if kind != "continuous" else ""
    mimic = ""
    if leader is not None:
        multiplier = rng.choice([-5.0, -2.0, -0.5, 0.5, 2.0, 3.0])
        mimic = f'<mimic joint="joint{leader}" multiplier="{multiplier}" offset="{rng.uniform(-0.5, 0.5)}"/>'
    return (
        f'<joint name="joint{k}" type="{kind}"><parent link="link{parent}"/><child link="link{k + 1}"/>'
        f'<origin xyz="{_text(origin)}" rpy="{_text(turn)}"/><axis xyz="{_text(axis)}"/>{limit}{mimic}</joint>'
    )


def _text(values) -> str:
    return " ".join(str(float(value)) for value in values)


def limit_states(rng, robot: pc.Robot, n: int) -> np.ndarray:
    """Configurations (n, nq) within the limits: each number random, at a limit, or beside one."""
    q = robot.random_configurations(n, rng)
    kind = rng.integers(0, 4, q.shape)
    finite = np.isfinite(robot.lower)
    q = np.where(finite & (kind == 0), robot.lower, np.where(finite & (kind == 1), robot.upper, q))
    return np.where(finite, np.clip(q, robot.lower, robot.upper), q)


def points_on_others(robot: pc.Robot, q, firsts, seconds, offsets) -> dict[int, list[np.ndarray]]:
    """For each configuration (n, nq) a point of one link, in another link's frame: by that link.

    A body put there on the second link touches one at that point of the first, at this configuration. `offsets` (n, 3)
    are the points in the frames of the first links.
    """
    poses = robot.link_poses(q)
    points: dict[int, list[np.ndarray]] = {}
    for k, (a, b) in enumerate(zip(firsts, seconds, strict=True)):
        on, other = (poses[k, robot.link_index(f"link{link}")] for link in (b, a))
        world = other[:3, :3] @ offsets[k] + other[:3, 3]
        points.setdefault(int(b), []).append(on[:3, :3].T @ (world - on[:3, 3]))
    return points
