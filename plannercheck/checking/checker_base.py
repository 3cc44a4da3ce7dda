"""Names and certificates for a checker's verdicts, in space and in the plane.

In: a checker that poses bodies and finds colliding pairs. Out: `ExplainingChecker`, whose `explain` returns the verdict
of one configuration with all colliding pairs, each with its proof.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.checking.named_configurations import given_configurations, named_configuration
from plannercheck.checking.protocols import AnyRobot, AnyScene
from plannercheck.checking.verdicts import PairCertificate, PairVerdict, Verdict
from plannercheck.common.array_types import Bools, Floats, Ints
from plannercheck.common.arrays import Configuration, real_numbers, shown_array
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.whole_numbers import row_of_table


class NamedBody(Protocol):
    """A body of a robot or a scene."""

    @property
    def name(self) -> str:
        """The name that reports use."""


class ExplainingChecker(ABC):
    """A checker whose verdicts have names and certificates.

    Attributes:
        robot: The robot.
        scene: The scene.
        bodies: The robot's bodies, then the scene's.
        pairs: (k, 2) indices into `bodies`: the pairs that are tested at every configuration.
    """

    robot: AnyRobot
    scene: AnyScene
    bodies: Sequence[NamedBody]
    pairs: Ints
    _labels: tuple[str, ...]  # the link or obstacle of each body

    @abstractmethod
    def colliding_pairs(self, q: ArrayLike) -> Bools:
        """Which pairs collide: (n, k) for configurations (n, nq) and the k rows of `pairs`."""

    @abstractmethod
    def body_poses(self, q: ArrayLike) -> Floats:
        """World poses of all bodies (n, bodies, …) at configurations (n, nq): the very doubles that verdicts use."""

    @abstractmethod
    def _certificate(self, a: int, b: int, poses: Floats) -> PairCertificate:
        """The proof of the verdict of two of `bodies`, at poses of all bodies."""

    @abstractmethod
    def _kinematic_error(self, q: Floats, poses: Floats) -> float:
        """The proven bound of the error of poses (bodies, …) at a configuration (nq,), m."""

    def explain(self, q: Configuration, separations: bool = False) -> Verdict:
        """The verdict of one configuration with the names and certificates behind it.

        Args:
            q: (nq,) rad and m, or each joint's value by its name.
            separations: Whether to give what separates all other pairs, too: planes, or lines in the plane.

        Returns:
            The verdict; certificates are in world coordinates.
        """
        row = self._single(q)
        colliding, poses = self.colliding_pairs(row)[0], self.body_poses(row)[0]
        wanted = range(len(self.pairs)) if separations else np.flatnonzero(colliding).tolist()
        found = [self.pair_verdict(k, poses, bool(colliding[k])) for k in wanted]
        return Verdict(
            not colliding.any(),
            tuple(v for v in found if v.colliding),
            tuple(v for v in found if not v.colliding),
            self._kinematic_error(row[0], poses),
        )

    def explain_pair(self, k: int, q: Configuration) -> PairVerdict:
        """The verdict of row k of `pairs` alone.

        Args:
            k: The row.
            q: (nq,) rad and m.

        Returns:
            The verdict with its certificate.
        """
        row, k = self._single(q), row_of_table(k, len(self.pairs))
        return self.pair_verdict(k, self.body_poses(row)[0], bool(self.colliding_pairs(row)[0, k]))

    def pair_verdict(self, k: int, poses: Floats, colliding: bool) -> PairVerdict:
        """The verdict of row k of `pairs` at poses of all bodies (bodies, …), m, with its certificate."""
        a, b = self.pairs[k].tolist()
        certificate = self._certificate(a, b, poses)
        links, names = self.pair_names(k), (self.bodies[a].name, self.bodies[b].name)
        if colliding:
            names = self._names_of_met(a, b, poses)
        return PairVerdict(*links, *names, colliding, certificate)

    def _names_of_met(self, a: int, b: int, poses: Floats) -> tuple[str, str]:
        """The names of two bodies that share a point; the name of a set of parts includes the part that does."""
        return self.bodies[a].name, self.bodies[b].name

    def pair_names(self, k: int) -> tuple[str, str]:
        """The link and the other link or obstacle of row k of `pairs`."""
        a, b = self.pairs[row_of_table(k, len(self.pairs))]
        return self._labels[a], self._labels[b]

    def _single(self, q: Configuration) -> Floats:
        """One configuration as a row (1, nq), from (nq,), (1, nq) or names of joints; or an error.

        Its numbers are checked later.
        """
        nq = self.robot.nq
        if type(q) is np.ndarray and q.shape == (nq,) and q.dtype.char == "d":  # most of all
            return q[None]
        if isinstance(q, Mapping):
            return named_configuration(self.robot, q)
        try:
            row = np.asarray(real_numbers(q), dtype=np.float64)
        except (TypeError, ValueError, OverflowError):
            raise PlannercheckError(f"one configuration must be {nq} numbers, not {shown_array(q)}") from None
        if row.ndim not in (1, 2) or (row.ndim == 2 and len(row) != 1):
            raise PlannercheckError(f"one configuration must have shape ({nq},), not {row.shape}")
        return row.reshape(1, nq) if row.shape[-1] == nq else given_configurations(self.robot, row)
