# SPDX-License-Identifier: GPL-3.0-or-later
"""Rectangular blocks with closed contacts as a linear system, built from nothing but numpy.

Per block q = (u, v, r, ex, ey, gxy) about the centroid; M x'' + K x = f, unit thickness.
"""

from dataclasses import dataclass

import numpy as np

SHEAR_RATIO = 2.5  # normal over shear stiffness of a contact
FIXED_RATIO = 100.0  # stiffness of a fixed point over that of a contact


@dataclass(frozen=True)
class Rock:
    """Density (kg/m³), Young's modulus (Pa), Poisson's ratio; plane stress."""

    density: float
    young: float
    poisson: float

    @property
    def moduli(self) -> np.ndarray:
        """Stress from strain."""
        e, nu = self.young, self.poisson
        return e / (1 - nu**2) * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])


@dataclass(frozen=True)
class Box:
    """An upright rectangle of rock."""

    left: float
    bottom: float
    width: float
    height: float
    rock: Rock

    @property
    def centre(self) -> np.ndarray:
        """Its centroid."""
        return np.array([self.left + self.width / 2, self.bottom + self.height / 2])

    @property
    def mass(self) -> float:
        """kg per metre of thickness."""
        return self.rock.density * self.width * self.height

    def shape(self, x: float, y: float) -> np.ndarray:
        """Displacement of the point (x, y) from the block's coordinates, (2, 6)."""
        x, y = np.array([x, y]) - self.centre
        return np.array([[1, 0, -y, x, 0, y / 2], [0, 1, x, 0, y, x / 2]])

    @property
    def inertia(self) -> np.ndarray:
        """ρ∫TᵀT by Gauss points, exact for a quadratic, (6, 6)."""
        sum_ = np.zeros((6, 6))
        for a in (-1, 1):
            for b in (-1, 1):
                point = self.centre + np.array([a * self.width, b * self.height]) / np.sqrt(12)
                t = self.shape(*point)
                sum_ += self.mass / 4 * t.T @ t
        return sum_


class Blocks:
    """Mass and stiffness of boxes, to which springs are added."""

    def __init__(self, boxes: list[Box]):
        self.boxes = boxes
        self.size = 6 * len(boxes)
        self.mass = np.zeros((self.size, self.size))
        self.stiffness = np.zeros((self.size, self.size))
        self.held = np.zeros((self.size, self.size))  # the part of supports in it
        for i, box in enumerate(boxes):
            own, strains = slice(6 * i, 6 * i + 6), slice(6 * i + 3, 6 * i + 6)
            self.mass[own, own] = box.inertia
            self.stiffness[strains, strains] = box.width * box.height * box.rock.moduli

    def motion(self, block: int, x: float, y: float) -> np.ndarray:
        """Rows that give the displacement of a point of a block, (2, size)."""
        rows = np.zeros((2, self.size))
        rows[:, 6 * block : 6 * block + 6] = self.boxes[block].shape(x, y)
        return rows

    def joint(self, lower: int, upper: int, stiffness: float) -> None:
        """A horizontal joint: a contact at each end of where two boxes touch."""
        low, high = self.boxes[lower], self.boxes[upper]
        left = max(low.left, high.left)
        right = min(low.left + low.width, high.left + high.width)
        springs = np.diag([stiffness / SHEAR_RATIO, stiffness])
        for x in (left, right):
            rows = self.motion(upper, x, high.bottom) - self.motion(lower, x, high.bottom)
            self.stiffness += rows.T @ springs @ rows

    def hold(self, block: int, x: float, y: float, stiffness: float) -> np.ndarray:
        """A fixed point; the force on the system of a unit displacement of it, (size, 2)."""
        rows = self.motion(block, x, y)
        self.stiffness += stiffness * rows.T @ rows
        self.held += stiffness * rows.T @ rows
        return stiffness * rows.T

    def gravity(self, acceleration: float) -> np.ndarray:
        """Weight, downwards, (size,)."""
        force = np.zeros(self.size)
        force[1::6] = [-acceleration * box.mass for box in self.boxes]
        return force

    def modes(self) -> tuple[np.ndarray, np.ndarray]:
        """Circular frequencies (rad/s), lowest first, and shapes in columns, by numpy alone."""
        root = np.linalg.inv(np.linalg.cholesky(self.mass))
        squares, vectors = np.linalg.eigh(root @ self.stiffness @ root.T)
        return np.sqrt(np.maximum(squares, 0.0)), root.T @ vectors

    def transfer(self, force, above, below, frequency, time_step) -> np.ndarray:
        """Ratio of the motions at two points, rows of `motion`, in the DDA scheme: docs/method.md.

        [(2M/Δt² + K) z − 2M/Δt² − (4M/Δt²)(z − 1)/(z + 1) + C v z] x = f z, z = exp(iωΔt), where
        the supports have dashpots C = k Δt/2 on the end velocity, v = (2/Δt)(z − 1)/(z + 1).
        """
        ratios = []
        inertia = 2 * self.mass / time_step**2
        for f in np.atleast_1d(frequency):
            z = np.exp(2j * np.pi * f * time_step)
            matrix = (inertia + self.stiffness) * z - inertia - 2 * inertia * (z - 1) / (z + 1)
            matrix += self.held * z * (z - 1) / (z + 1)
            x = np.linalg.solve(matrix, force * z)
            ratios.append((above @ x) / (below @ x))
        return np.array(ratios)


def stack(rocks: list[Rock], stiffness: float, width: float = 15.0, bottom: float = 0.0) -> Blocks:
    """Layers of 1 m, upwards, two contacts per joint."""
    boxes = [Box(0.0, bottom + i, width, 1.0, rock) for i, rock in enumerate(rocks)]
    blocks = Blocks(boxes)
    for i in range(1, len(rocks)):
        blocks.joint(i - 1, i, stiffness)
    return blocks


def scheme_decay(omega: float, time_step: float) -> tuple[float, float, float]:
    """Damping ratio, trace and determinant of the amplification matrix: docs/method.md."""
    square = (omega * time_step) ** 2
    trace, determinant = (4 - square) / (2 + square), 2 / (2 + square)
    size = np.sqrt(determinant)
    phase = np.arccos(trace / 2 / size)
    return -np.log(size) / np.hypot(phase, np.log(size)), trace, determinant
