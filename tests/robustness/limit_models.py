# SPDX-License-Identifier: GPL-3.0-or-later
"""Random dry arches and walls with openings under a horizontal body force."""

import math
from dataclasses import dataclass

import numpy as np

import sitedda
from sitedda.errors import ConvergenceError, InputError
from sitedda.stability import Limits

GRAVITY = 9.81  # m/s²
DENSITY = 2500.0  # kg/m³
SEED = 20260718
STIFFNESS = 1e10  # normal stiffness of contacts, N/m
LEAST, MOST = 0.03, 3.0  # limits of realistic shapes, times the weight


@dataclass(frozen=True)
class Assembly:
    """Dry blocks, some of them fixed."""

    name: str
    polygons: list[np.ndarray]  # the blocks, shape (n, 2), m
    held: tuple[int, ...]  # blocks that are fixed at their corners
    friction: float  # tan φ of all joints
    sense: int  # direction of the body force along x: 1 or −1

    def model(self, factor: float = 0.0) -> sitedda.Model:
        """Return the model without stages under a body force of `factor` times the weight."""
        model = sitedda.Model(self.name, time_step=1e-3)
        model.control(gravity=(self.sense * factor * GRAVITY, -GRAVITY))
        model.contact(normal_stiffness=STIFFNESS)
        model.material("stone", density=DENSITY, young_modulus=1e11, poisson_ratio=0.2)
        model.joint("dry", friction_angle=math.degrees(math.atan(self.friction)))
        for i, polygon in enumerate(self.polygons):
            model.block(polygon, name=f"block_{i}")
        for i in self.held:
            for x, y in self.polygons[i]:
                model.fixed_point(x, y, f"block_{i}")
        return model

    def limits(self) -> Limits:
        """Return the limits of the linear programmes."""
        return sitedda.limit_analysis(self.model(), direction=(self.sense, 0.0))


def arch(rng: np.random.Generator, name: str) -> Assembly:
    """Voussoirs with straight sides and unequal angles, and joints inclined to the radius."""
    count, radius = int(rng.integers(7, 32)), 5.0
    half_angle, thickness = math.radians(rng.uniform(40, 90)), radius * rng.uniform(0.1, 0.35)
    fractions = rng.uniform(0.6, 1.4, count)
    angle = half_angle - 2 * half_angle * np.append(0.0, np.cumsum(fractions)) / fractions.sum()
    smallest = (
        np.minimum(np.append(np.inf, fractions), np.append(fractions, np.inf)) / fractions.sum()
    )
    # Joints must not intersect within the ring.
    lean = rng.uniform(-1, 1, count + 1) * np.minimum(0.2, 0.4 * smallest * 2 * half_angle * radius
        / (0.5 * thickness))  # fmt: skip
    ray = np.column_stack([np.sin(angle), np.cos(angle)])
    direction = np.column_stack([np.sin(angle + lean), np.cos(angle + lean)])
    direction *= (0.5 * thickness / np.cos(lean))[:, None]
    polygons = _voussoirs(radius * ray - direction, radius * ray + direction)
    friction, sense = rng.uniform(0.4, 0.9), int(rng.choice([-1, 1]))
    return Assembly(name, polygons, (count, count + 1), float(friction), sense)


def _voussoirs(intrados: np.ndarray, extrados: np.ndarray) -> list[np.ndarray]:
    """Return the stones between joints from the right springing on, and two abutments."""
    count = len(intrados) - 1
    polygons = [np.array([intrados[i], extrados[i], extrados[i + 1], intrados[i + 1]])
                for i in range(count)]  # fmt: skip
    for i, sign in ((0, 1.0), (count, -1.0)):
        joint_vector = extrados[i] - intrados[i]
        normal = np.array([joint_vector[1], -joint_vector[0]]) * sign
        low, high = intrados[i] - 0.25 * joint_vector, extrados[i] + 0.25 * joint_vector
        corners = [low, low + normal, high + normal, high]
        polygons.append(np.array(corners if sign > 0 else corners[::-1]))
    return polygons


