# SPDX-License-Identifier: GPL-3.0-or-later
"""The augmented Lagrangian and the contact rules of the original DDA, against exact solutions."""

import numpy as np
import pytest

from sitedda_evidence import model as nml

DENSITY, YOUNG = 2500.0, 1e10
TOLERANCE = 1e-10  # m


def pile(blocks: int, friction: float = 30.0) -> str:
    """Return a pile of unit squares on a fixed base."""
    text = nml.material("stone", DENSITY, YOUNG, 0.2) + nml.joint("dry", friction)
    text += nml.fixed_block("base", nml.rectangle(-1, -1, 3, 1), points=[(-0.5, -0.5), (1.5, -0.5)])
    boxes = (nml.rectangle(0.1 * i, i, 1, 1) for i in range(blocks))
    return text + "".join(nml.block(f"b{i}", box) for i, box in enumerate(boxes))


def slid(rules: str, friction: float, young: float) -> float:
    """Return the slide of a block in 0.5 s on a slope of 30°, m."""
    slope = np.radians(30.0)
    text = nml.control(1e-3, 500) + rules
    text += nml.material("stone", DENSITY, young) + nml.joint("dry", friction)
    text += nml.fixed_block("base", nml.rotated(nml.rectangle(-2, -1, 10, 1), -slope))
    text += nml.block("slider", nml.rotated(nml.rectangle(0, 0, 1, 0.5), -slope))
    with nml.simulation(text) as run:
        start = run.coordinates[1, :2].copy()
        run.advance(500)
        return np.hypot(*(run.coordinates[1, :2] - start))


def exact_slide(friction: float) -> float:
    """Return the slide of a rigid block without penalty: ½ g (sin 30° − cos 30° tan φ) t², m."""
    slope = np.radians(30.0)
    return 0.125 * nml.GRAVITY * (np.sin(slope) - np.cos(slope) * np.tan(np.radians(friction)))


@pytest.mark.parametrize("penalty", [YOUNG / 25, YOUNG, 300 * YOUNG])
def test_penetrations_are_within_the_tolerance(penalty):
    """For each penalty, penetrations are within the tolerance, and forces are those of statics."""
    text = nml.control(5e-3, 400, dynamic_factor=0.0) + pile(3)
    text += nml.contact(penalty, penetration_tolerance=TOLERANCE)
    with nml.simulation(text) as run:
        run.advance(400)
        contacts = run.contacts
        supports = run.energies["support"]
    is_closed = contacts["state"] > 0
    assert np.abs(contacts["gap"][is_closed]).max() <= TOLERANCE
    assert supports > 0
    weight = DENSITY * nml.GRAVITY
    assert contacts["normal_force"][is_closed].sum() == pytest.approx(6 * weight, rel=1e-6)


def test_the_multiplier_equals_a_stiff_penalty():
    """A block slides off with the multiplier as with a stiff spring."""
    for penalty, options in ((1e14, {}), (1e10, {"penetration_tolerance": 1e-9})):
        distance = slid(nml.contact(penalty, **options), 20.0, 1e13)
        assert distance == pytest.approx(exact_slide(20.0), rel=1e-4)


@pytest.mark.parametrize(("friction", "slides"), [(40.0, False), (20.0, True)])
def test_original_rules_have_coulomb_friction(friction, slides):
    """With the original rules, a block on a slope of 30° rests for φ = 40° and slides for 20°."""
    slip = slid(nml.contact(1e9, contact_rules="original"), friction, YOUNG)
    if slides:
        assert slip == pytest.approx(exact_slide(friction), rel=5e-2)
    else:
        assert slip < 1e-3


@pytest.mark.parametrize(("depth", "closes"), [(0.9, False), (1.1, True)])
def test_the_original_rules_close_overlaps_above_a_threshold(depth, closes):
    """Contacts below s₀ = 2·10⁻⁴ · 1.5 m (half the model size) keep their velocity for a step."""
    overlap, gap, speed = depth * 2e-4 * 1.5, 1e-5, 0.1
    text = nml.control((gap + overlap) / speed, 1, gravity=(0.0, 0.0)) + pile(0)
    text += nml.contact(1e9, contact_rules="original") + nml.block("b", nml.rectangle(0, gap, 1, 1))
    with nml.simulation(text) as run:
        rates = np.zeros_like(run.rates)
        rates[1, 1] = -speed
        run.rates = rates
        run.advance(1)
        assert (run.contacts["state"] > 0).any() == closes
        assert (run.rates[1, 1] == pytest.approx(-speed, rel=1e-9)) != closes


def test_rates_that_are_set_by_a_script():
    """Energy of new rates is energy input; before the first step it is initial energy."""
    text = nml.control(1e-3, 100, gravity=(0.0, 0.0)) + nml.contact(1e9) + pile(1)
    with nml.simulation(text) as run:
        rates = np.zeros_like(run.rates)
        rates[1, 1] = 2.0
        run.rates = rates
        assert run.energies["initial"] == pytest.approx(0.5 * DENSITY * 4.0)
        run.advance(50)
        rates[1, 1] = 3.0
        run.rates = rates
        run.advance(50)
        assert run.energies["input"] == pytest.approx(0.5 * DENSITY * (9.0 - 4.0), rel=1e-9)
        assert abs(run.energies["balance"]) < 1e-9 * DENSITY
        with pytest.raises(ValueError, match="finite"):
            run.rates = np.full_like(rates, np.nan)
