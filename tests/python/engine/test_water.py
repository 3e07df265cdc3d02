# SPDX-License-Identifier: GPL-3.0-or-later
"""Tractions and water on edges against statics."""

import math

import numpy as np
import pytest
from random_content import random_model

import sitedda
from sitedda.model import Model
from sitedda_evidence.model import energy_residual

WATER = 9810.0  # N/m³


def block_on_floor(width=2.0, height=3.0, **control) -> Model:
    """A block of 25 kN/m³ on a fixed floor."""
    model = Model("Block on a floor", time_step=1e-3, steps=1, settle=True, gravity=(0, -10))
    model.control(**control)
    model.contact(normal_stiffness=1e10, shear_ratio=1.0)
    model.material("rock", density=2500.0, young_modulus=1e13, poisson_ratio=0.2)
    model.joint("joint", friction_angle=30.0)
    model.block([(-4, -1), (6, -1), (6, 0), (-4, 0)], name="floor")
    model.block([(0, 0), (width, 0), (width, height), (0, height)], name="block")
    for x in (-4.0, 6.0):
        model.fixed_point(x, -1.0, "floor")
    return model


def reaction(model) -> np.ndarray:
    """Force of the floor on the block at rest, x and y (N/m), and its moment about (0, 0) (N)."""
    with sitedda.Simulation(model) as run:
        contacts, polygons = run.contacts, run.polygons
    owner = np.repeat(np.arange(2), [*map(len, polygons)])
    positions = np.vstack(polygons)
    after = np.array([*range(1, 4), 0, *range(5, 8), 4])
    resultant = np.zeros(3)
    for v, e, normal, shear in zip(
        *(contacts[k] for k in ("vertex", "edge", "normal_force", "shear_force")), strict=True
    ):
        edge_vector = positions[after[e]] - positions[e]
        edge_vector /= np.hypot(*edge_vector)
        force = normal * np.array([edge_vector[1], -edge_vector[0]]) - shear * edge_vector
        force = np.append(force, positions[v, 0] * force[1] - positions[v, 1] * force[0])
        resultant += force if owner[v] == 1 else -force
    return resultant


@pytest.mark.parametrize("level", [0.5, 1.5, 3.0, 7.0])
def test_buoyancy(level):
    """Water in the joint and around the block lifts it by ρ_w g V of its immersed volume."""
    model = block_on_floor()
    model.water(surface=(-4.0, level, 6.0, level))
    submerged_area = 2.0 * min(level, 3.0)
    uplift = 6.0 * 25e3 - submerged_area * WATER
    assert reaction(model) == pytest.approx([0.0, uplift, uplift], abs=2.0)


def test_water_on_faces_alone_does_not_lift():
    model = block_on_floor()
    model.water(surface=(-4.0, 5.0, 6.0, 5.0), acts_on="faces")
    vertical_force = 6.0 * 25e3 + 2.0 * 2.0 * WATER
    assert reaction(model) == pytest.approx([0.0, vertical_force, vertical_force], abs=2.0)


def test_an_inclined_water_table_pushes_sideways():
    """½ γ (h₁² − h₂²) at a third of the heights; the joint has the pressure of the water table."""
    model = block_on_floor()
    model.water(surface=(-4.0, 2.5, 0.0, 2.5, 2.0, 1.0, 6.0, 1.0))
    thrust = 0.5 * WATER * (2.5**2 - 1.0**2)
    uplift = WATER * 0.5 * (2.5 + 1.0) * 2.0
    moment = WATER * ((2.5**3 - 1.0**3) / 6 - 3.0)
    expected = [-thrust, 6.0 * 25e3 - uplift, 6.0 * 25e3 + moment]
    assert reaction(model) == pytest.approx(expected, abs=3.0)


def test_pressure_along_a_joint_and_its_change_in_time():
    """Uplift of pressures p₁ … p₂ is their mean times the length; `scale` changes with time."""
    model = block_on_floor()
    model.water(name="uplift", along=(0, 0, 2, 0), pressure=(30e3, 10e3), time=(0.0, 1.0),
                scale=(0.5, 1.0))  # fmt: skip
    assert reaction(model)[1] == pytest.approx(6.0 * 25e3 - 0.5 * 20e3 * 2.0, abs=2.0)
    groups = block_on_floor(settle=None, steps=None)
    groups.water(name="uplift", along=(0, 0, 2, 0), head=(3.0, 3.0))
    groups.stage(name="dry", kind="static")
    groups.stage(name="wet", kind="static", add="uplift")
    groups.stage(name="dry again", kind="static", drop="uplift")
    history = groups.run().history
    data = history.assign_coords(stage=("time", history.stage.values))
    forces = [float(data.contact_normal_force[data.contact_frame == f].sum()) for f in range(3)]
    assert forces == pytest.approx([150e3, 150e3 - 2 * 3 * WATER, 150e3], rel=1e-4)
    assert energy_residual(history) < 1e-6


