# SPDX-License-Identifier: GPL-3.0-or-later
"""The shear wave of the paper in a stack of layers (figures 7 to 11, equations 12 to 17)."""

from functools import cache

import numpy as np
from scipy.signal import correlate

from sitedda.facade.run import run
from sitedda.report import Picture
from sitedda.report.style import BLUE, COLORS, GREY, INK, RED, small_axes

from ..case import Outcome, picture, study
from ..comparison import per_cent
from ..runs import Task, input_file
from .discrete import DiscreteModel
from .measure import sub_sample_maximum

_INPUT = "shear_wave.nml"
_PERIOD = 0.004  # only wave period that the paper prints (in its discussion), s
_DENSITY, _POISSON, _SIZE, _WIDTH = 2643.0, 0.25, 1.0, 15.0  # values of the input
_DISTANCE = 14.5  # distance from the base block, which fixed points make rigid, to M1, m
_RATIOS = (4, 8, 16, 32, 64)  # λ/Δx: ratios of the paper, and 64
_WIDE_STACK = {"width": 60.0, "penalty": 400.0, "ratios": (32, 64, 128)}  # study of longer waves
_PAPER_RATIOS = (4, 8, 16, 32)  # λ/Δx of the paper
_STEPS = (1e-5, 1e-4)  # time steps of figure 9, s
_AMPLITUDE = 1e-3  # m
_PENALTY = 100.0  # penalty over Young's modulus
_PENALTIES = (1.0, 10.0, 40.0, 100.0, 300.0, 1000.0)  # penalties over Young's modulus
_RECORDED_PERIODS = 1.25  # recorded periods after the arrival of the wave, before reflections
_PERIODS = (0.004, 0.01, 0.02)  # periods of the sensitivity study, s
_SPEED_RATIO = 32  # λ/Δx in the measurement of wave speed


def tasks(quick: bool = False) -> list[Task]:
    """Return the runs of the study; `quick` omits those not needed for the requirements."""
    cases = [("triangle", r, s, _PENALTY, _PERIOD) for r in _RATIOS for s in _STEPS]
    cases += [("sine", r, s, _PENALTY, _PERIOD) for r in _PAPER_RATIOS for s in _STEPS]
    if not quick:
        cases += [("sine", _SPEED_RATIO, 1e-5, p, _PERIOD) for p in _PENALTIES]
        cases += [("triangle", 32, s, _PENALTY, p) for s in _STEPS for p in _PERIODS[1:]]
        cases += [_wide_stack_case(r, s) for r in _WIDE_STACK["ratios"] for s in _STEPS]
    return [Task(case, _run_case, {"case": case}, _run_time_estimate(case))
            for case in dict.fromkeys(cases)]  # fmt: skip


def _wide_stack_case(ratio: int, time_step: float) -> tuple:
    """Return the case of a wide stack with the same joint stiffness per metre of width."""
    return ("wide triangle", ratio, time_step, _WIDE_STACK["penalty"], _PERIOD)


def _run_time_estimate(case: tuple) -> float:
    """Return the estimated computing time of a case, s."""
    _, ratio, step, _, period = case
    return _case_duration(ratio, period) / step * 2e-4


def _case_duration(ratio: float, period: float) -> float:
    """Return the simulated time until `_RECORDED_PERIODS` after the arrival of the wave, s."""
    return (1.3 * _DISTANCE / (ratio * _SIZE) + 1 + _RECORDED_PERIODS) * period


def _young_modulus(ratio: float, period: float) -> float:
    """Return Young's modulus for a wavelength of ratio × Δx by eq. 17: λ = T √(G/ρ)."""
    return 2 * (1 + _POISSON) * _DENSITY * (ratio * _SIZE / period) ** 2


def _incident_motion(shape: str, period: float) -> tuple[np.ndarray, float]:
    """Return samples of the incident motion (m) and their interval (s)."""
    spacing = period / 400
    phase = np.arange(401) / 400
    if shape == "sine":
        return _AMPLITUDE * np.sin(2 * np.pi * phase), spacing
    return _AMPLITUDE * (1 - abs(2 * phase - 1)), spacing


