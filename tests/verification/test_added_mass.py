# SPDX-License-Identifier: GPL-3.0-or-later
"""Westergaard's added mass of a reservoir that moves with an upstream face."""

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from shapely import Polygon

import sitedda
from sitedda import InputError
from sitedda.engine.checking import matrices

WATER, CONCRETE = 1000.0, 2400.0  # kg/m³
FACE, BASE, HEIGHT = 4.0, 8.0, 20.0  # m; the face leans by FACE over HEIGHT
BED = 4e9  # Pa/m, stiffness of the foundation


def dam(level: float = 18.0, inclination: float = 0.0, load=(), **control) -> sitedda.Model:
    """A stiff block on springs whose left face, inclined by `inclination`, is wet up to a level."""
    model = sitedda.Model("dam", **({"time_step": 1e-4, "steps": 400} | control))
    model.material("concrete", density=CONCRETE, young_modulus=1e15, poisson_ratio=0.0)
    model.joint("base", friction_angle=30.0)
    model.block([0, 0, BASE, 0, BASE, HEIGHT, inclination, HEIGHT], name="dam")
    model.boundary("bed", "springs", blocks="dam", edges=1, stiffness_per_area=BED)
    water = {"level": level, "unit_weight": 9.81 * WATER, "added_mass": True, "edges": 4}
    model.traction("reservoir", blocks="dam", **(water | dict(load)))
    return model


def added(level: float, inclination: float, depth: float | None = None) -> np.ndarray:
    """∫ (7/8) ρ √(Hz) rᵀr ds of a rigid block by quadrature; r is the motion normal to the face."""
    slope = np.hypot(inclination, HEIGHT) / HEIGHT
    normal = np.array([-HEIGHT, inclination]) / np.hypot(inclination, HEIGHT)
    block = Polygon([(0, 0), (BASE, 0), (BASE, HEIGHT), (inclination, HEIGHT)])
    centre = np.array([block.centroid.x, block.centroid.y])

    def entry(height: float, i: int, j: int) -> float:
        arm = np.array([inclination * height / HEIGHT, height]) - centre
        row = [*normal, normal[1] * arm[0] - normal[0] * arm[1]]
        mass = 7 / 8 * WATER * np.sqrt((depth or level) * (level - height)) * slope
        return mass * row[i] * row[j]

    water_depth = min(level, HEIGHT)
    return np.array([[quad(entry, 0, water_depth, (i, j), epsrel=1e-12)[0] for j in range(3)]
                     for i in range(3)])  # fmt: skip


def mass_of(model) -> np.ndarray:
    """Return the part of M for the translations and the rotation of the block."""
    return matrices(model)[1].toarray()[:3, :3]


@pytest.mark.parametrize(
    ("level", "inclination"), [(18.0, 0.0), (20.0, FACE), (26.0, FACE), (3.0, -2.0)]
)
def test_mass_is_the_integral_over_the_face(level, inclination):
    """The face is vertical, inclined, completely under water, or barely wet."""
    dry_mass = mass_of(dam(level, inclination, load={"added_mass": False}))
    exact = added(level, inclination)
    added_mass = mass_of(dam(level, inclination)) - dry_mass
    np.testing.assert_allclose(added_mass, exact, atol=1e-8 * exact.max())
    if inclination == 0.0 and level <= HEIGHT:
        assert added_mass[0, 0] == pytest.approx(7 / 12 * WATER * level**2, rel=1e-8)


def test_the_reservoir_may_be_deeper_than_the_face():
    """The reservoir may be deeper than the foot of the face, but not shallower."""
    dry_mass = mass_of(dam(load={"added_mass": False}))
    added_mass = mass_of(dam(load={"reservoir_depth": 32.0})) - dry_mass
    np.testing.assert_allclose(added_mass, added(18.0, 0.0, 32.0), atol=1e-8 * added_mass.max())
    with pytest.raises(InputError, match=r"reservoir_depth = 12 m is less than the depth of water"):
        sitedda.check(dam(load={"reservoir_depth": 12.0}))


