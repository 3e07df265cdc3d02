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

from ..base.arguments import first_of, positive
from ..base.errors import InputError, library_required, located
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

    ground = Motion.of(motion)
    nyquist = 0.5 / ground.time_step
    corners = [float(f) for f in (low, high) if f is not None]
    increasing = corners == sorted(set(corners))
    if not corners or not increasing or not 0 < corners[0] <= corners[-1] < nyquist:
        raise InputError(f"corners of {low} and {high} Hz: give one or two, in order, above 0 and "
                         f"below {nyquist:g} Hz, half of the sampling frequency")  # fmt: skip
    if not 1 <= order <= 10:
        raise InputError(f"order = {order}: give 1 to 10")
    kind = "bandpass" if len(corners) == 2 else "highpass" if high is None else "lowpass"
    sections = butter(order, corners if len(corners) == 2 else corners[0], kind,
                      fs=1 / ground.time_step, output="sos")  # fmt: skip
    zeros = np.zeros(int(np.ceil(1.5 * order / corners[0] / ground.time_step)))
    series = np.concatenate([zeros, ground.acceleration, zeros])
    method = f"zero-phase Butterworth, order {order}, {low} to {high} Hz"
    return of_acceleration(sosfiltfilt(sections, series, padlen=0), ground.time_step, method)


def resampled(motion, time_step: float) -> xr.Dataset:
    """Resample a motion, low-passed if its Nyquist frequency decreases.

    Parameters
    ----------
    motion : xarray.Dataset
    time_step : float
        s; its ratio to the step of the motion must be a quotient of whole numbers up to 1000.
    """
    from scipy.signal import resample_poly

    ground, step = Motion.of(motion), float(positive("time_step", time_step))
    ratio = Fraction(ground.time_step / step).limit_denominator(_MOST_RATIO)
    if not ratio or abs(float(ratio) * step / ground.time_step - 1) > 1e-6 or ratio > _MOST_RATIO:
        raise InputError(f"time_step = {step:g} s: its ratio to {ground.time_step:g} s is not a "
                         f"quotient of whole numbers up to {_MOST_RATIO}")  # fmt: skip
    series = resample_poly(ground.acceleration, ratio.numerator, ratio.denominator)
    return of_acceleration(series, step, f"resampled from {ground.time_step:g} s")


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
    with library_required("RotDnn needs the library: pip install pyrotd"):
        import pyrotd
    x, y = Motion.of(first), Motion.of(second)
    if abs(x.time_step - y.time_step) > 1e-9 * x.time_step:
        raise InputError(f"components have time steps of {x.time_step:g} and "
                         f"{y.time_step:g} s: resample one")  # fmt: skip
    size = min(x.acceleration.size, y.acceleration.size)
    grid = np.asarray(periods, dtype=float)
    levels = list(percentiles)
    components = x.acceleration[:size], y.acceleration[:size]
    spectra = pyrotd.calc_rotated_spec_accels(
        x.time_step, *components, 1 / grid, damping, percentiles=levels
    )
    return np.array([spectra.spec_accel[spectra.percentile == p] for p in levels])


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
    ground, grid = Motion.of(motion), np.asarray(periods, dtype=float)
    spectrum = spectral_acceleration(ground.acceleration, ground.time_step, grid, damping)
    if not np.all(spectrum > 0):
        raise InputError("a motion of zeros cannot be scaled")
    return float(np.exp(np.mean(np.log(target_at(target, grid) / spectrum))))


def target_at(target: Target, periods: NDArray[np.float64]) -> NDArray[np.float64]:
    """Interpolate a target spectrum (m/s²) at periods (s), linearly in its logarithms."""
    if callable(target):
        result = np.asarray(target(periods), dtype=float)
    else:
        grid, values = _sorted_target(*target)
        low, high = periods.min() * (1 + 1e-9), periods.max() / (1 + 1e-9)
        if not (grid.min() <= low and high <= grid.max()):
            raise InputError(f"the target covers {grid.min():g} to {grid.max():g} s, but must "
                             f"cover {periods.min():g} to {periods.max():g} s")  # fmt: skip
        result = np.exp(np.interp(np.log(periods), np.log(grid), np.log(values)))
    if result.shape != periods.shape or not np.all(np.isfinite(result) & (result > 0)):
        raise InputError("the target spectrum must be above 0 at all periods")
    return result


