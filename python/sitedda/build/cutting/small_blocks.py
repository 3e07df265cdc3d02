# SPDX-License-Identifier: GPL-3.0-or-later
"""Find blocks that are too small or too thin for the computation."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...base.numbers import counted
from .rings import Rings

_AREA = 1e-4  # smallest area / median area of the blocks
_EDGE = 1e-4  # shortest edge / square root of the median area
_ANGLE = 0.5  # degrees
_NAMED = 5  # largest number of slivers in a message


@dataclass(frozen=True)
class Sliver:
    """A block that is too small or too thin."""

    index: int  # index of the block, from 0
    name: str
    place: tuple[float, float]  # a point in the block, m
    reason: str  # area, edge or angle that is too small, in words

    def __str__(self) -> str:
        """Return name, position and reason in one line."""
        name = f"block {self.index + 1} {self.name}".rstrip()
        return f"{name} at ({self.place[0]:.6g}, {self.place[1]:.6g}): {self.reason}"


def in_words(slivers: Sequence) -> str:
    """Return the number of slivers and the descriptions of the first; blank if there are none."""
    if not slivers:
        return ""
    dots = " …" if len(slivers) > _NAMED else ""
    head = counted(len(slivers), "block is a sliver", "blocks are slivers")
    return f"{head}: {'; '.join(map(str, slivers[:_NAMED]))}{dots}"


def slivers(
    polygons: Sequence,
    names: Sequence[str] | None = None,
    *,
    least_area: float | None = None,
    least_edge: float | None = None,
    least_angle: float = _ANGLE,
) -> list[Sliver]:
    """Return the blocks of a model that are too small or too thin for the computation.

    Parameters
    ----------
    polygons : sequence of array_like, shape (n, 2)
        m, counter-clockwise.
    least_area : float
        Smallest area, m² (1e-4 of the median area).
    least_edge : float
        Shortest edge, m (1e-4 of the square root of the median area).
    least_angle : float
        Smallest angle of a corner, degrees.
    """
    if not len(polygons):
        return []
    rings = Rings.of(polygons)
    area, edge, angle = rings.areas(), rings.shortest_edges(), rings.sharpest_corners()
    usual = float(np.median(area))
    least_area = _AREA * usual if least_area is None else least_area
    least_edge = _EDGE * np.sqrt(usual) if least_edge is None else least_edge
    result = []
    for i in np.flatnonzero((area < least_area) | (edge < least_edge) | (angle < least_angle)):
        reasons = []
        if area[i] < least_area:
            reasons.append(f"area {area[i]:.3g} m² is below {least_area:.3g} m²")
        if edge[i] < least_edge:
            reasons.append(f"an edge of {edge[i]:.3g} m is below {least_edge:.3g} m")
        if angle[i] < least_angle:
            reasons.append(f"a corner of {angle[i]:.3g}° is below {least_angle:.3g}°")
        centre = tuple(np.mean(polygons[i], axis=0).tolist())
        result.append(Sliver(int(i), names[i] if names else "", centre, ", ".join(reasons)))
    return result