def _width_changes(shape: str) -> dict:
    """Return the changes of the input for a wide stack."""
    return {"layers[*].width": _WIDE_STACK["width"]} if shape.startswith("wide") else {}


def wave_changes(case: tuple) -> dict:
    """Return the changes of the input for a case: shape, λ/Δx, Δt (s), penalty/E, period (s)."""
    shape, ratio, step, penalty, period = case
    values, spacing = _incident_motion(shape, period)
    young = _young_modulus(ratio, period)
    return _width_changes(shape) | {
        "time_step": step,
        "duration": _case_duration(ratio, period),
        "contact": {"normal_stiffness": penalty * young},
        "material": {"young_modulus": young},
        "motion": {"values": values.tolist(), "time_step": spacing},
    }


def _run_case(case: tuple) -> dict:
    """Run a case; return time (s) and displacements of base and M1 along x (m)."""
    history = run(input_file(_INPUT), **wave_changes(case)).history
    sideways = history.displacement.isel(axis=0)
    interval = {name: sideways.sel(point=name).values for name in ("base", "M1")}
    return interval | {"time": history.time.values}


@cache
def _stack_model(penalty: float = _PENALTY, shape: str = "") -> DiscreteModel:
    """Return the stack in units of the period: λ/Δx = 1 and T = 1 s."""
    young = _young_modulus(1.0, 1.0)
    return DiscreteModel.of(input_file(_INPUT), contact={"normal_stiffness": penalty * young},
                            material={"young_modulus": young}, **_width_changes(shape))  # fmt: skip


@cache
def _exact_motion(case: tuple, samples: int, point: str = "M1") -> np.ndarray:
    """Return the displacement of a point by exact discrete theory at each step of a run, m.

    Times are scaled by the period.
    """
    shape, ratio, step, penalty, period = case
    model = _stack_model(penalty, shape if shape.startswith("wide") else "")
    values, spacing = _incident_motion(shape, period)
    time, given = step * np.arange(samples), spacing * np.arange(values.size)
    motion = np.interp(time, given, values)
    rate = np.interp(time, given, _engine_velocity(values, spacing), right=0.0)
    rate, step = rate * period / ratio, step * ratio / period
    return np.append(0.0, model.response_to_motion(model.row(point), motion, rate, step))


def _engine_velocity(values: np.ndarray, spacing: float) -> np.ndarray:
    """Return the velocity at samples of a displacement, by the finite differences of the engine."""
    slope = np.gradient(values, spacing, edge_order=2)
    slope[2:-2] = (values[:-4] - 8 * values[1:-3] + 8 * values[3:-1] - values[4:]) / (12 * spacing)
    slope[[0, -1]] = 0.0
    return slope


def _continuum_loss(ratio: float, time_step: float, period: float) -> float:
    """Return the fraction of amplitude that a triangular pulse loses in a continuous column.

    The factor exp(-ω²Δt x/4v) of the scheme is a convolution with a Gaussian of variance Δt x/2v.
    It reduces the peak of a triangle with slopes 2A/T by A √(4 Δt x / (π T λ)).
    """
    return float(np.sqrt(4 * time_step * _DISTANCE / (np.pi * period * ratio * _SIZE)))


def _speed_fraction(penalty: float) -> float:
    """Return speed of long waves / √(G/ρ), with springs in series with the layers."""
    shear = 1 / (2 * (1 + _POISSON))
    return float(1 / np.sqrt(1 + shear * _WIDTH / (2 * penalty / 2.5 * _SIZE)))


def _amplitude_error(result: dict) -> float:
    """Return the relative error of the peak at M1 by eq. 16."""
    return abs(_AMPLITUDE - result["M1"].max()) / _AMPLITUDE


