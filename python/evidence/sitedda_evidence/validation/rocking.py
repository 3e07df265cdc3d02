# SPDX-License-Identifier: GPL-3.0-or-later
"""Housner's rocking block: uplift, free decay with impacts, overturning by sines and pulses."""

import numpy as np
from scipy.integrate import quad, solve_ivp

from sitedda.report.style import BLUE, COLORS, GROUND, INK, RED, STONE, bare, canvas, draw_blocks
from sitedda.stability import bisect

from .. import model as nml
from ..case import Outcome, Table, at_most, case, convergence, relative, yes_or_no

WIDTH, HEIGHT, DENSITY = 0.5, 2.0, 2500.0  # m, m, kg/m³
SLENDER = np.arctan2(WIDTH, HEIGHT)  # Housner's α
RADIUS = 0.5 * np.hypot(WIDTH, HEIGHT)  # R, m
RATE = np.sqrt(3 * nml.GRAVITY / (4 * RADIUS))  # p, rad/s
RATIO = 1 - 1.5 * np.sin(SLENDER) ** 2  # ratio of angular velocities after and before an impact
PENALTY = 1e14  # N/m; impacts end within a step, as in Housner's theory


def housner(duration, angle=0.0, base=None, step=1e-3):
    """Return the rocking angle by Housner's equation.

    θ'' = −p² [sin(α sgn θ − θ) + (a/g) cos(α sgn θ − θ)]; at θ = 0, the angular velocity is
    multiplied by 1 − 1.5 sin² α.  The initial θ, `angle`, is positive about the right corner
    (clockwise).  `base` is the acceleration of the base (m/s²) as a function of time; a positive
    one causes negative θ.  The result is times (s), angles (rad) until the block has overturned
    (|θ| > π/2), and times of impact (s).
    """
    times, angles, impacts = [0.0], [angle], []
    t, state, base = 0.0, [angle, 0.0], base or (lambda _: 0.0)
    while t < duration:
        if abs(state[0]) < 1e-14 and abs(state[1]) < 1e-9:
            t, sign = _find_uplift(t, duration, base, step)
            times.append(t)
            angles.append(0.0)
            if t >= duration:
                break
        else:
            sign = np.sign(state[0]) if abs(state[0]) > 1e-14 else np.sign(state[1])
        part = _integrate_rocking(t, duration, state, sign, base, step)
        times += list(part.t[1:])
        angles += list(part.y[0, 1:])
        t, state = part.t[-1], part.y[:, -1]
        if part.status != 1 or len(part.t_events[1]):
            break
        impacts.append(t)
        state = [0.0, RATIO * state[1] if abs(state[1]) > 1e-4 else 0.0]
    return np.array(times), np.array(angles), impacts


def _integrate_rocking(t, duration, state, sign, base, step):
    """Return the solution (scipy) from a state at time t to impact, overturning or the end."""

    def rates(time, z):
        angle = SLENDER * sign - z[0]
        ratio = base(time) / nml.GRAVITY
        return [z[1], -(RATE**2) * (np.sin(angle) + ratio * np.cos(angle))]

    def impact(_, z):
        return z[0] * sign

    def overturned(_, z):
        return abs(z[0]) - 0.5 * np.pi

    impact.terminal, impact.direction = True, -1
    overturned.terminal = True
    exact = {"rtol": 1e-10, "atol": 1e-13, "max_step": step}
    return solve_ivp(rates, (t, duration), state, events=(impact, overturned), **exact)


def _find_uplift(t, duration, base, step):
    """Return the first time (s) at which |a| > g tan α, and the sense of rotation."""
    while t < duration:
        if abs(base(t)) > nml.GRAVITY * np.tan(SLENDER):
            return t, -np.sign(base(t))
        t += 0.1 * step
    return duration, 1.0


