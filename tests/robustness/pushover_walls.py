# SPDX-License-Identifier: GPL-3.0-or-later
"""Random walls with openings, pushed beyond their peak, against limit analysis.

``python tests/robustness/pushover_walls.py --walls 10``: each peak must lie between 0.98 of the
lower limit and 1.02 of the upper limit.
"""

import sys

from options import count_wrong, parse_options

import sitedda
from sitedda_evidence.validation.pushed import random_wall


def compare(seed: int, stiffness: float | None) -> tuple[str, bool]:
    """Describe limits and peak of a wall; return also whether the peak is between them."""
    model = random_wall(seed)
    if stiffness:
        model.contact(normal_stiffness=stiffness)
    limits = sitedda.limit_analysis(model)
    low, high = limits.lower.factor, limits.upper.factor
    curve = sitedda.pushover(model, "top", displacement=0.05)
    return (f"{seed:3d} {len(curve.names):4d} blocks  L {low:.4f}  U {high:.4f}  peak "
            f"{curve.peak:.4f} = {curve.peak / low:.3f} L = {curve.peak / high:.3f} U"
            ), 0.98 * low <= curve.peak <= 1.02 * high  # fmt: skip


def main() -> int:
    """Return status 1 if a peak is not between its limits."""
    options = parse_options(__doc__, walls=10, first=0, stiffness=float)
    seeds = range(options.first, options.first + options.walls)
    return count_wrong(compare(seed, options.stiffness) for seed in seeds)


if __name__ == "__main__":
    sys.exit(main())
