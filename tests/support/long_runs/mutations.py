"""Mutations of files: texts whose tokens and lines are changed, and bytes that are damaged.

In: content, random numbers. Out: other content, mostly broken in one to three places. What a number is replaced by
covers what readers trip over: no number, too long for a double, denormal, infinite, of another type.
"""

import re

import numpy as np

# What numbers and words are replaced by.
VALUES = (
    *("0", "-0", "-1", "1", "2", "1e-320", "1e308", "-1e308", "1e400", "1e999999999", "nan", "NaN", ".nan"),
    *("inf", "Infinity", "-.inf", "9999999999999999999999", "9" * 400, "-" + "9" * 400, "9" * 5000, "0x10", "1_0"),
    *("1:30", "2026-02-30", "2026-11-22", "null", "true", "[]", "{}", "[[]]", "''", '""', "~", "[1,2]", "{x:", "1}"),
    *("-", ":", "&", "*", "!", "!!binary", "<<", "world", "name", "é", "\\", "\x00", "\x1b", "\ufeff", "%", "../x"),
)
_TOKEN = re.compile(rb"[-+.\w]+")

# Most bytes that one change flips, exchanges or adds.
_STRETCH = 64


def mutated_text(text: bytes, rng: np.random.Generator) -> bytes:
    """A text with some tokens replaced, lines dropped, doubled, indented or moved, or bytes changed."""
    for _ in range(int(rng.integers(1, 4))):
        kind = int(rng.integers(11))
        if kind < 6:
            text = _other_token(text, rng)
        elif kind < 10:
            lines = text.split(b"\n")
            k = int(rng.integers(len(lines)))
            moved = lines[int(rng.integers(len(lines)))]
            lines[k : k + 1] = [[], [lines[k]] * 2, [b"  " + lines[k]], [moved]][kind - 6]
            text = b"\n".join(lines)
        else:
            text = damaged(text, rng)
    return text


def _other_token(text: bytes, rng: np.random.Generator) -> bytes:
    tokens = [match.span() for match in _TOKEN.finditer(text)]
    if not tokens:
        return text
    start, end = tokens[int(rng.integers(len(tokens)))]
    if rng.integers(4):
        new = VALUES[int(rng.integers(len(VALUES)))].encode()
    else:  # one of the file's own: a name of something else, a number that is out of place
        other = tokens[int(rng.integers(len(tokens)))]
        new = text[slice(*other)]
    return text[:start] + new + text[end:]


def damaged(content: bytes, rng: np.random.Generator) -> bytes:
    """Content with one kind of damage: bits flipped, cut, stretches exchanged, zeroed or added, bytes replaced."""
    data, size = bytearray(content), len(content)
    if not size:
        return rng.bytes(8)
    at = int(rng.integers(size))
    match int(rng.integers(7)):
        case 0:
            for place in rng.integers(size, size=int(rng.integers(1, 9))):
                data[place] ^= 1 << int(rng.integers(8))
        case 1:
            del data[at:]
        case 2:
            _exchange(data, at, int(rng.integers(size)), int(rng.integers(1, _STRETCH)))
        case 3:
            data += rng.bytes(int(rng.integers(1, _STRETCH)))
        case 4:
            data[at:at] = rng.bytes(int(rng.integers(1, _STRETCH)))
        case 5:
            data[at : at + _STRETCH] = bytes(len(data[at : at + _STRETCH]))
        case _:
            for place in rng.integers(size, size=int(rng.integers(1, 6))):
                data[place] = int(rng.choice([0, 1, 127, 128, 255]))
    return bytes(data)


def _exchange(data: bytearray, a: int, b: int, length: int) -> None:
    """Exchanges two stretches, as far as they neither meet nor pass the end."""
    a, b = min(a, b), max(a, b)
    length = min(length, b - a, len(data) - b)
    data[a : a + length], data[b : b + length] = data[b : b + length], data[a : a + length]
