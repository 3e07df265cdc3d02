# SPDX-License-Identifier: GPL-3.0-or-later
"""Sudden gravity on a column and on a wall without cohesion: nothing leaps, no energy is made.

The scheme cannot raise the energy of a convex potential (docs/method.md), so that a block that
leaps is a bug at any time step and any penalty.
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
    """15 layers of 15 m x 1 m on a fixed base: groups, fixed points."""
    groups = [
        group("layers", name="base", bottom=-1.0, width=15.0, thickness=1.0),
        group("layers", name="layer", width=15.0, thickness=1.0, count=15),
    ]
    return groups, [(x, y) for x in (2.5, 12.5) for y in (-0.25, -0.75)]


def wall() -> tuple[list, list]:
    """5 bricks x 10 courses in running bond on a fixed base."""
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
    """A model that meets gravity at once."""
    groups, places = MODELS[model]()
    return namelist(
        [
            group("control", gravity=[0.0, -GRAVITY], **control),
            group("contact", normal_stiffness=penalty),
            ("material", dict(ROCK)),
            ("joint", dict(DRY)),
            *groups,
            *(group("fixed_point", x=x, y=y) for x, y in places),
            group("output", block_interval=1),
        ]
    )


def at_rest(file) -> tuple[np.ndarray, np.ndarray, float]:
    """The linear system under its weight: where it rests, the weight, the slowest frequency."""
    blocks = DiscreteModel.of(file)
    weight = np.zeros(len(blocks.mass))
    weight[1::6] = -GRAVITY * blocks.mass.diagonal()[1::6]
    return np.linalg.solve(blocks.stiffness, weight), weight, blocks.omega[0]


@pytest.fixture(
    scope="module", params=CASES, ids=lambda c: f"{c[0]}, {c[1] / YOUNG:g} E, {c[2]:g} s"
)
def settling(request, tmp_path_factory):
    """A run of some periods, what every block did on the way, and the static answer."""
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
        work=float(weight @ static),  # of gravity on the way to the static answer
        total=sum(history[f"energy_{name}"].values for name in STORED),
        history=history,
    )


def test_no_block_leaps(settling):
    # an undamped chain of the column's masses on springs that cannot pull rebounds by 0.69 of it
    assert settling.rise.max() <= -settling.static[1::6].min()


def test_no_block_sinks_beyond_twice_the_settlement(settling):
    # a linear system let go from rest overshoots to at most about twice its static answer
    assert -settling.rise.min() <= 2.5 * -settling.static[1::6].min()


def test_total_energy_falls_in_every_step(settling):
    assert settling.total.max() - settling.total[0] <= 1e-6 * settling.work
    assert np.diff(settling.total).max() <= 1e-6 * settling.work


def test_losses_are_losses_and_the_audit_balances(settling):
    """The geometry between steps does little work."""
    history, work = settling.history, settling.work
    assert np.diff(history.energy_algorithmic).min() >= -1e-9 * work
    assert np.diff(history.energy_friction).min() >= -1e-9 * work
    assert abs(history.energy_balance).max() <= 1e-6 * work
    assert abs(history.energy_geometric).max() <= 1e-3 * work


@pytest.mark.parametrize("penalty", [YOUNG / 25, YOUNG, 100 * YOUNG], ids=["E/25", "E", "100 E"])
def test_the_column_comes_to_rest_where_statics_say(penalty, tmp_path):
    """With no memory of velocity the steps go straight to the static answer."""
    file = tmp_path / "model.nml"
    file.write_text(text("column", penalty, time_step=1.0, steps=30, dynamic_factor=0.0))
    static, *_ = at_rest(file)
    with sitedda.Simulation(file) as simulation:
        start = simulation.coordinates
        simulation.advance(30)
        moved = (simulation.coordinates - start)[:, 1]
    # second order: settlement over block size
    np.testing.assert_allclose(moved[1:], static[1::6][1:], rtol=2e-3)
