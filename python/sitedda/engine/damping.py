# SPDX-License-Identifier: GPL-3.0-or-later
"""Damping of materials as in the engine: constant ratio or Rayleigh damping."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.arguments import not_negative, positive
from ..base.core import api, checked
from .scheme import Scheme, SteadyFactors

Factors = tuple[NDArray[np.complex128], NDArray[np.complex128]]


@dataclass(frozen=True)
class Body:
    """A generalised Maxwell body fitted to a damping ratio.

    `omega`, `weight`: relaxation frequencies (rad/s) and weights Y, shape (mechanisms,).
    """

    omega: NDArray[np.float64]
    weight: NDArray[np.float64]
    unrelaxed: float  # unrelaxed modulus / modulus of the input
    misfit: float  # largest relative error of the damping ratio in the band
    band: tuple[float, float]  # lowest and highest frequency of the fit, Hz

    def factor(self, omega: ArrayLike) -> NDArray[np.complex128]:
        """Return complex modulus / modulus of the input, at angular frequencies (rad/s)."""
        frequency = np.asarray(omega, dtype=float)[..., None]
        relaxed = np.sum(self.weight * self.omega / (self.omega + 1j * frequency), -1)
        return self.unrelaxed * (1 - relaxed)


class MaterialDamping:
    """Base class of the damping of a layer of a :class:`sitedda.Column`."""

    def factors(self, frequency: NDArray[np.float64]) -> Factors:
        """Return the ratios of complex modulus and density to those of the input; Hz."""
        raise NotImplementedError

    def scheme_factors(
        self, frequency: NDArray[np.float64], steady: SteadyFactors, scheme: Scheme, step: float
    ) -> Factors:
        """Return `factors` under a time integration, without the factors of the scheme itself."""
        raise NotImplementedError

    def ratio_at(self, frequency: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the damping ratio at frequencies in Hz."""
        modulus, density = self.factors(frequency)
        square = modulus / density  # square of the complex velocity
        return 0.5 * square.imag / square.real


@dataclass(frozen=True)
class ConstantRatio(MaterialDamping):
    """``&material damping_ratio``: a constant damping ratio in a frequency band."""

    ratio: float  # damping ratio ζ > 0
    reference_frequency: float = 1.0  # frequency at which the modulus is that of the input, Hz
    # Hz; by default 0.1 ... 50; a long time step lowers the upper end.
    band: tuple[float, float] | None = None
    # Number of relaxation mechanisms; by default as many as the accuracy requires.
    mechanisms: int | None = None

    def __post_init__(self) -> None:
        positive("ratio", self.ratio)
        positive("reference_frequency", self.reference_frequency)
        _ = self.body

    @cached_property
    def body(self) -> Body:
        """Return the fitted body for time steps that are short enough for all its mechanisms."""
        return self._body_for_limit(np.finfo(float).max)

    def _body_for_limit(self, limit: float) -> Body:
        """Return the fitted body with relaxation frequencies below a limit, rad/s."""
        band = (0.0, 0.0) if self.band is None else tuple(map(float, self.band))
        ratio, reference = float(self.ratio), float(self.reference_frequency)
        return _fit_body(ratio, reference, band, self.mechanisms or 0, limit)

    def factors(self, frequency: NDArray[np.float64]) -> Factors:
        """Return the factor of the body on the modulus, and 1 for the density."""
        modulus = self.body.factor(2 * np.pi * frequency)
        return modulus, np.ones_like(modulus)

    def scheme_factors(
        self, frequency: NDArray[np.float64], steady: SteadyFactors, scheme: Scheme, step: float
    ) -> Factors:
        """Return the factors of the body that the time step permits, at pre-warped frequencies."""
        limit = np.finfo(float).max
        if scheme.theta > 0.5:
            limit = 4 / ((scheme.theta - 0.5) * step)
        warped = 2 * np.tan(np.pi * frequency * step) / step
        modulus = self._body_for_limit(limit).factor(warped)
        return modulus, np.ones_like(modulus)


@lru_cache
def _fit_body(ratio: float, reference: float, band: tuple, mechanisms: int, limit: float) -> Body:
    """Fit a generalised Maxwell body to a damping ratio; see `ConstantRatio`."""
    count, omega, weight, numbers = checked(api.body_of, ratio, reference, band, mechanisms, limit)
    unrelaxed, misfit, low, high = map(float, numbers)
    return Body(omega[:count].copy(), weight[:count].copy(), unrelaxed, misfit, (low, high))


@dataclass(frozen=True)
class Rayleigh(MaterialDamping):
    """``&material rayleigh_alpha, rayleigh_beta``: C = αM + βK."""

    alpha: float = 0.0  # 1/s, >= 0
    beta: float = 0.0  # s, >= 0

    def __post_init__(self) -> None:
        not_negative("alpha", self.alpha)
        not_negative("beta", self.beta)

    @classmethod
    def at(cls, ratio: float, frequencies: tuple[float, float]) -> "Rayleigh":
        """Return Rayleigh damping with a given damping ratio at two frequencies, Hz."""
        low, high = 2 * np.pi * positive("frequencies", np.asarray(frequencies, dtype=float))
        beta = 2 * float(not_negative("ratio", ratio)) / (low + high)
        return cls(float(beta * low * high), float(beta))

    def factors(self, frequency: NDArray[np.float64]) -> Factors:
        """Return the factors 1 + iβω and 1 - iα/ω."""
        omega = 2 * np.pi * np.maximum(frequency, np.finfo(float).tiny)
        return 1 + 1j * self.beta * omega, 1 - 1j * self.alpha / omega

    def scheme_factors(
        self, frequency: NDArray[np.float64], steady: SteadyFactors, scheme: Scheme, step: float
    ) -> Factors:
        """Return the factors with the discrete forms of the dashpots (on d/Δt) and of inertia."""
        inertia = np.where(steady.inertia == 0, np.finfo(float).tiny, steady.inertia)
        drag = self.alpha * steady.mean_dashpot / inertia
        return 1 + self.beta * steady.mean_dashpot, 1 + np.where(frequency > 0, drag, 0)


def damping_of(material: Mapping) -> MaterialDamping | None:
    """Return the damping of a group &material.

    `material`: its variables, as in the input.  Without damping, the result is None.
    """
    if material.get("rayleigh_alpha") or material.get("rayleigh_beta"):
        return Rayleigh(material.get("rayleigh_alpha", 0.0), material.get("rayleigh_beta", 0.0))
    if not material.get("damping_ratio"):
        return None
    if "rayleigh_frequencies" in material:
        return Rayleigh.at(material["damping_ratio"], material["rayleigh_frequencies"])
    reference = material.get("reference_frequency", ConstantRatio.reference_frequency)
    band = tuple(material["damping_band"]) if "damping_band" in material else None
    return ConstantRatio(material["damping_ratio"], reference, band, material.get("mechanisms"))