def _theoretical_error(case: tuple, result: dict) -> float:
    """Return the amplitude error of exact discrete theory for a run."""
    return _amplitude_error({"M1": _exact_motion(case, result["time"].size)})


@study("Shear wave: block size, time step and penalty (section 2.2, figures 7–11)", tasks)
def shear_wave(runs: dict) -> Outcome:
    """Compose rows, requirements and pictures from the runs."""
    outcome = Outcome(text=[
        f"A base block and 100 layers of 1 m × 15 m; M1 lies {_DISTANCE:g} m above the base block."
        f" The period is {_PERIOD:g} s; density and number of interfaces per metre are constant."
        " The shear modulus determines the wavelength (eq. 17); the penalty is 100 E. The paper"
        " prints neither period nor distance nor the values of figure 9.",
        "“Theory” is the exact solution of the discrete equations in modal coordinates, with the"
        " time steps of the scheme.",
    ])  # fmt: skip
    _add_amplitude_rows(outcome, runs)
    _add_step_rows(outcome, runs)
    _add_shape_rows(outcome, runs)
    _add_speed_rows(outcome, runs)
    _add_period_rows(outcome, runs)
    _add_width_rows(outcome, runs)
    outcome.pictures = _make_pictures(runs)
    return outcome


def _add_amplitude_rows(outcome: Outcome, runs: dict) -> None:
    """Compare the errors of the amplitude with figure 9."""
    for step in _STEPS:
        errors = []
        for ratio in _RATIOS:
            case = ("triangle", ratio, step, _PENALTY, _PERIOD)
            errors.append(_amplitude_error(runs[case]))
            loss = 100 * _continuum_loss(ratio, step, _PERIOD)
            outcome.compare(
                f"amplitude error of the triangular wave, λ/Δx = {ratio}, Δt = {step:g} s (%)",
                "Fig. 9, eq. 16" if ratio in _PAPER_RATIOS else "beyond Fig. 9", None,
                100 * _theoretical_error(case, runs[case]), 100 * errors[-1],
                f"continuous column: {loss:.2f} %")  # fmt: skip
        decreases = bool(np.all(np.diff(errors) < 0))
        error_at_32 = errors[_RATIOS.index(32)]
        outcome.require(f"Fig. 9: the amplitude error decreases with λ/Δx at Δt = {step:g} s",
                        decreases,
                        f"decreases from {per_cent(errors[0])} to {per_cent(errors[-1])},"
                        f" {100 * error_at_32:.3g} % at λ/Δx = 32")  # fmt: skip


def _add_step_rows(outcome: Outcome, runs: dict) -> None:
    """Compare the additional error of the larger step in run, exact theory and closed form."""
    cells, worst, ratio_of_closed_form = [], 0.0, {}
    for ratio in _RATIOS:
        cases = [("triangle", ratio, step, _PENALTY, _PERIOD) for step in _STEPS]
        measured = np.subtract(*[_amplitude_error(runs[case]) for case in reversed(cases)])
        exact = np.subtract(*[_theoretical_error(case, runs[case]) for case in reversed(cases)])
        closed = np.subtract(*[_continuum_loss(ratio, s, _PERIOD) for s in reversed(_STEPS)])
        worst = max(worst, abs(measured - exact) / exact)
        ratio_of_closed_form[ratio] = closed / measured
        cells.append([f"{ratio}", *(f"{100 * v:.2f}" for v in (measured, exact, closed))])
    outcome.tabulate(
        "Gap of figure 9: amplitude error at Δt = 1e-4 s minus that at 1e-5 s (%)",
        ["λ/Δx", "sitedda", "exact discrete theory", "√(4x/πTλ) (√Δt₂ - √Δt₁)"],
        cells,
    )
    outcome.require(
        "Fig. 9: the gap between the two time steps follows from the theory of the scheme",
        bool(worst < 0.01),
        f"largest difference between run and exact theory: {per_cent(worst)} of the gap; ratio of"
        f" the closed form of a continuous column to the gap: {ratio_of_closed_form[4]:.2f} at"
        f" λ/Δx = 4, {ratio_of_closed_form[32]:.2f} at 32",
    )
    outcome.notes.append(
        "The cause of the gap is the attenuation exp(-ω²Δt x/4v) of the scheme. In a continuous"
        " column, it reduces the peak of a triangle by √(4Δt·x/πTλ). With coarse blocks, dispersion"
        " also broadens the peak, so the two losses do not add. The exact discrete theory includes"
        " both and yields the gap to all printed digits. “Largely the same for every ratio” in the"
        " paper is true only for a fixed travel time x/v. At a fixed point M1 the gap is"
        " proportional to 1/√λ."
    )


