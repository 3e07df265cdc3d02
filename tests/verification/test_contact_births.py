# SPDX-License-Identifier: GPL-3.0-or-later
"""Contacts that begin, end and move between edges: no created energy and no jumps.

The term `geometric` of the energy balance is the change of spring energy by the updated geometry
of a new step; it would show a contact that begins with a penetration.
"""

import numpy as np
import pytest

from sitedda_evidence import model as nml

DENSITY, YOUNG, PENALTY = 2500.0, 1e10, 1e9
STONE = nml.material("stone", DENSITY, YOUNG, 0.2)


def block(name: str, left, bottom, width, height, material: str = "stone") -> str:
    """Return a rectangular block."""
    return nml.block(name, nml.rectangle(left, bottom, width, height), material)


@pytest.mark.parametrize("friction", [0.0, 20.0])
def test_block_slides_across_joints(friction):
    """A block crosses the joints of a floor of eight blocks without sinking or jumping."""
    floor = nml.rectangle(0.0, -0.5, 0.7, 0.5)
    text = (
        nml.control(1e-3, 1500)
        + nml.contact(PENALTY)
        + STONE
        + nml.material("moving", DENSITY, YOUNG, 0.2, velocity=(3.0, 0.0, 0.0))
        + nml.joint("dry", friction)
        + "".join(nml.fixed_block(f"floor_{i}", floor + [0.7 * i, 0.0], "stone") for i in range(8))
        + block("slider", 0.1, 0.0, 1.0, 0.5, "moving")
    )
    settlement = DENSITY * 0.5 * nml.GRAVITY / 2 / PENALTY  # m; the weight on two contacts
    with nml.simulation(text) as run:
        start, lowest, highest = run.coordinates[-1, :2].copy(), 0.0, -1.0
        while not run.done:
            run.advance(10)
            rise = run.coordinates[-1, 1] - start[1]
            lowest, highest = min(lowest, rise), max(highest, rise)
        energies = run.energies
        slip = run.coordinates[-1, 0] - start[0]
        rotation = abs(run.coordinates[-1, 2])
    mu = np.tan(np.radians(friction))
    expected = 4.5 if friction == 0 else 9.0 / (2 * mu * nml.GRAVITY)
    assert slip == pytest.approx(expected, rel=2e-3)
    kinetic = 0.5 * DENSITY * 0.5 * 9.0
    assert -1e-5 * kinetic < energies["geometric"] < 1e-9 * kinetic
    assert abs(energies["balance"]) < 1e-8 * kinetic
    assert lowest > -6 * settlement  # initial drop: twice the static settlement, and tilt
    assert highest < settlement
    assert rotation < 1e-4


def test_corner_impacts_create_no_energy():
    """Two blocks hit corner on corner at several overlaps: no impact increases the energy."""
    text = nml.control(2e-3, 400, gravity=(0.0, 0.0)) + nml.contact(1e10)
    text += nml.joint("dry", 30.0)
    text += nml.material("left", DENSITY, YOUNG, 0.2, velocity=(4.0, 0.0, 0.0))
    text += nml.material("right", DENSITY, YOUNG, 0.2, velocity=(-4.0, 0.0, 0.0))
    for i, overlap in enumerate((-1e-3, 0.0, 1e-4, 1e-3, 4e-3, 1e-2, 3e-2)):
        text += block(f"left_{i}", -1.6, 3.0 * i, 1.0, 1.0, "left")
        text += block(f"right_{i}", 0.6, 3.0 * i + 1.0 - overlap, 1.0, 1.0, "right")
    data = nml.history(text)
    kinetic = float(data.energy_initial[-1])
    energy = sum(data[f"energy_{term}"] for term in ("kinetic", "strain", "contact"))
    assert float(energy.max()) <= kinetic * (1 + 1e-6)
    assert float(abs(data.energy_balance).max()) < 1e-9 * kinetic


def test_a_block_on_a_stair_rests_on_its_tread():
    """A block at the foot of a stair rests only on its tread; the next tread does not lift it."""
    outline = [[0, 0], [3, 0], [3, 1], [2, 1], [2, 2], [1, 2], [1, 3], [0, 3]]
    text = nml.control(1e-3, 500) + nml.contact(PENALTY) + STONE
    text += nml.joint("dry", 30.0)
    text += nml.fixed_block("stair", outline, "stone", points=[(0.3, 0.3), (2.7, 0.3), (0.3, 2.7)])
    text += block("upper", 1.0, 2.0, 0.8, 0.8) + block("lower", 2.0, 1.0, 0.8, 0.8)
    with nml.simulation(text) as run:
        run.advance(500)
        contacts = run.contacts
        assert abs(run.energies["geometric"]) < 1e-6 * DENSITY * 0.64 * nml.GRAVITY
        assert np.abs(run.rates[1:, :2]).max() < 0.05
        assert contacts["gap"].min() > -1e-4


@pytest.mark.parametrize("stiffness", [2e10, 2e11])
def test_strong_shaking_creates_no_energy(stiffness):
    """Bricks of a wall lift, rock and slide; geometric updates add no energy to the springs."""
    text = nml.control(2e-3, 500, time_step_control="adaptive", least_time_step=1e-6)
    text += nml.contact(stiffness) + STONE + nml.joint("dry", 35.0)
    text += nml.group("layers", name="base", left=-0.5, bottom=-0.5, width=5.0, thickness=0.5)
    text += nml.group(
        "wall", name="brick", left=0.0, bottom=0.0, brick_length=1.0, brick_height=0.5, bricks=4,
        courses=5,
    )  # fmt: skip
    motion = 0.05 * np.sin(2 * np.pi * 2 * np.arange(0, 0.51, 0.05))
    text += nml.motion("shake", [*motion, 0, 0], 0.05, "displacement", None)
    for x, y in ((0.0, -0.25), (4.0, -0.25), (2.0, -0.4)):
        text += nml.group("fixed_point", x=x, y=y, motion_x="shake")
    data = nml.history(text)
    work = float(abs(data.energy_input).max())
    assert float(data.energy_geometric.max()) < 1e-4 * work
    assert float(np.diff(data.energy_geometric).max()) < 1e-4 * work
    assert float(abs(data.energy_balance).max()) < 1e-6 * work
