# SPDX-License-Identifier: GPL-3.0-or-later
"""Random profiles of a site: velocity and layering of Toro (1995), depth to rock, soil curves."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.arguments import positive
from ..base.errors import InputError
from .column import Column, Layer
from .curves import SoilCurves
from .profile import Profile

Site = tuple[Column, Sequence[SoilCurves | None]]  # a column and the curves of its layers

_C1, _C2, _C3 = 10.86, -0.89, 1.98  # parameters of the rate of interfaces, 1/m, with depths in m
_DEEP = 200.0  # m, depth below which the correlation of velocities is constant
_STIFFEST = 0.05  # smallest G/G_max of a varied curve
_DAMPING = (0.001, 0.15)  # range of varied damping ratios


@dataclass(frozen=True)
class Toro:
    """Correlation of log-normal velocities of layers: ρ = (1 − ρ_d) ρ_t + ρ_d.

    ρ_d = ρ₂₀₀ [(h + h₀)/(200 + h₀)]^b with the mean depth h of the middles of two layers (m; ρ₂₀₀
    below 200 m), ρ_t = ρ₀ exp(−t/Δ) with the distance t of the middles (m).

    References
    ----------
    Toro, G. R. (1995). Probabilistic models of site velocity profiles for generic and
    site-specific ground-motion amplification studies. Brookhaven National Laboratory, 779574.
    """

    sigma: float  # standard deviation of ln V_s
    rho_0: float
    delta: float  # m
    rho_200: float
    h_0: float  # m
    b: float

    def correlation(self, middles: ArrayLike) -> NDArray[np.float64]:
        """Return the correlation between each layer and the next, by the depths of middles (m)."""
        depths = np.asarray(middles, dtype=float)
        depth, distance = np.minimum((depths[1:] + depths[:-1]) / 2, _DEEP), np.diff(depths)
        deep = self.rho_200 * ((depth + self.h_0) / (_DEEP + self.h_0)) ** self.b
        return (1 - deep) * self.rho_0 * np.exp(-distance / self.delta) + deep


TORO = {  # Toro (1995): by V_s30 (A above 750, B to 360, C to 180 m/s, D below), by Geomatrix
    "USGS A": Toro(0.36, 0.95, 3.4, 0.42, 0.0, 0.063),
    "USGS B": Toro(0.27, 0.97, 3.8, 1.00, 0.0, 0.293),
    "USGS C": Toro(0.31, 0.99, 3.9, 0.98, 0.0, 0.344),
    "USGS D": Toro(0.37, 0.00, 5.0, 0.50, 0.0, 0.744),
    "USGS AB": Toro(0.35, 0.95, 4.2, 1.00, 0.0, 0.138),
    "USGS CD": Toro(0.36, 0.99, 3.9, 1.00, 0.0, 0.293),
    "Geomatrix AB": Toro(0.46, 0.96, 13.1, 0.96, 0.0, 0.095),
    "Geomatrix CD": Toro(0.38, 0.99, 8.0, 1.00, 0.0, 0.160),
}


def randomized(
    profile: Profile,
    count: int,
    seed: int = 1,
    *,
    velocity: str | Toro | None = "USGS C",
    sigma: float | None = None,
    layering: bool = False,
    depth_to_rock: float = 0.0,
    curves: float | None = None,
    clip: float = 2.0,
    water_table: float = math.inf,
    pressure_at_rest: float = 0.5,
) -> list[Site]:
    """Draw random realisations of a profile; the first ones do not depend on their number.

    Parameters
    ----------
    profile : Profile
        Its velocities are the medians.
    velocity : str, Toro or None
        Correlation of the velocities, one of `TORO`; None: they are those of the profile.
    sigma : float, optional
        Standard deviation of ln V_s, instead of the model's.
    layering : bool
        Interfaces by a Poisson process of rate 1.98 (h + 10.86)^−0.89 per m at depth h (m), in
        place of the profile's; a layer has the soil of the depth of its middle.
    depth_to_rock : float
        Standard deviation of the logarithm of the depth of the lowest layer's bottom.
    curves : float, optional
        Correlation of G/G_max and damping ratio, such as −0.5, with the standard deviations of
        Darendeli (2001) and one pair of deviates a row; None: curves are not varied.  They stay
        within G/G_max 0.05 … 1 and damping ratios of 0.1 … 15 %, and the stress never falls.
    clip : float
        Deviates are normal, truncated at this number of standard deviations, and then
        rescaled to the standard deviation of the model.
    water_table, pressure_at_rest : float
        See `Profile.curves`.

    Returns
    -------
    list of (Column, list of SoilCurves or None)
    """
    model = _velocity_model(velocity, sigma)
    if count != int(count) or count < 1:
        raise InputError(f"count = {count!r}: give a whole number above 0")
    if not 0 <= depth_to_rock < 2:
        raise InputError(f"depth_to_rock = {depth_to_rock!r}: give the standard deviation of the "
                         "logarithm of the depth, from 0 to 2")  # fmt: skip
    if curves is not None and not -1 <= curves <= 1:
        raise InputError(f"curves = {curves!r}: give a correlation from -1 to 1")
    positive("clip", clip)
    originals = profile.curves(water_table, pressure_at_rest)
    realisations = []
    for number in range(int(count)):
        deviates = _Deviates(np.random.default_rng([int(seed), number]), clip)
        bottom = profile.depth * math.exp(depth_to_rock * float(deviates.normal(1)[0]))
        if layering:
            bottoms = interfaces(deviates.generator, bottom)
        else:
            bottoms = np.append(profile.tops[1:-1][profile.tops[1:-1] < bottom], bottom)
        soils = originals
        if curves is not None:
            soils = [deviates.curves(curve, curves) for curve in originals]
        realisations.append(_draw_realisation(profile, bottoms, model, deviates, soils))
    return realisations


def interfaces(generator: np.random.Generator, depth: float) -> NDArray[np.float64]:
    """Draw depths (m) of layer bottoms down to the lowest by Toro's Poisson process."""
    power, unit_rate_depth, depths = _C2 + 1, 0.0, []
    while True:
        unit_rate_depth += generator.exponential()
        bottom = (power * unit_rate_depth / _C3 + _C1**power) ** (1 / power) - _C1
        if bottom >= depth:
            return np.array([*depths, depth])
        depths.append(bottom)


