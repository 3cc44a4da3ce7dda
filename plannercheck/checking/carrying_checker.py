"""Objects that links pick up and put down: a checker for the scene after an object was attached or detached.

In: a checker that can take another scene. Out: `CarryingChecker` with `attach` and `detach`, which return new checkers.
These share all prepared bodies with the checker they come from.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plannercheck.bodies.objects import Parts
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.transforms import inverse
from plannercheck.scenes.scene import Scene

Same = TypeVar("Same", bound="CarryingChecker")


class CarryingChecker(ABC):
    """A checker that makes new checkers in which a link carries another object, or puts one down."""

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
            name: The object's name.
            parts: Its shape, or posed shapes; None to take an obstacle of the scene.
            link: The link that carries it. The object is tested against all other links and against obstacles.
            pose: (4, 4) of the object's frame in the link's, m.
            touch_links: Other links or carried objects that it may touch.
            q: (nq,) in place of `pose`, for an obstacle of the scene: the configuration at which it is attached, where
                it stands.

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
        """The same checker without an attached object, or with that object as an obstacle.

        Args:
            name: The object's name.
            q: (nq,) the configuration at which it is put down: it becomes an obstacle where it is then. None removes
                it.

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
