# SPDX-License-Identifier: GPL-3.0-or-later
"""Mohr–Coulomb solids in blocks and bodies against closed forms."""

import numpy as np
import pytest

import sitedda
from sitedda_evidence.validation.yielding import bearing, prandtl, strip

COHESION = 3.45e6
SOLID = {
    "law": "mohr_coulomb", "cohesion": COHESION, "friction_angle": 30.0, "dilation_angle": 30.0,
}  # fmt: skip


def solid(penalty, young, poisson, law, density=2500.0, **control):
    """A model of one material without gravity."""
    control = {"gravity": [0.0, 0.0], "integration": "backward_euler"} | control
    model = sitedda.Model(**({"analysis": "plane_strain"} | control))
    model.contact(normal_stiffness=penalty)
    model.material("rock", density=density, young_modulus=young, poisson_ratio=poisson, **law)
    model.joint("joint", friction_angle=30.0)
    return model


def squeezed_block(confining, integration="backward_euler", steps=200, **strength):
    """A stiff block under lateral stress that is compressed to twice its strength."""
    law = SOLID | strength | {"initial_stress": [-confining, -confining, 0.0]}
    model = solid(1e15, 7e12, 0.21, law, time_step=1e-2, steps=steps, integration=integration)
    model.block(vertices=[0, 0, 1, 0, 1, 1, 0, 1], name="block")
    displacements = -1e-5 * np.arange(203) / 200
    model.motion(name="down", values=displacements.tolist(), quantity="displacement",
                 time_step=1e-2)  # fmt: skip
    for x in (0.0, 1.0):
        model.fixed_point(x=x, y=0.0, **({} if x == 0 else {"direction": "y"}))
        model.fixed_point(x=x, y=1.0, direction="y", motion_y="down")
    for side in ("left", "right"):
        model.traction(side=side, normal=confining)
    return model


@pytest.mark.parametrize("dilation", [0.0, 30.0])
@pytest.mark.parametrize("confining, strength", [(0.0, 11.9511506e6), (5e6, 26.9511506e6)])
def test_a_block_yields_at_the_strength_of_mohr_and_coulomb(confining, strength, dilation):
    """q_u = 2c tan 60°, and σ₃ tan² 60° + q_u; the suite yielding_solid tests points to 1e-9."""
    history = squeezed_block(confining, dilation_angle=dilation).run().history
    x, y, xy = history.block_stress.values[-1, 0]
    assert -y == pytest.approx(strength, rel=5e-5)
    dissipated = history.energy_plastic.values
    assert np.all(np.diff(dissipated) >= 0) and dissipated[-1] > 0
    assert np.abs(history.energy_balance).max() < 1e-9 * dissipated[-1]


def test_bounds_that_do_not_converge_are_counted():
    """Only materials with ψ < φ iterate on the mean stress of a bound."""
    for dilation, is_reported in ((0.0, True), (30.0, False)):
        summary = squeezed_block(0.0, dilation_angle=dilation).run().summary
        assert ("mean stress on which" in summary) == is_reported


def test_outputs_and_pictures_show_plastic_strain(tmp_path):
    """Without dilation, both principal plastic strains are opposite: κ is twice one of them."""
    run = squeezed_block(0.0, dilation_angle=0.0).run()
    strains = run.history.block_plastic_strain.values[:, 0]
    elastic = 2 * COHESION * 3**0.5 * (1 - 0.21**2) / 7e12
    assert strains[0] == 0 and np.all(np.diff(strains) >= 0)
    assert strains[-1] == pytest.approx(2 * (1e-5 - elastic), rel=2e-3)
    assert run.maxima["plastic_strain"].value == strains[-1]
    with sitedda.Simulation(squeezed_block(0.0, dilation_angle=0.0)) as simulation:
        while not simulation.advance():
            pass
        assert simulation.plastic_strains[0] == strains[-1]
    run.draw(color="plastic_strain").figure.savefig(tmp_path / "yielded.png")
    assert "plastic_strain" in str(run.view(tmp_path / "yielded.html").read_bytes())


@pytest.mark.parametrize("dilation", [0.0, 10.0, 30.0])
@pytest.mark.parametrize("integration", ["midpoint", "theta", "dda"])
def test_yielding_dissipates_energy(integration, dilation):
    history = squeezed_block(2e6, integration, dilation_angle=dilation).run().history
    dissipated = history.energy_plastic.values
    assert np.all(np.diff(dissipated) >= -1e-12 * dissipated[-1]) and dissipated[-1] > 0
    assert np.abs(history.energy_balance).max() < 1e-9 * dissipated[-1]


