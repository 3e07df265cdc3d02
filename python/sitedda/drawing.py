"""The look of all figures, and blocks drawn as they stand."""

from __future__ import annotations

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

THEORY = "0.15"
BLUE, ORANGE, GREEN, RED, PURPLE = "#1f6fb4", "#e07b00", "#2f8f4e", "#c23b3b", "#7a58b0"
COLORS = (BLUE, ORANGE, GREEN, PURPLE, RED)
STONE, GROUND = "#d9c9a8", "#a9a296"


def canvas(columns: int = 2, rows: int = 1, size=(10.0, 4.2), **more):
    """A figure and its axes, without top and right spines."""
    figure = Figure(figsize=size, layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, **more)
    for one in axes.flat:
        one.spines[["top", "right"]].set_visible(False)
    return figure, axes.ravel()


def draw_blocks(axes, polygons, color=STONE, edge="0.25", alpha=1.0, lw=0.6, **more) -> None:
    """Draw polygons to scale; `color` may be a list, one for each."""
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
