# SPDX-License-Identifier: GPL-3.0-or-later
"""A thousand random polygons dropped into a box."""

import hashlib

import numpy as np
from scipy.spatial import ConvexHull, cKDTree
from shapely import Polygon

from sitedda.report.style import BLUE, GROUND, ORANGE, RED, bare, canvas, draw_blocks

from .. import model as nml
from ..case import Outcome, Table, at_most, case, yes_or_no

DENSITY, YOUNG, PENALTY, TIME_STEP = 2500.0, 1e9, 1e9, 5e-4  # kg/m³, Pa, N/m, s
SPACING = 0.25  # spacing of the grid of polygons, m
# largest allowed overlap at rest, m; piles of other seeds have 15 to 200 µm
LARGEST_OVERLAP_AT_REST = 5e-4
LARGEST_OVERLAP = 2e-3  # largest allowed overlap at any time, with impacts of up to 7 m/s, m


def polygons(count: int, columns: int, seed: int = 5) -> list[np.ndarray]:
    """Return random convex polygons of 3 to 8 corners, each within a cell of a grid.

    `columns`: number of columns of the grid.

    Result: vertices, shape (n, 2), m, counter-clockwise, above y = 0.1 m.
    """
    random, shapes = np.random.default_rng(seed), []
    while len(shapes) < count:
        points = random.uniform(-1.0, 1.0, (random.integers(4, 12), 2))
        hull = points[ConvexHull(points).vertices]
        edges = np.linalg.norm(np.roll(hull, -1, axis=0) - hull, axis=1)
        if edges.min() < 0.15 or Polygon(hull).area < 0.8:
            continue
        row, column = divmod(len(shapes), columns)
        middle = SPACING * np.array([column + 0.5, row + 0.5]) + [0.0, 0.1]
        size = 0.5 * SPACING * random.uniform(0.6, 0.95)
        shapes.append(middle + size * hull)
    return shapes


def overlap(first: np.ndarray, second: np.ndarray) -> float:
    """Return the overlap (m) of two convex polygons by separating axes; ≤ 0 if separate."""
    smallest = np.inf
    for polygon, other in ((first, second), (second, first)):
        edges = np.roll(polygon, -1, axis=0) - polygon
        normal = np.column_stack([edges[:, 1], -edges[:, 0]])
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        reach = (polygon * normal).sum(axis=1)
        smallest = min(smallest, (reach - (other @ normal.T).min(axis=0)).min())
    return float(smallest)


def largest_overlap(shapes: list[np.ndarray]) -> float:
    """Return the largest overlap (m) of all pairs of convex polygons."""
    centres = np.array([shape.mean(axis=0) for shape in shapes])
    arms = (shape - centre for shape, centre in zip(shapes, centres, strict=True))
    radii = np.array([np.linalg.norm(arm, axis=1).max() for arm in arms])
    small = np.flatnonzero(radii < 2 * SPACING)
    large = np.flatnonzero(radii >= 2 * SPACING)
    tree = cKDTree(centres[small])
    pairs = [(small[i], small[j]) for i, j in tree.query_pairs(2 * radii[small].max())]
    pairs += [(i, j) for i in large for j in small]
    return max(overlap(shapes[i], shapes[j]) for i, j in pairs)


@case(
    "A thousand random polygons dropped into a box",
    "There is no closed form. The pile must come to rest, blocks must not pass through others, and "
    "the energy must not increase. Overlaps of blocks of about 0.2 m must be small, 0.5 mm at rest "
    "and 2 mm in impacts (penalty 1e9 N/m). A second run must be bit-identical.",
    "A common test with many blocks.",
)
def packing(short: bool) -> Outcome:
    """Check equilibrium, overlaps and energies of two identical runs."""
    count, columns, duration = (60, 8, 4.0) if short else (1000, 50, 5.0)
    first = _run_packing(count, columns, duration)
    second = _run_packing(count, columns, duration if short else 1.5)
    is_identical = second["digests"] == first["digests"][: len(second["digests"])]
    rows = [
        at_most("kinetic energy at the end / work of gravity", first["kinetic_ratio"], 1e-6),
        at_most("largest speed of a block at the end", first["largest_speed"], 1e-2, "m/s"),
        at_most("number of blocks outside the box", float(first["outside"]), 0.0),
        at_most("largest overlap at rest", first["overlap"], LARGEST_OVERLAP_AT_REST, "m"),
        at_most("largest overlap at any sampled time", first["largest_overlap"], LARGEST_OVERLAP,
            "m"),
        at_most("energy gain / work of gravity", first["gain"], 1e-6),
        at_most("energy residual / work of gravity", first["audit"], 1e-6),
        yes_or_no("two runs are bit-identical", True, is_identical),
    ]  # fmt: skip
    head = ("blocks", "Δt (s)", "time (s)", "steps and iterations")
    table = Table("The run.", head, [(count, TIME_STEP, first["time"][-1], first["summary"])])
    return Outcome(rows, _draw_packing(first), [table])


