# SPDX-License-Identifier: GPL-3.0-or-later
"""Damping of materials and wave velocities, as an input says them."""

import numpy as np
import pytest
from model_text import changed, tower

import sitedda


def damped(**values) -> list:
    """The tower in the midpoint rule, with its material changed."""
    groups = changed(tower(steps=400), "control", integration="midpoint")
    return changed(groups, "material", **values)


REFUSED = [
    ({"damping_ratio": -0.1}, "damping_ratio = -0.1"),
    ({"damping_ratio": 0.6}, "damping_ratio = 0.6"),
    ({"reference_frequency": 1.0}, "damping_ratio is missing"),
    ({"damping_ratio": 0.05, "reference_frequency": -1.0}, "reference_frequency = -1"),
    ({"damping_ratio": 0.05, "damping_band": [10.0, 1.0]}, "damping_band = 10, 1 must ascend"),
    ({"damping_ratio": 0.05, "damping_band": [10.0]}, "damping_band: a value is left out"),
    ({"damping_ratio": 0.05, "mechanisms": 40}, "mechanisms = 40"),
    ({"damping_ratio": 0.05, "mechanisms": 3}, "more mechanisms"),
    ({"damping_ratio": 0.05, "rayleigh_alpha": 1.0}, "not both"),
    ({"rayleigh_beta": -1.0}, "rayleigh_beta = -1"),
    ({"damping_ratio": 0.05, "rayleigh_frequencies": [2.0, 2.0]}, "must ascend"),
    (
        {"damping_ratio": 0.05, "rayleigh_frequencies": [2.0, 9.0], "mechanisms": 8},
        "leave them out",
    ),
    ({"shear_velocity": 800.0}, "must be given together"),
    ({"shear_velocity": 800.0, "pressure_velocity": 1600.0}, "not both"),
    (
        {
            "young_modulus": None,
            "poisson_ratio": None,
            "shear_velocity": 800.0,
            "pressure_velocity": 700.0,
        },
        "must be above shear_velocity",
    ),
    (
        {
            "young_modulus": None,
            "poisson_ratio": None,
            "shear_velocity": 100.0,
            "pressure_velocity": 7e4,
        },
        "give young_modulus",
    ),
    ({"young_modulus": None}, "young_modulus is missing"),
]


@pytest.mark.parametrize(("values", "words"), REFUSED, ids=[words for _, words in REFUSED])
def test_bad_values_are_refused_in_words(write_input, values, words):
    with pytest.raises(sitedda.InputError) as caught:
        sitedda.Simulation(write_input(damped(**values)))
    message = str(caught.value)
    assert "group &material (line " in message and words in message
    assert "\n" not in message


def test_mechanisms_that_the_time_step_does_not_admit_are_refused(write_input):
    groups = changed(damped(damping_ratio=0.05, damping_band=[0.1, 50.0]), "control", time_step=0.1)
    with pytest.raises(sitedda.InputError, match="smaller time_step"):
        sitedda.Simulation(write_input(changed(groups, "control", integration="dda")))


def test_velocities_are_moduli(write_input):
    density, young, ratio = 2643.0, 4.788e9, 0.25
    shear = np.sqrt(young / (2 * (1 + ratio)) / density)
    pressure = shear * np.sqrt((2 - 2 * ratio) / (1 - 2 * ratio))
    velocities = {"shear_velocity": shear, "pressure_velocity": pressure}
    by_velocity = damped(young_modulus=None, poisson_ratio=None, **velocities)
    first = sitedda.modes(write_input(by_velocity, "velocities"), 3).frequency
    assert first == pytest.approx(sitedda.modes(write_input(damped(), "moduli"), 3).frequency, 1e-9)


@pytest.mark.parametrize("ratio", [0.02, 0.1])
def test_modes_have_the_moduli_and_damping_of_their_frequencies(write_input, ratio):
    """A constant ratio goes with a modulus (f/f_ref)^2γ, γ = atan(2ζ)/π; joints are elastic."""
    reference, young = 40.0, 4.788e9
    body = {"damping_ratio": ratio, "reference_frequency": reference, "damping_band": [1.0, 500.0]}
    found = sitedda.modes(write_input(damped(**body), "damped"), 3)
    assert "at the frequency of each mode" in found.words
    for mode, frequency in enumerate(found.frequency):
        own = young * (frequency / reference) ** (2 * np.arctan(2 * ratio) / np.pi)
        elastic, stiffer = (
            sitedda.modes(write_input(damped(young_modulus=e), "elastic"), 3).frequency[mode]
            for e in (own, 1.001 * own)
        )
        share = 2 * np.log(stiffer / elastic) / np.log(1.001)  # of the energy that is in strains
        assert frequency == pytest.approx(elastic, 1e-3)
        assert found.damping[mode] == pytest.approx(share * ratio, 3e-3)


def test_rayleigh_damping_of_modes(write_input):
    file = write_input(damped(rayleigh_alpha=3.0, rayleigh_beta=1e-4))
    found = sitedda.modes(file, 3)
    omega = 2 * np.pi * found.frequency
    assert np.all(found.damping > 1.5 / omega + 0.9 * 0.5e-4 * omega)
    assert np.all(found.damping < 1.5 / omega + 0.5e-4 * omega)


def test_a_run_loses_energy_in_the_material(write_input):
    history = sitedda.run(write_input(damped(damping_ratio=0.1))).history
    lost = history.energy_material_damping.values
    assert np.all(np.diff(lost) >= 0) and lost[-1] > 0
    assert abs(history.energy_balance[-1]) < 1e-9 * history.energy_input.max()
