# SPDX-License-Identifier: GPL-3.0-or-later
"""The style of all figures of matplotlib: layout, colours of three schemes and saving.

Figures have their own canvas and do not use the backend of matplotlib.  They are drawn in the
colours of the light scheme, which `dress` replaces by those of another scheme.
"""

from collections.abc import Iterable
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import Collection, PolyCollection
from matplotlib.colors import LinearSegmentedColormap, to_hex, to_rgba
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.text import Text

from ..base.files import written
from . import colors
from .colors import EDGE, PAPER, RULE, SCHEMES, STONE

# Colours from light to strong: lighter than block outlines, with other hues than `MAGNITUDE`.
_SHADES = ["#ffd9a8", "#ff8c42", "#e5352b", "#a3003f"]
JOINT_MAP = LinearSegmentedColormap.from_list("joints", _SHADES)


def __getattr__(name: str) -> str:
    """Return a colour of `colors` by its name."""
    return getattr(colors, name)


def new_figure(rows: int = 1, columns: int = 1, size=(9.0, 6.0), **options):
    """Create a figure and its axes, like `matplotlib.pyplot.subplots` but without a window.

    `size`: width and height, inches; `**options`: for `matplotlib.figure.Figure.subplots`.
    """
    figure = empty_figure(size)
    return figure, figure.subplots(rows, columns, **options)


def empty_figure(size, layout: str | None = "constrained") -> Figure:
    """Create a figure without axes; `size` is width and height in inches.

    With `layout` None, the figure has no layout engine: its axes need positions.
    """
    figure = Figure(figsize=size, layout=_TwoLayouts() if layout else "none")
    FigureCanvasAgg(figure)
    return figure


class _TwoLayouts(ConstrainedLayoutEngine):
    """Constrained layout, first of all axes as if they had no scale, then with the actual ticks.

    Without the first layout, axes with equal scales would move in each of about ten layouts.
    """

    def execute(self, fig) -> None:
        """Compute the layout of a figure."""
        aspects = {axes: axes.get_aspect() for axes in fig.axes}
        for axes in aspects:
            axes.set_aspect("auto")
        try:
            super().execute(fig)
        finally:
            for axes, aspect in aspects.items():
                axes.set_aspect(aspect)
        if set(aspects.values()) != {"auto"}:
            super().execute(fig)


@contextmanager
def small_axes(figure: Figure, rows: int = 1, columns: int = 1, size=(6.6, 3.7), **options):
    """Create the axes of an empty figure in the style of small pictures.

    `rows`, `columns`, `size`, `**options`: see `new_figure`.
    """
    style = {"font.size": 9.5, "axes.grid": True, "grid.color": RULE, "grid.linewidth": 0.7,
             "axes.axisbelow": True, "legend.fontsize": 8.5, "lines.linewidth": 1.4,
             "axes.titlesize": 10, "axes.titlelocation": "left"}  # fmt: skip
    with matplotlib.rc_context(style):
        figure.set_size_inches(size)
        figure.set_layout_engine("constrained")
        yield figure.subplots(rows, columns, **options)


def canvas(columns: int = 2, rows: int = 1, size=(10.0, 4.2), **options):
    """Create a figure and its axes, shape (rows × columns,)."""
    figure, axes = new_figure(rows, columns, size, squeeze=False, **options)
    return figure, axes.ravel()


@contextmanager
def dressed(figure: Figure, scheme: str):
    """Yield a figure in the colours of a scheme, and restore the light scheme."""
    dress(figure, scheme)
    try:
        yield
    finally:
        dress(figure, "light", scheme)


def dress(figure: Figure, scheme: str = "light", present: str = "light") -> Figure:
    """Apply the common style and a scheme to all axes of a figure; return the figure.

    `present`: present scheme of the figure.
    """
    artists = figure.findobj()
    for axes in artists:
        if hasattr(axes, "spines"):
            _dress_axes(axes, SCHEMES[present]["faint"])
    figure.set_facecolor(SCHEMES[present]["paper"])
    color_of = {SCHEMES[present][name]: color for name, color in SCHEMES[scheme].items()}
    color_of |= {"#000000": SCHEMES[scheme]["ink"]}
    for artist in artists:
        if isinstance(artist, Text | Line2D | Patch | Collection):
            _recolor(artist, color_of)
    return figure


