# SPDX-License-Identifier: GPL-3.0-or-later
"""Quasi-static support movements: settlement, spreading or rotation in static increments.

Each step starts with zero velocity, so the unbalanced force is M d/Δt².  The time step Δt is so
long that this force is far below the weight.  The reaction is the force of the springs of the fixed
points, so it balances all loads and the forces of other blocks on the moved blocks.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase

import numpy as np

from ..base.arguments import FINITE, Range, floats
from ..base.errors import ConvergenceError, InputError, SolverError
from ..build.model import Group, Model
from ..engine.simulation import Simulation
from ..output.scene import Scene, deformation_gradient
from .bodies import block_at
from .strength import static_model

_STEADY = 1e-6  # largest ratio of M/Δt² to the contact stiffness
_FOLLOWS = 20.0  # smallest ratio of g Δt², the fall of a block in a step, to the increment
_EACH = 4  # number of static steps per increment; the supports move in the first step
_RATIO = 100.0  # default stiffness of fixed points / contact stiffness
_STEPS = Range(1, 1000, whole=True)  # a motion in an input has at most 4096 values


@dataclass(frozen=True)
class Movement:
    """Reactions during a support movement.

    Attributes
    ----------
    share : ndarray, shape (increments,)
        Fraction of the movement, 0 to 1.
    reaction : ndarray, shape (increments, 2)
        Force of the supports on the moved blocks, N/m.
    displacement : ndarray, shape (increments, blocks, 3)
        Displacement x, y (m) and rotation (rad) of all blocks.
    names : tuple of str
        Names of the blocks.
    polygons : list of ndarray
        Blocks at the end, shape (vertices, 2), m.
    ending : str
        Reason for an early end; empty if the movement is complete.
    """

    share: np.ndarray
    reaction: np.ndarray
    displacement: np.ndarray = field(repr=False)
    names: tuple[str, ...] = field(repr=False)
    polygons: list[np.ndarray] = field(repr=False)
    ending: str = ""

    def to_csv(self) -> str:
        """Return the curve as CSV: fraction of the movement and reaction (N/m)."""
        rows = np.column_stack([self.share, self.reaction])
        lines = [",".join(f"{value:.9g}" for value in row) for row in rows]
        return "\n".join(["share (1),reaction x (N/m),reaction y (N/m)", *lines, ""])


def move_supports(
    source,
    blocks: str | Sequence[str],
    displacement=(0.0, 0.0),
    *,
    rotation: float = 0.0,
    steps: int = 50,
    changes: Mapping | None = None,
) -> Movement:
    """Move the fixed points of some blocks quasi-statically and compute the reaction.

    Parameters
    ----------
    source : path or Model
        Input; it must reach equilibrium under its weight.  Its static stages are computed first;
        motions are ignored.
    blocks : str or sequence of str
        Names of the blocks whose &fixed_point groups move; the blocks have no other support.
    displacement : (float, float)
        Displacement at the end, m.
    rotation : float
        Rotation at the end about the mean position of these points, rad.
    steps : int
        Number of increments.
    changes : mapping, optional
        Changes of the input, see `Simulation`.

    Raises
    ------
    InputError
        If a block does not exist, has no fixed point or has an edge of a &boundary, or if a stage
        holds or releases its fixed points.
    ConvergenceError
        If the model does not reach equilibrium under its weight.
    """
    _STEPS.check("steps", steps)
    shift = floats("displacement", displacement)
    if shift.shape != (2,) or not np.isfinite(shift).all():
        raise InputError(f"displacement = {displacement!r} must be two finite numbers")
    FINITE.check("rotation", rotation)
    model = static_model(source, changes)
    with Simulation(model, drawn=True) as simulation:
        scene = Scene.of(simulation)
        stiffness, g = simulation.normal_stiffness, float(np.linalg.norm(simulation.gravity))
    density = [float(group["density"]) for group in scene.groups["material"]]
    mass = np.array(density)[scene.material] * scene.areas()
    supports = _Supports.of(model, scene, _block_indices(blocks, scene.names), stiffness)
    increment = (np.linalg.norm(shift) + abs(rotation) * scene.size) / steps
    time_step = math.sqrt(max(float(np.median(mass)) / (_STEADY * stiffness),
                              _FOLLOWS * increment / max(g, 1e-9)))  # fmt: skip
    supports.prescribe(model, shift, rotation, steps, time_step)
    model.control(time_step=time_step, dynamic_factor=0.0, integration="backward_euler",
                  time_step_control="adaptive", max_displacement_ratio=0.1)  # fmt: skip
    model.stage(name="supports move", steps=_EACH * steps, zero_displacements=True)
    return _run_increments(model, supports, supports.targets(shift, rotation, steps))


def _block_indices(blocks: str | Sequence[str], names: list[str]) -> list[int]:
    """Return the indices of blocks by their names; raise InputError if there is none."""
    chosen = [blocks] if isinstance(blocks, str) or not isinstance(blocks, Iterable) else [*blocks]
    if not chosen or not all(isinstance(name, str) for name in chosen):
        raise InputError(f"blocks = {blocks!r} must be names of blocks")
    if unknown := [name for name in chosen if name not in names]:
        raise InputError(f"blocks: {unknown[0]!r} is not the name of a block")
    return [names.index(name) for name in chosen]


@dataclass(frozen=True)
class _Supports:
    """The fixed points of the moved blocks: springs, each array of shape (points, …)."""

    points: list[Group]
    block: np.ndarray
    position: np.ndarray  # undisplaced, m
    offset: np.ndarray  # from the centroid of the undeformed block, m
    stiffness: np.ndarray  # along x and y, 0 if not fixed, N/m per metre

    @classmethod
    def of(cls, model: Model, scene: Scene, moved: list[int], stiffness: float) -> "_Supports":
        """Find the fixed points of the moved blocks; raise InputError if they cannot move."""
        polygons, groups = scene.polygons(0), model.of_kind("fixed_point")
        owners = [block_at(polygons, scene.names, (point.x, point.y), point.block or "")
                  for point in groups]  # fmt: skip
        _check_supports(model, scene, moved, groups, owners)
        pairs = [(point, block) for point, block in zip(groups, owners, strict=True)
                 if block in moved]  # fmt: skip
        points, block = [point for point, _ in pairs], np.array([block for _, block in pairs])
        position = np.array([(point.x, point.y) for point in points], dtype=float)
        fixed = [[axis in (point.direction or "xy") for axis in "xy"] for point in points]
        ratio = model.contact.fixed_point_ratio or _RATIO
        model.contact(fixed_point_ratio=ratio)
        return cls(points, block, position, scene.offsets(block, position),
                   ratio * stiffness * np.array(fixed))  # fmt: skip

    def targets(self, shift: np.ndarray, rotation: float, steps: int) -> np.ndarray:
        """Return the displacements of the points at each increment, (steps + 1, points, 2), m."""
        ratio = np.arange(steps + 1)[:, None] / steps
        x, y = (self.position - self.position.mean(axis=0)).T
        cos, sin = np.cos(rotation * ratio), np.sin(rotation * ratio)
        rotated = np.stack([cos * x - sin * y - x, sin * x + cos * y - y], axis=-1)
        return ratio[..., None] * shift + rotated

    def prescribe(
        self, model: Model, shift: np.ndarray, rotation: float, steps: int, time_step: float
    ) -> None:
        """Assign motions to the points, which move in the first step of each increment."""
        targets = self.targets(shift, rotation, steps)
        values = np.concatenate([targets[:1], np.repeat(targets[1:], _EACH, axis=0)])
        for i, (point, along) in enumerate(zip(self.points, self.stiffness, strict=True)):
            for axis in np.flatnonzero(along):
                name = f"support {i + 1} {'xy'[axis]}"
                model.motion(name=name, quantity="displacement", values=values[:, i, axis].tolist(),
                             time_step=time_step, after_end="hold")  # fmt: skip
                point(**{f"motion_{'xy'[axis]}": name})

    def reaction(self, run: Simulation, target: np.ndarray) -> np.ndarray:
        """Return the resultant force of the springs on their blocks, N/m."""
        coordinates = run.coordinates[self.block]
        offset = (deformation_gradient(coordinates) @ self.offset[..., None])[..., 0]
        stretch = self.position + target - coordinates[:, :2] - offset
        return (self.stiffness * stretch).sum(axis=0)


def _check_supports(model: Model, scene: Scene, moved, points, owners: list[int]) -> None:
    """Raise InputError unless fixed points are the only, constant supports of the moved blocks."""
    for i in moved:
        if i not in owners:
            raise InputError(f"blocks: there is no &fixed_point on block {scene.names[i]!r}")
    if "boundary_edge" in scene.data:
        edges = scene.data["boundary_edge"].values.astype(int)
        if held := {*scene.owner[edges]} & {*moved}:
            raise InputError(f"blocks: {scene.names[min(held)]!r} has an edge of a &boundary, "
                             "which does not move: replace it by &fixed_point groups")  # fmt: skip
    for stage in model.of_kind("stage"):
        patterns = f"{stage.release or ''},{stage.hold or ''}".split(",")
        for point, owner in zip(points, owners, strict=True):
            matches = (fnmatchcase(point.name or "", pattern.strip()) for pattern in patterns)
            if owner in moved and point.name and any(matches):
                raise InputError(f"stage {stage.name!r} holds or releases &fixed_point "
                                 f"{point.name!r}, which cannot move")  # fmt: skip


def _run_increments(model: Model, supports: _Supports, targets: np.ndarray) -> Movement:
    """Compute all increments; end early if the model does not reach equilibrium."""
    fractions, reactions, moves, ending = [], [], [], ""
    steps = len(targets) - 1
    with Simulation(model) as run:
        start, begin = run.coordinates, run.time
        for i, target in enumerate(targets):
            fractions.append(i / steps)
            reactions.append(supports.reaction(run, target))
            moves.append(run.coordinates[:, :3] - start[:, :3])
            if i == steps:
                break
            try:
                target_time = begin + (i + 1) * run.duration / steps
                while run.time < target_time * (1 - 1e-9):
                    run.advance()
            except (ConvergenceError, SolverError) as error:
                ending = str(error)
                break
        return Movement(np.array(fractions), np.array(reactions), np.array(moves),
                        tuple(run.block_names), run.polygons, ending)  # fmt: skip
