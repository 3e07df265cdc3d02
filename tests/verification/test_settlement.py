# SPDX-License-Identifier: GPL-3.0-or-later
"""Sudden gravity on a column and on a wall without cohesion: nothing leaps, no energy is made.

The scheme cannot raise the energy of a convex potential (docs/method.md), so that a block that
leaps is a bug at any time step and any penalty.
"""

from types import SimpleNamespace

import numpy as np
import pytest
from linear_theory import FIXED_RATIO, Blocks, Box, Rock
from model_text import DRY, ROCK, group, namelist

import sitedda

GRAVITY = 9.81
YOUNG = ROCK["young_modulus"]
STONE = Rock(ROCK["density"], YOUNG, ROCK["poisson_ratio"])
LONGEST, SHORTEST = 2000, 40  # steps


def column() -> tuple[list, list[Box], list]:
    """15 layers of 15 m x 1 m on a fixed base: groups, boxes, fixed points."""
    groups = [
        group("layers", name="base", bottom=-1.0, width=15.0, thickness=1.0),
        group("layers", name="layer", width=15.0, thickness=1.0, count=15),
    ]
    boxes = [Box(0.0, i - 1.0, 15.0, 1.0, STONE) for i in range(16)]
    return groups, boxes, [(x, y) for x in (2.5, 12.5) for y in (-0.25, -0.75)]


def wall() -> tuple[list, list[Box], list]:
    """5 bricks x 10 courses in running bond on a fixed base."""
    length, height = 0.5, 0.25
    groups = [
        group("layers", name="base", bottom=-0.5, width=2.5, thickness=0.5),
        group("wall", name="brick", brick_length=length, brick_height=height, bricks=5, courses=10),
    ]
    boxes = [Box(0.0, -0.5, 2.5, 0.5, STONE)]
    for course in range(10):
        ends = np.arange(6) * length
        if course % 2:
            ends = np.concatenate([[0.0], ends[:-1] + length / 2, [5 * length]])
        for left, right in zip(ends[:-1], ends[1:], strict=True):
            boxes.append(Box(left, course * height, right - left, height, STONE))
    return groups, boxes, [(x, y) for x in (0.5, 2.0) for y in (-0.125, -0.375)]


MODELS = {"column": column, "wall": wall}
CASES = [
    (model, penalty, time_step)
    for model in MODELS
    for penalty in (YOUNG / 25, YOUNG, 100 * YOUNG)
    for time_step in (1e-2, 1e-3, 1e-4)
]


def theory(boxes, places, penalty) -> Blocks:
    """The linear system with the bed joints closed and the head joints open."""
    blocks = Blocks(boxes)
    for i, low in enumerate(boxes):
        for j, high in enumerate(boxes):
            touching = abs(low.bottom + low.height - high.bottom) < 1e-9
            common = min(low.left + low.width, high.left + high.width) - max(low.left, high.left)
            if touching and common > 1e-9:
                blocks.joint(i, j, penalty)
    for place in places:
        blocks.hold(0, *place, FIXED_RATIO * penalty)
    return blocks


@pytest.fixture(
    scope="module", params=CASES, ids=lambda c: f"{c[0]}, {c[1] / YOUNG:g} E, {c[2]:g} s"
)
def settling(request, tmp_path_factory):
    """A run of some periods, what every block did on the way, and the static answer."""
    model, penalty, time_step = request.param
    groups, boxes, places = MODELS[model]()
    blocks = theory(boxes, places, penalty)
    weight = blocks.gravity(GRAVITY)
    static = np.linalg.solve(blocks.stiffness, weight)
    slowest = blocks.modes()[0][0]
    steps = int(np.clip(4 * 2 * np.pi / slowest / time_step, SHORTEST, LONGEST))
    file = tmp_path_factory.mktemp("settling") / "model.nml"
    file.write_text(
        namelist(
            [
                group("control", time_step=time_step, steps=steps, gravity=[0.0, -GRAVITY]),
                group("contact", normal_stiffness=penalty),
                ("material", dict(ROCK)),
                ("joint", dict(DRY)),
                *groups,
                *(group("fixed_point", x=x, y=y) for x, y in places),
                group("output", block_interval=1),
            ]
        )
    )
    history = sitedda.run(file).history
    heights = history.block_coordinates.values[:, :, 1]
    energies = {name: history[f"energy_{name}"].values for name in NAMES}
    return SimpleNamespace(
        time_step=time_step,
        rise=heights - heights[0],
        static=static,
        work=float(weight @ static),  # of gravity on the way to the static answer
        total=sum(energies[name] for name in NAMES[:5]),
        energies=energies,
        history=history,
        blocks=blocks,
        penalty=penalty,
    )


