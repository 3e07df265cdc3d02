# SPDX-License-Identifier: GPL-3.0-or-later
"""The 1-D twin against pyStrata and closed forms; `test_scheme.py` has those of its scheme."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pystrata import motion, propagation, site

from sitedda.column import (
    Column,
    HalfSpace,
    Layer,
    complex_modulus,
    damped_amplification,
    refined_peak,
    undamped_amplification,
)
from sitedda.scheme import scheme_damping, scheme_frequency

CONVENTIONS = ("shake", "shake91", "kramer", "dormieux")
FREQUENCIES = np.linspace(0.05, 40.0, 400)

TABLE_1 = {"density": 2643.0, "shear_modulus": 4.788e9 / (2 * 1.25)}
TABLE_2 = ((2403.0, 1.8e9), (2162.0, 1.64e9), (2243.0, 1.68e9), (2483.0, 1.6e9), (2643.0, 1.92e9))


def uniform_column(damping=0.022, count=15):
    return Column([Layer(1.0, damping=damping, **TABLE_1)] * count, convention="shake")


def random_column(seed, base="half-space", convention="shake"):
    rng = np.random.default_rng(seed)
    layers = [
        Layer(
            rng.uniform(0.5, 12.0),
            density=rng.uniform(1500.0, 2700.0),
            shear_velocity=rng.uniform(100.0, 900.0),
            damping=rng.uniform(0.002, 0.1),
        )
        for _ in range(rng.integers(1, 9))
    ]
    rock = HalfSpace(density=2700.0, shear_velocity=rng.uniform(600.0, 2500.0), damping=0.005)
    return Column(layers, rock if base == "half-space" else "rigid", convention)


# --- pyStrata ------------------------------------------------------------------------------------


def strata_transfer(column, rock, frequencies, places):
    """The answer of pyStrata; each place is (layer index, depth within it, wave field)."""
    media = [(layer, layer.thickness) for layer in column.layers] + [(rock, 0.0)]
    profile = site.Profile(
        [
            site.Layer(
                site.SoilType("", medium.density * motion.GRAVITY, None, medium.damping),
                thickness,
                medium.shear_velocity,
            )
            for medium, thickness in media
        ]
    )
    response, reference = (
        site.Location(index, profile[index], field, within) for index, within, field in places
    )
    calculator = propagation.LinearElasticCalculator()
    calculator(motion.Motion(frequencies), profile, reference)
    return calculator.calc_accel_tf(reference, response)


@pytest.fixture(params=["shake", "kramer", "dormieux"])
def convention(request, monkeypatch):
    names = {"shake": "seed", "kramer": "kramer", "dormieux": "dormieux"}
    monkeypatch.setattr(site, "COMP_MODULUS_MODEL", names[request.param])
    return request.param


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("field", ["within", "outcrop"])
def test_half_space_column_agrees_with_pystrata(convention, seed, field):
    column = random_column(seed, convention=convention)
    places = (0, 0.0, "outcrop"), (len(column.layers), 0.0, field)
    expected = strata_transfer(column, column.base, FREQUENCIES, places)
    # pyStrata takes the surface as an outcrop: the same as within, A = B there
    assert_allclose(column.transfer(FREQUENCIES, kind=field), expected, rtol=1e-6)


@pytest.mark.parametrize("seed", range(6))
def test_rigid_column_agrees_with_pystrata_within_motion(convention, seed):
    column = random_column(seed, "rigid", convention)
    rock = HalfSpace(density=2500.0, shear_velocity=1500.0)  # of no influence on within/within
    places = (0, 0.0, "within"), (len(column.layers), 0.0, "within")
    expected = strata_transfer(column, rock, FREQUENCIES, places)
    assert_allclose(column.transfer(FREQUENCIES), expected, rtol=1e-6)
    assert_allclose(column.transfer(FREQUENCIES, kind="outcrop"), expected, rtol=1e-6)


@pytest.mark.parametrize("seed", range(20, 26))
@pytest.mark.parametrize("field", ["within", "outcrop"])
def test_points_inside_layers_agree_with_pystrata(convention, seed, field):
    column = random_column(seed, convention=convention)
    last = len(column.layers) - 1
    top = 0.3 * column.layers[0].thickness
    within = 0.7 * column.layers[last].thickness
    bottom = sum(layer.thickness for layer in column.layers[:last]) + within
    expected = strata_transfer(
        column, column.base, FREQUENCIES, ((0, top, "within"), (last, within, field))
    )
    assert_allclose(column.transfer(FREQUENCIES, top, bottom, field), expected, rtol=1e-6)


# --- Closed forms --------------------------------------------------------------------------------


@pytest.mark.parametrize("name", CONVENTIONS)
def test_uniform_rigid_column_is_one_over_cosine(name):
    layer = Layer(15.0, damping=0.05, **TABLE_1)
    modulus = complex_modulus(layer.shear_modulus, 0.05, name)
    wave_number = 2 * np.pi * FREQUENCIES * np.sqrt(layer.density / modulus)
    actual = Column([layer], convention=name).transfer(FREQUENCIES)
    assert_allclose(actual, 1 / np.cos(15.0 * wave_number), rtol=1e-12)


def test_undamped_column_is_equation_9():
    column = uniform_column(damping=0.0)
    expected = undamped_amplification(FREQUENCIES, 15.0, column.layers[0].shear_velocity)
    assert_allclose(np.abs(column.transfer(FREQUENCIES)), expected, rtol=1e-9)


def test_equation_10_is_the_damped_column_up_to_second_order():
    velocity = uniform_column().layers[0].shear_velocity

    def error(damping):
        exact = np.abs(uniform_column(damping).transfer(FREQUENCIES))
        return np.max(
            np.abs(damped_amplification(FREQUENCIES, 15.0, velocity, damping) / exact - 1)
        )

    assert error(0.022) < 0.04
    assert_allclose(error(2e-4) / error(1e-4), 4.0, rtol=0.05)


def test_equations_9_and_10_at_the_resonance():
    resonance = 300.0 / (4 * 15.0)
    assert_allclose(damped_amplification(resonance, 15.0, 300.0, 0.05), 2 / (np.pi * 0.05))
    assert undamped_amplification(resonance, 15.0, 300.0) > 1e15
    off = np.array([0.0, 2.0])
    assert_allclose(
        damped_amplification(off, 15.0, 300.0, 0.0), undamped_amplification(off, 15.0, 300.0)
    )


def test_layer_on_half_space_has_the_impedance_ratio_as_peak():
    soil = HalfSpace(density=1800.0, shear_velocity=200.0)
    rock = HalfSpace(density=2500.0, shear_velocity=1000.0)
    layer = Layer(20.0, density=soil.density, shear_velocity=soil.shear_velocity)
    peak = Column([layer], rock).peak(kind="outcrop")
    assert_allclose(peak.frequency, 200.0 / 80.0, rtol=1e-7)
    assert_allclose(peak.amplitude, 2500.0 * 1000.0 / (1800.0 * 200.0), rtol=1e-12)


def test_static_motion_is_not_amplified():
    assert Column([Layer(3.0, density=1.0, shear_modulus=1.0, damping=0.3)]).transfer(0.0) == 1.0


def test_complex_moduli():
    ratio = 0.2
    expected = {
        "shake": 1 + 0.4j,
        "shake91": 0.92 + 0.4j * np.sqrt(0.96),
        "kramer": 0.96 + 0.4j,
        "dormieux": np.sqrt(0.84) + 0.4j,
    }
    for name in CONVENTIONS:
        assert_allclose(complex_modulus(3.0, ratio, name), 3 * expected[name], rtol=1e-15)
    assert_allclose(complex_modulus(3.0, ratio), 3 * expected["dormieux"], rtol=1e-15)  # by default
    for name in ("shake91", "dormieux"):  # these keep the modulus
        assert_allclose(np.abs(complex_modulus(3.0, ratio, name)), 3.0, rtol=1e-15)


# --- The paper -----------------------------------------------------------------------------------


def test_table_1_peak():
    peak = uniform_column(0.022).peak()
    assert_allclose(peak.amplitude, 28.95, atol=0.005)
    assert_allclose(peak.frequency, 14.191, atol=0.0005)


def test_table_1_agrees_with_the_papers_shake():
    peak = replace(uniform_column(0.022), convention="shake91").peak()
    assert_allclose(peak.amplitude, 28.93, atol=0.005)  # all digits printed
    assert_allclose(peak.frequency, 14.21, rtol=0.002)


def test_table_2_agrees_with_the_papers_shake_with_layer_1_on_top():
    layers = [
        Layer(3.0, density=density, shear_modulus=modulus, damping=0.023)
        for density, modulus in TABLE_2
    ]
    peak = Column(layers, convention="shake").peak()
    assert_allclose(peak.amplitude, 27.79, rtol=0.008)
    assert_allclose(peak.frequency, 14.50, rtol=0.003)
    upside_down = Column(layers[::-1], convention="shake").peak()
    assert abs(upside_down.frequency - 14.50) > 0.5


# --- The time integration ------------------------------------------------------------------------


def test_scheme_equals_a_damped_column_at_the_scheme_frequency():
    step, frequency = 1e-3, 13.0
    ratio = float(scheme_damping(frequency, step))
    column = uniform_column(ratio)
    assert_allclose(
        column.scheme_transfer(frequency, step),
        column.transfer(scheme_frequency(frequency, step)),
        rtol=1e-12,
    )


def test_scheme_peak_is_damped_and_slightly_low():
    column = uniform_column()
    peak = column.peak(time_step=1e-3)
    amplitude = 2 / (np.pi * scheme_damping(peak.frequency, 1e-3))
    assert_allclose(peak.amplitude, amplitude, rtol=2e-3)
    assert 0.998 < peak.frequency / (column.layers[0].shear_velocity / 60.0) < 1.0


# --- Frequency-dependent damping -----------------------------------------------------------------


def test_damping_may_be_a_function_of_frequency():
    column = uniform_column(lambda f: 0.01 + 0.002 * f)
    pointwise = [uniform_column(0.01 + 0.002 * f).transfer(f) for f in FREQUENCIES]
    assert_allclose(column.transfer(FREQUENCIES), pointwise, rtol=1e-13)


# --- Numerical safety ----------------------------------------------------------------------------


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("field", ["within", "outcrop"])
def test_thick_layers_and_high_frequencies_do_not_overflow(field):
    layers = [Layer(5000.0, density=1800.0, shear_velocity=100.0, damping=0.1)] * 20
    rock = HalfSpace(density=2500.0, shear_velocity=1000.0)
    transfer = Column(layers, rock).transfer([0.001, 1.0, 1e4], kind=field)
    assert np.all(np.isfinite(transfer))
    assert transfer[-1] == 0.0


def test_interfaces_are_met_despite_rounding():
    layers = [Layer(0.1, density=1800.0 + 50 * i, shear_velocity=200.0 + 20 * i) for i in range(9)]
    rock = HalfSpace(density=2500.0, shear_velocity=1000.0)
    column = Column(layers, rock)
    at_interface = column.transfer(FREQUENCIES, 0.0, 0.3, "outcrop")
    just_below = column.transfer(FREQUENCIES, 0.0, 0.3 + 1e-7, "outcrop")
    assert_allclose(at_interface, just_below, rtol=1e-4)
    assert_allclose(column.transfer(5.0, 0.0, 0.9), column.transfer(5.0))


# --- Peaks ---------------------------------------------------------------------------------------


def test_peak_of_a_lightly_damped_column_is_found_between_the_samples():
    layer = Layer(15.0, damping=1e-5, **TABLE_1)
    peak = Column([layer]).peak()
    assert_allclose(peak.frequency, layer.shear_velocity / 60.0, rtol=1e-8)
    assert_allclose(peak.amplitude, 2 / (np.pi * 1e-5), rtol=1e-6)


def test_higher_peaks_by_band():
    column = uniform_column(0.01)
    first = column.layers[0].shear_velocity / 60.0
    for mode in (3, 5, 31):
        peak = column.peak(((mode - 1) * first, (mode + 1) * first))
        assert_allclose(peak.frequency, mode * first, rtol=1e-3)
        assert_allclose(peak.amplitude, 1 / np.sinh(mode * np.pi / 2 * 0.01), rtol=2e-3)


def test_peak_of_any_function():
    peak = refined_peak(lambda f: 3 / (1 + (f - 2.125) ** 2), (0.0, 10.0), 20)
    assert_allclose((peak.frequency, peak.amplitude), (2.125, 3.0), rtol=1e-7)


# --- Errors --------------------------------------------------------------------------------------

GOOD = Layer(1.0, density=2000.0, shear_velocity=200.0)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Layer(0.0, density=1.0, shear_modulus=1.0), "thickness .* got 0"),
        (lambda: Layer(1.0, density=-2.0, shear_modulus=1.0), "density .* got -2"),
        (lambda: Layer(1.0, density=1.0), "shear_modulus or shear_velocity"),
        (lambda: Layer(1.0, density=1.0, shear_velocity=np.nan), "shear_velocity .* got nan"),
        (lambda: Layer(1.0, density=1.0, shear_modulus=4.0, shear_velocity=3.0), "agree"),
        (lambda: Layer(1.0, density=1.0, shear_modulus=1.0, damping=-0.1), "damping .* got -0.1"),
        (lambda: Column([]), "layers must contain at least one"),
        (lambda: Column([GOOD, 3]), "layers must contain Layer objects, got 3 as item 2"),
        (lambda: Column([GOOD], "soft"), "base must be .* got 'soft'"),
        (lambda: Column([GOOD], GOOD), "base must be"),
        (lambda: Column([GOOD], convention="voigt"), "convention must be one of .* got 'voigt'"),
        (lambda: Column([GOOD]).transfer([1.0, -3.0]), "frequencies .* got -3"),
        (lambda: Column([GOOD]).transfer(np.nan), "frequencies .* got nan"),
        (lambda: Column([GOOD]).transfer(1.0, bottom=2.0), "bottom must be a depth in 0 ... 1 m"),
        (lambda: Column([GOOD]).transfer(1.0, top=np.nan), "top must be a depth"),
        (lambda: Column([GOOD]).transfer(1.0, 0.8, 0.2), "top must not lie below bottom"),
        (lambda: Column([GOOD]).transfer(1.0, kind="rock"), "kind must be one of"),
        (lambda: Column([GOOD]).peak((5.0, 2.0)), "band must be"),
        (lambda: Column([GOOD]).peak((1.0, 2.0)), "contains no peak"),
        (lambda: Column([GOOD]).peak(), "unbounded"),
        (lambda: Column([GOOD]).scheme_transfer(50.0, 0.01), "Nyquist frequency 50 Hz"),
        (
            lambda: complex_modulus(1.0, 0.6),
            "damping must be in 0 ... 0.5 .*: 'shake', 'shake91', 'kramer'$",
        ),
        (lambda: complex_modulus(1.0, np.nan), "damping .* got nan"),
        (lambda: undamped_amplification(1.0, 1.0, 0.0), "shear_velocity .* got 0"),
        (lambda: damped_amplification(1.0, 1.0, 1.0, -1.0), "damping .* got -1"),
        (lambda: refined_peak(lambda f: f * np.nan, (0.0, 1.0)), "transfer is not finite"),
        (lambda: uniform_column(lambda f: f[:1]).transfer([1.0, 2.0]), "one ratio per frequency"),
        (lambda: uniform_column(lambda f: -f).transfer([1.0, 2.0]), "damping .* got -1"),
    ],
)
def test_errors_name_the_argument_and_its_value(call, message):
    with pytest.raises(ValueError, match=message):
        call()