def pile_text(count: int, columns: int, duration: float, **variables) -> str:
    """Return an input of polygons above an open box; `variables` are those of ``&control``."""
    width, height = columns * SPACING, (count // columns + 2) * SPACING
    return nml.text(
        nml.control(TIME_STEP, round(duration / TIME_STEP), **variables),
        nml.contact(PENALTY),
        nml.material("wall", DENSITY, nml.STIFF),
        nml.material("stone", DENSITY, YOUNG, 0.2),
        nml.joint("dry", 30.0),
        nml.fixed_block("floor", nml.rectangle(-0.5, -0.5, width + 1.0, 0.5), "wall"),
        nml.fixed_block("left", nml.rectangle(-0.5, 0.0, 0.5, height), "wall"),
        nml.fixed_block("right", nml.rectangle(width, 0.0, 0.5, height), "wall"),
        *(nml.block(f"p{i}", s, "stone") for i, s in enumerate(polygons(count, columns))),
    )


def _run_packing(count: int, columns: int, duration: float) -> dict:
    """Run the packing; return samples at 20 Hz and their largest values."""
    keys = ("time", "kinetic", "total", "work", "balance", "depth", "digests")
    samples: dict = {key: [] for key in keys}
    with nml.simulation(pile_text(count, columns, duration)) as pile:
        start = pile.polygons
        while not pile.done:
            pile.advance(round(0.05 / TIME_STEP))
            energies, shapes = pile.energies, pile.polygons
            digest = hashlib.sha256(pile.coordinates.tobytes() + pile.rates.tobytes()).hexdigest()
            values = (pile.time, energies["kinetic"], nml.energy_gain(energies),
                      -energies["gravity"], abs(energies["balance"]), largest_overlap(shapes),
                      digest)  # fmt: skip
            for key, value in zip(keys, values, strict=True):
                samples[key].append(value)
        rates, positions, summary = pile.rates[3:], pile.coordinates[3:], pile.summary
    work = max(samples["work"])
    x, y = positions[:, :2].T
    is_inside = (x > 0) & (x < columns * SPACING) & (y > 0)
    return {
        **samples,
        "start": start,
        "polygons": shapes,
        "summary": summary,
        "kinetic_ratio": samples["kinetic"][-1] / work,
        "largest_speed": float(np.linalg.norm(rates[:, :2], axis=1).max()),
        "outside": int(np.count_nonzero(~is_inside)),
        "overlap": samples["depth"][-1],
        "largest_overlap": max(samples["depth"]),
        "gain": max(samples["total"]) / work,
        "audit": max(samples["balance"]) / work,
    }


def _draw_packing(result):
    figure, (start, end, right) = canvas(3, size=(13, 5), width_ratios=[2, 2, 2])
    shades = np.random.default_rng(1).uniform(0.0, 1.0, len(result["polygons"]) - 3)
    colors = [(0.72 + 0.2 * s, 0.64 + 0.2 * s, 0.5 + 0.25 * s) for s in shades]
    for axes, shapes, title in (
        (start, result["start"], "at the start"),
        (end, result["polygons"], f"after {result['time'][-1]:g} s"),
    ):
        draw_blocks(axes, shapes, [GROUND] * 3 + colors, lw=0.25)
        axes.set_title(title)
        bare(axes)
    kinetic = np.array(result["kinetic"]) / max(result["work"])
    depth = np.maximum(result["depth"], 1e-9)
    right.semilogy(result["time"], kinetic, color=BLUE, label="kinetic energy / work of gravity")
    right.semilogy(result["time"], depth, color=ORANGE, label="largest overlap (m)")
    right.axhline(LARGEST_OVERLAP_AT_REST, color=RED, lw=1, ls="--", label="limit at rest (m)")
    right.set(xlabel="time (s)")
    right.legend(frameon=False, fontsize=8)
    return figure
