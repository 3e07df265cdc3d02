# SPDX-License-Identifier: GPL-3.0-or-later
"""Match motions to a response spectrum by quadratic programs, without permanent motion."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base.arguments import positive
from ..base.errors import ConvergenceError, InputError
from ..engine.signals import fast_length, running_integral, spectral_acceleration
from .motion import Motion
from .motions import Target, of_acceleration, resampled, target_at

if TYPE_CHECKING:
    import xarray as xr

_FINE = 10  # samples in the shortest matched period
_PER_DECADE = 240  # number of matched periods per decade
_SCALINGS = 10  # number of rounds that scale Fourier amplitudes
_RELAXED = 0.7  # exponent of the scaling of Fourier amplitudes
_MOST_PEAKS = 3  # largest number of new bounds per oscillator and round
_EDGE = 0.03  # length of the taper at each end / duration
_SPREAD = 1.0  # s, standard deviation of the window of the envelope
_FLOOR = 0.02  # smallest / largest value of the envelope
_SHARP = 0.8  # smallest refined maximum of the misfit / limit of the misfit
_NEAR = 17  # number of periods at which a maximum is refined
_ENOUGH = 0.95  # fraction of the tolerance at which the rounds end
_STAGE = 4  # rounds between two linear problems
_RIDGE = 1e-2  # ridge added to the diagonal of the dual problem / diagonal
_LESS = 0.5  # factor of the ridge after a linear problem that decreases the misfit


def matched(
    motion,
    target: Target,
    periods: tuple[float, float] = (0.02, 5.0),
    *,
    tolerance: float = 0.05,
    damping: float = 0.05,
    most_rounds: int = 60,
) -> xr.Dataset:
    """Change a motion by the least amount that makes its response spectrum equal a target.

    1. Fourier amplitudes are multiplied by target over spectrum, a few times.
    2. The least change d of the motion a is found such that

       |u_i(t; a + d)| ≤ (1 + ε) S_i at all t, and s_i u_i(t_i; a + d) ≥ (1 − ε) S_i

       for oscillators i with target S_i, whose response u_i to a is largest at t_i with sign s_i.

    The size of d is dᵀ C⁻¹ d with C = E F E: E is the envelope of a, F removes periods beyond
    twice the longest one, and C is projected so that velocity and displacement end at rest.  With
    impulse responses as the rows of K, d = C Kᵀ λ: reversed impulse responses (Lilhanand and Tseng
    1988).  The multipliers λ ≥ 0 solve the dual problem, which contains the violated bounds.
    A ridge relaxes bounds that contradict each other. After four rounds the problem is posed again
    for the best a + d, with half the ridge if the misfit has decreased, else with twice as much.
    At the end, periods at which the misfit has a maximum are added.

    Parameters
    ----------
    motion : xarray.Dataset
        Result of :func:`sitedda.read_record`; first scaled to the target, and resampled if its time
        step is longer than a tenth of the shortest period.
    target : callable or (periods, values)
        Sa (m/s²) of periods (s).
    periods : (float, float)
        Shortest and longest matched period, s.
    tolerance : float
        Largest permitted misfit; ε is half of it.
    damping : float
        Damping ratio of the spectrum.

    Returns
    -------
    xarray.Dataset
        ``attrs['misfit']`` is the largest relative misfit, at 960 periods a decade and 8 times as
        many at its maxima.

    Raises
    ------
    ConvergenceError
        If the misfit stays above the tolerance; the message has the least misfit.

    References
    ----------
    Lilhanand, K. & Tseng, W. S. (1988). Development and application of realistic earthquake time
    histories compatible with multiple-damping design spectra. Proc. 9th World Conference on
    Earthquake Engineering II, 819-824.
    """
    low, high = map(float, periods)
    if not 0 < low < high:
        raise InputError(f"periods = {periods}: give the shortest and the longest period (s, > 0)")
    positive("tolerance", tolerance)
    ground = Motion.of(motion)
    if not np.any(ground.acceleration):
        raise InputError("a motion of zeros cannot be matched")
    subdivisions = int(np.ceil(ground.time_step / (low / _FINE) - 1e-9))
    if subdivisions > 1:
        ground = Motion.of(resampled(motion, ground.time_step / subdivisions))
    if high > ground.acceleration.size * ground.time_step / 2:
        duration = ground.acceleration.size * ground.time_step
        raise InputError(f"a motion of {duration:.3g} s cannot be matched at periods of {high:g} s")
    grid = np.geomspace(low, high, int(np.ceil(_PER_DECADE * np.log10(high / low))) + 1)
    run = _Matching(ground, grid, target, damping)
    best, smallest_misfit = run.best_round(tolerance, most_rounds)
    if smallest_misfit > tolerance:
        raise ConvergenceError(
            f"the spectrum differs by {100 * smallest_misfit:.3g} % from the target (allowed: "
            f"{100 * tolerance:g} %): choose a motion with a closer spectrum, or fewer periods"
        )
    method = f"matched to a spectrum, {low:g} to {high:g} s"
    result = of_acceleration(best, ground.time_step, method)
    result.attrs["misfit"] = smallest_misfit
    return result


class _Bound(NamedTuple):
    """At least (1 − ε), or at most (1 + ε), times the target: sign × response at a sample."""

    oscillator: int
    sample: int
    sign: float
    lower: bool


class _Matching:
    """A motion near the target, and quadratic programs for its least change."""

    def __init__(self, motion: Motion, grid, target: Target, damping: float):
        from scipy.ndimage import gaussian_filter1d

        self.step, self.size, self.damping = motion.time_step, motion.acceleration.size, damping
        self.target, self.grid, self.target_values = target, grid, target_at(target, grid)
        self.regular_size = grid.size
        self.final_zeros = np.zeros(
            int(np.ceil(grid[-1] / self.step)) + 1
        )  # zeros for free vibration
        self.length = fast_length(2 * self.size + self.final_zeros.size)
        self.frequency = np.fft.rfftfreq(self.length, self.step)
        self.filter_gain = 1 / (1 + (0.5 / grid[-1] / np.maximum(self.frequency, 1e-9)) ** 8)
        mean = np.log(self._spectral_ratio(motion.acceleration)).mean()
        scaled = motion.acceleration * np.exp(-mean)
        time = np.linspace(0.0, 1.0, self.size)
        taper = np.sin(0.5 * np.pi * np.minimum(1.0, np.minimum(time, 1 - time) / _EDGE)) ** 2
        energy = gaussian_filter1d(scaled**2, _SPREAD / self.step)
        self.envelope = taper * np.sqrt(np.maximum(energy / energy.max(), _FLOOR**2))
        self.drifts = self._colour_motion(np.array([np.ones(self.size), 1 - time]))
        speeds = running_integral(self.drifts, self.step)
        final_motions = np.array([speeds[:, -1], running_integral(speeds, self.step)[:, -1]])
        self.correction = np.linalg.inv(final_motions)  # drifts that cancel final motions
        self.motion = self._remove_final_motion(self._scale_amplitudes(scaled, taper))
        self.lower_bounds: dict[int, _Bound] = {}  # chosen lower bounds by oscillator
        self.waves: dict[_Bound, tuple] = {}  # kernel and wave of each bound
        self.filters: dict[int, tuple] = {}  # coefficients of `_oscillator_response` by oscillator

    def best_round(self, tolerance: float, most_rounds: int):
        """Return the best motion and its misfit."""
        margin, ridge = tolerance / 2, _RIDGE * _LESS
        series, best, smallest, previous = self.motion, self.motion, np.inf, np.inf
        for number in range(most_rounds):
            ratio = self._spectral_ratio(series)
            misfit = float(np.abs(ratio - 1).max())
            if misfit <= tolerance:
                misfit = self._refine_periods(series, _ENOUGH * tolerance)
                ratio = self._spectral_ratio(series)
            best, smallest = (series, misfit) if misfit < smallest else (best, smallest)
            if smallest <= _ENOUGH * tolerance:
                break
            if number % _STAGE == 0:
                ridge *= _LESS if smallest < previous else 1 / _LESS
                previous, start, series = smallest, best, best
                ratio = self._spectral_ratio(series)
                bounds, self.lower_bounds, self.waves = [], {}, {}
            bounds, sampled = self._add_violated_bounds(series, ratio, margin, bounds)
            pairs = map(self._kernel_and_wave, bounds)
            kernels, waves = map(np.array, zip(*pairs, strict=True))
            required = [sampled[bound.oscillator] * (1 - margin if bound.lower else -1 - margin)
                        for bound in bounds]  # fmt: skip
            multipliers = _maximise_dual(kernels @ waves.T, required - kernels @ start, ridge)
            series = start + multipliers @ waves
            bounds = [bound for bound, size in zip(bounds, multipliers, strict=True) if size > 0]
        return best, smallest

    def _spectral_ratio(self, series) -> NDArray[np.float64]:
        """Return the ratio of spectrum to target at the matched periods."""
        spectrum = spectral_acceleration(series, self.step, self.grid, self.damping)
        return spectrum / self.target_values

    def _refine_periods(self, series, limit: float) -> float:
        """Return the misfit at four times as many periods, and more at its maxima.

        Maxima join the grid: they are sharp, so samples underestimate them.
        """
        last = self.regular_size - 1
        grid = np.geomspace(self.grid[0], self.grid[last], 4 * last + 1)
        misfits, _ = self._misfit(series, grid)
        inner = misfits[1:-1]
        is_peak = (inner >= misfits[:-2]) & (inner > misfits[2:]) & (inner > _SHARP * limit)
        is_peak[inner.argmax()] = True
        trials = grid[1:-1][is_peak, None] * (grid[1] / grid[0]) ** np.linspace(-1, 1, _NEAR)
        trial_misfits, targets = self._misfit(series, trials.ravel())
        maxima = np.arange(len(trials)) * _NEAR + trial_misfits.reshape(trials.shape).argmax(axis=1)
        maxima = maxima[trial_misfits[maxima] > limit]
        self.grid = np.append(self.grid, trials.ravel()[maxima])
        self.target_values = np.append(self.target_values, targets[maxima])
        return float(max(misfits.max(), trial_misfits.max()))

    def _misfit(self, series, periods) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return |spectrum / target − 1| and the target at periods (s)."""
        targets = target_at(self.target, periods)
        spectrum = spectral_acceleration(series, self.step, periods, self.damping)
        return np.abs(spectrum / targets - 1), targets

    def _scale_amplitudes(self, series, edge) -> NDArray[np.float64]:
        """Scale the Fourier amplitudes of a motion towards the target."""
        logs = np.log(np.maximum(self.frequency, 1e-9))
        for _ in range(_SCALINGS):
            gains = -_RELAXED * np.log(self._spectral_ratio(series))
            gain = np.exp(np.interp(logs, -np.log(self.grid[::-1]), gains[::-1]))
            factor = self.filter_gain * gain
            series = edge * self._filter_motion(series, factor)
        return series

    def _add_violated_bounds(self, series, ratio, margin: float, bounds):
        """Return all bounds, with violated ones, and the ratio of sampled to true peak of each."""
        violated = np.flatnonzero(np.abs(ratio - 1) > margin)
        all_bounds, sampled = list(bounds), {}
        for i in sorted({*violated, *(bound.oscillator for bound in bounds)}):
            response = self._oscillator_response(i, series)
            size = np.abs(response)
            sampled[i] = size.max() / ratio[i]  # the largest response may lie between samples
            if ratio[i] < 1 - margin:
                sample = int(size.argmax())
                first = _Bound(i, sample, float(np.sign(response[sample])), True)
                all_bounds.append(self.lower_bounds.setdefault(i, first))
            inner = size[1:-1]
            peaks = (inner >= size[:-2]) & (inner > size[2:]) & (inner > (1 + margin) * sampled[i])
            peaks = np.flatnonzero(peaks) + 1
            for sample in peaks[np.argsort(-size[peaks])][:_MOST_PEAKS]:
                all_bounds.append(_Bound(i, int(sample), float(np.sign(response[sample])), False))
        return list(dict.fromkeys(all_bounds)), sampled

    def _oscillator_response(self, number: int, series) -> NDArray[np.float64]:
        """Return pseudo-acceleration / target of an oscillator, during and after the motion.

        The recursion is exact for a motion that is straight between samples.
        """
        from scipy.signal import cont2discrete, lfilter

        if number not in self.filters:
            omega = 2 * np.pi / self.grid[number]
            system = (
                [-(omega**2) / self.target_values[number]],
                [1.0, 2 * self.damping * omega, omega**2],
            )
            (numerator,), denominator, _ = cont2discrete(system, self.step, "foh")
            self.filters[number] = numerator, denominator
        return lfilter(*self.filters[number], np.append(series, self.final_zeros))

    def _kernel_and_wave(self, bound: _Bound):
        """Return kernel k and wave C k of a bound; k · a is its signed response to a motion a."""
        if bound not in self.waves:
            kernel = np.zeros(self.size)
            impulse = self._oscillator_response(bound.oscillator, np.eye(1, self.size)[0])
            history = impulse[: bound.sample + 1][::-1][: self.size]
            kernel[: history.size] = history if bound.lower == (bound.sign > 0) else -history
            self.waves[bound] = kernel, self._remove_final_motion(self._colour_motion(kernel))
        return self.waves[bound]

    def _filter_motion(self, series, factor) -> NDArray[np.float64]:
        """Multiply the Fourier spectrum of a motion by a factor for each frequency."""
        spectrum = np.fft.rfft(series, self.length) * factor
        return np.fft.irfft(spectrum, self.length)[..., : self.size]

    def _colour_motion(self, series) -> NDArray[np.float64]:
        """Multiply a series by the envelope, filter it, and multiply it by the envelope again."""
        return self.envelope * self._filter_motion(self.envelope * series, self.filter_gain)

    def _remove_final_motion(self, series) -> NDArray[np.float64]:
        """Subtract two waves, so that velocity and displacement end at 0."""
        velocity = running_integral(series, self.step)
        final_motion = velocity[-1], running_integral(velocity, self.step)[-1]
        return series - self.correction @ final_motion @ self.drifts


def _maximise_dual(product, deficits, ridge: float) -> NDArray[np.float64]:
    """Return the λ ≥ 0 that maximises λ · lack − λᵀ product λ/2."""
    from scipy.optimize import nnls

    regularisation = ridge * np.diag(np.diag(product))
    factor = np.linalg.cholesky((product + product.T) / 2 + regularisation)
    return nnls(factor.T, np.linalg.solve(factor, deficits), maxiter=30 * deficits.size)[0]
