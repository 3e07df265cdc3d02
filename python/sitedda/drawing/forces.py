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
_LONGEST = 0.09  # longest arrow over the size of the model
_WIDEST = 7.0  # width of the widest link of a chain, points
_CHAIN_KEYS = (1.0, 0.5, 0.2)  # forces in the legend as fractions of the force scale


def force_lines(scene: Scene, frame: int, vertices) -> tuple[np.ndarray, np.ndarray]:
    """Return contact forces between neighbours: positions (m) and forces (N/m), each (k, 2)."""
    places, force, _, _ = resultants(scene, frame, vertices)
    return places, force


def resultants(scene: Scene, frame: int, vertices) -> tuple[np.ndarray, ...]:
    """Return the resultant contact force of each pair of neighbours.

    Position (k, 2), m; force on the first block (k, 2), N/m; blocks (k, 2); whether it is
    compressive (k,).
    """
    contacts = scene.contacts(frame)
    _, normal = scene.contact_points(frame, contacts)
    push, along = contacts["normal_force"], np.column_stack([-normal[:, 1], normal[:, 0]])
    force = push[:, None] * normal - contacts["shear_force"][:, None] * along
    a, b = scene.owner[contacts["vertex"]], scene.owner[contacts["edge"]]
    sign = np.where(a < b, 1.0, -1.0)
    pair = np.minimum(a, b) * scene.blocks + np.maximum(a, b)
    pair, which = np.unique(pair, return_inverse=True)
    k = len(pair)
    weight = np.bincount(which, abs(push), k)
    total = np.column_stack([np.bincount(which, sign * f, k) for f in force.T])
    where = scene.touching(vertices, contacts) if len(push) else np.zeros((0, 2))
    centre = np.column_stack([np.bincount(which, abs(push) * x, k) for x in where.T])
    good = weight > 0
    blocks = np.column_stack([pair // scene.blocks, pair % scene.blocks])
    presses = np.bincount(which, push, k) > 0
    return centre[good] / weight[good, None], total[good], blocks[good], presses[good]


def force_scale(scene: Scene, frames) -> float:
    """Return the force (N/m) that the longest arrow or the widest link represents, for frames."""
    sizes = [np.linalg.norm(force_lines(scene, f, scene.vertices(f))[1], axis=1) for f in frames]
    sizes = np.concatenate([np.zeros(1), *sizes])
    return limits(sizes, np.ones(len(sizes))).usual


def arrow_length(scene: Scene) -> float:
    """Return the length of the longest arrow, m, from the sizes of blocks and model."""
    return min(0.8 * float(np.sqrt(np.median(scene.areas()))), _LONGEST * scene.size)


def draw_forces(axes: Axes, scene: Scene, frame: int, vertices, most: float) -> list:
    """Draw two opposed arrows at the contact force of each pair of neighbours; return artists."""
    places, force = force_lines(scene, frame, vertices)
    size = np.linalg.norm(force, axis=1)
    seen = size > _LEAST * most
    if not most > 0 or not seen.any():
        return []
    shown = np.minimum(1.0, most / size[seen])[:, None] * force[seen] / most
    arrows = arrow_length(scene) * shown
    return [_draw_quiver(axes, places[seen], sign * arrows, "tip", FORCE) for sign in (1.0, -1.0)]


def _draw_quiver(axes: Axes, places, arrows, pivot: str, color: str):
    """Draw arrows (k, 2), m, of equal width at positions (k, 2), m; return the artist."""
    look = {"edgecolor": PAPER, "linewidth": 0.4, "width": 2.2 / 72, "units": "inches"}
    look |= {"headwidth": 3.4, "headlength": 3.6, "headaxislength": 3.4, "minlength": 0.6}
    return axes.quiver(*places.T, *arrows.T, angles="xy", scale_units="xy", scale=1.0,
                       pivot=pivot, color=color, zorder=4, **look)  # fmt: skip


def scale_arrow(length: float, most: float, unit: str, words: str) -> tuple[float, str]:
    """Return length (m) and label of an arrow for a round value; `length` represents `most`."""
    size, name = in_unit(most, unit)
    power = 10.0 ** np.floor(np.log10(most / size))
    value = max(step * power for step in (1, 2, 5) if step * power <= most / size * (1 + 1e-9))
    return length * value * size / most, f"{words}: {value:g} {name}"


def draw_chains(axes: Axes, scene: Scene, frame: int, factor: float, vertices, most: float) -> list:
    """Draw lines from centroid to centroid through contacts, wider for larger forces."""
    places, force, blocks, presses = resultants(scene, frame, vertices)
    size = np.linalg.norm(force, axis=1)
    seen = size > _LEAST * most
    if not most > 0 or not seen.any():
        return []
    centre = scene.coordinates(frame)[:, :2] + (factor - 1) * scene.displacement(frame)
    first, second = centre[blocks[seen]].transpose(1, 0, 2)
    lines = np.stack([first, places[seen], second], axis=1)
    width = _WIDEST * np.clip(size[seen] / most, 0.04, 1.0)
    colors = np.where(presses[seen], INK, FORCE)
    look = {"capstyle": "round", "joinstyle": "round", "zorder": 4}
    return [
        axes.add_collection(LineCollection(lines, colors=c, linewidths=width + more, **look))
        for c, more in ((PAPER, 1.2), (colors, 0.0))
    ]


def chain_key(most: float) -> list:
    """Return legend handles of the line widths that represent forces."""
    words = [shown(share * most, "N/m") for share in _CHAIN_KEYS]
    words[0] = f"contact force, compression {words[0]}"
    return [
        *(Line2D([], [], color=INK, lw=_WIDEST * share, solid_capstyle="round", label=label)
          for share, label in zip(_CHAIN_KEYS, words, strict=True)),
        Line2D([], [], color=FORCE, lw=2.0, label="tension"),
    ]  # fmt: skip


def movement_scale(scene: Scene, name: str, frames, since: int = 0) -> float:
    """Return the displacement (m) or velocity (m/s) that the longest arrow represents."""
    values = np.stack([quantity(scene, name, frame, since) for frame in frames])
    return limits(values, scene.areas()).usual


def draw_movement(axes: Axes, scene: Scene, name: str, frame: int, since: int, factor: float,
                  most: float) -> list:  # fmt: skip
    """Draw displacements or velocities of the centroids as arrows; return the artists."""
    moved = scene.displacement(frame)
    arrows = scene.rates(frame)[:, :2] if name == "velocity" else moved - scene.displacement(since)
    size = np.linalg.norm(arrows, axis=1)
    seen = (size > 0.02 * most) & ~scene.removed(frame)
    if not most > 0 or not seen.any():
        return []
    places = scene.coordinates(frame)[:, :2] + (factor - 1) * moved
    shown = np.minimum(1.0, most / size[seen])[:, None] * arrows[seen] / most
    length = _LONGEST * scene.size
    return [_draw_quiver(axes, places[seen], length * shown, "tail", BLUE)]
