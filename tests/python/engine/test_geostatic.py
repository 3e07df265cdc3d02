# SPDX-License-Identifier: GPL-3.0-or-later
"""Walls and layers with their weight as initial stress are at rest from the first step."""

import numpy as np
import pytest

import sitedda
from sitedda import InputError

DENSITY, GRAVITY, HEIGHT, COURSES, BRICKS = 2500.0, 9.81, 0.5, 12, 10
WEIGHT = DENSITY * GRAVITY * HEIGHT  # stress due to the weight of a course, Pa
HEAD_JOINT = 5e-4  # m


def wall(start: str, layers: str = "", courses: int = COURSES, gravity: str = "0, -9.81") -> str:
    """A wall on a footing with fixed corners."""
    return f"""
&control time_step = 1e-3, steps = 40, gravity = {gravity} /
&contact normal_stiffness = 1e12 /
&material density = {DENSITY}, young_modulus = 1e10, poisson_ratio = 0.25 /
&joint friction_angle = 35 /
&layers name = 'base', width = {BRICKS}, thickness = {HEIGHT}, bottom = -{HEIGHT} {layers} /
&wall brick_length = 1, brick_height = {HEIGHT}, bricks = {BRICKS}, courses = {courses} {start} /
&fixed_point x = 0.1, y = -0.4, block = 1 /
&fixed_point x = 9.9, y = -0.4, block = 1 /
"""


AT_REST = f", head_joint = {HEAD_JOINT}, geostatic = .true."
UNDER_WALL = f", geostatic = .true., overburden = {COURSES * WEIGHT}"


def started(tmp_path, text: str) -> sitedda.Simulation:
    file = tmp_path / "wall.nml"
    file.write_text(text)
    return sitedda.Simulation(file)


def largest_energy(run: sitedda.Simulation, steps: int) -> float:
    """Largest kinetic energy after a step, J per metre."""
    energy = 0.0
    for _ in range(steps):
        run.advance(1)
        energy = max(energy, run.energies["kinetic"])
    return energy


def test_the_initial_stress_is_that_of_the_weight(tmp_path):
    with started(tmp_path, wall(AT_REST, UNDER_WALL)) as run:
        stress = run.stresses
        names = run.block_names
    assert names[0] == "base_1" and names[1] == "brick_1"
    assert stress[0, 1] == pytest.approx(-(COURSES + 0.5) * WEIGHT, rel=1e-12)
    assert stress[1, 1] == pytest.approx(-(COURSES - 0.5) * WEIGHT, rel=1e-12)
    assert stress[-1, 1] == pytest.approx(-0.5 * WEIGHT, rel=1e-12)
    assert np.all(stress[:, [0, 2]] == 0.0)


def test_the_wall_is_at_rest_from_the_first_step(tmp_path):
    with started(tmp_path, wall(AT_REST, UNDER_WALL)) as run:
        calm_run = largest_energy(run, 40)
        assert run.counts["iterations"] == run.steps
        assert abs(run.energies["balance"]) < 1e-9 * abs(run.energies["gravity"])
    with started(tmp_path, wall("")) as run:
        sudden_run = largest_energy(run, 10)
        assert run.counts["iterations"] > 3 * run.steps
    assert calm_run < 0.05 * sudden_run


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        (wall(", head_joint = 0.5"), "must be shorter than half of brick_length"),
        (wall(", head_joint = -0.1"), "head_joint = -0.1"),
        (wall(", overburden = 1e3"), "geostatic = .true."),
        (wall(", geostatic = .true., overburden = -1"), "overburden = -1"),
        (wall(AT_REST, gravity="1, -9.81"), "acts downwards"),
        (wall("", ", geostatic = .true.", gravity="0, 0"), "acts downwards"),
    ],
)
def test_invalid_geostatic_input_is_refused(tmp_path, changed, message):
    with pytest.raises(InputError, match=r"&(wall|layers)") as error_info:
        started(tmp_path, changed)
    assert message in str(error_info.value)


@pytest.mark.parametrize(("start", "warned"), [("", True), (AT_REST, False)])
def test_check_warns_of_a_slow_start(tmp_path, start, warned):
    file = tmp_path / "wall.nml"
    file.write_text(wall(start, courses=100))
    lines = [line for line in sitedda.check(file).lines if line.topic == "start"]
    assert len(lines) == warned
    if warned:
        assert "geostatic" in lines[0].advice and "1051 blocks" in lines[0].words