def bridge(rng: np.random.Generator, name: str) -> Assembly:
    """Voussoirs with radial joints below a level road."""
    count, radius = int(rng.integers(7, 22)), 5.0
    half_angle, crown = math.radians(rng.uniform(40, 60)), radius * rng.uniform(0.03, 0.12)
    angle = np.linspace(half_angle, -half_angle, count + 1)
    ray = np.column_stack([np.sin(angle), np.cos(angle)])
    polygons = _voussoirs(radius * ray, (radius + crown) * ray / ray[:, 1:])
    return Assembly(name, polygons, (count, count + 1), float(rng.uniform(0.4, 0.9)), 1)


def _cut(left: float, right: float, joints: np.ndarray, smallest: float) -> list[tuple]:
    """Cut a course at joints such that no piece is shorter than `smallest`."""
    ends = [left]
    for x in joints:
        if x - ends[-1] >= smallest and right - x >= smallest:
            ends.append(float(x))
    return list(zip(ends, [*ends[1:], right], strict=True))


def wall(rng: np.random.Generator, name: str) -> Assembly:
    """Running bond of unequal bricks on a base, with one or two openings under lintels."""
    height, courses = 0.25, int(rng.integers(4, 10))
    length = float(rng.uniform(0.4, 0.8))  # of a brick
    openings = []
    width = length * float(rng.uniform(4, 7))
    for fractions in [(0.5,), (0.27, 0.73)][int(rng.integers(0, 2))]:
        half = 0.5 * length * rng.uniform(0.7, 1.1)
        bottom = int(rng.integers(0, 3))
        top = min(bottom + int(rng.integers(2, 4)), courses - 1)
        openings.append((fractions * width - half, fractions * width + half, bottom, top))
    bearing = 0.3 * length
    polygons = [_box(-0.5, width + 0.5, -0.5, 0.0)]
    for k in range(courses):
        shift = 0.5 * (k % 2) + rng.uniform(-0.1, 0.1)
        joints = length * (np.arange(-1, math.ceil(width / length) + 1) + shift)
        joints = joints + length * rng.uniform(-0.08, 0.08, len(joints))
        at, blocks = 0.0, []
        for left, right, bottom, top in openings:
            if bottom <= k < top:
                blocks += _cut(at, left, joints, 0.3 * length)
                at = right
            elif k == top:
                blocks += [*_cut(at, left - bearing, joints, 0.3 * length),
                    (left - bearing, right + bearing)]  # fmt: skip
                at = right + bearing
        blocks += _cut(at, width, joints, 0.3 * length)
        polygons += [_box(a, b, k * height, (k + 1) * height) for a, b in blocks]
    friction, sense = rng.uniform(0.3, 0.9), int(rng.choice([-1, 1]))
    return Assembly(name, polygons, (0,), float(friction), sense)


def _box(left: float, right: float, bottom: float, top: float) -> np.ndarray:
    return np.array([(left, bottom), (right, bottom), (right, top), (left, top)])


def _fits(assembly: Assembly, least_blocks: int, most_blocks: int):
    """Return the limits, or None if the model falls under its weight or has too few blocks."""
    free_blocks = len(assembly.polygons) - len(assembly.held)
    if not least_blocks <= free_blocks <= most_blocks:
        return None
    try:
        limits = assembly.limits()
    except (InputError, ConvergenceError):
        return None
    return limits if LEAST <= limits.lower.factor <= limits.upper.factor < MOST else None


def assemblies(models: int, seed: int = SEED):
    """Yield arches and, one in three, walls, with their limits; every second mechanism slides."""
    rng = np.random.default_rng(seed)
    for i in range(models):
        make, fewest, largest = (wall, 10, 60) if i % 3 == 2 else (arch, 7, 31)
        while True:
            assembly = make(rng, f"{make.__name__} {i + 1}")
            limits = _fits(assembly, fewest, largest)
            if limits is not None and limits.lower.slides == (i % 2 == 0):
                yield assembly, limits
                break
