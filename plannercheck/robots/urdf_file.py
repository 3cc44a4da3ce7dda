"""A URDF as text and as XML; some common faults of the XML are mended.

In: a path. Out: `UrdfFile`. Python's XML reader fails on an XML declaration that is not at the beginning, on undeclared
prefixes, and on "--" within a comment. None of these concerns collisions, so it gets a text without them.
`urdf_checks.py` checks links and joints. Pinocchio, and urdfdom under it, then get the links' masses and bodies and the
joints alone: a faulty <visual> or mass, for which urdfdom drops the whole link, is not among them.
"""

from __future__ import annotations

import re
import tempfile
import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from xml.etree.ElementTree import Element

from plannercheck.common.errors import PlannercheckError, shortened
from plannercheck.common.file_kinds import file_kind, kind_unless_xml
from plannercheck.common.input_limits import check_xml_text
from plannercheck.common.package_data import is_file, why_no_file
from plannercheck.robots.urdf_checks import check_robot, number, numbers
from plannercheck.robots.urdf_messages import native_messages
from plannercheck.robots.xacro import XACRO_SUFFIX, expanded, xacro_hint

_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
_DECLARATION = re.compile(r"<\?xml\b.*?\?>", re.DOTALL)
_PREFIX = re.compile(r"[<\s/]([A-Za-z_][\w.-]*):[A-Za-z_]")
_ROOT = re.compile(r"<robot\b")
_ENCODING = re.compile(rb"""(?:\xef\xbb\xbf)?<\?xml[^>]*?encoding\s*=\s*["']([^"']*)""")
_UTF8 = (b"utf-8", b"utf8", b"us-ascii", b"ascii")
_NO_TEXT = re.compile("[\ud800-\udfff]")
_BLANK = " \t\r\n\0"  # some files end in a zero byte
_XACRO = re.compile(r"\{[^}]*\bxacro/?\}")

# Roots of robots in other formats: MuJoCo's, which mjcf.py reads, and Gazebo's, which nothing here reads.
MJCF_ROOT, SDF_ROOT = "mujoco", "sdf"

# Attributes of an <inertia>.
_MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")

# The elements of links and joints that the model is made of.
_READ = ("inertial", "origin", "parent", "child", "axis", "limit", "mimic")

# Every XML reader knows these.
_KNOWN_PREFIXES = frozenset({"xml", "xmlns"})


@dataclass(frozen=True, eq=False)
class UrdfFile:
    """A URDF that has been read.

    Attributes:
        path: The file.
        mended: The text to read in place of the file: what a xacro expands to, or what is left of a file with faults;
            None to read the file itself.
        fault: Why the file is no XML; empty if it is.
    """

    path: Path
    mended: str | None
    fault: str
    _root: Element | None

    @classmethod
    def read(cls, path: Path, arguments: Mapping[str, str] | None = None, folders: Sequence[Path] = ()) -> UrdfFile:
        """Reads a URDF or a xacro. If it is no XML, only `root` raises.

        A xacro's arguments are by name; its packages are searched in the folders first.

        Raises:
            PlannercheckError: If there is no such file, it is nested too deep, a xacro can't be expanded, or links and
                joints can't be read as they are written.
        """
        if path.suffix == XACRO_SUFFIX:
            text = expanded(path, arguments or {}, folders)
            root, fault = _parsed(text)
            check_xml_text(text.encode(), f"URDF {path}")
            if root is not None:
                _check_links(root, path)
                _check_content(root, path)
            return cls(path, text, fault, root)
        if arguments:
            raise PlannercheckError(f"URDF {path} is no .xacro, so that it takes no arguments: {', '.join(arguments)}")
        if not is_file(path):
            raise PlannercheckError(f"URDF {path} {why_no_file(path)}")
        try:
            content = path.read_bytes()
        except OSError as error:
            raise PlannercheckError(f"URDF {path} can't be read: {error.strerror or error}") from None
        root, fault = _parsed(content)
        plain = None if root is not None else _plain(content)
        if plain is not None and (root := _parsed(plain)[0]) is not None:
            content = plain.encode()
        check_xml_text(content, f"URDF {path}")
        if root is None:
            _check_encoding(content, path)
            return cls(path, None, fault, None)
        _check_expanded(root, path)
        _check_content(root, path)
        return cls(path, plain, "", root)

    @property
    def root(self) -> Element:
        """The XML's root."""
        if self._root is None:
            raise PlannercheckError(f"URDF {self.path} does not parse: {self.hint or self.no_xml}")
        return self._root

    @property
    def kind(self) -> str:
        """The name of the root element: "robot" for a URDF, "mujoco" for an MJCF file; "" if it is no XML."""
        return "" if self._root is None else str(self._root.tag)

    @property
    def hint(self) -> str:
        """Says so if the file is a xacro that was not expanded; else empty."""
        return xacro_hint(self.path)

    @property
    def no_xml(self) -> str:
        """Says so if the file is no XML; else empty."""
        if not self.fault:
            return ""
        return kind_unless_xml(self.path) or f"it is no XML ({self.fault})"

    @cached_property
    def native(self) -> str:
        """The text that Pinocchio reads: what of links and joints it needs, masses where they are whole."""
        return self.text_with("")

    def text_with(self, kind: str) -> str:
        """The same with the elements of a kind, "collision" or "visual": a ball at the origin of each."""
        robot = Element("robot", self.root.attrib)
        for part in self.root:
            if part.tag in ("link", "joint"):
                robot.append(_stripped(part, kind))
        return ElementTree.tostring(robot, encoding="unicode")

    def messages(self, floating: bool) -> str:
        """What urdfdom and Pinocchio say about the file; empty if that can't be found out."""
        with tempfile.TemporaryDirectory() as folder:
            written = Path(folder) / self.path.name
            written.write_text(self.native, encoding="utf-8")
            return native_messages(written, floating).replace(str(written), str(self.path))


