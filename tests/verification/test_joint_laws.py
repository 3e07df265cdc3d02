# SPDX-License-Identifier: GPL-3.0-or-later
"""Joint laws in whole models: closure, strength, weakening, dilation, stiffness per area."""

import numpy as np
import pytest

import sitedda
from sitedda_evidence import model as nml

GRAVITY, DENSITY, WIDTH = 10.0, 2500.0, 2.0  # m/s², kg/m³, m
WEIGHT = DENSITY * WIDTH * GRAVITY  # weight of a block of 2 m x 1 m, N/m
ROUGH = {"law": "barton_bandis", "jrc": 10.0, "jcs": 1e8}


def pressed(stress: float, *groups: str, block_count: int = 1, width: float = WIDTH, **law) -> str:
    """A block presses on a joint with a stress (Pa); the base consists of `block_count` blocks."""
    text = [
        nml.control(1e-3, 1, gravity=(0.0, -GRAVITY), settle=True),
        nml.contact(1e12),
        nml.material("rock", DENSITY, 1e14),
        nml.material("load", stress / GRAVITY, 1e14),
        nml.joint("j", 30.0, **law),
        nml.block("top", nml.rectangle(0.0, 0.0, width, 1.0), "load", "j"),
        nml.measured_point("top", (width / 2, 0.5), "top"),
    ]
    edges = np.linspace(0.0, width, block_count + 1)
    text += [
        nml.fixed_block(f"base{i}", nml.rectangle(a, -1.0, b - a, 1.0), "rock", "j")
        for i, (a, b) in enumerate(zip(edges[:-1], edges[1:], strict=True))
    ]
    return "".join((*text, *groups))


def sheared(slip: float, density: float = DENSITY, returns: bool = False, **law) -> str:
    """A block is driven along its joint by `slip` (m) in 1 s, and may be driven back in 1 s."""
    fraction = np.linspace(0.0, 1.0, 201)
    displacement = slip * fraction**3 * (10 - 15 * fraction + 6 * fraction**2)
    if returns:
        displacement = np.concatenate([displacement, displacement[-2::-1]])
    steps, stress = 1100 if returns else 600, density * GRAVITY
    return nml.driven_block(2e-3, steps, law, displacement, 5e-3, 100, stress=stress, width=WIDTH)


def last(data, name: str) -> np.ndarray:
    """Return a variable of the closed contacts in the last frame."""
    of_last = (data.contact_frame == data.contact_frame.max()) & (data.contact_normal_force > 1.0)
    return data[f"contact_{name}"].values[of_last.values]


@pytest.mark.parametrize("stress", [1e6, 5e6, 10e6])
def test_hyperbolic_closure(stress):
    """δ = σ/(k_ni + σ/V_m), with k_ni and V_m from the index values."""
    with nml.simulation(pressed(stress, **ROUGH, compressive_strength=1e8)) as run:
        run.advance(1)
        contacts = run.contacts
    stiffness = (-7.15 + 1.75 * 10 + 0.02 * 100 / 0.2) * 1e9
    closure = (-0.296 - 0.0056 * 10 + 2.241 * (100 / 0.2) ** -0.245) * 1e-3
    is_closed = contacts["state"] > 0
    expected = stress / (stiffness + stress / closure)
    assert -contacts["gap"][is_closed] == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("block_count", [1, 2, 5])
def test_stiffness_of_the_joint(block_count):
    """The closure is σ/k for each number of corners; contact lengths add up to the joint length."""
    with nml.simulation(
        pressed(1e6, block_count=block_count, normal_stiffness_per_area=1e9)
    ) as run:
        run.advance(1)
        contacts = run.contacts
    is_closed = contacts["normal_force"] > 1.0
    assert is_closed.sum() == 2 * block_count
    assert contacts["length"][is_closed].sum() == pytest.approx(WIDTH, rel=1e-9)
    assert -contacts["gap"][is_closed] == pytest.approx(1e-3, rel=1e-6)


