"""Expands a xacro file: `python -m plannercheck.robots.xacro_worker FILE`, arguments and folders as JSON on stdin.

Out: the URDF on standard output, or xacro's message on the error stream and exit code 1. An argument that the file does
not declare is an error: xacro itself ignores it.
"""

from __future__ import annotations

import io
import json
import re
import sys
from contextlib import redirect_stdout
from pathlib import Path

from plannercheck.common.errors import unknown_name
from plannercheck.common.package_files import folders_above, package_folder, where_sought

# xacro puts the Python class of an error before its message.
_CLASS = re.compile(r"<class '[\w.]+'>: ")


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
    try:
        with redirect_stdout(io.StringIO()):
            text = xacro.process_file(file, mappings=arguments).toxml()
    except Exception as error:  # xacro raises what its files' expressions raise
        print(_CLASS.sub("", str(error) or repr(error)), file=sys.stderr)
        return 1
    unused = [name for name in task["arguments"] if name not in arguments.asked]
    if unused:
        print(unknown_name("xacro argument", unused[0], sorted(arguments.asked)), file=sys.stderr)
        return 1
    sys.stdout.buffer.write(text.encode())
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
