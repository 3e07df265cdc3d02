# SPDX-License-Identifier: GPL-3.0-or-later
"""The closed forms of the time integration against steps that are taken one by one."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import sitedda
from sitedda import scheme_damping, scheme_frequency, theta_for_damping, time_step_for_damping
from sitedda.column import Column, HalfSpace, Layer
from sitedda.scheme import Scheme

MEMBERS = {
    "dda": (1.0, 0.5),
    "midpoint": (0.5, 0.5),
    "theta": (0.75, 0.75),
    "backward_euler": (1.0, 1.0),
}
OMEGA = 10.0  # rad/s


def step_matrix(theta: float, chi: float, turn: float) -> np.ndarray:
    """One step of x'' + ω² x = 0 in (x, v Δt), solved for the end: docs/method.md."""
    before = np.array([[1.0, 1 - chi], [-(1 - theta) * turn**2, 1.0]])
    after = np.array([[1.0, -chi], [theta * turn**2, 1.0]])
    return np.linalg.solve(after, before)


@pytest.mark.parametrize("name", MEMBERS)
def test_the_members_by_name(name):
    assert (Scheme.named(name).theta, Scheme.named(name).chi) == MEMBERS[name]


@pytest.mark.parametrize("name", MEMBERS)
@pytest.mark.parametrize("turn", [0.05, 0.5, 3.0, 5.0, 100.0, 1e4])
def test_roots_are_the_eigenvalues_of_a_step(name, turn):
    found = Scheme.named(name).vibration(OMEGA / (2 * np.pi), turn / OMEGA)
    expected = np.linalg.eigvals(step_matrix(*MEMBERS[name], turn))
    order = np.argsort(-abs(expected)) if np.isreal(expected).all() else np.argsort(-expected.imag)
    roots = found.roots if np.isreal(expected).all() else sorted(found.roots, key=lambda z: -z.imag)
    assert_allclose(roots, expected[order], rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize("name", MEMBERS)
def test_damping_and_period_of_a_free_vibration(name):
    turn = 0.3
    root = np.linalg.eigvals(step_matrix(*MEMBERS[name], turn))[0]
    found = Scheme.named(name).vibration([OMEGA / (2 * np.pi)], turn / OMEGA)
    logarithm = np.log(root)
    assert_allclose(found.damping, -logarithm.real / abs(logarithm), rtol=1e-10, atol=1e-14)
    assert_allclose(found.elongation, turn / abs(logarithm.imag) - 1, rtol=1e-9)


def test_a_velocity_that_changes_its_sign_lasts_as_its_root_says():
    root = np.linalg.eigvals(step_matrix(1.0, 0.5, 30.0)).min()
    assert root < 0
    found = Scheme().vibration(OMEGA / (2 * np.pi), 30.0 / OMEGA)
    assert_allclose(found.ringing, -1 / np.log(-root), rtol=1e-9)
    assert found.damping == 1.0 and found.elongation == -1.0
    assert Scheme().vibration(OMEGA / (2 * np.pi), 0.1 / OMEGA).ringing == 0.0
    # the midpoint rule loses nothing: rounding may leave a huge number, or infinity
    assert Scheme.named("midpoint").vibration(OMEGA / (2 * np.pi), 30.0 / OMEGA).ringing > 1e12


@pytest.mark.parametrize("name", MEMBERS)
def test_steady_vibration_is_that_of_forced_steps(name):
    """x'' + 2hx' + ω²x = a e^{iωt} with force at t₀ + θΔt, until the start has died out."""
    (theta, chi), step, frequency = MEMBERS[name], 0.01, 7.0
    factors = Scheme.named(name).steady(frequency, step)
    square, dashpot, end = OMEGA**2, 3.0, 500.0  # stiffness at θ, dashpot on d/Δt, spring at end
    angle = 2j * np.pi * frequency * step
    x, v = 0.0, 0.0
    for n in range(4000):
        mass = 1 / (chi * step**2)
        load = np.exp(angle * (n + theta)) - square * x - end * x + v / (chi * step)
        d = load / (mass + theta * square + dashpot / step + end)
        x, v = x + d, d / (chi * step) - (1 / chi - 1) * v
    impedance = factors.inertia + square + dashpot * factors.mean_dashpot
    expected = factors.load / (impedance + end * factors.end_stiffness)
    assert_allclose(x / np.exp(angle * 4000), expected, rtol=1e-9)


