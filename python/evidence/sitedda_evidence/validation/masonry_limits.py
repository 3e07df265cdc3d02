# SPDX-License-Identifier: GPL-3.0-or-later
"""Limits of masonry: friction of an arch, and inclination of walls on a tilting table."""

import math
from functools import partial

import numpy as np

from sitedda.facade.model import Model
from sitedda.report.style import GROUND, STONE, bare, canvas, draw_blocks
from sitedda.stability import bisect

from ..case import Outcome, at_most, case, true
from ..model import GRAVITY, rectangle
from .slopes import is_stable, rest_of
from .stability import half_circle

TILT = {(3, 6): 30.862, (4, 12): 26.458}  # bricks × courses: upper limit of the angle, degrees
FRICTION = 0.65  # friction coefficient of the walls
MOVED = 5e-3  # displacement of a vertex that counts as collapse, m


def arch(friction: float, thickness: float) -> Model:
    """Return a half-circle arch of 27 voussoirs; `thickness` is a fraction of the radius."""
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
    "An arch of 27 voussoirs with t/R = 0.112 stands for μ ≥ 0.40, for which 0.10672 suffices. "
    "It falls for μ = 0.30, for which no thickness is sufficient (linear programme).",
    "Limit analysis with friction, by linear programming.",
)
def arch_friction(short: bool) -> Outcome:
    """Check that the arch stands at μ = 0.40 and collapses at 0.30."""
    high = rest_of(arch(0.40, 0.112))
    rows = [
        true("t/R 0.112 stands at μ 0.40", True, high is not None and high.moved < 1e-3),
        true("t/R 0.112 stands at μ 0.30", False, is_stable(arch(0.30, 0.112), MOVED)),
    ]
    if not short:
        got = is_stable(arch(0.4, 0.105), MOVED)
        rows.append(true("t/R 0.105 stands at μ 0.40", False, got))
    figure, axes = canvas(1, size=(6, 3.6))
    draw_blocks(axes[0], high.polygons if high else [], STONE)
    bare(axes[0])
    return Outcome(rows, figure)


def _is_wall_stable(bricks: int, courses: int, angle: float) -> bool:
    return is_stable(tilted_wall(bricks, courses, angle), MOVED)


@case(
    "Dry walls in running bond on a tilting table",
    "Bricks 2 : 1, μ = 0.65: limit analysis with associated sliding gives 30.862° for 3 bricks × 6 "
    "courses and 26.458° for 4 × 12, upper limits for friction that does not dilate.",
    "Limit analysis by linear programming.",
)
def tilting_wall(short: bool) -> Outcome:
    """Check the angle at which walls collapse."""
    rows = []
    figure, axes = canvas(2, size=(9, 4))
    for at, (size, limit) in zip(axes, TILT.items(), strict=True):
        if short and size != (3, 6):
            continue
        holds = partial(_is_wall_stable, *size)
        low, high = 0.95 * limit, limit
        if short:
            low, high = (low if holds(low) else 0.0), (2 * limit if holds(high) else high)
        else:
            low, high = bisect(holds, 0.85 * limit, 1.05 * limit, 1e-3)
        words = f"{size[0]} bricks × {size[1]} courses"
        rows.append(at_most(f"{words}: angle over its upper limit", high / limit, 1.0))
        rows.append(at_most(f"{words}: relative distance below it", 1.0 - low / limit, 0.06))
        rest = rest_of(tilted_wall(*size, low))
        rested = rest is not None and rest.moved < MOVED
        rows.append(true(f"{words}: rests at the lower angle", True, rested))
        if rest is None:
            continue
        turn = math.radians(low)
        c, s = np.cos(turn), np.sin(turn)
        draw_blocks(at, [p @ np.array([[c, -s], [s, c]]) for p in rest.polygons],
                    [GROUND, *[STONE] * (len(rest.polygons) - 1)])  # fmt: skip
        at.set_title(f"{words}: {low:.2f}°")
    for at in axes:
        bare(at)
    return Outcome(rows, figure)
