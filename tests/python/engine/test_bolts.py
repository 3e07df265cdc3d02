# SPDX-License-Identifier: GPL-3.0-or-later
"""Bolts against closed forms: stiffness, pretension, yield, rupture, joints that they cross."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

import sitedda
from sitedda.model import Model
from sitedda_evidence.model import energy_residual

STIFFNESS, MASS = 1.0e6, 2000.0  # N/m, kg/m


def rock(penalty: float, young: float, boxes: dict, joint=None, **control) -> Model:
    """Rectangles (left, bottom, right, top); the first is fixed."""
    model = Model("Rock", **({"time_step": 1e-3, "gravity": (0.0, -10.0)} | control))
    model.contact(normal_stiffness=penalty)
    model.material("rock", density=2000.0, young_modulus=young, poisson_ratio=0.0)
    model.joint("joint", **({"friction_angle": 30.0} | (joint or {})))
    for name, (left, low, right, high) in boxes.items():
        model.block([(left, low), (right, low), (right, high), (left, high)], name=name)
    name, (left, low, right, high) = next(iter(boxes.items()))
    for x in (left, right):
        model.fixed_point(x, (low + high) / 2, name)
    return model


def hanging(steps=2000, gravity=10.0, **bolt) -> Model:
    """A block of 2000 kg/m that hangs on a bolt, 2 m below a fixed block."""
    boxes = {"above": (0, 3, 1, 4), "below": (0, 0, 1, 1)}
    model = rock(1e10, 1e12, boxes, time_step=1e-4, steps=steps, gravity=(0.0, -gravity))
    model.output(history_interval=10)
    values = {"axial_stiffness": STIFFNESS, "compression": True} | bolt
    model.bolt("tie", (0.5, 3.5), (0.5, 0.5), **values)
    return model


def test_force_and_elongation_at_rest():
    """F = W, s = (W − pretension)/k; the other end does not rotate."""
    model = hanging(steps=1, pretension=5e3)
    model.control(settle=True)
    history = model.run().history
    assert history.bolt_force[-1, 0] == pytest.approx(20e3, rel=1e-6)
    assert history.bolt_elongation[-1, 0] == pytest.approx(15e3 / STIFFNESS, rel=1e-5)
    assert history.bolt_state[-1, 0] == 1
    assert history.bolt.values.tolist() == ["tie"]


def test_bolts_can_be_read_between_steps():
    """The weight is the bolt force; a model without bolts has no bolts."""
    model = hanging(steps=1, pretension=5e3)
    model.control(settle=True)
    with sitedda.Simulation(model) as run:
        run.advance(1)
        bolts = run.bolts
    assert bolts["force"] == pytest.approx([20e3], rel=1e-6)
    assert bolts["elongation"] == pytest.approx([15e3 / STIFFNESS], rel=1e-5)
    assert bolts["shear_force"].tolist() == [0.0]
    assert bolts["state"].tolist() == [1]
    model.clear("bolt")
    model.control(settle=None)
    with sitedda.Simulation(model) as run:
        assert [len(values) for values in run.bolts.values()] == [0, 0, 0, 0]


def test_a_mass_on_a_bolt_oscillates():
    """s = (g/ω²)(1 − cos ωt) under sudden gravity, with damping ωΔt/4 of the scheme."""
    history = hanging(steps=3000).run().history
    omega = math.sqrt(STIFFNESS / MASS)
    expected = 10.0 / omega**2 * (1.0 - np.cos(omega * history.time))
    damped = 1.0 - math.exp(-0.25 * omega * 1e-4 * omega * 0.3)
    assert abs(history.bolt_elongation[:, 0] - expected).max() < 1.5 * damped * 20e3 / STIFFNESS
    assert history.bolt_force.max() == pytest.approx(40e3, rel=2.0 * damped)
    assert energy_residual(history) < 1e-9


def bouncing(*bolt) -> Model:
    """A block that falls by 0.5 m, with half of its velocity left after an impact."""
    boxes = {"floor": (-1, -1, 2, 0), "block": (0, 0.5, 1, 1.5)}
    model = rock(1e9, 1e10, boxes, {"restitution": 0.5}, steps=800)
    model.measured_point("top", 0.5, 1.5)
    for values in bolt:
        model.bolt("tie", (0.5, -0.5), (0.5, 1.0), **values)
    return model


def test_a_bolt_without_force_does_not_change_impacts():
    """If a bolt yields, the step is repeated from its start, without its first impact."""
    free = bouncing().run().history
    bolted = bouncing({"axial_stiffness": 10.0, "yield_force": 1e-3}).run().history
    assert abs(bolted.bolt_force).max() <= 1e-3
    for name in ("displacement", "energy_impact", "energy_algorithmic"):
        assert_allclose(bolted[name].values[-1], free[name].values[-1], atol=1e-3)


def test_a_yielding_bolt_stops_its_block():
    """A bolt that yields at 1.5 W stops the block when (F_y − W) x equals the energy at yield."""
    history = hanging(steps=4000, yield_force=30e3).run().history
    elastic = 30e3 / STIFFNESS  # W x = ½ k x² + ½ m v² at yield, then F_y − W brakes
    largest_elongation = elastic + (20e3 * elastic - 0.5 * STIFFNESS * elastic**2) / (30e3 - 20e3)
    assert history.bolt_force.max() == pytest.approx(30e3, rel=1e-12)
    assert history.bolt_elongation.max() == pytest.approx(largest_elongation, rel=5e-3)
    plastic = float(history.energy_yield[-1]) / 30e3
    assert plastic == pytest.approx(largest_elongation - elastic, rel=5e-3)
    assert set(np.unique(history.bolt_state)) == {1, 2}
    assert energy_residual(history) < 1e-9


def test_rupture_lets_the_block_fall():
    history = hanging(steps=3000, rupture_elongation=0.025).run().history
    assert history.bolt_state[-1, 0] == 4
    assert history.bolt_force[-1, 0] == 0.0
    elongation = math.sqrt(float(history.energy_yield[-1]) / (0.5 * STIFFNESS))  # at rupture
    omega = math.sqrt(STIFFNESS / MASS)
    speed = 10.0 / omega * math.sqrt(1.0 - (1.0 - 0.025 * omega**2 / 10.0) ** 2)
    assert 0.025 <= elongation < 0.025 + speed * 1e-4  # it breaks in the step of this elongation
    speed = history.energy_kinetic.diff("time")[-3:] > 0.0
    assert speed.all()
    assert energy_residual(history) < 1e-9


def test_a_cable_takes_no_compression():
    """A block that moves up against gravity is free until it returns."""
    model = hanging(steps=600, gravity=0.0, compression=False)
    model["material"][0](initial_velocity=(0.0, 0.1, 0.0))
    history = model.run().history
    assert (history.bolt_force[1:, 0] == 0.0).all()
    assert (history.bolt_state[1:, 0] == 3).all()
    assert energy_residual(history) < 1e-9


DIP, FRICTION = math.radians(30.0), math.radians(20.0)
SHEAR_STIFFNESS = 1e7  # N/m
# Part of the weight of a layer of 4 m² that friction does not carry, N/m
LEFT = 80e3 * (math.sin(DIP) - math.cos(DIP) * math.tan(FRICTION))


def grouted(**bolt) -> Model:
    """Three layers on a 30° slope, in its axes, with a bolt grouted across both joints."""
    boxes = {"base": (-5, -2, 9, 0), "lower": (0, 0, 4, 1), "upper": (0, 1, 4, 2)}
    model = rock(1e11, 1e13, boxes, {"friction_angle": math.degrees(FRICTION)}, steps=1)
    model.control(settle=True, gravity=(10.0 * math.sin(DIP), -10.0 * math.cos(DIP)))
    model.contact(shear_ratio=1.0)
    values = {"axial_stiffness": 1e7, "shear_stiffness": SHEAR_STIFFNESS} | bolt
    model.bolt("dowel", (2.0, 1.5), (2.0, -0.5), grouted=True, **values)
    return model


def test_a_grouted_bolt_carries_the_load_beyond_friction():
    """Its shear force at a joint is W sin α − W cos α tan φ of the blocks above."""
    history = grouted().run().history
    assert history.bolt.values.tolist() == ["dowel", "dowel"]
    assert history.bolt_block.values.tolist() == [[2, 1], [1, 0]]
    shear_force = abs(history.bolt_shear_force[-1].values)
    assert shear_force == pytest.approx([LEFT, 2.0 * LEFT], rel=1e-3)
    assert abs(history.bolt_force[-1].values).max() < 1e-2 * LEFT


def test_a_grouted_bolt_turns_with_its_blocks():
    """Rigid rotation of both blocks together stretches neither component."""
    glued = {"cohesion": 1e9, "tensile_strength": 1e9}
    model = rock(1e10, 1e12, {"a": (0, 0, 1, 1), "b": (1, 0, 2, 1)}, glued, steps=200)
    model.clear("fixed_point")
    model.control(gravity=None)
    model.bolt("dowel", (0.5, 0.5), (1.5, 0.5), grouted=True, axial_stiffness=1e6,
               shear_stiffness=1e6, pretension=0.0, compression=True)  # fmt: skip
    with sitedda.Simulation(model) as run:
        rates = np.zeros((2, 6))
        rates[:, 1] = (-0.5, 0.5)
        rates[:, 2] = 1.0
        run.rates = rates
        run.advance(200)
        assert run.coordinates[0, 2] == pytest.approx(0.2, rel=1e-3)
        spring_energy = run.energies["support"]
    assert spring_energy < 1e-6 * 0.5 * 2 * 2000.0


@pytest.mark.parametrize("limit", ["shear_yield_force", "rupture_slip"])
def test_shear_yield_and_rupture_of_a_grouted_bolt(limit):
    """The lower joint carries the excess of both blocks: the bolt must not fail below this load."""
    limit_value = 2.0 * LEFT if limit == "shear_yield_force" else 2.0 * LEFT / SHEAR_STIFFNESS
    intact = grouted(**{limit: 1.02 * limit_value}).run().history
    assert abs(intact.bolt_shear_force[-1, 1]) == pytest.approx(2.0 * LEFT, rel=1e-3)
    with pytest.raises(sitedda.ConvergenceError, match="does not settle"):
        grouted(**{limit: 0.98 * limit_value}).run()


def test_stages_add_and_drop_bolts():
    """A bolt of a later stage has its pretension; a removed bolt has no force."""
    model = hanging(pretension=20e3)
    model.control(settle=None, steps=None)
    model.stage(name="hold", kind="static")
    model.stage(name="hang", kind="static", add="tie", remove="prop")
    model.stage(name="wait", steps=50)
    model.stage(name="fall", steps=1000, drop="t*")
    model.block([(0, -1), (1, -1), (1, 0), (0, 0)], name="prop")
    for x in (0.0, 1.0):
        model.fixed_point(x, -1.0, "prop")
    history = model.run().history
    assert history.bolt_state[:, 0].values[[0, 1, 3, -1]].tolist() == [0, 1, 1, 0]
    assert history.bolt_force[1, 0] == pytest.approx(20e3, rel=1e-3)
    assert history.bolt_force[-1, 0] == 0.0
    kinetic_energy = 0.5 * MASS * (10.0 * 0.1) ** 2
    assert float(history.energy_kinetic[-1]) == pytest.approx(kinetic_energy, rel=2e-2)
    assert energy_residual(history) < 1e-6


def test_both_programs_and_resumed_runs_are_bit_identical(tmp_path, same_everywhere):
    model = hanging(steps=1200, yield_force=30e3)
    model.output(block_interval=400)
    same_everywhere(model.write(tmp_path / "model.nml"), 800)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"to": (0.5, 2.0)}, "the point (0.5, 2) lies outside every block"),
        ({"from": (0.2, 0.5)}, "all points of the bolt are in the same block, 'below'"),
        ({"axial_stiffness": -1.0}, "axial_stiffness"),
        ({"shear_stiffness": 1e6}, "grouted = .true."),
        ({"pretension": 2e4, "yield_force": 1e4}, "is above yield_force"),
        ({"name": None}, "name is missing"),
    ],
)
def test_bad_bolts_are_refused(changes, message):
    model = hanging()
    model["bolt"][0](**changes)
    with pytest.raises(sitedda.InputError, match=r"^Model\.bolt\(…\), ") as error_info:
        sitedda.Simulation(model)
    assert message in str(error_info.value)


def test_a_stage_with_unknown_bolts_is_refused():
    model = hanging()
    model.stage(name="one", steps=5, add="nothing")
    model.control(steps=None)
    with pytest.raises(sitedda.InputError, match="add: nothing is named 'nothing'"):
        sitedda.Simulation(model)


def leaning(**bolt) -> np.ndarray:
    """Frequencies at rest of a block that is supported by friction and a bolt, Hz."""
    boxes = {"floor": (-1, -1, 2, 0), "block": (0, 0, 1, 1)}
    model = rock(1e9, 1e10, boxes, steps=1, gravity=(2.0, -10.0), settle=True)
    if bolt:
        model.bolt("tie", (-0.5, -0.1), (0.5, 0.5), axial_stiffness=1e8, **bolt)
    return sitedda.modes(model, contacts="settled").frequency


def test_a_bolt_that_breaks_in_a_static_stage_does_not_affect_modes():
    """The frequencies equal those without the bolt, with all contacts."""
    assert_allclose(leaning(rupture_elongation=1e-7), leaning(), rtol=1e-9)
    assert leaning(yield_force=1e9)[0] > 1.05 * leaning()[0]
