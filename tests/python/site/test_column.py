# SPDX-License-Identifier: GPL-3.0-or-later
"""The one-dimensional column against pyStrata, closed forms, a lumped beam and time stepping."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
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
ROCK = HalfSpace(density=2500.0, shear_velocity=1000.0)

TABLE_1 = {"density": 2643.0, "shear_modulus": 4.788e9 / (2 * 1.25)}
TABLE_2 = ((2403.0, 1.8e9), (2162.0, 1.64e9), (2243.0, 1.68e9), (2483.0, 1.6e9), (2643.0, 1.92e9))


def uniform_column(damping=0.022, count=15):
    return Column([Layer(1.0, damping=damping, **TABLE_1)] * count, convention="shake")


def random_column(seed, base="half-space", convention="shake"):
    rng = np.random.default_rng(seed)
    layers = [
        Layer(rng.uniform(0.5, 12.0), density=rng.uniform(1500.0, 2700.0),
              shear_velocity=rng.uniform(100.0, 900.0),
              damping=rng.uniform(0.002, 0.1))
        for _ in range(rng.integers(1, 9))
    ]  # fmt: skip
    rock = HalfSpace(density=2700.0, shear_velocity=rng.uniform(600.0, 2500.0), damping=0.005)
    return Column(layers, rock if base == "half-space" else "rigid", convention)


# --- pyStrata ------------------------------------------------------------------------------------


@pytest.fixture
def strata_transfer(strata_profile):
    """Return pystrata's transfer functions; a place is (layer index, depth in it, wave field)."""

    def transfer(column, rock, frequencies, places):
        profile = strata_profile(column.layers, rock)
        response, reference = (
            site.Location(index, profile[index], field, within) for index, within, field in places
        )
        calculator = propagation.LinearElasticCalculator()
        calculator(motion.Motion(frequencies), profile, reference)
        return calculator.calc_accel_tf(reference, response)

    return transfer


@pytest.fixture(params=["shake", "kramer", "dormieux"])
def convention(request, monkeypatch):
    names = {"shake": "seed", "kramer": "kramer", "dormieux": "dormieux"}
    monkeypatch.setattr(site, "COMP_MODULUS_MODEL", names[request.param])
    return request.param


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("field", ["within", "outcrop"])
def test_columns_agree_with_pystrata(convention, strata_transfer, seed, field):
    """Surface over base, points within layers, and a rigid base."""
    column = random_column(seed, convention=convention)
    last = len(column.layers) - 1
    top, within = 0.3 * column.layers[0].thickness, 0.7 * column.layers[last].thickness
    places = [  # pyStrata defines the surface as outcrop; there outcrop and within are equal, A = B
        ((0, 0.0, "outcrop"), (last + 1, 0.0, field)),
        ((0, top, "within"), (last, within, field)),
        ((0, 0.0, "within"), (last + 1, 0.0, "within")),
    ]
    full, inner, rigid = (strata_transfer(column, column.base, FREQUENCIES, p) for p in places)
    assert_allclose(column.transfer(FREQUENCIES, kind=field), full, rtol=1e-6)
    bottom = column.depth - column.layers[last].thickness + within
    assert_allclose(column.transfer(FREQUENCIES, top, bottom, field), inner, rtol=1e-6)
    # The half-space does not affect within/within; the kind of motion does not affect a rigid base.
    rigid_transfer = replace(column, base="rigid").transfer(FREQUENCIES, kind=field)
    assert_allclose(rigid_transfer, rigid, rtol=1e-6)


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
        actual = damped_amplification(FREQUENCIES, 15.0, velocity, damping)
        return np.abs(actual / exact - 1).max()

    assert error(0.022) < 0.04
    assert_allclose(error(2e-4) / error(1e-4), 4.0, rtol=0.05)


def test_equations_9_and_10_at_the_resonance():
    resonance = 300.0 / (4 * 15.0)
    assert_allclose(damped_amplification(resonance, 15.0, 300.0, 0.05), 2 / (np.pi * 0.05))
    assert undamped_amplification(resonance, 15.0, 300.0) > 1e15
    frequencies = np.array([0.0, 2.0])
    undamped = undamped_amplification(frequencies, 15.0, 300.0)
    assert_allclose(damped_amplification(frequencies, 15.0, 300.0, 0.0), undamped)


def test_layer_on_half_space_has_the_impedance_ratio_as_peak():
    soil = HalfSpace(density=1800.0, shear_velocity=200.0)
    layer = Layer(20.0, density=soil.density, shear_velocity=soil.shear_velocity)
    peak = Column([layer], ROCK).peak(kind="outcrop")
    assert_allclose(peak.frequency, 200.0 / 80.0, rtol=1e-7)
    assert_allclose(peak.amplitude, 2500.0 * 1000.0 / (1800.0 * 200.0), rtol=1e-12)


