# SPDX-License-Identifier: GPL-3.0-or-later
"""Cables over points of several blocks: an Atwood machine, and a block in a sling."""

import math

import numpy as np
from scipy.optimize import brentq

from sitedda.engine.checking import modes
from sitedda.facade.model import Model
from sitedda.report.style import BLUE, RED, canvas

from ..case import Outcome, at_most, case, relative
from ..model import GRAVITY, energy_residual

STIFFNESS = 1.0e6  # N/m
HEAVY, LIGHT = 6000.0, 2000.0  # kg/m
TENSION = 2.0 * GRAVITY * HEAVY * LIGHT / (HEAVY + LIGHT)  # cable force in steady motion, N/m
HALF_SPAN, DROP = 3.0, 4.0  # geometry of the sling, m
PRETENSION = 1.0e4  # pretension of the sling, N/m


def square(x: float, y: float, side: float = 1.0) -> list[tuple[float, float]]:
    """Return the vertices of a square about a centre, m."""
    half = 0.5 * side
    return [(x + a * half, y + b * half) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]


def stiff_model(title: str, **control) -> Model:
    """Return a model of blocks with negligible strains."""
    model = Model(title, gravity=(0.0, -GRAVITY), **control)
    model.contact(normal_stiffness=1e11)
    model.material("light", density=LIGHT, young_modulus=1e14, poisson_ratio=0.0)
    model.material("heavy", density=HEAVY, young_modulus=1e14, poisson_ratio=0.0)
    model.joint("joint", friction_angle=30.0)
    return model


def atwood(steps: int | None = 2000, time_step: float = 1e-4, **cable) -> Model:
    """Return an Atwood machine: two blocks on a cable over two points of a fixed beam."""
    model = stiff_model("Machine of Atwood", time_step=time_step, steps=steps)
    model.output(history_interval=10)
    model.block([(-3, 9), (3, 9), (3, 10), (-3, 10)], name="beam", material="light")
    for x in (-3.0, 3.0):
        model.fixed_point(x, 10.0, "beam")
    model.block(square(-2, 2), name="left", material="heavy")
    model.block(square(2, 2), name="right", material="light")
    model.measured_point("left", -2.0, 2.0)
    model.measured_point("right", 2.0, 2.0)
    values = {"axial_stiffness": STIFFNESS, "through": [(-2, 9.5), (2, 9.5)]} | cable
    model.bolt("cable", (-2, 2), (2, 2), **values)
    return model


def atwood_force(time: np.ndarray, time_step: float) -> np.ndarray:
    """Return the cable force after sudden gravity, T (1 − cos ωt) with damping ωΔt/4, N/m."""
    omega = atwood_frequency()
    return TENSION * (1.0 - np.exp(-0.25 * omega**2 * time_step * time) * np.cos(omega * time))


def atwood_frequency() -> float:
    """Return ω of the elastic mode, ω² = k (m₁ + m₂)/(m₁ m₂), rad/s."""
    return math.sqrt(STIFFNESS * (HEAVY + LIGHT) / (HEAVY * LIGHT))


def sling(**control) -> Model:
    """Return a block on a cable with fixed ends, which slides through the block."""
    model = stiff_model("Sling", time_step=1e-3, settle=True, steps=1, **control)
    for name, x in (("left", -HALF_SPAN), ("right", HALF_SPAN)):
        model.block(square(x, DROP), name=name, material="light")
        for dx in (-0.5, 0.5):
            model.fixed_point(x + dx, DROP + 0.5, name)
    model.block(square(0, 0), name="hung", material="light")
    model.measured_point("hung", 0.0, 0.0)
    ends, path = ((-HALF_SPAN, DROP), (HALF_SPAN, DROP)), {"through": [(0, 0)]}
    model.bolt("cable", *ends, **path, through_block=["hung"], axial_stiffness=STIFFNESS,
               pretension=PRETENSION)  # fmt: skip
    return model


