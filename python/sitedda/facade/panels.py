# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw panels of the picture of a run: histories, spectra, amplification, energies."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..base.numbers import in_unit
from ..engine.scheme import scheme_damping
from ..engine.signals import low_passed, smooth_konno_ohmachi
from ..output.energies import Budget
from ..output.response import Amplification
from ..output.scene import Scene
from ..output.verdict import (
    PERIODS,
    SPECTRUM_DAMPING,
    acceleration_spectrum,
    describe_damping,
    main_axis,
    run_scheme,
)
from ..report.colors import BLUE, COLORS, FAINT, GREY, INK, ORANGE
from ..report.layout import legend_above
from ..report.words import folded, plain
from ..site.column import damped_amplification
from ..site.twin import layered_soils

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

_MOST_POINTS = 6
_INCOMING = "incoming: "
_PERIOD_TICKS = (0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5)  # s
_MOTION_TOLERANCE = 1e-3  # motions with a smaller relative difference are drawn as one curve
_RESIDUAL = 0.16  # height of the panel of the audit residual / height of the energy panel
_LETTER = 0.02  # width of a letter of the name of a stage over the width of a panel
_LEAST_WIDTH = 0.04  # smallest width of a named stage over the width of a panel
_TEXT_HEIGHT = 1.8  # inches, largest length of a vertical text in a panel
_USUAL_FREQUENCIES = (1.0, 10.0)  # Hz; damping is reported here if there is no amplification peak
_SMOOTHED = 3000  # largest number of bins of a smoothed ratio, which is padded with zeros 8 times
_SAMPLES = 1500  # largest number of drawn samples of energies


def title_and_damping(history, *frequencies: float) -> tuple[str, str]:
    """Return the title of a run, and the damping of its model at frequencies (Hz) in words."""
    title = plain(str(history.attrs.get("title", ""))) or "Untitled"
    return title, describe_damping(history, *(frequencies or _USUAL_FREQUENCIES))


def draw_site(axes: dict, scene: Scene, result: Amplification, discrete) -> None:
    """Draw accelerations, response spectra and amplification of a site.

    `axes`: panels 'surface', 'base', 'spectra' and 'ratio'.
    `discrete`: exact transfer function of the model at the frequencies of the result.
    """
    history, axis = scene.data, ("x", "y").index(result.direction)
    series = {
        name: history.acceleration.sel(point=name).isel(axis=axis).values
        for name in dict.fromkeys((result.surface, result.base))
    }
    _draw_accelerations((axes["surface"], axes["base"]), history, series)
    for name in ("surface", "base"):
        mark_stages(axes[name], scene, named=name == "surface")
    draw_spectra(axes["spectra"], history, series)
    draw_ratio(axes["ratio"], history, result, discrete)


def _draw_accelerations(panels, history, series: dict) -> None:
    """Draw accelerations (m/s²) in one panel per point, with a common scale."""
    largest = max(float(abs(values).max()) for values in series.values()) or 1.0
    for axes, (name, values), color in zip(panels, series.items(), (BLUE, GREY), strict=False):
        axes.plot(history.time, values, color=color, lw=0.6)
        axes.set(xlim=(0, float(history.time[-1])), ylim=(-1.08 * largest, 1.08 * largest))
        label = f"acceleration of {plain(name)} (m/s²), largest {abs(values).max():.3g}"
        axes.set_title(label, loc="left", y=1.0, fontsize=9)
    panels[0].tick_params(labelbottom=False)
    panels[-1].set_xlabel("time (s)")


def draw_spectra(axes: Axes, history, series: dict, styles=None, resolved: float = 0.0) -> None:
    """Draw response spectra of named accelerations (m/s²), low-passed at `resolved` (Hz) if not 0.

    The low-pass removes impacts of contacts, as in the results of the run.
    """
    styles = styles or [{"color": color} for color in (BLUE, GREY)]
    for i, ((name, values), style) in enumerate(zip(series.items(), styles, strict=False)):
        step = mean_step(history)
        if resolved:
            values = low_passed(values, step, resolved)
        curve = acceleration_spectrum(values, step)
        axes.plot(PERIODS, curve, label=plain(name), **({"lw": 1.6, "zorder": 4 - i} | style))
    spectrum_axes(axes)
    if resolved:
        limit = f"{float(f'{resolved:.3g}'):g} Hz"  # 2500 Hz, not 2.5e+03 Hz
        axes.set_ylabel(f"Sa, {SPECTRUM_DAMPING:.0%} damping, below {limit} (m/s²)")
    legend_above(axes, 3)


def spectrum_axes(axes: Axes) -> None:
    """Set a logarithmic axis of periods with ticks at round numbers."""
    axes.set_xscale("log")
    axes.set(xlim=(PERIODS[0], PERIODS[-1]), ylim=(0, None), xlabel="period (s)")
    axes.set_ylabel(f"Sa, {SPECTRUM_DAMPING:.0%} damping (m/s²)")
    axes.set_xticks(_PERIOD_TICKS, labels=[f"{tick:g}" for tick in _PERIOD_TICKS])
    axes.minorticks_off()


