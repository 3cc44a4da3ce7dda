"""Exact verdicts in any dimension: a double oracle in integers.

In: two posed bodies, each given by vertices or by halfspaces, and a guess of the deciding ones (from doubles). Out: the
proof of the verdict, in integers.

The idea: only few vertices and halfspaces are active. Solve the game of the active ones exactly (`integers.solve`). The
solution either holds for all vertices and halfspaces, and is the certificate, or one that violates it joins the active
ones. Each round adds something new, so it ends. There are three games:

- vertices against vertices: mixtures that are the same point, or a direction that separates the two hulls;
- vertices against halfspaces: a mixture inside all of them, or multipliers of halfspaces whose sum holds no vertex;
- halfspaces against halfspaces: a point inside all, or multipliers whose sum is 0 · x ≤ -1.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from plannercheck.ndim.integers import Mix, Row, dot, solve
from plannercheck.ndim.posed import Exact, ExactRows, ExactVertices, in_common_unit

# All vertices of bodies with at most this many are active: one large game is cheaper than many small ones.
_FEW_VERTICES = 40


@dataclass(frozen=True)
class ExactSeparation:
    """The proof that two bodies share no point: direction·X > bound for the first, ≤ bound for the second, or ≥ and <.

    Attributes:
        direction: Integers, from the second body to the first.
        rows_p: If the first body is given by halfspaces: multipliers with Σ μ α = -direction.
        rows_r: If the second body is: multipliers with Σ μ α = direction.
    """

    direction: Row
    rows_p: dict[int, int] = field(default_factory=dict)
    rows_r: dict[int, int] = field(default_factory=dict)


@dataclass(frozen=True)
class ExactSharedPoint:
    """The proof that two bodies share a point.

    Attributes:
        point: Integers X, in the common unit, times the denominator.
        denominator: Positive.
        weights_p: If the first body is given by vertices: weights of them, of sum denominator, that mix the point.
        weights_r: The same for the second.
    """

    point: Row
    denominator: int
    weights_p: dict[int, int] = field(default_factory=dict)
    weights_r: dict[int, int] = field(default_factory=dict)


ExactCertificate = ExactSeparation | ExactSharedPoint


@dataclass(frozen=True)
class Guess:
    """A guess from doubles: vertices or halfspaces of each body that decide."""

    active_p: tuple[int, ...] = (0,)
    active_r: tuple[int, ...] = (0,)


def decide(p: Exact, r: Exact, guess: Guess | None = None) -> tuple[ExactCertificate, int]:
    """Decides whether two posed bodies share a point: the certificate, and how many games it took.

    Any guess gives the same verdict.
    """
    in_common_unit(p, r)
    guess = guess or Guess(_all_if_few(p), _all_if_few(r))
    start_p, start_r = guess.active_p or (0,), guess.active_r or (0,)
    if isinstance(p, ExactVertices):
        if isinstance(r, ExactVertices):
            return _vertices_and_vertices(p, r, _unique(start_p), _unique(start_r))
        return _vertices_and_rows(p, r, _unique(start_p), _unique(start_r))
    if isinstance(r, ExactVertices):
        certificate, games = _vertices_and_rows(r, p, _unique(start_r), _unique(start_p))
        return swapped(certificate), games
    return _rows_and_rows(p, r, _unique(start_p), _unique(start_r))


def _all_if_few(body: Exact) -> tuple[int, ...]:
    return tuple(range(len(body))) if isinstance(body, ExactVertices) and len(body) <= _FEW_VERTICES else (0,)


def swapped(certificate: ExactCertificate) -> ExactCertificate:
    """The same certificate with the bodies' parts exchanged."""
    if isinstance(certificate, ExactSeparation):
        return ExactSeparation([-x for x in certificate.direction], certificate.rows_r, certificate.rows_p)
    return ExactSharedPoint(certificate.point, certificate.denominator, certificate.weights_r, certificate.weights_p)


def _unique(indices: Iterable[int]) -> list[int]:
    return list(dict.fromkeys(int(k) for k in indices))


