"""YAML as it is written to files.

In: plain data, whose texts and numbers may be of subclasses, as NumPy's are. Out: text.
"""

from __future__ import annotations

from typing import Any

import yaml


class _Dumper(yaml.SafeDumper):
    """PyYAML's safe dumper, for subclasses of texts and numbers as well."""


_Dumper.add_multi_representer(str, lambda dumper, text: dumper.represent_str(str(text)))
_Dumper.add_multi_representer(float, lambda dumper, number: dumper.represent_float(float(number)))


def yaml_of(content: Any, flow: bool | None = None, width: int = 110) -> str:
    """YAML whose innermost lists are one line each, or as `flow` says; keys keep their order."""
    return str(
        yaml.dump(content, Dumper=_Dumper, sort_keys=False, default_flow_style=flow, width=width, allow_unicode=True)
    )
