# SPDX-License-Identifier: GPL-3.0-or-later
"""Cohesive joints: strength, fracture energy, and friction that increases with damage."""

import re
from pathlib import Path

import numpy as np
import pytest
from matplotlib.text import Text
from test_points_of_contact import bracket

import sitedda
from sitedda.engine import reduced_group
from sitedda.output.scene import Scene
from sitedda.vtk import contacts_of
from sitedda_evidence import model as nml
from sitedda_evidence.validation.cohesive import HEIGHT, RISE, bar, bracket_of


@pytest.mark.parametrize(
    ("length", "energy", "softening"), [(2.0, 60.0, "linear"), (1.0, 60.0, "exponential")]
)
def test_bounds_are_close_at_the_time_step_of_check(length, energy, softening, tmp_path):
    """A bar snaps at the Δt below which check promises that the bounds differ by at most 10 %."""
    file = tmp_path / "bar.nml"

    def text(steps: int) -> str:
        model = bar(steps, 2.2e-4 * length, length, softening=softening, fracture_energy=energy)
        return model.replace("block_interval = 1 ", f"block_interval = {steps} ")

    file.write_text(text(10))
    report = " ".join(str(sitedda.check(file)).split())
    step = float(re.search(r"below ([0-9.Ee+-]+) s the bounds", report)[1])
    lower, upper = bracket_of(nml.history(text(int(0.2 / step) + 1)))
    assert lower < energy * HEIGHT < upper
    assert upper - lower < 0.1 * energy * HEIGHT


@pytest.mark.parametrize(("strength", "is_intact"), [(56e3, False), (62e3, True)])
def test_flexural_strength(strength, is_intact, tmp_path):
    """Self-weight stresses a glued block by 6M/L² = 58.86 kPa, with three contact points."""
    stiffness = 1e12
    model = bracket(steps=200, law="cohesive", tensile_strength=strength,
                    fracture_energy=0.75 * strength**2 / stiffness, shear_fracture_energy=100.0,
                    normal_stiffness_per_area=stiffness)  # fmt: skip
    model.output(block_interval=200)
    data = model.run(output=tmp_path / "out.nc").history
    is_bonded = (data.contact_joint.values == 0) & (data.contact_frame.values == 1)
    assert is_bonded.sum() >= 3
    assert (data.contact_damage.values[is_bonded].max() < 1e-6) == is_intact


def test_unconverged_damage_is_reported(tmp_path):
    """A joint breaks within one step, far beyond the softening limit of check."""
    results = {
        steps: sitedda.run(_written(tmp_path, bar(steps, 4e-4, 2.0))).summary
        for steps in (40, 20000)
    }
    assert "the damage of cohesive joints did not converge" in results[40]
    assert "did not converge" not in results[20000]


def _written(folder: Path, text: str) -> Path:
    file = folder / "model.nml"
    file.write_text(text)
    return file


def test_studies_and_options_change_the_fracture_energy(tmp_path):
    file = _written(tmp_path, bar(400, 8e-5))
    energies = [30.0, 60.0]
    dissipated = sitedda.study(
        file, {"joint.j.fracture_energy": energies}, ["energy_fracture.last"], folder=tmp_path / "c"
    )["energy_fracture.last"].values
    np.testing.assert_allclose(dissipated, np.multiply(energies, HEIGHT), rtol=1e-2)
    history = sitedda.run(file, joint={"fracture_energy": 30.0}).history
    assert float(history.energy_fracture[-1]) == dissipated[0]


def test_the_law_unloads_to_the_origin_and_closes_completely():
    """A half damaged joint is closed: under compression its normal force is that of the springs."""
    text = bar(400, 8e-5)
    opening = 5.5e-5 * np.concatenate([RISE[::3], RISE[-2::-3], -RISE[2::3]])
    values = "values = " + ", ".join(repr(float(v)) for v in opening[:101])
    start = text.index("values", text.index("&motion"))
    end = text.index("/", start)
    data = nml.history(text[:start] + values + text[end:])
    damage = data.contact_damage.values
    frame = data.contact_frame.values
    assert (np.diff(damage[::3]) >= 0).all() and 0.0 < damage[-1] < 1.0
    is_last = frame == frame.max()
    pressure = data.contact_normal_force.values[is_last] / data.contact_length.values[is_last]
    assert pressure == pytest.approx(-2e12 * data.contact_gap.values[is_last], rel=1e-2)
    assert nml.energy_residual(data) < 1e-6


