# SPDX-License-Identifier: GPL-3.0-or-later
"""Shear waves in layers of soil: complex moduli and the recursion of SHAKE.

Time dependence is exp(iωt) and depth grows downwards from the free surface, so layer *j* has the
displacement ``A exp(ikz) + B exp(-ikz)``, with the upgoing wave first.

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

from collections.abc import Callable, Collection, Sequence
from dataclasses import KW_ONLY, dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.arguments import first_of, not_negative, positive
from ..base.errors import InputError
from ..engine.damping import MaterialDamping
from ..engine.scheme import Scheme

Damping = float | Callable[[NDArray[np.float64]], ArrayLike] | MaterialDamping


# --- Complex modulus -----------------------------------------------------------------------------

# name: (factor G*/G as a function of the damping ratio D, largest permitted D, modulus of G*)
CONVENTIONS = {
    "shake": (lambda d: 1 + 2j * d, np.inf, "G √(1 + 4D²)"),
    "shake91": (lambda d: 1 - 2 * d**2 + 2j * d * np.sqrt(1 - d**2), 1.0, "G"),
    "kramer": (lambda d: 1 - d**2 + 2j * d, 1.0, "G (1 + D²)"),
    "dormieux": (lambda d: np.sqrt(1 - 4 * d**2) + 2j * d, 0.5, "G"),
}
DEFAULT_CONVENTION = "dormieux"  # as in pystrata: |G*| = G, loss per cycle πD of ½ |G*| γ²


def largest_damping(convention: str) -> float:
    """Return the largest damping ratio permitted by a convention of :func:`complex_modulus`."""
    return CONVENTIONS[one_of("convention", convention, CONVENTIONS)][1]


def convention_words(convention: str) -> str:
    """Describe modulus and damping ratio of a convention of :func:`complex_modulus`."""
    _, largest, modulus = CONVENTIONS[one_of("convention", convention, CONVENTIONS)]
    limit = "" if np.isinf(largest) else f", D up to {largest:g}"
    return f"complex modulus '{convention}', |G*| = {modulus}{limit}"


def complex_modulus(
    shear_modulus: ArrayLike, damping: ArrayLike, convention: str = DEFAULT_CONVENTION
) -> NDArray[np.complex128]:
    """Return the complex shear modulus G* of a linear hysteretic material.

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
    """
    factor, largest, _ = CONVENTIONS[one_of("convention", convention, CONVENTIONS)]
    ratio = np.asarray(damping, dtype=float)
    is_allowed = (ratio >= 0) & (ratio <= largest) & np.isfinite(ratio)
    if not np.all(is_allowed):
        raise InputError(
            f"damping must be in 0 ... {largest:g} for convention '{convention}',"
            f" got {first_of(ratio, ~is_allowed):g}"
            f"{_wider_conventions(convention, ratio[~is_allowed])}"
        )
    return np.asarray(shear_modulus, dtype=float) * factor(ratio).astype(complex)


def _wider_conventions(convention: str, damping: NDArray[np.float64]) -> str:
    """Return the conventions that permit these damping ratios, for a message."""
    peak = np.max(damping)
    names = [
        f"'{name}'"
        for name, (_, largest, _) in CONVENTIONS.items()
        if name != convention and np.min(damping) >= 0 and peak <= largest and np.isfinite(peak)
    ]
    return f"; for such a ratio: {', '.join(names)}" if names else ""


# --- Closed forms of the uniform layer -----------------------------------------------------------


def undamped_amplification(
    frequency: ArrayLike, thickness: float, shear_velocity: float
) -> NDArray[np.float64]:
    """Return the surface amplification of a uniform undamped layer on a rigid base (eq. 9).

    ``1 / |cos(ωH/v)|`` with ω of the frequency (Hz), the thickness H (m) and the velocity v (m/s);
    rounding limits it at a resonance.
    """
    return 1 / np.abs(np.cos(_phase(frequency, thickness, shear_velocity)))


def damped_amplification(
    frequency: ArrayLike, thickness: float, shear_velocity: float, damping: ArrayLike
) -> NDArray[np.float64]:
    """Return the surface amplification of a uniform damped layer on a rigid base (eq. 10).

    ``1 / √(cos²(ωH/v) + (ζωH/v)²)``: ``1 / |cos(k*H)|`` with a relative error of the order of
    ζ² (1 + (ωH/v)²), see :func:`undamped_amplification`; ζ is the damping ratio.
    """
    phase = _phase(frequency, thickness, shear_velocity)
    ratio = not_negative("damping", damping)
    return 1 / np.hypot(np.cos(phase), ratio * phase)


def _phase(frequency: ArrayLike, thickness: float, shear_velocity: float) -> NDArray[np.float64]:
    """Return ωH/v."""
    height = positive("thickness", thickness)
    velocity = positive("shear_velocity", shear_velocity)
    return 2 * np.pi * not_negative("frequency", frequency) * height / velocity


# --- Layers and columns --------------------------------------------------------------------------


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
    InputError
        If a value is not finite and positive, or modulus and velocity are missing or disagree.
    """

    _: KW_ONLY
    density: float
    shear_modulus: float | None = None
    shear_velocity: float | None = None
    damping: Damping = 0.0

    def __post_init__(self) -> None:
        density = float(positive("density", self.density))
        modulus, velocity = self.shear_modulus, self.shear_velocity
        if velocity is not None:
            velocity = float(positive("shear_velocity", velocity))
        if modulus is not None:
            modulus = float(positive("shear_modulus", modulus))
            implied = float(np.sqrt(modulus / density))
            if velocity is not None and not np.isclose(velocity, implied, rtol=1e-9, atol=0):
                raise InputError(
                    "shear_velocity must be left out or agree with shear_modulus, got "
                    f"{velocity:g} m/s; the modulus implies {implied:g} m/s"
                )
            velocity = implied
        elif velocity is not None:
            modulus = density * velocity**2
        else:
            raise InputError("shear_modulus or shear_velocity must be given, got neither")
        damping = self.damping
        if not (callable(damping) or isinstance(damping, MaterialDamping)):
            damping = float(not_negative("damping", damping))
        names = ("density", "shear_modulus", "shear_velocity", "damping")
        for name, value in zip(names, (density, modulus, velocity, damping), strict=True):
            object.__setattr__(self, name, value)

    def damping_at(self, frequencies: ArrayLike) -> NDArray[np.float64]:
        """Return the damping ratio at each frequency (Hz, shape (n,)).

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
            raise InputError(
                f"damping must return one ratio per frequency, shape {values.shape},"
                f" got shape {ratio.shape}"
            )
        return np.broadcast_to(ratio, values.shape)


@dataclass(frozen=True)
class Layer(HalfSpace):
    """A horizontal layer: a :class:`HalfSpace` with a finite thickness.

    ``Layer(1.0, density=2643.0, shear_velocity=851.0, damping=0.022)``

    Parameters
    ----------
    thickness : float
        H, m; the only positional argument.
    density, shear_modulus, shear_velocity, damping
        See :class:`HalfSpace`.

    Raises
    ------
    InputError
        As in :class:`HalfSpace`, or if the thickness is not finite and positive.
    """

    thickness: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "thickness", float(positive("thickness", self.thickness)))
        super().__post_init__()


@dataclass(frozen=True)
class Waves:
    """Propagation of shear waves in media at some frequencies."""

    # Angular frequencies, rad/s; complex ones include the damping of a time integration
    omega: NDArray[np.complex128]
    # Returns complex shear modulus (Pa) and density (kg/m³) of a medium at these frequencies, of
    # shape (1,) if all are equal
    properties: Callable[[HalfSpace], tuple[NDArray[np.complex128], NDArray[np.complex128]]]

    @classmethod
    def damped(cls, frequencies: NDArray[np.float64], convention: str) -> "Waves":
        """Return waves with the damping of the media in a convention of :func:`complex_modulus`."""

        def properties(medium: HalfSpace):
            if isinstance(medium.damping, MaterialDamping):
                modulus, density = medium.damping.factors(frequencies)
                return medium.shear_modulus * modulus, medium.density * density
            constant = isinstance(medium.damping, float)
            ratio = medium.damping_at(frequencies[:1] if constant else frequencies)
            modulus = complex_modulus(medium.shear_modulus, ratio, convention)
            return modulus, np.full(modulus.shape, medium.density)

        return cls(2 * np.pi * frequencies, properties)

    @classmethod
    def stepped(cls, frequencies: NDArray[np.float64], time_step: float, scheme: Scheme) -> "Waves":
        """Return waves under a time integration, as in :meth:`Column.scheme_transfer`."""
        factors = scheme.steady(frequencies, time_step)

        def properties(medium: HalfSpace):
            modulus = density = np.ones(frequencies.shape, dtype=complex)
            if isinstance(medium.damping, MaterialDamping):
                state = frequencies, factors, scheme, float(time_step)
                modulus, density = medium.damping.scheme_factors(*state)
            return medium.shear_modulus * modulus, medium.density * density

        # The frequency is complex and moduli are unchanged: only ω²/G and ratios of moduli matter.
        return cls(np.sqrt(-factors.inertia), properties)


def recursion(
    waves: Waves, media: Sequence[HalfSpace | None], thicknesses: NDArray[np.float64]
) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Compute the waves in m layers by the SHAKE recursion in quotients that cannot overflow.

    A and B grow like exp(|Im k| z). Therefore R = B/A at the top of each medium and A_j / A_{j+1}
    are used, in which every exponential decays. A rigid base (a last medium of None) has impedance
    ratio 0.

    Result `steps`, shape (m, n): A at the top of layer j over A at the top of the medium below it.
    Result `reflections`, shape (m + 1, n): B/A at the top of each medium, that of the base last.
    """
    omega = waves.omega
    first = [media.index(medium) for medium in media]  # index of the first equal medium
    properties = {j: waves.properties(media[j]) for j in set(first) if media[j] is not None}
    steps = np.empty((len(thicknesses), omega.size), dtype=complex)
    reflections = np.empty((len(media), omega.size), dtype=complex)
    reflections[0], previous = 1.0, None
    for j, thickness in enumerate(thicknesses):
        modulus, density = properties[first[j]]
        if previous != (previous := (first[j], thickness)):
            decay = np.exp(-1j * omega * thickness / np.sqrt(modulus / density))
            decay_squared = decay**2
        reflected = reflections[j] * decay_squared
        if first[j + 1] == first[j]:  # nothing is reflected within a medium
            steps[j], reflections[j + 1] = decay, reflected
            continue
        contrast = 0.0
        if media[j + 1] is not None:
            contrast = np.sqrt(density * modulus / np.prod(properties[first[j + 1]], axis=0))
        upgoing = (1 + contrast) + (1 - contrast) * reflected
        downgoing = (1 - contrast) + (1 + contrast) * reflected
        with np.errstate(divide="ignore", invalid="ignore"):
            steps[j] = 2 * decay / upgoing
            reflections[j + 1] = downgoing / upgoing
    return steps, reflections


def one_of(name: str, value: str, allowed: Collection[str]) -> str:
    """Return the value; raise an error if it is not in the list."""
    if not isinstance(value, str) or value not in allowed:
        raise InputError(f"{name} must be one of {', '.join(allowed)}, got {value!r}")
    return value
