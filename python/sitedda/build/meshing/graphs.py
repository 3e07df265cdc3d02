# SPDX-License-Identifier: GPL-3.0-or-later
"""Plane graphs whose faces become cells: squares of several sizes, or regular polygons."""

from dataclasses import dataclass

import numpy as np
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import Voronoi

from ...base.errors import InputError
from ..cutting.distributions import uniform
from .sizes import Sizes

_FIT = 1e-6  # tolerance of a length in cells, so that rounding errors add no cell
_SPLIT = 1.2  # largest size of an undivided square / target size
_JITTER = 0.25  # largest offset of a seed from the middle of its square / side
_RELAXATIONS = 12
_SHORT = 0.15  # shortest side of a polygon / local size; shorter sides are removed
MOST_CELLS = 1_000_000
_FINEST = 2**29  # largest ratio of body to smallest square; positions are 32-bit integers


@dataclass
class Graph:
    """Nodes and straight edges without crossings."""

    nodes: np.ndarray  # shape (nodes, 2), m
    edges: np.ndarray  # nodes at both ends, shape (edges, 2)
    local: np.ndarray  # size of the cells at each node, m


def count_cells(lengths: np.ndarray, size: float) -> np.ndarray:
    """Return the numbers of cells of a size (m) along two lengths (m); reject too many cells."""
    with np.errstate(over="ignore"):
        counts = np.maximum(1.0, np.ceil(lengths / size - _FIT))
        cells = counts.prod()
    if cells > MOST_CELLS:
        raise InputError(
            f"a cell size of {size:g} m would give about {cells:.2g} cells, more than "
            f"{MOST_CELLS}; choose a larger size"
        )
    return counts.astype(int)


def _quadtree_squares(low, high, sizes: Sizes, rotation, shape):
    """Return the squares of a quadtree over a box, and the unit of their corners and sides (m).

    A square is divided by four until it has the target size at its middle.  Sizes grow so slowly
    with the distance that neighbours differ at most by a factor of two.
    """
    count = count_cells(high - low, sizes.largest)
    if count.max() * sizes.largest > _FINEST * sizes.smallest:
        raise InputError(
            f"the cell size {sizes.smallest:g} m is less than {1 / _FINEST:.0e} of the body size; "
            "choose a larger cell size"
        )
    depth = max(0, int(np.ceil(np.log2(sizes.largest / sizes.smallest)))) + 1
    unit = (high - low) / count / 2**depth
    corner = np.stack(np.meshgrid(*map(np.arange, count), indexing="ij"), -1).reshape(-1, 2)
    corner, side, leaves = corner * 2**depth, 2**depth, []
    while len(corner):
        middle = (low + (corner + side / 2) * unit) @ rotation
        boxes = shapely.points(middle)
        mask = shapely.dwithin(boxes, shape, side * np.hypot(*unit))
        corner, middle = corner[mask], middle[mask]
        split = (side * unit.max() > _SPLIT * sizes.at(middle)) & (side > 1)
        leaves.append(np.column_stack([corner[~split], np.full((~split).sum(), side)]))
        side //= 2
        steps = side * np.array([[0, 0], [1, 0], [0, 1], [1, 1]])
        corner = (corner[split][:, None] + steps).reshape(-1, 2)
        if 4 * len(corner) > MOST_CELLS:
            raise InputError(f"there would be more than {MOST_CELLS} cells; choose larger cells")
    return np.concatenate(leaves), unit


