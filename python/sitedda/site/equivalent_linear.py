# SPDX-License-Identifier: GPL-3.0-or-later
"""Equivalent-linear soil: moduli and damping that fit the strains they lead to (SHAKE)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..base.errors import ConvergenceError
from .column import Column
from .curves import SoilCurves
from .layers import convention_words, largest_damping
from .motion import Motion
from .response import ColumnResponse


@dataclass(frozen=True)
class EquivalentLinear:
    """The column that fits its strains, and how it was found.

    Attributes
    ----------
    response : ColumnResponse
        Of the fitted column; ``response.column`` has its moduli and damping ratios.
    strain : ndarray, shape (layers,)
        Effective shear strain of each layer.
    reduction : ndarray, shape (layers,)
        G/G_max.
    damping : ndarray, shape (layers,)
        Damping ratio.
    iterations : int
    change : float
        Largest relative change of a modulus or damping ratio in the last iteration.
    """

    response: ColumnResponse
    strain: NDArray[np.float64]
    reduction: NDArray[np.float64]
    damping: NDArray[np.float64]
    iterations: int
    change: float

    def __str__(self) -> str:
        lines = ["depth to bottom  effective strain   G/Gmax   damping"]
        _, interfaces = self.response.column.cut_at([])
        rows = zip(interfaces[1:], self.strain, self.reduction, self.damping, strict=True)
        for depth, strain, reduction, damping in rows:
            lines.append(
                f"{depth:13.4g} m {100 * strain:15.4g} % {reduction:8.4f} {100 * damping:7.3f} %"
            )
        lines.append(f"{self.iterations} iterations, last change {100 * self.change:.2g} %")
        lines.append(convention_words(self.response.column.convention))
        return "\n".join(lines)


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
    """Fit moduli and damping ratios of the layers to their strains under a motion.

    Parameters
    ----------
    column : Column
        With the moduli at small strain, n layers.
    curves : sequence of SoilCurves or None, length n
        Of each layer; None leaves it linear, with its own damping ratio.
    motion : xarray.Dataset, Motion or array_like, shape (samples,)
        As :func:`sitedda.read_record` returns it, or ground acceleration, m/s².
    time_step : float, optional
        s between samples of an array.
    bottom : float, optional
        Depth of the motion, m; by default the base.
    kind : {'outcrop', 'within'}
        What the motion is.
    strain_ratio : float
        Effective over largest strain; 0.65 or (magnitude − 1)/10.
    tolerance : float
        Relative error of moduli and damping ratios at which the iteration ends, estimated from the
        last change c and the one before: c r/(1 − r) with their ratio r, and c at least.
    most_iterations : int

    Raises
    ------
    ValueError
        If an argument is out of range, or a damping ratio at the end is larger than the convention
        of the column allows.
    ConvergenceError
        If the iteration does not end.
    """
    if len(curves) != len(column.layers):
        raise ValueError(f"{len(column.layers)} layers need as many curves, not {len(curves)}")
    if not 0 < strain_ratio <= 1:
        raise ValueError(f"strain_ratio must be in 0 < ratio <= 1, got {strain_ratio!r}")
    if not 0 < tolerance < 1:
        raise ValueError(f"tolerance must be in 0 < tolerance < 1, got {tolerance!r}")
    ground = motion if isinstance(motion, Motion) else Motion.of(motion, time_step)
    linear = _own_damping(column)
    reduction, damping = _properties(curves, np.zeros(len(linear)), linear)
    _, interfaces = column.cut_at([])
    middles = (interfaces[:-1] + interfaces[1:]) / 2
    before = 0.0
    for iteration in range(1, most_iterations + 1):
        fitted = _with(column, curves, reduction, damping)
        response = ColumnResponse.of(fitted, ground, bottom=bottom, kind=kind)
        strain = strain_ratio * np.abs(response.strain(middles)).max(axis=-1)
        wanted = _properties(curves, strain, linear)
        change = max(
            float(np.max(np.abs(new - old) / np.maximum(new, 1e-12)))
            for new, old in zip(wanted, (reduction, damping), strict=True)
        )
        # An iteration leaves the share r of the error; no word on it from a single change.
        left = change / before if before else 1.0
        if change == 0 or (left < 1 and change * max(1.0, left / (1 - left)) <= tolerance):
            _check_damping(fitted, damping, strain)
            return EquivalentLinear(response, strain, reduction, damping, iteration, change)
        (reduction, damping), before = wanted, change
    raise ConvergenceError(
        f"the equivalent-linear iteration does not end: after {most_iterations} iterations moduli "
        f"or damping ratios still change by {100 * change:.3g} %; try a larger tolerance"
    )


def small_strain_column(column: Column, curves: Sequence[SoilCurves | None]) -> Column:
    """The column with the moduli and damping ratios that its curves have at small strains."""
    linear = _own_damping(column)
    return _with(column, curves, *_properties(curves, np.zeros(len(linear)), linear))


def _own_damping(column: Column) -> NDArray[np.float64]:
    """Damping ratio of each layer at 1 Hz."""
    return np.array([layer.damping_at([1.0])[0] for layer in column.layers])


def _properties(curves, strain, linear):
    """G/G_max and damping ratio of each layer at its strain."""
    pairs = [
        (1.0, own) if curve is None else (curve.reduction_at(at), curve.damping_at(at))
        for curve, at, own in zip(curves, strain, linear, strict=True)
    ]
    return tuple(np.array(values, dtype=float) for values in zip(*pairs, strict=True))


def _check_damping(column: Column, damping, strain) -> None:
    """Refuse damping ratios that the convention has no complex modulus for."""
    largest = largest_damping(column.convention)
    for number, (ratio, at) in enumerate(zip(damping, strain, strict=True), start=1):
        if ratio > largest:
            raise ValueError(
                f"layer {number} has a damping ratio of {ratio:.4g} at its strain of "
                f"{100 * at:.4g} %, but convention '{column.convention}' ends at {largest:g}: try "
                "Column(convention='shake91'), or curves for large strains"
            )


def _with(column: Column, curves, reduction, damping) -> Column:
    """The column with these moduli; iterates that are damped beyond the convention, at its end."""
    damping = np.minimum(damping, largest_damping(column.convention))
    layers = [
        layer
        if curve is None
        else replace(
            layer, shear_modulus=share * layer.shear_modulus, shear_velocity=None, damping=ratio
        )
        for layer, curve, share, ratio in zip(
            column.layers, curves, reduction, damping, strict=True
        )
    ]
    return replace(column, layers=layers)