def draw_displacements(axes: Axes, scene: Scene, curves) -> None:
    """Draw the displacements of `curves_of` over time; incoming motions are absolute."""
    drawn_curves = [curve for curve in curves if not curve[0].startswith(_INCOMING)]
    if not drawn_curves or scene.origin == "absolute":
        drawn_curves = curves
    history = scene.data
    size, unit = in_unit(max(float(abs(displacement).max())
                             for _, displacement, _, _ in drawn_curves), "m")  # fmt: skip
    for label, displacement, _, style in drawn_curves:
        axes.plot(history.time, displacement / size, lw=1.1, label=plain(label), **style)
    end = float(history.time[-1])
    kind = "absolute displacement" if scene.origin == "absolute" else "displacement"
    axes.set(xlabel="time (s)", ylabel=f"{kind} ({unit})", xlim=(0, end or 1.0))
    legend_above(axes, 3)


def draw_profile(axes: Axes, result) -> None:
    """Draw peak accelerations of run and column, and the shear-wave velocity, over depth."""
    response, column = result.response, result.response.column
    ends = np.cumsum([0.0, *(layer.thickness for layer in column.layers)])
    theory = abs(response.acceleration(ends)).max(axis=1)
    depth, peak = result.points
    axes.plot(theory, ends, color=ORANGE, ls="--", label="1-D column")
    axes.plot(peak, depth, "o", color=BLUE, ms=5, clip_on=False, label="this run", zorder=4)
    largest = 1.1 * max(float(theory.max()), float(peak.max()))
    axes.set(xlabel="peak acceleration (m/s²)", ylabel="depth (m)", xlim=(0, largest),
             ylim=(column.depth, 0))  # fmt: skip
    speeds = np.array([layer.shear_velocity for layer in column.layers])
    axes.stairs(0.8 * largest * speeds / speeds.max(), ends, orientation="horizontal",
                baseline=None, color=GREY, lw=1.1)  # fmt: skip
    span = " … ".join(dict.fromkeys(f"{speed:.3g}" for speed in (speeds.min(), speeds.max())))
    axes.set_title(f"shear-wave velocity (grey): {span} m/s", loc="left", y=1.0, fontsize=9)
    axes.legend(frameon=False, fontsize=8.5, loc="upper left", bbox_to_anchor=(0.0, -0.2), ncols=2)


def draw_budget(axes: Axes, budget: Budget) -> None:
    """Draw energies as stacked areas, and the residual of the budget separately."""
    samples = np.unique(np.linspace(0, len(budget.time) - 1, _SAMPLES).astype(int))
    time = budget.time[samples]
    size, unit = in_unit(float(budget.given.max(initial=0.0)), "J/m")
    parts = [values[samples] / size for values in budget.parts.values()]
    axes.stackplot(time, parts, labels=list(budget.parts), colors=COLORS, alpha=0.75, lw=0)
    axes.plot(time, budget.given[samples] / size, color=INK, lw=1.0, label="supplied energy")
    end = float(time[-1]) or 1.0
    axes.set(ylabel=f"energy ({unit})", xlim=(0, end), ylim=(0, None))
    axes.tick_params(labelbottom=False)
    legend_above(axes, 3)
    below = axes.inset_axes((0.0, -_RESIDUAL - 0.06, 1.0, _RESIDUAL))
    largest = float(abs(budget.residual).max(initial=0.0))
    size, unit = in_unit(largest, "J/m")
    below.plot(time, budget.residual[samples] / size, color=INK, lw=0.8)
    bound = largest / size or 1.0
    below.set(xlim=(0, end), xlabel="time (s)", ylim=(-1.1 * bound, 1.1 * bound))
    values = (-bound, 0, bound)
    labels = [f"{value:.2g}".replace("-", "−") for value in values]
    below.set_yticks(values, labels=labels, fontsize=7)
    below.annotate(f"residual of the energy budget ({unit})", (0.01, 1.0), xycoords="axes fraction",
                  va="top", fontsize=7.5, color=FAINT)  # fmt: skip


def mean_step(history) -> float:
    """Return the mean time between two samples, s."""
    time = history.time.values
    return float(time[-1] - time[0]) / (len(time) - 1)


