# SPDX-License-Identifier: GPL-3.0-or-later
"""Quasi-static support movements: settlement, spreading or rotation in static increments.

Each step starts with zero velocity, so the unbalanced force is M d/Δt².  The time step Δt is so
long that this force is far below the weight.  The reaction balances gravity and the forces of the
other blocks on the moved blocks.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..base.arguments import FINITE, Range
from ..base.errors import ConvergenceError, InputError, SolverError
from ..build.model import Model
from ..engine.simulation import Simulation
from ..output.scene import Scene
from .strength import static_model

_STEADY = 1e-6  # largest ratio of M/Δt² to the contact stiffness
_FOLLOWS = 20.0  # smallest ratio of g Δt², the fall of a block in a step, to the increment
_EACH = 4  # number of static steps per increment; the supports move in the first step
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
        Names of the blocks whose &fixed_point groups move.
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
        If a block does not exist or has no fixed point.
    ConvergenceError
        If the model does not reach equilibrium under its weight.
    """
    _STEPS.check("steps", steps)
    shift = np.array([FINITE.check("displacement", component) for component in displacement])
    FINITE.check("rotation", rotation)
    model = static_model(source, changes)
    with Simulation(model) as simulation:
        scene, names = Scene.of(simulation), list(simulation.block_names)
        stiffness, g = simulation.normal_stiffness, float(np.linalg.norm(simulation.gravity))
    density = [float(group["density"]) for group in scene.groups["material"]]
    mass = np.array(density)[scene.material] * scene.areas()
    blocks = [blocks] if isinstance(blocks, str) else list(blocks)
    if unknown := [name for name in blocks if name not in names]:
        raise InputError(f"blocks: {unknown[0]!r} is not the name of a block")
    indices = [names.index(name) for name in blocks]
    increment = (np.linalg.norm(shift) + abs(rotation) * scene.size) / steps
    time_step = math.sqrt(max(float(np.median(mass)) / (_STEADY * stiffness),
                              _FOLLOWS * increment / max(g, 1e-9)))  # fmt: skip
    _prescribe_movement(model, [names[i] for i in indices], shift, rotation, steps, time_step)
    model.control(time_step=time_step, dynamic_factor=0.0, integration="backward_euler",
                  time_step_control="adaptive", max_displacement_ratio=0.1)  # fmt: skip
    model.stage(name="supports move", steps=_EACH * steps, zero_displacements=True)
    return _run_increments(model, indices, mass, steps)


def _prescribe_movement(
    model: Model, blocks, shift, rotation: float, steps: int, time_step: float
) -> None:
    """Assign motions to the fixed points of blocks, in the first step of each increment."""
    points = [item for item in model.of_kind("fixed_point") if item.block in blocks]
    if unsupported := set(blocks) - {item.block for item in points}:
        raise InputError(f"blocks: no &fixed_point has block = {min(unsupported)!r}")
    positions = np.array([(item.x, item.y) for item in points], dtype=float)
    ratio = np.append(0.0, np.repeat(np.arange(1, steps + 1) / steps, _EACH))[:, None]
    angle = rotation * ratio
    for i, (point, arm) in enumerate(zip(points, positions - positions.mean(0), strict=True), 1):
        rotated = np.hstack([np.cos(angle) * arm[0] - np.sin(angle) * arm[1] - arm[0],
                            np.sin(angle) * arm[0] + np.cos(angle) * arm[1] - arm[1]])  # fmt: skip
        values = ratio * shift + rotated
        for axis in (0, 1):
            if "xy"[axis] not in str(point.direction or "xy"):
                continue
            name = f"support {i} {'xy'[axis]}"
            model.motion(name=name, quantity="displacement", values=values[:, axis].tolist(),
                         time_step=time_step, after_end="hold")  # fmt: skip
            point(**{f"motion_{'xy'[axis]}": name})


def _run_increments(model: Model, indices: list[int], mass: np.ndarray, steps: int) -> Movement:
    """Compute all increments; end early if the model does not reach equilibrium."""
    fractions, reactions, moves, ending = [], [], [], ""
    with Simulation(model) as run:
        start, begin = run.coordinates, run.time
        weight = mass[indices].sum() * run.gravity
        for i in range(steps + 1):
            fractions.append(i / steps)
            reactions.append(-(_contact_force(run, indices) + weight))
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


def _contact_force(run: Simulation, blocks: list[int]) -> np.ndarray:
    """Return the resultant of the contact forces of other blocks on `blocks`, N/m."""
    scene = Scene.of(run)
    contacts = scene.contacts(0)
    _, normal = scene.contact_points(0, contacts)
    force = scene.contact_forces(contacts, normal)
    is_moved = [np.isin(scene.owner[contacts[end]], blocks) for end in ("vertex", "edge")]
    return (force * (is_moved[0].astype(float) - is_moved[1])[:, None]).sum(axis=0)
