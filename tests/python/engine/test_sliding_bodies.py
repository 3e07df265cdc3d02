# SPDX-License-Identifier: GPL-3.0-or-later
"""Stiff bodies with non-matching faces slide like rigid ones, as in closed form.

With stiff cells the displacement is that of a rigid block: if all contacts slide, x + y tan φ
moves under g_x − g_y tan φ in each step, and y follows the floor.
"""

import numpy as np
import pytest
import shapely
from test_bodies import cells_of, hold, model_of

FRICTION = np.tan(np.radians(20.0))
PULL = 5.0 - 10.0 * np.cos(np.pi / 6) * FRICTION
STEP, STIFF = 1e-3, 1e14


def sliding(bodies, fixed_blocks, steps, motion=None):
    """Bodies on others with fixed bases, on a slope of 30°, by the θ-method."""
    model = model_of(bodies, young=STIFF, time_step=STEP, steps=steps, integration="theta",
                     solver="direct", gravity=[5.0, -10.0 * np.cos(np.pi / 6)])  # fmt: skip
    model["joint"][0].friction_angle = 20.0
    model.contact(normal_stiffness=STIFF)
    moves = {}
    for axis, curve in (motion or {}).items():
        model.motion(axis, curve.tolist(), STEP, "displacement")
        moves[f"motion_{axis}"] = axis
    hold(model, [cell for body in bodies[:fixed_blocks] for cell in body], "y", **moves)
    model.output(block_interval=steps)
    return model


def moved(history, bodies):
    """Displacements of the centroids of bodies, shape (bodies, 2)."""
    position = history.block_coordinates.values[:, :, :2]
    path, first = [], 0
    for cells in bodies:
        area = np.array([shapely.Polygon(cell).area for cell in cells])
        part = position[-1, first : first + len(cells)] - position[0, first : first + len(cells)]
        path.append(area @ part / area.sum())
        first += len(cells)
    return np.array(path)


def free_path(steps):
    """Displacement by the θ-method with θ = χ = ¾ under PULL, from rest."""
    return PULL * STEP**2 * (steps**2 / 2 + steps / 4)


def shaken(steps):
    """Displacements x and y of a base that begins to move smoothly, shape (steps + 1,), m."""
    time = STEP * np.arange(steps + 1)
    begun = np.clip(time / 0.5, 0, 1)
    begun = begun**4 * (35 - 84 * begun + 70 * begun**2 - 20 * begun**3)
    return {
        axis: amplitude / omega**2 * (1 - np.cos(omega * time)) * begun
        for axis, amplitude, omega in (("x", 4.0, 6 * np.pi), ("y", 3.0, 10 * np.pi))
    }


@pytest.mark.parametrize(("size", "cells"), [(0.15, "voronoi"), (0.15, "quadrilateral")])
def test_a_body_slides_over_the_cells_of_a_shaken_body(size, cells):
    """Over 20 cells: displacement to 3·10⁻⁹, audit to 10⁻⁷, no contact opens.  (Over 100 cells:
    10⁻⁹ and 3·10⁻⁸.)"""
    floor = cells_of((0, 0, 6, 0.2), 0.2)
    block = cells_of((0.47, 0.2, 1.47, 1.2), size, cells)
    steps = 2080
    motion = shaken(steps)
    model = sliding([floor, block], 1, steps, motion)
    run = model.run()
    slip, lifted = moved(run.history, [floor, block])[1]
    assert lifted == pytest.approx(motion["y"][-1], abs=2e-9)
    assert slip == pytest.approx(free_path(steps) - FRICTION * motion["y"][-1], rel=3e-9)
    audit = abs(run.history.energy_balance.values).max()
    assert audit < 1e-7 * float(run.history.energy_friction[-1])
    assert run.verdict.values["contacts_opened"] == 0


CROSSING = [
    cells_of(*one)
    for one in (
        ((0, 0, 2, 1), 0.25),
        ((2, 0, 6, 1), 0.2),
        ((0.4, 1, 1.4, 2), 0.3, "voronoi"),
        ((1.4, 1, 2.4, 2), 0.22, "voronoi"),
    )
]


@pytest.mark.parametrize(("steps", "motion"), [(1200, None), (700, shaken(700))])
def test_bodies_slide_across_a_crossing_of_four(steps, motion):
    """Two bodies slide over the joint between two others, at rest or shaken.  Corners do not catch,
    although elasticity makes one body lower.  The pair separates by about 10⁻⁷ of the
    displacement."""
    run = sliding(CROSSING, 2, steps, motion).run()
    slip, uplift = moved(run.history, CROSSING)[2:].T
    up = motion["y"][-1] if motion else 0.0
    exact = free_path(steps) - FRICTION * up
    assert slip.mean() == pytest.approx(exact, rel=3e-9)
    assert abs(slip / exact - 1).max() < 3e-7
    assert abs(uplift - up).max() < 1e-8
    assert run.verdict.values["contacts_opened"] == 0
    audit = abs(run.history.energy_balance.values).max()
    assert audit < 1e-7 * float(run.history.energy_friction[-1])


def test_bonded_bodies_move_with_a_shaken_base_as_one_body():
    """Four bonded bodies: joints neither slip nor open, and all move like the base, within
    the elasticity of joints and cells, W/10¹⁴ N/m."""
    steps = 700
    motion = shaken(steps)
    model = sliding(CROSSING, 2, steps, motion)
    model["joint"][0](cohesion=1e9, tensile_strength=1e9)
    run = model.run()
    base = [motion["x"][-1], motion["y"][-1]]
    np.testing.assert_allclose(moved(run.history, CROSSING)[2:], [base, base], rtol=0, atol=1e-9)
    verdict = run.verdict.values
    assert verdict["contacts_opened"] == 0 and verdict["contacts_slipped"] == 0
    assert verdict["largest_slip_m"] < 1e-9
    audit = abs(run.history.energy_balance.values).max()
    assert audit < 1e-6 * abs(run.history.energy_input.values).max()
