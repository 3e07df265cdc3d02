# SPDX-License-Identifier: GPL-3.0-or-later
"""The verdict of the energy audit reaches whoever runs the engine."""

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
    group(
        "motion",
        name="shake",
        quantity="displacement",
        time_step=0.05,
        values=[0.0, 0.03, 0.05, 0.03, -0.03, -0.05, 0.0],
    ),
    group("fixed_point", x=0.0, y=-0.25, motion_x="shake"),
    group("fixed_point", x=4.0, y=-0.25, motion_x="shake"),
    group("fixed_point", x=2.0, y=-0.4, motion_x="shake"),
]


@pytest.fixture
def file(tmp_path):
    """The input of a shaken wall."""
    path = tmp_path / "wall.nml"
    path.write_text(namelist(WALL))
    return path


def test_a_loose_tolerance_is_told(file):
    """Steps that are accepted half converged leave energy unexplained: it is said, in place."""
    with pytest.warns(sitedda.AuditWarning, match="does not balance.*force_tolerance"):
        done = sitedda.run(file, contact={"force_tolerance": 1e-2})
    assert "does not balance" in done.history.attrs["energy_audit"]


def test_a_good_run_is_silent(file):
    """The default tolerance balances."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", sitedda.AuditWarning)
        done = sitedda.run(file)
    assert done.history.attrs["energy_audit"] == "balances"


def wheel() -> list:
    """An octagon that turns by a tenth of a radian in a step, on the ground."""
    corners = [math.pi * (i + 0.5) / 4 for i in range(8)]
    top = 0.5 * math.cos(math.pi / 8)  # of the ground, m: no corner is lower
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


def test_steps_too_long_for_the_geometry_are_told(write_input):
    """The audit names what the exact geometry gave to the springs, as the output has it."""
    path = write_input(wheel(), "wheel.nml")
    with pytest.warns(sitedda.AuditWarning, match="try a smaller time_step") as told:
        done = sitedda.run(path)
    gained = float(re.search(r"gained (-?[\d.]+) of", str(told[0].message))[1])
    assert gained == pytest.approx(float(done.history.energy_geometric[-1]), abs=1e-6)


@pytest.mark.parametrize(
    ("stiffness", "verdict", "advice"),
    [(1e6, "warn", "a higher normal_stiffness"), (1e10, "ok", ""), (1e17, "warn", "a lower")],
)
def test_penalty_bounds(file, stiffness, verdict, advice):
    """The check tells a penalty that blocks sink into, and one that is all rounding."""
    text = sitedda.check(file, contact={"normal_stiffness": stiffness}).text
    lines = text.splitlines()
    at = next(i for i, line in enumerate(lines) if "penalty bounds" in line)
    assert lines[at].startswith(verdict)
    assert advice in " ".join(lines[at : at + 6])
    assert ("->" in " ".join(lines[at + 1 : at + 6])) == bool(advice)
