"""Poses that lay a body on a half-space's plane, at gaps.

In: a body, a half-space, poses at which a feature of the body faces the plane. Out: the body's poses, moved along the
plane's normal until its lowest corner is at a gap over the plane, but for rounding: exact arithmetic tells what it is.
"""

from __future__ import annotations

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.evaluation.stress.random_cases import GAPS
from plannercheck.evaluation.stress_parts.bodies import Body
from plannercheck.evaluation.stress_parts.given import Under
from plannercheck.evaluation.stress_parts.half_space_truth import plane_in_world, rounded_heights

# The second time what rounding has left of the first is taken away.
_TIMES = 2
_STEPS = {"+1 ulp": np.inf, "-1 ulp": -np.inf}
# Normals of half-spaces are of any length, in these powers of ten.
_SHORTEST, _LONGEST = -3, 4
# Offsets over a body's size, and how fine those of a lattice are.
_OFFSETS, _LATTICE = (0.0, 1.0, 1.0, 100.0), 8


def random_half_space(size: float, rng: np.random.Generator) -> Body:
    """A half-space of any normal, or of whole numbers on a lattice, where bodies touch it exactly; at times padded."""
    padding = float(rng.choice([0.0, 0.0, 0.1, 1e-7])) * size
    distance = float(rng.choice(_OFFSETS)) * size * rng.normal()
    if rng.integers(2):
        normal = rng.normal(size=3) * 10.0 ** rng.integers(_SHORTEST, _LONGEST)
        return Body("half-space", Under(padding, normal, float(distance * np.linalg.norm(normal))))
    step = 2.0 ** np.round(np.log2(size)) / _LATTICE
    sign = float(rng.choice([-1, 1]))
    normal = sign * (np.eye(3)[rng.integers(3)] if rng.integers(3) else rng.integers(1, 4, size=3).astype(np.float64))
    return Body("half-space", Under(padding, normal, float(np.round(distance / step) * step)))


def lowered(body: Body, poses: Floats, under: Under, poses_under: Floats, size: float) -> Floats:
    """Poses (gaps, 4, 4) of a body near a plane, each moved to its gap of GAPS, in parts of the size (m), over it."""
    poses = poses.copy()
    for pose, pose_under, (name, gap) in zip(poses, poses_under, GAPS.items(), strict=True):
        normal, _ = plane_in_world(under, pose_under)
        for _ in range(_TIMES):
            pose[:3, 3] += (gap * size - rounded_heights(body, pose, under, pose_under)[0].min()) * normal
        axis = int(np.argmax(np.abs(normal)))
        if name in _STEPS:
            pose[axis, 3] = np.nextafter(pose[axis, 3], _STEPS[name] * normal[axis])
    return poses
