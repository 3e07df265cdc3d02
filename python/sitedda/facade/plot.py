# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw the picture of a run, chosen by its purpose, and the panels of a record."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..drawing.quantities import limits_of, movement_limits, rounding
from ..engine.signals import arias_growth
from ..output.energies import budget
from ..output.response import Amplification
from ..output.scene import Scene
from ..output.verdict import (
    PERIODS,
    acceleration_spectrum,
    have_fallen,
    resolved_frequency,
)
from ..report.layout import headline, place_panels, plain
from ..report.style import BLUE, ORANGE, RULE, empty_figure, save_picture
from ..site.beside import beside
from .panels import (
    curves_of,
    draw_budget,
    draw_displacements,
    draw_profile,
    draw_site,
    draw_spectra,
    mark_stages,
    mean_step,
    spectrum_axes,
    title_and_damping,
)
from .purpose import LEAST_DRAWN, Purpose, purpose_of

if TYPE_CHECKING:
    import xarray as xr

    from ..drawing.pictures import BlockPicture

_RECORD_UNITS = {"acceleration": "m/s²", "velocity": "m/s", "displacement": "m"}
_BLOCKS_WIDTH = 3.5  # inches, width of the blocks in a picture with two columns
_SITE_HEIGHT = 7.1  # inches, height of the panels of a level site with their labels
# Left and bottom ends, width and height of these panels, inches.
_SITE_PANELS = {
    "profile": (0.8, 4.11, 3.16, 2.57),
    "surface": (4.76, 5.55, 6.1, 1.13),
    "base": (4.76, 4.11, 6.1, 1.13),
    "spectra": (0.8, 0.5, 3.16, 2.36),
    "ratio": (4.76, 0.5, 6.1, 2.36),
}
_PANEL, _TITLES = 3.4, 0.9  # inches: height of a row; of titles and labels of blocks

CAPTIONS = {
    "site": "Profile of the site, motions, response spectra, and amplification with theory.",
    "surface": "Amplification along the surface over frequency, its peaks, and the model.",
    "shake": "The model, its displacements, histories and response spectra.",
    "forces": "The model, its contact forces and its displacements.",
}


def run_picture(source: xr.Dataset | Scene | Purpose, discrete=None) -> Figure:
    """Draw the picture of a run, by its purpose.

    `source`: output of a finished run.
    `discrete`: exact transfer function of the model at the frequencies of its amplification.
    """
    subject = source if isinstance(source, Purpose) else purpose_of(source)
    history = subject.scene.data
    if isinstance(subject.of, Amplification):
        return _site_picture(subject.scene, history, subject.of, discrete)
    if subject.of is not None:
        return subject.of.plot()
    return _draw_general_picture(subject.scene, history, subject.kind == "shake")


def _site_picture(scene: Scene, history, result: Amplification, discrete) -> Figure:
    """Draw a site: profile or blocks, accelerations, response spectra and amplification."""
    try:
        column = beside(history, result.surface, result.base)
    except ValueError:  # the ground is not level
        figure = empty_figure((11, 7.6))
        _draw_title(figure, history, result.peak.frequency)
        axes = figure.subplot_mosaic(
            [["profile", "surface"], ["profile", "base"], ["spectra", "ratio"]],
            width_ratios=[1, 1.9],
            height_ratios=[1, 1, 2.1],
        )
        style = {"color": "material", "legend": False}
        _draw_blocks(axes["profile"], scene, "The model", scene.frames - 1, **style)
    else:
        figure = empty_figure((11, _SITE_HEIGHT), None)
        title_height = _draw_title(figure, history, result.peak.frequency)
        figure.set_size_inches(11, _SITE_HEIGHT + title_height)
        axes = place_panels(figure, _SITE_PANELS)
        draw_profile(axes["profile"], column)
    draw_site(axes, scene, result, discrete)
    return figure


def _draw_general_picture(scene: Scene, history, shaken: bool) -> Figure:
    """Draw the model and its forces or displacements, and below them two panels of curves."""
    last, floor = [scene.frames - 1], rounding(scene)
    smallest = max(floor["m"], LEAST_DRAWN * scene.size * (not shaken))
    moving = limits_of(scene, "displacement", last).most > smallest
    samples = history.sizes.get("time", 0) > 2
    points = samples and "point_place" in history and len(scene.points()) > 0
    curves = [c for c in curves_of(scene) if abs(c[1]).max() > smallest] if points else []
    below = ["moved"] * bool(moving and not shaken) + ["curves"] * bool(curves)
    below += ["spectra"] * bool(shaken and _drop_fallen(scene, curves))
    below += ["energies"] * bool(samples and moving)
    below = below[:2] if len(below) > 1 else []
    figure = empty_figure((11, 8))
    _draw_title(figure, history)
    rows = 1 + bool(below)
    # Blocks have the same scale in all panels of a grid; curves need other widths.
    grid = figure.add_gridspec(rows, 2 if "moved" in below else 1)
    parts = [grid] if "moved" in below else [grid[row].subgridspec(1, 2) for row in range(rows)]
    panels = [figure.add_subplot(spot) for part in parts for spot in part]
    end = scene.frames - 1
    pictures = [_draw_blocks(panels[0], scene, "The model", 0, color="material")]
    if shaken:
        pictures.append(_draw_movements(panels[1], scene, smallest))
    else:
        style = {"color": "compression", "contacts": "force"}
        pictures.append(_draw_blocks(panels[1], scene, "Forces at the end", end, **style))
    height = [_row_height(scene, pictures)] + [_PANEL] * bool(below)
    for axes, name in zip(panels[2:], below, strict=False):
        if name == "moved":
            height[1] = _row_height(scene, [_draw_movements(axes, scene, smallest)])
        else:
            _draw_panel(axes, name, scene, history, curves)
    grid.set_height_ratios(height)
    figure.set_size_inches(11, 0.7 + sum(height))
    for axes in panels[2 + len(below) :]:
        axes.remove()
    return figure


