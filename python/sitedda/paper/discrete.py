"""Exact discrete theory of a model with closed contacts: K and M from the blocks, in NumPy.

The engine's blocks and springs, assembled a second time and solved without time steps: frequencies
from K x = ω² M x, transfer functions of the scheme from one complex solve per frequency, and time
histories mode by mode.  Only the list of contacts is taken from the engine.  Small motions;
contacts neither open nor slide; the weight of the blocks does not act on the frequencies.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import f90nml
import numpy as np
from scipy.linalg import eigh
from scipy.signal import lfilter

from ..changes import changed_input
from ..simulation import Simulation

__all__ = ["DiscreteModel", "free_damping", "free_frequency", "kinetic_damping_roots"]

_TOUCHING = 1e-6  # m, a vertex nearer to an edge touches it


def scheme_root(omega, time_step: float):
    """Complex eigenvalue λ of the scheme in free vibration, for ωΔt < 4 (paper eq. 13).

    From det = 2/(2 + Ω²) and trace = (4 - Ω²)/(2 + Ω²) of Newmark β = 1/2, γ = 1, Ω = ωΔt.
    """
    square = (np.asarray(omega) * time_step) ** 2
    half_trace = 0.5 * (4 - square) / (2 + square)
    return half_trace + 1j * np.sqrt(2 / (2 + square) - half_trace**2)


def free_damping(omega, time_step: float):
    """Damping ratio of the scheme in free vibration: ln(1/|λ|) / |ln λ|, about ωΔt/4.

    Parameters
    ----------
    omega : array_like
        Undamped angular frequencies, rad/s.
    time_step : float
        Δt, s.
    """
    logarithm = np.log(scheme_root(omega, time_step))
    return -logarithm.real / np.abs(logarithm)


def free_frequency(omega, time_step: float):
    """Frequency of the scheme in free vibration, Hz: the phase of λ over 2πΔt."""
    return np.angle(scheme_root(omega, time_step)) / (2 * np.pi * time_step)


def kinetic_damping_roots(omega: float, time_step: float, factor: float) -> np.ndarray:
    """The two eigenvalues of a step when the velocity carried over is multiplied by a factor.

    Parameters
    ----------
    omega : float
        rad/s.
    time_step : float
        Δt, s.
    factor : float
        The dynamic factor g: 1 fully dynamic, 0.99 is 1 % kinetic damping.
    """
    return np.roots(_poles(omega, time_step, factor))


def _poles(omega, time_step: float, factor: float = 1.0) -> np.ndarray:
    """Factors of z², z, 1 in the step's polynomial for x, from x1 = x0 + d, v1 = 2d/Δt - g v0."""
    inertia = 2 / time_step**2
    square = np.asarray(omega) ** 2
    return np.array(
        [inertia + square, square * factor - inertia * (1 + factor), inertia * factor + 0 * square]
    )


