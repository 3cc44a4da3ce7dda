"""The pages that follow a state and a motion through the code name functions that exist and call each other.

In: a page's table of files and functions, in the order in which the data pass. Each function but the first has to be
called by one before it, by way of functions of that one's own file at most. Calls are looked for in the text.
"""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "docs" / "explanation" / f"life_of_a_{thing}.md" for thing in ("state", "motion")]
MOST_FILES = 8


def steps(page: Path) -> list[tuple[str, str]]:
    """(file, function) of each row of the page's tables."""
    return re.findall(r"^\| `([^`]+)` \| `(\w+)` \|", page.read_text(encoding="utf-8"), re.MULTILINE)


def bodies(source: str, is_python: bool) -> dict[str, str]:
    """The text of each function by its name; overloads are put together."""
    if is_python:
        found = re.findall(r"^( *)def (\w+)\((.*?)(?=^\1[^\s)]|\Z)", source, re.MULTILINE | re.DOTALL)
        named = [(name, text) for _, name, text in found]
    else:  # definitions end on their first line, or where a line is indented as they are, in classes as well
        form = r"^( *)[\w:<>&*,\[\] ]*?(\w+)(\([^;{}]*\)[^;{}]*(?:\{[^\n]*\}$|\{.*?^\1\}))"
        named = [(name, text) for _, name, text in re.findall(form, source, re.MULTILINE | re.DOTALL)]
    joined: dict[str, str] = {}
    for name, text in named:
        joined[name] = joined.get(name, "") + text
    return joined


def reached(function: str, of_file: dict[str, str]) -> set[str]:
    """Names of all that a function calls, itself or through functions of its file."""
    calls: set[str] = set()
    left = [function]
    while left:
        for name in re.findall(r"(\w+)(?:<\w+>)?\(", of_file[left.pop()]):
            if name not in calls and name in of_file:
                left.append(name)
            calls.add(name)
    return calls


def faults(rows: list[tuple[str, str]], texts: dict[str, str]) -> list[str]:
    """Functions that are not there, and those that nothing before them calls."""
    functions = {file: bodies(text, file.endswith(".py")) for file, text in texts.items()}
    missing = [f"{file} has no {name}" for file, name in rows if name not in functions.get(file, {})]
    if missing:
        return missing
    found, called = [], reached(rows[0][1], functions[rows[0][0]])
    for file, name in rows[1:]:
        if not any(call.lstrip("_") == name for call in called):
            found.append(f"nothing before it calls {name} of {file}")
        called |= reached(name, functions[file])
    return found


@pytest.mark.parametrize("page", [page for page in PAGES if page.exists()], ids=lambda page: page.stem)
def test_each_function_exists_and_is_called_by_one_before_it(page):
    rows = steps(page)
    files = dict.fromkeys(file for file, _ in rows)
    assert 4 <= len(files) <= MOST_FILES
    assert faults(rows, {file: (ROOT / file).read_text(encoding="utf-8") for file in files}) == []


def test_missing_functions_and_calls_are_found():
    texts = {
        "a.py": "def ask(q):\n    return self._core_ask(q)\n",
        "b.cpp": "int core_ask(int q) {\n  return own(q);\n}\n",
    }
    rows = [("a.py", "ask"), ("b.cpp", "core_ask")]
    assert faults(rows, texts) == []
    assert faults([*rows, ("b.cpp", "other")], texts) == ["b.cpp has no other"]
    assert faults(rows, texts | {"a.py": "def ask(q):\n    return q\n"}) == [
        "nothing before it calls core_ask of b.cpp"
    ]
    through = (
        "class Own {\n  int own(int q) { return far(q); }\n  int far(int q) {\n    return last(q);\n  }\n};\n\n"
        + texts["b.cpp"]
    )
    assert faults([*rows, ("c.cpp", "last")], texts | {"b.cpp": through, "c.cpp": "int last(int q) {\n}\n"}) == []
