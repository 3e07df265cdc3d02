# SPDX-License-Identifier: GPL-3.0-or-later
"""Damping of the scheme, waves in bars, a cantilever, and a slipping joint under S waves."""

import numpy as np
from scipy.linalg import eigh

from sitedda.report.style import BLUE, COLORS, GREEN, ORANGE, RED, STONE, canvas, draw_blocks

from .. import model as nml
from ..case import Outcome, Table, absolute, at_most, case, observed_order, relative
from .joints import clipped_sine

DENSITY, YOUNG = 2500.0, 5e9  # kg/m³, Pa
SHEAR = 0.5 * YOUNG  # Pa, ν = 0
PENALTY = 40 * YOUNG  # N/m
SHEAR_RATIO = 2.5  # k_n / k_s
MEMBERS = {  # θ, χ
    "dda": (1.0, 0.5),
    "midpoint": (0.5, 0.5),
    "theta": (0.75, 0.75),
    "backward_euler": (1.0, 1.0),
}
GLUE = {"cohesion": 1e12, "tensile_strength": 1e12}  # Pa


@case(
    "Damping and period of the scheme",
    "Two bonded blocks vibrate against each other, Ω = ωΔt. With D = 1 + θχΩ² the amplification "
    "matrix has the determinant [1 + (1−θ)(1−χ)Ω²]/D and the trace 2 − (θ+χ)Ω²/D. For small Ω the "
    "damping ratio is (θ+χ−1)Ω/2. For DDA, (θ, χ) = (1, ½), it is Ω/4, and modes with Ω > 4 do not "
    "oscillate. A block on a support has θ = χ = 1 in every member, so its vibration decays fast.",
    "`docs/method.md`.",
)
def damping(short: bool) -> Outcome:
    """Check trace and determinant of the amplification matrix, fitted to free vibrations."""
    steps = (0.1, 5.0) if short else (0.01, 0.03, 0.1, 0.3, 1.0, 2.0, 3.9, 5.0, 20.0)
    rows, ratios = [], {}
    for name, member in MEMBERS.items():
        for omega_dt in steps:
            computed = fit_invariants(_run_bonded_blocks(omega_dt, name))
            expected = amplification_invariants(*member, omega_dt)
            rows += _invariant_rows(f"{name}, Ω = {omega_dt:g}", computed, expected)
            ratios[name, omega_dt] = _damping_ratio(*computed)
        for omega_dt in steps[1::2]:
            computed = fit_invariants(_run_supported_block(omega_dt, name))
            label = f"{name}, block on a support, Ω = {omega_dt:g}"
            rows += _invariant_rows(label, computed, amplification_invariants(1.0, 1.0, omega_dt))
    figure, (left, right) = canvas()
    fine = np.geomspace(0.005, 20.0, 300)
    for (name, member), color in zip(MEMBERS.items(), COLORS, strict=False):
        theory = [_damping_ratio(*amplification_invariants(*member, step)) for step in fine]
        right.loglog(fine, theory, color=color, lw=1, label=name)
        right.loglog(steps, [ratios[name, s] for s in steps], "o", color=color, ms=4)
        x = _run_bonded_blocks(5.0, name)
        left.plot(x / np.abs(x).max(), ".-", color=color, lw=0.8, label=name)
    right.set(xlabel="Ω = ωΔt", ylabel="damping ratio ζ", ylim=(1e-3, 1.5))
    right.set_title("lines: closed form")
    left.set(xlabel="step", ylabel="displacement / largest", title="Ω = 5", xlim=(0, 20))
    return Outcome(rows, figure)


def amplification_invariants(theta: float, chi: float, omega_step: float) -> tuple[float, float]:
    """Return trace and determinant of the amplification matrix of a member at Ω = `omega_step`."""
    square = omega_step**2
    denominator = 1 + theta * chi * square
    determinant = (1 + (1 - theta) * (1 - chi) * square) / denominator
    return 2 - (theta + chi) * square / denominator, determinant


def fit_invariants(x: np.ndarray) -> tuple[float, float]:
    """Fit trace and determinant to displacements with x₂ = trace x₁ − determinant x₀."""
    trace, negative = np.linalg.lstsq(np.column_stack([x[1:-1], x[:-2]]), x[2:], rcond=None)[0]
    return float(trace), -float(negative)


