# SPDX-License-Identifier: GPL-3.0-or-later
"""Limit analysis of dry rigid blocks: the largest body force that equilibrium with friction allows.

A joint pushes at its two ends with N ≥ 0 and |T| ≤ μN.  The largest factor of the body force at
which such forces balance all blocks is a linear programme (Livesley 1978); the multipliers of its
balance are the mechanism.  That is the limit of associated friction, in which joints open as they
slip; beyond it nothing rests.  Friction without dilation may hold less: a sequence of programmes
that bound |T| by the normal forces of those before (Gilbert, Casapulla and Ahmed 2006, Computers
and Structures 84, 873–887) ends with forces |T| ≤ μN and a mechanism that does not dilate.
"""

import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import block_array, coo_array, diags_array

from ..base.core import engine_names
from ..base.errors import ConvergenceError, InputError
from ..build.model import Model
from ..output.scene import Scene, is_netcdf
from .safety import _verdicts
from .strength import released, static_model

_MOST = 1e3  # times the weight: what holds this holds anything
_HELD = _MOST * (1 - 1e-6)
_PRESTRESS = 1e-6  # of the factor, for each normal force of the median weight: none without need
# Share of the latest normal forces in the next bound, and the programmes after which it falls as
# 1/n: with all of them sequences alternate.
_GAIN, _CONSTANT = 0.4, 30
_SETTLED, _TIMES = 1e-4, 5  # relative changes of the factor, one after the other, at the end
_PROGRAMMES = 300  # at most in a sequence
_SLIDES = 0.5  # of the work of the body force, taken by slip
_CORNER = 1e-6  # of its length: what is nearer to the end of an edge is at a corner
_AXES = {"x": [(1.0, 0.0)], "y": [(0.0, 1.0)], "xy": [(1.0, 0.0), (0.0, 1.0)], "none": []}
_USUAL = {"fixed": "xy", "springs": "xy", "roller": "normal"}  # direction of a boundary that holds
_OTHERS = ("load", "traction", "water", "bolt")  # groups of what this analysis does not know


