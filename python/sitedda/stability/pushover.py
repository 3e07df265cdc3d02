# SPDX-License-Identifier: GPL-3.0-or-later
"""Pushover: follow a load proportional to the weight beyond its peak by static steps.

Each step starts with zero velocity, so that unbalanced blocks move by d = M⁻¹ F Δt², which
determines the inertia forces.  With f the load at a factor of 1, the virtual work of the
displacements of the step gives the factor at equilibrium, λ − Σ d·M d/(Δt² Σ f·d).  The next factor
is this one plus an excess, chosen such that the named point moves by the wanted displacement per
step.  If the point hardly moves, the block with the largest displacement controls the step.
Displacement thus controls the load also if a mechanism without the point collapses. The forces of a
step are in equilibrium at its start, so the curve of a mechanism is exact.
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
from .safety import _judge_blocks
from .strength import static_model

LOADS = ("horizontal", "tilt", "mode")
_EXCESS = 0.005  # excess load of a step over the weight
_FIRST, _LEAST = 0.01, 0.05  # first factor; smallest factor to which changes are relative
_MOST = 0.02  # largest excess, as a fraction of the factor
_BACK = 0.5  # smallest next factor over the factor at equilibrium
_STEADY = 1.5  # largest excess over _EXCESS; above it, friction differs from static equilibrium
_SMALLEST = 1e-4  # smallest excess over _EXCESS
_MORE = 1.5  # largest ratio of the excesses of two steps
_SHORTEST = 1e-3  # smallest fraction of the time step before a step counts as not converged
_LOOKS, _TO_PEAK = 6, 500  # largest number of steps over the requested number, and before the peak
_HARDLY = 0.2  # fraction of the largest displacement below which the point does not control
_ELASTIC = 0.1  # fraction of the target displacement of a step below which it is elastic
_PARTED = 3.0  # the run ends if a block moves by this factor of the requested displacement
_STILL = 1e-3  # fraction of the largest modal displacement below which a block is fixed
_UNCONVERGED = "a step does not converge"
_BY_THEMSELVES = "blocks move without more load; more steps may follow the motion farther"
_TILT = math.radians(89.0)  # largest angle of a tilting table


@dataclass(frozen=True)
class Pushover:
    """A capacity curve and its mechanism.

    Attributes
    ----------
    load : str
        'horizontal', 'tilt' or 'mode'.
    sense : int
        Of the load along x: 1 or −1.
    point : str
        Of the curve.
    displacement : ndarray, shape (steps,)
        Of that point along the load, m.
    largest : ndarray, shape (steps,)
        Largest displacement of the centroid of a block, m.
    factor : ndarray, shape (steps,)
        Load over the weight at which the blocks are in balance; of a tilt its tangent.
    work : ndarray, shape (steps,)
        Of the load, J/m.
    friction : ndarray, shape (steps,)
        Energy dissipated by slip, J/m.
    mass : float
        Of the blocks that are loaded, kg/m.
    names, verdicts : tuple of str
        Of blocks and bodies; 'stable', 'slides' or 'topples', between peak and end.
    mechanism : ndarray, shape (blocks, 3)
        Displacement from the peak to the end: x, y (m), rotation (rad).
    block_verdicts : tuple of str
        The same of each block, those of a body alike.
    polygons : list of ndarray
        Blocks at the end, shape (vertices, 2), m.
    ending : str
        Reason why the curve ends there.
    masses : ndarray, shape (blocks,)
        Of blocks and bodies, kg/m.
    pull : float
        Gravity, m/s².
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

    @property
    def peak(self) -> float:
        """Return the largest load over the weight."""
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
        """Return peak, energies, mechanism and end, one line each."""
        counts = {word: self.verdicts.count(word) for word in ("stable", "slides", "topples")}
        moves = ", ".join(f"{n} {word}" for word, n in counts.items() if n)
        what = {"tilt": "tangent of the tilt", "mode": "load in the first mode over the weight",
                "horizontal": "horizontal load over the weight"}[self.load]  # fmt: skip
        return "\n".join([
            f"peak: {what} {self.peak:.4g} at {1e3 * self.at_peak:.4g} mm of {self.point}",
            f"end: {self.factor[-1]:.4g} at {1e3 * self.displacement[-1]:.4g} mm: {self.ending}",
            f"energy: work of the load {self.work[-1]:.4g} J/m, lost by slip "
            f"{self.friction[-1]:.4g} J/m",
            f"mechanism: {moves}",
        ])  # fmt: skip

    def to_csv(self) -> str:
        """Return the curve as CSV: displacement (m), factor, work and friction (J/m)."""
        rows = zip(
            self.displacement, self.largest, self.factor, self.work, self.friction, strict=True
        )
        lines = [",".join(f"{value:.9g}" for value in row) for row in rows]
        return "\n".join(
            ["displacement (m),largest (m),factor (1),work (J/m),friction (J/m)", *lines, ""]
        )

    def draw(self, limits=None):
        """Draw the curve, its energies and the blocks at the end; return the figure.

        Parameters
        ----------
        limits : Limits, optional
            Of `limit_analysis`, drawn beside the curve.
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
        It must reach equilibrium under its weight; static stages act, motions do not.
    point : str
        Name of a &measured_point.
    load : {'horizontal', 'tilt', 'mode'}
        A horizontal body force on all blocks; gravity that leans, as on a tilting table; or a
        horizontal force of each block as its mass times its displacement in the first mode of the
        model with bonded contacts, scaled so that the forces of the blocks that move add up to
        their weight.
    sense : {1, -1}
        Of the load along x.
    displacement : float, optional
        Of the point along the load, at the end, m (a tenth of its height above the lowest vertex).
    steps : int
        In that displacement; elastic ones before them are smaller.
    changes : mapping, optional
        Variables to change first, see `Simulation`.

    Raises
    ------
    InputError
        If an argument cannot be used.
    ConvergenceError
        If the model does not reach equilibrium under its weight.
    """
    if load not in LOADS or sense not in (1, -1):
        raise InputError(f"load = {load!r} must be one of {', '.join(LOADS)}, "
                         f"and sense = {sense!r} must be 1 or -1")  # fmt: skip
    COUNT.check("steps", steps)
    model = static_model(source, changes)
    pushed = _PushoverRun(model, point, load, sense, displacement, steps)
    return pushed.run()


