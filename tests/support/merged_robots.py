"""Robots merged by hand into one URDF and one SRDF, as users did before there were cells; shares nothing with cells."""

import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Placed:
    """A robot to merge: its files, and where its base stands, m and rad."""

    urdf: Path
    srdf: Path | None
    xyz: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)


def merged(robots: Mapping[str, Placed], folder: Path) -> tuple[Path, Path]:
    """Writes cell.urdf and cell.srdf: names get "robot/" before them, each base is fixed to the link "cell"."""
    urdf = ElementTree.Element("robot", name="cell")
    srdf = ElementTree.Element("robot", name="cell")
    ElementTree.SubElement(urdf, "link", name="cell")
    for name, placed in robots.items():
        root = ElementTree.parse(placed.urdf).getroot()
        links = [link.get("name") for link in root.findall("link")]
        children = {joint.find("child").get("link") for joint in root.findall("joint")}
        (base,) = (link for link in links if link not in children)
        for element in (*root.findall("link"), *root.findall("joint")):
            _prefix(element, name)
            urdf.append(element)
        joint = ElementTree.SubElement(urdf, "joint", name=f"{name}/base", type="fixed")
        ElementTree.SubElement(joint, "parent", link="cell")
        ElementTree.SubElement(joint, "child", link=f"{name}/{base}")
        numbers = {key: " ".join(map(repr, getattr(placed, key))) for key in ("xyz", "rpy")}
        ElementTree.SubElement(joint, "origin", numbers)
        disabled = [] if placed.srdf is None else ElementTree.parse(placed.srdf).getroot().findall("disable_collisions")
        for pair in disabled:
            _prefix(pair, name)
            srdf.append(pair)
    files = folder / "cell.urdf", folder / "cell.srdf"
    for path, tree in zip(files, (urdf, srdf), strict=True):
        path.write_text(ElementTree.tostring(tree, encoding="unicode"), encoding="utf-8")
    return files


def _prefix(element: ElementTree.Element, name: str) -> None:
    """Puts the robot's name before all names of links and joints of an element."""
    for key in ("name", "link1", "link2"):
        if element.tag in ("link", "joint", "disable_collisions") and element.get(key) is not None:
            element.set(key, f"{name}/{element.get(key)}")
    for tag, key in (("parent", "link"), ("child", "link"), ("mimic", "joint")):
        for child in element.findall(tag):
            child.set(key, f"{name}/{child.get(key)}")
