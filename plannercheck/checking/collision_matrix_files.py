"""Writes allowed collision matrices: SRDF, or the `disabled_pairs` of a robot's YAML.

In: pairs of links with reasons. Out: text. An SRDF gets the reasons that MoveIt's assistant knows; a comment says what
was proved. Groups, states and everything else in an existing SRDF stay as they are.
"""

from __future__ import annotations

import copy
import itertools
import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping, Sequence
from xml.etree.ElementTree import Element

from plannercheck.checking.collision_matrix import LinkPair
from plannercheck.common.written_yaml import yaml_of

_SRDF_REASONS = {
    "adjacent": "Adjacent",
    "default": "Default",
    "always": "Always",
    "never": "Never",
    "proved never": "Never",
}


def srdf_text(robot: str, pairs: Sequence[LinkPair], semantics: Element | None = None) -> str:
    """The text of a robot's SRDF that disables pairs, ordered by reason, in place of those of the semantics, if any."""
    root = Element("robot", name=robot) if semantics is None else copy.deepcopy(semantics)
    for old in root.findall("disable_collisions"):
        root.remove(old)
    for words, group in itertools.groupby(pairs, key=_heading):
        root.append(ElementTree.Comment(f" {words} "))
        for pair in group:
            reason = _SRDF_REASONS[str(pair.reason)]
            ElementTree.SubElement(root, "disable_collisions", link1=pair.link_a, link2=pair.link_b, reason=reason)
    return _written(root)


def commented_srdf(semantics: Element, comments: Mapping[frozenset[str], str]) -> str:
    """An SRDF as it is, with comments, by the names of both links, before its disabled pairs."""
    root = copy.deepcopy(semantics)
    for element in root.findall("disable_collisions"):
        text = comments.get(frozenset((element.get("link1", ""), element.get("link2", ""))))
        if text is not None:
            root.insert(list(root).index(element), ElementTree.Comment(f" {text.replace('--', '- -')} "))
    return _written(root)


def _written(root: Element) -> str:
    ElementTree.indent(root)
    return '<?xml version="1.0"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def yaml_text(pairs: Sequence[LinkPair]) -> str:
    """The `disabled_pairs` of a robot's YAML, one block a reason."""
    blocks = [
        {"reason": words, "pairs": [[pair.link_a, pair.link_b] for pair in group]}
        for words, group in itertools.groupby(pairs, key=_heading)
    ]
    return yaml_of({"disabled_pairs": blocks})


def _heading(pair: LinkPair) -> str:
    """Words for all pairs of a reason."""
    if pair.reason == "proved never":
        return "proved never to meet within the joint limits"
    if pair.reason == "never":
        return f"not seen to meet in {pair.states} random configurations"
    return {"adjacent": "adjacent", "default": "collide in the reference"}.get(str(pair.reason), "always collide")
