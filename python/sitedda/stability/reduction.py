# SPDX-License-Identifier: GPL-3.0-or-later
"""Factor of safety by strength reduction, and the mechanism in which a model fails.

All strengths (tan φ, c and T of joints and of materials of law 'mohr_coulomb') are divided by a
factor F.  The model *stands* at F if each static stage reaches equilibrium (`docs/method.md`,
statics), and displacements from the equilibrium with strong joints are at most a fraction of the
median radius of blocks.  For cells of a body, this is a fraction of the radius of the body.
Bisection finds the factor of safety, which is the largest such F and may be less than 1.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from ..base.arguments import NOT_NEGATIVE, POSITIVE, TOLERANCE
from ..base.errors import InputError
from ..build.cutting.rings import Rings
from ..build.model import Model
from ..engine.simulation import Simulation
from .bodies import Bodies
from .strength import Rest, come_to_rest, elastic_soils, lines_of, released, static_model, yielding

_LEAST_REDUCTION, _MOST_REDUCTION = 2.0**-12, 2.0**12  # range of factors
_BEYOND = 1.02  # ratio of the factor of the mechanism to the factor at failure
_SETTLEMENT = 0.2  # largest displacement of a block up to the first equilibrium / its radius
_UNDISTURBED = 0.1  # largest displacement before a mechanism, as a fraction of the allowed one
_SMALL = 0.01  # fraction of the area of the model below which a mechanism is small
_NAMED = 4  # largest number of blocks that a sentence names
_NEGLIGIBLE = 1e-6  # components below this fraction of the largest are shown as 0
_TOO_FAR = 2.0  # ratio of the displacement that ends a static stage to the allowed displacement
_STILL = 0.02  # fraction of the largest displacement below which a block is stable
_TURNING = 0.03  # ratio of rotation × radius to displacement above which a block topples
_LOADS = ("load", "traction", "water", "flow", "bolt", "in_situ")  # groups that load blocks
_STEP, _STEPS = 0.4, 3000  # time step / √(displacement / g); largest number of steps
_ELASTIC = 4  # number of first steps, in which elastic strains adapt to the new forces


@dataclass(frozen=True)
class Mechanism:
    """The motion of a model whose strength is divided by a factor.

    Attributes
    ----------
    factor : float
    displacement : ndarray, shape (bodies, 3)
        Mean displacement x, y (m) and rotation (rad) of each body from equilibrium.
    verdicts : tuple of str
        Motion of each body: 'stable', 'slides' or 'topples'.
    names : tuple of str
        Names of the bodies.
    moves : bool
        Whether a block has moved by the displacement that counts as failure.
    polygons : list of ndarray
        Outlines of the bodies at equilibrium, shape (vertices, 2), m.
    joint : str
        Joint with the largest normal force between moving and stable blocks; empty if none.
    lines : list of (str, ndarray)
        Bolts and water: kind ('bolt' or 'water') and line, shape (points, 2), m.
    """

    factor: float
    displacement: np.ndarray
    verdicts: tuple[str, ...]
    names: tuple[str, ...]
    moves: bool
    polygons: list[np.ndarray] = field(repr=False)
    joint: str = ""
    lines: list[tuple[str, np.ndarray]] = field(default_factory=list, repr=False)

    def draw(self, axes=None, title: str = ""):
        """Draw blocks coloured by their verdicts, with arrows; return matplotlib axes."""
        from .picture import draw_mechanism

        outcome = "Mechanism" if self.moves else "Stands"
        subtitle = f"strength divided by {self.factor:.4g}"
        if title:
            subtitle = f"{outcome.lower()} with {subtitle}"
        return draw_mechanism(self, axes, title or outcome, subtitle)

    @property
    def areas(self) -> tuple[float, float]:
        """Return the area of the moving blocks and of all blocks, m²."""
        each = abs(Rings.of(self.polygons).areas())
        return float(each[_are_moving(self.verdicts)].sum()), float(each.sum())

    @property
    def moving(self) -> list[str]:
        """Return the names of the moving blocks."""
        return [self.names[i] for i in np.flatnonzero(_are_moving(self.verdicts))]

    @property
    def words(self) -> str:
        """Return a phrase with the moving blocks, their area and the joint on which they move."""
        moving, total = self.areas
        names = self.moving
        listing = ", ".join(names[:_NAMED]) + (" …" if len(names) > _NAMED else "")
        verb = "moves" if len(names) == 1 else "move"
        joint = f", on joint {self.joint!r}" if self.joint else ""
        per_cent = 100 * moving / total
        return f"{listing} {verb}: {moving:.4g} m², {per_cent:.3g} % of the model{joint}"

    def to_dict(self) -> dict:
        """Return numbers, texts and lists, for example for JSON."""
        return {
            "factor": self.factor,
            "moves": self.moves,
            "blocks": dict(zip(self.names, self.verdicts, strict=True)),
            "area": self.areas[0],
            "joint": self.joint,
            "displacement": self.displacement.tolist(),
        }

    def __str__(self) -> str:
        """Return a table of the blocks as text."""
        width = max(map(len, self.names))
        head = f"{'block':{width}}  {'verdict':8} {'x (m)':>11} {'y (m)':>11} {'rotation (°)':>12}"
        rows = []
        negligible = _NEGLIGIBLE * float(abs(self.displacement).max(initial=0.0))
        displacement = np.where(abs(self.displacement) > negligible, self.displacement, 0.0)
        for name, verdict, (x, y, angle) in zip(self.names, self.verdicts, displacement,
                                                 strict=True):  # fmt: skip
            turn = math.degrees(angle)
            rows.append(f"{name:{width}}  {verdict:8} {x:11.4g} {y:11.4g} {turn:12.4g}")
        outcome = "moves" if self.moves else "does not move"
        result = f"strength divided by {self.factor:.6g}: the model {outcome}"
        return "\n".join([head, *rows, result])


@dataclass(frozen=True)
class Safety:
    """A factor of safety.

    Attributes
    ----------
    low, high : float
        The model stands at `low` and fails at `high`.
    trials : tuple of Rest
        All trials, in order.
    mechanism : Mechanism or None
        The mechanism of failure; None if the model stands without strength.
    warning : str
        Warning about the result; empty if there is none.
    smaller : tuple of Safety
        Mechanisms below `least_area`, whose blocks were removed successively.
    """

    low: float
    high: float
    trials: tuple[Rest, ...]
    mechanism: Mechanism | None
    warning: str = ""
    smaller: tuple["Safety", ...] = ()

    @property
    def factor(self) -> float:
        """Return the middle of the bracket; 0 if the model fails at any strength."""
        if self.low == 0.0 or math.isinf(self.high):
            return self.low
        return 0.5 * (self.low + self.high)

    def draw(self, axes=None):
        """Draw the mechanism; return matplotlib axes."""
        if self.mechanism is None:
            raise InputError("there is no mechanism: the model stands without strength")
        text = f"Factor of safety {self.factor:.4g}" if self.low else "Fails at any strength"
        return self.mechanism.draw(axes, text)

    def to_dict(self) -> dict:
        """Return numbers, texts and lists, for example for JSON."""
        result = {
            "factor": self.factor,
            "stands_at": self.low,
            "fails_at": None if math.isinf(self.high) else self.high,
            "warning": self.warning,
            "trials": [{"factor": item.factor, "stands": item.stands, "words": item.words}
                       for item in self.trials],
        }  # fmt: skip
        if self.mechanism:
            keys = ("blocks", "area", "joint")
            result |= {name: self.mechanism.to_dict()[name] for name in keys}
        if self.smaller:
            result["smaller"] = [item.to_dict() for item in self.smaller]
        return result

    @property
    def words(self) -> str:
        """Return the result, and the removed smaller mechanisms, in a sentence."""
        notes = [f"removed, below least_area: {item.mechanism.words}, factor {item.factor:.4g}"
                 for item in self.smaller]  # fmt: skip
        return "; ".join([self._result_words, *notes])

    @property
    def _result_words(self) -> str:
        """Return the factor, its bracket and the mechanism in a sentence."""
        if math.isinf(self.high):
            return f"stands even with all strengths divided by {self.low:g}"
        if self.low == 0.0:
            return f"fails even with all strengths multiplied by {1 / self.high:g}"
        text = (f"factor of safety {self.factor:.4g}: stands with all strengths divided "
                 f"by {self.low:.6g}, fails at {self.high:.6g}")  # fmt: skip
        if self.mechanism is None or "stable" not in self.mechanism.verdicts:
            return text
        moving, total = self.mechanism.areas
        text += f"; {self.mechanism.words}" if moving > 0.0 else ""
        small = 0.0 < moving < _SMALL * total
        return text + "; set least_area to find the factor of larger mechanisms" * small

    def __str__(self) -> str:
        """Return trials, mechanism and result as text."""
        head = f"strength divided by trial factors, by bisection\n{'factor':>10}  outcome"
        parts = ["\n".join([head, *map(str, self.trials)])]
        if self.mechanism:
            parts.append(str(self.mechanism))
        parts += [self.words, f"warning: {self.warning}" if self.warning else ""]
        return "\n\n".join(filter(None, parts))


def _are_moving(verdicts: tuple[str, ...]) -> np.ndarray:
    """Return whether each body moves, shape (bodies,)."""
    return np.array(verdicts) != "stable"


def _check_loads_and_supports(model: Model) -> None:
    """Raise InputError if a model has no loads or no supports."""
    gravity = model.control.gravity
    if (gravity is None or not np.any(gravity)) and not any(map(model.of_kind, _LOADS)):
        raise InputError("a factor of safety requires weight or loads: set gravity of &control")
    if not any(map(model.of_kind, ("fixed_point", "boundary"))):
        raise InputError("the blocks have no support: add a &fixed_point or &boundary")


def bisect(
    is_stable: Callable[[float], bool], low: float, high: float, tolerance: float
) -> tuple[float, float]:
    """Bisect a bracket between a value at which a model stands, `low`, and one at which it fails.

    `low` may be the larger value.  `tolerance` is the width of the last bracket as a fraction of
    its larger end.
    """
    while abs(high - low) > tolerance * max(abs(low), abs(high)):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if is_stable(middle) else (low, middle)
    return low, high


class _Trials:
    """The trials of a model with its strength divided by factors."""

    def __init__(self, model: Model, displacement: float, removed: list[str], progress=None):
        _check_loads_and_supports(model)
        self.progress = progress
        self.model, self.removed = model, ", ".join(removed) or None
        if self.removed:
            stage = model.of_kind("stage")[0]
            stage(remove=", ".join(filter(None, (stage.remove, *removed))))
        with released(self.model, 1.0, None, 1.0, 1) as simulation:  # the undeformed model
            self.start = simulation.coordinates
            names = [name or f"block {i}" for i, name in enumerate(simulation.block_names, 1)]
            self.bodies = Bodies(simulation.polygons, simulation.block_bodies, names)
        kinds = ("bolt", "water")
        self.lines = lines_of({k: [group.as_dict() for group in model.of_kind(k)] for k in kinds})
        self.done: list[Rest] = []
        self.share = displacement
        self.reference: np.ndarray | None = None
        self._end_early(_SETTLEMENT * self.bodies.radii.max())

    @property
    def allowed_displacement(self) -> np.ndarray:
        """Return the displacement of each block that counts as failure, m."""
        radii = self.bodies.radii
        usual = float(np.quantile(radii, 0.5, method="lower"))
        is_body = np.bincount(self.bodies.of) > 1
        return self.share * np.where(is_body, radii, usual)[self.bodies.of]

    def largest(self, coordinates: np.ndarray, start: np.ndarray) -> tuple[float, float]:
        """Return the displacement closest to failure, and its allowed value, m."""
        distance = self.movement(coordinates, start)
        worst = int(np.argmax(distance / self.allowed_displacement))
        return float(distance[worst]), float(self.allowed_displacement[worst])

    def movement(self, coordinates: np.ndarray, start: np.ndarray) -> np.ndarray:
        """Return √(displacement² + (radius × rotation)²) of each block, shape (blocks,), m."""
        change = coordinates - start
        radii = self.bodies.radii[self.bodies.of]
        return np.hypot(np.hypot(change[:, 0], change[:, 1]), radii * change[:, 2])

    def stands(self, factor: float) -> bool:
        """Run the static stages at a factor; return whether the model stands."""
        result = come_to_rest(self.model, factor)
        if result.stands:
            if self.reference is None:
                distance = self.movement(result.coordinates, self.start)
                peak = float((distance / self.bodies.radii[self.bodies.of]).max())
                limit, unit = _SETTLEMENT, "radii"
            else:
                (peak, limit), unit = self.largest(result.coordinates, self.reference), "m"
            text = f"{result.words}; a block has moved by {peak:.3g} {unit}, allowed {limit:.3g}"
            result = Rest(factor, peak <= limit, text, result.coordinates)
        if result.stands and self.reference is None:
            self.reference = result.coordinates
            settled = self.movement(self.reference, self.start).max()
            self._end_early(settled + self.allowed_displacement.max())
        self.done.append(result)
        if self.progress:
            self.progress(result)
        return result.stands

    def _end_early(self, limit: float) -> None:
        """Make static stages end as soon as a block moves by twice the allowed displacement, m."""
        for stage in self.model.of_kind("stage"):
            stage(displacement=float(_TOO_FAR * limit))

    def find_reference(self, factor: float) -> float | None:
        """Return the first of the factors 1/4, 1/64 … at which the model stands, if any."""
        factor *= 0.25
        while factor >= _LEAST_REDUCTION:
            if self.stands(factor):
                return factor
            factor /= 16.0
        return None

    def undisturbed_factor(self) -> float:
        """Return the largest factor at which the model stands with small displacements."""

        def is_undisturbed(trial: Rest) -> bool:
            peak, limit = self.largest(trial.coordinates, self.reference)
            return peak <= _UNDISTURBED * limit

        return max(rest.factor for rest in self.done if rest.stands and is_undisturbed(rest))


def safety(
    source,
    *,
    tolerance: float = 1e-3,
    displacement: float = 0.05,
    least_area: float = 0.0,
    changes: Mapping | None = None,
    progress: Callable[[Rest], None] | None = None,
) -> Safety:
    """Find the factor by which all strengths can be divided before a model fails.

    Parameters
    ----------
    source : path or Model
        Input.  Its dynamic stages become static; motions are ignored; loads have their values at
        time 0.
    tolerance : float
        Width of the last bracket as a fraction of its upper end.
    displacement : float
        Largest displacement of a block from the equilibrium with strong joints, over the median
        radius of the blocks (of cells: over the radius of their body).
    least_area : float
        Smallest area of a mechanism, m².  The blocks of smaller mechanisms are removed, and the
        factor is that of the remaining model.
    changes : mapping, optional
        Changes of the input, see `Simulation`.
    progress : callable, optional
        Called with each trial.

    Raises
    ------
    InputError
        If the input is invalid.
    """
    TOLERANCE.check("tolerance", tolerance)
    POSITIVE.check("displacement", displacement)
    NOT_NEGATIVE.check("least_area", least_area)
    model = static_model(source, changes)
    smaller: list[Safety] = []
    while True:
        removed = [name for item in smaller for name in item.mechanism.moving]
        result = _bisect_factor(_Trials(model.copy(), displacement, removed, progress), tolerance)
        small = result.mechanism is not None and result.mechanism.areas[0] < least_area
        if not small or not result.mechanism.moves or set(result.mechanism.moving) <= set(removed):
            return replace(result, smaller=tuple(smaller))
        smaller.append(result)


def _bisect_factor(trials: _Trials, tolerance: float) -> Safety:
    """Find the factor of safety by bisection, and the mechanism of failure."""
    reference = trials.find_reference(1.0)
    if reference is None:
        lowest, mechanism = trials.done[-1].factor, _release_mechanism(trials, 1.0, None)
        warning = _find_warnings(mechanism, trials.model)
        return Safety(0.0, lowest, tuple(trials.done), mechanism, warning)
    low, high = reference, 1.0
    while high <= _MOST_REDUCTION and trials.stands(high):
        low, high = high, 2.0 * high
    if high > _MOST_REDUCTION:
        return Safety(low, math.inf, tuple(trials.done), None, _find_warnings(None, trials.model))
    low, high = bisect(trials.stands, low, high, tolerance)
    mechanism = _release_mechanism(trials, _BEYOND * high, trials.undisturbed_factor())
    return Safety(low, high, tuple(trials.done), mechanism, _find_warnings(mechanism, trials.model))


def mechanism(
    source, factor: float = 1.0, *, displacement: float = 0.05, changes: Mapping | None = None
) -> Mechanism:
    """Compute the motion of a model with all strengths divided by a factor.

    Parameters
    ----------
    source, displacement, changes
        See `safety`.
    factor : float

    Returns
    -------
    Mechanism
        All blocks are stable if the model stands.
    """
    POSITIVE.check("factor", factor)
    POSITIVE.check("displacement", displacement)
    trials = _Trials(static_model(source, changes), displacement, [])
    reference = trials.find_reference(factor)
    if reference is not None and trials.stands(factor):
        bodies = trials.bodies
        motion = bodies.mean(trials.done[-1].coordinates[:, :3] - trials.reference[:, :3])
        stable = ("stable",) * len(bodies.names)
        return Mechanism(factor, motion, stable, bodies.names, False, bodies.outlines(),
                         lines=trials.lines)  # fmt: skip
    return _release_mechanism(trials, factor, reference)


def _release_mechanism(trials: _Trials, factor: float, start_factor: float | None) -> Mechanism:
    """Return the motion of the model at a factor, from the equilibrium at `start_factor`.

    Static steps are computed until a block has moved by the allowed displacement.
    """
    gravity = trials.model.control.gravity
    g = 0.0 if gravity is None else float(np.linalg.norm(gravity))
    unit = math.sqrt(float(trials.allowed_displacement.min()) / (g or 1.0))
    moves = ended = False
    with released(trials.model, factor, start_factor, _STEP * unit, _STEPS, trials.removed) as run:
        run.advance(_ELASTIC)
        start = run.coordinates
        while not (moves or ended):
            ended = run.advance(10)
            peak, limit = trials.largest(run.coordinates, start)
            moves = peak > limit
        bodies, change = trials.bodies, run.coordinates - start
        change = bodies.mean(change[:, :3])
        verdicts = judge_blocks(change, bodies.radii)
        joint = _joint_between(run, bodies.of, _are_moving(verdicts), trials.model)
    return Mechanism(factor, change, verdicts, bodies.names, moves, bodies.outlines(), joint,
                     trials.lines)  # fmt: skip


def _joint_between(run: Simulation, body: np.ndarray, moving: np.ndarray, model: Model) -> str:
    """Return the joint with the largest normal force between moving and stable bodies, or ''."""
    contacts = run.contacts
    owner = np.repeat(np.arange(len(body)), [len(polygon) for polygon in run.polygons])
    sides = [moving[body[owner[contacts[end]]]] for end in ("vertex", "edge")]
    force = np.where(sides[0] != sides[1], contacts["normal_force"], 0.0)
    names = [joint.name for joint in model.of_kind("joint")]
    # The weaker copies of all joints follow the original joints in the same order.
    total = np.bincount(contacts["joint"] % len(names), force, len(names))
    return names[int(np.argmax(total))] if total.max() > 0.0 else ""


def judge_blocks(change: np.ndarray, radii: np.ndarray) -> tuple[str, ...]:
    """Return 'stable', 'slides' or 'topples' for each block from displacement and rotation."""
    shift, rotation = np.hypot(change[:, 0], change[:, 1]), radii * abs(change[:, 2])
    stable = np.hypot(shift, rotation) <= _STILL * np.hypot(shift, rotation).max(initial=0.0)
    topples = rotation > _TURNING * shift
    return tuple(np.where(stable, "stable", np.where(topples, "topples", "slides")).tolist())


def _find_warnings(mechanism: Mechanism | None, model: Model) -> str:
    """Return warnings about the mechanism, elastic soils and large yielding cells."""
    warnings = []
    if mechanism and not mechanism.moves:
        warnings.append("static stages fail, but the released model moves less than the allowed "
                        "displacement: the cause may not be a lack of strength; see the "
                        "trials")  # fmt: skip
    if elastic := elastic_soils(model):
        warnings.append(f"soils of law 'hysteretic' are elastic in this analysis "
                        f"({', '.join(elastic)}): only the curves 'hyperbolic' and 'gqh' have a "
                        "shear strength")  # fmt: skip
    if mechanism and yielding(model):
        warnings.append("large cells overestimate the strength: compare with the factor for cells "
                        "of half the size")  # fmt: skip
    return "; ".join(warnings)
