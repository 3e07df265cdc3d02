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
from ..compared import per_cent
from ..runs import Task, input_file
from .discrete import DiscreteModel

_STEP = 1e-3  # time step of table I, s
_BAND = (1.0, 25.0)  # band in which the peak is searched, similar to figures 15 and 16, Hz
_TABLES = {
    1: {"input": "layers_table1.nml", "figure": "Fig. 15", "dda": (13.95, 29.07),
        "shake": (14.21, 28.93), "damping": None, "where": "uniform, table I"},
    2: {"input": "layers_table2.nml", "figure": "Fig. 16", "dda": (14.23, 28.76),
        "shake": (14.50, 27.79), "damping": 0.023, "where": "table II"},
}  # frequency (Hz), amplification and damping as printed in section 2.3  # fmt: skip
_DDA_LIMITS = (0.002, 0.01)  # largest errors of frequency and amplification, DDA of the paper
_SHAKE_LIMITS = (0.003, 0.008)  # the same, SHAKE of the paper
_NOISE = {"samples": 3000, "time_step": 0.01, "seed": 4}  # white noise


def tasks(quick: bool = False) -> list[Task]:
    """Return the runs of the study, all of which are short."""
    cases = [(table, loading) for table in _TABLES for loading in ("displacement", "acceleration")]
    cases.append((1, "noise"))
    todo = [Task(case, _run_layers, {"table": case[0], "loading": case[1]}, 3.0) for case in cases]
    return [*todo, Task("ground", _ground_motion, {}, 1.0)]


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
    take = {name: -history[name].isel(point=0, axis=0).values
            for name in ("acceleration", "velocity", "displacement")}  # fmt: skip
    return take | {"time": history.time.values}


@cache
def _discrete_model(table: int) -> DiscreteModel:
    return DiscreteModel.of(input_file(_TABLES[table]["input"]))


@cache
def _discrete_peak(table: int, point: str, loading: str = "displacement"):
    """Return the peak of the exact discrete transfer function from the base to a point."""
    model = _discrete_model(table)
    return refined_peak(
        lambda f: model.transfer(f, _STEP, point, "base", loading), (13.0, 15.5), 50
    )


def _measure_amplification(result: dict, point: str, ground: dict | None = None):
    """Return frequencies (Hz) and amplification from the base to a point, and its peak."""
    above, below = result[point], result["base"]
    if ground is not None:  # accelerations are relative to the base, whose motion is added
        below = ground["acceleration"]
        above = above + below
    frequency, ratio = amplification(above, below, _STEP)
    return frequency, abs(ratio), find_peak(frequency, abs(ratio), *_BAND)


@cache
def _damped_column(column: Column, damping: float, convention: str = "shake") -> Column:
    return Column([replace(layer, damping=damping) for layer in column.layers], "rigid", convention)


def _shake_damping(table: int) -> float:
    """Return the printed damping ratio for SHAKE, or else the rounded one of the scheme."""
    printed = _TABLES[table]["damping"]
    return printed or round(float(scheme_damping(_TABLES[table]["dda"][0], _STEP)), 3)


@study("Fifteen layers against SHAKE (section 2.3, figures 12–16, tables I and II)", tasks)
def layers(found: dict) -> Outcome:
    """Compose rows, requirements and pictures from the runs."""
    ground = found.pop("ground")
    done = Outcome(text=[
        "Fifteen layers of 15 m × 1 m on a shaken base block, k = 1500 GN/m, Δt = 1 ms, 60,000"
        " steps, damping by the scheme alone. “Theory” is the exact discrete one: K and M of the"
        " blocks and springs, one complex solve per frequency.",
        "The paper's record (Chi-Chi 1999, ALS, E) may not be redistributed; a Loma Prieta 1989"
        " record of the USGS replaces it. White noise gives the same peak.",
    ])  # fmt: skip
    for table in _TABLES:
        _add_dda_rows(done, table, found)
        _add_shake_rows(done, table, found[(table, "displacement")]["column"])
        _add_loading_row(done, table, found, ground)
    _add_noise_row(done, found)
    _add_notes(done, found)
    done.pictures = _make_pictures(found, ground)
    return done


