"""Libraries that come with an extra of the package: one error where such a library is missing."""

from __future__ import annotations

import importlib
from typing import Any

from plannercheck.common.errors import PlannercheckError


def extra_module(module: str, extra: str, purpose: str) -> Any:
    """Imports a library of an extra.

    Args:
        module: Its name, e.g. "pyarrow.parquet".
        extra: The extra in pyproject.toml that brings it.
        purpose: What it is needed for, e.g. "parquet files".

    Returns:
        The module.

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