def _add_shape_rows(outcome: Outcome, runs: dict) -> None:
    """Compare the wave form of one-cycle sines with figures 10 and 11."""
    fits = []
    for ratio in _PAPER_RATIOS:
        case = ("sine", ratio, 1e-4, _PENALTY, _PERIOD)
        result = runs[case]
        theory = _exact_motion(case, result["time"].size)
        crest, trough = result["M1"].max(), -result["M1"].min()
        fits.append(_largest_correlation(result))
        outcome.compare(f"one-cycle sine at λ/Δx = {ratio}: crest (mm)", "Fig. 11", None,
            1e3 * theory.max(), 1e3 * crest, "incident amplitude 1 mm")  # fmt: skip
        outcome.compare(f"one-cycle sine at λ/Δx = {ratio}: trough (mm)", "Fig. 11", None,
            -1e3 * theory.min(), 1e3 * trough,
            f"correlation with the incident wave {fits[-1]:.4f}")  # fmt: skip
    fine = [_largest_correlation(runs[("sine", r, 1e-5, _PENALTY, _PERIOD)]) for r in _PAPER_RATIOS]
    outcome.compare("correlations of M1 with the incident wave for each λ/Δx, Δt = 1e-5 s",
        "Fig. 11", "independent of the time step", None, ", ".join(f"{fit:.4f}" for fit in fine),
        "Δt = 1e-4 s: " + ", ".join(f"{fit:.4f}" for fit in fits))  # fmt: skip
    rising = bool(np.all(np.diff(fits) > 0))
    outcome.require("Fig. 11: the correlation with the incident wave increases with λ/Δx and"
        " exceeds 0.98 at 16", rising and fits[_PAPER_RATIOS.index(16)] > 0.98,
        "correlations " + ", ".join(f"{fit:.4f}" for fit in fits))  # fmt: skip


def _largest_correlation(result: dict) -> float:
    """Return the largest correlation coefficient of M1 with the delayed incident wave."""
    wave, incident = result["M1"], result["base"]
    return float(correlate(wave, incident).max() / np.sqrt(np.sum(wave**2) * np.sum(incident**2)))


def _add_speed_rows(outcome: Outcome, runs: dict) -> None:
    """Compare wave speeds for several penalties."""
    losses = []
    for penalty in _PENALTIES:
        case = ("sine", _SPEED_RATIO, 1e-5, penalty, _PERIOD)
        if case not in runs:
            return
        result = runs[case]
        losses.append(1 - _measure_speed(result))
        size = result["time"].size
        theory = {"time": result["time"], "base": _exact_motion(case, size, "base"),
                  "M1": _exact_motion(case, size)}  # fmt: skip
        outcome.compare(
            f"loss of wave speed 1 − v/√(G/ρ) at k = {penalty:g} E (%)", "section 2.2",
            {40.0: "typical", 100.0: "better accuracy above"}.get(penalty),
            100 * (1 - _measure_speed(theory)), 100 * losses[-1],
            f"long waves: 1 − 1/√(1 + GW/2k_sΔx) = {100 * (1 - _speed_fraction(penalty)):.3g} %",
            3)  # fmt: skip
    decreases = bool(np.all(np.diff(losses) < 0))
    outcome.require("The wave speed increases with the penalty", decreases,
        f"loss of wave speed {per_cent(losses[0])} to {per_cent(losses[-1])}")  # fmt: skip


