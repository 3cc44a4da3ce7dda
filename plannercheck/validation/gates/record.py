"""Records of judgements: all that is needed to judge again, and to see whether robot, scene or version have changed.

In: a checker, a chunk, settings, a verdict as plain data. Out: a record as plain data.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

from plannercheck.common.version import __version__
from plannercheck.motions.checker import Checker
from plannercheck.proofs.hashing import content_hash
from plannercheck.validation.fingerprint import robot_hash, scene_hash
from plannercheck.validation.gates.chunks import Chunk
from plannercheck.validation.gates.settings import GateSettings

# What a record is, by which files are told from others; grows with changes of what its keys mean.
FORMAT = "plannercheck gate 1"


class Hashes:
    """The hashes of a checker's robot and scene, computed when first needed."""

    def __init__(self, checker: Checker) -> None:
        """Takes the checker."""
        self._checker = checker

    @cached_property
    def robot(self) -> dict[str, str]:
        """The robot's name and hash."""
        return {"name": self._checker.robot.name, "hash": robot_hash(self._checker)}

    @cached_property
    def scene(self) -> dict[str, str]:
        """The scene's name and hash."""
        return {"name": self._checker.scene.name, "hash": scene_hash(self._checker)}

    def record(self, chunk: Chunk, settings: GateSettings, verdict: dict[str, Any]) -> dict[str, Any]:
        """A record of one judgement."""
        told = settings.as_json()
        return {
            "format": FORMAT,
            "version": __version__,
            "robot": self.robot,
            "scene": self.scene,
            "settings": {**told, "hash": settings_hash(settings)},
            "chunk": {**chunk_json(chunk), "hash": chunk_hash(chunk)},
            "verdict": verdict,
        }


def chunk_json(chunk: Chunk) -> dict[str, Any]:
    """A chunk as plain data."""
    return {
        **({"times": chunk.times.tolist()} if chunk.rate is None else {"rate": chunk.rate}),
        "positions": chunk.positions.tolist(),
        "start": {"q": chunk.q.tolist(), "dq": chunk.dq.tolist()},
    }


def chunk_hash(chunk: Chunk) -> str:
    """A hash of a chunk's numbers."""
    return content_hash(chunk.times, chunk.positions, chunk.q, chunk.dq)


def settings_hash(settings: GateSettings) -> str:
    """A hash of a gate's settings."""
    return content_hash(*vars(settings).values())
