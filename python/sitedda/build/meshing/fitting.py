# SPDX-License-Identifier: GPL-3.0-or-later
"""Move nodes near outlines onto the outlines, which avoids small cells."""

import numpy as np
import shapely
from scipy.spatial import cKDTree

from ..cutting.network import cross_product
from .graphs import Graph

_SHARP = np.radians(19.5)  # smallest turn of an outline at a sharp corner
_LEVEL = 1e-6  # difference of distances that are treated as equal / local size


def fit_to_outlines(graph: Graph, rings, corner_share: float, line_share: float) -> Graph:
    """Move the nodes of a graph near outlines onto their corners and sides.

    `rings`: shape (corners, 2); outlines, m; the first corner is not repeated.
    `corner_share`, `line_share`: largest distance from which a node is moved to a sharp corner, and
    to another corner or a side, over the local size.  The nearest node is moved to a corner, and it
    is moved to its nearest corner.
    """
    nodes = graph.nodes.copy()
    corners = np.concatenate(rings)
    sharp = np.concatenate([_turning_angles(ring) for ring in rings]) > _SHARP
    distance, node = cKDTree(nodes).query(corners)
    reach = np.where(sharp, corner_share, line_share) * graph.local[node]
    level = np.round(distance / (_LEVEL * graph.local[node]))
    order = np.lexsort((level, ~sharp, node))
    order = order[(distance <= reach)[order]]
    _, firsts = np.unique(node[order], return_index=True)
    nearest = order[firsts]
    nodes[node[nearest]] = corners[nearest]
    is_free = np.ones(len(nodes), dtype=bool)
    is_free[node[nearest]] = False
    sides = shapely.linestrings(
        np.concatenate([np.stack([ring, np.roll(ring, -1, axis=0)], axis=1) for ring in rings])
    )
    loose = np.flatnonzero(is_free)
    points = shapely.points(nodes[loose])
    tree = shapely.STRtree(sides)
    hits, side = tree.query(points, predicate="dwithin", distance=line_share * graph.local[loose])
    gap = shapely.distance(points[hits], sides[side])
    order = np.lexsort((side, np.round(gap / (_LEVEL * graph.local[loose[hits]])), hits))
    _, firsts = np.unique(hits[order], return_index=True)
    hits, side = hits[order][firsts], side[order][firsts]
    along = shapely.line_locate_point(sides[side], points[hits])
    foot = shapely.line_interpolate_point(sides[side], along)
    nodes[loose[hits]] = shapely.get_coordinates(foot)
    return Graph(nodes, graph.edges, graph.local)


def _turning_angles(ring) -> np.ndarray:
    """Return the turning angle of an outline at each corner, rad, shape (corners,)."""
    leaving, arriving = np.roll(ring, -1, axis=0) - ring, ring - np.roll(ring, 1, axis=0)
    cross = cross_product(arriving, leaving)
    return abs(np.arctan2(cross, (arriving * leaving).sum(axis=1)))
