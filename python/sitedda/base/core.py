# SPDX-License-Identifier: GPL-3.0-or-later
"""The engine compiled by f2py; its errors are raised as exceptions."""

import os
import threading
from collections.abc import Callable
from functools import cache
from types import SimpleNamespace

# Waiting threads must not occupy a core that another process needs.
os.environ.setdefault("GOMP_SPINCOUNT", "20000")

from .._core import (  # noqa: E402
    api_host,
    api_inputs,
    api_modes,
    api_motions,
    api_runs,
    api_schemes,
    api_soils,
)
from .errors import SiteddaError  # noqa: E402

api = SimpleNamespace()  # the routines of all files in `api/`
for _topic in (api_host, api_inputs, api_modes, api_motions, api_runs, api_schemes, api_soils):
    vars(api).update((name, getattr(_topic, name)) for name in dir(_topic) if name[0] != "_")

api.hear_python()  # Ctrl-C ends long calls with KeyboardInterrupt

FILES = threading.RLock()  # netCDF is not thread-safe: only one file operation at a time


def checked(routine: Callable, *arguments):
    """Call a routine of the engine and return its result; raise an exception if it fails.

    Raises
    ------
    SiteddaError
        If the status is not 0; the status selects the subclass.
    """
    api.forget_error()
    result = routine(*arguments)
    status, message = api.take_error()
    if status:
        raise SiteddaError.of(int(status), message.decode("utf-8", "replace").strip())
    return result


def version() -> str:
    """Return the version of the engine, which equals the version of the package."""
    return api.engine_version()[0].decode().strip()


__version__ = version()


def commit() -> str:
    """Return the commit from which the engine was built; blank if unknown."""
    return api.engine_version()[1].decode().strip()


@cache
def engine_names(kind: str) -> tuple[str, ...]:
    """Return the names of a kind that the engine defines, such as its energy terms.

    Parameters
    ----------
    kind : str
        ``'energies'``, ``'phases'``, ``'counts'``; ``'maxima'`` with ``'maxima units'`` and
        ``'maxima numbers'``, the words after ``largest_`` and ``residual_`` in verdicts;
        ``'boundary kinds'`` with ``'boundary kinds at rest'``, which replace them in static models,
        and ``'boundary directions'`` of the latter (or 'none').
    """
    return tuple(api.engine_names(kind).decode().split())


@cache
def printing_rules() -> tuple[float, int, str, str]:
    """Return the constants that the program and the native executable use to print verdicts.

    A final value below the first number times the largest value is printed as 0. The others are the
    characters per line, and the hints on the commands `check` and `accuracy`.
    """
    fraction, width, texts = api.printing_rules()
    more_text, bars = texts.decode().strip().splitlines()
    return float(fraction), int(width), more_text, bars


def wrapped(text: str, indent: int = 0, width: int = 0) -> str:
    """Wrap a text to the width of the screen, as the native executable does.

    `indent`: characters before the text on its first line, and blanks before the other lines.
    `width`: characters per line, including the indent; 0: the width of a screen.
    """
    data = " ".join(text.split()).encode()
    size = len(data) + data.count(b" ") * indent + 1
    codes = api.wrapped_text(data, indent, width or printing_rules()[1], size)
    return bytes(codes.astype("u1")).rstrip(b"\0").decode().removesuffix("\n")


def folded(text: str) -> str:
    """Wrap each line of a text to the width of the screen, as the native executable does."""
    return "\n".join(wrapped(line, 6) for line in text.splitlines() if line)


def print_notes(text: str) -> None:
    """Print notes, one per line of a text."""
    for line in filter(None, text.splitlines()):
        print(folded(f"note: {line}"))


def reduced_group(text: str, factor: float) -> dict[str, float]:
    """Return the variables of a &joint or &material with its strength divided by a factor.

    Parameters
    ----------
    text : str
        The group, as in a namelist.
    factor : float
        Above 0.
    """
    names, values = checked(api.reduced_group, text.encode(), factor)
    return dict(zip(names.decode().split(), map(float, values), strict=False))
