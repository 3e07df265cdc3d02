# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of columns under motions, alone or compared with a run."""

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from ..base.numbers import shown
from ..drawing.pictures import BlockPicture, view_box
from ..engine.signals import spectral_acceleration
from ..report.layout import headline, plain
from ..report.style import BLUE, FAINT, GREEN, INK, ORANGE, RED, empty_figure

PERIODS = np.logspace(-1.7, 0.7, 120)  # s
_WIDTH = 7.4  # inches, width of the model below the surface amplification
_LEVELS = 40  # number of levels of the map
_RATIOS = (0.1, 0.2, 0.3, 0.5, 0.7, 1, 1.4, 2, 3, 5, 10)
_TICKS = (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50)  # Hz
REFERENCE, COLUMN, BLOCKS = FAINT, ORANGE, BLUE
_SITE = ["spectra", "acceleration", "strain", "stress", "loop"]  # panels of yielding soil


def _make_panels(size: tuple[float, float], names: list[str]):
    """Return a figure and its panels by name: 'motion' above the named ones."""
    figure = empty_figure(size)
    rows = [["motion"] * len(names), names]
    return figure, figure.subplot_mosaic(rows, height_ratios=[1, 1.7])


def response_figure(response) -> Figure:
    """Draw motions, spectra and profiles of a column."""
    figure, axes = _make_panels((11, 7.2), ["spectra", "acceleration", "strain"])
    _draw_motion_panel(axes["motion"], response)
    _draw_spectra(axes["spectra"], response.motion.time_step, {
        "reference": (response.motion.acceleration, REFERENCE, "-"),
        "surface": (response.acceleration(), COLUMN, "-"),
    })  # fmt: skip
    profile = response.profile()
    axes["acceleration"].plot(profile.acceleration, profile.depth, color=COLUMN)
    axes["acceleration"].set(xlabel="peak acceleration (m/s²)", xlim=(0, None))
    strain = 100 * np.append(profile.strain.values, profile.strain.values[-1])
    axes["strain"].step(strain, profile.depth, where="pre", color=COLUMN)
    axes["strain"].set(xlabel="peak shear strain (%)", xlim=(0, None))
    for name in ("acceleration", "strain"):
        axes[name].set(ylabel="depth (m)", ylim=(response.column.depth, 0))
    subtitle = "; ".join(filter(None, (response.words, response.convention)))
    headline(figure, "Column under a motion", subtitle)
    return figure


def profile_figure(profile) -> Figure:
    """Draw velocities, density and damping of a site over depth."""
    figure = empty_figure((9, 5))
    velocity, density, damping = figure.subplots(1, 3, sharey=True, width_ratios=[2, 1, 1])
    media = [*profile.layers, *filter(None, [profile.half_space])]
    bottom = 1.15 * profile.depth if profile.half_space else profile.depth
    boundaries = np.append(profile.tops[: len(media)], bottom)

    def steps(axes, values, color, label=""):
        style = {"orientation": "horizontal", "baseline": None, "color": color, "label": label}
        axes.stairs(values, boundaries, **style)

    steps(velocity, [layer.shear_velocity for layer in media], BLOCKS, "$V_s$")
    if np.isfinite([layer.pressure_velocity for layer in media]).all():
        steps(velocity, [layer.pressure_velocity for layer in media], COLUMN, "$V_p$")
    velocity.legend(frameon=False)
    velocity.set(xlabel="velocity (m/s)", ylabel="depth (m)", ylim=(bottom, 0), xlim=(0, None))
    steps(density, [layer.density for layer in media], BLOCKS)
    density.set(xlabel="density (kg/m³)")
    steps(damping, [100 * layer.damping for layer in media], BLOCKS)
    damping.set(xlabel="damping ratio (%)", xlim=(0, None))
    mean_text = f"$V_{{s30}}$ = {profile.mean_velocity():.0f} m/s"
    headline(figure, f"{profile.file.stem}: {mean_text}")
    return figure


def nonlinear_figure(response) -> Figure:
    """Draw motions, spectra, profiles and the loop of largest strain of a yielding column."""
    figure, axes = _make_panels((14.5, 7.2), _SITE)
    _draw_motion_panel(axes["motion"], response)
    _draw_site_panels(axes, {"nonlinear": response})
    headline(figure, "Nonlinear column", response.words)
    return figure


def analyses_figure(analyses) -> Figure:
    """Draw spectra, profiles and the loop of largest strain of three analyses."""
    figure = empty_figure((14.5, 4.8))
    axes = figure.subplot_mosaic([_SITE])
    _draw_site_panels(axes, analyses.responses)
    headline(figure, "Three analyses of a column", analyses.nonlinear.words)
    return figure


