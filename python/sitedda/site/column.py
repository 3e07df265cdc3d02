# SPDX-License-Identifier: GPL-3.0-or-later
"""The one-dimensional twin of a layered model: exact transfer functions of a soil column.

Horizontal layers on a rigid base or on an elastic half-space, shaken by vertically propagating SH
waves, are solved exactly by the Thomson-Haskell recursion that SHAKE uses.  Time dependence is
exp(iωt) and depth grows downwards from the free surface, so layer *j* holds the displacement
``A exp(ikz) + B exp(-ikz)``, with the upgoing wave first.

The same column *as the engine's time integration sees it* has a closed form as well:
:meth:`Column.scheme_transfer`.

References
----------
.. [1] Schnabel, P. B., Lysmer, J. & Seed, H. B. (1972). SHAKE: a computer program for earthquake
   response analysis of horizontally layered sites. EERC 72-12, University of California, Berkeley.
.. [2] Idriss, I. M. & Sun, J. I. (1992). User's manual for SHAKE91. University of California at
   Davis.
.. [3] Kramer, S. L. (1996). Geotechnical Earthquake Engineering. Prentice Hall.
.. [4] Dormieux, L. & Canou, J. (1990), as documented by pyStrata (``pystrata/site.py``,
   ``Layer.comp_shear_mod``, https://github.com/arkottke/pystrata).
.. [5] The paper this project reproduces: "Site response analysis with two-dimensional numerical
   discontinuous deformation analysis method" (2013), equations 9 and 10.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import KW_ONLY, dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.arguments import first_of, not_negative, positive
from ..engine.damping import MaterialDamping
from ..engine.scheme import Scheme
from ..engine.spectra import Peak

__all__ = [
    "Column",
    "HalfSpace",
    "Layer",
    "complex_modulus",
    "damped_amplification",
    "refined_peak",
    "undamped_amplification",
]

Damping = float | Callable[[NDArray[np.float64]], ArrayLike] | MaterialDamping

_UNBOUNDED = 1e7  # a peak above this is the resonance of an undamped column
_POINTS_PER_MODE = 64  # samples between two resonances when peaks are searched
_MOST_POINTS = 1_000_000


# ---------------------------------------------------------------------------------------------
# Complex modulus
# ---------------------------------------------------------------------------------------------

# name: (factor G*/G of the damping ratio D, largest D for which it is defined, modulus of G*)
_CONVENTIONS = {
    "shake": (lambda d: 1 + 2j * d, np.inf, "G √(1 + 4D²)"),
    "shake91": (lambda d: 1 - 2 * d**2 + 2j * d * np.sqrt(1 - d**2), 1.0, "G"),
    "kramer": (lambda d: 1 - d**2 + 2j * d, 1.0, "G (1 + D²)"),
    "dormieux": (lambda d: np.sqrt(1 - 4 * d**2) + 2j * d, 0.5, "G"),
}
DEFAULT_CONVENTION = "dormieux"  # as pystrata: the modulus is G, and the loss πD of ½ |G*| γ²


def largest_damping(convention: str) -> float:
    """Largest damping ratio for which a convention of :func:`complex_modulus` is defined."""
    return _CONVENTIONS[_one_of("convention", convention, _CONVENTIONS)][1]


def convention_words(convention: str) -> str:
    """What a convention of :func:`complex_modulus` makes of modulus and damping ratio, in words."""
    _, largest, modulus = _CONVENTIONS[_one_of("convention", convention, _CONVENTIONS)]
    limit = "" if np.isinf(largest) else f", D up to {largest:g}"
    return f"complex modulus '{convention}', |G*| = {modulus}{limit}"


def complex_modulus(
    shear_modulus: ArrayLike, damping: ArrayLike, convention: str = DEFAULT_CONVENTION
) -> NDArray[np.complex128]:
    """Complex shear modulus G* of a linear hysteretic material.

    ============  ==================================  ==============  =======
    convention    G*                                  modulus abs G*  source
    ============  ==================================  ==============  =======
    ``shake``     G (1 + 2iD)                         G √(1 + 4D²)    [1]_
    ``shake91``   G (1 - 2D² + 2iD √(1 - D²))         G               [2]_
    ``kramer``    G (1 - D² + 2iD)                    G (1 + D²)      [3]_
    ``dormieux``  G (√(1 - 4D²) + 2iD)                G               [4]_
    ============  ==================================  ==============  =======

    The imaginary part is 2DG in all but ``shake91``; ``dormieux`` has no G* for D > ½, ``shake91``
    and ``kramer`` none for D > 1.

    Parameters
    ----------
    shear_modulus : array_like, shape (...)
        G, Pa.
    damping : array_like, shape (...)
        Damping ratio D >= 0, a fraction (0.05 is 5 %).
    convention : str
        One of the names above.

    Returns
    -------
    ndarray of complex128, shape of ``shear_modulus`` and ``damping`` broadcast
        G*, Pa.

    Raises
    ------
    ValueError
        If the convention is unknown or the damping ratio lies outside its range.
    """
    factor, largest, _ = _CONVENTIONS[_one_of("convention", convention, _CONVENTIONS)]
    ratio = np.asarray(damping, dtype=float)
    inside = (ratio >= 0) & (ratio <= largest) & np.isfinite(ratio)
    if not np.all(inside):
        raise ValueError(
            f"damping must be in 0 ... {largest:g} for convention '{convention}',"
            f" got {first_of(ratio, ~inside):g}{_wider(convention, ratio[~inside])}"
        )
    return np.asarray(shear_modulus, dtype=float) * factor(ratio).astype(complex)


def _wider(convention: str, damping: NDArray[np.float64]) -> str:
    """Conventions that are defined for damping ratios that this one is not, for its message."""
    most = np.max(damping)
    others = [
        f"'{name}'"
        for name, (_, largest, _) in _CONVENTIONS.items()
        if name != convention and np.min(damping) >= 0 and most <= largest and np.isfinite(most)
    ]
    return f"; for such a ratio: {', '.join(others)}" if others else ""


# ---------------------------------------------------------------------------------------------
# Closed forms of the uniform layer
# ---------------------------------------------------------------------------------------------


def undamped_amplification(
    frequency: ArrayLike, thickness: float, shear_velocity: float
) -> NDArray[np.float64]:
    """Surface amplification of a uniform undamped layer on a rigid base: paper eq. 9.

    ``1 / |cos(ωH/v)|``; at a resonance it is as large as rounding lets it be.

    Parameters
    ----------
    frequency : array_like, shape (...)
        Frequencies, Hz.
    thickness : float
        H, m.
    shear_velocity : float
        v, m/s.

    Returns
    -------
    ndarray, shape (...)
        Amplification, dimensionless.

    Raises
    ------
    ValueError
        If an argument is not finite or out of range.
    """
    return 1 / np.abs(np.cos(_phase(frequency, thickness, shear_velocity)))


def damped_amplification(
    frequency: ArrayLike, thickness: float, shear_velocity: float, damping: ArrayLike
) -> NDArray[np.float64]:
    """Surface amplification of a uniform damped layer on a rigid base: paper eq. 10.

    ``1 / √(cos²(ωH/v) + (ζωH/v)²)``: the exact ``1 / |cos(k*H)|`` but for a relative error of the
    order of ζ² (1 + (ωH/v)²).

    Parameters
    ----------
    frequency : array_like, shape (...)
        Frequencies, Hz.
    thickness : float
        H, m.
    shear_velocity : float
        v, m/s.
    damping : array_like, shape (...)
        Damping ratio ζ >= 0.

    Returns
    -------
    ndarray, shape (...)
        Amplification, dimensionless.

    Raises
    ------
    ValueError
        If an argument is not finite or out of range.
    """
    phase = _phase(frequency, thickness, shear_velocity)
    ratio = not_negative("damping", damping)
    return 1 / np.hypot(np.cos(phase), ratio * phase)


def _phase(frequency: ArrayLike, thickness: float, shear_velocity: float) -> NDArray[np.float64]:
    height = positive("thickness", thickness)
    velocity = positive("shear_velocity", shear_velocity)
    return 2 * np.pi * not_negative("frequency", frequency) * height / velocity


# ---------------------------------------------------------------------------------------------
# Layers and columns
# ---------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class HalfSpace:
    """A homogeneous damped elastic medium; on its own, the half-space below a column.

    Parameters
    ----------
    density : float
        ρ, kg/m³.
    shear_modulus : float
        G, Pa.  Give this or ``shear_velocity``; the other follows.  Both are accepted when they
        agree, so that :func:`dataclasses.replace` works.
    shear_velocity : float
        v = √(G/ρ), m/s.
    damping : float, callable or MaterialDamping
        Damping ratio, a fraction, or a function of the frequencies (Hz, shape (n,)) that returns
        one ratio per frequency, or the damping that a material of the engine has:
        :class:`sitedda.damping.ConstantRatio`, :class:`sitedda.damping.Rayleigh`.

    Raises
    ------
    ValueError
        If a value is not finite and positive, or modulus and velocity are missing or disagree.
    """

    _: KW_ONLY
    density: float
    shear_modulus: float | None = None
    shear_velocity: float | None = None
    damping: Damping = 0.0

    def __post_init__(self) -> None:
        density = float(positive("density", self.density))
        modulus, velocity = _modulus_and_velocity(density, self.shear_modulus, self.shear_velocity)
        object.__setattr__(self, "density", density)
        object.__setattr__(self, "shear_modulus", modulus)
        object.__setattr__(self, "shear_velocity", velocity)
        if not (callable(self.damping) or isinstance(self.damping, MaterialDamping)):
            object.__setattr__(self, "damping", float(not_negative("damping", self.damping)))

    def damping_at(self, frequencies: ArrayLike) -> NDArray[np.float64]:
        """Damping ratio at each frequency.

        Parameters
        ----------
        frequencies : array_like, shape (n,)
            Hz.

        Returns
        -------
        ndarray, shape (n,)
            Damping ratio.

        Raises
        ------
        ValueError
            If a damping function returns another shape, or a negative or non-finite ratio.
        """
        values = np.asarray(frequencies, dtype=float)
        if isinstance(self.damping, MaterialDamping):
            return self.damping.ratio_at(values)
        if not callable(self.damping):
            return np.full(values.shape, self.damping)
        ratio = not_negative("damping", self.damping(values))
        if ratio.shape not in ((), values.shape):
            raise ValueError(
                f"damping must return one ratio per frequency, shape {values.shape},"
                f" got shape {ratio.shape}"
            )
        return np.broadcast_to(ratio, values.shape)


@dataclass(frozen=True)
class Layer(HalfSpace):
    """One horizontal layer: a :class:`HalfSpace` cut to a thickness.

    ``Layer(1.0, density=2643.0, shear_velocity=851.0, damping=0.022)``

    Parameters
    ----------
    thickness : float
        H, m; the only positional argument.
    density, shear_modulus, shear_velocity, damping
        As for :class:`HalfSpace`.

    Raises
    ------
    ValueError
        As for :class:`HalfSpace`, or if the thickness is not finite and positive.
    """

    thickness: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "thickness", float(positive("thickness", self.thickness)))
        super().__post_init__()


@dataclass(frozen=True)
class Column:
    """Horizontal layers on a base, shaken from below by SH waves that travel vertically.

    Parameters
    ----------
    layers : sequence of Layer, length n >= 1
        From the surface downwards.
    base : 'rigid' or HalfSpace
        What the lowest layer rests on.
    convention : str
        Meaning of the damping ratio, see :func:`complex_modulus`; by default ``dormieux``, which
        keeps the modulus as it is given, for ratios up to ½.

    Raises
    ------
    ValueError
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

    def __post_init__(self) -> None:
        layers = tuple(self.layers)
        if not layers:
            raise ValueError("layers must hold at least one Layer, got none")
        for number, layer in enumerate(layers, start=1):
            if not isinstance(layer, Layer):
                raise ValueError(f"layers must hold Layer objects, got {layer!r} as item {number}")
        if isinstance(self.base, Layer) or not (
            isinstance(self.base, HalfSpace) or self.base == "rigid"
        ):
            raise ValueError(f"base must be 'rigid' or a HalfSpace, got {self.base!r}")
        _one_of("convention", self.convention, _CONVENTIONS)
        object.__setattr__(self, "layers", layers)

    @property
    def depth(self) -> float:
        """Depth of the base below the surface, m."""
        return float(self._interfaces[-1])

    @property
    def travel_time(self) -> float:
        """Time of a shear wave from the base to the surface, s."""
        return sum(layer.thickness / layer.shear_velocity for layer in self.layers)

    @property
    def _interfaces(self) -> NDArray[np.float64]:
        """Depth of the surface and of the bottom of each layer, m, shape (n + 1,)."""
        return np.cumsum([0.0, *(layer.thickness for layer in self.layers)])

    def transfer(
        self,
        frequencies: ArrayLike,
        top: float = 0.0,
        bottom: float | None = None,
        motion: str = "within",
    ) -> NDArray[np.complex128]:
        """Motion at depth ``top`` divided by the motion at depth ``bottom``.

        The ratio is the same for displacement, velocity and acceleration.

        Parameters
        ----------
        frequencies : array_like, shape (n,) or ()
            Hz, >= 0.
        top : float
            Depth of the response, m; 0 is the surface.
        bottom : float, optional
            Depth of the reference motion, m, not above ``top``; by default the base.
        motion : {'within', 'outcrop'}
            The reference motion: as it is inside the column, or as it would be were the medium at
            that depth a free surface (twice the upgoing wave; at an interface, of the medium
            below).  On a rigid base, ``bottom`` at the base, the two are the same.

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
        return self._ratio(waves, (top, bottom, motion)).reshape(values.shape)

    def scheme_transfer(
        self,
        frequencies: ArrayLike,
        time_step: float,
        top: float = 0.0,
        bottom: float | None = None,
        motion: str = "within",
        integration: str = "dda",
        theta: float = 0.75,
    ) -> NDArray[np.complex128]:
        """Transfer function of the same column under the engine's time integration.

        Exact in time for a base that moves by a prescribed displacement, exact in space: what the
        engine tends to with thin bonded layers and stiff contacts.  With τ = tan(ωΔt/2) the
        modulus is G (1 + i(2θ − 1)τ)(1 + i(2χ − 1)τ) at the angular frequency 2τ/Δt.  Besides that
        damping, :func:`sitedda.scheme_damping`, layers have theirs where it is one that materials
        of the engine can have, of :mod:`sitedda.damping`; plain ratios are not used.

        Parameters
        ----------
        frequencies : array_like, shape (n,) or ()
            Hz, >= 0 and below the Nyquist frequency 1/(2Δt).
        time_step : float
            Δt, s.
        top, bottom, motion
            As for :meth:`transfer`.
        integration : {'dda', 'midpoint', 'theta', 'backward_euler'} or Scheme
            As in ``&control``.
        theta : float
            θ of ``'theta'``.

        Returns
        -------
        ndarray of complex128, shape of ``frequencies``
            Transfer function, dimensionless.

        Raises
        ------
        ValueError
            If an argument is out of range, or the ratio is infinite (a resonance of the midpoint
            rule, which has no damping).
        """
        values = not_negative("frequencies", frequencies)
        waves = Waves.stepped(values.ravel(), time_step, Scheme.named(integration, theta))
        return self._ratio(waves, (top, bottom, motion)).reshape(values.shape)

    def peak(
        self,
        band: tuple[float, float] | None = None,
        top: float = 0.0,
        bottom: float | None = None,
        motion: str = "within",
        time_step: float | None = None,
        integration: str = "dda",
        theta: float = 0.75,
    ) -> Peak:
        """The highest resonance peak of the transfer function inside a band.

        Parameters
        ----------
        band : (float, float), optional
            Hz.  By default from 0 to 1/(2 × travel time), twice the first resonance of a uniform
            column on a rigid base.
        top, bottom, motion
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
            If an argument is out of range, the band holds no peak, or the peak is unbounded.
        """
        mode_spacing = 0.5 / self.travel_time
        low, high = _band((0.0, mode_spacing) if band is None else band)
        points = int(np.ceil(_POINTS_PER_MODE * max(1.0, (high - low) / mode_spacing)))
        place = (top, bottom, motion)
        if time_step is None:
            return refined_peak(lambda f: self.transfer(f, *place), (low, high), points)
        scheme = (integration, theta)
        return refined_peak(
            lambda f: self.scheme_transfer(f, time_step, *place, *scheme), (low, high), points
        )

    def _ratio(
        self, waves: Waves, place: tuple[float, float | None, str]
    ) -> NDArray[np.complex128]:
        """Response at one depth over reference motion at another, shape of ``waves.omega``."""
        top, bottom, motion = place
        _one_of("motion", motion, ("within", "outcrop"))
        upper, lower = self._depths(top, bottom)
        media, depths = self.cut_at([upper, lower])
        first, last = np.searchsorted(depths, [upper, lower])
        steps, reflections = recursion(waves, media, np.diff(depths))
        reference = 2.0 if motion == "outcrop" else 1 + reflections[last]
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.prod(steps[first:last], axis=0) * (1 + reflections[first]) / reference
        unbounded = ~np.isfinite(ratio)
        if np.any(unbounded):
            raise ValueError(
                "frequencies meet a resonance of the undamped column, where the ratio is infinite,"
                f" at {first_of(abs(waves.omega), unbounded) / (2 * np.pi):g} Hz"
            )
        return ratio

    def _depths(self, top: float, bottom: float | None) -> tuple[float, float]:
        """Both depths, checked and moved onto an interface that they meet but for rounding."""
        interfaces = self._interfaces
        upper = _snapped("top", top, interfaces)
        lower = interfaces[-1] if bottom is None else _snapped("bottom", bottom, interfaces)
        if upper > lower:
            raise ValueError(f"top must not lie below bottom, got {upper:g} m and {lower:g} m")
        return upper, lower

    def cut_at(self, depths: ArrayLike) -> tuple[list[HalfSpace | None], NDArray[np.float64]]:
        """The layers cut so that depths are interfaces.

        Parameters
        ----------
        depths : array_like, shape (n,)
            m, from the surface to the base.

        Returns
        -------
        media : list of HalfSpace, length m
            Those below each interface; the last is the base, ``None`` if rigid.
        interfaces : ndarray, shape (m,)
            Depths, m, from the surface to the base.

        Raises
        ------
        ValueError
            If a depth lies outside the column.
        """
        interfaces = self._interfaces
        cuts = np.union1d(interfaces, [_snapped("depth", depth, interfaces) for depth in depths])
        owners = np.searchsorted(interfaces, (cuts[:-1] + cuts[1:]) / 2) - 1
        base = self.base if isinstance(self.base, HalfSpace) else None
        return [*(self.layers[owner] for owner in owners), base], cuts

    def response(
        self,
        motion,
        time_step: float | None = None,
        *,
        bottom: float | None = None,
        kind: str = "outcrop",
    ):
        """The column under a motion: histories at any depth, profiles, spectra.

        Parameters
        ----------
        motion : xarray.Dataset or array_like, shape (samples,)
            As :func:`sitedda.read_record` returns it, or ground acceleration, m/s².
        time_step : float, optional
            s between samples of an array.
        bottom : float, optional
            Depth of the motion, m; by default the base.
        kind : {'outcrop', 'within'}
            What the motion is, as in :meth:`transfer`.

        Returns
        -------
        sitedda.site.ColumnResponse

        Raises
        ------
        ValueError
            If an argument is out of range.
        """
        from .response import ColumnResponse

        return ColumnResponse.of(self, motion, time_step, bottom=bottom, kind=kind)


@dataclass(frozen=True)
class Waves:
    """How shear waves travel in media, at some frequencies.

    Attributes
    ----------
    omega : ndarray, shape (n,)
        Angular frequencies, rad/s; complex ones carry the damping of a time integration.
    properties : callable
        Of a medium: its complex shear modulus, Pa, and density, kg/m³, each of shape (n,).
    """

    omega: NDArray[np.complex128]
    properties: Callable[[HalfSpace], tuple[NDArray[np.complex128], NDArray[np.complex128]]]

    @classmethod
    def damped(cls, frequencies: NDArray[np.float64], convention: str) -> Waves:
        """With the damping of the media, ratios in a convention of :func:`complex_modulus`."""

        def properties(medium: HalfSpace):
            if isinstance(medium.damping, MaterialDamping):
                modulus, density = medium.damping.factors(frequencies)
                return medium.shear_modulus * modulus, medium.density * density
            ratio = medium.damping_at(frequencies)
            modulus = complex_modulus(medium.shear_modulus, ratio, convention)
            return modulus, np.full(modulus.shape, medium.density)

        return cls(2 * np.pi * frequencies, properties)

    @classmethod
    def stepped(cls, frequencies: NDArray[np.float64], time_step: float, scheme: Scheme) -> Waves:
        """Under a time integration, as :meth:`Column.scheme_transfer`."""
        factors = scheme.steady(frequencies, time_step)

        def properties(medium: HalfSpace):
            modulus = density = np.ones(frequencies.shape, dtype=complex)
            if isinstance(medium.damping, MaterialDamping):
                modulus, density = medium.damping.scheme_factors(
                    frequencies, factors, scheme, float(time_step)
                )
            return medium.shear_modulus * modulus, medium.density * density

        # A complex frequency with the modulus of the materials: only ω²/G and ratios of moduli
        # matter.
        return cls(np.sqrt(-factors.inertia), properties)


def recursion(
    waves: Waves, media: Sequence[HalfSpace | None], thicknesses: NDArray[np.float64]
) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Waves in a stack of m layers: the SHAKE recursion in quotients that cannot overflow.

    Instead of A and B, which grow like exp(|Im k| z), carry R = B/A at the top of each medium and
    the step A_j / A_{j+1}; every exponential in them decays.  A rigid base has impedance ratio 0.

    Parameters
    ----------
    waves : Waves
        At n frequencies.
    media : sequence of HalfSpace, length m + 1
        From the surface downwards; the last is the base, ``None`` if rigid.
    thicknesses : ndarray, shape (m,)
        m.

    Returns
    -------
    steps : ndarray of complex128, shape (m, n)
        A at the top of layer j over A at the top of the medium below it.
    reflections : ndarray of complex128, shape (m + 1, n)
        B/A at the top of each medium, that of the base last.
    """
    omega = waves.omega
    of = {id(medium): waves.properties(medium) for medium in media if medium is not None}
    steps = np.empty((len(thicknesses), omega.size), dtype=complex)
    reflections = np.ones((len(media), omega.size), dtype=complex)
    for j, thickness in enumerate(thicknesses):
        modulus, density = of[id(media[j])]
        below = media[j + 1]
        contrast = 0.0
        if below is not None:
            contrast = np.sqrt(density * modulus / np.prod(of[id(below)], axis=0))
        decay = np.exp(-1j * omega * thickness / np.sqrt(modulus / density))
        down = reflections[j] * decay**2
        upgoing = (1 + contrast) + (1 - contrast) * down
        downgoing = (1 - contrast) + (1 + contrast) * down
        with np.errstate(divide="ignore", invalid="ignore"):
            steps[j] = 2 * decay / upgoing
            reflections[j + 1] = downgoing / upgoing
    return steps, reflections


