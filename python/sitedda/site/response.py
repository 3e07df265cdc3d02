# SPDX-License-Identifier: GPL-3.0-or-later
"""The response of a column to a motion: histories, profiles and spectra."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.arguments import floats, not_negative
from ..base.errors import InputError
from ..engine.damping import MaterialDamping
from ..engine.scheme import Scheme
from ..engine.signals import running_integral, spectral_acceleration
from .intensity import Intensity, intensity
from .layers import HalfSpace, Waves, convention_words
from .motion import Motion

if TYPE_CHECKING:
    import xarray as xr

    from .column import Column

KINDS = ("outcrop", "within")  # kinds of motions
# Peaks of a profile: their dimension and unit.
_PEAKS = {"acceleration": ("depth", "m/s^2"), "velocity": ("depth", "m/s"),
          "displacement": ("depth", "m"), "strain": ("middle", "1"),
          "stress": ("middle", "Pa")}  # fmt: skip
_RESOLVED = 10.0  # Hz, highest frequency for which peaks within layers are sought
_PARTS_A_WAVE = 8  # parts per wavelength of that frequency
_INSIDE = 1e-8  # distance from an interface at which the layer above it is meant / depth
_DEPTHS_AT_ONCE = 32  # number of depths whose histories fit the memory
_AT_ONCE = 2048  # number of frequencies whose waves in all layers fit the cache


class SiteResponse:
    """The response of a column to a motion: results from its accelerations."""

    column: Column
    motion: Motion
    bottom: float
    kind: str

    def acceleration(self, depth: float = 0.0) -> NDArray[np.float64]:
        """Acceleration at a depth (m), m/s², shape (samples,)."""
        raise NotImplementedError

    def velocity(self, depth: float = 0.0) -> NDArray[np.float64]:
        """Velocity at a depth (m), m/s, shape (samples,); from rest."""
        return running_integral(self.acceleration(depth), self.motion.time_step)

    def profile(self) -> xr.Dataset:
        """Return largest values over depth: strain, stress (Pa), acceleration (m/s²)."""
        raise NotImplementedError

    @property
    def largest(self) -> tuple[float, float]:
        """Return the largest shear strain, and shear stress (Pa), of all depths."""
        raise NotImplementedError

    @property
    def time(self) -> NDArray[np.float64]:
        """Times of the samples, s."""
        return self.motion.time_step * np.arange(self.motion.acceleration.size)

    def spectrum(
        self, periods: ArrayLike, depth: float = 0.0, damping: float = 0.05
    ) -> NDArray[np.float64]:
        """Return the pseudo-spectral acceleration at natural periods (s, shape (n,)), m/s²."""
        surface = self.acceleration(depth)
        return spectral_acceleration(surface, self.motion.time_step, periods, damping)

    def intensity(self, depth: float = 0.0) -> Intensity:
        """Return the intensity measures at a depth (m)."""
        return intensity(self.acceleration(depth), self.motion.time_step)

    @property
    def words(self) -> str:
        """Describe the reference motion."""
        if not isinstance(self.column.base, HalfSpace) and self.bottom == self.column.depth:
            return f"motion of the rigid base at {self.bottom:g} m depth"
        if self.kind == "outcrop":
            return f"outcrop motion (twice the upgoing wave) at {self.bottom:g} m depth"
        return f"within motion (up- and downgoing waves) at {self.bottom:g} m depth"

    def _peak_profile(self, depth: NDArray[np.float64], *histories) -> xr.Dataset:
        """Return the peaks of histories, shape (depths or middles, samples), see `_PEAKS`."""
        import xarray as xr

        data = {
            name: (dim, np.abs(values).max(axis=1), {"units": unit})
            for (name, (dim, unit)), values in zip(_PEAKS.items(), histories, strict=True)
        }
        depths = {"depth": depth, "middle": (depth[:-1] + depth[1:]) / 2}
        coordinates = {name: (name, values, {"units": "m"}) for name, values in depths.items()}
        return xr.Dataset(data, coordinates, {"motion": self.words})


@dataclass(frozen=True)
class ColumnResponse(SiteResponse):
    """The linear response of a column to a ground motion.

    It is computed in the frequency domain (SHAKE). Zeros follow the record, as many as its samples
    or more, until the free vibration has decayed.

    Attributes
    ----------
    column : Column
    motion : Motion
        The reference motion.
    bottom : float
        Depth of the reference motion, m.
    kind : {'outcrop', 'within'}
        Kind of reference motion.
    scheme : Scheme or None
        Time integration whose damping replaces that of the layers.
    scheme_step : float or None
        Δt of the time integration, s; None: the time between samples.
    """

    column: Column
    motion: Motion
    bottom: float
    kind: str
    scheme: Scheme | None = None
    scheme_step: float | None = None

    def _wave_field(self, frequencies: NDArray[np.float64], depth: ArrayLike):
        """Return waves, and the results of `Column.wave_field` at depths (m)."""
        if self.scheme is None:
            waves = Waves.damped(frequencies, self.column.convention)
        else:
            step = self.scheme_step or self.motion.time_step
            waves = Waves.stepped(frequencies, step, self.scheme)
        depths = floats("depth", depth).ravel()
        return waves, *self.column.wave_field(waves, depths, self.bottom, self.kind)

    @property
    def _frequencies(self) -> NDArray[np.float64]:
        """Return the frequencies of the motion above 0 and below the Nyquist frequency."""
        frequencies = self.motion.frequencies[1:]
        limit = np.inf if self.scheme is None else 0.5 / self.motion.time_step * (1 - 1e-9)
        return frequencies[frequencies < limit]

    @property
    def unbounded(self) -> str:
        """Return why free vibration never decays; '' if it does."""
        absorbed = self.kind == "outcrop" and isinstance(self.column.base, HalfSpace)
        if self.scheme or absorbed:
            return ""
        if any(layer.damping_at(self._frequencies).any() for layer in self.column.layers):
            return ""
        is_half_space = isinstance(self.column.base, HalfSpace)
        base = "above a base with a within motion" if is_half_space else "on a rigid base"
        return (
            f"soils without damping {base} have infinite amplification at resonance; give them a "
            "damping ratio at small strains"
        )

    def check_bounded(self) -> None:
        """Raise InputError if free vibration never decays."""
        if self.unbounded:
            raise InputError(f"the motion of the column is unbounded: {self.unbounded}")

    def _integrate_motion(
        self, ratio, order: int, depth: ArrayLike, first: complex = 0.0, trial: bool = False
    ) -> NDArray[np.float64]:
        """Return histories of the motion × `ratio`/(iω)^order; `first` is the value at 0 Hz.

        Without `trial`, the motion must be bounded.
        """
        if not trial:
            self.check_bounded()
        omega = 2j * np.pi * self._frequencies
        spectrum = self.motion.spectrum[1 : 1 + omega.size] / omega**order
        full_spectrum = np.zeros(self.motion.frequencies.size, dtype=complex)
        full_spectrum[0], histories = first, np.empty((len(ratio), self.motion.acceleration.size))
        for history, row in zip(histories, ratio, strict=True):
            np.multiply(row, spectrum, out=full_spectrum[1 : 1 + omega.size])
            history[:] = self.motion.history(full_spectrum)
        return histories.reshape(*np.shape(depth), histories.shape[-1])

    def transfer(self, frequencies: ArrayLike, depth: float = 0.0) -> NDArray[np.complex128]:
        """Return motion at a depth / reference motion at ``frequencies`` (Hz)."""
        values = not_negative("frequencies", frequencies)
        return self._displacement_ratio(values.ravel(), depth)[0].reshape(values.shape)

    def acceleration(self, depth: ArrayLike = 0.0) -> NDArray[np.float64]:
        """Acceleration at a depth or depths (m), m/s², shape (..., samples)."""
        ratio = self._displacement_ratio(self._frequencies, depth)
        return self._integrate_motion(ratio, 0, depth, self.motion.spectrum[0])

    def displacement(self, depth: ArrayLike = 0.0) -> NDArray[np.float64]:
        """Displacement relative to the reference motion, m, shape (..., samples)."""
        ratio = self._displacement_ratio(self._frequencies, depth)
        return self._integrate_motion(ratio - 1, 2, depth)

    def strain(self, depth: ArrayLike) -> NDArray[np.float64]:
        """Shear strain at a depth or depths (m), dimensionless, shape (..., samples)."""
        return self._integrate_motion(self._strain_ratio(depth)[0], 2, depth)

    def trial_strain(self, depth: ArrayLike) -> NDArray[np.float64]:
        """Shear strain as `strain`; in iterations, the column may have no damping."""
        return self._integrate_motion(self._strain_ratio(depth)[0], 2, depth, trial=True)

    def stress(self, depth: ArrayLike) -> NDArray[np.float64]:
        """Shear stress at a depth or depths (m), Pa, shape (..., samples)."""
        return self._integrate_motion(self._strain_ratio(depth)[1], 2, depth)

    def _displacement_ratio(self, frequencies, depth: ArrayLike) -> NDArray[np.complex128]:
        """Return displacements at depths / that of the reference motion, shape (depths, n)."""
        ratios = []
        for chunk in _split(frequencies):
            *_, indices, upgoing, reflections = self._wave_field(chunk, depth)
            ratios.append(upgoing[indices] * (1 + reflections[indices]))
        return np.concatenate(ratios, axis=1)

    def _strain_ratio(self, depth: ArrayLike) -> NDArray[np.complex128]:
        """Return shear strains ∂u/∂z, z downwards (1/m), and stresses (Pa/m), at depths."""
        ratios = [_strains(*self._wave_field(chunk, depth)) for chunk in _split(self._frequencies)]
        return np.concatenate(ratios, axis=2)

    def profile(self) -> xr.Dataset:
        """Return peaks over depth.

        Returns
        -------
        xarray.Dataset
            Peak ``acceleration``, ``velocity`` and ``displacement`` (relative to the reference
            motion) over ``depth``, the interfaces; peak ``strain`` and ``stress`` over ``middle``,
            the middles of the layers.
        """
        _, interfaces = self.column.cut_at([])
        middles = self.column.middles
        strains = self._strain_ratio(middles)
        accelerations = self.acceleration(interfaces)
        return self._peak_profile(
            interfaces, accelerations, running_integral(accelerations, self.motion.time_step),
            self.displacement(interfaces),
            *(self._integrate_motion(ratio, 2, middles) for ratio in strains),
        )  # fmt: skip

    @property
    def largest(self) -> tuple[float, float]:
        """Return the largest shear strain, and shear stress (Pa), at bottoms of parts of layers."""
        depths, top = [], 0.0
        for layer in self.column.layers:
            waves = _RESOLVED * layer.thickness / layer.shear_velocity
            parts = max(2, int(np.ceil(_PARTS_A_WAVE * waves)))
            depths.append(top + layer.thickness * np.arange(1, parts + 1) / parts)
            top += layer.thickness
        above = np.concatenate(depths) - _INSIDE * self.column.depth
        peaks = [
            [np.abs(self._integrate_motion(ratio, 2, some)).max()
             for ratio in self._strain_ratio(some)]
            for some in np.array_split(above, 1 + above.size // _DEPTHS_AT_ONCE)
        ]  # fmt: skip
        strain, stress = np.max(peaks, axis=0)
        return float(strain), float(stress)

    @property
    def convention(self) -> str:
        """Describe the convention of damping ratios; '' if no medium has one."""
        base = [self.column.base] if isinstance(self.column.base, HalfSpace) else []
        ratios = [medium.damping for medium in (*self.column.layers, *base)]
        constant = [ratio for ratio in ratios if ratio and not isinstance(ratio, MaterialDamping)]
        return convention_words(self.column.convention) if constant and self.scheme is None else ""

    def __str__(self) -> str:
        reference = intensity(self.motion.acceleration, self.motion.time_step)
        description = f"{self.words}; {self.convention}" if self.convention else self.words
        return f"{description}\nreference: {reference}\nsurface:   {self.intensity()}"

    def plot(self):
        """Draw surface and reference motion, spectra, and profiles; return the figure."""
        from .picture import response_figure

        return response_figure(self)


def _split(frequencies: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    return np.array_split(frequencies, 1 + frequencies.size // _AT_ONCE)


def _strains(waves: Waves, media, interfaces, indices, upgoing, reflections):
    """Return strains and stresses in a field of waves, shape (2, depths, n).

    At an interface, strains belong to the medium below, at a rigid base to the one above.
    """
    results = np.empty((2, len(indices), upgoing.shape[1]), dtype=complex)
    for row, j in enumerate(indices):
        rigid = media[j] is None
        layer = j - 1 if rigid else j
        modulus, density = waves.properties(media[layer])
        wavenumber = waves.omega / np.sqrt(modulus / density)
        upgoing_wave, downgoing_wave = upgoing[layer], upgoing[layer] * reflections[layer]
        if rigid:  # the waves at the bottom of the layer above
            phase = np.exp(-1j * wavenumber * (interfaces[j] - interfaces[layer]))
            upgoing_wave, downgoing_wave = upgoing_wave / phase, downgoing_wave * phase
        results[0, row] = 1j * wavenumber * (upgoing_wave - downgoing_wave)
        results[1, row] = modulus * results[0, row]
    return results