def tower_text(
    time_step, duration, angle=0.0, base=None, penalty=PENALTY, interval=2e-3,
    size=(WIDTH, HEIGHT), modulus=nml.STIFF, restitution=None, **variables,
) -> str:  # fmt: skip
    """Return a block on a stiff base; the acceleration of the base (m/s²) acts as body force."""
    width, height = size
    body = nml.rectangle(-0.5 * width, 0.0, width, height)
    if angle:
        body = nml.rotated(body, -angle, (0.5 * width, 0.0))
    shaking = ""
    if base is not None:
        times = np.arange(0.0, duration + interval, interval)
        values = [*np.trim_zeros(list(map(base, times)), "b"), 0.0]
        shaking = nml.motion("shaking", values, interval)
    motion = {"base_motion_x": "shaking" if shaking else None}
    variables = {"max_displacement_ratio": 0.01} | motion | variables
    return nml.text(
        nml.control(time_step, round(duration / time_step), **variables),
        nml.contact(penalty),
        nml.material("stiff", DENSITY, modulus),
        nml.joint("rough", 75.0, restitution=restitution),
        shaking,
        nml.fixed_block("base", nml.rectangle(-3, -0.5, 6, 0.5), "stiff"),
        nml.block("tower", body, "stiff"),
    )


def run_tower(text: str, angle=0.0, interval=1, limit=0.5 * np.pi - 0.3):
    """Run a rocking block until it has turned by a limit (rad), at which it has overturned.

    Return times (s) and clockwise angles (rad) every `interval` steps, and the energies at the end.
    """
    time, angles = [0.0], [angle]
    with nml.simulation(text) as tower:
        while not tower.done and abs(angles[-1]) < limit:
            tower.advance(interval)
            time.append(tower.time)
            angles.append(angle - tower.coordinates[1, 2])
        return np.array(time), np.array(angles), tower.energies


def _run_audited(time_step, duration, angle=0.0, base=None, penalty=PENALTY):
    """Run a rocking block; return time (s), angle (rad, clockwise) and energy residual / work."""
    text = tower_text(time_step, duration, angle, base, penalty)
    time, angles, energies = run_tower(text, angle, max(1, round(5e-4 / time_step)))
    work = max(abs(energies["gravity"]), abs(energies["input"]), DENSITY * WIDTH * HEIGHT * 1e-2)
    return time, angles, abs(energies["balance"]) / work


@case(
    "Rocking block: free decay with impacts",
    "The equation of motion is θ'' = −p² sin(α sgn θ − θ), p² = 3g/4R. An impact multiplies the"
    " angular velocity by 1 − 1.5 sin² α. A block of 0.5 m x 2 m is released at 0.6 α. With a"
    " penalty of 1e14 N/m and Δt 0.1 ms, an impact ends within a step.",
    "Housner (1963), Bull. Seism. Soc. Am. 53(2).",
)
def rocking_decay(short: bool) -> Outcome:
    """Check the angle until the third impact, within 1 % of the initial angle."""
    angle, duration = 0.6 * SLENDER, 3.0
    time, theory, impacts = housner(duration, angle)
    steps = (1e-4,) if short else (5e-4, 2e-4, 1e-4, 5e-5, 2.5e-5)
    runs = {dt: _run_audited(dt, duration, angle) for dt in steps}
    errors = []
    for run_time, angles, *_ in runs.values():
        is_compared = run_time <= impacts[2]
        difference = angles[is_compared] - np.interp(run_time[is_compared], time, theory)
        errors.append(np.abs(difference).max() / angle)
    run = runs[1e-4]
    impact_times = zero_times(run[0], run[1])
    label = "largest error of the angle until the third impact / initial angle, Δt 0.1 ms"
    rows = [
        at_most(label, errors[steps.index(1e-4)], 1e-2),
        *(relative(f"time of impact {i + 1}", impacts[i], impact_times[i], 1e-2, "s")
          for i in range(3)),
        relative("ratio of angular velocities at the first impact", RATIO, _velocity_ratio(run),
            1e-2),
        at_most("energy residual / work", run[2], 1e-6),
    ]  # fmt: skip
    title = "Largest relative error of the angle until the third impact for several Δt."
    tables = [] if short else [convergence(title, "Δt (s)", steps, errors)]
    return Outcome(rows, _draw_decay(run, time, theory, impacts), tables)


