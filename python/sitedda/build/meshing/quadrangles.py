# SPDX-License-Identifier: GPL-3.0-or-later
"""Divide shapes with four corners along their sides."""

import numpy as np
import shapely

from ..cutting.network import cross_product
from .graphs import Graph, count_cells

_STRAIGHT = 1e-9  # largest sine of the turn at a point of a straight side
_SHARPEST = np.radians(40.0)  # sharpest corner of a shape that is divided along its sides
_UNEVEN = 2.0  # largest ratio of the lengths of opposite sides


def divide_quadrangle(shape, size: float) -> Graph | None:
    """Return a graph of lines between opposite sides of a quadrangle; None for other shapes."""
    if len(shape.interiors):
        return None
    ring = shapely.get_coordinates(shape.exterior)[:-1]
    leaving, arriving = np.roll(ring, -1, axis=0) - ring, ring - np.roll(ring, 1, axis=0)
    cross = cross_product(arriving, leaving)
    lengths = np.hypot(*arriving.T) * np.hypot(*leaving.T)
    turning = abs(cross) > _STRAIGHT * lengths
    if turning.sum() != 4:
        return None
    corners = ring[turning]
    with np.errstate(over="ignore"):  # a size near zero is refused below
        lowest = int(np.lexsort(np.round(corners / size, 6).T)[0])
    corners = np.roll(corners, -lowest, axis=0)
    sides = np.roll(corners, -1, axis=0) - corners
    length = np.hypot(*sides.T)
    sine = cross_product(sides, np.roll(sides, -1, axis=0))
    if min(sine / (length * np.roll(length, -1))) < np.sin(_SHARPEST):
        return None
    if max(length[:2] / length[2:]) > _UNEVEN or min(length[:2] / length[2:]) < 1 / _UNEVEN:
        return None
    counts = count_cells(np.maximum(length[:2], length[2:]), size)
    u, v = (np.linspace(0.0, 1.0, count + 1) for count in counts)
    u, v = (grid.ravel()[:, None] for grid in np.meshgrid(u, v, indexing="ij"))
    a, b, c, d = corners
    nodes = (1 - v) * ((1 - u) * a + u * b) + v * ((1 - u) * d + u * c)
    number = np.arange(len(nodes)).reshape(counts + 1)
    upward = np.column_stack([number[:-1].ravel(), number[1:].ravel()])
    transverse = np.column_stack([number[:, :-1].ravel(), number[:, 1:].ravel()])
    return Graph(nodes, np.concatenate([upward, transverse]), np.full(len(nodes), size))
