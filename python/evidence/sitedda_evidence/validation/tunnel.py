# SPDX-License-Identifier: GPL-3.0-or-later
"""A tunnel in jointed rock between free fields, excavated and shaken."""

import numpy as np

from sitedda.facade.model import Model
from sitedda.facade.run import run
from sitedda.output.scene import Scene
from sitedda.report.style import STONE, bare, canvas, draw_blocks

from ..case import Outcome, Row, at_most, case, yes_or_no
from ..model import GRAVITY, energy_residual
from .sliding import record_file

ROCK = {"density": 2600.0, "shear_velocity": 900.0, "pressure_velocity": 1600.0}
SIDE, HALF, EDGE = 20.0, 15.0, 40.0  # half-width of jointed rock, half-height, half-width, m
OPENING = (-4.0, -3.0, 4.0, 4.0)  # left, bottom, right, top, m
BOLT = {"axial_stiffness": 5e7, "pretension": 2e5, "yield_force": 1e6}  # N/m, N
# Heads at the opening, and anchors in the rock, m.
ROOF = [((x, 4.1), (1.5 * x, 10.5)) for x in (-3.5, -2.5, -1.5, -0.5, 0.5, 1.5, 2.5, 3.5)]
WALLS = [((-4.1, 1.3), (-9.5, 2.5)), ((-4.1, -1.5), (-9.5, -1.5)), ((-4.1, 3.0), (-9.5, 4.0))]
WALLS += [((4.1, 1.0), (9.5, 2.0)), ((4.1, -1.5), (9.5, -1.5)), ((4.1, 3.0), (9.5, 4.5))]
VARIANTS = {
    "bolts": {},
    "bolts, adaptive": {"time_step_control": "adaptive"},
    "bolts, 'dda'": {"integration": "dda"},
    "bolts, no restitution": {},
    "no bolts": {},
    "no bolts, adaptive": {"time_step_control": "adaptive"},
    "no bolts, no restitution": {},
}


@case(
    "A tunnel between free fields",
    "Beds at 15° (φ = 30°) and cross joints at −70° (φ = 35°) lie between bonded ground, free"
    " fields at both sides and a half-space below. With bolts, the rock around the opening is"
    " stable after excavation and during the record. Without bolts, the wedge of the left wall"
    " must fall, because its lower face dips into the opening by 70° > φ. All steps must converge,"
    " and the energy budget must balance.",
    "Goodman and Shi (1985), removability of wedges; `docs/boundaries.md`.",
)
def tunnel(short: bool) -> Outcome:
    """Check the wedge and the energies of all variants."""
    rows: list[Row] = []
    names = ("bolts", "no bolts") if short else tuple(VARIANTS)
    figure, axes = canvas(2)
    for name in names:
        duration = 0.5 if short else 12.0
        data = run(_tunnel_model(name, duration)).history
        rows += _tunnel_rows(name, data, duration)
        if name in ("bolts", "no bolts"):
            axis = axes[int(name == "no bolts")]
            draw_blocks(axis, Scene.of(data).polygons(-1), STONE, lw=0.3)
            axis.set(title=name, xlim=(-SIDE, SIDE), ylim=(-HALF, HALF))
            bare(axis)
    return Outcome(rows, figure)


def _tunnel_rows(name: str, data, duration: float) -> list[Row]:
    """Check that a run is complete, that energies balance, and that bolts retain the wedge."""
    scene = Scene.of(data)
    wedge = scene.names.index(_wedge_name(scene))
    fallen = np.linalg.norm(scene.displacement(scene.frames - 1)[wedge]) > 0.1
    is_complete = abs(float(data.time[-1]) - duration) < 1e-6
    return [
        yes_or_no(f"{name}: the run completes all steps", True, is_complete),
        at_most(f"{name}: energy residual / work", energy_residual(data), 1e-6),
        yes_or_no(f"{name}: the wedge of the left wall falls", name.startswith("no"), fallen),
    ]


def _wedge_name(scene: Scene) -> str:
    """Return the name of the triangular block at the left wall of the opening."""
    left, bottom, _, top = OPENING
    start = scene.coordinates(0)
    candidates = [
        i for i, polygon in enumerate(scene.polygons(0))
        if len(polygon) == 3 and left - 1.0 < start[i, 0] < left and bottom < start[i, 1] < top
    ]  # fmt: skip
    return scene.names[candidates[0]]


def _tunnel_model(name: str, duration: float) -> Model:
    """Return a variant of the model; without bolts, excavation and shaking begin together."""
    control = {"integration": "theta", "analysis": "plane_strain"} | VARIANTS[name]
    model = Model(name, time_step=1e-3, gravity=(0.0, -GRAVITY), **control)
    model.material("rock", damping_ratio=0.02, reference_frequency=3.0, **ROCK)
    impacts = {} if name.endswith("no restitution") else {"restitution": 0.0}
    model.joint("bed", friction_angle=30.0, **impacts)
    model.joint("cross", friction_angle=35.0, **impacts)
    model.joint("bonded", friction_angle=35.0, cohesion=1e9, tensile_strength=1e9)
    _add_rock(model)
    model.motion("quake", file=str(record_file()))
    model.boundary("base", "compliant", side="bottom", motion_x="quake", **ROCK)
    for side in ("left", "right"):
        model.boundary(side=side, kind="free_field", **ROCK)
    bolted = name.startswith("bolts")
    if bolted:
        for number, (head, anchor) in enumerate(ROOF + WALLS, 1):
            model.bolt(f"bolt_{number}", head, anchor, **BOLT)
    excavation = {"remove": "core_*"}
    model.stage("rest", kind="static")
    if bolted:
        model.stage("excavation", kind="static", add="bolt_*", **excavation)
    model.stage("shaking", duration=duration, motions="quake", **({} if bolted else excavation))
    return model


def _add_rock(model: Model) -> None:
    """Add jointed rock, bonded ground at both sides, and the excavation to a model."""
    parts = {"rock": (-SIDE, SIDE), "left": (-EDGE, -SIDE), "right": (SIDE, EDGE)}
    for name, (left, right) in parts.items():
        outline = (left, -HALF, right, -HALF, right, HALF, left, HALF)
        model.region(name=name, outline=outline, joint="bed" if name == "rock" else "bonded")
    left, bottom, right, top = OPENING
    opening = (left, bottom, right, bottom, right, top, left, top)
    model.excavation(name="core", outline=opening, joint="bed")
    for joint, angle, spacing in (("bed", 15.0, 3.0), ("cross", -70.0, 4.0)):
        model.joint_set(joint=joint, region="rock", angle=angle, spacing=spacing, origin=(0.0, 0.0))
    for side in ("left", "right"):
        for angle in (0.0, 90.0):
            model.joint_set(joint="bonded", region=side, angle=angle, spacing=5.0,
                origin=(0.0, 0.0))  # fmt: skip
