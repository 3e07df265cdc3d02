# SPDX-License-Identifier: GPL-3.0-or-later
"""Cohesive joints: strength, fracture energy, and friction that increases with damage."""

import numpy as np

from .. import model as nml
from ..case import Outcome, at_most, case, curves, relative, yes_or_no

HEIGHT = 0.1  # height of the bar, m
PULLED = (  # number of steps, softening, largest width of the bounds over G
    (100, "linear", None),
    (400, "linear", None),
    (2000, "linear", 0.1),
    (2000, "exponential", None),
)
RISE = np.linspace(0.0, 1.0, 101)


def bar(steps: int, displacement: float, length: float = 0.5, **law) -> str:
    """Return a bar with a joint of T = 2 MPa, G = 60 N/m that is pulled apart in 0.2 s."""
    half = length / 2
    strength = {"cohesion": 4e6, "tensile_strength": 2e6, "fracture_energy": 60.0}
    law = {"law": "cohesive", "normal_stiffness_per_area": 2e12} | strength | law
    return nml.text(
        nml.control(0.2 / steps, steps, (0.0, 0.0), integration="midpoint"),
        nml.contact(1e10),
        nml.material("rock", 2500.0, 2e10),
        nml.joint("j", 30.0, **law),
        nml.fixed_block(
            "left", nml.rectangle(-half, 0, half, HEIGHT), "rock", "j", [(-half, 0), (-half, 0.1)]
        ),
        nml.block("right", nml.rectangle(0, 0, half, HEIGHT), "rock", "j"),
        nml.motion("drive", displacement * RISE, 2e-3, "displacement"),
        nml.group("fixed_point", x=half, y=0.0, block="right", motion_x="drive"),
        nml.group("fixed_point", x=half, y=HEIGHT, block="right", motion_x="drive"),
        nml.measured_point("end", (half, HEIGHT / 2), "right"),
        nml.group("output", block_interval=1),
    )


def triplet(steps: int, slip: float, **law) -> str:
    """Return a block under 1 MPa, sheared along a joint of c = 1 MPa, G_II = 100 N/m, φ = 30°."""
    strength = {"cohesion": 1e6, "tensile_strength": 5e5}
    energy = {"fracture_energy": 20.0, "shear_fracture_energy": 100.0}
    stiffness = {"normal_stiffness_per_area": 1e11, "shear_stiffness_per_area": 1e11}
    law = {"law": "cohesive"} | strength | energy | stiffness | law
    return nml.driven_block(0.4 / steps, steps, law, slip * RISE, 4e-3, 1)


def of_frames(data, name: str) -> np.ndarray:
    """Return the sum of the absolute values of a variable over the contacts of each frame."""
    return np.bincount(data.contact_frame.values, np.abs(data[f"contact_{name}"].values))


def bracket_of(data) -> tuple[float, float]:
    """Return bounds of the fracture energy dissipated in a run, J/m."""
    last = data.contact_frame.values == data.contact_frame.values.max()
    return tuple(
        float((data[f"contact_fracture_energy_{end}"] * data.contact_length).values[last].sum())
        for end in ("lower", "upper")
    )


def fracture_energy_rows(name: str, data, energy: float, width: float | None) -> list:
    """Return rows of a broken joint: dissipated energy (J/m), and width of its bounds."""
    lower, upper = bracket_of(data)
    dissipated = float(data.energy_fracture[-1])
    return [
        yes_or_no(f"{name}: fracture energy is between the bounds of the run", True,
            lower < energy < upper and lower < dissipated < upper),
        at_most(f"{name}: distance of the bounds / energy", (upper - lower) / energy, width),
        at_most(f"{name}: energy residual / work", nml.energy_residual(data), 1e-6),
    ]  # fmt: skip


