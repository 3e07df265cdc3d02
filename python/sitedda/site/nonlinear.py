# SPDX-License-Identifier: GPL-3.0-or-later
"""Nonlinear analysis of a soil column in the time domain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.arguments import positive
from ..base.core import api, checked
from ..engine.damping import ConstantRatio
from ..engine.signals import fast_length, low_pass, running_integral
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
_FEWEST_CELLS = 2  # of a layer
_MOST_VALUES = 50_000_000  # largest number of values of the motion or of a history
_PERIODS = (0.1, 0.2, 0.5, 1.0)  # s, periods of the results
_NYQUIST = 0.45  # fraction of the sampling frequency up to which a low-pass is applied
_CONVERGED = 0.05  # largest relative difference of two resolutions of a converged result


@dataclass(frozen=True)
class Histories:
    """Histories of a column at the samples of the motion.

    Attributes
    ----------
    interfaces : ndarray, shape (cells + 1,)
        Depths of the nodes, m, from the surface down.
    acceleration, displacement : ndarray, shape (cells + 1, samples)
        Of the nodes, m/s² and m.
    strain, stress : ndarray, shape (cells, samples)
        Shear of the cells, dimensionless and Pa.
    largest_strain, largest_stress : ndarray, shape (cells,)
        Largest absolute values of all steps, between the samples too.
    energy : dict of str to float
        J/m²: ``work`` at the base, and what it became, ``kinetic``, ``stored``, ``slipped`` (lost
        by the branches) and ``damped`` (lost by the damping of small strains).
    iterations : ndarray of int, shape (steps,)
    """

    interfaces: NDArray[np.float64]
    acceleration: NDArray[np.float64]
    displacement: NDArray[np.float64]
    strain: NDArray[np.float64]
    stress: NDArray[np.float64]
    largest_strain: NDArray[np.float64]
    largest_stress: NDArray[np.float64]
    energy: dict[str, float]
    iterations: NDArray[np.int32]


@dataclass(frozen=True)
class NonlinearResponse(SiteResponse):
    """The response of a column of yielding soil to a ground motion.

    Attributes
    ----------
    column : Column
        With the moduli of small strains.
    motion : Motion
        Of the base.
    bottom : float
        Depth of the base, m.
    kind : {'outcrop', 'within'}
        Kind of motion.
    branches : tuple of Branches or None, one for each layer
        None: the layer is linear.
    histories : Histories
    coarse : Histories or None
        The same in cells and steps of twice the size.
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

    def velocity(self, depth: float = 0.0) -> NDArray[np.float64]:
        """Velocity at a depth (m), m/s, shape (samples,); from rest."""
        return running_integral(self.acceleration(depth), self.motion.time_step)

    def displacement(self, depth: float = 0.0) -> NDArray[np.float64]:
        """Displacement relative to the reference motion, m, shape (samples,)."""
        step = self.motion.time_step
        ground = running_integral(running_integral(self.motion.acceleration, step), step)
        return self._values_at_nodes(self.histories.displacement, depth) - ground

    def strain(self, depth: ArrayLike) -> NDArray[np.float64]:
        """Shear strain of the cells at a depth or depths (m), shape (..., samples)."""
        return self.histories.strain[self._cell_indices(depth)]

    def stress(self, depth: ArrayLike) -> NDArray[np.float64]:
        """Shear stress of the cells at a depth or depths (m), Pa, shape (..., samples)."""
        return self.histories.stress[self._cell_indices(depth)]

    def _values_at_nodes(self, values: NDArray[np.float64], depth: float) -> NDArray[np.float64]:
        nodes = self.histories.interfaces
        at = self._checked_depths(depth)
        k = int(np.clip(np.searchsorted(nodes, at, side="right") - 1, 0, nodes.size - 2))
        share = (at - nodes[k]) / (nodes[k + 1] - nodes[k])
        return values[k] + share * (values[k + 1] - values[k])

    def _cell_indices(self, depth: ArrayLike) -> NDArray[np.int64]:
        found = (
            np.searchsorted(self.histories.interfaces, self._checked_depths(depth), side="right")
            - 1
        )
        return np.clip(found, 0, self.histories.strain.shape[0] - 1)

    def _checked_depths(self, depth: ArrayLike) -> NDArray[np.float64]:
        at = np.asarray(depth, dtype=float)
        if not np.all((at >= 0) & (at <= self.column.depth * (1 + 1e-9))):
            raise ValueError(f"depth must be in 0 … {self.column.depth:g} m, got {depth!r}")
        return at

    def profile(self) -> xr.Dataset:
        """Return peaks of nodes and cells over depth, as :meth:`ColumnResponse.profile`.

        ``acceleration_converged`` and ``strain_converged`` mark depths at which cells and steps of
        twice the size change the peak by at most 5 %. Peaks below half of the largest are compared
        with it.
        """
        kept, step = self.histories, self.motion.time_step
        ground = running_integral(running_integral(self.motion.acceleration, step), step)
        found = self._peak_profile(
            kept.interfaces, self._filter_resolved(kept.acceleration),
            running_integral(kept.acceleration, step), kept.displacement - ground,
            kept.largest_strain[:, None], kept.largest_stress[:, None],
        )  # fmt: skip
        if self.coarse is not None:
            ends = self.coarse.interfaces
            peak = np.abs(self._filter_resolved(self.coarse.acceleration)).max(axis=1)
            # The shear strain at the surface is 0.
            middles = np.append(0.0, (ends[:-1] + ends[1:]) / 2)
            strain = np.append(0.0, self.coarse.largest_strain)
            for name, at, values in (
                ("acceleration", ends, peak), ("strain", middles, strain),
            ):  # fmt: skip
                fine = found[name]
                coarse = np.interp(fine[fine.dims[0]].values, at, values)
                scale = np.maximum(fine.values, fine.values.max() / 2)
                good = np.abs(coarse - fine.values) <= _CONVERGED * scale
                found[f"{name}_converged"] = (fine.dims, good)
        return found

    def coarse_spectrum(self, periods: ArrayLike) -> NDArray[np.float64]:
        """Return Sa of the surface with cells and steps of twice the size, m/s²."""
        return self._spectral_acceleration(
            self._filter_resolved(self.coarse.acceleration[0]), periods, 0.05
        )

    @property
    def figures(self) -> dict[str, tuple[float, float]]:
        """Return results of the surface, and their changes with cells and steps of twice the size.

        ``pga`` (at the samples, m/s²), ``strain`` (of all cells and steps), ``sa_0.1`` … ``sa_1``
        (5 %, m/s²); the change is nan without the coarse run.
        """
        fine = self._compute_results(self.histories)
        if self.coarse is None:
            return {name: (value, float("nan")) for name, value in fine.items()}
        coarse = self._compute_results(self.coarse)
        return {name: (value, abs(value - coarse[name])) for name, value in fine.items()}

    def _compute_results(self, kept: Histories) -> dict[str, float]:
        surface = self._filter_resolved(kept.acceleration[0])
        spectrum = self._spectral_acceleration(surface, _PERIODS, 0.05)
        return {
            "pga": float(np.abs(surface).max()),
            "strain": float(kept.largest_strain.max()),
            **{f"sa_{p:g}": float(sa) for p, sa in zip(_PERIODS, spectrum, strict=True)},
        }

    @property
    def unconverged(self) -> list[str]:
        """Return the names of results that change by more than 5 % with coarser cells and steps."""
        return [
            n for n, (value, change) in self.figures.items() if change > _CONVERGED * abs(value)
        ]

    @property
    def beyond_curves(self) -> dict[int, float]:
        """Return largest strains of the layers (from 1) strained beyond the end of their curves.

        Beyond the end, a soil flows at the largest stress of its branches.
        """
        ends = np.cumsum([0.0, *(layer.thickness for layer in self.column.layers)])
        layer = np.searchsorted(ends, self.histories.interfaces[:-1] + 1e-9 * ends[-1]) - 1
        found = {}
        for i, soil in enumerate(self.branches):
            largest = float(self.histories.largest_strain[layer == i].max())
            if soil is not None and largest > soil.strain[-1]:
                found[i + 1] = largest
        return found

    def __str__(self) -> str:
        lines = [self.words, _describe_fit([b for b in self.branches if b is not None])]
        for name, (value, change) in self.figures.items():
            unit = " %" if name == "strain" else " m/s²"
            scale = 100 if name == "strain" else 1
            bar = "" if np.isnan(change) else f" ± {scale * change:.2g}"
            lines.append(f"{_result_label(name):22s}{scale * value:9.4g}{bar}{unit}")
        if self.unconverged:
            names = ", ".join(map(_result_label, self.unconverged))
            lines.append(
                f"results that do not converge with cells and steps: {names}; short periods "
                "contain numerical noise from yielding. Give the soil a damping ratio at small "
                "strains, or use longer periods"
            )
        if words := self._describe_noise():
            lines.append(words)
        if self.kind == "outcrop" and getattr(self.column.base, "damping", None):
            lines.append("the damping of the half-space is ignored")
        if self.beyond_curves:
            layers = ", ".join(
                f"layer {i} {100 * most:.3g} %" for i, most in self.beyond_curves.items()
            )
            lines.append(
                f"strains exceed the curves, so the soil flows: {layers}; give curves up to these "
                "strains, with a shear strength (gqh)"
            )
        return "\n".join(filter(None, lines))

    def _describe_noise(self) -> str:
        """Describe the depths whose peak acceleration does not converge; '' if there are none."""
        found = self.profile()
        if self.coarse is None or bool(found.acceleration_converged.all()):
            return ""
        depth = found.depth.values[~found.acceleration_converged.values]
        return (
            f"peak accelerations do not converge at {depth.size} of {found.depth.size} depths, "
            f"from {depth.min():.3g} to {depth.max():.3g} m"
        )

    def plot(self):
        """Draw surface and reference motion, spectra, profiles, and the loop of largest strain.

        Returns
        -------
        matplotlib.figure.Figure
        """
        from .picture import nonlinear_figure

        return nonlinear_figure(self)


