"""What robots and checkers in space and in the plane have in common, for code that serves both."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plannercheck.checking.verdicts import MotionVerdict, PairVerdict, Verdict
from plannercheck.common.array_types import Floats


class AnyRobot(Protocol):
    """A robot whose links are posed by configurations (nq,)."""

    @property
    def name(self) -> str:
        """The robot's name."""

    @property
    def nq(self) -> int:
        """How many numbers a configuration has."""

    @property
    def link_names(self) -> tuple[str, ...]:
        """Names of the links."""

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints, or of the numbers."""

    @property
    def lower(self) -> Floats:
        """(nq,) lower limits."""

    @property
    def upper(self) -> Floats:
        """(nq,) upper limits."""

    def check_configurations(self, q: ArrayLike) -> Floats:
        """Configurations as (n, nq), or an error."""

    def random_configurations(self, n: int, seed: int | np.random.Generator | None = None) -> Floats:
        """Uniform configurations (n, nq) within the limits."""


class AnyScene(Protocol):
    """A scene with declared states."""

    @property
    def name(self) -> str:
        """The scene's name."""

    def start(self, robot: str) -> Floats:
        """The start that it declares for a robot."""

    def goal(self, robot: str) -> Floats:
        """The goal that it declares for a robot."""


class AnyChecker(Protocol):
    """A robot in a scene, with exact verdicts."""

    @property
    def robot(self) -> AnyRobot:
        """The robot."""

    @property
    def scene(self) -> AnyScene:
        """The scene."""

    @property
    def pairs(self) -> NDArray[np.int32]:
        """(k, 2) indices of the bodies that are tested against each other."""

    @property
    def motion_sampler(self) -> Any:
        """Says how many states a motion needs (`steps`), and interpolates them (`states`)."""

    def is_valid(self, q: ArrayLike) -> bool:
        """Whether one configuration is free."""

    def check_states(self, q: ArrayLike, threads: int = 1) -> NDArray[np.bool_]:
        """Whether each configuration is free."""

    def first_colliding_pair(self, q: ArrayLike, threads: int = 1) -> NDArray[np.int32]:
        """The first colliding pair of each configuration, or -1."""

    def colliding_pairs(self, q: ArrayLike) -> NDArray[np.bool_]:
        """Which pairs collide."""

    def check_motion(
        self, q0: ArrayLike, q1: ArrayLike, resolution: float | None = None, tolerance: float = ...
    ) -> bool:
        """Whether a motion is free."""

    def check_motions(
        self,
        q0: ArrayLike,
        q1: ArrayLike,
        resolution: float | None = None,
        tolerance: float = ...,
        threads: int = 1,
    ) -> NDArray[np.bool_]:
        """Whether each of several motions is free."""

    def explain_motion(
        self, q0: ArrayLike, q1: ArrayLike, tolerance: float = ..., proofs: bool = False
    ) -> MotionVerdict:
        """How far a motion is free, and what stops it."""

    def pair_names(self, k: int) -> tuple[str, str]:
        """The link and the other link or obstacle of a pair."""

    def explain(self, q: ArrayLike, separations: bool = False) -> Verdict:
        """The verdict of one configuration."""

    def explain_pair(self, k: int, q: ArrayLike) -> PairVerdict:
        """The verdict of one pair at a configuration."""

    def statistics(self) -> dict[str, Any]:
        """Counters."""
