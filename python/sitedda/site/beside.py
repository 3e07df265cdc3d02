# SPDX-License-Identifier: GPL-3.0-or-later
"""Compare a run of layered blocks with its one-dimensional column."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..base.errors import InputError
from ..engine.scheme import Scheme
from ..engine.spectra import find_peak
from ..input.input_text import input_values
from ..output.response import amplifications, spectral_ratio
from ..output.verdict import run_scheme, run_step
from .column import Column
from .layers import convention_words
from .motion import equal_step
from .response import ColumnResponse, SiteResponse
from .twin import layered_soils

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class Beside:
    """Results of blocks and column for the same site."""

    # The column under the motion of the blocks' base: "column" if it is linear; otherwise
    # "nonlinear", "equivalent-linear" and "linear"
    columns: dict[str, SiteResponse]
    surface: NDArray[np.float64]  # acceleration of the blocks, m/s²
    base: NDArray[np.float64]
    frequency: NDArray[np.float64]  # Hz
    ratio: NDArray[np.complex128]  # surface / base motion of the blocks
    column_ratios: dict[str, NDArray[np.complex128]]  # those of the columns
    # Depths (m) and peak accelerations (m/s²) of the measured points, from the surface down
    points: tuple[NDArray[np.float64], NDArray[np.float64]]
    # Depths (m) and peak mean shear strains between adjacent measured points
    strains: tuple[NDArray[np.float64], NDArray[np.float64]]
    words: str  # description of the column
    title: str

    @property
    def response(self) -> SiteResponse:
        """Return the response of the first column, whose soil model equals that of the blocks."""
        return next(iter(self.columns.values()))

    @property
    def column_surface(self) -> NDArray[np.float64]:
        """Return the acceleration of the surface of this column, m/s², shape (samples,)."""
        return self.response.acceleration()[: self.surface.size]

    @property
    def column_ratio(self) -> NDArray[np.complex128]:
        """Return the ratio of surface to base of this column, shape (bins,)."""
        return next(iter(self.column_ratios.values()))

    @property
    def time(self) -> NDArray[np.float64]:
        """Return the times, s, shape (samples,)."""
        return self.response.time

    @property
    def yields(self) -> bool:
        """Return whether the soil of the column yields."""
        return "nonlinear" in self.columns

    def __str__(self) -> str:
        from .compare import tabulate_motions

        step = self.response.motion.time_step
        low, high = self.frequency[0], self.frequency[-1]
        ratios = [self.ratio, *self.column_ratios.values()]
        peaks = [find_peak(self.frequency, abs(r), low, high) for r in ratios]
        first_rows = [("largest amplification", [p.amplitude for p in peaks], ""),
                  ("  at", [p.frequency for p in peaks], "Hz")]  # fmt: skip
        last_rows, nonlinear = [], []
        if self.yields:
            strains = [100 * self.strains[1].max(initial=0.0)]
            strains += [100 * column.profile().strain.max() for column in self.columns.values()]
            last_rows = [("largest shear strain", strains, "%")]
            nonlinear = ["", "nonlinear column", str(self.response)]
        series = {name: column.acceleration() for name, column in self.columns.items()}
        lines = tabulate_motions({"blocks": self.surface} | series, step, first_rows, last_rows)
        return "\n".join([f"column: {self.words}", *lines, *nonlinear])

    def plot(self):
        """Draw all results in one picture; return the figure."""
        from .picture import beside_figure

        return beside_figure(self)


def beside(
    history: xr.Dataset,
    surface: str | None = None,
    base: str | None = None,
    damping: float | None = None,
) -> Beside:
    """Compare a finished run with the column that it models.

    Parameters
    ----------
    history : xarray.Dataset
        History of a run with equal steps, with measured points at surface and base.
    surface, base : str, optional
        Names of these points; by default those of the first &amplification of the input.
    damping : float, optional
        Damping ratio of the layers of the column; by default the damping of the run by its time
        integration and materials.  Nonlinear soil has its own damping.

    Raises
    ------
    InputError
        If the model is not layered, points are missing or the steps are not equal.
    """
    pairs = amplifications(history)
    if pairs:
        surface, base = surface or pairs[0].surface, base or pairs[0].base
    names = [str(name) for name in history.point.values] if "point" in history.coords else []
    for role, name in (("surface", surface), ("base", base)):
        if name not in names:
            raise InputError(
                f"no measured point {name!r} for the {role}: name it by --{role}; there are "
                + (", ".join(names) or "none")
            )
    if any(group.get("base_motion_x") for group in input_values(history.attrs).get("control", [])):
        raise InputError(
            "with base_motion_x, the coordinates move with the base, so the base point does not "
            "move: set motion_x of the fixed points instead"
        )
    column, soils = layered_soils(history, surface, base)
    series = {name: history.acceleration.sel(point=name).sel(axis="x").values for name in names}
    step = equal_step(history.time.values)
    ground, integration = series[base], (run_scheme(history), run_step(history))
    columns, description = _compute_columns(column, soils, ground, step, integration, damping)
    frequency, ratio = spectral_ratio(series[surface], ground, step, 8)
    band = (frequency >= 0.2) & (frequency <= min(25.0, 0.4 / step))
    top = float(history.point_place.sel(point=surface).values[1])
    points, strains = _peaks_over_depth(history, series, top, column.depth)
    ratios = {name: _surface_over_base(group, ground, step, frequency[band])
              for name, group in columns.items()}  # fmt: skip
    title = str(history.attrs.get("title", ""))
    return Beside(columns, series[surface], ground, frequency[band], ratio[band], ratios, points,
                  strains, description, title)  # fmt: skip


def _compute_columns(
    column: Column,
    soils,
    ground,
    step: float,
    integration: tuple[Scheme, float],
    damping: float | None,
) -> tuple[dict[str, SiteResponse], str]:
    """Return the columns under the motion of the base, and a description of their damping.

    The motion has samples at `step` (s); the run has a time integration scheme and Δt (s).
    """
    if any(soils):
        from .compare import analyses

        if damping is not None:
            raise InputError("yielding soil has the damping of its curves: omit --damping")
        results = analyses(column, soils, ground, step, kind="within")
        description = "the branches of the blocks' materials"
        description += f"; {results.unbounded}" if results.unbounded else ""
        return dict(reversed(results.responses.items())), description
    if damping is None:
        damped = any(layer.damping for layer in column.layers)
        sources = "and the materials" if damped else "alone"
        scheme, time_step = integration
        response = column.response(ground, step, kind="within", scheme=scheme,
                                   scheme_step=time_step)  # fmt: skip
        description = f"damped like the blocks, by the time integration {sources}"
    else:
        fixed = replace(column, layers=[replace(la, damping=damping) for la in column.layers])
        response = fixed.response(ground, step, kind="within")
        response.check_bounded()
        convention = convention_words(fixed.convention)
        description = f"damping ratio {100 * damping:g} % at all frequencies, {convention}"
    return {"column": response}, f"{description}; {response.words}"


def _surface_over_base(response: SiteResponse, ground, step: float, frequency: NDArray[np.float64]):
    """Return surface / base motion of a column: transfer function, or ratio of the spectra."""
    if isinstance(response, ColumnResponse):
        return response.transfer(frequency)
    bins, ratio = spectral_ratio(response.acceleration(), ground, step, 8)
    return ratio[np.searchsorted(bins, frequency)]


def _peaks_over_depth(history, series, top: float, depth: float):
    """Return depths and peak values of accelerations of the measured points within the column, and
    of mean shear strains between adjacent points."""
    depths = sorted((top - float(history.point_place.sel(point=name).values[1]), name)
                    for name in series)  # fmt: skip
    inner = [(z, name) for z, name in depths if -1e-9 <= z <= depth * 1.2]
    points = [(min(z, depth), np.abs(series[name]).max()) for z, name in inner]
    u = [history.displacement.sel(point=name).sel(axis="x").values for _, name in inner]
    strains = [
        (high + (low - high) / 2, np.abs(u[i] - u[i + 1]).max() / (low - high))
        for i, ((high, _), (low, _)) in enumerate(itertools.pairwise(inner))
        if low - high > 1e-6 * depth
    ]
    return (tuple(np.array(rows).reshape(-1, 2).T) for rows in (points, strains))
