# SPDX-License-Identifier: GPL-3.0-or-later
"""Free fall, bounce, large rotation, and a block that slides off an edge and lands."""

import numpy as np
from scipy.integrate import solve_ivp
from shapely import Polygon

from sitedda.report.style import (
    BLUE,
    COLORS,
    GROUND,
    INK,
    ORANGE,
    RED,
    STONE,
    bare,
    canvas,
    draw_blocks,
)

from .. import model as nml
from ..case import Outcome, Table, at_most, case, convergence, observed_order, relative

DENSITY = 2500.0  # kg/m³


@case(
    "Free fall and bounce",
    "The distance of fall is ½ g t². A contact lasts half a period of the springs, ω = √(2 k_n/m) "
    "for two corners. The numerical damping ratio ζ(ωΔt) reduces the speed by the factor "
    "e = exp(−ζ π/√(1−ζ²)) and the height by e². The loss vanishes with Δt.",
    "`docs/method.md`.",
)
def bounce(short: bool) -> Outcome:
    """Check fall, rebound and energy of a stiff block that is dropped from 1 m."""
    stiffness = 1e8
    omega = np.sqrt(2 * stiffness / DENSITY)
    steps = (1e-4,) if short else (8e-4, 4e-4, 2e-4, 1e-4, 5e-5)
    runs = {dt: _drop_block(dt, stiffness) for dt in steps}
    rows, table = [], []
    for dt, (time, height, total, audit) in runs.items():
        expected = _scheme_restitution(omega * dt) ** 2
        peak = _rebound_height(time, height)
        table.append((dt, omega * dt, peak, expected, abs(peak / expected - 1), 1 - peak))
        if dt == 1e-4:
            fall = time < 0.4
            error = np.abs(height[fall] - (1 - 0.5 * nml.GRAVITY * time[fall] ** 2)).max()
            rows.append(at_most("largest error of the height in the first 0.4 s", error, 1e-10,
                "m"))  # fmt: skip
            rows.append(relative("height of the first rebound, Δt 0.1 ms", expected, peak, 2e-3,
                "m"))  # fmt: skip
            gain = (total - total[0]).max() / (DENSITY * nml.GRAVITY)
            rows.append(at_most("energy gain / m g h", gain, 1e-6))
            rows.append(at_most("energy residual / m g h", audit, 1e-6))
    tables = [] if short else [_rebound_table(steps, table)]
    return Outcome(rows, _draw_rebounds(runs, table), tables)


def _scheme_restitution(time_step: float) -> float:
    """Return the restitution due to the damping of the scheme; `step`: ωΔt of the contact."""
    phase = np.arccos((4 - time_step**2) / (2 * (2 + time_step**2)) * np.sqrt(1 + time_step**2 / 2))
    decay = 0.5 * np.log(1 + time_step**2 / 2)
    return float(np.exp(-np.pi * decay / phase))


def _rebound_height(time, height) -> float:
    """Return the largest height after the first contact, m."""
    contact = int(np.argmax(height < 0))
    rebound = contact + int(np.argmax(height[contact:] > 0))
    top = rebound + int(np.argmax(height[rebound:]))
    return float(height[top]) if top < len(height) - 1 else np.nan


def _drop_block(time_step: float, stiffness: float):
    """Drop a block; return time (s), height (m), energy (J/m) and audit residual over m g h."""
    body = nml.rectangle(-0.5, 1.0, 1.0, 1.0)
    text = nml.text(
        nml.control(time_step, round(1.6 / time_step), max_displacement_ratio=0.02),
        nml.contact(stiffness),
        nml.material("stiff", DENSITY, nml.STIFF),
        nml.joint("j", 30.0),
        nml.fixed_block("floor", nml.rectangle(-2, -1, 4, 1), "stiff"),
        nml.block("block", body, "stiff"),
    )
    time, height, total = [0.0], [1.0], [0.0]
    with nml.simulation(text) as fall:
        while not fall.done:
            fall.advance()
            time.append(fall.time)
            height.append(fall.coordinates[1, 1] - 0.5)
            total.append(nml.energy_gain(fall.energies))
        audit = abs(fall.energies["balance"]) / (DENSITY * nml.GRAVITY)
    return np.array(time), np.array(height), np.array(total), audit


def _rebound_table(steps, table) -> Table:
    orders = observed_order(steps, [line[-1] for line in table])
    title = "Height of the first rebound for several Δt; the loss of the scheme is of first order."
    head = ("Δt (s)", "ωΔt", "height (m)", "closed form (m)", "relative error", "loss (m)", "order")
    return Table(title, head, [(*line, order) for line, order in zip(table, orders, strict=True)])


