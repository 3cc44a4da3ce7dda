"""Error constants of the sources, and the gappa scripts in tests/error_bounds that prove them.

In: sources of the core, or modules of the package where it has none of that name; scripts. Out: constants' values, as
the sources have them; scripts with these values in place of `@kName@` or `@_NAME@`, or of `@file/kName@` of another
source; whether gappa accepts a script.

`python tests/error_bounds/gappa_proofs.py` prints the least value of each constant that its script still proves.
"""

import ast
import importlib
import re
import subprocess
import sys
from fractions import Fraction
from functools import cache
from pathlib import Path
from types import ModuleType

ROOT = Path(__file__).resolve().parents[2]
SOURCES, PROOFS = ROOT / "plannercheck" / "cpp", ROOT / "tests" / "error_bounds"
_DECLARED = re.compile(r"constexpr (?:static )?(?:double|float) (k\w+ = [^;]*);", re.DOTALL)
_NUMBER = re.compile(r"(?<![\w.])(?:0x[0-9a-fA-F.]+p[+-]?\d+|\d[\d.]*(?:[eE][+-]?\d+)?)F?")
_PLACE = re.compile(r"@(?:(\w+)/)?(k\w+|_[A-Z_]+)@")


@cache
def constants(stem: str) -> dict[str, str]:
    """The constants that a source and its header declare at any scope: expressions by name."""
    found: dict[str, str] = {}
    if is_python(stem):
        return _python_constants(stem)
    for path in sorted(SOURCES.glob(f"*/{stem}.?pp")):
        text = re.sub(r"//[^\n]*", "", path.read_text())
        for declared in _DECLARED.findall(text):
            for part in re.split(r",\s*(?=k\w+ =)", declared):
                name, expression = part.split(" = ", 1)
                assert name not in found, f"{stem} declares {name} twice"
                found[name] = expression.strip()
    return found


def is_python(stem: str) -> bool:
    """Whether the constants are those of a module, since no C++ source has that name."""
    return not any(SOURCES.glob(f"*/{stem}.?pp"))


def _module(stem: str) -> ModuleType:
    """The module of that name, in whatever folder."""
    path = next((ROOT / "plannercheck").glob(f"*/{stem}.py"))
    return importlib.import_module(f"plannercheck.{path.parent.name}.{stem}")


def _python_constants(stem: str) -> dict[str, str]:
    """Those of a module that are floats."""
    module = _module(stem)
    text = Path(str(module.__file__)).read_text()
    assigned = [node for node in ast.parse(text).body if isinstance(node, ast.Assign)]
    named = [(node.targets[0].id, node.value) for node in assigned if isinstance(node.targets[0], ast.Name)]
    return {
        name: ast.get_source_segment(text, node) or "" for name, node in named if type(getattr(module, name)) is float
    }


def value(stem: str, name: str) -> Fraction:
    """A constant's value; what it is made of is computed exactly, but in Python in doubles, as the module does."""
    if is_python(stem):
        return Fraction(getattr(_module(stem), name))
    expression = _NUMBER.sub(lambda number: f"Fraction('{_exactly(number[0])}')", constants(stem)[name])
    expression = re.sub(r"\bk\w+", lambda other: f"Fraction('{_elsewhere(stem, other[0])}')", expression)
    return Fraction(eval(expression, {"Fraction": Fraction}))  # the project's own sources


def _exactly(number: str) -> Fraction:
    """A literal as it stands in the source: a decimal one is the nearest double."""
    number = number.rstrip("F")
    return Fraction(float.fromhex(number)) if number.startswith("0x") else Fraction(float(number))


def _elsewhere(stem: str, name: str) -> Fraction:
    for place in (stem, "predicates", "double_double", "support"):
        if name in constants(place):
            return value(place, name)
    raise KeyError(f"{stem} uses {name}, which no source declares")


def scripts() -> list[str]:
    """All that prove a constant, as "file/kName" or "module/_NAME"."""
    return sorted(str(path.relative_to(PROOFS).with_suffix("")) for path in PROOFS.glob("*/*.g"))


def filled(script: str, factor: Fraction = Fraction(1)) -> str:
    """A script's text with the sources' values; the constant it is named after is multiplied by `factor`."""
    own_stem, own = script.split("/") if "/" in script else ("", "")

    def number(place: re.Match[str]) -> str:
        stem, name = place[1] or own_stem, place[2]
        return _dyadic(_reduced(value(stem, name), factor) if (stem, name) == (own_stem, own) else value(stem, name))

    return _PLACE.sub(number, (PROOFS / f"{script}.g").read_text())


def _reduced(constant: Fraction, factor: Fraction) -> Fraction:
    """A part of a constant; of one that is 1 and a little, of that little."""
    return 1 + (constant - 1) * factor if 1 < constant < 1 + Fraction(1, 1000) else constant * factor


def _dyadic(number: Fraction) -> str:
    """As gappa writes m · 2^e."""
    exponent = -(number.denominator.bit_length() - 1)
    if number.denominator != 1 << -exponent:  # a sum of literals: rounded down, so that it proves no less
        exponent = number.numerator.bit_length() - number.denominator.bit_length() - 100
        number = Fraction(int(number / Fraction(2) ** exponent)) * Fraction(2) ** exponent
    return f"{int(number / Fraction(2) ** exponent)}b{exponent}"


def is_proved(text: str) -> tuple[bool, str]:
    """Whether gappa proves a script, and what it says."""
    # 200 bits: an interval of a bound in units of 2^-53 is then narrow. Scripts say what is split, if anything: else
    # gappa splits for minutes before it refuses.
    options = ["-Eprecision=200", "-Eno-auto-dichotomy"]
    run = subprocess.run(["gappa", *options], input=text, capture_output=True, text=True, timeout=60, check=False)
    said = run.stdout + run.stderr
    assert "syntax error" not in said, said
    return run.returncode == 0 and "Warning" not in said, said


def least_factor(script: str, steps: int = 12) -> float:
    """The least part of a constant that its script proves, up to 2^-steps of it, from 1/1024 to 1."""
    low, high = Fraction(1, 1024), Fraction(1)
    for _ in range(steps + 10):
        middle = (low + high) / 2
        low, high = (low, middle) if is_proved(filled(script, middle))[0] else (middle, high)
    return float(high)


def main() -> None:
    """Prints what each script proves at least."""
    for script in sys.argv[1:] or scripts():
        stem, name = script.split("/")
        stated = value(stem, name)
        print(f"{script}: {float(stated):.6g}, proved down to {least_factor(script):.3f} of it", flush=True)


if __name__ == "__main__":
    main()
