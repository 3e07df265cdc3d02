# SPDX-License-Identifier: GPL-3.0-or-later
"""Figures without a window system, their look, and blocks drawn as they stand.

Figures are made and saved on a canvas of their own; the backend of matplotlib is left alone.
"""

from __future__ import annotations

from contextlib import contextmanager

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

__all__ = [
    "BLUE",
    "COLORS",
    "FIELD",
    "GREEN",
    "GREY",
    "GROUND",
    "INK",
    "ORANGE",
    "PURPLE",
    "RED",
    "STONE",
    "bare",
    "canvas",
    "draw_blocks",
    "new_figure",
    "slope_guide",
    "small_axes",
]

INK, GREY = "#222222", "#6b6b6b"
BLUE, ORANGE, GREEN, RED, PURPLE = "#1f5fa8", "#e07b00", "#2f8f4e", "#c23b3b", "#7a4fa3"
COLORS = (BLUE, ORANGE, GREEN, PURPLE, RED, GREY)
STONE, GROUND, FIELD = "#d9c9a8", "#a9a296", "#b9a13c"

_SMALL = {
    "font.size": 9.5,
    "font.family": "DejaVu Sans",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "0.9",
    "grid.linewidth": 0.7,
    "axes.edgecolor": "0.35",
    "axes.axisbelow": True,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "lines.linewidth": 1.4,
    "axes.titlesize": 10,
    "axes.titlelocation": "left",
}


def new_figure(rows: int = 1, columns: int = 1, size=(9.0, 6.0), **options):
    """A figure and its axes, as of `matplotlib.pyplot.subplots`, but of no window.

    Parameters
    ----------
    rows, columns : int
        Of the grid of axes.
    size : (float, float)
        Inches.
    **options
        For `matplotlib.figure.Figure.subplots`; ``height_ratios`` and the like among them.
    """
    figure = Figure(figsize=size, layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.subplots(rows, columns, **options)


@contextmanager
def small_axes(figure: Figure, rows: int = 1, columns: int = 1, size=(6.6, 3.7), **options):
    """The axes of an empty figure in the look of small pictures.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
    rows, columns, size, **options
        See `new_figure`.
    """
    with matplotlib.rc_context(_SMALL):
        figure.set_size_inches(size)
        figure.set_layout_engine("constrained")
        yield figure.subplots(rows, columns, **options)


def canvas(columns: int = 2, rows: int = 1, size=(10.0, 4.2), **more):
    """A figure and its axes, shape (rows × columns,), without top and right spines."""
    figure, axes = new_figure(rows, columns, size, squeeze=False, **more)
    for one in axes.flat:
        one.spines[["top", "right"]].set_visible(False)
    return figure, axes.ravel()


def draw_blocks(axes, polygons, color=STONE, edge="0.25", alpha=1.0, lw=0.6, **more) -> None:
    """Draw blocks to scale.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    polygons : sequence of array_like, shape (vertices, 2)
        m.
    color : color or sequence of colors
        Of the faces, one for all or one for each.
    edge : color
    alpha : float
        Opacity, 0 … 1.
    lw : float
        Width of the edges, points.
    **more
        For `matplotlib.collections.PolyCollection`.
    """
    axes.add_collection(
        PolyCollection(
            [np.asarray(polygon) for polygon in polygons],
            facecolors=color,
            edgecolors=edge,
            linewidths=lw,
            alpha=alpha,
            **more,
        )
    )
    axes.set_aspect("equal")
    axes.autoscale_view()


def bare(axes) -> None:
    """Take ticks and frame away, for drawings to scale."""
    axes.set_xticks([])
    axes.set_yticks([])
    axes.spines[:].set_visible(False)


def slope_guide(axes, x, y, order: float, text: str) -> None:
    """A dotted line of a given order through the last point of a log-log series."""
    x = np.asarray(x, dtype=float)
    axes.loglog(x, y[-1] * (x / x[-1]) ** order, ":", color="0.5", lw=1.2, label=text)