@pytest.mark.parametrize(
    "strength, message",
    [
        ({"dilation_angle": 31.0}, "must not be above friction_angle"),
        ({"tensile_strength": 5.98e6}, "must not be above cohesion / tan"),
        ({"cohesion": None}, "cohesion is missing: law = 'mohr_coulomb' needs it"),
        ({"residual_cohesion": 1e6}, "softening_displacement is missing"),
        ({"residual_cohesion": 4e6, "softening_displacement": 0.1}, "must not be above cohesion"),
        ({"residual_tensile_strength": 7e6, "residual_friction_angle": 5.0, "dilation_angle": 0.0,
          "softening_displacement": 0.1},
         "must not be above tensile_strength = 5.97"),  # apex of the cone: 3.45 MPa cot 30°
    ],
)  # fmt: skip
def test_contradictory_strengths_are_refused(strength, message):
    with pytest.raises(sitedda.InputError, match=message):
        squeezed_block(0.0, steps=2, **strength).run()


def test_the_tensile_strength_may_be_that_of_the_cone():
    apex = SOLID["cohesion"] / np.tan(np.radians(SOLID["friction_angle"]))
    squeezed_block(0.0, steps=1, tensile_strength=apex).run()


def test_a_sinking_footing_keeps_its_resistance_with_a_warning():
    """Settlement of 3 % of the half-width; following pressure would halve the strength of bands."""
    run = strip(4, 0.03).run()
    ratio = bearing(run.history, 0.03) / prandtl(0.0)
    assert np.all(np.diff(ratio[-30:]) > -1e-3) and 0.98 < ratio[30] < ratio[-1] < 1.04
    assert np.abs(run.history.energy_balance).max() < 1e-9 * run.history.energy_plastic.values[-1]
    assert [doubt.topic for doubt in run.verdict.doubts] == ["strain"]


def cantilever(cells, **law):
    """A beam of 10:1 under 0.8 of the load at first yield; returns the displacement of its tip."""
    model = solid(1e12, 1e10, 0.2, law, time_step=0.02, steps=30, dynamic_factor=0.0, analysis=None)
    h = 1.0 / cells
    for i in range(10 * cells):
        for j in range(cells):
            x, y, name = i * h, j * h, f"c{i}_{j}"
            corners = [x, y, x + h, y, x + h, y + h, x, y + h]
            model.block(vertices=corners, body="rock", name=name)
            for at in (y, y + h) if i == 0 else ():
                model.fixed_point(x=0.0, y=at, block=name)
            if i == 10 * cells - 1:
                displacements_of_tip = [0.0, -0.8 * 2e6 / 60 * h, -0.8 * 2e6 / 60 * h]
                model.load(x=10.0, y=y + h / 2, block=name, time=[0.0, 0.3, 1e6], force_x=[0.0] * 3,
                           force_y=displacements_of_tip)  # fmt: skip
    model.measured_point(name="tip", x=10.0, y=0.0, block=f"c{10 * cells - 1}_0")
    return model.run().history.displacement.values[-1, 0, 1]


def test_a_strong_material_is_elastic():
    """Jumps of faces carry the remaining stress of points, much of it with two cells."""
    model = cantilever(2, law="mohr_coulomb", cohesion=1e6)
    assert model == pytest.approx(cantilever(2), rel=1e-3)


def test_a_yielding_run_is_bit_identical_everywhere(tmp_path, same_everywhere):
    same_everywhere(strip(2, 0.03, steps=40).write(tmp_path / "strip.nml"), 23)


@pytest.mark.parametrize("cohesion", [3.45e6, 5e5])
def test_a_change_of_material_keeps_an_admissible_stress(cohesion):
    model = squeezed_block(0.0, steps=None)
    weak = SOLID | {"cohesion": cohesion}
    model.material(name="weak", density=2500.0, young_modulus=7e12, poisson_ratio=0.21, **weak)
    model.stage(name="first", steps=30)
    model.stage(name="second", steps=1, change_materials="rock -> weak")
    with sitedda.Simulation(model) as simulation:
        simulation.advance(30)
        before = -simulation.stresses[0, 1]
        simulation.advance(1)
        after = -simulation.stresses[0, 1]
    limit = 2 * cohesion * np.tan(np.radians(60))
    assert before > limit or cohesion > 1e6
    assert after == pytest.approx(min(31 / 30 * before, limit), rel=1e-3)


