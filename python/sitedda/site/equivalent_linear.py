# SPDX-License-Identifier: GPL-3.0-or-later
"""Equivalent-linear analysis: moduli and damping consistent with the strains (SHAKE)."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..base.errors import ConvergenceError, InputError
from .column import Column
from .curves import SoilCurves
from .layers import convention_words, largest_damping
from .motion import Motion
from .response import ColumnResponse

DOUBTFUL_STRAIN = 0.005  # strain above which equivalent-linear results are doubtful
_MEANINGLESS = 0.01  # strain above which results are meaningless
_THICK = 0.2  # wavelengths above which one strain does not describe a layer
_SOFT = 0.1  # strain above which another solution is sought
_APART = 0.01  # smallest relative difference of the strains of two solutions


@dataclass(frozen=True)
class EquivalentLinear:
    """A column whose properties fit its strains, and data on the iteration.

    Attributes
    ----------
    response : ColumnResponse
        Response of the fitted column; ``response.column`` has its moduli and damping ratios.
    strain : ndarray, shape (layers,)
        Effective shear strain of each layer.
    reduction : ndarray, shape (layers,)
        G/G_max.
    damping : ndarray, shape (layers,)
        Damping ratio.
    iterations : int
    change : float
        Largest relative change of a modulus or damping ratio in the last iteration.
    strain_ratio : float
        Effective over largest strain.
    other_strain : float
        Largest strain of another consistent solution; NaN if none was found.
    """

    response: ColumnResponse
    strain: NDArray[np.float64]
    reduction: NDArray[np.float64]
    damping: NDArray[np.float64]
    iterations: int
    change: float
    strain_ratio: float = 0.65
    other_strain: float = np.nan

    @property
    def largest_strain(self) -> NDArray[np.float64]:
        """Return the largest shear strain in the middle of each layer, shape (layers,)."""
        return self.strain / self.strain_ratio

    @property
    def doubt(self) -> str:
        """Return warnings: strains above 0.5 %, two solutions, thick layers; '' for none."""
        return "\n".join(filter(None, [self.strain_doubt, self._thickness_doubt]))

    @property
    def _thickness_doubt(self) -> str:
        """Return a warning if a yielding layer is thick for its single strain; otherwise ''."""
        if self.response.unbounded or not np.any(self.response.motion.acceleration):
            return ""
        period = self.response.intensity().mean_period
        layers = self.response.column.layers
        waves = [(reduction < 1) * layer.thickness / (layer.shear_velocity * period)
                 for layer, reduction in zip(layers, self.reduction, strict=True)]  # fmt: skip
        layer = int(np.argmax(waves))
        if not waves[layer] > _THICK:
            return ""
        return (f"layer {layer + 1} is {layers[layer].thickness:.3g} m thick, {waves[layer]:.2g} "
                f"wavelengths at the mean period of {period:.3g} s: divide layers until they are "
                f"below {_THICK:g}")  # fmt: skip

    @property
    def strain_doubt(self) -> str:
        """Return a warning: strains above 0.5 % or two solutions; '' if there is none."""
        peak = float(self.largest_strain.max())
        if peak <= DOUBTFUL_STRAIN:
            return ""
        layer = 1 + int(self.largest_strain.argmax())
        verdict = "is not accurate" if peak > _MEANINGLESS else "may not be accurate"
        text = (
            f"layer {layer} has {100 * peak:.3g} % strain: above {100 * DOUBTFUL_STRAIN:g} % the "
            f"equivalent-linear method {verdict}; compare with the nonlinear analysis"
        )
        if np.isnan(self.other_strain):
            return text
        return (f"{text}. A second solution, of {100 * self.other_strain:.3g} % strain, also "
                "satisfies the curves")  # fmt: skip

    def __str__(self) -> str:
        lines = ["depth to bottom  effective strain   G/Gmax   damping"]
        _, interfaces = self.response.column.cut_at([])
        rows = zip(interfaces[1:], self.strain, self.reduction, self.damping, strict=True)
        lines += [f"{depth:13.4g} m {100 * strain:15.4g} % {reduction:8.4f} {100 * damping:7.3f} %"
                  for depth, strain, reduction, damping in rows]  # fmt: skip
        lines.append(f"{self.iterations} iterations, last change of moduli and damping ratios "
                     f"{100 * self.change:.2g} %")  # fmt: skip
        lines.append(convention_words(self.response.column.convention))
        return "\n".join(filter(None, [*lines, self.doubt]))


def equivalent_linear(
    column: Column,
    curves: Sequence[SoilCurves | None],
    motion,
    time_step: float | None = None,
    *,
    bottom: float | None = None,
    kind: str = "outcrop",
    strain_ratio: float = 0.65,
    tolerance: float = 1e-4,
    most_iterations: int = 500,
) -> EquivalentLinear:
    """Iterate moduli and damping ratios of the layers until they fit their strains.

    Parameters
    ----------
    column : Column
        Column with n layers and their moduli at small strains.
    curves : sequence of SoilCurves or None, length n
        Curves of each layer; None: the layer is linear with its own damping ratio.
    motion, time_step, bottom, kind
        See :meth:`Column.response`.
    strain_ratio : float
        Ratio of effective to largest strain: 0.65 or (magnitude − 1)/10.
    tolerance : float
        Relative error of moduli and damping ratios at which the iteration ends, estimated from the
        last change c and the one before: c r/(1 − r) with their ratio r, and c at least.
    most_iterations : int

    Raises
    ------
    ConvergenceError
        If the iteration does not converge.
    """
    column.check_curves(curves)
    if not 0 < strain_ratio <= 1:
        raise InputError(f"strain_ratio must be in 0 < ratio <= 1, got {strain_ratio!r}")
    if not 0 < tolerance < 1:
        raise InputError(f"tolerance must be in 0 < tolerance < 1, got {tolerance!r}")
    ground = Motion.of(motion, time_step)

    reference = {"bottom": bottom, "kind": kind}
    settings = (reference, strain_ratio, tolerance, most_iterations)
    result = _iterate_properties(column, curves, ground, 0.0, *settings)
    if result.strain_doubt:  # soft soil may have another solution
        with suppress(ConvergenceError, ValueError):
            second = _iterate_properties(column, curves, ground, _SOFT, *settings)
            if np.max(abs(second.strain / result.strain - 1)) > _APART:
                return replace(result, other_strain=float(second.largest_strain.max()))
    return result


def _iterate_properties(
    column, curves, ground, start_strain, reference, strain_ratio, tolerance, most_iterations
) -> EquivalentLinear:
    """Iterate from a strain of all layers to a column whose properties fit its strains."""
    reduction, damping = _strain_properties(column, curves, np.full(len(curves), start_strain))
    previous_change = 0.0
    for iteration in range(1, most_iterations + 1):
        fitted = _updated_column(column, curves, reduction, damping)
        response = fitted.response(ground, **reference)
        strain = strain_ratio * np.abs(response.trial_strain(column.middles)).max(axis=-1)
        required = _strain_properties(column, curves, strain)
        change = max(
            float(np.max(np.abs(new - old) / np.maximum(new, 1e-12)))
            for new, old in zip(required, (reduction, damping), strict=True)
        )
        # An iteration reduces the error by the factor r, which a single change does not show.
        ratio = change / previous_change if previous_change else 1.0
        if change == 0 or (ratio < 1 and change * max(1.0, ratio / (1 - ratio)) <= tolerance):
            _check_damping(fitted, damping, strain)
            soil = strain, reduction, damping
            return EquivalentLinear(response, *soil, iteration, change, strain_ratio)
        (reduction, damping), previous_change = required, change
    raise ConvergenceError(
        f"the equivalent-linear iteration does not converge: after {most_iterations} iterations "
        f"moduli or damping ratios still change by {100 * change:.3g} %; try a larger tolerance"
    )


def small_strain_column(column: Column, curves: Sequence[SoilCurves | None]) -> Column:
    """Return the column with the moduli and damping ratios of its curves at small strains."""
    properties = _strain_properties(column, curves, np.zeros(len(curves)))
    return _updated_column(column, curves, *properties)


def _strain_properties(column, curves, strain):
    """Return G/G_max and damping ratio (of linear layers at 1 Hz) of each layer at its strain."""
    pairs = [
        (1.0, layer.damping_at([1.0])[0]) if curve is None
        else (curve.reduction_at(layer_strain), curve.damping_at(layer_strain))
        for layer, curve, layer_strain in zip(column.layers, curves, strain, strict=True)
    ]  # fmt: skip
    return tuple(np.array(values, dtype=float) for values in zip(*pairs, strict=True))


def _check_damping(column: Column, damping, strain) -> None:
    """Reject damping ratios for which the convention has no complex modulus."""
    largest = largest_damping(column.convention)
    for number, (ratio, layer_strain) in enumerate(zip(damping, strain, strict=True), start=1):
        if ratio > largest:
            raise InputError(
                f"layer {number} has a damping ratio of {ratio:.4g} at its strain of "
                f"{100 * layer_strain:.4g} %; convention '{column.convention}' permits "
                f"{largest:g}: try Column(convention='shake91'), or curves for large strains"
            )


def _updated_column(column: Column, curves, reduction, damping) -> Column:
    """Return the column with these properties; damping is limited to the range allowed."""
    layers = list(column.layers)
    damping = np.minimum(damping, largest_damping(column.convention))
    for i, (layer, curve) in enumerate(zip(column.layers, curves, strict=True)):
        if curve is not None:
            modulus = reduction[i] * layer.shear_modulus
            layers[i] = replace(layer, shear_modulus=modulus, shear_velocity=None,
                                damping=damping[i])  # fmt: skip
    return replace(column, layers=layers)
