"""Methods whose compiled twin is asked first.

In: a method; the slot in which each object keeps a compiled function of the same arguments. Out: the method. A call
with positional arguments makes no Python frame if the compiled function returns anything but None.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from plannercheck.common.core import core

Method = TypeVar("Method", bound=Callable[..., Any])


def compiled_first(slot: str, arguments: int, *values: object) -> Callable[[Method], Method]:
    """Decorates a method.

    Args:
        slot: One of the `__slots__` of the method's class, in which an object has the compiled function, or None;
            without it, the method is called.
        arguments: Number of arguments of a call, besides the object, for which that function is asked, unless one of
            them is None.
        values: More arguments for it, after those of the call.

    Returns:
        The decorator. `__wrapped__` of what it returns is the method itself.
    """

    def decorated(method: Method) -> Method:
        descriptor = core.CompiledFirst  # type: ignore[attr-defined]  # no class of nanobind's: not in the stub
        return cast(Method, descriptor(method, slot, arguments, values))

    return decorated
