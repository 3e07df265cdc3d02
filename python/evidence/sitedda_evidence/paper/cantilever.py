# SPDX-License-Identifier: GPL-3.0-or-later
"""The cantilever of the paper: kinetic and algorithmic damping, and penalty (figures 2 to 6)."""

from functools import cache

import numpy as np
from scipy.signal import find_peaks

from sitedda.engine.scheme import Scheme
from sitedda.facade.run import run
from sitedda.report.style import BLUE, COLORS, GREY, RED, small_axes

from ..case import Outcome, picture, study
from ..comparison import per_cent
from ..runs import Task, input_file
from .discrete import DiscreteModel
from .measure import first_mode_decay

_INPUT = "cantilever.nml"
_END_OF_LOAD = 0.02  # end of the impulse, printed with figure 4, s
_STEPS = (1e-5, 1e-4)  # time steps of figure 5, s
_PENALTIES = (1, 10, 40, 100)  # penalties over Young's modulus; figure 6 shows 1E to 100E
_YOUNG = 4.788e9  # Young's modulus of the input, Pa
_FORCES = (1e3, 1e4, 1e5)  # peak forces of the impulse in the sensitivity study, N
_SAMPLING = 1e-4  # interval of stored samples, s
_LONG_DURATION = 3.0  # duration with the softest penalty, whose frequency is low, s


def tasks(quick: bool = False) -> list[Task]:
    """Return the runs of the study; `quick` omits those not needed for the requirements."""
    cases = [("step", step, {"time_step": step, "duration": 2.0}) for step in _STEPS]
    cases.append(("kinetic", 0.99, {"dynamic_factor": 0.99, "duration": 0.5}))
    for factor in _PENALTIES:
        changes = {"contact": {"normal_stiffness": factor * _YOUNG},
                   "duration": _LONG_DURATION if factor == 1 else 2.0}  # fmt: skip
        cases.append(("penalty", factor, changes))
    if not quick:
        for force in _FORCES:
            load = {"force_y": [0.0, -force, 0.0]}
            cases.append(("force", force, {"load": load, "time_step": 1e-4, "duration": 0.5}))
    return [
        Task((kind, value), _run_cantilever, {"changes": changes}, changes["duration"] * 2)
        for kind, value, changes in cases
        if (kind, value) != ("penalty", 40)  # the same as the run of the smaller time step
    ]


def _run_cantilever(changes: dict) -> dict:
    """Run the input with changes; return time (s) and displacement of the tip (m)."""
    interval = round(_SAMPLING / changes.get("time_step", _STEPS[0]))
    history = run(input_file(_INPUT), history_interval=interval, **changes).history
    tip = history.displacement.sel(point="tip").isel(axis=1).values
    return {"time": history.time.values, "tip": tip}


@cache
def _discrete_model(penalty: float = 40) -> DiscreteModel:
    return DiscreteModel.of(input_file(_INPUT), contact={"normal_stiffness": penalty * _YOUNG})


def kinetic_damping_roots(omega: float, time_step: float, factor: float) -> np.ndarray:
    """Return the two eigenvalues of a time step with kinetic damping.

    `omega`: rad/s; `time_step`: Δt, s; `factor`: the dynamic factor g, by which the velocity is
    multiplied; 0.99 is 1 % kinetic damping.
    """
    # coefficients of z², z, 1 of the equation for x with x1 = x0 + d, v1 = 2d/Δt - g v0
    inertia, square = 2 / time_step**2, omega**2
    return np.roots([inertia + square, square * factor - inertia * (1 + factor), inertia * factor])


def _linear_tip_displacement(model: DiscreteModel, time, time_step: float, factor: float = 1.0):
    """Return the tip displacement (m) of the linear discrete model under the impulse."""
    steps = round(time[-1] / time_step)
    force = np.interp(time_step * np.arange(1, steps + 1), [0.0, 0.01, 0.02], [0.0, -1e4, 0.0])
    row = model.row(model.loads[0], axis=1)
    tip = np.concatenate([[0.0], model.response_to_force(row, row, force, time_step, factor)])
    return tip[np.rint(time / time_step).astype(int)]


def _measure_decrement(result: dict, model: DiscreteModel):
    """Return the logarithmic decrement of the tip in the free vibration after the impulse."""
    free = result["time"] > _END_OF_LOAD
    first, second = model.frequencies[:2]
    time, tip = result["time"][free], result["tip"][free]
    return first_mode_decay(time, tip, first, np.sqrt(first * second))