def test_tractions():
    """Normal and shear tractions and a water level, on edges by side and by number."""
    model = block_on_floor()
    model.traction(along=(0, 3, 2, 3), normal=10e3, shear=4e3)
    model.traction(blocks="block", edges=[4], level=2.0)
    # Counter-clockwise along the top is to the left; edge 4 is the left face.
    thrust = 0.5 * WATER * 2.0**2
    expected = [4e3 * 2.0 - thrust, 150e3 + 20e3, 146e3 + WATER * 2.0**3 / 6]
    assert reaction(model) == pytest.approx(expected, abs=3.0)


@pytest.mark.parametrize("follows", [True, False])
def test_tractions_that_follow_turn_with_the_block(follows):
    """A free block under a traction on one face, rotated by 90°: the force rotates or does not."""
    model = Model("Turning block", time_step=1e-3, steps=400)
    model.contact(normal_stiffness=1e10)
    model.material("rock", density=1000.0, young_modulus=1e12, poisson_ratio=0.0)
    model.joint("joint", friction_angle=30.0)
    model.block([(0, 0), (1, 0), (1, 1), (0, 1)], name="block")
    model.traction(blocks="block", edges=[1], normal=[0.0, 0.0, 1e3, 1e3], follows=follows,
                   time=[0.0, 0.2, 0.2, 1.0])  # fmt: skip
    with sitedda.Simulation(model) as run:
        rates = np.zeros((1, 6))
        rates[0, 2] = 2.5 * math.pi
        run.rates = rates
        run.advance(199)
        assert np.hypot(*run.rates[0, :2]) < 1e-9
        run.advance(21)
        x, y = run.rates[0, :2]
        energies = run.energies
    assert np.hypot(x, y) == pytest.approx(0.021, rel=0.03)
    assert (x, y) == pytest.approx((-0.021, 0.0) if follows else (0.0, 0.021), abs=0.003)
    assert abs(energies["balance"]) < 1e-6 * abs(energies["input"]) + 1e-9


@pytest.mark.parametrize(
    ("group", "values", "message"),
    [
        ("water", {"surface": (-9, 1, 6, 1)}, "outside the model, which reaches from x = "),
        ("water", {"surface": (3, 1, 0, 1)}, "x must increase"),
        ("water", {"along": (0, 0, 0, -0.5), "head": (1, 1)}, "away from its joints and faces"),
        ("water", {"along": (0, 0, 2, 0)}, "along needs head or pressure"),
        ("water", {"along": (0, 0, 2, 0), "head": (1, 1, 1)}, "as many values as `along`"),
        ("water", {}, "give surface or along"),
        (
            "water",
            {"along": (0, 0, 2, 0), "pressure": (1, 1), "time": (0, 1), "scale": (-1, 1)},
            "scale",
        ),
        ("water", {"surface": (0, 1, 2, 1), "joints": "clay"}, "joints: nothing is named 'clay'"),
        ("traction", {"side": "left"}, "give normal or shear or level"),
        (
            "traction",
            {"side": "left", "level": 1.0, "normal": 1.0},
            "give either level or normal, not both",
        ),
        ("traction", {"side": "left", "normal": (1, 2)}, "as many values as `time`"),
        ("traction", {"normal": 1.0}, "the group selects no edges"),
    ],
)
def test_bad_loads_are_refused(group, values, message):
    model = block_on_floor()
    model.add(group, **values)
    with pytest.raises(sitedda.InputError, match=rf"^Model\.{group}\(…\), ") as error_info:
        sitedda.Simulation(model)
    assert message in str(error_info.value)


@pytest.mark.parametrize("seed", [59, 291])
def test_a_water_table_through_nodes_is_found(seed):
    """Slopes with nodes that are neither wet nor dry in some steps, but at the table."""
    text = random_model(seed)
    assert "state = 'steady'" in text
    run = sitedda.run(sitedda.Model.from_namelist(text))
    assert run.complete
    assert "water table" not in run.summary + run.history.attrs["doubts"]


@pytest.mark.parametrize("state", ["steady", "undrained"])
def test_a_block_without_support_falls_also_beside_a_wet_joint(state):
    model = sitedda.Model("fall", time_step=1e-3, gravity=(0, -9.81))
    model.material("rock", density=2500.0, young_modulus=1e10, poisson_ratio=0.2)
    model.joint("joint", friction_angle=35.0, normal_stiffness_per_area=1e10,
                shear_stiffness_per_area=1e10)  # fmt: skip
    model.block([(-2, -1), (6, -1), (6, 0), (-2, 0)], name="base")
    model.block([(0, 0), (4, 0), (4, 2), (0, 2)], name="dam")
    model.block([(10, 0), (11, 0), (11, 1), (10, 1)], name="loose")
    model.fixed_point(-1.5, -0.5)
    model.fixed_point(5.5, -0.5)
    model.flow(aperture=1e-3, channel_length=1.0, state_at_rest=state)
    model.stage("rest", kind="static")
    with pytest.raises(sitedda.ConvergenceError, match="block 3 'loose' falls"):
        sitedda.run(model, output=False)
