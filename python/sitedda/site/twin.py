# SPDX-License-Identifier: GPL-3.0-or-later
"""Derive the one-dimensional column of a run of layered blocks."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..base.errors import InputError, OutputError
from ..engine.damping import damping_of
from ..input.input_text import input_values
from .branches import Branches
from .column import Column, HalfSpace, Layer

if TYPE_CHECKING:
    import xarray as xr

_RECTANGLE_TOLERANCE = 1e-6


def layered_soils(
    history: xr.Dataset, surface: str, base: str
) -> tuple[Column, list[Branches | None]]:
    """Return the horizontally layered column that a run models, below its surface point.

    The column ends on top of the block of the base point, or, if that is a cell of the same body,
    at the base point. Its base is rigid, and its layers have the damping of their materials; the
    branches of a linear layer are None.
    """
    boxes = _block_boxes(history)
    base_position = history.point_place.sel(point=base).values
    low = _block_containing(boxes, base_position)
    high = _block_containing(boxes, history.point_place.sel(point=surface).values)
    size = boxes[high, 3] - boxes[high, 1]
    body = history.block_body.values if "block_body" in history else np.zeros(len(boxes))
    bottom = float(base_position[1] if body[low] and body[low] == body[high] else boxes[low, 3])
    middle = boxes[high, [0, 2]].mean()
    is_column = (boxes[:, 0] <= middle) & (middle < boxes[:, 2])
    is_column &= (boxes[:, 3] > bottom + 1e-6 * size) & (boxes[:, 1] <= boxes[high, 1])
    stack = np.flatnonzero(is_column)
    stack = stack[np.argsort(-boxes[stack, 1])]
    tops, bottoms = boxes[stack, 3], boxes[stack, 1]
    if not stack.size or np.any(abs(np.append(tops[1:], bottom) - bottoms) > 1e-6 * size):
        raise InputError("the blocks between base and surface are not stacked on each other")
    materials = input_values(history.attrs).get("material", [])
    number = history.block_material.values.astype(int)
    if np.any(number[stack] >= len(materials)):
        raise OutputError("the output is damaged: its input lacks the material of a block")
    layers, soils = [], []
    for b in stack:
        material = materials[number[b]]
        soils.append(Branches.of_material(material, float(history.block_shear_modulus[b])))
        damping = None if soils[-1] else damping_of(material)
        layers.append(_block_layer(history, b, float(boxes[b, 3] - boxes[b, 1]), damping))
    return Column(layers), soils


def _block_layer(history: xr.Dataset, block: int, thickness: float, damping) -> Layer:
    """Return a layer of the soil of a block."""
    return Layer(thickness, density=float(history.block_density[block]),
                 shear_modulus=float(history.block_shear_modulus[block]),
                 damping=damping or 0.0)  # fmt: skip


def column_below(history: xr.Dataset, position, side: float) -> Column | None:
    """Return the layers below a surface point (m) of any model, at small strains.

    A vertical line at a distance `side` (m) from the point cuts the blocks.  The base is the
    half-space of a compliant base, else rigid.  None: the point is not on top of the line, or there
    is a gap.
    """
    intervals: dict[float, tuple[float, int]] = {}
    x, top = np.asarray(position, dtype=float)
    for block, polygon in enumerate(_initial_polygons(history)):
        (x0, y0), (x1, y1) = polygon.T, np.roll(polygon, -1, axis=0).T
        crossed = (x0 - x - side) * (x1 - x - side) < 0
        fraction = (x + side - x0[crossed]) / (x1 - x0)[crossed]
        y = np.sort(y0[crossed] + fraction * (y1 - y0)[crossed])
        intervals |= {high: (low, block) for low, high in zip(y[::2], y[1::2], strict=True)}
    if not intervals or abs(max(intervals) - top) > 3 * abs(side):
        return None
    tops = np.sort(list(intervals))[::-1]
    if np.any(abs([intervals[high][0] for high in tops[:-1]] - tops[1:]) > 3 * abs(side)):
        return None
    groups = input_values(history.attrs)
    materials, number = groups.get("material", []), history.block_material.values.astype(int)
    layers = [_block_layer(history, b, high - low, damping_of(materials[number[b]]))
              for high, (low, b) in ((high, intervals[high]) for high in tops)]  # fmt: skip
    for boundary in groups.get("boundary", []):
        if boundary["kind"] == "compliant":
            rock = [boundary.get("density"), boundary.get("shear_velocity")]
            lowest = layers[-1].density, layers[-1].shear_velocity
            density, speed = (a or b for a, b in zip(rock, lowest, strict=True))
            return Column(layers, HalfSpace(density=density, shear_velocity=speed))
    return Column(layers)


def _initial_polygons(history: xr.Dataset) -> list[np.ndarray]:
    """Return the initial polygons of all blocks."""
    last = np.flatnonzero(np.diff(history.vertex_block.values))
    return np.split(history.vertices[0].values, last + 1)


def _block_boxes(history: xr.Dataset) -> np.ndarray:
    """Return the initial boxes (xmin, ymin, xmax, ymax) of all blocks."""
    boxes = []
    for polygon in _initial_polygons(history):
        low, high = polygon.min(0), polygon.max(0)
        corners = np.minimum(abs(polygon - low), abs(polygon - high))
        if len(polygon) != 4 or np.any(corners > _RECTANGLE_TOLERANCE * (high - low).max()):
            raise InputError("a block is not an upright rectangle, so the model is not layered")
        boxes.append([*low, *high])
    return np.array(boxes)


def _block_containing(boxes: np.ndarray, point: np.ndarray) -> int:
    contains = np.all((boxes[:, :2] - 1e-9 <= point) & (point <= boxes[:, 2:] + 1e-9), axis=1)
    if not contains.any():
        x, y = point
        raise InputError(f"no block lies at the measured point ({x:g}, {y:g}) m")
    return int(np.flatnonzero(contains)[0])