@study("Cantilever: damping and penalty (section 2.1, figures 2–6)", tasks)
def cantilever(runs: dict) -> Outcome:
    """Compose rows, requirements and pictures from the runs."""
    outcome = Outcome(text=_describe_study())
    runs[("penalty", 40)] = runs[("step", 1e-5)]
    worst = _add_damping_rows(outcome, runs)
    _add_kinetic_row(outcome, runs)
    worst = max(worst, _add_penalty_rows(outcome, runs))
    _add_sensitivity_rows(outcome, runs)
    outcome.require(
        "Damping ratios of the decaying vibration differ from the closed form by at most 1 %"
        f" ({len(_STEPS) + len(_PENALTIES)} cases)", worst <= 0.01,
        f"largest difference {per_cent(worst)}")  # fmt: skip
    outcome.pictures = [
        picture("cantilever_fig4", "Figure 4: full dynamic analysis and 1 % kinetic damping.",
                _draw_kinetic_damping, runs),
        picture("cantilever_fig5", "Figure 5: algorithmic damping at two time steps; dashed: closed"
                " form of the first mode.", _draw_time_steps, runs),
        picture("cantilever_fig6", "Figure 6: frequency, largest displacement and damping ratio"
                " for several penalties.", _draw_penalties, runs),
    ]  # fmt: skip
    return outcome


def _describe_study() -> list[str]:
    """Return the paragraphs on model and theory."""
    model = _discrete_model()
    beam = _beam_frequency()
    return [
        "Ten blocks of 1 m × 1 m are clamped at the left end. A triangular impulse of 0.02 s acts"
        " at the free end. The paper prints neither material nor impulse, so the input uses the"
        " rock of Table I and 10 kN.",
        "Blocks of constant strain do not bend, so only the joints allow bending. The two corner"
        " springs of a joint have the rotational stiffness k·w²/2. With soft joints the first"
        f" frequency is proportional to √k ({model.frequencies[0]:.2f} Hz at k = 40 E). With stiff"
        f" joints it tends to that of a shear beam, √(G/ρ)/4L = {_shear_frequency():.2f} Hz. The"
        f" frequency of a bending beam, 0.5596 √(EI/ρAL⁴) = {beam:.2f} Hz, would require k = E/6."
        " Figure 6 shows this as “frequency increasing with penalty”.",
    ]


def _beam_frequency() -> float:
    """Return the first frequency of an Euler–Bernoulli cantilever of 10 m × 1 m, Hz."""
    inertia, length, density = 1 / 12, 10.0, 2643.0
    return 0.5596 * np.sqrt(_YOUNG * inertia / (density * length**4))


def _shear_frequency() -> float:
    """Return the first frequency of the cantilever in pure shear, √(G/ρ)/4L, Hz."""
    return np.sqrt(_YOUNG / 2.5 / 2643.0) / 40.0


def _add_damping_rows(outcome: Outcome, runs: dict) -> float:
    """Compare both time steps with figure 5; return the largest error of the damping ratio."""
    model = _discrete_model()
    omega = model.omega[0]
    worst = 0.0
    for step in _STEPS:
        decay = _measure_decrement(runs[("step", step)], model)
        free = Scheme().vibration(omega / 2 / np.pi, step)
        theory = float(free.damping)
        worst = max(worst, abs(decay.damping_exact / theory - 1))
        outcome.compare(
            f"damping ratio at Δt = {step:g} s", "Fig. 5, eq. 11", None, theory,
            decay.damping_exact,
            "closed form ln(1/|λ|)/|ln λ| ≈ ωΔt/4 at the first frequency of K x = ω² M x;"
            f" eq. 11, which is linear in ζ, yields {decay.damping:.4g}")  # fmt: skip
        outcome.compare(f"frequency at Δt = {step:g} s (Hz)", "Fig. 5", None,
                        float(omega / 2 / np.pi / (1 + free.elongation)), decay.frequency,
                        f"from {decay.times.size - 1} periods", 5)  # fmt: skip
    results = [runs[("step", step)] for step in _STEPS]
    amplitudes = [abs(r["tip"][(r["time"] >= 1.9) & (r["time"] <= 2.0)]).max() for r in results]
    expected = np.exp(-1.9 * omega**2 / 4 * (_STEPS[1] - _STEPS[0]))
    outcome.compare(
        "amplitude after 1.9 s: ratio of Δt = 1e-4 s to 1e-5 s", "Fig. 5",
        "very significant attenuation", float(expected), float(amplitudes[1] / amplitudes[0]),
        "theory: exp(-ω²Δt t/4) of the first mode; the run with the smaller step also contains"
        " higher modes", 3)  # fmt: skip
    return worst


