"""One look for all pictures of the report."""

from __future__ import annotations

from contextlib import contextmanager

from matplotlib import rc_context
from matplotlib.figure import Figure

__all__ = ["COLORS", "FIELD", "PAPER", "SITEDDA", "THEORY", "figure"]

SITEDDA = "#1f5fa8"
THEORY = "#c8442d"
PAPER = "#222222"
FIELD = "#b9a13c"
COLORS = ["#1f5fa8", "#e08a1e", "#3a8f5c", "#c8442d", "#7a4fa3", "#6b6b6b"]

_STYLE = {
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


@contextmanager
def figure(drawing: Figure, rows: int = 1, columns: int = 1, size=(6.6, 3.7), **options):
    """Axes of a figure in the look of the report.

    Parameters
    ----------
    drawing : matplotlib.figure.Figure
        Empty.
    rows, columns : int
        Of the grid of axes.
    size : (float, float)
        Inches.
    **options
        For `matplotlib.figure.Figure.subplots`; also width_ratios and height_ratios.
    """
    with rc_context(_STYLE):
        drawing.set_size_inches(size)
        drawing.set_layout_engine("constrained")
        yield drawing.subplots(rows, columns, **options)
