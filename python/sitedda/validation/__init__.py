# SPDX-License-Identifier: GPL-3.0-or-later
"""Analytic cases: each with its formula, the engine's figure, the error, and a picture.

``CASES`` holds them by name; ``run_case(name)`` runs one and ``write_report`` writes results
down with their pictures.  From the command line:
``sitedda validate [CASE …] [--report FOLDER]``.
"""

from importlib import import_module
from pkgutil import iter_modules

from .case import CASES, Case, Outcome, Result, Row, Table
from .report import write_report

__all__ = ["CASES", "Case", "Outcome", "Result", "Row", "Table", "run_case", "write_report"]

for _module in iter_modules(__path__):  # those that hold cases register them
    import_module(f"{__name__}.{_module.name}")


def run_case(name: str, short: bool = False) -> Result:
    """Run the case of a name.

    Parameters
    ----------
    name : str
        One of ``CASES``.
    short : bool
        A quicker form with fewer variants and smaller models, as the tests use it.

    Raises
    ------
    KeyError
        If there is no such case.
    """
    if name not in CASES:
        raise KeyError(f"there is no case {name!r}; known are {', '.join(CASES)}")
    return CASES[name].run(short)