def test_a_factor_divides_the_strength_but_not_the_openings():
    text = (
        "&joint name = 'j', law = 'cohesive', friction_angle = 30, cohesion = 2e6, "
        "tensile_strength = 1e6, fracture_energy = 50, normal_stiffness_per_area = 1e11 /"
    )
    group = reduced_group(text, 2.0)
    assert group["tensile_strength"] == 5e5 and group["cohesion"] == 1e6
    assert group["fracture_energy"] == 25.0 and group["shear_fracture_energy"] == 250.0


def test_pictures_views_and_paraview_have_the_damage(tmp_path):
    """The scene of all of them shows an intact, a half damaged and a broken joint."""
    file = _written(tmp_path, bar(400, 8e-5))
    run = sitedda.run(file, tmp_path / "o.nc")
    scene = Scene.of(run)
    damage = np.array([scene.own_quantity("damage", f).max() for f in range(scene.frames)])
    assert damage[0] == 0.0 and damage[-1] == 1.0 and (np.diff(damage) >= 0.0).all()
    frame = int(np.argmax(damage > 0.1))
    assert damage[frame] < 1.0
    values = contacts_of(scene, frame).cells["damage"]
    assert values.max() == pytest.approx(damage[frame])
    axes = sitedda.draw(run, time=float(scene.time[-1]), color="damage")
    assert any("damage" in text.get_text() for text in axes.figure.findobj(Text))
    assert "largest damage of faces and joints" in run.view(tmp_path / "v.html").read_text()


@pytest.mark.parametrize("energy_per_area", [1.0, 1e-3])
def test_safety_of_a_glued_block(energy_per_area, tmp_path):
    """On a plane F = (c L + W cos α tan φ)/(W sin α), independent of the fracture energy."""
    angle, length, height, bond_strength = np.radians(35.0), 2.0, 0.05, 200.0

    def rotated_rectangle(*shape: float) -> list[tuple[float, float]]:
        c, s = np.cos(angle), np.sin(angle)
        return [(x * c + y * s, y * c - x * s) for x, y in nml.rectangle(*shape)]

    text = nml.text(
        nml.control(1e-3, 100, (0.0, -nml.GRAVITY), settle=True),
        nml.contact(1e9),
        nml.material("rock", 2500.0, 1e11),
        nml.joint("j", 30.0, law="cohesive", cohesion=bond_strength, tensile_strength=bond_strength,
                  fracture_energy=energy_per_area / 10, shear_fracture_energy=energy_per_area,
                  normal_stiffness_per_area=1e9),
        nml.fixed_block("base", rotated_rectangle(-1, -1, length + 2, 1), "rock", "j"),
        nml.block("top", rotated_rectangle(0, 0, length, height), "rock", "j"),
    )  # fmt: skip
    weight = 2500.0 * nml.GRAVITY * length * height
    held_back = bond_strength * length + weight * np.cos(angle) * np.tan(np.radians(30.0))
    result = sitedda.safety(_written(tmp_path, text))
    assert result.factor == pytest.approx(held_back / (weight * np.sin(angle)), rel=3e-3)


def test_unresolved_joints_are_reported(tmp_path):
    """Zone EG/T² = 0.3 m; half of 250 kg/m² at T²/2G = 33 GPa/m: Δt < 0.087 ms at χ = ½."""
    file = tmp_path / "model.nml"
    for steps, energy, zone, step in ((2000, 60.0, 0, 1), (4000, 60.0, 0, 0), (8000, 6.0, 1, 0)):
        file.write_text(bar(steps, 8e-5, fracture_energy=energy))
        notes = " ".join(str(sitedda.check(file)).split())
        assert ("the cohesive zone" in notes) == bool(zone)
        assert ("softens within a step" in notes) == bool(step)
        if step:
            limits = re.search(r"above (\S+) s the .*; below (\S+) s the bounds", notes).groups()
            assert [float(one) for one in limits] == pytest.approx([8.7e-5, 8.7e-5 / 20], rel=5e-3)
    for energy, advice in ((15.0, "contact_points = 9 or smaller blocks"), (6.0, "smaller blocks")):
        file.write_text(bar(8000, 8e-5, fracture_energy=energy))
        assert f"try {advice}" in " ".join(str(sitedda.check(file)).split())