@pytest.mark.parametrize(
    ("load", "message"),
    [
        ({"level": -1.0}, "requires a selected edge below the level"),
        ({"edges": 1}, "too flat"),
        ({"time": [0.0, 1.0]}, "added_mass.*time|time.*added_mass"),
        ({"level": None, "normal": 1e3}, "added_mass needs it"),
        ({"added_mass": False, "reservoir_depth": 30.0}, "reservoir_depth needs it"),
    ],
)
def test_invalid_variables_are_named(load, message):
    with pytest.raises(InputError, match=message):
        sitedda.check(dam(load=load))


def test_added_mass_lowers_the_frequencies():
    """The frequencies are those of the block with added mass, not those of the block alone."""
    model = dam()
    stiffness, mass = (m.toarray()[:3, :3] for m in matrices(model)[:2])
    block = CONCRETE * BASE * HEIGHT
    mass_of_block = np.diag([block, block, block * (BASE**2 + HEIGHT**2) / 12])
    np.testing.assert_allclose(mass, mass_of_block + added(18.0, 0.0), atol=1e-7 * mass.max())
    wet_frequencies, dry_frequencies = (
        np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(m, stiffness)).real)) / (2 * np.pi)
        for m in (mass, mass_of_block)
    )
    np.testing.assert_allclose(sitedda.modes(model, 3).frequency, wet_frequencies, rtol=2e-5)
    assert wet_frequencies[0] < 0.95 * dry_frequencies[0]


@pytest.mark.parametrize("integration", ["dda", "midpoint", "theta", "backward_euler"])
def test_energy_balance(integration):
    """The energy balance is closed in each scheme; kinetic energy includes that of the water."""
    model = dam(integration=integration)
    model.load(BASE / 2, HEIGHT / 2, force_x=[5e5, 5e5], time=[0.0, 1.0])
    data = sitedda.run(model).history.load()
    scale = abs(data.energy_water.values).max()
    assert scale > 1.0
    assert abs(data.energy_balance.values).max() < 1e-9 * scale


def test_moving_base_pushes_the_water():
    """In the frame of the base, the acceleration of the ground acts on block and added mass."""
    time = np.arange(301) * 1e-3
    pulse = np.sin(4 * np.pi * time)
    displacements = []
    for scale in (1.0, 0.0):
        model = dam(time_step=1e-3, steps=300, integration="midpoint", base_motion_x="pulse")
        kind = {"quantity": "acceleration", "drift_order": 0}
        model.motion("pulse", values=pulse, time_step=1e-3, scale=scale, **kind)
        model.measured_point("centre", BASE / 2, HEIGHT / 2, block="dam")
        data = sitedda.run(model).history.load()
        balance = abs(data.energy_balance.values).max()
        assert balance < 1e-9 * abs(data.energy_water.values).max()
        displacements.append(data.displacement.values[:, 0, 0])
    stiffness, mass = (m.toarray()[:3, :3] for m in matrices(model)[:2])

    def rate(t, state):
        force = -mass[:, 0] * np.interp(t, time, pulse) - stiffness @ state[:3]
        return [*state[3:], *np.linalg.solve(mass, force)]

    exact = solve_ivp(rate, (0, 0.3), np.zeros(6), t_eval=time, rtol=1e-9, atol=1e-12).y[0]
    displacement = displacements[0] - displacements[1]
    exact, bound = exact[-len(displacement) :], 3e-3 * abs(exact).max()
    np.testing.assert_allclose(displacement, exact, atol=bound)


def test_an_emptied_reservoir_has_no_added_mass():
    """The water moves with the face until a stage removes the reservoir."""
    model = dam(steps=None)
    model.load(BASE / 2, HEIGHT / 2, force_x=[5e5, 5e5], time=[0.0, 1.0])
    model.stage(name="full", steps=100)
    model.stage(name="empty", steps=100, drop="reservoir")
    data = sitedda.run(model).history.load()
    after_motion = data.time.values > 0.01005
    assert (data.energy_water.values[~after_motion][1:] > 0.0).all()
    assert (data.energy_water.values[after_motion] == 0.0).all()
    scale = abs(data.energy_kinetic.values).max()
    assert abs(data.energy_balance.values).max() < 1e-9 * scale


def test_an_unsupported_block_has_three_rigid_modes():
    """The added mass of the water does not change the number of rigid modes."""
    model = dam()
    model.clear("boundary")
    assert abs(sitedda.modes(model, 3).frequency).min() > 1.0  # elastic modes only
