# SPDX-License-Identifier: GPL-3.0-or-later
"""Fit the amplification of a suite over rock intensity, for hazard analyses."""

from __future__ import annotations

import re
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..base.arguments import first_of, positive
from ..base.errors import InputError
from ..base.files import write
from .suites import Suite

if TYPE_CHECKING:
    import xarray as xr

G = 9.80665  # m/s²
_FEWEST = 10  # smallest number of cases at a period for a fit
_BEYOND = 0.05  # largest part of a rate beyond the hazard curve without a warning
_KERNEL = 0.5  # half-width in ln Sa of the window of σ
_CORNERS = np.geomspace(0.01, 10.0, 61)  # trial values of f₃ / median Sa


@dataclass(frozen=True)
class AmplificationTable:
    """Median and σ of ln AF given Sa of the rock at the same period.

    Attributes
    ----------
    table : xarray.Dataset
        ``median`` and ``sigma_ln`` over ``level`` (Sa of the rock, m/s²) and ``period`` (s; 0 is
        PGA); NaN where no case is near.  ``coefficients`` f₁, f₂, f₃ of each period, ``count``.
    """

    table: xr.Dataset

    def hazard(self, period: float, levels, rates, wanted) -> NDArray[np.float64]:
        """Compute rates of exceedance at the surface by convolution with the rock hazard curve.

        Parameters
        ----------
        period : float
            s, one of the table's.
        levels, rates : array_like, shape (n,)
            Sa of the rock (m/s²), which increases, and its rates of exceedance (1/year).  Beyond
            the last level, the rock is taken to have this level; a warning reports if this part
            of a rate is above 5 %.
        wanted : array_like, shape (m,)
            Sa of the surface, m/s².

        Returns
        -------
        ndarray, shape (m,)
            1/year.

        References
        ----------
        Bazzurro, P. & Cornell, C. A. (2004). Nonlinear soil-site effects in probabilistic
        seismic-hazard analysis. BSSA 94(6), 2110-2123.
        """
        from scipy.special import ndtr

        levels, rates, wanted = _hazard_curve(levels, rates, wanted)
        part = self.table.sel(period=period)
        valid = np.isfinite(part["median"].values)
        logs = np.log(part.level.values[valid])
        fine = np.geomspace(np.min(levels), np.max(levels), 2000)
        rate = np.exp(np.interp(np.log(fine), np.log(levels), np.log(rates)))
        middle = np.append(np.sqrt(fine[1:] * fine[:-1]), fine[-1])
        rate_steps = np.append(-np.diff(rate), rate[-1])
        median = np.interp(np.log(middle), logs, np.log(part["median"].values[valid]))
        sigma = np.interp(np.log(middle), logs, part.sigma_ln.values[valid])
        excess = np.log(wanted[:, None] / middle) - median
        parts = ndtr(-excess / np.maximum(sigma, 1e-9)) * rate_steps
        result = parts.sum(axis=1)
        beyond = parts[:, -1] / np.maximum(result, np.finfo(float).tiny)
        if beyond.max() > _BEYOND:
            warnings.warn(f"{100 * beyond.max():.0f} % of the rate of {wanted[beyond.argmax()]:g} "
                          f"m/s² come from rock motions above the last level, {levels[-1]:g} "
                          "m/s²: extend the hazard curve", stacklevel=2)  # fmt: skip
        return result

    def to_openquake(self, file, code: str = "A", vs30: float = 760.0) -> Path:
        """Write the amplification functions for OpenQuake: levels in g, PGA and SA(T), sigmas.

        Parameters
        ----------
        file : path
        code : str
            ``ampcode`` of the site, at most 4 letters and digits.
        vs30 : float
            Mean S-wave velocity of the rock, m/s: ``vs30_ref``.
        """
        import pandas as pd

        if not re.fullmatch(r"[A-Za-z0-9]{1,4}", code):
            raise InputError(f"code = {code!r}: give 1 to 4 letters and digits")
        table = self.table
        complete = np.isfinite(table["median"]).all("period").values
        if not complete.any():
            raise InputError("no level has nearby cases at all periods: choose fewer levels, or "
                             "scale the motions to more levels")  # fmt: skip
        names = ["PGA" if p == 0 else f"SA({p:g})" for p in table.period.values]
        numbers = np.hstack([table.level.values[:, None] / G, table["median"], table.sigma_ln])
        heads = ["level", *names, *(f"sigma_{name}" for name in names)]
        rows = pd.DataFrame(numbers[complete], columns=heads)
        rows.insert(0, "ampcode", code)
        text = rows.to_csv(index=False, float_format="%.6g", lineterminator="\n")
        return write(Path(file), f'#,,"vs30_ref={vs30:g}"\n{text}', "a table")


