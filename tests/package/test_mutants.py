"""The lists of small faults that `mutation.py` puts in: every entry fits the checkout. Running them is done by hand."""

import re
import subprocess
import sys

import pytest
from found_faults import FAULTS
from mutants import CHECKOUT, LISTS, BadMutantError, Mutant, fault_of, faults_of, read_mutants
from tests_of import killing_tests

LEAST = 620

ENTRY = """
- name: one
  file: plannercheck/common/errors.py
  old: "class PlannercheckError("
  new: "class PlannercheckErrors("
  tests: [tests/package/test_mutants.py::test_every_mutant_fits_the_checkout]
"""


def written(folder, text) -> list[Mutant]:
    (folder / "area.yaml").write_text(text)
    return read_mutants(folder)


def test_every_mutant_fits_the_checkout():
    mutants = read_mutants()
    assert faults_of(mutants) == {}
    assert len(mutants) >= LEAST
    assert {path.stem for path in LISTS.glob("*.yaml")} == {mutant.area for mutant in mutants}


def test_the_tests_of_mutants_are_there_with_their_parameters(request):
    tests = sorted({test for mutant in read_mutants() for test in mutant.tests})
    # Where all tests run, all have been collected already, which takes long.
    items = {item.nodeid for item in request.session.items}
    files = {item.partition("::")[0] for item in items}
    folders = {file.rpartition("/")[0] for file in files}
    if set(tests) <= items | {item.partition("[")[0] for item in items} | files | folders:
        return
    command = [sys.executable, "-m", "pytest", "-q", "--collect-only", "-p", "no:cacheprovider", *tests]
    ran = subprocess.run(command, cwd=CHECKOUT, capture_output=True, text=True, check=False)
    assert [line for line in ran.stderr.splitlines() if "not found" in line] == []
    assert ran.returncode == 0, ran.stdout[-2000:]


def test_the_faults_that_the_stress_has_to_find_are_mutants():
    named = {name for fault in FAULTS.values() for name in fault.mutants}
    assert named <= {mutant.name for mutant in read_mutants()}


def test_the_tests_of_a_source_are_those_that_kill_its_mutants():
    (tests,) = killing_tests("cpp/motions/motion_bounds.cpp").values()
    assert tests["tests/motions/test_motion_contacts.py::test_curvature_is_no_less_than_what_it_is"] > 0
    assert killing_tests("no such source") == {}


def test_an_entry_that_fits(tmp_path):
    (mutant,) = written(tmp_path, ENTRY)
    assert fault_of(mutant) == ""
    assert not mutant.is_compiled
    assert mutant.applied("class PlannercheckError(ValueError)") == "class PlannercheckErrors(ValueError)"
    assert "repeats" in faults_of([mutant, mutant])["one"]


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("tests: [", "test: [", "unknown fields"),
        ("  new: ", "  # new: ", "new has to be a text"),
        ("tests: [", "equivalent: [", "either tests, or why"),
        ("tests: [", "equivalent: so\n  tests: [", "either tests, or why"),
        ("- name: one", "- nam: one", "without a name"),
    ],
)
def test_lists_that_cannot_be_read(tmp_path, old, new, says):
    with pytest.raises(BadMutantError, match=says):
        written(tmp_path, ENTRY.replace(old, new))


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("common/errors.py", "no_errors.py", "no source"),
        ("class PlannercheckError(", "class PlannercheckNoError(", "stands 0 times"),
        ('old: "class PlannercheckError("', 'old: "e"', "stands [0-9]+ times"),
        ("PlannercheckErrors(", "PlannercheckError(", "the same"),
        ("::test_every", "::test_evry", "no such test"),
    ],
)
def test_mutants_that_do_not_fit(tmp_path, old, new, says):
    (mutant,) = written(tmp_path, ENTRY.replace(old, new))
    assert re.search(says, fault_of(mutant))
