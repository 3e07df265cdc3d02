# SPDX-License-Identifier: GPL-3.0-or-later
"""The task 'accuracy' of a study: results of a case with error bars."""

from ..quantities import NAMES
from ..table import BAR, DECIDED
from .figures import COUNTS
from .measure import accuracy


def figures_with_bars(file) -> dict:
    """Return the results of an input with error bars and horizons, see `accuracy`.

    `file`: namelist input.

    Result: ``NAME``, ``NAME_bar`` and ``NAME_decided_s`` of each result, counts (also if 0),
    ``end_s`` (s), ``warning``.
    """
    results = accuracy(file, workers=1)
    numbers: dict = dict.fromkeys(COUNTS, 0.0) | {"end_s": results.end}
    for name, figure in results.figures.items():
        numbers[name] = figure.finest
        numbers[f"{name}{BAR}"], numbers[f"{name}{DECIDED}"] = figure.bar, figure.decided
    return numbers | {"warning": "\n".join(map(str, results.doubts()))}


figures_with_bars.results = {  # type: ignore[attr-defined]
    "end_s", *(name + more for name in NAMES for more in ("", BAR, DECIDED)),
}  # fmt: skip
