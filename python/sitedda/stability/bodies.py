# SPDX-License-Identifier: GPL-3.0-or-later
"""Bodies in the analysis of stability: all cells of a body count as one block."""

from collections.abc import Sequence

import numpy as np

from ..base.errors import InputError
from ..build.cutting.rings import Rings

_ON_EDGE = 1e-6  # largest distance of a point from its block / size of the model


def block_at(polygons: Sequence[np.ndarray], names: Sequence[str], point, name: str) -> int:
    """Return the index of the block with a name or number, or else at a position (m)."""
    import shapely

    named = [i for i, other in enumerate(names) if other == name]
    if len(named) == 1:
        return named[0]
    if name.isdigit() and not named:
        return int(name) - 1
    size = np.ptp(np.concatenate(polygons), axis=0).max()
    for i in named or range(len(polygons)):  # several blocks may have this name
        if shapely.distance(shapely.Polygon(polygons[i]), shapely.Point(point)) <= _ON_EDGE * size:
            return i
    raise InputError(f"no block is at ({point[0]:g}, {point[1]:g})")


class Bodies:
    """The bodies of a model: bodies composed of cells, and all other blocks as single bodies."""

    of: np.ndarray  # index of the body to which each block belongs
    names: tuple[str, ...]  # of the bodies
    radii: np.ndarray  # largest distance of a vertex from the mean of all vertices of a body, m

    def __init__(self, polygons: Sequence[np.ndarray], body: np.ndarray, names: Sequence[str]):
        """Find the bodies of blocks; `body` is the number of the body of each cell, otherwise 0."""
        self._polygons, self._alone = list(polygons), not np.any(body)
        label = np.where(body > 0, -body, np.arange(1, len(body) + 1))
        _, firsts, inverse = np.unique(label, return_index=True, return_inverse=True)
        rank = np.empty(len(firsts), dtype=int)
        rank[np.argsort(firsts)] = np.arange(len(firsts))
        self.of = rank[inverse.ravel()]
        self.names = tuple(names[i] for i in np.sort(firsts))
        corners = [np.concatenate([polygons[i] for i in cells]) for cells in self._blocks_by_body()]
        self.radii = np.array([np.linalg.norm(p - p.mean(0), axis=1).max() for p in corners])

    def _blocks_by_body(self) -> list[np.ndarray]:
        """Return the indices of the blocks of each body."""
        order = np.argsort(self.of, kind="stable")
        return np.split(order, np.flatnonzero(np.diff(self.of[order])) + 1)

    def mean(self, values: np.ndarray) -> np.ndarray:
        """Return values of blocks, averaged over the area of each body, shape (bodies, …)."""
        if self._alone:
            return values
        areas = Rings.of(self._polygons).areas()
        total = np.zeros((len(self.radii), *values.shape[1:]))
        np.add.at(total, self.of, values * areas[:, None])
        return total / np.bincount(self.of, areas)[:, None]

    def outlines(self) -> list[np.ndarray]:
        """Return the outer outline of each body, shape (vertices, 2), m."""
        if self._alone:
            return self._polygons
        import shapely

        outlines = []
        for cells in self._blocks_by_body():
            if len(cells) == 1:
                outlines.append(self._polygons[cells[0]])
                continue
            grid = 1e-9 * float(self.radii[self.of[cells[0]]])
            polygons = [shapely.Polygon(self._polygons[i]) for i in cells]
            union = shapely.union_all(polygons, grid_size=grid)
            outlines.append(np.array(union.exterior.coords)[:-1])
        return outlines
