"""Builds proofs of motions in the plane from the certifier's lines.

In: a planar checker, a motion that its certifier proves free. Out: a `Proof`. The certifier's lines become entries as
they are. Where the circles around both bodies are so far apart that the verifier can confirm it, intervals are joined
to one entry by circles.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import groupby
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plannercheck.common.array_types import Bools, Floats, Ints64
from plannercheck.common.arrays import distinct
from plannercheck.common.optional_imports import extra_module
from plannercheck.motions.certifier_answers import Proof as Line
from plannercheck.planar.curves import Curve
from plannercheck.planar.links import GeometryObject
from plannercheck.planar.motion_certifier import MotionCertifier
from plannercheck.planar.robot import Robot
from plannercheck.planar.scene import Scene
from plannercheck.proofs.data import Entry
from plannercheck.proofs.planar_proof import Piece, PlanarBody, PlanarLink, PlanarModel, PlanarMotion
from plannercheck.proofs.proof import Proof

# The error of computed states and poses of two bodies, as a multiple of L (links), A = 1 + all angles, and the size of
# what is posed: twice what `planar_well_formed.py` requires, and an eighth of what the certifier leaves
# (cpp/planar/motion_certifier_2d).
_ROUNDING = 2.0**-46

# Circles are used where their gap is at least this part of both radii, and this many times the distance by which the
# centres leave their chords.
_CLEAR, _CHORD_DEVIATIONS = 0.02, 4.0

# A circle's radius is rounded up by this part of it, and of its centre's coordinates.
_ROOM = 1e-12

# A circle in the world is stretched by its pose, which is rigid up to 1e-6.
_STRETCH = 3e-6


class CertifiedPolygons(Protocol):
    """The parts of a `planar.Checker` from which proofs of motions in the plane are built."""

    robot: Robot
    scene: Scene
    bodies: tuple[GeometryObject, ...]
    pairs: NDArray[np.int32]

    @property
    def motion_certifier(self) -> MotionCertifier:
        """Proves motions free."""

    def body_poses(self, q: ArrayLike) -> Floats:
        """(n, bodies, 3, 3) poses at configurations (n, nq)."""


class PlanarBuilder:
    """Builds proofs for one checker."""

    def __init__(self, checker: CertifiedPolygons) -> None:
        """Reads the checker.

        Raises:
            PlannercheckError: If python-flint is not installed.
        """
        extra_module("flint", "proofs", "proofs of motions")
        from plannercheck.proofs.planar_well_formed import hashes_of

        self._checker = checker
        self._model = planar_model(checker)
        self._hashes = hashes_of(self._model)
        self._centres = np.array([body.centre for body in self._model.bodies])
        self._radii = np.array([body.reach for body in self._model.bodies])

    def proof(
        self,
        start: Floats,
        end: Floats,
        asked_end: Floats,
        tolerance: float,
        pieces: Floats,
        curve: Curve,
        turning_radius: float | None,
    ) -> Proof | None:
        """The proof of one motion, None if the certifier does not find it free.

        From start (nq,) to end (nq,), the short way round to what was asked for; pieces are (k, 11) as for the
        certifier.
        """
        certifier = self._checker.motion_certifier
        result = certifier.motion_result(start, end, tolerance, True, pieces, asked_end)
        if not result.free or result.proved_until < 1:
            return None
        q0, q1, asked = (tuple(q.tolist()) for q in (start, end, asked_end))
        motion = PlanarMotion(q0, q1, asked, curve, float(turning_radius or 0.0), _pieces(pieces))
        parameters = distinct([t for line in result.proofs for t in (line.start, line.end)])
        states = certifier.states(start, end, parameters, pieces)
        margin = self._margin(motion)
        is_clear = self._clear(result.proofs, parameters, states, margin, pieces)
        entries = tuple(_joined(result.proofs, is_clear.tolist()))
        names = self._checker.robot.name, self._checker.scene.name
        return Proof("plane", *names, self._hashes, self._model, motion, margin, entries)

    def _margin(self, motion: PlanarMotion) -> float:
        first = 2 if self._checker.robot.is_free else 0
        anchors = np.array([[link.x, link.y, link.angle] for link in self._model.links])
        robots = [body.vertices for body in self._model.bodies if body.link >= 0]
        size = float(np.hypot(*anchors[:, :2].T).sum())
        size += max((float(np.hypot(*v.T).max()) for v in robots), default=0.0)
        size += max((sum(map(abs, (*p.origin, *p.way, *p.arm))) for p in motion.pieces), default=0.0)
        size += max(sum(map(abs, q[:first])) for q in (motion.start, motion.end))
        angles = 1 + float(np.abs(anchors[:, 2]).sum())
        angles += sum(map(abs, (*motion.start[first:], *motion.asked_end[first:])))
        return _ROUNDING * len(self._model.links) * angles * size

    def _clear(self, lines: Sequence[Line], parameters: Floats, states: Floats, margin: float, pieces: Floats) -> Bools:
        """(n,) where circles are enough, with room for details that are not checked here."""
        poses = self._checker.body_poses(states)
        centres = np.einsum("tbij,bj->tbi", poses[..., :2, :2], self._centres) + poses[..., :2, 2]
        links = self._checker.robot.link_poses(states)
        at = np.searchsorted(parameters, [(line.start, line.end) for line in lines]).reshape(-1, 2)
        a, b = self._checker.pairs[[line.pair for line in lines]].T.astype(np.int64)
        frames = np.array([line.frame for line in lines], dtype=np.int64)
        seen = [self._seen(centres, links, rows, a, b, frames) for rows in at.T]
        chord_deviations = np.array([line.chord_deviation for line in lines])
        radii = self._radii[a] + self._radii[b]
        slip = float(pieces[:, 10].max(initial=0.0))
        return np.asarray(
            _to_origin(*seen) > radii * (1 + _CLEAR) + _CHORD_DEVIATIONS * chord_deviations + 4 * (margin + slip)
        )

    def _seen(self, centres: Floats, links: Floats, rows: Ints64, a: Ints64, b: Ints64, frames: Ints64) -> Floats:
        """(n, 2) from b's centre to a's, seen from a frame."""
        way = centres[rows, a] - centres[rows, b]
        turns = links[rows, np.maximum(frames, 0), :2, :2]
        return np.asarray(np.where((frames >= 0)[:, None], np.einsum("nji,nj->ni", turns, way), way))


def _to_origin(first: Floats, last: Floats) -> Floats:
    """(n,) distances of segments from the origin, m."""
    way = last - first
    square = np.maximum((way**2).sum(axis=1), np.finfo(np.float64).tiny)
    part = np.clip(-(first * way).sum(axis=1) / square, 0, 1)
    return np.asarray(np.linalg.norm(first + part[:, None] * way, axis=1))


def _joined(lines: Sequence[Line], is_clear: Sequence[bool]) -> Iterable[Entry]:
    """Entries by pair, in order; neighbours by circles are joined, except a curve's end, which counts by itself."""
    rows = sorted(zip(lines, is_clear, strict=True), key=lambda row: (row[0].pair, row[0].start, row[0].end))
    key = lambda row: (row[0].pair, row[1], row[0].start == row[0].end)  # noqa: E731
    for (pair, clear, _), group in groupby(rows, key):
        found = [line for line, _ in group]
        if clear:
            yield Entry(pair, found[0].start, found[-1].end, "balls")
            continue
        for line in found:
            yield Entry(pair, line.start, line.end, "plane", line.frame, tuple(line.direction.tolist()))


