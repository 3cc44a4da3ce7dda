"""A motion as the certifier has it: its ends, and states evenly along it.

In: a checker and the ends q0, q1 (nq,) that a user gives. Out: the ends (1, nq) each, or states (steps + 1, nq).
"""

import numpy as np


def certified_ends(checker, q0, q1):
    return checker._motion_ends(q0[None], q1[None])[:2]


def dense_states(checker, q0, q1, steps):
    return checker.motion_certifier.states(q0, q1, np.linspace(0, 1, steps + 1))