def _vertices_and_vertices(
    p: ExactVertices, r: ExactVertices, active_p: list[int], active_r: list[int]
) -> tuple[ExactCertificate, int]:
    games = 0
    while True:
        games += 1
        columns = [[*p.point(k), 1, 0] for k in active_p]
        columns += [[*(-x for x in r.point(k)), 0, 1] for k in active_r]
        width = len(columns[0]) - 2
        answer = solve(columns, [0] * width + [1, 1])
        if isinstance(answer, Mix):
            return _shared_mixtures(p, answer, active_p, active_r), games
        direction = [-x for x in answer.row[:width]]
        low, high = p.lowest(direction), r.lowest([-x for x in direction])
        if dot(direction, p.point(low)) > dot(direction, r.point(high)):
            return ExactSeparation(direction), games
        _add(active_p, low)
        _add(active_r, high)


def _add(active: list[int], index: int) -> None:
    if index not in active:
        active.append(index)


def _shared_mixtures(p: ExactVertices, mix: Mix, active_p: list[int], active_r: list[int]) -> ExactSharedPoint:
    first = {active_p[k]: w for k, w in mix.weights.items() if k < len(active_p)}
    second = {active_r[k - len(active_p)]: w for k, w in mix.weights.items() if k >= len(active_p)}
    return ExactSharedPoint(mixed(p, first), mix.denominator, first, second)


def mixed(body: ExactVertices, weights: dict[int, int]) -> Row:
    """The sum of posed vertices, weighted."""
    points = [[w * x for x in body.point(k)] for k, w in weights.items()]
    return [sum(column) for column in zip(*points, strict=True)]


def _vertices_and_rows(
    p: ExactVertices, r: ExactRows, active_p: list[int], active_r: list[int]
) -> tuple[ExactCertificate, int]:
    games = 0
    while True:
        games += 1
        answer = solve(*_columns_against_rows(p, r, active_p, active_r))
        if isinstance(answer, Mix):
            weights = {active_p[k]: w for k, w in answer.weights.items() if k < len(active_p)}
            point = mixed(p, weights)
            worst = r.worst(point, answer.denominator)
            if worst is None:
                return ExactSharedPoint(point, answer.denominator, weights), games
            active_r.append(worst)
        else:
            multipliers = {k: -y for k, y in zip(active_r, answer.row, strict=False) if y}
            direction, bound = combined(r, multipliers)
            low = p.lowest(direction)
            if dot(direction, p.point(low)) > bound:
                return ExactSeparation(direction, rows_r=multipliers), games
            active_p.append(low)


def _columns_against_rows(
    p: ExactVertices, r: ExactRows, active_p: list[int], active_r: list[int]
) -> tuple[list[Row], Row]:
    """A mixture's excess over each active row plus its slack is 0, and its weights have sum 1."""
    size = len(active_r)
    columns = [[*(r.excess(j, p.point(k), 1) for j in active_r), 1] for k in active_p]
    columns += [[int(i == j) for i in range(size + 1)] for j in range(size)]
    return columns, [0] * size + [1]


def combined(body: ExactRows, multipliers: dict[int, int]) -> tuple[Row, int]:
    """The weighted sum of halfspaces, which holds the body if the multipliers are not negative."""
    rows = [(w, *body.row(k)) for k, w in multipliers.items()]
    width = len(body.row(0)[0])
    return [sum(w * alpha[k] for w, alpha, _ in rows) for k in range(width)], sum(w * beta for w, _, beta in rows)


def _rows_and_rows(
    p: ExactRows, r: ExactRows, active_p: list[int], active_r: list[int]
) -> tuple[ExactCertificate, int]:
    games = 0
    while True:
        games += 1
        rows = [p.row(k) for k in active_p] + [r.row(k) for k in active_r]
        width = len(rows[0][0])
        answer = solve([[*alpha, beta] for alpha, beta in rows], [0] * width + [-1])
        if isinstance(answer, Mix):
            first = {active_p[k]: w for k, w in answer.weights.items() if k < len(active_p)}
            second = {active_r[k - len(active_p)]: w for k, w in answer.weights.items() if k >= len(active_p)}
            return ExactSeparation(combined(r, second)[0], first, second), games
        point, denominator = answer.row[:width], -answer.row[width]
        over_p, over_r = p.worst(point, denominator), r.worst(point, denominator)
        if over_p is None and over_r is None:
            return ExactSharedPoint(point, denominator), games
        active_p += [] if over_p is None else [over_p]
        active_r += [] if over_r is None else [over_r]
