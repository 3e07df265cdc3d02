# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw water in joints: line width by pressure, dots for unsaturated joints, arrows of flux."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D

from ..base.numbers import shown
from ..output.scene import Scene
from ..report.style import PAPER, WATER

_LEAST = 0.05  # smallest flux with an arrow, as fraction of the largest flux


def draw_flow(axes: Axes, scene: Scene, frame: int) -> list:
    """Draw the water of a frame and return the artists; none without &flow."""
    blocks, positions = scene.water_lines
    if len(blocks) == 0:
        return []
    ends = np.stack([scene.carried(blocks, positions[:, k], frame) for k in (0, 1)], axis=1)
    mean, saturated, flux = scene.water(frame)
    pressure = np.clip(mean, 0, None)
    width = 0.5 + 4.0 * pressure / (pressure.max() or 1.0)
    artists = []
    for wet, style in ((saturated, "-"), (~saturated, ":")):
        lines = LineCollection(ends[wet], colors=WATER, linewidths=width[wet], ls=style, zorder=5)
        artists.append(axes.add_collection(lines))
    visible = abs(flux) > _LEAST * (abs(flux).max() or 1.0)
    if visible.any():
        middle = ends[visible].mean(1)
        along = np.diff(ends[visible], axis=1)[:, 0] * np.sign(flux[visible])[:, None]
        along *= 0.03 * scene.size / np.linalg.norm(along, axis=1, keepdims=True)
        artists.append(axes.quiver(*(middle - along / 2).T, *along.T, angles="xy", scale=1,
                                 scale_units="xy", color=WATER, ec=PAPER, lw=0.6, width=0.006,
                                 headwidth=3, zorder=6))  # fmt: skip
    return artists


def key_of_flow(scene: Scene, frame: int) -> list:
    """Return the legend handle of water in joints, in a list; none without &flow."""
    if len(scene.water_lines[0]) == 0:
        return []
    peak_pressure = float(scene.water(frame)[0].max())
    label = f"water in joints, largest\npressure {shown(peak_pressure, 'Pa')}; arrows: flux"
    return [Line2D([], [], color=WATER, lw=3.0, label=label)]
