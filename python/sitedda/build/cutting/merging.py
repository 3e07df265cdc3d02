# SPDX-License-Identifier: GPL-3.0-or-later
"""Merge slivers with a neighbour."""

import heapq

import numpy as np

from .network import Faces, Network, half_edge_starts
from .rings import Rings


def merge_slivers(
    network: Network, faces: Faces, kinds, least_area: float, least_angle: float
) -> tuple[list[list[int]], np.ndarray, int, list[int]]:
    """Merge small and sharp faces with the neighbour of the longest common edge.

    Parameters
    ----------
    network : Network
    faces : Faces
    kinds : ndarray of int, shape (faces,)
        Only faces of the same kind are merged; −1: no block.
    least_area : float
        m².
    least_angle : float
        Degrees.

    Returns
    -------
    cycles : list of list of int
        Half-edges around each face; empty for merged faces.
    areas : ndarray, shape (faces,)
    merged : int
    left : list of int
        Faces that could not be merged with any neighbour.
    """
    work = _Merging(network, faces, kinds)
    measure = work.sharpest if least_angle > 0 else None
    waiting = [
        (area, i)
        for i, area in enumerate(faces.areas.tolist())
        if kinds[i] >= 0 and (area < least_area or (measure and measure(i) < least_angle))
    ]
    heapq.heapify(waiting)
    merged, left = 0, []
    while waiting:
        area, i = heapq.heappop(waiting)
        if not work.cycles[i] or area != work.areas[i]:
            continue
        into = work.merge(i)
        if into is None:
            left.append(i)
            continue
        merged += 1
        if work.areas[into] < least_area or (measure and measure(into) < least_angle):
            heapq.heappush(waiting, (work.areas[into], into))
    left = [i for i in left if work.cycles[i]]
    return work.cycles, np.array(work.areas), merged, left


class _Merging:
    """Faces as cycles of half-edges that can be merged."""

    def __init__(self, network: Network, faces: Faces, kinds):
        self.nodes = network.nodes
        self.start = half_edge_starts(network).tolist()
        ends = network.nodes[network.edges]
        self.length = np.sqrt(((ends[:, 1] - ends[:, 0]) ** 2).sum(axis=1)).tolist()
        self.cycles = [list(cycle) for cycle in faces.cycles]
        self.areas = faces.areas.tolist()
        self.face = faces.face.tolist()
        self.kinds = kinds

    def sharpest(self, i: int) -> float:
        """Return the sharpest corner of a face, degrees."""
        corners = self.nodes[[self.start[h] for h in self.cycles[i]]]
        return float(Rings.of([corners]).sharpest_corners()[0])

    def merge(self, i: int) -> int | None:
        """Merge a face into a neighbour and return its number; None if there is none."""
        common: dict[int, float] = {}
        for h in self.cycles[i]:
            other = self.face[h ^ 1]
            if other >= 0 and other != i and self.kinds[other] == self.kinds[i]:
                common[other] = common.get(other, 0.0) + self.length[h >> 1]
        for other in sorted(common, key=lambda face: (-common[face], face)):
            cycle = self._union_cycle(i, other)
            if cycle is not None:
                for h in cycle:
                    self.face[h] = other
                self.cycles[other], self.cycles[i] = cycle, []
                self.areas[other] += self.areas[i]
                return other
        return None

    def _union_cycle(self, i: int, other: int) -> list[int] | None:
        """Return the cycle around two faces; None if it is not one simple polygon."""
        rest = self._remaining_chain(i, other)
        more = self._remaining_chain(other, i)
        if rest is None or more is None:
            return None
        nodes = [self.start[h] for h in rest + more]
        return rest + more if len(set(nodes)) == len(nodes) else None

    def _remaining_chain(self, i: int, other: int) -> list[int] | None:
        """Return the half-edges of a face not shared with another, if they form one chain."""
        cycle = self.cycles[i]
        is_common = [self.face[h ^ 1] == other for h in cycle]
        changes = [k for k in range(len(cycle)) if is_common[k - 1] and not is_common[k]]
        if len(changes) != 1:
            return None
        begin = changes[0]
        turned = cycle[begin:] + cycle[:begin]
        return turned[: len(cycle) - sum(is_common)]
