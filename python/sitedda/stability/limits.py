# SPDX-License-Identifier: GPL-3.0-or-later
"""Limit analysis of rigid blocks: the largest load in equilibrium within the joint strength.

A joint of length L transmits forces at its two ends, with N ≥ −f_t L/2 and |T| ≤ c L/2 + μN.  A
linear programme maximises the factor of the load at which such forces balance all blocks (Livesley
1978); the multipliers of the balance equations are the mechanism.  A compressive strength bounds
the moment of a joint, |M| ≤ N (L − N/σ_c)/2; tangents to this bound are added until no joint
exceeds it.  The result is the limit with associated friction, in which joints dilate as they slip;
no equilibrium exists above it.

Limits without dilation may be lower.  A sequence of programmes bounds |T| by the normal forces of
the preceding programme (Gilbert, Casapulla and Ahmed 2006, Computers and Structures 84, 873–887).
For the mechanism of each programme, a second programme minimises the factor with |T| ≤ μN, T = ±μN
at slipping joints, and N = 0 at opening joints.  If it has a solution, mechanism and forces prove a
limit.  Several limits may exist, because normal forces are indeterminate; the result is the lowest
limit from many starting forces.
"""

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.optimize import linprog, minimize_scalar
from scipy.sparse import block_array, coo_array, diags_array, hstack, vstack

from ..base.arguments import COUNT, POSITIVE, Range, first_of, floats, not_negative, positive
from ..base.core import engine_names
from ..base.errors import ConvergenceError, InputError
from ..build.cutting.rings import Rings
from ..build.model import Model
from ..output.scene import Interfaces, Scene, is_netcdf
from .bodies import block_at
from .reduction import judge_blocks
from .strength import lines_of, released, static_model

_MOST = 1e3  # ratio of load to weight above which the factor counts as infinite
_UNLIMITED = _MOST * (1 - 1e-6)  # factors from this value on count as infinite
_PRESTRESS = 1e-6  # penalty on normal forces in the objective, which prevents needless prestress
_LITTLE = 1e-8  # smaller penalty for mechanisms, whose dilation has an error of this size
_GAIN = 5.0  # in programme n, the weight of the latest normal forces is _GAIN / (_GAIN + n)
_PROGRAMMES = 30  # largest number of programmes in a sequence
_MOVES = 1e-7, 5.0  # smallest nonzero multiplier / largest multiplier, and / penalty
_STARTS = 60  # largest number of blocks whose contact forces are minimised for a start
_SLIDES = 0.5  # smallest ratio of the work of slip to the work of the load if the model slides
_CORNER = 1e-6  # largest distance of a corner contact from an end of the edge / its length
_AXES = {"x": [(1.0, 0.0)], "y": [(0.0, 1.0)], "xy": [(1.0, 0.0), (0.0, 1.0)], "none": []}
_LOADS = ("load", "traction", "water")  # groups of dead loads, which the engine computes
_LAWS = ("coulomb", "crushing", "mohr_coulomb")
_CUTS, _CRUSHED = 60, 1e-7  # largest number of rounds of tangents; tolerance of a moment / N L
# Moments of joints that do not limit the factor may keep changing.  An excess of _LEFT × median
# weight is accepted after _ROUNDS rounds in which the factor changes by at most _STILL.
_LEFT, _STILL, _ROUNDS = 1e-3, 1e-6, 3
_FRICTION = Range(0.0, 89.9)  # friction angles of backfill, °
_TANGENTS = 0.5 ** np.arange(8)  # forces at the first tangents / largest force of a joint


