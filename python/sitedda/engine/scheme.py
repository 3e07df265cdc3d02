# SPDX-License-Identifier: GPL-3.0-or-later
"""Closed forms of the time integration in linear vibrations, computed by the engine.

A member (θ, χ) of the family evaluates forces at t₀ + θΔt and displaces by d = Δt [(1 − χ) v₀ + χ
v₁] (docs/method.md). With τ = tan(ωΔt/2), its steady response equals that of a continuous system at
the frequency ω̃ = 2τ/Δt with the complex modulus K (1 + i(2θ − 1)τ)(1 + i(2χ − 1)τ).
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.arguments import first_of, not_negative, positive
from ..base.core import api, checked
from ..base.errors import InputError

__all__ = [
    "Scheme",
    "SteadyFactors",
    "Vibration",
    "scheme_damping",
    "scheme_frequency",
    "theta_for_damping",
    "time_step_for_damping",
]

_HUGE = 1e300  # larger numbers of the engine mean "no value"


@dataclass(frozen=True)
class Vibration:
    """Free vibration of oscillators under the time integration."""

    # Damping ratio ln(1/|λ|)/|ln λ|; 1 if the oscillator does not oscillate; shape (...)
    damping: NDArray[np.float64]
    # Relative elongation of the period; -1 if the oscillator does not oscillate; shape (...)
    elongation: NDArray[np.float64]
    # Number of steps in which a velocity that changes sign at each step decays to 1/e; 0 if its
    # sign does not change, inf if it does not decay; shape (...)
    ringing: NDArray[np.float64]
    roots: NDArray[np.complex128]  # eigenvalues of a step; the larger one is first; shape (..., 2)


@dataclass(frozen=True)
class SteadyFactors:
    """Factors of the equations in steady vibration exp(iωt), relative to elastic terms."""

    inertia: NDArray[np.complex128]  # factor of the mass M; replaces -ω², 1/s²; shape (n,)
    # Factor of stiffness at the end of the step (supports); shape (n,)
    end_stiffness: NDArray[np.complex128]
    # `mean_dashpot`, `end_dashpot`: factors of dashpots on d/Δt, and on the velocity at the end of
    # the step, 1/s; shape (n,)
    mean_dashpot: NDArray[np.complex128]
    end_dashpot: NDArray[np.complex128]
    load: NDArray[np.complex128]  # factor of loads and body forces; shape (n,)


@dataclass(frozen=True)
class Scheme:
    """A member (θ, χ) of the family of time integration schemes."""

    # θ, weight of the end of the step in elastic forces, 1/2 ... 1.
    theta: float = 1.0
    # χ, weight of the end velocity in the displacement, 1/2 ... 1.
    chi: float = 0.5

    @classmethod
    def of_control(cls, control: Mapping) -> "Scheme":
        """Return the scheme of a group ``&control`` of an input."""
        theta = control.get("theta", 0.75)
        if "damping_ratio" in control:
            values = (control[name] for name in ("damping_ratio", "damping_frequency", "time_step"))
            theta = float(theta_for_damping(*values))
        return cls.named(control.get("integration", "dda"), theta)

    @classmethod
    def named(cls, integration: "str | Scheme" = "dda", theta: float = 0.75) -> "Scheme":
        """Return the scheme of a name, as in ``&control``.

        Parameters
        ----------
        integration : {'dda', 'midpoint', 'theta', 'backward_euler'} or Scheme
        theta : float
            θ = χ of ``'theta'``, 1/2 ... 1; the other schemes ignore it.
        """
        if isinstance(integration, Scheme):
            return integration
        if not 0.5 <= float(theta) <= 1.0:
            raise InputError(f"theta must be in 0.5 ... 1, got {theta:g}")
        return cls(*map(float, checked(api.scheme_numbers, integration, float(theta))))

    def vibration(self, frequency: ArrayLike, time_step: float) -> Vibration:
        """Return the free vibration of oscillators.

        Parameters
        ----------
        frequency : array_like, shape (...)
            Undamped frequencies, Hz, >= 0; also beyond the Nyquist frequency.
        time_step : float
            Δt, s.
        """
        values = not_negative("frequency", frequency)
        step = float(positive("time_step", time_step))
        numbers, roots = api.scheme_vibration(self.theta, self.chi, step, values.ravel())
        rows = [finite_or_inf(row).reshape(values.shape) for row in numbers]
        damping, elongation, _, ringing = rows
        return Vibration(damping, elongation, ringing, roots.T.reshape(*values.shape, 2))

    def steady(
        self, frequency: ArrayLike, time_step: float, dynamic_factor: float = 1.0
    ) -> SteadyFactors:
        """Return the factors of the equations of motion in steady vibration.

        Parameters
        ----------
        frequency : array_like, shape (n,)
            Hz, >= 0 and below the Nyquist frequency 1/(2Δt).
        time_step : float
            Δt, s.
        dynamic_factor : float
            Factor on the velocity at the start of a step, 0 ... 1.
        """
        values = np.atleast_1d(_check_frequencies(frequency, time_step))
        step, factor = float(time_step), float(dynamic_factor)
        return SteadyFactors(*api.scheme_steady(self.theta, self.chi, step, factor, values))


def scheme_damping(
    frequency: ArrayLike, time_step: float, integration: str | Scheme = "dda", theta: float = 0.75
) -> NDArray[np.float64]:
    """Return the damping ratio that the time integration adds to a steady harmonic motion.

    Half the loss factor of the complex modulus: 2ζ = (a + b)τ/(1 − abτ²) with a = 2θ − 1,
    b = 2χ − 1 and τ = tan(ωΔt/2).  In the DDA member, 2ζ = τ.

    Parameters
    ----------
    frequency : array_like, shape (...)
        Frequencies of the motion, Hz, below the Nyquist frequency 1/(2Δt).
    time_step : float
        Δt, s.
    integration : {'dda', 'midpoint', 'theta', 'backward_euler'} or Scheme
    theta : float
        θ of ``'theta'``.

    Returns
    -------
    ndarray, shape (...)
        Damping ratio ζ; inf if the modulus has no positive real part (abτ² >= 1).

    Raises
    ------
    InputError
        If a frequency reaches the Nyquist frequency or an argument is out of range.
    """
    scheme = Scheme.named(integration, theta)
    values = _check_frequencies(frequency, time_step)
    properties, _ = api.scheme_vibration(scheme.theta, scheme.chi, float(time_step), values.ravel())
    return finite_or_inf(properties[2]).reshape(values.shape)


def scheme_frequency(frequency: ArrayLike, time_step: float) -> NDArray[np.float64]:
    """Return the frequency of the equivalent continuous system, equal for all schemes.

    ω̃/2π = (2/Δt) tan(ωΔt/2)/2π, to be used with the modulus of :func:`scheme_damping`.

    Parameters
    ----------
    frequency : array_like, shape (...)
        Frequencies of the motion, Hz, below the Nyquist frequency 1/(2Δt).
    time_step : float
        Δt, s.

    Returns
    -------
    ndarray, shape (...)
        Equivalent frequency, Hz; never below ``frequency``.

    Raises
    ------
    InputError
        If a frequency reaches the Nyquist frequency or an argument is out of range.
    """
    values = _check_frequencies(frequency, time_step)
    squares = -Scheme.named("midpoint").steady(values.ravel(), time_step).inertia.real
    return np.sqrt(abs(squares)).reshape(values.shape) / (2 * np.pi)


def time_step_for_damping(
    damping: ArrayLike, frequency: ArrayLike, integration: str = "dda", theta: float = 0.75
) -> NDArray[np.float64]:
    """Return the time step at which the time integration has a given damping ratio.

    The inverse of :func:`scheme_damping`; Δt = 2 atan(2ζ)/ω in the DDA member.

    Parameters
    ----------
    damping : array_like, shape (...)
        Required damping ratio ζ > 0.
    frequency : array_like, shape (...)
        Frequency of that damping ratio, Hz, > 0.
    integration : {'dda', 'theta', 'backward_euler'}
    theta : float
        θ of ``'theta'``, above 1/2.

    Returns
    -------
    ndarray, shape (...)
        Δt, s.

    Raises
    ------
    InputError
        If an argument is not finite and positive, or the member has no damping.
    """
    scheme = Scheme.named(integration, theta)
    if scheme.theta + scheme.chi <= 1.0:
        raise InputError(
            f"integration {integration!r} with theta {scheme.theta:g} has no damping at any"
            " time step; choose a larger theta, or 'dda'"
        )
    return _solve_for_damping(damping, frequency, scheme, 1.0)[0]


def theta_for_damping(
    damping: ArrayLike, frequency: ArrayLike, time_step: float
) -> NDArray[np.float64]:
    """Return θ of ``integration = 'theta'`` for a damping ratio in steady vibration at a Δt.

    Parameters
    ----------
    damping : array_like, shape (...)
        Required damping ratio ζ >= 0.
    frequency : array_like, shape (...)
        Frequency of that damping ratio, Hz, > 0 and below the Nyquist frequency 1/(2Δt).
    time_step : float
        Δt, s.

    Returns
    -------
    ndarray, shape (...)
        θ = χ, 1/2 ... 1.

    Raises
    ------
    InputError
        If an argument is out of range, or no θ gives the required damping at this time step.
    """
    _check_frequencies(frequency, time_step)
    theta = _solve_for_damping(damping, frequency, Scheme(), float(time_step), not_negative)[1]
    if np.any(theta > 1.0):
        ratio, hz = (np.broadcast_to(a, theta.shape)[theta > 1.0][0] for a in (damping, frequency))
        smallest = float(time_step_for_damping(ratio, hz, "backward_euler"))
        raise InputError(
            f"damping {ratio:g} at {hz:g} Hz needs a time_step of at least {smallest:g} s,"
            f" got {float(time_step):g}"
        )
    return theta


def _solve_for_damping(damping, frequency, scheme: Scheme, time_step: float, check=positive):
    """Return the time steps (s), and θ at a given time step, that have given damping ratios."""
    ratio, hz = np.broadcast_arrays(check("damping", damping), positive("frequency", frequency))
    rows = api.scheme_for_damping(scheme.theta, scheme.chi, time_step, ratio.ravel(), hz.ravel())
    return [row.reshape(ratio.shape) for row in rows]


def _check_frequencies(frequency: ArrayLike, time_step: float) -> NDArray[np.float64]:
    """Return frequencies (Hz); raise an error at or above the Nyquist frequency."""
    values = not_negative("frequency", frequency)
    step = float(positive("time_step", time_step))
    too_high = values * step >= 0.5
    if np.any(too_high):
        raise InputError(
            f"frequency must be below the Nyquist frequency {0.5 / step:g} Hz of"
            f" time_step {step:g} s, got {first_of(values, too_high):g}"
        )
    return values


def finite_or_inf(values: ArrayLike) -> NDArray[np.float64]:
    """Replace huge numbers of the engine, which mean "no value", by infinity."""
    return np.where(values > _HUGE, np.inf, values)
