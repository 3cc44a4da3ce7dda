"""The changelog's section of a version: `python packaging/release_notes.py 0.1.0`.

Out: the section, as the notes of a release; an error if it has no date, or if the version is not that of the sources.
"""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
# Each file that names the version, and where. CMake reads pyproject.toml.
VERSIONS = {
    "pyproject.toml": r'^version = "(.+)"$',
    "plannercheck/common/version.py": r'^__version__ = "(.+)"$',
    "plannercheck/cpp/package.xml": r"<version>(.+)</version>",
    "packaging/conda/recipe.yaml": r'^  version: "(.+)"$',
    "CITATION.cff": r"^version: (.+)$",
}


def versions() -> dict[str, str]:
    """The version that each file names."""
    texts = {name: (ROOT / name).read_text("utf-8") for name in VERSIONS}
    return {name: re.findall(VERSIONS[name], text, re.MULTILINE)[0] for name, text in texts.items()}


def section(version: str) -> tuple[str, str]:
    """What stands behind a version in the changelog's headline, and the section."""
    text = (ROOT / "CHANGELOG.md").read_text("utf-8")
    found = re.search(rf"^## \[{re.escape(version)}\] - (.+?)\n(.+?)(?=^## \[|\Z)", text, re.MULTILINE | re.DOTALL)
    if found is None:
        sys.exit(f"CHANGELOG.md has no section '## [{version}] - DATE'")
    return found[1], found[2].strip()


def main(version: str) -> int:
    """Prints the section."""
    date, text = section(version)
    other = {name: named for name, named in versions().items() if named != version}
    if other:
        sys.exit(f"not {version}: {', '.join(f'{named} in {name}' for name, named in other.items())}")
    if not re.fullmatch(r"\d{4}-\d{2}-\d{2}", date):
        sys.exit(f"CHANGELOG.md: {version} has no date, but '{date}'")
    print(text)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
