"""Proofs whose tables, intervals and numbers are not what a proof has to have."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from proof_cases import CUBE, STILL, at, claim, plane, point, sealed, turn

from plannercheck.proofs import Link


def swinging():
    """A proof with two pairs, each proved by several entries."""
    bodies = [point("wall", -1, at(y=1.1)), point("tip", 0, at(y=1.0)), point("floor", -1, at(y=-1.1))]
    times = (0.0, 0.25, 0.625, 1.0)
    entries = [plane(start=a, end=b) for a, b in pairwise(times)]
    entries += [plane((0, 1, 0), start=a, end=b, pair=1) for a, b in pairwise(times)]
    return claim([turn()], bodies, (-0.3,), (0.3,), entries, pairs=((0, 1), (1, 2)))


def test_intervals_have_to_tile():
    proof = swinging()
    assert proof.verify()
    for k, entry in enumerate(proof.entries):
        for name in ("start", "end"):
            for value in (np.nextafter(getattr(entry, name), x) for x in (-1, 2)):
                entries = list(proof.entries)
                entries[k] = replace(entry, **{name: float(value)})
                assert not replace(proof, entries=tuple(entries)).verify(), (k, name, value)
        assert not replace(proof, entries=proof.entries[:k] + proof.entries[k + 1 :]).verify()
        assert not replace(proof, entries=(*proof.entries[: k + 1], entry, *proof.entries[k + 1 :])).verify()
    assert not replace(proof, entries=proof.entries[:3]).verify()
    assert not replace(proof, entries=()).verify()
    assert replace(proof, entries=proof.entries[3:] + proof.entries[:3]).verify()


def test_intervals_go_forward():
    bodies = [point("wall", -1, at(y=1.1)), point("tip", 0, at(y=1.0))]
    times = (0.0, 0.6, 0.4, 1.0)
    back = claim([turn()], bodies, (-0.3,), (0.3,), [plane(start=a, end=b) for a, b in pairwise(times)])
    assert not back.verify()


def test_pairs_of_the_table_can_not_be_left_out_or_doubled():
    proof = swinging()
    for pairs in (((0, 1),), ((0, 1), (1, 1)), ((0, 1), (1, 3)), ((0, 1), (-1, 2)), ((0, 1), (0, 2))):
        assert not replace(proof, model=replace(proof.model, pairs=pairs)).verify()
    for pairs in (((0, 1), (1, 1)), ((0, 1), (1, 3)), ((0, 1), (-1, 2)), ((0, 1), (1, 2), (0, 2))):
        assert not sealed(proof, model=replace(proof.model, pairs=pairs)).verify(), pairs


MALFORMED = [
    ("joints", "parent", 0),
    ("joints", "parent", -2),
    ("joints", "kind", "twist"),
    ("joints", "columns", (1,)),
    ("joints", "columns", (-2,)),
    ("joints", "columns", (0, 0)),
    ("joints", "axis", (0.0, 0.0, 1.1)),
    ("joints", "axis", (0.0, 0.0)),
    ("joints", "axis", (0.0, 0.0, float("nan"))),
    ("joints", "multipliers", (float("inf"),)),
    ("joints", "offsets", ()),
    ("joints", "placement", (1.1, *STILL[1:])),
    ("joints", "placement", (-1.0, *STILL[1:])),
    ("joints", "placement", STILL[:11]),
    ("links", "joint", 1),
    ("links", "joint", -2),
    ("links", "placement", (float("nan"), *STILL[1:])),
    ("bodies", "link", 1),
    ("bodies", "link", -2),
    ("bodies", "radius", -1e-3),
    ("bodies", "padding", 1e-3),
    ("bodies", "padding", -1e-3),
    ("bodies", "reach", -1.0),
    ("bodies", "centre", (0.0,)),
    ("bodies", "pose", (1.0, 0.0)),
    ("bodies", "vertices", np.zeros((0, 3))),
    ("bodies", "vertices", np.zeros((3, 2))),
    ("bodies", "vertices", np.zeros(3)),
    ("bodies", "vertices", np.array([[0.0, np.nan, 0.0]])),
    ("bodies", "vertices", np.array([[-(2**63), 0, 0], [0, 0, 0]])),  # whose absolute value is negative
    ("bodies", "vertices", np.array([[0.0, 0.0, 5j]])),
    ("bodies", "vertices", np.zeros((1, 3), dtype=np.float32)),
    ("bodies", "vertices", np.ma.array([[0.0, 0.0, 0.0], [0.0, 9.0, 0.0]], mask=[[0, 0, 0], [1, 1, 1]])),
]


@pytest.mark.parametrize(("part", "name", "value"), MALFORMED)
def test_malformed_models_are_refused_whatever_their_hashes(part, name, value):
    proof = swinging()
    items = list(getattr(proof.model, part))
    items[0] = replace(items[0], **{name: value})
    found = sealed(proof, model=replace(proof.model, **{part: tuple(items)})).verify()
    assert not found
    assert "content hash" not in found.fault


SLIGHTLY_OFF = [
    ("joints", "placement", (1 + 1e-5, *STILL[1:]), "not rigid"),
    ("links", "placement", (*STILL[:5], 1 - 1e-5, *STILL[6:]), "not rigid"),
    ("bodies", "pose", (*STILL[:1], 1e-5, *STILL[2:]), "not rigid"),
    ("joints", "axis", (0.0, 0.0, 1 + 1e-5), "axis of length"),
    ("joints", "axis", (0.0, 0.0, 1 - 1e-5), "axis of length"),
]


@pytest.mark.parametrize(("part", "name", "value", "fault"), SLIGHTLY_OFF)
def test_placements_and_axes_that_are_slightly_off_are_refused(part, name, value, fault):
    proof = swinging()
    items = list(getattr(proof.model, part))
    items[0] = replace(items[0], **{name: value})
    found = sealed(proof, model=replace(proof.model, **{part: tuple(items)})).verify()
    assert not found
    assert fault in found.fault


def test_malformed_motions_are_refused():
    proof = swinging()
    for values in ((float("nan"),), (float("inf"),), (), (0.1, 0.2), (1e16,)):
        for name in ("start", "end", "asked_end"):
            found = replace(proof, motion=replace(proof.motion, **{name: values})).verify()
            assert not found
            assert ("not finite" if len(values) == 1 else "numbers, not 1") in found.fault
    for margin in (-1e-9, float("nan"), float("inf")):
        assert not replace(proof, margin=margin).verify()
    for direction in ((float("nan"), 1.0, 0.0), (0.0, float("inf"), 0.0), (0.0, 1.0), (1e300, 1e300, 0.0)):
        entries = (replace(proof.entries[0], direction=direction), *proof.entries[1:])
        assert not replace(proof, entries=entries).verify()
    for change in ({"frame": 1}, {"frame": -2}, {"pair": 2}, {"pair": -1}, {"by": "magic"}):
        assert not replace(proof, entries=(replace(proof.entries[0], **change), *proof.entries[1:])).verify()
    assert not replace(proof, motion=replace(proof.motion, asked_end=(0.3 + 2 * np.pi,))).verify()


def test_numbers_that_are_not_known_prove_nothing():
    # Products beyond the range of doubles: neither infinity nor what is no number may pass as "apart".
    huge = at(x=1e15, y=1e15)
    joints = [turn(k - 1, huge, column=0) for k in range(8)]
    bodies = [point("wall", -1, at(y=1.0)), point("tip", 7, huge, CUBE * 1e15)]
    found = claim(joints, bodies, (0.0,), (1e15,), [plane((1e15, 1e15, 0))]).verify()
    assert not found


def test_whole_turns_need_joints_that_a_whole_turn_does_not_change():
    bodies = [point("wall", -1, at(y=1.1)), point("tip", 0, at(y=1.0))]
    asked = (0.3 + 2 * np.pi,)
    assert claim([turn()], bodies, (-0.3,), (0.3,), [plane()], asked=asked, whole=(0,)).verify()
    assert not claim([turn(multiplier=0.5)], bodies, (-0.3,), (0.3,), [plane()], asked=asked, whole=(0,)).verify()
    slide = turn(kind="slide", axis=(1.0, 0.0, 0.0))
    assert not claim([slide], bodies, (-0.3,), (0.3,), [plane()], asked=asked, whole=(0,)).verify()
    assert not claim([turn()], bodies, (-3.2,), (3.2,), [plane()], asked=(3.2,), whole=(0,)).verify()


def test_chains_that_are_far_off_rigid_are_refused():
    # Each placement is within the contract; a thousand and more in a row are not what the bounds are for.
    off = tuple(x * (1 + 2e-7) if k % 4 < 3 else x for k, x in enumerate(STILL))
    joints = [replace(turn(k - 1, column=0), placement=off) for k in range(2000)]
    bodies = [point("wall", -1, at(y=9.0)), point("tip", 0, at(y=1.0))]
    found = claim(joints, bodies, (0.0,), (1e-6,), [plane()]).verify()
    assert not found
    assert "off rigid" in found.fault


def test_chains_of_any_length_are_followed():
    joints = [turn(k - 1, column=0, multiplier=1e-3) for k in range(2000)]
    bodies = [point("wall", -1, at(y=1.0001)), point("tip", 0, at(y=1.0))]
    proof = claim(joints, bodies, (0.0,), (0.1,), [plane()], links=(Link("last", 1999, STILL),))
    found = proof.verify()
    assert found, found.fault
