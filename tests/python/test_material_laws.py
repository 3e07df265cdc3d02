# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials with a law of their own in blocks and bodies, against closed forms and the column."""

import numpy as np
import pytest

import sitedda
from sitedda.column import Column, Layer
from sitedda.site.curves import hyperbolic
from sitedda.site.nonlinear import nonlinear

DENSITY, VELOCITY, POISSON = 2000.0, 300.0, 0.25
SHEAR = DENSITY * VELOCITY**2
REFERENCE = 3.65e-4  # strain of the hyperbola
MASING = {
    "law": "hysteretic", "curve": "hyperbolic", "reference_strain": REFERENCE,
    "damping_curve": "masing",
}  # fmt: skip


def soil_model(steps, soil, integration="midpoint", time_step=2e-3):
    """A model in plane strain of one soil, without blocks."""
    model = sitedda.Model()
    model.control(
        time_step=time_step, steps=steps, gravity=[0.0, 0.0], integration=integration,
        analysis="plane_strain",
    )  # fmt: skip
    model.contact(normal_stiffness=100 * SHEAR)
    young = 2 * SHEAR * (1 + POISSON)
    model.material(name="soil", density=DENSITY, young_modulus=young, poisson_ratio=POISSON, **soil)
    model.joint(name="joint", friction_angle=30.0)
    return model


def shaken_column(ground, cells, soil, integration="midpoint"):
    """A column of 20 m of cells that only shear, on a base that is shaken."""
    model = soil_model(ground.size - 1, soil, integration)
    model.control(base_motion_x="ground")
    model.motion(
        name="ground", values=ground.tolist(), quantity="acceleration", time_step=2e-3,
        drift_order=0,
    )  # fmt: skip
    size = 20.0 / cells
    for i in range(cells):
        low, high = i * size, (i + 1) * size
        corners = [0, low, size, low, size, high, 0, high]
        model.block(vertices=corners, body="column", name=f"c{i}")
        for x in (0, size):
            for y in (low, high):
                free = {} if y == 0 else {"direction": "y"}
                model.fixed_point(x=x, y=y, block=f"c{i}", **free)
    model.measured_point(name="top", x=size / 2, y=20.0, block=f"c{cells - 1}")
    return model


def sine(frequency, amplitude, steps):
    time = 2e-3 * np.arange(steps + 1)
    return amplitude * np.sin(2 * np.pi * frequency * time) * np.minimum(time, 1)


@pytest.mark.parametrize("amplitude", [0.2, 1.0])
def test_a_column_of_cells_is_the_column_of_one_dimension(amplitude):
    """Displacements of the surface within .7 % of the largest, over three seconds."""
    ground = sine(2.0, amplitude, 1500)
    history = shaken_column(ground, 20, MASING).run().history
    found = history.displacement.values[:, 0, 0]
    wanted = nonlinear(
        Column([Layer(20.0, density=DENSITY, shear_velocity=VELOCITY)]),
        [hyperbolic(REFERENCE)], ground, 2e-3, damping_curve="masing", branches=30, compare=False,
    ).displacement()  # fmt: skip
    assert np.abs(found - wanted).max() < 7e-3 * np.abs(wanted).max()
    assert np.abs(history.energy_balance).max() < 1e-9 * history.energy_input.values.max()
    lost = history.energy_plastic.values
    assert np.all(np.diff(lost) >= -1e-12 * lost[-1]) and lost[-1] > 0
    assert np.median(history.iterations) <= 8


def sheared_block(strain, soil, integration="midpoint"):
    """A block that two cycles of shear are forced on, of 400 steps each."""
    model = soil_model(800, soil, integration, 1e-2)
    model.block(vertices=[0, 0, 1, 0, 1, 1, 0, 1], name="block")
    values = strain * np.sin(2 * np.pi * np.arange(802) / 400)
    model.motion(name="top", values=values.tolist(), quantity="displacement", time_step=1e-2)
    for x in (0.0, 1.0):
        model.fixed_point(x=x, y=0.0)
        model.fixed_point(x=x, y=1.0, motion_x="top")
    return model


@pytest.mark.parametrize("x, damping", [(0.3, 5.5548), (1.0, 14.4775), (3.0, 27.6551)])
def test_loops_of_a_block_lose_what_masing_says(x, damping):
    """D = (2/π)[2(1 + 1/x)(1 − ln(1 + x)/x) − 1] of a hyperbola, within .4 points."""
    history = sheared_block(x * REFERENCE, MASING).run().history
    lost = history.energy_plastic.values
    secant = SHEAR / (1 + x)
    found = 100 * (lost[-1] - lost[-401]) / (2 * np.pi * secant * (x * REFERENCE) ** 2)
    assert found == pytest.approx(damping, abs=0.4)


@pytest.mark.parametrize("integration", ["dda", "theta", "midpoint"])
def test_no_step_gains(integration):
    soil = {"law": "hysteretic", "curve": "darendeli", "mean_stress": 1e5}
    history = sheared_block(1e-3, soil, integration).run().history
    terms = ["energy_plastic", "energy_material_damping"]
    for term in terms:
        assert np.all(np.diff(history[term].values) >= 0)
    scale = history.energy_plastic.values[-1]
    assert np.abs(history.energy_balance).max() < 1e-9 * scale


def test_small_strains_are_those_of_a_damping_ratio():
    """At a ten-millionth of the motion: a linear material with the same damping ratio."""
    ground = 1e-7 * sine(2.0, 1.0, 400)
    soil = MASING | {"damping_ratio": 0.02}
    found, wanted = (
        shaken_column(ground, 4, own, "dda").run().history.displacement.values[:, 0, 0]
        for own in (soil, {"damping_ratio": 0.02})
    )
    assert np.abs(found - wanted).max() < 0.02 * np.abs(wanted).max()


def test_modes_are_those_of_small_strains():
    ground = sine(2.0, 1.0, 4)
    law, linear = (
        sitedda.modes(shaken_column(ground, 8, own), count=6).frequency for own in (MASING, {})
    )
    np.testing.assert_allclose(law, linear, rtol=1e-12)


def test_a_run_goes_on_from_its_checkpoint_with_the_same_bits(tmp_path, same_bits):
    file = tmp_path / "column.nml"
    soil = MASING | {"damping_ratio": 0.01}
    shaken_column(sine(2.0, 1.0, 240), 6, soil).write(file)
    whole = sitedda.run(file, tmp_path / "whole.nc")
    with sitedda.Simulation(file, tmp_path / "half.nc") as half:
        half.advance(113)
    same_bits(whole.history, sitedda.resume(file, tmp_path / "half.nc").history)


@pytest.mark.parametrize(
    "soil, message",
    [
        ({"law": "hysteretic"}, "needs a curve"),
        ({"law": "hysteretic", "curve": "darendeli"}, "needs the mean_stress"),
        ({"law": "hysteretic", "curve": "mkz"}, "needs the reference_strain"),
        (MASING | {"shear_strength": 1e5}, "needs the reference_strain"),
        (MASING | {"curve": "gqh"}, "five numbers of curve_fit"),
        (MASING | {"curve": "table"}, "as many strains"),
        (MASING | {"rayleigh_beta": 1e-4}, "leave out rayleigh_alpha"),
        ({"curve": "mkz"}, "law"),
    ],
)
def test_a_law_that_lacks_something_is_refused(soil, message):
    with pytest.raises(sitedda.InputError, match=message):
        shaken_column(sine(2.0, 1.0, 4), 2, soil).run()
