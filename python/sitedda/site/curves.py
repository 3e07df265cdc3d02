# SPDX-License-Identifier: GPL-3.0-or-later
"""Modulus reduction and damping of soils over the shear strain."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.arguments import first_of, positive
from ..base.errors import InputError

ATMOSPHERE = 101325.0  # Pa
STRAINS = np.logspace(-6, -1.5, 91)  # strains at which formulas are tabulated
_PARTS = 60  # parts of their intervals in integrals of Masing's rules
_BELOW = 60  # number of intervals below the table at which such integrals begin


@dataclass(frozen=True, eq=False)
class SoilCurves:
    """Secant modulus and damping ratio of a soil as functions of the shear strain.

    They are interpolated linearly in the logarithm of the strain and constant beyond, as in SHAKE.

    Attributes
    ----------
    strain : ndarray, shape (n,)
        Increasing, dimensionless (1e-4 is 0.01 %).
    reduction : ndarray, shape (n,)
        G/G_max, in 0 … 1.
    damping : ndarray, shape (n,)
        Damping ratio, a fraction.
    name : str
    """

    strain: NDArray[np.float64]
    reduction: NDArray[np.float64]
    damping: NDArray[np.float64]
    name: str = ""

    def __post_init__(self) -> None:
        values_given = self.strain, self.reduction, self.damping
        arrays = [np.array(values, dtype=float) for values in values_given]
        strain, reduction, damping = arrays
        if strain.ndim != 1 or strain.size < 2 or any(a.shape != strain.shape for a in arrays):
            raise InputError("strain, reduction and damping must have equal lengths of at least 2")
        if not (np.all(strain > 0) and np.all(np.diff(strain) > 0) and np.all(np.isfinite(strain))):
            raise InputError("strain must be positive and increasing")
        is_valid = (reduction > 0) & (reduction <= 1)
        if not np.all(is_valid):
            value = first_of(reduction, ~is_valid)
            raise InputError(f"reduction must be in 0 < G/Gmax <= 1, got {value}")
        is_valid = (damping >= 0) & (damping < 1)
        if not np.all(is_valid):
            value = first_of(damping, ~is_valid)
            raise InputError(f"damping must be a fraction in 0 … 1, got {value}")
        for name, values in zip(("strain", "reduction", "damping"), arrays, strict=True):
            object.__setattr__(self, name, values)

    def __eq__(self, other) -> bool:
        return isinstance(other, SoilCurves) and self._content == other._content

    def __hash__(self) -> int:
        return hash(self._content)

    @property
    def _content(self) -> tuple[bytes, ...]:
        return tuple(values.tobytes() for values in (self.strain, self.reduction, self.damping))

    def reduction_at(self, strain: ArrayLike) -> NDArray[np.float64]:
        """Return G/G_max at shear strains."""
        return np.interp(_log_strain(strain), np.log(self.strain), self.reduction)

    def damping_at(self, strain: ArrayLike) -> NDArray[np.float64]:
        """Return the damping ratio at shear strains."""
        return np.interp(_log_strain(strain), np.log(self.strain), self.damping)

    def implied_strength(self, shear_modulus: float) -> float:
        """Return the largest shear stress of the curves for a modulus of small strains, both Pa."""
        return float(shear_modulus * np.max(self.strain * self.reduction))

    @classmethod
    def from_pystrata(cls, soil) -> "SoilCurves":
        """Return the curves of a soil type of pystrata (Vucetic & Dobry, Seed & Idriss, …)."""
        reduction, damping = soil.mod_reduc, soil.damping
        strain = np.union1d(reduction.strains, damping.strains)
        name = str(getattr(soil, "name", ""))

        def values(curve):
            return np.interp(np.log(strain), np.log(curve.strains), curve.values)

        return cls(strain, np.clip(values(reduction), 1e-6, 1.0), values(damping), name)


def _log_strain(strain: ArrayLike) -> NDArray[np.float64]:
    return np.log(np.maximum(np.abs(np.asarray(strain, dtype=float)), 1e-12))


def hyperbolic(
    reference_strain: float, curvature: float = 1.0, least_damping: float = 0.0
) -> SoilCurves:
    """G/G_max = 1/(1 + (γ/γ_r)^a) with the damping of Masing's rules for a = 1.

    Parameters
    ----------
    reference_strain : float
        γ_r at which the modulus is halved, dimensionless.
    curvature : float
        a.
    least_damping : float
        Damping ratio at small strain, added.
    """
    reference = float(positive("reference_strain", reference_strain))
    power = float(positive("curvature", curvature))
    reduction = 1 / (1 + (STRAINS / reference) ** power)
    damping = least_damping + _masing_damping(STRAINS / reference)
    return SoilCurves(STRAINS, reduction, np.minimum(damping, 0.999), "hyperbolic")


def mkz(reference_strain: float, beta: float = 1.0, power: float = 1.0) -> SoilCurves:
    """Return the modified hyperbola G/G_max = 1/(1 + β(γ/γ_r)^s) with Masing's damping.

    Parameters
    ----------
    reference_strain : float
        γ_r, dimensionless.
    beta : float
        β.
    power : float
        s, at most 1, so that the stress never falls.

    References
    ----------
    Matasovic, N. & Vucetic, M. (1993). Cyclic characterization of liquefiable sands. Journal of
    Geotechnical Engineering 119(11), 1805-1822.
    """
    reference = float(positive("reference_strain", reference_strain))
    factor, exponent = float(positive("beta", beta)), float(positive("power", power))
    if exponent > 1:
        raise InputError(f"power must be in 0 < s <= 1, got {exponent:g}: stress would decrease")
    return _masing_curves(lambda strain: 1 / (1 + factor * (strain / reference) ** exponent), "MKZ")


def gqh(reference_strain: float, theta: ArrayLike) -> SoilCurves:
    """Return a quadratic/hyperbolic backbone with shear strength and Masing's damping.

    τ/τ_max = 2x/[1 + x + √((1 + x)² − 4θx)] with x = γ/γ_r and
    θ = θ₁ + θ₂ θ₄ x^θ₅/(θ₃^θ₅ + θ₄ x^θ₅), which must nowhere be above 1.

    Parameters
    ----------
    reference_strain : float
        γ_r = τ_max/G_max: the shear strength over the modulus at small strain.
    theta : array_like, shape (5,)
        θ₁ … θ₅.

    Raises
    ------
    InputError
        If a value is out of range, or θ above 1 at a strain.

    References
    ----------
    Groholski, D. R. et al. (2016). Simplified model for small-strain nonlinearity and strength in
    1D seismic site response analysis. Journal of Geotechnical and Geoenvironmental Engineering
    142(9), 04016042.
    """
    reference = float(positive("reference_strain", reference_strain))
    fit = np.array(theta, dtype=float)
    if fit.shape != (5,) or not np.all(np.isfinite(fit)):
        raise InputError(f"theta must be five finite numbers, got {theta!r}")

    def reduction(strain):
        x = strain / reference
        growth = fit[3] * x ** fit[4]
        theta_values = fit[0] + fit[1] * growth / (fit[2] ** fit[4] + growth)
        if not np.all(theta_values <= 1):
            raise InputError(
                f"theta gives θ = {np.max(theta_values):g} at a strain of "
                f"{100 * first_of(strain, ~(theta_values <= 1)):.3g} %: θ must not exceed 1"
            )
        return _gqh_reduction(x, theta_values)

    return _masing_curves(reduction, "GQ/H")


def strength_corrected(
    curves: SoilCurves, shear_modulus: float, strength: float, known: float = 1e-3
) -> SoilCurves:
    """Return curves that follow given ones at small strains and tend to a strength (GQ/H).

    θ of :func:`gqh` is fitted to G/G_max up to a strain; the damping ratio stays the given one.

    Parameters
    ----------
    shear_modulus : float
        Modulus at small strains, Pa.
    strength : float
        Shear strength, Pa.
    known : float
        Strain up to which the curves are fitted; smaller if they exceed 0.7 of the strength.

    Raises
    ------
    InputError
        If a value is out of range, or the strength is reached at strains below 0.01 %.

    References
    ----------
    Groholski, D. R. et al. (2016), as :func:`gqh`.
    """
    from scipy.optimize import least_squares

    reference = float(positive("strength", strength) / positive("shear_modulus", shear_modulus))
    if not 1e-4 <= reference <= 0.1:
        raise InputError(
            f"a strength of {strength / 1e3:.4g} kPa is {100 * reference:.3g} % of the shear "
            "modulus; it must be 0.01 to 10 %"
        )
    x = np.logspace(-6, np.log10(known), 61) / reference
    target = curves.reduction_at(reference * x)
    x, target = x[is_weak := (x * target < 0.7)], target[is_weak]

    def reduction(p, ratios):
        growth = (ratios / np.exp(p[2])) ** p[3]
        return _gqh_reduction(ratios, p[0] + (p[1] - p[0]) * growth / (1 + growth))

    end_ratio = 0.1 / reference  # the strength is to be reached at a strain of 10 %

    def residuals(p):
        return np.append(reduction(p, x) - target, 0.4 * (end_ratio * reduction(p, end_ratio) - 1))

    bounds = [-20.0, -20.0, -8.0, 0.2], [1.0, 1.0, 8.0, 0.99]
    starts = [0.5, 0.9, 0.0, 0.8], [-2.0, 0.9, 1.0, 0.9], [0.9, -2.0, 0.0, 0.8]
    fits = [least_squares(residuals, start, bounds=bounds) for start in starts]
    p = min(fits, key=lambda fit: fit.cost).x
    strain = np.append(STRAINS, np.logspace(-1.45, -1.0, 10))
    reductions = np.minimum(reduction(p, strain / reference), 1.0)
    return SoilCurves(strain, reductions, curves.damping_at(strain), f"{curves.name}, GQ/H")


def _gqh_reduction(x, theta):
    """Return G/G_max of GQ/H at x = γ/γ_r with θ there."""
    return 2 / (1 + x + np.sqrt((1 + x) ** 2 - 4 * theta * x))


def darendeli(
    mean_stress: float,
    plasticity_index: float = 0.0,
    over_consolidation: float = 1.0,
    frequency: float = 1.0,
    cycles: float = 10.0,
) -> SoilCurves:
    """Return the curves of Darendeli (2001) for a soil in a given state.

    Parameters
    ----------
    mean_stress : float
        Mean effective stress σ₀', Pa.
    plasticity_index : float
        PI, per cent.
    over_consolidation : float
        OCR.
    frequency : float
        Frequency of the loading, Hz.
    cycles : float
        Number of cycles.

    References
    ----------
    Darendeli, M. B. (2001). Development of a new family of normalized modulus reduction and
    material damping curves. PhD dissertation, The University of Texas at Austin. The constants
    are those of the program Strata, ``DarendeliNonlinearProperty``.
    """
    stress = float(positive("mean_stress", mean_stress)) / ATMOSPHERE
    ratio = float(positive("over_consolidation", over_consolidation))
    plasticity = float(plasticity_index)
    if not 0 <= plasticity <= 300:
        raise InputError(f"plasticity_index must be in 0 … 300 per cent, got {plasticity:g}")
    log_frequency = np.log(float(positive("frequency", frequency)))
    log_cycles = np.log(float(positive("cycles", cycles)))
    power = 0.919
    reference = (0.0352 + 0.0010 * plasticity * ratio**0.3246) * stress**0.3483 / 100
    reduction = 1 / (1 + (STRAINS / reference) ** power)
    smallest_damping = (0.8005 + 0.0129 * plasticity * ratio**-0.1069) * stress**-0.2889
    smallest_damping *= 1 + 0.2919 * log_frequency
    masing = 100 * _masing_damping(STRAINS / reference)
    c1 = -1.1143 * power**2 + 1.8618 * power + 0.2523
    c2 = 0.0805 * power**2 - 0.0710 * power - 0.0095
    c3 = -0.0005 * power**2 + 0.0002 * power + 0.0003
    masing = c1 * masing + c2 * masing**2 + c3 * masing**3
    damping = (smallest_damping + (0.6329 - 0.00566 * log_cycles) * reduction**0.1 * masing) / 100
    damping = np.maximum.accumulate(damping)  # beyond, the polynomial would decrease
    return SoilCurves(STRAINS, reduction, np.clip(damping, 0.0, 0.999), "Darendeli (2001)")


def curves_of(material: Mapping, shear_modulus: float) -> SoilCurves:
    """Return the curves of a group &material of law 'hysteretic' with a modulus (Pa)."""
    value = material.get
    curve = material["curve"]
    if curve == "darendeli":
        state = value("plasticity_index", 0.0), value("ocr", 1.0), value("reference_frequency", 1.0)
        return darendeli(material["mean_stress"], *state)
    if curve == "table":
        return SoilCurves(material["strains"], material["reductions"], material["dampings"])
    reference = value("reference_strain") or material["shear_strength"] / shear_modulus
    if curve == "mkz":
        return mkz(reference, value("curve_factor", 1.0), value("curve_power", 1.0))
    return gqh(reference, material["curve_fit"]) if curve == "gqh" else hyperbolic(reference)


def _masing_curves(reduction, name: str) -> SoilCurves:
    """Return curves of a function G/G_max of the strain with Masing's damping.

    D = (2/π) [2 ∫τ dγ/(τγ) − 1], by the trapezoidal rule on _PARTS strains between two of the
    table, from _BELOW intervals before it on; the soil is linear up to there.
    """
    step = np.log(STRAINS[1] / STRAINS[0]) / _PARTS
    number = np.arange(-_BELOW * _PARTS, (STRAINS.size - 1) * _PARTS + 1)
    fine = STRAINS[0] * np.exp(step * number)
    stress = fine * reduction(fine)
    work = np.cumsum(np.diff(fine) * (stress[1:] + stress[:-1]) / 2)
    work = fine[0] * stress[0] / 2 + np.concatenate([[0.0], work])
    damping = (2 / np.pi * (2 * work / (stress * fine) - 1))[_BELOW * _PARTS :: _PARTS]
    moduli = np.minimum(reduction(STRAINS), 1.0)
    return SoilCurves(STRAINS, moduli, np.clip(damping, 0.0, 0.999), name)


def _masing_damping(ratio: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return Masing's damping ratio of a hyperbola at γ/γ_r."""
    small = ratio < 1e-3
    safe = np.where(small, 1.0, ratio)
    loop = 4 * (safe - np.log1p(safe)) / (safe**2 / (1 + safe)) - 2
    series = 2 * ratio / 3 - ratio**2 / 3
    return np.where(small, series, loop) / np.pi
