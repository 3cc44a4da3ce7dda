"""Content hashes of plain data.

In: dataclasses, tuples, arrays, numbers and texts. Out: SHA-256 over their bits, with a tag and a length before each
part, so that different values have different bytes. Names of fields are hashed as well.
"""

from __future__ import annotations

import hashlib
import struct
from dataclasses import is_dataclass
from typing import Any

import numpy as np

from plannercheck.proofs.optional_fields import given_fields


def content_hash(*values: Any) -> str:
    """SHA-256 of values, hexadecimal."""
    digest = hashlib.sha256()
    for value in values:
        _add(digest, value)
    return digest.hexdigest()


def _add(digest: hashlib._Hash, value: Any) -> None:
    match value:
        case np.ndarray():
            digest.update(f"array {value.shape} ".encode() + np.ascontiguousarray(value, dtype="<f8").tobytes())
        case float():
            digest.update(b"float" + struct.pack("<d", value))
        case int():
            digest.update(f"int {value} ".encode())
        case str():
            digest.update(f"text {len(value)} {value}".encode("utf-8", "surrogatepass"))
        case list() | tuple():
            digest.update(f"list {len(value)} ".encode())
            for part in value:
                _add(digest, part)
        case None:
            digest.update(b"none")
        case _ if is_dataclass(value):
            digest.update(f"{type(value).__name__} ".encode())
            for field in given_fields(value):
                _add(digest, getattr(value, field.name))
        case _:
            raise TypeError(f"no plain data: {type(value).__name__}")