@pytest.mark.parametrize("stress", [1e6, 5e6, 10e6])
def test_rough_strength(stress):
    """Each sliding contact has τ = σ tan(φ_r + JRC log₁₀(JCS/σ))."""
    data = nml.history(sheared(5e-3, stress / GRAVITY, **ROUGH, compressive_strength=1e8))
    middle = (data.contact_frame == 3) & (data.contact_state == 1)
    force, shear, length = (
        data[f"contact_{name}"].values[middle.values]
        for name in ("normal_force", "shear_force", "length")
    )
    angle = np.radians(30.0 + 10.0 * np.log10(1e8 * length / force))
    assert len(force) == 2
    assert np.abs(shear) == pytest.approx(force * np.tan(angle), rel=1e-6)
    assert force.sum() == pytest.approx(stress * WIDTH, rel=1e-3)
    assert nml.energy_residual(data) < 1e-6


@pytest.mark.parametrize("limit", [None, 0.01])
def test_slip_dilates_up_to_its_limit(limit):
    """The block rises by slip · tan ψ up to the limiting slip; friction supplies the work."""
    law = {"law": "mohr_coulomb", "dilation_angle": 8.0, "dilation_slip": limit}
    data = nml.history(sheared(0.02, **{k: v for k, v in law.items() if v}))
    slip = last(data, "slip_path")
    dilation = float(data.displacement.sel(point="top")[-1, 1])
    expected = np.tan(np.radians(8.0)) * np.minimum(slip, limit or np.inf)
    assert dilation == pytest.approx(expected, rel=1e-6)
    assert nml.energy_residual(data) < 1e-6
    assert float(data.energy_dilation[-1]) == pytest.approx(WEIGHT * dilation, rel=1e-3)
    assert float(data.energy_gravity[-1]) == pytest.approx(WEIGHT * dilation, rel=1e-6)


def test_work_of_linear_slip_weakening():
    """Work of linear slip weakening: ½ (peak + residual) d + residual (s − d)."""
    law = {"law": "mohr_coulomb", "friction_angle": 40.0, "residual_friction_angle": 20.0,
           "cohesion": 2e4, "residual_cohesion": 5e3, "weakening_slip": 0.01}  # fmt: skip
    data = nml.history(sheared(0.02, **law))
    peak, residual = (
        WEIGHT * np.tan(np.radians(angle)) + WIDTH * cohesion
        for angle, cohesion in ((40.0, 2e4), (20.0, 5e3))
    )
    slip = last(data, "slip_path").mean()
    work = 0.5 * (peak + residual) * 0.01 + residual * (slip - 0.01)
    assert float(data.energy_friction[-1]) == pytest.approx(work, rel=2e-3)
    assert last(data, "weakened") == pytest.approx(1.0)
    assert nml.energy_residual(data) < 1e-6


def test_a_brittle_joint_drops_to_its_residual_strength():
    """A brittle joint breaks once, at its peak strength."""
    law = {"law": "mohr_coulomb", "friction_angle": 40.0, "residual_friction_angle": 20.0,
           "cohesion": 2e4, "tensile_strength": 1e4, "residual_cohesion": 5e3,
           "residual_tensile_strength": 2e3}  # fmt: skip
    data = nml.history(sheared(0.02, **law))
    residual = WEIGHT * np.tan(np.radians(20.0)) + WIDTH * 5e3
    slip = last(data, "slip_path").mean()
    assert float(data.energy_friction[-1]) == pytest.approx(residual * slip, rel=1e-4)
    assert float(data.energy_fracture[-1]) > 0
    assert last(data, "weakened") == pytest.approx(1.0)
    assert last(data, "bonded").all()
    assert nml.energy_residual(data) < 1e-6


