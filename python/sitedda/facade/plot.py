# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture that a run ends with, and the panels of a record.

Only `matplotlib.figure.Figure` is used: the backend of the session stays as it is.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import ScaledTranslation

from ..base.files import save_picture
from ..drawing.pictures import FAINT, INK, draw, in_unit, plain, view_box
from ..engine.scheme import scheme_damping
from ..engine.signals import arias_growth, smooth_konno_ohmachi
from ..output.response import Amplification
from ..output.scene import Scene
from ..output.verdict import (
    PERIODS,
    SPECTRUM_DAMPING,
    acceleration_spectrum,
    damping_words,
    main_axis,
    run_scheme,
)
from ..site.column import damped_amplification
from ..site.twin import layered_twin

BASE, SURFACE, TWIN = "#8a9099", "#0072b2", "#d55e00"
COLORS = (SURFACE, TWIN, "#009e73", "#cc79a7", "#b58900", "#4a4f57")
_MOST_POINTS = 6
_PERIOD_TICKS = (0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5)  # s
_RECORD_UNITS = {"acceleration": "m/s²", "velocity": "m/s", "displacement": "m"}
_SAME = 1e-3  # of a motion: two that differ less are drawn as one
_BLOCKS_WIDTH = 4.2  # inches of the blocks in a picture of two of them
_USUAL_FREQUENCIES = (1.0, 10.0)  # Hz, that damping is said at where no peak is asked for


def run_picture(history: xr.Dataset, found=(), discrete=None) -> Figure:
    """The picture of a run: what it was asked for, and its blocks before and after.

    Parameters
    ----------
    history : xarray.Dataset
        Of a finished run.
    found : sequence of Amplification
        Of `response.amplifications`; the first is drawn.
    discrete : ndarray, optional
        The model's own transfer function at ``found[0].frequency``.
    """
    scene = Scene.of(history)
    if found:
        return _site_picture(scene, history, found[0], discrete)
    if history.sizes.get("time", 0) > 2 and "point_place" in history and len(scene.points()):
        return _history_picture(scene, history)
    figure = Figure(figsize=(11, 1.7 + _blocks_height(scene)), layout="constrained")
    _title(figure, history)
    _before_and_after(figure.subplots(1, 2), scene)
    return figure


def _site_picture(scene: Scene, history, result: Amplification, discrete) -> Figure:
    """Blocks and accelerations above, response spectra and amplification below."""
    figure = Figure(figsize=(11, 7.6), layout="constrained")
    axes = figure.subplot_mosaic(
        [["blocks", "surface"], ["blocks", "base"], ["spectra", "ratio"]],
        width_ratios=[1, 1.9],
        height_ratios=[1, 1, 2.1],
    )
    _small_blocks(axes["blocks"], scene)
    axis = ("x", "y").index(result.direction)
    series = {
        name: history.acceleration.sel(point=name).isel(axis=axis).values
        for name in dict.fromkeys((result.surface, result.base))
    }
    _accelerations((axes["surface"], axes["base"]), history, series)
    for name in ("surface", "base"):
        _mark_stages(axes[name], scene, named=name == "surface")
    _spectra(axes["spectra"], history, series)
    _ratio(axes["ratio"], history, result, discrete)
    _title(figure, history, result.peak.frequency)
    return figure


def _title(figure, history, *frequencies: float) -> None:
    """The title of the run, and under it which damping is in the model at frequencies (Hz)."""
    title = plain(str(history.attrs.get("title", ""))) or "Untitled"
    # The blank line of the title keeps the place of the words from the layout.
    figure.suptitle(f"{title}\n", x=0.01, ha="left", fontsize=13, fontweight="bold", color=INK)
    words = damping_words(history, *(frequencies or _USUAL_FREQUENCIES))
    under = figure.transFigure + ScaledTranslation(0, -0.22, figure.dpi_scale_trans)
    figure.text(0.01, 0.99, words, transform=under, va="top", fontsize=9.5, color="#5b6169")


def _accelerations(panels, history, series: dict) -> None:
    """One panel for each point, one scale for all: none hides another."""
    most = max(float(abs(values).max()) for values in series.values()) or 1.0
    for axes, (name, values), color in zip(panels, series.items(), (SURFACE, BASE), strict=False):
        axes.plot(history.time, values, color=color, lw=0.6)
        axes.set(xlim=(0, float(history.time[-1])), ylim=(-1.08 * most, 1.08 * most))
        axes.set_title(
            f"{plain(name)}: largest {abs(values).max():.3g} m/s²", loc="left", fontsize=9
        )
        axes.set_ylabel("m/s²")
        _bare(axes)
    panels[0].tick_params(labelbottom=False)
    panels[-1].set_xlabel("time (s)")


def _spectra(axes: Axes, history, series: dict) -> None:
    step = _mean_step(history)
    for i, (name, values) in enumerate(series.items()):
        curve, look = acceleration_spectrum(values, step), {"lw": 1.6, "zorder": 4 - i}
        axes.plot(PERIODS, curve, color=(SURFACE, BASE)[i], label=plain(name), **look)
    _spectrum_axes(axes)
    _legend(axes, 2)


