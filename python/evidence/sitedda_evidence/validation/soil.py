# SPDX-License-Identifier: GPL-3.0-or-later
"""Soil with a hysteretic law: Masing loops, and a simple wave."""

import numpy as np

from sitedda.facade.model import Model
from sitedda.report.style import BLUE, ORANGE

from ..case import Outcome, absolute, at_most, case, curves, relative

DENSITY, VELOCITY, POISSON = 2000.0, 300.0, 0.25
SHEAR = DENSITY * VELOCITY**2
REFERENCE = 3.65e-4  # reference strain of the hyperbola
MASING = {
    "law": "hysteretic", "curve": "hyperbolic", "reference_strain": REFERENCE,
    "damping_curve": "masing",
}  # fmt: skip
MKZ = {
    "law": "hysteretic", "curve": "mkz", "reference_strain": 1e-3, "curve_factor": 1.4,
    "curve_power": 0.8, "damping_curve": "masing", "branches": 60,
}  # fmt: skip
# Strain, G/G_max and damping (%) of MKZ with Masing's rules.
BACKBONE = ((1e-4, 0.81841, 3.5994), (1e-3, 0.41667, 14.7627), (1e-2, 0.10169, 31.159))
WAVES = ((0.64872, 108, 36.0), (1.71828, 225, 45.0))  # strain, cells, height (m)


def soil_model(steps, soil, integration="midpoint", time_step=2e-3):
    """Return a plane-strain model with one soil, without blocks."""
    model = Model()
    model.control(time_step=time_step, steps=steps, gravity=[0.0, 0.0], integration=integration,
                  analysis="plane_strain")  # fmt: skip
    model.contact(normal_stiffness=100 * SHEAR)
    young = 2 * SHEAR * (1 + POISSON)
    model.material(name="soil", density=DENSITY, young_modulus=young, poisson_ratio=POISSON, **soil)
    model.joint(name="joint", friction_angle=30.0)
    return model


def shaken_column(ground, cells, soil, integration="midpoint", height=20.0, time_step=2e-3):
    """Return a column of cells in pure shear on a base with accelerations `ground`, m/s²."""
    model = soil_model(ground.size - 1, soil, integration, time_step)
    model.motion("ground", ground.tolist(), time_step, "acceleration", drift_order=0)
    size = height / cells
    for i in range(cells):
        low, high = i * size, (i + 1) * size
        corners = [0, low, size, low, size, high, 0, high]
        model.block(vertices=corners, body="column", name=f"c{i}")
        for x in (0, size):
            for y in (low, high):
                support = {"motion_x": "ground"} if y == 0 else {"direction": "y"}
                model.fixed_point(x=x, y=y, block=f"c{i}", **support)
    for name, i, y in (("top", cells - 1, height), ("base", 0, 0.0)):
        model.measured_point(name=name, x=size / 2, y=y, block=f"c{i}")
    return model


def sine(frequency, amplitude, steps):
    """Return accelerations of a sine whose amplitude increases during 1 s, every 2 ms."""
    time = 2e-3 * np.arange(steps + 1)
    return amplitude * np.sin(2 * np.pi * frequency * time) * np.minimum(time, 1)


def sheared_block(strain, soil, integration="midpoint"):
    """Return a block under two prescribed cycles of shear strain with 400 steps each."""
    model = soil_model(800, soil, integration, 1e-2)
    return hold_sheared(model, strain * np.sin(2 * np.pi * np.arange(802) / 400))


def hold_sheared(model, values):
    """Add a block of 1 m whose top follows prescribed displacements, m."""
    model.block(vertices=[0, 0, 1, 0, 1, 1, 0, 1], name="block", material="soil")
    model.motion(name="top", values=values.tolist(), quantity="displacement", time_step=1e-2)
    for x in (0.0, 1.0):
        model.fixed_point(x=x, y=0.0)
        model.fixed_point(x=x, y=1.0, motion_x="top")
    return model