def _dress_axes(axes, faint: str) -> None:
    """Apply the style to axes: two spines only, titles at the left, legends without a frame."""
    bar = hasattr(axes, "_colorbar")
    if not bar:
        right = axes.yaxis.get_ticks_position() == "right"
        axes.spines["top"].set_visible(False)
        axes.spines["left" if right else "right"].set_visible(False)
        axes.spines[["left", "bottom", "right"]].set_color(faint)
        axes.tick_params(which="both", color=faint)
    title = axes.get_title("center")
    if title and not axes.get_title("left"):
        axes.set_title(title, loc="left", fontsize=10)
        axes.set_title("", loc="center")
    if legend := axes.get_legend():
        legend.set_frame_on(False)


@lru_cache(maxsize=256)
def _to_hex(color) -> str:
    """Return a colour as #rrggbb; '' if it is invisible."""
    return to_hex(color) if to_rgba(color)[3] else ""


def _recolor(artist, color_of: dict[str, str]) -> None:
    """Replace the colours of an artist by the colours to which `color_of` maps them."""

    def replaced(color):
        try:
            return color_of.get(_to_hex(color if isinstance(color, str) else tuple(color)), color)
        except (TypeError, ValueError):
            return color

    if isinstance(artist, Text):
        artist.set_color(replaced(artist.get_color()))
        for effect in artist.get_path_effects():
            stroke = getattr(effect, "_gc", {})
            stroke["foreground"] = replaced(stroke.get("foreground", PAPER))
    elif isinstance(artist, Line2D):
        artist.set_color(replaced(artist.get_color()))
        artist.set_markerfacecolor(replaced(artist.get_markerfacecolor()))
        artist.set_markeredgecolor(replaced(artist.get_markeredgecolor()))
    elif isinstance(artist, Patch):
        if artist.get_alpha() is None:
            artist.set_edgecolor(replaced(artist.get_edgecolor()))
            artist.set_facecolor(replaced(artist.get_facecolor()))
    else:
        edges = artist.get_edgecolor()
        if artist.get_array() is None or isinstance(artist, PolyCollection):
            artist.set_edgecolor([replaced(color) for color in edges] or "none")


def save_picture(figure, file, inputs: Iterable = (), scheme: str = "light", **options) -> Path:
    """Save a figure in the format of the file's ending (PNG if it has none); return the file.

    `inputs`: files that the same command reads; `**options`: options of ``savefig``.
    """
    file = Path(file)
    file = file if file.suffix else file.with_name(f"{file.name}.png")
    with (
        written(file, "a picture", inputs) as temporary,
        # The hinting of letters takes an eighth of the time of a picture.
        matplotlib.rc_context({"text.hinting": "none"}),
        _fix_layout(dress(figure, scheme), **options),
    ):
        if file.suffix == ".png":  # level 6 takes 3 times as long for 10 % smaller files
            options |= {"pil_kwargs": {"compress_level": 2}}
        figure.savefig(temporary, **options)
    return file


@contextmanager
def _fix_layout(figure: Figure, dpi: float | None = None, **_options):
    """Compute the layout of a figure before `savefig`, which would compute it twice."""
    engine, initial_dpi = figure.get_layout_engine(), figure.dpi
    if engine is not None:
        figure.dpi = dpi or initial_dpi
        engine.execute(figure)
        with matplotlib.rc_context({"figure.constrained_layout.use": False}):
            figure.set_layout_engine(None)  # with 'none', `savefig` would draw twice
    try:
        yield
    finally:
        if engine is not None:
            figure.set_layout_engine(engine)
            figure.dpi = initial_dpi


def draw_blocks(axes, polygons, color=STONE, edge=EDGE, alpha=1.0, lw=0.6, **options) -> None:
    """Draw blocks to scale.

    `polygons`: shape (vertices, 2); m.
    `color`: colour of the faces, one for all or one for each.
    `alpha`: opacity, 0 … 1.
    `lw`: width of the edges, points.
    `options`: for `matplotlib.collections.PolyCollection`.
    """
    axes.add_collection(PolyCollection([np.asarray(polygon) for polygon in polygons],
                                       facecolors=color, edgecolors=edge, linewidths=lw,
                                       alpha=alpha, **options))  # fmt: skip
    axes.set_aspect("equal")
    axes.autoscale_view()


def bare(axes) -> None:
    """Remove ticks and frame of axes, for drawings to scale."""
    axes.set_xticks([])
    axes.set_yticks([])
    axes.spines[:].set_visible(False)


def add_legends(figure: Figure) -> None:
    """Add a legend to the axes of a figure that have labelled artists but no legend."""
    for axes in figure.axes:
        if axes.get_legend() is None and axes.get_legend_handles_labels()[0]:
            axes.legend(frameon=False)
