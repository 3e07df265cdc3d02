# SPDX-License-Identifier: GPL-3.0-or-later
"""Members of the time integration: energies, transfer functions, and motion of supports."""

from itertools import product
from typing import NamedTuple

import numpy as np

from sitedda.engine.checking import transfer
from sitedda.engine.records import read_record
from sitedda.engine.spectra import amplification, find_peak
from sitedda.facade.run import run
from sitedda.report.style import BLUE, COLORS, INK, RED, canvas

from .. import model as nml
from ..case import Outcome, Table, absolute, at_most, case, relative
from .packing import pile_text
from .rocking import SLENDER, tower_text
from .settlement import PENALTIES, TIME_STEPS, wall_text
from .sliding import record_file, recorded

OTHERS = ("midpoint", "theta", "backward_euler")  # members other than DDA
ROCK = (2643.0, 4.788e9, 0.25)  # table I of the paper: kg/m³, Pa, Poisson's ratio
GLUE = {"cohesion": 1e12, "tensile_strength": 1e12}  # Pa
PENALTY = 300.0  # penalty over E × 1 m
WIDTH = 15.0  # width of the layers, m


def column_text(
    layers, rock, steps, shaking, height=None, penalty=None, body=None, **variables
) -> str:
    """Return layers on a base block that follows the motion "shaking" along x.

    `rock`: density (kg/m³), Young's modulus (Pa), Poisson's ratio.
    `steps`: time step (s) and number of steps.
    `shaking`: group ``&motion``.
    `height`: total height, m; default: 1 m per layer.
    `penalty`: N/m; default: `PENALTY` × Young's modulus × 1 m.
    `body`: other variables of ``&material``.
    `variables`: other variables of ``&control``.
    """
    points = [(x, y) for y in (-0.25, -0.75) for x in (2.5, 12.5)]
    height = float(height or layers)
    return nml.text(
        nml.control(*steps, gravity=(0, 0), **variables),
        nml.contact(penalty or PENALTY * rock[1]),
        nml.material("rock", *rock, **(body or {})),
        nml.joint("glued", 50.0, **GLUE),
        shaking,
        nml.fixed_block("base", nml.rectangle(0, -1, WIDTH, 1), points=points, motion_x="shaking"),
        nml.group("layers", name="layer", width=WIDTH, thickness=height / layers, count=layers),
        nml.measured_point("base", (WIDTH / 2, -0.5), "base"),
        nml.measured_point("surface", (WIDTH / 2, height)),
        nml.group("amplification", surface="surface", base="base", lowest=1.0, highest=25.0),
    )


def soil_column_text(time_step: float, duration: float, **variables) -> str:
    """Return 30 layers of soil of 1 m, V_s = 350 m/s, under the shipped record."""
    density, speed, poisson = 1900.0, 350.0, 0.3
    young = 2 * (1 + poisson) * density * speed**2
    steps = (time_step, round(duration / time_step))
    return column_text(30, (density, young, poisson), steps, recorded("shaking"), **variables)


def _surface_and_base(history) -> tuple[np.ndarray, np.ndarray]:
    """Return the accelerations of surface and base along x, m/s²."""
    values = history.acceleration.isel(axis=0)
    return values.sel(point="surface").values, values.sel(point="base").values


@case(
    "Supports without ringing",
    "A fixed point is a spring k and a dashpot (1 − χ) k Δt, whose velocity is relative to the "
    "motion at the end of the step. Both roots are those of backward Euler, so a base of any "
    "stiffness follows its motion for any Δt. The peak amplification by time stepping is compared "
    "with the exact discrete transfer function. The acceleration of the base is compared with the "
    "record averaged over each step.",
    "`docs/method.md`.",
)
def supports(short: bool) -> Outcome:
    """Check amplification and base motion with time steps far above 4/ω of the supports."""
    duration = 45.0  # s, 10 s longer than the record
    site = (2.29e-3, 4e-3, 5e-3, 7e-3, 10e-3)  # time steps, s; the layers of the paper use 1 ms
    texts = {f"table I, Δt {1e3 * dt:g} ms":
             column_text(15, ROCK, (dt, round(duration / dt)), recorded("shaking"))
             for dt in site}  # fmt: skip
    for member in ("theta", "backward_euler", "dda"):
        text = soil_column_text(10e-3, duration, integration=member)
        texts[f"soil, {member}, Δt 10 ms"] = text
    rows, histories = [], {}
    for name, text in texts.items():
        history, curve, peak = with_transfer(text)
        base, record, residual_motion = base_and_record(history)
        record_peak, base_peak = abs(record).max(), abs(base).max()
        rows += [
            relative(f"{name}: largest amplification", curve[1], peak.amplitude, 1e-4),
            absolute(f"{name}: frequency of the largest amplification", curve[0], peak.frequency,
                2e-3, "Hz"),
            relative(f"{name}: peak acceleration of the base", record_peak, base_peak, 0.03,
                "m/s²"),
            at_most(f"{name}: base acceleration, rms after the record / peak in the run",
                residual_motion, 1e-6),
        ]  # fmt: skip
        histories[name] = history.time.values[1:], base, record
    return Outcome(rows, _draw_supports(histories))


