# SPDX-License-Identifier: GPL-3.0-or-later
"""Inputs of cases as namelist text, and their runs."""

import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import xarray as xr

from sitedda.engine.simulation import Simulation
from sitedda.facade.run import run
from sitedda.input.groups import group_text

GRAVITY = 9.81  # m/s²
STORED = ("kinetic", "strain", "contact", "support", "gravity")
STIFF = 1e15  # Young's modulus of a practically rigid base, Pa


def group(name: str, /, **values) -> str:
    """Return a namelist group; values that are None are omitted."""
    return group_text(name, values)


def text(*groups: str) -> str:
    """Return an input composed of groups."""
    return "".join(groups)


def control(time_step: float, steps: int, gravity: Sequence[float] = (0.0, -GRAVITY), **variables):
    """Return ``&control``: Δt (s), number of steps, gravity (m/s²)."""
    return group("control", time_step=time_step, steps=int(steps), gravity=gravity, **variables)


def contact(normal_stiffness: float, **variables) -> str:
    """Return ``&contact``: penalty stiffness (N/m per metre of thickness)."""
    return group("contact", normal_stiffness=normal_stiffness, **variables)


def material(name, density, young_modulus, poisson_ratio=0.0, velocity=None, **variables) -> str:
    """Return ``&material``: density (kg/m³), E (Pa), initial velocity (m/s, m/s, rad/s)."""
    own_variables = {"name": name, "density": density, "young_modulus": young_modulus}
    own_variables |= {"poisson_ratio": poisson_ratio, "initial_velocity": velocity}
    return group("material", **own_variables, **variables)


def joint(name: str, friction_angle: float, **variables) -> str:
    """Return ``&joint``: friction angle in degrees."""
    return group("joint", name=name, friction_angle=friction_angle, **variables)


def block(name: str, vertices, material: str = "", joint: str = "") -> str:
    """Return ``&block`` with vertices, shape (n, 2), m, counter-clockwise."""
    return group("block", name=name, material=material, joint=joint, vertices=vertices)


def fixed_block(name: str, vertices, material="", joint="", points=None, **motions) -> str:
    """Return a block with two or more fixed points, by default at its vertices."""
    points = np.asarray(vertices if points is None else points, dtype=float)
    fixed = [group("fixed_point", x=x, y=y, block=name, **motions) for x, y in points]
    return block(name, vertices, material, joint) + "".join(fixed)


def pressed_block(time_step, steps, law: dict, *groups: str, stress=1e6, width=1.0) -> str:
    """Return a stiff block of height 1 m that presses on a joint of its fixed base under 10 m/s².

    `law`: variables of ``&joint``; the friction angle is 30° by default; `*groups`: further groups;
    `stress`, `width`: stress on the joint, Pa, and its length, m.
    """
    return text(
        control(time_step, steps, (0.0, -10.0), settle=True, integration="theta"),
        contact(1e10),
        material("rock", 2500.0, STIFF),
        material("load", stress / 10.0, STIFF),
        joint("j", **({"friction_angle": 30.0} | law)),
        fixed_block("base", rectangle(-2.0, -1.0, 8.0, 1.0), "rock", "j"),
        block("top", rectangle(0.0, 0.0, width, 1.0), "load", "j"),
        measured_point("top", (0.5 * width, 0.0), "top"),
        *groups,
    )


def driven_block(
    time_step, steps, law: dict, displacements, interval, frames: int, **variables
) -> str:
    """Return a `pressed_block` that follows displacements (m) along its joint.

    The displacements are `interval` s apart; the output contains the contacts every `frames` steps.
    """
    x = 0.5 * variables.get("width", 1.0)
    drive = motion("drive", displacements, interval, "displacement")
    point = group("fixed_point", x=x, y=0.0, block="top", direction="x", motion_x="drive")
    output = group("output", block_interval=frames)
    return pressed_block(time_step, steps, law, drive, point, output, **variables)


def measured_point(name: str, point, block: str = "") -> str:
    """Return ``&measured_point`` at a position, m."""
    return group("measured_point", name=name, x=point[0], y=point[1], block=block)


def motion(name: str, values, time_step: float, quantity="acceleration", drift_order=0) -> str:
    """Return ``&motion`` with samples in SI units."""
    variables = {"time_step": time_step, "drift_order": drift_order, "values": values}
    return group("motion", name=name, quantity=quantity, **variables)


def rectangle(left: float, bottom: float, width: float, height: float) -> np.ndarray:
    """Return the vertices of an axis-parallel rectangle, shape (4, 2), m."""
    right, top = left + width, bottom + height
    return np.array([[left, bottom], [right, bottom], [right, top], [left, top]], dtype=float)


def rotated(points, angle: float, about=(0.0, 0.0)) -> np.ndarray:
    """Rotate points counter-clockwise by an angle (rad) about a point."""
    c, s = np.cos(angle), np.sin(angle)
    return (np.asarray(points) - about) @ np.array([[c, s], [-s, c]]) + about


@contextmanager
def temporary_input(text: str) -> Iterator[Path]:
    """Yield a temporary file with an input text."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "case.nml"
        file.write_text(text)
        yield file


@contextmanager
def simulation(text: str) -> Iterator[Simulation]:
    """Yield a simulation of an input text, which the caller advances."""
    with temporary_input(text) as file, Simulation(file) as process:
        yield process


def history(text: str) -> xr.Dataset:
    """Run an input text to its end and return its output."""
    with temporary_input(text) as file:
        return run(file).history


def energy_gain(energies: dict[str, float]) -> float:
    """Return the increase of the stored energy since the start, J/m."""
    return sum(energies[kind] for kind in STORED) - energies["initial"]


def energy_residual(data: xr.Dataset) -> float:
    """Return the largest residual of the energy audit as a fraction of the work.

    The work is the largest work of gravity plus input, or at least the initial energy.
    """
    work = np.abs(data.energy_gravity).max() + np.abs(data.energy_input).max()
    start = float(data.energy_initial[-1])
    return float(np.abs(data.energy_balance).max() / max(float(work), abs(start)))
