# SPDX-License-Identifier: GPL-3.0-or-later
"""Error bar of a result from three runs with time steps Δt, Δt/2 and Δt/4.

Notes
-----
3 |b − c| contains the exact value if changes decrease with the time step, even irregularly, as with
impacts and slip that stops (`tests/robustness/error_bars.py`).  Roache (1994) uses the same factor
for two grids of unknown order.
"""

import math
from dataclasses import dataclass

SAFETY = 3.0  # width of an error bar over the last change
SMALL = 1e-3  # narrowest error bar, as a fraction of the result
ROUND_OFF = 1e-9  # smaller changes, as a fraction of the result, count as 0
NEAR = 0.3  # tolerance of the observed order around the order of the scheme


@dataclass(frozen=True)
class Bar:
    """The error bar of a result with respect to infinitely small time steps.

    Attributes
    ----------
    half : float
        Half the width of the bar, in the unit of the result; NaN if it exceeds the result.
    order : float
        p of the changes, which decrease by 2^p; NaN if they do not decrease or are round-off.
    extrapolated : float
        The Richardson value if the order is that of the scheme; otherwise NaN.
    converges : bool
        Whether the changes decrease or are round-off.  Otherwise the bar is only a guess.
    """

    half: float
    order: float
    extrapolated: float
    converges: bool


def bar_of_steps(a: float, b: float, c: float, order: int) -> Bar:
    """Return the error bar of a result at the finest step.

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
    # The last change may be small by chance; then the first change counts.
    half = max(SAFETY * max(last, first / 4.0**order), SMALL * size)
    seen = math.log2(first / last) if last > 0 else math.inf
    regular = (a - b) * (b - c) > 0 and abs(seen - order) <= NEAR
    extrapolated = c + (c - b) / (2.0**order - 1.0) if regular else math.nan
    return Bar(half, seen, extrapolated, True)


def penalty_error(figure: float, stiffer: float) -> float:
    """Return the error of a result by its penalty stiffness k_n, from the result with 4 k_n.

    The error of elastic contacts is s/k_n.  With impacts or beginning slip, it is s/√k_n, like the
    contact time and its slip.  The bound r = r∞ + s/√k_n holds for both.

    Parameters
    ----------
    figure, stiffer : float
        With k_n and with 4 k_n, all else alike.
    """
    return 2.0 * abs(figure - stiffer)
