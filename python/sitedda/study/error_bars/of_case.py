# SPDX-License-Identifier: GPL-3.0-or-later
"""The figures of a case with their bars in place of its run."""

from ..table import BAR, DECIDED
from .figures import COUNTS
from .measure import accuracy


def figures_with_bars(file) -> dict:
    """The figures of the run of an input, how sure each is, and until when, see `accuracy`.

    Parameters
    ----------
    file : path
        Namelist input.

    Returns
    -------
    dict
        Of each figure its value by name, ``NAME_bar`` and ``NAME_decided_s``; counts that are 0;
        ``end_s``, s; ``warning``.
    """
    found = accuracy(file, workers=1)
    numbers: dict = dict.fromkeys(COUNTS, 0.0) | {"end_s": found.end}
    for name, figure in found.figures.items():
        numbers[name] = figure.finest
        numbers[f"{name}{BAR}"], numbers[f"{name}{DECIDED}"] = figure.bar, figure.decided
    return numbers | {"warning": "\n".join(map(str, found.doubts()))}
