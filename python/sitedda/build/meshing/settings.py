# SPDX-License-Identifier: GPL-3.0-or-later
"""What is meshed, and how finely."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ...base.errors import InputError
from ..cutting.geometry import points_of

IN_A_WAVE = 12  # cells in the length of a shear wave
_FARTHEST = 1e9  # m
_NO_POINTS = np.zeros((0, 2))


@dataclass(kw_only=True)
class Mesh:
    """Blocks that become bodies of welded cells.

    Attributes
    ----------
    blocks, regions : str
        Names with commas, with ``*`` for any end: blocks, or regions whose blocks are meant.
    body : str
        Name of the one body that they become; blank: each becomes a body of its own name.
    size : float
        Side of a square as large as a cell, m.
    frequency : float
        In place of `size`, Hz: there are 12 cells in the length of a shear wave.
    cells : {'quadrilateral', 'voronoi'}
        Squares, and what outlines leave of them; or even polygons.
    fine_at, fine_along : array_like
        Points, and a polyline, x, y, m: near these cells have `fine_size`.
    fine_size : float
        m.
    seed : int
        Of the polygons, 0 … 2⁶³ − 1.
    """

    blocks: str = ""
    regions: str = ""
    body: str = ""
    size: float | None = None
    frequency: float | None = None
    cells: str = "quadrilateral"
    fine_at: np.ndarray = field(default_factory=_NO_POINTS.copy)
    fine_along: np.ndarray = field(default_factory=_NO_POINTS.copy)
    fine_size: float | None = None
    seed: int = 0

    def __post_init__(self):
        if bool(self.blocks.strip()) == bool(self.regions.strip()):
            raise InputError("give either blocks or regions")
        if (self.size is None) == (self.frequency is None):
            raise InputError("give either size or frequency")
        for name in ("size", "frequency", "fine_size"):
            value = getattr(self, name)
            if value is not None and not 0 < value <= _FARTHEST:
                raise InputError(f"{name} = {value:g} must be a positive number")
        if self.cells not in ("quadrilateral", "voronoi"):
            raise InputError(f"cells = {self.cells!r} must be 'quadrilateral' or 'voronoi'")
        if not 0 <= self.seed < 2**63:
            raise InputError(f"seed = {self.seed} must lie between 0 and 2**63 - 1")
        self.fine_at = points_of("fine_at", self.fine_at, 0)
        self.fine_along = points_of("fine_along", self.fine_along, 0)
        if len(self.fine_along) == 1:
            raise InputError("fine_along: 1 point given, at least 2 are needed")
        if bool(len(self.fine_at) + len(self.fine_along)) != (self.fine_size is not None):
            raise InputError("fine_size belongs to fine_at or fine_along, and they to it")

    def size_of(self, name: str, material: dict) -> float:
        """Size of cells (m) of a material, whose variables are given."""
        if self.size is not None:
            return self.size
        try:
            velocity = (
                material.get("shear_velocity")
                or (
                    material["young_modulus"]
                    / (2 * (1 + material["poisson_ratio"]) * material["density"])
                )
                ** 0.5
            )
        except (KeyError, ZeroDivisionError):
            raise InputError(
                f"frequency: material {name!r} lacks what gives the velocity of S waves"
            ) from None
        return velocity / (self.frequency * IN_A_WAVE)


def is_listed(name: str, patterns: str) -> bool:
    """Whether a name is one of 'one, two, all_*'."""
    entries = filter(None, map(str.strip, patterns.split(",")))
    return any(name.startswith(one[:-1]) if one.endswith("*") else name == one for one in entries)
