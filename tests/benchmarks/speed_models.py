# SPDX-License-Identifier: GPL-3.0-or-later
"""Models of the speed benchmark: stacks, running-bond walls and a packing of random polygons.

Blocks start with an initial stress that balances their weight, so that a model settles in a few
steps.  The head joints of walls are open by half a millimetre, as in dry masonry.  A wall whose
bricks all touch without forces starts with sudden gravity.
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.spatial import Voronoi

DENSITY = 2500.0
YOUNG_MODULUS = 1.0e10
POISSON_RATIO = 0.25
FRICTION_ANGLE = 35.0
SHEAR_RATIO = 2.5
FIXED_POINT_RATIO = 100.0
GRAVITY = 9.81
PERIOD = 500  # steps of shaking
SAMPLE = 10  # steps between samples of the shaking
HEAD_JOINT = 5.0e-4  # m


@dataclass
class Model:
    """Polygons (counter-clockwise, shape (vertices, 2), m) at rest under gravity."""

    polygons: list[np.ndarray]
    fixed: list[tuple[float, float, int]]  # x, y, block from 0
    lateral: float  # horizontal over vertical initial stress
    top: float  # height of the surface, m
    shaking: float  # amplitude of the base acceleration, g
    stress: np.ndarray = field(init=False)  # (blocks,) vertical initial stress, Pa

    def __post_init__(self):
        heights = np.array([polygon[:, 1].mean() for polygon in self.polygons])
        self.stress = np.round(-DENSITY * GRAVITY * (self.top - heights), -3)

    def text(self, penalty: float, step: float, rest_steps: int, active: int, solver: str) -> str:
        """Return the input: `rest_steps` (multiple of SAMPLE), then `active` steps of shaking."""
        samples = self.shaking_at(np.arange(0, active + 2 * SAMPLE, SAMPLE))
        lines = [
            f"&control time_step = {step!r}, steps = 1000000, gravity = 0.0, {-GRAVITY}",
            f"   base_motion_x = 'shaking', solver = '{solver}' /",
            f"&contact normal_stiffness = {penalty!r}, shear_ratio = {SHEAR_RATIO} /",
            f"&joint friction_angle = {FRICTION_ANGLE} /",
            "&motion name = 'shaking', quantity = 'acceleration'",
            f"   time_step = {SAMPLE * step!r}, drift_order = 0",
            f"   values = {rest_steps // SAMPLE}*0.0, {', '.join(f'{a:.6f}' for a in samples)} /",
        ]
        return "\n".join([*lines, *self.block_lines()]) + "\n"

    def block_lines(self) -> list[str]:
        """Return the groups of materials, blocks and fixed points."""
        names = {stress: f"m{i}" for i, stress in enumerate(np.unique(self.stress))}
        lines = []
        for stress, name in names.items():
            lines.append(
                f"&material name = '{name}', density = {DENSITY}, young_modulus = {YOUNG_MODULUS}"
                f", poisson_ratio = {POISSON_RATIO}"
                f", initial_stress = {self.lateral * stress}, {stress}, 0.0 /"
            )
        for polygon, stress in zip(self.polygons, self.stress, strict=True):
            coordinates = ", ".join(map(repr, polygon.ravel().tolist()))
            lines.append(f"&block material = '{names[stress]}', vertices = {coordinates} /")
        for x, y, block in self.fixed:
            lines.append(f"&fixed_point x = {x!r}, y = {y!r}, block = {block + 1} /")
        return lines

    def shaking_at(self, step: np.ndarray) -> np.ndarray:
        """Return the base acceleration, m/s², after steps of shaking; linear between samples."""
        before = step // SAMPLE * SAMPLE
        low, high = (np.sin(2 * np.pi * at / PERIOD) for at in (before, before + SAMPLE))
        return self.shaking * GRAVITY * (low + (high - low) * (step - before) / SAMPLE)


def rectangle(left: float, bottom: float, right: float, top: float) -> np.ndarray:
    """Return the corners of a rectangle."""
    return np.array([[left, bottom], [right, bottom], [right, top], [left, top]])


def held(left: float, right: float, bottom: float, top: float) -> list[tuple[float, float, int]]:
    """Return four fixed points of the first block."""
    return [(x, y, 0) for y in (bottom, top) for x in (left, right)]


def stack(layers: int) -> Model:
    """Return layers of 15 m x 1 m on a fixed one."""
    polygons = [rectangle(0.0, i - 1.0, 15.0, float(i)) for i in range(layers + 1)]
    return Model(polygons, held(2.5, 12.5, -0.75, -0.25), 0.0, float(layers), 0.75)


def wall(blocks: int, head_joint: float = HEAD_JOINT) -> Model:
    """Return about `blocks` bricks of 1 m x 0.5 m in running bond, about twice as wide as high."""
    bricks = max(2, round(blocks**0.5))
    courses = max(2, round(blocks / (bricks + 0.5)))
    polygons = [rectangle(-0.5, -0.5, bricks + 0.5, 0.0)]
    for course in range(courses):
        ends = np.arange(bricks + 1.0)
        if course % 2:
            ends = np.concatenate([[0.0], np.arange(bricks) + 0.5, [bricks]])
        for left, right in zip(ends[:-1], ends[1:], strict=True):
            polygons.append(rectangle(left, 0.5 * course, right - head_joint, 0.5 * (course + 1)))
    return Model(polygons, held(0.0, float(bricks), -0.4, -0.1), 0.0, 0.5 * courses, 0.1)


def touching_wall(blocks: int) -> Model:
    """Return the wall without open joints and without initial stress."""
    model = wall(blocks, 0.0)
    model.stress[:] = 0.0
    return model


def packing(blocks: int) -> Model:
    """Return `blocks` convex polygons of about 1 m² in a fixed trough twice as wide as high."""
    height = round((blocks / 2) ** 0.5)
    width = blocks / height
    rng = np.random.default_rng(6)
    seeds = rng.random((blocks, 2)) * [width, height]
    for _ in range(20):  # Lloyd's iteration avoids very short edges
        cells = cells_of(seeds, width, height)
        seeds = np.array([cell.mean(axis=0) for cell in cells])
    trough = np.array(
        [[-1.0, -1.0], [width + 1, -1.0], [width + 1, height], [width, height], [width, 0.0],
         [0.0, 0.0], [0.0, height], [-1.0, height]]
    )  # fmt: skip
    return Model([trough, *cells], held(0.0, width, -0.8, -0.2), 1.0, float(height), 0.1)


def cells_of(seeds: np.ndarray, width: float, height: float) -> list[np.ndarray]:
    """Return Voronoi cells in a rectangle, by mirror images of the seeds."""
    images = [seeds]
    for axis, end in ((0, width), (1, height)):
        for wall_at in (0.0, end):
            image = seeds.copy()
            image[:, axis] = 2 * wall_at - image[:, axis]
            images.append(image)
    diagram = Voronoi(np.concatenate(images))
    positions = np.round(diagram.vertices, 9)
    cells = []
    for i in range(len(seeds)):
        cell = positions[diagram.regions[diagram.point_region[i]]]
        order = np.argsort(np.arctan2(*(cell - cell.mean(axis=0)).T[::-1]))
        cells.append(without_short_edges(cell[order]))
    return cells


def without_short_edges(cell: np.ndarray) -> np.ndarray:
    """Return a polygon without repeated vertices."""
    lengths = np.linalg.norm(cell - np.roll(cell, 1, axis=0), axis=1)
    return cell[lengths > 1e-6]


MODELS = {
    "stack 15": lambda: stack(15),
    "stack 1000": lambda: stack(1000),
    "wall 100": lambda: wall(100),
    "wall 821": lambda: wall(820),
    "wall 1000": lambda: wall(1000),
    "wall 10000": lambda: wall(10000),
    "wall 100000": lambda: wall(100000),
    "packing 5000": lambda: packing(5000),
}
TOUCHING = {f"wall {n}": lambda n=n: touching_wall(n) for n in (100, 1000, 10000)}
