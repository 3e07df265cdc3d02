# SPDX-License-Identifier: GPL-3.0-or-later
"""Crossings of joints: blocks that slide over them, and slopes cut by two joint sets."""

import math
import tempfile
from pathlib import Path

import numpy as np

from sitedda.engine.simulation import Simulation
from sitedda.facade.model import Model
from sitedda.input.examples import copy_example
from sitedda.report.style import BLUE, ORANGE, canvas

from ..case import Outcome, Table, at_most, case, relative
from ..model import GRAVITY

SLIDE = 0.4  # duration of sliding, s
FULL = 0.8  # fraction of a ramp in which gravity increases
FEW = 10  # number of steps between changes of gravity, and between samples
SMALL_SLOPE = ((0.0, 0.0), (16.0, 0.0), (16.0, 8.0), (5.0, 8.0))  # outline, m


def _crossed_rows(rng: np.random.Generator) -> tuple[Model, tuple[float, float], float]:
    """Return a row of blocks on a fixed row with the same cross joints, in axes of the plane.

    The result is the model, gravity (m/s²), and the exact slip of the upper row in `SLIDE` (m).
    """
    inclination = math.tan(math.radians(rng.uniform(-30.0, 30.0)))  # of the cross joints
    below, above = rng.uniform(0.5, 2.0), rng.uniform(0.2, 0.5)  # m; low blocks do not topple
    joints = np.cumsum([0.0, *rng.uniform(0.8, 2.0, 5)])
    friction, excess = rng.uniform(5.0, 30.0), math.radians(rng.uniform(4.0, 12.0))
    dip = math.radians(friction) + excess
    model = Model("Row on row", time_step=1e-3)
    model.contact(normal_stiffness=1e10)
    model.material("rock", density=2500.0, young_modulus=2e10, poisson_ratio=0.2)
    model.joint("joint", friction_angle=friction)
    for name, low, high, first in (("lower", -below, 0.0, 0), ("upper", 0.0, above, 2)):
        for i, (left, right) in enumerate(zip(joints[first:-1], joints[first + 1 :], strict=True)):
            heights = np.array([low, low, high, high])
            abscissas = [left, right, right, left] + heights * inclination
            model.block(np.column_stack([abscissas, heights]), name=f"{name} {i}")
            if name == "lower":
                for fraction in (0.2, 0.8):
                    x = left + fraction * (right - left) + 0.5 * low * inclination
                    model.fixed_point(x, 0.5 * low)
    model.measured_point("end", joints[-2] + 0.1 + 0.5 * above * inclination, 0.5 * above)
    slope = math.sin(dip) - math.cos(dip) * math.tan(math.radians(friction))
    gravity = (-GRAVITY * math.sin(dip), -GRAVITY * math.cos(dip))
    return model, gravity, 0.5 * GRAVITY * slope * SLIDE**2


def _simulate_slip(model: Model, gravity: tuple[float, float], static_stage: bool) -> float:
    """Return the slip of the upper row, m, directly or after a static stage on level ground."""
    if static_stage:
        model.control(gravity=(0.0, gravity[1]))
        model.stage(name="rest", kind="static")
    model.stage(name="slide", duration=SLIDE)
    with Simulation(model) as run:
        run.gravity = gravity
        while not run.advance(1000):
            pass
        return -float(run.point_motions[0, 0, 0])


@case(
    "Rows of blocks that slide over crossings of joints",
    "Four blocks meet at a crossing of two joints. Opposite blocks touch only at a corner. A row "
    "that slides along a joint therefore moves by `½ g (sin α - cos α tan φ) t²`, like a single "
    "block on a plane, after a static stage or a sudden release. Sizes, inclination of the cross "
    "joints, friction and slope are random.",
    "Coulomb friction on a plane.",
)
def crossings(short: bool) -> Outcome:
    """Check the largest error of the slip of random rows."""
    rng = np.random.default_rng(2013)
    count = 4 if short else 60
    slips = np.empty((count, 3))
    for values in slips:
        model, gravity, values[0] = _crossed_rows(rng)
        values[1:] = [_simulate_slip(model.copy(), gravity, static) for static in (True, False)]
    labels = ("after a static stage", "after a sudden release")
    figure, axes = canvas(1, size=(6, 4))
    rows = []
    for label, slip, color in zip(labels, slips[:, 1:].T, (BLUE, ORANGE), strict=True):
        error = np.abs(slip / slips[:, 0] - 1.0).max()
        rows.append(at_most(f"largest relative error of the slip of {count} rows {label}", error,
            0.02))  # fmt: skip
        axes[0].plot(slips[:, 0], slip, "o", color=color, label=label)
    axes[0].plot([0.0, slips.max()], [0.0, slips.max()], "k-", label="closed form")
    axes[0].set(xlabel="closed form, m", ylabel=f"slip after {SLIDE:g} s, m")
    return Outcome(rows, figure)


