# SPDX-License-Identifier: GPL-3.0-or-later
"""Prepare records for an analysis: filter, resample, rotate, scale and select them."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.arguments import positive
from ..base.errors import InputError, MissingLibrary
from ..base.reading import read_bounded
from ..engine.signals import running_integral, spectral_acceleration
from .motion import Motion

if TYPE_CHECKING:
    import xarray as xr

_LARGEST = 2**28  # largest size of a flatfile, bytes
_MOST_RATIO = 1000  # largest integer in the ratio of two time steps
_HEAD = re.compile(  # of a spectrum
    r"\s*(?:T|SA|PSA)?[\s_(]*(\d+\.?\d*|\.\d+)\s*S?\)?\s*", re.IGNORECASE
)
_NAMES = ("file", "record", "name", "file name (horizontal 1)", "record sequence number")
Target = Callable | tuple[ArrayLike, ArrayLike]


def of_acceleration(acceleration: ArrayLike, time_step: float, method: str = "") -> xr.Dataset:
    """Return a motion (m/s², s) like :func:`sitedda.read_record`, integrated from zero velocity."""
    import xarray as xr

    motion = Motion.of(acceleration, time_step)
    velocity = running_integral(motion.acceleration, motion.time_step)
    return xr.Dataset(
        {
            "acceleration": ("time", motion.acceleration, {"units": "m/s^2"}),
            "velocity": ("time", velocity, {"units": "m/s"}),
            "displacement": ("time", running_integral(velocity, motion.time_step), {"units": "m"}),
        },
        {"time": ("time", motion.time_step * np.arange(velocity.size), {"units": "s"})},
        {"method": method},
    )


def band_pass(motion, low: float | None, high: float | None = None, order: int = 4) -> xr.Dataset:
    """Filter a motion forwards and backwards by a Butterworth filter without phase shift.

    Zeros for 1.5 × order / low on both sides contain the transients of the filter, so that
    velocity and displacement end at rest (Boore 2005, BSSA 95, 745-750).

    Parameters
    ----------
    motion : xarray.Dataset
        As :func:`sitedda.read_record` returns it.
    low, high : float, optional
        Corners, Hz, at which the amplitude is halved by the two passes; None: no such corner.
    order : int
        Order of a single pass.

    Raises
    ------
    InputError
        If the corners are not in order below half of the sampling frequency.
    """
    from scipy.signal import butter, sosfiltfilt

    given = Motion.of(motion)
    most = 0.5 / given.time_step
    corners = [float(f) for f in (low, high) if f is not None]
    if not corners or not 0 < corners[0] <= corners[-1] < most or len(set(corners)) < len(corners):
        raise InputError(f"corners of {low} and {high} Hz: give one or two, in order, above 0 and "
                         f"below {most:g} Hz, half of the sampling frequency")  # fmt: skip
    if not 1 <= order <= 10:
        raise InputError(f"order = {order}: give 1 to 10")
    kind = "bandpass" if len(corners) == 2 else "highpass" if high is None else "lowpass"
    sections = butter(order, corners if len(corners) == 2 else corners[0], kind,
                      fs=1 / given.time_step, output="sos")  # fmt: skip
    zeros = np.zeros(int(np.ceil(1.5 * order / corners[0] / given.time_step)))
    series = np.concatenate([zeros, given.acceleration, zeros])
    words = f"zero-phase Butterworth, order {order}, {low} to {high} Hz"
    return of_acceleration(sosfiltfilt(sections, series, padlen=0), given.time_step, words)


def resampled(motion, time_step: float) -> xr.Dataset:
    """Resample a motion, low-passed if its Nyquist frequency decreases.

    Parameters
    ----------
    motion : xarray.Dataset
    time_step : float
        s; its ratio to the step of the motion must be a quotient of whole numbers up to 1000.
    """
    from scipy.signal import resample_poly

    given, step = Motion.of(motion), float(positive("time_step", time_step))
    ratio = Fraction(given.time_step / step).limit_denominator(_MOST_RATIO)
    if not ratio or abs(float(ratio) * step / given.time_step - 1) > 1e-6 or ratio > _MOST_RATIO:
        raise InputError(f"time_step = {step:g} s: its ratio to {given.time_step:g} s is not a "
                         f"quotient of whole numbers up to {_MOST_RATIO}")  # fmt: skip
    series = resample_poly(given.acceleration, ratio.numerator, ratio.denominator)
    return of_acceleration(series, step, f"resampled from {given.time_step:g} s")


def rotated_spectra(
    first, second, periods: ArrayLike, percentiles: Sequence[float] = (0, 50, 100),
    damping: float = 0.05,
) -> NDArray[np.float64]:  # fmt: skip
    """Return RotDnn of two horizontal components: percentiles of Sa over all directions.

    Parameters
    ----------
    first, second : xarray.Dataset
        Components with equal time steps.
    periods : array_like, shape (n,)
        s.

    Returns
    -------
    ndarray, shape (m, n)
        m/s².

    References
    ----------
    Boore, D. M. (2010). Orientation-independent, nongeometric-mean measures of seismic intensity
    from two horizontal components of motion. BSSA 100(4), 1830-1835.
    """
    try:
        import pyrotd
    except ImportError as trouble:
        raise MissingLibrary("RotDnn needs the library: pip install pyrotd") from trouble
    one, other = Motion.of(first), Motion.of(second)
    if abs(one.time_step - other.time_step) > 1e-9 * one.time_step:
        raise InputError(f"components have time steps of {one.time_step:g} and "
                         f"{other.time_step:g} s: resample one")  # fmt: skip
    size = min(one.acceleration.size, other.acceleration.size)
    at = np.asarray(periods, dtype=float)
    wanted = list(percentiles)
    pair = one.acceleration[:size], other.acceleration[:size]
    found = pyrotd.calc_rotated_spec_accels(
        one.time_step, *pair, 1 / at, damping, percentiles=wanted
    )
    return np.array([found.spec_accel[found.percentile == p] for p in wanted])


def scale_to(motion, target: Target, periods: ArrayLike, damping: float = 0.05) -> float:
    """Return the factor with which the mean of ln Sa over periods equals that of a target.

    Parameters
    ----------
    motion : xarray.Dataset
    target : callable or (periods, values)
        Sa (m/s²) of periods (s).
    periods : array_like, shape (n,)
        s, such as ``np.geomspace(0.2, 2.0, 50)`` for a band.
    """
    given, at = Motion.of(motion), np.asarray(periods, dtype=float)
    own = spectral_acceleration(given.acceleration, given.time_step, at, damping)
    if not np.all(own > 0):
        raise InputError("a motion of zeros cannot be scaled")
    return float(np.exp(np.mean(np.log(target_at(target, at) / own))))


def target_at(target: Target, periods: NDArray[np.float64]) -> NDArray[np.float64]:
    """Interpolate a target spectrum (m/s²) at periods (s), linearly in its logarithms."""
    if callable(target):
        found = np.asarray(target(periods), dtype=float)
    else:
        at, values = (np.asarray(one, dtype=float) for one in target)
        if not (at.min() <= periods.min() * (1 + 1e-9) and periods.max() <= at.max() * (1 + 1e-9)):
            raise InputError(f"the target covers {at.min():g} to {at.max():g} s, but must cover "
                             f"{periods.min():g} to {periods.max():g} s")  # fmt: skip
        found = np.exp(np.interp(np.log(periods), np.log(at), np.log(values)))
    if found.shape != periods.shape or not np.all(np.isfinite(found) & (found > 0)):
        raise InputError("the target spectrum must be above 0 at all periods")
    return found


# --- selection to a conditional mean spectrum -----------------------------------------------------


def spectral_correlation(first: ArrayLike, second: ArrayLike) -> NDArray[np.float64]:
    """Return the correlation of ε at two periods (0.01 to 10 s) of Baker and Jayaram (2008).

    References
    ----------
    Baker, J. W. & Jayaram, N. (2008). Correlation of spectral acceleration values from NGA ground
    motion models. Earthquake Spectra 24(1), 299-317, equations 1 to 6.
    """
    first, second = np.broadcast_arrays(np.asarray(first, float), np.asarray(second, float))
    low, high = np.minimum(first, second), np.maximum(first, second)
    c1 = 1 - np.cos(np.pi / 2 - 0.366 * np.log(high / np.maximum(low, 0.109)))
    slow = 1 / (1 + np.exp(np.minimum(100 * high - 5, 500)))
    near = 1 - 0.105 * (1 - slow) * (high - low) / np.maximum(high - 0.0099, 1e-4)
    c2 = np.where(high < 0.2, near, 0.0)
    c3 = np.where(high < 0.109, c2, c1)
    c4 = c1 + 0.5 * (np.sqrt(c3) - c3) * (1 + np.cos(np.pi * low / 0.109))
    return np.where(high < 0.109, c2, np.where(low > 0.109, c1,
                    np.where(high < 0.2, np.minimum(c2, c4), c4)))  # fmt: skip


def conditional_mean(
    periods: ArrayLike, median: ArrayLike, sigma: ArrayLike, period: float, epsilon: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the conditional mean spectrum given Sa at a period (Baker 2011).

    Parameters
    ----------
    periods, median, sigma : array_like, shape (n,)
        s, m/s², and σ of ln Sa, of a ground motion model.
    period : float
        s, at which Sa is given.
    epsilon : float
        Its number of σ above the median.

    Returns
    -------
    mean, sigma : ndarray, shape (n,)
        m/s², and the conditional σ of ln Sa.

    References
    ----------
    Baker, J. W. (2011). Conditional mean spectrum: tool for ground-motion selection. Journal of
    Structural Engineering 137(3), 322-331.
    """
    at, spread = np.asarray(periods, dtype=float), np.asarray(sigma, dtype=float)
    rho = spectral_correlation(at, period)
    mean = np.asarray(median, dtype=float) * np.exp(rho * epsilon * spread)
    return mean, spread * np.sqrt(np.maximum(1 - rho**2, 0.0))


