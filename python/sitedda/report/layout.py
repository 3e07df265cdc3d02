# SPDX-License-Identifier: GPL-3.0-or-later
"""Place the texts of figures: titles above panels, and legends in a column beside the axes.

Texts are measured before they are placed, so that they neither overlap nor leave the figure.
"""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.transforms import ScaledTranslation

from ..base.numbers import number
from .colors import FAINT, INK
from .words import folded, plain

_MARGIN = 0.9  # inches between the left end of a panel and its axes
_SMALL = 8.5  # font size of keys (parts of a legend), points
_LABEL = 0.29  # inches between an axis and its label, for tick labels of one line
_EDGE = 0.05  # inches between a title and the upper edge of a figure without a layout engine
_LINE = 1.25 / 72  # line height in inches per point of font size
_KEY_DISTANCE, _GAP = 0.12, 0.16  # inches between axes and keys, and between two keys
_BAR = (0.15, 1.0)  # width and height of a colour bar, inches
_KEY_WIDTH = 1.55  # inches, width of the text of a key
_HANDLE = 0.4  # inches, width of the symbol beside the text of a legend


def panel_width(axes: Axes) -> float:
    """Return the width of a panel to the right of the left side of its axes, inches."""
    figure_width = axes.figure.bbox.width / axes.figure.dpi
    subplot = axes.get_subplotspec()
    if subplot is None:
        return axes.get_position(original=True).width * figure_width
    fraction = 1.0
    for spec in {subplot, subplot.get_topmost_subplotspec()}:
        ratios = np.array(spec.get_gridspec().get_width_ratios(), dtype=float)
        fraction *= ratios[spec.colspan.start : spec.colspan.stop].sum() / ratios.sum()
    return figure_width * fraction - _MARGIN


def headline(figure: Figure, title: str, subtitle: str = "") -> float:
    """Draw a title above all panels, at the left, with a fainter text below.

    `figure`: its layout engine, if it has one, reserves space for both texts.
    `title`, `subtitle`: texts in the notation of matplotlib, see `plain`.
    Result: height of both texts, inches.
    """
    width = figure.bbox.width / figure.dpi - 0.4
    title = folded(title, width, 13, True, 2)
    subtitle = folded(subtitle, width, 9.5)
    title_height = (title.count("\n") + 1) * 13 * _LINE + 0.08

    def below_top(distance: float):
        return figure.transFigure + ScaledTranslation(0, -distance, figure.dpi_scale_trans)

    style = {"fontsize": 13, "fontweight": "bold", "color": INK}
    if figure.get_layout_engine() is None:
        figure.text(0.01, 1.0, title, transform=below_top(_EDGE), va="top", **style)
    else:
        # Blank lines of the title reserve space for the text in the layout.
        blank_lines = "\n" * (subtitle.count("\n") + 1) if subtitle else ""
        figure.suptitle(title + blank_lines, x=0.01, ha="left", **style)
    position = below_top(title_height)
    figure.text(0.01, 1.0, subtitle, transform=position, va="top", fontsize=9.5, color=FAINT)
    return title_height + (subtitle.count("\n") + 1) * 9.5 * _LINE


def place_panels(figure: Figure, panels: dict[str, tuple]) -> dict[str, Axes]:
    """Create axes at given positions, in a figure without a layout engine.

    A layout engine draws all texts twice, which takes a quarter of the time of a picture.

    `panels`: left and bottom ends, width and height of each panel, inches.
    """
    size, placed = np.tile(figure.get_size_inches(), 2), {}
    for name, box in panels.items():
        placed[name] = axes = figure.add_axes(tuple(box / size))
        axes.xaxis.set_label_coords(0.5, -_LABEL / box[3])
    return placed


