"""Placements of a URDF in exact numbers: what is read, and how far a proof's doubles may be from it."""

import itertools
import math
import re
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from flint import arb, fmpq
from scipy.spatial.transform import Rotation

import plannercheck as pc
from plannercheck.motions.proof_builder import Builder
from plannercheck.proofs import exact_placements as exact
from plannercheck.proofs.faults import UnprovedError
from plannercheck.proofs.mesh_triangles import mesh_triangles
from plannercheck.proofs.urdf_joints import read_tree
from plannercheck.proofs.urdf_shapes import MeshFiles, confirm_shapes
from plannercheck.proofs.urdf_trees import confirm_tree


def placed(attributes):
    with exact.enough_digits():
        return exact.origin_of(ElementTree.fromstring(f"<joint><origin {attributes}/></joint>"))


def holds(ball, text):
    with exact.enough_digits():
        number = Fraction(text)
        off = (ball - arb(fmpq(number.numerator, number.denominator))).abs_upper()
    return float(off) < 1e-35 * max(1, abs(number))


# ----- what is read


def test_decimals_are_read_as_they_are():
    matrix = placed('xyz="0.1 -2.5e-3 1000000000000000.1"').matrix
    assert all(holds(matrix[k, 3], text) for k, text in enumerate(("0.1", "-0.0025", "1000000000000000.1")))
    with exact.enough_digits():
        tenth = exact.balls(exact.decimals("0.1", 1, ""))
        assert math.isclose(exact.furthest([0.1], tenth), Fraction(0.1) - Fraction("0.1"))
        assert exact.furthest([0.5], exact.balls(exact.decimals(".5", 1, ""))) == 0
        assert not exact.furthest([math.nan, 0.1], 2 * tenth) <= 1e300


@pytest.mark.parametrize(
    "text", ["1_0 0 0", "nan 0 0", "1/3 0 0", "1e400 0 0", "1e99999999999 0 0", "٣ 0 0", "1 2", ""]
)
def test_what_is_no_decimal_is_refused(text):
    with pytest.raises(ValueError, match="xyz of <origin> must be 3 numbers"):
        placed(f'xyz="{text}"')


def test_quaternions_are_turned_by_exactly():
    # 2, 3, 6 and 0 have the length 7: the matrix is of sevenths, the numbers of the text are off that length.
    turned = placed('quat_xyzw="0.2 0.3 0.6 0"').matrix
    x, y, z = (Fraction(k, 7) for k in (2, 3, 6))
    for (i, a), (j, b) in itertools.product(enumerate((x, y, z)), repeat=2):
        assert abs(Fraction(float(turned[i, j])) - (2 * a * b - (i == j))) < 2**-52
    with pytest.raises(ValueError, match="must have length 1"):
        placed('quat_xyzw="0.2 0.3 0.1 0"')


@pytest.mark.parametrize("seed", range(4))
def test_roll_pitch_yaw_turn_as_for_scipy(seed):
    rng = np.random.default_rng(seed)
    for rpy in (rng.uniform(-4, 4, 3), [np.pi / 2, 0, -np.pi], [0, np.pi / 2, 1e-9]):
        given = placed(f'''rpy="{" ".join(map(repr, map(float, rpy)))}"''')
        rows = np.column_stack([Rotation.from_euler("xyz", rpy).as_matrix(), np.zeros(3)])
        assert exact.off_placement(rows.ravel().tolist(), given) < 2e-15


def test_chains_are_multiplied_in_balls():
    first, second = placed('xyz="0.1 0 0" rpy="0 0 0.3"'), placed('xyz="0 7 0" rpy="1 0 0"')
    with exact.enough_digits():
        both = first.times(second)
        assert float(max(entry.rad() for entry in both.matrix.entries())) < 1e-35
    assert (both.count, both.allowance) == (2, 2 * exact.ROUNDING * (0.1 + 7))
    assert math.isclose(float(both.matrix[0, 3]), 0.1 - 7 * math.sin(0.3), abs_tol=1e-15)


# ----- proofs


CHAIN = (
    "<robot name='r'><link name='a'><collision><origin xyz='0.1 0.2 0.3' rpy='0.4 0.5 0.6'/><geometry>"
    "<box size='1 1 1'/></geometry></collision></link>"
    + "".join(
        f"<link name='{child}'>{shape}</link><joint name='{child}' type='{kind}'><parent link='{parent}'/>"
        f"<child link='{child}'/><origin xyz='1.1 0.7 {k}.3' rpy='0.{k} 1.{k} -2.{k}'/>{more}</joint>"
        for k, (parent, child, kind, shape, more) in enumerate(
            [
                ("a", "b", "fixed", "", ""),
                ("b", "c", "revolute", "", "<axis xyz='1 2 3'/><limit lower='-1' upper='1' effort='1' velocity='1'/>"),
                ("c", "d", "fixed", "", ""),
                ("d", "e", "fixed", "<collision><geometry><sphere radius='0.1'/></geometry></collision>", ""),
            ]
        )
    )
    + "</robot>"
)


@pytest.fixture
def chain(tmp_path):
    path = tmp_path / "chain.urdf"
    path.write_text(CHAIN)
    return path, Builder(pc.Checker(pc.Robot.load(path)))._model


def moved(rows, by, k=3):
    return (*rows[:k], rows[k] + by, *rows[k + 1 :])


def test_what_was_compared_has_the_proved_distance(chain):
    path, model = chain
    said = [confirm_tree(model, path, None, False, True), *shapes(path, model)]
    for sentence in said[:2]:
        (bound,) = re.findall(r"are at most (\S+) away", sentence)
        assert 0 < float(bound) < 3e-15


def shapes(path, model):
    return confirm_shapes(model, None, MeshFiles(str(path), lambda address: None, True))


