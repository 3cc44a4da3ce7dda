"""Spaces whose motions are sampled by OMPL's own interpolation.

In: an OMPL space. Out: `CurvedSpace`, the base of such spaces of robots in space and in the plane; states of a motion.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.ompl.state_numbers import NumberedSpace
from plannercheck.planar.spare_states import SpareStates


class CurvedSpace(NumberedSpace):
    """A space whose motions are sampled by OMPL's interpolation."""

    _space: Any = None
    _spare: SpareStates | None = None

    def _numbered(self, space: Any, width: int) -> Any:
        """The given space, which also interpolates between states from now on."""
        self._space, self._spare = space, SpareStates(space, 1)
        return super()._numbered(space, width)

    def curve_steps(self, s1: Any, s2: Any, sampler: Any, resolution: float | None) -> int:
        """How many steps a motion needs: no point moves over `resolution` m in one."""
        raise NotImplementedError

    def curve_states(self, s1: Any, s2: Any, parameters: Floats) -> Floats:
        """The states (k, nq) of a motion at parameters (k,) in [0, 1], by OMPL's interpolation."""
        if self._spare is None:
            self.ompl_space()
        assert self._spare is not None
        rows = []
        with self._spare.taken() as (between,):
            for t in parameters.tolist():
                self._space.interpolate(s1, s2, t, between)
                rows.append(self.read(between))
        return np.array(rows)


def sampled_curve(space: CurvedSpace, s1: Any, s2: Any, sampler: Any, resolution: float | None) -> Floats:
    """States (k, nq) of a curved motion, both ends included: no point moves over `resolution` m between two."""
    steps = space.curve_steps(s1, s2, sampler, resolution)
    return space.curve_states(s1, s2, np.arange(steps + 1) / steps)