def sling_at_rest() -> tuple[float, float]:
    """Return sag (m) and tension N (N/m) of the sling: W = 2 N cos β, N = N₀ + k ΔL."""
    initial_length = math.hypot(HALF_SPAN, DROP)

    def tension(sag: float) -> float:
        return PRETENSION + 2.0 * STIFFNESS * (math.hypot(HALF_SPAN, DROP + sag) - initial_length)

    def unbalanced(sag: float) -> float:
        cosine = (DROP + sag) / math.hypot(HALF_SPAN, DROP + sag)
        return 2.0 * tension(sag) * cosine - LIGHT * GRAVITY

    sag = brentq(unbalanced, -1.0, 1.0, xtol=1e-15)
    return sag, tension(sag)


def sling_frequencies() -> tuple[float, float]:
    """Return the horizontal and vertical frequency of the sling, Hz."""
    sag, tension = sling_at_rest()
    length = math.hypot(HALF_SPAN, DROP + sag)
    cosine = (DROP + sag) / length
    horizontal = 2.0 * tension / length * cosine**2
    vertical = 4.0 * STIFFNESS * cosine**2 + 2.0 * tension / length * (1.0 - cosine**2)
    return tuple(math.sqrt(k / LIGHT) / (2.0 * math.pi) for k in (horizontal, vertical))


@case(
    "Cables that pass blocks: a machine of Atwood and a sling",
    "Atwood machine: a = g (m₁ - m₂)/(m₁ + m₂) and N = T (1 - cos ωt) with T = 2 g m₁ m₂/(m₁ + "
    "m₂), ω² = k (m₁ + m₂)/(m₁ m₂) and the damping ratio ωΔt/4. Sling: W = 2 N cos β, and the "
    "horizontal frequency is given by ω² = 2 N cos²β/(L m).",
    "Statics and dynamics of a string without mass and friction.",
)
def cables_case(short: bool) -> Outcome:
    """Check acceleration, forces and frequencies."""
    steps = 1000 if short else 4000
    steady = atwood(steps, pretension=TENSION).run().history
    speed = float(steady.velocity[-1].sel(point="right", axis="y"))
    expected = GRAVITY * (HEAVY - LIGHT) / (HEAVY + LIGHT)
    sudden = atwood(steps).run().history
    time, force = sudden.time.values, sudden.bolt_force.values[:, 0]
    exact = atwood_force(time, 1e-4)
    at_rest = sling().run().history
    sag, tension = sling_at_rest()
    frequencies = modes(sling(), count=6).frequency
    rows = [
        relative("acceleration of the machine of Atwood", expected, speed / float(steady.time[-1]),
            1e-5, "m/s²"),
        at_most("largest error of the cable force / T", abs(force - exact).max() / TENSION, 1e-3),
        relative("cable force of the sling", tension, float(at_rest.bolt_force[-1, 0]), 1e-6,
            "N/m"),
        relative("sag of the sling", sag, -float(at_rest.block_coordinates[-1, 2, 1]), 1e-5, "m"),
    ]  # fmt: skip
    for direction, frequency in zip(("horizontal", "vertical"), sling_frequencies(), strict=True):
        nearest = frequencies[np.argmin(abs(frequencies - frequency))]
        rows.append(relative(f"{direction} frequency of the sling", frequency, nearest, 1e-4, "Hz"))
    rows.append(at_most("energy residual / work",
        max(energy_residual(steady), energy_residual(sudden)), 1e-6))  # fmt: skip
    figure, axes = canvas(1, size=(5.6, 3.6))
    axes[0].plot(time, exact / 1e3, color=RED, lw=2.5, alpha=0.5, label="closed form")
    axes[0].plot(time, force / 1e3, color=BLUE, lw=1.0, label="engine")
    axes[0].set(xlabel="time (s)", ylabel="cable force (kN/m)")
    return Outcome(rows, figure)
