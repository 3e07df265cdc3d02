# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw slip and opening of joints by width and colour, and the direction of large slips."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize

from ..output.scene import Scene
from ..report.style import INK, JOINT_MAP, PAPER
from .quantities import MOVEMENTS, Limits

_LEAST = 0.03  # smallest drawn slip or opening as fraction of the scale
_THIN, _WIDE = 0.5, 4.6  # smallest and largest width of a line, points
_HALO = 1.2  # margin around the widest line, points
_SENSES, _LEAST_SENSE = 24, 0.2  # largest number of half-arrow pairs; their smallest slip / scale
_LEAST_LENGTH = 0.02  # smallest length of a joint with half-arrows / size of the model


def joint_lines(scene: Scene, frame: int, factor: float) -> np.ndarray:
    """Return the ends of interfaces in a frame, shape (k, 2, 2), m; they move with first blocks."""
    faces, ends = scene.interfaces, []
    for reference in (faces.start, faces.end):
        position = scene.carried(faces.first, reference, frame)
        ends.append(position + (factor - 1.0) * (position - reference - scene.base[frame]))
    return np.stack(ends, axis=1)


def draw_movements(axes: Axes, scene: Scene, name: str, frame: int, factor: float,
                   scale: Limits) -> list:  # fmt: skip
    """Draw joints that have slipped or opened, the largest movement on top; return artists."""
    movement = scene.joint_movement(frame)[list(MOVEMENTS).index(name)]
    placed = scale.share(movement)
    visible = np.flatnonzero(placed > _LEAST)
    if not scale.high > 0 or len(visible) == 0:
        return []
    visible = visible[np.argsort(movement[visible])]
    lines = joint_lines(scene, frame, factor)[visible]
    fraction = placed[visible]
    width = _THIN + (_WIDE - _THIN) * fraction
    style = {"capstyle": "butt", "zorder": 3}
    halo = LineCollection(lines, colors=PAPER, linewidths=width + _HALO * fraction, **style)
    coloured = LineCollection(lines, linewidths=width, cmap=JOINT_MAP, norm=Normalize(0.0, 1.0),
                           array=fraction, **style)  # fmt: skip
    senses = _draw_slip_arrows(axes, scene, frame, lines, visible, placed) if name == "slip" else []
    return [axes.add_collection(halo), axes.add_collection(coloured), *senses]


def _draw_slip_arrows(axes: Axes, scene: Scene, frame: int, lines, visible, fraction) -> list:
    """Draw half-arrows on both sides of the joints with the largest slip; return artists."""
    along = lines[:, 1] - lines[:, 0]
    length = np.linalg.norm(along, axis=1)
    selected = (fraction[visible] > _LEAST_SENSE) & (length > _LEAST_LENGTH * scene.size)
    selected = np.flatnonzero(selected)[-_SENSES:]
    if len(selected) == 0:
        return []
    unit = along[selected] / length[selected, None]
    normal = np.column_stack([unit[:, 1], -unit[:, 0]])  # normal into the second block
    reach = np.minimum(0.3 * length[selected], 0.03 * scene.size)[:, None]
    # Slip of the second block relative to the first, positive along the edge of the first.
    sense = scene.joint_sense(frame)[visible[selected], None]
    middle, barbs = lines[selected].mean(axis=1), []
    for side in (1.0, -1.0):
        centre = middle + side * 0.35 * reach * normal
        tip = centre + side * sense * reach * unit
        barb = tip - side * 0.4 * reach * (sense * unit - 0.6 * normal)
        barbs.append(np.stack([centre - side * sense * reach * unit, tip, barb], axis=1))
    barbs = np.concatenate(barbs)
    style = {"capstyle": "round", "joinstyle": "round", "zorder": 5}
    return [axes.add_collection(LineCollection(barbs, colors=c, linewidths=w, **style))
            for c, w in ((PAPER, 2.6), (INK, 1.1))]  # fmt: skip
