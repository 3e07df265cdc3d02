# SPDX-License-Identifier: GPL-3.0-or-later
"""The largest values over all steps of a run, recorded by the engine."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class Maximum:
    """The largest value of a quantity."""

    value: float  # largest value; NaN if there is none, for example without measured points
    time: float  # time at which it was first reached, s
    unit: str
    # Name of the block; for a contact, names of the blocks of its vertex and of its edge.
    blocks: tuple[str, ...]
    points: tuple[str, ...]  # name of the measured point; for a drift, also of the point below
    residual: float  # the value at the end, or at the present time of a `sitedda.Simulation`

    def __str__(self) -> str:
        """Return value, position, time and residual as text."""
        position = " on ".join(self.blocks) or " over ".join(self.points)
        value, residual = (f"{v:.4g} {self.unit}" for v in (self.value, self.residual))
        return f"{value}, {position} at {self.time:.6g} s; residual {residual}"


def as_maxima(rows: Iterable, blocks, points) -> dict[str, Maximum]:
    """Return maxima by name.

    `rows`: name, unit, value, time, residual, numbers of blocks and of points, from 0; −1: none.
    `blocks`, `points`: names of all blocks and of all points.
    """

    def names(all_names, numbers) -> tuple[str, ...]:
        return tuple(str(all_names[int(i)]) for i in numbers if i >= 0)

    return {
        str(name): Maximum(float(value), float(time), str(unit), names(blocks, b),
                           names(points, p), float(residual))
        for name, unit, value, time, residual, b, p in rows
    }  # fmt: skip


def maxima_of(data: xr.Dataset) -> dict[str, Maximum]:
    """Return the maxima of an output by name."""
    order = ("maximum", "maximum_unit", "largest", "largest_time", "residual")
    sides = (data[name].transpose("maximum", "side").values for name in
           ("largest_block", "largest_point"))  # fmt: skip
    rows = zip(*(data[name].values for name in order), *sides, strict=True)
    return as_maxima(rows, data["block"].values, data["point"].values)