def squares(shape, sizes: Sizes, angle: float) -> Graph:
    """Return a graph of squares over a shape, with sides at an angle (rad) to the axes."""
    rotation = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    rotated = shapely.get_coordinates(shape) @ rotation.T
    low, high = rotated.min(axis=0), rotated.max(axis=0)
    leaves, unit = _quadtree_squares(low, high, sizes, rotation, shape)
    around = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    corners = leaves[:, None, :2] + leaves[:, None, 2:] * around
    keys = corners @ np.array([2**32, 1])
    nodes, index = np.unique(keys, return_inverse=True)
    index = index.reshape(keys.shape)
    local = np.full(len(nodes), np.inf)
    np.minimum.at(local, index, (leaves[:, 2:] * unit.max()) + np.zeros((1, 4)))
    # A side next to smaller squares becomes two edges.
    following = np.roll(index, -1, axis=1)
    middle = ((corners + np.roll(corners, -1, axis=1)) // 2) @ np.array([2**32, 1])
    position = np.minimum(np.searchsorted(nodes, middle), len(nodes) - 1)
    halved = (nodes[position] == middle) & (leaves[:, 2:] > 1)
    ends = [(index, following, ~halved), (index, position, halved), (position, following, halved)]
    edges = np.concatenate([np.column_stack([a[mask], b[mask]]) for a, b, mask in ends])
    grid = np.column_stack(np.divmod(nodes, 2**32))
    edges = np.unique(np.sort(edges, axis=1), axis=0)
    return Graph((low + grid * unit) @ rotation, edges, local)


# --- Polygons ------------------------------------------------------------------------------------


def polygons(shape, sizes: Sizes, seed: int) -> Graph:
    """Return a graph of polygons over a shape: a Voronoi diagram with relaxed seeds."""
    low, high = np.reshape(shape.bounds, (2, 2))
    leaves, unit = _quadtree_squares(low, high, sizes, np.eye(2), shape)
    jitter = uniform(seed, (11,), 2 * len(leaves)).reshape(-1, 2) - 0.5
    seeds = low + (leaves[:, :2] + leaves[:, 2:] * (0.5 + 2 * _JITTER * jitter)) * unit
    mask = shapely.contains_xy(shape, *seeds.T)
    seeds = seeds[mask] if mask.any() else shape.representative_point().coords[:]
    shapely.prepare(shape)
    seeds = np.array(seeds, dtype=float)
    for _ in range(_RELAXATIONS if len(seeds) > 1 else 0):
        seeds = _relax_seeds(seeds, shape, sizes)
    diagram = _voronoi_diagram(seeds, shape)
    sides = np.array(diagram.ridge_vertices)
    sides = sides[(sides >= 0).all(axis=1)]
    return _without_short_sides(diagram.vertices, sides, sizes)


def _voronoi_diagram(seeds, shape) -> Voronoi:
    """Return the Voronoi diagram of seeds and of four distant seeds, which bound it."""
    x, y = np.reshape(shape.bounds, (2, 2)).mean(axis=0)
    distance = 20 * shapely.length(shapely.envelope(shape))
    frame = [[x - distance, y], [x + distance, y], [x, y - distance], [x, y + distance]]
    return Voronoi(np.concatenate([seeds, frame]))


def _relax_seeds(seeds, shape, sizes: Sizes) -> np.ndarray:
    """Return seeds moved to the centroids of their cells, then towards smaller cells."""
    diagram = _voronoi_diagram(seeds, shape)
    regions = [diagram.regions[i] for i in diagram.point_region[: len(seeds)]]
    owner = np.repeat(np.arange(len(seeds)), [len(region) for region in regions])
    corners = diagram.vertices[np.concatenate(regions)]
    cells = shapely.convex_hull(shapely.multipoints(corners, indices=owner))
    crossing = ~shapely.contains_properly(shape, cells)
    cells[crossing] = shapely.intersection(cells[crossing], shape)
    centres = shapely.get_coordinates(shapely.centroid(cells))
    # A clipped cell may have two parts and its centroid outside both; its seed is not moved.
    valid = (shapely.get_type_id(cells) == 3) & shapely.contains_xy(shape, *centres.T)
    centres[~valid] = seeds[~valid]
    if sizes.smallest < sizes.largest:  # move seeds towards smaller cells
        middle = sizes.at(centres)
        step = 0.1 * middle
        arms = [step[:, None] * axis for axis in np.eye(2)]
        rises = [sizes.at(centres + arm) - sizes.at(centres - arm) for arm in arms]
        slope = np.column_stack(rises) / (2 * step[:, None])
        shifted = centres - slope * middle[:, None] / 6
        mask = shapely.contains_xy(shape, *shifted.T)
        centres[mask] = shifted[mask]
    return centres


def _without_short_sides(vertices, sides, sizes: Sizes) -> Graph:
    """Return a graph in which the ends of short sides are merged."""
    nodes_used, index = np.unique(sides, return_inverse=True)
    nodes, sides = vertices[nodes_used], index.reshape(-1, 2)
    local = sizes.at(nodes)
    length = np.hypot(*(nodes[sides[:, 1]] - nodes[sides[:, 0]]).T)
    short = sides[length < _SHORT * local[sides].min(axis=1)]
    links = coo_array((np.ones(len(short)), short.T), shape=(len(nodes),) * 2)
    groups, group = connected_components(links, directed=False)
    weight = np.bincount(group, minlength=groups)
    positions = np.column_stack([np.bincount(group, xy, groups) / weight for xy in nodes.T])
    edges = np.sort(group[sides], axis=1)
    edges = np.unique(edges[edges[:, 0] != edges[:, 1]], axis=0)
    return Graph(positions, edges, sizes.at(positions))
