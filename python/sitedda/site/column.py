# SPDX-License-Identifier: GPL-3.0-or-later
"""The one-dimensional column of a layered model: exact transfer functions.

The Thomson-Haskell recursion of SHAKE (`layers`) is the exact solution for horizontal layers on a
rigid base or an elastic half-space under vertically propagating SH waves.

The response of the same column *under the engine's time integration* also has a closed form:
:meth:`Column.scheme_transfer`.
"""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.arguments import first_of, not_negative
from ..base.errors import InputError
from ..engine.scheme import Scheme
from ..engine.spectra import Peak
from .layers import (
    CONVENTIONS,
    DEFAULT_CONVENTION,
    HalfSpace,
    Layer,
    Waves,
    complex_modulus,
    damped_amplification,
    one_of,
    recursion,
    undamped_amplification,
)
from .motion import Motion
from .response import KINDS, ColumnResponse

__all__ = ["Column", "HalfSpace", "Layer", "complex_modulus", "damped_amplification",
           "refined_peak", "undamped_amplification"]  # fmt: skip

_WRAPPED = 1e-2  # largest remaining fraction of the free vibration at the end of the zeros
_UNBOUNDED = 1e7  # a higher peak is the resonance of an undamped column
_POINTS_PER_MODE = 64  # samples between two resonances in the search of peaks
_MOST_POINTS = 1_000_000


