# SPDX-License-Identifier: GPL-3.0-or-later
"""What a run says of joints that lose strength or dilate."""

from __future__ import annotations

import math

import pytest
from model_text import rectangle

import sitedda

ROCK = {"name": "rock", "density": 2500.0, "young_modulus": 5e10, "poisson_ratio": 0.2}
PRESSURE = 1e6  # Pa
WAY = 0.01  # m


def direct_shear(**joint) -> list:
    """A block of 1 m under 1 MPa is pushed over another by a support, WAY in 0.1 s."""
    law = {"name": "plane", "law": "mohr_coulomb", "friction_angle": 30.0}
    law |= {"normal_stiffness_per_area": 1e10, "shear_stiffness_per_area": 1e10}
    push = {"name": "push", "quantity": "displacement", "time_step": 0.1, "values": [0.0, WAY, WAY]}
    blocks = {
        "lower": rectangle(-0.2, -0.1, 1.4, 0.1),
        "upper": rectangle(0.0, 0.0, 1.0, 0.1),
    }
    return [
        ("control", {"time_step": 1e-3}),
        ("material", ROCK),
        ("joint", law | joint),
        *(("block", {"name": name, "vertices": at}) for name, at in blocks.items()),
        ("fixed_point", {"block": "lower", "x": -0.1, "y": -0.05}),
        ("fixed_point", {"block": "lower", "x": 1.1, "y": -0.05}),
        ("motion", push),
        ("fixed_point", {"block": "upper", "x": 0.5, "y": 0.05, "direction": "x",
                         "motion_x": "push"}),
        ("traction", {"name": "load", "side": "top", "blocks": "upper", "normal": PRESSURE}),
        ("measured_point", {"name": "top", "block": "upper", "x": 0.5, "y": 0.05}),
        ("stage", {"name": "press", "kind": "static"}),
        ("stage", {"name": "shear", "duration": 0.1, "zero_displacements": True}),
        ("output", {"file": "shear.nc"}),
    ]  # fmt: skip


def test_a_joint_that_dilates_has_not_opened(write_input, tmp_path):
    """It carries the pressure and is lifted by tan ψ times its plastic slip."""
    run = sitedda.run(write_input(direct_shear(dilation_angle=8.0)), tmp_path / "run.nc")
    lift = run.history.displacement.values[-1, 0, 1]
    elastic = PRESSURE * math.tan(math.radians(30.0)) / 1e10
    assert lift == pytest.approx((WAY - elastic) * math.tan(math.radians(8.0)), rel=5e-3)
    assert run.verdict.values["contacts_slipped"] == 2
    assert run.verdict.values["contacts_opened"] == 0
    assert run.verdict.values["largest_opening_m"] == 0.0


@pytest.mark.parametrize(("cohesion", "bonds"), [(0.0, 0), (1e5, 2)])
def test_only_what_resists_without_pressure_is_a_bond(cohesion, bonds, write_input, tmp_path):
    """Both contacts slip and keep the residual strength; without cohesion it is the same."""
    run = sitedda.run(write_input(direct_shear(cohesion=cohesion)), tmp_path / "run.nc")
    assert run.verdict.values["contacts_slipped"] == 2
    assert run.verdict.values.get("bonds_broken", 0) == bonds
    assert (f"{bonds} bonds have broken" in str(run.verdict)) == (bonds > 0)