def _add_dda_rows(done: Outcome, table: int, found: dict) -> None:
    """Compare the run with theory and with DDA of the paper."""
    case = _TABLES[table]
    result = found[(table, "displacement")]
    printed = dict(zip(("frequency", "amplitude"), case["dda"], strict=True))
    reasons = {
        "middle": "M2 at the middle of the top block, which reproduces the printed value",
        "surface": "M2 on the surface: the top half layer amplifies slightly more",
    }
    for point, why in reasons.items():
        theory, peak = _discrete_peak(table, point), _measure_amplification(result, point)[2]
        place = f"{case['figure']}, DDA"
        at = "mid-layer" if point == "middle" else "surface"
        done.compare(f"resonance, {case['where']}, {at} (Hz)", place, printed["frequency"],
            theory.frequency, peak.frequency, why, 5)  # fmt: skip
        done.compare(f"amplification, {case['where']}, {at}", place, printed["amplitude"],
            theory.amplitude, peak.amplitude, "", 5)  # fmt: skip
    peak = _measure_amplification(result, "middle")[2]
    for what, limit in zip(("frequency", "amplitude"), _DDA_LIMITS, strict=True):
        done.rows.append(
            relative(f"{case['figure']}: DDA {what} within {per_cent(limit)} of the paper",
                     printed[what], getattr(peak, what), limit)
        )  # fmt: skip


def _add_shake_rows(done: Outcome, table: int, column: Column) -> None:
    """Compare the 1-D column with SHAKE of the paper."""
    case = _TABLES[table]
    damping = _shake_damping(table)
    peak = _damped_column(column, damping).peak()
    other = _damped_column(column, damping, "shake91").peak()
    closed = _closed_form_peak(column, damping)
    source = "printed" if case["damping"] else "the scheme's at the peak, rounded"
    place = f"{case['figure']}, SHAKE"
    done.compare(f"SHAKE twin: resonance, {case['where']} (Hz)", place, case["shake"][0],
        closed and closed.frequency, peak.frequency,
        f"D = {per_cent(damping)} ({source}); the paper reads the value at a spectral line",
        5)  # fmt: skip
    done.compare(f"SHAKE twin: amplification, {case['where']}", place, case["shake"][1],
        closed and closed.amplitude, peak.amplitude,
        f"G(1 + 2iD); with SHAKE91's modulus {other.amplitude:.2f} at {other.frequency:.3f} Hz",
        5)  # fmt: skip
    for what, limit, printed in zip(
        ("frequency", "amplitude"), _SHAKE_LIMITS, case["shake"], strict=True
    ):
        done.rows.append(
            relative(f"{case['figure']}: SHAKE twin {what} within {per_cent(limit)} of the paper's",
                     printed, getattr(peak, what), limit)
        )  # fmt: skip


def _closed_form_peak(column: Column, damping: float):
    """Return the peak of eq. 10 of the paper if the column is uniform; otherwise None."""
    if len({layer.shear_velocity for layer in column.layers}) > 1:
        return None
    speed = column.depth / column.travel_time
    return refined_peak(lambda f: damped_amplification(f, column.depth, speed, damping), (5, 25))


def _add_loading_row(done: Outcome, table: int, found: dict, ground: dict) -> None:
    """Compare loading by base displacement with loading by base acceleration."""
    case = _TABLES[table]
    frequency, by_force, peak = _measure_amplification(
        found[(table, "acceleration")], "middle", ground
    )
    _, by_motion, reference = _measure_amplification(found[(table, "displacement")], "middle")
    theory = _discrete_peak(table, "middle", "acceleration")
    strong = (frequency >= _BAND[0]) & (frequency <= _BAND[1])
    apart = np.max(abs(by_force - by_motion)[strong] / by_motion[strong])
    done.compare(f"base acceleration as body force: resonance, {case['where']} (Hz)", "section 2.3",
        case["dda"][0], theory.frequency, peak.frequency,
        "the two loadings differ only in how the scheme filters the base motion", 5)  # fmt: skip
    done.compare(f"base acceleration as body force: amplification, {case['where']}", "section 2.3",
        case["dda"][1], theory.amplitude, peak.amplitude,
        f"spectra differ by {per_cent(apart)} at most over {_BAND[0]:g}–{_BAND[1]:g} Hz",
        5)  # fmt: skip
    done.rows.append(
        relative(
            f"{case['figure']}: base displacement and base acceleration give the same spectrum",
            reference.amplitude,
            peak.amplitude,
            0.001,
        )
    )