@dataclass(frozen=True)
class Column:
    """Horizontal layers on a base, excited from below by vertically propagating SH waves.

    Parameters
    ----------
    layers : sequence of Layer, length n >= 1
        From the surface downwards.
    base : 'rigid' or HalfSpace
        Base of the lowest layer.
    convention : str
        Meaning of the damping ratio, see :func:`complex_modulus`; by default ``dormieux``, which
        keeps the modulus as it is given, for ratios up to ½.
    waves : {'S', 'P'}
        P: the moduli are constrained ones, to which curves of shear do not apply.

    Raises
    ------
    InputError
        If there is no layer, or an item, the base or the convention is of another kind.

    Examples
    --------
    >>> soil = Layer(15.0, density=2643.0, shear_modulus=1.9152e9, damping=0.022)
    >>> peak = Column([soil]).peak()
    >>> print(f"{peak.amplitude:.2f} at {peak.frequency:.3f} Hz")
    28.92 at 14.184 Hz
    """

    layers: Sequence[Layer]
    base: HalfSpace | str = "rigid"
    convention: str = DEFAULT_CONVENTION
    waves: str = "S"

    def __post_init__(self) -> None:
        layers = tuple(self.layers)
        if not layers:
            raise InputError("layers must contain at least one Layer, got none")
        for number, layer in enumerate(layers, start=1):
            if not isinstance(layer, Layer):
                raise InputError(f"layers must be Layer objects, got {layer!r} as item {number}")
        is_half_space = isinstance(self.base, HalfSpace) and not isinstance(self.base, Layer)
        if not is_half_space and self.base != "rigid":
            raise InputError(f"base must be 'rigid' or a HalfSpace, got {self.base!r}")
        one_of("convention", self.convention, CONVENTIONS)
        one_of("waves", self.waves, ("S", "P"))
        object.__setattr__(self, "layers", layers)

    @property
    def depth(self) -> float:
        """Return the depth of the base below the surface, m."""
        return float(self._interfaces[-1])

    def check_curves(self, curves: Sequence) -> None:
        """Reject curves that are not one per layer, and any curves of a column of P waves."""
        if len(curves) != len(self.layers):
            raise InputError(f"curves: give {len(self.layers)}, one per layer, not {len(curves)}")
        if self.waves == "P" and any(curve is not None for curve in curves):
            raise InputError("curves: those of shear do not apply to a column of P waves; "
                             "give None for each layer")  # fmt: skip

    @property
    def travel_time(self) -> float:
        """Time of a shear wave from the base to the surface, s."""
        return sum(layer.thickness / layer.shear_velocity for layer in self.layers)

    def decay_time(self, kind: str) -> float:
        """Return the time in which free vibration decays to 1/1000, s.

        The damping ratio is that of the layers, weighted by their strain energy: the stress of the
        first mode over the travel time is taken as that of a uniform column. In an outcrop motion
        each reflection at a half-space takes a fraction; a within motion fixes the base.
        """
        times = [layer.thickness / layer.shear_velocity for layer in self.layers[::-1]]
        relative_time = np.cumsum([0.0, *times]) / self.travel_time  # from the base
        energy = np.diff(relative_time + np.sin(np.pi * relative_time) / np.pi)[::-1]
        energy /= [layer.density * layer.shear_velocity for layer in self.layers]
        damping = [layer.damping_at([1.0])[0] for layer in self.layers]
        rate = np.pi * np.average(damping, weights=energy)
        if kind == "outcrop" and isinstance(self.base, HalfSpace):
            mass = sum(layer.density * layer.thickness for layer in self.layers)
            impedance_time = self.base.density * self.base.shear_velocity * self.travel_time
            rate -= np.log(max(abs(impedance_time - mass) / (impedance_time + mass), 1e-9))
        return float(2 * self.travel_time * np.log(1e3) / max(rate, 1e-9))

    @property
    def _interfaces(self) -> NDArray[np.float64]:
        """Depth of the surface and of the bottom of each layer, m, shape (n + 1,)."""
        return np.cumsum([0.0, *(layer.thickness for layer in self.layers)])

    @property
    def middles(self) -> NDArray[np.float64]:
        """Return the depths of the middles of the layers, m, shape (n,)."""
        return (self._interfaces[:-1] + self._interfaces[1:]) / 2

    def transfer(
        self,
        frequencies: ArrayLike,
        top: float = 0.0,
        bottom: float | None = None,
        kind: str = "within",
    ) -> NDArray[np.complex128]:
        """Return the motion at depth ``top`` divided by the motion at depth ``bottom``.

        The ratio is the same for displacement, velocity and acceleration.

        Parameters
        ----------
        frequencies : array_like, shape (n,) or ()
            Hz, >= 0.
        top : float
            Depth of the response, m; 0 is the surface.
        bottom : float, optional
            Depth of the reference motion, m, not above ``top``; by default the base.
        kind : {'within', 'outcrop'}
            The reference motion: as it is inside the column, or as it would be were the medium at
            that depth a free surface (twice the upgoing wave; at an interface, of the medium
            below).  On a rigid base, ``bottom`` at the base, the two are the same.  The default is
            that of points of a model; :meth:`response` takes records, which are of outcrops.

        Returns
        -------
        ndarray of complex128, shape of ``frequencies``
            Transfer function, dimensionless.

        Raises
        ------
        ValueError
            If an argument is out of range, or the ratio is infinite (an undamped resonance).
        """
        values = not_negative("frequencies", frequencies)
        waves = Waves.damped(values.ravel(), self.convention)
        return self._response_ratio(waves, (top, bottom, kind)).reshape(values.shape)

    def scheme_transfer(
        self,
        frequencies: ArrayLike,
        time_step: float,
        top: float = 0.0,
        bottom: float | None = None,
        kind: str = "within",
        integration: str | Scheme = "dda",
        theta: float = 0.75,
    ) -> NDArray[np.complex128]:
        """Return the transfer function of the column under the engine's time integration.

        It is exact in time, for a base with a prescribed displacement, and in space.  The engine
        converges to it with thin bonded layers and stiff contacts.  With τ = tan(ωΔt/2) the
        modulus is G (1 + i(2θ − 1)τ)(1 + i(2χ − 1)τ) at the angular frequency 2τ/Δt; this causes
        the damping :func:`sitedda.scheme_damping`.  Layers add their damping if it is that of a
        material of the engine (:mod:`sitedda.damping`); plain numbers are ignored.

        Parameters
        ----------
        frequencies : array_like, shape (n,) or ()
            Hz, >= 0 and below the Nyquist frequency 1/(2Δt).
        time_step : float
            Δt, s.
        top, bottom, kind
            As for :meth:`transfer`.
        integration : {'dda', 'midpoint', 'theta', 'backward_euler'} or Scheme
            As in ``&control``.
        theta : float
            θ of ``'theta'``.

        The result is that of :meth:`transfer`; a resonance of the midpoint rule is infinite without
        damping of the layers.
        """
        values = not_negative("frequencies", frequencies)
        waves = Waves.stepped(values.ravel(), time_step, Scheme.named(integration, theta))
        return self._response_ratio(waves, (top, bottom, kind)).reshape(values.shape)

    def peak(
        self,
        band: tuple[float, float] | None = None,
        top: float = 0.0,
        bottom: float | None = None,
        kind: str = "within",
        time_step: float | None = None,
        integration: str | Scheme = "dda",
        theta: float = 0.75,
    ) -> Peak:
        """Return the highest resonance peak of the transfer function inside a band.

        Parameters
        ----------
        band : (float, float), optional
            Hz.  By default from 0 to 1/(2 × travel time), twice the first resonance of a uniform
            column on a rigid base.
        top, bottom, kind
            As for :meth:`transfer`.
        time_step : float, optional
            Δt, s; if given, the peak of :meth:`scheme_transfer`, else of :meth:`transfer`.
        integration, theta
            As for :meth:`scheme_transfer`.

        Returns
        -------
        Peak
            Frequency, Hz, and amplification.

        Raises
        ------
        ValueError
            If an argument is out of range, the band contains no peak, or the peak is unbounded.
        """
        mode_spacing = 0.5 / self.travel_time
        low, high = _checked_band((0.0, mode_spacing) if band is None else band)
        points = int(np.ceil(_POINTS_PER_MODE * max(1.0, (high - low) / mode_spacing)))
        reference = (top, bottom, kind)

        def transfer(frequencies):
            if time_step is None:
                return self.transfer(frequencies, *reference)
            return self.scheme_transfer(frequencies, time_step, *reference, integration, theta)

        return refined_peak(transfer, (low, high), points)

    def _response_ratio(
        self, waves: Waves, reference: tuple[float, float | None, str]
    ) -> NDArray[np.complex128]:
        """Return the response at a depth over the reference motion at another depth."""
        top, bottom, kind = reference
        one_of("kind", kind, KINDS)
        upper, lower = self._check_depths(top, bottom)
        _, _, (index,), upgoing, reflections = self.wave_field(waves, [upper], lower, kind)
        ratio = upgoing[index] * (1 + reflections[index])
        unbounded = ~np.isfinite(ratio)
        if np.any(unbounded):
            raise InputError(
                "frequencies include a resonance of the undamped column, with an infinite ratio, at"
                f" {first_of(abs(waves.omega), unbounded) / (2 * np.pi):g} Hz"
            )
        return ratio

    def _check_depths(self, top: float, bottom: float | None) -> tuple[float, float]:
        """Check both depths; move them onto an interface if they equal it within rounding."""
        interfaces = self._interfaces
        upper = _move_to_interface("top", top, interfaces)
        bottom = interfaces[-1] if bottom is None else bottom
        lower = _move_to_interface("bottom", bottom, interfaces)
        if upper > lower:
            raise InputError(f"top must not lie below bottom, got {upper:g} m and {lower:g} m")
        return upper, lower

    def cut_at(self, depths: ArrayLike) -> tuple[list[HalfSpace | None], NDArray[np.float64]]:
        """Cut the layers so that depths (m) are interfaces; reject depths outside the column.

        Returns
        -------
        media : list of HalfSpace, length m
            Those below each interface; the last is the base, ``None`` if rigid.
        interfaces : ndarray, shape (m,)
            Depths, m, from the surface to the base.
        """
        interfaces = self._interfaces
        depths = [_move_to_interface("depth", depth, interfaces) for depth in depths]
        cuts = np.union1d(interfaces, depths)
        owners = np.searchsorted(interfaces, (cuts[:-1] + cuts[1:]) / 2) - 1
        base = self.base if isinstance(self.base, HalfSpace) else None
        return [*(self.layers[owner] for owner in owners), base], cuts

    def wave_field(self, waves: Waves, depths: ArrayLike, bottom: float, kind: str):
        """Compute the waves at depths (m) for a unit reference motion at the depth ``bottom``.

        Returns
        -------
        media, interfaces
            See :meth:`cut_at`.
        at : ndarray of int
            Number of the interface at each depth.
        upgoing, reflections : ndarray of complex128, shape (interfaces, n)
            Upgoing wave at the top of each medium, and downgoing over upgoing wave.
        """
        depths = [*np.asarray(depths, dtype=float), bottom]
        media, interfaces = self.cut_at(depths)
        *indices, last = (int(np.argmin(np.abs(interfaces - depth))) for depth in depths)
        steps, reflections = recursion(waves, media, np.diff(interfaces))
        upgoing = np.ones_like(reflections)
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
            for j in range(last - 1, -1, -1):
                upgoing[j] = upgoing[j + 1] * steps[j]
            for j in range(last, len(steps)):
                upgoing[j + 1] = upgoing[j] / steps[j]
            upgoing /= 2.0 if kind == "outcrop" else 1 + reflections[last]
        return media, interfaces, indices, upgoing, reflections

    def response(
        self,
        motion,
        time_step: float | None = None,
        *,
        bottom: float | None = None,
        kind: str = "outcrop",
        scheme: Scheme | None = None,
        scheme_step: float | None = None,
    ) -> ColumnResponse:
        """Compute the response to a motion: histories at any depth, profiles, spectra.

        Parameters
        ----------
        motion : xarray.Dataset or array_like, shape (samples,)
            Result of :func:`sitedda.read_record`, ground acceleration (m/s²), or a Motion.
        time_step : float, optional
            Time between samples of an array, s.
        bottom : float, optional
            Depth of the motion, m; by default the base.
        kind : {'outcrop', 'within'}
            Kind of motion, as in :meth:`transfer`; records are of outcrops, hence the default.
        scheme : Scheme, optional
            Time integration whose damping replaces that of the layers.
        scheme_step : float, optional
            Δt of the time integration, s; by default the time between samples.
        """
        one_of("kind", kind, KINDS)
        depth = self.depth if bottom is None else float(bottom)
        self.cut_at([depth])
        ground = Motion.of(motion, time_step)
        if scheme is None:
            decay = self.decay_time(kind)
            ground = ground.padded(decay)
            if 1e3 ** -(ground.zeros / decay) > _WRAPPED:
                warnings.warn(f"more than {100 * _WRAPPED:g} % of the free vibration remains when "
                              "the record repeats, and contaminates the result: increase the "
                              "damping of the layers, or use a half-space with an outcrop motion",
                              stacklevel=2)  # fmt: skip
        return ColumnResponse(self, ground, depth, kind, scheme, scheme_step)


