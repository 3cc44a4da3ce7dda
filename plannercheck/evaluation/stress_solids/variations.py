"""Faults that any mesh may have: inside out, holes, doubled or split triangles, no thickness.

In: a `Surface`, a random generator. Out: another `Surface`. No fault moves a point off a lattice of powers of two.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from plannercheck.evaluation.stress_solids.surfaces import Surface, joined, surface

# Powers of two by which the height is multiplied; the last leaves nothing.
_FLATNESS = (2.0**-10, 2.0**-30, 2.0**-52, 0.0)
# Of the size: moves of corners that turn flat parts into slivers that cross each other.
_TREMBLING = (1e-15, 1e-12, 1e-8)


def inverted(given: Surface, rng: np.random.Generator) -> Surface:
    """Turned inside out."""
    return given.inverted


def opened(given: Surface, rng: np.random.Generator) -> Surface:
    """Without some triangles."""
    count = len(given.triangles)
    kept = rng.permutation(count)[: max(1, count - int(rng.integers(1, 4)))]
    return surface(given.points, given.triangles[np.sort(kept)])


def doubled(given: Surface, rng: np.random.Generator) -> Surface:
    """Every triangle twice: wound around twice, or not at all where the copy is inside out."""
    return joined([given, given.inverted if rng.integers(2) else given])


def separate(given: Surface, rng: np.random.Generator) -> Surface:
    """Each triangle with corners of its own."""
    return surface(given.points[given.triangles.ravel()] + 0.0, np.arange(given.triangles.size))


def split(given: Surface, rng: np.random.Generator) -> Surface:
    """Edges split on one side: T-junctions, closed where a triangle without area is laid in between."""
    points, triangles = list(given.points), given.triangles.tolist()
    fills = bool(rng.integers(2))
    for _ in range(int(rng.integers(1, 6))):
        at = int(rng.integers(len(triangles)))
        a, b, c = np.roll(triangles[at], int(rng.integers(3))).tolist()
        middle = len(points)
        points.append((points[a] + points[b]) / 2)
        triangles[at] = [a, middle, c]
        triangles.append([middle, b, c])
        if fills:
            triangles.append([a, b, middle])
    return surface(np.array(points), triangles)


def with_needles(given: Surface, rng: np.random.Generator) -> Surface:
    """With segments between vertices, and points."""
    ends = rng.integers(0, len(given.points), (int(rng.integers(1, 4)), 2))
    needles = ends[:, [0, 1, 1]] if rng.integers(3) else ends[:, [0, 0, 0]]
    return surface(given.points, np.vstack([given.triangles, needles]))


def with_repeats(given: Surface, rng: np.random.Generator) -> Surface:
    """With some triangles twice, either way up: closed where both ways."""
    some = given.triangles[rng.integers(0, len(given.triangles), int(rng.integers(1, 4)))]
    more = np.vstack([some, some[:, ::-1]]) if rng.integers(2) else some
    return surface(given.points, np.vstack([given.triangles, more]))


def flattened(given: Surface, rng: np.random.Generator) -> Surface:
    """Pressed along an axis: to a sheet, or into a plane."""
    factors = np.ones(3)
    factors[rng.integers(3)] = rng.choice(_FLATNESS)
    if rng.random() < 0.2:
        factors[rng.integers(3)] = rng.choice(_FLATNESS)
    return Surface(given.points * factors, given.triangles)


def trembling(given: Surface, rng: np.random.Generator) -> Surface:
    """Corners moved a little."""
    return Surface(given.points + rng.choice(_TREMBLING) * rng.normal(size=given.points.shape), given.triangles)


def shuffled(given: Surface, rng: np.random.Generator) -> Surface:
    """In another order, with points that no triangle uses."""
    order = rng.permutation(len(given.points) + 2)
    points = np.vstack([given.points, 3 * rng.normal(size=(2, 3))])
    place = np.argsort(order)
    turned = np.array([np.roll(t, rng.integers(3)) for t in given.triangles])
    return surface(points[order], rng.permutation(place[turned]))


Variation = Callable[[Surface, np.random.Generator], Surface]
VARIATIONS: dict[str, Variation] = {
    "inverted": inverted,
    "opened": opened,
    "doubled": doubled,
    "separate": separate,
    "split": split,
    "with needles": with_needles,
    "with repeats": with_repeats,
    "flattened": flattened,
    "trembling": trembling,
    "shuffled": shuffled,
}


def varied(given: Surface, rng: np.random.Generator) -> tuple[Surface, str]:
    """None, one or two of the variations, and their names."""
    names = rng.choice(list(VARIATIONS), size=int(rng.choice([0, 1, 2], p=[0.5, 0.35, 0.15])), replace=False)
    for name in names:
        given = VARIATIONS[str(name)](given, rng)
    return given, "".join(f" {name}" for name in names)
