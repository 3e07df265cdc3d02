# SPDX-License-Identifier: GPL-3.0-or-later
"""Convert a site from a CSV file into a column with the curves of its soils."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..base.errors import InputError, located
from ..build.profile import Ground, SoilProfile, parse_curve, read_curve_table, read_soil_profile
from .column import Column, HalfSpace, Layer
from .curves import SoilCurves, darendeli, gqh, hyperbolic, mkz, strength_corrected
from .layers import one_of

_WEAK, _STRONG = 20.0, 45.0  # usual range of the friction angle of an implied strength, degrees


@dataclass(frozen=True)
class Profile(SoilProfile):
    """Layers of ground, from the surface downwards, as a column."""

    def column(
        self, base: str | None = None, convention: str | None = None, waves: str = "S"
    ) -> Column:
        """Return the layers as a column.

        Parameters
        ----------
        base : {'half_space', 'rigid'}, optional
            By default, the half-space if the file has one.
        convention : str, optional
            See `Column`.
        waves : {'S', 'P'}
            P: for vertical motions; its shear modulus is the constrained modulus.
        """
        one_of("waves", waves, ("S", "P"))
        if base not in (None, "half_space", "rigid"):
            raise InputError(f"base = {base!r}: use 'half_space' or 'rigid'")
        if base == "half_space" and self.half_space is None:
            raise InputError(f"{self.file} has no half-space: add a last row without thickness")
        base_medium: HalfSpace | str = "rigid"
        if base != "rigid" and self.half_space is not None:
            base_medium = HalfSpace(**self._medium(self.half_space, waves))
        options = {} if convention is None else {"convention": convention}
        layers = [Layer(layer.thickness, **self._medium(layer, waves)) for layer in self.layers]
        return Column(layers, base_medium, waves=waves, **options)

    def _medium(self, ground: Ground, waves: str) -> dict[str, float]:
        """Return the values of a layer for these waves."""
        if waves == "S":
            return ground.values()
        if math.isnan(ground.pressure_velocity):
            raise InputError(f"{self.file}, row {ground.row}: a column of P waves needs Vp or nu")
        return ground.values() | {"shear_velocity": ground.pressure_velocity}

    def curves(
        self, water_table: float = math.inf, pressure_at_rest: float = 0.5
    ) -> list[SoilCurves | None]:
        """Return modulus reduction and damping of each layer; None: linear.

        If a row has a damping ratio above 0, its damping curve is shifted so that it begins at
        this ratio.  If the file has a strength (``shear_strength``, ``friction_angle``), the
        curves end at it: see `strength_corrected`.

        Parameters
        ----------
        water_table : float
            Depth, m (none): effective stresses, which `darendeli` has, count from it.
        pressure_at_rest : float
            Coefficient K₀ of earth pressure at rest, for mean effective stresses.
        """
        stresses = self.mean_stresses(water_table, pressure_at_rest)
        strengths = self.strengths(water_table, pressure_at_rest)
        result = []
        for layer, mean, strength in zip(self.layers, stresses, strengths, strict=True):
            curve = _layer_curves(layer, mean, self.file)
            if curve is not None and layer.damping:
                shifted = curve.damping + (layer.damping - curve.damping[0])
                curve = replace(curve, damping=np.clip(shifted, 0.0, 0.999))
            if curve is not None and not math.isnan(strength):
                modulus = layer.density * layer.shear_velocity**2
                with located(f"{self.file}, row {layer.row}", ValueError):
                    curve = strength_corrected(curve, modulus, strength)
            result.append(curve)
        return result

    def strength_words(self, water_table: float = math.inf, pressure_at_rest: float = 0.5) -> str:
        """Describe the strength that `curves` imply if the file has none; '' if linear."""
        curves = self.curves(water_table, pressure_at_rest)
        means = self.mean_stresses(water_table, pressure_at_rest)
        lines = []
        for layer, curve, mean in zip(self.layers, curves, means, strict=True):
            if curve is None or not (math.isnan(layer.shear_strength)
                                   and math.isnan(layer.friction_angle)):  # fmt: skip
                continue
            strength = curve.implied_strength(layer.density * layer.shear_velocity**2)
            vertical = mean * 3 / (1 + 2 * pressure_at_rest)
            angle = math.degrees(math.atan2(strength, vertical))
            if not _WEAK <= angle <= _STRONG:
                lines.append(f"row {layer.row}: the curves imply a shear strength of "
                             f"{strength / 1e3:.3g} kPa (a friction angle of {angle:.2g}°); give "
                             "shear_strength or friction_angle")  # fmt: skip
        return "\n".join(lines)

    def plot(self):
        """Draw velocities, density and damping over depth; return the figure."""
        from .picture import profile_figure

        return profile_figure(self)


def read_profile(file, fill: str = "") -> Profile:
    """Read a site from a CSV file, see `sitedda.build.profile.read_soil_profile`."""
    profile = read_soil_profile(file, fill)
    return Profile(profile.layers, profile.half_space, profile.file)


def _layer_curves(layer: Ground, stress: float, file: Path) -> SoilCurves | None:
    location = f"{file}, row {layer.row}"
    name, numbers = parse_curve(layer.curve, location)
    formulas: dict[str, Callable[..., SoilCurves]] = {
        "darendeli": lambda *more: darendeli(stress, *more), "hyperbolic": hyperbolic, "mkz": mkz,
        "gqh": lambda reference, *theta: gqh(reference, theta),
    }  # fmt: skip
    try:
        if name in ("", "linear"):
            return None
        if name in formulas:
            return formulas[name](*numbers)
        return SoilCurves(*read_curve_table(file.parent / name), name=Path(name).stem)
    except InputError:
        raise
    except (ValueError, TypeError) as error:
        raise InputError(f"{location}: curve = {layer.curve!r}: {error}") from None