def ring(cells, around, stiffer=100.0, ratio=12.0, steps=40, dilation=0.0):
    """A quarter of a ring of c 3.45 MPa, φ 30° under 30 MPa, whose inner pressure is removed."""
    pressure, shear, bulk = 30e6, stiffer * 2.8e9, stiffer * 3.9e9
    young = 9 * bulk * shear / (3 * bulk + shear)
    law = SOLID | {"dilation_angle": dilation, "initial_stress": [-pressure, -pressure, 0.0]}
    model = solid(1e14, young, young / (2 * shear) - 1, law, time_step=0.02, steps=steps)
    radius = ratio ** (np.arange(cells + 1) / cells)
    angle = np.linspace(0, np.pi / 2, around + 1)
    for i in range(cells):
        for j in range(around):
            corners = [
                radius[k] * np.array([np.cos(angle[n]), np.sin(angle[n])])
                for k, n in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))
            ]
            name = f"c{i}_{j}"
            model.block(vertices=np.ravel(corners).tolist(), body="rock", name=name)
            for n, at, axis in ((0, j == 0, "y"), (2, j == around - 1, "x")):
                for x, y in corners[n : n + 2] if at else ():
                    model.fixed_point(x=x, y=y, block=name, direction=axis)
            if i == 0:
                times, let_off = [0.0, 0.6 * 0.02 * steps, 1e6], [pressure, 0.0, 0.0]
                model.traction(blocks=name, edges=[4], normal=let_off, time=times)
            if i == cells - 1:
                model.traction(blocks=name, edges=[2], normal=pressure)
    diagonal = np.sqrt(0.5)
    model.measured_point(name="wall", x=diagonal, y=diagonal, block=f"c0_{around // 2}")
    return model


def salencon(dilation):
    """Wall displacement of `ring` in the closed form of Salençon (1969), m."""
    flow, strength = (np.tan(np.radians(45 + a / 2)) ** 2 for a in (dilation, 30.0))
    tension = 2 * COHESION * np.sqrt(strength) / (strength - 1)
    yield_ratio = 2 / (strength + 1) * (30e6 + tension) / tension  # (R₀/a)^(K_φ − 1)
    poisson = (3 * 3.9 - 2 * 2.8) / (2 * (3 * 3.9 + 2.8))
    outer_ratio = yield_ratio ** ((flow + strength) / (strength - 1))
    factors = (1 - poisson) * np.array([(strength**2 - 1) * outer_ratio, flow * strength + 1])
    plastic = tension * (factors.sum() / (flow + strength) - poisson)
    return (plastic - (1 - 2 * poisson) * (30e6 + tension)) / (2 * 2.8e9)


@pytest.mark.parametrize("dilation", [0.0, 15.0, 30.0])
def test_a_tunnel_wall_moves_as_in_salencons_solution(dilation):
    """Excavation in 40 steps with a hundredth of the strains: +1.5, +1.2, +0.9 % with 24 cells."""
    history = ring(24, 12, dilation=dilation).run().history
    displacement = 100 * np.hypot(*history.displacement.values[-1, 0])
    assert displacement == pytest.approx(salencon(dilation), rel=0.02)
    assert np.abs(history.energy_balance).max() < 1e-9 * history.energy_plastic.values[-1]


def standing_block(**law):
    """A block of 20 kN/m³, 1 m high, on rollers."""
    model = solid(1e9, 1e8, 0.3, law, 2000.0, time_step=1.0, gravity=[0.0, -10.0], integration=None)
    model.block(vertices=[0, 0, 1, 0, 1, 1, 0, 1], name="block")
    model.fixed_point(x=0.0, y=0.0)
    model.fixed_point(x=1.0, y=0.0, direction="y")
    return model


@pytest.mark.parametrize("angle", [0.0, 25.0])
def test_safety_divides_the_strength_of_solids(angle):
    """A block of 20 kN/m³, 1 m high, has a mean stress of 10 kPa: 2 (c/F) tan(45° + φ_F/2)."""
    cohesion = 6e3

    def excess(factor):
        reduced = np.arctan(np.tan(np.radians(angle)) / factor)
        return 2 * cohesion / factor * np.tan(np.pi / 4 + reduced / 2) - 10e3

    model = standing_block(law="mohr_coulomb", cohesion=cohesion, friction_angle=angle)
    result = sitedda.safety(model, tolerance=2e-3)
    assert excess(0.997 * result.low) > 0 > excess(1.003 * result.high)
    assert "half the size" in result.warning and "moves less than" not in result.warning


def test_a_model_that_fails_at_any_strength_is_no_error():
    """The strength is increased 64 times; a friction angle of 60° remains below 90°."""
    model = standing_block(law="mohr_coulomb", cohesion=1e-3, friction_angle=60.0)
    result = sitedda.safety(model, tolerance=2e-3)
    assert result.low == 0.0 and "fails even with all strengths" in result.words