def zero_times(time, angle) -> list[float]:
    """Return the times at which the angle changes its sign, s."""
    index = np.flatnonzero(angle[1:] * angle[:-1] < 0)
    fraction = angle[index] / (angle[index] - angle[index + 1])
    return list(time[index] + fraction * (time[index + 1] - time[index]))


def _velocity_ratio(run) -> float:
    """Return the ratio of angular velocities at the first impact from the amplitudes around it.

    Between impacts, θ'²/2 = p² [cos(α − θmax) − cos α] in the upright position.
    """
    time, angle = run[:2]
    first_impact, second_impact = zero_times(time, angle)[:2]
    amplitude = np.abs(angle[(time > first_impact) & (time < second_impact)]).max()
    energy = np.cos(SLENDER - np.array([angle[0], amplitude])) - np.cos(SLENDER)
    return float(np.sqrt(energy[1] / energy[0]))


def _draw_decay(run, time, theory, impacts):
    figure, (left, right) = canvas(width_ratios=[1, 3])
    draw_blocks(left, [nml.rectangle(-1, -0.2, 2, 0.2)], GROUND)
    block = nml.rectangle(-WIDTH / 2, 0, WIDTH, HEIGHT)
    draw_blocks(left, [nml.rotated(block, -theory[0], (WIDTH / 2, 0))], STONE)
    bare(left)
    right.plot(time, theory / SLENDER, color=INK, lw=3, alpha=0.3, label="Housner")
    right.plot(run[0], run[1] / SLENDER, color=BLUE, lw=1, label="engine, Δt 0.1 ms")
    for impact_time in impacts[:3]:
        right.axvline(impact_time, color="0.75", lw=0.8)
    right.set(xlabel="time (s)", ylabel="θ / α", title="lines: first three impacts")
    return figure


@case(
    "Rocking block: onset",
    "A block lifts off when the acceleration of the base exceeds g tan α (g w/h). The acceleration "
    "increases by 0.5 m/s³ after a second of rest.",
    "Housner (1963).",
)
def rocking_onset(short: bool) -> Outcome:
    """Check the acceleration at which a corner opens."""
    slope, duration = 0.5, 7.0

    def base(t):
        return max(0.0, slope * (t - 1.0))

    lift_off, time, force = 0.0, [], []
    with nml.simulation(tower_text(2e-3, duration, 0.0, base)) as tower:
        owner = np.repeat(np.arange(2), [len(p) for p in tower.polygons])
        left_corner = int(np.flatnonzero(owner == 1)[0])
        while not tower.done:
            tower.advance()
            pressing = _corner_forces(tower.contacts, left_corner)
            if len(pressing) == 2:
                lift_off = tower.time
            time.append(tower.time)
            force.append([pressing.get(left_corner, 0.0), pressing.get(left_corner + 1, 0.0)])
        audit = abs(tower.energies["balance"] / tower.energies["input"])
    limit = nml.GRAVITY * np.tan(SLENDER)
    rows = [relative("acceleration of the base at uplift", limit, base(lift_off), 5e-3, "m/s²")]
    rows.append(at_most("energy residual / input work", audit, 1e-6))
    figure, (axes,) = canvas(1, size=(8, 4))
    for side, label in enumerate(("left corner", "right corner")):
        pushed, kilonewtons = [base(t) for t in time], 1e-3 * np.array(force)[:, side]
        axes.plot(pushed, kilonewtons, label=label, color=COLORS[side])
    axes.axvline(limit, color=RED, ls="--", lw=1, label="g tan α")
    axes.set(xlabel="acceleration of the base (m/s²)", ylabel="normal force (kN/m)")
    axes.set(xlim=(0, 1.2 * limit), ylim=(0, None))
    return Outcome(rows, figure)


