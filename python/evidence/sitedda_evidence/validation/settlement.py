# SPDX-License-Identifier: GPL-3.0-or-later
"""Walls under sudden gravity: the energy does not increase, and its budget balances."""

from itertools import product
from typing import NamedTuple

import numpy as np

from sitedda.base.errors import ConvergenceError
from sitedda.report.style import BLUE, COLORS, GROUND, RED, STONE, bare, canvas, draw_blocks

from .. import model as nml
from ..case import Outcome, Table, at_most, case

YOUNG, DENSITY = 5e9, 2500.0  # Pa, kg/m³
WALLS = {50: (5, 9), 200: (10, 19), 1000: (20, 49)}  # bricks per course, courses; by blocks
BRICK = (1.0, 0.5)  # m
TIME_STEPS = (1e-2, 1e-3, 1e-4, 1e-5)  # s
PENALTIES = (1 / 25, 1.0, 40.0, 300.0)  # penalties over E × 1 m


@case(
    "Walls of 50, 200 and 1000 blocks under sudden gravity",
    "All potentials of the scheme are convex and friction only dissipates. Kinetic plus potential "
    "energy therefore never exceeds its initial value, for any Δt and penalty. The energy scale is "
    "the work of gravity, at least its work on an elastic settlement of all blocks.",
    "`docs/method.md`.",
)
def settlement(short: bool) -> Outcome:
    """Check energy gain and audit residual of walls for several Δt and penalties."""
    sizes = (50,) if short else tuple(WALLS)
    penalties = PENALTIES[::3] if short else PENALTIES
    walls = {key: _run_wall(*key, steps=40 if key[0] == 1000 and key[2] > 1e-4 else 200)
             for key in product(sizes, penalties, TIME_STEPS)}  # fmt: skip
    failures = [
        f"{n} blocks, {k:g} E, Δt {dt:g} s" for (n, k, dt), run in walls.items() if run.message
    ]
    label = "; ".join(["number of runs in which a step does not converge", *failures])
    rows = [at_most(label, len(failures), 0)]
    for size in sizes:
        runs = [(key, run) for key, run in walls.items() if key[0] == size]
        for name, index in (("gain / energy scale", 0), ("residual / work of gravity", 1)):
            (_, penalty, step), run = max(runs, key=lambda item, index=index: item[1][index])
            settings = f"largest at Δt = {step:g} s, penalty {penalty:g} E"
            rows.append(at_most(f"{size} blocks: energy {name}, {settings}", run[index], 1e-6))
    table = Table(
        "Largest energy gain divided by the energy scale, largest energy residual divided by the "
        "work of gravity, and largest number of open–close iterations in a step.",
        ("blocks", "penalty / E", "Δt (s)", "gain", "residual", "iterations"),
        [(*key, *value[:3]) for key, value in walls.items()],
    )
    return Outcome(rows, _draw_energies(walls, sizes), [table])


def wall_text(size: int, penalty: float, time_step: float, steps: int, **variables) -> str:
    """Return a running-bond wall of about `size` blocks; `variables` are those of ``&control``."""
    bricks, courses = WALLS[size]
    return nml.text(
        nml.control(time_step, steps, **variables),
        nml.contact(penalty * YOUNG),
        nml.material("base", DENSITY, nml.STIFF),
        nml.material("stone", DENSITY, YOUNG, 0.2),
        nml.joint("dry", 35.0),
        nml.fixed_block("base", nml.rectangle(-1, -1, bricks * BRICK[0] + 2, 1), "base"),
        nml.group("wall", name="brick", material="stone", brick_length=BRICK[0],
                  brick_height=BRICK[1], bricks=bricks, courses=courses),
    )  # fmt: skip


class SettledWall(NamedTuple):
    """Energies of a wall divided by the energy scale, and its final state."""

    gain: float  # largest increase of the energy divided by the energy scale
    residual: float  # largest residual of the energy budget / work
    iterations: int  # largest number per step
    time: np.ndarray  # s
    total: np.ndarray  # change of the energy divided by the energy scale
    picture: list[np.ndarray]  # polygons at the end, m
    message: str  # error of the engine if a step does not converge


def _run_wall(size: int, penalty: float, time_step: float, steps: int) -> SettledWall:
    """Run a wall under gravity with a penalty (/ E) and a time step (s)."""
    courses = WALLS[size][1]
    with nml.simulation(wall_text(size, penalty, time_step, steps)) as wall:
        time, total, work, balance, iterations = [0.0], [0.0], [0.0], [0.0], 0
        blocks = len(wall.block_names) - 1
        message = ""
        try:
            while not wall.done:
                wall.advance()
                energies = wall.energies
                time.append(wall.time)
                total.append(nml.energy_gain(energies))
                work.append(abs(energies["gravity"]))
                balance.append(abs(energies["balance"]))
                iterations = max(iterations, wall.iterations)
        except ConvergenceError as error:
            message = str(error)
        picture = wall.polygons
    weight = DENSITY * nml.GRAVITY * BRICK[0] * BRICK[1]
    column = weight * courses  # load on a brick of the lowest course, N/m
    elastic = blocks * weight * column * (0.5 / (penalty * YOUNG) + 0.5 / YOUNG)
    scale = max(max(work), elastic)
    relative = np.array(total) / scale
    residual = max(balance) / max(max(work), elastic * 1e-12)
    largest = (relative.max(), residual, iterations)
    return SettledWall(*largest, np.array(time), relative, picture, message)


def _draw_energies(walls, sizes):
    figure, axes = canvas(3, size=(13, 4.2), width_ratios=[1, 1.3, 1.3])
    size = sizes[-1]
    picture = walls[size, PENALTIES[0], 1e-3].picture
    draw_blocks(axes[0], picture, [GROUND, *[STONE] * (len(picture) - 1)], lw=0.3)
    axes[0].set_title(f"{size} blocks")
    bare(axes[0])
    penalty = PENALTIES[-1]
    for time_step, color in zip(TIME_STEPS, COLORS, strict=False):
        run = walls[size, penalty, time_step]
        axes[1].semilogx(run.time[1:], run.total[1:], color=color, label=f"Δt {time_step:g} s")
    axes[1].axhline(0, color=RED, lw=0.8, ls="--")
    axes[1].set(xlabel="time (s)", ylabel="energy gain / energy scale")
    axes[1].set_title(f"{size} blocks, penalty {penalty:g} E")
    gain = [max(run.gain, 1e-20) for run in walls.values()]
    residuals = [max(run.residual, 1e-20) for run in walls.values()]
    axes[2].semilogy(residuals, "o", ms=4, color=BLUE, label="energy residual / work of gravity")
    axes[2].semilogy(gain, "s", ms=4, mfc="none", color="0.4", label="energy gain / energy scale")
    axes[2].axhline(1e-6, color=RED, lw=1, ls="--", label="allowed")
    axes[2].set(xlabel="run", title=f"all {len(walls)} runs (0 gain shown as 1e-20)")
    axes[2].legend(frameon=False, fontsize=8, loc="center right")
    return figure
