# SPDX-License-Identifier: GPL-3.0-or-later
"""The 15 layers of the paper and SHAKE (figures 12 to 16, tables I and II)."""

from dataclasses import replace
from functools import cache

import numpy as np

from sitedda.engine.scheme import scheme_damping
from sitedda.engine.spectra import amplification, find_peak
from sitedda.facade.run import run
from sitedda.report import Picture
from sitedda.report.style import BLUE, COLORS, INK, RED, small_axes
from sitedda.site.column import Column, damped_amplification, refined_peak
from sitedda.site.twin import layered_soils

from ..case import Outcome, picture, relative, study
from ..comparison import per_cent
from ..runs import Task, input_file
from .discrete import DiscreteModel

_STEP = 1e-3  # time step of table I, s
_BAND = (1.0, 25.0)  # band in which the peak is searched, similar to figures 15 and 16, Hz
_TABLES = {
    1: {"input": "layers_table1.nml", "figure": "Fig. 15", "dda": (13.95, 29.07),
        "shake": (14.21, 28.93), "damping": None, "site": "uniform, table I"},
    2: {"input": "layers_table2.nml", "figure": "Fig. 16", "dda": (14.23, 28.76),
        "shake": (14.50, 27.79), "damping": 0.023, "site": "table II"},
}  # frequency (Hz), amplification and damping as printed in section 2.3  # fmt: skip
_DDA_LIMITS = (0.002, 0.01)  # largest errors of frequency and amplification, DDA of the paper
_SHAKE_LIMITS = (0.003, 0.008)  # the same, SHAKE of the paper
_NOISE = {"samples": 3000, "time_step": 0.01, "seed": 4}  # white noise


def tasks(quick: bool = False) -> list[Task]:
    """Return the runs of the study, all of which are short."""
    cases = [(table, loading) for table in _TABLES for loading in ("displacement", "acceleration")]
    cases.append((1, "noise"))
    queue = [Task(case, _run_layers, {"table": case[0], "loading": case[1]}, 3.0) for case in cases]
    return [*queue, Task("ground", _ground_motion, {}, 1.0)]


def _run_layers(table: int, loading: str) -> dict:
    """Run the layers of a table; return accelerations of points (m/s²), and the 1-D column."""
    changes = {}
    if loading == "acceleration":
        changes = {"base_motion_x": "earthquake", "fixed_point[*]": {"motion_x": ""}}
    elif loading == "noise":
        changes = {"motion": _noise_motion()}
    history = run(input_file(_TABLES[table]["input"]), **changes).history
    points = ("base", "middle", "surface")
    result = {name: history.acceleration.sel(point=name).isel(axis=0).values for name in points}
    return result | {"column": layered_soils(history, "surface", "base")[0]}


def _noise_motion() -> dict:
    """Return the values of &motion for white noise of accelerations."""
    random = np.random.default_rng(_NOISE["seed"])
    values = random.standard_normal(_NOISE["samples"])
    return {"file": None, "format": None, "unit": "m/s2", "quantity": "acceleration",
            "time_step": _NOISE["time_step"], "values": values.tolist()}  # fmt: skip


def _ground_motion() -> dict:
    """Return the ground motion: acceleration, velocity and displacement at each step (SI)."""
    history = run(input_file("ground.nml")).history
    interval = {name: -history[name].isel(point=0, axis=0).values
            for name in ("acceleration", "velocity", "displacement")}  # fmt: skip
    return interval | {"time": history.time.values}


@cache
def _discrete_model(table: int) -> DiscreteModel:
    return DiscreteModel.of(input_file(_TABLES[table]["input"]))


@cache
def _discrete_peak(table: int, point: str, loading: str = "displacement"):
    """Return the peak of the exact discrete transfer function from the base to a point."""
    model = _discrete_model(table)
    return refined_peak(lambda f: model.transfer_function(f, _STEP, point, "base", loading),
                        (13.0, 15.5), 50)  # fmt: skip