def refined_peak(
    transfer: Callable[[NDArray[np.float64]], ArrayLike],
    band: tuple[float, float],
    points: int = 1000,
) -> Peak:
    """The highest interior maximum of |transfer| in a band, refined beyond any grid.

    Each local maximum of ``points`` samples brackets a peak; 1/|transfer|², smooth at a resonance
    however sharp, is minimised in the bracket (Brent, scipy).

    Parameters
    ----------
    transfer : callable
        Complex or real transfer function of an array of frequencies, Hz.
    band : (float, float)
        Hz, 0 <= low < high.
    points : int
        Number of intervals searched; there should be some ten or more between two peaks.

    Returns
    -------
    Peak
        Frequency, Hz, and amplitude.

    Raises
    ------
    ValueError
        If the band is no band, holds no interior maximum, or the maximum is unbounded.
    """
    low, high = _band(band)
    if not 2 <= points <= _MOST_POINTS:
        raise ValueError(f"points must be in 2 ... {_MOST_POINTS}, got {points}")
    grid = np.linspace(low, high, points + 1)
    size = np.abs(np.asarray(transfer(grid)))
    if not np.all(np.isfinite(size)):
        raise ValueError(f"transfer is not finite at {first_of(grid, ~np.isfinite(size)):g} Hz")
    summits = 1 + np.flatnonzero((size[1:-1] >= size[:-2]) & (size[1:-1] > size[2:]))
    if summits.size == 0:
        raise ValueError(f"band {low:g} ... {high:g} Hz holds no peak of the transfer function")
    peaks = (_refined(transfer, grid[i - 1], grid[i + 1]) for i in summits)
    return max(peaks, key=lambda peak: peak.amplitude)


