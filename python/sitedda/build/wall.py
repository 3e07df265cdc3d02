# SPDX-License-Identifier: GPL-3.0-or-later
"""Walls of courses with doors and windows, lintels, arches and ties, seen from the front."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from ..base.errors import InputError, located
from ..input import schema
from .cutting.distributions import uniform
from .cutting.rings import Rings
from .masonry import MOST_BLOCKS, rectangle

_BONDS = {"running": (1.0, 0.5), "header": (0.5, 0.25), "rubble": (1.0, 0.5)}
_LEAST = 0.3  # shortest stone at wall ends and openings / length of a stone
_OVERLAP = 0.2  # smallest offset of head joints of successive rubble courses / stone length
_SAME = 1e-9  # levels are equal if their difference is below this fraction of the wall size
_HEIGHT, _LENGTH = 1, 2  # streams of random numbers


class Opening(schema.OpeningValues):
    """A door, a window or a niche in a wall."""

    def groups(self, folder, all_groups) -> tuple[list[tuple[str, dict]], list[str]]:
        """Raise InputError unless the wall exists; return no groups: the wall makes the blocks."""
        walls = [values.get("name", MasonryWall.name) for kind, values in all_groups
                 if kind == "masonry_wall"]  # fmt: skip
        if self.wall not in walls:
            raise InputError(f"wall = {self.wall!r} is not the name of a &masonry_wall")
        return [], []

    def with_defaults(self, wall: MasonryWall) -> Opening:
        """Return the opening with default values from its wall; reject it if it leaves the wall."""
        values = dict(vars(self))
        course, stone = wall.height / wall.courses, wall.stone
        values["depth"] = course if self.depth is None else self.depth
        values["bearing"] = 0.5 * stone if self.bearing is None else self.bearing
        values["rise"] = 0.25 * self.width if self.rise is None else self.rise
        values["material"] = self.material or wall.material
        values["joint"] = self.joint or wall.joint
        opening = Opening(**values)
        opening.check(wall)
        return opening

    def check(self, wall: MasonryWall) -> None:
        """Raise InputError if the opening is not within the wall, or its arch is too high."""
        if self.head == "arch" and self.rise > 0.5 * self.width * (1 + 1e-12):
            raise InputError(f"rise = {self.rise:g} is above half of the width")
        if self.head == "arch" and self.rise >= self.height:
            raise InputError(f"rise = {self.rise:g} must be less than the height of the opening")
        left, bottom, right, top = self.box
        slack = _SAME * (wall.width + wall.height)
        is_within = left >= wall.left - slack and right <= wall.left + wall.width + slack
        if not (is_within and bottom >= wall.bottom - slack
                and top <= wall.bottom + wall.height + slack):  # fmt: skip
            raise InputError(f"the opening with its head, x = {left:g} to {right:g} m and y = "
                             f"{bottom:g} to {top:g} m, is not within the wall")  # fmt: skip

    @property
    def springing(self) -> float:
        """Return the level at which the head of the opening begins, m."""
        return self.bottom + self.height - (self.rise if self.head == "arch" else 0.0)

    @property
    def top(self) -> float:
        """Return the level of the upper side of the head, m."""
        return self.bottom + self.height + (0.0 if self.head == "none" else self.depth)

    @property
    def box(self) -> tuple[float, float, float, float]:
        """Return left, bottom, right and top of the opening with its head, m."""
        bearing = 0.0 if self.head == "none" else self.bearing
        return self.left - bearing, self.bottom, self.left + self.width + bearing, self.top

    def gaps(self) -> list[tuple[float, float, float, float]]:
        """Return the rectangles without courses: left, bottom, right, top, m."""
        right = self.left + self.width
        boxes = [(self.left, self.bottom, right, self.springing)]
        if self.head != "none":
            boxes.append((self.left - self.bearing, self.springing, right + self.bearing, self.top))
        return boxes

    def blocks(self) -> list[tuple[str, np.ndarray]]:
        """Return names and corners (m) of the lintel, or of voussoirs and springers."""
        if self.head == "none":
            return []
        _, box = self.gaps()
        if self.head == "lintel":
            return [(f"{self.name}_lintel", rectangle(*box))]
        half, centre = 0.5 * self.width, self.left + 0.5 * self.width
        radius = (half**2 + self.rise**2) / (2 * self.rise)
        middle = np.array([centre, self.springing + self.rise - radius])
        springing_angle = math.atan2(self.springing - middle[1], half)
        angle = np.linspace(springing_angle, math.pi - springing_angle, self.voussoirs + 1)
        rays = np.column_stack([np.cos(angle), np.sin(angle)])
        ends, outline = middle + radius * rays, rectangle(*box)
        result = []
        for i in range(self.voussoirs):
            stone = _left_part(outline, middle, rays[i])
            stone = _left_part(stone, middle, -rays[i + 1])
            stone = _left_part(stone, ends[i + 1], ends[i] - ends[i + 1])
            result.append((f"{self.name}_{i + 1}", stone))
        for side, ray, end in (("right", rays[0], ends[0]), ("left", -rays[-1], ends[-1])):
            stone = _left_part(outline, middle, -ray)
            sign = 1.0 if side == "right" else -1.0
            stone = _left_part(stone, end, np.array([0.0, -sign]))
            if len(stone) > 2 and np.divide(*Rings.of([stone, outline]).areas()) > 1e-6:
                result.append((f"{self.name}_{side}", stone))
        return result


class MasonryWall(schema.MasonryWallValues):
    """A wall of courses, seen from the front."""

    def _check_values(self) -> None:
        """Check the stiffness of tie rods and the number of stones."""
        if self.ties is not None and self.tie_stiffness is None:
            raise InputError("ties need tie_stiffness")
        length = self.stone * _BONDS[self.bond][0]
        if self.courses * (self.width / length + 1) > MOST_BLOCKS:
            raise InputError(f"courses = {self.courses} would need more than {MOST_BLOCKS} blocks")

    def groups(self, folder, all_groups) -> tuple[list[tuple[str, dict]], list[str]]:
        """Generate blocks and tie rods, and no notes; see `kinds`."""
        own_values = [values for kind, values in all_groups
               if kind == "opening" and values.get("wall", Opening.wall) == self.name]  # fmt: skip
        openings = [self._make_opening(values) for values in own_values]
        _require_apart(openings)
        stones = [(f"{self.name}_{i}", corners, self.material, self.joint)
                  for i, corners in enumerate(self._stone_corners(openings), 1)]  # fmt: skip
        for item in openings:
            blocks = item.blocks()
            stones += [(name, corners, item.material, item.joint) for name, corners in blocks]
        names = ("name", "vertices", "material", "joint")
        result = [("block", dict(zip(names, stone, strict=True))) for stone in stones]
        return result + self._tie_rods(stones), []

    def _make_opening(self, values: dict) -> Opening:
        """Return an opening that fits the wall; an error names the opening."""
        with located(f"opening {values.get('name', Opening.name)!r}"):
            return Opening(**values).with_defaults(self)

    def _course_levels(self, openings: list[Opening]) -> np.ndarray:
        """Return the levels between courses, m."""
        fixed = [self.bottom, self.bottom + self.height]
        for opening in openings:
            fixed += [level for gap in opening.gaps() for level in (gap[1], gap[3])]
        fixed = _distinct_levels(fixed, _SAME * (self.width + self.height))
        course, levels = self.height / self.courses, [fixed[0]]
        for part, (low, high) in enumerate(pairwise(fixed)):
            count = max(1, round((high - low) / course))
            fractions = np.arange(1, count) / count
            if self.bond == "rubble":
                heights = 1 + self.variation * (2 * uniform(self.seed, (_HEIGHT, part), count) - 1)
                fractions = np.cumsum(heights)[:-1] / heights.sum()
            levels += [*(low + fractions * (high - low)), high]
        return np.array(levels)

    def _stone_corners(self, openings: list[Opening]) -> Iterator[np.ndarray]:
        """Yield the corners of the stones, course by course, m."""
        gaps = [gap for opening in openings for gap in opening.gaps()]
        joints_below: list[float] = []
        for number, (low, high) in enumerate(pairwise(self._course_levels(openings))):
            middle = 0.5 * (low + high)
            cut = sorted((a, b) for a, y0, b, y1 in gaps if y0 < middle < y1)
            joints, start, stones = self._head_joints(number, joints_below), self.left, []
            for left, right in [*cut, (self.left + self.width,) * 2]:
                stones += self._stones_between(start, left, joints)
                start = max(start, right)
            joints_below = [right for _, right in stones]
            yield from (rectangle(a, low, b, high) for a, b in stones)

    def _head_joints(self, course: int, joints_below: list[float]) -> np.ndarray:
        """Return the positions of the head joints of a course without openings, m."""
        fraction, shift = _BONDS[self.bond]
        length = self.stone * fraction
        count = math.ceil(self.width / length) + 2
        if self.bond != "rubble":
            offset = shift * self.stone if course % 2 else 0.0
            return self.left + length * np.arange(count) - offset
        lengths = length * (1 + self.variation * (2 * uniform(self.seed, (_LENGTH, course),
                                                              2 * count) - 1))  # fmt: skip
        joints = self.left - 0.5 * (course % 2) * length + np.cumsum(lengths)
        if joints_below:  # head joints keep a distance from those of the course below
            positions = np.array(joints_below)
            nearest = positions[np.argmin(abs(joints[:, None] - positions), axis=1)]
            distance = joints - nearest
            overlap = _OVERLAP * self.stone
            is_close = abs(distance) < overlap
            joints = np.where(is_close, nearest + np.where(distance < 0, -overlap, overlap), joints)
        return np.unique(joints)

    def _stones_between(
        self, left: float, right: float, joints: np.ndarray
    ) -> list[tuple[float, float]]:
        """Return left and right ends (m) of stones that fill a part of a course, none too short."""
        if right - left <= _SAME * self.width:
            return []
        minimum, ends = _LEAST * self.stone * _BONDS[self.bond][0], [left]
        for joint in joints:
            if joint - ends[-1] >= minimum and right - joint >= minimum:
                ends.append(float(joint))
        return list(pairwise([*ends, right]))

    def _tie_rods(self, stones: list[tuple]) -> list[tuple[str, dict]]:
        """Return a tie rod per level, between the outermost stones at this level, as bolts."""
        bolts = []
        for number, level in enumerate(() if self.ties is None else self.ties, 1):
            candidates = [(corners, name) for name, corners, *_ in stones
                      if corners[:, 1].min() < level < corners[:, 1].max()]  # fmt: skip
            if not candidates:
                raise InputError(f"ties: {level:g} m is not within a course")
            ends = [min(candidates, key=lambda item: item[0][:, 0].min())[0],
                    max(candidates, key=lambda item: item[0][:, 0].max())[0]]  # fmt: skip
            middles = [item[:, 0].mean() for item in ends]
            values = {"name": f"{self.name}_tie_{number}", "from": (middles[0], level),
                      "to": (middles[1], level), "axial_stiffness": self.tie_stiffness,
                      "yield_force": self.tie_yield}  # fmt: skip
            bolts.append(("bolt", values))
        return bolts


def _require_apart(openings: list[Opening]) -> None:
    """Raise InputError if two openings, including their heads, overlap."""
    for i, first in enumerate(openings):
        for second in openings[:i]:
            for a, b, c, d in first.gaps():
                for e, f, g, h in second.gaps():
                    if a < g - _SAME and e < c - _SAME and b < h - _SAME and f < d - _SAME:
                        raise InputError(f"openings {second.name!r} and {first.name!r}, with their "
                                         "heads, overlap")  # fmt: skip


def _left_part(polygon: np.ndarray, point: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Return the part of a convex polygon (m) to the left of a line, shape (n, 2)."""
    if len(polygon) == 0:
        return polygon
    offset = polygon - point
    side = direction[0] * offset[:, 1] - direction[1] * offset[:, 0]
    side[abs(side) < _SAME * np.linalg.norm(direction) * np.ptp(polygon, axis=0).max()] = 0.0
    corners = []
    for i in range(len(polygon)):
        j = (i + 1) % len(polygon)
        if side[i] >= 0:
            corners.append(polygon[i])
        if side[i] * side[j] < 0:
            fraction = side[i] / (side[i] - side[j])
            corners.append(polygon[i] + fraction * (polygon[j] - polygon[i]))
    return np.array(corners).reshape(-1, 2)


def _distinct_levels(levels: list[float], tolerance: float) -> list[float]:
    """Return sorted levels; of levels that differ by `tolerance` or less, only the first."""
    result: list[float] = []
    for level in sorted(levels):
        if not result or level - result[-1] > tolerance:
            result.append(level)
    return result