def _measure_amplification(result: dict, point: str, ground: dict | None = None):
    """Return frequencies (Hz) and amplification from the base to a point, and its peak."""
    motion, base_motion = result[point], result["base"]
    if ground is not None:  # accelerations are relative to the base, whose motion is added
        base_motion = ground["acceleration"]
        motion = motion + base_motion
    frequency, ratio = amplification(motion, base_motion, _STEP)
    return frequency, abs(ratio), find_peak(frequency, abs(ratio), *_BAND)


@cache
def _damped_column(column: Column, damping: float, convention: str = "shake") -> Column:
    return Column([replace(layer, damping=damping) for layer in column.layers], "rigid", convention)


def _shake_damping(table: int) -> float:
    """Return the printed damping ratio for SHAKE, or else the rounded one of the scheme."""
    printed = _TABLES[table]["damping"]
    return printed or round(float(scheme_damping(_TABLES[table]["dda"][0], _STEP)), 3)


@study("Fifteen layers against SHAKE (section 2.3, figures 12–16, tables I and II)", tasks)
def layers(runs: dict) -> Outcome:
    """Compose rows, requirements and pictures from the runs."""
    ground = runs.pop("ground")
    outcome = Outcome(text=[
        "Fifteen layers of 15 m × 1 m lie on a shaken base block: k = 1500 GN/m, Δt = 1 ms, 60,000"
        " steps, only numerical damping. “Theory” is the exact transfer function of the discrete"
        " model: K and M of blocks and springs, one complex solution per frequency.",
        "The record of the paper (Chi-Chi 1999, ALS, E) may not be redistributed. A record of Loma"
        " Prieta 1989 (USGS) replaces it. White noise yields the same peak.",
    ])  # fmt: skip
    for table in _TABLES:
        _add_dda_rows(outcome, table, runs)
        _add_shake_rows(outcome, table, runs[(table, "displacement")]["column"])
        _add_loading_row(outcome, table, runs, ground)
    _add_noise_row(outcome, runs)
    _add_notes(outcome, runs)
    outcome.pictures = _make_pictures(runs, ground)
    return outcome


def _add_dda_rows(outcome: Outcome, table: int, runs: dict) -> None:
    """Compare the run with theory and with DDA of the paper."""
    case = _TABLES[table]
    result = runs[(table, "displacement")]
    printed = dict(zip(("frequency", "amplitude"), case["dda"], strict=True))
    reasons = {
        "middle": "M2 at the centre of the top block reproduces the printed value",
        "surface": "M2 on the surface: the upper half of the top layer adds amplification",
    }
    for point, cause in reasons.items():
        theory, peak = _discrete_peak(table, point), _measure_amplification(result, point)[2]
        source = f"{case['figure']}, DDA"
        position = "mid-layer" if point == "middle" else "surface"
        outcome.compare(f"frequency of the peak, {case['site']}, {position} (Hz)", source,
            printed["frequency"], theory.frequency, peak.frequency, cause, 5)  # fmt: skip
        outcome.compare(f"amplification at the peak, {case['site']}, {position}", source,
            printed["amplitude"], theory.amplitude, peak.amplitude, "", 5)  # fmt: skip
    peak = _measure_amplification(result, "middle")[2]
    for quantity, limit in zip(("frequency", "amplitude"), _DDA_LIMITS, strict=True):
        outcome.rows.append(relative(f"{case['figure']}: {quantity} of the DDA peak, relative to"
            " the paper", printed[quantity], getattr(peak, quantity), limit))  # fmt: skip


