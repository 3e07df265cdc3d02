# SPDX-License-Identifier: GPL-3.0-or-later
"""Analyse records and computed histories: decay, smoothing, response spectra, frequency.

The functions call the engine, scipy and pyKOOH.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.arguments import positive
from ..base.core import api
from ..base.errors import InputError

__all__ = [
    "Decrement",
    "ResponseSpectrum",
    "arias_growth",
    "arias_intensity",
    "dominant_frequency",
    "log_decrement",
    "low_pass",
    "low_passed",
    "response_spectrum",
    "running_integral",
    "smooth_konno_ohmachi",
    "spectral_acceleration",
]

GRAVITY = 9.80665  # m/s², for the Arias intensity
_BUTTERWORTH = np.cos(np.array([1.0, 3.0]) * np.pi / 8.0)  # damping of the poles, as in the engine

_FASTEST = 1e4  # largest number of oscillations between two samples
_PADDING = 8  # zero-padding factor of the spectrum for the dominant frequency


# ---------------------------------------------------------------------------------------------
# Logarithmic decrement
# ---------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Decrement:
    """Damping of a decaying oscillation; n is the number of cycles between the crests used.

    Parameters
    ----------
    damping : float
        ζ = ln(A0/An) / 2πn, paper eq. 11 (first order in ζ).
    damping_exact : float
        ζ = δ / √(4π²n² + δ²) with δ = ln(A0/An), exact for a viscously damped oscillator.
    frequency : float
        Damped frequency: number of cycles / time between the first and the last crest, Hz.
    times : ndarray, shape (n + 1,)
        Times of the crests used, s.
    crests : ndarray, shape (n + 1,)
        Heights of these crests above ``offset``, in the unit of the signal.
    offset : float
        Value about which the signal oscillates, in the unit of the signal.
    residual : float
        Root mean square deviation of ln(crest) from its regression line over the crest number, i.e.
        the relative scatter of the crests.  It is almost 0 for an exponential decay; 0.05 (5 %)
        means a poor fit.  It is 0 for two crests.
    """

    damping: float
    damping_exact: float
    frequency: float
    times: NDArray[np.float64]
    crests: NDArray[np.float64]
    offset: float
    residual: float


def log_decrement(
    time: ArrayLike,
    x: ArrayLike,
    cycles: int | None = None,
    offset: float | None = None,
    floor: float = 0.01,
) -> Decrement:
    """Compute damping ratio and frequency of a free decay by eq. 11 of the paper.

    Parabolas through three samples locate crests and troughs.  The first crest that is used is the
    highest.

    Parameters
    ----------
    time : array_like, shape (m,)
        Equidistant times, s.
    x : array_like, shape (m,)
        The free decay, any unit, without the motion before it.
    cycles : int, optional
        Number of cycles n; by default all cycles of the signal.
    offset : float, optional
        Value c about which the signal oscillates.  By default it is computed from the extrema e,
        which for one decaying mode satisfy e[k+1] - c = -q (e[k] - c) exactly.
    floor : float
        Smallest prominence of an extremum, as fraction of the range of x; smaller ones are noise.
    """
    step, values = _check_equidistant(time, x)
    if not 0 < floor < 1:
        raise InputError(f"floor must be in 0 ... 1, got {floor!r}")
    if cycles is not None and (cycles != int(cycles) or cycles < 1):
        raise InputError(f"cycles must be a whole number >= 1, got {cycles!r}")
    peak_to_peak = np.ptp(values)
    crest_at, crest = _find_crests(values, floor * peak_to_peak)
    if offset is None:
        trough_at, trough = _find_crests(-values, floor * peak_to_peak)
        offset = _fit_offset(crest_at, crest, trough_at, -trough)
    elif not np.isfinite(offset):
        raise InputError(f"offset must be finite, got {offset!r}")
    crests, height = _select_crests(crest_at, crest - offset, cycles)
    return _make_decrement(np.asarray(time, dtype=float)[0] + step * crests, height, float(offset))


def _find_crests(
    values: NDArray[np.float64], prominence: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return positions (in samples) and heights of maxima, by parabolas through three samples."""
    if prominence == 0:
        return np.empty(0), np.empty(0)
    from scipy.signal import find_peaks

    peak, _ = find_peaks(values, prominence=prominence)
    left, centre, right = values[peak - 1], values[peak], values[peak + 1]
    bend = left - 2 * centre + right
    bend[bend == 0] = -np.inf  # a plateau: its position is not shifted
    shift = 0.5 * (left - right) / bend
    return peak + shift, centre - 0.25 * (left - right) * shift


