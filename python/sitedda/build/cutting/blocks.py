# SPDX-License-Identifier: GPL-3.0-or-later
"""Cut regions into blocks by joints."""

import os
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import reduce
from itertools import pairwise

import numpy as np
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ...base.arrays import parts_of
from ...base.errors import InputError
from ...base.numbers import counted
from . import geometry
from .merging import merge_slivers
from .network import Network, merge_close_nodes, split_segments, trace_faces, without_dead_ends
from .rings import Rings
from .small_blocks import Sliver, in_words, slivers

_ROUNDING = 1e-9  # tolerance of positions / size of the regions
_BITS = 8  # rounding error of coordinates far from (0, 0), in units in the last place
_SLIVER_AREA = 1e-3  # smallest area of a block / mean area
_SLIVER_EDGE = 1e-3  # shortest edge / square root of the mean area
_BYTES = 4000  # bytes of memory per block during cutting
MOST_CORNERS = 512  # largest number of corners of a block
_MARGIN = 1.25  # factor on the limit for estimated crossings; the exact limit is checked later
_NAMED = 5  # largest number of positions in a message


@dataclass
class Blocks:
    """The blocks cut from regions."""

    # Corners, m, counter-clockwise, beginning at the lowest one; each of shape (corners, 2)
    polygons: list[np.ndarray] = field(default_factory=list)
    # Joint of each edge; edge i connects corners i and i + 1
    edge_joints: list[list[str]] = field(default_factory=list)
    # Corners, clockwise, and joints of the holes within a block, if rings are allowed
    holes: list[list[tuple[np.ndarray, list[str]]]] = field(default_factory=list)
    names: list[str] = field(default_factory=list)
    materials: list[str] = field(default_factory=list)
    regions: list[str] = field(default_factory=list)
    messages: list[str] = field(default_factory=list)  # on removed, merged or remaining blocks
    slivers: list[Sliver] = field(default_factory=list)  # remaining slivers
    area: float = 0.0  # area of the regions without holes, m²
    dead_ends: int = 0  # number of removed edges of joints that end inside a block
    loops: int = 0  # number of removed loops of joints inside a block
    merged: int = 0  # number of slivers that have been merged with a neighbour

    def __len__(self) -> int:
        return len(self.polygons)

    @property
    def joints(self) -> list[str]:
        """Return the joint with the greatest length on the outline of each block, by name."""
        return main_joints(self.polygons, self.edge_joints)


def main_joints(polygons: Sequence, edge_joints: Sequence[Sequence[str]]) -> list[str]:
    """Return the joint with the greatest length on each outline; blank if no edge has a joint."""
    lengths = Rings.of(polygons).edge_lengths().tolist() if len(polygons) else []
    result, start = [], 0
    for names in edge_joints:
        total: dict[str, float] = {}
        for name, length in zip(names, lengths[start : start + len(names)], strict=True):
            if name:
                total[name] = total.get(name, 0.0) + length
        start += len(names)
        result.append(max(sorted(total), key=total.__getitem__) if total else "")
    return result


def cut(
    regions: Sequence[geometry.Region],
    joints: Sequence[geometry.JointLine | geometry.JointSet | geometry.Voronoi] = (),
    surfaces: Sequence[geometry.Surface] = (),
    holes: Sequence[geometry.Hole | geometry.Tunnel] = (),
    excavations: Sequence[geometry.Excavation] = (),
    settings: geometry.Cutting | None = None,
    rings: bool = False,
) -> Blocks:
    """Cut regions into blocks.

    Parameters
    ----------
    regions : sequence of Region
        They must not overlap.
    joints : sequence of JointLine, JointSet and Voronoi
    surfaces : sequence of Surface
        Surfaces from the top down.
    holes : sequence of Hole and Tunnel
    excavations : sequence of Excavation
    settings : Cutting
    rings : bool
        Whether a block may surround other blocks or a hole; it must then be meshed.

    Returns
    -------
    Blocks
        In an order that does not depend on the order of the input.

    Raises
    ------
    InputError
        If the regions cannot be cut, or would give too many blocks (checked before the cut).

    Notes
    -----
    If two cuts coincide, the edge gets the joint of the cut that is first in this list: hole,
    excavation, single joint, surface, joint set, Voronoi polygons, region.
    """
    settings = settings or geometry.Cutting()
    return _Cut(regions, joints, surfaces, holes, excavations, settings).blocks(rings)


