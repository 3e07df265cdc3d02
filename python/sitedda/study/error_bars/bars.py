# SPDX-License-Identifier: GPL-3.0-or-later
"""Error of a figure from three runs with time steps Δt, Δt/2 and Δt/4.

Notes
-----
3 |b − c| contains the truth where changes fall with the time step, also where they fall
irregularly, as those of impacts and of slip that stops do (`tests/robustness/error_bars.py`).
Roache (1994) has the same factor for two grids whose order is not known.
"""

import math
from dataclasses import dataclass

SAFETY = 3.0  # of a bar over the last change
SMALL = 1e-3  # fraction of a figure: the narrowest bar
ROUND_OFF = 1e-9  # fraction of a figure: a smaller change counts as none
NEAR = 0.3  # of the order of the scheme: tolerance of the observed order


@dataclass(frozen=True)
class Bar:
    """How far a figure may be from that of infinitely small steps.

    Attributes
    ----------
    half : float
        Half the width of the bar, in the unit of the figure; NaN if it would be wider than that.
    order : float
        p of the changes, which fall by 2^p; NaN where they do not fall or are round-off.
    extrapolated : float
        The Richardson value, where the order is the scheme's; else NaN.
    converges : bool
        The changes fall or are round-off.  However small, a bar of changes that do not fall is a
        guess.
    """

    half: float
    order: float
    extrapolated: float
    converges: bool


def bar_of_steps(a: float, b: float, c: float, order: int) -> Bar:
    """The bar of a figure at the finest step.

    Parameters
    ----------
    a, b, c : float
        The figure at Δt, Δt/2 and Δt/4.
    order : int
        Of the time integration: 1 or 2.
    """
    if not all(map(math.isfinite, (a, b, c))):
        return Bar(math.nan, math.nan, math.nan, False)
    size, first, last = max(map(abs, (a, b, c))), abs(a - b), abs(b - c)
    if max(first, last) <= ROUND_OFF * size:
        return Bar(SMALL * size, math.nan, c, True)
    if last >= first:
        half = max(SAFETY * last, SMALL * size)
        half = half if half < size else math.nan
        return Bar(half, math.nan, math.nan, False)
    # The last change may be small by chance; then the first one counts.
    half = max(SAFETY * max(last, first / 4.0**order), SMALL * size)
    seen = math.log2(first / last) if last > 0 else math.inf
    regular = (a - b) * (b - c) > 0 and abs(seen - order) <= NEAR
    extrapolated = c + (c - b) / (2.0**order - 1.0) if regular else math.nan
    return Bar(half, seen, extrapolated, True)


def penalty_error(figure: float, stiffer: float) -> float:
    """Of a figure by its penalty stiffness k_n, from that with 4 k_n.

    Elastic contacts err by s/k_n.  Where contacts hit each other or begin to slip it is s/√k_n, as
    the time in contact and its slip are; the bound is that of the latter, r = r∞ + s/√k_n, and
    holds for both.

    Parameters
    ----------
    figure, stiffer : float
        With k_n and with 4 k_n, all else alike.
    """
    return 2.0 * abs(figure - stiffer)