def _corner_forces(contacts, first_corner) -> dict[int, float]:
    """Return the normal force (N/m) of each lower corner that is closed, by its vertex."""
    forces: dict[int, float] = {}
    columns = (contacts[name] for name in ("vertex", "normal_force", "state"))
    for vertex, force, state in zip(*columns, strict=True):
        if state and vertex in (first_corner, first_corner + 1):
            forces[int(vertex)] = float(force)
    return forces


@case(
    "Rocking block: overturning under one sine cycle",
    "The base acceleration is one cycle a sin(ω t) with ω/p = 2, 3, 4 and 5. The limit amplitude"
    " is the smallest that overturns the block by Housner's equation (scipy, bisection to 0.1 %)."
    " In the engine, the block must stand 5 % below and fall 5 % above it (penalty 1e13 N/m, Δt"
    " 0.2 ms).",
    "Housner (1963); Zhang & Makris (2001), J. Eng. Mech. 127(5).",
)
def overturning(short: bool) -> Outcome:
    """Check both sides of the overturning boundary."""
    ratios = (3.0,) if short else (2.0, 3.0, 4.0, 5.0)
    rows, histories = [], []
    for ratio in ratios:
        limit = _overturning_amplitude(ratio)
        for side, topples in ((0.95, False), (1.05, True)):
            base, duration = _sine_cycle(side * limit, ratio)
            run = _run_audited(2e-4, duration, 0.0, base, 1e13)
            fell = bool(abs(run[1]).max() > 0.5 * np.pi - 0.3)
            factor_text = f"{side:g} × the limit amplitude {limit / nml.GRAVITY:.3f} g"
            rows.append(yes_or_no(f"overturns at ω/p = {ratio:g}, {factor_text}", topples, fell))
            rows.append(at_most(f"energy residual / work, ω/p = {ratio:g}, {side:g} × the limit",
                run[2], 1e-6))  # fmt: skip
            histories.append((ratio, side, run, housner(duration, 0.0, base)))
        relative_limit = limit / (nml.GRAVITY * np.tan(SLENDER))
        rows.append(at_most(f"limit amplitude / (g tan α) at ω/p = {ratio:g} (not checked)",
            relative_limit, None))  # fmt: skip
    return Outcome(rows, _draw_overturning(histories, len(ratios)))


def _sine_cycle(amplitude, ratio):
    """Return one sine cycle of base acceleration (m/s²) as a function, and the duration (s)."""
    omega = ratio * RATE
    period = 2 * np.pi / omega

    def base(t):
        return amplitude * np.sin(omega * t) if t < period else 0.0

    return base, period + 5.0


def _is_overturned(amplitude, ratio) -> bool:
    """Return whether a sine cycle overturns the block by Housner's equation."""
    base, duration = _sine_cycle(amplitude, ratio)
    _, angle, _ = housner(duration, 0.0, base, step=4e-3)
    return bool(abs(angle).max() > 0.5 * np.pi - 1e-6)


def _overturning_amplitude(ratio) -> float:
    """Return the smallest amplitude of a sine cycle that overturns the block, m/s²."""
    high = 1.02 * nml.GRAVITY * np.tan(SLENDER)
    while not _is_overturned(high, ratio):
        high *= 1.04
    return 0.5 * sum(bisect(lambda a: _is_overturned(a, ratio), high, high / 1.04, 1e-3))


