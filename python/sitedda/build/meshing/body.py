# SPDX-License-Identifier: GPL-3.0-or-later
"""Divide a body of one or several parts into convex cells."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from ...base.arrays import parts_of
from ...base.errors import InputError
from ..cutting.blocks import face_polygons, segments_of
from ..cutting.network import (
    CORNER,
    CROSSING,
    Network,
    merge_close_nodes,
    split_network,
    trace_faces,
    without_dead_ends,
)
from ..cutting.rings import Rings
from .cells import Cells
from .fitting import fit_to_outlines
from .graphs import Graph, polygons, squares
from .quadrangles import divide_quadrangle
from .sizes import Sizes

_ROUNDING = 1e-9  # tolerance of positions / size of a body
_BITS = 8  # rounding error of coordinates far from (0, 0), in units in the last place
_CLOSE = 0.1  # distance of merged nodes as fraction of the smallest cell size
_HOLE = 0.5  # largest size of cells beside a hole / width of the hole
_SHORTEST, _LONGEST = 0.05, 1.6  # lengths of faces without a note, as fractions of the local size
# Distances within which nodes move onto corners and sides / local size, see `fit_to_outlines`.
_CORNER_REACH = {"quadrilateral": 0.75, "voronoi": 0.25}
_LINE_REACH = {"quadrilateral": 0.3, "voronoi": 0.2}


@dataclass
class Part:
    """A polygon of one material in a body."""

    outline: np.ndarray  # corners, shape (n, 2), m, counter-clockwise
    joints: Sequence[str]  # joint of each edge of the outline
    size: float  # size of the cells, m
    # Outlines of holes, of either orientation, and the joint of each edge
    holes: list = field(default_factory=list)

    @property
    def rings(self) -> list:
        """Return outline and holes with their joints."""
        return [(self.outline, self.joints), *self.holes]


@dataclass
class Cut:
    """Cells of a body, in an order independent of the input."""

    polygons: list[np.ndarray]  # corners, m, counter-clockwise, beginning at the lowest one
    joints: list[list[str]]  # joint of each edge; blank within the body
    parts: np.ndarray  # part to which each cell belongs
    short: np.ndarray  # middles of faces that are much shorter than the local size, m
    long: np.ndarray  # middles of much longer faces, m


def mesh_body(
    parts: Sequence[Part],
    cells: str = "quadrilateral",
    fine: Sequence = (),
    fine_size: float | None = None,
    seed: int = 0,
) -> Cut:
    """Divide a body into convex cells.

    `parts`: parts that do not overlap; their common edges are edges of cells.
    `fine`: near these geometries, cells have `fine_size` (m) and grow with the distance.
    `seed`: seed of the random polygons ('voronoi').
    """
    return _Body(parts, cells, fine, fine_size, seed).mesh()


class _Body:
    """The steps of `mesh_body`; coordinates are relative to the middle of the body."""

    def __init__(self, parts, cells, fine, fine_size, seed):
        self.parts, self.cells, self.seed = list(map(_normalised_part, parts)), cells, seed
        parts = self.parts
        corners = np.concatenate([ring for part in parts for ring, _ in part.rings])
        low, high = corners.min(axis=0), corners.max(axis=0)
        self.centre, self.size = 0.5 * (low + high), float((high - low).max())
        self.rounding = _BITS * float(np.spacing(abs(corners).max()))
        self.tolerance = max(_ROUNDING * self.size, self.rounding)
        self.rings = [ring - self.centre for part in parts for ring, _ in part.rings]
        self.shapes = [
            shapely.Polygon(
                part.outline - self.centre, [ring - self.centre for ring, _ in part.holes]
            )
            for part in parts
        ]
        shapely.prepare(self.shapes)
        self.domain = shapely.union_all(shapely.buffer(self.shapes, self.tolerance))
        shapely.prepare(self.domain)
        shapes = shapely.transform(list(fine), lambda xy: xy - self.centre)
        self.fine = bool(fine)
        sizes = Sizes(self.shapes, [part.size for part in parts], list(shapes), fine_size)
        for ring in (ring - self.centre for part in parts for ring, _ in part.holes):
            sizes.bound(shapely.Polygon(ring), _HOLE * float(np.ptp(ring, axis=0).min()))
        self.sizes = sizes

    def mesh(self) -> Cut:
        """Return the cells."""
        network = self._body_network()
        faces = trace_faces(network)
        starts = network.starts
        cycles = [starts[np.array(cycle)].tolist() for cycle in faces.cycles]
        kinds = self._find_parts(face_polygons(network, faces.cycles))
        ends = network.edges[network.outline].tolist()
        labels = dict(zip(map(tuple, ends), network.labels[network.outline].tolist(), strict=True))
        indices = [i for i, kind in enumerate(kinds) if kind >= 0]
        cells = Cells(network.nodes, [cycles[i] for i in indices], kinds[indices].tolist(), labels)
        cells.make_convex(self.sizes.at)
        cells.merge_small(self.sizes.at)
        self._check_area(cells)
        return self._ordered_cells(cells)

    # --- Edges -----------------------------------------------------------------------------------

    def _dividing_lines(self) -> list[Graph]:
        """Return the lines that divide the body: one graph for all parts, or one per part."""
        if self.cells == "voronoi":
            return [polygons(shape, self.sizes, self.seed) for shape in self.shapes]
        if len(self.parts) == 1 and not self.sizes.varies:
            graph = divide_quadrangle(self.shapes[0], self.sizes.largest)
            if graph is not None:
                return [graph]
        return [squares(shapely.multipolygons(self.shapes), self.sizes, self._main_direction())]

    def _main_direction(self) -> float:
        """Return the direction of the longest straight side, between 0 and 90°, rad."""
        ring = np.concatenate(
            [np.stack([ring, np.roll(ring, -1, axis=0)], axis=1) for ring in self.rings]
        )
        along = ring[:, 1] - ring[:, 0]
        length = np.hypot(*along.T)
        angle = np.mod(np.arctan2(along[:, 1], along[:, 0]), np.pi / 2)
        # Directions within rounding errors of a right angle are treated as 0.
        angle[angle > np.pi / 2 - 1e-6] = 0.0
        longest = np.flatnonzero(length > (1 - 1e-6) * length.max())
        return float(angle[longest].min())

    def _body_network(self) -> Network:
        """Return outlines and dividing lines of the body, split at their crossings."""
        all_names = [names for part in self.parts for _, names in part.rings]
        self.names = sorted(set().union(*all_names))
        number = {name: i for i, name in enumerate(self.names)}
        nodes, edges, labels, outline, kinds, count = [], [], [], [], [], 0
        joints = [names for part in self.parts for _, names in part.rings]
        for ring, names in zip(self.rings, joints, strict=True):
            nodes_of_ring = count + np.arange(len(ring))
            nodes.append(ring)
            edges.append(np.column_stack([nodes_of_ring, np.roll(nodes_of_ring, -1)]))
            labels.append([number[name] for name in names])
            outline.append(np.full(len(ring), True))
            kinds.append(np.full(len(ring), CORNER))
            count += len(ring)
        for graph, shape in zip(self._dividing_lines(), self.shapes, strict=False):
            shape = shape if self.cells == "voronoi" else self.domain
            reach = _CORNER_REACH[self.cells], _LINE_REACH[self.cells]
            graph = fit_to_outlines(graph, self.rings, *reach)
            inner = _clip_graph(graph, shape)
            nodes.append(inner.nodes)
            edges.append(inner.edges + count)
            labels.append(np.full(len(inner.edges), len(self.names)))
            outline.append(np.full(len(inner.edges), False))
            kinds.append(np.full(len(inner.nodes), CROSSING))
            count += len(inner.nodes)
        arrays = map(np.concatenate, (nodes, kinds, edges, labels, outline))
        network = split_network(_drop_unused_nodes(Network(*arrays)), self.tolerance)
        network, _, _ = without_dead_ends(self._clipped_network(network))
        network, _ = merge_close_nodes(network, _CLOSE * self.sizes.smallest)
        return without_dead_ends(self._clipped_network(network))[0]

    def _clipped_network(self, network: Network) -> Network:
        """Return a network without the edges outside the body."""
        ends = network.nodes[network.edges]
        mask = shapely.contains_xy(self.domain, *ends.mean(axis=1).T)
        return network.subset(mask | network.outline)

    def _find_parts(self, faces) -> np.ndarray:
        """Return the index of the part that contains each face; −1: none."""
        points = shapely.point_on_surface(faces)
        kinds = np.full(len(faces), -1)
        for i, shape in enumerate(self.shapes):
            kinds[shapely.contains(shape, points)] = i
        return kinds

    # --- Cells -----------------------------------------------------------------------------------

    def _check_area(self, cells: Cells) -> None:
        """Raise InputError if the cells do not fill the body."""
        area = sum(cells.area(cycle) for cycle in cells.cycles if cycle)
        body_area = float(shapely.area(self.shapes).sum())
        if abs(area - body_area) > 1e-9 * body_area:
            raise InputError(
                f"the area of the cells exceeds the area of the body, {body_area:g} m², by "
                f"{area - body_area:g} m²: sides of the outline are closer to each other than the "
                "size of a cell; choose smaller cells"
            )

    def _ordered_cells(self, cells: Cells) -> Cut:
        """Return the cells with corners, edge joints and parts, in a canonical order."""
        indices = [i for i, cycle in enumerate(cells.cycles) if cycle]
        cycles = [cells.cycles[i] for i in indices]
        self._check_connected(cells, indices)
        nodes = np.concatenate(cycles)
        following = np.concatenate([cycle[1:] + cycle[:1] for cycle in cycles])
        inner = len(self.names)
        edges = zip(nodes.tolist(), following.tolist(), strict=True)
        edge_labels = (cells.label(a, b) for a, b in edges)
        labels = np.array([inner if label is None else label for label in edge_labels])
        rings = Rings(np.array(cells.nodes)[nodes], list(map(len, cycles)))
        rings, corners, labels, order = rings.in_order(labels, self.size, self.rounding)
        short, long = self._unusual_faces(rings)
        polygons = parts_of(self._original_positions(rings.corners[corners]), rings.first)
        joints = np.array([*self.names, ""], dtype=object)[labels].tolist()
        joints_of_cells = [joints[rings.first[i] : rings.first[i + 1]] for i in order]
        parts = np.array([cells.kinds[indices[i]] for i in order])
        return Cut([polygons[i] for i in order], joints_of_cells, parts, short, long)

    def _original_positions(self, positions) -> np.ndarray:
        """Return positions relative to (0, 0); corners of outlines are exactly as in the input."""
        corners = np.concatenate([ring for part in self.parts for ring, _ in part.rings])
        distance, nearest = cKDTree(corners - self.centre).query(positions)
        result = positions + self.centre
        mask = distance <= self.tolerance
        result[mask] = corners[nearest[mask]]
        return result

    def _check_connected(self, cells: Cells, indices) -> None:
        """Raise InputError if a body consists of unconnected pieces."""
        rank = {i: k for k, i in enumerate(indices)}
        owner = cells.owner
        pairs = [(i, owner[b, a]) for (a, b), i in owner.items() if (b, a) in owner]
        links = np.array([(rank[i], rank[k]) for i, k in pairs]).reshape(-1, 2)
        graph = coo_array((np.ones(len(links)), links.T), shape=(len(indices),) * 2)
        count, _ = connected_components(graph, directed=False)
        if count > 1:
            raise InputError(
                f"the body has {count} parts without a common edge; give each part its own name"
            )

    def _unusual_faces(self, rings: Rings) -> tuple[np.ndarray, np.ndarray]:
        """Return the middles (k, 2), m, of faces much shorter or longer than the local size."""
        length = rings.edge_lengths()
        middle = 0.5 * (rings.corners + rings.corners[rings.after])
        local = self.sizes.at(middle)
        positions = middle + self.centre
        return positions[length < _SHORTEST * local], positions[length > _LONGEST * local]


def _normalised_part(part: Part) -> Part:
    """Return a part whose rings begin at their lowest, leftmost corner."""
    rings = []
    for k, (ring, joints) in enumerate(part.rings):
        ring, joints = np.asarray(ring, dtype=float), list(joints)
        if shapely.is_ccw(shapely.linearrings(ring)) != (k == 0):
            ring, joints = ring[::-1], joints[-2::-1] + joints[-1:]
        lowest = int(np.lexsort(ring.T)[0])
        rings.append((np.roll(ring, -lowest, axis=0), joints[lowest:] + joints[:lowest]))
    return Part(*rings[0], part.size, sorted(rings[1:], key=lambda item: tuple(item[0][0])))


def _clip_graph(graph: Graph, shape) -> Graph:
    """Return a graph whose edges are clipped to a shape."""
    lines = shapely.linestrings(graph.nodes[graph.edges])
    interior = shapely.contains_properly(shape, lines)
    ends, starts = segments_of(shapely.intersection(lines[~interior], shape))
    edges = np.column_stack([starts, starts + 1]) + len(graph.nodes)
    nodes = np.concatenate([graph.nodes, ends])
    return Graph(nodes, np.concatenate([graph.edges[interior], edges]), graph.local)


def _drop_unused_nodes(network: Network) -> Network:
    """Return a network without the nodes that have no edge."""
    ids, index = np.unique(network.edges, return_inverse=True)
    edges = np.sort(index.reshape(-1, 2), axis=1)
    return Network(network.nodes[ids], network.kinds[ids], edges, network.labels, network.outline)
