# SPDX-License-Identifier: GPL-3.0-or-later
"""`solve_for` with several parameters: roots in closed form, and systems without roots."""

import math

import numpy as np
import pytest
from test_answers import WEIGHT, slider, slip_of

import sitedda
from sitedda import NoRootError, solve_for


def circle(a, b):
    """Sum of squares and difference, with scales that differ by 10^12."""
    return a**2 + (b * 1e9) ** 2, 1e6 * (a - b * 1e9)


def test_roots_of_functions():
    root = solve_for(circle, ["a", "b"], ["radius", "off"], [25.0, 1e6],
                      between=[(0, 10), (0, 2e-8)], tolerance=1e-6)  # fmt: skip
    assert root.value == pytest.approx([4.0, 3e-9], rel=1e-6)
    assert root.reached == pytest.approx([25.0, 1e6], rel=1e-6)
    assert root.slope[0] == pytest.approx([8.0, 6e9], rel=1e-4)
    assert np.all(root.bar <= 1e-6 * np.array([10, 2e-8]))
    assert str(root).startswith("a = ") and "radius = 25" in str(root)

    def three(x, y, z):
        return {"sum": x + y + z, "product": x * y * z, "other": x * y + math.exp(z)}

    expected = three(0.3, 1.2, 2.0)
    root = solve_for(three, list("xyz"), list(expected), list(expected.values()),
                      between=[(0, 1), (1, 3), (1.5, 4)], tolerance=1e-8)  # fmt: skip
    assert root.value == pytest.approx([0.3, 1.2, 2.0], rel=1e-7)


def test_a_root_that_needs_another_starting_point():
    """From the middle of the ranges, |f| decreases to a minimum that is not a root."""

    def hills(x, y):
        return x**3 - 3 * x, y - x

    root = solve_for(hills, ["x", "y"], ["f", "g"], [12.0, 0.5], between=[(-3, 4), (-4, 6)])
    assert hills(*root.value) == pytest.approx([12.0, 0.5], rel=1e-3)


@pytest.mark.parametrize(
    ("function", "targets", "mode", "message"),
    [
        (lambda x, y: (x * x + y * y + 1, x - y), (0, 0), "outside", "the closest is x = "),
        (lambda x, y: (x + y, x * y), (30, 1), "outside", r"f = .* \(target 30\)"),
        (lambda x, y: (x + y, 2 * x + 2 * y), (1, 2), "dependent", "f and g do not change indep"),
        (lambda x, y: (x * y + 1, (x * y + 1) ** 2), (1, 3), "dependent", "with x and y"),
        (lambda x, y: (x, x**2 + 1), (0.5, 1), "flat", "y changes none"),
        (lambda x, y: (x + y, 3.0), (0.5, 1), "flat", "g depends on none"),
        (lambda x, y: (x, math.nan), (0.5, 1), "no number", "g is not a number at x = "),
    ],
)
def test_systems_without_roots(function, targets, mode, message):
    with pytest.raises(NoRootError, match=message) as error_info:
        solve_for(function, ["x", "y"], ["f", "g"], targets, between=[(-1, 2), (-2, 3)])
    assert error_info.value.mode == mode
    assert mode == "no number" or len(error_info.value.trials) > 4


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"target": [1.0]}, "between must have the same length, not 2, 2, 1 and 2"),
        ({"target": 1.0}, "target = 1.0: give a list"),
        ({"result": "f"}, "result = 'f': give a list"),
        ({"parameter": ["x", "x"]}, "a name is repeated"),
        ({"parameter": []}, "not 0, 2, 2 and 2"),
        ({"between": [(0, 1), (1, 1)]}, "must differ"),
        ({"target": [1.0, math.inf]}, "target"),
        ({"model": lambda x, y: x}, r"must return 2 numbers \(f, g\)"),
    ],
)
def test_invalid_arguments_are_refused(changes, message):
    arguments = {"model": circle, "parameter": ["x", "y"], "result": ["f", "g"],
                 "target": [1.0, 2.0], "between": [(0, 1), (0, 1)]}  # fmt: skip
    with pytest.raises(sitedda.InputError, match=message):
        solve_for(**arguments | changes)


def test_friction_and_density_of_a_sliding_block():
    """Newmark's block: its weight yields the density, then its slip yields the friction angle."""
    model = slider(0.0, 30.0, 4.0, 0.4, 1.0, stiffness=1e12)
    model["material.rock"].density = 2000.0
    root = solve_for(
        model, ["joint[plane].friction_angle", "material.density"],
        ["joint_slip[base].last", "joint_normal_force[base].last"],
        [slip_of(0.0, 18.0, 4.0, 0.4), WEIGHT],
        between=[(10, 30), (2000, 3000)], tolerance=1e-4,
    )  # fmt: skip
    assert root.value == pytest.approx([18.0, 2500.0], rel=2e-3)
    assert np.all(abs(root.value - [18.0, 2500.0]) <= root.bar + [0.01, 0.1])
