# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of mechanisms, capacity curves and performance points."""

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.patches import Patch

from ..report.layout import Head, headline, plain
from ..report.style import BLUE, EDGE, INK, RED, STONE, new_figure

FILLS = {"stable": STONE, "slides": "#8fb8de", "topples": "#e59a86"}
_LONGEST_ARROW = 0.12  # length of the longest arrow as a fraction of the size of the model


def draw_mechanism(found, axes=None, title: str = "", words: str = ""):
    """Draw a mechanism: undisplaced blocks, coloured by their verdicts, and displacement arrows.

    Parameters
    ----------
    found : Mechanism or Limit
    axes : matplotlib.axes.Axes, optional
        Axes to draw in; default: those of a new figure.
    title, words : str
        Title and subtitle.

    Returns
    -------
    matplotlib.axes.Axes
    """
    places = np.vstack(found.polygons)
    low, high = places.min(0), places.max(0)
    size = float((high - low).max())
    if axes is None:
        wide, tall = (high - low) / size
        axes = new_figure(size=(3.0 + 7.0 * wide, 1.2 + 7.0 * tall))[1]
    _draw_blocks(axes, found.polygons, found.verdicts, 0.8)
    centres = np.array([polygon.mean(0) for polygon in found.polygons])
    moved = found.displacement[:, :2]
    most = float(np.hypot(*moved.T).max(initial=0.0))
    moving = np.array([verdict != "stable" for verdict in found.verdicts])
    if most > 0.0 and moving.any():
        arrows = (moved * (_LONGEST_ARROW * size / most))[moving]
        colors = [RED if v == "topples" else BLUE for v in found.verdicts if v != "stable"]
        axes.quiver(*centres[moving].T, *arrows.T, color=colors, angles="xy", scale_units="xy",
                    scale=1.0, width=0.004)  # fmt: skip
    handles = _count_verdicts(found.verdicts) + _draw_lines(axes, found.lines)
    if (thrust := getattr(found, "thrust", None)) is not None and len(thrust):
        handles.append(_draw_thrust(axes, found, thrust))
    margin = 0.04 * size
    axes.set(xlim=(low[0] - margin, high[0] + margin), ylim=(low[1] - margin, high[1] + margin))
    axes.set(aspect="equal", xlabel="x (m)", ylabel="y (m)")
    axes.legend(handles=handles, frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    Head(axes, title, [words])
    return axes


def _draw_blocks(axes, polygons, verdicts, width: float) -> None:
    """Draw blocks coloured by their verdicts; `width` is that of their outlines in points."""
    fills = [FILLS[verdict] for verdict in verdicts]
    axes.add_collection(
        PolyCollection(polygons, facecolors=fills, edgecolors=EDGE, linewidths=width)
    )


def _draw_lines(axes, lines) -> list:
    """Draw bolts and water surfaces; return one handle per kind for the legend."""
    handles = {}
    for kind, line in lines:
        style = {"color": INK, "lw": 1.6} if kind == "bolt" else {"color": BLUE, "ls": "--"}
        handles[kind] = axes.plot(*line.T, label=kind, **style)[0]
    return list(handles.values())


def _draw_thrust(axes, found, thrust: np.ndarray):
    """Draw the line of thrust through the joints of each block; its width shows the force."""
    segments, forces = [], []
    for i in range(len(found.polygons)):
        mine = thrust[(thrust[:, :2] == i).any(axis=1)]
        if len(mine) > 1:
            middle = mine[:, 2:4].mean(axis=0)
            ends = [mine[1, 2:4]] if len(mine) == 2 else [middle] * len(mine)
            segments += [[one[2:4], end] for one, end in zip(mine, ends, strict=False)]
            forces += [np.hypot(*one[4:6]) for one, _ in zip(mine, ends, strict=False)]
    widths = 0.5 + 3.0 * np.array(forces) / max(forces, default=1.0)
    line = LineCollection(segments, colors=RED, linewidths=widths, label="line of thrust")
    axes.add_collection(line)
    return line


def _count_verdicts(verdicts) -> list[Patch]:
    """Return legend handles with colour and number of blocks of each verdict that occurs."""
    return [Patch(fc=fill, ec=EDGE, label=f"{name}: {verdicts.count(name)}")
            for name, fill in FILLS.items() if name in verdicts]  # fmt: skip


def pushover_figure(found, limits=None):
    """Draw a capacity curve, the energy dissipated by slip, and the blocks at the end.

    Parameters
    ----------
    found : Pushover
    limits : Limits, optional
        Limits to draw as horizontal lines L (lower) and U (upper).

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure, (curve, blocks) = new_figure(1, 2, (11, 4.6))
    way = 1e3 * found.displacement
    curve.plot(way, found.factor, color=BLUE)
    curve.plot(1e3 * found.at_peak, found.peak, "o", color=BLUE)
    for limit, words, side in (
        ((limits.lower, "L", "top"), (limits.upper, "U", "bottom")) if limits else ()
    ):
        curve.axhline(limit.factor, color=INK, ls="--", lw=0.8)
        curve.annotate(words, (0.0, limit.factor), va=side, ha="right")
    what = {"tilt": "tangent of the tilt", "mode": "load in the first mode / weight"}
    curve.set(xlabel=f"displacement of {found.point} (mm)", ylim=(0, None),
              ylabel=what.get(found.load, "horizontal load / weight"))  # fmt: skip
    right = curve.twinx()
    right.plot(way, found.friction, color=RED, lw=0.8)
    right.set_ylabel("lost by slip (J/m)", color=RED)
    _draw_blocks(blocks, found.polygons, found.block_verdicts, 0.6)
    blocks.autoscale()
    blocks.set(aspect="equal", xlabel="x (m)", ylabel="y (m)")
    headline(figure, "Capacity, and blocks at the end", plain(found.ending))
    blocks.legend(handles=_count_verdicts(found.verdicts), frameon=False, loc="upper left",
                  bbox_to_anchor=(1.0, 1.0))  # fmt: skip
    return figure


def performance_figure(found):
    """Draw capacity curve, equivalent oscillator and elastic spectrum over displacement.

    Parameters
    ----------
    found : Performance

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure, axes = new_figure(size=(6.4, 4.6))
    unit = np.array([1e3, 1.0])
    for values, style, words in (
        (found.spectrum, {"color": INK, "lw": 0.9}, "elastic spectrum"),
        (found.curve, {"color": BLUE}, "pushover"),
        (found.equivalent, {"color": BLUE, "ls": "--", "lw": 0.9}, "equivalent oscillator"),
    ):
        axes.plot(*(values * unit).T, label=words, **style)
    height = float(found.curve[:, 1].max())
    slope = (2 * np.pi / found.period) ** 2
    axes.axline((0.0, 0.0), slope=slope * 1e-3, color=INK, ls=":", lw=0.8,
                label=f"T = {found.period:.3g} s")  # fmt: skip
    at = np.interp(found.demand, *found.curve.T)
    axes.plot(1e3 * found.demand, at, "o", color=RED, label="performance point")
    axes.axvline(1e3 * found.capacity, color=RED, lw=0.8, label="capacity")
    wide = 1.3e3 * max(found.demand, found.capacity)
    tall = 1.3 * max(height, float(found.spectrum[:, 1].max()))
    axes.set(xlim=(0, wide), ylim=(0, tall), xlabel="displacement of the oscillator (mm)",
             ylabel="acceleration (m/s²)")  # fmt: skip
    axes.legend(frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    Head(axes, "Stands" if found.stands else "Fails", [str(found)])
    return figure
