# SPDX-License-Identifier: GPL-3.0-or-later
"""The plane graph of joints: crossings, common ends, dead ends, and the faces that become blocks.

Segments are split at crossings and contacts into nodes and edges; each edge has the label of its
segment. All faces are simple polygons if and only if the graph remains connected after removal of
any one node. Therefore dead ends, bridges, and loops of joints that are connected at one node or
none are removed before the faces are traced.
"""

from dataclasses import dataclass

import numpy as np
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from ...base.errors import InputError

_PASSES = 40
# Distance within which a node splits an edge, as fraction of the tolerance.  It must be below
# cos 45°; otherwise two nodes may alternately split each other's edge to a third node forever.
_BESIDE = 0.7
_ROUNDING = 16 * np.finfo(float).eps  # relative rounding of positions and products
_CANDIDATES = 1_000_000  # number of pairs of segments that are processed at once
MOST_CANDIDATES = 400_000_000

# Kinds of nodes, ordered from fixed to free.
CORNER, BOUNDARY, CROSSING, END = range(4)


@dataclass
class Network:
    """A plane graph of nodes and edges."""

    nodes: np.ndarray  # shape (nodes, 2), m
    kinds: np.ndarray  # kind of each node, `CORNER` to `END`
    edges: np.ndarray  # nodes at both ends, in ascending order; each edge occurs once
    labels: np.ndarray  # smallest label of the segments to which an edge belongs
    outline: np.ndarray  # whether an edge is part of an outline
    moved: int = 0  # number of nodes that have been merged with others

    @property
    def starts(self) -> np.ndarray:
        """Return the start node of each half-edge, shape (2 × edges,)."""
        return self.edges.ravel()

    def subset(self, keep) -> "Network":
        """Return a network with all nodes and the edges for which `keep` is true."""
        edges, labels, outline = self.edges[keep], self.labels[keep], self.outline[keep]
        return Network(self.nodes, self.kinds, edges, labels, outline, self.moved)


def split_segments(segments, labels, outline, tolerance: float) -> Network:
    """Return the network of segments that are split at crossings and contacts.

    `segments`: shape (n, 2, 2); both ends, m.
    `labels`: shape (n,).
    `outline`: shape (n,); whether a segment belongs to an outline, whose corners do not move.
    `tolerance`: m, see `split_network`.
    """
    return split_network(_sort_segments(segments, labels, outline), tolerance)


def split_network(network: Network, tolerance: float, rigid: bool = False) -> Network:
    """Return a network whose edges are split at crossings and contacts.

    `tolerance`: m. Nodes that are closer to each other are merged. Nodes whose distance from an
    edge is less than 0.7 of the tolerance split the edge, and free ends of joints are moved onto
    the edge.
    `rigid`: do not change the shape of outlines: nodes of different outlines are not merged.
    """
    network = _merge_nodes(network, tolerance, rigid)
    for _ in range(_PASSES):
        events = _find_splits(network, tolerance, rigid)
        count = len(network.nodes)
        network = _split_edges(network, *events)
        network = _merge_nodes(network, tolerance, rigid)
        if not len(events[0]) and len(network.nodes) == count:
            return network
    raise InputError(
        f"corners within {tolerance:g} m of each other cannot be merged, because other "
        "corners would then be as close; choose a smaller least_edge"
    )


def merge_close_nodes(network: Network, reach: float) -> tuple[Network, float]:
    """Merge nodes within a distance (m), which is reduced if necessary; return also the distance.

    The shape of outlines does not change.  The distance is reduced if merging fails.
    """
    for distance in (reach, reach / 2, reach / 4):
        try:
            return split_network(network, distance, rigid=True), distance
        except InputError:
            continue
    return network, reach


