# SPDX-License-Identifier: GPL-3.0-or-later
"""The group &mesh: blocks that are meshed, and sizes of their cells."""

from ...base.errors import InputError
from ...input import schema

IN_A_WAVE = 12  # number of cells per shear wavelength


class Mesh(schema.MeshValues):
    """Blocks that become bodies of welded cells."""

    def _check_values(self) -> None:
        """Raise InputError if `fine_along` is a single point."""
        if len(self.fine_along) == 1:
            raise InputError("fine_along: 1 point given, at least 2 are needed")

    def size_of(self, name: str, material: dict) -> float:
        """Return the size of cells (m) for a material with this name and these variables."""
        if self.size is not None:
            return self.size
        try:
            velocity = material.get("shear_velocity")
            if not velocity:
                divisor = 2 * (1 + material["poisson_ratio"]) * material["density"]
                velocity = (material["young_modulus"] / divisor) ** 0.5
        except (KeyError, ZeroDivisionError):
            raise InputError(
                f"frequency: material {name!r} needs young_modulus and poisson_ratio, or velocities"
            ) from None
        return velocity / (self.frequency * IN_A_WAVE)


def is_listed(name: str, patterns: str) -> bool:
    """Return whether a name matches one of the patterns 'one, two, all_*'."""
    entries = filter(None, map(str.strip, patterns.split(",")))
    return any(name.startswith(key[:-1]) if key.endswith("*") else name == key for key in entries)