@pytest.mark.parametrize("law", ["coulomb", "mohr_coulomb"])
def test_equivalent_laws_have_equal_results(law):
    """Coulomb contacts, a law without special variables, and a stiffness per area."""
    coulomb = nml.history(sheared(0.02))
    joint = {"law": law, "normal_stiffness_per_area": 1e10, "shear_stiffness_per_area": 4e9}
    equivalent = nml.history(sheared(0.02, **joint))
    for name in ("displacement", "energy_friction", "energy_contact"):
        scale = float(np.abs(coulomb[name]).max())
        assert np.abs(coulomb[name] - equivalent[name]).max() < 1e-9 * scale


SHAKEN = {
    "coulomb": {"law": "coulomb"},
    "mohr_coulomb": {"law": "mohr_coulomb", "friction_angle": 40.0, "dilation_angle": 10.0,
                     "residual_friction_angle": 30.0, "weakening_slip": 1e-3},
    "brittle": {"law": "mohr_coulomb", "friction_angle": 40.0, "residual_friction_angle": 30.0},
    "barton_bandis": ROUGH | {"max_closure": 1e-3},
    "cohesive": {"law": "cohesive", "cohesion": 3e4, "tensile_strength": 1.5e4,
                 "fracture_energy": 5.0},
    "plesha": {"law": "plesha", "asperity_angle": 10.0, "asperity_wear": 1e-3},
}  # fmt: skip


def shaken_wall(stiffness: float, **law) -> str:
    """Bricks whose bed and head joints open, close and slip."""
    ground = 0.3 * np.sin(2 * np.pi * np.arange(61) / 100)
    groups = [
        nml.control(1e-3, 40, (0.0, -GRAVITY), settle=True),
        nml.contact(stiffness),
        nml.material("rock", DENSITY, 5e9),
        nml.joint("j", law.pop("friction_angle", 30.0), **law),
        nml.block("base", nml.rectangle(-1.0, -1.0, 10.0, 1.0), "rock", "j"),
        nml.group("wall", brick_length=1.0, brick_height=0.5, bricks=8, courses=8),
        nml.motion("ground", ground, 1e-3, "velocity"),
        *(nml.group("fixed_point", x=x, y=-0.5, motion_x="ground") for x in (0.5, 7.5)),
        nml.measured_point("top", (4.0, 3.75), ""),
        nml.group("output", block_interval=10),
    ]
    return "".join(groups)


@pytest.mark.parametrize("points", [2, 3, 5])
@pytest.mark.parametrize("law", SHAKEN)
def test_a_shaken_wall_converges_with_each_law(law, points):
    """Forces are continuous as contacts open, close and slip, as with Coulomb contacts."""
    options = SHAKEN[law] | {"normal_stiffness_per_area": 2e9, "contact_points": points}
    data = nml.history(shaken_wall(1e9, **options))
    assert nml.energy_residual(data) < 1e-6
    # 5 or 6 per step; 22 where cohesion softens, 93 where friction drops suddenly
    assert int(data.iterations.max()) <= {"cohesive": 40, "brittle": 150}.get(law, 10)
    assert float(data.energy_friction[-1]) > 0


def test_modes_use_the_tangent_stiffness_at_the_weight(tmp_path):
    """Vertical mode of a heavy block on a closed joint: k = k_ni (1 − δ/V_m)⁻²."""
    stress, stiffness, closure = 5e6, 2e10, 1.4e-4
    law = {**ROUGH, "normal_stiffness_per_area": stiffness, "max_closure": closure}
    file = tmp_path / "model.nml"
    file.write_text(pressed(stress, **law))
    settlement = stress / (stiffness + stress / closure)
    tangent = stiffness / (1 - settlement / closure) ** 2
    expected = np.sqrt(tangent / (stress / GRAVITY)) / (2 * np.pi)
    frequencies = sitedda.modes(file, 3).frequency
    assert np.abs(np.array(frequencies) / expected - 1).min() < 1e-3