def _draw_motion_panel(axes, response) -> None:
    """Draw surface and reference motion over time."""
    _draw_histories(axes, response.time, "acceleration (m/s²)", {
        "surface": (response.acceleration(), COLUMN, "-"),
        "reference motion": (response.motion.acceleration, REFERENCE, "-"),
    })  # fmt: skip


def _draw_histories(axes, time, label: str, series) -> None:
    """Draw accelerations over time, each with its colour and line; the legend is above."""
    for name, (values, color, style) in series.items():
        axes.plot(time, values, color=color, ls=style, lw=0.8, label=name)
    axes.set(xlabel="time (s)", ylabel=label, xlim=(time[0], time[-1]))
    axes.legend(frameon=False, ncols=2, loc="lower right", bbox_to_anchor=(1.0, 1.0))


_ANALYSES = {"linear": (GREEN, ":"), "equivalent-linear": (RED, "--"), "nonlinear": (COLUMN, "-")}


def _draw_site_panels(axes, responses, other_series=None) -> None:
    """Draw spectra, also of others, and profiles by analysis; and the loop of the nonlinear one."""
    nonlinear = responses["nonlinear"]
    depth = nonlinear.column.depth
    series = {"reference": (nonlinear.motion.acceleration, REFERENCE, "-")}
    series |= {name: (r.acceleration(), *_ANALYSES[name]) for name, r in responses.items()}
    _draw_spectra(axes["spectra"], nonlinear.motion.time_step, series | (other_series or {}))
    for name, response in responses.items():
        color, style = _ANALYSES[name]
        profile = response.profile()
        axes["acceleration"].plot(profile.acceleration, profile.depth, color=color, ls=style)
        axes["strain"].plot(100 * profile.strain, profile.middle, color=color, ls=style)
        axes["stress"].plot(profile.stress / 1e3, profile.middle, color=color, ls=style)
    axes["acceleration"].set(xlabel="peak acceleration (m/s²)", xlim=(0, None))
    axes["strain"].set(xlabel="peak shear strain (%)", xscale="log")
    axes["stress"].set(xlabel="peak shear stress (kPa)", xlim=(0, None))
    for name in ("acceleration", "strain", "stress"):
        axes[name].set(ylabel="depth (m)", ylim=(depth, 0))
    _draw_loop(axes["loop"], nonlinear)


def _draw_loop(axes, response) -> None:
    """Draw stress over strain of the cell with the largest strain."""
    histories = response.histories
    cell = int(histories.largest_strain.argmax())
    axes.plot(100 * histories.strain[cell], histories.stress[cell] / 1e3, color=COLUMN, lw=0.6)
    depth = histories.interfaces[cell : cell + 2].mean()
    axes.set(xlabel="shear strain (%)", ylabel="shear stress (kPa)")
    axes.set_title(f"at {depth:.3g} m depth")


def beside_figure(comparison) -> Figure:
    """Draw a run of blocks and its column in one picture."""
    (depth, peak), (middle, strain) = comparison.points, comparison.strains
    blocks = {"blocks (DDA)": (comparison.surface, BLOCKS, "-")}
    if comparison.yields:
        figure, axes = _make_panels((14.5, 7.6), _SITE)
        _draw_site_panels(axes, comparison.columns, blocks)
        axes["strain"].plot(100 * strain, middle, "o", color=BLOCKS, ms=5)
    else:
        figure, axes = _make_panels((11, 7.6), ["ratio", "spectra", "acceleration"])
        _draw_ratio(axes["ratio"], comparison)
        _draw_peaks(axes["acceleration"], comparison.response, peak)
        series = {"base": (comparison.base, REFERENCE, "-"), **blocks,
                  "column": (comparison.column_surface, COLUMN, "--")}  # fmt: skip
        _draw_spectra(axes["spectra"], comparison.response.motion.time_step, series)
    _draw_histories(axes["motion"], comparison.time, "surface (m/s²)", blocks | {
        f"column, {comparison.words.partition(';')[0]}": (comparison.column_surface, COLUMN, "--"),
    })  # fmt: skip
    axes["acceleration"].plot(peak, depth, "o", color=BLOCKS, ms=5)
    headline(figure, plain(comparison.title))
    return figure


def _draw_ratio(axes, data) -> None:
    axes.plot(data.frequency, abs(data.ratio), color=BLOCKS, lw=0.9, label="blocks (DDA)")
    axes.plot(data.frequency, abs(data.column_ratio), color=COLUMN, lw=0.9, ls="--")
    axes.set(xlabel="frequency (Hz)", ylabel="surface/base", ylim=(0, None))
    axes.set_xlim(data.frequency[0], data.frequency[-1])


def _draw_spectra(axes, step: float, series) -> None:
    """Draw response spectra of accelerations, each with its colour and line."""
    for name, (values, color, style) in series.items():
        spectrum = spectral_acceleration(values, step, PERIODS)
        axes.semilogx(PERIODS, spectrum, color=color, ls=style, label=name)
    axes.set(xlabel="period (s)", ylabel="Sa, 5 % (m/s²)", ylim=(0, None))
    axes.legend(frameon=False, fontsize=8)


