# SPDX-License-Identifier: GPL-3.0-or-later
"""Synthetic ground motions: filtered noise with an envelope, fitted to a response spectrum."""

from collections.abc import Sequence

import numpy as np

from ..base.errors import InputError
from ..engine.signals import response_spectrum, running_integral
from .records import Record

_ROUNDS, _GOOD = 30, 0.02  # largest number of iterations of the fit; misfit at which it ends
_PERIODS = 60  # number of periods at which the spectrum is fitted
_RISE, _PLATEAU = 0.15, 0.35  # durations of rise and plateau as fractions of the total duration
_GROUND_DAMPING = 0.6  # damping ratio of the filter of Kanai and Tajimi


def synthetic(
    seeds: int | Sequence[int],
    spectrum,
    duration: float = 20.0,
    time_step: float = 0.01,
    periods: tuple[float, float] = (0.05, 2.0),
    damping: float = 0.05,
) -> list[Record]:
    """Create records from seeds, each fitted to a response spectrum.

    Gaussian noise is filtered by the filter of Kanai and Tajimi, whose frequency is that of the
    largest spectral value, and multiplied by an envelope.  Then its Fourier amplitudes are
    multiplied repeatedly by the ratio of the target to its response spectrum.

    Parameters
    ----------
    seeds : int or sequence of int
        Seeds of random numbers; each yields one record.
    spectrum : callable or (periods, values)
        Target: pseudo-acceleration (m/s²) as a function of periods (s), or a table.
    duration, time_step : float
        s.
    periods : (float, float)
        Shortest and longest fitted period, s.
    damping : float
        Damping ratio of the spectrum.

    Returns
    -------
    list of Record
        Records, whose `misfit` is the root mean square of Sa / target − 1 over the periods.
    """
    if not (duration > 20 * time_step > 0 and 0 < periods[0] < periods[1]):
        raise InputError(f"duration = {duration:g} s, time_step = {time_step:g} s, periods = "
                         f"{periods} s: give more than 20 time steps, and the shortest period "
                         "first")  # fmt: skip
    if periods[0] < 4 * time_step or periods[1] > duration / 2:
        raise InputError(f"periods {periods} s cannot be fitted with a time step of {time_step:g} "
                         f"s and a duration of {duration:g} s: keep periods above 4 time steps and "
                         "below half the duration")  # fmt: skip
    grid = np.geomspace(*periods, _PERIODS)
    if callable(spectrum):
        target = np.asarray(spectrum(grid), dtype=float)
    else:
        target = np.exp(np.interp(np.log(grid), np.log(spectrum[0]), np.log(spectrum[1])))
    if not np.all(np.isfinite(target) & (target > 0)):
        raise InputError("the target spectrum must be above 0 at all periods")
    seeds = [seeds] if isinstance(seeds, int) else list(seeds)
    return [_fit_record(seed, grid, target, duration, time_step, damping) for seed in seeds]


def _fit_record(seed, grid, target, duration, step, damping) -> Record:
    """Fit filtered noise to the target (m/s²) at periods `grid` (s); return the best iterate."""
    count = round(duration / step) + 1
    ground = 1.0 / grid[np.argmax(target)]
    motion = _filtered_noise(seed, count, step, ground) * _envelope(count)
    frequency = np.fft.rfftfreq(2 * count, step)
    best_motion, least_misfit = motion, np.inf
    for _ in range(_ROUNDS):
        ratio = target / _motion_spectrum(motion, step, grid, damping)
        misfit = float(np.sqrt(np.mean((1 / ratio - 1) ** 2)))
        if misfit < least_misfit:
            best_motion, least_misfit = motion, misfit
        if least_misfit < _GOOD:
            break
        factor = np.interp(frequency, 1 / grid[::-1], ratio[::-1])
        spectrum = np.fft.rfft(motion, 2 * count) * factor
        spectrum[frequency < 0.5 / grid[-1]] *= 0.5  # periods above twice the longest fitted one
        motion = _remove_drift(np.fft.irfft(spectrum)[:count] * _end_taper(count), step)
    return Record(f"synthetic {seed}", best_motion, step, least_misfit)


def _motion_spectrum(motion, step, periods, damping) -> np.ndarray:
    """Return the pseudo-acceleration (m/s²) of a motion that is followed by rest."""
    zeros = np.zeros(int(np.ceil(periods[-1] / step)))
    padded = np.concatenate([motion, zeros])
    return response_spectrum(padded, step, periods, damping).pseudo_acceleration


def _filtered_noise(seed: int, count: int, step: float, ground: float) -> np.ndarray:
    """Return white noise after the filter of Kanai and Tajimi with frequency `ground`, Hz."""
    white_noise = np.random.Generator(np.random.Philox(seed)).standard_normal(count)
    r = np.fft.rfftfreq(2 * count, step) / ground
    damping_term = 2j * _GROUND_DAMPING * r
    transfer = (1 + damping_term) / (1 - r**2 + damping_term)
    return np.fft.irfft(np.fft.rfft(white_noise, 2 * count) * transfer)[:count]


def _envelope(count: int) -> np.ndarray:
    """Return an envelope that increases as t², is constant, and decays to 5 %."""
    t = np.linspace(0.0, 1.0, count)
    end = _RISE + _PLATEAU
    rise = np.minimum(t / _RISE, 1.0) ** 2
    return np.where(t <= end, rise, np.exp(-3.0 * (t - end) / (1.0 - end)))


def _end_taper(count: int) -> np.ndarray:
    """Return a cosine taper over the first and last 2 % of the samples."""
    n = max(count // 50, 1)
    taper = np.ones(count)
    taper[:n] = 0.5 - 0.5 * np.cos(np.pi * np.arange(n) / n)
    taper[-n:] = taper[:n][::-1]
    return taper


def _remove_drift(acceleration: np.ndarray, step: float) -> np.ndarray:
    """Remove the derivative of the parabola that is fitted to the velocity."""
    t = np.arange(acceleration.size) * step
    velocity = running_integral(acceleration, step)
    basis = np.column_stack([t, t**2])
    slope, bend = np.linalg.lstsq(basis, velocity, rcond=None)[0]
    return acceleration - slope - 2 * bend * t
