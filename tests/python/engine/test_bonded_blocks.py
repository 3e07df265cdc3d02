# SPDX-License-Identifier: GPL-3.0-or-later
"""The shipped tests of bonded grains: splitting of a disc, crushing of a sample."""

import numpy as np
import pytest
from shapely import Polygon

import sitedda
from sitedda.examples import copy_example

R = 0.05  # radius of the disc, m
WHOLE = {f"joint[bond].{name}": value for name, value in
         (("tensile_strength", 1e9), ("cohesion", 1e9), ("fracture_energy", 1e5))}  # fmt: skip


@pytest.fixture
def disc(tmp_path):
    return copy_example("studies/brazilian", tmp_path)[0].with_suffix(".nml")


def disc_stress(x, y):
    """Stresses across and along an elastic disc under forces of 1 N/m at (0, ±R), Pa."""
    first, second = R - y, R + y
    a, b = np.hypot(x, first) ** 4, np.hypot(x, second) ** 4
    horizontal = -2 / np.pi * (first * x**2 / a + second * x**2 / b - 1 / (2 * R))
    vertical = -2 / np.pi * (first**3 / a + second**3 / b - 1 / (2 * R))
    return horizontal, vertical


def test_intact_bonds_carry_the_stresses_of_an_elastic_disc(disc):
    """The mean over 20 or more grains; the forces of both platens agree, so inertia is small."""
    changes = WHOLE | {"control.duration": 8e-4}
    history = sitedda.run(disc, output=False, changes=changes).history
    with sitedda.Simulation(disc, changes=changes) as start:
        positions, polygons = start.coordinates[:, :2], start.polygons
    force = history.joint_normal_force.values[-1, 0]
    middle = (np.hypot(*positions.T) < 0.018) & (np.abs(positions[:, 1]) < 0.04)
    assert middle.sum() >= 20
    areas = np.array([Polygon(polygon).area for polygon in polygons])[middle]
    weight_fraction = areas / areas.sum()
    horizontal, vertical, _ = weight_fraction @ history.block_stress.values[-1][middle] / force
    expected = [weight_fraction @ stress for stress in disc_stress(*positions[middle].T)]
    assert horizontal == pytest.approx(expected[0], rel=0.2)
    assert vertical == pytest.approx(expected[1], rel=0.1)


def test_the_disc_splits_in_the_middle_and_loses_its_strength(disc):
    changes = {"voronoi.size": 0.01, "stop.tilt": 20.0, "control.duration": 3e-3}
    history = sitedda.run(disc, output=False, changes=changes).history
    start = history.block_coordinates.values[0, :, 0]
    displacement = history.block_coordinates.values[-1, :, 0] - start
    force = history.joint_normal_force.values[:, 0]
    strength = 2 * force.max() / (np.pi * 2 * R)
    assert 2e6 < strength < 20e6
    assert force[-1] < 0.3 * force.max()
    right, left = start > 0.02, start < -0.02
    assert displacement[right].mean() - displacement[left].mean() > 1e-4


def test_lateral_pressure_makes_the_sample_stronger(tmp_path):
    sample = copy_example("studies/biaxial", tmp_path)[0].with_suffix(".nml")
    strength = []
    for pressure in (0.0, 10e6):
        changes = {f"traction[{side}].normal": pressure for side in ("left", "right")}
        changes |= {"voronoi.size": 0.01, "stop.fallen": 1}
        history = sitedda.run(sample, output=False, changes=changes).history
        strength.append(history.joint_normal_force.values.max() / 0.05)
    smallest_strength = 10e6 * np.tan(np.radians(45 + 15)) ** 2  # the part due to friction of 30°
    assert strength[1] > strength[0] + 0.5 * smallest_strength
