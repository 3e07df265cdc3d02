# SPDX-License-Identifier: GPL-3.0-or-later
"""Cases with published results: see `docs/casebook`."""

from itertools import pairwise

import numpy as np

from sitedda.base.errors import InputError
from sitedda.engine.simulation import Simulation
from sitedda.facade.model import Model
from sitedda.report.style import GROUND, STONE, bare, canvas, draw_blocks
from sitedda.stability.capacity import pushover
from sitedda.stability.limits import limit_analysis
from sitedda.stability.reduction import bisect

from ..case import Outcome, absolute, at_most, case, relative, yes_or_no
from ..model import GRAVITY, rectangle
from .rocking import run_tower, tower_text
from .slopes import single_block
from .stability import half_circle

THINNEST = {"radial": 0.1075, "vertical": 0.1095}  # smallest t/R by direction of the cuts
ROUGH = 5.0  # friction coefficient without slip
WITH_FRICTION = {0.325: 0.178, 0.35: 0.152, 0.375: 0.126, 0.5: 0.106}  # smallest t/R by friction
PSI = np.radians(40.0)
STATES = {(10.0, 40.1): "stable", (5.0, 20.0): "slides", (25.0, 40.0): "topples"}
MEASURED = {3: 0.97, 5: 0.95}  # velocity ratio / rigid theory, by height / width


@case(
    "The thinnest half-circle arch with radial and vertical cuts",
    "Rigid blocks under self-weight, without tension and sliding, have the minimum thickness "
    "t/R = 0.1075 with radial cuts and 0.1095 with vertical cuts. With 120 stones, straight sides "
    "instead of arcs change t/R by 0.0001.",
    "`docs/casebook/arch.md`.",
)
def arch_stereotomy(short: bool) -> Outcome:
    """Check both thicknesses by limit analysis to the published digits."""
    count, allowed = (40, 4e-4) if short else (160, 1.5e-4)
    rows, (figure, axes) = [], canvas(2, size=(9, 3))
    for axis, (cuts, published) in zip(axes, THINNEST.items(), strict=True):
        low, high = _find_thinnest(cuts, ROUGH, count, (0.111, 0.106), 1e-3 if short else 1e-4)
        rows.append(absolute(f"smallest thickness / radius, {cuts} cuts", published,
            0.5 * (low + high), allowed))  # fmt: skip
        polygons = limit_analysis(half_circle(count, low, ROUGH, cuts)).lower.polygons
        draw_blocks(axis, polygons, [GROUND, *[STONE] * (len(polygons) - 1)])
        axis.set_title(f"{cuts}: t/R = {low:.4f}")
        bare(axis)
    return Outcome(rows, figure)


@case(
    "The thinnest half-circle arch for several friction coefficients",
    "The arch has 27 rigid stones with radial cuts, without tension and dilation. Its smallest t/R "
    "for several friction coefficients agrees with a published figure within 0.002. Below the "
    "coefficient 0.309 ± 0.001, no arch is stable.",
    "`docs/casebook/arch.md`.",
)
def arch_by_friction(short: bool) -> Outcome:
    """Check the curve and its end by limit analysis without dilation."""
    rows, computed, (figure, (axis,)) = [], [], canvas(1, size=(5, 3))
    published = list(WITH_FRICTION.items())[:: 2 if short else 1]
    for friction, expected in published:
        bracket = _find_thinnest("radial", friction, 27, (0.2, 0.1), 1e-3 if short else 1e-4)
        computed.append(0.5 * sum(bracket))
        rows.append(absolute(f"smallest thickness / radius, μ = {friction:g}", expected,
            computed[-1], 2e-3))  # fmt: skip
    low, high = bisect(lambda mu: _is_arch_stable(0.45, "radial", mu, 27), 0.35, 0.28, 1e-3)
    rows.append(absolute("smallest friction coefficient of a stable arch", 0.309,
        0.5 * (low + high), 1e-3))  # fmt: skip
    axis.plot(*np.transpose(published), "o", label="published")
    axis.plot([friction for friction, _ in published], computed, label="sitedda")
    axis.set(xlabel="coefficient of friction", ylabel="smallest t/R", ylim=(0, None))
    return Outcome(rows, figure)


def _find_thinnest(cuts: str, friction: float, stones: int, bracket, tolerance: float):
    """Return a bracket of the smallest t/R at which the arch is stable."""
    return bisect(lambda t: _is_arch_stable(t, cuts, friction, stones), *bracket, tolerance)


def _is_arch_stable(thickness: float, cuts: str, friction: float, stones: int) -> bool:
    try:
        return limit_analysis(half_circle(stones, thickness, friction, cuts)).lower.factor > 0
    except InputError:  # no forces are in equilibrium
        return False


@case(
    "A dry wall under horizontal load",
    "Six courses of stones of 0.4 × 0.175 m, friction coefficient 0.65: the limit load is 0.64 of "
    "the weight.",
    "`docs/casebook/wall.md`.",
)
def pushed_wall(short: bool) -> Outcome:
    """Check limit analysis to the published digits, and a pushover between its limits."""
    wall = _make_wall()
    limits = limit_analysis(wall)
    curve = pushover(wall, "top", displacement=0.01 if short else 0.03, steps=60)
    low, high = limits.lower.factor, limits.upper.factor
    rows = [
        absolute("limit load / weight, without dilation", 0.64, low, 5e-3),
        absolute("largest load of the pushover / weight, between both limits", 0.5 * (low + high),
            curve.peak, 0.5 * (high - low) + 1e-3),
    ]  # fmt: skip
    return Outcome(rows, curve.draw(limits))


