"""Objects that a robot's links carry: the links that they are tested against.

In: a robot's links and bodies, attached objects of a scene. Out: the pairs that carried bodies add to the robot's self
pairs. As in MoveIt, a carried object is tested against all links except its own link and its touch links. It is tested
against all other carried objects, except objects on the same link, and pairs in which one object names the other as a
touch link.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence

from plannercheck.bodies.objects import SceneObject
from plannercheck.bodies.shapes import GeometryObject
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.user_warnings import warn


def listed_objects(objects: Iterable[SceneObject]) -> tuple[SceneObject, ...]:
    """The objects, each of another name, or an error for what is no list of objects."""
    listed = tuple(objects) if isinstance(objects, Iterable) else (None,)
    if not all(isinstance(item, SceneObject) for item in listed):
        raise PlannercheckError(f"a robot carries a list of attached objects, e.g. scene.attached, not {objects!r:.80}")
    names = [item.name for item in listed]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise PlannercheckError(f"a robot carries two objects named {twice!r}: rename one, or leave it out")
    return listed


def check_objects(objects: Sequence[SceneObject], links: Sequence[str], bodies: Sequence[GeometryObject]) -> None:
    """Raises for unknown links and for names that the robot's bodies have; warns of touch links that do not exist."""
    taken = {*links, *(body.name for body in bodies)}
    names = {item.name for item in objects}
    for item in objects:
        if item.link not in links:
            raise unknown_name(f"link that carries {item.name!r}", str(item.link), links)
        for name in (item.name, *(body.name for body in item.bodies)):
            if name in taken:
                raise PlannercheckError(f"attached object {item.name!r}: a link or body of the robot is named {name!r}")
        unknown = [link for link in item.touch_links if link not in links and link not in names]
        if unknown:
            warn(f"touch links {', '.join(unknown)} of {item.name!r} are no links of the robot, left out")


def carried_pairs(objects: Sequence[SceneObject], bodies: Sequence[GeometryObject]) -> list[tuple[int, int]]:
    """Index pairs that carried bodies add to a robot's self pairs: those with links, then those among the objects.

    The objects' bodies follow the robot's own, object by object.
    """
    owners = [item for item in objects for _ in item.bodies]
    first = len(bodies)
    with_links = [
        (k, first + i)
        for i, item in enumerate(owners)
        for k, body in enumerate(bodies)
        if body.link != item.link and body.link not in item.touch_links
    ]
    among = [
        (first + i, first + j)
        for (i, a), (j, b) in itertools.combinations(enumerate(owners), 2)
        if a.link != b.link and a.name not in b.touch_links and b.name not in a.touch_links
    ]
    return with_links + among