def with_transfer(text: str):
    """Run an input; return its history, the exact peak (Hz, amplitude) and the peak of the run."""

    def largest(low, high):
        frequency = np.linspace(low, high, 401)
        values = abs(transfer(file, frequency))
        best = int(np.argmax(values))
        return float(frequency[best]), float(values[best])

    with nml.temporary_input(text) as file:
        history = run(file).history
        frequency_estimate = largest(1.5, 20.0)[0]
        exact = largest(frequency_estimate - 0.06, frequency_estimate + 0.06)
    step = float(history.time[1] - history.time[0])
    frequency, ratio = amplification(*_surface_and_base(history), step, 8)
    return history, exact, find_peak(frequency, abs(ratio), 1.5, 20.0)


def base_and_record(history):
    """Return accelerations of base and record, and rms after the record / peak of the base.

    The accelerations (m/s²) are means over each time step.
    """
    time, base = history.time.values, _surface_and_base(history)[1][1:]
    record = read_record(record_file(), format="smc", unit="cm/s2")
    velocity = np.interp(time, record.time.values, record.velocity.values, right=0.0)
    is_later = time[1:] > float(record.time[-1]) + 10 * (time[1] - time[0])
    residual_motion = np.sqrt(np.mean(base[is_later] ** 2)) / abs(base).max()
    return base, np.diff(velocity) / np.diff(time), residual_motion


def _draw_supports(histories):
    figure, axes = canvas(2, size=(12, 4.2))
    name = list(histories)[-1]
    time, base, record = histories[name]
    axes[0].plot(time, record, color=INK, lw=2.5, alpha=0.3, label="record, averaged over Δt")
    axes[0].plot(time, base, color=BLUE, lw=0.8, label="base")
    axes[0].set(xlabel="time (s)", ylabel="acceleration (m/s²)", xlim=(5, 15), title=name)
    for (label, (t, b, _)), color in zip(histories.items(), COLORS * 2, strict=False):
        axes[1].semilogy(t, np.maximum(abs(b) / abs(b).max(), 1e-18), color=color, lw=0.5)
        axes[1].plot([], [], color=color, label=label)
    axes[1].set(xlabel="time (s)", ylabel="|acceleration of the base| / peak", xlim=(30, None))
    axes[1].legend(frameon=False, fontsize=8)
    return figure


CHANGES = {  # variables of &control
    "dda": {"integration": "dda"},
    "theta": {"integration": "theta"},
    "theta = 0.6": {"integration": "theta", "theta": 0.6},
    "5 % at 42 Hz": {"integration": "theta", "damping_ratio": 0.05, "damping_frequency": 42.0},
    "backward_euler": {"integration": "backward_euler"},
}
BAND = (5.0, 150.0)  # Hz


def transfer_error(changes: dict) -> tuple:
    """Return the largest relative error of a transfer function by time stepping over `BAND`.

    Five layers of rock are excited by a short pulse.  The ratio of the spectra of two points is
    compared with `sitedda.transfer`.

    Result: error, frequency (Hz), amplification by time stepping, and exact amplification.
    """
    step = 1e-3
    time = np.arange(0.0, 0.06, step)
    pulse = np.exp(-0.5 * ((time - 0.03) / 0.0025) ** 2) * np.sin(2 * np.pi * 60 * (time - 0.03))
    shaking = nml.motion("shaking", pulse, step)
    with nml.temporary_input(column_text(5, ROCK, (step, 3000), shaking, **changes)) as file:
        frequency, computed = amplification(*_surface_and_base(run(file).history), step, 1)
        in_band = (frequency >= BAND[0]) & (frequency <= BAND[1])
        frequency, computed = frequency[in_band], computed[in_band]
        exact = transfer(file, frequency)
    return float((abs(computed - exact) / abs(exact)).max()), frequency, abs(computed), abs(exact)


class Audited(NamedTuple):
    """Energies of a run / exchanged energy."""

    gain: float  # largest increase of the total energy since the start
    growth: float  # largest increase of the total energy in a step
    lowest: float  # smallest change of the total energy since the start
    residual: float  # largest residual of the energy budget
    time: np.ndarray  # s
    total: np.ndarray  # change of the total energy since the start


