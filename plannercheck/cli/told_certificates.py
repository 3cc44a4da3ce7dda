"""Certificates of pairs in words and as JSON, for commands that judge paths and trajectories.

In: the verdict of a pair. Out: text, or plain data.
"""

from __future__ import annotations

from typing import Any

from plannercheck import planar
from plannercheck.bodies.certificates import Separation, SharedPoint
from plannercheck.bodies.part_certificates import PartSeparation
from plannercheck.bodies.solid_certificates import Enclosure
from plannercheck.bodies.solid_separations import SolidSeparation
from plannercheck.checking.verdicts import PairVerdict


def certificate_in_words(pair: PairVerdict) -> str:
    """What is proved of a pair, for the terminal."""
    certificate = pair.certificate
    if isinstance(certificate, Separation | planar.Separation):
        return f"apart by at least {certificate.gap:.3g} m along ({_listed(certificate.normal.tolist())})"
    if isinstance(certificate, SolidSeparation | PartSeparation):
        return f"apart by at least {certificate.gap:.3g} m"
    assert isinstance(certificate, SharedPoint | planar.SharedPoint | Enclosure)
    return f"which share the point ({_listed(certificate.point.tolist())})"


def _listed(values: list[float]) -> str:
    return ", ".join(f"{value:.6g}" for value in values)


def certificate_as_json(pair: PairVerdict) -> dict[str, Any]:
    """A pair, its bodies and its certificate."""
    certificate = pair.certificate
    if isinstance(certificate, Separation | planar.Separation):
        proof: dict[str, Any] = {
            "normal": certificate.normal.tolist(),
            "offset": certificate.offset,
            "gap": certificate.gap,
        }
    elif isinstance(certificate, SolidSeparation | PartSeparation):
        proof = {"gap": certificate.gap}
    else:
        assert isinstance(certificate, SharedPoint | planar.SharedPoint | Enclosure)
        proof = {"shared_point": certificate.point.tolist()}
    return {
        "pair": [pair.first, pair.second],
        "bodies": [pair.first_body, pair.second_body],
        "certificate": proof,
    }
