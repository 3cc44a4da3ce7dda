"""Each error constant of the core is proved by gappa, as large as it stands in the source, or has its lemma by hand.

The scripts are in tests/error_bounds; its README says which lemmas stand by hand and lists all constants.
"""

import os
import re
import shutil
from fractions import Fraction

import pytest
from bounds_search import SEARCHED, search
from gappa_proofs import PROOFS, constants, filled, is_proved, scripts, value

# Where an error constant may not be without a script or a lemma. Constants of the same files that are none of errors
# are in the table, too: they are limits of ranges and counts.
CHECKED = [
    "pair_frame",
    "given_poses",
    "minkowski_difference",
    "expanding_polytope",
    "penetration_depth",
    "gjk",
    "points_near_bodies",
    "points_near_hull",
    "support_scan",
    "gjk_double_double",
    "polygon_signs",
    "support_exact_direction",
    "predicates",
    "double_double",
    "support",
    "polytope",
    "vec",
    "centre_axis",
    "distance",
    "bounding_sphere",
    "box_filter",
    "float_sincos",
    "float_pose_error",
    "float_link_poser",
    "overlap_filter",
    "plane_filter",
    "half_space",
    "half_space_pair",
    "candidate_tables",
    "direction_cells",
    "inner_shapes",
    "inner_shape_search",
    "motion_check",
    "motion_pairs",
    "motion_rounding",
    "motion_filters",
    "motion_bounds",
    "motion_screen",
    "swept_distance",
    "motion_certifier_2d",
    "oriented_box",
    "tree_frames",
    "posed_solid",
    "solid_pair",
    "solid_side",
    "triangle_tree",
    "inner_overlap",
    "solid_distance",
    "part_boxes",
    "part_set",
    "part_walk",
    "part_pair",
    "part_separation",
    "kinematic_error",
]

# A constant that is so much smaller is below what its script needs; most are at half.
SMALLEST_PART = Fraction(1, 16)


@pytest.fixture(scope="module")
def gappa():
    if shutil.which("gappa") is None:
        assert os.environ.get("PLANNERCHECK_REQUIRE_GAPPA") != "1", "gappa is required here: apt-get install gappa"
        pytest.skip("needs gappa: apt-get install gappa")


def table():
    """Rows of the README: what stands behind each constant, by "file/kName"."""
    rows = re.findall(r"^\| `(\w+/\w+)` \| ([^|]+) \| ([^|]+) \|", (PROOFS / "README.md").read_text(), re.MULTILINE)
    assert len(rows) == len({name for name, _, _ in rows}), "a constant stands twice in the table"
    return {name: (stated.strip(), proof.strip()) for name, stated, proof in rows}


@pytest.mark.parametrize("script", ["chains", *scripts()])
def test_gappa_proves_the_constant_of_the_source(gappa, script):
    proved, said = is_proved(filled(script))
    assert proved, said


@pytest.mark.parametrize("script", scripts())
def test_gappa_refuses_a_constant_that_is_too_small(gappa, script):
    part = Fraction(1, 2)
    while part >= SMALLEST_PART and is_proved(filled(script, part))[0]:
        part /= 2
    assert part >= SMALLEST_PART, "the script proves anything, or the constant has far too much room"


@pytest.mark.parametrize("script", scripts())
def test_scripts_use_the_constant_that_they_are_named_after(script):
    stem, name = script.split("/")
    assert f"@{name}@" in (PROOFS / f"{script}.g").read_text()
    assert name in constants(stem)


def test_every_constant_has_a_script_or_a_lemma():
    declared = {f"{stem}/{name}" for stem in CHECKED for name in constants(stem)}
    assert set(table()) == declared
    scripted = {name for name, (_, proof) in table().items() if proof == "gappa"}
    assert scripted == set(scripts())


def test_the_table_has_the_values_of_the_sources():
    # So that a constant whose lemma stands by hand does not change without one looking at the lemma.
    for name, (stated, _) in table().items():
        assert stated == constants(name.split("/")[0])[name.split("/")[1]].replace("\n", " "), name


@pytest.mark.parametrize("name", SEARCHED)
def test_no_error_found_by_a_search_exceeds_its_bound(name):
    error, count = SEARCHED[name]
    assert 0 < search(error, count, 400, seed=2) < 1


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("predicates/kRoundoff", Fraction(1, 2**53)),
        ("support_exact_direction/kTopDoubt", Fraction(12, 2**53)),
        ("predicates/kDoubleDoubleBound", Fraction(1, 2**97)),
        ("support_scan/kFloatTie", Fraction(32, 2**24)),
        ("gjk/kInflationAlong", 1 + Fraction(4, 2**53)),
    ],
)
def test_values_are_those_of_the_sources(name, expected):
    assert value(*name.split("/")) == expected
