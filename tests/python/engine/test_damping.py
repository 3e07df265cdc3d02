# SPDX-License-Identifier: GPL-3.0-or-later
"""Damping of materials and wave velocities as variables of an input."""

import re

import numpy as np
import pytest
from model_text import changed, group, tower, without

import sitedda
from sitedda.damping import ConstantRatio, Rayleigh


def damped(**values) -> list:
    """The tower with the midpoint rule and a changed material."""
    groups = changed(tower(steps=400), "control", integration="midpoint")
    return changed(groups, "material", **values)


BARE = {"young_modulus": None, "poisson_ratio": None}
REFUSED = [
    ({"damping_ratio": -0.1}, "damping_ratio = -0.1"),
    ({"damping_ratio": 0.6}, "damping_ratio = 0.6"),
    ({"reference_frequency": 1.0}, "reference_frequency needs damping_ratio"),
    ({"damping_ratio": 0.05, "reference_frequency": -1.0}, "reference_frequency = -1"),
    ({"damping_ratio": 0.05, "damping_band": [10.0, 1.0]}, "damping_band = 10, 1 must ascend"),
    ({"damping_ratio": 0.05, "damping_band": [10.0]}, "damping_band: a value is missing"),
    ({"damping_ratio": 0.05, "mechanisms": 40}, "mechanisms = 40"),
    ({"damping_ratio": 0.05, "mechanisms": 3}, "more mechanisms"),
    ({"damping_ratio": 0.05, "rayleigh_alpha": 1.0}, "not both"),
    ({"rayleigh_beta": -1.0}, "rayleigh_beta = -1"),
    ({"damping_ratio": 0.05, "rayleigh_frequencies": [2.0, 2.0]}, "must ascend"),
    (
        {"damping_ratio": 0.05, "rayleigh_frequencies": [2.0, 9.0], "mechanisms": 8},
        "give either rayleigh_frequencies or mechanisms, not both",
    ),
    ({"shear_velocity": 800.0}, "pressure_velocity is missing: shear_velocity needs it"),
    ({"shear_velocity": 800.0, "pressure_velocity": 1600.0}, "or young_modulus, not both"),
    ({**BARE, "shear_velocity": 800.0, "pressure_velocity": 700.0}, "must be above shear_velocity"),
    ({**BARE, "shear_velocity": 100.0, "pressure_velocity": 7e4}, "give young_modulus"),
    ({"young_modulus": None}, "young_modulus is missing"),
    ({"damping_ratio": 0.05, "damping_band(2)": 50.0}, "damping_band"),
    ({"damping_ratio": 0.05, "rayleigh_frequencies(2)": 8.0}, "rayleigh_frequencies"),
]


@pytest.mark.parametrize(("values", "phrase"), REFUSED, ids=[message for _, message in REFUSED])
def test_bad_values_are_refused_with_a_reason(write_input, values, phrase):
    with pytest.raises(sitedda.InputError) as error_info:
        sitedda.Simulation(write_input(damped(**values)))
    message = str(error_info.value)
    assert "group &material (line " in message and phrase in message
    assert "\n" not in message


def test_mechanisms_too_fast_for_the_time_step_are_refused(write_input):
    groups = changed(damped(damping_ratio=0.05, damping_band=[0.1, 50.0]), "control", time_step=0.1)
    with pytest.raises(sitedda.InputError, match="smaller time_step"):
        sitedda.Simulation(write_input(changed(groups, "control", integration="dda")))


def test_a_band_above_all_mechanisms_is_refused(write_input):
    groups = changed(damped(damping_ratio=0.05), "control", time_step=10.0, integration="dda")
    message = "permits mechanisms only up to .* smaller time_step"
    with pytest.raises(sitedda.InputError, match=message):
        sitedda.Simulation(write_input(groups))


def test_a_longer_time_step_is_refused_if_mechanisms_are_too_fast(write_input):
    file = write_input(changed(damped(damping_ratio=0.05), "control", integration="dda"))
    with sitedda.Simulation(file) as run:
        run.advance(2)
        with pytest.raises(sitedda.InputError, match="too long for the damping of a material"):
            run.change({"time_step": 0.05})
        run.advance(2)


