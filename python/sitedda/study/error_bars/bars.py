# SPDX-License-Identifier: GPL-3.0-or-later
"""Error bar of a result from three runs with time steps Δt, Δt/2 and Δt/4.

Notes
-----
With results a, b, c, the exact value is within c ± 3 |b − c| if the changes decrease with Δt, even
irregularly because of impacts or of slip that stops (`tests/robustness/error_bars.py`).  Roache
(1994) uses the same factor for two grids of unknown order.
"""

import math
from dataclasses import dataclass

SAFETY = 3.0  # ratio of half the width of the error bar to the last change
SMALL = 1e-3  # smallest half width of an error bar, as a fraction of the result
ROUND_OFF = 1e-9  # changes below this fraction of the result count as 0
ORDER_TOLERANCE = 0.3  # largest difference between the observed order and the order of the scheme


@dataclass(frozen=True)
class Bar:
    """The error bar of a result due to the size of the time step."""

    # Half the width of the bar, in the unit of the result; NaN if it exceeds the result.
    half: float
    # Observed order p: the ratio of successive changes is 2^p; NaN if they do not decrease or are
    # round-off.
    order: float
    # Richardson extrapolation if the observed order is that of the scheme; otherwise NaN.
    extrapolated: float
    # Whether the changes decrease or are round-off.  Otherwise `half` is only a rough estimate.
    converges: bool


def bar_of_steps(a: float, b: float, c: float, order: int) -> Bar:
    """Return the error bar of a result at the finest step.

    `a`, `b`, `c`: the result with Δt, Δt/2 and Δt/4; `order`: that of the time integration, 1 or 2.
    """
    if not all(map(math.isfinite, (a, b, c))):
        return Bar(math.nan, math.nan, math.nan, False)
    magnitude, coarse_change, fine_change = max(map(abs, (a, b, c))), abs(a - b), abs(b - c)
    if max(coarse_change, fine_change) <= ROUND_OFF * magnitude:
        return Bar(SMALL * magnitude, math.nan, c, True)
    if fine_change >= coarse_change:
        half_width = max(SAFETY * fine_change, SMALL * magnitude)
        half_width = half_width if half_width < magnitude else math.nan
        return Bar(half_width, math.nan, math.nan, False)
    # The last change may be small by chance; then the first change determines the width.
    half_width = max(SAFETY * max(fine_change, coarse_change / 4.0**order), SMALL * magnitude)
    observed = math.log2(coarse_change / fine_change) if fine_change > 0 else math.inf
    regular = (a - b) * (b - c) > 0 and abs(observed - order) <= ORDER_TOLERANCE
    extrapolated = c + (c - b) / (2.0**order - 1.0) if regular else math.nan
    return Bar(half_width, observed, extrapolated, True)


def penalty_error(figure: float, stiffer: float) -> float:
    """Return a bound of the error due to the penalty stiffness, from results with k_n and 4 k_n.

    The error is proportional to 1/k_n in elastic contacts, and to 1/√k_n with impacts or beginning
    slip, like the contact time.  The assumption of 1/√k_n is conservative for both.

    `figure`, `stiffer`: results with k_n and with 4 k_n, and otherwise the same input.
    """
    return 2.0 * abs(figure - stiffer)