def _spectrum_axes(axes: Axes) -> None:
    """Periods from left to right, with ticks that can be read."""
    axes.set_xscale("log")
    axes.set(xlim=(PERIODS[0], PERIODS[-1]), ylim=(0, None), xlabel="period (s)")
    axes.set_ylabel(f"Sa, {SPECTRUM_DAMPING:.0%} damping (m/s²)")
    axes.set_xticks(_PERIOD_TICKS, labels=[f"{tick:g}" for tick in _PERIOD_TICKS])
    axes.minorticks_off()
    _bare(axes)


def _mean_step(history) -> float:
    return float(history.time[-1] - history.time[0]) / (history.sizes["time"] - 1)


def _ratio(axes: Axes, history, result: Amplification, discrete) -> None:
    """Amplification of the run with what theory says of it."""
    axes.plot(result.frequency, result.ratio, color=SURFACE, lw=1.5, label="this run")
    _smoothed(axes, result)
    if discrete is not None:
        label = "exact discrete theory of the model"
        axes.plot(result.frequency, abs(discrete), color=INK, lw=1.1, ls=":", label=label)
    _theory(axes, history, result)
    peak = result.peak
    axes.plot(peak.frequency, peak.amplitude, "o", color=SURFACE, ms=5)
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
        ylabel=f"{plain(result.surface)} / {plain(result.base)}",
        xlim=(result.frequency[0], result.frequency[-1]),
        ylim=(0, None),
    )
    _bare(axes)
    _legend(axes, 2)


def _history_picture(scene: Scene, history) -> Figure:
    """Blocks before and after, displacements of the measured points, response spectra."""
    blocks, curves = _blocks_height(scene), _curves(history)
    figure = Figure(figsize=(11, 4.4 + blocks), layout="constrained")
    _title(figure, history)
    above, below = figure.subfigures(2, 1, height_ratios=[blocks + 0.7, 3.7])
    _before_and_after(above.subplots(1, 2), scene)
    left, right = below.subplots(1, 2)
    size, unit = in_unit(max(float(abs(moved).max()) for _, moved, _, _ in curves), "m")
    step = _mean_step(history)
    for label, moved, acceleration, look in curves:
        left.plot(history.time, moved / size, lw=1.1, label=plain(label), **look)
        spectrum = acceleration_spectrum(acceleration, step)
        right.plot(PERIODS, spectrum, lw=1.4, label=plain(label), **look)
    _mark_stages(left, scene)
    left.set(xlabel="time (s)", ylabel=f"displacement ({unit})", xlim=(0, float(history.time[-1])))
    _bare(left)
    _legend(left, 3)
    _spectrum_axes(right)
    _legend(right, 3)
    return figure


def _curves(history) -> list[tuple]:
    """Label, displacement (m), acceleration (m/s²) and look of what histories show.

    Measured points, and what comes in through boundaries: one curve of several that are the same.
    """
    found = []
    for name, color in zip(_liveliest(history), COLORS, strict=False):
        point = history.sel(point=name)
        axis = main_axis(point.velocity)
        pair = (point[n].values[:, axis] for n in ("displacement", "acceleration"))
        found.append((f"{name}, {'xy'[axis]}", *pair, {"color": color}))
    seen = []
    for name in history.boundary.values if "boundary" in history.coords else ():
        boundary = history.sel(boundary=name)
        axis = main_axis(boundary.incoming_velocity)
        moved, acceleration = (
            boundary[f"incoming_{n}"].values[:, axis] for n in ("displacement", "acceleration")
        )
        if any(np.allclose(moved, other, atol=_SAME * np.ptp(moved)) for other in seen):
            continue
        look = {"color": BASE, "ls": ("-", "--", ":")[len(seen) % 3], "zorder": 1.5}
        found.append((f"incoming: {name}, {'xy'[axis]}", moved, acceleration, look))
        seen.append(moved)
    return found


def _blocks_height(scene: Scene) -> float:
    """Inches that two pictures of the blocks beside each other need."""
    width, height = np.subtract(*view_box(scene)[::-1])
    return float(np.clip(_BLOCKS_WIDTH * height / width, 1.2, 4.0))


def _liveliest(history) -> list[str]:
    """The measured points that move most."""
    moved = np.ptp(history.displacement.values, axis=0).max(axis=-1)
    order = np.argsort(-moved, kind="stable")[:_MOST_POINTS]
    return [str(history.point.values[i]) for i in sorted(order)]


def _before_and_after(panels, scene: Scene) -> None:
    before, after = panels
    draw(scene, time=float(scene.time[0]), color="material", axes=before)
    draw(scene, axes=after)
    before.set_title("Before", loc="left", fontsize=10, fontweight="bold", pad=24)
    after.set_title("After", loc="left", fontsize=10, fontweight="bold", pad=24)


