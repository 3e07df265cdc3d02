#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Mechanisms of random slopes of two joint sets, against a search for removable blocks.

usage: python tests/robustness/removable_blocks.py [--slopes N] [--first I] [--seed S]

One set dips out of the slope, the other steeply into it.  The search uses the edges of blocks: a
block that moves down the dip pushes each block in its way, and is removable if none of these is
fixed.  All removable blocks slide at tan φ / tan α.
"""

import math
import sys
from pathlib import Path

import numpy as np
import shapely

sys.path.insert(0, str(Path(__file__).parent))

from options import count_wrong, parse_options  # noqa: E402

import sitedda  # noqa: E402

SEED = 20261128
LENGTH, DEPTH = 40.0, 8.0  # length of the slope and depth below its toe, m
TOUCH = 1e-6  # m
BELOW, ABOVE = 0.99, 1.01  # times the factor of safety F of the search
AREA = 0.01  # relative tolerance of areas


def random_slope(rng: np.random.Generator) -> tuple[sitedda.Model, float, float]:
    """Return a slope, the dip of the set that it slides on (°), and its factor of safety."""
    height, face = rng.uniform(12, 20), math.radians(rng.uniform(50, 75))
    dip, steep_dip = rng.uniform(22, 36), rng.uniform(-80, -60)
    friction = rng.uniform(25, 45)
    model = sitedda.Model("Slope of two joint sets", time_step=1e-3, gravity=(0, -9.81))
    model.contact(normal_stiffness=1e10, shear_ratio=1.0)
    model.material("rock", density=2600.0, young_modulus=1e11, poisson_ratio=0.2)
    model.joint("bedding", friction_angle=friction)
    model.joint("cross", friction_angle=rng.uniform(25, 45))
    toe = 0.6 * LENGTH
    crest = toe - height / math.tan(face)
    top = DEPTH + height
    model.region("rock", [0, 0, LENGTH, 0, LENGTH, DEPTH, toe, DEPTH, crest, top, 0, top])
    origin = rng.uniform(0, 5, 2)
    model.joint_set("bedding", angle=-dip, spacing=rng.uniform(2, 4), origin=origin)
    model.joint_set("cross", angle=-steep_dip, spacing=rng.uniform(3, 6), origin=origin + 0.5)
    for side in ("left", "right", "bottom"):
        model.boundary(kind="fixed", side=side)
    return model.build(), dip, math.tan(math.radians(friction)) / math.tan(math.radians(dip))


def removable(polygons: list[np.ndarray], dip: float) -> np.ndarray:
    """Return whether each block can move down the dip without pushing a fixed block."""
    direction = np.array([math.cos(math.radians(dip)), -math.sin(math.radians(dip))])
    blocks_ahead = [[j for j, other in enumerate(polygons)
              if j != i and _runs_into(polygon, other, direction)]
             for i, polygon in enumerate(polygons)]  # fmt: skip
    supported = {i for i, p in enumerate(polygons)
            if (p[:, 0] < TOUCH).any() or (p[:, 0] > LENGTH - TOUCH).any() or
            (p[:, 1] < TOUCH).any()}  # fmt: skip
    blocks = []
    for i in range(len(polygons)):
        moving, added = {i}, [i]
        while added:
            added = [j for j in blocks_ahead[added.pop()] if j not in moving] + added
            moving.update(added)
        blocks.append(not moving & supported)
    return np.array(blocks)


def _runs_into(block: np.ndarray, other: np.ndarray, direction: np.ndarray) -> bool:
    """Return whether a moving block pushes another at a shared edge."""
    for a, b in zip(block, np.roll(block, -1, axis=0), strict=True):
        length = np.linalg.norm(b - a)
        edge_direction = (b - a) / length
        normal = np.array([edge_direction[1], -edge_direction[0]])  # outward normal
        if direction @ normal < 1e-6:
            continue
        for c, d in zip(other, np.roll(other, -1, axis=0), strict=True):
            if max(abs((c - a) @ normal), abs((d - a) @ normal)) < TOUCH:
                low, high = sorted(((c - a) @ edge_direction, (d - a) @ edge_direction))
                if min(high, length) - max(low, 0.0) > TOUCH:
                    return True
    return False


def compare(number: int, seed: int = SEED) -> tuple[str, bool]:
    """Describe a slope with removable blocks; return also whether engine and search agree."""
    rng = np.random.default_rng([seed, number])
    while True:
        model, dip, factor = random_slope(rng)
        groups = model.of_kind("block")
        polygons = [np.reshape(group.vertices, (-1, 2)).astype(float) for group in groups]
        is_removable = removable(polygons, dip)
        if 0 < is_removable.sum() < len(is_removable):
            break
    areas = np.array([shapely.Polygon(polygon).area for polygon in polygons])
    expected = float(areas[is_removable].sum())
    state_below, state_above = (sitedda.mechanism(model, fraction * factor)
                                for fraction in (BELOW, ABOVE))  # fmt: skip
    names = {group.name for group, moves in zip(groups, is_removable, strict=True) if moves}
    differences = names ^ set(state_above.moving)
    are_equal = not state_below.moves and abs(state_above.areas[0] / expected - 1) < AREA
    state = "moves" if state_below.moves else "stands"
    return (
        f"slope {number + 1}: {len(polygons)} blocks, F = tan φ / tan α = {factor:.4f}; "
        f"{state} at {BELOW} F; at {ABOVE} F {len(state_above.moving)} blocks of "
        f"{state_above.areas[0]:.2f} m² move on {state_above.joint!r}; search: {len(names)} of "
        f"{expected:.2f} m², {len(differences)} differ"
    ), are_equal and state_above.joint == "bedding"


def main() -> int:
    """Return status 1 if engine and search differ."""
    options = parse_options(__doc__, slopes=10, first=0, seed=SEED)
    return count_wrong(compare(i, options.seed) for i in range(options.first, options.slopes))


if __name__ == "__main__":
    sys.exit(main())