def _add_shake_rows(outcome: Outcome, table: int, column: Column) -> None:
    """Compare the 1-D column with SHAKE of the paper."""
    case = _TABLES[table]
    damping = _shake_damping(table)
    peak = _damped_column(column, damping).peak()
    shake91_peak = _damped_column(column, damping, "shake91").peak()
    exact = _closed_form_peak(column, damping)
    origin = "printed" if case["damping"] else "of the scheme at the peak, rounded"
    source = f"{case['figure']}, SHAKE"
    outcome.compare(f"1-D column: frequency of the peak, {case['site']} (Hz)", source,
        case["shake"][0], exact and exact.frequency, peak.frequency,
        f"D = {per_cent(damping)} ({origin}); the paper prints the frequency of a spectral line",
        5)  # fmt: skip
    outcome.compare(f"1-D column: amplification at the peak, {case['site']}", source,
        case["shake"][1], exact and exact.amplitude, peak.amplitude, "modulus G(1 + 2iD); with the"
        f" modulus of SHAKE91 {shake91_peak.amplitude:.2f} at {shake91_peak.frequency:.3f} Hz",
        5)  # fmt: skip
    for quantity, limit, printed in zip(
        ("frequency", "amplitude"), _SHAKE_LIMITS, case["shake"], strict=True
    ):
        label = f"{case['figure']}: {quantity} of the peak of the 1-D column, relative to SHAKE"
        outcome.rows.append(relative(label, printed, getattr(peak, quantity), limit))


def _closed_form_peak(column: Column, damping: float):
    """Return the peak of eq. 10 of the paper if the column is uniform; otherwise None."""
    if len({layer.shear_velocity for layer in column.layers}) > 1:
        return None
    speed = column.depth / column.travel_time
    return refined_peak(lambda f: damped_amplification(f, column.depth, speed, damping), (5, 25))


def _add_loading_row(outcome: Outcome, table: int, runs: dict, ground: dict) -> None:
    """Compare loading by base displacement with loading by base acceleration."""
    case = _TABLES[table]
    result = runs[(table, "acceleration")]
    frequency, by_force, peak = _measure_amplification(result, "middle", ground)
    _, by_motion, reference = _measure_amplification(runs[(table, "displacement")], "middle")
    theory = _discrete_peak(table, "middle", "acceleration")
    band = (frequency >= _BAND[0]) & (frequency <= _BAND[1])
    difference = np.max(abs(by_force - by_motion)[band] / by_motion[band])
    outcome.compare(f"base acceleration as body force: frequency of the peak, {case['site']} (Hz)",
        "section 2.3", case["dda"][0], theory.frequency, peak.frequency,
        "the scheme filters displacements and accelerations of the base differently",
        5)  # fmt: skip
    outcome.compare(f"base acceleration as body force: amplification at the peak, {case['site']}",
        "section 2.3", case["dda"][1], theory.amplitude, peak.amplitude,
        f"largest difference of the spectra {per_cent(difference)}, {_BAND[0]:g}–{_BAND[1]:g} Hz",
        5)  # fmt: skip
    outcome.rows.append(relative(f"{case['figure']}: amplification at the peak, base acceleration"
        " and base displacement", reference.amplitude, peak.amplitude, 0.001))  # fmt: skip


def _add_noise_row(outcome: Outcome, runs: dict) -> None:
    """Compare the amplification of white noise with that of the record."""
    peaks = [_measure_amplification(runs[(1, kind)], "middle")[2]
             for kind in ("displacement", "noise")]  # fmt: skip
    outcome.compare("sensitivity: amplification at the peak under white noise", "assumed",
                    _TABLES[1]["dda"][1], _discrete_peak(1, "middle").amplitude, peaks[1].amplitude,
                    f"at {peaks[1].frequency:.4f} Hz; under the record {peaks[0].amplitude:.3f}",
                    5)  # fmt: skip


