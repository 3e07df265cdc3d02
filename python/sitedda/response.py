# SPDX-License-Identifier: GPL-3.0-or-later
"""Site response of a finished run: amplification in time domain and its one-dimensional twin."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .column import Column, Layer
from .damping import damping_of
from .errors import OutputError
from .input_text import input_values
from .spectra import Peak, amplification, find_peak

if TYPE_CHECKING:
    import xarray as xr

_RECTANGLE_TOLERANCE = 1e-6


@dataclass(frozen=True)
class Amplification:
    """The spectral ratio of two measured points.

    Attributes
    ----------
    surface, base : str
        Names of the points.
    direction : str
        'x' or 'y'.
    frequency : ndarray, shape (bins,)
        Hz, from `lowest` to `highest` of the request.
    ratio : ndarray, shape (bins,)
        Modulus of the ratio of the Fourier spectra of the accelerations.
    peak : Peak
        Its largest value in the band.
    """

    surface: str
    base: str
    direction: str
    frequency: np.ndarray
    ratio: np.ndarray
    peak: Peak

    def __str__(self) -> str:
        """One line, as the native executable prints it."""
        how = "peak interpolated" if self.peak.interpolated else "peak at a bin"
        return (
            f'amplification {self.surface}/{self.base} ("within"): {self.peak.amplitude:.3f} at '
            f"{self.peak.frequency:.4f} Hz (bin width {self.peak.bin_width:.6f} Hz, {how})"
        )


def amplifications(history: xr.Dataset) -> list[Amplification]:
    """Every amplification that the input of a run asks for (groups &amplification)."""
    groups = input_values(history.attrs).get("amplification", [])
    return [
        point_amplification(
            history,
            group.get("surface", "surface"),
            group.get("base", "base"),
            group["lowest"],
            group["highest"],
            group.get("direction", "x"),
            group.get("padding", 8),
        )
        for group in groups
    ]


def point_amplification(
    history: xr.Dataset,
    surface: str,
    base: str,
    lowest: float,
    highest: float,
    direction: str = "x",
    padding: int = 8,
) -> Amplification:
    """Amplification between two measured points, with its peak between two frequencies (Hz)."""
    axis = ("x", "y").index(direction)
    above, below = (
        history.acceleration.sel(point=name).isel(axis=axis).values for name in (surface, base)
    )
    time = history.time.values
    frequency, ratio = amplification(above, below, (time[-1] - time[0]) / (time.size - 1), padding)
    peak = find_peak(frequency, abs(ratio), lowest, highest)
    band = (frequency >= lowest) & (frequency <= highest)
    return Amplification(surface, base, direction, frequency[band], abs(ratio[band]), peak)


def layered_twin(history: xr.Dataset, surface: str, base: str) -> Column:
    """The horizontally layered column that a run models, on the block of its base point.

    Parameters
    ----------
    history : xarray.Dataset
    surface, base : str
        Measured points; the column is made of the blocks above the base point's block.

    Returns
    -------
    Column
        Layers on a rigid base, with the damping of their materials.

    Raises
    ------
    ValueError
        If the blocks are not rectangles stacked on each other.
    """
    boxes = _rectangles(history)
    low = _block_at(boxes, history.point_place.sel(point=base).values)
    high = _block_at(boxes, history.point_place.sel(point=surface).values)
    stack = [b for b in np.argsort(-boxes[:, 1]) if boxes[low, 1] < boxes[b, 1] <= boxes[high, 1]]
    tops, bottoms = boxes[stack, 3], boxes[stack, 1]
    size = boxes[high, 3] - boxes[low, 3]
    materials = input_values(history.attrs).get("material", [])
    number = history.block_material.values.astype(int)
    if np.any(number[stack] >= len(materials)):
        raise OutputError("the output is damaged: its input lacks the material of a block")
    if not stack or np.any(abs(np.append(tops[1:], boxes[low, 3]) - bottoms) > 1e-6 * size):
        raise ValueError("the blocks between base and surface are not stacked on each other")
    return Column(
        [
            Layer(
                float(boxes[b, 3] - boxes[b, 1]),
                density=float(history.block_density[b]),
                shear_modulus=float(history.block_shear_modulus[b]),
                damping=damping_of(materials[number[b]]) or 0.0,
            )
            for b in stack
        ]
    )


def _rectangles(history: xr.Dataset) -> np.ndarray:
    """Boxes (xmin, ymin, xmax, ymax) of all blocks in their first state."""
    owner = history.vertex_block.values
    vertices = np.split(history.vertices[0].values, np.flatnonzero(np.diff(owner)) + 1)
    boxes = []
    for polygon in vertices:
        low, high = polygon.min(0), polygon.max(0)
        corners = np.minimum(abs(polygon - low), abs(polygon - high))
        if len(polygon) != 4 or np.any(corners > _RECTANGLE_TOLERANCE * (high - low).max()):
            raise ValueError("a block is not an upright rectangle, so the model is not layered")
        boxes.append([*low, *high])
    return np.array(boxes)


def _block_at(boxes: np.ndarray, place: np.ndarray) -> int:
    inside = np.all((boxes[:, :2] - 1e-9 <= place) & (place <= boxes[:, 2:] + 1e-9), axis=1)
    return int(np.flatnonzero(inside)[0])
