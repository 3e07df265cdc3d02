# SPDX-License-Identifier: GPL-3.0-or-later
"""Charts of lines and texts drawn by Pillow, a small substitute for figures of matplotlib.

To import matplotlib and to draw a figure of six panels takes half as long as the steps of a run of
60,000 steps.  A `Panel` has the methods of `matplotlib.axes.Axes` that the panels of a site use, so
that the same functions draw in both.  Lengths are in inches from the lower left corner.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
from PIL import Image, ImageColor, ImageDraw

from ..base.files import written
from .colors import FAINT, INK, PAPER
from .words import folded, font_of

_FINER = 2  # lines are drawn on a finer grid, whose pixels are then averaged
_POINT = 1 / 72  # inches
_LINE = 1.25  # height of a line over the size of its font
_DASHES = {"--": (3.7, 1.6), ":": (1.0, 1.65)}  # lengths of dash and gap over the width of a line
_STEPS = (1.0, 2.0, 2.5, 5.0, 10.0)  # distances of ticks over powers of 10
_EACH = {"x": 0.6, "y": 0.3}  # smallest distance of ticks, inches
_TICK, _PAD = 3.5, 3.5  # length of a tick and distance of its label, points
_MARGIN = 0.05  # free part of an automatic range at its ends
_SMALL, _HANDLE, _BETWEEN = 8.5, 0.19, 0.25  # font size of legends, points; inches of their parts


class Chart:
    """Panels and texts on a page.

    Parameters
    ----------
    size : (float, float)
        Width and height, inches.
    dpi : int
        Pixels per inch.
    """

    def __init__(self, size: tuple[float, float], dpi: int = 130):
        self.size, self.dpi = size, dpi
        self.panels: list[Panel] = []
        self.texts: list[tuple] = []
        wide, tall = (round(length * dpi) for length in size)
        self._image = Image.new("RGB", (_FINER * wide, _FINER * tall), PAPER)
        self._draw = ImageDraw.Draw(self._image)

    def add_panel(self, left: float, width: float) -> Panel:
        """Add a panel; its height is set by `Panel.place`."""
        self.panels.append(Panel(self, left, width))
        return self.panels[-1]

    def text(
        self, x: float, y: float, words: str, size: float, color: str = INK, across: str = "l",
        bold: bool = False, upright: bool = False,
    ) -> None:  # fmt: skip
        """Write lines of text below each other.

        Parameters
        ----------
        x, y : float
            Position of the baseline of the first line.
        words : str
        size : float
            Font size, points.
        color : str
        across : {'l', 'm', 'r'}
            Part of the text at the position: left end, middle or right end.
        bold, upright : bool
            An upright text reads from bottom to top.
        """
        words = words.replace(r"\$", "$").replace("\u200b", "")
        self.texts.append((x, y, words, size, color, across, bold, upright))

    def line(self, points, color: str, width: float, style: str = "-") -> None:
        """Draw a line through points, shape (n, 2); the width is in points."""
        fine = _FINER * self.dpi
        pixels = np.asarray(points) * [fine, -fine] + [0.0, self._image.height]
        thick = max(1, round(width * _POINT * fine))
        for part in _dashed(pixels, style, width * _POINT * fine) if len(pixels) > 1 else ():
            self._draw.line(part.ravel().tolist(), color, thick)

    def disc(self, x: float, y: float, size: float, color: str) -> None:
        """Draw a filled circle; its diameter is in points."""
        fine = _FINER * self.dpi
        centre = x * fine, self._image.height - y * fine
        self._draw.circle(centre, 0.5 * size * _POINT * fine, color)

    def area(self, corners, color: str) -> None:
        """Fill a rectangle between two corners."""
        fine = _FINER * self.dpi
        (left, low), (right, high) = np.asarray(corners) * [fine, -fine] + [0, self._image.height]
        self._draw.rectangle([left, high, right, low], color)

    def save(self, file, reads: Iterable = ()) -> Path:
        """Save the chart as PNG, but not over files that the command `reads`; return the file."""
        for panel in self.panels:
            panel.draw()
            if panel.above:
                panel.above.draw()
        image = self._image.reduce(_FINER)
        for text in self.texts:
            self._write(image, *text)
        with written(file, "a picture", reads) as beside:
            image.save(beside, "PNG", compress_level=1)
        return Path(file)

    def _write(self, image, x, y, words, size, color, across, bold, upright) -> None:
        """Write a text on the pixels of a page."""
        font = font_of(size * _POINT * self.dpi, bold)
        at = x * self.dpi, image.height - y * self.dpi
        if not upright:
            for i, line in enumerate(words.split("\n")):
                place = at[0], at[1] + i * _LINE * size * _POINT * self.dpi
                ImageDraw.Draw(image).text(place, line, color, font, f"{across}s")
            return
        left, top, right, bottom = ImageDraw.Draw(image).multiline_textbbox((0, 0), words, font)
        mask = Image.new("L", (int(right - left) + 2, int(bottom - top) + 2))
        ImageDraw.Draw(mask).multiline_text((1 - left, 1 - top), words, 255, font, align="center")
        mask = mask.transpose(Image.Transpose.ROTATE_90)
        place = round(at[0] - mask.width), round(at[1] - mask.height / 2)
        image.paste(color, (*place, place[0] + mask.width, place[1] + mask.height), mask)


class Panel:
    """A panel of a chart with the methods of `matplotlib.axes.Axes` that it needs."""

    def __init__(self, chart: Chart, left: float, width: float):
        self.chart, self.left, self.width = chart, left, width
        self.bottom = self.height = 0.0
        self.curves: list[tuple] = []
        self.stages: list[tuple] = []
        self.notes: list[tuple] = []
        self.above: Panel | None = None  # panel with another x axis, at the top
        self.legend_height = 0.0
        self.limits: dict[str, list] = {"x": [None, None], "y": [None, None]}
        self.labels = {"x": ("", 10.0, INK), "y": ("", 10.0, INK)}
        self.ticks: dict[str, tuple] = {}
        self.tick_look = (True, INK, 10.0)  # labels of the x axis; colour and size of labels
        self.title = ("", 9.0)
        self.scale = lambda values: np.asarray(values, dtype=float)
        self._legend: tuple | None = None

    def place(self, bottom: float, height: float) -> None:
        """Place the panel between the bottom and the top of its axes."""
        self.bottom, self.height = bottom, height
        if self.above:
            self.above.place(bottom, height)

    # The methods of matplotlib.axes.Axes
    def plot(self, x, y, marks="", *, color=INK, lw=1.5, ls="-", label="", ms=5.0, zorder=2,
             clip_on=True) -> None:  # fmt: skip
        """Draw a line, or discs if `marks` is 'o'."""
        x, y = np.broadcast_arrays(*(np.atleast_1d(np.asarray(one, dtype=float)) for one in (x, y)))
        x, y = (one[np.isfinite(x) & np.isfinite(y)] for one in (x, y))
        self.curves.append((zorder, x, y, color, ms if marks else lw, "o" if marks else ls, label))

    def stairs(self, values, edges, *, orientation, baseline, color, lw) -> None:
        """Draw values between horizontal edges."""
        assert orientation == "horizontal" and baseline is None
        self.plot(np.repeat(values, 2), np.repeat(edges, 2)[1:-1], color=color, lw=lw)

    def axvspan(self, begin, end, *, color, alpha, lw, zorder) -> None:
        """Shade a range of x."""
        mixed = np.array(ImageColor.getrgb(color)) * alpha + 255 * (1 - alpha)
        self.stages.append((begin, end, "#" + bytes(mixed.astype("u1")).hex()))

    def annotate(self, words, at, xytext, textcoords, xycoords="data", *, fontsize, color,
                 ha="left", va="baseline", rotation=0, zorder=0) -> None:  # fmt: skip
        """Write a text at an offset (points) from a position."""
        self.notes.append((words, at, xytext, xycoords, fontsize, color, ha, va, rotation))

    def set(self, **values) -> None:
        """Set limits and labels by name."""
        for name, value in values.items():
            getattr(self, f"set_{name}")(value)

    def set_xlim(self, low, high=None) -> None:
        """Set the limits of x; None is automatic."""
        self.limits["x"] = list(low) if high is None else [low, high]

    def set_ylim(self, low) -> None:
        """Set the limits of y; None is automatic."""
        self.limits["y"] = list(low)

    def set_xlabel(self, words, color=INK, fontsize=10.0) -> None:
        """Set the label of the x axis."""
        self.labels["x"] = (words, fontsize, color)

    def set_ylabel(self, words) -> None:
        """Set the label of the y axis."""
        self.labels["y"] = (words, 10.0, INK)

    def set_title(self, words, loc, fontsize) -> None:
        """Set the title, which begins at the left."""
        self.title = (words, fontsize)

    def set_xscale(self, name) -> None:
        """Set the scale of x."""
        self.scale = {"log": np.log10}[name]

    def set_xticks(self, values, labels) -> None:
        """Set the ticks of x."""
        self.ticks["x"] = (values, labels)

    def minorticks_off(self) -> None:
        """Do nothing: a panel has no minor ticks."""

    def tick_params(self, labelbottom=True, labelcolor=INK, labelsize=10.0) -> None:
        """Set the look of the labels of ticks."""
        self.tick_look = (labelbottom, labelcolor, labelsize)

    def twiny(self) -> Panel:
        """Return a panel with the same y axis and another x axis, at the top."""
        self.above = Panel(self.chart, self.left, self.width)
        self.above.limits["y"] = self.limits["y"]
        return self.above

    def add_legend(self, columns: int, below: float = 0.0) -> None:
        """Add a legend above the panel in as many columns as fit, or at a distance below it."""
        room = self.width - _HANDLE - 2 * _BETWEEN
        found = [(*one[3:6], folded(one[6], room, _SMALL, most=2))
                 for one in self.curves if one[6]]  # fmt: skip
        wide = lambda words: font_of(_SMALL * 8).getlength(words) / 72 / 8  # noqa: E731
        for count in range(columns, 0, -1):
            tall = -(-len(found) // count)
            parts = [found[i : i + tall] for i in range(0, len(found), tall)]
            sizes = [max(wide(line) for one in part for line in one[3].split("\n"))
                     + _HANDLE + _BETWEEN + 0.15 for part in parts]  # fmt: skip
            if sum(sizes) <= self.width + 0.15:
                break
        rows = [max(part[i][3].count("\n") + 1 for part in parts if i < len(part))
                for i in range(tall)]  # fmt: skip
        self.legend_height = (sum(rows) * _LINE * _SMALL + 3 * tall) * _POINT
        self._legend = (parts, sizes, rows, below)

    # Drawing
    def draw(self) -> None:
        """Draw the panel."""
        chart = self.chart
        for axis, k in (("x", 1), ("y", 2)):
            self.limits[axis] = self._range(axis, k)
        self._scaled = self.scale(self.limits["x"])
        for begin, end, color in self.stages:
            sides = self._places([begin, end], self.limits["y"])
            sides[:, 1] = self.bottom, self.bottom + self.height
            chart.area(sides, color)
        for _, x, y, color, size, style, _ in sorted(self.curves, key=lambda one: one[0]):
            places = self._places(x, y)
            if style == "o":
                for place in places:
                    chart.disc(place[0], place[1], size, color)
            else:
                chart.line(_thinned(places, _FINER * chart.dpi), color, size, style)
        self._draw_frame()
        self._draw_notes()
        if self._legend:
            self._draw_legend(*self._legend)

    def _range(self, axis: str, column: int) -> list[float]:
        """Return the limits of an axis, of which None are those of the curves."""
        values = np.concatenate([one[column] for one in self.curves] or [[]])
        low, high = values.min(initial=np.inf), values.max(initial=-np.inf)
        if not low < high:
            low, high = (low - 0.5, low + 0.5) if np.isfinite(low) else (0.0, 1.0)
        more = _MARGIN * (high - low)
        given = zip(self.limits[axis], (low - more, high + more), strict=True)
        low, high = (usual if asked is None else float(asked) for asked, usual in given)
        return [low, high] if low != high else [low, low + 1.0]

    def _places(self, x, y) -> np.ndarray:
        """Return the positions of points on the page, shape (n, 2)."""
        low, high = self.limits["y"]
        across = (self.scale(x) - self._scaled[0]) / (self._scaled[1] - self._scaled[0])
        up = (np.asarray(y) - low) / (high - low)
        places = self.left + self.width * across, self.bottom + self.height * up
        return np.stack(np.broadcast_arrays(*places), axis=-1)

    def _draw_frame(self) -> None:
        """Draw both axes with their ticks, labels and the title."""
        chart, top, right = self.chart, self.bottom + self.height, self.left + self.width
        shown, color, size = self.tick_look
        upper = self not in chart.panels
        if not upper:
            frame = [(self.left, top), (self.left, self.bottom), (right, self.bottom)]
            chart.line(frame, FAINT, 0.8)
        at, outwards = (top, 1) if upper else (self.bottom, -1)
        gap = (_TICK + _PAD) * _POINT
        values, labels = self.ticks.get("x") or _ticks(self.limits["x"], self.width, "x")
        for (x, _), words in zip(self._places(values, values), labels, strict=True):
            chart.line([(x, at), (x, at + outwards * _TICK * _POINT)], FAINT, 0.8)
            base = at + gap if upper else at - gap - 0.75 * size * _POINT
            chart.text(x, base, words if shown or upper else "", size, color, "m")
        words, larger, color = self.labels["x"]
        far = gap + (1.3 * size + _PAD) * _POINT
        base = at + far if upper else at - far - 0.75 * larger * _POINT
        chart.text((self.left + right) / 2, base, words, larger, color, "m")
        if upper:
            return
        values, labels = _ticks(self.limits["y"], self.height, "y")
        for y, words in zip(self._places(self.limits["x"][:1], values)[:, 1], labels, strict=True):
            chart.line([(self.left, y), (self.left - _TICK * _POINT, y)], FAINT, 0.8)
            chart.text(self.left - gap, y - 0.36 * 10 * _POINT, words, 10, INK, "r")
        widest = max((font_of(80).getlength(words) for words in labels), default=0.0) / 8
        words, size, color = self.labels["y"]
        side = self.left - gap - (widest + _PAD) * _POINT
        chart.text(side, (self.bottom + top) / 2, words, size, color, upright=True)
        chart.text(self.left, top + 6 * _POINT, self.title[0], self.title[1])

    def _draw_notes(self) -> None:
        """Write the texts of `annotate`."""
        for words, at, shift, kind, size, color, across, up, turned in self.notes:
            x, y = self._places(at[:1], at[1:])[0] + np.array(shift) * _POINT
            if kind != "data":
                y = self.bottom + at[1] * self.height + shift[1] * _POINT
            if turned:  # from top to bottom of its letters: the text ends at its position
                long = font_of(8 * size).getlength(words) / 8 * _POINT
                self.chart.text(x + 1.1 * size * _POINT, y - long / 2, words, size, color,
                                upright=True)  # fmt: skip
                continue
            y -= 0.8 * size * _POINT if up == "top" else 0.0
            self.chart.text(x, y, words, size, color, across[0])

    def _draw_legend(self, parts, sizes, rows, below) -> None:
        """Draw the symbols and texts of the legend."""
        left = self.left + 0.07
        for part, size in zip(parts, sizes, strict=True):
            y = self.bottom - below if below else self.bottom + self.height + self.legend_height
            for (color, wide, style, words), lines in zip(part, rows, strict=False):
                middle = y - (0.5 * _LINE * _SMALL) * _POINT
                if style == "o":
                    self.chart.disc(left + _HANDLE / 2, middle, wide, color)
                else:
                    ends = [(left, middle), (left + _HANDLE, middle)]
                    self.chart.line(ends, color, wide, style)
                self.chart.text(
                    left + _HANDLE + 0.09, middle - 0.36 * _SMALL * _POINT, words, _SMALL
                )
                y -= (lines * _LINE * _SMALL + 3) * _POINT
            left += size


def _ticks(limits, length: float, axis: str) -> tuple[np.ndarray, list[str]]:
    """Return round values between the limits of an axis of a length (inches), and their labels."""
    low, high = sorted(limits)
    least = (high - low) * _EACH[axis] / max(length, 2 * _EACH[axis])
    power = 10.0 ** np.floor(np.log10(least))
    step = next(power * one for one in _STEPS if power * one >= least * (1 - 1e-9))
    small = 1e-9 * step
    values = step * np.arange(np.ceil((low - small) / step), np.floor((high + small) / step) + 1)
    digits = max(0, -int(np.floor(np.log10(step * 1.0001))) + (step / power == 2.5))
    if max(abs(low), abs(high)) >= 1e5 or digits > 5:
        return values, [f"{value:.3g}".replace("-", "−") for value in values]
    return values, [f"{value + 0.0:.{digits}f}".replace("-", "−") for value in values]


def _thinned(places: np.ndarray, dpi: int) -> np.ndarray:
    """Return a line of increasing x with its extremes in each column of pixels only."""
    if not len(places):
        return places
    column = np.floor(places[:, 0] * dpi).astype(int)
    starts = np.flatnonzero(np.diff(column, prepend=column[0] - 1))
    if len(places) < 4 * len(starts) or np.any(np.diff(column) < 0):
        return places
    y = places[:, 1]
    ends = np.append(starts[1:], len(y)) - 1
    low, high = np.minimum.reduceat(y, starts), np.maximum.reduceat(y, starts)
    x = (column[starts] + 0.5) / dpi
    up = y[starts] <= y[ends]  # a line that rises in a column has its lowest value first
    near, far = np.where(up, low, high), np.where(up, high, low)
    return np.column_stack([np.repeat(x, 4), np.stack([y[starts], near, far, y[ends]], 1).ravel()])


def _dashed(points: np.ndarray, style: str, width: float) -> list[np.ndarray]:
    """Return the dashes of a line, which are itself if it is solid."""
    if style == "-":
        return [points]
    dash, gap = np.multiply(_DASHES[style], width)
    along = np.append(0.0, np.cumsum(np.hypot(*np.diff(points, axis=0).T)))
    found = []
    for start in np.arange(0.0, along[-1], dash + gap):
        ends = start, min(start + dash, along[-1])
        inner = slice(*np.searchsorted(along, ends))
        sides = np.column_stack([np.interp(ends, along, points[:, k]) for k in (0, 1)])
        found.append(np.vstack([sides[:1], points[inner], sides[1:]]))
    return found
