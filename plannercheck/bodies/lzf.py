"""LZF, the compression of PCD files: literal runs, and copies of earlier output.

In: packed bytes and the size that they must unpack to. Out: the bytes. After a control byte c below 32, c + 1 literal
bytes follow. A larger control byte has a length in its upper three bits (7: a byte of more length follows) and the
upper five bits of a distance; the lower eight bits follow. (liblzf by Marc Lehmann, lzf_d.c; PCL's io/src/lzf.cpp.)
"""

from __future__ import annotations

from plannercheck.common.errors import PlannercheckError

_LITERALS = 32
_LONG = 7


def unpacked(packed: bytes, size: int) -> bytes:
    """The `size` bytes that `lzf_compress` has packed.

    Raises:
        PlannercheckError: If they are not as many, or the packed bytes end within a copy or copy what is not there.
    """
    out, at, end = bytearray(), 0, len(packed)
    try:
        while at < end:
            control = packed[at]
            at += 1
            if control < _LITERALS:
                out += packed[at : at + control + 1]
                at += control + 1
                continue
            length = control >> 5
            if length == _LONG:
                length += packed[at]
                at += 1
            distance = ((control & 0x1F) << 8) + packed[at] + 1
            at += 1
            _copy(out, distance, length + 2)
            if len(out) > size:
                break
    except IndexError:
        at = end + 1
    if at > end or len(out) != size:
        raise PlannercheckError(f"its packed data is broken: it does not unpack to {size} bytes")
    return bytes(out)


def _copy(out: bytearray, distance: int, length: int) -> None:
    """Appends bytes from a distance back, which may run into those that are being appended."""
    start = len(out) - distance
    if start < 0:
        raise IndexError(distance)
    if distance >= length:
        out += out[start : start + length]
    else:
        period = out[start:]
        out += (period * (length // distance + 1))[:length]