def refined_peak(
    transfer: Callable[[NDArray[np.float64]], ArrayLike],
    band: tuple[float, float],
    points: int = 1000,
) -> Peak:
    """Find the highest interior maximum of |transfer| in a band (Hz), refined beyond the grid.

    Each local maximum of ``points`` samples brackets a peak; there should be some ten or more
    between two peaks.  In the bracket, 1/|transfer|², which is smooth even at a sharp resonance, is
    minimised (Brent, scipy).  ``transfer`` is a function of an array of frequencies, Hz.
    """
    low, high = _checked_band(band)
    if not 2 <= points <= _MOST_POINTS:
        raise InputError(f"points must be in 2 ... {_MOST_POINTS}, got {points}")
    grid = np.linspace(low, high, points + 1)
    size = np.abs(np.asarray(transfer(grid)))
    if not np.all(np.isfinite(size)):
        raise InputError(f"transfer is not finite at {first_of(grid, ~np.isfinite(size)):g} Hz")
    summits = 1 + np.flatnonzero((size[1:-1] >= size[:-2]) & (size[1:-1] > size[2:]))
    if summits.size == 0:
        raise InputError(f"band {low:g} ... {high:g} Hz contains no peak of the transfer function")
    peaks = (_refine_peak(transfer, grid[i - 1], grid[i + 1]) for i in summits)
    return max(peaks, key=lambda peak: peak.amplitude)


