# SPDX-License-Identifier: GPL-3.0-or-later
"""Site response of a finished run: amplification computed from its histories."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from ..engine.spectra import Peak, amplification, find_peak
from ..input.input_text import input_values

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class Amplification:
    """The spectral ratio of two measured points and its peak.

    Attributes
    ----------
    surface, base : str
        Names of the points.
    direction : str
        'x' or 'y'.
    frequency : ndarray, shape (bins,)
        Hz, from `lowest` to `highest` of the request.
    ratio : ndarray, shape (bins,)
        Modulus of the ratio of the Fourier spectra of the accelerations.
    peak : Peak
        Largest ratio in the band.
    """

    surface: str
    base: str
    direction: str
    frequency: np.ndarray
    ratio: np.ndarray
    peak: Peak

    def __str__(self) -> str:
        """Return one line, as printed by the native executable."""
        source = "peak interpolated" if self.peak.interpolated else "peak at a bin"
        return (
            f'amplification {self.surface}/{self.base} ("within"): {self.peak.amplitude:.3f} at '
            f"{self.peak.frequency:.4f} Hz (bin width {self.peak.bin_width:.6f} Hz, {source})"
        )


def amplifications(history: xr.Dataset) -> list[Amplification]:
    """Return the amplifications that the groups &amplification of a run request."""
    groups = input_values(history.attrs).get("amplification", [])
    return [
        point_amplification(
            history,
            group.get("surface", "surface"),
            group.get("base", "base"),
            group["lowest"],
            group["highest"],
            group.get("direction", "x"),
            group.get("padding", 8),
        )
        for group in groups
    ]


def point_amplification(
    history: xr.Dataset,
    surface: str,
    base: str,
    lowest: float,
    highest: float,
    direction: str = "x",
    padding: int = 8,
) -> Amplification:
    """Return the amplification between two points, with its peak between two frequencies (Hz)."""
    axis = ("x", "y").index(direction)
    upper, lower = (
        history.acceleration.sel(point=name).isel(axis=axis).values for name in (surface, base)
    )
    time = history.time.values
    frequency, ratio = spectral_ratio(upper, lower, (time[-1] - time[0]) / (time.size - 1), padding)
    peak = find_peak(frequency, abs(ratio), lowest, highest)
    band = (frequency >= lowest) & (frequency <= highest)
    return Amplification(surface, base, direction, frequency[band], abs(ratio[band]), peak)


def spectral_ratio(upper, lower, time_step: float, padding: int) -> tuple[np.ndarray, np.ndarray]:
    """Return a cached `amplification`, which texts and pictures of a run share."""
    motions = (np.ascontiguousarray(motion, dtype=float).tobytes() for motion in (upper, lower))
    return _spectral_ratio(*motions, float(time_step), padding)


@lru_cache(maxsize=2)
def _spectral_ratio(upper: bytes, lower: bytes, time_step: float, padding: int):
    """Return the `amplification` of two motions, which are given as bytes."""
    return amplification(np.frombuffer(upper), np.frombuffer(lower), time_step, padding)
