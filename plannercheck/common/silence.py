"""Keeps libraries from printing while they work for us, in any number of threads.

In: functions that read and set a library's log level. Out: a context. The level belongs to the whole process, so
contexts are counted: the first one saves the level, the last one restores it. Descriptors stay as they are.
"""

from __future__ import annotations

import ctypes
import ctypes.util
import importlib.metadata
import threading
from collections.abc import Callable
from functools import lru_cache
from typing import Any

# console_bridge::CONSOLE_BRIDGE_LOG_NONE, and its functions as compilers name them.
_BRIDGE_NONE = 4
_BRIDGE_GET, _BRIDGE_SET = "_ZN14console_bridge11getLogLevelEv", "_ZN14console_bridge11setLogLevelENS_8LogLevelE"


class Silence:
    """Silence of one library, for as long as anyone wants it."""

    def __init__(self, get: Callable[[], Any], put: Callable[[Any], object], none: Any) -> None:
        """Nothing changes yet; takes what reads and sets the log level, and that at which nothing is written."""
        self._get, self._put, self._none = get, put, none
        self._lock, self._wanted, self._level = threading.Lock(), 0, None

    def __call__(self) -> Silence:
        """A context within which nothing is written."""
        return self

    def __enter__(self) -> None:
        with self._lock:
            if self._wanted == 0:
                self._level = self._get()
                self._put(self._none)
            self._wanted += 1

    def __exit__(self, *_: object) -> None:
        with self._lock:
            self._wanted -= 1
            if self._wanted == 0:
                self._put(self._level)


@lru_cache(maxsize=1)
def urdf_silence() -> Silence:
    """Silences urdfdom, which writes through console_bridge; if it can't be found, its output stays visible."""
    try:
        bridge = ctypes.CDLL(_bridge_path())
        return Silence(getattr(bridge, _BRIDGE_GET), getattr(bridge, _BRIDGE_SET), _BRIDGE_NONE)
    except (OSError, AttributeError):
        return Silence(lambda: None, lambda level: None, None)


def _bridge_path() -> str:
    """The library that is loaded already: what Pinocchio's wheel brings, by its versioned name, else the system's."""
    try:
        files = importlib.metadata.files("cmeel-console-bridge") or []
    except importlib.metadata.PackageNotFoundError:
        files = []
    brought = [str(file.locate()) for file in files if file.name.startswith("libconsole_bridge.")]
    return max(brought, key=len) if brought else str(ctypes.util.find_library("console_bridge"))
