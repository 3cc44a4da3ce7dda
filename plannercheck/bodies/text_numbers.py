"""Numbers of text files, all at once: exact doubles and whole numbers, or None for a text with anything else.

In: bytes. Out: arrays. NumPy's parser of texts is fast and rounds correctly, but skips blanks inside of numbers and, in
older versions, stops at the first word that is no number. So the letters and the count of words are compared as well.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.array_types import Floats, Ints64

_BLANKS = b" \t\r\n\f\v"
_OF_FLOATS = b"0123456789+-.eE" + _BLANKS
_OF_INTEGERS = b"0123456789+-" + _BLANKS

# Longest whole number: with one digit more, it can be beyond 64 bits.
_MOST_DIGITS = 18


def floats_of(text: bytes) -> Floats | None:
    """The finite numbers of a text, (n,); None if one of its words is no finite number."""
    return _floats(text, len(text.split()))


def floats_of_words(words: Sequence[bytes]) -> Floats | None:
    """The finite numbers (n,) that n words are; None if one is none."""
    return _floats(b" ".join(words), len(words))


def integers_of(text: bytes) -> Ints64 | None:
    """The whole numbers of a text, (n,); None if one of its words is none, or takes more than 18 digits."""
    if text.translate(None, _OF_INTEGERS) or text.rstrip().endswith((b"+", b"-")):  # NumPy reads 0 from a last sign
        return None
    numbers = _parsed(text, len(text.split()), np.int64)
    if numbers is None:
        return None
    integers = numbers.astype(np.int64, copy=False)
    return None if (np.abs(integers) >= 10**_MOST_DIGITS).any() else integers


def word_counts(lines: Sequence[bytes]) -> Ints64:
    """How many words each line has, (n,)."""
    return np.fromiter((len(line.split()) for line in lines), dtype=np.int64, count=len(lines))


def pieces_of(values: Floats, starts: Ints64, lengths: Ints64) -> Floats:
    """Pieces of an array, one after the other: from each of some places, so many values."""
    if len(lengths) and (lengths == lengths[0]).all():
        return np.asarray(values[starts[:, None] + np.arange(lengths[0])].reshape(-1))
    steps = np.arange(lengths.sum()) - np.repeat(np.cumsum(lengths) - lengths, lengths)
    return np.asarray(values[np.repeat(starts, lengths) + steps])


def filled_lines(content: bytes, first: int = 1) -> tuple[list[bytes], list[int]]:
    """The lines with something on them, and their numbers."""
    lines = content.splitlines()
    if all(map(bytes.strip, lines)):
        return lines, list(range(first, first + len(lines)))
    kept = [(k, line) for k, line in enumerate(lines, first) if line.strip()]
    return [line for _, line in kept], [k for k, _ in kept]


def first_bad(words: Sequence[bytes]) -> int:
    """Which of some texts is the first that is not made of finite numbers; -1 if all are."""
    return next((k for k, word in enumerate(words) if floats_of(word) is None), -1)


def shown(text: bytes) -> str:
    """A piece of a file for an error, in quotes, cut if it is long."""
    words = text.decode("utf-8", errors="replace").strip()
    return repr(words if len(words) <= 80 else words[:77] + "...")


def _floats(text: bytes, words: int) -> Floats | None:
    if text.translate(None, _OF_FLOATS):
        return None
    numbers = _parsed(text, words, np.float64)
    return None if numbers is None or not np.isfinite(numbers).all() else numbers.astype(np.float64, copy=False)


def _parsed(text: bytes, words: int, kind: type[np.generic]) -> NDArray[np.generic] | None:
    if not words:  # NumPy reads a number from blanks
        return np.zeros(0, dtype=kind)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # what older versions say of what they skip
            numbers = np.fromstring(text, dtype=kind, sep=" ")
    except ValueError:
        return None
    return numbers if len(numbers) == words else None
