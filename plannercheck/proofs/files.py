"""Proofs in files: JSON, which anyone can read, or npz, which is smaller.

In: proofs of motions of one robot in one scene, which share the model. Out: a file, and the same bits back.

A document: {"format": "plannercheck motion proof", "version": 1, "kind", "robot", "scene", "hashes", "model",
"motions": [{"motion", "margin", "entries"}, …]}, with the fields of the classes in `data.py`. A motion in space without
`path` follows screws: so files from before there were other paths can be read. An npz has the document as the text
`document`, in which {"array": k} stands for the array `array_k`.
"""

from __future__ import annotations

import json
import zipfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.atomic_files import write_atomically
from plannercheck.common.checked_yaml import BROKEN_FILE, error_context, read_bytes
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.file_kinds import kind_of
from plannercheck.common.input_limits import INPUT_LIMITS
from plannercheck.common.unique_keys import object_of
from plannercheck.proofs.data import FORMAT, VERSION, Entry, Hashes, Model, Motion, ProofData
from plannercheck.proofs.plain_data import from_plain, to_plain
from plannercheck.proofs.planar_proof import PlanarModel, PlanarMotion

# The classes of a proof's model and motion, by its kind.
_CLASSES: dict[str, tuple[type, type]] = {"space": (Model, Motion), "plane": (PlanarModel, PlanarMotion)}

# The path of motions in files that name none.
_UNNAMED_PATH = "screw"

_KEYS = ("format", "version", "kind", "robot", "scene", "hashes", "model", "motions")


def save_proofs(proofs: Sequence[ProofData], path: str | Path) -> None:
    """Writes proofs of one robot in one scene; the file appears whole or not at all.

    Args:
        proofs: At least one; all of the same model.
        path: Ends in .json or .npz.

    Raises:
        PlannercheckError: If the proofs are of several models, or the file can't be written.
    """
    write_document(document(proofs), path)


def write_document(content: dict[str, Any], path: str | Path) -> None:
    """Writes a document to a .json or .npz; arrays are those of doubles."""
    path = Path(path)
    with error_context(f"proof file {str(path)!r}"):
        _check_suffix(path)
    if path.suffix == ".json":
        text = json.dumps(content, default=lambda array: array.tolist(), separators=(",", ":"))
        write_atomically(path, lambda aside: aside.write_text(text + "\n", encoding="utf-8"))
        return
    arrays: dict[str, NDArray[np.float64]] = {}

    def apart(array: NDArray[np.float64]) -> dict[str, int]:
        arrays[f"array_{len(arrays)}"] = array
        return {"array": len(arrays) - 1}

    text = json.dumps(content, default=apart)

    def write(aside: Path) -> None:
        with aside.open("wb") as file:  # given a name, numpy would add its suffix
            np.savez_compressed(file, document=np.array(text), **arrays)  # type: ignore[arg-type]

    write_atomically(path, write)


def read_document(path: str | Path) -> Any:
    """The document of a .json or .npz."""
    path = Path(path)
    _check_suffix(path)
    return _from_json(path) if path.suffix == ".json" else _from_npz(path)


def document(proofs: Sequence[ProofData]) -> dict[str, Any]:
    """The document of proofs of one model; arrays stay arrays."""
    if not proofs:
        raise PlannercheckError("a proof file needs at least one proof")
    first = proofs[0]
    if any((proof.kind, proof.hashes) != (first.kind, first.hashes) for proof in proofs):
        raise PlannercheckError("a proof file holds motions of one robot in one scene: save others in another file")
    shared = {name: to_plain(getattr(first, name)) for name in ("kind", "robot", "scene", "hashes", "model")}
    motions = [{name: to_plain(getattr(proof, name)) for name in ("motion", "margin", "entries")} for proof in proofs]
    for item in motions:
        if item["motion"].get("path") == _UNNAMED_PATH:
            del item["motion"]["path"]
    return {"format": FORMAT, "version": VERSION, **shared, "motions": motions}