def _draw_overturning(histories, columns):
    figure, axes = canvas(columns, 2, size=(max(6, 3.2 * columns), 5.5))
    for i, (ratio, side, run, theory) in enumerate(histories):
        axis = axes[i // 2 + (i % 2) * columns]
        axis.plot(theory[0], theory[1] / SLENDER, color=INK, lw=3, alpha=0.3, label="Housner")
        axis.plot(run[0], run[1] / SLENDER, color=RED if side > 1 else BLUE, lw=1, label="engine")
        axis.set(title=f"ω/p {ratio:g}, {side:g} of the limit", ylim=(-4, 4))
        axis.set(xlabel="time (s)", ylabel="θ / α")
    return figure


def pulse_duration(width: float, height: float, acceleration: float) -> float:
    """Return the shortest rectangular pulse that overturns a block, s, by the rocking equation.

    With k = a/g, the energy yields ½ θ'² = p² [k (sin α − sin(α − θ)) − cos(α − θ) + cos α].  The
    block overturns if this is at least p² (1 − cos(α − θ)) at the end of the pulse, which is at
    sin(α − θ) = sin α − (1 − cos α)/k.  The duration is t = ∫ dθ/θ'.

    `width`, `height`: m; `acceleration`: acceleration of the floor, above g tan α, m/s².
    """
    slender, rate = _slenderness(width, height)
    ratio = acceleration / nml.GRAVITY
    final_angle = slender - np.arcsin(np.sin(slender) - (1 - np.cos(slender)) / ratio)

    def time_per_root(root):  # θ = root², because θ' starts as √θ
        angle = max(root, 1e-6) ** 2
        half, mean = np.sin(angle / 2), slender - angle / 2
        energy = 2 * half * (ratio * np.cos(mean) - np.sin(mean))  # avoids cancellation
        return 2 * np.sqrt(angle / (2 * energy))

    return quad(time_per_root, 0.0, np.sqrt(final_angle))[0] / rate


def housner_duration(width: float, height: float, acceleration: float) -> float:
    """Return the shortest pulse by Housner, s: cosh pt = 1 + 1/(2 q (q − 1)), q = a/(g tan α)."""
    slender, rate = _slenderness(width, height)
    ratio = acceleration / (nml.GRAVITY * np.tan(slender))
    return float(np.arccosh(1 + 0.5 / (ratio * (ratio - 1))) / rate)


def _slenderness(width, height):
    """Return the slenderness angle α (rad) and frequency parameter p (rad/s) of a block."""
    return np.arctan2(width, height), np.sqrt(1.5 * nml.GRAVITY / np.hypot(width, height))


def pulse_text(width, height, pulse, loading, time_step, duration, **variables) -> str:
    """Return a stiff block under a rectangular pulse (m/s², s) of the floor or as body force.

    The pulse has two samples; it may end within a time step.
    """
    acceleration, lasts = pulse
    base = nml.rectangle(-3, -0.5, 6, 0.5)
    variables["base_motion_x"] = "pulse" if loading == "body force" else None
    return nml.text(
        nml.control(time_step, round(duration / time_step), **variables),
        nml.contact(1e12),
        nml.material("stiff", DENSITY, nml.STIFF),
        nml.joint("rough", 75.0),
        nml.motion("pulse", [acceleration, acceleration], lasts),
        nml.fixed_block("base", base, "stiff", motion_x="pulse" if loading == "floor" else None),
        nml.block("tower", nml.rectangle(-0.5 * width, 0.0, width, height), "stiff"),
    )


def pulse_limit(width, height, acceleration, loading, time_step=1e-3, tolerance=5e-4, **options):
    """Return the shortest pulse (s) that overturns the block, and the largest energy residual.

    Bisection starts between 0.9 and 1.1 of :func:`pulse_duration` and ends at a relative width of
    `tolerance`.  The duration is NaN if the block overturns at 0.9 or does not at 1.1.
    """
    expected = pulse_duration(width, height, acceleration)
    low, high = 0.9 * expected, 1.1 * expected
    slender, rate = _slenderness(width, height)
    audits = []

    def falls(pulse_length):
        pulse, duration = (acceleration, pulse_length), pulse_length + 12 / rate
        text = pulse_text(width, height, pulse, loading, time_step, duration, **options)
        with nml.simulation(text) as tower:
            while not tower.done:
                tower.advance(20)
                rotation = abs(tower.coordinates[1, 2])
                time_after_pulse = tower.time - pulse_length
                is_falling = rotation > 1.3 * slender and time_after_pulse > 0
                if is_falling or (rotation < 0.2 * slender and time_after_pulse > 0.5 / rate):
                    break
            energies = tower.energies
        audits.append(abs(energies["balance"]) / abs(energies["input"]))
        return rotation > slender

    if falls(low) or not falls(high):
        return np.nan, max(audits)
    limit = 0.5 * sum(bisect(falls, high, low, tolerance))
    return limit, max(audits)


@case(
    "Rocking block: overturning under a rectangular pulse",
    "A pulse of 1.5 or 3 g tan α acts as motion of the floor or as body force in the frame of the"
    " floor. The energy integral of the rocking equation yields the shortest duration that"
    " overturns the block. Housner's linear equation for slender blocks is cosh pt = 1 + 1/(2q(q −"
    " 1)) with q = a/(g tan α). Δt is 1 ms; durations are bisected to 0.05 %.",
    "Housner (1963); Zhang & Makris (2001), J. Eng. Mech. 127(5).",
)
def pulses(short: bool) -> Outcome:
    """Check floor and body force within 0.5 %, and slender blocks within 1 % of Housner."""
    shapes = ((0.2, 2.0), (0.3, 2.0)) if short else ((0.2, 2.0), (0.3, 2.0), (0.5, 2.0), (0.4, 1.0))
    rows, table = [], []
    for width, height in shapes:
        slender = np.arctan2(width, height)
        for ratio in (3.0,) if short else (1.5, 3.0):
            acceleration = ratio * nml.GRAVITY * np.tan(slender)
            exact = pulse_duration(width, height, acceleration)
            linear = housner_duration(width, height, acceleration)
            (floor, audit), (force, audit_of_force) = (
                pulse_limit(width, height, acceleration, loading)
                for loading in ("floor", "body force")
            )
            label = f"α = {slender:.3f}, a = {ratio:g} g tan α"
            rows.append(relative(f"{label}: shortest pulse, moving floor", exact, floor, 5e-3, "s"))
            rows.append(relative(f"{label}: shortest pulse, body force; expected: moving floor",
                floor, force, 5e-3, "s"))  # fmt: skip
            if slender <= 0.15:
                rows.append(relative(f"{label}: shortest pulse, moving floor; expected: Housner",
                    linear, floor, 1e-2, "s"))  # fmt: skip
            rows.append(at_most(f"{label}: energy residual / input work",
                max(audit, audit_of_force), 1e-6))  # fmt: skip
            table.append((f"{slender:.3f}", ratio, exact, linear, floor, force))
    heads = ("α", "a/(g tan α)", "exact (s)", "Housner (s)", "floor (s)", "body force (s)")
    tables = [Table("Shortest pulses that overturn the block.", heads, table)]
    return Outcome(rows, _draw_pulse_durations(table), tables)


def _draw_pulse_durations(table):
    figure, (axes,) = canvas(1, size=(8, 4))
    abscissa = np.arange(len(table))
    exact = np.array([row[2] for row in table])
    for column, label, color in ((3, "Housner", INK), (4, "floor", RED), (5, "body force", BLUE)):
        error = 100 * (np.array([row[column] for row in table]) / exact - 1)
        axes.plot(abscissa, error, "o", color=color, label=label, fillstyle="none")
    axes.set_xticks(abscissa, [f"{row[0]}\n{row[1]:g}" for row in table])
    axes.set(xlabel="α, a/(g tan α)", ylabel="difference from the rocking equation (%)")
    return figure
