# SPDX-License-Identifier: GPL-3.0-or-later
"""Signal tools against closed forms."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.fft import next_fast_len

from sitedda.signals import (
    dominant_frequency,
    fast_length,
    log_decrement,
    response_spectrum,
    smooth_konno_ohmachi,
)

# --- Logarithmic decrement -----------------------------------------------------------------------


def decay(damping, frequency=5.0, offset=0.0, step=1e-3, duration=4.0, phase=0.7):
    """Free vibration of a viscously damped oscillator with the given damped frequency."""
    time = step * np.arange(round(duration / step))
    omega = 2 * np.pi * frequency
    rate = omega * damping / np.sqrt(1 - damping**2)
    return time, offset + np.exp(-rate * time) * np.cos(omega * time - phase)


@pytest.mark.parametrize("damping", [1e-3, 0.01, 0.05, 0.2])
@pytest.mark.parametrize("offset", [0.0, -3.0])
def test_exact_damping_is_recovered(damping, offset):
    decrement = log_decrement(*decay(damping, offset=offset))
    assert_allclose(decrement.damping_exact, damping, rtol=1e-3)
    assert_allclose(decrement.damping, damping / np.sqrt(1 - damping**2), rtol=1e-3)
    assert_allclose(decrement.frequency, 5.0, rtol=1e-4)
    assert_allclose(decrement.offset, offset, atol=1e-4)
    assert decrement.residual < 2e-3


def test_equation_11_uses_the_first_and_the_nth_crest():
    time, x = decay(0.03)
    decrement = log_decrement(time, x, cycles=4)
    assert decrement.crests.size == decrement.times.size == 5
    expected = np.log(decrement.crests[0] / decrement.crests[4]) / (2 * np.pi * 4)
    assert_allclose(decrement.damping, expected, rtol=1e-12)
    assert_allclose(np.diff(decrement.times), 0.2, rtol=1e-4)


def test_crests_are_located_between_samples():
    # 11 samples a period: the nearest sample alone is wrong by up to 4 % in height
    time, x = decay(0.005, step=1 / 55, duration=6.0)
    decrement = log_decrement(time, x)
    assert_allclose(decrement.damping_exact, 0.005, rtol=0.02)
    assert decrement.residual < 0.005


@settings(max_examples=40, deadline=None)
@given(damping=st.floats(0.002, 0.15), scale=st.floats(1e-9, 1e9), offset=st.floats(-5.0, 5.0),
       phase=st.floats(0.0, 6.28), frequency=st.floats(3.0, 30.0))  # fmt: skip
def test_units_origin_and_phase_have_no_effect(damping, scale, offset, phase, frequency):
    time, x = decay(damping, frequency, offset, phase=phase)
    decrement = log_decrement(time + 17.0, scale * x)
    assert_allclose(decrement.damping_exact, damping, rtol=5e-3)
    assert_allclose(decrement.frequency, frequency, rtol=5e-3)
    assert_allclose(decrement.offset, scale * offset, atol=1e-3 * scale)


def test_free_vibration_of_the_scheme():
    # Newmark β = 1/2, γ = 1: ζ = ln(1/|λ|) / hypot(φ, ln|λ|), |λ| = (1 + Ω²/2)^(-1/2)
    step, omega = 1e-3, 2 * np.pi * 20.0
    x, velocity, history = 1.0, 0.0, []
    for _ in range(800):
        history.append(x)
        increment = (-(omega**2) * x + 2 / step * velocity) / (omega**2 + 2 / step**2)
        x, velocity = x + increment, 2 / step * increment - velocity
    size = (1 + (omega * step) ** 2 / 2) ** -0.5
    phase = np.arccos((4 - (omega * step) ** 2) / (2 + (omega * step) ** 2) / 2 / size)
    decrement = log_decrement(step * np.arange(800), history, offset=0.0)
    expected = -np.log(size) / np.hypot(phase, np.log(size))
    assert_allclose(decrement.damping_exact, expected, rtol=1e-3)
    assert_allclose(decrement.frequency, phase / (2 * np.pi * step), rtol=1e-4)


def test_a_decay_of_two_frequencies_has_a_large_residual():
    time, single = decay(0.01)
    _, second = decay(0.01, frequency=5.6)
    assert log_decrement(time, single).residual < 1e-3
    assert log_decrement(time, single + 0.5 * second).residual > 0.1


def test_small_noise_does_not_add_crests():
    time, x = decay(0.02)
    noisy = x + 1e-3 * np.random.default_rng(1).standard_normal(time.size)
    decrement = log_decrement(time, noisy, cycles=5, floor=0.02)
    assert_allclose(decrement.damping_exact, 0.02, rtol=0.05)


# --- Konno-Ohmachi -------------------------------------------------------------------------------


def window_average(frequency, spectrum, bandwidth, centre):
    x = bandwidth * np.log10(frequency / centre)
    weight = np.sinc(x / np.pi) ** 4
    return np.sum(weight * spectrum) / np.sum(weight)


@pytest.mark.parametrize("bandwidth", [20.0, 40.0])
def test_smoothing_is_the_published_window(bandwidth):
    frequency = np.linspace(0.1, 30.0, 600)
    spectrum = 1 + np.sin(3 * frequency) ** 2
    centres = np.array([0.5, 2.0, 7.777, 20.0])
    expected = [window_average(frequency, spectrum, bandwidth, c) for c in centres]
    smoothed = smooth_konno_ohmachi(frequency, spectrum, bandwidth, centres)
    assert_allclose(smoothed, expected, rtol=1e-9)


def test_smoothing_keeps_a_constant():
    frequency = np.arange(0, 200)  # whole numbers, from zero
    assert_allclose(smooth_konno_ohmachi(frequency, np.full(200, -3j)), 3.0, rtol=1e-12)


# --- Response spectrum ---------------------------------------------------------------------------


def test_step_acceleration_is_exact():
    # u = -(a/ω²) [1 - exp(-ζωt) (cos ωd t + ζω/ωd sin ωd t)], greatest at ωd t = π
    damping, frequency = 0.05, 2.0
    omega = 2 * np.pi * frequency
    damped = omega * np.sqrt(1 - damping**2)
    step = np.pi / damped / 40  # a sample falls on the maximum
    spectrum = response_spectrum(np.full(60, 3.0), step, [1 / frequency], damping)
    overshoot = np.exp(-damping * np.pi / np.sqrt(1 - damping**2))
    assert_allclose(spectrum.displacement, 3.0 / omega**2 * (1 + overshoot), rtol=1e-12)
    assert_allclose(spectrum.pseudo_acceleration, 3.0 * (1 + overshoot), rtol=1e-12)
    assert_allclose(spectrum.pseudo_velocity, 3.0 / omega * (1 + overshoot), rtol=1e-12)


def test_ramp_acceleration_is_exact():
    # undamped: u = -(c/ω²) (t - sin ωt / ω), u' = -(c/ω²) (1 - cos ωt)
    time = np.linspace(0.0, 1.0, 401)
    omega = 2 * np.pi * 1.0
    spectrum = response_spectrum(2.0 * time, time[1], [1.0], 0.0)
    assert_allclose(spectrum.displacement, 2 / omega**2, rtol=1e-11)
    assert_allclose(spectrum.velocity, 2 / omega**2 * 2, rtol=1e-11)
    assert_allclose(spectrum.acceleration, 2.0, rtol=1e-11)


@pytest.mark.parametrize("ratio", [0.2, 0.7, 1.0, 1.4, 4.0])
def test_harmonic_ground_motion_in_steady_state(ratio):
    damping, frequency, step = 0.2, 2.0, 5e-4
    time = np.arange(0.0, 30.0, step)
    # a motion that grows smoothly, so that the transient never exceeds the steady state
    envelope = np.sin(np.pi / 2 * np.minimum(time / 20.0, 1.0)) ** 2
    ground = envelope * np.sin(2 * np.pi * ratio * frequency * time)
    spectrum = response_spectrum(ground, step, [1 / frequency], damping)
    denominator = np.hypot(1 - ratio**2, 2 * damping * ratio)
    assert_allclose(spectrum.pseudo_acceleration, 1 / denominator, rtol=5e-4)
    transmitted = np.hypot(1, 2 * damping * ratio) / denominator
    assert_allclose(spectrum.acceleration, transmitted, rtol=5e-4)


def test_harmonic_ground_motion_from_rest():
    # ζ = 0.05 by default; steady state plus the transient that starts from rest
    omega, driving, step = 2 * np.pi * 1.5, 2 * np.pi * 2.2, 1e-4
    damping, time = 0.05, np.arange(0.0, 6.0, 1e-4)
    steady = -1 / (omega**2 - driving**2 + 2j * damping * omega * driving)
    eigenvalue = omega * complex(-damping, np.sqrt(1 - damping**2))
    u0, v0 = -np.imag(steady), -np.imag(1j * driving * steady)
    free_vibration = (v0 - eigenvalue.conjugate() * u0) / eigenvalue.imag
    free_vibration = free_vibration * np.exp(eigenvalue * time)
    expected = np.imag(steady * np.exp(1j * driving * time) + free_vibration)
    spectrum = response_spectrum(np.sin(driving * time), step, frequencies=[1.5])
    assert_allclose(spectrum.displacement, np.max(np.abs(expected)), rtol=1e-6)


def test_limits_of_stiff_and_soft_oscillators():
    time = np.arange(0.0, 10.0, 0.01)
    ground = np.sin(2 * np.pi * time) * np.exp(-0.5 * (time - 5.0) ** 2)
    stiff_spectrum = response_spectrum(ground, 0.01, [2e-3])
    assert_allclose(stiff_spectrum.acceleration, np.abs(ground).max(), rtol=1e-3)
    soft_spectrum = response_spectrum(ground, 0.01, [1e4], 0.0)
    displacement = np.abs(np.cumsum(np.cumsum(ground)) * 1e-4).max()
    assert_allclose(soft_spectrum.displacement, displacement, rtol=0.02)


def test_fast_oscillators_have_maxima_between_the_samples():
    ground = np.full(5, 1.0)
    spectrum = response_spectrum(ground, 1.0, damping=0.0, frequencies=[0.9])
    assert_allclose(spectrum.pseudo_acceleration, 2.0, rtol=2e-3)


# --- Dominant frequency --------------------------------------------------------------------------


@settings(max_examples=40, deadline=None)
@given(frequency=st.floats(1.0, 45.0), phase=st.floats(0.0, 6.28), offset=st.floats(-9.0, 9.0))
def test_frequency_of_a_sine_is_found_between_the_bins(frequency, phase, offset):
    time = 0.01 * np.arange(1000)  # lines are 0.1 Hz apart
    x = offset + np.cos(2 * np.pi * frequency * time + phase)
    assert_allclose(dominant_frequency(x, 0.01), frequency, atol=1e-3)


def test_the_band_selects_the_peak():
    time = 0.005 * np.arange(4000)
    x = np.sin(2 * np.pi * 3.0 * time) + 0.2 * np.sin(2 * np.pi * 11.0 * time)
    assert_allclose(dominant_frequency(x, 0.005), 3.0, atol=1e-3)
    assert_allclose(dominant_frequency(x, 0.005, (8.0, 20.0)), 11.0, atol=1e-3)


def test_frequency_of_a_decay():
    time, x = decay(0.02, frequency=6.3)
    assert_allclose(dominant_frequency(x, time[1]), 6.3, rtol=2e-3)


def test_fast_lengths_are_those_of_scipy():
    lengths = [*range(1, 1000), 120_001, 999_983]
    assert [fast_length(n) for n in lengths] == [next_fast_len(n, real=True) for n in lengths]


# --- Bad arguments -------------------------------------------------------------------------------

ERRORS = {
    log_decrement: [
        (([0, 1, 2], [0, 1]), "same length"),
        (([0, 1, 3, 4], [0, 1, 0, 1]), "equidistant"),
        (([0, 1, 2], [0, np.nan, 1]), "x must be finite, got nan at index 1"),
        (([0, 1, 2], [0, 1j, 1]), "x must be real"),
        ((np.arange(9), np.zeros(9)), "extrema, but at least three"),
        ((np.arange(50), np.exp(-np.arange(50.0))), "extrema, but at least three"),
        ((*decay(0.05), 500), "x has .* crests, but 501 are needed"),
        ((*decay(0.05), 0), "cycles .* got 0"),
        ((*decay(0.05), 2, np.inf), "offset must be finite"),
        ((*decay(0.05), 2, 0.0, 1.5), "floor .* got 1.5"),
        ((np.arange(9), np.zeros(9), 1, 0.0), "x has 0 decaying crests, but 2 are needed"),
    ],
    smooth_konno_ohmachi: [
        (([1.0, 2.0], [1.0]), "frequency and spectrum must have the same length"),
        (([2.0, 1.0], [1.0, 1.0]), "frequency must contain increasing"),
        (([-1.0, 1.0], [1.0, 1.0]), "frequency must contain increasing"),
        (([1.0, 2.0], [1.0, np.nan]), "spectrum must be finite, got nan"),
        (([1.0, 2.0], [1.0, 1.0], 0.0), "bandwidth .* got 0"),
        (([1.0, 2.0], [1.0, 1.0], 40.0, [-1.0]), "centres must not be negative"),
        (([1.0, 2.0], [1.0, 1.0], 40.0, [90.0]), "the window at the centre 90 Hz"),
    ],
    response_spectrum: [
        (([1.0], 0.1, [1.0]), "at least two samples, got 1"),
        (([1.0, np.inf], 0.1, [1.0]), "acceleration must be finite, got inf"),
        (([1.0, 1.0], 0.0, [1.0]), "time_step .* got 0"),
        (([1.0, 1.0], 0.1, [1.0, 0.0]), "periods must be finite and positive, got 0"),
        (([1.0, 1.0], 0.1, [1.0, 5e-6]), "periods must be at least 1e-05 s, got 5e-06 s"),
        (([1.0, 1.0], 0.1), "either `periods` or `frequencies`"),
        (([1.0, 1.0], 0.1, [1.0], 1.0), "damping .* got 1"),
        (([1.0, 1.0], 0.1, [1.0], np.nan), "damping .* got nan"),
        (([[1.0, 1.0]], 0.1, [1.0]), "one-dimensional"),
    ],
    dominant_frequency: [
        ((np.ones(7), 0.1), "at least 8 samples, got 7"),
        ((np.full(100, 0.1), 0.1), "has no peak"),
        ((np.zeros(100), 0.1), "has no peak"),
        ((np.full(100, np.nan), 0.1), "x must be finite"),
        ((np.ones(100), -0.1), "dt .* got -0.1"),
        ((np.ones(100), 0.1, (3.0, 2.0)), "band must be"),
        ((np.ones(100), 0.1, (3.0, 7.0)), "band must be 0 <= low < high <= 5 Hz"),
    ],
}


@pytest.mark.parametrize(
    ("function", "arguments", "message"),
    [(function, *case) for function, cases in ERRORS.items() for case in cases],
)
def test_bad_arguments_are_named(function, arguments, message):
    with pytest.raises(ValueError, match=message):
        function(*arguments)
