# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw symbols of boundaries along the edges of blocks, outside the blocks."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D
from matplotlib.path import Path

from ..output.scene import Scene
from ..report.style import BLUE, GOLD, GREEN, INK

HELD, MOVED, ABSORBS, GOES_ON = INK, BLUE, GREEN, GOLD
_SPACING, _DEPTH = 0.03, 0.018  # spacing and depth of symbols / size of the model
_TURN = np.linspace(0.0, 2.0 * np.pi, 13)
# Label, colour and lines of the symbol of each kind; coordinates: along the edge, outwards.
SIGNS = {
    "fixed": ("fixed", HELD, [[[0.5, 0.0], [-0.2, 1.0]], [[-0.2, 0.0], [-0.9, 1.0]]]),
    "roller": ("roller", HELD, [np.column_stack([np.cos(_TURN), 1 + np.sin(_TURN)]) / 2]),
    "springs": ("springs", HELD, [[[0, 0], [0.4, 0.3], [-0.4, 0.7], [0.4, 1.1], [0, 1.4]]]),
    "viscous": ("viscous", ABSORBS,
                [[[0.0, 0.0], [0.0, 0.6]], [[-0.35, 0.6], [0.35, 0.6]],
                 [[-0.5, 0.35], [-0.5, 0.95], [0.5, 0.95], [0.5, 0.35]]]),
    "compliant": ("compliant", ABSORBS,
                  [[[0.0, 1.4], [0.0, 0.15]], [[-0.3, 0.65], [0.0, 0.15], [0.3, 0.65]]]),
    "tied": ("left tied to right", GOES_ON, [[[-0.5, d], [0.5, d]] for d in (0.4, 0.8)]),
    "free_field": ("free field beyond", GOES_ON,
                   [[[a, 0.0], [a, d]] for a, d in ((-0.5, 0.7), (0.0, 1.4), (0.5, 0.7))]),
}  # fmt: skip


def draw_boundaries(axes: Axes, scene: Scene, frame: int) -> list:
    """Draw the boundaries of a frame; return handles for the legend.

    `axes`: axes with coordinates in m.
    """
    handles = {}
    for boundary in scene.boundaries(frame):
        kind = boundary["kind"]
        label, color, sign = SIGNS.get(kind, (kind, HELD, [[[0.0, 0.0], [0.0, 1.0]]]))
        edges = np.stack([boundary["start"], boundary["end"]], axis=1)
        edges = edges[np.any(edges[:, 0] != edges[:, 1], axis=1)]
        if not len(edges):  # a stage has removed the blocks of the boundary
            continue
        if boundary["moved"]:
            is_support = color == HELD
            label += ", moved" if is_support else ", incoming wave"
            color = MOVED if is_support else color
        style = {"colors": color, "capstyle": "round", "zorder": 5}
        axes.add_collection(LineCollection(edges, linewidths=2.2, **style))
        lines = _sign_lines(sign, edges, scene.size)
        axes.add_collection(LineCollection(lines, linewidths=1.0, **style))
        marker = Path.make_compound_path(*(Path(np.multiply(line, [1, -1])) for line in sign))
        style = {"marker": marker, "ms": 12, "mfc": "none", "lw": 2.2}
        handles[label] = Line2D([], [], color=color, label=label, **style)
    return list(handles.values())


def _sign_lines(sign, edges, size: float) -> list[np.ndarray]:
    """Return the lines of all symbols along edges (k, 2, 2), m, each of shape (points, 2)."""
    middle = edges.mean(axis=1)
    edges = edges[np.argsort(middle[:, np.argmax(np.ptp(middle, axis=0))], kind="stable")]
    begin, along = edges[:, 0], edges[:, 1] - edges[:, 0]
    length = np.linalg.norm(along, axis=1)
    edge_ends = np.cumsum(length)
    count = max(1, round(edge_ends[-1] / (_SPACING * size)))
    distances = (np.arange(count) + 0.5) / count * edge_ends[-1]
    edge = np.searchsorted(edge_ends, distances)
    along = along[edge] / length[edge, None]
    origins = begin[edge] + (distances - edge_ends[edge] + length[edge])[:, None] * along
    axes = _DEPTH * size * np.stack([along, along[:, ::-1] * [1, -1]], axis=1)
    return [origins[i] + np.asarray(line) @ axes[i] for i in range(count) for line in sign]