@dataclass(frozen=True)
class DiscreteModel:
    """Matrices of a model.

    Attributes
    ----------
    stiffness, mass : ndarray, shape (6n, 6n)
        K, M for unknowns (u0, v0, r0, ex, ey, gxy) of each block, per metre of thickness.
    support : ndarray, shape (6n, 2)
        Forces of all fixed points for a unit displacement of them in x, in y.
    centroids : ndarray, shape (n, 2)
        m.
    points : dict
        Measured points: name -> (block, place in m).
    loads : list
        Point loads: (block, place in m).
    """

    stiffness: np.ndarray
    mass: np.ndarray
    support: np.ndarray
    centroids: np.ndarray
    points: dict
    loads: list

    @classmethod
    def of(cls, file: Path, changes: Mapping | None = None, **more) -> DiscreteModel:
        """The model of an input with changes, as for `sitedda.Simulation`."""
        changes = dict(changes or {}) | more
        parsed = f90nml.Parser().reads(changed_input(Path(file).read_text(), changes))
        with Simulation(file, changes=changes) as simulation:
            polygons = [np.array(polygon) for polygon in simulation.polygons]
            contacts = simulation.contacts
            names = simulation.block_names
        moments = [_moments(polygon) for polygon in polygons]
        centroids = np.array([m[1] for m in moments])
        n = len(polygons)
        mass, stiffness = np.zeros((6 * n, 6 * n)), np.zeros((6 * n, 6 * n))
        for b, material in enumerate(_materials(parsed)):
            here = slice(6 * b, 6 * b + 6)
            mass[here, here] = _mass(material, *moments[b])
            stiffness[here, here] += _elastic(material, moments[b][0])
        shape = _Shape(centroids)
        normal = parsed["contact"]["normal_stiffness"]
        shear = normal / parsed["contact"].get("shear_ratio", 2.5)
        _add_contacts(stiffness, polygons, contacts, shape, (normal, shear))
        ratio = parsed["contact"].get("fixed_point_ratio", 100.0)
        support = _add_supports(stiffness, parsed, polygons, names, shape, ratio * normal)
        points = {
            group["name"]: (_block_of(group, polygons, names), (group["x"], group["y"]))
            for group in _groups(parsed, "measured_point")
        }
        loads = [
            (_block_of(group, polygons, names), (group["x"], group["y"]))
            for group in _groups(parsed, "load")
        ]
        return cls(stiffness, mass, support, centroids, points, loads)

    def row(self, place, axis: int = 0) -> np.ndarray:
        """Row that gives the displacement along an axis of a measured point (name), or of a
        (block, place)."""
        block, where = self.points[place] if isinstance(place, str) else place
        return _Shape(self.centroids)(block, where)[axis]

    @cached_property
    def _modes(self) -> tuple[np.ndarray, np.ndarray]:
        square, shapes = eigh(self.stiffness, self.mass)
        return np.sqrt(np.maximum(square, 0.0)), shapes

    @property
    def omega(self) -> np.ndarray:
        """Undamped angular frequencies, ascending, rad/s."""
        return self._modes[0]

    @property
    def frequencies(self) -> np.ndarray:
        """Undamped frequencies, ascending, Hz."""
        return self.omega / (2 * np.pi)

    def mode(self, number: int) -> np.ndarray:
        """Mass-normalised shape of a mode, shape (6n,)."""
        return self._modes[1][:, number]

    def share(self, axis: int) -> np.ndarray:
        """Effective mass of each mode over the total, for motion along an axis."""
        unit = np.zeros(len(self.mass))
        unit[axis::6] = 1.0
        return (self._modes[1].T @ self.mass @ unit) ** 2 / (unit @ self.mass @ unit)

    def first(self, axis: int) -> int:
        """The mode that carries the most mass along an axis."""
        return int(np.argmax(self.share(axis)))

    def transfer(self, frequency, time_step: float, surface: str, base: str, loading: str):
        """Transfer function of the scheme between two points for motion in x.

        With z = exp(iωΔt): [(2M/Δt² + K) z - 2M/Δt² - (4M/Δt²)(z-1)/(z+1)] x = F z.

        Parameters
        ----------
        frequency : array_like
            Hz.
        time_step : float
            Δt, s.
        surface, base : str
            Measured points.
        loading : str
            'displacement': of the fixed points; ratio of the two points' motions.
            'acceleration': as body force in the frame of the base; 1 + relative acceleration of
            the surface over the base's.
        """
        frequency = np.atleast_1d(frequency)
        force = self.support[:, 0]
        if loading == "acceleration":
            unit = np.zeros(len(self.mass))
            unit[0::6] = 1.0
            force = -self.mass @ unit
        ratios = [self._at(f, time_step, force) for f in frequency]
        top = np.array([self.row(surface) @ x for x in ratios])
        if loading == "displacement":
            return top / np.array([self.row(base) @ x for x in ratios])
        tangent = np.tan(np.pi * frequency * time_step)
        measured = -((2 / time_step * tangent) ** 2) / (1 + 1j * tangent)
        return 1 + top * measured

    def _at(self, frequency: float, time_step: float, force: np.ndarray) -> np.ndarray:
        z = np.exp(2j * np.pi * frequency * time_step)
        inertia = self.mass * 2 / time_step**2
        step = (inertia + self.stiffness) * z - inertia - 2 * inertia * (z - 1) / (z + 1)
        return np.linalg.solve(step, force * z)

    def history(
        self, row: np.ndarray, force: np.ndarray, series, time_step: float, factor: float = 1.0
    ) -> np.ndarray:
        """Displacement after each step under force × series, from rest, mode by mode.

        Parameters
        ----------
        row : ndarray, shape (6n,)
            What is measured, see `row`.
        force : ndarray, shape (6n,)
            Where the force acts.
        series : array_like, shape (steps,)
            Its factor at the end of each step.
        time_step : float
            Δt, s.
        factor : float
            Dynamic factor.
        """
        omega, shapes = self._modes
        weight = (row @ shapes) * (force @ shapes)
        result = np.zeros(len(series))
        poles = _poles(omega, time_step, factor)
        for mode in np.flatnonzero(abs(weight) > 1e-14 * abs(weight).max()):
            result += lfilter(weight[mode] * np.array([1.0, factor, 0.0]), poles[:, mode], series)
        return result


