# SPDX-License-Identifier: GPL-3.0-or-later
"""Random walls with openings, pushed past their peak, beside limit analysis.

``python tests/robustness/pushover_walls.py --walls 10``: every peak is to lie between .98 of the
lower limit and 1.02 of the upper one.
"""

import sys

from options import asked

import sitedda
from sitedda_evidence.validation.pushed import random_wall


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
