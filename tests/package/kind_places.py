"""Places that ask what kind a body is: `python tests/package/kind_places.py [--list] [CHECKOUT]`.

In: a checkout. Out: how many lines of the core and of the package (bodies, checking, motions) ask
whether a body, its shape or its certificate is a hull, a solid, a set of parts or a half-space; with --list, each. A
row chosen from a table by the kind is one place as well. Assertions ask nothing, and `as` reads what is known. Places
that ask for a trait (`KindTraits`), which a new kind states in its row, are counted by themselves.
"""

import argparse
import re
from collections.abc import Iterator
from pathlib import Path

_SHAPES = "Solid|PartSet|HalfSpace"
_POSED = "PosedHalfSpace|PosedParts|PosedTriangles|GivenParts|SolidSeparation|PartSeparation"
_ASKED = {
    "plannercheck/cpp": re.compile(
        r"\bis_of_(?:parts|half_space|solids)\(|\bkind_of\(|\bsets_of\(|\bkernel_of\("
        r"|\bkind(?:\(\))? [=!]= Kind::k(?:Hull|Solid|PartSet|HalfSpace)\b|\b(?:body|b)(?:\.|->)kind\(\)"
        r"|\b(?:body|under|over|body_a|body_b|a|b|set)(?:\([^()]*\))?(?:\.|->)(?:solid|parts|half_space)\b(?!->| =)"
    ),
    "plannercheck": re.compile(
        rf"isinstance\([^()]*(?:\([^()]*\))?[^()]*\b(?:{_SHAPES}|{_POSED})\b"
        r"|\bis_of_(?:parts|half_space)\(|\bpair_kind\(|\bkind_of_shape\(|\b[A-Z_]+\[\w+\.kind\]"
        r"|(?<!self)\.kind (?:[=!]=|in) .*\"(?:hull|solid|part_set|half_space)\"|\.kind, \w+\.kind\)"
        r"|\.(?:solid|parts|half_space) is (?:not )?None|\.is_solid\b"
    ),
}
_ROW = re.compile(r"kernel_of\(|\[kind_of\(|kind = kind_of\(|push_back\(kind_of\(|\[pair_kind\(|[A-Z]+\[\w+\.kind\]")
_TRAIT = re.compile(r"\btraits(?:\(\))?\.|\btraits_of\(|\bhave_parts\(|\bare_bounded\(")
_FOLDERS = {"plannercheck": ("bodies", "checking", "motions")}
_LEFT_OUT = ("oracle/", "planar/")
# Definitions, and what only stands in comments and assertions.
_NOT_ASKED = re.compile(r"^\s*(?://|#|assert |def |inline (?:Kind|Sets|const PairKernel&) |\"\"\"|static |bool is_of_)")


def places(checkout: Path, traits: bool = False) -> Iterator[tuple[str, int, str]]:
    """File, line and text of each place that asks for a kind, or for a trait."""
    for root, for_kind in _ASKED.items():
        asked = _TRAIT if traits else for_kind
        folder = checkout / root
        under = [folder / each for each in _FOLDERS.get(root, ("",))]
        suffixes = {".cpp", ".hpp"} if root.endswith("cpp") else {".py"}
        for path in sorted(path for each in under for path in each.rglob("*") if path.suffix in suffixes):
            if str(path.relative_to(folder)).startswith(_LEFT_OUT):
                continue
            for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
                if asked.search(line) and not _NOT_ASKED.match(line):
                    yield str(path.relative_to(checkout)), number, line.strip()


def main() -> None:
    """Prints the numbers."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("checkout", type=Path, nargs="?", default=Path(__file__).parents[2])
    parser.add_argument("--list", action="store_true", help="each place")
    options = parser.parse_args()
    found = list(places(options.checkout))
    if options.list:
        for path, number, text in found:
            print(f"{path}:{number}: {text}")
    of_core = sum(path.startswith("plannercheck/cpp") for path, _, _ in found)
    rows = sum(bool(_ROW.search(text)) for _, _, text in found)
    print(
        f"{len(found)} places: {of_core} in the core, {len(found) - of_core} in the package; of them {rows} choose a "
        "row of a table; "
        f"{len(list(places(options.checkout, True)))} places ask for a trait"
    )


if __name__ == "__main__":
    main()
