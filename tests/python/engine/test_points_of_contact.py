# SPDX-License-Identifier: GPL-3.0-or-later
"""Contact points between corners: positions in files and pictures, warning about bending bonds."""

import re

import numpy as np
import pytest

import sitedda
from sitedda.drawing.view.encode import encode
from sitedda.model import Model
from sitedda.pictures import neighbour_forces
from sitedda.scene import Scene
from sitedda.vtk import contacts_of

WEIGHT = 2000.0 * 9.81  # weight of the glued block, N/m; bending stress 6 W/2 = 58.86 kPa


def bracket(steps: int = 40, **joint) -> Model:
    """A block of 1 m that is glued to a wall by one side, and a brick that is pushed along it."""
    model = Model("Bracket", time_step=1e-3, steps=steps, settle=True)
    model.control(gravity=(0.0, -9.81))
    model.contact(normal_stiffness=1e9)
    model.material("stone", density=2000.0, young_modulus=1e12, poisson_ratio=0.2)
    model.material("foam", density=10.0, young_modulus=1e12, poisson_ratio=0.2)
    bond = {"friction_angle": 20.0, "cohesion": 1e6, "tensile_strength": 62e3}
    model.joint("mortar", **(bond | joint))
    model.joint("dry", friction_angle=10.0, contact_points=5)
    model.block([(-1, -2), (0, -2), (0, 3), (-1, 3)], name="wall", material="stone", joint="mortar")
    model.block([(0, 0), (1, 0), (1, 1), (0, 1)], name="block", material="stone", joint="mortar")
    model.block(
        [(0.2, 1.0), (0.6, 1.0), (0.6, 1.2), (0.2, 1.2)], name="brick", material="foam", joint="dry"
    )
    for y in (-1.5, 2.5):
        model.fixed_point(-0.5, y)
    model.load(0.4, 1.0, time=(0.0, 1e-3, 1.0), force_x=(0.0, 5.0, 5.0), block="brick")
    return model


def test_closed_contacts_are_a_subset_of_contacts():
    with sitedda.Simulation(bracket(contact_points=3)) as run:
        run.advance(40)
        contacts, is_pressed = run.contacts, run.contacts["normal_force"] > 0.0
        names = ("vertex", "edge", "place", "normal_force", "shear_force")
        expected = np.column_stack([contacts[name][is_pressed] for name in names])
        assert 0 < is_pressed.sum() < len(is_pressed) and expected[:, 2].any()
        np.testing.assert_array_equal(run.closed_contacts, expected)


@pytest.fixture(scope="module")
def bracketed(tmp_path_factory):
    model = bracket(contact_points=3)
    model.output(block_interval=20)
    return model.run(output=tmp_path_factory.mktemp("bracket") / "out.nc")


def test_points_have_positions(bracketed):
    """In the output, in pictures and for ParaView; on the brick, the points move along with it."""
    scene = Scene.of(bracketed)
    frame = scene.frames - 1
    contacts = scene.contacts(frame)
    positions, _ = scene.contact_points(frame, contacts)
    between = contacts["place"] > 0.0
    is_bonded = between & (contacts["bonded"] == 1)
    np.testing.assert_allclose(positions[is_bonded], [[0.0, 0.5]], atol=1e-3)
    slide = scene.coordinates(frame)[2, 0] - 0.4
    assert slide > 1e-3
    offsets = 0.2 * np.array([-1, 0, 1]) * np.sqrt(3 / 7)
    np.testing.assert_allclose(np.sort(positions[between & ~is_bonded, 0]), 0.4 + slide + offsets,
                               atol=1e-2 * slide)  # fmt: skip
    assert len(contacts_of(scene, frame).points) == 2 * len(contacts["normal_force"])


def test_resultants_pass_through_the_points(bracketed):
    """The weight of the brick acts under its middle, in pictures and in the view."""
    scene = Scene.of(bracketed)
    frame = scene.frames - 1
    positions, force = neighbour_forces(scene, frame, scene.vertices(frame))
    brick = np.argmin(np.linalg.norm(positions - scene.coordinates(frame)[2, :2], axis=1))
    np.testing.assert_allclose(abs(force[brick, 1]), 10.0 * 0.08 * 9.81, rtol=1e-2)
    assert encode(scene, 10**7).meta["pairs"] >= 5 + 1


def test_simulation_has_the_positions(tmp_path):
    with sitedda.Simulation(bracket(contact_points=5).write(tmp_path / "model.nml")) as run:
        fractions = run.contacts["place"][run.contacts["bonded"] == 1]
        np.testing.assert_allclose(np.sort(fractions)[2:],
                                   0.5 + 0.5 * np.sqrt(3 / 7) * np.array([-1, 0, 1]))  # fmt: skip


def said(model: Model, binary, tmp_path, main) -> list[str]:
    """Lines about bending in run, native run, check and native check."""
    file = model.write(tmp_path / "model.nml")
    texts = []
    for call in (main, binary):
        for arguments in (("run", file, "--quiet"), ("check", file)):
            process = call(*arguments, folder=tmp_path)
            texts.append(re.sub(r"\n {7,}", " ", process.stdout + process.stderr))
    return [line for text in texts for line in text.splitlines() if "three times too high" in line]


def test_a_bending_bond_causes_one_line(binary, tmp_path, main):
    """The line has the end stress by beam theory; no line with points or without bending."""
    bent = said(bracket(contact_points=2), binary, tmp_path, main)
    assert len(bent) == 4
    for line in bent:
        tension = float(re.search(r"tension of (\S+) Pa at one end", line)[1])
        assert tension == pytest.approx(3 * WEIGHT, rel=2e-2)
        assert "'mortar'" in line and "contact_points = 5" in line  # it has a static stage
    assert said(bracket(contact_points=3), binary, tmp_path, main) == []
    hanging_model = bracket(contact_points=2)
    hanging_model.control(gravity=(9.81, 0.0))
    assert said(hanging_model, binary, tmp_path, main) == []
