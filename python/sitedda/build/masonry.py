# SPDX-License-Identifier: GPL-3.0-or-later
"""Build masonry from a few parameters: arches, piers, lintels, colonnades, walls."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..base.errors import InputError
from ..input import schema

MOST_BLOCKS = 100_000  # largest number of blocks of a structure


@dataclass(frozen=True)
class Stone:
    """A block of masonry."""

    name: str
    polygon: np.ndarray  # corners, shape (n, 2), m, counter-clockwise
    material: str = ""  # blank: the first material and the first joint of the model
    joint: str = ""


def _check_count(blocks: int) -> None:
    """Raise InputError for a number of blocks above the limit."""
    if blocks > MOST_BLOCKS:
        raise InputError(f"{blocks} blocks exceed the limit of {MOST_BLOCKS}")


def rectangle(left, bottom, right, top) -> np.ndarray:
    """Return the corners of a rectangle, shape (4, 2), m."""
    return np.array([[left, bottom], [right, bottom], [right, top], [left, top]], dtype=float)


def _lay_courses(left, right, bottom, height, courses, stones) -> Iterator[tuple[int, np.ndarray]]:
    """Yield course number and corners (m) of stones in running bond between two straight faces.

    `left`, `right`: x of a face at the bottom and at the top, m.
    `bottom`, `height`: m.
    `courses`, `stones`: numbers of courses, and of stones in a full course; every second course
    begins and ends with half a stone, unless a course is one stone.
    """
    for k in range(courses):
        ratios = np.arange(stones + 1) / stones
        if k % 2 and stones > 1:
            ratios = np.concatenate([[0.0], (np.arange(stones) + 0.5) / stones, [1.0]])
        low, high = k / courses, (k + 1) / courses
        foot = np.interp(ratios, [0, 1], [np.interp(low, [0, 1], side) for side in (left, right)])
        head = np.interp(ratios, [0, 1], [np.interp(high, [0, 1], side) for side in (left, right)])
        y, top = bottom + low * height, bottom + high * height
        for i in range(len(ratios) - 1):
            corners = [(foot[i], y), (foot[i + 1], y), (head[i + 1], top), (head[i], top)]
            yield k, np.array(corners, dtype=float)


def _number_stones(name: str, polygons, material: str, joint: str) -> list[Stone]:
    """Return stones with these polygons, named NAME_1, NAME_2 and so on."""
    return [Stone(f"{name}_{i}", polygon, material, joint) for i, polygon in enumerate(polygons, 1)]


class Arch(schema.ArchValues):
    """An arch of straight-sided voussoirs, with joints at right angles to the centre line."""

    def _check_values(self) -> None:
        """Check the number of voussoirs and the thickness; set span and rise from the radius."""
        if self.radius is not None:
            self.span, self.rise = 2 * self.radius, self.radius
        if self.is_pointed and self.voussoirs % 2:
            raise InputError(f"voussoirs = {self.voussoirs} of a pointed arch must be even")
        radius, _ = self._right_arc_geometry()
        if self.thickness / 2 >= radius:
            limit = f"must be less than twice the radius, {radius:g} m"
            raise InputError(f"thickness = {self.thickness:g} {limit}")

    @property
    def is_pointed(self) -> bool:
        """Return whether the centre line has a corner at the crown."""
        return self.rise > 0.5 * self.span * (1 + 1e-12)

    def _right_arc_geometry(self) -> tuple[float, tuple[float, float]]:
        """Return radius and centre of the right arc, m, relative to the middle of the springing."""
        half, rise = self.span / 2, self.rise
        if self.is_pointed:
            radius = (half**2 + rise**2) / (2 * half)
            return radius, (half - radius, 0.0)
        radius = (half**2 + rise**2) / (2 * rise)
        return radius, (0.0, rise - radius)

    def _joint_ends(self, offset: float) -> np.ndarray:
        """Return the points of the joints at an offset (m) from the centre line, (n + 1, 2), m."""
        radius, (x0, y0) = self._right_arc_geometry()
        half, n = self.span / 2, self.voussoirs
        springing = np.arctan2(-y0, half - x0)
        angle = np.linspace(springing, np.pi - springing, n + 1)
        if self.is_pointed:
            angle = np.linspace(0.0, np.arctan2(self.rise, -x0), n // 2 + 1)
        ends = (radius + offset) * np.column_stack([np.cos(angle), np.sin(angle)]) + (x0, y0)
        if self.is_pointed:
            ends[-1] = 0.0, np.sqrt((radius + offset) ** 2 - x0**2)
        right = ends[: n // 2 + 1]
        # The left half mirrors the right half exactly.
        left = right[::-1] * (-1, 1) if n % 2 else right[-2::-1] * (-1, 1)
        return np.vstack([right, left]) + np.asarray(self.centre, dtype=float)

    def blocks(self) -> list[Stone]:
        """Return the voussoirs, beginning at the right springing, then the abutments."""
        inner, outer = self._joint_ends(-self.thickness / 2), self._joint_ends(self.thickness / 2)
        polygons = [np.array([inner[i], outer[i], outer[i + 1], inner[i + 1]])
                    for i in range(self.voussoirs)]  # fmt: skip
        stones = _number_stones(self.name, polygons, self.material, self.joint)
        if self.abutment:
            for side, i in (("left", -1), ("right", 0)):
                block = self._build_abutment(inner[i], outer[i])
                stones.append(Stone(f"{self.name}_{side}", block, self.material, self.joint))
        return stones

    def _build_abutment(self, inner, outer) -> np.ndarray:
        """Return the corners of the abutment under the springing joint from inner to outer, m."""
        bottom = min(inner[1], outer[1]) - self.abutment
        outer_face = outer[0] + np.copysign(self.abutment, outer[0] - inner[0])
        corners = [inner, (inner[0], bottom), (outer_face, bottom), (outer_face, outer[1]), outer]
        return np.array(corners if outer[0] > inner[0] else corners[::-1])


class Pier(schema.PierValues):
    """A pier of courses in running bond."""

    def _check_values(self) -> None:
        """Check the number of stones; set the default of the upper width."""
        self.top_width = self.top_width or self.width
        _check_count(self.courses * (self.stones + 1))

    def blocks(self) -> list[Stone]:
        """Return the stones course by course from below."""
        half = 0.5 * np.array([self.width, self.top_width])
        faces = (self.centre - half, self.centre + half)
        courses = _lay_courses(*faces, self.bottom, self.height, self.courses, self.stones)
        return _number_stones(self.name, (stone for _, stone in courses), self.material, self.joint)


class Lintel(schema.LintelValues):
    """A beam over an opening."""

    def blocks(self) -> list[Stone]:
        """Return the beam."""
        right = self.left + self.span + self.bearing
        beam = rectangle(self.left - self.bearing, self.bottom, right, self.bottom + self.height)
        return [Stone(self.name, beam, self.material, self.joint)]


class Colonnade(schema.ColonnadeValues):
    """Columns of drums, with optional capitals and beams; outer beams end flush."""

    def _check_values(self) -> None:
        """Check the number of drums, the capitals and the spacing of the columns."""
        self.top_width = self.top_width or self.width
        _check_count(self.columns * (self.drums + 2))
        if (self.capital_width > 0) != (self.capital_height > 0):
            raise InputError("give both capital_width and capital_height, or neither")
        if self.spacing <= max(self.width, self.top_width, self.capital_width):
            raise InputError(f"spacing = {self.spacing:g} is too small: the columns would touch")

    def blocks(self) -> list[Stone]:
        """Return the stones of the columns, from below, then the beams, from the left."""
        stones = []
        top = self.bottom + self.height
        half = 0.5 * np.array([self.width, self.top_width])
        for c in range(self.columns):
            axis, name = self.left + c * self.spacing, f"{self.name}{c + 1}"
            faces = (axis - half, axis + half)
            courses = _lay_courses(*faces, self.bottom, self.height, self.drums, 1)
            stones += _number_stones(name, (drum for _, drum in courses), self.material, self.joint)
            if self.capital_height:
                reach = 0.5 * self.capital_width
                block = rectangle(axis - reach, top, axis + reach, top + self.capital_height)
                stones.append(Stone(f"{name}_capital", block, self.material, self.joint))
        if self.beam_height:
            name = f"{self.name}_beam"
            stones += _number_stones(name, self._build_beams(), self.material, self.joint)
        return stones

    def _build_beams(self) -> Iterator[np.ndarray]:
        """Yield the corners of the beams between columns, from the left, m."""
        low = self.bottom + self.height + self.capital_height
        reach = 0.5 * (self.capital_width or self.top_width)
        for i in range(max(1, self.columns - 1)):
            first, last = i == 0, i >= self.columns - 2
            left = self.left + i * self.spacing - (reach if first else 0.0)
            right = self.left + min(i + 1, self.columns - 1) * self.spacing
            yield rectangle(left, low, right + (reach if last else 0.0), low + self.beam_height)


class RetainingWall(schema.RetainingWallValues):
    """A wall of courses in running bond with a vertical back and a battered face."""

    def _check_values(self) -> None:
        """Check the number of stones."""
        _check_count(self.courses * (self.stones + 1))

    def blocks(self) -> list[Stone]:
        """Return the stones course by course from below."""
        right = self.left + self.base_width
        faces = (self.left, right - self.top_width), (right, right)
        if self.face == "right":
            faces = (self.left, self.left), (right, self.left + self.top_width)
        courses = _lay_courses(*faces, self.bottom, self.height, self.courses, self.stones)
        return _number_stones(self.name, (stone for _, stone in courses), self.material, self.joint)


class MultiLeafWall(schema.MultiLeafWallValues):
    """A cross-section of two leaves of stones with a core between them."""

    def _check_values(self) -> None:
        """Check the number of stones."""
        _check_count(self.courses * (2 + self.core_courses * (self.core_stones + 1)))

    def blocks(self) -> list[Stone]:
        """Return the stones of each course, from below: left leaf, core, right leaf; or a tie."""
        x = self.left + np.cumsum([0.0, self.leaf, self.core, self.leaf])
        step = self.height / self.courses
        core_material = self.core_material or self.material
        core_joint = self.core_joint or self.joint
        stones, numbers = [], {}

        def add(kind: str, polygon, material: str, joint: str) -> None:
            numbers[kind] = numbers.get(kind, 0) + 1
            name = f"{self.name}_{kind}_{numbers[kind]}"
            stones.append(Stone(name, polygon, material, joint))

        for k in range(self.courses):
            low, high = self.bottom + k * step, self.bottom + (k + 1) * step
            if self.ties and (k + 1) % self.ties == 0:
                add("tie", rectangle(x[0], low, x[3], high), self.material, self.joint)
                continue
            add("left", rectangle(x[0], low, x[1], high), self.material, self.joint)
            faces = (x[1], x[1]), (x[2], x[2])
            for _, stone in _lay_courses(*faces, low, step, self.core_courses, self.core_stones):
                add("core", stone, core_material, core_joint)
            add("right", rectangle(x[2], low, x[3], high), self.material, self.joint)
        return stones