def _sorted_target(periods: ArrayLike, values: ArrayLike):
    """Return a target spectrum with increasing periods."""
    grid, values = (np.asarray(axis, dtype=float) for axis in (periods, values))
    if grid.shape != values.shape or grid.ndim != 1 or not grid.size:
        raise InputError("target: give as many values as periods, one or more")
    if not np.all(is_valid := np.isfinite(grid) & (grid > 0)):
        raise InputError(f"target: a period of {first_of(grid, ~is_valid):g} s must be above 0")
    order = np.argsort(grid)
    grid, values = grid[order], values[order]
    if np.any(is_repeated := np.diff(grid) == 0):
        raise InputError(f"target: the period {first_of(grid[1:], is_repeated):g} s is repeated")
    return grid, values


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
    transition = 1 / (1 + np.exp(np.minimum(100 * high - 5, 500)))
    reduced = 1 - 0.105 * (1 - transition) * (high - low) / np.maximum(high - 0.0099, 1e-4)
    c2 = np.where(high < 0.2, reduced, 0.0)
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
    grid, sigmas = np.asarray(periods, dtype=float), np.asarray(sigma, dtype=float)
    rho = spectral_correlation(grid, period)
    mean = np.asarray(median, dtype=float) * np.exp(rho * epsilon * sigmas)
    return mean, sigmas * np.sqrt(np.maximum(1 - rho**2, 0.0))


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
            Smallest and largest factor of a record.

        Returns
        -------
        list of (name, factor, misfit)
            Best first; the misfit is the root mean square of ln (Sa of the record / target).
        """
        grid = self.periods if periods is None else np.asarray(periods, dtype=float)
        target_logs = np.log(target_at(target, grid))
        spectrum_logs = np.log(self.spectra)
        logs = np.array(
            [np.interp(np.log(grid), np.log(self.periods), row) for row in spectrum_logs]
        )
        shift = np.clip(np.mean(target_logs - logs, axis=1), *np.log(factors))
        misfit = np.sqrt(np.mean((logs + shift[:, None] - target_logs) ** 2, axis=1))
        if not 1 <= count <= len(self.names):
            raise InputError(f"count = {count}: the flatfile has {len(self.names)} records")
        best = np.argsort(misfit, kind="stable")[:count]
        return [(self.names[i], float(np.exp(shift[i])), float(misfit[i])) for i in best]


def read_flatfile(file, unit: float = 9.80665) -> Flatfile:
    """Read spectra of records from a CSV file, such as the flatfile of NGA-West2.

    Parameters
    ----------
    file : path
        A column ``file``, ``record``, ``name`` or that of NGA-West2, and columns of Sa with heads
        like ``T0.100S``, ``SA(0.1)`` or ``0.1``.  Records with values of 0 or below are omitted.
    unit : float
        Unit of the spectra, m/s² (default: g).
    """
    import pandas as pd

    data = io.BytesIO(read_bounded(Path(file), _LARGEST))
    with located(file, ValueError):
        table = pd.read_csv(data, dtype=str, encoding="utf-8-sig", encoding_errors="replace",
                            keep_default_na=False)  # fmt: skip
    heads = {head.strip().lower(): head for head in table}
    name_columns = [heads[name] for name in _NAMES if name in heads]
    by_head = {head: float(match[1]) for head in table if (match := _HEAD.fullmatch(head))}
    if not name_columns or len(by_head) < 2:
        raise InputError(f"{file}: give a column 'file' and two or more columns of spectra, "
                         "such as 'SA(0.1)'")  # fmt: skip
    columns = sorted(by_head, key=by_head.__getitem__)
    spectra = table[columns].apply(pd.to_numeric, errors="coerce").to_numpy()
    is_invalid = np.isnan(spectra).any(axis=1)
    if is_invalid.any():
        raise InputError(f"{file}, row {2 + is_invalid.argmax()}: a spectrum cannot be read")
    is_positive = np.all(spectra > 0, axis=1)
    if not is_positive.any():
        raise InputError(f"{file} has no record with a spectrum above 0")
    names = list(table.loc[is_positive, name_columns[0]].str.strip())
    return Flatfile(
        names, np.array([by_head[head] for head in columns]), unit * spectra[is_positive]
    )
