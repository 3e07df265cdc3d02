# SPDX-License-Identifier: GPL-3.0-or-later
"""Cohesive joints: strength, fracture energy, and friction that increases with damage."""

import numpy as np

from .. import model as nml
from ..case import Outcome, at_most, case, curves, relative, true

HEIGHT = 0.1  # height of the bar, m
PULLED = (  # number of steps, softening, largest width of the bounds over G
    (100, "linear", None),
    (400, "linear", None),
    (2000, "linear", 0.1),
    (2000, "exponential", None),
)
RISE = np.linspace(0.0, 1.0, 101)


def bar(steps: int, pull: float, length: float = 0.5, **law) -> str:
    """Return a bar with a joint of T = 2 MPa, G = 60 N/m that is pulled apart in 0.2 s."""
    half = length / 2
    law = {
        "law": "cohesive",
        "cohesion": 4e6,
        "tensile_strength": 2e6,
        "fracture_energy": 60.0,
        "normal_stiffness_per_area": 2e12,
    } | law
    return nml.text(
        nml.control(0.2 / steps, steps, (0.0, 0.0), integration="midpoint"),
        nml.contact(1e10),
        nml.material("rock", 2500.0, 2e10),
        nml.joint("j", 30.0, **law),
        nml.held(
            "left", nml.rectangle(-half, 0, half, HEIGHT), "rock", "j", [(-half, 0), (-half, 0.1)]
        ),
        nml.block("right", nml.rectangle(0, 0, half, HEIGHT), "rock", "j"),
        nml.motion("drive", pull * RISE, 2e-3, "displacement"),
        nml.group("fixed_point", x=half, y=0.0, block="right", motion_x="drive"),
        nml.group("fixed_point", x=half, y=HEIGHT, block="right", motion_x="drive"),
        nml.measured("end", (half, HEIGHT / 2), "right"),
        nml.group("output", block_interval=1),
    )


def triplet(steps: int, slip: float, **law) -> str:
    """Return a block under 1 MPa, sheared along a joint of c = 1 MPa, G_II = 100 N/m, φ = 30°."""
    law = {
        "law": "cohesive",
        "cohesion": 1e6,
        "tensile_strength": 5e5,
        "fracture_energy": 20.0,
        "shear_fracture_energy": 100.0,
        "normal_stiffness_per_area": 1e11,
        "shear_stiffness_per_area": 1e11,
    } | law
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
    spent = float(data.energy_fracture[-1])
    return [
        true(f"{name}: within the bounds of its run", True, lower < energy < upper
             and lower < spent < upper),
        at_most(f"{name}: width of the bounds", (upper - lower) / energy, width),
        at_most(f"{name}: residual of the energy audit", nml.residual(data), 1e-6),
    ]  # fmt: skip


@case(
    "A bar pulled apart at a cohesive joint",
    "σ increases to T and decreases to 0; the joint has then dissipated G, at any time step. L = "
    "2 m: σ²L/2E = 200 J/m² are stored at T, 60 are dissipated, 140 become kinetic energy.",
    "Hillerborg, Modéer and Petersson (1976).",
)
def cohesive_bar(short: bool) -> Outcome:
    """Check linear and exponential softening, coarse and fine steps, and unstable fracture."""
    rows, lines = [], []
    for steps, softening, width in PULLED:
        data = nml.history(bar(steps, 8e-5 if softening == "linear" else 8e-4, softening=softening))
        force, name = of_frames(data, "normal_force"), f"{steps} steps, {softening}"
        last = data.contact_frame.values == data.contact_frame.values.max()
        whole = (data.contact_damage.values[last] == 1.0).all()
        spent = float(data.energy_fracture[-1])
        rows += [
            relative(f"{name}: largest force", 2e6 * HEIGHT, force.max(), 5e-3, "N/m"),
            relative(f"{name}: fracture energy", 60.0 * HEIGHT, spent, 1e-2, "J/m"),
            true(f"{name}: broken, without a force", True, bool(whole and force[-1] == 0.0)),
            *fracture_energy_rows(name, data, 60.0 * HEIGHT, width),
        ]
        lines.append((data.frame_time.values, force / HEIGHT / 1e6, {"label": name}))
    data = nml.history(bar(4000, 4e-4, length=2.0))
    lost, spent = 2e6**2 * 2.0 / (2 * 2e10) * HEIGHT, data.energy_fracture.values
    peak = int(data.energy_strain.values.argmax())
    broken = np.flatnonzero(spent > 0.999 * spent[-1])[0]
    moving = (data.energy_kinetic + data.energy_strain).values[broken]
    given = float(data.energy_input[broken] - data.energy_input[peak])
    rows += [
        relative("2 m: stored at T", lost, float(data.energy_strain.max()), 1e-2, "J/m"),
        relative("2 m: fracture energy", 60.0 * HEIGHT, spent[-1], 1e-3, "J/m"),
        relative("2 m: into motion", lost - 60.0 * HEIGHT, moving - given, 2e-2, "J/m"),
        at_most("2 m: residual of the energy audit", nml.residual(data), 1e-6),
    ]
    return Outcome(rows, curves("time (s)", "stress (MPa)", *lines))


@case(
    "A cohesive joint sheared under pressure",
    "The peak is c + σ tan φ, and the area above friction is G_II; the residual stress is σ tan φ, "
    "because friction increases with damage.",
    "Shear tests on triplets of bricks.",
)
def cohesive_triplet(short: bool) -> Outcome:
    """Check peak, residual force and energies with linear and exponential softening."""
    rows, lines, friction = [], [], np.tan(np.radians(30.0))
    for softening in ("linear", "exponential"):
        data = nml.history(
            triplet(2000, 4e-4 if softening == "linear" else 2e-3, softening=softening)
        )
        shear, normal = of_frames(data, "shear_force"), of_frames(data, "normal_force")
        work = friction * 1e6 * float(data.contact_slip_path[-3:].mean())
        spent, paid = float(data.energy_fracture[-1]), float(data.energy_friction[-1])
        rows += [
            relative(f"{softening}: peak", (1.0 + friction) * 1e6, shear.max(), 2e-2, "N/m"),
            relative(f"{softening}: at the end", friction * normal[-1], shear[-1], 5e-2, "N/m"),
            relative(f"{softening}: fracture energy", 100.0, spent, 1e-3, "J/m"),
            relative(f"{softening}: work of friction", work, paid, 1e-3, "J/m"),
            *fracture_energy_rows(softening, data, 100.0, 0.1),
        ]
        lines.append((data.frame_time.values, shear / 1e6, {"label": softening}))
    return Outcome(rows, curves("time (s)", "shear force (MN/m)", *lines))
