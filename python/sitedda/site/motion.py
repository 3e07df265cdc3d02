# SPDX-License-Identifier: GPL-3.0-or-later
"""A ground motion in the frequency domain."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..base.arguments import positive
from ..base.errors import InputError
from ..engine.signals import fast_length

_MOST_ZEROS = 31  # largest number of zeros / number of samples


@dataclass(frozen=True)
class Motion:
    """Acceleration at equal steps, followed by zeros for the free vibration after it."""

    acceleration: NDArray[np.float64]  # m/s²
    time_step: float  # s
    length: int  # number of samples including the zeros

    @classmethod
    def of(cls, motion, time_step: float | None = None) -> "Motion":
        """Create a motion from a Dataset of :func:`sitedda.read_record`, or array and time step.

        A Motion is returned as it is.
        """
        if isinstance(motion, Motion):
            return motion
        if hasattr(motion, "acceleration"):
            if time_step is not None:
                raise InputError("omit time_step: the record states its time step")
            series = np.asarray(motion.acceleration.values, dtype=float)
            time_step = equal_step(motion.time.values)
        else:
            if time_step is None:
                raise InputError("an array of accelerations needs time_step")
            series = np.array(motion, dtype=float)
        if series.ndim != 1 or series.size < 2:
            raise InputError(f"a motion needs a row of 2 or more samples, not shape {series.shape}")
        if not np.all(np.isfinite(series)):
            index = int(np.flatnonzero(~np.isfinite(series))[0])
            raise InputError(f"sample {index} of the motion is {series[index]}")
        step = float(positive("time_step", time_step))
        return cls(series, step, fast_length(2 * series.size))

    def padded(self, duration: float) -> "Motion":
        """Return the motion with zeros of at least this duration (s), up to `_MOST_ZEROS`."""
        samples = self.acceleration.size
        zeros = min(duration / self.time_step, _MOST_ZEROS * samples)
        return replace(self, length=max(self.length, fast_length(samples + int(zeros))))

    @property
    def zeros(self) -> float:
        """Return the duration of the zeros after the samples, s."""
        return self.time_step * (self.length - self.acceleration.size)

    @property
    def frequencies(self) -> NDArray[np.float64]:
        """Return the frequencies, Hz, shape (length // 2 + 1,)."""
        return np.fft.rfftfreq(self.length, self.time_step)

    @property
    def spectrum(self) -> NDArray[np.complex128]:
        """Return the discrete Fourier transform, m/s², shape (length // 2 + 1,)."""
        return np.fft.rfft(self.acceleration, self.length)

    def history(self, spectrum: NDArray[np.complex128]) -> NDArray[np.float64]:
        """Transform a spectrum back to the samples; shape (..., samples)."""
        return np.fft.irfft(spectrum, self.length, axis=-1)[..., : self.acceleration.size]


def equal_step(times) -> float:
    """Return the step between times (s); raise InputError if the steps differ."""
    step = float((times[-1] - times[0]) / (times.size - 1)) if times.size > 1 else 0.0
    if np.any(np.abs(np.diff(times) - step) > 1e-6 * step):
        raise InputError(
            "the samples of the motion are not at equal time steps: resample a record, or run "
            "without adaptive control"
        )
    return step
