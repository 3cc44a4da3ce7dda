"""Which of a robot's bodies are tested against each other.

In: the joints that move the bodies, an SRDF, the tree of links, disabled pairs. Out: index pairs into the robot's
bodies. With an SRDF they are all pairs on different joints, without those that MoveIt 2 leaves out by that SRDF:
Pinocchio keeps the same pairs where the file has <disable_collisions> alone. Without an SRDF, adjacent links are left
out as well. Pairs that a robot's YAML disables are always left out.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.shapes import GeometryObject
from plannercheck.common.errors import unknown_name
from plannercheck.common.user_warnings import warn
from plannercheck.robots.link_tree import LinkTree
from plannercheck.robots.srdf import DisabledPair, Srdf, disabled_collisions, enabled_collisions, untested_pairs


def self_pairs(
    joints: NDArray[np.int64],
    bodies: tuple[GeometryObject, ...],
    srdf: Srdf | None,
    tree: LinkTree,
    disabled: Iterable[DisabledPair],
) -> NDArray[np.int64]:
    """Index pairs (k, 2) into the robot's bodies, in Pinocchio's order.

    Pinocchio itself searches all pairs for each pair that it adds or removes, and a thousand links have half a million
    pairs. So the same table is made here, from arrays.
    """
    first, second = np.triu_indices(len(bodies), 1)
    apart = joints[first] != joints[second]
    first, second = first[apart], second[apart]
    kept = np.ones(len(first), dtype=bool)
    if srdf is not None:
        untested = untested_pairs(srdf.root, tree.names)
        kept &= ~_of_links(first, second, bodies, (frozenset((pair.link_a, pair.link_b)) for pair in untested))
        _warn_of_one_joint(srdf, joints, bodies)
        if kept.all():
            warn(
                f"SRDF {srdf.path} disables no pair of links{_of_another(srdf, tree)}: adjacent ones, which usually "
                "touch, are tested as well"
            )
    left_out = _disabled_links(disabled, tree)
    if srdf is None:
        left_out |= {frozenset(pair) for pair in tree.parents.items()}
    kept &= ~_of_links(first, second, bodies, left_out)
    return np.stack([first[kept], second[kept]], axis=1)


def without_links(
    pairs: NDArray[np.int64],
    bodies: tuple[GeometryObject, ...],
    srdf: Srdf | None,
    tree: LinkTree,
    disabled: Iterable[DisabledPair],
) -> NDArray[np.int64]:
    """The pairs (k, 2) of bodies that neither an SRDF nor a YAML disables."""
    links = _disabled_links(disabled, tree)
    if srdf is not None:
        links |= {frozenset((pair.link_a, pair.link_b)) for pair in untested_pairs(srdf.root, tree.names)}
    first, second = pairs.T
    return np.asarray(pairs[~_of_links(first, second, bodies, links)])


def _of_links(
    first: NDArray[np.int64],
    second: NDArray[np.int64],
    bodies: tuple[GeometryObject, ...],
    links: Iterable[frozenset[str | None]],
) -> NDArray[np.bool_]:
    """(k,) which pairs of bodies are of one of these pairs of links."""
    names = [body.link for body in bodies]
    number = {name: k for k, name in enumerate(dict.fromkeys(names))}
    listed = [sorted(number[name] for name in pair) for pair in links if pair <= number.keys() and len(pair) == 2]
    codes = np.array([low * len(number) + high for low, high in listed], dtype=np.int64)
    of_body = np.array([number[name] for name in names], dtype=np.int64)
    low, high = np.sort([of_body[first], of_body[second]], axis=0)
    return np.asarray(np.isin(low * len(number) + high, codes))


def _warn_of_one_joint(srdf: Srdf, joints: NDArray[np.int64], bodies: tuple[GeometryObject, ...]) -> None:
    """Warns of enabled pairs that no joint moves against each other, which are left out all the same."""
    joint_of = {body.link: int(joint) for body, joint in zip(bodies, joints, strict=True)}
    still = [
        f"{pair.link_a} and {pair.link_b}"
        for pair in enabled_collisions(srdf.root)
        if pair.link_a != pair.link_b and joint_of.get(pair.link_a, -1) == joint_of.get(pair.link_b, -2)
    ]
    if still:
        warn(
            f"SRDF {srdf.path} enables collisions of links on one joint, which never move against each other and are "
            f"not tested: {', '.join(still[:3])}"
        )


def _of_another(srdf: Srdf, tree: LinkTree) -> str:
    """A hint if an SRDF names other links than the robot has; else empty."""
    named = dict.fromkeys(link for pair in disabled_collisions(srdf.root) for link in (pair.link_a, pair.link_b))
    unknown = [name for name in named if name not in tree.names]
    return f" of this robot, but of {', '.join(unknown[:3])}, which it has not" if unknown else ""


def _disabled_links(disabled: Iterable[DisabledPair], tree: LinkTree) -> set[frozenset[str | None]]:
    pairs: set[frozenset[str | None]] = set()
    for pair in disabled:
        for link in (pair.link_a, pair.link_b):
            if link not in tree.names:
                raise unknown_name("link in disabled_pairs", link, tree.names)
        pairs.add(frozenset((pair.link_a, pair.link_b)))
    return pairs