@case(
    "Loops of a block of hysteretic soil",
    "A hyperbola with Masing's rules has the damping ratio D = (2/π)[2(1 + 1/x)(1 − ln(1 + x)/x) − "
    "1] at x = γ/γ_r. For MKZ with β = 1.4 and s = 0.8, G/G_max follows from its curve and D from "
    "quadrature.",
    "Masing (1926); Matasović and Vucetic (1993).",
)
def hysteretic_loops(short: bool) -> Outcome:
    """Check the damping of the second of two cycles, and the secant modulus."""
    rows, lines = [], []
    for x in (0.3, 1.0, 3.0):
        dissipated = sheared_block(x * REFERENCE, MASING).run().history.energy_plastic.values
        elastic = 2 * np.pi * SHEAR / (1 + x) * (x * REFERENCE) ** 2
        expected = 200 / np.pi * (2 * (1 + 1 / x) * (1 - np.log(1 + x) / x) - 1)
        computed = 100 * (dissipated[-1] - dissipated[-401]) / elastic
        rows.append(absolute(f"hyperbola, x = {x:g}: damping ratio", expected, computed, 0.4, "%"))
    for strain, reduction, damping in BACKBONE:
        model = sheared_block(strain, MKZ)
        model.output(block_interval=4)
        history = model.run().history
        stress = history.block_stress.sel(component="xy").values[:, 0]
        peak, dissipated = np.abs(stress).max(), history.energy_plastic.values
        computed = 100 * (dissipated[-1] - dissipated[-401]) / (2 * np.pi * peak * strain)
        secant = peak / (SHEAR * strain)
        rows.append(relative(f"MKZ, γ = {strain:g}: G/G_max", reduction, secant, 1e-3))
        rows.append(absolute(f"MKZ, γ = {strain:g}: damping ratio", damping, computed, 0.03, "%"))
        time = history.frame_time.values / 4.0
        lines.append((np.sin(2 * np.pi * time), stress / peak, {"label": f"γ = {strain:g}"}))
    return Outcome(rows, curves("strain / largest strain", "stress / largest stress", *lines))


@case(
    "A simple wave through soil that softens",
    "In a simple wave through soil with a hyperbolic curve, the strain x γ_r has the particle "
    "velocity c₀γ_r ln(1 + x) and the wave velocity c₀/(1 + x). A pulse therefore steepens behind "
    "its peak.",
    "Characteristics of the wave equation with a tangent modulus G₀/(1 + x)².",
)
def simple_wave(short: bool) -> Outcome:
    """Check the strain after 20 m in cells in pure shear."""
    rows, lines = [], []
    for x, cells, height in WAVES:
        time, strain, exact = strain_history(x, cells, height)
        rows.append(relative(f"largest strain / γ_r after 20 m, x = {x:.3g}", x, strain.max(),
            5e-3))  # fmt: skip
        worst = np.abs(strain - exact).max() / x
        rows.append(at_most(f"largest error of the strain at any time / peak, x = {x:.3g}", worst,
            0.015))  # fmt: skip
        lines += [(time, strain, {"color": BLUE, "label": "computed"}),
                  (time, exact, {"color": ORANGE, "ls": "--", "label": "exact"})]  # fmt: skip
    return Outcome(rows, curves("time (s)", "strain / γ_r after 20 m", *lines))


def strain_history(x: float, cells: int, height: float):
    """Return times (s), and computed and exact strains / γ_r after 20 m."""
    speed, reference, rise, step = 300.0, 1e-3, 0.04, 5e-4
    duration = 20.0 / speed * (1 + x) + 1.1 * rise
    time = step * np.arange(round(duration / step) + 1)
    wave = np.where(time < rise, 1 - np.cos(2 * np.pi * time / rise), 0.0) / rise
    soil = MASING | {"reference_strain": reference, "branches": 150}
    ground_motion = speed * reference * np.log(1 + x) * wave
    model = shaken_column(ground_motion, cells, soil, height=height, time_step=step)
    size = height / cells
    cell = round(20.0 / size)
    for i in (cell, cell + 1):
        model.measured_point(name=f"p{i}", x=size / 2, y=i * size, block=f"c{cell}")
    u = model.run().history.displacement.sel(axis="x").values
    strain = np.abs(u[:, -1] - u[:, -2]) / (size * reference)
    fine = np.linspace(0, rise, 2001)
    strains = (1 + x) ** (fine / rise - np.sin(2 * np.pi * fine / rise) / (2 * np.pi)) - 1
    arrival = fine + (cell + 0.5) * size * (1 + strains) / speed
    return time, strain, np.interp(time, arrival, strains, left=0.0)
