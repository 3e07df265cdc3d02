# SPDX-License-Identifier: GPL-3.0-or-later
"""The verdict of the energy audit is reported in all interfaces."""

import math
import re
import warnings

import pytest
from model_text import DRY, ROCK, group, namelist

import sitedda

WALL = [
    group("control", time_step=2e-3, steps=150, gravity=[0.0, -9.81]),
    group("contact", normal_stiffness=1e10),
    ("material", ROCK),
    ("joint", DRY),
    group("layers", name="base", left=-0.5, bottom=-0.5, width=5.0, thickness=0.5),
    group("wall", name="brick", brick_length=1.0, brick_height=0.5, bricks=4, courses=4),
    group("motion", name="shake", quantity="displacement", time_step=0.05,
          values=[0.0, 0.03, 0.05, 0.03, -0.03, -0.05, 0.0]),
    group("fixed_point", x=0.0, y=-0.25, motion_x="shake"),
    group("fixed_point", x=4.0, y=-0.25, motion_x="shake"),
    group("fixed_point", x=2.0, y=-0.4, motion_x="shake"),
]  # fmt: skip


@pytest.fixture
def file(tmp_path):
    """The input of a shaken wall."""
    path = tmp_path / "wall.nml"
    path.write_text(namelist(WALL))
    return path


def test_a_loose_tolerance_causes_a_warning(file):
    """Accepted steps with incomplete convergence leave an energy residual, which is reported."""
    with pytest.warns(sitedda.AuditWarning, match="does not balance.*force_tolerance"):
        result = sitedda.run(file, contact={"force_tolerance": 1e-2})
    assert "does not balance" in result.history.attrs["energy_audit"]


def test_a_good_run_is_silent(file):
    """The default tolerance balances."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", sitedda.AuditWarning)
        result = sitedda.run(file)
    assert result.history.attrs["energy_audit"] == "balances"


def wheel() -> list:
    """An octagon on the ground that rotates by 0.1 rad per step."""
    corners = [math.pi * (i + 0.5) / 4 for i in range(8)]
    top = 0.5 * math.cos(math.pi / 8)  # level of the ground below the lowest corners, m
    outline = [f for a in corners for f in (0.5 * math.cos(a), top + 0.5 * math.sin(a))]
    return [
        group(
            "control", time_step=0.03, steps=33, gravity=[0.0, -9.81], max_displacement_ratio=0.2
        ),
        group("contact", normal_stiffness=1e6),
        ("material", ROCK | {"initial_velocity": [0.0, 0.0, -6.0]}),
        ("material", ROCK | {"name": "floor"}),
        ("joint", DRY),
        group("block", vertices=outline),
        group("block", material="floor", vertices=[-5.0, -1.0, 5.0, -1.0, 5.0, 0.0, -5.0, 0.0]),
        *(group("fixed_point", x=x, y=-0.5) for x in (-4.0, 4.0)),
    ]


def test_steps_too_long_for_the_geometry_cause_a_warning(write_input):
    """The audit reports the energy that the exact geometry added to springs, as in the output."""
    path = write_input(wheel(), "wheel.nml")
    with pytest.warns(sitedda.AuditWarning, match="try a smaller time_step") as warning_list:
        result = sitedda.run(path)
    energy_gain = float(re.search(r"gained (-?[\d.]+) of", str(warning_list[0].message))[1])
    assert energy_gain == pytest.approx(float(result.history.energy_geometric[-1]), abs=1e-6)


@pytest.mark.parametrize(
    ("stiffness", "verdict", "advice"),
    [(1e6, "warn", "a higher normal_stiffness"), (1e10, "ok", ""), (1e17, "warn", "a lower")],
)
def test_penalty_bounds(file, stiffness, verdict, advice):
    """The check reports a penalty that is too soft, and one that causes rounding errors."""
    text = sitedda.check(file, contact={"normal_stiffness": stiffness}).text
    lines = text.splitlines()
    at = next(i for i, line in enumerate(lines) if "penalty bounds" in line)
    assert lines[at].startswith(verdict)
    assert advice in " ".join(lines[at : at + 6])
    assert ("->" in " ".join(lines[at + 1 : at + 6])) == bool(advice)


def test_bonds_that_break_between_steps_add_no_energy_to_springs():
    """In masonry on springs under sudden weight, contact springs gained 288 kJ/m between steps.

    Beside the arch, a stone has an edge of 8 mm; its other end, 6 mm apart, took over the bond.
    """
    model = sitedda.Model(time_step=5e-4, integration="theta", analysis="plane_strain",
                          gravity=(0.0, -9.81), steps=44)  # fmt: skip
    model.material("rock", density=1779.4, young_modulus=3.762e8, poisson_ratio=0.024)
    model.joint("bed", law="mohr_coulomb", friction_angle=59.6, residual_friction_angle=31.6,
                cohesion=6980.0, tensile_strength=1.79e4, weakening_slip=3.42e-3,
                dilation_angle=2.2)  # fmt: skip
    model.layers(name="base", left=-1.0, bottom=-0.5, width=7.44, thickness=0.5)
    model.masonry_wall(width=5.44, height=3.7, courses=10, stone=0.76, bond="running", seed=10)
    model.opening(name="door", left=2.06, bottom=0.8, width=1.0, height=1.09, head="arch",
                  rise=0.249)  # fmt: skip
    model.boundary("bed", "springs", side="bottom", blocks="base*", stiffness_per_area=3.42e9)
    with sitedda.Simulation(model) as run:
        run.advance(10)
        assert abs(run.energies["geometric"]) < 1e-3 * abs(run.energies["gravity"])
        run.advance(34)
        assert run.counts["broken"] > 20
        assert abs(run.energies["geometric"]) < 1e-6 * run.energies["strain"]
        assert abs(run.energies["balance"]) < 1e-9 * run.energies["strain"]
