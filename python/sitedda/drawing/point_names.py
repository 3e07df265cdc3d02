# SPDX-License-Identifier: GPL-3.0-or-later
"""Names beside points of a picture, none over another or over a point."""

from itertools import product

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke
from matplotlib.transforms import Bbox

from ..report.style import PAPER, POINT

# Where a name may stand beside its point: offset in points, alignment.  The first is the best.
_SIDES = [(6 * x, 5 * y, "left" if x > 0 else "right", "bottom" if y > 0 else "top")
          for y, x in product((1, -1), (1, -1))] + [
    (0, 9, "center", "bottom"), (0, -9, "center", "top"),
    (9, 0, "left", "center"), (-9, 0, "right", "center"),
]  # fmt: skip
_RADIUS = 4.0  # points of a mark


class PointNames(Artist):
    """Names that find their places when the picture is drawn, since only then its scale is known.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    names : sequence of str
        As matplotlib reads texts.
    places : array_like, shape (points, 2)
        m.
    marked : array_like, shape (k, 2)
        Where marks are drawn that no name may cover, m.
    """

    def __init__(self, axes: Axes, names, places, marked):
        super().__init__()
        self.marked = np.asarray(marked, dtype=float)
        look = {"textcoords": "offset points", "fontsize": 8.5, "color": POINT, "zorder": 8}
        look["path_effects"] = [withStroke(linewidth=2.5, foreground=PAPER)]
        self.names = [axes.annotate(name, place, xytext=_SIDES[0][:2], **look)
                      for name, place in zip(names, places, strict=True)]  # fmt: skip
        self.set(zorder=0, in_layout=False)  # drawn first, so that the names are where they go
        axes.add_artist(self)

    def draw(self, renderer) -> None:
        """Give each name the first of its places that is free, or the one that covers least."""
        reach = _RADIUS * renderer.points_to_pixels(1.0)
        marks = self.axes.transData.transform(self.marked)
        taken = [Bbox([at - reach, at + reach]) for at in marks]
        for name in self.names:
            boxes = []
            for *offset, ha, va in _SIDES:
                name.set(ha=ha, va=va)
                name.xyann = tuple(offset)
                boxes.append(name.get_window_extent(renderer))
            covered = [sum(_overlap(box, other) for other in taken) for box in boxes]
            best = int(np.argmin(covered))
            *offset, ha, va = _SIDES[best]
            name.set(ha=ha, va=va)
            name.xyann = tuple(offset)
            taken.append(boxes[best])


def _overlap(one: Bbox, other: Bbox) -> float:
    """Area that two boxes share, pixels²."""
    shared = Bbox.intersection(one, other)
    return shared.width * shared.height if shared else 0.0
