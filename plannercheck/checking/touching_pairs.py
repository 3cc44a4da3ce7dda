"""Warnings about pairs that touch and that no joint moves: they touch at every configuration.

In: such pairs, bodies and their poses at the reference. Out: a `RuntimeWarning` for each pair that touches. Links that
are fixed to the world are not tested against obstacles, so such a contact would go unnoticed. A carried object that
touches a link which no joint moves against it makes every configuration invalid.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence

import numpy as np

from plannercheck.bodies.shapes import GeometryObject
from plannercheck.checking.compiled_pairs import CompiledPairs, PairSource
from plannercheck.common.array_types import Floats, Ints
from plannercheck.common.user_warnings import warn

LinkPoses = Callable[[Floats], Floats]

_UNCOUNTED = (
    "{0!r} of {robot}, which is fixed to the world, touches obstacle {1!r}; "
    "this pair is not counted at any configuration"
)
_COUNTED = (
    "{1!r}, which a link of {robot} carries, touches {0!r} at every configuration, since no joint of the group moves "
    "one against the other: no configuration is valid unless {0!r} is one of its touch_links"
)


def warn_of_touching(
    source: PairSource,
    labels: Sequence[str],
    uncounted: Ints,
    counted: Ints,
    link_poses: LinkPoses,
    known: Collection[GeometryObject],
) -> None:
    """Warns of touching pairs that no joint moves.

    Args:
        source: The bodies, and how pairs are tested.
        labels: The link or obstacle of each body.
        uncounted: (k, 2) pairs of a link that is fixed to the world and an obstacle.
        counted: (k, 2) pairs of a carried object and a link: if they touch, no configuration is valid.
        link_poses: A function from configurations (n, nq) to poses of links (n, links, 4, 4), m.
        known: Bodies of an earlier checker, which has warned of pairs of them.
    """
    for rows, words in ((uncounted, _UNCOUNTED), (counted, _COUNTED)):
        news = [row for row in rows.tolist() if not all(source.bodies[k] in known for k in row)]
        for a, b in _touching(source, np.array(news, dtype=np.int32).reshape(-1, 2), link_poses):
            text = words.format(labels[a], labels[b], robot=source.robot.name)
            warn(text)


def _touching(source: PairSource, pairs: Ints, link_poses: LinkPoses) -> list[list[int]]:
    """Which of these pairs (k, 2) touch at the reference."""
    if not len(pairs):
        return []
    colliding = CompiledPairs(source, pairs).colliding(link_poses(source.robot.reference[None]))[0]
    touching: list[list[int]] = pairs[colliding].tolist()
    return touching
