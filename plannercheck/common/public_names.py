"""Public names of classes and functions, independent of the module that defines them."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

Named = TypeVar("Named")


def set_module(module: str) -> Callable[[Named], Named]:
    """A decorator: errors, reprs and pickles say this module, from which the class or function can be imported."""

    def decorated(item: Named) -> Named:
        item.__module__ = module
        return item

    return decorated
