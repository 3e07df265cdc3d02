# SPDX-License-Identifier: GPL-3.0-or-later
"""Many polygons, stored as one array of corners and the indices of first corners."""

from collections.abc import Sequence

import numpy as np

# Tolerances as fractions of the size of all polygons:
_STRAIGHT = 1e-13  # distance of omitted corners from a straight line
_LEVEL = 1e-9  # difference of height of corners that are treated as equally low
_ORDER = 1e-6  # difference of centroids that are treated as equal in the order of polygons


class Rings:
    """Polygons, counter-clockwise."""

    corners: np.ndarray  # of all polygons, shape (corners, 2), m
    first: np.ndarray  # index of the first corner of each polygon, then the number of corners
    after: np.ndarray  # index of the next corner within the polygon

    def __init__(self, corners, lengths):
        self.corners = corners
        self.first = np.concatenate([[0], np.cumsum(lengths, dtype=int)])
        count = np.arange(len(corners))
        self.after, self._before = count + 1, count - 1
        self.after[self.first[1:] - 1] = self.first[:-1]
        self._before[self.first[:-1]] = self.first[1:] - 1

    @classmethod
    def of(cls, polygons: Sequence) -> "Rings":
        """Create rings from a list of arrays, shape (n, 2)."""
        arrays = [np.asarray(polygon, dtype=float) for polygon in polygons]
        return cls(np.concatenate(arrays), [len(array) for array in arrays])

    @property
    def owner(self) -> np.ndarray:
        """Return the polygon of each corner."""
        return np.repeat(np.arange(len(self.first) - 1), np.diff(self.first))

    def _sum_per_polygon(self, values) -> np.ndarray:
        """Return the sums of values of corners over each polygon, shape (polygons,)."""
        return np.add.reduceat(values, self.first[:-1])

    def _relative_corners(self):
        """Return corners relative to the first of their polygon, next corners, cross products."""
        corners = self.corners - self.corners[self.first[:-1]][self.owner]
        following = corners[self.after]
        return corners, following, corners[:, 0] * following[:, 1] - corners[:, 1] * following[:, 0]

    def areas(self) -> np.ndarray:
        """Return the area of each polygon, m²."""
        return 0.5 * self._sum_per_polygon(self._relative_corners()[2])

    def centroids(self) -> np.ndarray:
        """Return the centroids, shape (polygons, 2), m."""
        corners, following, cross = self._relative_corners()
        moments = np.column_stack(
            [self._sum_per_polygon(cross * (corners + following)[:, k]) for k in (0, 1)]
        )
        return self.corners[self.first[:-1]] + moments / (3 * self._sum_per_polygon(cross)[:, None])

    def edge_lengths(self) -> np.ndarray:
        """Return the length of the edge that begins at each corner, m."""
        return np.hypot(*(self.corners[self.after] - self.corners).T)

    def shortest_edges(self) -> np.ndarray:
        """Return the length of the shortest edge of each polygon, m."""
        return np.minimum.reduceat(self.edge_lengths(), self.first[:-1])

    def sharpest_corners(self) -> np.ndarray:
        """Return the angle of the sharpest corner of each polygon, degrees."""
        leaving = self.corners[self.after] - self.corners
        arriving = leaving[self._before]
        sine = arriving[:, 0] * leaving[:, 1] - arriving[:, 1] * leaving[:, 0]
        inner = np.pi - np.arctan2(sine, (arriving * leaving).sum(axis=1))
        return np.degrees(np.minimum.reduceat(inner, self.first[:-1]))

    def straight(self, distance: float) -> np.ndarray:
        """Return which corners lie within a distance (m) of the line between their neighbours."""
        chord = self.corners[self.after] - self.corners[self._before]
        arm = self.corners - self.corners[self._before]
        offset = abs(chord[:, 0] * arm[:, 1] - chord[:, 1] * arm[:, 0])
        return offset <= distance * np.hypot(*chord.T)

    def in_order(self, labels, size: float, rounding: float):
        """Return polygons in an order that does not depend on the order of the input.

        The result: rings without straight corners between edges of equal `labels`; corners, with
        the lowest first in each polygon; labels of these corners; order of the polygons.
        """
        keep = ~self.straight(max(_STRAIGHT * size, rounding)) | (labels != labels[self._before])
        rings = Rings(self.corners[keep], np.add.reduceat(keep, self.first[:-1], dtype=int))
        order_of_corners = rings.from_lowest(max(_LEVEL * size, rounding))
        order = np.lexsort(np.round(rings.centroids() / (_ORDER * size)).T)
        return rings, order_of_corners, labels[keep][order_of_corners], order

    def from_lowest(self, distance: float) -> np.ndarray:
        """Return an order of corners in which each polygon begins with its lowest, leftmost corner.

        Corners whose heights differ by less than about `distance` (m) are equally low.
        """
        owner = self.owner
        x, y = np.round(self.corners / distance).T
        lowest = np.lexsort((x, y, owner))[self.first[:-1]]
        length = np.diff(self.first)[owner]
        shift = (lowest - self.first[:-1])[owner]
        rank = np.arange(len(owner)) - self.first[:-1][owner]
        return self.first[:-1][owner] + (rank + shift) % length
