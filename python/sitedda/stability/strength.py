# SPDX-License-Identifier: GPL-3.0-or-later
"""Static models with reduced strength: their equilibrium, and their motion from it."""

from collections.abc import Mapping
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from ..base.core import engine_names, reduced_group
from ..base.errors import ConvergenceError, SolverError
from ..build.model import Group, Model
from ..engine.simulation import Simulation
from ..input.changes import changed_input
from ..input.groups import group_text

_TIMED = ("base_motion_x", "base_motion_y", "motion_x", "motion_y")
_TIME_ZERO = {
    "load": (("force_x", "force_y"), False),
    "traction": (("normal", "shear", "level"), False),
    "water": (("rise", "scale"), True),
}  # variables that depend on time, by group, and whether they are constant outside the given times
_DAMPING = ("damping_ratio", "reference_frequency", "damping_band", "mechanisms")  # of materials
_DAMPING += ("rayleigh_alpha", "rayleigh_beta", "rayleigh_frequencies")
_CURVES = ("curve", "plasticity_index", "mean_stress", "ocr", "reference_strain", "shear_strength",
           "curve_factor", "curve_power", "curve_fit", "strains", "reductions", "dampings",
           "damping_curve", "branches")  # fmt: skip
_WITH_STRENGTH = ("hyperbolic", "gqh")  # curves that end at a shear strength


@dataclass(frozen=True)
class Rest:
    """The result of the static stages at a factor."""

    factor: float  # divisor of tan φ, c and T
    stands: bool  # whether all static stages reach equilibrium
    words: str  # description of the equilibrium, or of the blocks that still move
    coordinates: np.ndarray | None  # block coordinates at equilibrium, shape (blocks, 6)

    def __str__(self) -> str:
        return f"{self.factor:10.6g}  {'stands' if self.stands else 'fails'}"


def static_model(source, changes: Mapping | None = None) -> Model:
    """Return a copy of a model with static stages only, and with loads as at time 0.

    Dynamic stages that change the model become static; other dynamic stages are removed.  A model
    without stages gets one static stage.  Motions and references to them are removed.

    `changes`: changes of the input, see `sitedda.changes.changed_input`.
    """
    from ..input.source import opened_input

    with opened_input(source) as (file, text):
        model = Model.from_namelist(changed_input(text, changes or {}, file=file), file)
    model = model.build()
    model.control(**dict.fromkeys((*_TIMED[:2], "settle", "dynamic_factor", "duration", "steps")))
    if model.control.time_step is None:
        model.control.time_step = 1.0  # has no effect in static stages
    model.control(time_step_control=None, least_time_step=None, integration=None, theta=None)
    model.control(damping_ratio=None, damping_frequency=None)
    stages = [_static_stage(group) for group in model.of_kind("stage")]
    for number, group in enumerate(model.of_kind("joint"), 1):
        group(name=group.name or f"joint {number}")
    for number, group in enumerate(model.of_kind("block"), 1):
        group(name=group.name or group.body or f"block {number}")
    for kind in ("motion", "amplification", "stage", "stop"):
        model.clear(kind)
    for kind, arguments in _TIME_ZERO.items():
        for load in model.of_kind(kind):
            _freeze_load(load, *arguments)
    for point in model.of_kind("fixed_point"):
        point(motion_x=None, motion_y=None)
    for material in model.of_kind("material"):
        material(**dict.fromkeys(("initial_velocity", *_DAMPING)), **_static_soil(material))
    for boundary in model.of_kind("boundary"):
        _fix_boundary(boundary)
    for values in filter(None, stages):
        model.stage(**values)
    if not model.of_kind("stage"):
        model.stage(name="rest", kind="static")
    return model


def _static_soil(material: Group) -> dict:
    """Return the variables of a hysteretic soil that change in static stages; {} for others.

    A soil whose curve has a shear strength becomes a solid with this cohesion and no friction.
    """
    if material.law != "hysteretic" or material.curve not in _WITH_STRENGTH:
        return {}
    strength = material.shear_strength
    if strength is None:
        strength = material.reference_strain * _shear_modulus(material)
    return dict.fromkeys(_CURVES) | {"law": "mohr_coulomb", "cohesion": float(strength)}


def _shear_modulus(material: Group) -> float:
    """Return the shear modulus of a material at small strains, Pa."""
    if material.shear_velocity is not None:
        return material.density * material.shear_velocity**2
    return material.young_modulus / (2 * (1 + material.poisson_ratio))


def elastic_soils(model: Model) -> list[str]:
    """Return the names of hysteretic soils whose curves have no shear strength."""
    soils = [soil for soil in model.of_kind("material") if soil.law == "hysteretic"]
    return [soil.name or "without a name" for soil in soils if soil.curve not in _WITH_STRENGTH]


def _static_stage(group: Group) -> dict | None:
    """Return the variables of a stage with kind 'static'; None if the stage changes nothing."""
    timed = ("duration", "steps", "time_step", "integration", "theta", "motions", "kind")
    values = {name: v for name, v in group.as_dict().items() if name not in timed}
    does_nothing = values.keys() <= {"name", "zero_displacements"}
    return None if does_nothing and group.kind != "static" else values | {"kind": "static"}