@dataclass(frozen=True)
class Limit:
    """A limit load and its mechanism.

    Attributes
    ----------
    factor : float
        Largest ratio of the body force to the weight; inf above 1000.
    displacement : ndarray, shape (blocks, 3)
        The mechanism: x, y (m) and rotation (rad) of each block, scaled so that the largest
        displacement of a corner is 1 m.
    verdicts : tuple of str
        Motion of each block: 'stable', 'slides' or 'topples'.
    slides : bool
        Whether slip dissipates at least half of the work of the body force.
    names : tuple of str
        Names of the blocks.
    blocks : ndarray of int, shape (points, 2)
        Indices of the two blocks in contact at each point; a joint has a point at each of its ends.
    points : ndarray, shape (points, 2)
        Positions, m.
    normals : ndarray, shape (points, 2)
        Unit vectors from the first of these blocks into the second.
    normal_force, shear_force : ndarray, shape (points,)
        Forces on the second block that balance all blocks at the limit, N/m: compression, and force
        along the normal rotated by 90° counter-clockwise.
    polygons : list of ndarray
        Polygons of the blocks, shape (vertices, 2), m.
    bolt_force : dict
        Axial force of each bolt at the limit, N/m.
    title : str
        Title of the picture; empty: a title with the factor.
    lines : list of (str, ndarray)
        Bolts and water: kind ('bolt' or 'water') and line, shape (points, 2), m.
    """

    factor: float
    displacement: np.ndarray
    verdicts: tuple[str, ...]
    slides: bool
    names: tuple[str, ...] = field(repr=False)
    blocks: np.ndarray = field(repr=False)
    points: np.ndarray = field(repr=False)
    normals: np.ndarray = field(repr=False)
    normal_force: np.ndarray = field(repr=False)
    shear_force: np.ndarray = field(repr=False)
    polygons: list[np.ndarray] = field(repr=False)
    bolt_force: dict[str, float] = field(default_factory=dict)
    title: str = ""
    lines: list[tuple[str, np.ndarray]] = field(default_factory=list, repr=False)

    @property
    def thrust(self) -> np.ndarray:
        """Return resultants of closed joints: both blocks (from 0), x, y (m), N and T (N/m)."""
        _, firsts, joint = np.unique(np.column_stack([self.blocks, self.normals.round(9)]), axis=0,
                                    return_index=True, return_inverse=True)  # fmt: skip
        weighted = self.normal_force[:, None] * self.points
        values = np.column_stack([weighted, self.normal_force, self.shear_force])
        total = np.array([np.bincount(joint.ravel(), column) for column in values.T]).T
        loaded = total[:, 2] > _CORNER * self.normal_force.max(initial=0.0)
        centres = total[loaded, :2] / total[loaded, 2:3]
        return np.hstack([self.blocks[firsts][loaded], centres, total[loaded, 2:]])

    @property
    def openings(self) -> np.ndarray:
        """Return opening and slip at each point in the mechanism, shape (points, 2), m."""
        centres = Rings.of(self.polygons).centroids()
        arms = self.points[:, None] - centres[self.blocks]
        move = self.displacement[self.blocks]
        path = move[..., :2] + move[..., 2:] * np.stack([-arms[..., 1], arms[..., 0]], axis=-1)
        tangents = np.column_stack([-self.normals[:, 1], self.normals[:, 0]])
        jump = path[:, 1] - path[:, 0]
        return np.column_stack([np.sum(jump * axis, axis=1) for axis in (self.normals, tangents)])

    def to_csv(self) -> str:
        """Return forces, opening and slip at each point as CSV."""
        numbers = np.column_stack([self.points, self.normal_force, self.shear_force, self.openings])
        heads = "block,other,x (m),y (m),normal force (N/m),shear force (N/m),opening (m),slip (m)"
        lines = [heads]
        for pair, row in zip(self.blocks, numbers, strict=True):
            lines.append(",".join([*(self.names[i] for i in pair), *map("{:.9g}".format, row)]))
        return "\n".join([*lines, ""])

    def draw(self, axes=None):
        """Draw the blocks coloured by their verdicts, with arrows; return matplotlib axes."""
        from .picture import draw_mechanism

        title = self.title or f"Body force {self.factor:.4g} times the weight"
        return draw_mechanism(self, axes, title)


@dataclass(frozen=True)
class Limits:
    """Limits of a load with and without dilation.

    Attributes
    ----------
    upper : Limit
        Limit with associated friction, above which no equilibrium exists.
    lower : Limit
        Lowest limit that was found for friction without dilation.  If its factor is 0, the weight
        alone may cause collapse.
    starts : int
        Number of starting forces in the search of limits without dilation.
    """

    upper: Limit
    lower: Limit
    starts: int


@dataclass(frozen=True)
class Travel:
    """Limit loads of axles at positions along a line, with associated friction.

    Attributes
    ----------
    position : ndarray, shape (positions,)
        Positions of the first axle along the line, m.
    load : ndarray, shape (positions,)
        Limit of the total weight of all axles at each position, N/m; inf: unlimited.
    worst, least : float
        Position with the smallest limit load, m, and this load, N/m.
    limit : Limit
        Limit at the position `worst`; its factor is the load divided by the weight of the blocks.
    """

    position: np.ndarray
    load: np.ndarray
    worst: float
    least: float
    limit: Limit


@dataclass(frozen=True)
class Backfill:
    """Soil on edges that face upwards or sideways: weight, and pressures from 0 to passive."""

    surface: np.ndarray  # from left to right, shape (points, 2), m; no soil is beyond its ends
    unit_weight: float  # N/m³
    friction_angle: float  # φ, degrees; passive pressure / vertical stress = tan²(45° + φ/2)

    def __post_init__(self):
        """Raise InputError if a value is invalid."""
        x = _pairs("surface", self.surface, least=2)[:, 0]
        if not (np.diff(x) > 0.0).all():
            raise InputError(f"surface must have ascending x, got {x.tolist()}")
        POSITIVE.check("unit_weight", self.unit_weight)
        _FRICTION.check("friction_angle", self.friction_angle)

    def forces(self, begin: np.ndarray, end: np.ndarray):
        """Yield position (m), weight and passive force (N/m) of the soil on parts of an edge.

        The block is on the left of the edge.  The surface is straight above each part.
        """
        surface = np.asarray(self.surface, dtype=float)
        reach, width = _CORNER * np.ptp(surface[:, 0]), end[0] - begin[0]
        kinks = (surface[:, 0] - begin[0]) / width if width else np.zeros(0)
        shares = np.unique([0.0, *kinks[(kinks > 0.0) & (kinks < 1.0)], 1.0])
        for low, high in pairwise(shares):
            middle = begin[0] + 0.5 * (low + high) * width
            if surface[0, 0] - reach <= middle <= surface[-1, 0] + reach:
                part = [begin + share * (end - begin) for share in (low, high)]
                yield from self._forces_below_line(surface, *part)

    def _forces_below_line(self, surface: np.ndarray, begin: np.ndarray, end: np.ndarray):
        """Yield the same for the part of an edge that is below a straight surface."""
        depth = [np.interp(p[0], *surface.T) - p[1] for p in (begin, end)]
        if max(depth) <= 0.0:
            return
        if min(depth) < 0.0:  # only the part below the surface is loaded
            crossing = begin + (end - begin) * depth[0] / (depth[0] - depth[1])
            begin, end = (crossing, end) if depth[0] < 0.0 else (begin, crossing)
        upper, lower = np.maximum(depth, 0.0)
        stress = 0.5 * self.unit_weight * (upper + lower)  # mean, vertical
        width, height = end - begin
        passive = math.tan(math.radians(45.0 + 0.5 * self.friction_angle)) ** 2
        point = begin + (end - begin) * (upper + 2 * lower) / (3 * (upper + lower))
        yield point, stress * np.array([0.0, width]), passive * stress * np.array([-height, 0.0])


