"""Objects picked up and put down: a checker for the scene in which a link carries one more, or one less.

In: a checker that can take another scene. Out: `CarryingChecker` with `attach` and `detach`, which give new checkers
that share all prepared bodies with the one before.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plannercheck.bodies.objects import Parts
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.robots.anchored_objects import inverse
from plannercheck.scenes.scene import Scene

Same = TypeVar("Same", bound="CarryingChecker")


class CarryingChecker(ABC):
    """A checker whose scene can be exchanged, so that links may take up objects and put them down."""

    scene: Scene

    @abstractmethod
    def with_scene(self: Same, scene: Scene | None) -> Same:
        """The same checker for another scene."""

    @abstractmethod
    def _link_pose(self, link: str, q: ArrayLike) -> NDArray[np.float64]:
        """(4, 4) of a link at one configuration (nq,), m."""

    def attach(
        self: Same,
        name: str,
        parts: Parts | None,
        link: str,
        pose: ArrayLike | None = None,
        touch_links: Iterable[str] = (),
        *,
        q: ArrayLike | None = None,
    ) -> Same:
        """The same checker with an object that a link carries.

        Args:
            name: Of the object.
            parts: Its shape, or posed shapes; None for an object of the scene, which leaves the world.
            link: Which carries it. The object is tested against all other links, and against obstacles.
            pose: (4, 4) of the object's frame in the link's, m.
            touch_links: Links, or other carried objects, that it may touch, too.
            q: (nq,) instead of `pose`, for an object of the scene: it is attached where it stands while the robot is at
                this configuration.

        Returns:
            A checker that shares all prepared bodies with this one.
        """
        scene = self.scene.copy()
        if q is not None:
            if pose is not None or parts is not None:
                raise PlannercheckError("attach takes a pose on the link, or for an object of the scene q=, not both")
            pose = inverse(self._link_pose(link, q)) @ scene.object(name).pose
        scene.attach(name, link, pose, touch_links, parts)
        return self.with_scene(scene)

    def detach(self: Same, name: str, q: ArrayLike | None = None) -> Same:
        """The same checker without an attached object, or with it standing in the world.

        Args:
            name: Of the object.
            q: (nq,) the object becomes an obstacle where it is at this configuration; None removes it.

        Returns:
            A checker that shares all prepared bodies with this one.
        """
        scene = self.scene.copy()
        if name not in {item.name for item in scene.attached}:
            raise unknown_name("attached object", name, [item.name for item in scene.attached])
        if q is None:
            scene.remove(name)
        else:
            item = scene.object(name)
            scene.detach(name, self._link_pose(str(item.link), q) @ item.pose)
        return self.with_scene(scene)