@dataclass(frozen=True)
class Flatfile:
    """Spectra of records."""

    names: list[str]
    periods: NDArray[np.float64]  # s
    spectra: NDArray[np.float64]  # shape (records, periods), m/s²

    def select(
        self, target: Target, count: int, periods: ArrayLike | None = None,
        factors: tuple[float, float] = (0.25, 4.0),
    ) -> list[tuple[str, float, float]]:  # fmt: skip
        """Select the records whose spectral shapes are closest to a target.

        Parameters
        ----------
        target : callable or (periods, values)
            Sa (m/s²) of periods (s).
        periods : array_like, optional
            s; periods of the file at which spectra are compared.
        factors : (float, float)
            Least and largest factor of a record.

        Returns
        -------
        list of (name, factor, misfit)
            Best first; the misfit is the root of the mean square of ln Sa less that of the target.
        """
        at = self.periods if periods is None else np.asarray(periods, dtype=float)
        wanted = np.log(target_at(target, at))
        known = np.log(self.spectra)
        logs = np.array([np.interp(np.log(at), np.log(self.periods), one) for one in known])
        shift = np.clip(np.mean(wanted - logs, axis=1), *np.log(factors))
        misfit = np.sqrt(np.mean((logs + shift[:, None] - wanted) ** 2, axis=1))
        if not 1 <= count <= len(self.names):
            raise InputError(f"count = {count}: the flatfile has {len(self.names)} records")
        best = np.argsort(misfit, kind="stable")[:count]
        return [(self.names[i], float(np.exp(shift[i])), float(misfit[i])) for i in best]


