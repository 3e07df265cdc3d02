# SPDX-License-Identifier: GPL-3.0-or-later
"""Error bars of a sliding block, which contain the exact slip."""

import math

from sitedda.report.style import canvas
from sitedda.study.error_bars import accuracy

from ..case import Outcome, absolute, at_most, case
from ..model import temporary_input

G = 9.81
FRICTION = 20.0  # degrees
PUSH, LAST = 6.0, 0.3  # acceleration of the base (m/s²) and its duration (s)

SLIDE = f"""
&control time_step = 2e-3, duration = 1.5, gravity = 0, {-G}, settle = .true.,
         base_motion_x = 'push' /
&material density = 2643, young_modulus = 5e9, poisson_ratio = 0.2 /
&joint friction_angle = {FRICTION}, restitution = 0 /
&block name = 'floor', vertices = -10 -1 10 -1 10 0 -10 0 /
&block name = 'block', vertices = -1 0 1 0 1 1 -1 1 /
&fixed_point x = -10, y = -1, block = 'floor' /
&fixed_point x = 10, y = -1, block = 'floor' /
&fixed_point x = -10, y = 0, block = 'floor' /
&motion name = 'push', quantity = 'acceleration', drift_order = 0, time_step = 0.01,
        values = 30*{PUSH} 200*0 /
"""


def slip() -> float:
    """Return the exact slip of a rigid block, m (Newmark)."""
    deceleration, ramp = G * math.tan(math.radians(FRICTION)), 0.01
    duration = LAST - ramp
    speed = (PUSH - deceleration) * duration
    distance = 0.5 * speed * duration + speed * ramp
    distance += (PUSH / 3.0 - 0.5 * deceleration) * ramp**2
    speed += 0.5 * PUSH * ramp - deceleration * ramp
    return distance + 0.5 * speed**2 / deceleration


@case(
    "Error bars of a block that slides",
    "The exact slip is by Newmark's equation of a rigid block under a pulse that decreases to zero "
    "in its last interval. Error bars are from runs with Δt, Δt/2, Δt/4, a stiffer contact and a "
    "displaced block.",
    "Newmark (1965); docs/accuracy.md.",
)
def error_bars(short: bool) -> Outcome:
    """Check that the error bar contains the exact slip and is less than 5 % of it."""
    with temporary_input(SLIDE) as file:
        results = accuracy(file, folder=file.parent / "runs")
    rows, (figure, (axis,)) = [], canvas(1, size=(5.0, 3.0))
    for name in ("largest_slip_m", "residual_displacement_m"):
        slip_value, bar = results[name].finest, results[name].bar
        rows.append(absolute(f"{name}: exact slip within the error bar", slip(), slip_value, bar,
            "m"))  # fmt: skip
        rows.append(at_most(f"{name}: error bar / slip", bar / slip(), 0.05))
        axis.errorbar(name, slip_value, bar, fmt="o", capsize=4)
    axis.axhline(slip(), ls="--", label="rigid block")
    axis.set_ylabel("slip (m)")
    return Outcome(rows, figure)
