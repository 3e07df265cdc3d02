# SPDX-License-Identifier: GPL-3.0-or-later
"""Pushover: a load that grows with the weight to its peak and falls behind it, by static steps.

Each step drops all velocities, so that blocks out of balance move by d = M⁻¹ F Δt², and what
inertia takes of the load is known: with f the load at a factor of 1, virtual work of the step's own
displacements gives the factor at which the blocks are in balance, λ − Σ d·M d/(Δt² Σ f·d).  The
next factor is that and an excess which makes the displacement of the named point in a step as large
as it is wanted, or that of the block that moves farthest where the point hardly moves:
displacement controls the load, also where a mechanism falls that the point is no part of.  The
forces of a step balance where it begins, so that the curve of a mechanism is exact.
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
from .safety import _verdicts
from .strength import static_model

LOADS = ("horizontal", "tilt", "mode")
_EXCESS = 0.005  # of the weight: excess load of a step
_FIRST, _LEAST = 0.01, 0.05  # first factor; factor that changes are fractions of, at least
_MOST = 0.02  # fraction of the factor, of its excess
_BACK = 0.5  # of the factor of balance, to which the next one falls at most
_STEADY = 1.5  # times _EXCESS; above it normal forces, and so friction, differ from those at rest
_SMALLEST = 1e-4  # the same, at least
_MORE = 1.5  # largest ratio of the excesses of two steps
_SHORTEST = 1e-3  # of the time step, below which a step does not converge
_LOOKS, _TO_PEAK = 6, 500  # limit of steps over those requested, and before the peak
_HARDLY = 0.2  # of the largest displacement of a step: the point does not control it
_ELASTIC = 0.1  # of the target displacement of a step: less is elastic
_PARTED = 3.0  # times the displacement requested: a block has left the point behind
_STILL = 1e-3  # of the largest displacement of a mode: a fixed block
_UNCONVERGED = "a step does not converge"
_BY_THEMSELVES = "blocks move by themselves; more steps may follow them farther"
_TILT = math.radians(89.0)  # at which a tilting table ends


@dataclass(frozen=True)
class Pushover:
    """A capacity curve, and how the blocks move.

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
        Lost by slip, J/m.
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
        Why it ended there.
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
        """Largest load over the weight."""
        return float(self.factor.max())

    @property
    def at_peak(self) -> float:
        """Displacement there, m."""
        return float(self.displacement[int(np.argmax(self.factor))])

    @property
    def converged(self) -> bool:
        """Whether all of its steps converged."""
        return not self.ending.startswith(_UNCONVERGED)

    def __str__(self) -> str:
        """Peak, energies, mechanism and end, a line each."""
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
        """The curve as lines of displacement (m), factor, work and friction (J/m)."""
        rows = zip(
            self.displacement, self.largest, self.factor, self.work, self.friction, strict=True
        )
        lines = [",".join(f"{value:.9g}" for value in row) for row in rows]
        return "\n".join(
            ["displacement (m),largest (m),factor (1),work (J/m),friction (J/m)", *lines, ""]
        )

    def draw(self, limits=None):
        """Curve, energies and blocks at the end; a matplotlib.figure.Figure.

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
    """Push a model past its peak, under control of displacements.

    Parameters
    ----------
    source : path or Model
        It must come to rest under its weight; static stages act, motions do not.
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
        If the model does not come to rest under its weight.
    """
    if load not in LOADS or sense not in (1, -1):
        raise InputError(f"load = {load!r}, sense = {sense!r}: use {', '.join(LOADS)}; 1 or -1")
    COUNT.check("steps", steps)
    model = static_model(source, changes)
    pushed = _Pushed(model, point, load, sense, displacement, steps)
    return pushed.run()


@dataclass(frozen=True)
class _Loaded:
    """The blocks of a model, and the load of each at a factor of 1 over its weight."""

    bodies: Bodies
    mass: np.ndarray
    polar: np.ndarray
    centres: np.ndarray
    lowest: float
    pattern: np.ndarray

    @classmethod
    def of(cls, model: Model, load: str) -> "_Loaded":
        """Those of a model."""
        with Simulation(model) as first:
            scene, polygons, centres = Scene.of(first), first.polygons, first.coordinates[:, :2]
            density = [float(group["density"]) for group in scene.groups["material"]]
            mass = np.array(density)[scene.material] * scene.areas()
            each = zip(polygons, centres, strict=True)
            polar = mass * [_polar(polygon - centre) for polygon, centre in each]
            pattern = _first_mode(first, mass) if load == "mode" else np.ones(len(mass))
            bodies = Bodies(polygons, first.block_bodies, list(scene.names))
        lowest = float(np.concatenate(polygons)[:, 1].min())
        return cls(bodies, mass, polar, centres, lowest, pattern)


def _first_mode(first: Simulation, mass: np.ndarray) -> np.ndarray:
    """Displacements along x, scaled so that the forces add up to the weight of what moves."""
    from ..engine.checking import modes

    shape = modes(first, 1).shapes[0][:, 0]
    shape = shape / shape[np.argmax(abs(shape))]
    moves = abs(shape) > _STILL
    total = mass[moves].sum() / np.sum(mass * abs(shape) * moves)
    return np.where(moves, shape, 0.0) * total


class _Pushed:
    """A model, and the load on it."""

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
        self.blocks = _Loaded.of(model, load)
        height = points[point].y - self.blocks.lowest
        self.end = POSITIVE.check("displacement", 0.1 * height if end is None else end)
        self.model = self._stepped(model)

    def _stepped(self, model: Model) -> Model:
        """The model with a stage of static steps."""
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
        """Step to the end."""
        rows, states, ending = [], [], ""
        excess, factor, work, moved, far = _FIRST, _FIRST, 0.0, 0.0, 0.0
        steps: list[
            tuple[float, float]
        ] = []  # displacement of the controlling point or block; balance
        with Simulation(self.model) as run:
            start = before = run.coordinates
            time, lost = run.time, run.energies["friction"]
            while not ending:
                self._set(run, factor)
                try:
                    done = run.advance()
                except (ConvergenceError, SolverError) as trouble:
                    ending = f"{_UNCONVERGED}: {trouble}"
                    break
                now = run.coordinates
                change, step = now - before, run.time - time
                before, time, last = now, run.time, moved
                power, inertia = self._power(change, factor), self._inertia(change) / step**2
                balance = factor - (inertia / power if power > 0 else 0.0)
                work += balance * power
                row = (moved, far, balance, work, run.energies["friction"] - lost)
                moved = self.sense * float(run.point_motions[0, self.index, 0])
                far = float(np.hypot(*(now - start)[:, :2].T).max())
                steady = factor - balance <= _STEADY * _EXCESS
                ending = self._ending(done, moved, far, balance)
                if balance <= 0 and not steady:
                    ending = _BY_THEMSELVES
                if steady:
                    rows.append(row)
                    states.append(now[:, :3])
                steps.append((self._controlling_displacement(change, moved - last), balance))
                excess = self._excess(excess, factor, steps)
                ahead = max(_balance_ahead(steps), _BACK * balance)
                factor = min(factor, ahead) + excess
            polygons = run.polygons
        return self._found(rows, states, polygons, ending)

    def _controlling_displacement(self, change: np.ndarray, own: float) -> float:
        """Displacement that controls a step: of the point, or of the block that moves farthest."""
        most = float(np.hypot(*change[:, :2].T).max())
        return max(abs(own) if abs(own) > _HARDLY * most else most, 1e-12 * self.end)

    def _excess(self, excess: float, factor: float, steps: list[tuple[float, float]]) -> float:
        """What the next factor has beyond balance: a mechanism moves in proportion to it."""
        (way, balance), wanted = steps[-1], self.end / self.steps
        next_one = _MORE * excess
        if way > _ELASTIC * wanted:
            next_one = min(next_one, (factor - balance) * wanted / way)
        least, most = _SMALLEST * max(factor, _LEAST), _MOST * max(balance, _LEAST)
        return min(max(next_one, least), most)

    def _ending(self, done: bool, moved: float, far: float, balance: float) -> str:
        """Why the last step was the last one; empty if it was not."""
        if balance <= 0:
            return "collapse: no resistance is left"
        if abs(moved) >= self.end:
            return "the target displacement is reached"
        if far >= _PARTED * self.end:
            return (
                f"another block has moved by {1e3 * far:.4g} mm while the point moved by "
                f"{1e3 * abs(moved):.4g} mm; choose a point on that block"
            )
        if self.load == "tilt" and balance >= math.tan(_TILT):
            return "the table is upright"
        return "as many steps as it may take" if done else ""

    def _inertia(self, change: np.ndarray) -> float:
        """d·M d of a step, kg m² per metre."""
        square = np.sum(change[:, :2] ** 2, axis=1)
        return float(np.sum(self.blocks.mass * square + self.blocks.polar * change[:, 2] ** 2))

    def _power(self, change: np.ndarray, factor: float) -> float:
        """Work of the load at a factor of 1 over the displacements of a step, J/m."""
        weight, ways = self.pull * self.blocks.mass, change[:, :2]
        if self.load != "tilt":
            return float(self.sense * np.sum(weight * self.blocks.pattern * ways[:, 0]))
        return float(self.sense * np.sum(weight * ways[:, 0]) * math.cos(math.atan(factor)))

    def _set(self, run: Simulation, factor: float) -> None:
        """Apply the load."""
        if self.load == "horizontal":
            run.gravity = (self.sense * factor * self.pull, -self.pull)
        elif self.load == "tilt":
            angle = math.atan(factor)
            run.gravity = (self.sense * self.pull * math.sin(angle), -self.pull * math.cos(angle))
        else:
            forces = self.sense * factor * self.pull * self.blocks.mass * self.blocks.pattern
            run.change({f"load[push {i}].force_x": (f, f) for i, f in enumerate(forces, 1)})

    def _found(self, rows, states, polygons, ending: str) -> Pushover:
        if not rows:
            raise ConvergenceError(f"the model cannot be pushed: {ending}")
        displacement, largest, factor, work, friction = np.array(rows).T
        change = states[-1] - states[int(np.argmax(factor))]
        if not abs(change).any():
            change = states[-1] - states[0]
        bodies = self.blocks.bodies
        mean = bodies.mean(change)
        verdicts = _verdicts(mean, bodies.radii)
        return Pushover(self.load, self.sense, self.point, displacement, largest, factor, work,
                        friction, float(self.blocks.mass.sum()), bodies.names, verdicts, mean,
                        tuple(verdicts[i] for i in bodies.of), polygons, ending,
                        np.bincount(bodies.of, self.blocks.mass), self.pull)  # fmt: skip


def _balance_ahead(steps: list[tuple[float, float]]) -> float:
    """Factor of balance where the last step ended, by the slope over the two before."""
    if len(steps) < 2:
        return steps[-1][1]
    (before, higher), (way, balance) = steps[-2:]
    return balance + (balance - higher) * way / before


def _polar(offsets: np.ndarray) -> float:
    """Square of the polar radius of gyration of a polygon about its centroid, m²."""
    x, y = offsets.T
    a, b = np.roll(x, -1), np.roll(y, -1)
    cross = x * b - a * y
    return float(np.sum((x * x + x * a + a * a + y * y + y * b + b * b) * cross)
                 / (6 * cross.sum()))  # fmt: skip
