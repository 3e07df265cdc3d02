# SPDX-License-Identifier: GPL-3.0-or-later
"""Elastic bodies of welded cells, assembled independently of the engine, to test meshes.

A cell moves linearly: displacement of its centroid, rotation, three strains.  The strain of a face
is the mean of the distributional strain over the two triangles between the face and the centroids;
the rest of a cell has the strain of the cell.  Jumps of the displacement across faces have an
energy, from their mean and from their linear part.
"""

from dataclasses import dataclass

import numpy as np
import shapely
from scipy.sparse import coo_array

from sitedda.cutting.rings import Rings

MEAN_JUMP = 0.5  # p_m


@dataclass
class Faces:
    """Common parts of edges: cells, ends (k, 2), unit normal from the first cell to the second."""

    first: np.ndarray
    second: np.ndarray
    start: np.ndarray
    end: np.ndarray
    normal: np.ndarray
    edge: np.ndarray  # edges of both cells, by the corner where each begins

    @property
    def length(self):
        return np.hypot(*(self.end - self.start).T)


def faces_of(polygons, near=1e-7):
    """Return the faces of cells, each once, with a tolerance over their mean size."""
    rings = Rings.of(polygons)
    corners, after, owner = rings.corners, rings.corners[rings.after], rings.owner
    reach = near * np.sqrt(rings.areas().mean())
    lines = shapely.linestrings(np.stack([corners, after], axis=1))
    a, b = shapely.STRtree(lines).query(lines, predicate="dwithin", distance=reach)
    a, b = (v[owner[a] < owner[b]] for v in (a, b))
    length = np.hypot(*(after - corners)[a].T)
    along = (after - corners)[a] / length[:, None]
    normal = np.column_stack([along[:, 1], -along[:, 0]])
    off = [abs(((points[b] - corners[a]) * normal).sum(axis=1)) for points in (corners, after)]
    low = np.maximum(0.0, ((after[b] - corners[a]) * along).sum(axis=1))
    high = np.minimum(length, ((corners[b] - corners[a]) * along).sum(axis=1))
    good = (np.maximum(*off) < reach) & (high - low > reach)
    a, b, low, high, along, normal = (v[good] for v in (a, b, low, high, along, normal))
    start = corners[a] + low[:, None] * along
    end = corners[a] + high[:, None] * along
    return Faces(owner[a], owner[b], start, end, normal, np.column_stack([a, b]))


def displacement_operator(points, centres):
    """Return the displacement operator of cells with these centroids, shape (k, 2, 6)."""
    x, y = (points - centres).T
    one, zero = np.ones_like(x), np.zeros_like(x)
    rows = [[one, zero, -y, x, zero, 0.5 * y], [zero, one, x, zero, y, 0.5 * x]]
    return np.moveaxis(np.array(rows), -1, 0)


def elasticity(young, poisson, plane_strain):
    """Return the matrix from strains ε_x, ε_y, γ to stresses, shape (3, 3), and the modulus E′."""
    if plane_strain:
        young, poisson = young / (1 - poisson**2), poisson / (1 - poisson)
    factor = young / (1 - poisson**2)
    matrix = [[1, poisson, 0], [poisson, 1, 0], [0, 0, (1 - poisson) / 2]]
    return factor * np.array(matrix), young


