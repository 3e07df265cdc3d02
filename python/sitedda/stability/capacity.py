# SPDX-License-Identifier: GPL-3.0-or-later
"""Pushover: static steps follow a load that is proportional to the weight, also after its peak.

Each step starts with zero velocity, so unbalanced forces F displace blocks by d = M⁻¹ F Δt².  Let f
be the load at a factor of 1.  The virtual work of forces and inertia forces yields the factor at
equilibrium, λ − Σ d·M d/(Δt² Σ f·d).  The next factor is this factor plus an excess, with which
the measured point moves by the required displacement per step.  If another block moves much
farther than the point, this block controls the step.  Forces are in equilibrium at the start of a
step, so the curve of a mechanism is exact.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ..base.arguments import COUNT, POSITIVE
from ..base.errors import ConvergenceError, InputError, SolverError
from ..build.model import Model
from ..engine.simulation import Simulation
from ..output.scene import Scene
from .bodies import Bodies
from .reduction import judge_blocks
from .strength import static_model

LOADS = ("horizontal", "tilt", "mode")
_EXCESS = 0.005  # excess of the factor at which a mechanism moves by one step of displacement
_FIRST, _LEAST = 0.01, 0.05  # first factor; smallest factor in relative changes of the factor
_MOST = 0.02  # largest excess, as a fraction of the factor
_BACK = 0.5  # smallest ratio of the next factor to the factor at equilibrium
_STEADY = 1.5  # largest excess over _EXCESS at which friction is that of static equilibrium
_SMALLEST = 1e-4  # smallest excess, as a fraction of the factor
_MORE = 1.5  # largest ratio of the excesses of successive steps
_SHORTEST = 1e-3  # fraction of the time step below which a step counts as not converged
_LOOKS, _TO_PEAK = 6, 500  # largest number of steps: _TO_PEAK + _LOOKS × requested number
_LEAST_CONTROL = 0.2  # smallest displacement of the control point / largest
_ELASTIC = 0.1  # displacement / target displacement below which a step counts as elastic
_PARTED = 3.0  # ratio of the largest displacement of a block to the requested one that ends the run
_STILL = 1e-3  # fraction of the largest modal displacement below which a block does not move
_UNCONVERGED = "a step does not converge"
_BY_THEMSELVES = "blocks move without further load; try more steps to follow the motion"
_TILT = math.radians(89.0)  # largest angle of a tilting table


@dataclass(frozen=True)
class Pushover:
    """A capacity curve and its mechanism.

    Attributes
    ----------
    load : str
        'horizontal', 'tilt' or 'mode'.
    sense : int
        Sense of the load along x: 1 or −1.
    point : str
        Measured point whose displacement the curve shows.
    displacement : ndarray, shape (steps,)
        Displacement of this point along the load, m.
    largest : ndarray, shape (steps,)
        Largest displacement of the centroid of a block, m.
    factor : ndarray, shape (steps,)
        Ratio of load to weight at equilibrium; tangent of the angle for 'tilt'.
    work : ndarray, shape (steps,)
        Work of the load, J/m.
    friction : ndarray, shape (steps,)
        Energy dissipated by slip, J/m.
    mass : float
        Total mass of the blocks, kg/m.
    names, verdicts : tuple of str
        Name and motion from peak to end ('stable', 'slides' or 'topples') of each body.
    mechanism : ndarray, shape (bodies, 3)
        Displacement from peak to end: x, y (m), rotation (rad).
    block_verdicts : tuple of str
        Verdict of the body of each block.
    polygons : list of ndarray
        Blocks at the end, shape (vertices, 2), m.
    ending : str
        Reason for the end of the curve.
    masses : ndarray, shape (bodies,)
        Masses of the bodies, kg/m.
    pull : float
        Gravity, m/s².
    pattern : ndarray, shape (bodies,)
        Load on each body at a factor of 1 / its weight; 1 for 'horizontal' and 'tilt'.
    """

    load: str
    sense: int
    point: str
    displacement: np.ndarray
    largest: np.ndarray
    factor: np.ndarray
    work: np.ndarray
    friction: np.ndarray
    mass: float
    names: tuple[str, ...]
    verdicts: tuple[str, ...]
    mechanism: np.ndarray
    block_verdicts: tuple[str, ...] = field(repr=False)
    polygons: list[np.ndarray] = field(repr=False)
    ending: str = ""
    masses: np.ndarray = field(repr=False, default_factory=lambda: np.zeros(0))
    pull: float = 9.81
    pattern: np.ndarray = field(repr=False, default_factory=lambda: np.ones(1))

    @property
    def peak(self) -> float:
        """Return the largest factor."""
        return float(self.factor.max())

    @property
    def at_peak(self) -> float:
        """Return the displacement at the peak, m."""
        return float(self.displacement[int(np.argmax(self.factor))])

    @property
    def converged(self) -> bool:
        """Return whether all steps converged."""
        return not self.ending.startswith(_UNCONVERGED)

    def __str__(self) -> str:
        """Return four lines: peak, end, energies and mechanism."""
        verdicts = [v for v in ("stable", "slides", "topples") if v in self.verdicts]
        moves = ", ".join(f"{self.verdicts.count(verdict)} {verdict}" for verdict in verdicts)
        quantity = {"tilt": "tangent of the tilt", "mode": "load in the first mode / weight",
                "horizontal": "horizontal load / weight"}[self.load]  # fmt: skip
        return "\n".join([
            f"peak: {quantity} {self.peak:.4g} at {1e3 * self.at_peak:.4g} mm of {self.point}",
            f"end: {self.factor[-1]:.4g} at {1e3 * self.displacement[-1]:.4g} mm: {self.ending}",
            f"energy: work of the load {self.work[-1]:.4g} J/m, dissipated by slip "
            f"{self.friction[-1]:.4g} J/m",
            f"mechanism: {moves}",
        ])  # fmt: skip

    def to_csv(self) -> str:
        """Return the curve as CSV: displacement (m), factor, work and friction (J/m)."""
        columns = self.displacement, self.largest, self.factor, self.work, self.friction
        lines = [",".join(map("{:.9g}".format, row)) for row in zip(*columns, strict=True)]
        heads = "displacement (m),largest (m),factor (1),work (J/m),friction (J/m)"
        return "\n".join([heads, *lines, ""])

    def draw(self, limits=None):
        """Draw the curve, the energy dissipated by slip and the blocks at the end.

        Parameters
        ----------
        limits : Limits, optional
            Result of `limit_analysis` to draw with the curve.
        """
        from .picture import pushover_figure

        return pushover_figure(self, limits)


def pushover(
    source,
    point: str,
    *,
    load: str = "horizontal",
    sense: int = 1,
    displacement: float | None = None,
    steps: int = 200,
    changes: Mapping | None = None,
) -> Pushover:
    """Compute the capacity curve of a model past its peak, under displacement control.

    Parameters
    ----------
    source : path or Model
        Input; it must reach equilibrium under its weight.  Its static stages are computed first;
        motions are ignored.
    point : str
        Name of a &measured_point.
    load : {'horizontal', 'tilt', 'mode'}
        'horizontal': horizontal body force on all blocks; 'tilt': rotated gravity, as on a tilting
        table; 'mode': horizontal forces proportional to mass × displacement in the first mode with
        bonded contacts, whose sum is the weight of the blocks that move in this mode.
    sense : {1, -1}
        Sense of the load along x.
    displacement : float, optional
        Displacement of the point along the load at the end, m; default: a tenth of its height above
        the lowest vertex.
    steps : int
        Number of steps to this displacement; elastic steps, which are smaller, are not counted.
    changes : mapping, optional
        Changes of the input, see `Simulation`.

    Raises
    ------
    ConvergenceError
        If the model does not reach equilibrium under its weight.
    """
    if load not in LOADS or sense not in (1, -1):
        raise InputError(f"load = {load!r} must be one of {', '.join(LOADS)}, "
                         f"and sense = {sense!r} must be 1 or -1")  # fmt: skip
    COUNT.check("steps", steps)
    model = static_model(source, changes)
    run = _PushoverRun(model, point, load, sense, displacement, steps)
    return run.run()


@dataclass(frozen=True)
class _LoadedBlocks:
    """The blocks of a model; `pattern`: load at a factor of 1 / weight of each block."""

    bodies: Bodies
    mass: np.ndarray
    polar: np.ndarray
    centres: np.ndarray
    lowest: float
    pattern: np.ndarray

    @classmethod
    def of(cls, model: Model, load: str) -> "_LoadedBlocks":
        """Return the blocks of a model under one of `LOADS`."""
        with Simulation(model) as simulation:
            scene, polygons = Scene.of(simulation), simulation.polygons
            centres = simulation.coordinates[:, :2]
            density = [float(group["density"]) for group in scene.groups["material"]]
            mass = np.array(density)[scene.material] * scene.areas()
            pairs = zip(polygons, centres, strict=True)
            polar = mass * [_gyration_squared(polygon - centre) for polygon, centre in pairs]
            pattern = _mode_forces(simulation, mass) if load == "mode" else np.ones(len(mass))
            bodies = Bodies(polygons, simulation.block_bodies, list(scene.names))
        lowest = float(np.concatenate(polygons)[:, 1].min())
        return cls(bodies, mass, polar, centres, lowest, pattern)


def _mode_forces(simulation: Simulation, mass: np.ndarray) -> np.ndarray:
    """Return the forces of the load 'mode' / weights of the blocks, shape (blocks,)."""
    from ..engine.checking import modes

    shape = modes(simulation, 1).shapes[0][:, 0]
    shape = shape / shape[np.argmax(abs(shape))]
    moves = abs(shape) > _STILL
    total = mass[moves].sum() / np.sum(mass * abs(shape) * moves)
    return np.where(moves, shape, 0.0) * total


class _PushoverRun:
    """The run of a pushover: a model, its variable load and the measured point."""

    def __init__(self, model: Model, point: str, load: str, sense: int, end, steps: int):
        self.load, self.sense, self.point, self.steps = load, sense, point, steps
        gravity = (0.0, 0.0) if model.control.gravity is None else model.control.gravity
        self.pull = -float(gravity[1])
        if gravity[0] or not self.pull > 0:
            raise InputError("a pushover requires gravity along −y: set gravity of &control")
        points = {group.name: group for group in model.groups if group._name == "measured_point"}
        if point not in points:
            raise InputError(f"point = {point!r} is not the name of a &measured_point; there are "
                             f"{', '.join(points) or 'none'}")  # fmt: skip
        self.index = list(points).index(point)
        self.blocks = _LoadedBlocks.of(model, load)
        height = points[point].y - self.blocks.lowest
        self.end = POSITIVE.check("displacement", 0.1 * height if end is None else end)
        self.model = self._with_static_stage(model)

    def _with_static_stage(self, model: Model) -> Model:
        """Return a copy of the model with static steps, in which the load increases."""
        copy = model.copy()
        if self.load == "mode":
            for i, (x, y) in enumerate(self.blocks.centres, 1):
                copy.load(x, y, str(i), f"push {i}", time=(0, 1e9), force_x=(0, 0))
        step = math.sqrt(self.end / self.steps / (_EXCESS * self.pull))
        copy.control(time_step=step, dynamic_factor=0.0, integration="backward_euler",
                       time_step_control="adaptive", least_time_step=_SHORTEST * step,
                       max_displacement_ratio=0.1)  # fmt: skip
        copy.stage(name="pushed", steps=_TO_PEAK + _LOOKS * self.steps, zero_displacements=True)
        return copy

    def run(self) -> Pushover:
        """Compute all steps and return the capacity curve."""
        rows, states, ending = [], [], ""
        excess, factor, work, motion, farthest_motion = _FIRST, _FIRST, 0.0, 0.0, 0.0
        # Controlling displacement and factor at equilibrium of each step.
        steps: list[tuple[float, float]] = []
        with Simulation(self.model) as run:
            start = previous = run.coordinates
            time, friction, names = run.time, run.energies["friction"], run.block_names
            while not ending:
                self._apply_load(run, factor)
                try:
                    ended = run.advance()
                except (ConvergenceError, SolverError) as error:
                    ending = f"{_UNCONVERGED}: {error}"
                    break
                current = run.coordinates
                change, step = current - previous, run.time - time
                previous, time, previous_motion = current, run.time, motion
                power = self._load_work(change, factor)
                inertia = self._squared_mass_norm(change) / step**2
                balance = factor - (inertia / power if power > 0 else 0.0)
                work += balance * power
                row = (motion, farthest_motion, balance, work, run.energies["friction"] - friction)
                motion = self.sense * float(run.point_motions[0, self.index, 0])
                distances = np.hypot(*(current - start)[:, :2].T)
                farthest = int(distances.argmax())
                farthest_motion = float(distances[farthest])
                name = names[farthest] or f"block {farthest + 1}"
                steady = factor - balance <= _STEADY * _EXCESS
                ending = self._end_reason(ended, motion, farthest_motion, name, balance)
                if balance <= 0 and not steady:
                    ending = _BY_THEMSELVES
                if steady:
                    rows.append(row)
                    states.append(current[:, :3])
                path = self._controlling_displacement(change, motion - previous_motion)
                steps.append((path, balance))
                excess = self._next_load_excess(excess, factor, steps)
                extrapolated = max(_extrapolate_factor(steps), _BACK * balance)
                factor = min(factor, extrapolated) + excess
            polygons = run.polygons
        return self._make_pushover(rows, states, polygons, ending)

    def _controlling_displacement(self, change: np.ndarray, motion: float) -> float:
        """Return the displacement of the point, or of a block if it moves much farther, m."""
        peak = float(np.hypot(*change[:, :2].T).max())
        return max(abs(motion) if abs(motion) > _LEAST_CONTROL * peak else peak, 1e-12 * self.end)

    def _next_load_excess(
        self, excess: float, factor: float, steps: list[tuple[float, float]]
    ) -> float:
        """Return the excess of the next factor over the factor at equilibrium."""
        (motion, balance), target = steps[-1], self.end / self.steps
        next_one = _MORE * excess
        if motion > _ELASTIC * target:
            next_one = min(next_one, (factor - balance) * target / motion)
        lowest, highest = _SMALLEST * max(factor, _LEAST), _MOST * max(balance, _LEAST)
        return min(max(next_one, lowest), highest)

    def _end_reason(
        self, ended: bool, motion: float, farthest: float, name: str, balance: float
    ) -> str:
        """Return the reason for the end of the run after a step; empty if the run continues."""
        if balance <= 0:
            return "collapse: the resistance is zero"
        if abs(motion) >= self.end:
            return "the target displacement is reached"
        if farthest >= _PARTED * self.end:
            return (
                f"{name} has moved by {1e3 * farthest:.4g} mm while {self.point!r} moved by "
                f"{1e3 * abs(motion):.4g} mm; choose a point on {name}"
            )
        if self.load == "tilt" and balance >= math.tan(_TILT):
            return "the table is vertical"
        return "the largest number of steps is reached" if ended else ""

    def _squared_mass_norm(self, change: np.ndarray) -> float:
        """Return d·M d of the displacements d of a step, kg m²/m."""
        square = np.sum(change[:, :2] ** 2, axis=1)
        return float(np.sum(self.blocks.mass * square + self.blocks.polar * change[:, 2] ** 2))

    def _load_work(self, change: np.ndarray, factor: float) -> float:
        """Return the work of the load at a factor of 1 in a step, J/m."""
        weight, motion = self.pull * self.blocks.mass, change[:, :2]
        if self.load != "tilt":
            return float(self.sense * np.sum(weight * self.blocks.pattern * motion[:, 0]))
        return float(self.sense * np.sum(weight * motion[:, 0]) * math.cos(math.atan(factor)))

    def _apply_load(self, run: Simulation, factor: float) -> None:
        """Set gravity or forces of the run to the load at a factor."""
        if self.load == "horizontal":
            run.gravity = (self.sense * factor * self.pull, -self.pull)
        elif self.load == "tilt":
            angle = math.atan(factor)
            run.gravity = (self.sense * self.pull * math.sin(angle), -self.pull * math.cos(angle))
        else:
            forces = self.sense * factor * self.pull * self.blocks.mass * self.blocks.pattern
            run.change({f"load[push {i}].force_x": (f, f) for i, f in enumerate(forces, 1)})

    def _make_pushover(self, rows, states, polygons, ending: str) -> Pushover:
        """Return the result from rows of the curve and coordinates of the blocks in each step."""
        if not rows:
            raise ConvergenceError(f"the pushover has no step in equilibrium: {ending}")
        displacement, largest, factor, work, friction = np.array(rows).T
        change = states[-1] - states[int(np.argmax(factor))]
        if not abs(change).any():
            change = states[-1] - states[0]
        bodies = self.blocks.bodies
        mean = bodies.mean(change)
        verdicts = judge_blocks(mean, bodies.radii)
        masses = np.bincount(bodies.of, self.blocks.mass)
        pattern = np.bincount(bodies.of, self.blocks.mass * self.blocks.pattern) / masses
        return Pushover(self.load, self.sense, self.point, displacement, largest, factor, work,
                        friction, float(self.blocks.mass.sum()), bodies.names, verdicts, mean,
                        tuple(verdicts[i] for i in bodies.of), polygons, ending,
                        masses, self.pull, pattern)  # fmt: skip


def _extrapolate_factor(steps: list[tuple[float, float]]) -> float:
    """Return the factor at equilibrium, extrapolated to the end of the last step."""
    if len(steps) < 2:
        return steps[-1][1]
    (previous, previous_balance), (motion, balance) = steps[-2:]
    return balance + (balance - previous_balance) * motion / previous


def _gyration_squared(offsets: np.ndarray) -> float:
    """Return the squared polar radius of gyration of a polygon about its centroid, m²."""
    x, y = offsets.T
    a, b = np.roll(x, -1), np.roll(y, -1)
    cross = x * b - a * y
    return float(np.sum((x * x + x * a + a * a + y * y + y * b + b * b) * cross)
                 / (6 * cross.sum()))  # fmt: skip