@dataclass(frozen=True)
class _Shape:
    """Shape matrix T of paper eq. 4 in the unknowns of all blocks."""

    centroids: np.ndarray

    def __call__(self, block: int, place) -> np.ndarray:
        x, y = np.asarray(place) - self.centroids[block]
        rows = np.zeros((2, 6 * len(self.centroids)))
        rows[:, 6 * block : 6 * block + 6] = [[1, 0, -y, x, 0, y / 2], [0, 1, x, 0, y, x / 2]]
        return rows


def _groups(parsed, name: str) -> list:
    found = parsed.get(name, [])
    return found if isinstance(found, list) else [found]


def _materials(parsed) -> list:
    """Material of each block, in the order of the groups."""
    materials = _groups(parsed, "material")
    by_name = {material.get("name", ""): material for material in materials}
    return [
        by_name.get(group.get("material", ""), materials[0])
        for name in parsed
        if name in ("block", "layers", "drums")
        for group in _groups(parsed, name)
        for _ in range(group.get("count", 1))
    ]


def _moments(polygon: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """Area, centroid and ∫(r - c)(r - c)ᵀ of a polygon, by triangles from its first vertex."""
    origin = polygon[0]
    a, b = polygon[1:-1] - origin, polygon[2:] - origin
    twice = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    area = twice.sum() / 2
    centre = (twice[:, None] * (a + b)).sum(0) / (6 * area)
    second = np.zeros((2, 2))
    for weight, p, q in zip(twice, a, b, strict=True):
        second += weight / 24 * (np.outer(p, p) + np.outer(q, q) + np.outer(p + q, p + q))
    return area, centre + origin, second - area * np.outer(centre, centre)


def _mass(material, area: float, _centre, second: np.ndarray) -> np.ndarray:
    """ρ ∫TᵀT about the centroid."""
    (xx, xy), (_, yy) = second
    matrix = np.zeros((6, 6))
    matrix[0, 0] = matrix[1, 1] = area
    matrix[2, 2:] = [xx + yy, -xy, xy, (xx - yy) / 2]
    matrix[3, 3:] = [xx, 0.0, xy / 2]
    matrix[4, 4:] = [yy, xy / 2]
    matrix[5, 5] = (xx + yy) / 4
    return material["density"] * (matrix + np.triu(matrix, 1).T)


def _elastic(material, area: float) -> np.ndarray:
    """Area × D of plane stress on the strains."""
    young, nu = material["young_modulus"], material["poisson_ratio"]
    matrix = np.zeros((6, 6))
    plane = np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
    matrix[3:, 3:] = area * young / (1 - nu**2) * plane
    return matrix


def _add_contacts(stiffness, polygons, contacts, shape: _Shape, springs) -> None:
    """Normal and shear spring of every vertex that touches an edge, of those the engine lists."""
    vertices = np.concatenate(polygons)
    owner = np.repeat(np.arange(len(polygons)), [len(polygon) for polygon in polygons])
    following = np.concatenate([np.roll(polygon, -1, axis=0) for polygon in polygons])
    for vertex, edge in zip(contacts["vertex"], contacts["edge"], strict=True):
        place, along = vertices[vertex], following[edge] - vertices[edge]
        length = np.hypot(*along)
        along = along / length
        foot = along @ (place - vertices[edge])
        off = np.hypot(*(place - vertices[edge] - np.clip(foot, 0.0, length) * along))
        if off > _TOUCHING:
            continue
        apart = shape(owner[vertex], place) - shape(owner[edge], place)
        for spring, direction in zip(springs, ((along[1], -along[0]), along), strict=True):
            row = np.asarray(direction) @ apart
            stiffness += spring * np.outer(row, row)


def _add_supports(stiffness, parsed, polygons, names, shape: _Shape, spring: float) -> np.ndarray:
    support = np.zeros((len(stiffness), 2))
    for group in _groups(parsed, "fixed_point"):
        rows = shape(_block_of(group, polygons, names), (group["x"], group["y"]))
        for axis, letter in enumerate("xy"):
            if letter in group.get("direction", "xy"):
                stiffness += spring * np.outer(rows[axis], rows[axis])
                support[:, axis] += spring * rows[axis]
    return support


def _block_of(group, polygons, names) -> int:
    """The block that a point belongs to: by name, or the first that holds it."""
    if group.get("block"):
        return names.index(group["block"])
    place = np.array([group["x"], group["y"]])
    for number, polygon in enumerate(polygons):
        sides = np.roll(polygon, -1, axis=0) - polygon
        away = place - polygon
        if np.all(sides[:, 0] * away[:, 1] - sides[:, 1] * away[:, 0] >= -1e-9):
            return number
    raise ValueError(f"no block holds the point {place}")
