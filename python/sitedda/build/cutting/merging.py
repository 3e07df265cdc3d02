# SPDX-License-Identifier: GPL-3.0-or-later
"""Merge slivers with neighbouring blocks."""

import heapq
from collections.abc import Callable

import numpy as np

from .network import Faces, Network
from .rings import Rings


def merge_slivers(
    network: Network, faces: Faces, kinds, least_area: float, least_angle: float
) -> tuple[list[list[int]], int]:
    """Merge small and sharp faces with the neighbour of the longest common edge.

    `kinds`: kind of each face; only faces of the same kind are merged; −1: no block; `least_area`:
    m²; `least_angle`: degrees.

    Result: half-edges around each face, empty for merged faces; number of merged faces.
    """
    work = _Merging(network, faces, kinds)

    def is_small(i: int) -> bool:
        sharp = least_angle > 0 and work.sharpest(i) < least_angle
        return kinds[i] >= 0 and (work.areas[i] < least_area or sharp)

    return work.cycles, merge_smallest(work.cycles, work.areas, is_small, work.merge)


def merge_smallest(
    cycles: list[list[int]],
    areas: list[float],
    is_small: Callable[[int], bool],
    merge: Callable[[int], int | None],
) -> int:
    """Merge small faces, the smallest first; return the number of merged faces.

    `merge` merges a face into a neighbour and returns this neighbour, or None.  It updates the
    cycles, which are empty for merged faces, and the areas.
    """
    heap = [(area, i) for i, area in enumerate(areas) if is_small(i)]
    heapq.heapify(heap)
    count = 0
    while heap:
        area, i = heapq.heappop(heap)
        if not cycles[i] or area != areas[i] or (target := merge(i)) is None:
            continue
        count += 1
        if is_small(target):
            heapq.heappush(heap, (areas[target], target))
    return count


def rest_of_cycle(cycle: list[int], common: list[bool]) -> list[int] | None:
    """Return a cycle without its edges that are `common`; None unless these form one chain."""
    starts = [k for k in range(len(cycle)) if common[k - 1] and not common[k]]
    if len(starts) != 1:
        return None
    rotated = cycle[starts[0] :] + cycle[: starts[0]]
    return rotated[: len(cycle) - sum(common)]


class _Merging:
    """Faces as cycles of half-edges, which can be merged."""

    def __init__(self, network: Network, faces: Faces, kinds):
        self.nodes = network.nodes
        self.start = network.starts.tolist()
        ends = network.nodes[network.edges]
        self.length = np.sqrt(((ends[:, 1] - ends[:, 0]) ** 2).sum(axis=1)).tolist()
        self.cycles = [list(cycle) for cycle in faces.cycles]
        self.areas = faces.areas.tolist()
        self.face = faces.face.tolist()
        self.kinds = kinds

    def sharpest(self, i: int) -> float:
        """Return the angle of the sharpest corner of a face, degrees."""
        corners = self.nodes[[self.start[h] for h in self.cycles[i]]]
        return float(Rings.of([corners]).sharpest_corners()[0])

    def merge(self, i: int) -> int | None:
        """Merge a face into a neighbour and return this neighbour; None if that is impossible."""
        common: dict[int, float] = {}
        for h in self.cycles[i]:
            neighbour = self.face[h ^ 1]
            if neighbour >= 0 and neighbour != i and self.kinds[neighbour] == self.kinds[i]:
                common[neighbour] = common.get(neighbour, 0.0) + self.length[h >> 1]
        for neighbour in sorted(common, key=lambda face: (-common[face], face)):
            cycle = self._cycle_around_both(i, neighbour)
            if cycle is not None:
                for h in cycle:
                    self.face[h] = neighbour
                self.cycles[neighbour], self.cycles[i] = cycle, []
                self.areas[neighbour] += self.areas[i]
                return neighbour
        return None

    def _cycle_around_both(self, i: int, neighbour: int) -> list[int] | None:
        """Return the cycle around two faces; None if it is not one simple polygon."""
        first, second = (
            rest_of_cycle(self.cycles[a], [self.face[h ^ 1] == b for h in self.cycles[a]])
            for a, b in ((i, neighbour), (neighbour, i))
        )
        if first is None or second is None:
            return None
        nodes = [self.start[h] for h in first + second]
        return first + second if len(set(nodes)) == len(nodes) else None