@dataclass(frozen=True)
class Limit:
    """A limit of equilibrium and its mechanism.

    Attributes
    ----------
    factor : float
        Largest body force over the weight; inf if a thousand times the weight is held.
    displacement : ndarray, shape (blocks, 3)
        The mechanism: x, y (m) and rotation (rad) of each block, where the largest way of a corner
        is 1 m.
    verdicts : tuple of str
        Of each block: 'stable', 'slides' or 'topples'.
    slides : bool
        Slip of joints takes at least half of the work of the body force; else turning blocks, which
        are lifted, take more.
    names : tuple of str
        Of the blocks.
    blocks : ndarray of int, shape (points, 2)
        The blocks that touch at a point, from 0; a joint has a point at each of its ends.
    points : ndarray, shape (points, 2)
        Places, m.
    normals : ndarray, shape (points, 2)
        Unit vectors from the first of these blocks into the second.
    normal_force, shear_force : ndarray, shape (points,)
        A set of forces on the second block that balances all blocks at the limit, N/m: compression,
        and along the normal turned by 90° counter-clockwise.
    polygons : list of ndarray
        The blocks, shape (vertices, 2), m.
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

    def draw(self, axes=None):
        """Draw the blocks in the colours of their verdicts, with arrows; matplotlib axes."""
        from .picture import draw_mechanism

        return draw_mechanism(self, axes, f"Body force {self.factor:.4g} of the weight")


@dataclass(frozen=True)
class Limits:
    """Limits of a body force by the two kinds of friction.

    Attributes
    ----------
    upper : Limit
        With associated friction: beyond it nothing rests.
    lower : Limit
        With friction that does not dilate.
    """

    upper: Limit
    lower: Limit


def limit_analysis(source, *, direction=(1.0, 0.0), changes: Mapping | None = None) -> Limits:
    """Find the largest body force that dry rigid blocks bear beside their weight.

    Parameters
    ----------
    source : path, Model, Run, Dataset or Simulation
        An input or an output, which counts as its first frame shows it.  Stages and motions do not
        act.
    direction : (float, float)
        Of the body force; its length does not count.
    changes : mapping, optional
        Variables of an input to change first, see `Simulation`.

    Raises
    ------
    InputError
        If joints have strength or laws beyond dry friction, forces act beside the weight, or the
        blocks stand under no body force of this direction.
    ConvergenceError
        If the sequence without dilation finds no end.
    """
    direction = _unit_vector(direction)
    scene = _scene(source, changes)
    _require_dry(scene)
    programme = _Programme(scene, direction)
    friction = programme.friction
    upper = programme.solve(friction, np.zeros(len(friction)))
    return Limits(programme.limit(upper), programme.limit(_without_dilation(programme, upper)))


def _unit_vector(direction) -> np.ndarray:
    try:
        vector = np.asarray(direction, dtype=float)
    except (TypeError, ValueError):
        vector = np.zeros(0)
    if vector.shape != (2,) or not 0 < np.linalg.norm(vector) < np.inf:
        raise InputError(f"direction = {direction!r} must be two numbers, not both zero")
    return vector / np.linalg.norm(vector)


def _scene(source, changes: Mapping | None) -> Scene:
    """The scene of an output, or of an input before anything has moved."""
    is_file = isinstance(source, str | os.PathLike)
    if isinstance(source, Model) or (is_file and not is_netcdf(Path(source))):
        with released(static_model(source, changes), 1.0, None, 1.0, 1) as simulation:
            return Scene.of(simulation)
    if changes:
        raise InputError("changes are of an input; this is an output")
    return Scene.of(source)


def _require_dry(scene: Scene) -> None:
    for group in scene.groups.get("joint", []):
        name = str(group.get("name", "")).strip()
        if group.get("law", "coulomb").strip() != "coulomb":
            raise InputError(f"joint {name!r} has the law {group['law']!r}: it must be 'coulomb'")
        for strength in ("cohesion", "tensile_strength"):
            if group.get(strength):
                raise InputError(f"joint {name!r} has {strength}: limit analysis is of dry joints")
    if scene.welded.any():
        raise InputError("the model has bodies that bend: limit analysis is of rigid blocks")
    for kind in _OTHERS:
        if scene.groups.get(kind, []):
            raise InputError(f"the model has a &{kind}: limit analysis is of weight alone")


@dataclass(frozen=True)
class _Solution:
    """Of a programme: factor, forces at the points (N/m), velocities of the blocks (blocks, 3)."""

    factor: float
    normal: np.ndarray
    shear: np.ndarray
    velocity: np.ndarray


class _Programme:
    """Balance of all blocks as rows of a linear programme, forces over the median weight."""

    def __init__(self, scene: Scene, direction: np.ndarray):
        self.scene = scene
        self.polygons = scene.polygons(0)
        self._set_weights(direction)
        self._set_points()

    def _set_weights(self, direction: np.ndarray) -> None:
        gravity = np.array(self.scene.groups.get("control", [])[0].get("gravity", (0.0, 0.0)))
        if not gravity.any():
            raise InputError("the model has no gravity: there is no weight to hold blocks")
        density = [float(group["density"]) for group in self.scene.groups.get("material", [])]
        mass = np.array(density)[self.scene.material] * self.scene.areas()
        pull = np.linalg.norm(gravity)
        self.unit = float(np.median(mass) * pull)
        self.dead = mass[:, None] * gravity / self.unit
        self.live = mass[:, None] * pull * direction / self.unit
        self.centres = np.array([_centroid(polygon) for polygon in self.polygons])
        self.radii = np.array([
            np.linalg.norm(polygon - centre, axis=1).max()
            for polygon, centre in zip(self.polygons, self.centres, strict=True)
        ])  # fmt: skip

    def _set_points(self) -> None:
        """Ends of joints, then single corners on edges."""
        scene, faces = self.scene, self.scene.interfaces
        angle = np.array([float(g["friction_angle"]) for g in scene.groups.get("joint", [])])
        tangent = np.tan(np.radians(angle))
        corners, edges, normals = self._single_corners()
        ends = np.stack([faces.start, faces.end], axis=1).reshape(-1, 2)
        pairs = np.repeat(np.column_stack([faces.first, faces.second]), 2, axis=0)
        alone = np.column_stack([scene.owner[edges], scene.owner[corners]])
        touched = np.column_stack([edges, corners, scene.previous_vertex[corners]])
        self.blocks = np.vstack([pairs, alone])
        self.points = np.vstack([ends, scene.vertices(0)[corners]])
        self.normals = np.vstack([np.repeat(faces.normal, 2, axis=0), normals])
        self.tangents = np.column_stack([-self.normals[:, 1], self.normals[:, 0]])
        self.friction = np.append(
            np.repeat(tangent[scene.interface_joints], 2),
            tangent[scene.joint[touched]].min(axis=1, initial=np.inf),
        )

    def _single_corners(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Corners within edges that they are not parallel to: vertices, edges, normals (k, 2)."""
        scene, contacts = self.scene, self.scene.contacts(0)
        vertex, edge = contacts["vertex"], contacts["edge"]
        places, normals = scene.contact_points(0, contacts)
        start = scene.vertices(0)[edge]
        along = scene.vertices(0)[scene.next_vertex[edge]] - start
        length = np.linalg.norm(along, axis=1)
        share = np.sum((places - start) * along, axis=1) / length**2
        depth = np.sum((places - start) * normals, axis=1) / length
        inside = (share > _CORNER) & (share < 1 - _CORNER) & (abs(depth) < _CORNER)
        faces = scene.interfaces
        known = {*zip(faces.first_edge, faces.second_edge, strict=True)}
        known |= {(b, a) for a, b in known}
        alone = [
            not known & {(v, e), (before, e)}
            for v, before, e in zip(vertex, scene.previous_vertex[vertex], edge, strict=True)
        ]
        kept = inside & np.array(alone, dtype=bool)
        return vertex[kept], edge[kept], normals[kept]

    def _columns(self, block, place, force) -> coo_array:
        """Rows of the balance that unit forces (k, 2) at places (k, 2) add to, (3 blocks, k)."""
        arm = (place - self.centres[block]) / self.radii[block, None]
        moment = arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]
        values = np.column_stack([force, moment]).ravel()
        rows = (3 * block[:, None] + np.arange(3)).ravel()
        columns = np.repeat(np.arange(len(block)), 3)
        return coo_array((values, (rows, columns)), shape=(3 * len(self.polygons), len(block)))

    def _reactions(self) -> coo_array:
        """Columns of what supports may push and pull: fixed points, and the ends of held edges."""
        held = [*self._fixed_points(), *self._held_edges()]
        if not held:
            raise InputError("nothing holds the blocks: there is no support")
        block, place, force = zip(*held, strict=True)
        return self._columns(np.array(block), np.array(place), np.array(force))

    def _fixed_points(self):
        for group in self.scene.groups.get("fixed_point", []):
            place = np.array([group["x"], group["y"]], dtype=float)
            for force in _AXES[str(group.get("direction", "xy")).strip()]:
                yield self._block_at(place, str(group.get("block", "")).strip()), place, force

    def _block_at(self, place: np.ndarray, name: str) -> int:
        """The block of this name or number, else the first that holds the place."""
        if name in self.scene.names:
            return self.scene.names.index(name)
        if name.isdigit():
            return int(name) - 1
        reach = _CORNER * self.scene.size
        return next(i for i, one in enumerate(self.polygons) if _holds(one, place, reach))

    def _held_edges(self):
        kinds = engine_names("boundary kinds"), engine_names("boundary kinds at rest")
        at_rest = dict(zip(*kinds, strict=True))
        groups = self.scene.groups.get("boundary", [])
        if not groups:
            return
        edge, number = (self.scene.data[f"boundary_{n}"].values for n in ("edge", "edge_group"))
        for i, (shown, group) in enumerate(zip(self.scene.boundaries(0), groups, strict=True)):
            kind = at_rest.get(shown["kind"], shown["kind"])
            direction = str(group.get("direction", "")).strip() or _USUAL.get(kind)
            if direction is None:
                raise InputError(f"limit analysis does not know what a {kind} boundary holds")
            for begin, end, e in zip(shown["start"], shown["end"], edge[number == i], strict=True):
                along = (end - begin) / np.linalg.norm(end - begin)
                forces = _AXES.get(direction, [(along[1], -along[0])])
                yield from ((self.scene.owner[e], p, f) for p in (begin, end) for f in forces)

    @cached_property
    def balance(self):
        """Of all blocks: columns of normal forces, shear forces, reactions and the factor."""
        parts = []
        for force in (self.normals, self.tangents):
            first, second = self.blocks.T
            parts.append(
                self._columns(second, self.points, force)
                - self._columns(first, self.points, force)
            )  # fmt: skip
        live = np.pad(self.live, ((0, 0), (0, 1))).reshape(-1, 1)
        return block_array([[*parts, self._reactions(), coo_array(live)]], format="csc")

    def solve(self, slope: np.ndarray, bound: np.ndarray, most: float = _MOST) -> _Solution:
        """The largest factor up to `most` with |T| ≤ bound + slope N at each point."""
        n, size = len(slope), self.balance.shape[1]
        rest = coo_array((n, size - 2 * n))
        one, slopes = diags_array(np.ones(n)), diags_array(slope)
        found = linprog(
            np.append(np.zeros(size - 1), -1.0) + np.repeat([_PRESTRESS, 0.0], [n, size - n]),
            A_ub=block_array([[-slopes, one, rest], [-slopes, -one, rest]], format="csc"),
            b_ub=np.tile(bound / self.unit, 2),
            A_eq=self.balance,
            b_eq=-np.pad(self.dead, ((0, 0), (0, 1))).ravel(),
            bounds=[(0, None)] * n + [(None, None)] * (size - n - 1) + [(0, most)],
            options={"primal_feasibility_tolerance": 1e-9, "dual_feasibility_tolerance": 1e-9},
        )
        if found.status == 2:
            raise InputError("the blocks stand under no body force of this direction")
        if found.status != 0:
            raise ConvergenceError(f"the linear programme has no solution: {found.message}")
        velocity = -found.eqlin.marginals.reshape(-1, 3)
        velocity[:, 2] /= self.radii
        forces = found.x[: 2 * n] * self.unit
        return _Solution(float(found.x[-1]), forces[:n], forces[n:], velocity)

    def _slip(self, velocity: np.ndarray) -> np.ndarray:
        """At the points, m, shape (points,)."""
        arms = self.points[:, None] - self.centres[self.blocks]
        turn = velocity[self.blocks]
        ways = turn[..., :2] + turn[..., 2:] * np.stack([-arms[..., 1], arms[..., 0]], axis=-1)
        return abs(np.sum((ways[:, 1] - ways[:, 0]) * self.tangents, axis=1))

    def limit(self, found: _Solution) -> Limit:
        """A solution in plain values."""
        reach = np.hypot(*found.velocity[:, :2].T) + self.radii * abs(found.velocity[:, 2])
        held = found.factor >= _HELD
        velocity = found.velocity / (1.0 if held else reach.max())
        if held:
            velocity = np.zeros_like(velocity)
        slip_work = self._slip(velocity) * abs(found.shear)
        work = self.unit * found.factor * np.sum(self.live * velocity[:, :2])
        return Limit(
            np.inf if held else found.factor,
            velocity,
            _verdicts(velocity, self.radii),
            bool(slip_work.sum() > _SLIDES * work),
            tuple(self.scene.names),
            self.blocks,
            self.points,
            self.normals,
            found.normal,
            found.shear,
            self.polygons,
        )


