# SPDX-License-Identifier: GPL-3.0-or-later
"""Damping of materials: free decay, and a layered site with the complex modulus of SHAKE."""

import numpy as np

from sitedda.engine.checking import transfer
from sitedda.engine.damping import ConstantRatio, Rayleigh
from sitedda.facade.run import run
from sitedda.output.response import amplifications
from sitedda.report.style import COLORS, canvas
from sitedda.site.column import Column, Layer

from .. import model as nml
from ..case import Outcome, Row, absolute, at_most, case, relative
from .integration import ROCK, column_text
from .sliding import recorded

DENSITY = 2000.0  # kg/m³
REFERENCE = 14.2  # Hz
STIFF_JOINTS = 1e6  # penalty of stiff joints over E × 1 m
HEIGHT = 15.0  # height of the layers of table I, m
FREQUENCIES = np.linspace(1.0, 25.0, 241)  # Hz
# Peaks of table I by damping ratio, from another program: amplification and frequency (Hz) on a
# rigid base with the midpoint rule, Δt = 1 ms
PEAKS = {0.01: (66.073, 13.950), 0.05: (13.2507, 13.964), 0.10: (6.6820, 14.014)}


@case(
    "Free decay of a damped block",
    "A free square block vibrates in shear, ω² = 24 G/(ρa²). With the constant ratio ζ, the "
    "damping ratio from its logarithmic decrement is sin(½π γ/(1 − γ)), γ = atan(2ζ)/π. This "
    "exceeds ζ of steady vibration, because the motion decays. Rayleigh damping yields "
    "α/(2ω) + βω/2.",
    "Kjartansson (1979), Constant Q wave propagation and attenuation; `docs/damping.md`.",
)
def free_decay(short: bool) -> Outcome:
    """Check the damping ratio of a free block from its decrement."""
    rows = []
    figure, (left, right) = canvas()
    ratios, frequencies = ((0.05,), (2.0,)) if short else ((0.01, 0.05, 0.1), (0.5, 2.0, 10.0))
    for ratio, color in zip(ratios, COLORS, strict=False):
        for frequency in frequencies:
            body = {"damping_ratio": ratio, "reference_frequency": frequency}
            time, strain, residual = _simulate_free_decay(frequency, body)
            measured = _decay_ratio(time, strain)
            exponent = 2 / np.pi * np.arcsin(measured)
            converted = 0.5 * np.tan(np.pi * exponent / (1 + exponent))
            gamma = np.arctan(2 * ratio) / np.pi
            label = f"ζ {100 * ratio:g} %, {frequency:g} Hz"
            decay = np.sin(0.5 * np.pi * gamma / (1 - gamma))
            rows += [
                relative(f"{label}: damping ratio from the decrement", decay, measured, 0.01),
                relative(f"{label}: ζ converted from the decrement", ratio, converted, 0.01),
                at_most(f"{label}: energy residual / work", residual, 1e-6),
            ]
        left.plot(time * frequency, strain / abs(strain).max(), color=color, lw=0.9, label=label)
    rayleigh = Rayleigh.at(0.05, (2.0, 12.0))
    tested = (1.0, 24.0) if short else (1.0, 2.0, 4.9, 12.0, 24.0)
    values = {"rayleigh_alpha": rayleigh.alpha, "rayleigh_beta": rayleigh.beta}
    measured = []
    for frequency in tested:
        omega = 2 * np.pi * frequency
        exact = 0.5 * (rayleigh.alpha / omega + rayleigh.beta * omega)
        time, strain, residual = _simulate_free_decay(frequency, values)
        measured.append(_decay_ratio(time, strain))
        rows += [
            relative(f"Rayleigh, {frequency:g} Hz: damping ratio", exact, measured[-1], 0.005),
            at_most(f"Rayleigh, {frequency:g} Hz: energy residual / initial energy", residual,
                1e-6),
        ]  # fmt: skip
    fine = np.geomspace(0.7, 35.0, 200)
    right.semilogx(fine, rayleigh.ratio_at(fine), label="α/(2ω) + βω/2")
    right.semilogx(tested, measured, "o", label="free decay")
    right.set(xlabel="frequency (Hz)", ylabel="damping ratio", title="Rayleigh, 5 % at 2 and 12 Hz")
    left.set(xlabel="periods", ylabel="shear strain / largest", title="constant ratio")
    return Outcome(rows, figure)