def draw_ratio(axes: Axes, history, result: Amplification, discrete) -> None:
    """Draw the amplification of the run and of the theory."""
    axes.plot(result.frequency, result.ratio, color=BLUE, lw=1.5, label="this run")
    # Centres are frequencies of bins, so that each window contains a sample.
    every = slice(None, None, 1 + result.frequency.size // _SMOOTHED)
    bins, ratio = result.frequency[every], result.ratio[every]
    centres = bins[:: max(1, bins.size // 150)]
    curve = smooth_konno_ohmachi(bins, ratio, 40.0, centres)
    axes.plot(centres, curve, color=GREY, lw=1.0, label="smoothed, Konno–Ohmachi, b = 40")
    if discrete is not None:
        label = "transfer function of the discrete model"
        axes.plot(bins, abs(discrete[every]), color=INK, lw=1.1, ls=":", label=label)
    _draw_theory(axes, history, result, bins)
    peak = result.peak
    axes.plot(peak.frequency, peak.amplitude, "o", color=BLUE, ms=5)
    right = peak.frequency > 0.6 * result.frequency[-1]
    axes.annotate(
        f"{peak.amplitude:.2f} at {peak.frequency:.2f} Hz",
        (peak.frequency, peak.amplitude),
        xytext=(-10 if right else 10, -2),
        ha="right" if right else "left",
        textcoords="offset points",
        fontsize=9.5,
        color=INK,
    )
    axes.set(
        xlabel="frequency (Hz)",
        ylabel=plain(folded(f"{result.surface} / {result.base}", _TEXT_HEIGHT, 10)),
        xlim=(result.frequency[0], result.frequency[-1]),
        ylim=(0, None),
    )
    legend_above(axes, 2)


def curves_of(scene: Scene) -> list[tuple]:
    """Return label, displacement (m), acceleration (m/s²) and style of the curves of a run.

    The curves are measured points and incoming motions; equal incoming motions are one curve.
    """
    curves: list[tuple] = []
    history = scene.data
    displacement = np.ptp(history.displacement.values, axis=0).max(axis=-1)
    most_moving = np.sort(np.argsort(-displacement, kind="stable")[:_MOST_POINTS])
    for name, color in zip(history.point.values[most_moving], COLORS, strict=False):
        point = history.sel(point=name)
        displacement = point["displacement"].values - scene.base_history
        axis = main_axis(displacement)
        acceleration = point["acceleration"].values[:, axis]
        label = f"{name}, {'xy'[axis]}"
        curves.append((label, displacement[:, axis], acceleration, {"color": color}))
    drawn_motions = []
    for i, name in enumerate(history.boundary.values if "boundary" in history.coords else ()):
        boundary = history.isel(boundary=i)
        axis = main_axis(boundary["incoming_displacement"].values)
        displacement, acceleration = (boundary[f"incoming_{n}"].values[:, axis]
                                      for n in ("displacement", "acceleration"))  # fmt: skip
        if any(
            np.allclose(displacement, drawn, atol=_MOTION_TOLERANCE * np.ptp(displacement))
            for drawn in drawn_motions
        ):
            continue
        style = {"color": GREY, "ls": ("-", "--", ":")[len(drawn_motions) % 3], "zorder": 1.5}
        curves.append((f"{_INCOMING}{name}, {'xy'[axis]}", displacement, acceleration, style))
        drawn_motions.append(displacement)
    return curves


def mark_stages(axes: Axes, scene: Scene, named: bool = True) -> None:
    """Shade every second stage, and write the names of stages."""
    starts = scene.stage_starts()
    if not starts:
        return
    ends = [begin for _, begin in starts[1:]] + [float(scene.data.time[-1])]
    for i, ((name, begin), end) in enumerate(zip(starts, ends, strict=True)):
        if i % 2:
            axes.axvspan(begin, end, color=FAINT, alpha=0.12, lw=0, zorder=0)
        fraction = (end - begin) / (ends[-1] - starts[0][1] or 1.0)
        if named and fraction > _LEAST_WIDTH:
            label, position = plain(folded(name, _TEXT_HEIGHT, 8, most_lines=1)), (begin, 1.0)
            style = {"fontsize": 8, "color": FAINT, "va": "top", "ha": "left"}
            style["rotation"] = 0 if fraction > _LETTER * len(name) else 90
            axes.annotate(label, position, xytext=(2, -2), xycoords=("data", "axes fraction"),
                          textcoords="offset points", zorder=1, **style)  # fmt: skip


def _draw_theory(axes: Axes, history: xr.Dataset, result: Amplification, frequencies) -> None:
    """Draw the amplification of the one-dimensional column, damped by scheme and materials."""
    try:
        column = layered_soils(history, result.surface, result.base)[0]
    except ValueError:
        return
    time_step = float(history.time_step[-1])
    scheme = run_scheme(history)
    speed = column.depth / column.travel_time
    has_damping = any(layer.damping for layer in column.layers)
    uniform = len({(layer.shear_velocity, layer.density) for layer in column.layers}) == 1
    if uniform and not has_damping:
        damping = scheme_damping(frequencies, time_step, scheme)
        theory = damped_amplification(frequencies, column.depth, speed, damping)
    else:
        theory = abs(column.scheme_transfer(frequencies, time_step, integration=scheme))
    label = "1-D theory with damping of the scheme" + " and the materials" * has_damping
    axes.plot(frequencies, np.asarray(theory), color=ORANGE, lw=1.2, ls="--", label=label)
