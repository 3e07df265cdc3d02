# SPDX-License-Identifier: GPL-3.0-or-later
"""Half-spaces beyond a boundary: incident waves, and reflection at dashpots."""

from itertools import pairwise

import numpy as np

from sitedda.engine.checking import transfer
from sitedda.facade.model import Model
from sitedda.report.style import BLUE, RED, canvas

from ..case import Outcome, at_most, case, relative
from ..model import GRAVITY

DENSITY, SPEED, POISSON = 1800.0, 200.0, 0.25  # soil: kg/m³, m/s, –
ROCK = {"density": 2200.0, "shear_velocity": 800.0, "pressure_velocity": 1500.0}


def _layered_model(layers: int, height: float, penalty: float, time_step: float) -> Model:
    """Return layers of soil between rollers on a half-space of rock."""
    young = 2 * DENSITY * SPEED**2 * (1 + POISSON)
    control = {"integration": "midpoint", "analysis": "plane_strain"}
    model = Model("layers", time_step=time_step, steps=1, **control)
    model.contact(normal_stiffness=penalty * young)
    model.material("soil", density=DENSITY, young_modulus=young, poisson_ratio=POISSON)
    model.joint("glue", friction_angle=40.0, cohesion=1e12, tensile_strength=1e12)
    model.layers("layer", width=1.0, thickness=height / layers, count=layers)
    model.boundary("base", "compliant", side="bottom", **ROCK)
    for side in ("left", "right"):
        model.boundary(side=side, kind="roller", direction="y")
    model.measured_point("surface", 0.5, height)
    return model


@case(
    "A layer on an elastic half-space",
    "The ratio of surface and outcrop motion is 1/|cos kH + i a sin kH| with a = ρ_sV_s/ρ_rV_r."
    " The error of blocks of thickness h is proportional to h². Dashpots with the impedance of the"
    " blocks reflect the fraction |(Z(e^iqh) + ikh)/(Z(e^−iqh) + ikh)| of the amplitude, about"
    " (kh)²/48, where Z(e) = 1 − e − (kh)²(2 + e)/6, cos qh = (6 − 2(kh)²)/(6 + (kh)²) and kh ="
    " 2πh/λ.",
    "Kramer (1996), §7.2.1; Lysmer and Kuhlemeyer (1969); `docs/boundaries.md`.",
)
def half_space(short: bool) -> Outcome:
    """Check transfer functions of 10, 20 and 40 layers, and reflections at four wavelengths."""
    height = 20.0
    ratio = DENSITY * SPEED / (ROCK["density"] * ROCK["shear_velocity"])
    frequencies = np.linspace(0.5, 5.0, 19 if short else 91)
    phase = 2 * np.pi * frequencies * height / SPEED
    exact = 1 / abs(np.cos(phase) + 1j * ratio * np.sin(phase))
    figure, (axes,) = canvas(1)
    axes.plot(frequencies, exact, color=BLUE, label="closed form")
    rows, errors = [], []
    for layers, allowed in ((10, 0.01), (20, 3e-3), (40, 1e-3)):
        computed = abs(transfer(_layered_model(layers, height, 2e5, 1e-4), frequencies, base=None))
        errors.append(max(abs(computed - exact)) / max(exact))
        rows.append(at_most(f"{layers} layers: largest error / peak of the amplification",
            errors[-1], allowed))  # fmt: skip
    for coarse, fine in pairwise(errors):
        rows.append(relative("order of convergence of the amplification", 2.0,
            float(np.log2(coarse / fine)), 0.1))  # fmt: skip
    axes.plot(frequencies, computed, ".", color=RED, label="40 layers")
    axes.set(xlabel="frequency (Hz)", ylabel="surface / outcrop motion")
    for length in (8, 20) if short else (8, 12, 20, 32):
        number = 2 * np.pi / length
        factor_e = np.exp(1j * _discrete_phase(number))
        incident_force, reflected_force = (
            _face_force(number, factor) + 1j * number for factor in (factor_e, 1 / factor_e)
        )
        computed = _measure_reflection(length)
        rows.append(relative(f"reflected / incident amplitude, λ/h = {length}",
            abs(incident_force / reflected_force), computed, 0.01))  # fmt: skip
    return Outcome(rows, figure)


