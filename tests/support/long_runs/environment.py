"""Where processes of the long runs find plannercheck: where this one found it, whatever folder they work in."""

import os
import sys
from pathlib import Path

import plannercheck

_HOME = str(Path(plannercheck.__file__).resolve().parents[1])
PYTHON = [sys.executable]
_OTHERS = os.environ.get("PYTHONPATH")
ENVIRONMENT = {**os.environ, "PYTHONPATH": os.pathsep.join([_HOME, _OTHERS] if _OTHERS else [_HOME])}