def test_a_half_space_equal_to_the_layer_reflects_nothing():
    layer = Layer(10.0, density=2000.0, shear_velocity=400.0)
    rock = HalfSpace(density=2000.0, shear_velocity=400.0)
    actual = Column([layer], rock).transfer(FREQUENCIES, kind="outcrop")
    assert_allclose(actual, np.exp(-2j * np.pi * FREQUENCIES * 10.0 / 400.0), rtol=1e-12)


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
    assert_allclose(complex_modulus(3.0, ratio), 3 * expected["dormieux"], rtol=1e-15)  # default
    for name in ("shake91", "dormieux"):  # these conventions do not change the modulus
        assert_allclose(np.abs(complex_modulus(3.0, ratio, name)), 3.0, rtol=1e-15)


# --- The paper -----------------------------------------------------------------------------------


def test_table_1_agrees_with_the_papers_shake():
    column = uniform_column(0.022)
    peak, printed = column.peak(), replace(column, convention="shake91").peak()
    assert_allclose((peak.amplitude, printed.amplitude), (28.95, 28.93), atol=0.005)  # all digits
    assert_allclose(peak.frequency, 14.191, atol=0.0005)
    assert_allclose(printed.frequency, 14.21, rtol=0.002)


def test_table_2_agrees_with_the_papers_shake_with_layer_1_on_top():
    layers = [Layer(3.0, density=density, shear_modulus=modulus, damping=0.023)
              for density, modulus in TABLE_2]  # fmt: skip
    peak = Column(layers, convention="shake").peak()
    assert_allclose(peak.amplitude, 27.79, rtol=0.008)
    assert_allclose(peak.frequency, 14.50, rtol=0.003)
    upside_down = Column(layers[::-1], convention="shake").peak()
    assert abs(upside_down.frequency - 14.50) > 0.5


# --- Lumped shear beam ---------------------------------------------------------------------------


def lumped_beam(column, per_layer):
    """Return lumped mass (diagonal), stiffness per damping ratio, and load per base displacement.

    Nodes at the surface and at the interfaces of thin slices; the base node is prescribed.
    """
    slices = [layer for layer in column.layers for _ in range(per_layer)]
    count = len(slices)
    mass, stiffness = np.zeros(count + 1), np.zeros((count + 1, count + 1), dtype=complex)
    for i, layer in enumerate(slices):
        height = layer.thickness / per_layer
        mass[i : i + 2] += layer.density * height / 2
        spring = layer.shear_modulus * (1 + 2j * layer.damping) / height
        stiffness[i : i + 2, i : i + 2] += spring * np.array([[1, -1], [-1, 1]])
    return mass[:-1], stiffness[:-1, :-1], -stiffness[:-1, -1]


def lumped_transfer(column, frequency, per_layer):
    mass, stiffness, load = lumped_beam(column, per_layer)
    omega = 2 * np.pi * frequency
    return np.linalg.solve(stiffness - omega**2 * np.diag(mass), load)[0]


@pytest.mark.parametrize("seed", [1, 5, 10])
@pytest.mark.parametrize("frequency", [2.0, 7.3])
def test_lumped_shear_beam_converges_to_the_column(seed, frequency):
    column = random_column(seed, "rigid")
    exact = column.transfer(frequency)
    coarse, middle, fine = (lumped_transfer(column, frequency, n) for n in (15, 30, 60))
    assert_allclose(abs(middle - exact) / abs(fine - exact), 4.0, rtol=0.05)  # second order
    sharper = fine + (fine - middle) / 3
    sharp = middle + (middle - coarse) / 3
    assert abs(sharper + (sharper - sharp) / 15 - exact) < 1e-6 * abs(exact)


# --- The time integration ------------------------------------------------------------------------


def newmark_transfer(column, frequency, time_step, per_layer):
    """Exact discrete transfer function of the lumped beam under Newmark β = 1/2, γ = 1."""
    mass, stiffness, load = lumped_beam(column, per_layer)
    z = np.exp(2j * np.pi * frequency * time_step)
    inertia = 2 / time_step**2 * (z - 1) - 4 / time_step**2 * (z - 1) / (z + 1)
    return np.linalg.solve(z * stiffness + inertia * np.diag(mass), z * load)[0]


@pytest.mark.parametrize("frequency", [3.0, 14.0, 41.0])
def test_scheme_transfer_is_the_limit_of_the_discrete_beam(frequency):
    column, step = Column([Layer(15.0, **TABLE_1)]), 1e-3
    exact = column.scheme_transfer(frequency, step)
    coarse, fine = (newmark_transfer(column, frequency, step, n) for n in (200, 400))
    assert_allclose(fine + (fine - coarse) / 3, exact, rtol=1e-6)


def test_scheme_transfer_equals_time_stepping():
    column, step, frequency, count = Column([Layer(15.0, **TABLE_1)]), 2e-3, 14.0, 12000
    mass, stiffness, load = (np.real(part) for part in lumped_beam(column, 60))
    base = np.exp(2j * np.pi * frequency * step * np.arange(count))
    inverse = np.linalg.inv(stiffness + 2 / step**2 * np.diag(mass))
    x, velocity = np.zeros((2, mass.size), dtype=complex)
    for value in base[1:]:
        increment = inverse @ (load * value - stiffness @ x + 2 / step * mass * velocity)
        x, velocity = x + increment, 2 / step * increment - velocity
    assert_allclose(x[0] / base[-1], newmark_transfer(column, frequency, step, 60), rtol=1e-9)
    assert_allclose(x[0] / base[-1], column.scheme_transfer(frequency, step), rtol=3e-3)


