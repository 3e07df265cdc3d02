# SPDX-License-Identifier: GPL-3.0-or-later
"""Fragility curves by maximum likelihood, or bounds of the probability of failure per level."""

from dataclasses import dataclass
from textwrap import wrap

import numpy as np

from ..base.errors import InputError
from ..base.numbers import axis_label, title_and_unit
from .table import DECIDED

_LEAST_DISPERSION, _LARGEST_DISPERSION = 1e-3, 20.0  # smallest and largest dispersion
MATCHED_SCATTER = 0.1  # largest scatter of ln Sa of matched records; natural ones: 0.3 to 0.8


@dataclass(frozen=True, kw_only=True)
class FragilityBounds:
    """Numbers of failures at levels of intensity, and bounds of the probability of failure.

    Attributes
    ----------
    intensity, failures, trials : ndarray, shape (levels,)
        Intensity of each level, and its numbers of failed cases and of all cases.
    confidence : float
        Confidence level of the bounds.
    name, unit : str
        Name and unit of the intensity.
    design : float or None
        Design level of the intensity.
    why : str
        Reason why no curve can be fitted.
    doubt : str
        Warnings about results after their horizon and about spectrally matched records; otherwise
        blank.
    """

    intensity: np.ndarray
    failures: np.ndarray
    trials: np.ndarray
    confidence: float
    name: str = "intensity"
    unit: str = ""
    design: float | None = None
    why: str = ""
    doubt: str = ""

    @property
    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Return lower and upper bounds of the probability at each level (Clopper and Pearson)."""
        from scipy.special import betaincinv

        k, n, tail_probability = self.failures, self.trials, (1 - self.confidence) / 2
        low = np.where(k > 0, betaincinv(k, n - k + 1, tail_probability), 0.0)
        high = np.where(k < n, betaincinv(k + 1, n - k, 1 - tail_probability), 1.0)
        return low, high

    def band(self, intensity) -> tuple[np.ndarray, np.ndarray]:
        """Return bounds at other intensities, if the probability increases with the intensity."""
        level = np.asarray(intensity, dtype=float)[..., None]
        low, high = self.bounds
        return (np.where(self.intensity <= level, low, 0.0).max(-1),
                np.where(self.intensity >= level, high, 1.0).min(-1))  # fmt: skip

    @property
    def words(self) -> str:
        """Return a sentence on the probability of failure at the design level, or largest level."""
        x = self.intensity.max() if self.design is None else self.design
        low, high = self.band(x)
        return (f"No curve: {self.why}. At {self._format_level(x)} the probability of failure is "
                f"between {low:.2g} and {high:.2g}")  # fmt: skip

    def _format_level(self, value: float) -> str:
        return f"{self.name} {value:.3g} {self.unit}".replace("^2", "²").strip()

    def picture(self):
        """Draw the fraction of failures per level, and the curve or bounds; return the figure."""
        from ..report.style import BLUE, INK, ORANGE, canvas

        figure, (axes,) = canvas(1, size=(7.0, 4.6))
        x = np.linspace(0.0, 1.25 * self.intensity.max(), 300)[1:]
        label = f"{self.confidence:.0%} confidence"
        axes.fill_between(x, *self.band(x), color=BLUE, alpha=0.18, lw=0, label=label)
        self._draw_curve(axes, x)
        has_trials = self.trials > 0
        fractions = self.failures[has_trials] / self.trials[has_trials]
        axes.plot(self.intensity[has_trials], fractions, "o", color=INK, ms=5,
                  label="failed cases / cases of the level")  # fmt: skip
        if self.design is not None:
            axes.axvline(self.design, color=INK, ls=":", lw=1, label="design level")
        axes.set(xlabel=axis_label(self.name, self.unit), ylabel="probability of failure",
                 xlim=(0, x[-1]), ylim=(-0.02, 1.02))  # fmt: skip
        axes.legend(frameon=False, loc="best")
        if warning := "; ".join(filter(None, (self.why, self.doubt))):
            axes.set_title("\n".join(wrap(warning, 80)), fontsize=8, color=ORANGE, loc="left")
        return figure

    def _draw_curve(self, axes, x) -> None:
        """Draw no curve; `Fragility` overrides this method."""


@dataclass(frozen=True, kw_only=True)
class Fragility(FragilityBounds):
    """A lognormal fragility curve, P(failure | im) = Φ(ln(im / median) / dispersion).

    Attributes
    ----------
    median : float
        Intensity with a probability of failure of 0.5.
    dispersion : float
        Standard deviation β of the logarithm.
    median_interval, dispersion_interval : (float, float)
        Confidence intervals by the profile likelihood; unbounded ends are 0 or inf.
    covariance : ndarray, shape (2, 2)
        Covariance of ln median and ln dispersion: inverse of the observed information.
    """

    median: float
    dispersion: float
    median_interval: tuple[float, float]
    dispersion_interval: tuple[float, float]
    covariance: np.ndarray

    def probability(self, intensity) -> np.ndarray:
        """Return the probability of failure at intensities."""
        from scipy.special import ndtr

        return ndtr(np.log(np.asarray(intensity) / self.median) / self.dispersion)

    def band(self, intensity) -> tuple[np.ndarray, np.ndarray]:
        """Return bounds of the probability at each intensity by the delta method."""
        from scipy.special import ndtr, ndtri

        z = np.log(np.asarray(intensity, dtype=float) / self.median) / self.dispersion
        slope = np.stack([np.full_like(z, -1 / self.dispersion), -z], axis=-1)
        deviation = np.sqrt(np.einsum("...i,ij,...j", slope, self.covariance, slope))
        half_width = ndtri(0.5 + self.confidence / 2) * deviation
        return ndtr(z - half_width), ndtr(z + half_width)

    @property
    def words(self) -> str:
        """Return a sentence with the margin at the design level, or with the median."""
        if self.design is None:
            low, high = self.median_interval
            return (f"Half of the cases fail at {self._format_level(self.median)} "
                    f"({self.confidence:.0%}: {low:.3g} … {high:.3g})")  # fmt: skip
        verdict = "Stands" if self.median > self.design else "Fails"
        low, high = self.band(self.design)
        return (f"{verdict} at {self._format_level(self.design)}: half of the cases fail at "
                f"{self._format_level(self.median)}, {self.median / self.design:.3g} times the "
                "design level. The probability of failure at the design level is "
                f"{self.probability(self.design):.2g} ({low:.2g} … {high:.2g})"
               )  # fmt: skip

    def _draw_curve(self, axes, x) -> None:
        from ..report.style import BLUE

        axes.plot(x, self.probability(x), color=BLUE, lw=2,
                  label=f"median {self.median:.4g}, β = {self.dispersion:.3g}")  # fmt: skip


def fragility(intensity, failures, trials, confidence: float = 0.95, **metadata) -> Fragility:
    """Fit a lognormal fragility curve by maximum likelihood.

    The number of failures at a level is binomial (Baker 2015, Earthquake Spectra 31(1), 579).

    Parameters
    ----------
    intensity : array_like, shape (levels,)
    failures, trials : array_like of int, shape (levels,)
    confidence : float
        Confidence level of the intervals.
    **metadata
        ``name``, ``unit``, ``design`` and ``doubt`` of `FragilityBounds`.

    Raises
    ------
    InputError
        If the likelihood has no maximum: no case or all cases failed, or all failures are at higher
        levels than all survivals.
    """
    from scipy.optimize import minimize
    from scipy.stats import chi2

    x, k, n = (np.atleast_1d(np.asarray(v, dtype=float)) for v in (intensity, failures, trials))
    _check_counts(x, k, n, confidence)
    _check_maximum_exists(x, k, n)
    tested = n > 0
    start = np.array([np.log(np.average(x[tested], weights=n[tested])), np.log(0.4)])
    fit = minimize(_negative_log_likelihood, start, (x, k, n), method="Nelder-Mead",
                     options={"xatol": 1e-10, "fatol": 1e-12, "maxiter": 4000})  # fmt: skip
    optimum = fit.x
    if not fit.success or not _LEAST_DISPERSION < np.exp(optimum[1]) < _LARGEST_DISPERSION:
        raise InputError("the likelihood has no maximum: the dispersion is not determined")
    covariance = np.linalg.inv(_information_matrix(optimum, x, k, n))
    limit = 0.5 * float(chi2.ppf(confidence, 1))
    medians, dispersions = (_profile_interval(i, optimum, covariance, limit, x, k, n)
                            for i in range(2))  # fmt: skip
    median, dispersion = map(float, np.exp(optimum))
    return Fragility(median=median, dispersion=dispersion, median_interval=medians,
                     dispersion_interval=dispersions, confidence=confidence, covariance=covariance,
                     intensity=x, failures=k, trials=n, **metadata)  # fmt: skip


def fragility_of(
    table, quantity: str, threshold: float, intensity: str, confidence=0.95, design=None
) -> FragilityBounds:
    """Return the fragility curve of a study, or bounds per level if no curve can be fitted.

    Parameters
    ----------
    table : xarray.Dataset
        Results of a study; those of ``task="accuracy"`` contain horizons.
    quantity : str
        Result whose value above the threshold means failure. Cases without this result (failed or
        missing runs) do not count.
    intensity : str
        Dimension of the levels; the other dimensions contain the trials.
    confidence : float
    design : float, optional
        Design level of the intensity.
    """
    values = table[quantity]
    dims = [dim for dim in values.dims if dim != intensity]
    trials = values.notnull().sum(dims).values.astype(float)
    failures = (values > threshold).sum(dims).values.astype(float)
    level = table[intensity]
    warning_texts = (_horizon_warning(table, quantity), _scatter_warning(table))
    metadata = {"name": intensity, "unit": str(level.attrs.get("units", "")), "design": design,
             "doubt": "; ".join(filter(None, warning_texts))}  # fmt: skip
    _check_counts(level.values, failures, trials, confidence)
    try:
        return fragility(level.values, failures, trials, confidence, **metadata)
    except InputError as error:
        return FragilityBounds(intensity=level.values, failures=failures, trials=trials,
                               confidence=confidence, why=str(error), **metadata)  # fmt: skip


def _scatter_warning(table) -> str:
    """Return a warning if the records were matched to one spectrum; otherwise blank."""
    scatter = table["record"].attrs.get("spectral_scatter") if "record" in table.coords else None
    if scatter is None or scatter >= MATCHED_SCATTER:
        return ""
    return (f"the records were matched to one spectrum (scatter {scatter:.0%}): the "
            "dispersion does not include the variability of motions")  # fmt: skip


def _horizon_warning(table, quantity: str) -> str:
    """Return a warning if cases end after the horizon of a quantity, or the horizon is unknown."""
    horizon = table.get(f"{quantity}{DECIDED}")
    name = title_and_unit(quantity)[0]
    if horizon is None:
        return (f"the horizon of {name}, after which values are random samples, is unknown; "
                "a study with task = 'accuracy' computes this horizon")  # fmt: skip
    late_cases, cases = int((horizon < table["end_s"]).sum()), int(horizon.notnull().sum())
    if late_cases == 0:
        return ""
    return (f"{late_cases} of {cases} cases end after the horizon of {name}: each of these values "
            "is a random sample")  # fmt: skip


def _check_counts(x, k, n, confidence) -> None:
    """Check intensities, numbers of failures, numbers of trials, and confidence level."""
    if not (x.shape == k.shape == n.shape and x.ndim == 1):
        raise InputError("intensity, failures and trials must have one value for each level")
    if not 0 < confidence < 1:
        raise InputError(f"confidence = {confidence} must be between 0 and 1")
    if not np.all(np.isfinite(x) & (x > 0)):
        raise InputError("intensities must be above 0")
    if not np.all((k >= 0) & (k <= n) & (k == np.round(k)) & (n == np.round(n))):
        raise InputError("failures must be whole numbers from 0 to the number of trials")


def _check_maximum_exists(x, k, n) -> None:
    """Raise InputError if the likelihood of intensities, failures and trials has no maximum."""
    failing, surviving = x[k > 0], x[k < n]
    if not failing.size or not surviving.size:
        reason = "no case failed" if not failing.size else "all cases failed"
        raise InputError(f"{reason}: a fragility curve requires failures and survivals")
    if failing.min() >= surviving.max():
        raise InputError(
            f"no case fails below {failing.min():g}, and none survives above {surviving.max():g}: "
            "the dispersion is not determined; add levels between these, or cases"
        )
    # The likelihood is concave, so the curve rises if its derivative at slope 0 is above 0.
    derivative = np.sum((k - n * k.sum() / n.sum()) * np.log(x))
    if derivative <= 0:
        raise InputError("the fraction of failures does not increase with the intensity")


def _negative_log_likelihood(p, x, k, n) -> float:
    """Return the negative log-likelihood of p = (ln median, ln dispersion), up to a constant."""
    from scipy.special import log_ndtr

    z = (np.log(x) - p[0]) / np.exp(p[1])
    return -float(np.sum(k * log_ndtr(z) + (n - k) * log_ndtr(-z)))


def _information_matrix(p, x, k, n) -> np.ndarray:
    """Return the observed information: numerical Hessian of the negative log-likelihood."""
    h = 1e-4
    matrix = np.empty((2, 2))
    for i in range(2):
        for j in range(2):
            e, f = h * np.eye(2)[i], h * np.eye(2)[j]
            terms = [(p + e + f, 1), (p + e - f, -1), (p - e + f, -1), (p - e - f, 1)]
            total = sum(s * _negative_log_likelihood(q, x, k, n) for q, s in terms)
            matrix[i, j] = total / (4 * h * h)
    return matrix


def _profile_interval(i, optimum, covariance, limit, x, k, n) -> tuple[float, float]:
    """Return the interval of exp(p_i) within which the profile log-likelihood drops by `limit`."""
    from scipy.optimize import brentq, minimize_scalar

    minimum, step = _negative_log_likelihood(optimum, x, k, n), np.sqrt(covariance[i, i])
    start = optimum[1 - i]

    def excess(value: float) -> float:
        def negative_log_likelihood(q: float) -> float:
            return _negative_log_likelihood((value, q) if i == 0 else (q, value), x, k, n)

        reach = 3.0 + abs(value - optimum[i])
        bounds = start - reach, start + reach
        fit = minimize_scalar(negative_log_likelihood, bounds=bounds, method="bounded",
                              options={"xatol": 1e-10})  # fmt: skip
        return fit.fun - minimum - limit

    limits = []
    for sign, unbounded in ((-1, 0.0), (1, np.inf)):
        distance = next((d for d in 2.0 ** np.arange(1, 7)
                         if excess(optimum[i] + sign * d * step) > 0), None)  # fmt: skip
        if distance is None:
            limits.append(unbounded)
            continue
        root = brentq(lambda d, s=sign: excess(optimum[i] + s * d * step), 0.0, distance, xtol=1e-8)
        limits.append(float(np.exp(optimum[i] + sign * root * step)))
    return limits[0], limits[1]