def _stripped(part: Element, kind: str) -> Element:
    """A link or joint without elements that are not read, and without faulty masses."""
    kept = Element(str(part.tag), part.attrib)
    for inner in part:
        if inner.tag == kind:
            kept.append(_ball(inner))
        elif inner.tag in _READ and not (inner.tag == "inertial" and _lacks(inner)):
            kept.append(inner)
    return kept


def _ball(element: Element) -> Element:
    """An element of the same kind and place, whose shape is a ball."""
    ball = Element(str(element.tag))
    ball.extend(element.iterfind("origin"))
    ElementTree.SubElement(ElementTree.SubElement(ball, "geometry"), "sphere", radius="1")
    return ball


def _parsed(content: bytes | str) -> tuple[Element | None, str]:
    """The XML's root, or why there is none."""
    try:
        return ElementTree.fromstring(content), ""
    except (ElementTree.ParseError, LookupError, ValueError) as error:  # the last two for encodings
        return None, str(error)


def _plain(content: bytes) -> str | None:
    """The text without comments and declarations, all prefixes bound; None if it is no UTF-8, or says so."""
    declared = _ENCODING.match(content)
    if declared is not None and declared[1].lower() not in _UTF8:
        return None
    text = _DECLARATION.sub("", _COMMENT.sub("", content.decode("utf-8-sig", "surrogateescape"))).strip(_BLANK)
    if _NO_TEXT.search(text):
        return None
    unbound = {name for name in _PREFIX.findall(text) if f"xmlns:{name}" not in text} - _KNOWN_PREFIXES
    bindings = "".join(f' xmlns:{name}="unbound:{name}"' for name in sorted(unbound))
    return _ROOT.sub(f"<robot{bindings}", text, count=1)


def _check_expanded(root: Element, path: Path) -> None:
    """Raises for elements of xacro: urdfdom skips them, so that links and joints would be missing."""
    found = next((each.tag for each in root.iter() if isinstance(each.tag, str) and _XACRO.match(each.tag)), None)
    if found is not None:
        raise PlannercheckError(f"URDF {path} holds <xacro:{found.partition('}')[2]}>: {xacro_hint(path)}")


def _check_links(root: Element, path: Path) -> None:
    """Raises for a xacro that makes no link: it only defines macros, which others call."""
    if root.find("link") is None:
        macros = re.findall(r"""<xacro:macro\s[^>]*?name=["']([^"']+)""", path.read_text(errors="replace"))
        listed = f" ({', '.join(map(shortened, macros[:3]))})" if macros else ""
        raise PlannercheckError(
            f"xacro {path} expands to no link: it defines macros{listed}, so give the .xacro that includes it and "
            "calls them"
        )


def _check_encoding(content: bytes, path: Path) -> None:
    """Raises for a file that says nothing about its encoding, or UTF-8, and is none."""
    declared = _ENCODING.match(content)
    if content.startswith((b"\xff\xfe", b"\xfe\xff")) or (declared is not None and declared[1].lower() not in _UTF8):
        return
    try:
        _COMMENT.sub("", content.decode("utf-8-sig", "surrogateescape")).encode()
    except UnicodeEncodeError as error:
        line = error.object.count("\n", 0, error.start) + 1
        raise PlannercheckError(
            f"URDF {path} is not UTF-8 in line {line} (comments left out): save it so, or declare its encoding, as in "
            '<?xml version="1.0" encoding="latin-1"?>'
        ) from None


def _check_content(root: Element, path: Path) -> None:
    """Raises for what is no robot, and for links and joints that can't be read as they are written."""
    _check_named(root, path)
    if root.tag == "robot":
        try:
            check_robot(root, path)
        except PlannercheckError:
            hint = xacro_hint(path)
            if not hint:
                raise
            raise PlannercheckError(f"URDF {path} does not parse: {hint}") from None


def _check_named(root: Element, path: Path) -> None:
    """Raises for a robot without a name, which urdfdom does not take, and for what is no robot."""
    if root.tag in (MJCF_ROOT, SDF_ROOT):
        return
    if root.tag != "robot":
        kind = file_kind(ElementTree.tostring(root))
        raise PlannercheckError(f"URDF {path} is none: {kind}, where the root must be <robot>")
    if root.find("link") is None and (root.find("group") is not None or root.find("disable_collisions") is not None):
        raise PlannercheckError(f"URDF {path} is none: it is an SRDF, which --srdf takes, beside the URDF as --robot")
    if root.find("link") is None and not root.get("name"):
        raise PlannercheckError(
            f"URDF {path} has no <link>, nor a name: does it only define macros? Give the .xacro that calls them"
        )
    if not root.get("name"):
        raise PlannercheckError(f'URDF {path}: its <robot> has no name: write <robot name="...">')


def _lacks(inertial: Element) -> bool:
    """Whether an <inertial> has no mass, no moments of inertia, or numbers that are none: these decide no verdict."""
    origin, mass, moments = (inertial.find(tag) for tag in ("origin", "mass", "inertia"))
    if mass is None or moments is None:
        return True
    turned = {} if origin is None else {key: origin.get(key) for key in ("xyz", "rpy") if key in origin.attrib}
    try:
        number(mass.get("value"), "mass")
        for key in _MOMENTS:
            number(moments.get(key), key)
        for text in turned.values():
            numbers(text, 3, "origin")
    except PlannercheckError:
        return True
    return False
