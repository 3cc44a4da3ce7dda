"""What stops a verification: a sentence, raised where it is found and returned by the verifier."""

from __future__ import annotations


class UnprovedError(Exception):
    """A number or an entry of a proof that is not what it has to be; never leaves the verifier."""