def _add_kinetic_row(outcome: Outcome, runs: dict) -> None:
    """Compare the motion with 1 % kinetic damping, Δt = 1e-5 s, with figure 4."""
    result, full = runs[("kinetic", 0.99)], runs[("step", 1e-5)]
    roots = kinetic_damping_roots(_discrete_model().omega[0], 1e-5, 0.99)
    slow = float(-np.log(abs(roots).max()) / 1e-5)
    interval = (result["time"] > 0.1) & (result["time"] < 0.4)
    time, tip = result["time"][interval], result["tip"][interval]
    rate = float(-np.polyfit(time, np.log(abs(tip)), 1)[0])
    outcome.compare(
        "motion with 1 % kinetic damping, Δt = 1e-5 s", "Fig. 4", "totally damped",
        "overdamped: both eigenvalues real" if np.isreal(roots).all() else "oscillates",
        "returns without oscillation" if np.ptp(np.sign(tip)) == 0 else "oscillates",
        "a factor of 0.99 on the velocity in each of 100,000 steps per second is a decay rate of"
        f" {-np.log(0.99) / 1e-5:.0f}/s")  # fmt: skip
    outcome.compare("decay rate of the displacement with 1 % kinetic damping (1/s)", "Fig. 4", None,
                    slow, rate, "", 4)  # fmt: skip
    outcome.compare("largest displacement: ratio of 1 % kinetic damping to full dynamic analysis",
                    "Fig. 4", None, _theoretical_peak_ratio(),
                    float(abs(result["tip"]).max() / abs(full["tip"]).max()),
                    "linear model integrated step by step", 4)  # fmt: skip


def _theoretical_peak_ratio() -> float:
    """Return the ratio of largest tip displacements with 1 % kinetic damping and without."""
    time = np.arange(5001) * _SAMPLING
    damped, full = (abs(_linear_tip_displacement(_discrete_model(), time, 1e-5, factor)).max()
                    for factor in (0.99, 1.0))  # fmt: skip
    return float(damped / full)


def _add_penalty_rows(outcome: Outcome, runs: dict) -> float:
    """Compare results for several penalties with figure 6; return the largest damping error."""
    worst = 0.0
    for factor in _PENALTIES:
        model, result = _discrete_model(factor), runs[("penalty", factor)]
        omega, decay = model.omega[0], _measure_decrement(result, model)
        theory = float(Scheme().vibration(omega / 2 / np.pi, 1e-5).damping)
        worst = max(worst, abs(decay.damping_exact / theory - 1))
        tip = _linear_tip_displacement(model, result["time"], 1e-5)
        results = f"at k = {factor} E"
        outcome.compare(f"frequency {results} (Hz)", "Fig. 6", None, float(omega / 2 / np.pi),
            decay.frequency, "discrete theory K x = ω² M x", 5)  # fmt: skip
        outcome.compare(f"damping ratio {results}", "Fig. 6", None, theory, decay.damping_exact)
        outcome.compare(f"largest displacement {results} (mm)", "Fig. 6", None,
            1e3 * float(abs(tip).max()), 1e3 * float(abs(result["tip"]).max()))  # fmt: skip
    soft, stiff = (_measure_decrement(runs[("penalty", f)], _discrete_model(f)) for f in (1, 100))
    ratio = stiff.damping_exact / stiff.frequency / (soft.damping_exact / soft.frequency)
    outcome.compare("damping ratio / frequency: ratio of k = 100 E to k = E", "Fig. 6",
                    "no obvious effect", 1.0, ratio,
                    "ζ = ωΔt/4 does not depend on the penalty, only on the frequency"
                    f" (×{stiff.frequency / soft.frequency:.1f})")  # fmt: skip
    outcome.notes.append("“The penalty has no obvious effect on damping” is true only"
        " for a given frequency. From k = E to 100 E the frequency increases by the"
        f" factor {stiff.frequency / soft.frequency:.2f}. The damping ratio increases"
        f" from {per_cent(soft.damping_exact)} to {per_cent(stiff.damping_exact)},"
        " which is invisible in a plot of a few cycles at 1e-5 s.")  # fmt: skip
    return worst


