# SPDX-License-Identifier: GPL-3.0-or-later
"""Yielding materials in blocks and bodies against closed forms and the one-dimensional column."""

import re

import numpy as np
import pytest
from test_yielding import standing_block

import sitedda
from sitedda.column import Column, Layer
from sitedda.signals import spectral_acceleration
from sitedda.site import Branches, beside
from sitedda.site.curves import darendeli, gqh, hyperbolic, mkz
from sitedda.site.nonlinear import nonlinear
from sitedda_evidence.validation.soil import (
    DENSITY,
    MASING,
    POISSON,
    REFERENCE,
    SHEAR,
    VELOCITY,
    hold_sheared,
    shaken_column,
    sheared_block,
    sine,
    soil_model,
)

DARENDELI = {"law": "hysteretic", "curve": "darendeli", "mean_stress": 1e5}


def moved(history):
    """Displacement of the surface relative to the base, m."""
    top, base = (history.displacement.sel(point=name, axis="x").values for name in ("top", "base"))
    return top - base


@pytest.mark.parametrize("amplitude", [0.2, 1.0])
def test_a_column_of_cells_is_the_column_of_one_dimension(amplitude):
    """Surface displacements over three seconds, within 0.7 % of the largest."""
    ground = sine(2.0, amplitude, 1500)
    history = shaken_column(ground, 20, MASING).run().history
    motion = moved(history)
    expected = nonlinear(
        Column([Layer(20.0, density=DENSITY, shear_velocity=VELOCITY)]),
        [hyperbolic(REFERENCE)], ground, 2e-3, damping_curve="masing", branches=30, compare=False,
    ).displacement()  # fmt: skip
    assert np.abs(motion - expected).max() < 7e-3 * np.abs(expected).max()
    assert np.abs(history.energy_balance).max() < 1e-9 * history.energy_input.values.max()
    dissipated = history.energy_plastic.values
    assert np.all(np.diff(dissipated) >= -1e-12 * dissipated[-1]) and dissipated[-1] > 0
    assert np.median(history.iterations) <= 8


def test_blocks_of_soil_agree_with_column_analyses(tmp_path, capsys):
    """P1 of PRENOLIN (sem2dpack: 5.95 γ_ref in steady state): blocks and nonlinear column; and the
    analyses that do not converge."""
    file = tmp_path / "column.nml"
    model = shaken_column(sine(2.0, 1.0, 3000), 20, MASING)
    model.measured_point(name="low", x=0.5, y=1.0, block="c0")
    model.write(file)
    comparison = beside(model.run().history, "top", "base")
    low = comparison.strains[1][-1] / REFERENCE
    assert low == pytest.approx(5.95, abs=0.5)
    assert list(comparison.columns) == ["nonlinear", "equivalent-linear"]
    assert "without damping on a rigid base" in str(comparison)
    periods = [0.1, 0.2, 0.5, 1.0]
    motions = (comparison.surface, comparison.column_surface)
    spectra = [spectral_acceleration(motion, 2e-3, periods) for motion in motions]
    assert spectra[0] == pytest.approx(spectra[1], rel=0.015)
    assert "equivalent-linear" in str(comparison) and "largest shear strain" in str(comparison)
    comparison.plot().savefig(tmp_path / "both.png")
    with pytest.raises(ValueError, match="omit --damping"):
        beside(model.run().history, "top", "base", damping=0.02)


def test_compared_columns_have_the_small_strain_damping():
    """All three columns include D_min of the curve, which the input does not give."""
    ground = 1e-4 * np.concatenate([sine(2.0, 1.0, 1000), np.zeros(1000)])
    soil = DARENDELI | {"mean_stress": 2.5e4, "plasticity_index": 100.0}
    comparison = beside(shaken_column(ground, 10, soil).run().history, "top", "base")
    expected = Branches.of(darendeli(2.5e4, 100.0), 30).misfit
    misfit = comparison.columns["nonlinear"].branches[0].misfit
    assert misfit == pytest.approx(expected, rel=1e-4)
    assert list(comparison.columns) == ["nonlinear", "equivalent-linear", "linear"]
    peaks = [np.abs(column.acceleration()[:2001]).max() for column in comparison.columns.values()]
    assert peaks == pytest.approx([np.abs(comparison.surface).max()] * 3, rel=0.05)


