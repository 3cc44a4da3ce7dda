"""Reads and writes models by their suffix.

In: a path. Out: `Primitives` by link; or the file.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from plannercheck.common.atomic_files import write_atomically
from plannercheck.common.checked_yaml import error_context
from plannercheck.common.errors import PlannercheckError
from plannercheck.coverings import curobo_files, plain_files, urdf_files
from plannercheck.coverings.primitives import Primitives
from plannercheck.robots.urdf_file import MJCF_ROOT, UrdfFile

_FORMATS = (curobo_files, urdf_files, plain_files)
_WORDS = "cuRobo's .yml or .xrdf, a .urdf as foam and VAMP have it, or .json"


def read_model(path: Path, link_names: Sequence[str]) -> dict[str, Primitives]:
    """The primitives of a model by link.

    Raises:
        PlannercheckError: If the file can't be read, has another format, unknown links or faulty numbers, or is empty.
    """
    with error_context(f"sphere model {path}"):
        reader = next((each for each in _FORMATS if path.suffix in each.SUFFIXES), None)
        if reader is None:
            raise PlannercheckError(f"suffix {path.suffix!r} is of no model: these are {_WORDS}")
        found: dict[str, Primitives] = reader.read(path, link_names)
        if not any(map(len, found.values())):
            raise PlannercheckError("it has no spheres, capsules or boxes that count for a link of the robot")
    return found


def write_model(path: Path, covers: Mapping[str, Primitives], urdf: UrdfFile | None, source: Path | None) -> None:
    """Writes a model.

    Args:
        path: Its suffix says the format.
        covers: Primitives by link.
        urdf: The robot's file, if it is made of one.
        source: The file that the model was read from, if any.
    """
    if path.suffix in plain_files.SUFFIXES:
        content = plain_files.model_text(covers)
    elif path.suffix in (".yml", ".yaml"):
        content = curobo_files.model_text(covers, source)
    elif path.suffix in urdf_files.SUFFIXES:
        if urdf is None or urdf.kind == MJCF_ROOT:
            raise PlannercheckError(f"file {str(path)!r}: the robot has no URDF to put spheres into: save as .json")
        content = urdf_files.model_text(covers, urdf)
    else:
        raise PlannercheckError(f"file {str(path)!r}: a model is written as .yml, .urdf or .json")
    write_atomically(path, lambda aside: aside.write_text(content, encoding="utf-8"))