class _Cut:
    """The steps of `cut`; coordinates are relative to the middle of the regions."""

    def __init__(self, regions, joints, surfaces, holes, excavations, settings):
        if not regions:
            raise InputError("there is nothing to cut; give a region")
        self.regions, self.surfaces, self.settings = regions, surfaces, settings
        self.excavations = excavations
        corners = np.concatenate([region.outline for region in regions])
        self.centre = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
        self.size = float((corners.max(axis=0) - corners.min(axis=0)).max())
        # Far from (0, 0), the rounding error of coordinates exceeds the tolerance by size.
        self.rounding = _BITS * float(np.spacing(abs(corners).max()))
        self.tolerance = settings.tolerance or max(_ROUNDING * self.size, self.rounding)
        self.messages: list[str] = []
        self.outlines = [self._centred_polygon(region.outline) for region in regions]
        self._check_overlap()
        self.holes = [self._centred_polygon(hole.outline) for hole in holes]
        self.pits = [self._centred_polygon(excavation.outline) for excavation in excavations]
        self._check_inside(holes, self.holes, "hole")
        self._check_inside(excavations, self.pits, "excavation")
        # Polygons are united one by one, because a union of many can omit some (GEOS 3.14).
        self.domain = reduce(shapely.union, self.outlines)
        self.domain = reduce(shapely.difference, self.holes, self.domain)
        if self.domain.area <= 0:
            raise InputError("the holes cover the regions completely")
        self._check_order()
        shapely.prepare(self.domain)
        self._gather_segments(joints, surfaces, holes, excavations)

    def _centred_polygon(self, outline) -> shapely.Polygon:
        """Return a polygon with coordinates relative to the middle of the regions."""
        return shapely.Polygon(outline - self.centre)

    def _check_overlap(self) -> None:
        """Raise InputError if two regions overlap."""
        first, second = shapely.STRtree(self.outlines).query(self.outlines, predicate="intersects")
        for i, k in zip(first.tolist(), second.tolist(), strict=True):
            common = shapely.intersection(self.outlines[i], self.outlines[k]).area if i < k else 0
            if common > self.tolerance * self.size:
                names = f"{self.regions[i].name!r} and {self.regions[k].name!r}"
                raise InputError(f"the regions {names} overlap by {common:g} m²")

    def _check_inside(self, items, polygons, kind: str) -> None:
        """Raise InputError for a hole or excavation that overlaps no region."""
        for item, polygon in zip(items, polygons, strict=True):
            if not any(shapely.intersection(polygon, ring).area > 0 for ring in self.outlines):
                raise InputError(f"the {kind} {item.name!r} lies outside all regions")

    def _check_order(self) -> None:
        """Raise InputError if a surface lies above the one that precedes it, across the regions."""
        left, right = np.array(self.domain.bounds)[[0, 2]] + self.centre[0]
        for i, (upper, lower) in enumerate(pairwise(self.surfaces), start=1):
            x = np.clip(np.concatenate([upper.points[:, 0], lower.points[:, 0]]), left, right)
            x = np.concatenate([x, [left, right]])
            difference = np.interp(x, *lower.points.T) - np.interp(x, *upper.points.T)
            if difference.min() >= -self.tolerance and difference.max() > self.tolerance:
                raise InputError(f"surface {i + 1} lies above surface {i}: give the surfaces from "
                                 "the top down")  # fmt: skip

    def _gather_segments(self, joints, surfaces, holes, excavations) -> None:
        """Collect the segments of all cuts with their labels; check their expected number first."""
        reach = self.size * 0.75
        sets = [joint for joint in joints if hasattr(joint, "expected_segments")]
        segment_count = sum(joint.expected_segments(reach) for joint in sets)
        if segment_count > geometry.MOST_JOINTS:
            raise InputError(
                f"the joints would have about {segment_count:.2g} segments, more than "
                f"{geometry.MOST_JOINTS:.2g}; choose a larger spacing, or a smaller region"
            )
        rows = []  # tuples: rank of the kind of cut, joint, segments, whether they are an outline
        for hole, polygon in zip(holes, self.holes, strict=True):
            rows.append((0, hole.joint, _polygon_sides(polygon), True))
        for excavation, polygon in zip(excavations, self.pits, strict=True):
            sides = self._clip_to_regions(_polygon_sides(polygon), "")
            rows.append((1, excavation.joint, sides, True))
        ranks = {geometry.JointLine: 2, geometry.JointSet: 4, geometry.Voronoi: 5}
        cutters = [(ranks[type(joint)], joint) for joint in joints]
        for rank, cutter in [*cutters, *((3, surface) for surface in surfaces)]:
            rows.append((rank, cutter.joint, self._clip_cutter(cutter, reach), False))
        for region, polygon in zip(self.regions, self.outlines, strict=True):
            rows.append((6, region.joint, _polygon_sides(polygon), True))
        keys = sorted({row[:2] for row in rows})
        self.joint_names = [name for _, name in keys]
        counts = [len(row[2]) for row in rows]
        self.segments = np.concatenate([row[2] for row in rows])
        self.labels = np.repeat([keys.index(row[:2]) for row in rows], counts)
        self.outline = np.repeat([row[3] for row in rows], counts)
        self._check_block_count()

    def _clip_cutter(self, cutter, reach: float) -> np.ndarray:
        """Return the segments of a joint or surface in its regions; errors name this joint."""
        try:
            options = {}
            if isinstance(cutter, geometry.JointSet):
                options["corner"] = self._lower_left_corner(cutter)
            segments = cutter.segments(self.centre, reach, **options)
            return self._clip_to_regions(segments - self.centre, cutter)
        except InputError as error:
            error.cause = cutter
            raise

    def _lower_left_corner(self, cutter) -> np.ndarray:
        """Return the lower left corner of the box around the regions of a joint set, m."""
        cut = [region.outline for region in self.regions if cutter.region in ("", region.name)]
        return np.min([outline.min(axis=0) for outline in cut or [self.centre[None]]], axis=0)

    def _clip_to_regions(self, segments, cutter) -> np.ndarray:
        """Clip segments to all regions, or to the region of a joint set."""
        domain, target = self.domain, getattr(cutter, "region", "")
        if target:
            names = [region.name for region in self.regions]
            if target not in names:
                raise InputError(f"region = {target!r}: the regions are {', '.join(names)}")
            domain = shapely.intersection(domain, self.outlines[names.index(target)])
            shapely.prepare(domain)
        if not len(segments):
            return segments
        lines = shapely.linestrings(segments)
        lines = lines[shapely.intersects(domain, lines)]
        crossing = ~shapely.contains_properly(domain, lines)
        lines[crossing] = shapely.intersection(lines[crossing], domain)
        ends, start = segments_of(lines)
        return np.stack([ends[start], ends[start + 1]], axis=1)

    def _check_block_count(self) -> None:
        """Raise InputError if the estimated number of blocks exceeds the limit or the memory.

        Segments of lengths L at angles θ and at random positions in an area A cross
        ½ Σ Lᵢ Lⱼ |sin(θᵢ − θⱼ)| / A times on average.
        """
        joints = self.segments[~self.outline]
        along = joints[:, 1] - joints[:, 0]
        bins = 90
        angle = np.mod(np.arctan2(along[:, 1], along[:, 0]), np.pi)
        bin_index = np.minimum((angle * bins / np.pi).astype(int), bins - 1)
        length = np.bincount(bin_index, np.hypot(*along.T), bins)
        directions = np.arange(bins) * np.pi / bins
        sine = abs(np.sin(directions[:, None] - directions))
        crossings = 0.5 * float(length @ sine @ length) / self.domain.area
        block_count = crossings + len(joints) + len(self.regions)
        limit = self.settings.most_blocks
        if crossings > _MARGIN * limit:
            raise InputError(
                f"the joints would form about {crossings:.2g} blocks, one per crossing, more than "
                f"most_blocks = {limit}; choose larger spacings, or a smaller region"
            )
        memory = _free_memory()
        if block_count * _BYTES > memory:
            raise InputError(
                f"cutting about {block_count:.2g} blocks needs {block_count * _BYTES / 1e9:.2g} GB "
                f"of memory, but only {memory / 1e9:.2g} GB are free"
            )

    def blocks(self, rings: bool = False) -> Blocks:
        """Return the blocks; slivers are merged, reported or rejected."""
        network = split_segments(self.segments, self.labels, self.outline, self.tolerance)
        network, dead, loops = without_dead_ends(network)
        faces = trace_faces(network)
        if len(faces.cycles) > self.settings.most_blocks:
            raise InputError(
                f"the joints form {len(faces.cycles)} blocks, more than most_blocks = "
                f"{self.settings.most_blocks}; choose larger spacings, or a smaller region"
            )
        network, faces = self._merge_short_edges(network, faces)
        self._report_loops(loops)
        polygons = face_polygons(network, faces.cycles)
        inner = self._find_enclosed(network, faces, polygons)
        if inner and not rings:
            self._reject_rings(network, inner)
        for face, cycles in inner.items():
            holes = [network.nodes[network.starts[cycle]] for cycle in cycles]
            polygons[face] = shapely.Polygon(polygons[face].exterior, holes)
        kinds, keys = self._find_kinds(polygons)
        self._check_area(shapely.area(polygons[kinds >= 0]))
        mean = self.domain.area / max(1, int((kinds >= 0).sum()))
        limit = self.settings.least_area
        limit = _SLIVER_AREA * mean if limit is None else limit
        cycles, count = faces.cycles, 0
        if self.settings.slivers == "merge":
            cycles, count = merge_slivers(network, faces, kinds, limit, self.settings.least_angle)
        keep = [i for i, cycle in enumerate(cycles) if cycle and kinds[i] >= 0]
        inner = [inner.get(i, []) for i in keep]
        cycles, keys = [cycles[i] for i in keep], [keys[kinds[i]] for i in keep]
        result = self._order_blocks(network, cycles, keys, inner)
        result.area, result.dead_ends, result.loops = self.domain.area, dead, len(loops)
        result.merged = count
        self._judge_slivers(result, mean, limit)
        result.messages = self.messages
        return result

    def _merge_short_edges(self, network: Network, faces):
        """Return network and faces after close corners have been merged, if this is requested."""
        limit = self.settings.least_edge
        if limit is None:
            limit = _SLIVER_EDGE * np.sqrt(self.domain.area / max(1, len(faces.cycles)))
        if self.settings.slivers != "merge" or limit <= self.tolerance:
            return network, faces
        old_count = network.moved
        network, limit = merge_close_nodes(network, limit)
        network, _, _ = without_dead_ends(network)
        if network.moved > old_count:
            corners = counted(network.moved - old_count, "corner was", "corners were")
            self.messages.append(f"{corners} merged with others closer than {limit:.3g} m")
        return network, trace_faces(network)

    def _report_loops(self, loops) -> None:
        """Add a message on removed loops of joints."""
        if loops:
            self.messages.append(
                f"{counted(len(loops), 'loop', 'loops')} of joints inside one block omitted, for "
                f"example at {self._format_points(loops)}"
            )

    def _format_points(self, points) -> str:
        """Return the first positions as text, for messages."""
        texts = [f"({x:.6g}, {y:.6g})" for x, y in np.array(points[:_NAMED]) + self.centre]
        return ", ".join(texts) + (" …" if len(points) > _NAMED else "")

    def _find_kinds(self, polygons):
        """Return the key of each face (−1: outside), and the keys: region, excavation, surface."""
        points = shapely.point_on_surface(polygons)
        region = _find_containing(points, self.outlines)
        region[_find_containing(points, self.holes) >= 0] = -1
        pit = _find_containing(points, self.pits)
        positions = shapely.get_coordinates(points) + self.centre
        is_above = np.array([surface.is_above(positions) for surface in self.surfaces], dtype=bool)
        layer = np.full(len(polygons), -1)
        for i, surface in enumerate(self.surfaces):
            if surface.material:
                layer[is_above[i]] = i
        keys, kinds = np.unique(np.column_stack([region, pit, layer]), axis=0, return_inverse=True)
        return np.where(region >= 0, kinds.ravel(), -1), keys

    def _find_enclosed(self, network: Network, faces, polygons) -> dict[int, list[np.ndarray]]:
        """Return, by face, the half-edges around each group of other faces that lies inside it."""
        count = len(network.nodes)
        ends = network.edges.T
        graph = coo_array((np.ones(ends.shape[1]), ends), shape=(count, count))
        _, part = connected_components(graph, directed=False)
        parts, first_edge = np.unique(part[network.edges[:, 0]], return_index=True)
        if len(parts) < 2:
            return {}
        nodes = network.edges[first_edge, 0]
        tree = shapely.STRtree(polygons)
        node, face = tree.query(shapely.points(network.nodes[nodes]), predicate="within")
        result: dict[int, list[np.ndarray]] = {}
        for n in np.unique(node):
            candidates = face[node == n]
            f = int(candidates[faces.areas[candidates].argmin()])
            point = self._point_inside(network, faces.cycles[f])
            if shapely.contains_xy(self.domain, *point):
                result.setdefault(f, []).append(_outer_cycle(network, faces, part == parts[n]))
        return result

    def _reject_rings(self, network: Network, inner) -> None:
        """Raise InputError for a block that surrounds a hole or other blocks."""
        cycle = next(iter(inner.values()))[0]
        raise InputError(
            "a block is a ring around the hole or region with a corner at "
            f"{self._format_points(network.nodes[network.starts[cycle[:1]]])}; cut it by a "
            "joint, or mesh it"
        )

    @staticmethod
    def _point_inside(network: Network, cycle) -> np.ndarray:
        """Return a point just inside the longest edge of a face."""
        start = network.starts
        edges = np.array(cycle)
        a, b = network.nodes[start[edges]], network.nodes[start[edges ^ 1]]
        longest = int(((b - a) ** 2).sum(axis=1).argmax())
        x, y = b[longest] - a[longest]
        return 0.5 * (a[longest] + b[longest]) + 1e-6 * np.array([-y, x])

    def _check_area(self, areas) -> None:
        """Raise InputError if the blocks do not fill the regions."""
        difference = abs(float(areas.sum()) - self.domain.area)
        if difference > 1e-9 * self.domain.area:
            raise InputError(
                f"the area of the blocks differs by {difference:g} m² from the area of the "
                f"regions, {self.domain.area:g} m²: outlines lie closer to each other than the "
                "tolerance; let these outlines share corners"
            )

    def _order_blocks(self, network: Network, cycles, keys, inner) -> Blocks:
        """Return the blocks with corners, edge joints and names, in a canonical order."""
        edges = np.concatenate([np.array(cycle) for cycle in cycles])
        rings = Rings(network.nodes[network.starts[edges]], list(map(len, cycles)))
        labels = network.labels[edges >> 1]
        rings, corners, labels, order = rings.in_order(labels, self.size, self.rounding)
        self._check_corners(rings)
        polygons = parts_of(rings.corners[corners] + self.centre, rings.first)
        joints = np.array(self.joint_names, dtype=object)[labels].tolist()
        blocks, numbers = Blocks(), Counter()
        for i in order.tolist():
            region, pit, layer = keys[i]
            stem = self.excavations[pit].name if pit >= 0 else self.regions[region].name
            numbers[stem] += 1
            material = self.surfaces[layer].material if layer >= 0 else ""
            blocks.polygons.append(polygons[i])
            blocks.edge_joints.append(joints[rings.first[i] : rings.first[i + 1]])
            blocks.holes.append([
                (network.nodes[network.starts[cycle]] + self.centre,
                 [self.joint_names[label] for label in network.labels[cycle >> 1]])
                for cycle in inner[i]
            ])  # fmt: skip
            blocks.names.append(f"{stem}_{numbers[stem]}")
            blocks.regions.append(self.regions[region].name)
            blocks.materials.append(material or self.regions[region].material)
        return blocks

    def _check_corners(self, rings: Rings) -> None:
        """Raise InputError for a block with too many corners."""
        count = np.diff(rings.first)
        worst = int(count.argmax())
        if count[worst] > MOST_CORNERS:
            raise InputError(
                f"the block at {self._format_points(rings.corners[rings.first[worst]][None])} has "
                f"{count[worst]} corners, more than {MOST_CORNERS}; draw its outline with fewer "
                "points, or cut the block"
            )

    def _judge_slivers(self, blocks: Blocks, mean: float, least_area: float) -> None:
        """Report merged and remaining slivers; raise InputError if slivers are refused."""
        least_edge = self.settings.least_edge
        if least_edge is None:
            least_edge = _SLIVER_EDGE * np.sqrt(mean)
        if blocks.merged:
            count = counted(blocks.merged, "sliver was", "slivers were")
            self.messages.append(f"{count} merged with the block that shares the longest edge")
        limits = {"least_area": least_area, "least_edge": least_edge}
        limits["least_angle"] = self.settings.least_angle
        blocks.slivers = slivers(blocks.polygons, blocks.names, **limits)
        text = in_words(blocks.slivers)
        if text and self.settings.slivers == "refuse":
            raise InputError(f"{text}; merge them (slivers = 'merge') or move the joints")
        self.messages += [text] if text else []