@dataclass(frozen=True)
class _LoadedBlocks:
    """The blocks of a model, and the load of each over its weight at a factor of 1."""

    bodies: Bodies
    mass: np.ndarray
    polar: np.ndarray
    centres: np.ndarray
    lowest: float
    pattern: np.ndarray

    @classmethod
    def of(cls, model: Model, load: str) -> "_LoadedBlocks":
        """Return the loaded blocks of a model."""
        with Simulation(model) as first:
            scene, polygons, centres = Scene.of(first), first.polygons, first.coordinates[:, :2]
            density = [float(group["density"]) for group in scene.groups["material"]]
            mass = np.array(density)[scene.material] * scene.areas()
            each = zip(polygons, centres, strict=True)
            polar = mass * [_gyration_squared(polygon - centre) for polygon, centre in each]
            pattern = _mode_forces(first, mass) if load == "mode" else np.ones(len(mass))
            bodies = Bodies(polygons, first.block_bodies, list(scene.names))
        lowest = float(np.concatenate(polygons)[:, 1].min())
        return cls(bodies, mass, polar, centres, lowest, pattern)


def _mode_forces(first: Simulation, mass: np.ndarray) -> np.ndarray:
    """Return the first mode along x, scaled to forces equal to the weight that moves."""
    from ..engine.checking import modes

    shape = modes(first, 1).shapes[0][:, 0]
    shape = shape / shape[np.argmax(abs(shape))]
    moves = abs(shape) > _STILL
    total = mass[moves].sum() / np.sum(mass * abs(shape) * moves)
    return np.where(moves, shape, 0.0) * total


