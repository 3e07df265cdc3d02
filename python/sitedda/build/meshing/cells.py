# SPDX-License-Identifier: GPL-3.0-or-later
"""Split the cells of a mesh until all are convex; merge small cells into convex unions."""

from collections.abc import Sequence
from math import hypot, pi

import numpy as np

from ..cutting.merging import merge_smallest, rest_of_cycle

_FLAT = 1e-7  # sine of the turn of a straight line, due to rounding errors
_SMALL = 0.35  # smallest area of a cell over the square of the local size
_DIGITS = 6  # digits of compared numbers, so that rounding errors have no effect
_NEAR = 0.15  # smallest distance between the end of a split and a corner over the local size


class Cells:
    """Cells as cycles of nodes, counter-clockwise.

    Parameters
    ----------
    nodes : ndarray, shape (nodes, 2)
        m.
    cycles : list of list of int
    kinds : sequence of int
        Kind of each cell; only cells of the same kind are merged.
    labels : dict
        Label of each edge of an outline, by its two nodes in ascending order.
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
        return [
            k
            for k in range(count)
            if self.turn(cycle[k - 1], cycle[k], cycle[(k + 1) % count]) < -_FLAT
        ]

    def concave(self, cycle: list[int]) -> list[int]:
        """Return the corners at which a cycle turns right, or a joint ends on a straight side."""
        found, count = self.reflex(cycle), len(cycle)
        for k in range(count):
            a, b, c = cycle[k - 1], cycle[k], cycle[(k + 1) % count]
            if self.label(a, b) != self.label(b, c) and abs(self.turn(a, b, c)) <= _FLAT:
                found.append(k)
        return found

    def area(self, cycle: list[int]) -> float:
        """Return the area of a cell, m²."""
        x0, y0 = self.nodes[cycle[0]]
        shifted = [(x - x0, y - y0) for x, y in map(self.nodes.__getitem__, cycle)]
        after = shifted[1:] + shifted[:1]
        return 0.5 * sum(x * yn - y * xn for (x, y), (xn, yn) in zip(shifted, after, strict=True))

    def perimeter(self, cycle: list[int]) -> float:
        """Return the perimeter of a cell, m."""
        places = [self.nodes[k] for k in cycle]
        ends = places[1:] + places[:1]
        return sum(hypot(x - a, y - b) for (x, y), (a, b) in zip(places, ends, strict=True))

    def roundness(self, cycle: list[int]) -> float:
        """Return the area of a cell over the area of a circle of the same perimeter, 0 … 1."""
        return 4 * pi * self.area(cycle) / self.perimeter(cycle) ** 2

    # --- Splitting -------------------------------------------------------------------------------

    def make_convex(self, local) -> None:
        """Split cells until all are convex; `local` returns the target size at a position, m."""
        waiting = [i for i, cycle in enumerate(self.cycles) if self.concave(cycle)]
        while waiting:
            i = waiting.pop()
            reflex = self.concave(self.cycles[i])
            if reflex and (found := self._best_split(i, reflex, local)):
                waiting += self._split(i, *found)

    def _best_split(self, i: int, reflex: list[int], local):
        """Return the best split of a cell: first corner, last corner, and end point on an edge.

        The end point is on the edge after the last corner, or None if the split ends at the corner.
        """
        cycle = self.cycles[i]
        size = float(local(np.array([self.nodes[cycle[reflex[0]]]]))[0])
        best, found = -np.inf, None
        for k in reflex:
            for end, place in [
                *self._visible_corners(cycle, k),
                *self._ray_points(cycle, k, _NEAR * size),
            ]:
                one, other = self._split_cycle(cycle, k, end, place)
                if min(len(one), len(other)) < 3:
                    continue
                worst = min(self._rate_half(half, place, size) for half in (one, other))
                worst = round(worst + 0.05 * (place is None), _DIGITS)
                if worst > best:
                    best, found = worst, (k, end, place)
        return found

    def _rate_half(self, cycle, place, size: float) -> float:
        """Return the rating of one half of a split: high if round, large, with few right turns."""
        nodes = self.nodes
        self.nodes = [*nodes, place] if place is not None else nodes
        cycle = [len(nodes) if node < 0 else node for node in cycle]
        area = self.area(cycle)
        share = min(1.0, area / (_SMALL * size**2))
        worth = share * self.roundness(cycle) - len(self.reflex(cycle)) if area > 0 else -np.inf
        self.nodes = nodes
        return worth

    @staticmethod
    def _split_cycle(cycle, k, end, place):
        """Return both halves of a cycle that is split from corner k to corner `end`.

        If `place` is given, the split ends at a new node, −1, on the edge after corner `end`.
        """
        turned = cycle[k:] + cycle[:k]
        at = (end - k) % len(cycle)
        if place is None:
            return turned[: at + 1], turned[at:] + turned[:1]
        return turned[: at + 1] + [-1], [-1] + turned[at + 1 :] + turned[:1]

    def _visible_corners(self, cycle, k):
        """Yield the corners that are visible from corner k, except its neighbours."""
        count = len(cycle)
        for end in range(count):
            if end in (k, (k - 1) % count, (k + 1) % count):
                continue
            if self._is_visible(cycle, k, self.nodes[cycle[end]], (end, (end - 1) % count)):
                yield end, None

    def _ray_points(self, cycle, k, near: float):
        """Yield the edge and the point that a ray from corner k hits first.

        Rays extend both sides of the corner, their bisector, and the normal of the first side.
        """
        count = len(cycle)
        px, py = self.nodes[cycle[k]]
        before, after = (self.nodes[cycle[(k + step) % count]] for step in (-1, 1))
        along = [np.subtract((px, py), before), np.subtract((px, py), after)]
        along = [way / np.hypot(*way) for way in along]
        upright = np.array([-along[0][1], along[0][0]])  # normal of the first side
        for way in (*along, along[0] + along[1], upright):
            best = None
            for end in range(count):
                if end in (k, (k - 1) % count):
                    continue
                (ax, ay), (bx, by) = self.nodes[cycle[end]], self.nodes[cycle[(end + 1) % count]]
                ex, ey = bx - ax, by - ay
                sine = way[0] * ey - way[1] * ex
                if sine <= 0:  # the ray does not leave the cell through this edge
                    continue
                t = ((ax - px) * ey - (ay - py) * ex) / sine
                s = ((ax - px) * way[1] - (ay - py) * way[0]) / sine
                if t > 0 and 0 < s < 1 and (best is None or t < best[0]):
                    best = t, s, hypot(ex, ey), end, (ax + s * ex, ay + s * ey)
            if best and min(best[1], 1 - best[1]) * best[2] > near:
                yield best[3], best[4]

    def _is_visible(self, cycle, k, target, beside) -> bool:
        """Return whether the line from corner k to a point lies within the cell."""
        count = len(cycle)
        p = self.nodes[cycle[k]]

        def side(a, b, c) -> float:
            return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])

        for e in range(count):
            if e in (k, (k - 1) % count, *beside):
                continue
            a, b = self.nodes[cycle[e]], self.nodes[cycle[(e + 1) % count]]
            if side(p, target, a) * side(p, target, b) <= 0 and (
                side(a, b, p) * side(a, b, target) <= 0
            ):
                return False
        before, after = self.nodes[cycle[k - 1]], self.nodes[cycle[(k + 1) % count]]
        # At a reflex corner, the line must not begin between the two sides, outside the cell.
        return side(p, after, target) > 0 or side(before, p, target) > 0

    def _split(self, i: int, k: int, end: int, place) -> tuple[int, int]:
        """Split a cell; return the indices of the two new cells."""
        cycle = self.cycles[i]
        one, other = self._split_cycle(cycle, k, end, place)
        if place is not None:
            new = len(self.nodes)
            self.nodes.append(place)
            one, other = ([new if node < 0 else node for node in half] for half in (one, other))
            self._insert_node(cycle[end], cycle[(end + 1) % len(cycle)], new)
        self.cycles[i] = one
        self.cycles.append(other)
        self.kinds.append(self.kinds[i])
        self._register_edges(i)
        self._register_edges(len(self.cycles) - 1)
        return i, len(self.cycles) - 1

    def _insert_node(self, a: int, b: int, new: int) -> None:
        """Insert a node into an edge of the neighbour cell, and into the labels."""
        label = self.labels.pop((min(a, b), max(a, b)), None)
        if label is not None:
            self.labels[min(a, new), max(a, new)] = label
            self.labels[min(new, b), max(new, b)] = label
        beyond = self.owner.pop((b, a), None)
        self.owner.pop((a, b))
        if beyond is not None:
            cycle = self.cycles[beyond]
            cycle.insert(cycle.index(b) + 1, new)
            self._register_edges(beyond)

    # --- Merging ---------------------------------------------------------------------------------

    def merge_small(self, local) -> int:
        """Merge small cells into convex unions, the smallest first; return the number merged."""
        middles = np.array(
            [np.mean([self.nodes[k] for k in cycle], axis=0) for cycle in self.cycles]
        )
        self._least = (_SMALL * local(middles) ** 2).tolist()
        self.areas = [self._relative_area(i) for i in range(len(self.cycles))]
        return merge_smallest(
            self.cycles, self.areas, lambda i: self.areas[i] < 1, self._merge_cell
        )

    def _relative_area(self, i: int) -> float:
        """Return the area of a cell over the smallest permitted area, rounded."""
        return round(self.area(self.cycles[i]) / self._least[i], _DIGITS)

    def _merge_cell(self, i: int) -> int | None:
        """Merge a cell into the neighbour with the roundest convex union; return this neighbour."""
        cycle = self.cycles[i]
        others = {self.owner.get((b, a)) for a, b in zip(cycle, cycle[1:] + cycle[:1], strict=True)}
        best, found = -1.0, None
        for other in sorted(others - {None, i}):
            if self.kinds[other] == self.kinds[i] and (union := self._convex_union(i, other)):
                worth = round(self.roundness(union), _DIGITS)
                if worth > best:
                    best, found = worth, (other, union)
        if found is None:
            return None
        into, union = found
        for k in (i, into):
            cycle = self.cycles[k]
            for edge in zip(cycle, cycle[1:] + cycle[:1], strict=True):
                self.owner.pop(edge, None)
        self.cycles[into], self.cycles[i] = union, []
        self._register_edges(into)
        self.areas[into] = self._relative_area(into)
        return into

    def _convex_union(self, i: int, other: int) -> list[int] | None:
        """Return the cycle around two cells; None unless it is a convex polygon."""
        rest, more = self._outer_nodes(i, other), self._outer_nodes(other, i)
        if rest is None or more is None:
            return None
        union = rest + more
        if len(set(union)) < len(union) or len(union) < 3 or self.concave(union):
            return None
        return union

    def _outer_nodes(self, i: int, other: int) -> list[int] | None:
        """Return the nodes of a cell without those inside its common edges with another cell."""
        cycle = self.cycles[i]
        edges = zip(cycle[1:] + cycle[:1], cycle, strict=True)
        return rest_of_cycle(cycle, [self.owner.get(edge) == other for edge in edges])