def _fit_offset(
    crest_at: NDArray[np.float64],
    crest: NDArray[np.float64],
    trough_at: NDArray[np.float64],
    trough: NDArray[np.float64],
) -> float:
    """Fit the offset c of e[k+1] = -q e[k] + (1 + q) c to successive extrema."""
    order = np.argsort(np.concatenate([crest_at, trough_at]))
    extrema = np.concatenate([crest, trough])[order]
    is_crest = (np.arange(order.size) < crest.size)[order]
    alternates = is_crest[1:] != is_crest[:-1]
    e, next_extrema = extrema[:-1][alternates], extrema[1:][alternates]
    if e.size < 2 or np.ptp(e) == 0:
        raise InputError(
            f"x has {extrema.size} extrema, but at least three are needed to compute its offset;"
            " give offset, a longer record or a lower floor"
        )
    offsets, next_mean = e - e.mean(), next_extrema.mean()
    slope = np.sum(offsets * (next_extrema - next_mean)) / np.sum(offsets**2)
    if not slope < 0:
        raise InputError("x does not oscillate about a constant; give offset or a higher floor")
    return float((next_mean - slope * e.mean()) / (1 - slope))


def _select_crests(
    crests: NDArray[np.float64], height: NDArray[np.float64], cycles: int | None
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the requested number of crests above the offset, starting at the highest crest."""
    start = int(np.argmax(height)) if height.size else 0
    crests, height = crests[start:], height[start:]
    negative = np.flatnonzero(height <= 0)
    count = int(negative[0]) if negative.size else height.size
    requested = count if cycles is None else int(cycles) + 1
    if count < max(requested, 2):
        raise InputError(
            f"x has {count} decaying crests, but {max(requested, 2)} are needed;"
            " give a longer record, fewer cycles or a lower floor"
        )
    return crests[:requested], height[:requested]


def _make_decrement(
    times: NDArray[np.float64], crests: NDArray[np.float64], offset: float
) -> Decrement:
    """Compute damping ratios and frequency from times (s) and heights of crests."""
    count = crests.size - 1
    logs = np.log(crests)
    delta = logs[0] - logs[-1]
    number = np.arange(crests.size)
    line = np.polynomial.Polynomial.fit(number, logs, 1)
    return Decrement(
        damping=float(delta / (2 * np.pi * count)),
        damping_exact=float(delta / np.hypot(2 * np.pi * count, delta)),
        frequency=float(count / (times[-1] - times[0])),
        times=times,
        crests=crests,
        offset=offset,
        residual=float(np.sqrt(np.mean((logs - line(number)) ** 2))) if count > 1 else 0.0,
    )


# ---------------------------------------------------------------------------------------------
# Konno-Ohmachi smoothing
# ---------------------------------------------------------------------------------------------

_LEAST_WINDOW = 0.3  # smallest sum of weights; if it is smaller, the main lobe contains no sample
_MOST_WEIGHTS = 2**17  # weights computed at once, limited by the cache


def smooth_konno_ohmachi(
    frequency: ArrayLike,
    spectrum: ArrayLike,
    bandwidth: float = 40.0,
    centres: ArrayLike | None = None,
) -> NDArray[np.float64]:
    """Smooth an amplitude spectrum with the window of Konno & Ohmachi (1998).

    The weights ``[sin(b log10(f/fc)) / (b log10(f/fc))]⁴`` are normalised to unit sum; at 0 Hz the
    result is the first amplitude.

    Parameters
    ----------
    frequency : array_like, shape (n,)
        Frequencies of the spectrum, Hz, >= 0 and increasing.
    spectrum : array_like, shape (n,)
        Amplitudes; complex values are replaced by their magnitude.
    bandwidth : float
        b; a smaller value smooths more.
    centres : array_like, shape (m,), optional
        Frequencies of the result, Hz; by default ``frequency``.

    Raises
    ------
    InputError
        If arguments differ in length or are not finite, or a window contains no sample.

    References
    ----------
    Konno, K. & Ohmachi, T. (1998). Ground-motion characteristics estimated from spectral ratio
    between horizontal and vertical components of microtremor. BSSA 88(1), 228-241.
    """
    frequencies = _check_vector("frequency", frequency)
    amplitudes = _check_vector("spectrum", np.abs(np.asarray(spectrum)))
    if amplitudes.size != frequencies.size:
        sizes = f"{frequencies.size} and {amplitudes.size}"
        raise InputError(f"frequency and spectrum must have the same length, got {sizes}")
    if frequencies.size == 0 or frequencies[0] < 0 or np.any(np.diff(frequencies) <= 0):
        raise InputError("frequency must contain increasing values >= 0")
    width = float(positive("bandwidth", bandwidth))
    targets = frequencies if centres is None else _check_vector("centres", centres)
    if np.any(targets < 0):
        raise InputError(f"centres must not be negative, got {targets.min():g} Hz")
    is_positive = frequencies > 0
    log_f, amplitude = np.log10(frequencies[is_positive]), amplitudes[is_positive]
    smoothed = np.full(targets.size, amplitudes[0])
    indices = np.flatnonzero(targets > 0)
    for chunk in np.array_split(indices, indices.size * log_f.size // _MOST_WEIGHTS + 1):
        weight = np.sinc(width / np.pi * (log_f - np.log10(targets[chunk])[:, None])) ** 2
        weight *= weight
        total = weight.sum(axis=1)
        if np.any(void := total <= _LEAST_WINDOW):
            raise InputError(
                f"the window at the centre {targets[chunk][void][0]:g} Hz with bandwidth {width:g} "
                "contains no sample; use other centres or a smaller bandwidth"
            )
        smoothed[chunk] = weight @ amplitude / total
    return smoothed


# ---------------------------------------------------------------------------------------------
# Response spectrum
# ---------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class ResponseSpectrum:
    """Largest responses of linear oscillators to a ground acceleration, each of shape (n,).

    Parameters
    ----------
    frequencies : ndarray
        Natural frequencies of the oscillators, Hz.
    displacement : ndarray
        Largest displacement relative to the ground, unit of the acceleration × s².
    velocity : ndarray
        Largest relative velocity, unit of the acceleration × s.
    acceleration : ndarray
        Largest absolute acceleration, unit of the ground acceleration.
    """

    frequencies: NDArray[np.float64]
    displacement: NDArray[np.float64]
    velocity: NDArray[np.float64]
    acceleration: NDArray[np.float64]

    @property
    def periods(self) -> NDArray[np.float64]:
        """Natural periods, s."""
        return 1 / self.frequencies

    @property
    def pseudo_velocity(self) -> NDArray[np.float64]:
        """Pseudo-spectral velocity: ω × displacement."""
        return 2 * np.pi * self.frequencies * self.displacement

    @property
    def pseudo_acceleration(self) -> NDArray[np.float64]:
        """Pseudo-spectral acceleration: ω² × displacement."""
        return (2 * np.pi * self.frequencies) ** 2 * self.displacement


def response_spectrum(
    acceleration: ArrayLike,
    time_step: float,
    periods: ArrayLike | None = None,
    damping: float = 0.05,
    *,
    frequencies: ArrayLike | None = None,
) -> ResponseSpectrum:
    """Compute the response spectrum of a ground acceleration, with oscillators initially at rest.

    The result is exact for an acceleration that is linear between samples (Nigam & Jennings, 1969).
    For fast oscillators, maxima between the samples are included.  The response ends at the last
    sample: append zeros to include the free vibration.

    Parameters
    ----------
    acceleration : array_like, shape (m,), m >= 2
        Ground acceleration, any unit.
    time_step : float
        Sampling interval, s.
    periods : array_like, shape (n,)
        Natural periods of the oscillators, s, > 0.
    damping : float
        Damping ratio, 0 <= ζ < 1.
    frequencies : array_like, shape (n,)
        Natural frequencies, Hz, > 0, instead of periods.

    References
    ----------
    Nigam, N. C. & Jennings, P. C. (1969). Calculation of response spectra from strong-motion
    earthquake records. BSSA 59(2), 909-922.
    """
    ground = _check_vector("acceleration", acceleration)
    if ground.size < 2:
        raise InputError(f"acceleration must contain at least two samples, got {ground.size}")
    step = float(positive("time_step", time_step))
    naturals = _natural_hz(periods, frequencies)
    if not np.all(naturals * step <= _FASTEST):
        shortest = step / _FASTEST
        raise InputError(f"periods must be at least {shortest:g} s, got {1 / naturals.max():g} s")
    if not 0 <= damping < 1:
        raise InputError(f"damping must be in 0 <= damping < 1, got {damping!r}")
    return ResponseSpectrum(naturals, *api.oscillator_peaks_of(ground, step, naturals, damping))


def _natural_hz(periods: ArrayLike | None, frequencies: ArrayLike | None) -> NDArray[np.float64]:
    """Return natural frequencies (Hz) from either periods (s) or frequencies (Hz)."""
    if (periods is None) == (frequencies is None):
        raise InputError("give either `periods` or `frequencies`, not both")
    if frequencies is None:
        return 1 / positive("periods", _check_vector("periods", periods))
    return positive("frequencies", _check_vector("frequencies", frequencies))


def spectral_acceleration(
    acceleration: ArrayLike, time_step: float, periods: ArrayLike, damping: float = 0.05
) -> NDArray[np.float64]:
    """Compute the pseudo-spectral acceleration Sa, including free vibration after the record.

    Parameters
    ----------
    acceleration : array_like, shape (m,), m >= 2
        Ground acceleration, any unit.
    time_step : float
        Sampling interval, s.
    periods : array_like, shape (n,)
        Natural periods, s, > 0.
    damping : float
        Damping ratio, 0 <= ζ < 1.
    """
    longest = 1 / _natural_hz(periods, None).min()
    zeros = np.zeros(int(np.ceil(longest / float(positive("time_step", time_step)))) + 1)
    ground = np.concatenate([_check_vector("acceleration", acceleration), zeros])
    return response_spectrum(ground, time_step, periods, damping).pseudo_acceleration


def low_pass(length: int, time_step: float, frequency: float) -> NDArray[np.complex128]:
    """Return the engine's fourth-order Butterworth filter on the grid of `scipy.fft.rfftfreq`.

    Parameters
    ----------
    length : int
        Length of the motion, samples.
    time_step : float
        Sampling interval, s.
    frequency : float
        Corner frequency (half power), Hz.
    """
    warped = np.tan(np.pi * np.minimum(np.fft.rfftfreq(length, time_step) * time_step, 0.4999))
    s = 1j * warped / np.tan(np.pi * min(frequency * time_step, 0.45))
    return 1.0 / np.prod([s * s + 2.0 * c * s + 1.0 for c in _BUTTERWORTH], axis=0)


def low_passed(motion: ArrayLike, time_step: float, frequency: float) -> NDArray[np.float64]:
    """Filter a motion, shape (m,), sampled every `time_step` s, by `low_pass`; frequency in Hz."""
    values = np.asarray(motion, dtype=float)
    length = fast_length(2 * len(values))
    spectrum = np.fft.rfft(values, length) * low_pass(length, time_step, frequency)
    return np.fft.irfft(spectrum, length)[: len(values)]


def fast_length(minimum: int) -> int:
    """Return the smallest length >= `minimum` without prime factors above 5, for fast FFTs."""
    power = 1 << (minimum - 1).bit_length()
    odd_factors = [3**i * 5**j for i in range(40) for j in range(28)]
    products = (n << max(0, -(-minimum // n) - 1).bit_length() for n in odd_factors if n < power)
    return min([power, *products])


def running_integral(series: ArrayLike, time_step: float) -> NDArray[np.float64]:
    """Integrate along the last axis by trapezoids, with 0 at the start; the shape is unchanged."""
    values = np.asarray(series, dtype=float)
    sums = np.cumsum((values[..., 1:] + values[..., :-1]) * time_step / 2, axis=-1)
    return np.concatenate([np.zeros_like(values[..., :1]), sums], axis=-1)


def arias_intensity(acceleration: ArrayLike, time_step: float) -> float:
    """Return the Arias intensity π/2g ∫a² dt, m/s, of an acceleration, m/s², shape (m,)."""
    return float(arias_growth(acceleration, time_step)[-1])


def arias_growth(acceleration: ArrayLike, time_step: float) -> NDArray[np.float64]:
    """Return the Arias intensity up to each sample, m/s, shape (m,)."""
    squares = np.asarray(acceleration, dtype=float) ** 2
    return np.pi / (2 * GRAVITY) * running_integral(squares, time_step)


# ---------------------------------------------------------------------------------------------
# Dominant frequency
# ---------------------------------------------------------------------------------------------


def dominant_frequency(x: ArrayLike, dt: float, band: tuple[float, float] | None = None) -> float:
    """Return the interpolated frequency (Hz) of the highest peak of the amplitude spectrum.

    The mean is removed, a Hann window is applied, and the record is padded with zeros; a parabola
    through the logarithms of three amplitudes locates the peak.

    Parameters
    ----------
    x : array_like, shape (m,), m >= 8
        The signal, any unit.
    dt : float
        Sampling interval, s.
    band : (float, float), optional
        Band to search, Hz; by default from 0 to the Nyquist frequency.
    """
    from scipy.signal.windows import hann

    values = _check_vector("x", x)
    step = float(positive("dt", dt))
    if values.size < 8:
        raise InputError(f"x must contain at least 8 samples, got {values.size}")
    low, high = _check_band(band, 0.5 / step)
    windowed = (values - values.mean()) * hann(values.size, sym=False)
    length = _PADDING * values.size
    size = np.abs(np.fft.rfft(windowed, length))
    line = np.arange(1, size.size - 1)
    summit = line[(size[line] > size[line - 1]) & (size[line] >= size[line + 1])]
    summit = summit[(summit >= low * length * step) & (summit <= high * length * step)]
    floor = 1e-12 * np.abs(values).sum()  # smaller peaks are rounding errors
    if summit.size == 0 or size[summit].max() <= floor:
        raise InputError(f"the spectrum of x has no peak in the band {low:g} ... {high:g} Hz")
    peak = summit[np.argmax(size[summit])]
    left, centre, right = np.log(np.maximum(size[peak - 1 : peak + 2], np.finfo(float).tiny))
    shift = 0.5 * (left - right) / (left - 2 * centre + right)
    return float((peak + shift) / (length * step))


# ---------------------------------------------------------------------------------------------
# Checks of arguments
# ---------------------------------------------------------------------------------------------


def _check_vector(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """Return an argument as a vector of finite real numbers; raise InputError if it is none."""
    if np.iscomplexobj(value):
        raise InputError(f"{name} must be real, got complex values")
    values = np.asarray(value, dtype=float)
    if values.ndim != 1:
        raise InputError(f"{name} must be one-dimensional, got shape {values.shape}")
    if not np.all(np.isfinite(values)):
        index = int(np.flatnonzero(~np.isfinite(values))[0])
        raise InputError(f"{name} must be finite, got {values[index]} at index {index}")
    return values


def _check_band(band: tuple[float, float] | None, nyquist: float) -> tuple[float, float]:
    """Return both ends of a frequency band (Hz), by default 0 and the Nyquist frequency."""
    edges = np.asarray((0.0, nyquist) if band is None else band, dtype=float)
    if edges.shape != (2,) or not 0 <= edges[0] < edges[1] <= nyquist * (1 + 1e-12):
        raise InputError(f"band must be 0 <= low < high <= {nyquist:g} Hz, got {band!r}")
    return float(edges[0]), float(edges[1])


def _check_equidistant(time: ArrayLike, x: ArrayLike) -> tuple[float, NDArray[np.float64]]:
    """Return sampling interval (s) and values of a history; raise InputError if it is uneven."""
    times, values = _check_vector("time", time), _check_vector("x", x)
    if times.size != values.size or times.size < 3:
        sizes = f"{times.size} and {values.size}"
        raise InputError(f"time and x must have the same length >= 3, got {sizes}")
    step = (times[-1] - times[0]) / (times.size - 1)
    if step <= 0 or np.any(np.abs(np.diff(times) - step) > 1e-3 * step):
        raise InputError("time must be equidistant and increasing")
    return float(step), values
