# SPDX-License-Identifier: GPL-3.0-or-later
"""A façade of 357 stones with nine openings: pushover past the peak, beside limit analysis.

``python tests/benchmarks/facade.py`` prints both and the time that each takes.
"""

import time

import sitedda

WIDTH, HEIGHT = 10.5, 8.7


def facade() -> sitedda.Model:
    """Three storeys of three openings, under arches and lintels."""
    model = sitedda.Model("facade", time_step=1e-3, steps=1, gravity=(0, -9.81))
    model.contact(normal_stiffness=1e10)
    model.material("stone", density=2500.0, young_modulus=1e11, poisson_ratio=0.2)
    model.joint("dry", friction_angle=35.0)
    model.block([-1, -0.5, WIDTH + 1, -0.5, WIDTH + 1, 0, -1, 0], name="floor")
    for x, y in ((-0.9, -0.25), (WIDTH + 0.9, -0.25), (5, -0.4)):
        model.fixed_point(x, y, "floor")
    model.masonry_wall(width=WIDTH, height=HEIGHT, courses=28, stone=0.85)
    for bay in range(3):
        for storey in range(3):
            door = storey == 0 and bay == 1
            head = {"head": "lintel"} if storey % 2 else {"head": "arch", "rise": 0.25}
            model.opening(f"o{bay}{storey}", left=1.2 + 3.2 * bay, width=1.1, depth=0.3,
                          bottom=0.0 if door else 0.9 + 2.9 * storey,
                          height=2.2 if door else 1.3, **head)  # fmt: skip
    model.measured_point("top", 5.3, 8.6)
    return model


def main() -> None:
    """Print the limits, the pushover, and the seconds of each."""
    model = facade()
    begun = time.perf_counter()
    limits = sitedda.limit_analysis(model)
    print(f"L {limits.lower.factor:.4f}, U {limits.upper.factor:.4f}: "
          f"{time.perf_counter() - begun:.1f} s")  # fmt: skip
    begun = time.perf_counter()
    found = sitedda.pushover(model, "top", displacement=0.05, steps=50)
    print(f"{found}\npeak/L {found.peak / limits.lower.factor:.3f}: "
          f"{time.perf_counter() - begun:.1f} s")  # fmt: skip


if __name__ == "__main__":
    main()
