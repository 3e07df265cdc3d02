# SPDX-License-Identifier: GPL-3.0-or-later
"""Regions, and the surfaces, joints, random polygons and holes that cut regions."""

import numpy as np

from ...base.errors import InputError
from ...input import schema
from ...input.values import Values, points_of
from .distributions import check_distribution, draw, draw_lengths, uniform

MOST_JOINTS = 2_000_000  # largest number of segments of all joints together


def outline_of(name: str, values) -> np.ndarray:
    """Return the corners of a valid polygon, counter-clockwise, shape (n, 2), m, not repeated."""
    points = points_of(name, values, 3)
    if (points[0] == points[-1]).all():
        points = points[:-1]
    points = points[(points != np.roll(points, 1, axis=0)).any(axis=1)]
    if len(points) < 3:
        raise InputError(f"{name}: a polygon needs at least 3 different points")
    import shapely

    polygon = shapely.Polygon(points)
    if not polygon.is_valid:
        raise InputError(f"{name} crosses or touches itself: {shapely.is_valid_reason(polygon)}")
    return points if shapely.is_ccw(polygon.exterior) else points[::-1].copy()


def _segments_between(points) -> np.ndarray:
    """Return the segments between successive points, shape (n − 1, 2, 2)."""
    return np.stack([points[:-1], points[1:]], axis=1)


class _Outlined(Values):
    """A group with an outline."""

    outline: np.ndarray

    def _check_values(self) -> None:
        """Check the outline, and orient it counter-clockwise."""
        self.outline = outline_of("outline", self.outline)


class Region(schema.RegionValues, _Outlined):
    """A polygon that is cut into blocks."""


class Hole(schema.HoleValues, _Outlined):
    """A polygon without blocks."""


class Excavation(schema.ExcavationValues, _Outlined):
    """A polygon whose outline cuts blocks that a later stage can remove."""


