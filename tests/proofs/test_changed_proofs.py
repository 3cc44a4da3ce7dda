"""Proofs with one number changed at random, beyond its slack: all are refused.

PLANNERCHECK_PROOFS=1000 changes as many; 1,000 take some 5 minutes.
"""

import os
import warnings
from dataclasses import replace

import numpy as np
import proof_oracle
import pytest
from proof_cases import free_motions, random_tree, scattered

import plannercheck as pc
from plannercheck.proofs.well_formed import hashes_of

# Proofs of which one number is changed; 1,000 take some 10 minutes.
CHANGES = int(os.environ.get("PLANNERCHECK_PROOFS", "60"))


def pool():
    """Proofs of small robots: trees with all kinds of joints, a Panda among a few obstacles."""
    import tempfile
    from pathlib import Path

    out = []
    for seed in range(8):
        generator = np.random.default_rng(300 + seed)
        with tempfile.TemporaryDirectory() as folder:
            robot = pc.Robot.from_urdf(random_tree(generator, Path(folder), links=5), floating=seed % 4 == 1)
        if seed % 2:
            leaders = [name for name in robot.joint_names if name not in robot.mimics]
            robot = robot.with_group(leaders)
        checker = pc.Checker(robot, scattered(generator, 2, 0.8))
        out += [proof for proof in checker.certify_motions(*free_motions(checker, 2, seed)) if proof is not None]
    return out


@pytest.fixture(scope="module")
def proofs():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = pool()
    assert len(found) >= 8
    assert all(proof.verify() for proof in found)
    return found


def changed_model(proof, generator, amount):
    """A proof with one number of its model changed by an amount, None if there is nothing to change."""
    part = generator.choice(["joints", "links", "bodies"])
    items = list(getattr(proof.model, part))
    k = int(generator.integers(len(items)))
    names = {
        "joints": ["placement", "axis", "multipliers", "offsets"],
        "links": ["placement"],
        "bodies": ["pose", "vertices", "radius", "centre", "reach"],
    }
    name = str(generator.choice(names[part]))
    value = getattr(items[k], name)
    if isinstance(value, float):
        new = value + amount
    elif isinstance(value, np.ndarray):
        new = value.copy()
        new[tuple(generator.integers(0, new.shape))] += amount
    else:
        j = int(generator.integers(len(value)))
        new = tuple(x + amount if i == j else x for i, x in enumerate(value))
    items[k] = replace(items[k], **{name: new})
    return replace(proof, model=replace(proof.model, **{part: tuple(items)}))


def changed_rest(proof, generator, amount):
    """A proof with one number of the motion or of an entry changed."""
    place = generator.choice(["start", "end", "margin", "direction", "direction", "frame"])
    if place == "margin":
        return replace(proof, margin=proof.margin + abs(amount))
    if place in ("start", "end"):
        j = int(generator.integers(proof.model.columns))
        q = tuple(x + amount if i == j else x for i, x in enumerate(getattr(proof.motion, place)))
        motion = replace(proof.motion, **{place: q})
        return replace(proof, motion=replace(motion, asked_end=motion.end))
    entries = list(proof.entries)
    planes = [k for k, entry in enumerate(entries) if entry.by == "plane"]
    if not planes:
        return proof
    k = int(generator.choice(planes))
    if place == "frame":
        entries[k] = replace(entries[k], frame=int(generator.integers(-1, len(proof.model.links))))
    else:
        j = int(generator.integers(3))
        direction = tuple(x + amount if i == j else x for i, x in enumerate(entries[k].direction))
        entries[k] = replace(entries[k], direction=direction)
    return replace(proof, entries=tuple(entries))


def changed_entries(proof, wrong):
    """Indices of the entries whose claims differ: all, if not just an entry is another."""
    if proof.hashes != wrong.hashes or proof.motion != wrong.motion or proof.margin != wrong.margin:
        return range(len(proof.entries))
    return [k for k, (a, b) in enumerate(zip(proof.entries, wrong.entries, strict=True)) if a != b]


def test_proofs_with_one_number_changed_beyond_its_slack_are_refused(proofs):
    """A change is beyond the slack where a sampled state contradicts the claim.

    Numbers with slack are directions, ends, placements, shapes: a gap is mostly larger than the margin, so a small
    change leaves a true claim, of another motion or body, which may pass. What the hashes hold has none: see below.
    """
    generator = np.random.default_rng(5)
    refused = 0
    for _ in range(50 * CHANGES):
        if refused >= CHANGES:
            break
        proof = proofs[int(generator.integers(len(proofs)))]
        change = (changed_model, changed_rest)[int(generator.integers(2))]
        seed = int(generator.integers(2**31))
        sign = float(generator.choice([-1, 1]))
        amount = sign * 10.0 ** generator.uniform(-4, 1)
        wrong = change(proof, np.random.default_rng(seed), amount)
        wrong = replace(wrong, hashes=hashes_of(wrong.model))
        if proof_oracle.is_false(wrong, only=changed_entries(proof, wrong)):
            found = wrong.verify()
            assert not found, (change.__name__, seed, amount)
            assert found.fault
            refused += 1
    assert refused >= CHANGES


def test_any_bit_of_the_model_is_held_by_its_hashes(proofs):
    generator = np.random.default_rng(6)
    for _ in range(CHANGES):
        proof = proofs[int(generator.integers(len(proofs)))]
        wrong = changed_model(proof, generator, 1e-16 * float(generator.choice([-1, 1])))
        if hashes_of(wrong.model) != proof.hashes:
            found = wrong.verify()
            assert not found
    model = replace(proof.model, bodies=(replace(proof.model.bodies[0], name="other"), *proof.model.bodies[1:]))
    assert "content hash" in replace(proof, model=model).verify().fault