def test_check_reports_the_softening_of_soil():
    model = shaken_column(sine(2.0, 1.0, 300), 4, MASING | {"branches": 60})
    report = str(sitedda.check(model))
    line = " ".join(report[report.index("branches, moduli") :].split())
    assert "at 0.1 and 1 % shear strain G/G0 = 0.267" in line
    cells, frequency = map(float, re.search(r"λ/([\d.]+) at ([\d.]+) Hz", line).groups())
    assert cells == pytest.approx(VELOCITY * np.sqrt(0.267) / (5.0 * frequency), rel=2e-3)
    assert "blocks no larger than" in line


CURVES = {
    "hyperbolic": (MASING, hyperbolic(REFERENCE)),
    "mkz": (
        {"law": "hysteretic", "curve": "mkz", "reference_strain": 1e-3, "curve_factor": 1.4,
         "curve_power": 0.8, "damping_curve": "masing"},
        mkz(1e-3, 1.4, 0.8),
    ),
    "gqh": (
        {"law": "hysteretic", "curve": "gqh", "reference_strain": 1e-3, "damping_curve": "masing",
         "curve_fit": [-2.0, 1.9, 1.0, 1.0, 0.9]},
        gqh(1e-3, [-2.0, 1.9, 1.0, 1.0, 0.9]),
    ),
    "darendeli": (DARENDELI | {"mean_stress": 2e5, "plasticity_index": 30.0, "ocr": 2.0},
                  darendeli(2e5, 30.0, 2.0)),
}  # fmt: skip


@pytest.mark.parametrize("name", CURVES)
def test_the_engine_has_the_curves_of_the_package(name):
    """Moduli at 0.1 and 1 % in the check, within its misfit with 60 branches."""
    soil, curve = CURVES[name]
    model = shaken_column(sine(2.0, 1.0, 10), 2, soil | {"branches": 60})
    report = " ".join(str(sitedda.check(model)).split())
    points = re.search(r"shear strain G/G0 = ([\d.]+) and ([\d.]+),", report).groups()
    assert list(map(float, points)) == pytest.approx(curve.reduction_at([1e-3, 1e-2]), rel=0.02)
    pattern = r"within (\S+) %(?:, damping ratios within (\S+) percentage points)?"
    points = re.search(pattern, report).groups()
    misfit = 100 * np.array(Branches.of(curve, 60, soil.get("damping_curve", "target")).misfit)
    assert [float(number or 0) for number in points] == pytest.approx(misfit, rel=2e-3)


@pytest.mark.parametrize("plasticity, is_warned", [(200.0, True), (100.0, False)])
def test_a_poorly_fitted_damping_curve_causes_a_warning(plasticity, is_warned):
    soil = DARENDELI | {"mean_stress": 2.5e4, "plasticity_index": plasticity}
    model = shaken_column(sine(2.0, 0.1, 20), 2, soil)
    for report in (str(sitedda.check(model)), str(model.run().verdict)):
        assert ("points off their curve, more than 0.3" in " ".join(report.split())) == is_warned


def test_safety_uses_the_shear_strength_of_a_curve():
    """A block of 20 kN/m³, 1 m high, has a mean stress of 10 kPa: 2 s_u/F."""
    for curve, warning in (("hyperbolic", "half the size"), ("darendeli", "elastic")):
        law_variables = {"shear_strength": 6e3} if curve == "hyperbolic" else {"mean_stress": 1e4}
        model = standing_block(law="hysteretic", curve=curve, **law_variables)
        result = sitedda.safety(model, tolerance=2e-3)
        assert warning in result.warning
        assert result.factor == (pytest.approx(1.2, rel=3e-3) if curve == "hyperbolic" else 4096.0)