def _without_dilation(programme: _Programme, upper: _Solution) -> _Solution:
    """The lowest limit without dilation that sequences from two sets of forces lead to.

    They begin with the forces at the upper limit, which press joints as hard as dilation does, and
    with those under the weight alone; where blocks wedge each other they may end apart.
    """
    none = np.zeros(len(programme.friction))
    starts = [programme.solve(programme.friction, none, most=0.0)]
    if upper.factor < _HELD:
        starts.append(upper)
    ends = [end for start in starts if (end := _sequence(programme, start)) is not None]
    if not ends:
        raise ConvergenceError(f"{_PROGRAMMES} programmes without dilation found no limit")
    lowest = min(ends, key=lambda end: end.factor)
    # Where blocks stay, bounds and forces of the last programme need not agree: others do as well.
    forces = programme.solve(programme.friction, none, most=lowest.factor)
    return replace(forces, velocity=lowest.velocity)


def _sequence(programme: _Programme, found: _Solution) -> _Solution | None:
    """The programmes that bound friction by the normal forces of those before; none: no end."""
    pressed, settled = found.normal.copy(), 0
    for i in range(_PROGRAMMES):
        before = found.factor
        found = programme.solve(np.zeros(len(pressed)), programme.friction * pressed)
        pressed += _GAIN * min(1.0, _CONSTANT / (i + 1)) * (found.normal - pressed)
        settled = settled + 1 if abs(found.factor - before) <= _SETTLED * before else 0
        if settled == _TIMES:
            return found
    return None


def _centroid(polygon: np.ndarray) -> np.ndarray:
    """Of a polygon (n, 2), m."""
    about = polygon[0]
    one = polygon - about
    after = np.roll(one, -1, axis=0)
    cross = one[:, 0] * after[:, 1] - one[:, 1] * after[:, 0]
    return about + (one + after).T @ cross / (3 * cross.sum())


def _holds(polygon: np.ndarray, place: np.ndarray, reach: float) -> bool:
    """Whether a place (m) is in a polygon, or within `reach` (m) of its outline."""
    one, after = polygon - place, np.roll(polygon, -1, axis=0) - place
    along = after - one
    share = np.clip(-np.sum(one * along, axis=1) / np.sum(along**2, axis=1), 0.0, 1.0)
    if np.linalg.norm(one + share[:, None] * along, axis=1).min() <= reach:
        return True
    cross = one[:, 0] * after[:, 1] - one[:, 1] * after[:, 0]
    upward = (one[:, 1] <= 0) & (after[:, 1] > 0) & (cross > 0)
    return upward.sum() != ((after[:, 1] <= 0) & (one[:, 1] > 0) & (cross < 0)).sum()
