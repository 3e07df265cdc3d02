# SPDX-License-Identifier: GPL-3.0-or-later
"""Pushover beyond the peak: a rocking or sliding block, and walls with openings."""

import math

import numpy as np

from sitedda.facade.model import Model
from sitedda.report.style import BLUE, ORANGE, canvas
from sitedda.stability.capacity import pushover
from sitedda.stability.limits import limit_analysis

from ..case import Outcome, absolute, at_most, case, curves, relative, yes_or_no

WIDTH, HEIGHT = 0.5, 2.0


def tower(friction=40.0) -> Model:
    """Return a block on a fixed floor."""
    model = Model("tower", time_step=1e-3, steps=1, gravity=(0, -9.81))
    model.contact(normal_stiffness=1e10)
    model.material("stone", density=2500.0, young_modulus=1e11, poisson_ratio=0.2)
    model.joint("dry", friction_angle=friction)
    model.block([-3, -1, 3, -1, 3, 0, -3, 0], name="floor")
    model.block([0, 0, WIDTH, 0, WIDTH, HEIGHT, 0, HEIGHT], name="tower")
    for x, y in ((-2.5, -0.5), (2.5, -0.5), (0, -0.9)):
        model.fixed_point(x, y)
    model.measured_point("top", WIDTH / 2, HEIGHT, "tower")
    return model


@case(
    "A block loaded until it topples or slides",
    "If a block rotates by θ about its corner, λ = tan(α − θ) decreases from tan α = b/h to 0. If "
    "tan φ < b/h, the block slides at λ = tan φ, and friction dissipates all work.",
    "Statics of a rigid block.",
)
def pushed_block(short: bool) -> Outcome:
    """Check peak, curve and verdict of each kind of load."""
    rows, rotation = [], np.linspace(0, 0.5, 5000)
    displacement = -WIDTH / 2 * (np.cos(rotation) - 1) + HEIGHT * np.sin(rotation)
    pushes = [(load, sense) for load in ("horizontal", "tilt", "mode") for sense in (1, -1)]
    for load, sense in pushes:
        curve = pushover(tower(), "top", load=load, sense=sense, displacement=0.6, steps=60)
        rocking, name = curve.displacement > 1e-3, f"{load}, {sense:+d}"
        angle = np.interp(curve.displacement[rocking], displacement, rotation)
        exact = np.tan(math.atan(WIDTH / HEIGHT) - angle)
        rows += [
            relative(f"{name}: largest λ", WIDTH / HEIGHT, curve.peak, 2e-3),
            at_most(f"{name}: largest error of λ", abs(curve.factor[rocking] - exact).max(), 1e-3),
            yes_or_no(f"{name}: the block topples", True, curve.verdicts == ("stable", "topples")),
            yes_or_no(f"{name}: the curve ends with collapse", True,
                curve.factor[-1] <= 0 and "collapse" in curve.ending),
            at_most(f"{name}: work of friction / work of the load",
                abs(curve.friction[-1] / curve.work[-1]), 1e-4),
        ]  # fmt: skip
    sliding = pushover(tower(10.0), "top", displacement=0.2, steps=40)
    coefficient = math.tan(math.pi / 18)
    rows += [
        relative("sliding: largest λ", coefficient, sliding.peak, 2e-3),
        relative("sliding: λ at the end", coefficient, sliding.factor[-1], 2e-3),
        relative("sliding: work of friction / work of the load", 1.0,
                 sliding.friction[-1] / sliding.work[-1], 0.02),
        yes_or_no("sliding: in the direction of the load up to the target", True,
             sliding.verdicts == ("stable", "slides") and "target displacement" in sliding.ending),
    ]  # fmt: skip
    lines = [(curve.displacement, curve.factor, {"color": BLUE, "label": "rocks"}),
             (curve.displacement[rocking], exact, {"color": ORANGE, "ls": "--", "label": "exact"}),
             (sliding.displacement, sliding.factor, {"label": "slides"})]  # fmt: skip
    return Outcome(rows, curves("displacement of the top (m)", "λ", *lines))


def random_wall(seed: int) -> Model:
    """Return a random wall with a door; the seed determines bond, lintel or arch, and window."""
    rng = np.random.default_rng(seed)
    width, height = rng.uniform(3, 5), rng.uniform(2.2, 3.2)
    stone, door = rng.uniform(0.5, 0.8), rng.uniform(0.7, 1.0)
    model = Model("wall", time_step=1e-3, steps=1, gravity=(0, -9.81))
    model.material("stone", density=2500.0, young_modulus=1e11, poisson_ratio=0.2)
    model.block([-1, -0.5, width + 1, -0.5, width + 1, 0, -1, 0], name="floor")
    for x, y in ((-0.9, -0.25), (width + 0.9, -0.25), (width / 2, -0.4)):
        model.fixed_point(x, y, "floor")
    bond = ("running", "header", "rubble")[seed % 3]
    model.masonry_wall(width=width, height=height, courses=int(rng.integers(7, 11)), stone=stone,
                       bond=bond, seed=seed)  # fmt: skip
    model.opening("door", left=0.2 * width, width=door, height=0.6 * height, depth=0.3,
                  bearing=0.3, head=("lintel", "arch")[seed % 2])  # fmt: skip
    if seed % 4 > 1:
        model.opening("window", left=0.65 * width, bottom=0.3 * height, width=0.6,
                      height=0.3 * height, depth=0.3, bearing=0.25)  # fmt: skip
    model.joint("dry", friction_angle=math.degrees(math.atan(rng.uniform(0.4, 0.8))))
    model.measured_point("top", 0.5 * width + 0.01, height - 0.05)
    return model


@case(
    "Pushover of walls with openings beyond the peak",
    "Random walls have one of two bond patterns, and lintels or arches. The largest load lies "
    "between the limit loads without and with dilation, within 2 %.",
    "`docs/stability.md`.",
)
def pushed_walls(short: bool) -> Outcome:
    """Check that the peak of the pushover is between both limits."""
    rows, (figure, axes) = [], canvas(2, size=(9.0, 3.4))
    for seed, axis in zip((2, 3), axes, strict=True):
        model = random_wall(seed)
        limits, curve = limit_analysis(model), pushover(model, "top", displacement=0.02, steps=40)
        low, high = limits.lower.factor, limits.upper.factor
        middle, half = 0.5 * (0.98 * low + 1.02 * high), 0.5 * (1.02 * high - 0.98 * low)
        rows.append(absolute(f"wall {seed}: largest λ between both limits, ± 2 %", middle,
            curve.peak, half))  # fmt: skip
        axis.plot(curve.displacement, curve.factor)
        axis.axhspan(low, high, alpha=0.2)
        axis.set(xlabel="displacement of the top (m)", ylabel="λ", title=f"wall {seed}")
    return Outcome(rows, figure)