def _discrete_phase(number):
    """Return wave number × thickness in blocks; `number` is that in a continuum."""
    return np.arccos((6 - 2 * number**2) / (6 + number**2))


def _face_force(number: float, factor: complex) -> complex:
    """Return force on the outer face / (G/h × displacement) of a block; `factor` is e^iqh."""
    return 1 - factor - number**2 * (2 + factor) / 6


def _measure_reflection(length: float, layers: int = 80) -> float:
    """Return the reflection coefficient of matched dashpots from ripples of the amplitude."""
    model = _layered_model(layers, float(layers), 2e5, 1e-6)
    model["boundary"][0](density=DENSITY, shear_velocity=SPEED, pressure_velocity=None)
    centre, width = SPEED / length, SPEED / 2 / layers
    frequencies = centre + width * np.linspace(-0.5, 0.5, 41)
    amplitude = abs(transfer(model, frequencies, base=None))
    phase = 2 * layers * _discrete_phase(2 * np.pi * frequencies / SPEED)
    ratio = frequencies / centre
    terms = [ratio**2 * np.cos(phase), ratio**2 * np.sin(phase), np.ones_like(ratio), ratio - 1]
    ripple = np.linalg.lstsq(np.column_stack(terms), amplitude, rcond=None)[0]
    return float(np.hypot(*ripple[:2]) / ripple[2])


@case(
    "A pulse in rock on a half-space of the same rock",
    "A wave of 1 g enters through the base, is doubled at the surface and leaves through the base. "
    "The peak acceleration is 1 g at the base for both passages and 2 g at the surface.",
    "`docs/boundaries.md`.",
)
def pulse(short: bool) -> Outcome:
    """Check peaks of a Ricker wavelet of 10 Hz in 140 m (short: 35 m) of rock."""
    height, step = (35.0 if short else 140.0), 1e-3
    young, poisson, density = 3e9, 0.3, 2100.0
    speed = np.sqrt(young / (2 * (1 + poisson) * density))
    model = Model("pulse", time_step=step, duration=0.45 + 2 * height / speed + 0.1)
    model.control(analysis="plane_strain", integration="midpoint")
    model.contact(normal_stiffness=2000 * young)
    model.material("rock", density=density, young_modulus=young, poisson_ratio=poisson)
    model.joint("glue", friction_angle=40.0, cohesion=1e12, tensile_strength=1e12)
    model.layers("layer", width=10.0, thickness=1.0, count=int(height))
    time = np.arange(0.0, 0.3, step)
    square = (np.pi * 10 * (time - 0.15)) ** 2
    wavelet = GRAVITY * (1 - 2 * square) * np.exp(-square)
    model.motion("up", wavelet, step, "acceleration", drift_order=0)
    model.boundary("base", "compliant", side="bottom", motion_x="up", motion_is="incoming")
    model.boundary(kind="tied")
    model.measured_point("surface", 5.0, height)
    model.measured_point("base", 5.0, 0.0)
    history = model.run().history
    acceleration = history.acceleration.sel(axis="x") / GRAVITY
    base, surface = acceleration.sel(point="base").values, acceleration.sel(point="surface").values
    time = history.time.values
    is_incident = time < 0.15 + height / speed
    figure, (axes,) = canvas(1)
    axes.plot(time, surface, color=RED, label="surface")
    axes.plot(time, base, color=BLUE, label="base")
    axes.set(xlabel="time (s)", ylabel="acceleration (g)")
    work = history.energy_damping.values[-1] + history.energy_input.values[-1]
    rows = [
        relative("peak acceleration of the surface", 2.0, surface.max(), 0.01, "g"),
        at_most("energy residual / work", abs(history.energy_balance.values).max() / work, 1e-6),
    ]
    if not short:
        rows += [
            relative("peak acceleration of the base, upgoing wave", 1.0, base[is_incident].max(),
                0.01, "g"),
            relative("peak acceleration of the base, downgoing wave", 1.0, base[~is_incident].max(),
                0.01, "g"),
        ]  # fmt: skip
    return Outcome(rows, figure)