_MOST_OFF = 0.003  # largest misfit of a damping ratio without a warning


def _describe_fit(soils: list[Branches]) -> str:
    """Describe the worst fit of branches to curves of all soils; '' if there are none."""
    if not soils:
        return ""
    modulus, damping = np.max([soil.misfit for soil in soils], axis=0)
    words = f"{soils[0].strain.size} branches, moduli within {100 * modulus:.2g} %"
    if damping:
        words += f", damping ratios within {100 * damping:.2g} points"
    if damping > _MOST_OFF:
        words += f" – more than {100 * _MOST_OFF:.1g}: the damping curve is not fitted"
    return f"{words} (strains of 0.001 to 1 %)"


def _result_label(name: str) -> str:
    known = {"pga": "surface PGA", "strain": "largest strain"}
    return known.get(name, f"surface Sa({name.removeprefix('sa_')} s)")


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
        With the moduli at small strain, n layers; on a rigid base or a half-space, whose damping is
        left out.
    curves : sequence of SoilCurves, Branches or None, length n
        Of each layer; branches are taken as they are; None leaves it linear, with its own damping
        ratio.
    motion, time_step, kind
        As for :meth:`Column.response`, or a Motion: of the base, which a motion within moves
        directly.
    damping_curve : {'target', 'masing'}
        See :meth:`Branches.of`.
    branches : int
        For each soil.
    highest_frequency : float
        Hz, for which cells (12 a wave of small strains) and steps (40 a period) are small enough.
    reference_frequency : float
        Hz, at which the moduli are the given ones.
    compare : bool
        Run once more in cells and steps of twice the size, so that figures have a bar.

    Raises
    ------
    ValueError
        If an argument is out of range, or a linear layer's damping is no ratio.
    ConvergenceError
        If a step does not converge.
    """
    if len(curves) != len(column.layers):
        raise ValueError(f"curves: give {len(column.layers)}, one per layer, not {len(curves)}")
    one_of("kind", kind, KINDS)
    highest = float(positive("highest_frequency", highest_frequency))
    ground = motion if isinstance(motion, Motion) else Motion.of(motion, time_step)
    reference = float(positive("reference_frequency", reference_frequency))
    ratios = [_layer_ratio(i, column) for i in range(len(curves))]
    soils = tuple(
        curve
        if curve is None or isinstance(curve, Branches)
        else Branches.of(
            curve, branches, damping_curve, None if damping_curve == "target" else ratio, reference
        )
        for curve, ratio in zip(curves, ratios, strict=True)
    )
    run = _ColumnRun(column, soils, ground, kind, reference)
    fine = run.at(highest)
    coarse = run.at(highest / 2) if compare else None
    return NonlinearResponse(column, ground, column.depth, kind, soils, fine, coarse, highest)


@dataclass(frozen=True)
class _ColumnRun:
    """Runs of a column under a motion."""

    column: Column
    soils: tuple[Branches | None, ...]
    motion: Motion
    kind: str
    reference: float

    def at(self, highest: float) -> Histories:
        """Run with cells and steps that resolve a frequency, Hz."""
        cells = [_count_cells(layer, highest) for layer in self.column.layers]
        every = max(1, int(np.ceil(_STEPS_A_PERIOD * highest * self.motion.time_step)))
        samples = self.motion.acceleration.size
        if max(sum(cells), every) * samples > _MOST_VALUES:
            raise ValueError(
                f"{sum(cells)} cells, {samples} samples and {every} steps for each are more than "
                f"{_MOST_VALUES} values: lower highest_frequency, or shorten the motion"
            )
        layers = [
            (layer.thickness / n, layer.density, layer.shear_modulus)
            for layer, n in zip(self.column.layers, cells, strict=True)
            for _ in range(n)
        ]
        ground = self.motion.acceleration
        base = np.interp(
            np.arange((ground.size - 1) * every + 1) / every, np.arange(ground.size), ground
        )
        *kept, largest, energy, iterations = checked(
            api.shake_soil,
            np.array(layers).T,
            np.repeat(np.arange(1, len(cells) + 1), cells),
            self._layer_branches(),
            *self._damping_and_limits(),
            self.reference,
            self._base_dashpot(),
            self.motion.time_step / every,
            base,
            every,
            ground.size,
        )
        acceleration, displacement, strain, stress = kept
        names = ("work", "kinetic", "stored", "slipped", "damped")
        return Histories(
            np.cumsum([0.0, *(thickness for thickness, _, _ in layers)]),
            acceleration,
            displacement,
            -strain,  # depth increases downwards
            -stress,
            largest[0],
            largest[1],
            dict(zip(names, map(float, energy), strict=True)),
            iterations,
        )

    def _layer_branches(self) -> NDArray[np.float64]:
        """Return branches of all layers, shape (most, 3, layers); unused ones have no modulus."""
        most = max(1 if soil is None else soil.strain.size for soil in self.soils)
        found = np.zeros((most, 3, len(self.soils)), order="F")
        found[:, 0, :] = 1e30  # beyond any strain
        for i, soil in enumerate(self.soils):
            if soil is None:
                found[0, 1:, i] = self._long_term_fraction(i), 1.0
            else:
                rows = [soil.strain, soil.modulus, soil.slipping]
                found[: soil.strain.size, :, i] = np.transpose(rows)
        return found

    def _long_term_fraction(self, i: int) -> float:
        """Return the fraction of the modulus of a linear layer that its branch has."""
        ratio = _layer_ratio(i, self.column)
        if ratio == 0:
            return 1.0
        body = ConstantRatio(ratio, self.reference).body
        return body.unrelaxed * (1 - body.weight.sum())

    def _damping_and_limits(self) -> tuple[list[float], list[float]]:
        """Return damping ratios of small strains, and strains at which their bodies slip."""
        ratios, limits = [], []
        for i, soil in enumerate(self.soils):
            ratios.append(_layer_ratio(i, self.column) if soil is None else soil.least_damping)
            limits.append(np.finfo(float).max if soil is None else soil.body_strain)
        return ratios, limits

    def _base_dashpot(self) -> float:
        base = self.column.base
        if self.kind == "within" or not isinstance(base, HalfSpace):
            return 0.0
        return base.density * base.shear_velocity


def _layer_ratio(i: int, column: Column) -> float:
    """Return the damping ratio of a layer; reject one that depends on frequency."""
    own = column.layers[i].damping
    if isinstance(own, ConstantRatio):
        own = own.ratio
    if not isinstance(own, float):
        raise ValueError(
            f"the damping of layer {i + 1} depends on frequency: the nonlinear analysis needs a "
            "constant damping ratio"
        )
    return own


def _count_cells(layer, highest: float) -> int:
    wave = layer.shear_velocity / highest
    return max(_FEWEST_CELLS, int(np.ceil(_CELLS_A_WAVE * layer.thickness / wave * (1 - 1e-9))))