def _invariant_rows(label: str, computed, expected) -> list:
    """Return rows that compare trace and determinant with their theoretical values."""
    names = ("trace", "determinant")
    return [
        absolute(f"{name}, {label}", theory, result, 1e-8)
        for name, theory, result in zip(names, expected, computed, strict=True)
    ]


def _free_control(time_step: float, integration: str) -> str:
    """Return ``&control`` with 60 steps without gravity."""
    settings = {"max_displacement_ratio": 1.0, "integration": integration}
    return nml.control(time_step, 60, gravity=(0, 0), **settings)


def _run_bonded_blocks(omega_dt: float, integration: str) -> np.ndarray:
    """Run two bonded rigid blocks that initially separate; return a displacement (m).

    Their relative motion is that of half a mass on the two springs of the joint.
    """
    omega = 100.0
    mass, speed = DENSITY, 1e-3
    text = nml.text(
        _free_control(omega_dt / omega, integration),
        nml.contact(0.25 * mass * omega**2),
        nml.material("up", DENSITY, nml.STIFF, velocity=(0, speed, 0)),
        nml.material("down", DENSITY, nml.STIFF, velocity=(0, -speed, 0)),
        nml.joint("glued", 45.0, **GLUE),
        nml.block("upper", nml.rectangle(0, 0, 1, 1), "up"),
        nml.block("lower", nml.rectangle(0, -1, 1, 1), "down"),
        nml.measured_point("centre", (0.5, 0.5)),
    )
    return nml.history(text).displacement.values[:, 0, 1]


def _run_supported_block(omega_dt: float, integration: str) -> np.ndarray:
    """Run a rigid block with a fixed point at its centre; return its displacement (m)."""
    omega = 100.0
    stiffness = DENSITY * omega**2
    text = nml.text(
        _free_control(omega_dt / omega, integration),
        nml.contact(stiffness / 100, fixed_point_ratio=100.0),
        nml.material("stiff", DENSITY, nml.STIFF, velocity=(1e-3, 0, 0)),
        nml.joint("j", 30),
        nml.fixed_block("block", nml.rectangle(-0.5, -0.5, 1, 1), points=[(0.0, 0.0)]),
        nml.measured_point("centre", (0, 0)),
    )
    return nml.history(text).displacement.values[:, 0, 0]


def _damping_ratio(trace: float, determinant: float) -> float:
    """Return the damping ratio of the two eigenvalues; ``nan`` if they are real."""
    size = np.sqrt(determinant)
    if abs(trace) >= 2 * size:
        return np.nan
    phase, decay = np.arccos(0.5 * trace / size), -np.log(size)
    return float(decay / np.hypot(phase, decay))


@case(
    "P and S waves in a bar",
    "The wave velocity is c = √(M/ρ) at ν = 0. The joint springs are in series, so 1/M = 1/E + "
    "w/(2 k_n h) for P waves and 1/G + w/(2 k_s h) for S waves (two contacts per joint of width w, "
    "spacing h). The travel time of a Gaussian pulse is measured by correlation between two points "
    "60 blocks apart.",
    "A standard case; joint springs in series.",
)
def bars(short: bool) -> Outcome:
    """Check wave speeds and the convergence of their error with the length of the pulse."""
    rows, tables, histories = [], [], {}
    lengths = (40.0,) if short else (10.0, 20.0, 40.0)
    for wave in ("P", "S"):
        expected = _bar_speed(wave)
        errors = []
        for length in lengths:
            data, speed = _run_pulse(wave, length, expected)
            errors.append(abs(speed / expected - 1))
            if length == 40.0:
                histories[wave] = data
                rows.append(relative(f"{wave} wave: velocity, pulse of 40 blocks", expected, speed,
                    2e-3, "m/s"))  # fmt: skip
                rigid_joint_speed = np.sqrt((YOUNG if wave == "P" else SHEAR) / DENSITY)
                rows.append(relative(f"{wave} wave: velocity; expected: rigid joints (not checked)",
                    rigid_joint_speed, speed, None, "m/s"))  # fmt: skip
                rows.append(at_most(f"{wave} wave: energy residual / work",
                    nml.energy_residual(data), 1e-6))  # fmt: skip
        if not short:
            orders = observed_order([1 / length for length in lengths], errors)
            title = f"{wave} wave: relative error of the velocity for several lengths of the pulse."
            heads = ("blocks per pulse length", "error of the velocity", "order in 1/blocks")
            tables.append(Table(title, heads, list(zip(lengths, errors, orders, strict=True))))
    figure, axes = canvas()
    for axes_of_wave, (wave, data) in zip(axes, histories.items(), strict=True):
        axis = 0 if wave == "S" else 1
        for point, color in (("near", BLUE), ("far", ORANGE)):
            series = 1e6 * data.displacement.sel(point=point).isel(axis=axis)
            axes_of_wave.plot(1e3 * data.time, series, color=color, label=point)
        axes_of_wave.set(xlabel="time (ms)", ylabel="displacement (µm)",
            title=f"{wave} wave, 60 m apart")  # fmt: skip
    return Outcome(rows, figure, tables)