NAMES = [
    "kinetic",
    "strain",
    "contact",
    "support",
    "gravity",
    "friction",
    "algorithmic",
    "geometric",
    "balance",
]


def test_the_engine_has_the_blocks_of_the_theory(settling):
    centres = [box.centre for box in settling.blocks.boxes]
    np.testing.assert_allclose(
        settling.history.block_coordinates.values[0, :, :2], centres, atol=1e-12
    )


def test_no_block_leaps(settling):
    settlement = -settling.static[1::6]
    print(f"highest rise {settling.rise.max():.3e} m, settlement {settlement.max():.3e} m")
    # an undamped chain of the column's masses on springs that cannot pull rebounds by 0.69 of it
    assert settling.rise.max() <= settlement.max()


def test_no_block_sinks_beyond_twice_the_settlement(settling):
    # a linear system let go from rest overshoots to at most about twice its static answer
    assert -settling.rise.min() <= 2.5 * -settling.static[1::6].min()


def test_total_energy_never_exceeds_its_first_value(settling):
    above = settling.total.max() - settling.total[0]
    print(f"energy above the first {above:.3e}, work {settling.work:.3e} J/m")
    assert above <= 1e-6 * settling.work


def test_total_energy_falls_in_every_step(settling):
    growth = np.diff(settling.total).max()
    print(f"largest growth in a step {growth:.3e}, work {settling.work:.3e} J/m")
    assert growth <= 1e-6 * settling.work


def test_losses_are_losses(settling):
    small = 1e-9 * settling.work
    assert np.diff(settling.energies["algorithmic"]).min() >= -small
    assert np.diff(settling.energies["friction"]).min() >= -small


def test_the_audit_balances(settling):
    worst = abs(settling.energies["balance"]).max()
    print(f"balance {worst:.3e}, work {settling.work:.3e} J/m")
    assert worst <= 1e-6 * settling.work


def test_the_geometry_between_steps_does_little_work(settling):
    assert abs(settling.energies["geometric"]).max() <= 1e-3 * settling.work


@pytest.mark.parametrize("penalty", [YOUNG / 25, YOUNG, 100 * YOUNG], ids=["E/25", "E", "100 E"])
def test_the_column_comes_to_rest_where_statics_say(penalty, tmp_path):
    """With no memory of velocity the steps go straight to the static answer."""
    groups, boxes, places = column()
    blocks = theory(boxes, places, penalty)
    static = np.linalg.solve(blocks.stiffness, blocks.gravity(GRAVITY))
    file = tmp_path / "model.nml"
    control = {
        "time_step": 1.0,
        "steps": 30,
        "gravity": [0.0, -GRAVITY],
        "dynamic_factor": 0.0,
    }
    file.write_text(
        namelist(
            [
                ("control", control),
                group("contact", normal_stiffness=penalty),
                ("material", dict(ROCK)),
                ("joint", dict(DRY)),
                *groups,
                *(group("fixed_point", x=x, y=y) for x, y in places),
            ]
        )
    )
    with sitedda.Simulation(file) as simulation:
        start = simulation.coordinates
        simulation.advance(30)
        moved = (simulation.coordinates - start)[:, 1]
    # second order: settlement over block size
    np.testing.assert_allclose(moved[1:], static[1::6][1:], rtol=2e-3)