@pytest.mark.parametrize("name", MEMBERS)
def test_the_twin_is_the_column_of_the_complex_modulus(name):
    """Modulus G (1 + i(2θ − 1)τ)(1 + i(2χ − 1)τ) at 2τ/Δt, in a closed form of one's own."""
    (theta, chi), step = MEMBERS[name], 5e-3
    frequency = np.array([0.5, 3.3, 11.0, 40.0])
    tau = np.tan(np.pi * frequency * step)
    loss = (1 + 1j * (2 * theta - 1) * tau) * (1 + 1j * (2 * chi - 1) * tau)
    density, speed, height = 1900.0, 350.0, 30.0
    column = Column([Layer(height, density=density, shear_velocity=speed)])
    phase = 2 * tau / step * height / (speed * np.sqrt(loss))
    found = column.scheme_transfer(frequency, step, integration=name)
    assert_allclose(found, 1 / np.cos(phase), rtol=1e-9)
    base = HalfSpace(density=2200.0, shear_velocity=800.0)
    contrast = density * speed / (2200.0 * 800.0)
    found = Column(column.layers, base).scheme_transfer(
        frequency, step, kind="outcrop", integration=name
    )
    assert_allclose(found, 1 / (np.cos(phase) + 1j * contrast * np.sin(phase)), rtol=1e-9)


def test_the_twins_peak_knows_the_member():
    column = Column([Layer(15.0, density=2643.0, shear_velocity=851.0)])
    peaks = {
        name: column.peak(time_step=1e-3, integration=name).amplitude
        for name in ("dda", "theta", "backward_euler")
    }
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


def test_damping_of_all_members_is_half_the_loss_factor():
    tau = np.tan(np.pi * 14.0 * 5e-3)
    for name, (theta, chi) in MEMBERS.items():
        modulus = (1 + 1j * (2 * theta - 1) * tau) * (1 + 1j * (2 * chi - 1) * tau)
        ratio = modulus.imag / modulus.real / 2
        assert scheme_damping(14.0, 5e-3, name) == pytest.approx(ratio, rel=1e-12, abs=1e-15)
    assert scheme_damping(80.0, 5e-3, "backward_euler") == np.inf  # no positive real part


@pytest.mark.parametrize("name", ["dda", "theta", "backward_euler"])
def test_the_step_for_a_damping_is_the_inverse(name):
    ratios = np.array([1e-6, 0.022, 0.3, 2.0])
    steps = time_step_for_damping(ratios, 14.0, name)
    assert_allclose([scheme_damping(14.0, s, name) for s in steps], ratios, rtol=1e-10)


def test_theta_for_a_damping_is_the_inverse():
    ratios = np.array([0.0, 1e-4, 0.022, 0.1])
    found = theta_for_damping(ratios, 14.2, 5e-3)
    assert found[0] == 0.5
    again = [scheme_damping(14.2, 5e-3, "theta", theta) for theta in found]
    assert_allclose(again, ratios, rtol=1e-10, atol=1e-15)


def test_the_member_of_a_group_control():
    assert Scheme.of_control({"time_step": 1e-3}) == Scheme()
    assert Scheme.of_control({"integration": "theta"}) == Scheme(0.75, 0.75)
    asked = {"integration": "theta", "time_step": 5e-3, "damping_ratio": 0.05}
    found = Scheme.of_control(asked | {"damping_frequency": 14.0})
    assert found.theta == found.chi
    assert scheme_damping(14.0, 5e-3, found) == pytest.approx(0.05)


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


def test_all_of_it_is_public():
    names = {"scheme_damping", "scheme_frequency", "theta_for_damping", "time_step_for_damping"}
    assert names <= set(sitedda.__all__)