def _bar_speed(wave: str) -> float:
    """Return the wave speed (m/s) with joint springs in series; h = w = 1 m."""
    modulus = YOUNG if wave == "P" else SHEAR
    stiffness = PENALTY if wave == "P" else PENALTY / SHEAR_RATIO
    return float(np.sqrt(1 / (1 / modulus + 1 / (2 * stiffness)) / DENSITY))


def _column_text(
    count: int, joints: list[str], materials: list[str], direction: str, upright: bool
) -> str:
    """Return stacked blocks of 1 m x 1 m; the lowest follows the motion "wave" along `direction`.

    If `upright`, fixed points at mid-height prevent rotations of the blocks.
    """
    text = []
    for i in range(count):
        text.append(nml.block(f"b{i}", nml.rectangle(0, i, 1, 1), materials[i], joints[i]))
        if i == 0:
            motion = {f"motion_{direction}": "wave"}
            text += [nml.group("fixed_point", x=x, y=0.5, block="b0", **motion) for x in (0.0, 1.0)]
        elif upright:
            fixed = {"y": i + 0.5, "block": f"b{i}", "direction": "y"}
            text += [nml.group("fixed_point", x=x, **fixed) for x in (0.0, 1.0)]
    return "".join(text)


def _run_pulse(wave: str, length: float, speed: float):
    """Run a Gaussian pulse with 2σ of `length` blocks; return history and wave speed (m/s)."""
    count = 100 + round(2 * length)
    sigma = length / speed / 4
    step = 0.1 / speed
    duration = (90 + 2 * length) / speed
    samples = np.arange(0.0, duration, sigma / 20)
    pulse = 1e-6 * np.exp(-0.5 * ((samples - 5 * sigma) / sigma) ** 2)
    names, axis = (["glued"] * count, ["rock"] * count), "y" if wave == "P" else "x"
    text = nml.text(
        nml.control(step, round(duration / step), gravity=(0, 0)),
        nml.contact(PENALTY),
        nml.material("rock", DENSITY, YOUNG),
        nml.joint("glued", 45.0, **GLUE),
        nml.motion("wave", pulse, sigma / 20, "displacement"),
        _column_text(count, *names, axis, wave == "S"),
        nml.measured_point("near", (0.5, 10.5)),
        nml.measured_point("far", (0.5, 70.5)),
    )
    data = nml.history(text)
    u = data.displacement.isel(axis=0 if wave == "S" else 1)
    lag = _delay_samples(u.sel(point="near").values, u.sel(point="far").values)
    return data, 60.0 / (lag * step)


def _delay_samples(first: np.ndarray, second: np.ndarray) -> float:
    """Return the delay (samples) of the second series, at the peak of the correlation."""
    size = 2 ** int(np.ceil(np.log2(2 * len(first))))
    product = np.fft.irfft(np.fft.rfft(second, size) * np.conj(np.fft.rfft(first, size)), size)
    top = int(np.argmax(product[: len(first)]))
    a, b, c = product[top - 1 : top + 2]
    return top + 0.5 * (a - c) / (a - 2 * b + c)