def _pieces(rows: Floats) -> tuple[Piece, ...]:
    """The pieces of a curve without the last row, which is the end itself."""
    return tuple(
        Piece(r[0], r[1], (r[2], r[3]), (r[4], r[5]), r[6], r[7], (r[8], r[9]), r[10]) for r in rows[:-1].tolist()
    )


def planar_model(checker: CertifiedPolygons) -> PlanarModel:
    """The model of a checker, as plain data."""
    robot = checker.robot
    rows, anchors, columns = robot.core_links()
    links = tuple(
        PlanarLink(link.name, parent, link.joint, column, *anchor)
        for link, (parent, _, column), anchor in zip(robot.links, rows.tolist(), anchors.tolist(), strict=True)
    )
    labels = (*(robot.link_names[body.link] for body in robot.bodies), *checker.scene.body_objects)
    bodies = []
    for body, label in zip(checker.bodies, labels, strict=True):
        low, high = body.vertices.min(axis=0), body.vertices.max(axis=0)
        centre = (low + high) / 2
        reach = float(np.hypot(*(body.vertices - centre).T).max())
        reach += _ROOM * (reach + float(np.abs(centre).sum())) + (_STRETCH * reach if body.link < 0 else 0.0)
        pose = tuple(body.pose[:2].ravel().tolist())
        bodies.append(PlanarBody(body.name, label, body.link, pose, body.vertices, tuple(centre.tolist()), reach))
    pairs = tuple((a, b) for a, b in checker.pairs.tolist())
    whole_turns = tuple(np.flatnonzero(robot.angles).tolist())
    return PlanarModel(links, tuple(bodies), pairs, whole_turns, columns)
