"""Compiles an MJCF file in a process of its own: `python -m plannercheck.bodies.mjcf_worker`.

In: the path of the file as the argument. Out, on standard output: an npz with the arrays of MuJoCo's model that
`mjcf_files.py` names, the names of its elements, what MuJoCo warns of, and, if it refuses the file, its error. It has
to be another process: a faulty file can stop MuJoCo's compiler or fill the memory, and MuJoCo writes its warnings to
the terminal and to a file in the current folder.
"""

from __future__ import annotations

import io
import json
import os
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from plannercheck.bodies.mjcf_files import FIELDS, FLAGS, NAMED


def main() -> None:
    """Compiles one file."""
    path = Path(sys.argv[1]).absolute()
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
