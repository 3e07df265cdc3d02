# SPDX-License-Identifier: GPL-3.0-or-later
"""The one-dimensional twin of a run of layered blocks."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..base.errors import OutputError
from ..engine.damping import damping_of
from ..input.input_text import input_values
from .column import Column, Layer

if TYPE_CHECKING:
    import xarray as xr

_RECTANGLE_TOLERANCE = 1e-6


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
    if not inside.any():
        x, y = place
        raise ValueError(f"no block lies at the measured point ({x:g}, {y:g}) m")
    return int(np.flatnonzero(inside)[0])