def _fix_boundary(boundary: Group) -> None:
    """Replace an absorbing boundary by static supports, and remove motions.

    Free-field ground beyond a side is replaced by rollers.
    """
    boundary(motion_x=None, motion_y=None, motion_is=None)
    kinds = engine_names("boundary kinds"), engine_names("boundary kinds at rest")
    static_kind = dict(zip(*kinds, strict=True)).get(boundary.kind, boundary.kind)
    if static_kind != boundary.kind:
        boundary(kind=static_kind, density=None, shear_velocity=None, pressure_velocity=None)


def _freeze_load(load: Group, names: tuple[str, ...], ends: bool) -> None:
    """Set the variables `names` of a load to their values at time 0, for all times.

    Outside its times, the load is constant if `ends`, otherwise zero.
    """
    if load.time is None:
        return
    times = np.asarray(load.time, dtype=float)
    acts = ends or times[0] <= 0.0 <= times[-1]
    for name in names:
        history = getattr(load, name)
        if history is not None:
            values = np.broadcast_to(np.asarray(history, dtype=float), times.shape)
            load(**{name: [float(np.interp(0.0, times, values))] * 2})
    load(time=[-1e9, 1e9] if acts else [-1e9, -9e8])


def weakened(model: Model, factor: float) -> Model:
    """Return a copy of a model with the strengths of all joints and solids divided by a factor."""
    copy = model.copy()
    for kind, group in _groups_with_strength(copy):
        group(**_divide_strength(kind, group, factor))
    return copy


def _groups_with_strength(model: Model) -> list[tuple[str, Group]]:
    """Return joints and yielding materials with their kinds, 'joint' or 'material'."""
    groups = {"joint": model.of_kind("joint"), "material": yielding(model)}
    return [(kind, group) for kind in groups for group in groups[kind]]


def yielding(model: Model) -> list[Group]:
    """Return the materials that have a strength."""
    solids = model.of_kind("material")
    return [solid for solid in solids if _divide_strength("material", solid, 1.0)]


def _divide_strength(kind: str, group: Group, factor: float) -> dict:
    """Return the strengths of a joint or material, divided by a factor, as its law defines."""
    return reduced_group(group_text(kind, group.as_dict()), factor)


def come_to_rest(model: Model, factor: float) -> Rest:
    """Run a static model with strengths divided by a factor; return whether it stands."""
    try:
        with Simulation(weakened(model, factor)) as simulation:
            while not simulation.advance():
                pass
            return Rest(factor, True, simulation.summary, simulation.coordinates)
    except (ConvergenceError, SolverError) as error:
        return Rest(factor, False, str(error), None)


def lines_of(groups) -> list[tuple[str, np.ndarray]]:
    """Return kind ('bolt' or 'water') and line, shape (points, 2), m, of bolts and water."""
    bolts = [[*group["from"], *np.ravel(group.get("through", [])), *group["to"]]
             for group in groups.get("bolt", [])]  # fmt: skip
    water = [group[name] for group in groups.get("water", []) for name in ("surface", "along")
             if group.get(name) is not None]  # fmt: skip
    return [(kind, np.reshape(line, (-1, 2)).astype(float))
            for kind, lines in (("bolt", bolts), ("water", water)) for line in lines]  # fmt: skip


@contextmanager
def released(
    model: Model,
    factor: float,
    start_factor: float | None,
    time_step: float,
    steps: int,
    removed: str | None = None,
):
    """Yield a simulation that starts in equilibrium and weakens to the strength at `factor`.

    Velocities are set to zero after each step, so blocks move by F Δt²/M per step in the direction
    of the unbalanced forces F, without oscillation.

    `model` has static stages only.  It reaches equilibrium at `start_factor`; without this factor,
    it starts without contact forces and without the blocks `removed` (as in `remove` of a stage).
    The time step is at most `time_step` (s), the duration at most `steps` such time steps.
    """
    moving = weakened(model, factor if start_factor is None else start_factor)
    moving.control(time_step=time_step, time_step_control="adaptive", dynamic_factor=0.0)
    moving.control(integration="backward_euler")
    names: dict[str, list[str]] = {"joint": [], "material": []}
    if start_factor is None:
        moving.clear("stage")
    else:
        for kind, group in _groups_with_strength(moving):
            weak_name = f"{group.name} weaker"
            names[kind].append(f"{group.name} -> {weak_name}")
            strengths = _divide_strength(kind, group, factor / start_factor)
            values = group.as_dict() | strengths | {"name": weak_name}
            getattr(moving, kind)(**values)
    joints, materials = (", ".join(pairs) or None for pairs in names.values())
    moving.stage(
        name="strength is lost", steps=steps, change_joints=joints, change_materials=materials,
        remove=removed if start_factor is None else None,
    )  # fmt: skip
    with Simulation(moving) as simulation:
        yield simulation