class Head:
    """A title above axes and fainter lines below the title, aligned with the left side.

    `texts`: texts, one of which is shown at a time; space is reserved for the longest one.
    """

    def __init__(self, axes: Axes, title: str, texts=("",)):
        self.width = panel_width(axes)
        self.lines = (max(self._wrap_words(text).count("\n") + 1
                          for text in texts) if any(texts) else 0)  # fmt: skip
        axes.set_title(plain(folded(title, self.width, 12, True, 2)), loc="left", fontsize=12,
                       color=INK, fontweight="bold", pad=11 + 13 * self.lines)  # fmt: skip
        self.note = axes.annotate("", (0, 1), xytext=(0, 8), xycoords="axes fraction",
                                  textcoords="offset points", fontsize=9.5,
                                  color=FAINT)  # fmt: skip
        self.note.set_in_layout(False)
        self.show(texts[0])

    def _wrap_words(self, text: str, most_lines: int = 6) -> str:
        """Wrap a text below the title to the width of the panel."""
        return folded(text, self.width, 9.5, most_lines=most_lines)

    def show(self, text: str) -> None:
        """Show a text; lines that do not fit end with …."""
        text = self._wrap_words(text, self.lines) if self.lines else ""
        self.note.set_text(plain(text) + "\n" * (self.lines - 1 - text.count("\n")))


def legend_above(axes: Axes, columns: int = 3) -> None:
    """Draw the legend above the panel, outside the data, in as many columns as fit."""
    room = panel_width(axes)
    handles, labels = axes.get_legend_handles_labels()
    labels = [folded(label, room - _HANDLE, _SMALL, most_lines=2) for label in labels]
    for count in range(columns, 0, -1):
        legend = axes.legend(handles, labels, loc="lower left", bbox_to_anchor=(0.0, 1.0),
                             ncols=count, frameon=False, fontsize=_SMALL, borderaxespad=0.2,
                             handlelength=1.6, columnspacing=1.2)  # fmt: skip
        if legend.get_window_extent().width <= room * axes.figure.dpi:
            return


class Keys:
    """Keys in a column beside axes: colour bars, lengths and symbols with their meaning.

    `axes`: axes; the column begins at their upper right corner.
    `height`: height of the column, inches.
    """

    def __init__(self, axes: Axes):
        self.axes, self.height = axes, 0.0
        self.origin = axes.figure.dpi_scale_trans + ScaledTranslation(1.0, 1.0, axes.transAxes)

    def bar(self, artist, label: str, locator) -> None:
        """Add the colour bar of a mappable artist, with the ticks of a locator."""
        title = folded(label, _KEY_WIDTH + 0.3, _SMALL)
        width, height = _BAR
        self.height += (title.count("\n") + 1) * _SMALL * _LINE + 7 / 72 + height
        cax = self.axes.inset_axes((_KEY_DISTANCE, -self.height, width, height),
                                   transform=self.origin)  # fmt: skip
        bar = self.axes.figure.colorbar(artist, cax=cax)
        bar.outline.set_visible(False)
        cax.set_title(title, loc="left", fontsize=_SMALL, pad=7)
        cax.tick_params(length=2.5, color=FAINT, labelcolor=INK, labelsize=_SMALL)
        cax.yaxis.set_major_locator(locator)
        cax.yaxis.set_major_formatter(lambda value, _: number(value, 3).replace("-", "−"))
        cax.minorticks_off()
        self.height += _GAP

    def length(self, size: float, label: str) -> None:
        """Add a length of the picture (m) and the value that it represents."""
        from mpl_toolkits.axes_grid1.anchored_artists import AnchoredSizeBar  # 0.01 s

        style = {"frameon": False, "borderpad": 0.0, "sep": 4, "color": INK, "label_top": False}
        style["fontproperties"] = FontProperties(size=_SMALL)
        text = folded(label, _KEY_WIDTH + 0.3, _SMALL)
        bar = AnchoredSizeBar(self.axes.transData, size, text, "upper left", **style,
                              bbox_to_anchor=(_KEY_DISTANCE, -self.height),
                              bbox_transform=self.origin)  # fmt: skip
        bar.size_bar.get_children()[0].set_linewidth(1.6)
        self.axes.add_artist(bar)
        self.height += 6 / 72 + (text.count("\n") + 1) * _SMALL * _LINE + _GAP

    def legend(self, handles: list) -> None:
        """Add symbols, each with its label."""
        labels = [plain(folded(handle.get_label(), _KEY_WIDTH, _SMALL)) for handle in handles]
        legend = self.axes.legend(handles, labels, loc="upper left", frameon=False,
                                  fontsize=_SMALL, bbox_to_anchor=(_KEY_DISTANCE, -self.height),
                                  bbox_transform=self.origin, borderaxespad=0.0, borderpad=0.0,
                                  handlelength=1.8)  # fmt: skip
        self.height += legend.get_window_extent().height / self.axes.figure.dpi