def _add_notes(outcome: Outcome, runs: dict) -> None:
    """Add notes on contact springs, order of the layers of table II, and damping."""
    uniform, column = (runs[(table, "displacement")]["column"] for table in _TABLES)
    reversed_column = _damped_column(replace(column, layers=column.layers[::-1]), _shake_damping(2))
    peak = _damped_column(column, _shake_damping(2)).peak()
    stiff = DiscreteModel.of(input_file(_TABLES[1]["input"]), contact={"normal_stiffness": 1.5e15})
    outcome.notes += [
        "The frequency of DDA is lower than that of SHAKE, because the contact springs (two per"
        " joint) add to the compliance of the layers. The undamped frequency is"
        f" {_discrete_model(1).frequencies[0]:.2f} Hz at k = 1500 GN/m of the paper and"
        f" {stiff.frequencies[0]:.2f} Hz at a thousand times this penalty. That of the continuum is"
        f" √(G/ρ)/4H = {0.25 / uniform.travel_time:.2f} Hz.",
        "Table II numbers its layers from the top. With layers numbered from the base, the"
        f" frequency of the peak of the 1-D column would be {reversed_column.peak().frequency:.2f}"
        f" Hz instead of {peak.frequency:.2f} Hz (paper {_TABLES[2]['shake'][0]:.2f} Hz).",
        "The damping ratio does not depend on the penalty: 2ζ = tan(ωΔt/2) yields"
        f" {per_cent(float(scheme_damping(_TABLES[2]['dda'][0], _STEP)))} at 14.23 Hz and 1 ms. The"
        f" paper determined {per_cent(_TABLES[2]['damping'])} by trial.",
    ]


def _make_pictures(runs: dict, ground: dict) -> list[Picture]:
    """Return the pictures of the ground motion and of the amplification of both tables."""
    spectra = [
        picture(f"layers_fig{14 + table}",
                f"{_TABLES[table]['figure'].replace('Fig.', 'Figure')}: amplification,"
                f" {_TABLES[table]['site']}; circles: peaks of the paper.", _draw_amplification,
                table, runs, ground)
        for table in _TABLES
    ]  # fmt: skip
    motion = picture(
        "layers_fig14",
        "Figure 14 with the record of this study: acceleration, velocity, and displacement of the"
        " fixed points.", _draw_ground_motion, ground)  # fmt: skip
    return [motion, *spectra]


def _draw_ground_motion(drawing, ground) -> None:
    with small_axes(drawing, 3, 1, size=(7.0, 4.2), sharex=True) as axes:
        for axis, name, label, color in zip(
            axes, ("acceleration", "velocity", "displacement"), ("a (m/s²)", "v (m/s)", "d (m)"),
            COLORS, strict=False,
        ):  # fmt: skip
            axis.plot(ground["time"][::10], ground[name][::10], color=color, lw=0.7)
            axis.set(ylabel=label, xlim=(0, 40))
        axes[-1].set_xlabel("time (s)")


def _draw_amplification(drawing, table, runs, ground) -> None:
    case = _TABLES[table]
    result = runs[(table, "displacement")]
    frequency, ratio, peak = _measure_amplification(result, "middle")
    band = (frequency >= _BAND[0]) & (frequency <= _BAND[1])
    band[::2] = False
    shake = _damped_column(result["column"], _shake_damping(table))
    with small_axes(drawing, size=(6.8, 3.9)) as axis:
        axis.plot(frequency[band], ratio[band], color=BLUE, lw=2, label="sitedda, displacement")
        by_force = runs[(table, "acceleration")]
        ratio_by_force = _measure_amplification(by_force, "middle", ground)[1]
        axis.plot(frequency[band], ratio_by_force[band], ":", color=COLORS[1], lw=1.6,
                  label="sitedda, acceleration")  # fmt: skip
        axis.plot(frequency[band], abs(shake.transfer(frequency[band])), "--", color=RED,
                  lw=1.2, label=f"1-D column, D = {per_cent(_shake_damping(table))}")  # fmt: skip
        for (x, y), name, face in ((case["dda"], "DDA", BLUE), (case["shake"], "SHAKE", "w")):
            axis.plot(x, y, "o", ms=7, mfc=face, mec=INK, label=f"paper, {name}: {y} at {x} Hz")
        axis.set(xlabel="frequency (Hz)", ylabel="spectral amplification", xlim=_BAND, ylim=(0, 32))
        axis.text(0.02, 0.95, f"sitedda {peak.amplitude:.2f} at {peak.frequency:.2f} Hz",
                  transform=axis.transAxes, va="top", color=BLUE)  # fmt: skip
        axis.legend(loc="upper right", fontsize=7.5)