def _draw_rebounds(runs, table):
    figure, (left, right) = canvas()
    colors = ("0.8", "0.65", "0.5", "0.3", BLUE)
    for (dt, (time, height, *_)), color in zip(runs.items(), colors, strict=False):
        left.plot(time, height, color=color, lw=1, label=f"{1e3 * dt:g} ms")
    left.set(xlabel="time (s)", ylabel="gap under the block (m)", title="Dropped from 1 m")
    left.legend(frameon=False, title="Δt")
    steps, loss = [line[0] for line in table], [line[-1] for line in table]
    fine = np.geomspace(min(steps) / 2, max(steps) * 1.5)
    omega = table[0][1] / table[0][0]
    theory = [1 - _scheme_restitution(omega * dt) ** 2 for dt in fine]
    right.loglog(fine, theory, color=INK, lw=1, label="closed form")
    right.loglog(steps, loss, "o", color=BLUE, label="engine")
    right.set(xlabel="Δt (s)", ylabel="loss of height at the first bounce (m)")
    return figure


@case(
    "A hundred turns in flight",
    "Area, edges and angular momentum of a free body are constant. A rectangle and an L-shaped "
    "block rotate at 2π rad/s, with 20 and 200 steps per turn.",
    "`docs/method.md` (linear rotation, a fault of the original, increases the size of blocks).",
)
def rotation(short: bool) -> Outcome:
    """Check area, edge lengths and angular momentum after 100 turns."""
    rows, pictures = [], []
    ell = np.array([[0, 0], [3, 0], [3, 1], [1, 1], [1, 2], [0, 2]], dtype=float)
    for name, shape in {"rectangle": nml.rectangle(0, 0, 2, 1), "L": ell}.items():
        for steps_per_turn in (40,) if short else (20, 200):
            result = _run_spinning_body(shape, 100, steps_per_turn)
            pictures.append((f"{name}, {steps_per_turn}", result))
            label = f"{name}, {steps_per_turn} steps per turn"
            rows += [
                relative(f"number of turns, {label}", 100.0, result["turns"], 1e-10),
                at_most(f"largest relative change of the area, {label}", result["area"], 1e-10),
                at_most(f"largest relative change of an edge, {label}", result["edge"], 1e-10),
                at_most(f"largest relative change of the angular momentum, {label}",
                    result["momentum"], 1e-6),
            ]  # fmt: skip
    return Outcome(rows, _draw_rotation(pictures))


def _edge_lengths(polygon) -> np.ndarray:
    return np.linalg.norm(np.roll(polygon, -1, axis=0) - polygon, axis=1)