def _small_slope() -> Model:
    """Return a slope of two joint sets under a few acceleration pulses."""
    t = np.arange(0.0, 1.0, 0.01)
    model = Model("Slope of two joint sets", time_step=1e-3)
    model.control(gravity=(0.0, -GRAVITY), time_step_control="adaptive")
    model.material("rock", density=2600.0, young_modulus=5e9, poisson_ratio=0.25)
    model.joint("bedding", friction_angle=38.0)
    model.joint("cross", friction_angle=30.0)
    model.region("slope", outline=SMALL_SLOPE)
    model.joint_set("bedding", region="slope", angle=35.0, spacing=2.0, origin=(1.0, 1.5))
    model.joint_set("cross", region="slope", angle=100.0, spacing=2.5, origin=(4.0, 0.0))
    ground = [(-5.0, -3.0), (20.0, -3.0), (20.0, 8.0), (16.0, 8.0), (16.0, 0.0), (-5.0, 0.0)]
    model.region("ground", outline=ground)
    quake = 6.0 * np.sin(6.0 * np.pi * t) * np.sin(np.pi * t) ** 2
    model.motion("quake", quantity="acceleration", time_step=0.01, values=quake)
    for x, y in ((-4.5, -2.5), (19.5, -2.5), (19.5, 7.5)):
        model.fixed_point(x, y, motion_x="quake")
    model.measured_point("crest", 5.0, 8.0)
    return model


def _example_slope(folder: Path) -> Model:
    """Return the slope of the examples, with restitution 0 in all joints."""
    model = Model.read(copy_example("slope", folder)[0])
    model.control(duration=None, settle=None, time_step=1e-3)
    model.output(block_interval=None)
    for joint in model["joint"]:
        joint.restitution = 0.0
    return model


def _shaken_slip(model: Model, ramp: float, duration: float) -> np.ndarray:
    """Return the displacement of the crest relative to the base during shaking, m, shape (n, 2).

    `ramp`: time in which gravity increases before, s; 0: a static stage.
    """
    gravity_stage = {"duration": ramp} if ramp else {"kind": "static"}
    model.stage(name="gravity", **gravity_stage)
    model.stage(name="shake", duration=duration, motions="quake", zero_displacements=True)
    displacements = []
    with Simulation(model) as run:
        steps = round(ramp / model["control"].time_step)
        for step in range(0, steps, FEW):
            fraction = min(1.0, (step + FEW) / (FULL * steps))
            run.gravity = (0.0, -GRAVITY * fraction**2 * (3.0 - 2.0 * fraction))
            run.advance(FEW)
        origin, at_end = run.coordinates[0, :2].copy(), False
        while not at_end:
            at_end = run.advance(FEW)
            displacements.append(run.point_motions[0, 0] - (run.coordinates[0, :2] - origin))
    return np.array(displacements)


@case(
    "A slope with two joint sets, shaken after a static stage and after a ramp of gravity",
    "If the joints slip, the final displacement hardly depends on the application of gravity. The "
    "model is the slope of the examples under its record (30 m, planes at 35°, φ 38°, 5 % damping, "
    "impacts without rebound). The short form is a slope of 8 m under pulses. Stick and slip of "
    "many blocks amplify small differences, so means of seven runs are compared; φ differs by "
    "0.001° from run to run. Single runs scatter by 4 to 10 %, hence the limit of 15 %.",
    "Plasticity: residual stresses do not change an associated plastic flow. Friction without "
    "dilation is not associated, so a difference of a few percent may remain.",
)
def gravity_ramp(short: bool) -> Outcome:
    """Check the mean slip of the crest; tabulate the slip of each run."""
    duration, ramp = (1.5, 1.0) if short else (13.0, 5.0)
    offsets = (0.0,) if short else 1e-3 * np.arange(-3, 4)
    figure, axes = canvas(1, size=(8, 4))
    slips = {"static stage": [], f"ramp of {ramp:g} s": []}
    for (beginning, results), color, seconds in zip(
        slips.items(), (BLUE, ORANGE), (0.0, ramp), strict=True
    ):
        for offset in offsets:
            with tempfile.TemporaryDirectory() as folder:
                model = _small_slope() if short else _example_slope(Path(folder))
                model["joint.bedding"].friction_angle += offset
                slip = np.linalg.norm(_shaken_slip(model, seconds, duration), axis=1)
            label = beginning if not results else None
            axes[0].plot(np.linspace(0.0, duration, len(slip)), slip, color=color, label=label)
            results.append(float(slip[-1]))
    axes[0].set(xlabel="time, s", ylabel="slip of the crest, m")
    after_stage, after_ramp = (float(np.mean(results)) for results in slips.values())
    quantity = "mean slip of the crest after a ramp of gravity; expected: after a static stage"
    rows = [relative(quantity, after_stage, after_ramp, 0.01 if short else 0.15, "m")]
    cells = [[start, *(f"{slip:.4f}" for slip in results)] for start, results in slips.items()]
    head = ["gravity", *(f"φ {38.0 + offset:g}°" for offset in offsets)]
    return Outcome(rows, figure, [Table("Slip of the crest, m", head, cells)])