@case(
    "A bar pulled apart at a cohesive joint",
    "The stress increases to T and decreases to 0. The joint then has dissipated G, for any time "
    "step. With L = 2 m, σ²L/2E = 200 J/m² are stored at T; 60 J/m² are dissipated, and 140 J/m² "
    "become kinetic energy.",
    "Hillerborg, Modéer and Petersson (1976).",
)
def cohesive_bar(short: bool) -> Outcome:
    """Check linear and exponential softening, coarse and fine steps, and unstable fracture."""
    rows, lines = [], []
    for steps, softening, width in PULLED:
        data = nml.history(bar(steps, 8e-5 if softening == "linear" else 8e-4, softening=softening))
        force, name = of_frames(data, "normal_force"), f"{steps} steps, {softening}"
        last = data.contact_frame.values == data.contact_frame.values.max()
        is_broken = (data.contact_damage.values[last] == 1.0).all()
        dissipated = float(data.energy_fracture[-1])
        rows += [
            relative(f"{name}: largest normal force", 2e6 * HEIGHT, force.max(), 5e-3, "N/m"),
            relative(f"{name}: fracture energy", 60.0 * HEIGHT, dissipated, 1e-2, "J/m"),
            yes_or_no(f"{name}: the joint is broken and has no force", True,
                bool(is_broken and force[-1] == 0.0)),
            *fracture_energy_rows(name, data, 60.0 * HEIGHT, width),
        ]  # fmt: skip
        lines.append((data.frame_time.values, force / HEIGHT / 1e6, {"label": name}))
    data = nml.history(bar(4000, 4e-4, length=2.0))
    stored, dissipated = 2e6**2 * 2.0 / (2 * 2e10) * HEIGHT, data.energy_fracture.values
    peak = int(data.energy_strain.values.argmax())
    frame = np.flatnonzero(dissipated > 0.999 * dissipated[-1])[0]
    energy = (data.energy_kinetic + data.energy_strain).values[frame]
    work = float(data.energy_input[frame] - data.energy_input[peak])
    rows += [
        relative("2 m: largest strain energy", stored, float(data.energy_strain.max()), 1e-2,
            "J/m"),
        relative("2 m: fracture energy", 60.0 * HEIGHT, dissipated[-1], 1e-3, "J/m"),
        relative("2 m: released energy of motion", stored - 60.0 * HEIGHT, energy - work, 2e-2,
            "J/m"),
        at_most("2 m: energy residual / work", nml.energy_residual(data), 1e-6),
    ]  # fmt: skip
    return Outcome(rows, curves("time (s)", "stress (MPa)", *lines))


@case(
    "A cohesive joint sheared under pressure",
    "The peak stress is c + σ tan φ. The area above the friction is G_II. The residual stress is "
    "σ tan φ, because friction increases with damage.",
    "Shear tests on triplets of bricks.",
)
def cohesive_triplet(short: bool) -> Outcome:
    """Check peak, residual force and energies with linear and exponential softening."""
    rows, lines, friction = [], [], np.tan(np.radians(30.0))
    for softening in ("linear", "exponential"):
        slip = 4e-4 if softening == "linear" else 2e-3
        data = nml.history(triplet(2000, slip, softening=softening))
        shear, normal = of_frames(data, "shear_force"), of_frames(data, "normal_force")
        work = friction * 1e6 * float(data.contact_slip_path[-3:].mean())
        dissipated, friction_work = float(data.energy_fracture[-1]), float(data.energy_friction[-1])
        rows += [
            relative(f"{softening}: largest shear force", (1.0 + friction) * 1e6, shear.max(), 2e-2,
                "N/m"),
            relative(f"{softening}: shear force at the end", friction * normal[-1], shear[-1], 5e-2,
                "N/m"),
            relative(f"{softening}: fracture energy", 100.0, dissipated, 1e-3, "J/m"),
            relative(f"{softening}: work of friction", work, friction_work, 1e-3, "J/m"),
            *fracture_energy_rows(softening, data, 100.0, 0.1),
        ]  # fmt: skip
        lines.append((data.frame_time.values, shear / 1e6, {"label": softening}))
    return Outcome(rows, curves("time (s)", "shear force (MN/m)", *lines))