@case(
    "Cantilever of glued blocks",
    "The first frequency is 0.5596 √(EI/(ρ A L⁴)). First-order blocks do not bend, so only the"
    " joints allow bending. Two springs k_n at the edges of a joint of width w, at intervals h,"
    " yield EI = k_n w² h/2. The expected frequency is that of the chain of rigid blocks and joint"
    " springs (eigenvalues, scipy). Its limit for many blocks is the Euler–Bernoulli beam.",
    "A standard case; the stiffness of the joint springs is derived here.",
)
def cantilever(short: bool) -> Outcome:
    """Check the first frequency of 10 blocks and its convergence to the continuum."""
    counts = (10,) if short else (10, 20, 40)
    beam = float(0.5596 * np.sqrt(YOUNG / 12 / (DENSITY * 10.0**4)))
    rows, lines = [], []
    for count in counts:
        frequency, theory, shape, data = _run_cantilever(count)
        if count == 10:
            rows = [
                relative("first frequency of 10 blocks; expected: chain of joints", theory,
                    frequency, 2e-3, "Hz"),
                relative("first frequency of 10 blocks; expected: continuous beam (not checked)",
                    beam, frequency, None, "Hz"),
                at_most("energy residual / work", nml.energy_residual(data), 1e-6),
            ]  # fmt: skip
            first_case = shape, data
        lines.append((count, frequency, theory, beam, abs(frequency / beam - 1)))
    orders = observed_order([1 / count for count in counts], [line[-1] for line in lines])
    lines = [(*line, order) for line, order in zip(lines, orders, strict=True)]
    head = ("blocks", "engine", "chain of joints", "beam", "relative difference to beam", "order")
    table = Table("First frequency (Hz) for several numbers of blocks.", head, lines)
    figure, (left, right) = canvas(width_ratios=[2, 3])
    shape, data = first_case
    bent = [nml.rectangle(i, -0.5, 1, 1) + [0, 2.5 * shape[3 * i + 1]] for i in range(10)]
    draw_blocks(left, [nml.rectangle(-1, -0.5, 1, 1)], "0.7")
    draw_blocks(left, bent, STONE)
    left.set_title("first mode (offsets of the blocks)", fontsize=10)
    tip = data.displacement.sel(point="tip").isel(axis=1)
    right.plot(data.time, 1e6 * tip, color=BLUE)
    right.set(xlabel="time (s)", ylabel="tip (µm)", title="free vibration in the first mode")
    return Outcome(rows, figure, [] if short else [table])


def _joint_stiffness(count: int) -> float:
    """Return k_n (N/m) that gives the chain the EI of a beam 1 m wide: E w³/12 = k_n w² h/2."""
    return YOUNG / (6 * 10.0 / count)


def _chain_mode(count: int) -> tuple[float, np.ndarray]:
    """Return the first frequency (Hz) and mode (u, v, r) of rigid blocks with joint springs."""
    h, stiffness_k = 10.0 / count, _joint_stiffness(count)
    stiffness = np.zeros((3 * count, 3 * count))
    for i in range(count):
        for y in (-0.5, 0.5):
            normal, shear = np.zeros(3 * count), np.zeros(3 * count)
            normal[3 * i : 3 * i + 3], shear[3 * i : 3 * i + 3] = (1, 0, -y), (0, 1, -0.5 * h)
            if i:
                normal[3 * i - 3 : 3 * i] = (-1, 0, y)
                shear[3 * i - 3 : 3 * i] = (0, -1, -0.5 * h)
            stiffness += stiffness_k * np.outer(normal, normal)
            stiffness += stiffness_k / SHEAR_RATIO * np.outer(shear, shear)
    mass = DENSITY * h * np.tile([1.0, 1.0, (1 + h**2) / 12], count)
    values, shapes = eigh(stiffness, np.diag(mass), subset_by_index=[0, 0])
    return float(np.sqrt(values[0]) / (2 * np.pi)), shapes[:, 0] / np.abs(shapes[:, 0]).max()