def test_small_steps_add_no_damping():
    column = uniform_column(0.0)
    frequencies = np.array([1.0, 10.0, 30.0])
    actual = column.scheme_transfer(frequencies, 1e-9)
    assert_allclose(actual, column.transfer(frequencies), rtol=1e-5)


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


def test_scheme_as_a_function_of_frequency():
    step = 1e-3

    def damping(frequency):
        return scheme_damping(np.arctan(np.pi * frequency * step) / np.pi / step, step)

    column = uniform_column(damping)
    frequencies = np.linspace(1.0, 50.0, 30)
    assert_allclose(column.transfer(scheme_frequency(frequencies, step)),
                    column.scheme_transfer(frequencies, step), rtol=1e-11)  # fmt: skip


# --- Properties ----------------------------------------------------------------------------------

seeds = st.integers(0, 10_000)
scales = st.floats(1e-3, 1e3)
bases = st.sampled_from(["rigid", "half-space"])


def rescaled(medium, length, mass):
    """Return the medium in other units of length and mass, with the same unit of time."""
    thickness = {"thickness": medium.thickness * length} if isinstance(medium, Layer) else {}
    return replace(medium, density=medium.density * mass / length**3, shear_velocity=None,
                   shear_modulus=medium.shear_modulus * mass / length, **thickness)  # fmt: skip


@settings(max_examples=40, deadline=None)
@given(seed=seeds, base=bases, length=scales, mass=scales)
def test_results_do_not_depend_on_units(seed, base, length, mass):
    column = random_column(seed, base)
    rock = column.base if base == "rigid" else rescaled(column.base, length, mass)
    layers = [rescaled(layer, length, mass) for layer in column.layers]
    rescaled_column = replace(column, layers=layers, base=rock)
    assert_allclose(rescaled_column.transfer(FREQUENCIES), column.transfer(FREQUENCIES), rtol=1e-9)


@settings(max_examples=40, deadline=None)
@given(seed=seeds, base=bases, fraction=st.floats(0.01, 0.99), number=seeds)
def test_splitting_a_layer_changes_nothing(seed, base, fraction, number):
    column = random_column(seed, base)
    index = number % len(column.layers)
    layer = column.layers[index]
    thicknesses = (fraction * layer.thickness, (1 - fraction) * layer.thickness)
    halves = [replace(layer, thickness=thickness) for thickness in thicknesses]
    layers = [*column.layers[:index], *halves, *column.layers[index + 1 :]]
    for field in ("within", "outcrop"):
        assert_allclose(replace(column, layers=layers).transfer(FREQUENCIES, kind=field),
                        column.transfer(FREQUENCIES, kind=field), rtol=1e-9)  # fmt: skip


@settings(max_examples=40, deadline=None)
@given(seed=seeds, base=bases, fraction=st.floats(0.0, 1.0))
def test_transfer_functions_multiply(seed, base, fraction):
    column = random_column(seed, base)
    middle = fraction * column.depth
    product = column.transfer(FREQUENCIES, 0.0, middle) * column.transfer(FREQUENCIES, middle)
    assert_allclose(product, column.transfer(FREQUENCIES), rtol=1e-9)
    assert_allclose(column.transfer(FREQUENCIES, middle, middle), 1.0, rtol=1e-12)


@settings(max_examples=25, deadline=None)
@given(seed=seeds)
def test_very_stiff_half_space_is_a_rigid_base(seed):
    rigid = random_column(seed, "rigid")
    rock = HalfSpace(density=2700.0, shear_velocity=1e12)
    for field in ("within", "outcrop"):
        actual = replace(rigid, base=rock).transfer(FREQUENCIES, kind=field)
        assert_allclose(actual, rigid.transfer(FREQUENCIES), rtol=1e-6)


# --- Numerical safety ----------------------------------------------------------------------------


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("field", ["within", "outcrop"])
def test_thick_layers_and_high_frequencies_do_not_overflow(field):
    layers = [Layer(5000.0, density=1800.0, shear_velocity=100.0, damping=0.1)] * 20
    transfer = Column(layers, ROCK).transfer([0.001, 1.0, 1e4], kind=field)
    assert np.all(np.isfinite(transfer))
    assert transfer[-1] == 0.0


def test_interfaces_are_recognised_despite_rounding():
    layers = [Layer(0.1, density=1800.0 + 50 * i, shear_velocity=200.0 + 20 * i) for i in range(9)]
    column = Column(layers, ROCK)
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
        (lambda: Column([GOOD, 3]), "layers must be Layer objects, got 3 as item 2"),
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
            "damping .* 0 ... 0.5 .*: 'shake', 'shake91', 'kramer'$",
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