def _pairs(name: str, values, least: int) -> np.ndarray:
    """Return finite pairs of numbers, shape (n, 2), n ≥ `least`; raise InputError otherwise."""
    pairs = floats(name, values)
    if pairs.ndim != 2 or pairs.shape[1] != 2 or len(pairs) < least:
        raise InputError(f"{name} has shape {pairs.shape}: it must be (n, 2), with n >= {least}")
    if not np.isfinite(pairs).all():
        raise InputError(f"{name} must be finite, got {first_of(pairs, ~np.isfinite(pairs)):g}")
    return pairs


def travelling_axle(
    source,
    line,
    *,
    axles=((0.0, 1.0),),
    positions: int = 41,
    backfill: Backfill | None = None,
    changes: Mapping | None = None,
) -> Travel:
    """Find the position of axles along a line at which their limit load is smallest.

    Parameters
    ----------
    source : path or Model
        Input.
    line : array_like, shape (points, 2)
        Polyline on blocks, m.
    axles : sequence of (float, float)
        Distance behind the first axle (m) and relative weight of each axle.  Axles beyond the ends
        of the line do not act.
    positions : int
        Number of evenly spaced positions; a search between the neighbours of the worst position
        then refines it.
    backfill : Backfill, optional
        Soil, which does not spread the loads of the axles.
    changes : mapping, optional
        Changes of the input, see `Simulation`.

    Raises
    ------
    InputError
        As in `limit_analysis`, if a position on the line is outside of all blocks, or if no axle
        is on the line at any position.
    """
    points, pairs = _pairs("line", line, least=2), _pairs("axles", axles, least=1)
    distances = not_negative("distances of axles", pairs[:, 0])
    weights = positive("weights of axles", pairs[:, 1])
    COUNT.check("positions", positions)
    programme = _Programme(*_scene_and_loads(source, changes), np.array([1.0, 0.0]), None, backfill)
    along = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))

    def solve(position: float) -> _Solution:
        offsets = position - distances
        is_on = (offsets >= 0.0) & (offsets <= along[-1])
        points_on = np.column_stack([np.interp(offsets[is_on], along, axis) for axis in points.T])
        programme.set_axles(points_on, weights[is_on] / weights.sum())
        return programme.upper()

    stations = np.linspace(0.0, along[-1], positions)
    if stations[-1] < distances.min():
        raise InputError(f"axles: none is on the line, because all distances exceed "
                         f"{stations[-1]:g} m")  # fmt: skip
    factors = np.array([solve(position).factor for position in stations])
    lowest = int(np.argmin(factors))
    low, high = stations[max(lowest - 1, 0)], stations[min(lowest + 1, len(stations) - 1)]
    bounded = {"bounds": (low, high), "method": "bounded"}
    refined = minimize_scalar(lambda position: solve(position).factor, **bounded)
    worst_position = stations[lowest] if factors[lowest] <= refined.fun else float(refined.x)
    result = programme.limit(solve(worst_position))
    loads = np.where(factors >= _UNLIMITED, np.inf, factors * programme.weight)
    load = result.factor * programme.weight
    title = f"Axles of {load:.4g} N/m at the worst position, x = {worst_position:.4g} m"
    result = replace(result, title=title)
    return Travel(stations, loads, float(worst_position), load, result)


def limit_analysis(
    source,
    *,
    direction=(1.0, 0.0),
    load: str | None = None,
    backfill: Backfill | None = None,
    changes: Mapping | None = None,
) -> Limits:
    """Find the limit of a body force on rigid blocks under their weight and other loads.

    Parameters
    ----------
    source : path, Model, Run, Dataset or Simulation
        Input or output; the geometry of an output is that of its first frame.  Stages and motions
        are ignored.  Loads, tractions and water of an input have their values at time 0.
    direction : (float, float)
        Direction of the body force; the length of this vector is ignored.
    load : str, optional
        Name of &load groups that increase instead of the body force; the factor multiplies their
        forces at time 0.
    backfill : Backfill, optional
    changes : mapping, optional
        Changes of an input, see `Simulation`.

    Raises
    ------
    InputError
        If joint laws include more than friction, cohesion, tension and crushing, bodies have cells,
        bolts are grouted, an output has loads, or no factor of the load is in equilibrium.
    ConvergenceError
        If no limit without dilation is found.
    """
    direction = _unit_vector(direction)
    programme = _Programme(*_scene_and_loads(source, changes), direction, load, backfill)
    lower, starts = _undilated_limit(programme, programme.upper())
    return Limits(programme.limit(programme.upper(_LITTLE)), programme.limit(lower), starts)


