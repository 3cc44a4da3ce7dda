"""Reads the container of a prepared cell from its description alone (plannercheck/cpp/library/cell_file.hpp).

In: bytes. Out: names and arrays. It shares nothing with the writer.
"""

import binascii

import numpy as np

TYPES = {1: "u1", 2: "<i4", 3: "<f8"}


def number(file: bytes, at: int, size: int) -> int:
    return int.from_bytes(file[at : at + size], "little")


def read_sections(file: bytes) -> list[tuple[str, np.ndarray]]:
    """The sections in their order; asserts everything that the container promises."""
    assert file[:16] == b"plannercheck".ljust(12) + b"\n\0\0\0"
    assert number(file, 24, 8) == len(file)
    assert number(file, 36, 4) == binascii.crc32(file[48:])
    assert number(file, 40, 8) == 0
    count = number(file, 32, 4)
    end, found = 48 + 64 * count, []
    for k in range(count):
        entry = file[48 + 64 * k :][:64]
        name = entry[:32].rstrip(b"\0").decode()
        kind, columns, rows, place = (number(entry, *field) for field in ((32, 4), (36, 4), (40, 8), (48, 8)))
        assert number(entry, 56, 8) == 0
        assert place % 64 == 0
        assert 0 <= place - end < 64
        assert not any(file[end:place])
        values = np.frombuffer(file, TYPES[kind], rows * columns, place)
        found.append((name, values.reshape(rows, columns)))
        end = place + values.nbytes
    assert end == len(file)
    return found
