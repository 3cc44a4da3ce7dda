"""The record of tuning: its table is the core's, and bad values are refused."""

import inspect

import pytest

import plannercheck as pc
from plannercheck.bodies.tuning import core_tuning, tuning_table
from plannercheck.common.core import core

SWITCHES = [row.name for row in tuning_table() if row.type == "bool"]
OF_PYTHON = {"reach", "static_poses", "middle_states", "apart_cells"}
OF_CORE = "halves"  # a verdict within the tolerance may depend on it


def test_the_core_has_a_member_for_each_field_but_those_of_python():
    members = {name for name in dir(core.Tuning) if not name.startswith("_")}
    assert members - {OF_CORE} == {row.name for row in tuning_table()} - OF_PYTHON


@pytest.mark.parametrize("name", sorted(set(SWITCHES) - OF_PYTHON))
def test_a_switch_reaches_the_member_of_its_name_alone(name):
    members = [switch for switch in SWITCHES if switch not in OF_PYTHON]
    assert [switch for switch in members if not getattr(core_tuning(pc.Tuning().without(name)), switch)] == [name]


def test_the_defaults_are_the_cores():
    for row in tuning_table():
        if row.name not in {"method", *OF_PYTHON}:
            assert getattr(core.Tuning(), row.name) is row.default
    assert core.Tuning().method == core.Solver.oracle == core_tuning().method


@pytest.mark.parametrize("method", ["walk", "exact"])
def test_a_method_reaches_the_core(method):
    assert core_tuning(pc.Tuning(method=method)).method == getattr(core.Solver, method)


def test_the_docstring_has_a_line_for_each_field():
    assert all(
        f"        {row.name}: {row.purpose}" in inspect.getdoc(pc.Tuning).replace("\n", "\n    ")
        for row in tuning_table()
    )


def test_a_checker_has_at_most_eight_parameters():
    assert len(inspect.signature(pc.Checker).parameters) <= 8


@pytest.mark.parametrize(
    ("given", "said"), [({"method": "gjk"}, "unknown method 'gjk'"), ({"bounds": 1}, "bounds must be")]
)
def test_bad_values_are_refused(given, said):
    with pytest.raises(pc.PlannercheckError, match=said):
        pc.Tuning(**given)


def test_a_misspelt_switch_is_named_with_the_one_that_is_meant():
    with pytest.raises(pc.PlannercheckError, match=r"unknown switch 'bonds'.*bounds"):
        pc.Tuning().without("bonds")
