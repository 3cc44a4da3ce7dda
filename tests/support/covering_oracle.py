"""What covers hold, by fractions alone, and robots to cover; shares nothing with plannercheck/coverings."""

import itertools
from fractions import Fraction

import numpy as np

import plannercheck as pc
from plannercheck.coverings.primitives import Primitives


def exact(point):
    return [Fraction(x) for x in point]


def ball_holds(centre, radius, point):
    return sum((x - y) ** 2 for x, y in zip(exact(centre), point, strict=True)) <= Fraction(radius) ** 2


def capsule_holds(a, b, radius, point):
    a, b = exact(a), exact(b)
    along, off = [y - x for x, y in zip(a, b, strict=True)], [y - x for x, y in zip(a, point, strict=True)]
    square, product = sum(x * x for x in along), sum(x * y for x, y in zip(along, off, strict=True))
    if product <= 0 or product >= square:
        return ball_holds(a if product <= 0 else b, radius, point)
    return sum(x * x for x in off) * square - product**2 <= Fraction(radius) ** 2 * square


def box_holds(pose, half, point):
    """Of a pose whose axes are those of the frame, in any order."""
    columns = np.array(pose)[:3, :3].T.tolist()
    off = [x - Fraction(y) for x, y in zip(point, np.array(pose)[:3, 3].tolist(), strict=True)]
    return all(
        abs(sum(Fraction(x) * y for x, y in zip(column, off, strict=True))) <= Fraction(h)
        for column, h in zip(columns, half, strict=True)
    )


def holds(cover, point):
    """Whether a union holds a point (three fractions)."""
    pairs = zip(cover.ends.tolist(), cover.radii.tolist(), strict=True)
    boxes = zip(cover.frames.tolist(), cover.halves.tolist(), strict=True)
    return any(capsule_holds(a, b, r, point) for (a, b), r in pairs) or any(box_holds(*box, point) for box in boxes)


def distances(cover, points):
    """How far points are outside spheres and capsules, in doubles, by another formula than ours."""
    found = []
    for (a, b), radius in zip(cover.ends, cover.radii, strict=True):
        best = np.minimum(np.linalg.norm(points - a, axis=1), np.linalg.norm(points - b, axis=1))
        length = np.linalg.norm(b - a)
        if length:
            along = (points - a) @ (b - a) / length
            beside = (along > 0) & (along < length)
            best[beside] = np.linalg.norm(np.cross(points - a, b - a), axis=1)[beside] / length
        found.append(best - radius)
    return np.min(found, axis=0)


def random_cover(rng, count, capsules=0):
    spheres = [(rng.normal(size=3).tolist(), rng.uniform(0.3, 1.0)) for _ in range(count)]
    return Primitives.of(spheres, [(*rng.normal(size=(2, 3)).tolist(), rng.uniform(0.2, 0.6)) for _ in range(capsules)])


def samples_in_hull(rng, vertices, count):
    """Points in a hull, many of them on its edges and corners."""
    weights = rng.dirichlet(np.full(len(vertices), 0.15), count)
    return np.concatenate([vertices, weights @ vertices])


def write_robot(folder, links):
    """A chain of links with these collision elements, joined by turns about z, 1 m apart."""
    names = list(links)
    parts = [f'<link name="{name}">{links[name]}</link>' for name in names]
    for a, b in itertools.pairwise(names):
        parts.append(
            f'<joint name="{a}_{b}" type="revolute"><parent link="{a}"/><child link="{b}"/><origin xyz="1 0 0"/>'
            '<axis xyz="0 0 1"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>'
        )
    path = folder / "robot.urdf"
    path.write_text(f'<robot name="robot">{"".join(parts)}</robot>')
    return pc.Robot.from_urdf(path)


def element(shape, xyz="0 0 0", rpy="0 0 0"):
    return f'<collision><origin xyz="{xyz}" rpy="{rpy}"/><geometry>{shape}</geometry></collision>'