@pytest.mark.parametrize("by", [1e-6, 1e-11, 1e-13])
@pytest.mark.parametrize("k", [1, 3, 11])
def test_placements_that_rounding_does_not_explain_are_refused_and_named(chain, by, k):
    path, model = chain
    for part, name, index in (("joints", "joint 'c'", 0), ("links", "link 'e'", 4), ("links", "link 'b'", 1)):
        items = list(getattr(model, part))
        items[index] = replace(items[index], placement=moved(items[index].placement, by, k))
        with pytest.raises(UnprovedError, match=f"{name} is not where the URDF has it: off by"):
            confirm_tree(replace(model, **{part: tuple(items)}), path, None, False, True)
    body = replace(model.bodies[0], pose=moved(model.bodies[0].pose, by, k))
    with pytest.raises(UnprovedError, match=f"body '{body.name}' is not where the URDF has it: off by"):
        shapes(path, replace(model, bodies=(body, *model.bodies[1:])))


@pytest.mark.parametrize(
    ("old", "new"), [("xyz='1.1 0.7 2.3'", "xyz='1.10000000001 0.7 2.3'"), ("-2.3", "-2.30000000001")]
)
def test_a_urdf_that_differs_in_the_eleventh_digit_is_another_one(chain, old, new):
    path, model = chain
    path.write_text(CHAIN.replace(old, new))
    assert path.read_text() != CHAIN
    with pytest.raises(UnprovedError, match=r"link '[de]' is not where the URDF has it: off by"):
        confirm_tree(model, path, None, False, True)


def test_axes_that_rounding_does_not_explain_are_refused(chain):
    path, model = chain
    (joint,) = model.joints
    for by in (1e-11, 1e-14):
        with pytest.raises(UnprovedError, match="joint 'c' has the axis"):
            confirm_tree(
                replace(model, joints=(replace(joint, axis=(joint.axis[0] + by, *joint.axis[1:])),)),
                *(path, None, False, True),
            )


@pytest.mark.filterwarnings("ignore:.*has no <collision>")
def test_multipliers_are_compared_as_fractions(tmp_path):
    joints = "".join(
        f"<link name='l{k}'/><joint name='j{k}' type='prismatic'><parent link='{'a' if k == 0 else f'l{k - 1}'}'/>"
        f"<child link='l{k}'/><axis xyz='0 0 1'/><limit lower='-1' upper='1' effort='1' velocity='1'/>{mimic}</joint>"
        for k, mimic in enumerate(
            [
                "",
                "<mimic joint='j0' multiplier='0.1' offset='0.3'/>",
                "<mimic joint='j1' multiplier='-0.7' offset='0.2'/>",
            ]
        )
    )
    path = tmp_path / "r.urdf"
    path.write_text(f"<robot name='r'><link name='a'/>{joints}</robot>")
    model = Builder(pc.Checker(pc.Robot.load(path).with_group(["j0"])))._model
    last = model.joints[2]
    assert np.allclose([*last.multipliers, *last.offsets], [-0.07, -0.01], rtol=0, atol=1e-15)
    confirm_tree(model, path, None, False, False)
    for change in ({"multipliers": (last.multipliers[0] + 1e-13,)}, {"offsets": (last.offsets[0] + 1e-13,)}):
        with pytest.raises(UnprovedError, match="joint 'j2' takes its value by"):
            confirm_tree(
                replace(model, joints=(*model.joints[:2], replace(last, **change))), *(path, None, False, False)
            )


def test_links_that_hang_on_themselves_are_no_tree(tmp_path):
    joint = "<joint name='{0}{1}' type='fixed'><parent link='{0}'/><child link='{1}'/></joint>"
    path = tmp_path / "r.urdf"
    links = "".join(f"<link name='{name}'/>" for name in "abc")
    path.write_text(f"<robot name='r'>{links}{joint.format('b', 'c')}{joint.format('c', 'b')}</robot>")
    with pytest.raises(pc.PlannercheckError, match="is no tree"):
        read_tree(path)


def test_errors_cut_names_of_any_length(tmp_path):
    """A mutated URDF: the error had 5,087 characters."""
    path = tmp_path / "r.urdf"
    joint = f"<joint name='{5000 * '9'}'/>"
    for content in (f"<link name='a'/><link name='{5000 * '9'}'/>", f"<link name='a'/>{joint}"):
        path.write_text(f"<robot name='r'>{content}</robot>")
        with pytest.raises(pc.PlannercheckError, match=r"9{20}") as caught:
            read_tree(path)
        assert len(str(caught.value)) < 500


# ----- meshes


@pytest.mark.parametrize("seed", range(3))
def test_scaled_corners_are_within_three_units_of_the_exact_product(tmp_path, seed):
    rng = np.random.default_rng(seed)
    texts = [f"{x:.{digits}e}" for digits in (1, 7, 25) for x in rng.normal(size=30) * 10.0 ** rng.integers(-9, 9, 30)]
    scales = ("0.001", "0.0254", "3.7")
    rows = [texts[k : k + 3] for k in range(0, len(texts), 3)]
    path = tmp_path / "x.obj"
    path.write_text(
        "\n".join(["v " + " ".join(row) for row in rows] + [f"f {k + 1} {k + 2} {k + 3}" for k in range(0, 30, 3)])
    )
    found = mesh_triangles(path).reshape(-1, 3)
    for row, given, scaled in zip(rows, found.tolist(), (found * np.array(scales, dtype=float)).tolist(), strict=True):
        for text, scale, one, other in zip(row, scales, given, scaled, strict=True):
            assert abs(Fraction(one) - Fraction(text)) <= Fraction(math.ulp(one)) / 2
            assert abs(Fraction(other) - Fraction(text) * Fraction(scale)) <= 3 * Fraction(math.ulp(other))