def _sort_segments(segments, labels, outline) -> Network:
    """Return segments as a network of unconnected edges in a canonical order.

    The result then does not depend on the order of the input.
    """
    start, end = segments[:, 0], segments[:, 1]
    reverse = (start[:, 0] > end[:, 0]) | ((start[:, 0] == end[:, 0]) & (start[:, 1] > end[:, 1]))
    segments = np.where(reverse[:, None, None], segments[:, ::-1], segments)
    flat = segments.reshape(-1, 4)
    order = np.lexsort((*flat.T[::-1], labels, ~outline))
    segments, labels, outline = segments[order], labels[order], outline[order]
    nodes = segments.reshape(-1, 2)
    kinds = np.repeat(np.where(outline, CORNER, END), 2)
    edges = np.arange(len(nodes)).reshape(-1, 2)
    return Network(nodes, kinds, edges, labels, outline)


def _overlapping_pairs(network: Network, tolerance: float):
    """Yield chunks of pairs of edges i < j whose bounding boxes overlap."""
    ends = network.nodes[network.edges]
    low, high = ends.min(axis=1) - tolerance, ends.max(axis=1) + tolerance
    boxes = shapely.box(low[:, 0], low[:, 1], high[:, 0], high[:, 1])
    tree = shapely.STRtree(boxes)
    start, portion, total = 0, 256, 0
    while start < len(boxes):
        first, second = tree.query(boxes[start : start + portion])
        first = first + start
        start += portion
        keep = first < second
        total += len(first)
        if total > MOST_CANDIDATES:
            raise InputError(
                f"more than {MOST_CANDIDATES:.0e} pairs of joints have overlapping bounding boxes; "
                "use fewer or shorter joints"
            )
        portion = max(1, 2 * portion if len(first) < _CANDIDATES else portion // 2)
        order = np.lexsort((second[keep], first[keep]))
        yield first[keep][order], second[keep][order]


def cross_product(a, b):
    """Return the cross products of vectors, shape (..., 2)."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def _find_splits(network: Network, tolerance: float, rigid: bool):
    """Return the splits of edges at crossings and contacts, and the new nodes.

    Result `edge`, `fraction`, `node`: edge, fraction of its length, and node; larger indices than
    those of the network are new nodes.
    Result `positions`, `kinds`: of the new nodes, shapes (new, 2) and (new,).
    Result `shifted`, `targets`: free ends that touch an edge, and their positions on it; ends on
    outlines come last.
    """
    edge, fraction, node, positions, kinds, shifted, targets, on_outline = ([] for _ in range(8))
    next_node = len(network.nodes)
    for first, second in _overlapping_pairs(network, tolerance):
        touched = np.zeros(len(first), dtype=bool)
        for edges_a, edges_b in ((first, second), (second, first)):
            for side in (0, 1):
                ends = network.edges[edges_b, side]
                hits, along, points = _find_touching(network, edges_a, ends, _BESIDE * tolerance)
                if rigid:
                    stiff = network.outline[edges_a[hits]] & (network.kinds[ends[hits]] <= BOUNDARY)
                    hits, along, points = hits[~stiff], along[~stiff], points[~stiff]
                touched[hits] = True
                edge.append(edges_a[hits])
                fraction.append(along)
                end = ends[hits]
                node.append(end)
                limit = np.where(network.outline[edges_a[hits]], CROSSING, END)
                movable = network.kinds[end] >= limit
                shifted.append(end[movable])
                targets.append(points[movable])
                on_outline.append(network.outline[edges_a[hits]][movable])
        hits, along, fraction_b, points = _find_crossings(network, first, second, ~touched)
        node_index = next_node + np.arange(len(hits))
        next_node += len(hits)
        edge += [first[hits], second[hits]]
        fraction += [along, fraction_b]
        node += [node_index, node_index]
        positions.append(points)
        outlines = network.outline[first[hits]].astype(int) + network.outline[second[hits]]
        kinds.append(CROSSING - outlines)
    join = np.concatenate
    if not edge:
        empty = np.zeros(0, dtype=int)
        return empty, np.zeros(0), empty, np.zeros((0, 2)), empty, empty, np.zeros((0, 2))
    order = np.argsort(join(on_outline), kind="stable")
    shifted, targets = join(shifted)[order], join(targets)[order]
    split = np.array([join(edge), join(node)]), join(fraction)
    keep = _keep_last_outline(network, *split[0]) if rigid else slice(None)
    (edge, node), fraction = split[0][:, keep], split[1][keep]
    return edge, fraction, node, join(positions), join(kinds), shifted, targets


def _keep_last_outline(network: Network, edge, node) -> np.ndarray:
    """Return which splits remain if each inner node splits only the last outline that it touches.

    The node is moved onto this outline; a split would change the shape of other outlines.
    """
    inner = network.outline[edge] & (node < len(network.nodes))
    inner[inner] = network.kinds[node[inner]] > BOUNDARY
    owner = np.full(len(network.nodes), -1)
    owner[node[inner]] = edge[inner]
    keep = ~inner
    keep[inner] = owner[node[inner]] == edge[inner]
    return keep


def _find_touching(network, edge, node, tolerance):
    """Return which nodes touch an edge between its ends, at which fractions and positions."""
    a, b = network.nodes[network.edges[edge]].swapaxes(0, 1)
    along, offset = b - a, network.nodes[node] - a
    squared = (along**2).sum(axis=1)
    fraction = (offset * along).sum(axis=1) / squared
    distance = abs(cross_product(along, offset)) / np.sqrt(squared)
    foreign = (network.edges[edge] != node[:, None]).all(axis=1)
    hits = np.flatnonzero(foreign & (fraction > 0) & (fraction < 1) & (distance <= tolerance))
    return hits, fraction[hits], a[hits] + fraction[hits, None] * along[hits]


def _find_crossings(network, first, second, mask):
    """Return which pairs of edges cross between their ends, at which fractions and positions."""
    foreign = (network.edges[first][:, :, None] != network.edges[second][:, None, :]).all(
        axis=(1, 2)
    )
    pairs = np.flatnonzero(mask & foreign)
    a, b = network.nodes[network.edges[first[pairs]]].swapaxes(0, 1)
    c, d = network.nodes[network.edges[second[pairs]]].swapaxes(0, 1)
    r, s, offset = b - a, d - c, c - a
    sine = cross_product(r, s)
    parallel = sine == 0
    sine = np.where(parallel, 1.0, sine)
    t, u = cross_product(offset, s) / sine, cross_product(offset, r) / sine
    crosses = ~(_is_collinear(r, c - a, network) & _is_collinear(r, d - a, network))
    crosses &= ~(_is_collinear(s, a - c, network) & _is_collinear(s, b - c, network))
    hits = np.flatnonzero(~parallel & crosses & (t > 0) & (t < 1) & (u > 0) & (u < 1))
    return pairs[hits], t[hits], u[hits], a[hits] + t[hits, None] * r[hits]


def _is_collinear(along, arm, network) -> np.ndarray:
    """Return whether positions lie on the lines of edges within rounding errors.

    Edges on the same side of an outline are parallel only within rounding errors; the position of
    their crossing is therefore undefined.
    """
    rounding = _ROUNDING * abs(network.nodes).max()
    return abs(cross_product(along, arm)) <= rounding * (np.hypot(*along.T) + np.hypot(*arm.T))


def _split_edges(network, edge, fraction, node, positions, kinds, shifted, targets) -> Network:
    """Return a network with edges that are split at nodes, see `_find_splits`."""
    nodes = np.concatenate([network.nodes, positions])
    kinds = np.concatenate([network.kinds, kinds]).astype(int)
    # If a free end touches an outline and a joint, it is moved onto the outline.
    nodes[shifted] = targets
    on_outline = np.zeros(len(kinds), dtype=bool)
    on_outline[node[network.outline[edge]]] = True
    kinds = np.where(on_outline, np.minimum(kinds, BOUNDARY), np.minimum(kinds, END))
    kinds[node] = np.minimum(kinds[node], CROSSING)
    count = np.arange(len(network.edges))
    edge = np.concatenate([count, edge, count])
    fraction = np.concatenate([np.full(len(count), -1.0), fraction, np.full(len(count), 2.0)])
    node = np.concatenate([network.edges[:, 0], node, network.edges[:, 1]])
    order = np.lexsort((node, fraction, edge))
    edge, node = edge[order], node[order]
    same_edge = edge[1:] == edge[:-1]
    edges = np.column_stack([node[:-1], node[1:]])[same_edge]
    source = edge[:-1][same_edge]
    labels, outline = network.labels[source], network.outline[source]
    return Network(nodes, kinds, edges, labels, outline, network.moved)


def _merge_nodes(network: Network, tolerance: float, rigid: bool) -> Network:
    """Return a network in which close nodes are merged and repeated edges are removed."""
    count = len(network.nodes)
    pairs = cKDTree(network.nodes).query_pairs(tolerance, output_type="ndarray")
    if rigid and len(pairs):
        pairs = _mergeable_pairs(network, pairs)
    links = coo_array((np.ones(len(pairs)), pairs.T.reshape(2, -1)), shape=(count, count))
    groups, group = connected_components(links, directed=False)
    nodes, kinds = network.nodes, network.kinds
    lowest_kind = np.full(groups, END)
    np.minimum.at(lowest_kind, group, kinds)
    leads = kinds == lowest_kind[group]
    weight = np.bincount(group, leads, groups)
    positions = np.column_stack([np.bincount(group, leads * xy, groups) / weight for xy in nodes.T])
    # The position of a node that is not merged does not change at all.
    leader = np.full(groups, count)
    np.minimum.at(leader, group, np.where(leads, np.arange(count), count))
    single = weight == 1
    positions[single] = nodes[leader[single]]
    edges = np.sort(group[network.edges], axis=1)
    keep = edges[:, 0] != edges[:, 1]
    key, index = np.unique(edges[keep] @ np.array([groups, 1]), return_inverse=True)
    labels = np.full(len(key), np.iinfo(np.int64).max)
    np.minimum.at(labels, index, network.labels[keep])
    outline = np.zeros(len(key), dtype=bool)
    np.logical_or.at(outline, index, network.outline[keep])
    edges = np.column_stack(np.divmod(key, groups))
    count_moved = network.moved + int((nodes != positions[group]).any(axis=1).sum())
    return Network(positions, lowest_kind, edges, labels, outline, count_moved)


def _mergeable_pairs(network: Network, pairs) -> np.ndarray:
    """Return the pairs of close nodes that can be merged without changing outlines.

    An inner node can merge with the nearest node on an outline, and a node on an outline with the
    nearest adjacent corner of the same outline. Nodes without such a partner can merge with nodes
    of the same kind. Corners do not move.
    """
    kinds = np.minimum(network.kinds, CROSSING)
    count = np.array([len(network.nodes), 1])
    sides = np.sort(network.edges[network.outline], axis=1) @ count
    on_sides = np.isin(np.sort(pairs, axis=1) @ count, sides)
    chosen, paired = [], np.zeros(len(kinds), dtype=bool)
    for kind in (BOUNDARY, CROSSING):
        valid = on_sides if kind == BOUNDARY else np.ones(len(pairs), dtype=bool)
        mixed = valid & (kinds[pairs].max(axis=1) == kind) & (kinds[pairs].min(axis=1) < kind)
        upper = np.where(kinds[pairs[mixed, 0]] == kind, pairs[mixed, 0], pairs[mixed, 1])
        distance = np.linalg.norm(np.diff(network.nodes[pairs[mixed]], axis=1)[:, 0], axis=1)
        order = np.lexsort((distance, upper))
        partnered, nearest = np.unique(upper[order], return_index=True)
        chosen.append(pairs[mixed][order[nearest]])
        paired[partnered] = True
        equal = valid & (kinds[pairs] == kind).all(axis=1) & ~paired[pairs].any(axis=1)
        chosen.append(pairs[equal])
    return np.concatenate(chosen)


def without_dead_ends(network: Network) -> tuple[Network, int, list[np.ndarray]]:
    """Return the part of a network whose faces are simple polygons.

    Result: the network, the number of removed edges of dead ends, and a position (m) on each
    removed loop of joints; such a loop lies inside a block and touches the outline of the block at
    one point at most.
    """
    pruned = _remove_dangling_edges(network)
    dead = len(network.edges) - len(pruned.edges)
    parts = _biconnected_parts(len(pruned.nodes), pruned.edges)
    anchored = np.unique(parts[pruned.outline])
    keep = np.isin(parts, anchored)
    sizes = np.bincount(parts, minlength=parts.max(initial=0) + 1)
    is_loop = ~keep & (sizes[parts] > 1)
    _, first_edge = np.unique(parts[is_loop], return_index=True)
    positions = [pruned.nodes[pruned.edges[is_loop][i, 0]] for i in first_edge]
    return pruned.subset(keep), dead + int((~keep & ~is_loop).sum()), positions


def _remove_dangling_edges(network: Network) -> Network:
    """Return a network without edges that have a free end."""
    while True:
        degree = np.bincount(network.edges.ravel(), minlength=len(network.nodes))
        keep = (degree[network.edges] > 1).all(axis=1)
        if keep.all():
            return network
        network = network.subset(keep)


def _biconnected_parts(nodes: int, edges) -> np.ndarray:
    """Return the biconnected component of each edge (Hopcroft & Tarjan 1973), shape (edges,)."""
    ends = edges.ravel()
    order = np.argsort(ends, kind="stable")
    begin = np.searchsorted(ends[order], np.arange(nodes + 1)).tolist()
    incident = (order // 2).tolist()
    neighbour = edges[order // 2, 1 - order % 2].tolist()
    part = [-1] * len(edges)
    depth, low = [0] * nodes, [0] * nodes
    cursor = begin[:-1]
    parts = clock = 0
    for root in np.unique(ends).tolist():
        if depth[root]:
            continue
        clock += 1
        depth[root] = low[root] = clock
        path, pending, entered = [root], [], [-1]
        while path:
            v = path[-1]
            i = cursor[v]
            if i < begin[v + 1]:
                cursor[v] = i + 1
                e, w = incident[i], neighbour[i]
                if e == entered[-1] or depth[w] > depth[v]:
                    continue
                pending.append(e)
                if depth[w]:
                    low[v] = min(low[v], depth[w])
                else:
                    clock += 1
                    depth[w] = low[w] = clock
                    path.append(w)
                    entered.append(e)
                continue
            path.pop()
            e = entered.pop()
            if not path:
                continue
            u = path[-1]
            low[u] = min(low[u], low[v])
            if low[v] >= depth[u]:
                while True:
                    edge = pending.pop()
                    part[edge] = parts
                    if edge == e:
                        break
                parts += 1
    return np.array(part, dtype=int)


@dataclass
class Faces:
    """The faces of a network, each on the left of its half-edges.

    Half-edge 2e leads along edge e from its first to its second node; half-edge 2e + 1 leads back.
    """

    cycles: list[list[int]]  # half-edges around each face, counter-clockwise
    face: np.ndarray  # face on the left of each half-edge; −1: outside
    areas: np.ndarray  # m²


def trace_faces(network: Network) -> Faces:
    """Return all bounded faces of a network without dead ends."""
    start = network.starts
    count = len(start)
    twin = np.arange(count) ^ 1
    along = network.nodes[start[twin]] - network.nodes[start]
    angle = np.arctan2(along[:, 1], along[:, 0])
    order = np.lexsort((angle, start))
    rank = np.empty(count, dtype=int)
    rank[order] = np.arange(count)
    begin = np.searchsorted(start[order], start)
    end = np.searchsorted(start[order], start, side="right") - 1
    # After a half-edge, a face continues with the edge that is next to its twin, clockwise.
    previous = np.where(rank == begin, end, rank - 1)
    following = order[previous][twin].tolist()
    x, y = network.nodes[start].T.tolist()
    visited, cycles, areas = [False] * count, [], []
    for h in range(count):
        if visited[h]:
            continue
        cycle, double_area = [], 0.0
        x0, y0 = x[h], y[h]
        while not visited[h]:
            visited[h] = True
            cycle.append(h)
            successor = following[h]
            double_area += (x[h] - x0) * (y[successor] - y0) - (y[h] - y0) * (x[successor] - x0)
            h = successor
        if double_area > 0:
            cycles.append(cycle)
            areas.append(0.5 * double_area)
    face = np.full(count, -1)
    lengths = [len(cycle) for cycle in cycles]
    if cycles:
        face[np.concatenate(cycles)] = np.repeat(np.arange(len(cycles)), lengths)
    return Faces(cycles, face, np.array(areas))
