"""Whether two posed bodies share a point, by proofs in compiled whole numbers: a faster `exact_reference.intersects`.

The oracle shares nothing with the core; tests/evaluation/test_oracle.py holds it against Python's integers, which
decide here where it finds no proof.
"""

import numpy as np

from plannercheck import _oracle
from plannercheck.bodies import exact_reference

UNPROVED = 2  # an answer of `_oracle.decide`


def intersects(vertices_p, vertices_r, pose_p=None, pose_r=None, inflation_p=0.0, inflation_r=0.0):
    """Whether they share a point; arguments as for `exact_reference.decide`."""
    asked = []
    for vertices, radius, pose in ((vertices_p, inflation_p, pose_p), (vertices_r, inflation_r, pose_r)):
        asked.append(_oracle.Points(np.array(vertices, dtype=np.float64).reshape(-1, 3), float(radius)))
        asked.append(np.array(np.eye(4) if pose is None else pose, dtype=np.float64)[None])
    (found,) = _oracle.decide(*asked, True).tolist()
    if found == UNPROVED:
        return exact_reference.intersects(vertices_p, vertices_r, pose_p, pose_r, inflation_p, inflation_r)
    return bool(found)