def _simulate_free_decay(frequency: float, damping: dict) -> tuple[np.ndarray, np.ndarray, float]:
    """Return times (s) and shear strain of a free block, and the relative energy residual."""
    shear = (2 * np.pi * frequency) ** 2 * DENSITY / 24
    step, steps = 1 / (400 * frequency), 2800
    text = nml.text(
        nml.control(step, steps, gravity=(0, 0), integration="midpoint"),
        nml.contact(40 * shear),
        nml.material("soil", DENSITY, 2 * shear, **damping),
        nml.joint("none", 30.0),
        nml.block("square", nml.rectangle(0, 0, 1, 1)),
    )
    strain = [0.0]
    with nml.simulation(text) as free:
        rates = np.zeros((1, 6))
        rates[0, 5] = 1e-6 * frequency
        free.rates = rates
        for _ in range(steps):
            free.advance()
            strain.append(float(free.coordinates[0, 5]))
        energies = free.energies
    residual = abs(energies["balance"]) / energies["initial"]
    return step * np.arange(steps + 1), np.array(strain), residual


def _decay_ratio(time: np.ndarray, strain: np.ndarray) -> float:
    """Return the damping ratio from swings between extremes, independent of the mean."""
    inner = abs(strain[1:-1])
    extremes = np.flatnonzero((inner > abs(strain[:-2])) & (inner >= abs(strain[2:]))) + 1
    y0, y1, y2 = (strain[extremes + k] for k in (-1, 0, 1))
    swings = abs(np.diff(y1 + (y0 - y2) ** 2 / (8 * (2 * y1 - y0 - y2))))
    count = np.arange(swings.size)
    selected = (count >= 1) & (swings > 0.05 * swings[0])
    slope = -np.polyfit(count[selected], np.log(swings[selected]), 1)[0]  # per half period
    return float(slope / np.hypot(np.pi, slope))


@case(
    "A layered site with the same damping at all frequencies",
    "The layers of Table I have a constant damping ratio; the midpoint rule has no numerical "
    "damping. Peaks of `transfer` and of time stepping under a record are compared with an "
    "independent program. The transfer function with stiff joints and thin layers is compared with "
    "the one-dimensional column of the same complex modulus.",
    "Schnabel, Lysmer & Seed (1972), SHAKE; `docs/damping.md`.",
)
def material_damping(short: bool) -> Outcome:
    """Check peaks by transfer function and time stepping, and curves of the column."""
    rows: list[Row] = []
    figure, (left, right) = canvas()
    steps = (2e-3,) if short else (1e-3, 2e-3)
    for ratio, color in zip((0.05,) if short else PEAKS, COLORS, strict=False):
        amplitude, frequency = PEAKS[ratio]
        for step in steps:
            label = f"ζ {100 * ratio:g} %, Δt {1e3 * step:g} ms"
            peak, stepped_peak, residual, curve = _transfer_peaks(ratio, step)
            # the midpoint rule lowers frequencies: tan(ωΔt/2)/Δt is the same at 1 ms
            warped = np.tan(np.pi * frequency * 1e-3) / 1e-3
            frequency_at_step = np.arctan(warped * step) / (np.pi * step)
            rows += [
                relative(f"{label}: largest amplification by `transfer`", amplitude, peak[0], 5e-4),
                absolute(f"{label}: frequency of the peak by `transfer`", frequency_at_step,
                    peak[1], 5e-3, "Hz"),
                relative(f"{label}: largest amplification by time stepping", amplitude,
                    stepped_peak[0], 3e-3),
                absolute(f"{label}: frequency of the peak by time stepping", frequency_at_step,
                    stepped_peak[1], 0.02, "Hz"),
                at_most(f"{label}: energy residual / work", residual, 1e-6),
            ]  # fmt: skip
            left.plot(*curve, color=color, lw=0.9, label=label)
    layers = 30 if short else 120
    for ratio, color in zip((0.05,) if short else (0.01, 0.05, 0.1), COLORS, strict=False):
        frequencies, engine, column, hysteretic = _compare_transfer_functions(ratio, layers)
        label = f"ζ {100 * ratio:g} %"
        difference = abs(abs(engine) / abs(column) - 1).max()
        rows.append(at_most(f"{label}: largest relative difference from the column", difference,
            5e-3))  # fmt: skip
        difference_at_peak = abs(abs(engine).max() / abs(hysteretic).max() - 1)
        rows.append(at_most(f"{label}: relative difference of the peak from K (1 + 2iζ)",
            difference_at_peak, 5e-3))  # fmt: skip
        worst = _rayleigh_error(ratio, layers)
        label_rayleigh = f"{label}, Rayleigh: largest relative difference from SHAKE91, 1–25 Hz"
        rows.append(at_most(label_rayleigh, worst, 5e-3))
        right.semilogy(frequencies, abs(engine), color=color, label=label)
        right.semilogy(frequencies, abs(hysteretic), "k:", lw=0.9)
    left.set(xlabel="frequency (Hz)", ylabel="amplification", title="time stepping, Table I")
    right.set(xlabel="frequency (Hz)", title="stiff joints; dotted: hysteretic column")
    return Outcome(rows, figure)


