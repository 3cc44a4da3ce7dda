"""Terrains: rough ground as a height field, by a sum of waves whose strength falls with their number.

In: sizes and a seed. Out: heights in m. The same seed gives the same ground.
"""

from __future__ import annotations

import numpy as np

from plannercheck.common.array_types import Floats

# The strength of a wave falls with this power of its number: between a coast's and a dune's.
_FALL = 2.2


def terrain(count: int, seed: int, height: float = 3.0) -> Floats:
    """Heights (count, count) of rough ground, m, from 0 to `height`; the seed is that of its waves."""
    rng = np.random.default_rng(seed)
    across = np.fft.fftfreq(count)[:, None] * count
    along = np.fft.rfftfreq(count)[None] * count
    number = np.hypot(across, along)
    number[0, 0] = np.inf
    waves = number**-_FALL * np.exp(2j * np.pi * rng.random(number.shape))
    heights = np.fft.irfft2(waves, s=(count, count))
    heights -= heights.min()
    return np.asarray(heights * (height / heights.max()))
