"""The kinds of joints, held against Pinocchio, the verifier's own table, and the page on what a new one needs."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from plannercheck.proofs.data import JOINT_VALUES
from plannercheck.robots.joints import KINDS, kind_of, number_of

ROOT = Path(__file__).parents[2]
NAMES = [(kind, name) for kind in dict.fromkeys(KINDS) for name in kind.pinocchio]


def made(name):
    joint = getattr(pin, f"JointModel{name}")
    return joint(np.array([0.6, 0.0, 0.8])) if name in ("RevoluteUnaligned", "PrismaticUnaligned") else joint()


@pytest.mark.parametrize(("kind", "name"), NAMES, ids=[name for _, name in NAMES])
def test_joints_take_as_many_numbers_as_in_pinocchio(kind, name):
    model = pin.Model()
    model.addJoint(0, made(name), pin.SE3.Identity(), "joint")
    joint = model.joints[1]
    assert kind_of(joint) is kind is KINDS[number_of(joint)]
    assert joint.nq == kind.numbers
    unit = pin.neutral(model)[slice(*kind.unit)] if kind.unit else [1.0]
    assert np.linalg.norm(unit) == 1


def test_numbers_are_those_of_the_kernel():
    source = (ROOT / "plannercheck/cpp/robots/joints.hpp").read_text(encoding="utf-8")
    listed = re.search(r"enum class JointKind : int \{(.*?)\};", source, re.DOTALL)
    names = re.findall(r"^ *k(\w+),", listed[1], re.MULTILINE)
    words = {"Turn": "turn", "UnitTurn": "circle", "Slide": "slide", "Planar": "planar", "Ball": "ball", "Free": "free"}
    assert [words[re.sub("(?<=Turn)([XYZ]|Axis)$", "", name)] for name in names] == [kind.name for kind in KINDS]
    assert [kind.first for kind in KINDS] == [KINDS.index(kind) for kind in KINDS]


def test_the_verifier_takes_as_many_numbers():
    assert {kind.name: kind.numbers for kind in KINDS} == JOINT_VALUES


def test_a_new_kind_touches_at_most_eight_files():
    page = (ROOT / "docs/explanation/add_a_part.md").read_text(encoding="utf-8")
    part = page.partition("\n## A joint\n")[2].partition("\n## ")[0]
    files = re.findall(r"^\| `([^`]+)` \|", part, re.MULTILINE)
    assert 4 <= len(files) <= 8
    assert [file for file in files if not (ROOT / file).exists()] == []
