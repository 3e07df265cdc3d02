# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures of the strength and the duration of a motion."""

from dataclasses import dataclass

import numpy as np

from ..base.errors import InputError
from ..engine.signals import arias_growth, running_integral
from .motion import Motion


@dataclass(frozen=True)
class Intensity:
    """Intensity measures of an acceleration.

    Attributes
    ----------
    peak_acceleration : float
        m/s².
    peak_velocity : float
        m/s, of the acceleration integrated from rest.
    arias : float
        Arias intensity π/2g ∫a² dt, m/s.
    duration : float
        D5–95, s: between 5 and 95 % of the Arias intensity.
    mean_period : float
        T_m of Rathje et al. (2004), s: mean of 1/f over the squared Fourier amplitudes from 0.25 to
        20 Hz.
    cumulative_velocity : float
        ∫|a| dt, m/s.
    """

    peak_acceleration: float
    peak_velocity: float
    arias: float
    duration: float
    mean_period: float
    cumulative_velocity: float

    def __str__(self) -> str:
        return (
            f"PGA {self.peak_acceleration:.4g} m/s², PGV {self.peak_velocity:.4g} m/s, "
            f"Arias {self.arias:.4g} m/s, D5–95 {self.duration:.4g} s, "
            f"mean period {self.mean_period:.4g} s, CAV {self.cumulative_velocity:.4g} m/s"
        )


def intensity(motion, time_step: float | None = None) -> Intensity:
    """Compute the intensity measures of a motion.

    Parameters
    ----------
    motion, time_step
        See :meth:`Column.response`.

    Raises
    ------
    InputError
        If the motion is invalid, or all samples are 0.

    References
    ----------
    Rathje, E. M., Faraj, F., Russell, S. & Bray, J. D. (2004). Empirical relationships for
    frequency content parameters of earthquake ground motions. Earthquake Spectra 20(1), 119-144.
    """
    ground = Motion.of(motion, time_step)
    series, step = ground.acceleration, ground.time_step
    if not np.any(series):
        raise InputError("the motion has no acceleration: every sample is 0")
    arias = arias_growth(series, step)
    low, high = np.interp([0.05, 0.95], arias / arias[-1], step * np.arange(series.size))
    frequency = np.fft.rfftfreq(series.size, step)
    power = np.abs(np.fft.rfft(series)) ** 2
    band = (frequency >= 0.25) & (frequency <= 20.0)
    total = power[band].sum()
    mean = float((power[band] / frequency[band]).sum() / total) if total > 0 else float("nan")
    peaks = (np.abs(values).max() for values in (series, running_integral(series, step)))
    cumulative = running_integral(np.abs(series), step)[-1]
    return Intensity(*map(float, (*peaks, arias[-1], high - low, mean, cumulative)))