def _add_sensitivity_rows(outcome: Outcome, runs: dict) -> None:
    """Compare impulses of several sizes, and add notes on other materials."""
    forces = [force for kind, force in runs if kind == "force"]
    if forces:
        compliance = [abs(runs[("force", f)]["tip"]).max() / f for f in forces]
        outcome.compare(
            "sensitivity: relative range of displacement / force for impulses of 1 to 100 kN",
            "assumed", None, 0.0, float(np.ptp(compliance) / np.mean(compliance)),
            "the response is proportional to the impulse", 2)  # fmt: skip
    omega = _discrete_model().omega[0]
    for name, scale in (("limestone of Avdat (17 GPa, 2250 kg/m³)", 17e9 / 2250),
                        ("hard rock (50 GPa, 2500 kg/m³)", 50e9 / 2500)):  # fmt: skip
        scaled = omega * np.sqrt(scale / (_YOUNG / 2643.0))
        damping = Scheme().vibration(scaled / 2 / np.pi, 1e-4).damping
        outcome.notes.append(
            f"Sensitivity to the material: for {name} and the same k/E the frequency is"
            f" {scaled / 2 / np.pi:.1f} Hz. The damping ratio at Δt = 1e-4 s is"
            f" {per_cent(float(damping))}. All frequencies are proportional to √(E/ρ), and the"
            " damping ratio to the frequency."
        )


def _draw_kinetic_damping(drawing, runs) -> None:
    with small_axes(drawing, 1, 2, size=(7.6, 3.3), width_ratios=[1, 2.6]) as (load, tip):
        load.plot([0, 10, 20, 40], [0, 10, 0, 0], color=GREY)
        load.set(xlabel="time (ms)", ylabel="F (kN, downwards)", title="Fig. 3, assumed force")
        full, damped = runs[("step", 1e-5)], runs[("kinetic", 0.99)]
        interval = full["time"] <= 0.5
        time, motion = full["time"][interval], 1e3 * full["tip"][interval]
        tip.plot(time, motion, color=BLUE, label="full dynamic")
        style = {"color": RED, "label": "1 % kinetic damping"}
        tip.plot(damped["time"], 1e3 * damped["tip"], "--", **style)
        tip.axvline(_END_OF_LOAD, color="0.6", lw=0.8, ls=":")
        tip.set(xlabel="time (s)", ylabel="v of the free end (mm)", xlim=(0, 0.5), title="Fig. 4")
        tip.legend(loc="upper right", ncols=2)
        tip.set_ylim(top=1.35 * 1e3 * full["tip"].max())


def _draw_time_steps(drawing, runs) -> None:
    omega = _discrete_model().omega[0]
    with small_axes(drawing, 2, 1, size=(7.2, 4.6), sharex=True, sharey=True) as axes:
        for axis, step, color in zip(axes, _STEPS, COLORS, strict=False):
            result = runs[("step", step)]
            thin = round(1e-3 / _SAMPLING)
            time, tip = result["time"][::thin], 1e3 * result["tip"][::thin]
            axis.plot(time, tip, color=color, lw=0.8, label=f"Δt = {step:g} s")
            fine_tip = runs[("step", 1e-5)]["tip"]
            crests = fine_tip[find_peaks(fine_tip, height=0.5 * fine_tip.max())[0][:5]]
            envelope = 1e3 * np.median(crests) * np.exp(-(omega**2) * step / 4 * time)
            for sign in (1, -1):
                axis.plot(time, sign * envelope, "--", color="0.25", lw=1)
            axis.set(ylabel="v (mm)", xlim=(0, 2))
            axis.legend(loc="upper right", bbox_to_anchor=(1, 1.22))
        axes[1].set_xlabel("time (s)")


def _draw_penalties(drawing, runs) -> None:
    decays = [_measure_decrement(runs[("penalty", f)], _discrete_model(f)) for f in _PENALTIES]
    lines = np.geomspace(1, 100, 30)
    omegas = np.array([_discrete_model(float(k)).omega[0] for k in lines])
    with small_axes(drawing, 1, 3, size=(8.4, 3.0)) as (low, middle, high):
        low.loglog(lines, omegas / 2 / np.pi, color=RED, lw=1, label="discrete theory")
        low.loglog(_PENALTIES, [d.frequency for d in decays], "o", color=BLUE, label="sitedda")
        low.axhline(_shear_frequency(), color="0.6", ls=":", lw=1, label="shear beam, √(G/ρ)/4L")
        low.set(ylabel="frequency (Hz)")
        middle.legend(*low.get_legend_handles_labels(), loc="upper right")
        largest = [1e3 * abs(runs[("penalty", f)]["tip"]).max() for f in _PENALTIES]
        middle.loglog(_PENALTIES, largest, "o-", color=BLUE, lw=0.8)
        middle.set(ylabel="largest displacement (mm)")
        high.loglog(lines, Scheme().vibration(omegas / 2 / np.pi, 1e-5).damping, color=RED, lw=1)
        high.loglog(_PENALTIES, [d.damping_exact for d in decays], "o", color=BLUE)
        high.set(ylabel="damping ratio, Δt = 1e-5 s")
        for axis in (low, middle, high):
            axis.set(xlabel="penalty / E (m)")
