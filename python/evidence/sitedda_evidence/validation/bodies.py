# SPDX-License-Identifier: GPL-3.0-or-later
"""Bodies of cells: a wave through the interface of two materials."""

import numpy as np

from sitedda.engine.simulation import Simulation
from sitedda.facade.model import Model

from ..case import Outcome, case, curves, relative

SPEED, LENGTH, DENSITY = 2000.0, 200.0, 2500.0  # left half (m/s), pulse (m), bar (kg/m³)


def pulse(x):
    """Return the initial pulse, of height 1, at positions (m)."""
    phase = np.clip((x / LENGTH + 2.5) / 1.5, -0.5, 0.5)
    return 0.5 + 0.5 * np.cos(2 * np.pi * phase)


@case(
    "A pulse through the interface of two bodies",
    "A pulse in a bar of constant density meets a change of wave velocity by the factor c. Its "
    "fraction 2/(1 + c) is transmitted, and 2/(1 + c) − 1 is reflected.",
    "Impedances of plane waves.",
)
def interface(short: bool) -> Outcome:
    """Check both impulses and the transmitted peak, with twelve cells per pulse length."""
    rows, lines = [], []
    for contrast in (0.1, 0.5, 4.0):
        centre, size, velocity = passed_by(contrast)
        transmitted = centre > 0
        reflected = (centre < 0) & (centre > -2.6 * LENGTH)  # the wave to the left is farther away
        impulse = velocity * size / np.where(transmitted, contrast, 1.0)
        incident, passes = (pulse(centre) * size)[~transmitted].sum(), 2 / (1 + contrast)
        rows += [
            relative(f"c = {contrast:g}: transmitted / incident impulse", passes,
                     impulse[transmitted].sum() / incident, 1e-3),
            relative(f"c = {contrast:g}: reflected / incident impulse", passes - 1,
                     impulse[reflected].sum() / incident, 1e-3),
            relative(f"c = {contrast:g}: transmitted / incident peak velocity", passes,
                     velocity[transmitted].max(), 1e-2),
        ]  # fmt: skip
        lines.append((centre, velocity, {"label": f"c = {contrast:g}"}))
    return Outcome(rows, curves("position (m)", "velocity (m/s)", *lines))


def passed_by(contrast: float):
    """Run a bar of two materials; return centres, lengths (m) and final velocities of cells."""
    size, count = np.array([1.0, contrast]) * LENGTH / 12, 72
    edges = np.concatenate([size[0] * np.arange(-count, 0), size[1] * np.arange(count + 1)])
    centre, size = (edges[1:] + edges[:-1]) / 2, np.diff(edges)
    step = 0.05 * LENGTH / 12 / SPEED
    model = Model()
    model.control(time_step=step, steps=round(4.1 * LENGTH / SPEED / step), gravity=[0.0, 0.0],
                  analysis="plane_stress", integration="midpoint")  # fmt: skip
    for number, factor in enumerate([1.0, contrast**2]):
        model.material(name=f"m{number}", density=DENSITY, poisson_ratio=0.0,
                       young_modulus=DENSITY * SPEED**2 * factor)  # fmt: skip
    model.joint(name="joint", friction_angle=30.0)
    for left, right in zip(edges[:-1], edges[1:], strict=True):
        box = [left, 0, right, 0, right, size.min(), left, size.min()]
        model.block(vertices=box, body="bar", material="m0" if left < 0 else "m1")
    rates = np.zeros((len(centre), 6))  # twice the pulse, half of which moves in each direction
    rates[:, 0] = 2 * pulse(centre)
    rates[:, 3] = 2 * (pulse(centre + size / 2) - pulse(centre - size / 2)) / size
    with Simulation(model) as run:
        run.rates = rates
        while not run.advance(1000):
            pass
        return centre, size, run.rates[:, 0]
