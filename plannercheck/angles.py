"""Angles that count modulo a whole turn."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def wrapped(angles: Floats) -> Floats:
    """Angles brought to [-pi, pi); those that are there already keep their bits."""
    inside = (angles >= -np.pi) & (angles < np.pi)
    return np.where(inside, angles, (angles + np.pi) % (2 * np.pi) - np.pi)


def whole_turns(differences: Floats) -> Floats:
    """What has to be taken off differences to bring them within half a turn, rad; 0 for a half turn, as OMPL has it."""
    return np.asarray(2 * np.pi * np.rint(differences / (2 * np.pi)))


def short_way(differences: Floats) -> Floats:
    """Differences brought to within half a turn."""
    return np.asarray(differences - whole_turns(differences))