def varied_curves(curves: SoilCurves, reduction: float, damping: float) -> SoilCurves:
    """Shift G/G_max and damping ratio by standard deviations of Darendeli (2001, 7.29 and 7.30)."""
    mean = curves.reduction
    deviation = np.exp(-4.23) + np.sqrt(np.maximum(0.25 - (mean - 0.5) ** 2, 0.0) / np.exp(3.62))
    reductions = np.clip(mean + reduction * deviation, np.minimum(mean, _STIFFEST), 1.0)
    reductions = np.minimum.accumulate(reductions)
    stress = np.maximum.accumulate(curves.strain * reductions)
    deviation = (np.exp(-5.0) + np.exp(-0.25) * np.sqrt(100 * curves.damping)) / 100
    ratios = np.clip(curves.damping + damping * deviation, *_DAMPING)
    return replace(curves, reduction=stress / curves.strain, damping=ratios)


class _Deviates:
    """Standard normal deviates, truncated and rescaled to a standard deviation of 1."""

    def __init__(self, generator: np.random.Generator, clip: float):
        self.generator, self.clip = generator, clip

    def normal(self, count: int, correlation: ArrayLike = 0.0) -> NDArray[np.float64]:
        """Draw a row with correlations between successive deviates, shape (count - 1,)."""
        deviates = self.generator.standard_normal(count)
        for i, rho in enumerate(np.broadcast_to(correlation, max(count - 1, 0)), start=1):
            deviates[i] = rho * deviates[i - 1] + math.sqrt(1 - rho**2) * deviates[i]
        return truncated(deviates, self.clip)

    def curves(self, curves: SoilCurves | None, correlation: float) -> SoilCurves | None:
        # Deviates are drawn for linear soil too, so that those of other rows do not change.
        pair = self.normal(2, correlation)
        return None if curves is None else varied_curves(curves, *map(float, pair))


def truncated(deviates: NDArray[np.float64], clip: float) -> NDArray[np.float64]:
    """Convert standard normal deviates to a normal distribution truncated at ± `clip`.

    Their standard deviation is 1; correlations change little (by less than 0.03 at a clip of 2).
    """
    from scipy.special import ndtr, ndtri

    low, high = ndtr(-clip), ndtr(clip)
    density = math.exp(-(clip**2) / 2) / math.sqrt(2 * math.pi)
    deviation = math.sqrt(1 - 2 * clip * density / (high - low))
    return ndtri(low + ndtr(deviates) * (high - low)) / deviation


def _velocity_model(velocity, sigma: float | None) -> Toro | None:
    if velocity is None:
        return None
    if not isinstance(velocity, Toro):
        if velocity not in TORO:
            raise InputError(f"velocity = {velocity!r}: use {', '.join(TORO)}")
        velocity = TORO[velocity]
    if sigma is not None and not 0 < sigma < 2:
        raise InputError(f"sigma = {sigma!r}: give the standard deviation of ln V_s, 0 to 2")
    return velocity if sigma is None else replace(velocity, sigma=float(sigma))


def _draw_realisation(
    profile: Profile, bottoms, model: Toro | None, deviates: _Deviates, soils
) -> Site:
    """Draw a realisation with layers whose bottoms are at depths `bottoms`, m."""
    tops = np.concatenate([[0.0], bottoms[:-1]])
    middles = (tops + bottoms) / 2
    rows = np.searchsorted(profile.tops[1:-1], middles, side="right")
    speeds = np.array([profile.layers[row].shear_velocity for row in rows])
    if model is not None:
        log_deviates = deviates.normal(bottoms.size, np.clip(model.correlation(middles), -1.0, 1.0))
        speeds = speeds * np.exp(model.sigma * log_deviates)
    values = [profile.layers[row].values() | {"shear_velocity": float(speed)}
              for row, speed in zip(rows, speeds, strict=True)]  # fmt: skip
    thicknesses = (bottoms - tops).tolist()
    layers = [Layer(h, **soil) for h, soil in zip(thicknesses, values, strict=True)]
    return Column(layers, profile.column().base), [soils[row] for row in rows]