def _refine_peak(transfer: Callable, low: float, high: float) -> Peak:
    from scipy.optimize import minimize_scalar

    def inverse_square(frequency: float) -> float:
        return 1 / abs(np.asarray(transfer(np.array([frequency])))[0]) ** 2

    options = {"bounds": (low, high), "method": "bounded", "options": {"xatol": 1e-12 * high}}
    minimum = minimize_scalar(inverse_square, **options)
    amplitude = 1 / np.sqrt(minimum.fun)
    if amplitude > _UNBOUNDED:
        raise InputError(f"the peak near {minimum.x:g} Hz is unbounded: the column has no damping")
    return Peak(float(minimum.x), float(amplitude))


def _checked_band(band: tuple[float, float]) -> tuple[float, float]:
    edges = np.asarray(band, dtype=float)
    if edges.shape != (2,) or not np.all(np.isfinite(edges)) or not 0 <= edges[0] < edges[1]:
        raise InputError(f"band must be two frequencies 0 <= low < high, got {band!r}")
    return float(edges[0]), float(edges[1])


def _move_to_interface(name: str, depth: float, interfaces: NDArray[np.float64]) -> float:
    bottom = interfaces[-1]
    tolerance = 1e-9 * bottom
    value = float(depth)
    if not -tolerance <= value <= bottom + tolerance:
        raise InputError(f"{name} must be a depth in 0 ... {bottom:g} m, got {value:g}")
    nearest = interfaces[np.argmin(np.abs(interfaces - value))]
    return float(nearest) if abs(nearest - value) <= tolerance else value
