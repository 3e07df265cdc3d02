# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw forces and movements as arrows, or forces as chains, with a scale."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D

from ..base.numbers import in_unit, shown
from ..output.scene import Scene
from ..report.style import BLUE, FORCE, INK, PAPER
from .quantities import limits, quantity

_LEAST = 0.005  # smallest drawn force as fraction of the force scale
_LONGEST = 0.09  # longest arrow / size of the model
_WIDEST = 7.0  # width of the widest link of a chain, points
_CHAIN_KEYS = (1.0, 0.5, 0.2)  # forces in the legend as fractions of the force scale


def neighbour_forces(scene: Scene, frame: int, vertices) -> tuple[np.ndarray, np.ndarray]:
    """Return contact forces between neighbours: positions (m) and forces (N/m), each (k, 2)."""
    positions, force, _, _ = resultants(scene, frame, vertices)
    return positions, force


def resultants(scene: Scene, frame: int, vertices) -> tuple[np.ndarray, ...]:
    """Return the resultant contact force of each pair of neighbours.

    Position (k, 2), m; force on the first block (k, 2), N/m; blocks (k, 2); whether it is
    compressive (k,).
    """
    contacts = scene.contacts(frame)
    _, normal = scene.contact_points(frame, contacts)
    push, force = contacts["normal_force"], scene.contact_forces(contacts, normal)
    a, b = scene.owner[contacts["vertex"]], scene.owner[contacts["edge"]]
    sign = np.where(a < b, 1.0, -1.0)
    pair = np.minimum(a, b) * scene.blocks + np.maximum(a, b)
    pair, pair_index = np.unique(pair, return_inverse=True)
    k = len(pair)
    weight = np.bincount(pair_index, abs(push), k)
    total = np.column_stack([np.bincount(pair_index, sign * f, k) for f in force.T])
    positions = scene.touching(vertices, contacts) if len(push) else np.zeros((0, 2))
    centre = np.column_stack([np.bincount(pair_index, abs(push) * x, k) for x in positions.T])
    loaded = weight > 0
    blocks = np.column_stack([pair // scene.blocks, pair % scene.blocks])
    is_compressed = np.bincount(pair_index, push, k) > 0
    centres = centre[loaded] / weight[loaded, None]
    return centres, total[loaded], blocks[loaded], is_compressed[loaded]


def force_scale(scene: Scene, frames) -> float:
    """Return the force (N/m) that the longest arrow or the widest link represents, for frames."""
    forces = [neighbour_forces(scene, frame, scene.vertices(frame))[1] for frame in frames]
    sizes = np.linalg.norm(np.concatenate([np.zeros((1, 2)), *forces]), axis=1)
    return limits(sizes, np.ones(len(sizes))).usual


def arrow_length(scene: Scene) -> float:
    """Return the length of the longest arrow, m, from the sizes of blocks and model."""
    return min(0.8 * float(np.sqrt(np.median(scene.areas()))), _LONGEST * scene.size)


def draw_forces(axes: Axes, scene: Scene, frame: int, vertices, scale: float) -> list:
    """Draw two opposed arrows at the contact force of each pair of neighbours; return artists."""
    points, force = neighbour_forces(scene, frame, vertices)
    size = np.linalg.norm(force, axis=1)
    visible = size > _LEAST * scale
    if not scale > 0 or not visible.any():
        return []
    relative = np.minimum(1.0, scale / size[visible])[:, None] * force[visible] / scale
    arrows = arrow_length(scene) * relative
    return [_draw_quiver(axes, points[visible], sign * arrows, "tip", FORCE) for sign in (1, -1)]


def _draw_quiver(axes: Axes, positions, arrows, pivot: str, color: str):
    """Draw arrows (k, 2), m, of equal width at positions (k, 2), m; return the artist."""
    style = {"edgecolor": PAPER, "linewidth": 0.4, "width": 2.2 / 72, "units": "inches"}
    style |= {"headwidth": 3.4, "headlength": 3.6, "headaxislength": 3.4, "minlength": 0.6}
    return axes.quiver(*positions.T, *arrows.T, angles="xy", scale_units="xy", scale=1.0,
                       pivot=pivot, color=color, zorder=4, **style)  # fmt: skip


def scale_arrow(length: float, scale: float, unit: str, label: str) -> tuple[float, str]:
    """Return length (m) and label of an arrow for a round value; `length` represents `scale`."""
    size, name = in_unit(scale, unit)
    power = 10.0 ** np.floor(np.log10(scale / size))
    value = max(step * power for step in (1, 2, 5) if step * power <= scale / size * (1 + 1e-9))
    return length * value * size / scale, f"{label}: {value:g} {name}"


def draw_chains(
    axes: Axes, scene: Scene, frame: int, factor: float, vertices, scale: float
) -> list:
    """Draw lines from centroid to centroid through contacts, wider for larger forces."""
    points, force, blocks, is_compressed = resultants(scene, frame, vertices)
    size = np.linalg.norm(force, axis=1)
    visible = size > _LEAST * scale
    if not scale > 0 or not visible.any():
        return []
    centre = scene.coordinates(frame)[:, :2] + (factor - 1) * scene.displacement(frame)
    start, end = centre[blocks[visible]].transpose(1, 0, 2)
    lines = np.stack([start, points[visible], end], axis=1)
    width = _WIDEST * np.clip(size[visible] / scale, 0.04, 1.0)
    colors = np.where(is_compressed[visible], INK, FORCE)
    style = {"capstyle": "round", "joinstyle": "round", "zorder": 4}
    return [axes.add_collection(LineCollection(lines, colors=c, linewidths=width + margin, **style))
            for c, margin in ((PAPER, 1.2), (colors, 0.0))]  # fmt: skip


def chain_key(scale: float) -> list:
    """Return legend handles of the line widths that represent forces."""
    labels = [shown(fraction * scale, "N/m") for fraction in _CHAIN_KEYS]
    labels[0] = f"contact force, compression {labels[0]}"
    return [
        *(Line2D([], [], color=INK, lw=_WIDEST * fraction, solid_capstyle="round", label=label)
          for fraction, label in zip(_CHAIN_KEYS, labels, strict=True)),
        Line2D([], [], color=FORCE, lw=2.0, label="tension"),
    ]  # fmt: skip


def movement_scale(scene: Scene, name: str, frames, since: int = 0) -> float:
    """Return the displacement (m) or velocity (m/s) that the longest arrow represents."""
    values = np.stack([quantity(scene, name, frame, since) for frame in frames])
    return limits(values, scene.areas()).usual


def draw_movement(axes: Axes, scene: Scene, name: str, frame: int, since: int, factor: float,
                  scale: float) -> list:  # fmt: skip
    """Draw displacements or velocities of the centroids as arrows; return the artists."""
    motion = scene.displacement(frame)
    arrows = scene.rates(frame)[:, :2] if name == "velocity" else motion - scene.displacement(since)
    size = np.linalg.norm(arrows, axis=1)
    visible = (size > 0.02 * scale) & ~scene.removed(frame)
    if not scale > 0 or not visible.any():
        return []
    points = scene.coordinates(frame)[:, :2] + (factor - 1) * motion
    relative = np.minimum(1.0, scale / size[visible])[:, None] * arrows[visible] / scale
    length = _LONGEST * scene.size
    return [_draw_quiver(axes, points[visible], length * relative, "tail", BLUE)]
