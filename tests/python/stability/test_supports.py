# SPDX-License-Identifier: GPL-3.0-or-later
"""Quasi-static support movements against closed forms of rigid blocks."""

import math

import numpy as np
import pytest

import sitedda
from sitedda import InputError

LENGTH, HEIGHT = 2.0, 0.5
WEIGHT = 2500.0 * 9.81 * LENGTH * HEIGHT  # weight of a half, N/m


def flat_arch() -> sitedda.Model:
    """Two stones between two abutments."""
    model = sitedda.Model("flat arch", time_step=1e-3, gravity=(0, -9.81))
    model.contact(normal_stiffness=1e11)
    model.material("stone", density=2500.0, young_modulus=1e13, poisson_ratio=0.2)
    model.joint("dry", friction_angle=50.0)
    for name, left in (("left", -1.0), ("first", 0.0), ("second", LENGTH), ("right", 2 * LENGTH)):
        right = left + (1.0 if name in ("left", "right") else LENGTH)
        model.block([left, 0, right, 0, right, HEIGHT, left, HEIGHT], name=name)
        if name in ("left", "right"):
            for x in (left + 0.1, right - 0.1):
                model.fixed_point(x, 0.25, name)
    return model


def thrust(spread: float) -> float:
    """Thrust with hinges at the feet of both abutments and at the top: H = w x/(2 r)."""
    x = LENGTH + spread / 2
    return WEIGHT * x / (2 * math.sqrt(LENGTH**2 + HEIGHT**2 - x**2))


def test_the_thrust_of_a_spreading_arch():
    movement = sitedda.move_supports(flat_arch(), ["right"], (0.02, 0.0), steps=10)
    assert not movement.ending and movement.share[-1] == 1.0
    expected = [thrust(0.02 * fraction) for fraction in movement.share]
    assert -movement.reaction[1:, 0] == pytest.approx(expected[1:], rel=2e-3)
    vertical = WEIGHT + 2500.0 * 9.81 * HEIGHT  # with the weight of the abutment
    assert movement.reaction[1:, 1] == pytest.approx(np.full(10, vertical), rel=1e-3)
    assert movement.displacement[-1, 3, 0] == pytest.approx(0.02, rel=1e-3)
    drop = HEIGHT - math.sqrt(LENGTH**2 + HEIGHT**2 - (LENGTH + 0.01) ** 2)
    assert movement.displacement[-1, 1, 1] == pytest.approx(-drop / 2, rel=0.02)
    assert movement.to_csv().count("\n") == 12


def test_a_settling_and_rotating_support():
    """A stone follows its base: the reaction remains the weight of both."""
    model = sitedda.Model("base", time_step=1e-3, gravity=(0, -9.81))
    model.contact(normal_stiffness=1e10)
    model.material("stone", density=2000.0, young_modulus=1e12, poisson_ratio=0.2)
    model.joint("dry", friction_angle=40.0)
    model.block([0, 0, 4, 0, 4, 1, 0, 1], name="base")
    model.block([1, 1, 3, 1, 3, 2, 1, 2], name="stone")
    for x in (1.0, 3.0):
        model.fixed_point(x, 0.5, "base")
    movement = sitedda.move_supports(model, ["base"], (0.0, -0.05), rotation=0.02, steps=5)
    assert movement.reaction[:, 1] == pytest.approx(np.full(6, 6 * 2000 * 9.81), rel=1e-3)
    assert movement.displacement[-1, 0] == pytest.approx((0.0, -0.05, 0.02), abs=1e-4)
    assert movement.displacement[-1, 1, 2] == pytest.approx(0.02, rel=1e-2)


@pytest.mark.parametrize("named", [True, False])
def test_the_reaction_balances_all_loads_and_points_belong_to_their_blocks(named):
    """Load, traction and stretched tie add their forces to the thrust; the move is complete."""
    model = flat_arch()
    tie = {"axial_stiffness": 1e7, "pretension": 2e4}
    model.bolt("tie", (-0.5, 0.1), (4.5, 0.1), **tie)
    model.load(4.5, 0.4, "right", time=(0, 1), force_x=(-7e4, -7e4), force_y=(-2e5, -2e5))
    model.traction(along=[4, 0.5, 5, 0.5], normal=1e5)
    if not named:
        for point in model.of_kind("fixed_point"):
            point(block=None)
    movement = sitedda.move_supports(model, "right", (0.02, 0.0), steps=5)
    assert movement.displacement[-1, 3] == pytest.approx((0.02, 0.0, 0.0), abs=1e-6)
    spread = 0.02 * movement.share[1:]
    expected = [2e4 + 1e7 * d + 7e4 - thrust(d) for d in spread]
    assert movement.reaction[1:, 0] == pytest.approx(expected, rel=2e-3)
    vertical = WEIGHT + 2500.0 * 9.81 * HEIGHT + 2e5 + 1e5
    assert movement.reaction[:, 1] == pytest.approx(np.full(6, vertical), rel=1e-3)


@pytest.mark.parametrize(
    ("blocks", "message"),
    [(["middle"], "'middle' is not the name"), (["first"], "no &fixed_point"), ([], "blocks = "),
     (3, "blocks = 3")],
)  # fmt: skip
def test_blocks_without_fixed_points_cannot_move(blocks, message):
    with pytest.raises(InputError, match=message):
        sitedda.move_supports(flat_arch(), blocks, (0.01, 0.0))


@pytest.mark.parametrize("shift", [(0.02,), (0.02, 0, 5), 5, (0, math.nan), ("a", 0)])
def test_a_movement_has_two_components(shift):
    with pytest.raises(InputError, match="displacement"):
        sitedda.move_supports(flat_arch(), ["right"], shift)


def test_other_supports_of_moved_blocks_are_refused():
    model = flat_arch()
    model.boundary(kind="fixed", side="right")
    assert not sitedda.move_supports(model, ["left"], (-1e-3, 0.0), steps=1).ending
    with pytest.raises(InputError, match="'right' has an edge of a &boundary"):
        sitedda.move_supports(model, ["right"], (0.01, 0.0))
    model = flat_arch()
    model.of_kind("fixed_point")[-1](name="prop 1")
    model.stage(name="free", kind="static", release="prop *")
    with pytest.raises(InputError, match="stage 'free' holds or releases &fixed_point 'prop 1'"):
        sitedda.move_supports(model, ["right"], (0.01, 0.0))