def _make_wall() -> Model:
    """Return a wall of 2 × 1.05 m in running bond."""
    model = Model("wall", time_step=1e-3, gravity=(0.0, -GRAVITY))
    model.material("stone", density=1000.0, young_modulus=1e10, poisson_ratio=0.2)
    model.joint("dry", friction_angle=float(np.degrees(np.arctan(0.65))))
    model.block(rectangle(-1.0, -0.5, 4.0, 0.5), name="ground")
    model.boundary(kind="fixed", blocks="ground", side="bottom")
    for course in range(6):
        ends = np.arange(0, 2.1, 0.4) if course % 2 else np.array([0, 0.2, 0.6, 1, 1.4, 1.8, 2])
        for left, right in pairwise(ends):
            model.block(rectangle(left, 0.175 * course, right - left, 0.175))
    model.measured_point("top", 1.99, 1.04)
    return model


@case(
    "A block on a slope of 40°: stable, sliding, toppling",
    "Width 10 m, height y, friction angle φ: with y = 10 m and φ = 40.1° the block is stable, with "
    "5 m and 20° it slides by ½ g (sin ψ − cos ψ tan φ) t², with 25 m and 40° it topples.",
    "`docs/casebook/slope.md`.",
)
def block_on_slope(short: bool) -> Outcome:
    """Check every published state and the displacement of the sliding block."""
    rows, (figure, axes) = [], canvas(3, size=(9, 3))
    for axis, ((height, friction), published) in zip(axes, STATES.items(), strict=True):
        duration = 1.0 if short else 2.0
        displacement, rotation, polygons = _run_released_block(height, friction, duration)
        state = "topples" if rotation > 0.05 else "slides" if displacement > 1.0 else "stable"
        rows.append(yes_or_no(f"state with y = {height:g} m, φ = {friction:g}°: {published}", True,
            state == published))  # fmt: skip
        if published == "slides":
            acceleration = np.sin(PSI) - np.cos(PSI) * np.tan(np.radians(friction))
            slip = 0.5 * 10.0 * acceleration * duration**2
            rows.append(relative("displacement of the sliding block", slip, displacement, 1e-6,
                "m"))  # fmt: skip
        draw_blocks(axis, polygons, STONE)
        axis.set_title(state)
        bare(axis)
    return Outcome(rows, figure)


def _run_released_block(height: float, friction: float, duration: float):
    """Release a block; return displacement (m) and clockwise rotation (rad), and polygons."""
    model = single_block(friction, float(np.degrees(PSI)), 10.0, height)
    model.control(time_step=1e-3)
    model.joint("glue", friction_angle=80.0, cohesion=1e9, tensile_strength=1e9)
    for block in model["block"]:
        block.joint = "glue"
    model.stage("rest", kind="static")
    model.stage("let_go", duration=duration, change_joints="glue -> joint")
    with Simulation(model) as simulation:
        start = simulation.coordinates[1].copy()
        while not simulation.advance(100):
            pass
        x, _, rotation = (simulation.coordinates[1] - start)[:3]
        return float(x), -float(rotation), simulation.polygons


@case(
    "Angular velocity of a rocking block after an impact",
    "The ratio of angular velocities after and before an impact is 1 − 1.5 sin² α in rigid theory, "
    "α = arctan(width/height), with restitution 0. Ratios measured on concrete are 0.97 of this "
    "value at a height of 3 widths and 0.95 at 5 widths.",
    "`docs/casebook/rocking.md`.",
)
def rocking_share(short: bool) -> Outcome:
    """Check the velocity ratio: rigid theory within 0.15 %, measured values within 6 %."""
    rows, (figure, axes) = [], canvas(2, size=(6, 3))
    for axis, (slenderness, measured) in zip(axes, MEASURED.items(), strict=True):
        alpha = np.arctan(1 / slenderness)
        theory = 1 - 1.5 * np.sin(alpha) ** 2
        ratio, time, angle = _simulate_first_impact(slenderness)
        rows.append(relative(f"ratio of angular velocities, height of {slenderness} widths", theory,
            ratio, 1.5e-3))  # fmt: skip
        rows.append(at_most(f"(computed − measured ratio) / theory, height of {slenderness} widths",
            ratio / theory - measured, 0.06))  # fmt: skip
        axis.plot(time, angle / alpha)
        axis.set(xlabel="time (s)", ylabel="angle / α", title=f"height of {slenderness} widths")
    return Outcome(rows, figure)


def _simulate_first_impact(slenderness: int):
    """Return the ratio of angular velocities at the first impact, times (s) and angles (rad)."""
    width, alpha = 1.0 / slenderness, np.arctan(1 / slenderness)
    tilt = 0.5 * alpha
    contact = {"penalty": 1e11, "restitution": 0.0}
    text = tower_text(2e-4, 1.5, tilt, size=(width, 1.0), integration="theta", **contact)
    time, angle, _ = run_tower(text, tilt, 5)
    energy = np.cos(alpha - np.array([tilt, abs(min(angle))])) - np.cos(alpha)
    return float(np.sqrt(energy[1] / energy[0])), time, angle
