# SPDX-License-Identifier: GPL-3.0-or-later
"""Coulomb friction: inclines, a shaken base, a real record, a tilting table, many blocks."""

from pathlib import Path

import numpy as np

from sitedda.input.examples import inputs
from sitedda.report import style

from .. import model as nml
from ..case import Outcome, Table, at_most, case, convergence, relative

ROCK = {"density": 2643.0, "young_modulus": 4.788e9, "poisson_ratio": 0.25}  # paper table I
RECORD = "LomaPrieta1989_USGS1002_APEEL2_133.smc"
SLIDING = 1  # state of a sliding contact


def _incline_text(
    friction_angle, stiffness, time_step, duration, slope=30.0, samples=100, motion="", **settings
) -> str:
    """Return a block of 1 m × 0.5 m on a fixed wedge that is inclined by `slope` degrees."""
    angle = -np.radians(slope)
    wedge = nml.rotated(nml.rectangle(-1.0, -1.0, 9.0, 1.0), angle)
    rider = nml.rotated(nml.rectangle(0.0, 0.0, 1.0, 0.5), angle)
    steps = round(duration / time_step)
    return nml.text(
        nml.control(time_step, steps, **settings),
        nml.contact(stiffness),
        nml.material("base", 2643.0, nml.STIFF),
        nml.material("rock", **ROCK),
        nml.joint("plane", friction_angle),
        motion,
        nml.fixed_block("wedge", wedge, "base"),
        nml.block("block", rider, "rock"),
        nml.measured_point("centre", rider.mean(axis=0), "block"),
        nml.group("output", history_interval=max(1, steps // samples)),
    )


def _slip_down_slope(data, slope: float) -> np.ndarray:
    """Return the displacement of the block down the slope, m."""
    angle = np.radians(slope)
    move = data.displacement.sel(point="centre").values
    return move @ np.array([np.cos(angle), -np.sin(angle)])


def _coulomb_slip(friction_angle: float, slope: float, time):
    """Return the slip ½ g (sin α − cos α tan φ) t², m."""
    angle, mu = np.radians(slope), np.tan(np.radians(friction_angle))
    return 0.5 * nml.GRAVITY * (np.sin(angle) - np.cos(angle) * mu) * np.asarray(time) ** 2


@case(
    "Block on an incline of 30°",
    "If φ < α, the slip is ½ g (sin α − cos α tan φ) t²; if φ > α, the block is at rest.",
    "A standard case; MacLaughlin & Sitar (1999) use the same case for the original DDA.",
)
def incline(short: bool) -> Outcome:
    """Check the slip after 1 s with φ = 0, 10, 20°, and equilibrium with φ = 35°."""
    young = ROCK["young_modulus"]
    rows, runs = [], {}
    for factor in (1, 50):
        for friction in (0.0, 10.0, 20.0):
            data = nml.history(_incline_text(friction, factor * young, 1e-3, 1.0))
            runs[factor, friction] = data
            name = f"slip after 1 s, φ = {friction:g}°, penalty {factor} E"
            expected = _coulomb_slip(friction, 30.0, 1.0)
            rows.append(relative(name, expected, _slip_down_slope(data, 30.0)[-1], 1e-6, "m"))
            rows.append(at_most(f"energy residual / work, φ = {friction:g}°, penalty {factor} E",
                nml.energy_residual(data), 1e-6))  # fmt: skip
        duration = 6.0 if short else 60.0
        data = nml.history(_incline_text(35.0, factor * young, 1e-3, duration, samples=600))
        runs[factor, 35.0] = data
        displacement = _slip_down_slope(data, 30.0)
        drift = np.ptp(displacement[data.time.values > 1.0])
        rows.append(at_most(f"drift after the first second, φ = 35°, penalty {factor} E", drift,
            1e-12, "m"))  # fmt: skip
        elastic = _elastic_settlement(35.0, factor * young)
        rows.append(at_most(f"elastic displacement, φ = 35°, penalty {factor} E", displacement[-1],
            elastic, "m"))  # fmt: skip
    tables = [] if short else _incline_tables(young)
    return Outcome(rows, _draw_incline(runs, tables), tables)


def _elastic_settlement(friction_angle: float, stiffness: float) -> float:
    """Return a bound of the elastic displacement down the slope, m."""
    weight = ROCK["density"] * 0.5 * nml.GRAVITY * np.sin(np.radians(30.0))
    shear_modulus = 0.5 * ROCK["young_modulus"] / (1 + ROCK["poisson_ratio"])
    return 2.0 * weight * (2.5 / (2 * stiffness) + 0.5 / shear_modulus)


def _incline_tables(young: float) -> list[Table]:
    """Tabulate the error of the slip at φ = 20° for several penalties and time steps."""

    def error(penalty: float, time_step: float) -> float:
        data = nml.history(_incline_text(20.0, penalty, time_step, 1.0))
        return abs(_slip_down_slope(data, 30.0)[-1] / _coulomb_slip(20.0, 30.0, 1.0) - 1)

    factors = (0.04, 0.2, 1, 5, 50, 300)
    by_penalty = [error(factor * young, 1e-3) for factor in factors]
    steps = (1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 1e-4)
    by_step = [error(young, step) for step in steps]
    return [
        Table(
            "Relative error of the slip at φ = 20° for several penalties (Δt 1e-3 s). Gravity is"
            " applied suddenly. If Δt resolves the contact springs, the block first bounces and"
            " sticks (errors above 1e-4). If the springs are damped within a step, only the"
            " settlement of springs and block remains.",
            ("penalty / E", "error"),
            list(zip(factors, by_penalty, strict=True)),
        ),
        Table(
            "Relative error of the slip for several Δt (penalty E). The scheme is exact for a "
            "constant acceleration. Below 1 ms the springs vibrate (period 2.5 ms).",
            ("Δt (s)", "error"),
            list(zip(steps, by_step, strict=True)),
        ),
    ]


def _draw_incline(runs, tables):
    figure, (left, right) = style.canvas()
    for color, friction in zip(style.COLORS, (0.0, 10.0, 20.0), strict=False):
        data = runs[1, friction]
        left.plot(data.time, _coulomb_slip(friction, 30.0, data.time), color=style.INK, lw=1)
        slip = _slip_down_slope(data, 30.0)[::10]
        left.plot(data.time[::10], slip, "o", ms=4, color=color, label=f"φ {friction:g}°")
    left.plot([], [], color=style.INK, lw=1, label="formula")
    left.set(xlabel="time (s)", ylabel="slip (m)", title="Slip on 30°, penalty E, Δt 1 ms")
    if tables:
        factors, errors = zip(*tables[0].rows, strict=True)
        right.loglog(factors, errors, "o-", color=style.BLUE, label="φ 20°, Δt 1 ms")
        right.axhline(1e-6, color=style.RED, lw=1, ls="--", label="allowed")
        right.set(xlabel="penalty / E", ylabel="relative error")
        right.set_title("Error of the slip after 1 s")
    else:
        for factor, color in ((1, style.BLUE), (50, style.ORANGE)):
            data = runs[factor, 35.0]
            slip = 1e6 * _slip_down_slope(data, 30.0)
            right.plot(data.time, slip, color=color, label=f"{factor} E")
        right.set(xlabel="time (s)", ylabel="displacement (µm)", title="φ = 35°: the block sticks")
    return figure


def rigid_slide(time, base, slope: float, friction_angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Return slip (m) and slip velocity (m/s) of Newmark's block on an accelerated base.

    `base` is the horizontal acceleration of the base in the downslope sense, m/s², at equidistant
    times (s).  Each interval is integrated in closed form with mean acceleration.  During downward
    slip, v' = g [sin α + k cos α − tan φ (cos α − k sin α)] with k = −base/g; during upward slip,
    friction has the opposite sign.  The block sticks if the velocity changes its sign and the
    driving force is less than friction.
    """
    angle, mu = np.radians(slope), np.tan(np.radians(friction_angle))
    drive = nml.GRAVITY * np.sin(angle) - base * np.cos(angle)
    bound = mu * (nml.GRAVITY * np.cos(angle) + base * np.sin(angle))
    drive, bound = 0.5 * (drive[1:] + drive[:-1]), 0.5 * (bound[1:] + bound[:-1])
    step = time[1] - time[0]
    slip, velocity = np.zeros(len(time)), np.zeros(len(time))
    s = v = 0.0
    for i, (f, n) in enumerate(zip(drive.tolist(), bound.tolist(), strict=True)):
        s, v = _integrate_slip(s, v, f, n, step)
        slip[i + 1], velocity[i + 1] = s, v
    return slip, velocity


def _integrate_slip(s: float, v: float, drive: float, bound: float, duration: float):
    """Return slip and velocity after a duration (s) of constant push and friction bound, m/s²."""
    for _ in range(2):
        if v == 0.0 and abs(drive) <= bound:
            return s, 0.0
        direction = np.sign(v) if v != 0.0 else np.sign(drive)
        rate = drive - direction * bound
        stop = -v / rate if v != 0.0 and rate * direction < 0.0 else np.inf
        if stop >= duration:
            return s + v * duration + 0.5 * rate * duration**2, v + rate * duration
        s, v, duration = s + 0.5 * v * stop, 0.0, duration - stop
    return s, v


def _refine_series(time: np.ndarray, values: np.ndarray, time_step: float, finer: int = 20):
    """Return times and values, interpolated linearly to intervals of `step` / `finer`."""
    fine = np.arange(0.0, time[-1] + 0.5 * time_step / finer, time_step / finer)
    return fine, np.interp(fine, time, values)


def record_file() -> Path:
    """Return the path of the shipped record."""
    return inputs() / "records" / RECORD


def recorded(name: str, **variables) -> str:
    """Return the group ``&motion`` of the shipped record."""
    kind = {"quantity": "acceleration", "unit": "cm/s2", "format": "smc"}
    return nml.group("motion", name=name, file=str(record_file()), **kind, **variables)


def read_smc(file: Path) -> tuple[np.ndarray, np.ndarray]:
    """Read time (s) and acceleration (m/s²) of an SMC file without the engine."""
    lines = file.read_text().splitlines()
    integers = [int(number) for line in lines[11:17] for number in line.split()]
    rate = float(lines[17].split()[1])
    samples, comments = integers[16], integers[15]
    text = "".join(line.ljust(80)[:80] for line in lines[27 + comments :])
    values = [float(text[i : i + 10]) for i in range(0, 10 * samples, 10)]
    return np.arange(samples) / rate, 0.01 * np.array(values)


@case(
    "Newmark's sliding block under a recorded earthquake",
    "A sliding block has the acceleration g [sin α + k cos α − tan φ (cos α − k sin α)]; it yields"
    " at k_y = tan(φ − α). The case has α = 15°, φ = 22° and the shipped record of Loma Prieta"
    " 1989, APEEL array 2, times 2 (0.45 g). The reference solution integrates the rigid block"
    " piecewise in closed form at Δt/20.",
    "Newmark (1965), Géotechnique 15(2).",
)
def newmark(short: bool) -> Outcome:
    """Check the permanent displacement of a block on 15° under the doubled record."""
    slope, friction, scale, step = 15.0, 22.0, 2.0, 1e-3
    time, acceleration = read_smc(record_file())
    interval = time <= (14.0 if short else time[-1])
    fine, base = _refine_series(time[interval], scale * acceleration[interval], step)
    slip, velocity = rigid_slide(fine, base, slope, friction)
    steps = (1e-3,) if short else (5e-3, 2e-3, 1e-3, 5e-4)
    runs = {dt: _run_newmark(dt, fine[-1], slope, friction, scale) for dt in steps}
    data, computed = runs[step]
    young = ROCK["young_modulus"]
    rows = [
        relative("permanent slip, Δt 1 ms, penalty 1 E", slip[-1], computed[-1], 5e-3, "m"),
        at_most("largest error of the slip at any time / permanent slip",
            np.abs(computed - np.interp(data.time, fine, slip)).max() / slip[-1], 5e-3),
        at_most("energy residual / work", nml.energy_residual(data), 1e-6),
    ]  # fmt: skip
    tables = []
    if not short:
        _, stiff = _run_newmark(step, fine[-1], slope, friction, scale, 50 * young)
        rows.append(relative("permanent slip, Δt 1 ms, penalty 50 E", slip[-1], stiff[-1], 5e-3,
            "m"))  # fmt: skip
        errors = [abs(runs[dt][1][-1] / slip[-1] - 1) for dt in steps]
        title = ("Relative error of the permanent slip for several Δt. The scheme uses the "
                 "acceleration at the end of the step.")  # fmt: skip
        tables = [convergence(title, "Δt (s)", steps, errors)]
    figure = _draw_newmark_slip(fine, base, slip, velocity, data, computed, slope, friction)
    return Outcome(rows, figure, tables)


def _run_newmark(time_step, duration, slope, friction, scale, stiffness=ROCK["young_modulus"]):
    """Run Newmark's block under the record as body force; return history and slip (m)."""
    shaking = recorded("record", scale=scale, drift_order=0)
    data = nml.history(_incline_text(friction, stiffness, time_step, duration, slope, 2000, shaking,
                                base_motion_x="record"))  # fmt: skip
    return data, _slip_down_slope(data, slope)


def _draw_newmark_slip(fine, base, slip, velocity, data, computed, slope, friction):
    figure, (top, middle, bottom) = style.canvas(1, 3, size=(9, 7), sharex=True)
    top.plot(fine[::10], -base[::10] / nml.GRAVITY, color="0.45", lw=0.6)
    limit = np.tan(np.radians(friction - slope))
    top.axhline(limit, color=style.RED, lw=1, ls="--", label=f"yield {limit:.3f} g")
    top.set(ylabel="k, − base acceleration / g", title="Loma Prieta 1989, APEEL array 2, doubled")
    along = np.array([np.cos(np.radians(slope)), -np.sin(np.radians(slope))])
    speed = data.velocity.sel(point="centre").values @ along
    pale = {"color": style.INK, "lw": 2.2, "alpha": 0.35, "label": "rigid block"}
    middle.plot(fine[::10], velocity[::10], **pale)
    middle.plot(data.time, speed, color=style.BLUE, lw=0.8, label="engine")
    middle.set(ylabel="slip velocity (m/s)")
    bottom.plot(fine[::10], slip[::10], **pale)
    bottom.plot(data.time, computed, color=style.BLUE, lw=1, label="engine")
    bottom.set(xlabel="time (s)", ylabel="slip (m)")
    return figure


@case(
    "Block on a base that shakes",
    "The block sticks if |a| ≤ μ g; otherwise its acceleration is ± μ g until the relative"
    " velocity is zero. Fixed points prescribe the displacement of the base, whose acceleration is"
    " 0.4 g sin(2π t); μ = tan 10°.",
    "A standard case; Kamai & Hatzor (2008) use the same case.",
)
def shaking_base(short: bool) -> Outcome:
    """Check the slip on the base by comparison with the integrated rigid block."""
    amplitude, friction, duration = 0.4 * nml.GRAVITY, 10.0, 4.0
    steps = (2.5e-4,) if short else (1e-3, 5e-4, 2.5e-4)
    time = np.arange(0.0, duration + 5e-4, 1e-3)
    shaking = amplitude * np.sin(2 * np.pi * time)
    fine, base = _refine_series(time, shaking, 1e-3)
    slip, _ = rigid_slide(fine, base, 0.0, friction)
    runs = {dt: _run_shaken_block(dt, duration, friction, shaking) for dt in steps}
    errors = [
        np.abs(_slip_on_base(runs[dt]) - np.interp(runs[dt].time, fine, slip)).max()
        / np.abs(slip).max()
        for dt in steps
    ]
    data = runs[2.5e-4]
    rows = [
        at_most("largest error of the slip / largest slip, Δt 0.25 ms, penalty 50 E", errors[-1],
            5e-3),
        relative("slip at the end", slip[-1], _slip_on_base(data)[-1], 5e-3, "m"),
        at_most("energy residual / work", nml.energy_residual(data), 1e-6),
    ]  # fmt: skip
    title = ("Largest error of the slip / largest slip for several Δt. It is of first order, "
             "because the scheme uses the base acceleration at the end of the step.")  # fmt: skip
    tables = [] if short else [convergence(title, "Δt (s)", steps, errors)]
    return Outcome(rows, _draw_shaken_block(data, fine, base, slip, friction), tables)


def _run_shaken_block(time_step: float, duration: float, friction: float, shaking):
    """Run a block on a base with accelerations `shaking` (m/s²) every 1 ms; return the history."""
    rider = nml.rectangle(-0.5, 0.0, 1.0, 0.5)
    text = nml.text(
        nml.control(time_step, round(duration / time_step)),
        nml.contact(50 * ROCK["young_modulus"]),
        nml.material("base", 2643.0, nml.STIFF),
        nml.material("rock", **ROCK),
        nml.joint("plane", friction),
        nml.motion("shaking", shaking, 1e-3),
        nml.fixed_block("base", nml.rectangle(-6, -1, 12, 1), "base", motion_x="shaking"),
        nml.block("block", rider, "rock"),
        nml.measured_point("centre", rider.mean(axis=0), "block"),
        nml.measured_point("base", (0.0, -0.5), "base"),
    )
    return nml.history(text)


def _slip_on_base(data) -> np.ndarray:
    x = data.displacement.isel(axis=0)
    return (x.sel(point="centre") - x.sel(point="base")).values


def _draw_shaken_block(data, fine, base, slip, friction):
    figure, (left, right) = style.canvas()
    v = data.velocity.isel(axis=0)
    left.plot(data.time, v.sel(point="base"), color="0.6", label="base")
    left.plot(data.time, v.sel(point="centre"), color=style.BLUE, label="block")
    left.set(xlabel="time (s)", ylabel="velocity (m/s)", title="0.4 g sin(2πt), μ = tan 10°")
    right.plot(fine, slip, color=style.INK, lw=3, alpha=0.3, label="rigid block")
    right.plot(data.time, _slip_on_base(data), color=style.BLUE, lw=1.2, label="engine")
    right.set(xlabel="time (s)", ylabel="slip (m)", title="Slip relative to the base")
    return figure


@case(
    "Tilting table",
    "A block on a slowly tilting table slides at tan α = μ, a slender block topples at tan α ="
    " w/h. One block of each kind stands on the table (φ = 15°; w/h = 0.3 with φ = 40°). The table"
    " rotates by 1°/s about its lower left corner.",
    "A standard case of the field.",
)
def tilt(short: bool) -> Outcome:
    """Check the angle at which one block slides and the angle at which another one topples."""
    rate, duration = np.radians(2.0 if short else 1.0), (9.0 if short else 18.0)
    text = _tilting_table_text(rate, duration, 1e-3)
    slide_at = topple_at = 0.0
    frames, times = {}, np.linspace(0, duration, 4)
    with nml.simulation(text) as table:
        owner = np.repeat(np.arange(3), [len(p) for p in table.polygons])
        for _ in range(round(duration / 1e-3)):
            table.advance()
            states = _contact_states(table.contacts, owner)
            if states[1] and any(state != SLIDING for state in states[1]):
                slide_at = table.time
            if len(states[2]) > 1:
                topple_at = table.time
            if len(frames) < len(times) and table.time >= times[len(frames)] - 1e-9:
                frames[table.time] = table.polygons
        audit = abs(table.energies["balance"]) / abs(table.energies["input"])
    frames = list(frames.items())
    sliding, toppling = np.degrees(rate * slide_at), np.degrees(rate * topple_at)
    limit = np.degrees(np.arctan(0.3))
    rows = [
        relative("angle at which the block begins to slide", 15.0, sliding, 2e-3, "°"),
        relative("angle at which the slender block begins to topple", limit, toppling, 2e-3, "°"),
        at_most("energy residual / input work at the end", audit, 1e-6),
    ]
    return Outcome(rows, _draw_tilted_table(frames, rate))


def _contact_states(contacts, owner) -> dict[int, list[int]]:
    """Return the states of the closed contacts with the table, by block (1 and 2)."""
    states: dict[int, list[int]] = {1: [], 2: []}
    pairs = zip(owner[contacts["vertex"]], owner[contacts["edge"]], contacts["state"], strict=True)
    for a, b, state in pairs:
        if state and min(a, b) == 0 and max(a, b) in states:
            states[max(a, b)].append(int(state))
    return states


def _tilting_table_text(rate: float, duration: float, time_step: float) -> str:
    """Return two blocks on a table that rotates by `rate` (rad/s, clockwise)."""
    table = nml.rectangle(0.0, -0.5, 6.0, 0.5)
    time = np.arange(0.0, duration + 0.02, 0.01)
    angle = -rate * time
    points, motions = "", ""
    for i, (x, y) in enumerate(table - table[0]):
        dx = x * (np.cos(angle) - 1) - y * np.sin(angle)
        dy = x * np.sin(angle) + y * (np.cos(angle) - 1)
        motions += nml.motion(f"x{i}", dx, 0.01, "displacement")
        motions += nml.motion(f"y{i}", dy, 0.01, "displacement")
        position = {"x": table[i, 0], "y": table[i, 1], "block": "table"}
        points += nml.group("fixed_point", **position, motion_x=f"x{i}", motion_y=f"y{i}")
    return nml.text(
        nml.control(time_step, round(duration / time_step)),
        nml.contact(50 * ROCK["young_modulus"]),
        nml.material("base", 2643.0, nml.STIFF),
        nml.material("rock", **ROCK),
        nml.joint("rough", 40.0),
        nml.joint("smooth", 15.0),
        motions,
        nml.block("table", table, "base", "rough"),
        nml.block("slider", nml.rectangle(1.0, 0.0, 1.0, 0.5), "rock", "smooth"),
        nml.block("tower", nml.rectangle(4.0, 0.0, 0.6, 2.0), "rock", "rough"),
        points,
    )


def _draw_tilted_table(frames, rate):
    figure, axes = style.canvas(len(frames), size=(12, 3.4), sharex=True, sharey=True)
    for axis, (time, polygons) in zip(axes, frames, strict=True):
        style.draw_blocks(axis, polygons, [style.GROUND, style.COLORS[0], style.STONE])
        axis.set_title(f"{np.degrees(rate * time):.1f}°")
        style.bare(axis)
    return figure


@case(
    "Twenty blocks on an incline",
    "Touching blocks lie on an incline of 30°; φ increases upwards from 5° to 24°. The blocks "
    "separate, and each slips by ½ g (sin α − cos α tan φ) t². Poisson's ratio is 0: with 0.25 the "
    "blocks first bulge against each other, and the relative error of a slip is 1.3e-5.",
    "A standard case of the field.",
)
def many_blocks(short: bool) -> Outcome:
    """Check the slip of each block after 1 s."""
    count = 20
    friction = 24.0 - np.arange(count)  # degrees, from the top down
    angle = -np.radians(30.0)
    shapes = [nml.rotated(nml.rectangle(0.5 * i, 0.0, 0.5, 0.3), angle) for i in range(count)]
    text = nml.text(
        nml.control(1e-3, 1000),
        nml.contact(50 * ROCK["young_modulus"]),
        nml.material("base", 2643.0, nml.STIFF),
        nml.material("rock", **{**ROCK, "poisson_ratio": 0.0}),
        nml.joint("plane", 60.0),
        *(nml.joint(f"j{i}", phi) for i, phi in enumerate(friction)),
        nml.fixed_block("wedge", nml.rotated(nml.rectangle(-1, -1, 16, 1), angle), "base", "plane"),
        *(nml.block(f"b{i}", s, "rock", f"j{i}") for i, s in enumerate(shapes)),
    )
    with nml.simulation(text) as slide:
        start, initial = slide.coordinates[1:, :2], slide.polygons
        while not slide.advance(100):
            pass
        displacement = slide.coordinates[1:, :2] - start
        final, energies = slide.polygons, slide.energies
    slip = displacement @ np.array([np.cos(angle), np.sin(angle)])
    expected = np.array([_coulomb_slip(phi, 30.0, 1.0) for phi in friction])
    worst = int(np.argmax(np.abs(slip / expected - 1)))
    label = f"slip with the largest error, block with φ = {friction[worst]:g}°"
    rows = [
        relative(label, expected[worst], slip[worst], 1e-6, "m"),
        at_most("energy residual / work of gravity", abs(energies["balance"] / energies["gravity"]),
            1e-6),
    ]  # fmt: skip
    return Outcome(rows, _draw_sliding_blocks(initial, final, friction, expected, slip))


def _draw_sliding_blocks(initial, final, friction, expected, slip):
    figure, (left, right) = style.canvas(width_ratios=[3, 2])
    style.draw_blocks(left, initial[1:], "none", edge="0.6")
    style.draw_blocks(left, final, [style.GROUND, *([style.STONE] * (len(final) - 1))])
    left.set_title("after 1 s; outlines: at the start")
    style.bare(left)
    right.plot(friction, expected, color=style.INK, lw=1, label="formula")
    right.plot(friction, slip, "o", ms=4, color=style.BLUE, label="engine")
    right.set(xlabel="friction angle (°)", ylabel="slip after 1 s (m)")
    return figure
