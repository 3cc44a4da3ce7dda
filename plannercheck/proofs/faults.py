"""The error that stops a verification; the verifier returns its sentence."""

from __future__ import annotations


class UnprovedError(Exception):
    """A wrong number or entry of a proof; the verifier catches it."""