def _transfer_peaks(ratio: float, time_step: float):
    """Return peaks by `transfer` and by time stepping, energy residual, and the stepped curve."""
    body = {"damping_ratio": ratio, "reference_frequency": REFERENCE}
    text = column_text(15, ROCK, (time_step, round(60 / time_step)), recorded("shaking"), body=body,
                       penalty=1.5e12, integration="midpoint")  # of Table I  # fmt: skip
    with nml.temporary_input(text) as file:
        fine = np.linspace(13.5, 14.5, 10001)
        curve = abs(transfer(file, fine))
        history = run(file).history
    amplification = amplifications(history)[0]
    peak = (float(curve.max()), float(fine[curve.argmax()]))
    stepped_peak = (amplification.peak.amplitude, amplification.peak.frequency)
    curve = (amplification.frequency, amplification.ratio)
    return peak, stepped_peak, nml.energy_residual(history), curve


def _compare_transfer_functions(ratio: float, layers: int):
    """Return frequencies (Hz) and transfer functions of stiff stack, column and SHAKE."""
    engine = _stiff_stack_transfer(layers, damping_ratio=ratio, reference_frequency=REFERENCE)
    column = _uniform_column(ConstantRatio(ratio, REFERENCE)).transfer(FREQUENCIES)
    hysteretic = _uniform_column(ratio, convention="shake").transfer(FREQUENCIES)  # K (1 + 2iζ)
    return FREQUENCIES, engine, column, hysteretic


def _rayleigh_error(ratio: float, layers: int) -> float:
    """Return the largest relative error of a stack with Rayleigh damping, compared with SHAKE91.

    Rayleigh damping has its minimum, the ratio, at ω slightly above the first mode.  Like the
    modulus of SHAKE91, it does not change the stiffness.
    """
    omega = 2 * np.pi * REFERENCE * (1 + ratio)
    rayleigh = {"rayleigh_alpha": ratio * omega, "rayleigh_beta": ratio / omega}
    engine = _stiff_stack_transfer(layers, **rayleigh)
    exact = _uniform_column(ratio, convention="shake91").transfer(FREQUENCIES)
    return float(abs(abs(engine) / abs(exact) - 1).max())


def _uniform_column(damping, **options) -> Column:
    """Return the rock of table I as a column of one layer."""
    density, young, poisson = ROCK
    shear = young / (2 * (1 + poisson))
    return Column([Layer(HEIGHT, density=density, shear_modulus=shear, damping=damping)], **options)


def _stiff_stack_transfer(layers: int, **body: float):
    """Return the transfer function of layers of the rock of table I with stiff joints."""
    static = nml.motion("shaking", np.zeros(3), 1.0)
    text = column_text(layers, ROCK, (1e-4, 10), static, HEIGHT, STIFF_JOINTS * ROCK[1], body,
                       integration="midpoint")  # fmt: skip
    with nml.temporary_input(text) as file:
        return transfer(file, FREQUENCIES)
