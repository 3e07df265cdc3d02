# SPDX-License-Identifier: GPL-3.0-or-later
"""Split the cells of a mesh until all are convex; merge small cells into convex unions."""

from collections.abc import Sequence
from math import hypot, pi

import numpy as np

from ..cutting.merging import merge_smallest, rest_of_cycle

_FLAT = 1e-7  # sine of the turn of a straight line, due to rounding errors
_SMALL = 0.35  # smallest area of a cell / square of the local size
_DIGITS = 6  # digits of compared numbers, so that rounding errors have no effect
_NEAR = 0.15  # smallest distance between the end of a split and a corner / local size


class Cells:
    """Cells as cycles of nodes, counter-clockwise.

    `nodes`: shape (nodes, 2); m.
    `kinds`: kind of each cell; only cells of the same kind are merged.
    `labels`: label of each edge of an outline, by its two nodes in ascending order.
    """

    def __init__(self, nodes, cycles: list[list[int]], kinds: Sequence[int], labels: dict):
        self.nodes: list[tuple[float, float]] = list(map(tuple, nodes.tolist()))
        self.cycles, self.kinds, self.labels = cycles, list(kinds), labels
        self.owner: dict[tuple[int, int], int] = {}
        for i in range(len(cycles)):
            self._register_edges(i)

    def _register_edges(self, i: int) -> None:
        """Store a cell as the owner of its edges."""
        cycle = self.cycles[i]
        self.owner.update(dict.fromkeys(zip(cycle, cycle[1:] + cycle[:1], strict=True), i))

    def label(self, a: int, b: int):
        """Return the label of an edge; None within a body."""
        return self.labels.get((min(a, b), max(a, b)))

    def turn(self, a: int, b: int, c: int) -> float:
        """Return the sine of the left turn from a–b to b–c; ±1 for turns above a right angle."""
        (ax, ay), (bx, by), (cx, cy) = self.nodes[a], self.nodes[b], self.nodes[c]
        ux, uy, vx, vy = bx - ax, by - ay, cx - bx, cy - by
        sine = (ux * vy - uy * vx) / (hypot(ux, uy) * hypot(vx, vy) or 1.0)
        return sine if ux * vx + uy * vy >= 0 else (1.0 if sine >= 0 else -1.0)

    def reflex(self, cycle: list[int]) -> list[int]:
        """Return the indices of the corners at which a cycle turns to the right."""
        count = len(cycle)
        turns = (self.turn(cycle[k - 1], cycle[k], cycle[(k + 1) % count]) for k in range(count))
        return [k for k, turn in enumerate(turns) if turn < -_FLAT]

    def concave(self, cycle: list[int]) -> list[int]:
        """Return the corners at which a cycle turns right, or a joint ends on a straight side."""
        corners, count = self.reflex(cycle), len(cycle)
        for k in range(count):
            a, b, c = cycle[k - 1], cycle[k], cycle[(k + 1) % count]
            if self.label(a, b) != self.label(b, c) and abs(self.turn(a, b, c)) <= _FLAT:
                corners.append(k)
        return corners

    def area(self, cycle: list[int]) -> float:
        """Return the area of a cell, m²."""
        x0, y0 = self.nodes[cycle[0]]
        shifted = [(x - x0, y - y0) for x, y in map(self.nodes.__getitem__, cycle)]
        ends = shifted[1:] + shifted[:1]
        return 0.5 * sum(x * yn - y * xn for (x, y), (xn, yn) in zip(shifted, ends, strict=True))

    def perimeter(self, cycle: list[int]) -> float:
        """Return the perimeter of a cell, m."""
        corners = [self.nodes[k] for k in cycle]
        ends = corners[1:] + corners[:1]
        return sum(hypot(x - a, y - b) for (x, y), (a, b) in zip(corners, ends, strict=True))

    def roundness(self, cycle: list[int]) -> float:
        """Return area of a cell / area of a circle of the same perimeter, 0 … 1."""
        return 4 * pi * self.area(cycle) / self.perimeter(cycle) ** 2

    # --- Splitting -------------------------------------------------------------------------------

    def make_convex(self, local) -> None:
        """Split cells until all are convex; `local` returns the target size at a position, m."""
        pending = [i for i, cycle in enumerate(self.cycles) if self.concave(cycle)]
        while pending:
            i = pending.pop()
            reflex = self.concave(self.cycles[i])
            if reflex and (best := self._best_split(i, reflex, local)):
                pending += self._split(i, *best)

    def _best_split(self, i: int, reflex: list[int], local):
        """Return the best split of a cell: first corner, last corner, and end point on an edge.

        The end point is on the edge after the last corner, or None if the split ends at the corner.
        """
        cycle = self.cycles[i]
        size = float(local(np.array([self.nodes[cycle[reflex[0]]]]))[0])
        best_rating, result = -np.inf, None
        for k in reflex:
            rays = self._ray_points(cycle, k, _NEAR * size)
            for end, point in [*self._visible_corners(cycle, k), *rays]:
                first, second = self._split_cycle(cycle, k, end, point)
                if min(len(first), len(second)) < 3:
                    continue
                rating = min(self._rate_half(half, point, size) for half in (first, second))
                rating = round(rating + 0.05 * (point is None), _DIGITS)
                if rating > best_rating:
                    best_rating, result = rating, (k, end, point)
        return result

    def _rate_half(self, cycle, point, size: float) -> float:
        """Return the rating of one half of a split: high if round, large, with few right turns."""
        nodes = self.nodes
        self.nodes = [*nodes, point] if point is not None else nodes
        cycle = [len(nodes) if node < 0 else node for node in cycle]
        area = self.area(cycle)
        fraction = min(1.0, area / (_SMALL * size**2))
        worth = fraction * self.roundness(cycle) - len(self.reflex(cycle)) if area > 0 else -np.inf
        self.nodes = nodes
        return worth

    @staticmethod
    def _split_cycle(cycle, k, end, point):
        """Return both halves of a cycle that is split from corner k to corner `end`.

        If `point` is given, the split ends at a new node, −1, on the edge after corner `end`.
        """
        rotated = cycle[k:] + cycle[:k]
        split = (end - k) % len(cycle)
        if point is None:
            return rotated[: split + 1], rotated[split:] + rotated[:1]
        return rotated[: split + 1] + [-1], [-1] + rotated[split + 1 :] + rotated[:1]

    def _visible_corners(self, cycle, k):
        """Yield the corners that are visible from corner k, except its neighbours."""
        count = len(cycle)
        for end in range(count):
            if end in (k, (k - 1) % count, (k + 1) % count):
                continue
            if self._is_visible(cycle, k, self.nodes[cycle[end]], (end, (end - 1) % count)):
                yield end, None

    def _ray_points(self, cycle, k, distance: float):
        """Yield the edge and the point that a ray from corner k hits first.

        Rays extend both sides of the corner, their bisector, and the normal of the first side.
        """
        count = len(cycle)
        px, py = self.nodes[cycle[k]]
        previous, following = (self.nodes[cycle[(k + step) % count]] for step in (-1, 1))
        along = [np.subtract((px, py), previous), np.subtract((px, py), following)]
        along = [direction / np.hypot(*direction) for direction in along]
        upright = np.array([-along[0][1], along[0][0]])  # normal of the first side
        for direction in (*along, along[0] + along[1], upright):
            hit = None
            for end in range(count):
                if end in (k, (k - 1) % count):
                    continue
                (ax, ay), (bx, by) = self.nodes[cycle[end]], self.nodes[cycle[(end + 1) % count]]
                ex, ey = bx - ax, by - ay
                sine = direction[0] * ey - direction[1] * ex
                if sine <= 0:  # the ray does not leave the cell through this edge
                    continue
                t = ((ax - px) * ey - (ay - py) * ex) / sine
                s = ((ax - px) * direction[1] - (ay - py) * direction[0]) / sine
                if t > 0 and 0 < s < 1 and (hit is None or t < hit[0]):
                    hit = t, s, hypot(ex, ey), end, (ax + s * ex, ay + s * ey)
            if hit and min(hit[1], 1 - hit[1]) * hit[2] > distance:
                yield hit[3], hit[4]

    def _is_visible(self, cycle, k, target, edges_of_target) -> bool:
        """Return whether the line from corner k to a point lies within the cell."""
        count = len(cycle)
        p = self.nodes[cycle[k]]

        def cross(a, b, c) -> float:
            return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])

        for e in range(count):
            if e in (k, (k - 1) % count, *edges_of_target):
                continue
            a, b = self.nodes[cycle[e]], self.nodes[cycle[(e + 1) % count]]
            if cross(p, target, a) * cross(p, target, b) <= 0 and (
                cross(a, b, p) * cross(a, b, target) <= 0
            ):
                return False
        previous, following = self.nodes[cycle[k - 1]], self.nodes[cycle[(k + 1) % count]]
        # At a reflex corner, the line must not begin between the two sides, outside the cell.
        return cross(p, following, target) > 0 or cross(previous, p, target) > 0

    def _split(self, i: int, k: int, end: int, point) -> tuple[int, int]:
        """Split a cell; return the indices of the two new cells."""
        cycle = self.cycles[i]
        first, second = self._split_cycle(cycle, k, end, point)
        if point is not None:
            node_index = len(self.nodes)
            self.nodes.append(point)
            halves = (first, second)
            first, second = ([node_index if n < 0 else n for n in half] for half in halves)
            self._insert_node(cycle[end], cycle[(end + 1) % len(cycle)], node_index)
        self.cycles[i] = first
        self.cycles.append(second)
        self.kinds.append(self.kinds[i])
        self._register_edges(i)
        self._register_edges(len(self.cycles) - 1)
        return i, len(self.cycles) - 1

    def _insert_node(self, a: int, b: int, node: int) -> None:
        """Insert a node into an edge of the neighbour cell, and into the labels."""
        label = self.labels.pop((min(a, b), max(a, b)), None)
        if label is not None:
            self.labels[min(a, node), max(a, node)] = label
            self.labels[min(node, b), max(node, b)] = label
        neighbour = self.owner.pop((b, a), None)
        self.owner.pop((a, b))
        if neighbour is not None:
            cycle = self.cycles[neighbour]
            cycle.insert(cycle.index(b) + 1, node)
            self._register_edges(neighbour)

    # --- Merging ---------------------------------------------------------------------------------

    def merge_small(self, local) -> int:
        """Merge small cells into convex unions, the smallest first; return the number merged."""
        corners = ([self.nodes[k] for k in cycle] for cycle in self.cycles)
        middles = np.array([np.mean(points, axis=0) for points in corners])
        self._least = (_SMALL * local(middles) ** 2).tolist()
        self.areas = [self._relative_area(i) for i in range(len(self.cycles))]
        areas = self.areas
        return merge_smallest(self.cycles, areas, lambda i: areas[i] < 1, self._merge_cell)

    def _relative_area(self, i: int) -> float:
        """Return area of a cell / smallest permitted area, rounded."""
        return round(self.area(self.cycles[i]) / self._least[i], _DIGITS)

    def _merge_cell(self, i: int) -> int | None:
        """Merge a cell into the neighbour with the roundest convex union; return this neighbour."""
        cycle = self.cycles[i]
        cells = {self.owner.get((b, a)) for a, b in zip(cycle, cycle[1:] + cycle[:1], strict=True)}
        best_rating, result = -1.0, None
        for cell in sorted(cells - {None, i}):
            if self.kinds[cell] == self.kinds[i] and (union := self._convex_union(i, cell)):
                worth = round(self.roundness(union), _DIGITS)
                if worth > best_rating:
                    best_rating, result = worth, (cell, union)
        if result is None:
            return None
        target, union = result
        for k in (i, target):
            cycle = self.cycles[k]
            for edge in zip(cycle, cycle[1:] + cycle[:1], strict=True):
                self.owner.pop(edge, None)
        self.cycles[target], self.cycles[i] = union, []
        self._register_edges(target)
        self.areas[target] = self._relative_area(target)
        return target

    def _convex_union(self, i: int, neighbour: int) -> list[int] | None:
        """Return the cycle around two cells; None unless it is a convex polygon."""
        first, second = self._outer_nodes(i, neighbour), self._outer_nodes(neighbour, i)
        if first is None or second is None:
            return None
        union = first + second
        if len(set(union)) < len(union) or len(union) < 3 or self.concave(union):
            return None
        return union

    def _outer_nodes(self, i: int, neighbour: int) -> list[int] | None:
        """Return the nodes of a cell without those inside its common edges with another cell."""
        cycle = self.cycles[i]
        edges = zip(cycle[1:] + cycle[:1], cycle, strict=True)
        return rest_of_cycle(cycle, [self.owner.get(edge) == neighbour for edge in edges])