class _PushoverRun:
    """A model and the variable load on it."""

    def __init__(self, model: Model, point: str, load: str, sense: int, end, steps: int):
        self.load, self.sense, self.point, self.steps = load, sense, point, steps
        gravity = (0.0, 0.0) if model.control.gravity is None else model.control.gravity
        self.pull = -float(gravity[1])
        if gravity[0] or not self.pull > 0:
            raise InputError("a pushover needs gravity along −y")
        points = {one.name: one for one in model.groups if one._name == "measured_point"}
        if point not in points:
            raise InputError(f"point = {point!r} is not the name of a &measured_point; there are "
                             f"{', '.join(points) or 'none'}")  # fmt: skip
        self.index = list(points).index(point)
        self.blocks = _LoadedBlocks.of(model, load)
        height = points[point].y - self.blocks.lowest
        self.end = POSITIVE.check("displacement", 0.1 * height if end is None else end)
        self.model = self._with_static_stage(model)

    def _with_static_stage(self, model: Model) -> Model:
        """Return the model with an added stage of static steps."""
        pushed = model.copy()
        if self.load == "mode":
            for i, (x, y) in enumerate(self.blocks.centres, 1):
                pushed.load(x, y, str(i), f"push {i}", time=(0, 1e9), force_x=(0, 0))
        step = math.sqrt(self.end / self.steps / (_EXCESS * self.pull))
        pushed.control(time_step=step, dynamic_factor=0.0, integration="backward_euler",
                       time_step_control="adaptive", least_time_step=_SHORTEST * step,
                       max_displacement_ratio=0.1)  # fmt: skip
        pushed.stage(name="pushed", steps=_TO_PEAK + _LOOKS * self.steps, zero_displacements=True)
        return pushed

    def run(self) -> Pushover:
        """Run all steps and return the capacity curve."""
        rows, states, ending = [], [], ""
        excess, factor, work, moved, far = _FIRST, _FIRST, 0.0, 0.0, 0.0
        # Of each step: displacement of the controlling point or block, factor at equilibrium.
        steps: list[tuple[float, float]] = []
        with Simulation(self.model) as run:
            start = before = run.coordinates
            time, lost, names = run.time, run.energies["friction"], run.block_names
            while not ending:
                self._apply_load(run, factor)
                try:
                    done = run.advance()
                except (ConvergenceError, SolverError) as trouble:
                    ending = f"{_UNCONVERGED}: {trouble}"
                    break
                now = run.coordinates
                change, step = now - before, run.time - time
                before, time, last = now, run.time, moved
                power, inertia = (
                    self._load_work(change, factor),
                    self._squared_mass_norm(change) / step**2,
                )
                balance = factor - (inertia / power if power > 0 else 0.0)
                work += balance * power
                row = (moved, far, balance, work, run.energies["friction"] - lost)
                moved = self.sense * float(run.point_motions[0, self.index, 0])
                ways = np.hypot(*(now - start)[:, :2].T)
                farthest = int(ways.argmax())
                far, name = float(ways[farthest]), names[farthest] or f"block {farthest + 1}"
                steady = factor - balance <= _STEADY * _EXCESS
                ending = self._end_reason(done, moved, far, name, balance)
                if balance <= 0 and not steady:
                    ending = _BY_THEMSELVES
                if steady:
                    rows.append(row)
                    states.append(now[:, :3])
                steps.append((self._controlling_displacement(change, moved - last), balance))
                excess = self._next_load_excess(excess, factor, steps)
                ahead = max(_extrapolate_factor(steps), _BACK * balance)
                factor = min(factor, ahead) + excess
            polygons = run.polygons
        return self._make_pushover(rows, states, polygons, ending)

    def _controlling_displacement(self, change: np.ndarray, own: float) -> float:
        """Return the controlling displacement of a step: of the point or of another block."""
        most = float(np.hypot(*change[:, :2].T).max())
        return max(abs(own) if abs(own) > _HARDLY * most else most, 1e-12 * self.end)

    def _next_load_excess(
        self, excess: float, factor: float, steps: list[tuple[float, float]]
    ) -> float:
        """Return the excess of the next factor over equilibrium, which moves a mechanism."""
        (way, balance), wanted = steps[-1], self.end / self.steps
        next_one = _MORE * excess
        if way > _ELASTIC * wanted:
            next_one = min(next_one, (factor - balance) * wanted / way)
        least, most = _SMALLEST * max(factor, _LEAST), _MOST * max(balance, _LEAST)
        return min(max(next_one, least), most)

    def _end_reason(self, done: bool, moved: float, far: float, name: str, balance: float) -> str:
        """Return the reason why the run ends after this step; empty if it continues."""
        if balance <= 0:
            return "collapse: no resistance is left"
        if abs(moved) >= self.end:
            return "the target displacement is reached"
        if far >= _PARTED * self.end:
            return (
                f"{name} has moved by {1e3 * far:.4g} mm while {self.point!r} moved by "
                f"{1e3 * abs(moved):.4g} mm; choose a point on {name}"
            )
        if self.load == "tilt" and balance >= math.tan(_TILT):
            return "the table is vertical"
        return "the largest number of steps is reached" if done else ""

    def _squared_mass_norm(self, change: np.ndarray) -> float:
        """Return d·M d of a step, kg m² per metre."""
        square = np.sum(change[:, :2] ** 2, axis=1)
        return float(np.sum(self.blocks.mass * square + self.blocks.polar * change[:, 2] ** 2))

    def _load_work(self, change: np.ndarray, factor: float) -> float:
        """Return the work of the load at a factor of 1 over the displacements of a step, J/m."""
        weight, ways = self.pull * self.blocks.mass, change[:, :2]
        if self.load != "tilt":
            return float(self.sense * np.sum(weight * self.blocks.pattern * ways[:, 0]))
        return float(self.sense * np.sum(weight * ways[:, 0]) * math.cos(math.atan(factor)))

    def _apply_load(self, run: Simulation, factor: float) -> None:
        """Apply the load at a factor."""
        if self.load == "horizontal":
            run.gravity = (self.sense * factor * self.pull, -self.pull)
        elif self.load == "tilt":
            angle = math.atan(factor)
            run.gravity = (self.sense * self.pull * math.sin(angle), -self.pull * math.cos(angle))
        else:
            forces = self.sense * factor * self.pull * self.blocks.mass * self.blocks.pattern
            run.change({f"load[push {i}].force_x": (f, f) for i, f in enumerate(forces, 1)})

    def _make_pushover(self, rows, states, polygons, ending: str) -> Pushover:
        if not rows:
            raise ConvergenceError(f"the model cannot be pushed: {ending}")
        displacement, largest, factor, work, friction = np.array(rows).T
        change = states[-1] - states[int(np.argmax(factor))]
        if not abs(change).any():
            change = states[-1] - states[0]
        bodies = self.blocks.bodies
        mean = bodies.mean(change)
        verdicts = _judge_blocks(mean, bodies.radii)
        return Pushover(self.load, self.sense, self.point, displacement, largest, factor, work,
                        friction, float(self.blocks.mass.sum()), bodies.names, verdicts, mean,
                        tuple(verdicts[i] for i in bodies.of), polygons, ending,
                        np.bincount(bodies.of, self.blocks.mass), self.pull)  # fmt: skip


def _extrapolate_factor(steps: list[tuple[float, float]]) -> float:
    """Extrapolate the factor at equilibrium to the end of the last step."""
    if len(steps) < 2:
        return steps[-1][1]
    (before, higher), (way, balance) = steps[-2:]
    return balance + (balance - higher) * way / before


def _gyration_squared(offsets: np.ndarray) -> float:
    """Return the squared polar radius of gyration of a polygon about its centroid, m²."""
    x, y = offsets.T
    a, b = np.roll(x, -1), np.roll(y, -1)
    cross = x * b - a * y
    return float(np.sum((x * x + x * a + a * a + y * y + y * b + b * b) * cross)
                 / (6 * cross.sum()))  # fmt: skip
