# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of mechanisms, capacity curves and performance points."""

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.patches import Patch

from ..report.layout import Head, headline, plain
from ..report.style import BLUE, EDGE, INK, RED, STONE, new_figure

FILLS = {"stable": STONE, "slides": "#8fb8de", "topples": "#e59a86"}
_LONGEST_ARROW = 0.12  # length of the longest arrow as a fraction of the size of the model


def draw_mechanism(result, axes=None, title: str = "", subtitle: str = ""):
    """Draw a mechanism: undisplaced blocks, coloured by their verdicts, and displacement arrows.

    `axes`: axes to draw in; default: those of a new figure.
    """
    vertices = np.vstack(result.polygons)
    low, high = vertices.min(0), vertices.max(0)
    size = float((high - low).max())
    if axes is None:
        width, height = (high - low) / size
        axes = new_figure(size=(3.0 + 7.0 * width, 1.2 + 7.0 * height))[1]
    _draw_blocks(axes, result.polygons, result.verdicts, 0.8)
    centres = np.array([polygon.mean(0) for polygon in result.polygons])
    shift = result.displacement[:, :2]
    peak = float(np.hypot(*shift.T).max(initial=0.0))
    moving = np.array([verdict != "stable" for verdict in result.verdicts])
    if peak > 0.0 and moving.any():
        arrows = (shift * (_LONGEST_ARROW * size / peak))[moving]
        colors = [RED if v == "topples" else BLUE for v in result.verdicts if v != "stable"]
        axes.quiver(*centres[moving].T, *arrows.T, color=colors, angles="xy", scale_units="xy",
                    scale=1.0, width=0.004)  # fmt: skip
    handles = _count_verdicts(result.verdicts) + _draw_lines(axes, result.lines)
    if (thrust := getattr(result, "thrust", None)) is not None and len(thrust):
        handles.append(_draw_thrust(axes, result, thrust))
    margin = 0.04 * size
    axes.set(xlim=(low[0] - margin, high[0] + margin), ylim=(low[1] - margin, high[1] + margin))
    axes.set(aspect="equal", xlabel="x (m)", ylabel="y (m)")
    axes.legend(handles=handles, frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    Head(axes, title, [subtitle])
    return axes


def _draw_blocks(axes, polygons, verdicts, width: float) -> None:
    """Draw blocks coloured by their verdicts; `width` is that of their outlines in points."""
    fills = [FILLS[verdict] for verdict in verdicts]
    style = {"facecolors": fills, "edgecolors": EDGE, "linewidths": width}
    axes.add_collection(PolyCollection(polygons, **style))


def _draw_lines(axes, lines) -> list:
    """Draw bolts and water surfaces; return one handle per kind for the legend."""
    handles = {}
    for kind, line in lines:
        style = {"color": INK, "lw": 1.6} if kind == "bolt" else {"color": BLUE, "ls": "--"}
        handles[kind] = axes.plot(*line.T, label=kind, **style)[0]
    return list(handles.values())


def _draw_thrust(axes, result, thrust: np.ndarray):
    """Draw the line of thrust through the joints of each block; its width shows the force."""
    segments, forces = [], []
    for i in range(len(result.polygons)):
        rows = thrust[(thrust[:, :2] == i).any(axis=1)]
        if len(rows) > 1:
            middle = rows[:, 2:4].mean(axis=0)
            ends = [rows[1, 2:4]] if len(rows) == 2 else [middle] * len(rows)
            segments += [[point[2:4], end] for point, end in zip(rows, ends, strict=False)]
            forces += [np.hypot(*point[4:6]) for point, _ in zip(rows, ends, strict=False)]
    widths = 0.5 + 3.0 * np.array(forces) / max(forces, default=1.0)
    line = LineCollection(segments, colors=RED, linewidths=widths, label="line of thrust")
    axes.add_collection(line)
    return line


def _count_verdicts(verdicts) -> list[Patch]:
    """Return legend handles with colour and number of blocks of each verdict that occurs."""
    return [Patch(fc=fill, ec=EDGE, label=f"{name}: {verdicts.count(name)}")
            for name, fill in FILLS.items() if name in verdicts]  # fmt: skip


def pushover_figure(result, limits=None):
    """Draw a capacity curve, the energy dissipated by slip, and the blocks at the end.

    `limits`: limits to draw as horizontal lines L (lower) and U (upper).
    """
    figure, (curve, blocks) = new_figure(1, 2, (11, 4.6))
    distance = 1e3 * result.displacement
    curve.plot(distance, result.factor, color=BLUE)
    curve.plot(1e3 * result.at_peak, result.peak, "o", color=BLUE)
    levels = ((limits.lower, "L", "top"), (limits.upper, "U", "bottom")) if limits else ()
    for limit, text, side in levels:
        curve.axhline(limit.factor, color=INK, ls="--", lw=0.8)
        curve.annotate(text, (0.0, limit.factor), va=side, ha="right")
    labels = {"tilt": "tangent of the tilt", "mode": "load in the first mode / weight"}
    curve.set(xlabel=f"displacement of {result.point} (mm)", ylim=(0, None),
              ylabel=labels.get(result.load, "horizontal load / weight"))  # fmt: skip
    right = curve.twinx()
    right.plot(distance, result.friction, color=RED, lw=0.8)
    right.set_ylabel("energy dissipated by slip (J/m)", color=RED)
    _draw_blocks(blocks, result.polygons, result.block_verdicts, 0.6)
    blocks.autoscale()
    blocks.set(aspect="equal", xlabel="x (m)", ylabel="y (m)")
    headline(figure, "Capacity, and blocks at the end", plain(result.ending))
    blocks.legend(handles=_count_verdicts(result.verdicts), frameon=False, loc="upper left",
                  bbox_to_anchor=(1.0, 1.0))  # fmt: skip
    return figure


def performance_figure(result):
    """Draw capacity curve, equivalent oscillator and elastic spectrum over displacement."""
    figure, axes = new_figure(size=(6.4, 4.6))
    unit = np.array([1e3, 1.0])
    for values, style, label in (
        (result.spectrum, {"color": INK, "lw": 0.9}, "elastic spectrum"),
        (result.curve, {"color": BLUE}, "pushover"),
        (result.equivalent, {"color": BLUE, "ls": "--", "lw": 0.9}, "equivalent oscillator"),
    ):
        axes.plot(*(values * unit).T, label=label, **style)
    height = float(result.curve[:, 1].max())
    slope = (2 * np.pi / result.period) ** 2
    axes.axline((0.0, 0.0), slope=slope * 1e-3, color=INK, ls=":", lw=0.8,
                label=f"T = {result.period:.3g} s")  # fmt: skip
    demand = np.interp(result.demand, *result.curve.T)
    axes.plot(1e3 * result.demand, demand, "o", color=RED, label="performance point")
    axes.axvline(1e3 * result.capacity, color=RED, lw=0.8, label="capacity")
    width = 1.3e3 * max(result.demand, result.capacity)
    top = 1.3 * max(height, float(result.spectrum[:, 1].max()))
    axes.set(xlim=(0, width), ylim=(0, top), xlabel="displacement of the oscillator (mm)",
             ylabel="acceleration (m/s²)")  # fmt: skip
    axes.legend(frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    Head(axes, "Stands" if result.stands else "Fails", [str(result)])
    return figure