def test_velocities_are_equivalent_to_moduli(write_input):
    density, young, ratio = 2643.0, 4.788e9, 0.25
    shear = np.sqrt(young / (2 * (1 + ratio)) / density)
    pressure = shear * np.sqrt((2 - 2 * ratio) / (1 - 2 * ratio))
    velocities = {"shear_velocity": shear, "pressure_velocity": pressure}
    by_velocity = damped(young_modulus=None, poisson_ratio=None, **velocities)
    by_velocity = changed(by_velocity, "control", analysis="plane_stress")  # as in the other model
    first = sitedda.modes(write_input(by_velocity, "velocities"), 3).frequency
    assert first == pytest.approx(sitedda.modes(write_input(damped(), "moduli"), 3).frequency, 1e-9)


@pytest.mark.parametrize("ratio", [0.02, 0.1])
def test_modes_have_the_moduli_and_damping_of_their_frequencies(write_input, ratio):
    """A constant ratio changes the modulus by (f/f_ref)^2γ, γ = atan(2ζ)/π; joints are elastic."""
    reference, young = 40.0, 4.788e9
    body = {"damping_ratio": ratio, "reference_frequency": reference, "damping_band": [1.0, 500.0]}
    modes = sitedda.modes(write_input(damped(**body), "damped"), 3)
    assert "at its own frequency" in modes.words
    for mode, frequency in enumerate(modes.frequency):
        modulus = young * (frequency / reference) ** (2 * np.arctan(2 * ratio) / np.pi)
        elastic, stiffer = (
            sitedda.modes(write_input(damped(young_modulus=e), "elastic"), 3)
            for e in (modulus, 1.001 * modulus)
        )
        assert frequency == pytest.approx(elastic.frequency[mode], 1e-3)
        # Fraction of the strain energy in the damped material; supports have numerical damping
        energy_fraction = 2 * np.log(stiffer.frequency / elastic.frequency)[mode] / np.log(1.001)
        expected = energy_fraction * ratio + elastic.damping[mode]
        assert modes.damping[mode] == pytest.approx(expected, 3e-3)


def test_rayleigh_damping_of_modes(write_input):
    file = write_input(damped(rayleigh_alpha=3.0, rayleigh_beta=1e-4))
    modes = sitedda.modes(file, 3)
    omega = 2 * np.pi * modes.frequency
    assert np.all(modes.damping > 1.5 / omega + 0.9 * 0.5e-4 * omega)
    assert np.all(modes.damping < 1.5 / omega + 0.5e-4 * omega)


def test_a_run_loses_energy_in_the_material(write_input):
    history = sitedda.run(write_input(damped(damping_ratio=0.1))).history
    dissipated = history.energy_material_damping.values
    assert np.all(np.diff(dissipated) >= 0) and dissipated[-1] > 0
    assert abs(history.energy_balance[-1]) < 1e-9 * history.energy_input.max()


DAMPED = {
    "constant ratio": (
        {"damping_ratio": 0.05, "reference_frequency": 5.0},
        ConstantRatio(0.05, 5.0),
    ),
    "Rayleigh": (
        {"damping_ratio": 0.05, "rayleigh_frequencies": [2.0, 12.0]},
        Rayleigh.at(0.05, (2, 12)),
    ),
}


@pytest.mark.parametrize("integration", ["dda", "theta", "midpoint"])
@pytest.mark.parametrize("name", DAMPED)
def test_thin_layers_respond_as_the_column(write_input, name, integration):
    """15 m of layers with stiff joints and time steps of 5 ms."""
    values, damping = DAMPED[name]
    groups = changed(damped(**values), "control", time_step=5e-3, integration=integration)
    groups = changed(groups, "contact", normal_stiffness=1e15)
    groups = changed(groups, "layers", 1, thickness=0.25, count=60)
    point = {"name": "surface", "x": 7.5, "y": 15.0, "block": "layer_60"}
    groups = [*without(groups, "measured_point"), ("measured_point", point)]
    groups.append(group("measured_point", name="base", x=7.5, y=0.0, block="base_1"))
    frequencies = np.linspace(1.0, 40.0, 40)
    response = sitedda.transfer(write_input(groups), frequencies)
    layer = sitedda.Layer(15.0, density=2643.0, shear_modulus=4.788e9 / 2.5, damping=damping)
    column = sitedda.Column([layer])
    exact = column.scheme_transfer(frequencies, 5e-3, integration=integration)
    assert np.max(abs(response / exact - 1)) < 5e-3
    assert (
        np.max(abs(column.scheme_transfer(frequencies, 1e-6) / column.transfer(frequencies) - 1))
        < 1e-3
    )


