"""Libraries that come with an extra of the package: one error where such a library is missing."""

from __future__ import annotations

import importlib
from typing import Any

from plannercheck.common.errors import PlannercheckError


def extra_module(module: str, extra: str, purpose: str) -> Any:
    """Imports a library, e.g. "pyarrow.parquet", of an extra in pyproject.toml, for a purpose, e.g. "parquet files".

    Raises:
        PlannercheckError: If it is not installed; the message has the command that installs it.
    """
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise PlannercheckError(
            f"{purpose} need {module.partition('.')[0]}, which is not installed ({error}): "
            f"pip install 'plannercheck[{extra}]'"
        ) from None