class Tunnel(schema.TunnelValues):
    """A hole with the shape of an ellipse, a horseshoe (walls under a semicircle) or a box."""

    def _check_values(self) -> None:
        """Set the default height, and check the height of a horseshoe."""
        self.height = self.height or self.width
        if self.shape == "horseshoe" and self.height <= self.width / 2:
            raise InputError(f"height = {self.height:g} of a horseshoe must exceed half its width")

    @property
    def outline(self) -> np.ndarray:
        """Return the corners, shape (n, 2), m, counter-clockwise; those of an ellipse lie on it."""
        a, b = self.width / 2, self.height / 2  # semi-axes
        if self.shape == "rectangle":
            corners = np.array([[-a, -b], [a, -b], [a, b], [-a, b]])
        elif self.shape == "circle":
            angle = 2 * np.pi * (np.arange(self.sides) + 0.5) / self.sides
            corners = np.column_stack([a * np.cos(angle), b * np.sin(angle)])
        else:
            angle = np.linspace(0, np.pi, self.sides // 2 + 1)
            roof = a * np.column_stack([np.cos(angle), np.sin(angle)])
            corners = np.vstack([[[-a, -b], [a, -b]], roof + (0, b - a)])
        return corners + self.centre


class Surface(schema.SurfaceValues):
    """A line from left to right across the regions, below which another material may begin."""

    def _check_values(self) -> None:
        """Raise InputError unless x increases from point to point."""
        if (np.diff(self.points[:, 0]) <= 0).any():
            k = int(np.flatnonzero(np.diff(self.points[:, 0]) <= 0)[0]) + 2
            raise InputError(f"points: x must increase from point to point; point {k} does not")

    def segments(self, centre, radius: float) -> np.ndarray:
        """Return the segments across a circle (m), shape (n, 2, 2)."""
        left, right = centre[0] - radius, centre[0] + radius
        x, y = self.points.T
        head = [[left, y[0]]] if left < x[0] else []
        tail = [[right, y[-1]]] if right > x[-1] else []
        return _segments_between(np.vstack([*head, self.points, *tail]))

    def is_above(self, positions) -> np.ndarray:
        """Return whether the surface lies above positions, shape (n, 2), m."""
        return np.interp(positions[:, 0], *self.points.T) > positions[:, 1]


class JointLine(schema.JointLineValues):
    """A single joint, or a fault, as a chain of straight segments."""

    def _check_values(self) -> None:
        """Raise InputError for fewer than two points."""
        points_of("points", self.points, 2)

    def segments(self, centre, radius: float) -> np.ndarray:
        """Return the segments, shape (n, 2, 2), m."""
        return _segments_between(self.points)

    def expected_segments(self, radius: float) -> float:
        """Return the number of segments."""
        return len(self.points) - 1


class JointSet(schema.JointSetValues):
    """A set of parallel joints, or of joints that are parallel on average.

    Joints are generated from the origin outwards, each line with its own random numbers. With the
    same origin, a larger region therefore contains the joints of a smaller region. Without an
    origin, joints begin at the corner of the region, so that a shift of the region shifts its
    blocks. Joints of random angle are turned about the middle of their trace; infinite joints are
    turned about the point nearest to the middle of the regions.
    """

    def _check_values(self) -> None:
        """Set the angle from the dip, and check all distributions."""
        if self.angle is None:
            self.angle = -self.dip
        for name in ("angle", "spacing", "trace_length", "bridge"):
            check_distribution(name, *self._distribution_arguments(name))

    def _distribution_arguments(self, name: str):
        """Return distribution, mean and deviation of a variable."""
        values = (f"{name}_distribution", name, f"{name}_deviation")
        return tuple(getattr(self, value) for value in values)

    def expected_segments(self, radius: float) -> float:
        """Estimate the number of segments in a circle (m)."""
        line_count = 2 * radius / self.spacing + 1
        period = self.trace_length + self.bridge
        return line_count * (2 * radius / period + 1) if period else line_count

    def segments(self, centre, radius: float, corner=(0.0, 0.0)) -> np.ndarray:
        """Return the joints that reach into a circle (m), shape (n, 2, 2).

        The joints begin at the `corner` (m) if no origin is given.
        """
        origin = np.asarray(corner if self.origin is None else self.origin)
        angle = np.radians(self.angle)
        along, normal = np.array([np.cos(angle), np.sin(angle)]), [-np.sin(angle), np.cos(angle)]
        middle = centre - origin
        s0, p0 = along @ middle, normal @ middle
        tilt = {"constant": 0, "uniform": 1}.get(self.angle_distribution, 3) * self.angle_deviation
        reach = radius / np.cos(np.radians(min(tilt, 75.0)))  # few joints are turned by over 75°
        lines = []
        if np.hypot(*middle) > 1e6 * self.spacing:
            raise InputError("origin is over a million spacings from the regions; move it")
        for side in (1, -1):
            offsets = self._draw_offsets(side, max(side * p0 + reach, 0.0))
            angles = np.radians(self._draw_angles((3 + (side < 0),), len(offsets)))
            for k in np.flatnonzero(abs(side * offsets - p0) <= reach):
                ends, tilt = np.array([[s0 - 2 * reach, s0 + 2 * reach]]), angles[k : k + 1]
                if self.trace_length:
                    ends, tilt = self._draw_traces(side, k, s0 - reach, s0 + reach)
                offset = side * offsets[k]
                lines.append(_segments_on_line(origin, ends, offset, tilt, along, normal))
        return np.concatenate(lines) if lines else np.zeros((0, 2, 2))

    def _draw_angles(self, stream, count: int) -> np.ndarray:
        """Return random deviations of joints from the mean angle, degrees, shape (count,)."""
        if self.angle_distribution == "constant":
            return np.zeros(count)
        numbers = uniform(self.seed, stream, count)
        return draw(numbers, *self._distribution_arguments("angle")) - self.angle

    def _draw_offsets(self, side: int, end: float) -> np.ndarray:
        """Return random distances of lines from the origin on one side, m, to beyond `end`.

        The line through the origin belongs to the upper side.
        """
        count = int(end / self.spacing * 1.2) + 16
        while True:
            offsets = np.cumsum(self._draw_lengths("spacing", (1 + (side < 0),), count))
            if offsets[-1] > end:
                offsets = offsets[: np.searchsorted(offsets, end) + 1]
                return np.append(0.0, offsets) if side > 0 else offsets
            count *= 2

    def _draw_traces(self, side: int, k: int, start: float, stop: float):
        """Return random ends of traces on a line, (n, 2), m from the origin, and angles, rad."""
        period = self.trace_length + self.bridge
        constant = self.trace_length_distribution == self.bridge_distribution == "constant"
        index = k if side > 0 else k + 1
        shift = self.stagger * side * index * period
        key = (int(side < 0), int(index))
        if not constant:
            shift += period * (uniform(self.seed, (7, *key), 1)[0] - 0.5)
        ends, angles = [], []
        for half in (0, 1):
            pairs = self._draw_trace_ends((*key, half), max(stop - shift, shift - start, period))
            pairs = shift + pairs if half == 0 else shift - pairs[:, ::-1]
            keep = (pairs[:, 1] > start) & (pairs[:, 0] < stop)
            ends.append(pairs[keep])
            angles.append(np.radians(self._draw_angles((8, *key, half), len(pairs)))[keep])
        return np.concatenate(ends), np.concatenate(angles)

    def _draw_trace_ends(self, stream, end: float) -> np.ndarray:
        """Return random starts and ends of traces in one direction, (n, 2), m, to beyond `end`.

        The first direction begins with a trace, the second with a bridge.
        """
        count = int(end / (self.trace_length + self.bridge) * 1.2) + 8
        while True:
            lengths = self._draw_lengths("trace_length", (5, *stream), count)
            gaps = np.zeros(count)
            if self.bridge:
                gaps = self._draw_lengths("bridge", (6, *stream), count)
            finish = np.cumsum(lengths + gaps)
            if finish[-1] > end:
                if stream[2] == 0:
                    return np.column_stack([finish - lengths - gaps, finish - gaps])
                return np.column_stack([finish - lengths, finish])
            count *= 2

    def _draw_lengths(self, name: str, stream, count: int) -> np.ndarray:
        """Return random values of a length with a distribution, m, shape (count,)."""
        numbers = uniform(self.seed, stream, count)
        return draw_lengths(numbers, *self._distribution_arguments(name))


def _segments_on_line(origin, ends, p: float, angles, direction, normal) -> np.ndarray:
    """Return segments on a line at a distance p (m) from the origin, turned about their middles."""
    middle, half = ends.mean(axis=1), 0.5 * (ends[:, 1] - ends[:, 0])
    foot = origin + middle[:, None] * direction + p * np.asarray(normal)
    arm = np.outer(np.cos(angles), direction) + np.outer(np.sin(angles), normal)
    arm *= half[:, None]
    return np.stack([foot - arm, foot + arm], axis=1)


class Voronoi(schema.VoronoiValues):
    """Random polygons of a Voronoi diagram."""

    def expected_segments(self, radius: float) -> float:
        """Estimate the number of segments in a circle (m)."""
        return 3 * (2 * (min(radius / self.size, 1e9) + 3)) ** 2

    def segments(self, centre, radius: float) -> np.ndarray:
        """Return the sides of the polygons in a circle (m), shape (n, 2, 2)."""
        from scipy.spatial import Voronoi as Diagram

        half = radius + 3 * self.size
        count = max(4, round((2 * half / self.size) ** 2))
        numbers = uniform(self.seed, (9,), 2 * count).reshape(-1, 2)
        points = half * (2 * numbers - 1)
        for _ in range(self.iterations):
            points = _centroids(Diagram(_mirror(points, half, 6 * self.size)), count)
        diagram = Diagram(_mirror(points, half, 6 * self.size))
        sides = np.array(diagram.ridge_vertices)
        bounded = (diagram.ridge_points < count).any(axis=1) & (sides >= 0).all(axis=1)
        return diagram.vertices[sides[bounded]] + centre


def _mirror(points, half: float, band: float) -> np.ndarray:
    """Return points and their mirror images at the sides of a square, which bound all polygons."""
    images = [points]
    for axis in (0, 1):
        for side in (-half, half):
            image = points[abs(points[:, axis] - side) < band].copy()
            image[:, axis] = 2 * side - image[:, axis]
            images.append(image)
    return np.concatenate(images)


def _centroids(diagram, count: int) -> np.ndarray:
    """Return the centroids of the first polygons of a Voronoi diagram, shape (count, 2).

    Each polygon consists of the triangles between its point and its sides.
    """
    points, sides = diagram.points, np.array(diagram.ridge_vertices)
    area, moment = np.zeros(count), np.zeros((count, 2))
    bounded = (sides >= 0).all(axis=1)
    ends = diagram.vertices[sides[bounded]]
    for side in (0, 1):
        owner = diagram.ridge_points[bounded, side]
        mask = owner < count
        index, a, b = owner[mask], ends[mask, 0], ends[mask, 1]
        p = points[index]
        size = 0.5 * abs(
            (a[:, 0] - p[:, 0]) * (b[:, 1] - p[:, 1]) - (a[:, 1] - p[:, 1]) * (b[:, 0] - p[:, 0])
        )
        area += np.bincount(index, size, count)
        third = (a + b + p) / 3
        moment += np.column_stack([np.bincount(index, size * xy, count) for xy in third.T])
    return np.where(area[:, None] > 0, moment / np.maximum(area, 1e-300)[:, None], points[:count])


class Cutting(schema.CuttingValues):
    """Tolerances for cutting, and treatment of slivers."""
