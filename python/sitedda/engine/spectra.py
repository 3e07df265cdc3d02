# SPDX-License-Identifier: GPL-3.0-or-later
"""Fourier spectra and amplification, computed by the engine (FFTW)."""

from dataclasses import dataclass

import numpy as np

from ..base.core import api, checked
from ..base.errors import InputError


@dataclass(frozen=True)
class Peak:
    """The largest amplitude in a frequency band.

    Attributes
    ----------
    frequency : float
        Hz; in a spectrum, the vertex of the parabola through the three highest bins.
    amplitude : float
        Amplitude at this frequency.
    bin_width : float
        Distance between bins, Hz; 0 for the peak of a formula.
    interpolated : bool
        False if the highest bin is at an end of the band, and for the peak of a formula.
    """

    frequency: float
    amplitude: float
    bin_width: float = 0.0
    interpolated: bool = False


def _check_series(name: str, values) -> np.ndarray:
    """Return values as a one-dimensional array; raise InputError for other shapes."""
    series = np.ascontiguousarray(values, dtype=float)
    if series.ndim != 1:
        raise InputError(f"{name} must be one-dimensional, not of shape {series.shape}")
    return series


def fourier_spectrum(series, time_step: float, padding: int = 1, taper: float = 0.0):
    """Compute a one-sided Fourier spectrum, an estimate of the Fourier integral.

    Parameters
    ----------
    series : array_like, shape (samples,)
    time_step : float
        s between samples.
    padding : int
        Zero-padded length over original length.
    taper : float
        Fraction of the length under a cosine taper, half of it at each end, 0 … 1.

    Returns
    -------
    frequency : ndarray, shape (bins,)
        Hz.
    spectrum : complex ndarray, shape (bins,)
        Unit of the series times s.

    Raises
    ------
    InputError
        If an argument is out of range or a sample is not finite.
    """
    series = _check_series("series", series)
    bins = int(padding) * series.size // 2 + 1
    return checked(api.spectrum_of, series, [], time_step, padding, taper, bins)


def amplification(surface, base, time_step: float, padding: int = 8, taper: float = 0.0):
    """Compute the ratio of the Fourier spectra of two motions of the same kind.

    Parameters
    ----------
    surface, base : array_like, shape (samples,)
    time_step : float
        s between samples.
    padding : int
        Zero-padded length over original length.
    taper : float
        Fraction of the length under a cosine taper.

    Returns
    -------
    frequency : ndarray, shape (bins,)
        Hz.
    ratio : complex ndarray, shape (bins,)
        0 at frequencies where the base motion is negligible.
    """
    surface, base = _check_series("surface", surface), _check_series("base", base)
    if surface.shape != base.shape:
        sizes = f"{surface.size} and {base.size}"
        raise InputError(f"`surface` and `base` differ in number of samples: {sizes}")
    bins = int(padding) * surface.size // 2 + 1
    return checked(api.spectrum_of, surface, base, time_step, padding, taper, bins)


def find_peak(frequency, amplitude, lowest: float, highest: float) -> Peak:
    """Return the largest amplitude between two frequencies (Hz), interpolated by a parabola.

    Raises
    ------
    InputError
        If no bin lies in the band.
    """
    bins = _check_series("frequency", frequency), _check_series("amplitude", amplitude)
    peak = checked(api.peak_of, *bins, lowest, highest)
    return Peak(float(peak[0]), float(peak[1]), float(peak[2]), bool(peak[3]))