def segments_of(lines) -> tuple[np.ndarray, np.ndarray]:
    """Return the points of lines and collections of lines, m, and the points that begin segments.

    Each segment ends at the following point; parts without length have no segments.
    """
    parts = shapely.get_parts(shapely.get_parts(lines))
    parts = parts[(shapely.get_type_id(parts) == 1) & (shapely.length(parts) > 0)]
    points, owner = shapely.get_coordinates(parts, return_index=True)
    return points, np.flatnonzero(owner[1:] == owner[:-1])


def _polygon_sides(polygon: shapely.Polygon) -> np.ndarray:
    """Return the sides of a polygon, shape (n, 2, 2)."""
    corners = shapely.get_coordinates(polygon.exterior)
    return np.stack([corners[:-1], corners[1:]], axis=1)


def _outer_cycle(network: Network, faces, nodes) -> np.ndarray:
    """Return the half-edges around a part of the network, clockwise; `nodes` selects the part."""
    start = network.starts
    outer = np.flatnonzero((faces.face < 0) & nodes[start])
    following = dict(zip(start[outer].tolist(), outer.tolist(), strict=True))
    cycle = [outer[0]]
    while (successor := following[int(start[cycle[-1] ^ 1])]) != cycle[0]:
        cycle.append(successor)
    return np.array(cycle)


def _find_containing(points, polygons) -> np.ndarray:
    """Return the index of the polygon that contains each point; −1: none."""
    result = np.full(len(points), -1)
    if polygons:
        point, polygon = shapely.STRtree(polygons).query(points, predicate="within")
        result[point] = polygon
    return result


def face_polygons(network: Network, cycles) -> np.ndarray:
    """Return the faces as shapely polygons; `cycles`: half-edges around each face."""
    if not cycles:
        return np.array([], dtype=object)
    owner = np.repeat(np.arange(len(cycles)), list(map(len, cycles)))
    corners = network.nodes[network.starts[np.concatenate(cycles)]]
    return shapely.polygons(shapely.linearrings(corners, indices=owner))


def _free_memory() -> float:
    """Return the free memory in bytes; infinite if the system does not report it."""
    try:
        with open("/proc/meminfo") as file:
            lines = dict(line.split(":") for line in file)
        return 1024.0 * int(lines["MemAvailable"].split()[0])
    except (OSError, KeyError, ValueError):
        pages = getattr(os, "sysconf", lambda _: -1)("SC_PHYS_PAGES")
        return float(pages) * os.sysconf("SC_PAGE_SIZE") if pages > 0 else float("inf")