def audited(text: str, interval: int = 1) -> Audited:
    """Run an input in which only gravity does work, and return its energies.

    The exchanged energy is the largest work of gravity or kinetic energy.
    """
    time, total, balance, exchanged = [0.0], [0.0], [0.0], 0.0
    with nml.simulation(text) as model:
        while not model.done:
            model.advance(interval)
            energies = model.energies
            time.append(model.time)
            total.append(nml.energy_gain(energies))
            balance.append(abs(energies["balance"]))
            exchanged = max(exchanged, abs(energies["gravity"]), energies["kinetic"])
    relative = np.array(total) / exchanged
    worst = (relative.max(), np.diff(relative).max(), relative.min(), max(balance) / exchanged)
    return Audited(*worst, np.array(time), relative)


def collision_text(time_step: float, **variables) -> str:
    """Return a slightly rotated block that hits a fixed block at 1 m/s and rebounds."""
    flying = nml.rectangle(0.011, 0.0, 1.0, 1.0) @ np.array([[1.0, 0.02], [-0.02, 1.0]])
    variables |= {"gravity": (0, 0), "max_displacement_ratio": 0.02}
    return nml.text(
        nml.control(time_step, round(0.5 / time_step), **variables),
        nml.contact(40 * 5e9),
        nml.material("still", 2500.0, nml.STIFF),
        nml.material("flying", 2500.0, 5e9, 0.2, velocity=(-1.0, 0.0, 0.0)),
        nml.joint("dry", 30.0),
        nml.fixed_block("wall", nml.rectangle(-1.03, -1.0, 1.0, 3.0), "still"),
        nml.block("stone", flying, "flying"),
    )


def _energy_texts(integration: str, short: bool) -> dict[str, tuple[str, int]]:
    """Return inputs by name, with the number of steps between evaluations of energy."""
    member = {"integration": integration}
    sizes = (50,) if short else (50, 200)
    steps = TIME_STEPS[:2] if short else TIME_STEPS
    texts = {}
    for size, penalty, dt in product(sizes, PENALTIES[::3], steps):
        text = wall_text(size, penalty, dt, 100 if short else 200, **member)
        texts[f"wall of {size}, {penalty:g} E, Δt {dt:g} s"] = text, 1
    texts["rocking block"] = tower_text(5e-4, 2.0 if short else 3.0, 0.6 * SLENDER, **member), 1
    texts["collision"] = collision_text(1e-3, **member), 1
    count, columns, duration = (60, 8, 1.2) if short else (300, 25, 3.0)
    texts[f"{count} polygons"] = pile_text(count, columns, duration, **member), 5
    return texts


@case(
    "Members of the time integration: energy and transfer functions",
    "If θ, χ ≥ ½, no member gains energy, even if contacts open and close: ΔE = −(θ−½) dᵀKd − "
    "(χ−½) ΔvᵀMΔv − the loss of contacts and supports. Each is a term of the budget. In steady "
    "vibration a member is exactly equivalent to the complex modulus K (1 + i(2θ−1)τ)(1 + "
    "i(2χ−1)τ) at the frequency 2τ/Δt, τ = tan(ωΔt/2).",
    "`docs/method.md`.",
)
def integration(short: bool) -> Outcome:
    """Check energies and transfer functions of each member."""
    rows, lines, last_audits, curves = [], [], {}, {}
    for name in OTHERS:
        texts = _energy_texts(name, short)
        audits = {label: audited(*text) for label, text in texts.items()}
        for quantity, index in (("gain", 0), ("gain in a step", 1), ("residual", 3)):
            worst = max(audits, key=lambda key, index=index, audits=audits: audits[key][index])
            rows.append(at_most(f"{name}: largest energy {quantity} / exchanged energy ({worst})",
                audits[worst][index], 1e-6))  # fmt: skip
        lines += [(name, label, *audit[:4]) for label, audit in audits.items()]
        last_audits[name] = list(audits.values())[-1]
    for label, changes in CHANGES.items():
        error, *curves[label] = transfer_error(changes)
        rows.append(at_most(f"largest relative error of the transfer function, {label}", error,
            2e-3))  # fmt: skip
    head = ("member", "model", "gain", "gain in a step", "lowest", "residual")
    table = Table("Energy / exchanged energy.", head, lines)
    return Outcome(rows, _draw_energies_and_transfer(last_audits, curves), [table])


def _draw_energies_and_transfer(audits, curves):
    figure, (left, right) = canvas(2, size=(12, 4.2))
    for (name, computed), color in zip(audits.items(), COLORS, strict=False):
        left.plot(computed.time, computed.total, color=color, label=name)
    left.axhline(0, color=RED, lw=0.8, ls="--")
    label = "energy gain / exchanged energy"
    left.set(xlabel="time (s)", ylabel=label, title="falling polygons")
    for (name, (frequency, computed, exact)), color in zip(curves.items(), COLORS, strict=False):
        right.semilogy(frequency, exact, color=color, lw=2.5, alpha=0.3)
        right.semilogy(frequency, computed, color=color, lw=0.8, label=name)
    right.set(xlabel="frequency (Hz)", ylabel="surface / base acceleration", title="pale: exact")
    right.legend(frameon=False, fontsize=8)
    return figure
