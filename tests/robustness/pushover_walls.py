# SPDX-License-Identifier: GPL-3.0-or-later
"""Random walls with openings, pushed past their peak, beside limit analysis.

``python tests/robustness/pushover_walls.py --walls 10``: every peak is to lie between .98 of the
lower limit and 1.02 of the upper one.
"""

import math
import sys

import numpy as np
from options import asked

import sitedda


def random_wall(seed: int) -> sitedda.Model:
    """A wall with a door and, every other pair, a window, in one of the bonds."""
    rng = np.random.default_rng(seed)
    width, height = rng.uniform(3, 5), rng.uniform(2.2, 3.2)
    stone, door = rng.uniform(0.5, 0.8), rng.uniform(0.7, 1.0)
    model = sitedda.Model("wall", time_step=1e-3, steps=1, gravity=(0, -9.81))
    model.material("stone", density=2500.0, young_modulus=1e11, poisson_ratio=0.2)
    model.block([-1, -0.5, width + 1, -0.5, width + 1, 0, -1, 0], name="floor")
    for x, y in ((-0.9, -0.25), (width + 0.9, -0.25), (width / 2, -0.4)):
        model.fixed_point(x, y, "floor")
    bond = ("running", "header", "rubble")[seed % 3]
    model.masonry_wall(width=width, height=height, courses=int(rng.integers(7, 11)), stone=stone,
                       bond=bond, seed=seed)  # fmt: skip
    model.opening("door", left=0.2 * width, width=door, height=0.6 * height, depth=0.3,
                  bearing=0.3, head=("lintel", "arch")[seed % 2])  # fmt: skip
    if seed % 4 > 1:
        model.opening("window", left=0.65 * width, bottom=0.3 * height, width=0.6,
                      height=0.3 * height, depth=0.3, bearing=0.25)  # fmt: skip
    model.joint("dry", friction_angle=math.degrees(math.atan(rng.uniform(0.4, 0.8))))
    model.measured_point("top", 0.5 * width + 0.01, height - 0.05)
    return model


def main() -> int:
    """Print limits and peak of each wall; 1 if one lies outside."""
    options, outside = asked(__doc__, walls=10, first=0, stiffness=float), 0
    for seed in range(options.first, options.first + options.walls):
        model = random_wall(seed)
        if options.stiffness:
            model.contact(normal_stiffness=options.stiffness)
        limits = sitedda.limit_analysis(model)
        low, high = limits.lower.factor, limits.upper.factor
        found = sitedda.pushover(model, "top", displacement=0.05)
        good = 0.98 * low <= found.peak <= 1.02 * high
        outside += not good
        print(f"{seed:3d} {len(found.names):4d} blocks  L {low:.4f}  U {high:.4f}  peak "
              f"{found.peak:.4f} = {found.peak / low:.3f} L = {found.peak / high:.3f} U"
              f"{'' if good else '  outside'}", flush=True)  # fmt: skip
    print(f"{outside} of {options.walls} outside")
    return int(outside > 0)


if __name__ == "__main__":
    sys.exit(main())
