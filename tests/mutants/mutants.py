"""Small faults kept as data, for `mutation.py`: read from tests/mutants/*.yaml and held against the checkout.

In: lists of entries. Out: `Mutant`s, and in words what is wrong with them. An entry has

    name: unique, says the fault
    file: the source, from the checkout's root
    old: text that stands exactly once in it
    new: what replaces it
    tests: [tests that must fail then, shortest first]
    equivalent: why no test can notice  # instead of tests, only where that is proved
"""

import ast
import hashlib
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import yaml

CHECKOUT = Path(__file__).resolve().parents[2]
LISTS = CHECKOUT / "tests" / "mutants"
SUFFIXES = {".py", ".cpp", ".hpp"}
SOURCE_TESTS = {"tests/error_bounds/test_gappa_proofs.py", "tests/error_bounds/test_rounding_budgets.py"}
_FIELDS = {"name", "file", "old", "new", "tests", "equivalent"}


class BadMutantError(ValueError):
    """A list that can't be read."""


@dataclass(frozen=True)
class Mutant:
    """One fault.

    Attributes:
        area: The list it stands in.
        name: Of the fault, unique.
        file: The source, from the checkout's root.
        old: What stands there.
        new: The fault.
        tests: Tests that must fail, in the words of pytest; none for an equivalent.
        equivalent: Why no test can notice; empty otherwise.
    """

    area: str
    name: str
    file: str
    old: str
    new: str
    tests: tuple[str, ...]
    equivalent: str

    @property
    def is_compiled(self) -> bool:
        """Whether the core has to be built again: not for tests that read the sources alone."""
        return not self.file.endswith(".py") and not self._files_of_tests() <= SOURCE_TESTS

    def applied(self, text: str) -> str:
        """A source's text with the fault."""
        return text.replace(self.old, self.new)

    def _files_of_tests(self) -> set[str]:
        return {test.split("::")[0] for test in self.tests}

    def key(self) -> str:
        """A hash of all that its result is kept for: the fault, the source around it, its tests' files."""
        sources = [self.file, *sorted(self._files_of_tests())]
        parts = [self.name, self.old, self.new, *self.tests, *(source_text(source) for source in sources)]
        return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:16]


@cache
def source_text(file: str) -> str:
    """The text of a file of the checkout; empty if there is none."""
    path = CHECKOUT / file
    return path.read_text(encoding="utf-8") if path.is_file() else ""


@cache
def read_mutants(folder: Path = LISTS) -> list[Mutant]:
    """All entries of all lists, in the order of files and lines."""
    return [
        _mutant(path.stem, entry)
        for path in sorted(folder.glob("*.yaml"))
        for entry in yaml.safe_load(path.read_text(encoding="utf-8")) or []
    ]


def _mutant(area: str, entry: Any) -> Mutant:
    if not isinstance(entry, dict) or not isinstance(entry.get("name"), str):
        raise BadMutantError(f"{area}.yaml: an entry without a name: {str(entry)[:80]}")
    where = f"{area}.yaml, {entry['name']}"
    if unknown := set(entry) - _FIELDS:
        raise BadMutantError(f"{where}: unknown fields {sorted(unknown)}; known are {sorted(_FIELDS)}")
    for field in ("file", "old", "new"):
        if not isinstance(entry.get(field), str):
            raise BadMutantError(f"{where}: {field} has to be a text")
    tests, equivalent = entry.get("tests", []), entry.get("equivalent", "")
    if not isinstance(tests, list) or not all(isinstance(test, str) for test in tests):
        raise BadMutantError(f"{where}: tests has to be a list of texts")
    if not isinstance(equivalent, str) or bool(tests) == bool(equivalent.strip()):
        raise BadMutantError(f"{where}: either tests, or why it is equivalent")
    return Mutant(area, entry["name"], entry["file"], entry["old"], entry["new"], tuple(tests), equivalent)


def faults_of(mutants: Iterable[Mutant]) -> dict[str, str]:
    """What is wrong, in a sentence, by the names of mutants that don't fit the checkout."""
    found: dict[str, str] = {}
    names: set[str] = set()
    for mutant in mutants:
        fault = f"{mutant.area}.yaml repeats this name" if mutant.name in names else fault_of(mutant)
        names.add(mutant.name)
        if fault:
            found[mutant.name] = fault
    return found


def fault_of(mutant: Mutant) -> str:
    """What is wrong with a mutant; empty if nothing is."""
    text = source_text(mutant.file)
    if not text or Path(mutant.file).suffix not in SUFFIXES or mutant.file.startswith("tests/"):
        return f"{mutant.file} is no source of the package"
    if (count := text.count(mutant.old)) != 1:
        return f"its old text stands {count} times in {mutant.file}, has to once"
    if mutant.old == mutant.new:
        return "old and new are the same"
    missing = [test for test in mutant.tests if not _is_a_test(test)]
    return f"no such test: {', '.join(missing)}" if missing else ""


def _is_a_test(test: str) -> bool:
    file, _, name = test.partition("::")
    return not name or name.split("[")[0] in _functions(file)


@cache
def _functions(file: str) -> frozenset[str]:
    """Names of the tests in a file, found without running it; those in a class as `Class::name`."""
    tree = ast.parse(source_text(file))
    names = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
    for kind in (node for node in tree.body if isinstance(node, ast.ClassDef)):
        names |= {f"{kind.name}::{node.name}" for node in kind.body if isinstance(node, ast.FunctionDef)}
    return frozenset(name for name in names if name.split("::")[-1].startswith("test"))