def _run_spinning_body(shape, turns: int, steps_per_turn: int) -> dict:
    """Run a free body at one turn per second; return turns, largest changes and polygons."""
    rate = 2 * np.pi
    step, steps = 1 / steps_per_turn, turns * steps_per_turn
    text = nml.text(
        nml.control(step, steps, gravity=(0, 0), max_displacement_ratio=1.0),
        nml.contact(1e10),
        nml.material("rock", DENSITY, 1e10, 0.2, velocity=(1.0, 0.5, rate)),
        nml.joint("j", 30.0),
        nml.block("body", shape),
    )
    with nml.simulation(text) as flight:
        start = flight.polygons[0]
        area, edges = Polygon(start).area, _edge_lengths(start)
        path, changes = [start], []
        for _ in range(4 * turns):
            flight.advance(steps_per_turn // 4)
            polygon = flight.polygons[0]
            path.append(polygon)
            ratios = (Polygon(polygon).area / area, _edge_lengths(polygon) / edges,
                      flight.rates[0, 2] / rate)  # fmt: skip
            changes.append([np.abs(ratio - 1).max() for ratio in ratios])
        rotation = flight.coordinates[0, 2] / (2 * np.pi)
    worst = dict(zip(("area", "edge", "momentum"), np.max(changes, axis=0), strict=True))
    return worst | {"turns": rotation, "path": path, "changes": np.array(changes)}


def _draw_rotation(pictures):
    figure, (left, right) = canvas(size=(11, 4.4), width_ratios=[3, 2])
    for i, (name, result) in enumerate(pictures):
        color = COLORS[i % len(COLORS)]
        turns = 0.25 * np.arange(1, len(result["changes"]) + 1)
        worst = np.maximum.accumulate(result["changes"][:, 0])
        right.semilogy(turns, worst, color=color, lw=0.8, label=name)
        if i % 2 == 0 or len(pictures) == 2:
            shift = [0.0, -3.5 * (i > 0)]
            draw_blocks(left, [p + shift for p in result["path"][:9]], color, alpha=0.35)
            draw_blocks(left, [result["path"][0] + shift], STONE)
    left.set_title("the first two turns, every quarter turn", fontsize=10)
    bare(left)
    right.axhline(1e-10, color=RED, lw=1, ls="--", label="allowed")
    label = "largest relative change of the area"
    right.set(xlabel="turns", ylabel=label, ylim=(1e-17, 1e-9))
    right.legend(frameon=False, fontsize=8, title="steps per turn", loc="lower right")
    return figure


@case(
    "A block slides off an edge, tips, flies and lands",
    "A rigid block slides without friction until its centre passes the edge. It then rotates about "
    "the edge while it slides (two coordinates), and flies when the force at the edge vanishes. "
    "The reference integrates Lagrange's equations of each phase (scipy, tolerance 1e-11).",
    "A standard case; phases: rigid-body dynamics, derived here.",
)
def edge(short: bool) -> Outcome:
    """Check position, angle and time of landing, and equilibrium on the floor."""
    steps = (1e-4,) if short else (4e-4, 2e-4, 1e-4)
    truth = _integrate_tipping_block()
    runs = {dt: _run_sliding_block(dt) for dt in steps}
    run = runs[steps[-1]]
    landing = truth["t"][-1]
    x, y, angle = (np.interp(landing, run["time"], run[key]) for key in ("x", "y", "angle"))
    rows = [
        relative("x of the centre at landing, Δt 0.1 ms", truth["x"][-1], x, 1e-3, "m"),
        relative("height of the centre at landing", truth["y"][-1], y, 1e-3, "m"),
        relative("angle at landing", truth["angle"][-1], angle, 5e-3, "rad"),
        relative("time of landing", landing, run["landing"], 1e-3, "s"),
        at_most("kinetic energy at the end / at landing", run["kinetic_ratio"], 1e-4),
        at_most("largest penetration of a corner into the floor at the end", run["depth"], 1e-4,
            "m"),
        at_most("energy residual / work of gravity", run["audit"], 1e-6),
        at_most("energy gain / m g h, h: height of the table", run["gain"], 1e-6),
    ]  # fmt: skip
    angles = [np.interp(landing, history["time"], history["angle"]) for history in runs.values()]
    errors = [abs(angle_at_landing / truth["angle"][-1] - 1) for angle_at_landing in angles]
    title = "Relative error of the angle at landing for several Δt."
    table = convergence(title, "Δt (s)", steps, errors)
    return Outcome(rows, _draw_landing(run, truth), [] if short else [table])


WIDTH, HEIGHT, SPEED, TABLE = 1.0, 0.4, 2.0, 2.0  # block (m, m, m/s), height of the table (m)


def _run_sliding_block(time_step: float) -> dict:
    """Run a block that slides off a smooth table; return histories, landing and residuals."""
    body = nml.rectangle(-1.0, TABLE, WIDTH, HEIGHT)
    text = nml.text(
        nml.control(time_step, round(3.0 / time_step), max_displacement_ratio=0.02),
        nml.contact(1e11),
        nml.material("stiff", DENSITY, nml.STIFF),
        nml.material("moving", DENSITY, nml.STIFF, velocity=(SPEED, 0.0, 0.0)),
        nml.joint("rough", 45.0),
        nml.joint("smooth", 0.0),
        nml.fixed_block("table", nml.rectangle(-3, 0, 3, TABLE), "stiff", "smooth"),
        nml.fixed_block("floor", nml.rectangle(-3, -0.5, 9, 0.5), "stiff", "rough"),
        nml.block("block", body, "moving", "rough"),
    )
    keys = ("time", "x", "y", "angle", "polygon", "low", "total", "kinetic")
    result: dict = {key: [] for key in keys}
    with nml.simulation(text) as flight:
        while not flight.done:
            flight.advance()
            energies, polygon = flight.energies, flight.polygons[2]
            values = (flight.time, *flight.coordinates[2, :3], polygon, polygon[:, 1].min(),
                      nml.energy_gain(energies), energies["kinetic"])  # fmt: skip
            for key, value in zip(keys, values, strict=True):
                result[key].append(value)
    lowest, kinetic = np.array(result["low"]), np.array(result["kinetic"])
    contact = int(np.argmax(lowest < 0.0))
    fraction = lowest[contact - 1] / (lowest[contact - 1] - lowest[contact])
    result["landing"] = result["time"][contact - 1] + fraction * time_step
    result["kinetic_ratio"] = kinetic[-1] / kinetic[contact - 1]
    result["depth"] = max(0.0, -lowest[-1])
    result["audit"] = abs(energies["balance"] / energies["gravity"])
    result["gain"] = max(result["total"]) / (DENSITY * WIDTH * HEIGHT * nml.GRAVITY * TABLE)
    return result


def _integrate_tipping_block() -> dict:
    """Return the exact motion of a rigid block that slides, tips, flies and lands.

    While the block tips about the smooth edge P at (0, TABLE), its centre is at P + s t + (h/2) n
    with unit vectors t, n along and across the block.  Lagrange's equations in (s, θ), θ < 0
    clockwise, are::

        s'' − (h/2) θ'' = s θ'² − g sin θ
        (s² + h²/4 + I/m) θ'' − (h/2) s'' = −2 s s' θ' − g (s cos θ − (h/2) sin θ)
    """
    half = 0.5 * HEIGHT
    inertia = (WIDTH**2 + HEIGHT**2) / 12
    start = 0.5 / SPEED  # s; the centre is initially at −0.5 m

    def rates(_, z):
        s, angle, ds, rate = z
        matrix = [[1, -half], [-half, s**2 + half**2 + inertia]]
        load = [
            s * rate**2 - nml.GRAVITY * np.sin(angle),
            -2 * s * ds * rate - nml.GRAVITY * (s * np.cos(angle) - half * np.sin(angle)),
        ]
        return [ds, rate, *np.linalg.solve(matrix, load)]

    def force(t, z):
        """Return the normal force of the edge over the mass, n · (x'' + g)."""
        s, angle, ds, rate = z
        _, _, _, bend = rates(t, z)
        return 2 * ds * rate + s * bend - half * rate**2 + nml.GRAVITY * np.cos(angle)

    def off(t, z):
        """Return 0 if the rear corner reaches the edge or the force is zero."""
        return min(0.5 * WIDTH - z[0], force(t, z))

    off.terminal, off.direction = True, -1
    exact = {"rtol": 1e-11, "atol": 1e-12, "max_step": 1e-3}
    tip = solve_ivp(rates, (0, 2), [0, 0, SPEED, 0], events=off, **exact)
    s, angle, ds, rate = tip.y
    t, n = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    position = s * t + half * n + np.array([[0.0], [TABLE]])
    speed = (ds - half * rate) * t + s * rate * n
    times, path, angles = start + tip.t, position, angle
    flight = np.linspace(0, 1.0, 20001)[1:]
    px = position[0, -1] + speed[0, -1] * flight
    py = position[1, -1] + speed[1, -1] * flight - 0.5 * nml.GRAVITY * flight**2
    pa = angle[-1] + rate[-1] * flight
    reach = 0.5 * (WIDTH * np.abs(np.sin(pa)) + HEIGHT * np.abs(np.cos(pa)))
    landing = int(np.argmax(py < reach)) + 1
    return {
        "t": np.concatenate([times, times[-1] + flight[:landing]]),
        "x": np.concatenate([path[0], px[:landing]]),
        "y": np.concatenate([path[1], py[:landing]]),
        "angle": np.concatenate([angles, pa[:landing]]),
        "tip": times[-1],
    }


def _draw_landing(run, truth):
    figure, (left, right) = canvas(width_ratios=[3, 2])
    draw_blocks(left, [nml.rectangle(-2, 0, 2, TABLE), nml.rectangle(-2, -0.3, 6, 0.3)], GROUND)
    frames = [int(i) for i in np.linspace(0, np.searchsorted(run["time"], truth["t"][-1]), 10)]
    draw_blocks(left, [run["polygon"][i] for i in frames], STONE, alpha=0.7)
    draw_blocks(left, run["polygon"][-1:], ORANGE, alpha=0.8)
    left.plot(truth["x"], truth["y"], color=RED, lw=1, label="centre, theory")
    left.legend(frameon=False, loc="upper right")
    left.set_title("orange: at rest after 3 s", fontsize=10)
    bare(left)
    right.plot(truth["t"], np.degrees(truth["angle"]), color=INK, lw=3, alpha=0.3, label="theory")
    right.plot(run["time"], np.degrees(run["angle"]), color=BLUE, lw=1, label="engine")
    right.axvline(truth["tip"], color="0.7", lw=0.8)
    right.axvline(truth["t"][-1], color="0.7", lw=0.8)
    right.set(xlabel="time (s)", ylabel="angle (°)", title="lines: leaves the edge, lands")
    return figure