def _draw_peaks(axes, response, other_peaks) -> None:
    """Draw peak accelerations of a column over depth, with room for others."""
    profile, depth = response.profile(), response.column.depth
    axes.plot(profile.acceleration, profile.depth, color=COLUMN, ls="--")
    largest = max(other_peaks.max(), float(profile.acceleration.max()))
    axes.set(xlabel="peak acceleration (m/s²)", ylabel="depth (m)", xlim=(0, 1.1 * largest),
             ylim=(1.03 * depth, -0.03 * depth))  # fmt: skip


def surface_figure(surface) -> Figure:
    """Draw amplification along the surface, peaks and the model below each other."""
    low, high = view_box(surface.scene)
    height = _WIDTH * (high - low)[1] / (high - low)[0]
    figure = empty_figure((9.5, 5.0 + height))
    map_, peaks, blocks = figure.subplots(3, 1, height_ratios=[3, 1.0, height + 0.4])
    _draw_map(map_, surface)
    for values, color, label in (
        (surface.peak_acceleration, BLOCKS, "peak acceleration"),
        (surface.peak_velocity, COLUMN, "peak velocity"),
        (surface.aggravation_factor, GREEN, "2-D / 1-D amplification, mean"),
    ):
        peaks.plot(surface.place[:, 0], values, "o-", color=color, ms=4, lw=1.2, label=label)
    peaks.axhline(1.0, color=REFERENCE, lw=0.8)
    peaks.set_ylabel("ratio")
    peaks.legend(frameon=False, ncols=3, loc="lower left", bbox_to_anchor=(0.0, 1.0))
    picture = BlockPicture(surface.scene, "material", axes=blocks, legend=False)
    picture.show(0)
    picture.head.note.remove()
    blocks.set_title("", loc="left")
    blocks.set_aspect("equal", adjustable="datalim")
    blocks.set_autoscale_on(True)  # the first drawing adapts its limits to the scale
    headline(figure, plain(surface.scene.title))
    figure.draw_without_rendering()
    blocks.set_aspect("auto")
    for axes in (map_, peaks):
        axes.set_xlim(blocks.get_xlim())
    return figure


def section_figure(surface, axis: str = "x"):
    """Draw the velocity histories of the points along the surface by their position."""
    data, positions = surface.scene.data, surface.place[:, 0]
    traces = data.velocity.sel(point=surface.names, axis=axis).values
    peak = float(abs(traces).max()) or 1.0
    spacing = float(np.median(np.diff(positions)))
    figure = empty_figure((9.5, 6.0))
    axes = figure.subplots()
    time = data.time.values
    for x, trace in zip(positions, traces.T, strict=True):
        offsets = x + 0.9 * spacing * trace / peak
        axes.plot(offsets, time, color=BLUE, lw=0.7)
        axes.fill_betweenx(time, x, offsets, where=offsets > x, color=BLUE, alpha=0.35, lw=0)
    axes.set(xlabel="x (m)", ylabel="time (s)", ylim=(time[-1], time[0]))
    headline(figure, plain(surface.scene.title),
             f"velocity along {axis} of the surface points; the largest, "
             f"{shown(peak, 'm/s')}, has a width of 0.9 of the point spacing")  # fmt: skip
    return figure


def _draw_map(axes, surface) -> None:
    """Draw amplification by position and frequency; white is 1."""
    ratio = surface.amplification
    limit = max(float(ratio.max()), 1.0 / float(ratio.min()), 1.01)
    levels, norm = np.geomspace(1.0 / limit, limit, _LEVELS), LogNorm(1.0 / limit, limit)
    grid = surface.place[:, 0], surface.frequency, ratio.T
    contours = axes.contourf(*grid, levels=levels, cmap="RdBu_r", norm=norm)
    for x in surface.place[:, 0]:
        axes.axvline(x, color=INK, lw=0.6, ls=":", alpha=0.5)
    ticks = [f for f in _TICKS if surface.frequency[0] <= f <= surface.frequency[-1]]
    axes.set(yscale="log", ylabel="frequency (Hz)")
    axes.set_yticks(ticks, labels=[f"{tick:g}" for tick in ticks])
    axes.minorticks_off()
    title = f"relative to the {surface.reference}; interpolated between points (dotted)"
    axes.set_title(plain(title), loc="left", fontsize=10)
    bar = axes.figure.colorbar(contours, ax=axes, aspect=18, pad=0.02, label="amplification")
    ratios = [r for r in _RATIOS if 1.0 / limit <= r <= limit]
    bar.set_ticks(ratios, labels=[f"{r:g}" for r in ratios])
    bar.minorticks_off()
    bar.outline.set_visible(False)
