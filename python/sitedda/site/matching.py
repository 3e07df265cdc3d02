# SPDX-License-Identifier: GPL-3.0-or-later
"""Match motions to a response spectrum by wavelets without permanent motion."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..base.errors import ConvergenceError, InputError
from ..engine.signals import fast_length, running_integral, spectral_acceleration
from .motion import Motion
from .motions import Target, of_acceleration, resampled, target_at

if TYPE_CHECKING:
    import xarray as xr

_FINE = 10  # samples in the shortest matched period
_PER_DECADE = 40  # number of matched periods
_RELAXED = 0.7  # fraction of the required change made in a round
_MEEK = 0.1  # weight of peaks below the target that need not change
_RIVAL = 0.85  # fraction of the target from which a peak is watched, so as not to exceed it
_SMALL = (5e-3, 2e-4)  # regularisation in first and last round, over the largest singular value
_WIDTH = 1.178  # γ(f) = 1.178 f^−0.93, s: duration of a wavelet


def matched(
    motion,
    target: Target,
    periods: tuple[float, float] = (0.02, 5.0),
    *,
    tolerance: float = 0.05,
    damping: float = 0.05,
    most_rounds: int = 40,
) -> xr.Dataset:
    """Add wavelets to a motion until its response spectrum equals a target.

    For each period, a cosine times a bell is added at the time of the largest response of its
    oscillator (Al Atik and Abrahamson 2010). A bell times a linear function removes its drift, so
    that velocity and displacement of each wavelet end exactly at 0. The drift of the motion itself
    is removed once in the same way.

    Parameters
    ----------
    motion : xarray.Dataset
        As :func:`sitedda.read_record` returns it; first scaled to the target, and resampled to a
        tenth of the shortest period where it is coarser.
    target : callable or (periods, values)
        Sa (m/s²) of periods (s).
    periods : (float, float)
        Shortest and longest that are matched, s.
    tolerance : float
        Largest relative misfit.
    damping : float
        Of the spectrum.
    most_rounds : int

    Returns
    -------
    xarray.Dataset
        ``attrs['misfit']`` is the largest relative misfit between the periods.

    Raises
    ------
    ConvergenceError
        If the misfit stays above the tolerance; the message has the least misfit.

    References
    ----------
    Al Atik, L. & Abrahamson, N. (2010). An improved method for nonstationary spectral matching.
    Earthquake Spectra 26(3), 601-617.
    """
    low, high = map(float, periods)
    if not 0 < low < high:
        raise InputError(f"periods = {periods}: give the shortest and the longest, above 0, s")
    if Motion.of(motion).time_step > low / _FINE * (1 + 1e-9):
        given = Motion.of(motion)
        parts = int(np.ceil(given.time_step / (low / _FINE) - 1e-9))
        motion = resampled(motion, given.time_step / parts)
    given = Motion.of(motion)
    if high > given.acceleration.size * given.time_step / 2:
        raise InputError(f"a motion of {given.acceleration.size * given.time_step:.3g} s cannot be "
                         f"matched at periods of {high:g} s")  # fmt: skip
    count = int(np.ceil(_PER_DECADE * np.log10(high / low))) + 1
    grid = np.geomspace(low, high, count)
    wanted = target_at(target, grid)
    run = _Matching(given, grid, wanted, damping)
    best, least = run.rounds(tolerance, most_rounds)
    if least > tolerance:
        raise ConvergenceError(
            f"the spectrum is within {100 * least:.3g} % of the target, not {100 * tolerance:g} %: "
            "choose a motion whose spectrum is closer to the target, or fewer periods"
        )
    found = of_acceleration(best, given.time_step, f"matched to a spectrum, {low:g} to {high:g} s")
    found.attrs["misfit"] = least
    return found


class _Matching:
    def __init__(self, motion: Motion, grid, wanted, damping: float):
        self.step, self.grid, self.wanted, self.damping = motion.time_step, grid, wanted, damping
        rest = int(np.ceil(grid[-1] / self.step))
        self.length = fast_length(2 * motion.acceleration.size + rest)
        self.size = motion.acceleration.size
        omega = 2 * np.pi * np.fft.rfftfreq(self.length, self.step)
        own = 2 * np.pi / grid[:, None]
        # Pseudo-acceleration of oscillators under a ground acceleration.
        self.transfer = -(own**2) / (own**2 - omega**2 + 2j * damping * own * omega)
        time = self.step * np.arange(self.size)
        bell = np.sin(np.pi * time / time[-1]) ** 2
        self.motion = _remove_drift(motion.acceleration, bell, self.step)
        own_spectrum = self._spectrum(self.motion)
        self.motion = self.motion * np.exp(np.mean(np.log(wanted / own_spectrum)))

    def _spectrum(self, series, periods=None) -> NDArray[np.float64]:
        at = self.grid if periods is None else periods
        return spectral_acceleration(series, self.step, at, self.damping)

    def rounds(self, tolerance: float, most: int):
        """Return the best motion and its misfit, also between the matched periods."""
        between = np.sqrt(self.grid[1:] * self.grid[:-1])
        logs = np.interp(np.log(between), np.log(self.grid), np.log(self.wanted))
        best, least, series = self.motion, np.inf, self.motion
        for small in np.geomspace(*_SMALL, most):
            off = np.abs(self._spectrum(series) / self.wanted - 1).max()
            off = max(off, np.abs(self._spectrum(series, between) / np.exp(logs) - 1).max())
            if off < least:
                best, least = series, float(off)
            if least <= 0.8 * tolerance:
                break
            series = series + self._find_wavelets(series, small)
        return best, least

    def _find_wavelets(self, series, small: float) -> NDArray[np.float64]:
        """Return wavelets that change the spectrum towards the target, to first order."""
        spectrum = np.fft.rfft(series, self.length)
        responses = np.fft.irfft(self.transfer * spectrum, self.length, axis=-1)
        largest = np.abs(responses).argmax(axis=1)
        owner, peak = self._peaks(np.abs(responses), largest)
        value = responses[owner, peak]
        lack = self.wanted[owner] - np.abs(value)
        first = peak == largest[owner]
        lack[first] = (self.wanted - self._spectrum(series))[owner[first]]  # also between samples
        lack = np.where(first, lack, np.minimum(lack, 0.0)) * np.sign(value)
        strong = first | (lack * np.sign(value) < 0)
        waves = np.array([self._wavelet(t, at) for t, at in zip(self.grid, largest, strict=True)])
        moved = np.fft.rfft(waves, self.length, axis=-1)
        phase = np.exp(2j * np.pi * np.outer(peak, np.arange(moved.shape[1])) / self.length)
        weight = np.full(moved.shape[1], 2.0 / self.length)
        weight[0] = 1.0 / self.length
        effect = ((self.transfer[owner] * phase * weight) @ moved.T).real  # on peaks
        rows = np.where(strong, 1.0, _MEEK) / self.wanted[owner]
        left, sizes, right = np.linalg.svd(effect * rows[:, None], full_matrices=False)
        filtered = sizes / (sizes**2 + (small * sizes[0]) ** 2)
        amplitude = right.T @ (filtered * (left.T @ (_RELAXED * lack * rows)))
        return amplitude @ waves

    def _peaks(self, sizes, largest):
        """Return oscillator and sample of the peaks close to the largest of their oscillator."""
        inner = sizes[:, 1:-1]
        high = (inner >= sizes[:, :-2]) & (inner > sizes[:, 2:])
        high &= inner > _RIVAL * np.maximum(self.wanted, inner.max(axis=1))[:, None]
        rows, at = np.nonzero(high)
        rows, at = np.append(rows, np.arange(largest.size)), np.append(at + 1, largest)
        keep = np.unique(np.column_stack([rows, at]), axis=0)
        return keep[:, 0], keep[:, 1]

    def _wavelet(self, period: float, peak: int) -> NDArray[np.float64]:
        """Return a cosine times a bell around a time, without final velocity or displacement."""
        time = self.step * np.arange(self.size)
        width = min(_WIDTH * period**0.93, time[-1] / 8)
        own = 2 * np.pi / period * np.sqrt(1 - self.damping**2)
        lag = np.arctan(np.sqrt(1 - self.damping**2) / self.damping) / own
        centre = float(np.clip(self.step * peak - lag, 2 * width, time[-1] - 2 * width))
        at = time - centre
        bell = np.exp(-((at / width) ** 2))
        edge = np.minimum(1.0, np.minimum(time, time[-1] - time) / (width / 2))
        bell *= np.sin(0.5 * np.pi * edge) ** 2
        return _remove_drift(np.cos(own * at) * bell, bell, self.step)


def _remove_drift(series, bell, step: float) -> NDArray[np.float64]:
    """Subtract (a + b t) times a bell, so that velocity and displacement end at 0."""
    time = np.linspace(-1.0, 1.0, series.size)
    basis = np.array([bell, bell * time])
    ends = []
    for one in (series, *basis):
        velocity = running_integral(one, step)
        ends.append((velocity[-1], running_integral(velocity, step)[-1]))
    share = np.linalg.solve(np.array(ends[1:]).T, ends[0])
    return series - share @ basis
