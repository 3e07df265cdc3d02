# SPDX-License-Identifier: GPL-3.0-or-later
"""A run of layered blocks and its one-dimensional column side by side."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..engine.scheme import Scheme
from ..engine.signals import spectral_acceleration
from ..engine.spectra import amplification, find_peak
from ..output.response import amplifications
from ..output.verdict import run_scheme
from .column import Column
from .intensity import intensity
from .layers import convention_words
from .response import ColumnResponse
from .twin import layered_twin

_SHOWN = (0.1, 0.2, 0.5, 1.0)  # s, periods of the table


@dataclass(frozen=True)
class Beside:
    """What blocks and column say of the same site.

    Attributes
    ----------
    response : ColumnResponse
        Of the column under the motion of the blocks' base.
    surface, base, column_surface : ndarray, shape (samples,)
        Accelerations, m/s²: of the blocks at surface and base, of the column at the surface.
    frequency : ndarray, shape (bins,)
        Hz.
    ratio, column_ratio : ndarray, shape (bins,)
        Surface over base, of the blocks and of the column.
    points : tuple of ndarray
        Depths (m) and peak accelerations (m/s²) of the measured points.
    damping : str
        What damps the column.
    title : str
    """

    response: ColumnResponse
    surface: NDArray[np.float64]
    base: NDArray[np.float64]
    column_surface: NDArray[np.float64]
    frequency: NDArray[np.float64]
    ratio: NDArray[np.complex128]
    column_ratio: NDArray[np.complex128]
    points: tuple[NDArray[np.float64], NDArray[np.float64]]
    damping: str
    title: str

    @property
    def time(self) -> NDArray[np.float64]:
        """s, shape (samples,)."""
        return self.response.time

    def __str__(self) -> str:
        step = self.response.motion.time_step
        low, high = self.frequency[0], self.frequency[-1]
        peaks = [find_peak(self.frequency, abs(r), low, high) for r in self._ratios]
        series = (self.surface, self.column_surface)
        spectra = [spectral_acceleration(s, step, _SHOWN) for s in series]
        lines = [f"{'':28s}{'blocks':>12s}{'column':>12s}"]

        def row(name, values, unit):
            lines.append(f"{name:28s}{values[0]:12.4g}{values[1]:12.4g} {unit}".rstrip())

        row("amplification, largest", [p.amplitude for p in peaks], "")
        row("  at", [p.frequency for p in peaks], "Hz")
        row("surface PGA", [np.abs(s).max() for s in series], "m/s²")
        row("surface Arias intensity", [intensity(s, step).arias for s in series], "m/s")
        for at, period in enumerate(_SHOWN):
            row(f"surface Sa at {period:g} s", [s[at] for s in spectra], "m/s²")
        return "\n".join([f"column: {self.damping}; {self.response.words}", *lines])

    def plot(self):
        """Both in one picture; a matplotlib.figure.Figure."""
        from .picture import beside_figure

        return beside_figure(self)

    @property
    def _ratios(self):
        return self.ratio, self.column_ratio


def beside(
    history: xr.Dataset,
    surface: str | None = None,
    base: str | None = None,
    damping: float | None = None,
) -> Beside:
    """Put a finished run beside the column that it models.

    Parameters
    ----------
    history : xarray.Dataset
        Of a run, with measured points at surface and base, in equal steps.
    surface, base : str, optional
        Their names; by default those of the input's first &amplification.
    damping : float, optional
        Damping ratio of the column's layers; by default the damping of the run: that of its time
        integration and of its materials.

    Returns
    -------
    Beside

    Raises
    ------
    ValueError
        If the model is not layered, points are missing or the steps are not equal.
    """
    found = amplifications(history)
    if found:
        surface, base = surface or found[0].surface, base or found[0].base
    names = [str(name) for name in history.point.values] if "point" in history.coords else []
    for role, name in (("surface", surface), ("base", base)):
        if name not in names:
            raise ValueError(
                f"no measured point {name!r} for the {role}: name it by --{role}; there are "
                + (", ".join(names) or "none")
            )
    column = layered_twin(history, surface, base)
    series = {name: history.acceleration.sel(point=name).sel(axis="x").values for name in names}
    time = history.time.values
    step = (time[-1] - time[0]) / (time.size - 1)
    if np.any(np.abs(np.diff(time) - step) > 1e-6 * step):
        raise ValueError("the samples of the run are not at equal steps (adaptive time steps)")
    response, words = _response(column, series[base], step, run_scheme(history), damping)
    frequency, ratio = amplification(series[surface], series[base], step, 8)
    band = (frequency >= 0.2) & (frequency <= min(25.0, 0.4 / step))
    return Beside(
        response,
        series[surface],
        series[base],
        response.acceleration(),
        frequency[band],
        ratio[band],
        response.transfer(frequency[band]),
        _points(history, series, surface, column.depth),
        words,
        str(history.attrs.get("title", "")),
    )


def _response(column: Column, ground, step: float, scheme: Scheme, damping: float | None):
    """The column under the base's motion, and what damps it."""
    if damping is None:
        damped = any(layer.damping for layer in column.layers)
        also = "and the materials" if damped else "alone"
        return (
            ColumnResponse.of(column, ground, step, kind="within", scheme=scheme),
            f"damped by the time integration {also}, as the blocks",
        )
    damped = replace(column, layers=[replace(la, damping=damping) for la in column.layers])
    return (
        ColumnResponse.of(damped, ground, step, kind="within"),
        f"damping ratio {100 * damping:g} % at all frequencies, "
        + convention_words(damped.convention),
    )


def _points(history, series, surface: str, depth: float):
    """Depths and peak accelerations of the measured points within the column."""
    top = float(history.point_place.sel(point=surface).values[1])
    depths = {n: top - float(history.point_place.sel(point=n).values[1]) for n in series}
    inside = [name for name, at in depths.items() if -1e-9 <= at <= depth * 1.2]
    return (
        np.array([min(depths[name], depth) for name in inside]),
        np.array([np.abs(series[name]).max() for name in inside]),
    )
