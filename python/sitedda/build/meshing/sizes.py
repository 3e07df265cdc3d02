# SPDX-License-Identifier: GPL-3.0-or-later
"""Target sizes of cells as a function of position."""

from collections.abc import Sequence

import numpy as np
import shapely

_GROWTH = 0.25  # increase of the cell size per distance from smaller cells


class Sizes:
    """The target size of the cells of a body.

    `sizes`: size in each part, m.
    `fine`: geometries near which cells have `fine_size`.
    `fine_size`: m.
    """

    def __init__(
        self,
        parts: Sequence,
        sizes: Sequence[float],
        fine: Sequence = (),
        fine_size: float | None = None,
    ):
        self.largest, self.smallest = max(sizes), min([*sizes, *([fine_size] if fine else [])])
        # A part with the largest size does not limit the size elsewhere.
        self._near = [
            (part, size) for part, size in zip(parts, sizes, strict=True) if size < self.largest
        ]
        self._near += [(shape, fine_size) for shape in fine]

    @property
    def varies(self) -> bool:
        """Return whether the target size depends on position."""
        return bool(self._near)

    def bound(self, shape, size: float) -> None:
        """Limit the size of cells (m) beside a shape."""
        if size < self.largest:
            self._near.append((shape, size))
            self.smallest = min(self.smallest, size)

    def at(self, positions) -> np.ndarray:
        """Return the target size (m), shape (n,), at positions, shape (n, 2)."""
        result = np.full(len(positions), self.largest)
        points = shapely.points(positions) if self._near else None
        for shape, size in self._near:
            shapely.prepare(shape)
            result = np.minimum(result, size + _GROWTH * shapely.distance(points, shape))
        return result
