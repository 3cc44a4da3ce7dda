"""YAML as it is written to files.

In: plain data, whose texts and numbers may be of subclasses, as NumPy's are. Out: text; numbers from a file as they
were written there, since they may be names.
"""

from __future__ import annotations

from typing import Any

import yaml

from plannercheck.common.yaml_loader import FLOAT, INT, WrittenFloat, WrittenInt


class _Dumper(yaml.SafeDumper):
    """PyYAML's safe dumper, for subclasses of texts and numbers as well."""


_Dumper.add_multi_representer(str, lambda dumper, text: dumper.represent_str(str(text)))
_Dumper.add_multi_representer(float, lambda dumper, number: dumper.represent_float(float(number)))
_Dumper.add_representer(WrittenInt, lambda dumper, number: dumper.represent_scalar(INT, number.written))
_Dumper.add_representer(WrittenFloat, lambda dumper, number: dumper.represent_scalar(FLOAT, number.written))


def yaml_of(content: Any, flow: bool | None = None, width: int = 110) -> str:
    """YAML whose innermost lists are one line each, or as `flow` says; keys keep their order."""
    return str(
        yaml.dump(content, Dumper=_Dumper, sort_keys=False, default_flow_style=flow, width=width, allow_unicode=True)
    )