def from_document(content: Any) -> tuple[ProofData, ...]:
    """The proofs of a document.

    Raises:
        PlannercheckError: If it is none, or of another version.
    """
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise PlannercheckError(f"is no motion proof: 'format' must be {FORMAT!r}")
    checked_version(content)
    missing = [key for key in _KEYS if key not in content]
    if missing:
        raise PlannercheckError(f"lacks {missing[0]!r}")
    if not isinstance(content["kind"], str) or content["kind"] not in _CLASSES:
        raise PlannercheckError(f"'kind' must be one of {', '.join(_CLASSES)}, not {content['kind']!r:.60}")
    model_class, motion_class = _CLASSES[content["kind"]]
    model: Any = from_plain(model_class, content["model"], "model")
    hashes = from_plain(Hashes, content["hashes"], "hashes")
    names = [from_plain(str, content[key], repr(key)) for key in ("robot", "scene")]
    if not isinstance(content["motions"], list):
        raise PlannercheckError("'motions' must be a list")
    if not content["motions"]:
        raise PlannercheckError("has no motions")
    return tuple(
        _motion(content["kind"], names, hashes, model, motion_class, item, f"motion {k}")
        for k, item in enumerate(content["motions"])
    )


def checked_version(content: dict[str, Any]) -> None:
    """Raises for a document of another version."""
    version = content.get("version")
    if type(version) is not int or version != VERSION:  # true and 1.0 are equal to 1, and are no versions
        raise PlannercheckError(f"is of version {version!r:.40}; this plannercheck reads version {VERSION}")


def _motion(
    kind: Any, names: Sequence[str], hashes: Hashes, model: Any, motion_class: Any, item: Any, where: str
) -> ProofData:
    if not isinstance(item, dict) or set(item) != {"motion", "margin", "entries"}:
        raise PlannercheckError(f"{where} must have motion, margin, entries")
    if not isinstance(item["entries"], list):
        raise PlannercheckError(f"{where}: 'entries' must be a list")
    margin = from_plain(float, item["margin"], f"{where}, 'margin'")
    entries = tuple(from_plain(Entry, entry, f"{where}, entry {k}") for k, entry in enumerate(item["entries"]))
    given = item["motion"]
    if motion_class is Motion and isinstance(given, dict):
        given = {"path": _UNNAMED_PATH, **given}
    motion = from_plain(motion_class, given, where)
    return ProofData(kind, names[0], names[1], hashes, model, motion, margin, entries)


def _check_suffix(path: Path) -> None:
    if path.suffix not in (".json", ".npz"):
        raise PlannercheckError("must end in .json or .npz")


def _from_json(path: Path) -> Any:
    try:
        return json.loads(read_bytes(path), object_pairs_hook=object_of)
    except PlannercheckError:
        raise
    except (ValueError, RecursionError) as error:
        raise PlannercheckError(f"is no JSON, or is cut off: {kind_of(path) or error}") from None


def _from_npz(path: Path) -> Any:
    read_bytes(path)  # says what is wrong with a file that can't be opened
    try:
        _check_unpacked(path)
        with np.load(path, allow_pickle=False) as file:
            text = str(file["document"])
            return json.loads(text, object_pairs_hook=_array_reader(file))
    except PlannercheckError:
        raise
    except BROKEN_FILE as error:
        raise PlannercheckError(f"is no npz of a proof, or is cut off: {error!s:.200}") from None


def _check_unpacked(path: Path) -> None:
    """Raises if an npz unpacks to more than the limit: each member says to how much, and is read no further."""
    with zipfile.ZipFile(path) as archive:
        size = sum(member.file_size for member in archive.infolist())
    if size > INPUT_LIMITS.archive_bytes:
        raise PlannercheckError(
            f"unpacks to {size} bytes, more than {INPUT_LIMITS.archive_bytes} (INPUT_LIMITS.archive_bytes)"
        )


def _array_reader(file: Any) -> Callable[[Sequence[tuple[str, Any]]], Any]:
    unpacked: dict[str, Any] = {}  # each once, however often the document names it

    def read(pairs: Sequence[tuple[str, Any]]) -> Any:
        node = object_of(pairs)
        if set(node) != {"array"}:
            return node
        name = f"array_{node['array']}"
        if name not in unpacked:
            unpacked[name] = file[name]
        return unpacked[name]

    return read
