# SPDX-License-Identifier: GPL-3.0-or-later
"""The performance point of a capacity curve: displacement demand of a spectrum.

Let φ be the mechanism (1 at the point of the curve), Γ = Σmφ/Σmφ², d = Γ d*.  The principle of
virtual work with inertia forces and the load λ g p m, of pattern p, yields d̈* + a*(d*) = −ü_g,
a* = λ g Σpmφ/Σmφ.  (The Italian code uses λ g/e*, e* ≤ 1, which is larger if masses have different
displacements.)

- 'n2' (Fajfar 2000, Earthquake Spectra 16; EN 1998-1, annex B): an elastic–perfectly plastic
  oscillator, with the secant stiffness at 0.6 of the peak and the same energy up to 0.8 of the peak
  on the falling branch.  Demand: S_De(T*), for T* < T_C multiplied by (1 + (q − 1) T_C/T*)/q.
- 'mechanism' (Italian code, Circolare 617/2009, C8A.4.2): rocking on a falling curve.  Capacity
  d_u = 0.4 d₀, with zero resistance at d₀; demand S_De(T_s), T_s = 2π √(d_s/a_s), d_s = 0.4 d_u.
  (The Circolare of 2019 has another period.)
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ..base.errors import InputError
from .capacity import Pushover

METHODS = ("n2", "mechanism")
_ELASTIC, _LEFT = 0.6, 0.8  # fractions of the peak at the secant stiffness and at the capacity
_CAPACITY, _SECANT = 0.4, 0.4  # ratios d_u/d₀ and d_s/d_u
_BRIEF = 0.1  # largest distance of rows between which the capacity is interpolated / displacement
_FAR = 6.0  # largest ratio of d₀, which is extrapolated, to the last displacement
_LATE = 0.75  # fraction of the falling branch after which a line is fitted and extrapolated to 0
_PERIODS = np.geomspace(0.01, 10.0, 3001)  # periods in the search of T_C and in the picture, s
_LEAST = 0.1  # smallest ratio of the displacement of the point to the largest displacement
_PLATEAU = 1e-3  # relative tolerance of the largest pseudo-velocity
_ROCKING = ("T* follows from the stiffness of the contacts (normal_stiffness), because blocks "
            "topple: method = 'mechanism' describes rocking")  # fmt: skip


@dataclass(frozen=True)
class Performance:
    """The displacement demand of a spectrum and the capacity of a curve.

    Attributes
    ----------
    method : str
        'n2' or 'mechanism'.
    period : float
        Period of the equivalent oscillator, T* or T_s, s.
    demand, capacity : float
        Displacements d* of the oscillator, m.
    at_point : float
        Demand as displacement of the point of the curve, Γ d*, m.
    curve, equivalent : ndarray, shape (k, 2)
        d* (m) and a* (m/s²) of the pushover and of the equivalent oscillator.
    spectrum : ndarray, shape (periods, 2)
        Elastic S_De (m) and S_Ae (m/s²).
    doubt : str
        Reason to doubt the result; empty if there is none.
    """

    method: str
    period: float
    demand: float
    capacity: float
    at_point: float
    curve: np.ndarray = field(repr=False)
    equivalent: np.ndarray = field(repr=False)
    spectrum: np.ndarray = field(repr=False)
    doubt: str = ""

    @property
    def stands(self) -> bool:
        """Return whether the demand is within the capacity."""
        return self.demand <= self.capacity

    @property
    def margin(self) -> float:
        """Return the ratio of capacity to demand."""
        return self.capacity / self.demand if self.demand else math.inf

    def __str__(self) -> str:
        """Return the verdict, demand, capacity, margin and a doubt in a sentence."""
        doubt = f"; doubt: {self.doubt}" if self.doubt else ""
        return (
            f"{'stands' if self.stands else 'fails'} ({self.method}): demand "
            f"{1e3 * self.demand:.4g} mm, capacity {1e3 * self.capacity:.4g} mm at T = "
            f"{self.period:.4g} s, margin {self.margin:.3g}; the point moves by "
            f"{1e3 * self.at_point:.4g} mm{doubt}"
        )

    def draw(self):
        """Draw curve, spectrum and performance point over displacement; return the figure."""
        from .picture import performance_figure

        return performance_figure(self)


def performance_point(pushover: Pushover, spectrum, *, method: str = "n2") -> Performance:
    """Find the performance point of a capacity curve under a spectrum.

    Parameters
    ----------
    pushover : Pushover
    spectrum : callable or (array_like, array_like)
        Elastic acceleration S_Ae (m/s²) as a function of periods (s); or periods and values, which
        are interpolated linearly.
    method : {'n2', 'mechanism'}

    Raises
    ------
    InputError
        If the method or spectrum is invalid, or the curve does not fall as 'mechanism' requires.

    Examples
    --------
    >>> curve = sitedda.pushover("wall.nml", "top")              # doctest: +SKIP
    >>> performance_point(curve, eurocode8(2.0, "B"))            # doctest: +SKIP
    """
    if method not in METHODS:
        raise InputError(f"method = {method!r}: use one of {', '.join(METHODS)}")
    acceleration = _spectrum_function(spectrum)
    participation, displacement, resistance = _equivalent_oscillator(pushover)
    equivalent = _plastic_oscillator if method == "n2" else _rocking_oscillator
    period, capacity, line, strength = equivalent(displacement, resistance)
    demand = (period / (2 * math.pi)) ** 2 * float(acceleration(np.array([period]))[0])
    values = acceleration(_PERIODS)
    if method == "n2":
        demand = _inelastic_demand(demand, period, strength, values)
    elastic = np.column_stack([values * (_PERIODS / (2 * math.pi)) ** 2, values])
    curve = np.column_stack([displacement, resistance])
    at_point = participation * demand
    doubt = _ROCKING if method == "n2" and _is_rocking(pushover) else ""
    return Performance(method, period, demand, capacity, at_point, curve, line, elastic, doubt)


def _is_rocking(pushover: Pushover) -> bool:
    """Return whether a body topples and the curve falls below 0.8 of its peak."""
    falling = pushover.factor[int(np.argmax(pushover.factor)) :]
    return "topples" in pushover.verdicts and bool(falling.min() < _LEFT * pushover.peak)


def _spectrum_function(spectrum) -> Callable:
    """Return S_Ae (m/s²) as a function of periods (s); raise InputError if it is invalid."""
    if callable(spectrum):
        return spectrum
    try:
        periods, values = np.array(spectrum, dtype=float)
    except (TypeError, ValueError):
        periods = values = np.zeros(0)
    if len(periods) < 2 or not (np.diff(periods) > 0).all() or not (values >= 0).all():
        raise InputError("spectrum must be a function of periods, or ascending periods (s) and "
                         "accelerations (m/s²)")  # fmt: skip
    return lambda period: np.interp(period, periods, values)


def _equivalent_oscillator(pushover: Pushover) -> tuple[float, np.ndarray, np.ndarray]:
    """Return Γ, d* (m) and a* (m/s²) of a curve, at points with positive resistance."""
    peak = int(np.argmax(pushover.factor))
    begin = peak if pushover.displacement[-1] != pushover.displacement[peak] else 0
    control = pushover.displacement[-1] - pushover.displacement[begin]
    if not control > _LEAST * pushover.largest[-1]:
        raise InputError("the measured point moves by less than 0.1 of the largest displacement of "
                         "the mechanism: choose another point")  # fmt: skip
    shape = pushover.sense * pushover.mechanism[:, 0] / control
    mass, square = float(pushover.masses @ shape), float(pushover.masses @ shape**2)
    pull = pushover.pull * float((pushover.masses * pushover.pattern) @ shape) / mass
    valid = pushover.factor > 0.0
    displacements = pushover.displacement[valid] * square / mass
    return mass / square, displacements, pushover.factor[valid] * pull


def _plastic_oscillator(displacement: np.ndarray, resistance: np.ndarray):
    """Return T* (s), capacity (m), corners and strength (m/s²) of the method 'n2'."""
    peak = int(np.argmax(resistance))
    rising = slice(0, peak + 1)
    secant = float(np.interp(_ELASTIC * resistance[peak], np.maximum.accumulate(resistance[rising]),
                             displacement[rising]))  # fmt: skip
    stiffness = _ELASTIC * resistance[peak] / max(secant, 1e-12 * displacement[-1])
    displacement, resistance = _until_capacity(displacement, resistance)
    capacity = float(displacement[-1])
    if not capacity > 0.0:
        raise InputError("the curve falls below 0.8 of its peak in its first step: increase the "
                         "number of steps")  # fmt: skip
    energy = float(np.trapezoid(np.append(0.0, resistance), np.append(0.0, displacement)))
    root = max(0.0, capacity**2 - 2 * energy / stiffness)
    yielding = capacity - math.sqrt(root)
    strength = stiffness * yielding
    line = np.array([(0.0, 0.0), (yielding, strength), (capacity, strength)])
    return 2 * math.pi / math.sqrt(stiffness), capacity, line, strength


def _until_capacity(displacement: np.ndarray, resistance: np.ndarray):
    """Return the curve up to 0.8 of its peak on the falling branch, or to its end.

    This point is interpolated between neighbouring rows; the curve ends before rows far apart.
    """
    peak = int(np.argmax(resistance))
    left = _LEFT * resistance[peak]
    weak = np.flatnonzero(resistance[peak:] < left)
    if not len(weak):
        return displacement, resistance
    end = peak + int(weak[0])
    (before, after), (strong, low) = displacement[end - 1 : end + 1], resistance[end - 1 : end + 1]
    displacement, resistance = displacement[:end], resistance[:end]
    if after - before > _BRIEF * after:
        return displacement, resistance
    capacity = before + (after - before) * (strong - left) / (strong - low)
    return np.append(displacement, capacity), np.append(resistance, left)


def _rocking_oscillator(displacement: np.ndarray, resistance: np.ndarray):
    """Return T_s (s), capacity (m), corners and strength (m/s²) of the method 'mechanism'."""
    peak = int(np.argmax(resistance))
    displacements, resistances = displacement[peak:], resistance[peak:]
    if len(resistances) < 3 or not resistances[-1] < _LEFT * resistances[0]:
        raise InputError("method = 'mechanism' requires a curve that falls below 0.8 of its peak: "
                         "increase the displacement, or use 'n2'")  # fmt: skip
    is_tail = displacements >= displacements[0] + _LATE * (displacements[-1] - displacements[0])
    slope, height = np.polyfit(displacements[is_tail], resistances[is_tail], 1)
    end = -height / slope if slope < 0.0 else math.inf
    if not end <= _FAR * displacements[-1]:
        raise InputError("method = 'mechanism' requires a curve that falls towards zero "
                         "resistance: increase the displacement, or use 'n2'")  # fmt: skip
    capacity = _CAPACITY * end
    secant = _SECANT * capacity
    strength = float(np.interp(secant, displacements, resistances))
    line = np.array([(0.0, 0.0), (secant, strength), (end, 0.0)])
    return 2 * math.pi * math.sqrt(secant / strength), capacity, line, strength


def _inelastic_demand(elastic: float, period: float, strength: float, values: np.ndarray) -> float:
    """Return the displacement demand of the plastic oscillator, m; `elastic` is S_De, m."""
    velocity = values * _PERIODS
    corner = float(_PERIODS[np.argmax(velocity >= (1 - _PLATEAU) * velocity.max())])
    reduction = elastic * (2 * math.pi / period) ** 2 / strength
    if reduction <= 1.0 or period >= corner:
        return elastic
    return elastic / reduction * (1 + (reduction - 1) * corner / period)