def _unit_vector(direction) -> np.ndarray:
    """Return the unit vector of a direction; raise InputError if it is invalid."""
    try:
        vector = np.asarray(direction, dtype=float)
    except (TypeError, ValueError):
        vector = np.zeros(0)
    if vector.shape != (2,) or not 0 < np.linalg.norm(vector) < np.inf:
        raise InputError(f"direction = {direction!r} must be two numbers, not both zero")
    return vector / np.linalg.norm(vector)


def _scene_and_loads(source, changes: Mapping | None) -> tuple[Scene, np.ndarray | None]:
    """Return the first geometry of an input or output, and the loads on blocks of an input."""
    is_file = isinstance(source, str | os.PathLike)
    if isinstance(source, Model) or (is_file and not is_netcdf(Path(source))):
        model = static_model(source, changes)
        with released(model, 1.0, None, 1.0, 1) as simulation:
            scene = Scene.of(simulation)
        _check_supported(scene)
        model.clear("bolt")  # bolt forces are unknowns of the programme, not loads
        with released(model, 1.0, None, 1.0, 1) as simulation:
            return scene, simulation.loads[:, :3]
    if changes:
        raise InputError("changes require an input, not an output")
    scene = Scene.of(source)
    _check_supported(scene)
    for kind in _LOADS:
        if scene.groups.get(kind, []):
            raise InputError(f"an output does not contain the loads of &{kind}: give the input")
    return scene, None


def _check_supported(scene: Scene) -> None:
    """Raise InputError if limit analysis does not support a joint, body or bolt of the model."""
    for group in scene.groups.get("joint", []):
        name = str(group.get("name", "")).strip()
        law = str(group.get("law", "coulomb")).strip()
        if law not in _LAWS:
            laws = ", ".join(map(repr, _LAWS))
            raise InputError(f"joint {name!r} has the law {law!r}: the law must be one of {laws}")
        for peak in ("friction_angle", "cohesion", "tensile_strength"):
            value = group.get(peak, 0.0)
            low = group.get(f"residual_{peak}", value if peak == "friction_angle" else 0.0)
            if law == "mohr_coulomb" and low != value:
                raise InputError(f"joint {name!r} weakens: limit analysis requires "
                                 f"residual_{peak} = {value:g}")  # fmt: skip
    if scene.welded.any():
        raise InputError("the model has bodies that bend: limit analysis requires rigid blocks")
    for group in scene.groups.get("bolt", []):
        if group.get("grouted"):
            raise InputError(f"bolt {str(group['name']).strip()!r} is grouted: limit analysis "
                             "supports only bolts anchored at their ends")  # fmt: skip


@dataclass(frozen=True)
class _Solution:
    """Solution of a programme: factor, forces (N/m) and velocities of the blocks, (blocks, 3).

    `binding`: indices of the binding inequalities, and of the forces at their lower and upper
    bounds, at which the mechanism slips or opens.
    """

    factor: float
    normal: np.ndarray
    shear: np.ndarray
    bolts: np.ndarray
    velocity: np.ndarray
    binding: tuple[np.ndarray, np.ndarray, np.ndarray]