def _measure_speed(result: dict) -> float:
    """Return wave speed / √(G/ρ), from the delay of M1 with the largest correlation."""
    time = result["time"]
    step = time[1] - time[0]
    correlation = correlate(result["M1"], result["base"])
    delays = step * (np.arange(correlation.size) - (time.size - 1))
    delay, _ = sub_sample_maximum(delays, correlation)
    return _DISTANCE / delay / (_SPEED_RATIO * _SIZE / _PERIOD)


def _add_period_rows(outcome: Outcome, runs: dict) -> None:
    """Compare errors for several periods, because the paper does not print its period."""
    for period in _PERIODS[1:]:
        cases = [("triangle", 32, step, _PENALTY, period) for step in _STEPS]
        if any(case not in runs for case in cases):
            return
        for case, step in zip(cases, _STEPS, strict=True):
            outcome.compare(
                f"sensitivity: amplitude error, λ/Δx = 32, T = {period:g} s, Δt = {step:g} s (%)",
                "assumed", None,
                100 * _theoretical_error(case, runs[case]), 100 * _amplitude_error(runs[case]),
                f"√(4Δt·x/πTλ) = {100 * _continuum_loss(32, step, period):.2f} %:"
                " it depends only on Δt/T and x/λ")  # fmt: skip


def _add_width_rows(outcome: Outcome, runs: dict) -> None:
    """Compare errors for longer waves in a wide stack."""
    for ratio in _WIDE_STACK["ratios"]:
        for step in _STEPS:
            case = _wide_stack_case(ratio, step)
            if case not in runs:
                return
            outcome.compare(
                f"sensitivity: amplitude error, λ/Δx = {ratio}, stack {_WIDE_STACK['width']:g} m"
                f" wide, Δt = {step:g} s (%)", "assumed", None,
                100 * _theoretical_error(case, runs[case]), 100 * _amplitude_error(runs[case]),
                f"√(4Δt·x/πTλ) = {100 * _continuum_loss(ratio, step, _PERIOD):.2f} %")  # fmt: skip
    case_128 = ("triangle", 128, 1e-5, _PENALTY, _PERIOD)
    samples = np.arange(0.0, _case_duration(128, _PERIOD), 1e-5).size
    excess = _exact_motion(case_128, samples).max() / _AMPLITUDE - 1
    cases = ("triangle", 64, 1e-5, _PENALTY, _PERIOD), _wide_stack_case(64, 1e-5)
    narrow_error, wide_error = (100 * _amplitude_error(runs[case]) for case in cases)
    outcome.notes.append(
        "A stack of 15 m width bends under long waves. At λ/Δx = 128 and Δt = 1e-5 s the exact"
        f" theory predicts a crest {per_cent(excess)} above the incident crest. Bending therefore"
        f" also affects the error of figure 9: at λ/Δx = 64 the error is {narrow_error:.2f} %, but"
        f" {wide_error:.2f} % in a stack of {_WIDE_STACK['width']:g} m. The wide stack (rows above)"
        " follows the trend up to 128, and the stack of 15 m only up to 64."
    )


def _make_pictures(runs: dict) -> list[Picture]:
    """Return the pictures of figures 8 to 11, and of the wave speed if it was measured."""
    pictures = [
        picture("shear_wave_fig9", "Figures 8 and 9: triangular wave and relative error of its"
                " amplitude at M1; pale points are not in the paper.", _draw_peak_errors, runs),
        picture("shear_wave_fig11", "Figures 10 and 11: one-cycle sine at M1, Δt = 1e-4 s,"
                " and the incident wave delayed by the exact travel time.", _draw_sines, runs),
    ]  # fmt: skip
    if ("sine", _SPEED_RATIO, 1e-5, 1.0, _PERIOD) in runs:
        caption = "Wave speed for several penalties (section 2.2)."
        pictures.append(picture("shear_wave_speed", caption, _draw_wave_speed, runs))
    return pictures


