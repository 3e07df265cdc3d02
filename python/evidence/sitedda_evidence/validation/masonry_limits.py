# SPDX-License-Identifier: GPL-3.0-or-later
"""Limits of masonry: friction of an arch, and inclination of walls on a tilting table."""

import math
from functools import partial

import numpy as np

from sitedda.facade.model import Model
from sitedda.report.style import GROUND, STONE, bare, canvas, draw_blocks
from sitedda.stability import bisect

from ..case import Outcome, at_most, case, yes_or_no
from ..model import GRAVITY, rectangle
from .slopes import is_stable, rest_of
from .stability import half_circle

TILT = {(3, 6): 30.862, (4, 12): 26.458}  # bricks × courses: upper limit of the angle, degrees
FRICTION = 0.65  # friction coefficient of the walls
COLLAPSE = 5e-3  # displacement of a vertex that counts as collapse, m


def arch(friction: float, thickness: float) -> Model:
    """Return a semicircular arch of 27 voussoirs; `thickness` is a fraction of the radius."""
    model = half_circle(27, thickness, friction)
    model.contact(normal_stiffness=1e11, shear_ratio=0.1)
    return model


def tilted_wall(bricks: int, courses: int, angle: float) -> Model:
    """Return a dry wall of bricks 2 : 1 on a tilted table (degrees), in axes of the table."""
    tilt = math.radians(angle)
    model = Model("Wall on a tilting table", time_step=1e-2)
    model.control(gravity=(GRAVITY * math.sin(tilt), -GRAVITY * math.cos(tilt)))
    model.contact(normal_stiffness=1e11, shear_ratio=0.1)
    model.material("stone", density=2000.0, young_modulus=1e12, poisson_ratio=0.0)
    model.joint("dry", friction_angle=math.degrees(math.atan(FRICTION)))
    model.block(rectangle(-1.0, -0.1, 0.2 * bricks + 2.0, 0.1), name="table")
    model.wall(brick_length=0.2, brick_height=0.1, bricks=bricks, courses=courses)
    model.fixed_point(-1.0, -0.1)
    model.fixed_point(0.2 * bricks + 1.0, -0.1)
    return model


@case(
    "A half-circle arch held by friction",
    "An arch of 27 voussoirs with t/R = 0.112 stands for μ = 0.40; limit analysis requires"
    " 0.10672. It falls for μ = 0.30, for which limit analysis finds no sufficient thickness.",
    "Limit analysis with friction, by linear programming.",
)
def arch_friction(short: bool) -> Outcome:
    """Check that the arch stands at μ = 0.40 and collapses at 0.30."""
    equilibrium = rest_of(arch(0.40, 0.112))
    rows = [
        yes_or_no("the arch stands with t/R = 0.112, μ = 0.40", True,
            equilibrium is not None and equilibrium.displacement < 1e-3),
        yes_or_no("the arch stands with t/R = 0.112, μ = 0.30", False,
            is_stable(arch(0.30, 0.112), COLLAPSE)),
    ]  # fmt: skip
    if not short:
        stands = is_stable(arch(0.4, 0.105), COLLAPSE)
        rows.append(yes_or_no("t/R 0.105 stands at μ 0.40", False, stands))
    figure, axes = canvas(1, size=(6, 3.6))
    draw_blocks(axes[0], equilibrium.polygons if equilibrium else [], STONE)
    bare(axes[0])
    return Outcome(rows, figure)


def _is_wall_stable(bricks: int, courses: int, angle: float) -> bool:
    return is_stable(tilted_wall(bricks, courses, angle), COLLAPSE)


@case(
    "Dry walls in running bond on a tilting table",
    "The bricks are 2 : 1, μ = 0.65. Limit analysis with dilation yields 30.862° for 3 bricks × 6 "
    "courses and 26.458° for 4 × 12. These are upper limits for friction without dilation.",
    "Limit analysis by linear programming.",
)
def tilting_wall(short: bool) -> Outcome:
    """Check the angle at which walls collapse."""
    rows = []
    figure, axes = canvas(2, size=(9, 4))
    for axis, (size, limit) in zip(axes, TILT.items(), strict=True):
        if short and size != (3, 6):
            continue
        is_stable = partial(_is_wall_stable, *size)
        low, high = 0.95 * limit, limit
        if short:
            low, high = (low if is_stable(low) else 0.0), (2 * limit if is_stable(high) else high)
        else:
            low, high = bisect(is_stable, 0.85 * limit, 1.05 * limit, 1e-3)
        name = f"{size[0]} bricks × {size[1]} courses"
        rows.append(at_most(f"{name}: smallest angle of collapse / upper limit", high / limit, 1.0))
        rows.append(at_most(f"{name}: 1 − largest stable angle / upper limit", 1.0 - low / limit,
            0.06))  # fmt: skip
        equilibrium = rest_of(tilted_wall(*size, low))
        is_at_rest = equilibrium is not None and equilibrium.displacement < COLLAPSE
        rows.append(yes_or_no(f"{name}: the wall is at rest at the largest stable angle", True,
            is_at_rest))  # fmt: skip
        if equilibrium is None:
            continue
        tilt = math.radians(low)
        c, s = np.cos(tilt), np.sin(tilt)
        draw_blocks(axis, [p @ np.array([[c, -s], [s, c]]) for p in equilibrium.polygons],
                    [GROUND, *[STONE] * (len(equilibrium.polygons) - 1)])  # fmt: skip
        axis.set_title(f"{name}: {low:.2f}°")
    for axis in axes:
        bare(axis)
    return Outcome(rows, figure)
