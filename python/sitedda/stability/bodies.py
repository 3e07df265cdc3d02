# SPDX-License-Identifier: GPL-3.0-or-later
"""Bodies as stability sees them: the cells of one count as one block."""

from collections.abc import Sequence

import numpy as np

from ..build.cutting.rings import Rings


class Bodies:
    """Blocks, and bodies of cells in their place.

    Parameters
    ----------
    polygons : sequence of ndarray, shape (vertices, 2)
        Of all blocks, m.
    body : ndarray of int, shape (blocks,)
        Number of the body that each is a cell of; 0: none.
    names : sequence of str
        Of all blocks.

    Attributes
    ----------
    of : ndarray of int, shape (blocks,)
        Which of them each block is, or is part of.
    names : tuple of str
    radii : ndarray, shape (bodies,)
        Farthest vertex from the mean of all vertices, m.
    """

    def __init__(self, polygons: Sequence[np.ndarray], body: np.ndarray, names: Sequence[str]):
        self._polygons, self._alone = list(polygons), not np.any(body)
        own = np.where(body > 0, -body, np.arange(1, len(body) + 1))
        _, first, inverse = np.unique(own, return_index=True, return_inverse=True)
        rank = np.empty(len(first), dtype=int)
        rank[np.argsort(first)] = np.arange(len(first))
        self.of = rank[inverse.ravel()]
        self.names = tuple(names[i] for i in np.sort(first))
        corners = [np.concatenate([polygons[i] for i in cells]) for cells in self._members()]
        self.radii = np.array([np.linalg.norm(p - p.mean(0), axis=1).max() for p in corners])

    def _members(self) -> list[np.ndarray]:
        """Numbers of the blocks of each body."""
        order = np.argsort(self.of, kind="stable")
        return np.split(order, np.flatnonzero(np.diff(self.of[order])) + 1)

    def mean(self, values: np.ndarray) -> np.ndarray:
        """Means over the area of each body, of values of its blocks, shape (bodies, …)."""
        if self._alone:
            return values
        areas = Rings.of(self._polygons).areas()
        total = np.zeros((len(self.radii), *values.shape[1:]))
        np.add.at(total, self.of, values * areas[:, None])
        return total / np.bincount(self.of, areas)[:, None]

    def outlines(self) -> list[np.ndarray]:
        """Polygons of the blocks and outer outlines of the bodies, shape (vertices, 2), m."""
        if self._alone:
            return self._polygons
        import shapely

        outlines = []
        for cells in self._members():
            if len(cells) == 1:
                outlines.append(self._polygons[cells[0]])
                continue
            grid = 1e-9 * float(self.radii[self.of[cells[0]]])
            whole = shapely.union_all(
                [shapely.Polygon(self._polygons[i]) for i in cells], grid_size=grid
            )
            outlines.append(np.array(whole.exterior.coords)[:-1])
        return outlines
