"""Padding: distances that pairs of bodies have to keep.

In: one distance in m for all pairs, or lengths by name: shares of links, obstacles or bodies, and distances of pairs of
these. Out: `PaddedPairs`: each body's share, by which it is inflated. The distance of a pair must exceed the sum of
both bodies' shares. Points and faces stay as they are, and the test adds inflation radii without rounding, so padded
verdicts are as exact as others. One rounding to a double remains: the sum of a share and the inflation radius of a ball
or capsule.

A pair with its own distance gets copies of its bodies, each with half the distance. A checker for a later scene sets
aside the entries that do not fit that scene: a missing name, or a pair that the scene does not test, such as a hand and
the object that it now carries.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.shapes import GeometryObject
from plannercheck.common.array_types import Ints
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.real_numbers import positive_number

Padding: TypeAlias = float | Mapping[str, float] | Mapping[str | tuple[str, str], float]


class PaddedPairs(NamedTuple):
    """Bodies and pairs with their padding.

    Attributes:
        bodies: The given bodies, then copies for pairs with a distance of their own.
        labels: The link or obstacle of each.
        shares: (bodies,) each body's share, m.
        pairs: The given tables (k, 2), with indices of copies where pairs have a distance of their own.
    """

    bodies: tuple[GeometryObject, ...]
    labels: tuple[str, ...]
    shares: NDArray[np.float64]
    pairs: tuple[Ints, ...]


def padded_pairs(
    padding: Padding, bodies: Sequence[GeometryObject], labels: Sequence[str], tables: Sequence[Ints]
) -> PaddedPairs:
    """Distributes padding among bodies.

    Args:
        padding: The distance that every pair keeps, m; or lengths by name. A body's part is its own, else its link's or
            obstacle's, else 0; a pair keeps the sum of both shares. A pair of names (of bodies, links or obstacles, in
            any order) has the whole distance of these pairs, whatever the shares; if several fit a pair, the last one
            counts.
        bodies: All bodies.
        labels: The link or obstacle of each.
        tables: Tables of pairs, (k, 2) indices into bodies each.

    Returns:
        Bodies and pairs.

    Raises:
        PlannercheckError: If a length is negative or not finite, a name is unknown, or a pair is never tested.
    """
    if not isinstance(padding, Mapping):
        shares = [_checked(padding, "padding") / 2] * len(bodies)
        return PaddedPairs(tuple(bodies), tuple(labels), np.array(shares, dtype=np.float64), tuple(tables))
    own = padding_shares({name: length for name, length in padding.items() if isinstance(name, str)}, bodies, labels)
    distances = {pair: length for pair, length in padding.items() if not isinstance(pair, str)}
    copies = _Copies(bodies, labels, own)
    for pair, length in distances.items():
        _check_pair(pair, bodies, labels, tables)
        _checked(length, f"padding of {pair!r}")
    rewritten = tuple(_rewritten(table, distances, bodies, labels, copies) for table in tables)
    return PaddedPairs(tuple(copies.bodies), tuple(copies.labels), np.array(copies.shares, dtype=np.float64), rewritten)


def padding_that_fits(
    padding: Padding, bodies: Sequence[GeometryObject], labels: Sequence[str], tables: Sequence[Ints]
) -> Padding:
    """The entries of a padding whose names a scene has, and whose pairs it tests; arguments as for `padded_pairs`."""
    if not isinstance(padding, Mapping):
        return padding
    names = _names(bodies, labels)

    def fits(entry: str | tuple[str, str]) -> bool:
        return entry in names if isinstance(entry, str) else _is_tested(entry, bodies, labels, tables)

    return {entry: length for entry, length in padding.items() if fits(entry)}


def padding_shares(
    padding: Mapping[str, float], bodies: Sequence[GeometryObject], labels: Sequence[str]
) -> list[float]:
    """Each body's part, m: its own, else its link's or obstacle's, else 0."""
    _check_names(padding, bodies, labels)
    shares = {name: _checked(length, f"padding of {name!r}") for name, length in padding.items()}
    return [shares.get(body.name, shares.get(label, 0.0)) for body, label in zip(bodies, labels, strict=True)]


class _Copies:
    """Bodies, and copies of them with other parts, one copy for each body and part."""

    def __init__(self, bodies: Sequence[GeometryObject], labels: Sequence[str], shares: Sequence[float]) -> None:
        self.bodies, self.labels, self.shares = list(bodies), list(labels), list(shares)
        self._known = {(k, share): k for k, share in enumerate(shares)}

    def with_share(self, body: int, share: float) -> int:
        """The index of the copy of a body that is inflated by a share."""
        if (body, share) not in self._known:
            self._known[body, share] = len(self.bodies)
            self.bodies.append(self.bodies[body])
            self.labels.append(self.labels[body])
            self.shares.append(share)
        return self._known[body, share]


def _rewritten(
    table: Ints,
    distances: Mapping[tuple[str, str], float],
    bodies: Sequence[GeometryObject],
    labels: Sequence[str],
    copies: _Copies,
) -> Ints:
    """A table with copies where pairs have a distance of their own."""
    out = table.copy()
    chosen = {row: length for pair, length in distances.items() for row in _rows_of(pair, bodies, labels, table)}
    for row, length in chosen.items():
        out[row] = [copies.with_share(body, length / 2) for body in table[row].tolist()]
    out.flags.writeable = False
    return out


def _names(bodies: Sequence[GeometryObject], labels: Sequence[str]) -> set[str]:
    return {*labels, *(body.name for body in bodies)}


def _check_names(given: Iterable[str], bodies: Sequence[GeometryObject], labels: Sequence[str]) -> None:
    """Raises for unknown names, and for those of a body of one link or obstacle and of another one."""
    names = _names(bodies, labels)
    for name in given:
        if name not in names:
            raise unknown_name("padded body, link or obstacle", name, sorted(names))
        meant = {label for body, label in zip(bodies, labels, strict=True) if name in (body.name, label)}
        if len(meant) > 1:
            other = min(meant - {name})
            raise PlannercheckError(
                f"padding of {name!r} would count twice, for it and for a body of {other!r} of that name: rename one"
            )


def _check_pair(pair: object, bodies: Sequence[GeometryObject], labels: Sequence[str], tables: Sequence[Ints]) -> None:
    if not isinstance(pair, tuple) or len(pair) != 2 or not all(isinstance(name, str) for name in pair):
        raise PlannercheckError(f"padding is for a name or a pair of names, not {pair!r}")
    _check_names(pair, bodies, labels)
    if not _is_tested(pair, bodies, labels, tables):
        raise PlannercheckError(
            f"padding of {pair!r}: no such pair is tested, as both are on one link or allowed to touch"
        )


def _is_tested(
    pair: tuple[str, str], bodies: Sequence[GeometryObject], labels: Sequence[str], tables: Sequence[Ints]
) -> bool:
    return any(True for table in tables for _ in _rows_of(pair, bodies, labels, table))


def _rows_of(
    pair: tuple[str, str], bodies: Sequence[GeometryObject], labels: Sequence[str], table: Ints
) -> Iterator[int]:
    """Rows of a table whose bodies a pair of names means."""
    meant = [{k for k, body in enumerate(bodies) if name in (body.name, labels[k])} for name in pair]
    for row, (a, b) in enumerate(table.tolist()):
        if (a in meant[0] and b in meant[1]) or (a in meant[1] and b in meant[0]):
            yield row


def _checked(length: float, what: str) -> float:
    return positive_number(length, f"{what} must be a length in m of at least 0", or_zero=True)