class Body:
    """Stiffness and mass of a body of cells of one material.

    Parameters
    ----------
    polygons : list of ndarray
    young, poisson, density : float
    plane_strain : bool
    """

    def __init__(self, polygons, young=1.0, poisson=0.25, density=1.0, plane_strain=True):
        self.polygons = polygons
        rings = Rings.of(polygons)
        self.areas, self.centres = rings.areas(), rings.centroids()
        self.faces, self.density = faces_of(polygons), density
        self.matrix, self.modulus = elasticity(young, poisson, plane_strain)
        self.shear = self.matrix[2, 2]
        self._set_points()

    def _set_points(self):
        """Set the operators of faces on the twelve unknowns of their cells."""
        f = self.faces
        length = f.length
        pair = np.stack([f.first, f.second])
        height = [abs(((self.centres[c] - f.start) * f.normal).sum(axis=1)) for c in pair]
        part = 0.5 * length * np.array(height)
        self.point_areas = part.sum(axis=0)
        at = [[displacement_operator(p, self.centres[c]) for c in pair] for p in (f.start, f.end)]
        jump = [np.concatenate([one, -other], axis=2) for one, other in at]
        mean, linear = 0.5 * (jump[0] + jump[1]), 0.5 * (jump[1] - jump[0])
        own = np.zeros((len(length), 3, 12))
        for k, fraction in enumerate(part / self.point_areas):
            own[:, [0, 1, 2], [6 * k + 3, 6 * k + 4, 6 * k + 5]] = fraction[:, None]
        x, y = f.normal.T
        zero = np.zeros_like(x)
        across = np.moveaxis(np.array([[x, zero], [zero, y], [y, x]]), -1, 0)
        strain = own - (length / self.point_areas)[:, None, None] * (across @ mean)
        self.strain, self.mean, self.linear = strain, mean, linear
        self.rest = self.areas.copy()
        for c, area in zip(pair, part, strict=True):
            np.subtract.at(self.rest, c, area)

    def stiffness(self):
        """Return the sparse stiffness matrix, shape (6 cells, 6 cells)."""
        f = self.faces
        over = f.length / (2 * self.point_areas / f.length)
        blocks = np.einsum(
            "kai,ab,kbj,k->kij", self.strain, self.matrix, self.strain, self.point_areas
        )
        blocks += (
            2 * MEAN_JUMP * self.shear * np.einsum("kai,kaj,k->kij", self.mean, self.mean, over)
        )
        blocks += self.modulus / 3 * np.einsum("kai,kaj,k->kij", self.linear, self.linear, over)
        index = np.concatenate(
            [6 * f.first[:, None] + np.arange(6), 6 * f.second[:, None] + np.arange(6)], axis=1
        )
        rows, columns = np.broadcast_arrays(index[:, :, None], index[:, None, :])
        own = 6 * np.arange(len(self.areas))[:, None] + [3, 4, 5]
        more_rows, more_columns = np.broadcast_arrays(own[:, :, None], own[:, None, :])
        values = self.rest[:, None, None] * self.matrix
        entries = [np.concatenate([one.ravel(), other.ravel()]) for one, other in
                   ((blocks, values), (rows, more_rows), (columns, more_columns))]  # fmt: skip
        count = 6 * len(self.areas)
        return coo_array((entries[0], (entries[1], entries[2])), shape=(count, count)).tocsc()

    def mass(self):
        """Return the sparse mass matrix, shape (6 cells, 6 cells), exact for linear motion."""
        blocks = np.zeros((len(self.areas), 6, 6))
        for i, corners in enumerate(self.polygons):
            corners_of_cell = corners - self.centres[i]
            after = np.roll(corners_of_cell, -1, axis=0)
            double = corners_of_cell[:, 0] * after[:, 1] - corners_of_cell[:, 1] * after[:, 0]
            middles = [
                0.5 * corners_of_cell,
                0.5 * after,
                0.5 * (corners_of_cell + after),
            ]  # exact for squares
            for points in middles:
                shape = displacement_operator(points, 0.0)
                blocks[i] += np.einsum("kai,kaj,k->ij", shape, shape, double / 6)
        index = 6 * np.arange(len(blocks))[:, None] + np.arange(6)
        rows, columns = np.broadcast_arrays(index[:, :, None], index[:, None, :])
        count = 6 * len(blocks)
        entries = (self.density * blocks.ravel(), (rows.ravel(), columns.ravel()))
        return coo_array(entries, shape=(count, count)).tocsc()

    def linear_field(self, gradient):
        """Return the unknowns of cells in a displacement gradient (2, 2) about the origin."""
        move = self.centres @ gradient.T
        rotations = np.full(len(move), 0.5 * (gradient[1, 0] - gradient[0, 1]))
        strains = [gradient[0, 0], gradient[1, 1], gradient[0, 1] + gradient[1, 0]]
        return np.column_stack([move, rotations, np.tile(strains, (len(move), 1))])

    def free_edges(self):
        """Return cells, ends (k, 2) and outward normals of the edges without a face."""
        rings = Rings.of(self.polygons)
        count = np.bincount(self.faces.edge.ravel(), minlength=len(rings.corners))
        free = count == 0
        start, end = rings.corners[free], rings.corners[rings.after][free]
        along = (end - start) / np.hypot(*(end - start).T)[:, None]
        return rings.owner[free], start, end, np.column_stack([along[:, 1], -along[:, 0]])