def _mark_stages(axes: Axes, scene: Scene, named: bool = True) -> None:
    """A line where each stage begins, every other stage shaded, names along the upper end."""
    starts = scene.stage_starts()
    if not starts:
        return
    ends = [begin for _, begin in starts[1:]] + [float(scene.data.time[-1])]
    for i, ((name, begin), end) in enumerate(zip(starts, ends, strict=True)):
        if i % 2:
            axes.axvspan(begin, end, color=FAINT, alpha=0.12, lw=0, zorder=0)
        if named and end > begin:
            place = (begin, 1.0)
            look = {"fontsize": 8, "color": FAINT, "rotation": 90, "va": "top", "ha": "left"}
            axes.annotate(plain(name), place, xytext=(2, -2), xycoords=("data", "axes fraction"),
                          textcoords="offset points", zorder=1, **look)  # fmt: skip


def _small_blocks(axes: Axes, scene: Scene) -> None:
    draw(scene, axes=axes)
    axes.set_title("Blocks at the end", loc="left", fontsize=9.5, pad=22)


def _legend(axes: Axes, columns: int) -> None:
    """Above the panel, where no data can be."""
    axes.legend(
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        ncols=columns,
        frameon=False,
        fontsize=8.5,
        borderaxespad=0.2,
        handlelength=1.6,
        columnspacing=1.2,
    )


def _bare(axes: Axes) -> None:
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(FAINT)
    axes.tick_params(color=FAINT)


def _smoothed(axes: Axes, result: Amplification) -> None:
    """The curve smoothed, for the eye; the peak is read from the raw one."""
    # Centres on the bins themselves, so that no window is empty, however coarse the spectrum.
    centres = result.frequency[:: max(1, result.frequency.size // 300)]
    curve = smooth_konno_ohmachi(result.frequency, result.ratio, 40.0, centres)
    axes.plot(centres, curve, color=BASE, lw=1.0, label="smoothed, Konno–Ohmachi, b = 40")


def _theory(axes: Axes, history: xr.Dataset, result: Amplification) -> None:
    """The one-dimensional twin with the damping of the scheme and of the materials."""
    try:
        column = layered_twin(history, result.surface, result.base)
    except ValueError:
        return
    time_step = float(history.time_step[-1])
    scheme = run_scheme(history)
    speed = column.depth / column.travel_time
    damped = any(layer.damping for layer in column.layers)
    uniform = len({(layer.shear_velocity, layer.density) for layer in column.layers}) == 1
    if uniform and not damped:
        damping = scheme_damping(result.frequency, time_step, scheme)
        theory = damped_amplification(result.frequency, column.depth, speed, damping)
    else:
        theory = abs(column.scheme_transfer(result.frequency, time_step, integration=scheme))
    label = "1-D theory, damping of the scheme" + " and the materials" * damped
    axes.plot(result.frequency, np.asarray(theory), color=TWIN, lw=1.2, ls="--", label=label)


def record_panels(motion: xr.Dataset, file) -> Path:
    """Draw a record: its motion, its response spectrum, and how its Arias intensity grows.

    Parameters
    ----------
    motion : xarray.Dataset
        Of `sitedda.read_record`.
    file : path
        Picture to write.
    """
    figure = Figure(figsize=(11, 6.4), layout="constrained")
    rows = [[name, "spectrum"] for name in _RECORD_UNITS]
    rows[-1][1] = "arias"
    panels = figure.subplot_mosaic(rows, width_ratios=[1.7, 1])
    for name, unit in _RECORD_UNITS.items():
        _record_series(panels[name], motion, name, unit)
    panels["displacement"].set_xlabel("time (s)")
    acceleration, step = motion.acceleration.values, _mean_step(motion)
    panels["spectrum"].plot(PERIODS, acceleration_spectrum(acceleration, step), color=SURFACE)
    _spectrum_axes(panels["spectrum"])
    panels["arias"].plot(motion.time, arias_growth(acceleration, step), color=SURFACE, lw=1.2)
    panels["arias"].set(
        xlabel="time (s)", ylabel="Arias intensity (m/s)", xlim=(0, float(motion.time[-1]))
    )
    _bare(panels["arias"])
    title = motion.attrs.get("station", "") or motion.attrs["file"]
    figure.suptitle(plain(title), fontsize=10)
    return save_picture(figure, file, [motion.attrs["file"]], dpi=130)


def _record_series(axes: Axes, motion: xr.Dataset, name: str, unit: str) -> None:
    """One quantity over time, its largest value marked."""
    series = motion[name].values
    peak = int(abs(series).argmax())
    axes.axhline(0.0, color="0.8", lw=0.6)
    axes.plot(motion.time, series, color=SURFACE, lw=0.7)
    axes.plot(motion.time[peak], series[peak], "o", color=TWIN, ms=4)
    axes.set(ylabel=f"{name} ({unit})", xlim=(0, float(motion.time[-1])))
    axes.set_title(f"largest {abs(float(series[peak])):.4g} {unit}", loc="right", fontsize=9)
    _bare(axes)
