# SPDX-License-Identifier: GPL-3.0-or-later
"""Exact discrete theory of a model with bonded contacts: K and M from the blocks, in NumPy.

This second assembly of blocks, springs and supports yields frequencies from K x = ω² M x, transfer
functions of the scheme from one complex solution per frequency, and time histories in modal
coordinates.  The engine provides the list of contacts and the closed forms of the scheme.
Assumptions: motions are small, contacts neither open nor slide, and weight has no effect.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path

import numpy as np
from scipy.linalg import eigh
from shapely import LineString, Point, Polygon

from sitedda.engine.scheme import Scheme
from sitedda.engine.simulation import Simulation
from sitedda.input.changes import changed_input
from sitedda.input.input_text import groups_by_name

_TOUCHING = 1e-6  # largest distance between an edge and a vertex that touches it, m


@dataclass(frozen=True)
class DiscreteModel:
    """The matrices of a linear model with bonded contacts."""

    # Matrices of shape (6n, 6n), N/m and kg per metre of thickness; the unknowns of each block
    # are (u0, v0, r0, ex, ey, gxy)
    elastic: np.ndarray
    mass: np.ndarray
    supports: np.ndarray  # displacements of fixed points per unknown, shape (supports, 6n)
    support_axes: np.ndarray  # fixed directions: 0 x, 1 y
    support_stiffness: float  # k, N/m per metre of thickness; the dashpot is (1 - χ) k Δt
    centroids: np.ndarray  # shape (n, 2), m
    points: dict  # block and position (m) of each measured point, by name
    loads: list  # block and position (m) of each point load
    scheme: Scheme  # time integration of the input

    @classmethod
    def of(cls, file: Path, changes: Mapping | None = None, **options) -> "DiscreteModel":
        """Return the model of an input with changes, as for `sitedda.Simulation`."""
        changes = dict(changes or {}) | options
        parsed = groups_by_name(changed_input(Path(file).read_text(), changes))
        with Simulation(file, changes=changes) as simulation:
            polygons = [np.array(polygon) for polygon in simulation.polygons]
            contacts = simulation.contacts
            names = simulation.block_names
        moments = [_area_moments(polygon) for polygon in polygons]
        centroids = np.array([m[1] for m in moments])
        n = len(polygons)
        mass, stiffness = np.zeros((6 * n, 6 * n)), np.zeros((6 * n, 6 * n))
        for b, material in enumerate(_block_materials(parsed, n)):
            unknowns = slice(6 * b, 6 * b + 6)
            mass[unknowns, unknowns] = _mass_matrix(material, *moments[b])
            stiffness[unknowns, unknowns] += _strain_stiffness(material, moments[b][0])
        shape = partial(_shape_matrix, centroids)
        normal = parsed["contact"][0]["normal_stiffness"]
        shear = normal / parsed["contact"][0].get("shear_ratio", 2.5)
        _add_contacts(stiffness, polygons, contacts, shape, (normal, shear))
        ratio = parsed["contact"][0].get("fixed_point_ratio", 100.0)
        supports, axes = _support_rows(parsed, polygons, names, shape)
        points = {group["name"]: (_block_at_point(group, polygons, names), (group["x"], group["y"]))
                  for group in parsed.get("measured_point", [])}  # fmt: skip
        loads = [(_block_at_point(group, polygons, names), (group["x"], group["y"]))
                 for group in parsed.get("load", [])]  # fmt: skip
        scheme = Scheme.of_control(parsed["control"][0])
        return cls(stiffness, mass, supports, axes, ratio * normal, centroids, points, loads,
                   scheme)  # fmt: skip

    @property
    def stiffness(self) -> np.ndarray:
        """Return K with the springs of the supports, shape (6n, 6n)."""
        return self.elastic + self.support_stiffness * self.supports.T @ self.supports

    def _support_dashpot(self, time_step: float) -> float:
        """Return the dashpot of a support for velocities at the end of a step, N s/m."""
        return (1 - self.scheme.chi) * self.support_stiffness * time_step

    def _sum_support_rows(self, axis: int) -> np.ndarray:
        """Return the sum of the rows of `supports` along an axis, shape (6n,)."""
        return self.supports[self.support_axes == axis].sum(0)

    def row(self, point, axis: int = 0) -> np.ndarray:
        """Return the row that yields the displacement of a point along an axis, shape (6n,).

        The point is a name or (block, position in m).
        """
        block, position = self.points[point] if isinstance(point, str) else point
        return _shape_matrix(self.centroids, block, position)[axis]

    @cached_property
    def _omega_and_shapes(self) -> tuple[np.ndarray, np.ndarray]:
        """Return angular frequencies (rad/s) and mass-normalised shapes (columns)."""
        square, shapes = eigh(self.stiffness, self.mass)
        return np.sqrt(np.maximum(square, 0.0)), shapes

    @property
    def omega(self) -> np.ndarray:
        """Return the undamped angular frequencies, ascending, rad/s."""
        return self._omega_and_shapes[0]

    @property
    def frequencies(self) -> np.ndarray:
        """Return the undamped frequencies, ascending, Hz."""
        return self.omega / (2 * np.pi)

    def mode(self, number: int) -> np.ndarray:
        """Return the mass-normalised shape of a mode, shape (6n,)."""
        return self._omega_and_shapes[1][:, number]

    def mass_fractions(self, axis: int) -> np.ndarray:
        """Return the effective mass of each mode along an axis as a fraction of the total mass."""
        unit_translation = np.zeros(len(self.mass))
        unit_translation[axis::6] = 1.0
        mass = self.mass @ unit_translation
        return (self._omega_and_shapes[1].T @ mass) ** 2 / (unit_translation @ mass)

    def transfer_function(self, frequency, time_step: float, surface: str, base: str, loading: str):
        """Return the transfer function of the scheme between two points for motion in x.

        It solves [w_M M + K + (w_e k + w_d c) RᵀR] x = F with the factors w of `Scheme.steady` and
        the matrix R of the supports; frequencies in Hz, time step in s.

        `loading` 'displacement': the fixed points move; the result is the ratio of both motions.
        'acceleration': a body force in the frame of the base; the result is 1 + relative
        acceleration of the surface over acceleration of the base.
        """
        factors = self.scheme.steady(frequency, time_step)
        support_factor = (self.support_stiffness * factors.end_stiffness
                          + self._support_dashpot(time_step) * factors.end_dashpot)  # fmt: skip
        support_product = self.supports.T @ self.supports
        if loading == "displacement":
            force = support_factor[:, None] * self._sum_support_rows(0)
        else:
            unit_translation = np.zeros(len(self.mass))
            unit_translation[0::6] = 1.0
            force = -factors.load[:, None] * (self.mass @ unit_translation)
        x = np.array(
            [np.linalg.solve(inertia * self.mass + self.elastic + k * support_product, f)
             for inertia, k, f in zip(factors.inertia, support_factor, force, strict=True)]
        )  # fmt: skip
        top = x @ self.row(surface)
        if loading == "displacement":
            return top / (x @ self.row(base))
        # the engine computes accelerations as (v1 - v0)/Δt
        return 1 + top * factors.inertia / factors.end_stiffness

    def response_to_force(
        self, row: np.ndarray, force: np.ndarray, series, time_step: float, factor: float = 1.0
    ) -> np.ndarray:
        """Return a displacement after each step under force × series, from rest, shape (steps,).

        `row`: row of the displacement, see `row`; `force`: unit force, shape (6n,); `series`:
        factor of the force at t₀ + θΔt in each step; `time_step`: Δt, s; `factor`: dynamic factor.
        """
        return self._step_modes(row, force, series, np.zeros(len(self.mass)), time_step, factor)

    def response_to_motion(self, row: np.ndarray, motion, rate, time_step: float) -> np.ndarray:
        """Return a displacement after each step if all fixed points move along x.

        `row`: row of the displacement, see `row`; `motion`, `rate`: displacement (m) and velocity
        (m/s) of the fixed points from the start; `time_step`: Δt, s.
        """
        chi, dashpot = self.scheme.chi, self._support_dashpot(time_step)
        motion, rate = np.array(motion, dtype=float), np.array(rate, dtype=float)
        if chi > 0.5:  # the scheme computes velocities of supports from their displacements
            for n, increment in enumerate(np.diff(motion)):
                rate[n + 1] = increment / (chi * time_step) - (1 / chi - 1) * rate[n]
        unit_force = self._sum_support_rows(0)
        # the supports have the initial velocity already in the first step
        weight = (1 - chi) * dashpot * time_step
        matrix = self.mass + weight * self.supports.T @ self.supports
        velocity = np.linalg.solve(matrix, weight * rate[0] * unit_force)
        series = self.support_stiffness * motion[1:] + dashpot * rate[1:]
        return self._step_modes(row, unit_force, series, velocity, time_step, 1.0)

    def _step_modes(
        self, row, force, series, velocity, time_step: float, factor: float
    ) -> np.ndarray:
        """Return a displacement after each step; computed in modal coordinates."""
        square, shapes = self.omega**2, self._omega_and_shapes[1]
        theta, chi = self.scheme.theta, self.scheme.chi
        rows, k, c = (self.supports @ shapes, self.support_stiffness,
                      self._support_dashpot(time_step))  # fmt: skip
        momentum, velocity_factor = 1 / (chi * time_step), (1 / chi - 1) * factor
        flexibility = 1 / (momentum / time_step + theta * square)
        # forces of K - k RᵀR are those at t₀ + θΔt; forces of k and c are those at the end
        support_term = (1 - theta) * k + c * momentum
        flexible_rows = rows * flexibility
        matrix = np.eye(len(rows)) + support_term * flexible_rows @ rows.T
        reduced = np.linalg.inv(matrix) * support_term
        x, v = np.zeros(len(square)), shapes.T @ self.mass @ velocity
        modal_force, modal_row = shapes.T @ force, row @ shapes
        result = np.empty(len(series))
        for n, value in enumerate(series):
            load = value * modal_force + factor * momentum * v - square * x
            load += (c * velocity_factor) * ((rows @ v) @ rows)
            increment = flexibility * load
            increment -= flexible_rows.T @ (reduced @ (rows @ increment))
            x = x + increment
            v = momentum * increment - velocity_factor * v
            result[n] = modal_row @ x
        return result


def _shape_matrix(centroids: np.ndarray, block: int, point) -> np.ndarray:
    """Return the matrix T of eq. 4 of the paper for a point of a block, shape (2, 6n)."""
    x, y = np.asarray(point) - centroids[block]
    rows = np.zeros((2, 6 * len(centroids)))
    rows[:, 6 * block : 6 * block + 6] = [[1, 0, -y, x, 0, y / 2], [0, 1, x, 0, y, x / 2]]
    return rows


def _block_materials(parsed, count: int) -> list:
    """Return the &material of each block, in the order of the groups in the input."""
    materials = parsed.get("material", [])
    if len(materials) == 1:
        return materials * count
    by_name = {material.get("name", ""): material for material in materials}
    groups = [group for name in parsed if name in ("block", "layers", "drums")
              for group in parsed[name]]  # fmt: skip
    return [by_name.get(group.get("material", ""), materials[0])
            for group in groups for _ in range(group.get("count", 1))]  # fmt: skip


def _area_moments(polygon: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """Return area (m²), centroid c (m) and ∫(r - c)(r - c)ᵀ (m⁴) of a polygon."""
    origin = polygon[0]
    a, b = polygon[1:-1] - origin, polygon[2:] - origin
    twice = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    area = twice.sum() / 2
    centre = (twice[:, None] * (a + b)).sum(0) / (6 * area)
    second = np.zeros((2, 2))
    for weight, p, q in zip(twice, a, b, strict=True):
        second += weight / 24 * (np.outer(p, p) + np.outer(q, q) + np.outer(p + q, p + q))
    return area, centre + origin, second - area * np.outer(centre, centre)


def _mass_matrix(material, area: float, _centre, second: np.ndarray) -> np.ndarray:
    """Return the mass matrix ρ ∫TᵀT of a block about its centroid, shape (6, 6)."""
    (xx, xy), (_, yy) = second
    matrix = np.zeros((6, 6))
    matrix[0, 0] = matrix[1, 1] = area
    matrix[2, 2:] = [xx + yy, -xy, xy, (xx - yy) / 2]
    matrix[3, 3:] = [xx, 0.0, xy / 2]
    matrix[4, 4:] = [yy, xy / 2]
    matrix[5, 5] = (xx + yy) / 4
    return material["density"] * (matrix + np.triu(matrix, 1).T)


def _strain_stiffness(material, area: float) -> np.ndarray:
    """Return the stiffness matrix of a block, area × D of plane stress, shape (6, 6)."""
    young, nu = material["young_modulus"], material["poisson_ratio"]
    matrix = np.zeros((6, 6))
    plane_stress = np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
    matrix[3:, 3:] = area * young / (1 - nu**2) * plane_stress
    return matrix


def _add_contacts(stiffness, polygons, contacts, shape, springs) -> None:
    """Add normal and shear springs of the contacts of the engine to a stiffness matrix."""
    vertices = np.concatenate(polygons)
    owner = np.repeat(np.arange(len(polygons)), [len(polygon) for polygon in polygons])
    following = np.concatenate([np.roll(polygon, -1, axis=0) for polygon in polygons])
    for vertex, edge in zip(contacts["vertex"], contacts["edge"], strict=True):
        point, along = vertices[vertex], following[edge] - vertices[edge]
        if LineString([vertices[edge], following[edge]]).distance(Point(point)) > _TOUCHING:
            continue
        along = along / np.hypot(*along)
        relative = shape(owner[vertex], point) - shape(owner[edge], point)
        for spring, direction in zip(springs, ((along[1], -along[0]), along), strict=True):
            row = np.asarray(direction) @ relative
            stiffness += spring * np.outer(row, row)


def _support_rows(parsed, polygons, names, shape) -> tuple[np.ndarray, np.ndarray]:
    """Return `supports` and `support_axes` of `DiscreteModel`."""
    rows, axes = [], []
    for group in parsed.get("fixed_point", []):
        matrix = shape(_block_at_point(group, polygons, names), (group["x"], group["y"]))
        for axis, letter in enumerate("xy"):
            if letter in group.get("direction", "xy"):
                rows.append(matrix[axis])
                axes.append(axis)
    return np.array(rows).reshape(-1, 6 * len(polygons)), np.array(axes, dtype=int)


def _block_at_point(group, polygons, names) -> int:
    """Return the index of the block that a group names, or that contains its point."""
    if group.get("block"):
        return names.index(group["block"])
    point = Point(group["x"], group["y"])
    return next(i for i, polygon in enumerate(polygons) if Polygon(polygon).distance(point) < 1e-9)