def _run_cantilever(count: int):
    """Run the first mode; return its frequency, the theoretical one (Hz), mode and history."""
    theory, shape = _chain_mode(count)
    h, cycles = 10.0 / count, 4
    step = 1 / theory / 400
    velocities = 1e-4 * shape.reshape(count, 3)
    text = [
        nml.control(step, cycles * 400, gravity=(0, 0)),
        nml.contact(_joint_stiffness(count), fixed_point_ratio=1e4),
        nml.material("wall", DENSITY, nml.STIFF),
        nml.joint("glued", 45.0, **GLUE),
        nml.fixed_block("wall", nml.rectangle(-h, -0.5, h, 1), "wall"),
        nml.measured_point("tip", (10.0, 0.0), f"b{count - 1}"),
    ]
    for i, velocity in enumerate(velocities):
        text.append(nml.material(f"m{i}", DENSITY, nml.STIFF, velocity=velocity))
        text.append(nml.block(f"b{i}", nml.rectangle(i * h, -0.5, h, 1), f"m{i}"))
    data = nml.history("".join(text))
    tip = data.displacement.sel(point="tip").isel(axis=1).values
    crossings = np.flatnonzero(tip[1:-1] * tip[2:] < 0) + 1
    zeros = crossings + tip[crossings] / (tip[crossings] - tip[crossings + 1])
    return 0.5 * (len(zeros) - 1) / ((zeros[-1] - zeros[0]) * step), theory, shape, data


@case(
    "A joint that slips under harmonic S waves",
    "The joint transmits the incident stress τ(t) = ρ c v up to its strength ± τ_s, at which it"
    " slips. The transmitted wave is τ clipped at ± τ_s; the reflected wave is the difference. R²"
    " and T² are the ratios of reflected and transmitted energy to the incident energy, and A ="
    " √(1 − R² − T²). Energies are integrated over a period at one wavelength from the joint. A run"
    " without slip yields the incident wave after the same distance, including the numerical"
    " damping.",
    "Miller (1978), Bull. Seism. Soc. Am. 68.",
)
def slip_joint(short: bool) -> Outcome:
    """Check transmission, reflection and absorption for ratios of incident stress to strength."""
    ratios = (3.0,) if short else (1.25, 1.5, 2.0, 3.0, 5.0, 8.0)
    per_wave = 20 if short else 40
    reference, strength = _run_slip_joint(0.5, per_wave)
    incident = _energy_flux(reference, "above", per_wave)
    arriving = _incident_stress_ratio(reference, strength, per_wave) / 0.5
    rows, lines, sample_run = [], [], None
    for ratio in ratios:
        data, _ = _run_slip_joint(ratio, per_wave)
        transmitted = _energy_flux(data, "above", per_wave) / incident / (ratio / 0.5) ** 2
        velocity, incoming = (_point_velocity(run, "below") for run in (data, reference))
        square = _squared_velocity(velocity - ratio / 0.5 * incoming, data, per_wave)
        reflected = square / incident / (ratio / 0.5) ** 2
        coefficients = np.sqrt([transmitted, reflected, max(0.0, 1 - transmitted - reflected)])
        expected = clipped_sine(1 / (ratio * arriving))
        for name, a, b in zip(("T", "R", "A"), expected, coefficients, strict=True):
            label = f"coefficient {name}, τ/τ_s = {ratio * arriving:.3f}"
            rows.append(absolute(label, a, b, 1e-2))
        lines.append((ratio * arriving, *coefficients))
        sample_run = sample_run if sample_run and ratio != 3.0 else (data, ratio)
    return Outcome(rows, _draw_slipping_joint(lines, sample_run, strength, per_wave))


def _incident_stress_ratio(reference, strength: float, per_wave: int) -> float:
    """Return incident stress at the joint / its strength, from the run without slip.

    It is the geometric mean of two points, because the scheme attenuates the wave.
    """
    squares = [_energy_flux(reference, point, per_wave) for point in ("below", "above")]
    period = per_wave / _bar_speed("S")
    samples = np.count_nonzero(_energy_samples(reference, period))
    amplitude = np.sqrt(2 * np.sqrt(squares[0] * squares[1]) / samples)
    return float(DENSITY * _bar_speed("S") * amplitude / strength)


def _energy_samples(data, period: float) -> np.ndarray:
    """Return whether each sample belongs to the period in which energies are integrated."""
    return (data.time.values > 5.5 * period) & (data.time.values <= 6.5 * period)


BELOW, ABOVE, WEAK = 3, 4, 1 / 30  # wavelengths below, above; normal stress of the weak joint