def _hazard_curve(levels, rates, wanted):
    """Return the values of a hazard curve, and the wanted Sa, as checked arrays."""
    levels, rates = positive("levels", levels), positive("rates", rates)
    if levels.ndim != 1 or levels.shape != rates.shape or levels.size < 2:
        raise InputError(f"give one rate for each level, two or more, not {rates.size} for "
                         f"{levels.size}")  # fmt: skip
    if np.any(falls := np.diff(levels) <= 0):
        raise InputError(f"levels must increase: see {first_of(levels[1:], falls):g} m/s²")
    if np.any(rises := np.diff(rates) > 0):
        raise InputError(f"rates must not increase: see {first_of(rates[1:], rises):g} per year")
    return levels, rates, np.atleast_1d(positive("wanted", wanted))


def amplification_table(
    suite: Suite, levels: Sequence[float], analysis: str = "equivalent-linear", pga: bool = True
) -> AmplificationTable:
    """Fit amplification over the intensity of the rock to a suite at several levels.

    ln AF = f₁ + f₂ ln((Sa + f₃)/f₃) with Sa of the rock at the same period, by least squares
    (Stewart et al. 2014); σ is the root of the mean square of the residuals in a window of ±0.5 in
    ln Sa about a level.

    Parameters
    ----------
    suite : Suite
        Suite with motions at several levels.
    levels : sequence of float
        Sa of the rock, m/s².  A level that the motions do not reach gets NaN.
    analysis : str
        Analysis of the suite.
    pga : bool
        The shortest period of the suite, at most 0.05 s, represents PGA.

    Raises
    ------
    InputError
        If the suite has too few cases.

    References
    ----------
    Stewart, J. P., Afshari, K. & Hashash, Y. M. A. (2014). Guidelines for performing
    hazard-consistent one-dimensional ground response analysis. PEER report 2014/16.
    """
    import xarray as xr

    levels = np.asarray(levels, dtype=float)
    if levels.ndim != 1 or not np.all(levels > 0) or not np.all(np.diff(levels) > 0):
        raise InputError("levels must be above 0 and increase, m/s²")
    if analysis not in suite.table.analysis.values:
        raise InputError(f"analysis = {analysis!r}: the suite has "
                         + ", ".join(suite.table.analysis.values))  # fmt: skip
    part = suite.table.sel(analysis=analysis)
    rock, factor = xr.broadcast(part.reference, part.amplification)
    cases = {"case": [d for d in factor.dims if d != "period"]}
    rock, factor = (v.stack(cases).transpose("period", "case").values for v in (rock, factor))
    periods = part.period.values.copy()
    if pga and periods.min() <= 0.05:
        periods[periods.argmin()] = 0.0
    fits = [_fit_period(r, a, levels) for r, a in zip(rock, factor, strict=True)]
    median, sigma, numbers, count = (np.array(values) for values in zip(*fits, strict=True))
    level = ("level", levels, {"units": "m/s^2"})
    return AmplificationTable(xr.Dataset(
        {
            "median": (("level", "period"), median.T),
            "sigma_ln": (("level", "period"), sigma.T),
            "coefficients": (("period", "coefficient"), numbers),
            "count": ("period", count),
        },
        {"level": level, "period": periods, "coefficient": ["f1", "f2", "f3"]},
    ))  # fmt: skip


def _fit_period(rock, factor, levels):
    """Return median and σ at levels, coefficients and number of cases of a period."""
    valid = np.isfinite(factor) & (factor > 0)
    x, y = rock[valid], np.log(factor[valid])
    if x.size < _FEWEST:
        raise InputError(f"only {x.size} cases succeed at a period: a fit needs {_FEWEST}")
    varies = np.ptp(np.log(x)) > 0.1  # with one level, no dependence can be fitted

    def fit(corner):
        basis = np.column_stack([np.ones(x.size), varies * np.log((x + corner) / corner)])
        coefficients = np.linalg.lstsq(basis, y, rcond=None)[0]
        square_sum = float(np.sum((basis @ coefficients - y) ** 2))
        return square_sum, *map(float, coefficients), float(corner)

    _, *best = min(map(fit, np.median(x) * (_CORNERS if varies else np.ones(1))))
    median = best[0] + best[1] * np.log((levels + best[2]) / best[2])
    residual = y - best[0] - best[1] * np.log((x + best[2]) / best[2])
    is_near = np.abs(np.log(x[None, :] / levels[:, None])) <= _KERNEL
    count = is_near.sum(axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        freedom = max(x.size - 3, 1) / x.size  # fitted: two coefficients and f₃
        sigma = np.sqrt((is_near * residual**2).sum(axis=1) / count / freedom)
    is_sparse = count < _FEWEST
    median, sigma = np.where(is_sparse, np.nan, median), np.where(is_sparse, np.nan, sigma)
    return np.exp(median), sigma, best, x.size
