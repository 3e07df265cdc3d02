# SPDX-License-Identifier: GPL-3.0-or-later
"""Cables over several points against closed forms, in addition to the validation case."""

import math

import numpy as np
import pytest

import sitedda
from sitedda.facade.model import Model
from sitedda.scene import Scene
from sitedda_evidence.model import GRAVITY, energy_residual
from sitedda_evidence.validation.cables import (
    DROP,
    HALF_SPAN,
    HEAVY,
    LIGHT,
    STIFFNESS,
    TENSION,
    atwood,
    sling,
    square,
    stiff_model,
)


def test_a_cable_yields_along_its_whole_length():
    """At constant force m₁ falls with g − F/m₁; dissipation is F × plastic elongation."""
    force = 0.5 * TENSION
    history = atwood(pretension=force, yield_force=force).run().history
    speed = history.velocity.sel(axis="y").values[-1]
    assert speed[0] == pytest.approx(-(GRAVITY - force / HEAVY) * 0.2, rel=1e-5)
    assert speed[1] == pytest.approx(-(GRAVITY - force / LIGHT) * 0.2, rel=1e-5)
    stretch = float(history.bolt_elongation[-1, 0])
    assert float(history.energy_yield[-1]) == pytest.approx(force * stretch, rel=1e-6)
    assert energy_residual(history) < 1e-9


def test_the_highest_frequency_of_a_stiff_sling():
    """ω² = k Σ u_i²/m_i over the three blocks, u = ∂L/∂x; it is between the guaranteed bounds."""
    model = sling()
    model.control(settle=None, gravity=(0.0, 0.0))
    model["bolt"][0](axial_stiffness=1e17)
    report = sitedda.check(model)
    cosine = DROP / math.hypot(HALF_SPAN, DROP)
    expected = math.sqrt(1e17 * ((2.0 * cosine) ** 2 + 1.0 + 1.0) / LIGHT)
    assert report.omega_max == pytest.approx(expected, rel=1e-4)
    message = next(line.words for line in report.lines if line.topic == "highest frequency")
    assert "governed by a bolt between block 1 'left' and block 3 'hung'" in message


def test_a_pretensioned_cable_presses_a_row_together():
    """The compressive force in each joint of the row is the cable force, without bending."""
    model = stiff_model("Row", time_step=1e-3, steps=1, settle=True)
    model.control(gravity=(0.0, 0.0))
    for i in range(3):
        model.block(square(i, 0), name=f"block_{i}", material="light")
    model.fixed_point(0.0, 0.0, "block_0")
    model.fixed_point(-0.5, 0.0, "block_0")
    model.bolt("cable", (0, 0.2), (2, 0.2), through=[(0.6, 0.2), (1.4, 0.2)],
               axial_stiffness=STIFFNESS, pretension=50e3)  # fmt: skip
    run = model.run()
    force = float(run.history.bolt_force[-1, 0])
    scene = Scene.of(run)
    contacts = scene.contacts(scene.frames - 1)
    assert force == pytest.approx(50e3, rel=1e-3)
    assert contacts["normal_force"].sum() == pytest.approx(2.0 * force, rel=1e-6)
    assert abs(run.history.energy_balance).max() < 1e-6 * run.history.energy_support.max()


def pendulum(integration="midpoint", anchor=0.5, steps=20000) -> Model:
    """A block of 2000 kg/m that swings on a bolt below a fixed block."""
    model = stiff_model("Pendulum", time_step=1e-3, steps=steps, integration=integration)
    model.output(history_interval=100)
    model.block(square(0, 5), name="above", material="light")
    model.block(square(0, 0), name="below", material="heavy")
    model["material"][1](density=LIGHT, initial_velocity=(0.1, 0.0, 0.0))
    for x in (-0.5, 0.5):
        model.fixed_point(x, 5.5, "above")
    model.bolt("tie", (0, 5), (0, anchor), axial_stiffness=1e7, pretension=LIGHT * GRAVITY)
    return model


