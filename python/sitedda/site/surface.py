# SPDX-License-Identifier: GPL-3.0-or-later
"""Compute the amplification along the surface of a run by topography and soil."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..base.errors import InputError
from ..engine.signals import fast_length, running_integral, smooth_konno_ohmachi
from ..engine.spectra import fourier_spectrum
from ..input.input_text import input_values
from ..output.scene import Scene
from ..output.verdict import run_scheme, run_step
from .motion import equal_step
from .twin import column_below

if TYPE_CHECKING:
    import xarray as xr

BANDWIDTH = 40.0  # bandwidth of the window of Konno and Ohmachi
_BINS = 120  # number of frequencies of the map
_FINE = 20.0  # smallest number of bins below the lowest frequency, so that no window is empty
_TOUCHING = 1e-6  # tolerance of points on the surface / size of the model
# Columns that amplify the reference more are omitted at this frequency.  A layer on rigid rock
# amplifies its first mode by 2/(πξ), 318 for a damping ratio ξ of 0.2 %.
_MOST_GAIN = 320.0


@dataclass(frozen=True)
class Surface:
    """Ratios of the motion of measured points along the surface to that of a reference."""

    scene: Scene  # scene of the run
    names: list[str]  # names of the points from left to right
    place: NDArray[np.float64]  # positions of the points, shape (points, 2), m
    frequency: NDArray[np.float64]  # Hz
    # Ratio of the smoothed Fourier spectra of acceleration, shape (points, bins)
    amplification: NDArray[np.float64]
    peak_acceleration: NDArray[np.float64]  # ratios of the peaks
    peak_velocity: NDArray[np.float64]
    reference: str  # reference of the ratios, in words
    # The same ratio of the column of layers below each point, with the time step of the run; NaN
    # if the model has no such column, or the axis is y
    column_amplification: NDArray[np.float64]

    @property
    def aggravation(self) -> NDArray[np.float64]:
        """Return the ratio of 2-D to 1-D amplification, shape (points, bins)."""
        return self.amplification / self.column_amplification

    @property
    def aggravation_factor(self) -> NDArray[np.float64]:
        """Return the geometric mean of the aggravation over the band, shape (points,)."""
        return np.exp(np.mean(np.log(self.aggravation), axis=1))

    def __str__(self) -> str:
        lines = [f"amplification relative to the {self.reference}",
                 f"{'point':16s}{'x (m)':>9s}{'PGA':>8s}{'PGV':>8s}{'largest':>9s} {'at (Hz)':8s}"
                 f"{'2-D/1-D':>8s}{'largest':>9s}"]  # fmt: skip
        for i, name in enumerate(self.names):
            top = int(np.argmax(self.amplification[i]))
            lines.append(
                f"{name:16s}{self.place[i, 0]:9.4g}{self.peak_acceleration[i]:8.3f}"
                f"{self.peak_velocity[i]:8.3f}{self.amplification[i, top]:9.3f} "
                f"{self.frequency[top]:<8.3g}{self.aggravation_factor[i]:8.3f}"
                f"{self.aggravation[i].max():9.3f}"
            )
        return "\n".join(lines)

    def section(self, axis: str = "x"):
        """Draw the velocity histories of the points along 'x' or 'y'; return the figure."""
        from .picture import section_figure

        return section_figure(self, axis)

    def plot(self):
        """Draw amplification by position and frequency, peaks, and the model; return the figure."""
        from .picture import surface_figure

        return surface_figure(self)


def surface(
    history: xr.Dataset, axis: str = "x", lowest: float = 0.5, highest: float = 15.0
) -> Surface:
    """Compare the measured points on the surface with the free field or the outcrop.

    The reference is the surface of the first free field of the model; without one, the motion of
    an outcrop of the half-space: twice the incoming wave of a compliant base.

    Parameters
    ----------
    history : xarray.Dataset
        History of a run with equal steps.
    axis : {'x', 'y'}
    lowest, highest : float
        Band of the amplification, Hz.

    Raises
    ------
    InputError
        If no boundary has an incoming wave, fewer than two points are on the surface, the band is
        empty, or the steps are not equal.
    """
    ground, reference = _reference_motion(history, axis)
    scene = Scene.of(history)
    names = _points_on_surface(scene, history)
    if len(names) < 2:
        raise InputError(f"{len(names)} measured points are on the surface: two or more are needed")
    step = equal_step(history.time.values)
    minimum, maximum = 1.0 / (step * ground.size), 0.5 / step
    if not minimum <= lowest < highest <= maximum:
        raise InputError(
            f"the band from {lowest:g} to {highest:g} Hz does not lie between {minimum:.4g} Hz, "
            f"one period in the run, and {maximum:.4g} Hz, half of the sampling frequency"
        )
    frequency = np.geomspace(lowest, highest, _BINS)
    series = [history.acceleration.sel(point=name, axis=axis).values for name in names]
    spectrum = _smooth(ground, step, frequency)
    if not np.all(spectrum > 0):
        raise InputError(f"the {reference} has no motion along {axis}")
    pga, pgv = np.transpose([_peak_motion(a, step) for a in series])
    reference_pga, reference_pgv = _peak_motion(ground, step)
    positions = np.array([history.point_place.sel(point=name).values for name in names])
    columns = [None] * len(names)
    if axis == "x":
        columns = _column_motions(history, scene, positions, ground, step)
    ratios = np.array([_smooth(a, step, frequency) / spectrum for a in series])
    unknown = np.full(frequency.size, np.nan)
    column_ratios = np.array([unknown if a is None else _smooth(a, step, frequency) / spectrum
                              for a in columns])  # fmt: skip
    return Surface(scene, names, positions, frequency, ratios, pga / reference_pga,
                   pgv / reference_pgv, reference, column_ratios)  # fmt: skip


def _column_motions(history: xr.Dataset, scene: Scene, positions, reference, step: float) -> list:
    """Return the accelerations of the soil columns below the points; None without a column."""
    length, scheme = fast_length(2 * reference.size), run_scheme(history)
    bins = np.fft.rfftfreq(length, step)[:-1]
    distance = _TOUCHING * scene.size

    def transfer(point) -> NDArray[np.complex128] | None:
        columns = [column_below(history, point, side) for side in (distance, -distance)]
        column = next(filter(None, columns), None)
        if column is None:
            return None
        try:
            step = run_step(history)
            return column.scheme_transfer(bins, step, kind="outcrop", integration=scheme)
        except ValueError:  # undamped resonance
            return None

    ground: NDArray | None = np.ones(bins.size)
    boundaries = input_values(history.attrs).get("boundary", [])
    sides = [group["side"] for group in boundaries if group["kind"] == "free_field"]
    if sides:  # the reference is the surface of the column
        corners = scene.vertices(0)
        edge = corners[:, 0].max() if sides[0] == "right" else corners[:, 0].min()
        ground = transfer((edge, corners[corners[:, 0] == edge, 1].max()))
    ratios = [transfer(point) for point in positions]
    spectrum = np.fft.rfft(reference, length)[:-1]

    def motion(ratio) -> NDArray[np.float64]:
        # The time integration removes high frequencies from the reference, less so from a lower
        # column: the quotient of both is not a motion.
        omitted = np.abs(ratio) > _MOST_GAIN * np.abs(ground)
        gain = np.where(omitted, 0.0, ratio) / np.where(ground == 0.0, 1.0, ground)
        return np.fft.irfft(np.append(spectrum * gain, 0.0), length)[: reference.size]

    return [None if ratio is None or ground is None else motion(ratio) for ratio in ratios]


def _reference_motion(history: xr.Dataset, axis: str) -> tuple[NDArray[np.float64], str]:
    """Return the reference acceleration, m/s², and its description."""
    kinds = list(history.boundary_kind.values) if "boundary_kind" in history else []
    for kind, factor, description in (
        ("free_field", 1.0, "surface of {}"),
        ("compliant", 2.0, "outcrop of the half-space below {}"),
    ):
        if kind in kinds:
            boundary = history.isel(boundary=kinds.index(kind))
            name = str(boundary.boundary.values)
            incoming = boundary.incoming_acceleration.sel(axis=axis).values
            return factor * incoming, description.format(name)
    raise InputError(
        "no wave enters the model from outside: add free-field sides, or a boundary of "
        "kind = 'compliant' with a motion"
    )


def _points_on_surface(scene: Scene, history: xr.Dataset) -> list[str]:
    """Return the measured points without a block above, from left to right."""
    vertices = scene.vertices(0)
    (x0, y0), (x1, y1) = vertices.T, vertices[scene.next_vertex].T
    distance = _TOUCHING * scene.size

    def highest(x: float) -> float:
        crossed = (np.minimum(x0, x1) <= x) & (x <= np.maximum(x0, x1)) & (x0 != x1)
        fraction = (x - x0[crossed]) / (x1 - x0)[crossed]
        return np.max(y0[crossed] + fraction * (y1 - y0)[crossed], initial=-np.inf)

    surface_points = []
    for name, (x, y) in zip(history.point.values, history.point_place.values, strict=True):
        heights = [high for side in (-1, 1) if np.isfinite(high := highest(x + side * distance))]
        if min(heights) <= y + 2 * distance:
            surface_points.append((x, str(name)))
    return [name for _, name in sorted(surface_points)]


def _smooth(series, step: float, frequency) -> NDArray[np.float64]:
    """Return the smoothed Fourier spectrum at frequencies."""
    zeros = int(np.ceil(_FINE / (frequency[0] * step * series.size)))
    bins, spectrum = fourier_spectrum(series, step, padding=max(1, zeros))
    return smooth_konno_ohmachi(bins, spectrum, BANDWIDTH, frequency)


def _peak_motion(acceleration, step: float) -> NDArray[np.float64]:
    """Return PGA and PGV."""
    return np.array([abs(acceleration).max(), abs(running_integral(acceleration, step)).max()])
