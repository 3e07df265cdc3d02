# SPDX-License-Identifier: GPL-3.0-or-later
"""Joints whose shear force is a function of slip: continuously yielding, rate and state."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import sitedda
from sitedda_evidence import model as nml

GRAVITY, LOAD = 10.0, 1e6  # m/s²; N/m on a block of 1 m x 1 m: a stress of 1 MPa
YIELDING = {"law": "continuously_yielding", "initial_friction_angle": 45.0, "roughness": 2e-3,
            "normal_stiffness_per_area": 1e10, "shear_stiffness_per_area": 1e10}  # fmt: skip
A, SLIP, THRESHOLD = 0.01, 1e-4, 1e-9  # a, L (m), v_c (m/s)
REFERENCE = 1e-6  # v_0, m/s


def driven(displacements, step: float, every=1, **law):
    """Return the history of a block with a given displacement (m) along its joint in each step."""
    steps = len(displacements) - 1
    return nml.history(nml.driven_block(step, steps, law, displacements, step, every))


def shear_and_slip(data) -> tuple[np.ndarray, np.ndarray]:
    """Return shear force (N/m) and slip (m) of the joint in each frame."""
    frame = data.contact_frame.values
    force = -np.bincount(frame, data.contact_shear_force.values)
    position = data.displacement.sel(point="top", axis="x").values
    at = np.searchsorted(data.time.values, data.frame_time.values)
    return force, position[at] - position[0]


def yielding_stress(slips, stiffness=1e10, pressure=1e6) -> np.ndarray:
    """Return τ (Pa) along slips (m) by integration, with r as defined in UDEC."""
    stress, worn, ratio, path = 0.0, 0.0, 0.0, 0.0
    stresses = [0.0]

    def rates(stress, worn, path, ratio):
        bound = pressure * np.tan(np.pi / 6 + np.pi / 12 * np.exp(-worn / YIELDING["roughness"]))
        factor = (1 - path * stress / bound) / (1 - ratio)
        return np.array([factor * stiffness * path, 1 - factor]), bound

    for change in np.diff(slips):
        sign = np.sign(change)
        if sign * path < 0:
            ratio = min(0.75, sign * stress / rates(stress, worn, sign, 0.0)[1])
        path = sign
        solution = solve_ivp(
            lambda _, y, *state: rates(*y, *state)[0], (0.0, abs(change)), (stress, worn),
            args=(path, ratio), rtol=1e-6, atol=(1.0, 1e-12),
        )  # fmt: skip
        stress, worn = solution.y[:, -1]
        stresses.append(stress)
    return np.array(stresses)


def test_a_yielding_joint_passes_its_peak():
    """φ_m from 45° to 30°: peak 0.9320 MPa; 0.8364, 0.6082, 0.5774 MPa at 1, 5 and 20 mm."""
    displacement = np.concatenate([np.zeros(20), np.arange(1, 4061) * 5e-6])
    data = driven(displacement, 2e-3, every=10, **YIELDING)
    force, slip = shear_and_slip(data)
    assert force.max() == pytest.approx(0.9320e6, rel=1e-3)
    for slip_at, stress in ((1e-3, 0.8364e6), (5e-3, 0.6082e6), (20e-3, 0.5774e6)):
        assert np.interp(slip_at, slip, force) == pytest.approx(stress, rel=1e-3)
    assert nml.energy_residual(data) < 1e-6
    assert (data.contact_state.values[-2:] == 1).all()  # it slides


def test_a_yielding_joint_is_elastic_at_a_reversal():
    """Slip to 2 mm, back to 1 mm, and to 4 mm; in small cycles r is at most 0.75."""
    reversals = np.array([0.0, 2e-3, 1e-3, 1.02e-3, 0.98e-3, 4e-3])
    step = 2e-6
    parts = [np.arange(1, round(abs(b - a) / step) + 1) * step * np.sign(b - a) + a
              for a, b in zip(reversals[:-1], reversals[1:], strict=True)]  # fmt: skip
    data = driven(np.concatenate([np.zeros(20), *parts]), 2e-3, every=5, **YIELDING)
    force, _ = shear_and_slip(data)
    every_step = data.displacement.sel(point="top", axis="x").values
    at = np.searchsorted(data.time.values, data.frame_time.values)
    expected = yielding_stress(every_step - every_step[0])[at]
    assert np.abs(force - expected).max() < 3e-3 * expected.max()
    assert force.min() < -0.65e6
    assert nml.energy_residual(data) < 1e-6


def steady(velocity: float, b: float, friction: float = np.tan(np.pi / 6)) -> float:
    """Friction coefficient of steady slip."""
    direct = A * np.log((velocity + THRESHOLD) / REFERENCE)
    return friction + direct - b * np.log(velocity / REFERENCE)


def rate_state(b: float) -> dict:
    return {"law": "rate_state", "direct_effect": A, "evolution_effect": b or None,
            "threshold_velocity": THRESHOLD, "reference_velocity": REFERENCE,
            "state_distance": SLIP if b else None, "normal_stiffness_per_area": 1e10,
            "shear_stiffness_per_area": 1e12}  # fmt: skip


@pytest.mark.parametrize("b", [0.0, 0.006, 0.015])
def test_friction_follows_a_step_of_the_velocity(b):
    """μ for a constant velocity, and after a tenfold step: θ = L/v + (θ₀ − L/v) exp(−vt/L)."""
    slow, fast, step, each = 1e-4, 1e-3, 5e-4, 2000
    slow_part = slow * step * np.arange(each + 1)
    displacement = np.concatenate([slow_part, slow_part[-1] + fast * step * np.arange(1, each + 1)])
    data = driven(
        displacement, step, every=20, **rate_state(b) | {"initial_age": SLIP / slow if b else None}
    )
    force, slip = shear_and_slip(data)
    time = data.frame_time.values
    changes = each * step + time[0]
    assert force[time < changes][-1] == pytest.approx(steady(slow, b) * LOAD, rel=1e-3)
    is_after = time > changes + 10 * step  # the elastic spring has followed
    time_since_change = time[is_after] - changes
    age = SLIP / fast + (SLIP / slow - SLIP / fast) * np.exp(-fast * time_since_change / SLIP)
    expected = np.tan(np.pi / 6) + A * np.log((fast + THRESHOLD) / REFERENCE)
    expected = expected + b * np.log(age * REFERENCE / SLIP)
    assert force[is_after] == pytest.approx(expected * LOAD, rel=1e-3)
    assert force[-1] == pytest.approx(steady(fast, b) * LOAD, rel=1e-3)
    assert (force[-1] > force[time < changes][-1]) == (b < A)
    assert nml.energy_residual(data) < 1e-6


def on_an_incline(angle: float, steps: int, **law):
    """Return the history of a block that is released on a plane."""
    text = (
        nml.control(1e-3, steps, GRAVITY * np.array([np.sin(angle), -np.cos(angle)])),
        nml.contact(1e10),
        nml.material("rock", 2500.0, 1e15),
        nml.joint("j", 30.0, **law),
        nml.fixed_block("base", nml.rectangle(-2.0, -1.0, 5.0, 1.0), "rock", "j"),
        nml.block("top", nml.rectangle(0.0, 0.0, 1.0, 0.2), "rock", "j"),
        nml.measured_point("top", (0.5, 0.1), "top"),
    )
    return nml.history("".join(text))


@pytest.mark.parametrize(("b", "slope"), [(0.0, 0.62), (0.006, 0.60)])
def test_a_block_on_an_incline_reaches_its_steady_velocity(b, slope):
    """tan β = μ₀ + (a − b) ln(v/v₀)."""
    data = on_an_incline(np.arctan(slope), 6000, **rate_state(b), initial_age=0.1)
    velocity = float(data.velocity.sel(point="top", axis="x")[-1])
    assert slope == pytest.approx(steady(velocity, b), rel=1e-5)
    steady_velocity = REFERENCE * np.exp((slope - np.tan(np.pi / 6)) / (A - b))
    assert velocity == pytest.approx(steady_velocity, rel=1e-3)
    assert nml.energy_residual(data) < 1e-6


def test_velocity_weakening_friction_is_unstable():
    """For b > a there is no steady velocity under a constant load."""
    data = on_an_incline(np.arctan(0.75), 1000, **rate_state(0.015))
    assert float(data.velocity.sel(point="top", axis="x")[-1]) > 1.0


@pytest.mark.parametrize(("fraction", "stable"), [(0.5, False), (2.0, True)])
def test_a_spring_slider_has_stick_slip_below_its_critical_stiffness(fraction, stable):
    """k_crit = (b − a) N/L [Ruina, 1983]: steady slip above it, stick-slip below."""
    b, velocity, step, steps = 0.015, 3e-4, 4e-3, 10000
    spring = 1.0 / (1.0 / (fraction * (b - A) * LOAD / SLIP) - 1.0 / 1e12)
    start = steady(velocity, b) * LOAD
    displacement = velocity * step * steps * np.linspace(0.0, 1.2, 13)  # the motion continues
    text = nml.pressed_block(
        step, steps, rate_state(b) | {"initial_age": SLIP / velocity},
        nml.fixed_block("driver", nml.rectangle(2.0, 0.1, 0.5, 0.5), "rock", "j", motion_x="drive"),
        nml.motion("drive", displacement, step * steps / 10, "displacement"),
        nml.group("bolt", name="spring", **{"from": (0.5, 0.3), "to": (2.25, 0.3)},
              from_block="top", to_block="driver", axial_stiffness=spring, pretension=start),
    )  # fmt: skip
    data = nml.history(text)
    speed = data.velocity.sel(point="top", axis="x").values
    final_speeds = speed[len(speed) * 3 // 4 :]
    if stable:
        assert final_speeds == pytest.approx(velocity, rel=0.02)
    else:
        assert final_speeds.min() < 0.1 * velocity
        assert final_speeds.max() > 5 * velocity


@pytest.mark.parametrize("sliding", ["strengthening", "weakening"])
def test_only_slip_of_a_joint_with_an_age_is_doubted(tmp_path, sliding):
    """A block slides by many `state_distance` in a step; another joint comes first."""
    law = "friction_angle = 20.0, law = 'rate_state', direct_effect = 0.01"
    file = tmp_path / "slide.nml"
    file.write_text(f"""
&control time_step = 1e-2, duration = 0.5, gravity = 5.0, -9.81 /
&contact normal_stiffness = 1e9 /
&material density = 2000.0, young_modulus = 1e10, poisson_ratio = 0.2 /
&joint name = 'strengthening', {law}, threshold_velocity = 1e-6 /
&joint name = 'weakening', {law}, evolution_effect = 0.005, state_distance = 1e-4
   threshold_velocity = 1e-6 /
&block name = 'base', vertices = -9,-1, 9,-1, 9,0, -9,0, joint = '{sliding}' /
&block name = 'top', vertices = -0.5,0, 0.5,0, 0.5,1, -0.5,1, joint = '{sliding}' /
&boundary kind = 'fixed', blocks = 'base', side = 'bottom' /
""")
    doubts = str(sitedda.run(file, output=False).verdict)
    assert ("contact_slip_share" in doubts) == (sliding == "weakening")