def _refined(transfer: Callable, low: float, high: float) -> Peak:
    from scipy.optimize import minimize_scalar

    def inverse_square(frequency: float) -> float:
        return 1 / abs(np.asarray(transfer(np.array([frequency])))[0]) ** 2

    found = minimize_scalar(
        inverse_square, bounds=(low, high), method="bounded", options={"xatol": 1e-12 * high}
    )
    amplitude = 1 / np.sqrt(found.fun)
    if amplitude > _UNBOUNDED:
        raise ValueError(f"the peak near {found.x:g} Hz is unbounded: the column has no damping")
    return Peak(float(found.x), float(amplitude))


# ---------------------------------------------------------------------------------------------
# Checks of arguments
# ---------------------------------------------------------------------------------------------


def _one_of(name: str, value: str, known: Sequence[str]) -> str:
    if not isinstance(value, str) or value not in known:
        raise ValueError(f"{name} must be one of {', '.join(known)}, got {value!r}")
    return value


def _band(band: tuple[float, float]) -> tuple[float, float]:
    edges = np.asarray(band, dtype=float)
    if edges.shape != (2,) or not np.all(np.isfinite(edges)) or not 0 <= edges[0] < edges[1]:
        raise ValueError(f"band must be two frequencies 0 <= low < high, got {band!r}")
    return float(edges[0]), float(edges[1])


def _snapped(name: str, depth: float, interfaces: NDArray[np.float64]) -> float:
    bottom = interfaces[-1]
    tolerance = 1e-9 * bottom
    value = float(depth)
    if not -tolerance <= value <= bottom + tolerance:
        raise ValueError(f"{name} must be a depth in 0 ... {bottom:g} m, got {value:g}")
    nearest = interfaces[np.argmin(np.abs(interfaces - value))]
    return float(nearest) if abs(nearest - value) <= tolerance else value


def _modulus_and_velocity(
    density: float, modulus: float | None, velocity: float | None
) -> tuple[float, float]:
    if modulus is None and velocity is None:
        raise ValueError("shear_modulus or shear_velocity must be given, got neither")
    if modulus is None:
        velocity = float(positive("shear_velocity", velocity))
        return density * velocity**2, velocity
    modulus = float(positive("shear_modulus", modulus))
    implied = float(np.sqrt(modulus / density))
    if velocity is not None and not np.isclose(velocity, implied, rtol=1e-9, atol=0):
        raise ValueError(
            f"shear_velocity must be left out or agree with shear_modulus, got {velocity:g} m/s"
            f" where the modulus gives {implied:g} m/s"
        )
    return modulus, implied
