# SPDX-License-Identifier: GPL-3.0-or-later
"""Closed forms of the time integration in Python; `tests/fortran/test_scheme.f90` tests the forms
themselves."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from sitedda import scheme_damping, scheme_frequency, theta_for_damping, time_step_for_damping
from sitedda.column import Column, HalfSpace, Layer
from sitedda.scheme import Scheme

MEMBERS = {
    "dda": (1.0, 0.5),
    "midpoint": (0.5, 0.5),
    "theta": (0.75, 0.75),
    "backward_euler": (1.0, 1.0),
}


@pytest.mark.parametrize("name", MEMBERS)
def test_the_members_by_name(name):
    assert (Scheme.named(name).theta, Scheme.named(name).chi) == MEMBERS[name]


@pytest.mark.parametrize("name", MEMBERS)
def test_the_column_with_a_scheme_has_the_complex_modulus(name):
    """Modulus G (1 + i(2θ − 1)τ)(1 + i(2χ − 1)τ) at 2τ/Δt, in an independent closed form."""
    (theta, chi), step = MEMBERS[name], 5e-3
    frequency = np.array([0.5, 3.3, 11.0, 40.0])
    tau = np.tan(np.pi * frequency * step)
    loss = (1 + 1j * (2 * theta - 1) * tau) * (1 + 1j * (2 * chi - 1) * tau)
    density, speed, height = 1900.0, 350.0, 30.0
    column = Column([Layer(height, density=density, shear_velocity=speed)])
    phase = 2 * tau / step * height / (speed * np.sqrt(loss))
    response = column.scheme_transfer(frequency, step, integration=name)
    assert_allclose(response, 1 / np.cos(phase), rtol=1e-9)
    base = HalfSpace(density=2200.0, shear_velocity=800.0)
    contrast = density * speed / (2200.0 * 800.0)
    column = Column(column.layers, base)
    response = column.scheme_transfer(frequency, step, kind="outcrop", integration=name)
    assert_allclose(response, 1 / (np.cos(phase) + 1j * contrast * np.sin(phase)), rtol=1e-9)


def test_the_peak_of_a_column_depends_on_the_member():
    column = Column([Layer(15.0, density=2643.0, shear_velocity=851.0)])
    peaks = {name: column.peak(time_step=1e-3, integration=name).amplitude
             for name in ("dda", "theta", "backward_euler")}  # fmt: skip
    assert peaks["theta"] == pytest.approx(peaks["dda"], rel=2e-3)
    assert peaks["backward_euler"] == pytest.approx(peaks["dda"] / 2, rel=5e-3)
    with pytest.raises(ValueError, match="unbounded"):
        column.peak(time_step=1e-3, integration="midpoint")


def test_damping_of_the_dda_member_is_the_known_closed_form():
    frequency = np.array([0.5, 14.0, 200.0])
    assert_allclose(scheme_damping(frequency, 1e-3), 0.5 * np.tan(np.pi * frequency * 1e-3))
    expected = np.tan(np.pi * frequency * 1e-3) / (np.pi * 1e-3)
    assert_allclose(scheme_frequency(frequency, 1e-3), expected, rtol=1e-12)
    assert scheme_frequency(0.0, 1e-3) == 0.0 == scheme_damping(0.0, 1e-3)
    assert scheme_damping(80.0, 5e-3, "backward_euler") == np.inf  # no positive real part


@pytest.mark.parametrize("name", ["dda", "theta", "backward_euler"])
def test_the_step_for_a_damping_is_the_inverse(name):
    ratios = np.array([1e-6, 0.022, 0.3, 2.0])
    steps = time_step_for_damping(ratios, 14.0, name)
    assert_allclose([scheme_damping(14.0, s, name) for s in steps], ratios, rtol=1e-10)


def test_theta_for_a_damping_is_the_inverse():
    ratios = np.array([0.0, 1e-4, 0.022, 0.1])
    thetas = theta_for_damping(ratios, 14.2, 5e-3)
    assert thetas[0] == 0.5
    ratios_again = [scheme_damping(14.2, 5e-3, "theta", theta) for theta in thetas]
    assert_allclose(ratios_again, ratios, rtol=1e-10, atol=1e-15)


def test_the_member_of_a_group_control():
    assert Scheme.of_control({"time_step": 1e-3}) == Scheme()
    assert Scheme.of_control({"integration": "theta"}) == Scheme(0.75, 0.75)
    variables = {"integration": "theta", "time_step": 5e-3, "damping_ratio": 0.05}
    scheme = Scheme.of_control(variables | {"damping_frequency": 14.0})
    assert scheme.theta == scheme.chi
    assert scheme_damping(14.0, 5e-3, scheme) == pytest.approx(0.05)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: scheme_damping(1.0, 0.0), "time_step .* got 0"),
        (lambda: scheme_damping(500.0, 1e-3), "Nyquist frequency 500 Hz .* got 500"),
        (lambda: scheme_damping(1.0, 1e-3, "newmark"), "integration 'newmark' is not known"),
        (lambda: scheme_damping(1.0, 1e-3, "theta", 0.4), "theta must be in 0.5 ... 1, got 0.4"),
        (lambda: time_step_for_damping(0.0, 1.0), "damping .* got 0"),
        (lambda: time_step_for_damping(0.1, np.inf), "frequency .* got inf"),
        (lambda: time_step_for_damping(0.1, 1.0, "midpoint"), "has no damping at any time step"),
        (lambda: theta_for_damping(-0.1, 1.0, 1e-3), "damping .* got -0.1"),
        (lambda: theta_for_damping(0.1, 600.0, 1e-3), "Nyquist frequency 500 Hz"),
        (lambda: theta_for_damping(0.5, 14.2, 1e-3), "needs a time_step of at least 0.0088"),
    ],
)
def test_errors_name_the_argument_and_its_value(call, message):
    with pytest.raises(ValueError, match=message):
        call()
