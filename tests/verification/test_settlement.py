# SPDX-License-Identifier: GPL-3.0-or-later
"""Sudden gravity on a column and on a wall without cohesion: no jumps and no created energy.

The scheme cannot increase the energy of a convex potential (docs/method.md), so that a jump of a
block is an error for each time step and penalty.
"""

from types import SimpleNamespace

import numpy as np
import pytest
from model_text import DRY, ROCK, group, namelist

import sitedda
from sitedda_evidence.model import GRAVITY, STORED
from sitedda_evidence.paper.discrete import DiscreteModel

YOUNG = ROCK["young_modulus"]
LONGEST, SHORTEST = 2000, 40  # steps


def column() -> tuple[list, list]:
    """Return groups and fixed points of 15 layers of 15 m x 1 m on a fixed base."""
    groups = [
        group("layers", name="base", bottom=-1.0, width=15.0, thickness=1.0),
        group("layers", name="layer", width=15.0, thickness=1.0, count=15),
    ]
    return groups, [(x, y) for x in (2.5, 12.5) for y in (-0.25, -0.75)]


def wall() -> tuple[list, list]:
    """Return 5 bricks x 10 courses in running bond on a fixed base."""
    bricks = {"brick_length": 0.5, "brick_height": 0.25, "bricks": 5, "courses": 10}
    groups = [
        group("layers", name="base", bottom=-0.5, width=2.5, thickness=0.5),
        group("wall", name="brick", **bricks),
    ]
    return groups, [(x, y) for x in (0.5, 2.0) for y in (-0.125, -0.375)]


MODELS = {"column": column, "wall": wall}
CASES = [
    (model, penalty, time_step)
    for model in MODELS
    for penalty in (YOUNG / 25, YOUNG, 100 * YOUNG)
    for time_step in (1e-2, 1e-3, 1e-4)
]


def text(model: str, penalty: float, **control) -> str:
    """Return the input of a model under sudden gravity."""
    groups, fixed_points = MODELS[model]()
    return namelist(
        [
            group("control", gravity=[0.0, -GRAVITY], **control),
            group("contact", normal_stiffness=penalty),
            ("material", dict(ROCK)),
            ("joint", dict(DRY)),
            *groups,
            *(group("fixed_point", x=x, y=y) for x, y in fixed_points),
            group("output", block_interval=1),
        ]
    )


def at_rest(file) -> tuple[np.ndarray, np.ndarray, float]:
    """Return static displacements and weight of the linear system, and its lowest frequency."""
    blocks = DiscreteModel.of(file)
    weight = np.zeros(len(blocks.mass))
    weight[1::6] = -GRAVITY * blocks.mass.diagonal()[1::6]
    return np.linalg.solve(blocks.stiffness, weight), weight, blocks.omega[0]


@pytest.fixture(
    scope="module", params=CASES, ids=lambda c: f"{c[0]}, {c[1] / YOUNG:g} E, {c[2]:g} s"
)
def settling(request, tmp_path_factory):
    """Run some periods; return rise of the blocks, energies, history and static displacements."""
    model, penalty, time_step = request.param
    file = tmp_path_factory.mktemp("settling") / "model.nml"
    file.write_text(text(model, penalty, time_step=time_step, steps=1))
    static, weight, slowest = at_rest(file)
    steps = int(np.clip(4 * 2 * np.pi / slowest / time_step, SHORTEST, LONGEST))
    file.write_text(text(model, penalty, time_step=time_step, steps=steps))
    history = sitedda.run(file).history
    heights = history.block_coordinates.values[:, :, 1]
    return SimpleNamespace(
        rise=heights - heights[0],
        static=static,
        work=float(weight @ static),  # work of gravity up to the static displacements
        total=sum(history[f"energy_{name}"].values for name in STORED),
        history=history,
    )


def test_no_block_jumps(settling):
    # an undamped chain of these masses on springs without tension rebounds to 0.69 of this value
    assert settling.rise.max() <= -settling.static[1::6].min()


def test_no_block_sinks_beyond_twice_the_settlement(settling):
    # a linear system under sudden load reaches at most about twice its static displacement
    assert -settling.rise.min() <= 2.5 * -settling.static[1::6].min()


def test_total_energy_falls_in_every_step(settling):
    assert settling.total.max() - settling.total[0] <= 1e-6 * settling.work
    assert np.diff(settling.total).max() <= 1e-6 * settling.work


def test_dissipation_is_positive_and_the_energy_balance_is_closed(settling):
    """The geometric term is small."""
    history, work = settling.history, settling.work
    assert np.diff(history.energy_algorithmic).min() >= -1e-9 * work
    assert np.diff(history.energy_friction).min() >= -1e-9 * work
    assert abs(history.energy_balance).max() <= 1e-6 * work
    assert abs(history.energy_geometric).max() <= 1e-3 * work


@pytest.mark.parametrize("penalty", [YOUNG / 25, YOUNG, 100 * YOUNG], ids=["E/25", "E", "100 E"])
def test_the_column_rests_at_its_static_displacements(penalty, tmp_path):
    """With dynamic_factor = 0, the steps converge directly to the static solution."""
    file = tmp_path / "model.nml"
    file.write_text(text("column", penalty, time_step=1.0, steps=30, dynamic_factor=0.0))
    static, *_ = at_rest(file)
    with sitedda.Simulation(file) as simulation:
        start = simulation.coordinates
        simulation.advance(30)
        displacement = (simulation.coordinates - start)[:, 1]
    # second-order error: settlement over block size
    np.testing.assert_allclose(displacement[1:], static[1::6][1:], rtol=2e-3)