def read_flatfile(file, unit: float = 9.80665) -> Flatfile:
    """Read spectra of records from a CSV file, such as the flatfile of NGA-West2.

    Parameters
    ----------
    file : path
        A column ``file``, ``record``, ``name`` or NGA-West2's own, and columns of Sa headed
        ``T0.100S``, ``SA(0.1)`` or ``0.1``.  Records with a value that is not above 0 are left out.
    unit : float
        Unit of the spectra, m/s² (default: g).
    """
    import pandas as pd

    data = io.BytesIO(read_bounded(Path(file), _LARGEST))
    try:
        table = pd.read_csv(data, dtype=str, encoding="utf-8-sig", encoding_errors="replace",
                            keep_default_na=False)  # fmt: skip
    except ValueError as trouble:
        raise InputError(f"{file}: {trouble}") from None
    heads = {head.strip().lower(): head for head in table}
    named = [heads[name] for name in _NAMES if name in heads]
    of = {head: float(found[1]) for head in table if (found := _HEAD.fullmatch(head))}
    if not named or len(of) < 2:
        raise InputError(f"{file}: give a column 'file' and two or more columns of spectra, "
                         "such as 'SA(0.1)'")  # fmt: skip
    columns = sorted(of, key=of.__getitem__)
    spectra = table[columns].apply(pd.to_numeric, errors="coerce").to_numpy()
    unread = np.isnan(spectra).any(axis=1)
    if unread.any():
        raise InputError(f"{file}, row {2 + unread.argmax()}: a spectrum cannot be read")
    good = np.all(spectra > 0, axis=1)
    if not good.any():
        raise InputError(f"{file} has no record with a spectrum above 0")
    names = list(table.loc[good, named[0]].str.strip())
    return Flatfile(names, np.array([of[head] for head in columns]), unit * spectra[good])
