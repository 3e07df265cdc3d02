# SPDX-License-Identifier: GPL-3.0-or-later
"""Place names beside points of a picture without overlap."""

from itertools import product

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke
from matplotlib.text import Text
from matplotlib.transforms import Bbox

from ..report.style import PAPER, POINT

# Permitted positions of a name beside its point: offset in radii of the mark, and alignment.
# Positions close to the point are tried first.
_SIDES = [(1.5 * x, 1.2 * y, "left" if x > 0 else "right", "bottom" if y > 0 else "top")
          for y, x in product((1, -1), (1, -1))] + [
    (0, 2.2, "center", "bottom"), (0, -2.2, "center", "top"),
    (2.2, 0, "left", "center"), (-2.2, 0, "right", "center"),
]  # fmt: skip
_RINGS = (1.0, 3.0, 5.0, 8.0, 12.0)  # factors on these offsets; a line is drawn for factors above 1
_RADIUS = 4.0  # radius of a mark, points


class PointNames(Artist):
    """Names of points, placed when the picture is drawn, because the scale is unknown before.

    `names`: names in the notation of matplotlib.
    `positions`: shape (points, 2); positions of the points, m.
    `marked`: shape (k, 2); positions of marks that no name may cover, m.
    """

    def __init__(self, axes: Axes, names, positions, marked):
        super().__init__()
        self.marked = np.asarray(marked, dtype=float)
        style = {"textcoords": "offset points", "fontsize": 8.5, "color": POINT, "zorder": 8}
        style["path_effects"] = [withStroke(linewidth=2.5, foreground=PAPER)]
        style["arrowprops"] = {"arrowstyle": "-", "color": POINT, "lw": 0.7, "shrinkA": 0,
                              "shrinkB": 0, "relpos": (0.5, 0.5)}  # fmt: skip
        self.names = [axes.annotate(name, position, xytext=_SIDES[0][:2], **style)
                      for name, position in zip(names, positions, strict=True)]  # fmt: skip
        for name in self.names:
            name.set_in_layout(False)
        self.set(zorder=0, in_layout=False)  # drawn first, because it places the names
        axes.add_artist(self)

    def draw(self, renderer) -> None:
        """Place each name at its first free position within the axes; hide it if none is free."""
        reach = _RADIUS * renderer.points_to_pixels(1.0)
        marks = self.axes.transData.transform(self.marked)
        occupied = [Bbox([mark - reach, mark + reach]) for mark in marks]
        for name in self.names:
            name.set_visible(True)
            for ring, (x, y, ha, va) in product(_RINGS, _SIDES):
                name.set(ha=ha, va=va)
                name.xyann = ring * _RADIUS * x, ring * _RADIUS * y
                name.arrow_patch.set_visible(ring > 1.0)
                name.update_positions(renderer)
                box = Text.get_window_extent(name, renderer)
                fits = self.axes.bbox.contains(*box.min) and self.axes.bbox.contains(*box.max)
                if fits and not any(map(box.overlaps, occupied)):
                    occupied.append(box)
                    break
            else:
                name.set_visible(False)
