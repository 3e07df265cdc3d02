# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw principal stresses in the cells of bodies as crosses."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D

from ..output.scene import Scene, principal_stresses
from ..report.style import COMPRESSION, TENSION

_REACH = 0.85  # length of the arm of the largest stress / square root of the cell area
_LEAST = 0.02  # smallest drawn stress as fraction of the largest stress


def largest_stress(scene: Scene, frames) -> float:
    """Return the largest absolute principal stress in cells of bodies over frames, Pa."""
    cells = scene.body > 0
    peak = 0.0
    for frame in frames:
        for component in principal_stresses(scene.stress(frame)[cells]):
            peak = max(peak, float(abs(component[np.isfinite(component)]).max(initial=0.0)))
    return peak


def draw_crosses(axes: Axes, scene: Scene, frame: int, factor: float, scale: float) -> list:
    """Draw the principal stresses of cells as arms along the principal directions.

    `factor`: factor on the displacements of the picture; `scale`: stress whose arm is 85 % of a
    cell long, Pa.
    """
    cells = np.flatnonzero(scene.body > 0)
    if not scale > 0:
        return []
    stress = scene.stress(frame)[cells]
    along = 0.5 * np.arctan2(2 * stress[:, 2], stress[:, 0] - stress[:, 1])
    centre = scene.coordinates(frame)[cells, :2] + (factor - 1) * scene.displacement(frame)[cells]
    size = 0.5 * _REACH * np.sqrt(scene.areas(frame)[cells])
    lines, colors = [], []
    for values, angle in zip(principal_stresses(stress), (along, along + np.pi / 2), strict=True):
        visible = abs(values) > _LEAST * scale
        arm = (size * abs(values) / scale)[:, None] * np.stack([np.cos(angle), np.sin(angle)], 1)
        lines.append(np.stack([centre - arm, centre + arm], axis=1)[visible])
        colors += [TENSION if value > 0 else COMPRESSION for value in values[visible]]
    lines = np.concatenate(lines)
    return [axes.add_collection(LineCollection(lines, colors=colors, linewidths=0.9, zorder=4))]


def key_of_crosses(largest: str) -> list:
    """Return the legend handles of the arms; `largest` is the largest stress with its unit."""
    text = f"compression of cells,\nlargest stress {largest}"
    return [
        Line2D([], [], color=COMPRESSION, lw=1.2, label=text),
        Line2D([], [], color=TENSION, lw=1.2, label="tension"),
    ]
