"""Expands a xacro file: `python -m plannercheck.robots.xacro_worker FILE`, arguments and folders as JSON on stdin.

Out: the URDF on standard output and xacro's warnings on the error stream, or its message there and exit code 1. An
argument that the file does not declare is an error, and an element of xacro without "xacro:" gets a warning: xacro
itself ignores both.
"""

from __future__ import annotations

import io
import json
import re
import sys
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

from plannercheck.common.errors import unknown_name
from plannercheck.common.package_files import folders_above, package_folder, where_sought

# xacro puts the Python class of an error before its message.
_CLASS = re.compile(r"<class '[\w.]+'>: ")

# Elements of xacro, which it read without "xacro:" until ROS Jade, and elements of URDFs, whose names macros may have.
_ELEMENTS = {"include", "property", "macro", "if", "unless", "insert_block", "arg"}
_OF_URDFS = {"link", "joint", "material", "transmission", "gazebo", "sensor", "ros2_control", "inertial", "visual"}
_OF_URDFS |= {"collision", "origin", "parent", "child", "axis", "limit", "mimic", "dynamics", "safety_controller"}


class Arguments(dict[str, str]):
    """Arguments that know which of them the file asked for, by <xacro:arg> or $(arg): xacro looks for both in here."""

    def __init__(self, given: dict[str, str]) -> None:
        super().__init__(given)
        self.asked: dict[str, None] = {}

    def __contains__(self, name: object) -> bool:
        self.asked[str(name)] = None
        return super().__contains__(name)

    def __getitem__(self, name: str) -> str:
        self.asked[name] = None
        return super().__getitem__(name)


def main(file: str) -> int:
    """Expands one file."""
    import xacro
    from xacro import substitution_args

    task = json.load(sys.stdin)
    folders = [Path(folder) for folder in task["folders"]]
    above = folders_above(Path(file))

    def find(name: str) -> str:
        folder = package_folder(name, folders, above)
        if folder is None:
            raise LookupError(f"package {name!r} is not found. {where_sought(folders)}")
        return str(folder)

    substitution_args._eval_find = find
    substitution_args._eval_dict["find"] = find
    arguments = Arguments(task["arguments"])
    macros, grab_macro = set(), xacro.grab_macro

    def grab_named_macro(element: Any, table: Any) -> None:
        macros.add(element.getAttribute("name"))
        grab_macro(element, table)

    xacro.grab_macro = grab_named_macro
    try:
        with redirect_stdout(io.StringIO()):
            document = xacro.process_file(file, mappings=arguments)
            text = document.toxml()
    except Exception as error:  # xacro raises what its files' expressions raise
        print(_CLASS.sub("", str(error) or repr(error)), file=sys.stderr)
        return 1
    unused = [name for name in task["arguments"] if name not in arguments.asked]
    if unused:
        print(unknown_name("xacro argument", unused[0], sorted(arguments.asked)), file=sys.stderr)
        return 1
    for tag in sorted(_tags(document.documentElement) & (_ELEMENTS | macros - _OF_URDFS)):
        print(f"<{tag}> is passed over: write <xacro:{tag}>", file=sys.stderr)
    sys.stdout.buffer.write(text.encode())
    return 0


def _tags(root: Any) -> set[str]:
    """The tags of a robot's elements, and of those within links and joints."""
    parts = [part for part in root.childNodes if part.nodeType == part.ELEMENT_NODE]
    inner = [each for part in parts if part.tagName in ("link", "joint") for each in part.childNodes]
    return {part.tagName for part in (*parts, *inner) if part.nodeType == part.ELEMENT_NODE}


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