@pytest.mark.parametrize("integration", ["dda", "theta", "midpoint"])
def test_no_step_gains_energy(integration):
    history = sheared_block(1e-3, DARENDELI, integration).run().history
    for term in ("energy_plastic", "energy_material_damping"):
        assert np.all(np.diff(history[term].values) >= 0)
    scale = history.energy_plastic.values[-1]
    assert np.abs(history.energy_balance).max() < 1e-9 * scale


def test_at_small_strains_soil_is_linear_with_a_damping_ratio():
    """With 1e-7 of the motion, a linear material with the same damping ratio moves equally."""
    ground = 1e-7 * sine(2.0, 1.0, 400)
    soil = MASING | {"damping_ratio": 0.02}
    models = [shaken_column(ground, 4, law, "dda") for law in (soil, {"damping_ratio": 0.02})]
    soil_motion, linear_motion = (moved(model.run().history) for model in models)
    assert np.abs(soil_motion - linear_motion).max() < 0.02 * np.abs(linear_motion).max()


def test_modes_use_the_small_strain_modulus():
    ground = sine(2.0, 1.0, 4)
    models = [shaken_column(ground, 8, law) for law in (MASING, {})]
    soil, linear = (sitedda.modes(model, count=6).frequency for model in models)
    np.testing.assert_allclose(soil, linear, rtol=1e-12)


@pytest.mark.parametrize("soil", [MASING | {"damping_ratio": 0.01}, DARENDELI])
def test_a_run_is_bit_identical_everywhere(soil, tmp_path, same_everywhere):
    same_everywhere(shaken_column(sine(2.0, 1.0, 240), 6, soil).write(tmp_path / "m.nml"), 113)


@pytest.mark.parametrize("first, second", [({}, MASING), (MASING, {}), (MASING, DARENDELI)])
def test_a_change_of_law_keeps_stresses(first, second):
    """The material of a block changes while the block is held sheared."""
    model = soil_model(None, first, time_step=1e-2)
    young = 2 * SHEAR * (1 + POISSON)
    model.material("other", density=DENSITY, young_modulus=young, poisson_ratio=POISSON, **second)
    hold_sheared(model, 1e-3 * np.minimum(np.arange(102) / 50, 1))
    model.stage(name="first", steps=95)
    model.stage(name="second", steps=5, change_materials="soil -> other")
    with sitedda.Simulation(model) as simulation:
        simulation.advance(95)
        before = simulation.stresses[0, 2]
        simulation.advance(5)
        after = simulation.stresses[0, 2]
    assert after == pytest.approx(before, rel=1e-4)
    law = {"yields": 1e-3 / (1 + 1e-3 / REFERENCE), "linear": 1e-3}
    assert before == pytest.approx(SHEAR * law["yields" if first else "linear"], rel=0.02)


@pytest.mark.parametrize(
    "soil, message",
    [
        ({"law": "hysteretic"}, "curve is missing"),
        (
            {"law": "hysteretic", "curve": "darendeli"},
            "mean_stress is missing: curve = 'darendeli' needs it",
        ),
        ({"law": "hysteretic", "curve": "mkz"}, "needs reference_strain or shear_strength"),
        (MASING | {"shear_strength": 1e5}, "reference_strain or shear_strength, not both"),
        (MASING | {"curve": "gqh"}, "curve_fit is missing"),
        (MASING | {"curve": "table"}, "strains is missing"),
        (MASING | {"rayleigh_beta": 1e-4}, "law = 'hysteretic' excludes rayleigh_beta"),
        ({"curve": "mkz"}, "law"),
    ],
)
def test_an_incomplete_law_is_refused(soil, message):
    with pytest.raises(sitedda.InputError, match=message):
        shaken_column(sine(2.0, 1.0, 4), 2, soil).run()
