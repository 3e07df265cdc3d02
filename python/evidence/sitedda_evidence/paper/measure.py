# SPDX-License-Identifier: GPL-3.0-or-later
"""Measurements on histories."""

import numpy as np
from scipy.signal import butter, sosfiltfilt

from sitedda.engine.signals import Decrement, log_decrement

_ORDER = 6  # order of the zero-phase Butterworth filter that removes higher modes


def first_mode_decay(time, x, frequency: float, cutoff: float, trim: float = 4.0) -> Decrement:
    """Return the decrement of the lowest mode in a free decay (eq. 11).

    A zero-phase filter removes higher modes without a change of the decay rate.

    `time`, `x`: shape (m,); free decay, s and any unit.
    `frequency`: approximate frequency of the lowest mode, Hz.
    `cutoff`: frequency between the two lowest modes, Hz.
    `trim`: number of periods removed at both ends after filtering.
    """
    time, x = np.asarray(time), np.asarray(x)
    step = (time[-1] - time[0]) / (time.size - 1)
    filtered = sosfiltfilt(butter(_ORDER, cutoff, fs=1 / step, output="sos"), x)
    trimmed = int(trim / frequency / step)
    return log_decrement(time[trimmed:-trimmed], filtered[trimmed:-trimmed], offset=0.0, floor=1e-3)


def sub_sample_maximum(time, x) -> tuple[float, float]:
    """Return time and value of the maximum of a series, interpolated by a parabola."""
    x = np.asarray(x)
    i = int(np.argmax(x))
    if i in (0, x.size - 1):
        return float(time[i]), float(x[i])
    left, middle, right = x[i - 1 : i + 2]
    curvature = left - 2 * middle + right
    shift = 0.5 * (left - right) / curvature if curvature else 0.0
    step = time[i + 1] - time[i]
    return float(time[i] + shift * step), float(middle - 0.25 * (left - right) * shift)