@pytest.mark.parametrize("integration", ["dda", "midpoint"])
def test_a_pendulum_gains_no_energy(integration):
    """The scheme damps by ω²Δt/2 per second; the exact geometry adds no energy."""
    history = pendulum(integration, 0.0).run().history
    omega = math.sqrt(GRAVITY / 5.0)
    start = 0.5 * LIGHT * 0.1**2
    dissipated = float(history.energy_algorithmic[-1])
    assert dissipated == pytest.approx(
        start * (1.0 - math.exp(-0.5 * omega**2 * 1e-3 * 20.0)), rel=2e-2
    )
    assert abs(history.energy_geometric).max() < 1e-6 * start


def test_modes_of_a_pendulum():
    """The modes of a double pendulum: a bolt of length l, and the block about an anchor at a."""
    arm, radius = 0.5, 1.0 / math.sqrt(6.0)  # m; radius of gyration
    length = 5.0 - arm
    mass = np.array([[length**2, length * arm], [length * arm, arm**2 + radius**2]])
    weight = GRAVITY * np.diag([length, arm])
    expected = np.sqrt(np.linalg.eigvals(np.linalg.solve(mass, weight)).real) / (2.0 * math.pi)
    frequencies = sitedda.modes(pendulum(anchor=arm, steps=1), count=8).frequency
    for frequency in expected:
        assert abs(frequencies / frequency - 1.0).min() < 1e-4


def test_a_removed_block_removes_its_cable():
    """Also a block between the ends of the cable; both other blocks then fall freely."""
    model = atwood(steps=None, time_step=1e-3)
    model.stage(name="hang", steps=20)
    model.stage(name="cut", steps=100, remove="beam")
    history = model.run().history
    assert history.bolt_state[[0, -1], 0].values.tolist() == [1, 0]
    assert float(history.bolt_force[-1, 0]) == 0.0
    speed = history.velocity.sel(axis="y").values
    assert speed[-1] - speed[2] == pytest.approx(-GRAVITY * 0.1, rel=1e-9)


def test_threads_and_resumed_runs_are_bit_identical(tmp_path, same_everywhere):
    model = atwood(steps=1200, yield_force=1.5 * TENSION)
    model.output(block_interval=400)
    same_everywhere(model.write(tmp_path / "model.nml"), 800)


def test_pictures_show_the_points_of_a_cable():
    """Before a run and in the frames of its output."""
    model = atwood(steps=100, pretension=TENSION)
    model.output(block_interval=100)
    before = Scene.of(model).bolts(0)[0]
    assert before["places"].tolist() == [[-2, 2], [-2, 9.5], [2, 9.5], [2, 2]]
    scene = Scene.of(model.run())
    after = scene.bolts(scene.frames - 1)[0]
    fall = 0.5 * GRAVITY * 0.5 * 0.01**2
    assert after["places"][:, 1] == pytest.approx([2 - fall, 9.5, 9.5, 2 + fall], abs=1e-6)
    assert after["force"] == pytest.approx(TENSION, rel=1e-5)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"through": [(0.0, 5.0)]}, "the point (0, 5) lies outside every block"),
        ({"through": [(-2, 9.5), (-2, 9.5)]}, "are at the same position, (-2, 9.5)"),
        ({"through": [(-2.0, 2.0)]}, "are at the same position, (-2, 2)"),
        ({"to": (-2.2, 2.2), "through": [(-2.1, 2.1)]}, "all points of the bolt are in the same"),
        ({"to": None}, "to is missing"),
        ({"grouted": True}, "give either through or grouted = .true."),
        ({"compression": True}, "through or compression = .true., not both"),
        ({"through_block": ["beam", "beam", "beam"]}, "names more blocks than `through` has"),
        ({"through_block": ["left"]}, "the point (-2, 9.5) lies outside block 'left'"),
        ({"through_block": ["no"]}, "'no' is not the name or number of a block"),
    ],
)
def test_bad_cables_are_refused(changes, message):
    model = atwood()
    model["bolt"][0](**changes)
    with pytest.raises(sitedda.InputError, match=r"^Model\.bolt\(…\), ") as error_info:
        sitedda.Simulation(model)
    assert message in str(error_info.value)


def test_a_point_with_one_coordinate_is_refused(tmp_path):
    file = atwood().write(tmp_path / "model.nml")
    text = file.read_text()
    assert "9.5, 2.0, 9.5" in text
    file.write_text(text.replace("9.5, 2.0, 9.5", "9.5, 2.0"))
    with pytest.raises(sitedda.InputError, match="through: a value is missing"):
        sitedda.Simulation(file)
