# SPDX-License-Identifier: GPL-3.0-or-later
"""Crushing joints: the hinge of a block at e = t/2 − N/2σ_c, closure, energy, verdict."""

import numpy as np
import pytest

import sitedda

STRENGTH, STIFFNESS, WIDTH = 1e6, 1e11, 1.0  # Pa, Pa/m, m
WEIGHT = 200.0 * 9.81 * WIDTH * 0.5  # weight of the block, N/m


def pressed(ratio: float, fraction: float, law: str = "crushing", **joint) -> sitedda.Model:
    """A block under N = `ratio` σ_c t at a fraction of the limit eccentricity."""
    force = ratio * STRENGTH * WIDTH
    abscissa = fraction * (WIDTH - ratio * WIDTH) / 2
    model = sitedda.Model("Pressed", time_step=1e-3, gravity=(0.0, -9.81))
    model.material("stone", density=200.0, young_modulus=1e13, poisson_ratio=0.2)
    law_variables = {"crushing_strength": STRENGTH} if law == "crushing" else {"contact_points": 17}
    model.joint("bed", friction_angle=35.0, law=law, normal_stiffness_per_area=STIFFNESS,
                **(law_variables | joint))  # fmt: skip
    model.block([(-2, -1), (2, -1), (2, 0), (-2, 0)], name="floor")
    model.block([(-0.5, 0), (0.5, 0), (0.5, 0.5), (-0.5, 0.5)], name="stone")
    for x in (-1.5, 1.5):
        model.fixed_point(x, -0.5, "floor")
    load = force - WEIGHT
    model.load(abscissa * force / load, 0.25, "stone", name="press", time=(0, 1),
               force_y=(-load, -load))  # fmt: skip
    model.stage("rest", kind="static")
    return model


def stands(model: sitedda.Model) -> bool:
    """Return whether the model is at rest without rotation above 0.001 rad."""
    try:
        with sitedda.Simulation(model) as run:
            return abs(run.coordinates[1, 2]) < 1e-3
    except sitedda.ConvergenceError:
        return False


@pytest.mark.parametrize("press", [0.1, 0.3, 0.6])
def test_a_hinge_turns_about_its_crushed_edge(press):
    assert stands(pressed(press, 0.99))
    assert not stands(pressed(press, 1.01))


def test_without_a_strength_a_block_turns_about_its_corner():
    """e = t/2: the block stands beyond the limit of the crushing joint."""
    assert stands(pressed(0.3, 1.2, "coulomb"))


def test_the_shipped_pier_stands_on_a_crushed_bed(root):
    """The eccentricity is 0.335 m, at most 0.35 m; a load 3 % farther out overturns the pier."""
    file = root / "inputs" / "crushing_pier.nml"
    with sitedda.Simulation(file) as run:
        assert run.contacts["crushed"].max() > 0.0
    with pytest.raises(sitedda.ConvergenceError):
        sitedda.Simulation(file, changes={"load[roof].x": 0.3714 * 0.36 / 0.335})


def test_limit_analysis_has_the_same_hinge():
    """A vertical force at x = t/4 increases: N = σ_c (t − 2e), e = x (N − W)/N."""
    model = pressed(0.3, 0.5)
    model.clear("load")
    model.load(0.25, 0.25, "stone", name="live", time=(0, 1), force_y=(-1e5, -1e5))
    limits = sitedda.limit_analysis(model, load="live")
    largest = np.roots([1.0, -(WIDTH - 0.5) * STRENGTH, -0.5 * STRENGTH * WEIGHT]).max()
    assert limits.upper.factor == pytest.approx((largest - WEIGHT) / 1e5, rel=1e-4)
    assert limits.lower.factor == pytest.approx(limits.upper.factor, rel=1e-3)
    for fraction in (0.98, 1.02):
        load = fraction * 1e5 * limits.upper.factor
        model["load.live"](force_y=(-load, -load))
        assert stands(model) == (fraction < 1.0)


def test_a_crushing_joint_is_elastic_below_its_strength():
    """At σ_max < σ_c nothing crushes; the closure equals that without a strength."""
    tops = []
    for law in ("crushing", "coulomb"):
        with sitedda.Simulation(pressed(0.3, 0.4, law)) as run:
            tops.append(run.coordinates)
            if law == "crushing":
                assert not run.contacts["crushed"].any()
    np.testing.assert_array_equal(*tops)


def pulsed(rise: float, seconds: float, step: float, **joint) -> sitedda.Model:
    """The block under its weight, then in dynamics under a centric pulse of 1.05 σ_c t."""
    model = pressed(0.1, 0.0, **joint)
    model.clear("load")
    model["material.stone"](density=2000.0)
    peak, times = -1.05 * STRENGTH * WIDTH, (0, rise, 2 * rise, 1)
    model.load(0.0, 0.25, "stone", name="pulse", time=times, force_y=(0, peak, 0, 0))
    model.stage("pulse", duration=seconds, time_step=step)
    return model


def test_energy_of_crushing(tmp_path):
    """The term fracture is σ_c Σ L p, the audit balances, and the block rests lower by p."""
    model = pulsed(0.1, 0.3, 1e-3)
    history = model.run(tmp_path / "pulse.nc").history
    with sitedda.Simulation(model) as second_run:
        second_run.advance(10**6)
        contacts = second_run.contacts
        crushed = contacts["crushed"]
        low = second_run.coordinates[1, 1]
    dissipated = STRENGTH * (contacts["length"] * crushed).sum()
    assert crushed.max() > 1e-4
    assert float(history.energy_fracture[-1]) == pytest.approx(dissipated, rel=1e-6)
    work = float(abs(history.energy_fracture).max())
    assert abs(history.energy_balance.values).max() < 1e-6 * work
    assert 0.25 - low == pytest.approx(crushed.max(), rel=1e-2)
    verdict = history.attrs["verdict"]
    assert "joints have crushed by up to" in verdict and "at floor, stone" in verdict


def test_a_crushed_joint_has_dissipated_its_fracture_energy(tmp_path):
    """A block that crushes its joint completely dissipates G_c per area of the joint."""
    model = pulsed(0.01, 0.0125, 1e-5, crushing_energy=200.0)
    history = model.run(tmp_path / "pulse.nc").history
    assert float(history.energy_fracture[-1]) == pytest.approx(200.0 * WIDTH, rel=0.02)
