"""Pairs of convex polygons for the planar tests: random, near contact, degenerate; a robot and a scene.

In: a random generator. Out: vertices (n, 2) of both, and their poses (3, 3).
"""

import numpy as np

import plannercheck as pc

# Gaps of pairs near contact, as a part of the size; negative ones overlap. Below about 1e-16 rounding decides.
GAPS = (0.0, *(sign * 10.0**-k for k in range(2, 18) for sign in (1, -1)))


def rotation(angle):
    pose = np.eye(3)
    pose[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    return pose


def random_pose(rng, reach=2.0):
    """Any pose, one of a quarter turn, or a shift by whole numbers."""
    pose = rotation(rng.uniform(0, 2 * np.pi)) if rng.random() < 0.6 else np.eye(3)
    if rng.random() < 0.2:
        pose[:2, :2] = [[0, -1], [1, 0]]
    pose[:2, 2] = rng.uniform(-reach, reach, 2) if rng.random() < 0.6 else rng.integers(-3, 4, 2)
    return pose


def ellipse(rng, n, flatness=1.0):
    """n vertices at random angles; convex in doubles, too, for some hundred vertices."""
    angles = (np.arange(n) + rng.uniform(0.2, 0.8, n)) * 2 * np.pi / n
    return np.column_stack([np.cos(angles), flatness * np.sin(angles)])


def regular(n, flatness=1.0):
    """n vertices at equal angles."""
    angles = 2 * np.pi * np.arange(n) / n
    return np.column_stack([np.cos(angles), flatness * np.sin(angles)])


def sliver(rng, n):
    return ellipse(rng, n, 10.0 ** -rng.uniform(2, 8))


def with_runs(rng, n):
    """A convex polygon on a coarse grid with further vertices on its sides, exactly on them."""
    corners = hull_of_grid(np.rint(8 * ellipse(rng, max(n // 2, 3))))
    rows = []
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        parts = np.flatnonzero(rng.random(8) < rng.choice([0.0, 0.3, 0.9]))
        rows += [a] + [a + (b - a) * k / 8 for k in parts if k]
    return np.array(rows) / 4


def hull_of_grid(points):
    """Corners of the hull of whole numbers (n, 2), counter-clockwise, by the monotone chain."""

    def half(ordered):
        chain = []
        for p in ordered:
            while len(chain) > 1 and turn(chain[-2], chain[-1], p) <= 0:
                chain.pop()
            chain.append(p)
        return chain[:-1]

    def turn(a, b, c):
        return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])

    ordered = sorted({tuple(row) for row in points.tolist()})
    return np.array(half(ordered) + half(ordered[::-1]))


def point(rng, n):
    return rng.integers(-3, 4, (1, 2)).astype(float)


def segment(rng, n):
    ends = rng.integers(-3, 4, (2, 2)).astype(float)
    return ends if (ends[0] != ends[1]).any() else ends[:1]


def folded(rng, n):
    """Vertices on a line, out and back."""
    way = rng.integers(1, 3, 2) * rng.choice([-1, 1], 2)
    places = np.sort(rng.choice(np.arange(-8, 9), max(n, 3), replace=False))
    there = rng.random(len(places)) < 0.5
    there[0], there[-1] = True, False
    order = np.concatenate([places[there], places[~there][::-1]])
    return rng.integers(-2, 3, 2) + np.outer(order, way) / 4


ROUND = (ellipse, sliver, with_runs)
FLAT = (point, segment, folded)


def shuffled(rng, vertices):
    """The same polygon from another vertex on, or the other way round."""
    rolled = np.roll(vertices, rng.integers(len(vertices)), axis=0)
    return np.ascontiguousarray(rolled if rng.random() < 0.5 else rolled[::-1])


def random_polygon(rng, kinds=ROUND + FLAT, largest=14):
    return shuffled(rng, kinds[rng.integers(len(kinds))](rng, int(rng.integers(3, largest))))


def random_pair(rng, kinds=ROUND + FLAT, largest=14):
    polygons = (random_polygon(rng, kinds, largest) for _ in range(2))
    return *polygons, random_pose(rng), random_pose(rng)


def near_pair(rng, largest=14, kinds=ROUND):
    """A pair whose second polygon touches a side or corner of the first, up to a gap and rounding."""
    a, b = random_polygon(rng, kinds, largest), random_polygon(rng, kinds, largest)
    pose_a, pose_b = random_pose(rng), random_pose(rng)
    placed = a @ pose_a[:2, :2].T + pose_a[:2, 2]
    k = rng.integers(len(placed))
    way = placed[(k + 1) % len(placed)] - placed[k]
    normal = np.array([way[1], -way[0]]) / np.linalg.norm(way) if way.any() else np.array([0.6, 0.8])
    if (placed - placed[k]).sum(axis=0) @ normal > 0:  # the centre is on the inner side
        normal = -normal
    contact = placed[k] + way * rng.choice([0.0, 0.5, 1.0, rng.random()])
    turned = b @ pose_b[:2, :2].T
    gap = rng.choice(GAPS)
    pose_b[:2, 2] = contact + gap * normal - turned[np.argmin(turned @ normal)]
    if rng.random() < 0.3:  # one step of a double away
        axis = rng.integers(2)
        pose_b[axis, 2] = np.nextafter(pose_b[axis, 2], rng.choice([-np.inf, np.inf]))
    return a, b, pose_a, pose_b


def nudged(rng, pair, count):
    """The pair and `count` more whose second polygon is a little off: by a part of its size or by steps of a double."""
    a, b, pose_a, pose_b = pair
    pairs = [pair]
    for _ in range(count):
        pose = pose_b.copy()
        axis, gap = rng.integers(2), rng.choice(GAPS)
        pose[axis, 2] = np.nextafter(pose[axis, 2], rng.choice([-9, 9])) if rng.random() < 0.3 else pose[axis, 2] + gap
        pairs.append((a, b, pose_a, pose))
    return pairs


def exact_contact(rng, largest=14):
    """Polygons on a grid that share a corner, or a corner and a place on a side, without any rounding."""
    a, b = (with_runs(rng, int(rng.integers(6, largest))) for _ in range(2))
    k = rng.integers(len(a))
    way = a[(k + 1) % len(a)] - a[k]
    normal = np.array([way[1], -way[0]])  # outwards: these run counter-clockwise
    pose = np.eye(3)
    pose[:2, 2] = a[k] + way * rng.choice([0.0, 0.25, 0.5]) - b[np.argmin(b @ normal)]
    pose[:2, 2] += rng.choice([0, 0, 1, -1]) * np.spacing(rng.choice([1e-3, 1.0])) * np.sign(normal)
    return shuffled(rng, a), shuffled(rng, b), np.eye(3), pose


def nested_pair(rng, largest=14):
    """One polygon strictly inside the other, either one."""
    outer, inner = 10 * ellipse(rng, int(rng.integers(3, largest))), random_polygon(rng, largest=largest)
    pair = (shuffled(rng, outer), inner / 4)
    a, b = pair if rng.random() < 0.5 else pair[::-1]
    return a, b, rotation(rng.uniform(0, 7)), rotation(rng.uniform(0, 7))


def chain():
    """A truck with two trailers, a mast fixed to the second, and a concave truck."""
    truck = [[-1, -1], [5, -1], [5, 1], [3, 1], [3, 0.2], [-1, 1]]
    return pc.planar.Robot(
        [
            pc.planar.Link("truck", truck, joint="free"),
            pc.planar.Link(
                "one", [[-6, -1], [0.5, -1], [0.5, 1], [-6, 1]], "truck", (-0.5, 0.1, 0.2), "revolute", (-1.2, 1.2)
            ),
            pc.planar.Link("two", [[-4, -1], [0.5, -1], [0.5, 1], [-4, 1]], "one", (-6, 0, 0), "revolute"),
            pc.planar.Link("mast", [[0, 0], [0, 6]], "two", (-4, 0, 0.5)),
        ],
        name="chain",
    )


def cluttered(seed=0, count=60, reach=20.0):
    rng = np.random.default_rng(seed)
    scene = pc.planar.Scene("cluttered", [[-reach, -reach], [reach, reach]])
    for k in range(count):
        scene.add_box(
            f"box{k}", rng.uniform(0.1, 2, 2), pc.planar.pose_of(rng.uniform(-reach, reach, 2), rng.uniform(0, 7))
        )
    scene.add_polygon("ell", [[0, 0], [3, 0], [3, 1], [1, 1], [1, 3], [0, 3]])
    return scene
