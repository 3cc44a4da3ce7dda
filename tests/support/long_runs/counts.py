"""What parts of the long runs tell: counts by name, or that a promise is broken."""

from typing import TypeAlias

# Numbers and words by what they count, for the table.
Counts: TypeAlias = "dict[str, int | float | str]"


class BrokenPromiseError(Exception):
    """A promise that did not hold; the message says which one, and for what."""
