# SPDX-License-Identifier: GPL-3.0-or-later
"""Findings of a check on dashpots, block size, and sides of a model."""

import re

import numpy as np
import pytest
from lattices import DENSITY, MODULUS, POISSON, SPEED, lattice

import sitedda


def line(model, topic: str):
    """The finding of a check on a topic, or None."""
    return next((row for row in sitedda.check(model).lines if row.topic == topic), None)


def percent(text: str, before: str) -> float:
    return float(re.search(r"([0-9.]+) % " + before, text)[1])


@pytest.mark.parametrize(
    ("integration", "fraction"), [("dda", 1 / 8), ("midpoint", 0), ("theta", 0)]
)
def test_the_check_reports_the_reflection_of_dashpots(integration, fraction):
    """(kh)²/48 due to the lowest blocks, plus ωΔt/8 in DDA and 0 in other members."""
    message = line(lattice("free_field", columns=3, integration=integration), "dashpots").words
    frequency = float(re.search(r"and ([0-9.]+) Hz", message)[1])
    omega = 2 * np.pi * frequency
    slowest = np.sqrt(MODULUS / (2 * (1 + POISSON)) / (DENSITY + 200))  # of the top layer
    expected = 100 * (omega / slowest) ** 2 / 48
    by_size = percent(message, "of the amplitude due to the block size")
    assert by_size == pytest.approx(expected, rel=0.02)
    expected = 100 * omega * 1e-3 * fraction
    assert percent(message, "due to the time") == pytest.approx(expected, rel=0.02)
    # The table of docs/boundaries.md for ν = ¼: 0.0003 at 30° and 0.0039 at 45° for P waves.
    degrees = [int(n) for n in re.findall(r"(\d+)°", message)]
    assert degrees[0] <= 50
    assert degrees[1] <= 21


def test_the_check_reports_the_velocity_error_of_the_block_size():
    """(kΔx)²/24: the first frequency of layers on a fixed base exceeds the closed form."""
    layers, height = 4, 4.0
    model = sitedda.Model("layers", time_step=1e-5, steps=1)
    model.control(analysis="plane_strain", integration="midpoint")
    model.contact(normal_stiffness=1e6 * MODULUS)
    model.material("soil", density=DENSITY, young_modulus=MODULUS, poisson_ratio=POISSON)
    model.joint("glue", friction_angle=40.0, cohesion=1e12, tensile_strength=1e12)
    model.layers("layer", width=1.0, thickness=height / layers, count=layers)
    model.boundary("base", "fixed", side="bottom")
    for side in ("left", "right"):
        model.boundary(side=side, kind="roller", direction="y")
    velocity_ratio = sitedda.modes(model, 1).frequency[0] / (SPEED / 4 / height)
    assert velocity_ratio - 1 == pytest.approx((np.pi / 2 / layers) ** 2 / 24, rel=0.03)


def test_the_check_warns_of_free_sides():
    assert line(lattice("free", columns=3), "sides").verdict == "warn"
    assert line(lattice("viscous", columns=3), "sides").verdict == "warn"
    assert line(lattice("tied", columns=3), "sides") is None


@pytest.mark.parametrize(("height", "warns"), [(0.0, True), (20.0, False)])
def test_points_at_the_foot_of_the_sides_fix_only_the_base(height, warns):
    model = sitedda.Model("ground", time_step=1e-3, duration=1.0)
    model.control(analysis="plane_strain")
    model.material("soil", density=DENSITY, young_modulus=MODULUS, poisson_ratio=POISSON)
    model.joint("joint", friction_angle=30.0)
    model.block([[0, 0], [60, 0], [60, 20], [0, 20]], name="ground")
    shaking = np.sin(np.linspace(0.0, 60.0, 500))
    model.motion("shaking", quantity="acceleration", time_step=0.02, values=shaking)
    for x in (0.0, 60.0):
        model.fixed_point(x, height, motion_x="shaking")
    for side in ("left", "right"):
        model.boundary(side=side, kind="viscous")
    sides = line(model, "sides")
    assert (sides is not None and sides.verdict == "warn") == warns


def test_level_ground_does_not_differ_from_its_free_fields():
    side_line = line(lattice("free_field", columns=3), "sides")
    assert side_line.verdict == "ok"
    assert percent(side_line.words, "at ") == 0.0


def departure_of_a_step(omega, depths, distances) -> float:
    """Largest departure at the ends of a bar with a step, at given distances from the step (m).

    u = u_free + A e^κx + B e^−κx in both parts, κ² = (iωZ − ρHω²)/(E'H); at the step u and E'H u'
    are continuous, at the ends E'H u' = ∓iωρV_p H (u − u_free).
    """
    density, plate, base, side = 2400.0, 2.16e9 / (1.0 - 0.25**2), 2400 * 600.0, 2400 * 1039.23
    depths, ends = np.array(depths), np.array([-1.0, 1.0]) * distances
    free_field = 2.0 / (1.0 + 1j * omega * density * depths / base)
    wave = np.sqrt((1j * omega * base / depths - density * omega**2) / plate)
    slope = plate * depths * wave
    equations = np.zeros((4, 4), dtype=complex)  # unknowns: A, B on the left, A, B on the right
    equations[0] = [1.0, 1.0, -1.0, -1.0]
    equations[1] = [slope[0], -slope[0], -slope[1], slope[1]]
    growth = np.exp(wave * ends)
    for part, direction in ((0, -1.0), (1, 1.0)):
        dashpot = 1j * omega * side * depths[part]
        reflection = ((direction * slope[part] + dashpot) * growth[part],
                      (dashpot - direction * slope[part]) / growth[part])  # fmt: skip
        equations[2 + part, 2 * part : 2 * part + 2] = reflection
    load = [free_field[1] - free_field[0], 0.0, 0.0, 0.0]
    amplitudes = np.linalg.solve(equations, load).reshape(2, 2)
    added = amplitudes[:, 0] * growth + amplitudes[:, 1] / growth
    return float(abs(added / free_field).max())


@pytest.mark.parametrize(
    ("distances", "verdict"), [((60.0, 100.0), "warn"), ((200.0, 280.0), "ok")]
)
def test_departure_of_sides_from_their_free_fields(root, distances, verdict):
    """Ground that steps from 15 to 45 m, by the closed form of its long-wave estimate."""
    model = sitedda.Model.read(root / "inputs" / "step.nml")
    left, right = -distances[0], distances[1]
    model["region"][0](outline=[(left, -15), (right, -15), (right, 30), (0, 30), (0, 0), (left, 0)])
    model.clear("measured_point")
    model.measured_point("step", 0.0, 0.0)
    side_line = line(model, "sides")
    frequency = float(re.search(r"at ([0-9.]+) Hz", side_line.words)[1])
    expected = departure_of_a_step(2 * np.pi * frequency, (15.0, 45.0), distances)
    assert percent(side_line.words, "at ") == pytest.approx(100 * expected, rel=5e-3)
    assert side_line.verdict == verdict
