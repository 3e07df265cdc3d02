# SPDX-License-Identifier: GPL-3.0-or-later
"""Nonlinear analysis of a soil column in the time domain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.arguments import positive
from ..base.core import api, checked
from ..base.errors import InputError
from ..engine.damping import ConstantRatio
from ..engine.signals import fast_length, low_pass, running_integral, spectral_acceleration
from .branches import Branches
from .column import Column, HalfSpace
from .curves import SoilCurves
from .layers import one_of
from .motion import Motion
from .response import KINDS, SiteResponse

if TYPE_CHECKING:
    import xarray as xr

_CELLS_A_WAVE = 12  # cells per wavelength of the highest frequency at small strains
_STEPS_A_PERIOD = 40
_FEWEST_CELLS = 2  # smallest number of cells of a layer
_MOST_VALUES = 50_000_000  # largest number of values of the motion or of a history
PERIODS = (0.1, 0.2, 0.5, 1.0)  # s, of results and tables
_NYQUIST = 0.45  # fraction of the sampling frequency up to which a low-pass is applied
CONVERGED = 0.05  # largest relative difference of two resolutions of a converged result


@dataclass(frozen=True)
class Histories:
    """Histories of a column at the samples of the motion."""

    interfaces: NDArray[np.float64]  # depths of the nodes, from the surface down, m
    acceleration: NDArray[np.float64]  # of the nodes, shape (cells + 1, samples), m/s²
    displacement: NDArray[np.float64]  # of the nodes, m
    strain: NDArray[np.float64]  # of the cells, shape (cells, samples)
    stress: NDArray[np.float64]  # Pa
    largest_strain: NDArray[np.float64]  # of all steps, also between samples, shape (cells,)
    largest_stress: NDArray[np.float64]  # Pa
    # Energies, J/m²: "work" at the base, "kinetic", "stored", "slipped" (dissipated by branches),
    # "damped" (dissipated by the damping of small strains)
    energy: dict[str, float]
    iterations: NDArray[np.int32]  # of each step


@dataclass(frozen=True)
class NonlinearResponse(SiteResponse):
    """The response of a column of yielding soil to a ground motion.

    Attributes
    ----------
    column : Column
        Column with moduli at small strains.
    motion : Motion
        Motion of the base.
    bottom : float
        Depth of the base, m.
    kind : {'outcrop', 'within'}
        Kind of motion.
    branches : tuple of Branches or None, one for each layer
        None: the layer is linear.
    histories : Histories
    coarse : Histories or None
        Histories with cells and steps of twice the size.
    band : float
        Hz, up to which cells and steps are small enough.  Accelerations that are returned pass a
        zero-phase low-pass at it; `histories` has them as computed.
    """

    column: Column
    motion: Motion
    bottom: float
    kind: str
    branches: tuple[Branches | None, ...]
    histories: Histories
    coarse: Histories | None
    band: float

    def acceleration(self, depth: float = 0.0) -> NDArray[np.float64]:
        """Acceleration at a depth (m), m/s², shape (samples,)."""
        return self._filter_resolved(self._values_at_nodes(self.histories.acceleration, depth))

    def _filter_resolved(self, acceleration: NDArray[np.float64]) -> NDArray[np.float64]:
        """Filter accelerations, shape (..., samples), to the resolved band."""
        step, samples = self.motion.time_step, acceleration.shape[-1]
        if self.band >= _NYQUIST / step:
            return acceleration
        length = fast_length(2 * samples)
        passed = np.abs(low_pass(length, step, self.band)) ** 2
        return np.fft.irfft(np.fft.rfft(acceleration, length) * passed, length)[..., :samples]

    def displacement(self, depth: float = 0.0) -> NDArray[np.float64]:
        """Displacement relative to the reference motion, m, shape (samples,)."""
        return self._values_at_nodes(self.histories.displacement, depth) - self._ground

    @property
    def _ground(self) -> NDArray[np.float64]:
        """Return the displacement of the reference motion, m."""
        step = self.motion.time_step
        return running_integral(running_integral(self.motion.acceleration, step), step)

    def strain(self, depth: ArrayLike) -> NDArray[np.float64]:
        """Shear strain of the cells at a depth or depths (m), shape (..., samples)."""
        return self.histories.strain[self._cell_indices(depth)]

    def stress(self, depth: ArrayLike) -> NDArray[np.float64]:
        """Shear stress of the cells at a depth or depths (m), Pa, shape (..., samples)."""
        return self.histories.stress[self._cell_indices(depth)]

    def _values_at_nodes(self, values: NDArray[np.float64], depth: float) -> NDArray[np.float64]:
        nodes, k = self.histories.interfaces, self._cell_indices(depth)
        fraction = (depth - nodes[k]) / (nodes[k + 1] - nodes[k])
        return values[k] + fraction * (values[k + 1] - values[k])

    def _cell_indices(self, depth: ArrayLike) -> NDArray[np.int64]:
        depths, nodes = np.asarray(depth, dtype=float), self.histories.interfaces
        if not np.all((depths >= 0) & (depths <= self.column.depth * (1 + 1e-9))):
            raise InputError(f"depth must be in 0 … {self.column.depth:g} m, got {depth!r}")
        return np.clip(np.searchsorted(nodes, depths, side="right") - 1, 0, nodes.size - 2)

    def profile(self) -> xr.Dataset:
        """Return peaks of nodes and cells over depth, as :meth:`ColumnResponse.profile`.

        ``acceleration_converged`` and ``strain_converged`` mark depths at which cells and steps of
        twice the size change the peak by at most 5 %. Peaks below half of the largest are compared
        with it.
        """
        peaks = self._profile_of(self.histories)
        if self.coarse is not None:
            coarse = self._profile_of(self.coarse)
            # No strain is computed at the surface, at which it is 0.
            for name, surface in (("acceleration", []), ("strain", [0.0])):
                fine, rough = peaks[name], coarse[name]
                depths, values = (np.append(surface, v) for v in (rough[rough.dims[0]], rough))
                change = np.interp(fine[fine.dims[0]], depths, values) - fine.values
                scale = np.maximum(fine.values, fine.values.max() / 2)
                peaks[f"{name}_converged"] = (fine.dims, np.abs(change) <= CONVERGED * scale)
        return peaks

    def _profile_of(self, histories: Histories) -> xr.Dataset:
        return self._peak_profile(
            histories.interfaces, self._filter_resolved(histories.acceleration),
            running_integral(histories.acceleration, self.motion.time_step),
            histories.displacement - self._ground,
            histories.largest_strain[:, None], histories.largest_stress[:, None],
        )  # fmt: skip

    @property
    def largest(self) -> tuple[float, float]:
        """Return the largest shear strain, and shear stress (Pa), of all cells and steps."""
        histories = self.histories
        return float(histories.largest_strain.max()), float(histories.largest_stress.max())

    def coarse_spectrum(self, periods: ArrayLike) -> NDArray[np.float64]:
        """Return Sa (m/s²) of the run with cells and steps twice as large, or NaN."""
        if self.coarse is None:
            return np.full(np.shape(periods), np.nan)
        surface = self._filter_resolved(self.coarse.acceleration[0])
        return spectral_acceleration(surface, self.motion.time_step, periods)

    @property
    def figures(self) -> dict[str, tuple[float, float]]:
        """Return results of the surface, and their changes with cells and steps of twice the size.

        ``pga`` (at the samples, m/s²), ``strain`` (of all cells and steps), ``sa_0.1`` … ``sa_1``
        (5 %, m/s²); the change is nan without the coarse run.
        """
        fine = self._compute_results(self.histories)
        coarse = self._compute_results(self.coarse) if self.coarse else dict.fromkeys(fine, np.nan)
        return {name: (value, abs(value - coarse[name])) for name, value in fine.items()}

    def _compute_results(self, histories: Histories) -> dict[str, float]:
        surface = self._filter_resolved(histories.acceleration[0])
        spectrum = spectral_acceleration(surface, self.motion.time_step, PERIODS)
        return {
            "pga": float(np.abs(surface).max()),
            "strain": float(histories.largest_strain.max()),
            **{f"sa_{p:g}": float(sa) for p, sa in zip(PERIODS, spectrum, strict=True)},
        }

    @property
    def unconverged(self) -> list[str]:
        """Return the names of results that change by more than 5 % with coarser cells and steps."""
        return [n for n, (value, change) in self.figures.items() if change > CONVERGED * abs(value)]

    @property
    def beyond_curves(self) -> dict[int, float]:
        """Return largest strains of the layers (from 1) strained beyond the end of their curves.

        Beyond the end, a soil flows at the largest stress of its branches.
        """
        bottoms = np.cumsum([0.0, *(layer.thickness for layer in self.column.layers)])
        layer = np.searchsorted(bottoms, self.histories.interfaces[:-1] + 1e-9 * bottoms[-1]) - 1
        strains = {}
        for i, soil in enumerate(self.branches):
            largest = float(self.histories.largest_strain[layer == i].max())
            if soil is not None and largest > soil.strain[-1]:
                strains[i + 1] = largest
        return strains

    def __str__(self) -> str:
        lines = [self.words, _describe_fit([b for b in self.branches if b is not None])]
        for name, (value, change) in self.figures.items():
            scale, unit = (100, " %") if name == "strain" else (1, " m/s²")
            bar = "" if np.isnan(change) else f" ± {scale * change:.2g}"
            lines.append(f"{_result_label(name):22s}{scale * value:9.4g}{bar}{unit}")
        if self.unconverged:
            names = ", ".join(map(_result_label, self.unconverged))
            lines.append(
                f"results that do not converge with cells and steps: {names}; short periods "
                "contain numerical noise from yielding. Give the soil a damping ratio at small "
                "strains, or use longer periods"
            )
        lines.append(self._describe_noise())
        if self.kind == "outcrop" and getattr(self.column.base, "damping", None):
            lines.append("the damping of the half-space is ignored")
        if self.beyond_curves:
            layers = ", ".join(f"layer {i} {100 * e:.3g} %" for i, e in self.beyond_curves.items())
            lines.append(f"strains exceed the curves, so the soil flows: {layers}; give curves up "
                         "to these strains, with a shear strength (gqh)")  # fmt: skip
        return "\n".join(filter(None, lines))

    def _describe_noise(self) -> str:
        """Describe the depths whose peak acceleration does not converge; '' if there are none."""
        profile = self.profile()
        if self.coarse is None or bool(profile.acceleration_converged.all()):
            return ""
        depth = profile.depth.values[~profile.acceleration_converged.values]
        return (
            f"peak accelerations do not converge at {depth.size} of {profile.depth.size} depths, "
            f"from {depth.min():.3g} to {depth.max():.3g} m"
        )

    def plot(self):
        """Draw motions, spectra, profiles, and the loop of largest strain; return the figure."""
        from .picture import nonlinear_figure

        return nonlinear_figure(self)


_MOST_OFF = 0.003  # largest misfit of a damping ratio without a warning


def _describe_fit(soils: list[Branches]) -> str:
    """Describe the worst fit of branches to curves of all soils; '' if there are none."""
    if not soils:
        return ""
    modulus, damping = np.max([soil.misfit for soil in soils], axis=0)
    text = f"{soils[0].strain.size} branches, moduli within {100 * modulus:.2g} %"
    if damping:
        text += f", damping ratios within {100 * damping:.2g} percentage points"
    if damping > _MOST_OFF:
        text += f" – more than {100 * _MOST_OFF:.1g}: the damping curve is not fitted"
    return f"{text} (strains of 0.001 to 1 %)"


def _result_label(name: str) -> str:
    labels = {"pga": "surface PGA", "strain": "largest strain"}
    return labels.get(name, f"surface Sa at {name.removeprefix('sa_')} s")


def nonlinear(
    column: Column,
    curves: Sequence[SoilCurves | Branches | None],
    motion,
    time_step: float | None = None,
    *,
    kind: str = "outcrop",
    damping_curve: str = "target",
    branches: int = 40,
    highest_frequency: float = 25.0,
    reference_frequency: float = 1.0,
    compare: bool = True,
) -> NonlinearResponse:
    """Compute the nonlinear response of a column in the time domain.

    Cells of one strain, the midpoint rule, :class:`Branches` for each layer; small strains are
    damped at all frequencies alike by the least ratio of the curves, which fades as the modulus
    does (by Masing's rules: by the ratio of the layer).

    Parameters
    ----------
    column : Column
        Column of n layers with moduli at small strains, on a rigid base or on a half-space, whose
        damping is ignored.
    curves : sequence of SoilCurves, Branches or None, length n
        Curves of each layer; branches are used unchanged; None: the layer is linear with its own
        damping ratio.
    motion, time_step, kind
        See :meth:`Column.response`; the motion of the base, which a within motion prescribes
        directly.
    damping_curve : {'target', 'masing'}
        See :meth:`Branches.of`.
    branches : int
        Number of branches of each soil.
    highest_frequency : float
        Hz; cells (12 per wavelength at small strains) and steps (40 per period) resolve it.
    reference_frequency : float
        Hz; frequency at which the moduli are the given ones.
    compare : bool
        Run again with cells and steps of twice the size, so that results have error bars.

    Raises
    ------
    ConvergenceError
        If a step does not converge.
    """
    column.check_curves(curves)
    one_of("kind", kind, KINDS)
    highest = float(positive("highest_frequency", highest_frequency))
    ground = Motion.of(motion, time_step)
    reference = float(positive("reference_frequency", reference_frequency))
    ratios = [_layer_ratio(i, column) for i in range(len(curves))]
    soils: list[Branches | None] = []
    for curve, ratio in zip(curves, ratios, strict=True):
        if curve is not None and not isinstance(curve, Branches):
            smallest_damping = None if damping_curve == "target" else ratio
            curve = _fit_branches(curve, branches, damping_curve, smallest_damping, reference)
        soils.append(curve)
    every_soil = [soil or _linear_branches(ratio, reference)
                  for soil, ratio in zip(soils, ratios, strict=True)]  # fmt: skip
    dashpot = 0.0
    if kind == "outcrop" and isinstance(column.base, HalfSpace):
        dashpot = column.base.density * column.base.shear_velocity
    runs = [_run_column(column, every_soil, ground, reference, dashpot, resolved)
            for resolved in ((highest, highest / 2) if compare else (highest,))]  # fmt: skip
    fine, coarse = runs if compare else (*runs, None)
    depth = column.depth
    return NonlinearResponse(column, ground, depth, kind, tuple(soils), fine, coarse, highest)


_fit_branches = lru_cache(maxsize=2048)(Branches.of)  # once for all layers and motions


def _linear_branches(ratio: float, reference: float) -> Branches:
    """Return the single branch of a linear layer; its spring and damping element never slip."""
    modulus = 1.0
    if ratio:
        body = ConstantRatio(ratio, reference).body
        modulus = body.unrelaxed * (1 - body.weight.sum())
    strain, largest = np.array([1e30]), float(np.finfo(float).max)
    return Branches(strain, np.array([modulus]), np.ones(1), ratio, largest, largest, (0.0, 0.0))


def _run_column(
    column: Column, soils: Sequence[Branches], motion: Motion, reference: float, dashpot: float,
    highest: float,
) -> Histories:  # fmt: skip
    """Run with cells and steps that resolve a frequency, Hz."""
    cells = [_count_cells(layer, highest) for layer in column.layers]
    substeps = max(1, int(np.ceil(_STEPS_A_PERIOD * highest * motion.time_step)))
    ground, samples = motion.acceleration, motion.acceleration.size
    if max(sum(cells), substeps) * samples > _MOST_VALUES:
        raise InputError(
            f"{sum(cells)} cells, {samples} samples and {substeps} steps for each are more than "
            f"{_MOST_VALUES} values: lower highest_frequency, or shorten the motion"
        )
    layers = np.array([
        (layer.thickness / n, layer.density, layer.shear_modulus)
        for layer, n in zip(column.layers, cells, strict=True)
        for _ in range(n)
    ]).T  # fmt: skip
    branches = np.zeros((max(soil.strain.size for soil in soils), 3, len(soils)), order="F")
    branches[:, 0, :] = 1e30  # unused branches have no modulus
    for i, soil in enumerate(soils):
        rows = [soil.strain, soil.modulus, soil.slipping]
        branches[: soil.strain.size, :, i] = np.transpose(rows)
    damping = [soil.least_damping for soil in soils]
    body_strains = [soil.body_strain for soil in soils]
    fractions = np.arange((samples - 1) * substeps + 1) / substeps
    series = np.interp(fractions, np.arange(samples), ground)
    owners = np.repeat(np.arange(1, len(cells) + 1), cells)
    acceleration, displacement, strain, stress, largest, energy, iterations = checked(
        api.shake_soil, layers, owners, branches, damping, body_strains, reference, dashpot,
        motion.time_step / substeps, series, substeps, samples,
    )  # fmt: skip
    names = ("work", "kinetic", "stored", "slipped", "damped")
    balance = dict(zip(names, map(float, energy), strict=True))
    strain, stress = -strain, -stress  # depth increases downwards
    return Histories(np.cumsum([0.0, *layers[0]]), acceleration, displacement, strain, stress,
                     largest[0], largest[1], balance, iterations)  # fmt: skip


def _layer_ratio(i: int, column: Column) -> float:
    """Return the damping ratio of a layer; reject one that depends on frequency."""
    damping = column.layers[i].damping
    if isinstance(damping, ConstantRatio):
        damping = damping.ratio
    if not isinstance(damping, float):
        raise InputError(
            f"the damping of layer {i + 1} depends on frequency: the nonlinear analysis needs a "
            "constant damping ratio"
        )
    return damping


def _count_cells(layer, highest: float) -> int:
    wave = layer.shear_velocity / highest
    return max(_FEWEST_CELLS, int(np.ceil(_CELLS_A_WAVE * layer.thickness / wave * (1 - 1e-9))))
