"""The engine, as f2py compiled it, with its errors as exceptions."""

from __future__ import annotations

import os

# Threads that wait for each other must not hold a core that another process wants.
os.environ.setdefault("GOMP_SPINCOUNT", "20000")

from ._core import api  # noqa: E402
from .errors import SiteddaError  # noqa: E402

__all__ = ["api", "checked", "version"]


def checked(*result):
    """The values of a call of the engine, without the status and message that end them.

    Raises
    ------
    SiteddaError
        Of the kind that the status names, if it is not 0.
    """
    *values, status, message = result
    if status:
        raise SiteddaError.of(int(status), message.decode("utf-8", "replace").strip())
    if not values:
        return None
    return values[0] if len(values) == 1 else tuple(values)


def version() -> str:
    """Version of the engine, which is that of the package."""
    return api.engine_version().decode().strip()