class _Programme:
    """Linear programme of the equilibrium of all blocks; forces are scaled by the median weight."""

    def __init__(
        self,
        scene: Scene,
        loads: np.ndarray | None,
        direction: np.ndarray,
        load: str | None,
        backfill: Backfill | None = None,
    ):
        self.scene = scene
        self.polygons = scene.polygons(0)
        self._set_weights(direction)
        if loads is not None:
            scale = np.column_stack([np.ones((len(self.radii), 2)), self.radii])
            self.dead = loads / self.unit / scale
        if load is not None:
            self._set_load(load)
        self._set_points()
        self.passive = list(self._add_backfill(backfill)) if backfill else []
        self._cuts: list[tuple[coo_array, np.ndarray]] = []
        if self.crushing.size:
            pairs = np.repeat(self.crushing, 2)
            for ratio in _TANGENTS:
                self._bound_moments(pairs, np.tile([1.0, -1.0], len(self.crushing)),
                          ratio * self.most[pairs] * self.length[pairs])  # fmt: skip

    def _set_load(self, name: str) -> None:
        """Move the &load groups of a name from the dead loads to the variable load."""
        live = np.zeros_like(self.dead)
        for group in self.scene.groups.get("load", []):
            if str(group.get("name", "")).strip() == name:
                time = np.asarray(group["time"], dtype=float)
                values = (group.get(name, 0.0) for name in ("force_x", "force_y"))
                series = (np.broadcast_to(forces, len(time)) for forces in values)
                force = [float(np.interp(0.0, time, forces, 0.0, 0.0)) for forces in series]
                point = np.array([group["x"], group["y"]], dtype=float)
                block = self._block_at(point, str(group.get("block", "")).strip())
                live += self._block_forces([block], point[None], np.array([force]) / self.unit)
        if not live.any():
            raise InputError(f"load = {name!r}: no &load of this name acts at time 0")
        self.dead, self.live = self.dead - live, live

    def set_axles(self, points: np.ndarray, weights: np.ndarray) -> None:
        """Set the variable load: axles at positions (m), with fractions of the total weight."""
        blocks = [self._block_at(point, "") for point in points]
        self.live = self._block_forces(blocks, points, weights[:, None] * self.down * self.weight
                                 / self.unit)  # fmt: skip

    def _block_forces(self, blocks, points, forces) -> np.ndarray:
        """Return forces and moments on all blocks, (blocks, 3), due to scaled forces (k, 2)."""
        if not len(blocks):
            return np.zeros((len(self.polygons), 3))
        columns = self._equilibrium_columns(np.array(blocks), points, forces)
        return columns.sum(axis=1).reshape(-1, 3)

    def upper(self, prestress: float = _PRESTRESS) -> _Solution:
        """Return the limit with associated friction."""
        return self.solve(self.friction, self.cohesion, prestress=prestress)

    def _set_weights(self, direction: np.ndarray) -> None:
        """Set weights, centroids, radii, dead load (weight) and variable load (body force)."""
        gravity = np.array(self.scene.groups.get("control", [])[0].get("gravity", (0.0, 0.0)))
        if not gravity.any():
            raise InputError("limit analysis requires weight: set gravity of &control")
        density = [float(group["density"]) for group in self.scene.groups.get("material", [])]
        mass = np.array(density)[self.scene.material] * self.scene.areas()
        g = np.linalg.norm(gravity)
        self.unit = float(np.median(mass) * g)
        self.weight, self.down = float(mass.sum() * g), gravity / g
        zeros = np.zeros((len(mass), 1))
        self.dead = np.hstack([mass[:, None] * gravity / self.unit, zeros])
        self.live = np.hstack([mass[:, None] * g * direction / self.unit, zeros])
        self.centres = Rings.of(self.polygons).centroids()
        self.radii: np.ndarray = np.array([
            np.linalg.norm(polygon - centre, axis=1).max()
            for polygon, centre in zip(self.polygons, self.centres, strict=True)
        ])  # fmt: skip

    def _set_points(self) -> None:
        """Set the contact points: ends of joints, then single corners on edges."""
        scene, faces = self.scene, self.scene.interfaces
        angle = np.array([float(g["friction_angle"]) for g in scene.groups.get("joint", [])])
        tangent = np.tan(np.radians(angle))
        corners, edges, normals = self._single_corners()
        ends = np.stack([faces.start, faces.end], axis=1).reshape(-1, 2)
        pairs = np.repeat(np.column_stack([faces.first, faces.second]), 2, axis=0)
        single = np.column_stack([scene.owner[edges], scene.owner[corners]])
        touched = np.column_stack([edges, corners, scene.previous_vertex[corners]])
        self.blocks = np.vstack([pairs, single])
        self.points = np.vstack([ends, scene.vertices(0)[corners]])
        self.normals = np.vstack([np.repeat(faces.normal, 2, axis=0), normals])
        self.tangents = np.column_stack([-self.normals[:, 1], self.normals[:, 0]])
        corner_friction = tangent[scene.joint[touched]].min(axis=1, initial=np.inf)
        self.friction = np.append(np.repeat(tangent[scene.interface_joints], 2), corner_friction)
        self._set_strengths(len(single))

    def _set_strengths(self, corners: int) -> None:
        """Set cohesive and tensile forces at the points, and strengths of crushing joints."""
        scene, faces = self.scene, self.scene.interfaces
        self.length = np.linalg.norm(faces.end - faces.start, axis=1)

        def strength(name: str, default: float) -> np.ndarray:
            groups = scene.groups.get("joint", [])
            values = [default if (v := group.get(name)) is None else v for group in groups]
            return np.array(values, dtype=float)[scene.interface_joints]

        half = 0.5 * self.length
        zeros = np.zeros(corners)
        self.cohesion = np.append(np.repeat(strength("cohesion", 0.0) * half, 2), zeros)
        self.tensile = strength("tensile_strength", 0.0)
        self.tension = np.append(np.repeat(self.tensile * half, 2), zeros)
        self.most = strength("crushing_strength", np.inf) + self.tensile
        self.crushing = np.flatnonzero(np.isfinite(self.most))

    def _bound_moments(self, joint: np.ndarray, side: np.ndarray, compression: np.ndarray) -> None:
        """Bound moments of the sign `side` by the tangents at N + f_t L = `pressed`, N/m."""
        length, strength = self.length[joint], self.most[joint]
        slope = 0.5 - compression / (strength * length)
        rows, n = np.arange(len(joint)), len(self.points)
        values = np.concatenate([0.5 * side - slope, -0.5 * side - slope])
        columns = np.concatenate([2 * joint, 2 * joint + 1])
        matrix = coo_array((values, (np.tile(rows, 2), columns)), shape=(len(joint), n))
        bound = slope * self.tensile[joint] * length + compression**2 / (2 * strength * length)
        self._cuts.append((matrix, bound))

    def _add_tangents(self, normal: np.ndarray, limit: float) -> bool:
        """Add tangents for joints whose moments exceed their strength.

        Return whether the excess, relative to the median weight, is larger than `limit`.
        """
        j = self.crushing
        ends = normal[2 * j], normal[2 * j + 1]
        length, compression = self.length[j], ends[0] + ends[1] + self.tensile[j] * self.length[j]
        moment = 0.5 * (ends[0] - ends[1])  # eccentricity / L
        excess = abs(moment) - 0.5 * compression * (1 - compression / (self.most[j] * length))
        exceeds = excess > _CRUSHED * np.maximum(compression, self.unit)
        if exceeds.any():
            self._bound_moments(j[exceeds], np.sign(moment[exceeds]), compression[exceeds])
        return bool(exceeds.any() and (excess / self.unit).max() > limit)

    def _single_corners(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return vertices, edges and normals (k, 2) of corners on edges that belong to no joint."""
        scene, contacts = self.scene, self.scene.contacts(0)
        vertex, edge = contacts["vertex"], contacts["edge"]
        points, normals = scene.contact_points(0, contacts)
        start = scene.vertices(0)[edge]
        edges = scene.vertices(0)[scene.next_vertex[edge]] - start
        length = np.linalg.norm(edges, axis=1)
        fraction = np.sum((points - start) * edges, axis=1) / length**2
        depth = np.sum((points - start) * normals, axis=1) / length
        on_edge = (fraction > _CORNER) & (fraction < 1 - _CORNER) & (abs(depth) < _CORNER)
        faces = scene.interfaces
        pairs = {*zip(faces.first_edge, faces.second_edge, strict=True)}
        pairs |= {(b, a) for a, b in pairs}
        touched = zip(vertex, scene.previous_vertex[vertex], edge, strict=True)
        single = [not pairs & {(v, e), (previous, e)} for v, previous, e in touched]
        mask = on_edge & np.array(single, dtype=bool)
        return vertex[mask], edge[mask], normals[mask]

    def _equilibrium_columns(self, block, point, force) -> coo_array:
        """Return one column of forces and moments on all blocks per unit force at a position."""
        arm = (point - self.centres[block]) / self.radii[block, None]
        moment = arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]
        values = np.column_stack([force, moment]).ravel()
        rows = (3 * block[:, None] + np.arange(3)).ravel()
        columns = np.repeat(np.arange(len(block)), 3)
        return coo_array((values, (rows, columns)), shape=(3 * len(self.polygons), len(block)))

    def _reaction_columns(self) -> coo_array:
        """Return the equilibrium columns of the reactions of fixed points and fixed edges."""
        columns = []
        for group in self.scene.groups.get("fixed_point", []):
            point = np.array([group["x"], group["y"]], dtype=float)
            block = self._block_at(point, str(group.get("block", "")).strip())
            axes = _AXES[str(group.get("direction", "xy")).strip()]
            columns += [(block, point, force) for force in axes]
        columns += self._supported_edges()
        if not columns:
            raise InputError("the blocks have no support: add a &fixed_point or &boundary")
        block, point, force = zip(*columns, strict=True)
        return self._equilibrium_columns(np.array(block), np.array(point), np.array(force))

    def _bolt_columns(self):
        """Yield name, equilibrium column and bounds (N/m) of the axial force of each bolt."""
        for group in self.scene.groups.get("bolt", []):
            inner_points = np.ravel(group.get("through", []))
            points = np.array([*group["from"], *inner_points, *group["to"]], dtype=float)
            points = points.reshape(-1, 2)
            inner = np.ravel(group.get("through_block", [])).tolist()
            inner += [""] * (len(points) - 2 - len(inner))
            owners = [group.get("from_block", ""), *inner, group.get("to_block", "")]
            pairs = zip(points, owners, strict=True)
            blocks = [self._block_at(point, str(name).strip()) for point, name in pairs]
            direction = np.diff(points, axis=0)
            direction /= np.linalg.norm(direction, axis=1)[:, None]
            force = np.pad(direction, ((0, 1), (0, 0))) - np.pad(direction, ((1, 0), (0, 0)))
            limit = group.get("yield_force")
            limit = np.inf if limit is None else float(limit)
            column = self._block_forces(blocks, points, force).reshape(-1, 1)
            yield str(group["name"]).strip(), column, (-limit if group.get("compression") else 0.0,
                                                        limit)  # fmt: skip

    def _add_backfill(self, backfill: Backfill):
        """Add the weight of backfill to the dead load; yield columns and bounds of pressures."""
        scene, begins = self.scene, self.scene.vertices(0)
        for edge, begin, end in _free_parts(scene.interfaces, begins, begins[scene.next_vertex]):
            width, height = begin[0] - end[0], abs(end[1] - begin[1])
            if width < -_CORNER * height:
                continue
            for point, weight, passive in backfill.forces(begin, end):
                block, peak = [scene.owner[edge]], float(np.linalg.norm(passive))
                self.dead += self._block_forces(block, point[None], weight[None] / self.unit)
                if peak > 0.0:
                    column = self._block_forces(block, point[None], passive[None] / peak)
                    yield "", column.reshape(-1, 1), (0.0, peak)

    def _block_at(self, point: np.ndarray, name: str) -> int:
        """Return the index of the block with a name or number, or else at a position."""
        return block_at(self.polygons, self.scene.names, point, name)

    def _supported_edges(self):
        """Yield block, position and direction of each reaction at the ends of fixed edges."""
        kinds = engine_names("boundary kinds")
        at_rest = dict(zip(kinds, engine_names("boundary kinds at rest"), strict=True))
        usual = dict(zip(kinds, engine_names("boundary directions"), strict=True))
        groups = self.scene.groups.get("boundary", [])
        if not groups:
            return
        edge, number = (self.scene.data[f"boundary_{n}"].values for n in ("edge", "edge_group"))
        for i, (lines, group) in enumerate(zip(self.scene.boundaries(0), groups, strict=True)):
            kind = at_rest.get(lines["kind"], lines["kind"])
            direction = str(group.get("direction", "")).strip() or usual[kind]
            if usual[kind] == "none":
                raise InputError(f"limit analysis does not support boundaries of kind {kind}")
            for begin, end, e in zip(lines["start"], lines["end"], edge[number == i], strict=True):
                along = (end - begin) / np.linalg.norm(end - begin)
                forces = _AXES.get(direction, [(along[1], -along[0])])
                yield from ((self.scene.owner[e], p, f) for p in (begin, end) for f in forces)

    @cached_property
    def balance(self):
        """Return the columns of equilibrium: normal forces, shear forces, reactions, bolts."""
        parts = []
        for force in (self.normals, self.tangents):
            first, second = (self._equilibrium_columns(block, self.points, force)
                             for block in self.blocks.T)  # fmt: skip
            parts.append(second - first)
        self.bolts = [*self._bolt_columns(), *self.passive]
        columns = [coo_array(column) for _, column, _ in self.bolts]
        return block_array([[*parts, self._reaction_columns(), *columns]], format="csc")

    def solve(
        self,
        slope: np.ndarray,
        bound: np.ndarray,
        limit: float = _MOST,
        rounds: int = _ROUNDS,
        prestress: float | np.ndarray = _PRESTRESS,
        binding=None,
    ) -> _Solution:
        """Maximise the factor up to `limit` with |T| ≤ bound + slope N at each point.

        If `binding` constraints of another solution are given, they become equations, and the
        factor is minimised.
        """
        previous, steady = np.inf, 0
        for _ in range(_CUTS):
            solution = self._solve_once(slope, bound, limit, prestress, binding)
            is_steady = abs(solution.factor - previous) <= _STILL * solution.factor
            steady = steady + 1 if is_steady else 0
            previous = solution.factor
            if not self._add_tangents(solution.normal, _LEFT if steady >= rounds else 0.0):
                return solution
        raise ConvergenceError(f"the moment limits of joints do not converge in {_CUTS} rounds")

    def _solve_once(self, slope, bound, limit: float, prestress, binding) -> _Solution:
        """Solve the linear programme with the present tangents of crushing joints."""
        balance = hstack([self.balance, coo_array(self.live.reshape(-1, 1))], format="csc")
        n, size = len(slope), balance.shape[1]
        zeros = coo_array((n, size - 2 * n))
        motion, slopes = diags_array(np.ones(n)), diags_array(slope)
        rows = [[-slopes, motion, zeros], [-slopes, -motion, zeros]]
        rows += [[cut, coo_array((cut.shape[0], n)), None] for cut, _ in self._cuts]
        matrix = block_array(rows, format="csr")
        right = np.concatenate([bound, bound, *(cut for _, cut in self._cuts)]) / self.unit
        bolts = np.reshape([pair for *_, pair in self.bolts], (-1, 2)) / self.unit
        bounds = np.tile([-np.inf, np.inf], (size, 1))
        bounds[:n, 0] = -self.tension / self.unit
        bounds[size - 1 - len(bolts) :] = [*bolts, (0.0, limit)]
        exact, balanced = balance, -self.dead.ravel()
        if binding is not None:
            fixed, low, high = binding
            exact = vstack([balance, matrix[fixed]], format="csc")
            balanced = np.append(balanced, right[fixed])
            bounds[low, 1], bounds[high, 0] = bounds[low, 0], bounds[high, 1]
        penalty = np.append(np.broadcast_to(prestress, n), np.zeros(size - n - 1))
        objective = np.append(penalty, -1.0 if binding is None else 1.0)
        options = {f"{name}_feasibility_tolerance": 1e-9 for name in ("primal", "dual")}
        result = linprog(objective, matrix, right, exact, balanced, bounds, options=options)
        if result.status == 2:
            raise InputError("no factor of the load is in equilibrium with the joint strengths")
        if result.status != 0:
            raise ConvergenceError(f"the linear program has no solution: {result.message}")
        multipliers = result.eqlin.marginals[: balance.shape[0]]
        velocity = -multipliers.reshape(-1, 3)
        velocity[:, 2] /= self.radii
        forces = result.x[: 2 * n] * self.unit
        bolt_forces = result.x[size - 1 - len(bolts) : -1] * self.unit
        tolerance = _MOVES[0] * abs(multipliers).max() + _MOVES[1] * penalty.max()
        low, high = result.lower.marginals[:-1], -result.upper.marginals[:-1]
        motions = [-result.ineqlin.marginals, low, high]
        binding = tuple(np.flatnonzero(motion > tolerance) for motion in motions)
        return _Solution(
            float(result.x[-1]), forces[:n], forces[n:], bolt_forces, velocity, binding
        )

    def limit(self, solution: _Solution) -> Limit:
        """Convert a solution to a `Limit`."""
        reach = np.hypot(*solution.velocity[:, :2].T) + self.radii * abs(solution.velocity[:, 2])
        unlimited = solution.factor >= _UNLIMITED
        velocity = solution.velocity / (1.0 if unlimited else reach.max())
        if unlimited:
            velocity = np.zeros_like(velocity)
        displacement = velocity * np.column_stack([np.ones((len(velocity), 2)), self.radii])
        work = self.unit * solution.factor * np.sum(self.live * displacement)
        pairs = zip(self.bolts, solution.bolts, strict=True)
        bolt_force = {name: float(force) for (name, *_), force in pairs if name}
        limit = Limit(
            np.inf if unlimited else solution.factor, velocity,
            judge_blocks(velocity, self.radii), False,
            tuple(self.scene.names), self.blocks, self.points, self.normals, solution.normal,
            solution.shear, self.polygons, bolt_force, lines=lines_of(self.scene.groups),
        )  # fmt: skip
        slip_work = abs(limit.openings[:, 1]) * abs(solution.shear)
        return replace(limit, slides=bool(slip_work.sum() > _SLIDES * work))


def _free_parts(faces: Interfaces, begins: np.ndarray, ends: np.ndarray):
    """Yield the number and both ends (m) of each part of an edge that belongs to no joint."""
    covered: dict[int, list[tuple[float, float]]] = {}
    for edges in (faces.first_edge, faces.second_edge):
        for edge, *corners in zip(edges, faces.start, faces.end, strict=True):
            begin, along = begins[edge], ends[edge] - begins[edge]
            low, high = sorted((corner - begin) @ along / (along @ along) for corner in corners)
            covered.setdefault(int(edge), []).append((low, high))
    for edge, (begin, end) in enumerate(zip(begins, ends, strict=True)):
        last = 0.0
        for low, high in [*sorted(covered.get(edge, [])), (1.0, 1.0)]:
            if low - last > _CORNER:
                yield edge, begin + last * (end - begin), begin + low * (end - begin)
            last = max(last, high)


def _undilated_limit(programme: _Programme, upper: _Solution) -> tuple[_Solution, int]:
    """Return the lowest limit without dilation from several starts, and the number of starts.

    The starts are normal forces at the upper limit, and, for each block, normal forces under the
    weight alone that load this block least.
    """
    blocks = len(programme.polygons)
    starts = [upper.normal] if upper.factor < _UNLIMITED else []
    for block in np.unique(np.linspace(0, blocks - 1, min(blocks, _STARTS)).round()):
        relieved = np.where((programme.blocks == block).any(axis=1), 1.0, _PRESTRESS)
        strength = programme.friction, programme.cohesion
        starts.append(programme.solve(*strength, limit=0.0, rounds=0, prestress=relieved).normal)
    cache: dict[tuple[bytes, ...], _Solution | None] = {}
    ends = [end for start in starts if (end := _find_limit(programme, start, cache)) is not None]
    if not ends:
        raise ConvergenceError(f"no limit without dilation was found from {len(starts)} starts")
    return min(ends, key=lambda end: end.factor), len(starts)


def _find_limit(programme: _Programme, normal: np.ndarray, cache: dict) -> _Solution | None:
    """Return the limit without dilation from starting normal forces `pressed`; None if not found.

    `cache` contains the limits of mechanisms by their binding constraints.
    """
    for i in range(_PROGRAMMES):
        bound = np.maximum(0.0, programme.cohesion + programme.friction * normal)
        try:
            solution = programme.solve(np.zeros(len(normal)), bound, rounds=0, prestress=_LITTLE)
        except InputError:
            return None
        if solution.factor >= _UNLIMITED:
            return solution
        key = tuple(part.tobytes() for part in solution.binding)
        if key not in cache:
            cache[key] = _least_load(programme, solution)
        if cache[key] is not None:
            return cache[key]
        normal = normal + _GAIN / (_GAIN + i) * (solution.normal - normal)
    return None


def _least_load(programme: _Programme, solution: _Solution) -> _Solution | None:
    """Return the limit with the mechanism of a solution and the smallest factor, if any."""
    strength = programme.friction, programme.cohesion
    try:
        lowest = programme.solve(*strength, rounds=0, prestress=0.0, binding=solution.binding)
    except (InputError, ConvergenceError):
        return None
    return replace(lowest, velocity=solution.velocity)