def _run_slip_joint(ratio: float, per_wave: int):
    """Run an incident stress of `ratio` × strength; return history and strength of the joint (Pa).

    Blocks have fixed vertical positions and initial stresses (`_initial_pressures`); the normal
    stress of the weak joint is 1/30 of that of other joints.
    """
    count, weak, stress = (BELOW + ABOVE) * per_wave, BELOW * per_wave, 1e6
    strength = stress * WEAK * np.tan(np.radians(30.0))
    speed = _bar_speed("S")
    period, steps = per_wave / speed, 1000
    time = np.linspace(0, 8 * period, 801)
    amplitude = ratio * strength / (DENSITY * speed) * period / (2 * np.pi)
    wave = amplitude * (1 - np.cos(2 * np.pi * time / period))
    pressures = _initial_pressures(count, weak, stress)
    text = nml.text(
        nml.control(period / steps, 7 * steps, gravity=(0, 0)),
        nml.contact(PENALTY, fixed_point_ratio=1e4),
        *(nml.material(f"m{i}", DENSITY, YOUNG, initial_stress=(0.0, -pressure, 0.0))
          for i, pressure in enumerate(pressures)),
        nml.joint("rough", 30.0),
        nml.motion("wave", wave, period / 100, "displacement"),
        _column_text(count, ["rough"] * count, [f"m{i}" for i in range(count)], "x", True),
        nml.measured_point("below", (0.5, weak - per_wave + 0.5)),
        nml.measured_point("above", (0.5, weak + per_wave + 0.5)),
        nml.group("output", history_interval=10),
    )  # fmt: skip
    return nml.history(text), strength


def _initial_pressures(count: int, weak: int, stress: float) -> np.ndarray:
    """Return the initial pressure (Pa) of each block for the required joint stresses.

    Joint j between blocks j and j+1 has the force F_j = k_n h (ε_j + ε_j+1) of two contacts.  A
    block is in equilibrium if its stress is −(F_below + F_above)/2w = −p + E ε.
    """
    force = np.full(count - 1, stress)
    force[weak - 1] = WEAK * stress
    strain = np.empty(count)
    strain[weak - 1 : weak + 1] = 0.5 * force[weak - 1] / PENALTY
    for i in range(weak - 2, -1, -1):
        strain[i] = force[i] / PENALTY - strain[i + 1]
    for i in range(weak + 1, count):
        strain[i] = force[i - 1] / PENALTY - strain[i - 1]
    forces = np.concatenate([[0.0], force, [0.0]])
    return 0.5 * (forces[:-1] + forces[1:]) + YOUNG * strain


def _point_velocity(data, point: str) -> np.ndarray:
    return data.velocity.sel(point=point).isel(axis=0).values


def _squared_velocity(velocity, data, per_wave: int) -> float:
    """Return Σ v² over the period of `_energy_samples`, (m/s)²."""
    period = per_wave / _bar_speed("S")
    return float(np.sum(velocity[_energy_samples(data, period)] ** 2))


def _energy_flux(data, point: str, per_wave: int) -> float:
    """Return Σ v² of a point, to which the energy of the wave is proportional."""
    return _squared_velocity(_point_velocity(data, point), data, per_wave)


def _draw_slipping_joint(lines, sample_run, strength, per_wave):
    figure, (left, right) = canvas()
    data, ratio = sample_run
    period = per_wave / _bar_speed("S")
    stress = DENSITY * _bar_speed("S") * _point_velocity(data, "above") / strength
    cycles = data.time / period
    incident = ratio * np.sin(2 * np.pi * cycles) * (cycles > BELOW + 1)
    left.plot(cycles, incident, color="0.7", label="incident")
    left.plot(cycles, stress, color=BLUE, label="transmitted, engine")
    for side in (-1, 1):
        left.axhline(side, color=RED, lw=0.8, ls="--")
    left.set(xlabel="time / period", ylabel="τ / τ_s", title=f"τ/τ_s = {ratio:g}", xlim=(3.5, 7))
    fine = np.geomspace(1.001, 12, 60)
    theory = np.array([clipped_sine(1 / x) for x in fine])
    computed = np.array(lines)
    for i, (name, color) in enumerate((("T", BLUE), ("R", ORANGE), ("A", GREEN))):
        right.semilogx(fine, theory[:, i], color=color, lw=1)
        right.semilogx(computed[:, 0], computed[:, i + 1], "o", color=color, label=name)
    right.set(xlabel="τ / τ_s", ylabel="coefficient", title="lines: theory, points: engine")
    return figure