def _draw_peak_errors(drawing, runs) -> None:
    with small_axes(drawing, 1, 2, size=(7.8, 3.4), width_ratios=[1, 2.2]) as (pulse, errors):
        values, spacing = _incident_motion("triangle", _PERIOD)
        time = spacing * np.arange(-100, 501)
        pulse.plot(1e3 * time, 1e3 * np.pad(values, 100), color=GREY)
        pulse.set(xlabel="time (ms)", ylabel="u (mm)", title="Fig. 8, period assumed")
        for step, color in zip(_STEPS, COLORS, strict=False):
            cases = [("triangle", r, step, _PENALTY, _PERIOD) for r in _RATIOS]
            exact = [100 * _theoretical_error(c, runs[c]) for c in cases]
            errors.plot(_RATIOS, exact, "-", color=color, lw=1)
            measured = [100 * _amplitude_error(runs[c]) for c in cases]
            errors.plot(_RATIOS[4:], measured[4:], "o", color=color, alpha=0.4)
            errors.plot(_PAPER_RATIOS, measured[:4], "o", color=color, label=f"Δt = {step:g} s")
            closed = [100 * _continuum_loss(r, step, _PERIOD) for r in _RATIOS]
            errors.plot(_RATIOS, closed, ":", color=color, lw=1.2)
        errors.plot([], [], "-", color=INK, lw=1, label="exact discrete theory")
        errors.plot([], [], ":", color=INK, lw=1.2, label="closed form, continuous column")
        errors.set_xscale("log", base=2)
        errors.set_xticks(_RATIOS, [str(r) for r in _RATIOS])
        errors.set(xlabel="λ/Δx", ylabel="relative error (%)", title="Fig. 9", ylim=(0, None))
        errors.legend()


def _draw_sines(drawing, runs) -> None:
    with small_axes(drawing, 2, 2, size=(7.4, 4.6), sharey=True) as axes:
        for axis, ratio in zip(axes.flat, _PAPER_RATIOS, strict=True):
            result = runs[("sine", ratio, 1e-4, _PENALTY, _PERIOD)]
            delay = _DISTANCE / (ratio * _SIZE / _PERIOD)
            time = 1e3 * result["time"]
            values, spacing = _incident_motion("sine", _PERIOD)
            axis.plot(1e3 * (delay + spacing * np.arange(401)), 1e3 * values, "--",
                      color="0.6", lw=1.2, label="incident")  # fmt: skip
            axis.plot(time, 1e3 * result["M1"], color=BLUE, label="M1")
            axis.set(title=f"λ/Δx = {ratio}", xlim=(time[0], time[-1]))
        axes[0, 0].legend(loc="lower left")
        for axis in axes[1]:
            axis.set_xlabel("time (ms)")
        for axis in axes[:, 0]:
            axis.set_ylabel("u (mm)")


def _draw_wave_speed(drawing, runs) -> None:
    measured = [_measure_speed(runs[("sine", _SPEED_RATIO, 1e-5, p, _PERIOD)]) for p in _PENALTIES]
    line = np.geomspace(0.7, 1500, 80)
    with small_axes(drawing, size=(5.6, 3.2)) as axis:
        axis.semilogx(line, [_speed_fraction(p) for p in line], color=RED, lw=1,
                      label="1/√(1 + GW/2k$_s$Δx)")  # fmt: skip
        label = f"sitedda, λ/Δx = {_SPEED_RATIO}"
        axis.semilogx(_PENALTIES, measured, "o", color=BLUE, label=label)
        for value, name in ((40, "40 E, typical"), (100, "100 E, advised")):
            axis.axvline(value, color="0.6", lw=0.8, ls=":")
            axis.annotate(name, (value, 0.42), rotation=90, ha="right", fontsize=8, color="0.35")
        axis.set(xlabel="penalty / E (m)", ylabel="wave speed / √(G/ρ)", ylim=(0.3, 1.05))
        axis.legend(loc="lower right")
