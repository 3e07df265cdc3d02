# SPDX-License-Identifier: GPL-3.0-or-later
"""Verdicts of runs with joints that weaken or dilate."""

import math

import pytest
from model_text import group, rectangle

import sitedda

ROCK = {"name": "rock", "density": 2500.0, "young_modulus": 5e10, "poisson_ratio": 0.2}
PRESSURE = 1e6  # Pa
WAY = 0.01  # m


def direct_shear(**joint) -> list:
    """A support pushes a block of 1 m under 1 MPa over another one, by WAY in 0.1 s."""
    law = {"name": "plane", "law": "mohr_coulomb", "friction_angle": 30.0}
    law |= {"normal_stiffness_per_area": 1e10, "shear_stiffness_per_area": 1e10}
    motion = {"name": "push", "quantity": "displacement", "time_step": 0.1,
              "values": [0.0, WAY, WAY]}  # fmt: skip
    blocks = {"lower": rectangle(-0.2, -0.1, 1.4, 0.1), "upper": rectangle(0.0, 0.0, 1.0, 0.1)}
    return [
        group("control", time_step=1e-3),
        ("material", ROCK),
        ("joint", law | joint),
        *(group("block", name=name, vertices=at) for name, at in blocks.items()),
        group("fixed_point", block="lower", x=-0.1, y=-0.05),
        group("fixed_point", block="lower", x=1.1, y=-0.05),
        ("motion", motion),
        group("fixed_point", block="upper", x=0.5, y=0.05, direction="x", motion_x="push"),
        group("traction", name="load", side="top", blocks="upper", normal=PRESSURE),
        group("measured_point", name="top", block="upper", x=0.5, y=0.05),
        group("stage", name="press", kind="static"),
        group("stage", name="shear", duration=0.1, zero_displacements=True),
        group("output", file="shear.nc"),
    ]  # fmt: skip


def test_a_joint_that_dilates_has_not_opened(write_input, tmp_path):
    """The joint carries the pressure, and its block rises by tan ψ times the plastic slip."""
    run = sitedda.run(write_input(direct_shear(dilation_angle=8.0)), tmp_path / "run.nc")
    dilation = run.history.displacement.values[-1, 0, 1]
    elastic = PRESSURE * math.tan(math.radians(30.0)) / 1e10
    assert dilation == pytest.approx((WAY - elastic) * math.tan(math.radians(8.0)), rel=5e-3)
    assert run.verdict.values["contacts_slipped"] == 2
    assert run.verdict.values["contacts_opened"] == 0
    assert run.verdict.values["largest_opening_m"] == 0.0


@pytest.mark.parametrize(("cohesion", "bonds"), [(0.0, 0), (1e5, 2)])
def test_only_cohesive_contacts_count_as_bonds(cohesion, bonds, write_input, tmp_path):
    """Both contacts slip and have the residual strength; without cohesion there is no bond."""
    run = sitedda.run(write_input(direct_shear(cohesion=cohesion)), tmp_path / "run.nc")
    assert run.verdict.values["contacts_slipped"] == 2
    assert run.verdict.values.get("bonds_broken", 0) == bonds
    assert (f"{bonds} bonds have broken" in str(run.verdict)) == (bonds > 0)


@pytest.mark.parametrize(("strength", "is_stable"), [(60e3, True), (58e3, False)])
def test_five_points_fail_like_a_brittle_joint(strength, is_stable, write_input):
    """The block bends its joint by 6M/L² = 58.86 kPa; after one break, 1.19 times this stress."""
    at_rest = glued_block(tensile_strength=strength / 1.19, contact_points=5)
    if not is_stable:
        with pytest.raises(sitedda.ConvergenceError, match="does not settle"):
            sitedda.run(write_input(at_rest))
        return
    assert "1 broken in static steps" in str(sitedda.run(write_input(at_rest)).verdict)


def test_intact_bonds_cause_no_warning(write_input):
    run = sitedda.run(write_input(glued_block(tensile_strength=62e3, contact_points=3)))
    assert "broken in static" not in str(run.verdict)


def glued_block(**joint) -> list:
    """A block of 1 m and 19.62 kN/m that is glued to a wall by one side."""
    blocks = {"wall": rectangle(-1, -2, 1, 5), "block": rectangle(0, 0, 1, 1)}
    return [
        group("control", time_step=1e-3, steps=2, gravity=[0.0, -9.81], settle=True),
        group("contact", normal_stiffness=1e9),
        group("material", name="stone", density=2000.0, young_modulus=1e12, poisson_ratio=0.2),
        ("joint", {"friction_angle": 20.0, "cohesion": 1e6} | joint),
        *(group("block", name=name, vertices=at) for name, at in blocks.items()),
        *(group("fixed_point", block="wall", x=-0.5, y=y) for y in (-1.5, 2.5)),
    ]  # fmt: skip