def _add_noise_row(done: Outcome, found: dict) -> None:
    """Compare the amplification of white noise with that of the record."""
    peaks = [
        _measure_amplification(found[(1, kind)], "middle")[2] for kind in ("displacement", "noise")
    ]
    done.compare(
        "sensitivity: amplification of white noise",
        "assumed",
        _TABLES[1]["dda"][1],
        _discrete_peak(1, "middle").amplitude,
        peaks[1].amplitude,
        f"at {peaks[1].frequency:.4f} Hz; under the record {peaks[0].amplitude:.3f}:"
        " a property of the model, not of the record",
        5,
    )


def _add_notes(done: Outcome, found: dict) -> None:
    """Add notes on contact springs, order of the layers of table II, and damping."""
    uniform, column = (found[(table, "displacement")]["column"] for table in _TABLES)
    turned = _damped_column(replace(column, layers=column.layers[::-1]), _shake_damping(2))
    right = _damped_column(column, _shake_damping(2)).peak()
    stiff = DiscreteModel.of(input_file(_TABLES[1]["input"]), contact={"normal_stiffness": 1.5e15})
    done.notes += [
        "DDA resonates lower than SHAKE because the contact springs, two at each of 15 joints, add"
        f" to the compliance of the layers: {_discrete_model(1).frequencies[0]:.2f} Hz undamped at"
        f" the paper's k = 1500 GN/m, {stiff.frequencies[0]:.2f} Hz at a thousand times that, the"
        f" continuum's √(G/ρ)/4H being {0.25 / uniform.travel_time:.2f} Hz.",
        "Table II counts its layers from the top: from the base the twin's peak would lie at"
        f" {turned.peak().frequency:.2f} Hz and not at {right.frequency:.2f} Hz"
        f" (paper {_TABLES[2]['shake'][0]:.2f} Hz).",
        "The damping does not depend on the penalty: 2ζ = tan(ωΔt/2), "
        f"{per_cent(float(scheme_damping(_TABLES[2]['dda'][0], _STEP)))} at 14.23 Hz and 1 ms;"
        f" the paper found {per_cent(_TABLES[2]['damping'])} by trial.",
    ]


def _make_pictures(found: dict, ground: dict) -> list[Picture]:
    """Return the pictures of the ground motion and of the amplification of both tables."""
    spectra = [
        picture(
            f"layers_fig{14 + table}",
            f"{_TABLES[table]['figure'].replace('Fig.', 'Figure')}: amplification,"
            f" {_TABLES[table]['where']}; circles are the paper's peaks.",
            _draw_amplification,
            table,
            found,
            ground,
        )
        for table in _TABLES
    ]
    motion = picture(
        "layers_fig14",
        "Figure 14 with the record used here: acceleration and the displacement that moves the"
        " fixed points.",
        _draw_ground_motion,
        ground,
    )
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


def _draw_amplification(drawing, table, found, ground) -> None:
    case = _TABLES[table]
    result = found[(table, "displacement")]
    frequency, ratio, peak = _measure_amplification(result, "middle")
    band = (frequency >= _BAND[0]) & (frequency <= _BAND[1])
    band[::2] = False
    shake = _damped_column(result["column"], _shake_damping(table))
    with small_axes(drawing, size=(6.8, 3.9)) as axis:
        axis.plot(frequency[band], ratio[band], color=BLUE, lw=2, label="sitedda, displacement")
        _, other, _ = _measure_amplification(found[(table, "acceleration")], "middle", ground)
        axis.plot(frequency[band], other[band], ":", color=COLORS[1], lw=1.6,
                  label="sitedda, acceleration")  # fmt: skip
        axis.plot(frequency[band], abs(shake.transfer(frequency[band])), "--", color=RED,
                  lw=1.2, label=f"SHAKE twin, D = {per_cent(_shake_damping(table))}")  # fmt: skip
        for (x, y), name, face in ((case["dda"], "DDA", BLUE), (case["shake"], "SHAKE", "w")):
            axis.plot(x, y, "o", ms=7, mfc=face, mec=INK, label=f"paper, {name}: {y} at {x} Hz")
        axis.set(xlabel="frequency (Hz)", ylabel="spectral amplification", xlim=_BAND,
                 ylim=(0, 32))  # fmt: skip
        axis.text(0.02, 0.95, f"sitedda {peak.amplitude:.2f} at {peak.frequency:.2f} Hz",
                  transform=axis.transAxes, va="top", color=BLUE)  # fmt: skip
        axis.legend(loc="upper right", fontsize=7.5)
