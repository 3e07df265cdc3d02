"""One look for all pictures of the report."""

from __future__ import annotations

from contextlib import contextmanager
from pathlib import Path

import matplotlib

matplotlib.use("Agg", force=False)
import matplotlib.pyplot as plt  # noqa: E402
from PIL import Image  # noqa: E402

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
_HUES = 64  # of the saved picture: a drawing needs no more, and it stays below 60 kB


@contextmanager
def figure(file: Path, rows: int = 1, columns: int = 1, size=(6.6, 3.7), **options):
    """A figure and its axes, saved to a small PNG at the end.

    Parameters
    ----------
    file : Path
        Picture to write.
    rows, columns : int
        Of the grid of axes.
    size : (float, float)
        Inches.
    **options
        For `matplotlib.pyplot.subplots`.
    """
    with plt.rc_context(_STYLE):
        drawing, axes = plt.subplots(rows, columns, figsize=size, layout="constrained", **options)
        try:
            yield axes
            drawing.savefig(file, dpi=110)
        finally:
            plt.close(drawing)
    with Image.open(file) as picture:
        small = picture.convert("RGB").quantize(_HUES)
    small.save(file, optimize=True)