def _draw_panel(axes, name: str, scene: Scene, history, curves) -> None:
    """Draw a lower panel: 'curves' (displacements), 'spectra' or 'energies'."""
    if name == "curves":
        draw_displacements(axes, scene, curves)
        mark_stages(axes, scene)
    elif name == "spectra":
        shaken = _drop_fallen(scene, curves)
        motions, looks = {c[0]: c[2] for c in shaken}, [c[3] for c in shaken]
        draw_spectra(axes, history, motions, looks, resolved_frequency(history))
    else:
        draw_budget(axes, budget(history))


def _drop_fallen(scene: Scene, curves) -> list[tuple]:
    """Return the curves of points whose block has not fallen."""
    is_fallen = have_fallen(scene, scene.frames - 1)
    if not is_fallen.any():
        return curves
    from shapely import Point, Polygon, distance

    outlines = np.array([Polygon(corners) for corners in scene.polygons(0)])
    landed = set()
    for point in scene.points():
        block = int(np.argmin(distance(outlines, Point(point["x"], point["y"]))))
        if is_fallen[scene.names.index(point["block"]) if point["block"] else block]:
            landed.add(point["name"])
    return [one for one in curves if one[0].rpartition(",")[0] not in landed]


def _draw_blocks(axes, scene: Scene, title: str, frame: int, **look) -> BlockPicture:
    """Draw the blocks of a frame under a title; return the picture."""
    from ..drawing.pictures import BlockPicture  # 0.01 s

    picture = BlockPicture(scene, axes=axes, title=title, **look)
    picture.show(frame)
    return picture


def _draw_movements(axes, scene: Scene, smallest: float) -> BlockPicture:
    """Draw displacements, and the larger of slip and opening if it exceeds `least` (m)."""
    last = scene.frames - 1
    slip, gap = (movement_limits(scene, name, [last]).high for name in ("slip", "opening"))
    contacts = "slip" if slip >= gap else "opening"
    if max(slip, gap) <= smallest:
        contacts = None
    style = {"color": "displacement", "contacts": contacts}
    return _draw_blocks(axes, scene, "Displacements at the end", last, **style)


def _draw_title(figure, history, *frequencies: float) -> float:
    """Draw the title of a run, and below it the damping of its model at frequencies (Hz).

    The height of both (inches) is returned.
    """
    return headline(figure, *title_and_damping(history, *frequencies))


def _row_height(scene: Scene, pictures: list[BlockPicture]) -> float:
    """Return the height (inches) of a row of pictures of blocks with their keys."""
    from ..drawing.pictures import view_box

    width, height = np.subtract(*view_box(scene)[::-1])
    tall = float(np.clip(_BLOCKS_WIDTH * height / width, 1.2, 4.0))
    return max(tall, *(panel.keys.height for panel in pictures)) + _TITLES + 0.18 * max(
        panel.head.lines for panel in pictures)  # fmt: skip


def record_panels(motion: xr.Dataset, file) -> Path:
    """Draw a record: motion, response spectrum and growth of the Arias intensity.

    `motion`: result of `sitedda.read_record`.
    `file`: picture to write.
    """
    figure = empty_figure((11, 6.4))
    rows = [[name, "spectrum"] for name in _RECORD_UNITS]
    rows[-1][1] = "arias"
    panels = figure.subplot_mosaic(rows, width_ratios=[1.7, 1])
    for name, unit in _RECORD_UNITS.items():
        _draw_series(panels[name], motion, name, unit)
    panels["displacement"].set_xlabel("time (s)")
    acceleration, step = motion.acceleration.values, mean_step(motion)
    panels["spectrum"].plot(PERIODS, acceleration_spectrum(acceleration, step), color=BLUE)
    spectrum_axes(panels["spectrum"])
    panels["arias"].plot(motion.time, arias_growth(acceleration, step), color=BLUE, lw=1.2)
    panels["arias"].set(xlabel="time (s)", ylabel="Arias intensity (m/s)")
    panels["arias"].set_xlim(0, float(motion.time[-1]))
    title = motion.attrs.get("station", "") or motion.attrs["file"]
    headline(figure, plain(title))
    return save_picture(figure, file, [motion.attrs["file"]], dpi=130)


def _draw_series(axes: Axes, motion: xr.Dataset, name: str, unit: str) -> None:
    """Draw a quantity over time and mark its largest value."""
    series = motion[name].values
    peak = int(abs(series).argmax())
    axes.axhline(0.0, color=RULE, lw=0.6)
    axes.plot(motion.time, series, color=BLUE, lw=0.7)
    axes.plot(motion.time[peak], series[peak], "o", color=ORANGE, ms=4)
    axes.set(ylabel=f"{name} ({unit})", xlim=(0, float(motion.time[-1])))
    axes.set_title(f"largest {name}: {abs(float(series[peak])):.4g} {unit}", loc="right",
                   fontsize=9)  # fmt: skip
