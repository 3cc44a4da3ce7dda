"""Compiles an MJCF file in a separate process: `python -m plannercheck.bodies.mjcf_worker`.

In: the path of the file as the argument. Out, on standard output: an npz with the arrays of MuJoCo's model that
`mjcf_files.py` names, the names of its elements, what MuJoCo warns of, and, if it refuses the file, its error. It has
to be another process: a faulty file can stop MuJoCo's compiler or fill the memory, and MuJoCo writes its warnings to
the terminal and to a file in the current folder.
"""

from __future__ import annotations

import io
import json
import os
import re
import resource
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from plannercheck.bodies.mjcf_files import FIELDS, FLAGS, NAMED

# The processor time in s and the memory in bytes that a model may take which names no meshes or other files: a count of
# 1e9 in a <replicate> or <flexcomp> would take hours, and all memory.
_SECONDS, _MEMORY = 4, 2 << 30

# The processor time of all others, s: MuJoCo splits and smooths large meshes.
_SECONDS_WITH_FILES = 300


def main() -> None:
    """Compiles one file."""
    path = Path(sys.argv[1]).absolute()
    _limit_itself(path)
    out = os.dup(1)
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)  # of MUJOCO_LOG.TXT
        said = Path(folder) / "said"
        with said.open("wb") as file:
            os.dup2(file.fileno(), 1)
            os.dup2(file.fileno(), 2)
        content = compiled(path)
        content["said"] = np.array(said.read_text(errors="replace"))
        os.chdir("/")
    written = io.BytesIO()
    np.savez(written, **content)
    with os.fdopen(out, "wb") as file:
        file.write(written.getbuffer())


def _limit_itself(path: Path) -> None:
    named = re.search(rb"\bfile\s*=", path.read_bytes()) is not None
    _lower(resource.RLIMIT_CPU, _SECONDS_WITH_FILES if named else _SECONDS)
    if not named:
        _lower(resource.RLIMIT_AS, _MEMORY)


def _lower(kind: int, limit: int) -> None:
    """Lowers a limit of this process, if it is higher."""
    soft, hard = resource.getrlimit(kind)
    known = [each for each in (limit, soft) if each != resource.RLIM_INFINITY]
    resource.setrlimit(kind, (min(known), hard))


def compiled(path: Path) -> dict[str, Any]:
    """The arrays and names of a file's model, or MuJoCo's error."""
    import mujoco

    try:
        model = mujoco.MjModel.from_xml_path(str(path))
    except Exception as error:  # of several unrelated types
        return {"error": np.array(str(error))}
    kinds = {kind: getattr(mujoco.mjtObj, f"mjOBJ_{kind.upper()}") for kind in NAMED}
    names = {
        kind: [mujoco.mj_id2name(model, number, k) or "" for k in range(getattr(model, count))]
        for (kind, count), number in zip(NAMED.items(), kinds.values(), strict=True)
    }
    names["model"] = [model.names.partition(b"\0")[0].decode(errors="replace")]
    fields = {field: np.asarray(getattr(model, field)) for field in FIELDS}
    disabled = {flag for flag in FLAGS if model.opt.disableflags & getattr(mujoco.mjtDisableBit, f"mjDSBL_{flag}")}
    return {**fields, "disabled": np.array(sorted(disabled), dtype=str), "names": np.array(json.dumps(names))}


if __name__ == "__main__":
    main()