def test_damping_of_a_layer_is_its_ratio():
    frequencies = np.geomspace(0.1, 50.0, 50)
    for ratio in (0.01, 0.2):
        body = ConstantRatio(ratio, 14.2)
        assert body.ratio_at(frequencies) == pytest.approx(ratio, rel=1e-3)
        assert body.body.factor(2 * np.pi * 14.2).real == pytest.approx(1.0, rel=1e-12)
    rayleigh = Rayleigh.at(0.05, (2.0, 12.0))
    assert (rayleigh.alpha, rayleigh.beta) == pytest.approx((1.0771175, 1.136821e-3), rel=1e-6)
    with pytest.raises(sitedda.InputError, match="more mechanisms"):
        ConstantRatio(0.05, mechanisms=3)


CHECKED = [
    ({"damping_ratio": 0.05}, {}, "ok", "over 0.1 … 50 Hz"),
    (
        {"damping_ratio": 0.05, "damping_band": [20.0, 50.0]},
        {},
        "warn",
        "damping is smaller outside the band",
    ),
    ({"damping_ratio": 0.05}, {"gravity": [0.0, -9.81]}, "warn", "creep under their weight"),
    ({"damping_ratio": 0.05}, {"gravity": [0.0, -9.81], "settle": True}, "ok", "mechanisms"),
    # 5 mechanisms have an error of 0.58 % of the ratio in 1 … 40 Hz, 1.1 % in 1 … 80 Hz; limit 1 %.
    (
        {"damping_ratio": 0.05, "mechanisms": 5, "damping_band": [1.0, 40.0]},
        {"integration": "midpoint"},
        "ok",
        "error 0.5816 %",
    ),
    (
        {"damping_ratio": 0.05, "mechanisms": 5, "damping_band": [1.0, 80.0]},
        {"integration": "midpoint"},
        "warn",
        "error 1.103 %",
    ),
    ({"damping_ratio": 0.05, "rayleigh_frequencies": [5.0, 50.0]}, {}, "ok", "largest α"),
    ({"rayleigh_beta": 0.1}, {}, "ok", "changes its sign in each step"),
]


@pytest.mark.parametrize(("material", "control", "verdict", "message"), CHECKED)
def test_check_reports_the_damping_of_materials(write_input, material, control, verdict, message):
    file = write_input(changed(damped(**material), "control", **control))
    report = sitedda.check(file)
    assert not re.search(r"\b(omega|zeta|eta|alpha|beta|tau|dt|dx)\b|omega_max", report.text)
    lines = {line.topic: line for line in report.lines}
    line = lines["Rayleigh damping" if "rayleigh" in str(material) else "material damping"]
    assert line.verdict == verdict and message in line.words


def test_check_states_no_damping_ratio_at_a_frequency_of_zero(write_input):
    """ζ = α/(2ω) is undefined at 0 Hz, where the band of a one-sided record begins."""
    groups = changed(damped(rayleigh_beta=1e-3), "motion", values=[1.0] * 8)
    report = sitedda.check(write_input(groups))
    lines = {line.topic: line for line in report.lines}
    assert report.band[0] == 0.0 and "NaN" not in report.text
    assert " % at " in lines["Rayleigh damping"].words


def test_check_reports_that_alpha_damps_free_blocks(write_input):
    groups = changed(damped(rayleigh_alpha=1.0), "joint", cohesion=0.0, tensile_strength=0.0)
    groups = changed(groups, "control", gravity=[0.0, -9.81], settle=True)
    lines = {line.topic: line for line in sitedda.check(write_input(groups)).lines}
    assert lines["Rayleigh damping"].verdict == "warn"
    assert "fall at most at a speed of 9.81" in lines["Rayleigh damping"].words


def test_the_highest_frequency_uses_the_largest_modulus(write_input):
    body = {"damping_ratio": 0.2, "damping_band": [0.1, 2.0], "reference_frequency": 0.5}
    file = write_input(damped(**body), "damped")
    stiffer = ConstantRatio(0.2, 0.5, (0.1, 2.0)).body.unrelaxed * 4.788e9
    soft = {"contact": {"normal_stiffness": 1.5e9}}
    expected = sitedda.check(write_input(damped(young_modulus=stiffer), "stiff"), changes=soft)
    omega_max = sitedda.check(file, changes=soft).omega_max
    assert omega_max == pytest.approx(expected.omega_max, rel=1e-9)
