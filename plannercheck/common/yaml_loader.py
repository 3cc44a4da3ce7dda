"""The loader of YAML files: PyYAML's, which refuses what it would read otherwise than the file's writer meant.

In: YAML text. Out: plain Python values. A key that stands twice in a mapping is refused (YAML 1.2, 3.2.1.3: keys are
unique); a key beside `<<` may stand in the merged mapping as well, and counts. `010`, `1_2` and `1:30` are texts, not
8, 12 and 90: MoveIt's yaml-cpp writes names so, reads 10 where it needs a number, and refuses `1:30`. Keys are texts as
they are written, and numbers know how they are: a name `1.10` is not `1.1`.
"""

from __future__ import annotations

import re
from typing import Any

import yaml

from plannercheck.common.errors import PlannercheckError, shortened
from plannercheck.common.input_limits import YAML_LOADER
from plannercheck.common.unique_keys import key_given_twice

INT, FLOAT = "tag:yaml.org,2002:int", "tag:yaml.org,2002:float"
_TEXT, _NULL = "tag:yaml.org,2002:str", "tag:yaml.org,2002:null"
_NO_NUMBER = "(?![^:]*:|[^_]*_|[-+]?0[0-7]+$)"

# What `ros2 topic echo` writes in place of a list's entries after the 128th.
_CUT = "..."


class WrittenInt(int):
    """A number that the file has as another text than Python."""

    written: str


class WrittenFloat(float):
    """A number that the file has as another text than Python."""

    written: str


class YamlLoader(YAML_LOADER):  # type: ignore[misc]  # which of two PyYAML has depends on the platform
    """PyYAML's safe loader with unique keys, without octal and base 60, and without lists that were cut short."""

    yaml_implicit_resolvers = {  # noqa: RUF012  # of PyYAML
        first: [
            (tag, re.compile(_NO_NUMBER + known.pattern, known.flags) if tag in (INT, FLOAT) else known)
            for tag, known in resolvers
        ]
        for first, resolvers in YAML_LOADER.yaml_implicit_resolvers.items()
    }

    def __init__(self, text: bytes | str, as_written: str | None = None) -> None:
        super().__init__(text)
        self._flattened: set[yaml.Node] = set()
        self._as_written = as_written

    def flatten_mapping(self, node: yaml.MappingNode) -> None:
        """Puts merged keys into a mapping, once: PyYAML comes again for each mapping that merges this one."""
        if node in self._flattened:
            return
        self._flattened.add(node)
        twice = key_given_twice([key.value for key, _ in node.value if type(key.value) is str])
        if twice is not None:
            lines = ", ".join(str(key.start_mark.line + 1) for key, _ in node.value if key.value == twice)
            raise PlannercheckError(f"a mapping has the key {shortened(twice)!r} twice, on lines {lines}: give it once")
        super().flatten_mapping(node)
        for k, (key, value) in enumerate(node.value):
            if key.tag != _TEXT:
                node.value[k] = _as_text(key), value
        for k, (key, value) in enumerate(node.value if self._as_written else ()):
            if key.value == self._as_written and isinstance(value, yaml.MappingNode):
                node.value[k] = key, self._with_texts(value)

    def _with_texts(self, node: yaml.MappingNode) -> yaml.MappingNode:
        """A mapping whose scalars are texts as they are written: 1.10 is not 1.1, and on is not true."""
        self.flatten_mapping(node)
        pairs = [(key, value if value.tag == _NULL else _as_text(value)) for key, value in node.value]
        return yaml.MappingNode(node.tag, pairs, node.start_mark, node.end_mark)

    def construct_sequence(self, node: yaml.SequenceNode, deep: bool = False) -> list[Any]:
        """The list of a sequence that is whole."""
        if node.value and node.value[-1].value == _CUT:
            raise PlannercheckError(
                f"the list on line {node.start_mark.line + 1} ends in '...' after {len(node.value) - 1} entries:"
                " `ros2 topic echo` cuts lists short without --full-length"
            )
        return super().construct_sequence(node, deep)  # type: ignore[no-any-return]

    def construct_yaml_int(self, node: yaml.ScalarNode) -> Any:
        """A whole number, with its text if Python writes another one."""
        return _number(node, int, super().construct_yaml_int, WrittenInt)

    def construct_yaml_float(self, node: yaml.ScalarNode) -> Any:
        """A number, in the same way."""
        return _number(node, float, super().construct_yaml_float, WrittenFloat)


def _number(node: yaml.ScalarNode, read: Any, read_any: Any, written: Any) -> Any:
    """A number by Python's reading where that will do: PyYAML's takes longer."""
    try:
        value = read(node.value)
    except ValueError:
        value = read_any(node)
    if str(value) == node.value:
        return value
    number = written(value)
    number.written = node.value
    return number


def _as_text(node: yaml.Node) -> yaml.Node:
    """A scalar as the text that is written; a node of its own, since aliases of the scalar are what they were."""
    if not isinstance(node, yaml.ScalarNode):
        return node
    return yaml.ScalarNode(_TEXT, node.value, node.start_mark, node.end_mark)


YamlLoader.add_constructor(INT, YamlLoader.construct_yaml_int)
YamlLoader.add_constructor(FLOAT, YamlLoader.construct_yaml_float)
