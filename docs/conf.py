"""Sphinx settings: `pip install '.[docs]' && sphinx-build -W docs build/docs`. The command reference is made here."""

from __future__ import annotations

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))  # for the command reference
if not any((HERE.parent / "plannercheck").glob("_core_*")):  # an installed plannercheck has the compiled core
    sys.path = [entry for entry in sys.path if Path(entry or ".").resolve() != HERE.parent]

from command_reference import write_reference  # noqa: E402

project = "plannercheck"
copyright = "2026, the plannercheck developers"
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
autodoc_typehints = "none"
autodoc_member_order = "bysource"
autoclass_content = "both"
napoleon_google_docstring = True
napoleon_use_ivar = True
napoleon_use_rtype = False
source_suffix = {".md": "markdown"}
myst_heading_anchors = 3
html_theme = "alabaster"
html_theme_options = {
    "description": "Exact collision verdicts for motion planning",
    "page_width": "1120px",
    "sidebar_width": "260px",
}
html_static_path: list[str] = []
exclude_patterns = ["build"]

write_reference(HERE / "reference" / "commands.md")
