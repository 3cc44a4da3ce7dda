"""The kinds of joints, held against Pinocchio, the verifier's own table, and the page on what a new one needs."""

import dataclasses
import re
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from plannercheck.proofs.data import JOINTS
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


def test_the_verifier_knows_the_same_of_each_kind():
    forms = {kind.name: (kind.numbers, kind.lengths, kind.has_axis, kind.unit is not None) for kind in KINDS}
    assert {name: dataclasses.astuple(form) for name, form in JOINTS.items()} == forms


def files_that_tell_kinds_apart():
    """Those that name two kinds or more: one alone may be another word, such as "free"."""
    kinds = "|".join(JOINTS)
    patterns = {"*.py": rf'"({kinds})"', "*.[ch]pp": r"\b(?:JointKind|PartKind)::k(\w+)|^  k(\w+),"}
    for suffix, pattern in patterns.items():
        for file in sorted((ROOT / "plannercheck").rglob(suffix)):
            found = re.findall(pattern, file.read_text(encoding="utf-8"), re.MULTILINE)
            names = {"".join(name) for name in found}
            if len(names) >= 2 and (suffix == "*.py" or names & {"Ball", "Planar", "TurnX"}):
                yield str(file.relative_to(ROOT))


def test_the_page_lists_every_file_that_tells_kinds_apart():
    page = (ROOT / "docs/explanation/add_a_part.md").read_text(encoding="utf-8")
    part = page.partition("\n## A joint\n")[2].partition("\n## ")[0]
    files = re.findall(r"^\| `([^`]+)` \|", part, re.MULTILINE)
    assert [file for file in files if not (ROOT / file).exists()] == []
    assert [file for file in files_that_tell_kinds_apart() if Path(file).name not in part] == []
    assert len([file for file in files if "/evaluation/" not in file]) <= 8
