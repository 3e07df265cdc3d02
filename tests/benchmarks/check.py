# SPDX-License-Identifier: GPL-3.0-or-later
"""How long the check takes on running-bond walls: python tests/benchmarks/check.py [BRICKS …]."""

import platform
import sys
import tempfile
import time
from pathlib import Path

import sitedda

MODEL = """
&control time_step = 1e-4, steps = 1000, gravity = 0.0, {gravity} /
&contact normal_stiffness = 1e12 /
&material density = 2500.0, young_modulus = 1e10, poisson_ratio = 0.25 /
&joint friction_angle = 35.0 /
&layers name = 'base', left = -0.5, bottom = -0.5, width = {width}, thickness = 0.5 /
&wall brick_length = 1.0, brick_height = 0.5, bricks = {bricks}, courses = {courses} /
&fixed_point x = 0.0, y = -0.25, block = 'base_1' /
&fixed_point x = {bricks}, y = -0.25, block = 'base_1' /
&fixed_point x = {middle}, y = -0.4, block = 'base_1' /
"""


def wall(blocks: int, gravity: float) -> str:
    """Input of a wall about twice as wide as high, with about so many blocks."""
    bricks = max(2, round(blocks**0.5))
    courses = max(2, round(blocks / bricks))
    return MODEL.format(
        bricks=bricks,
        courses=courses,
        width=bricks + 1.0,
        middle=bricks / 2,
        gravity=gravity,
    )


def main(sizes: list[int]) -> None:
    """Print a row for each size."""
    print(f"{platform.processor() or platform.machine()}, sitedda {sitedda.__version__}")
    print(f"{'blocks':>8} {'read':>8} {'check':>8} s   omega_max within the bracket")
    with tempfile.TemporaryDirectory() as folder:
        for size in sizes:
            file = Path(folder) / "wall.nml"
            file.write_text(wall(size, 0.0))
            begun = time.perf_counter()
            with sitedda.Simulation(file) as model:
                read = time.perf_counter() - begun
                begun = time.perf_counter()
                report = sitedda.check(model)
                spent = time.perf_counter() - begun
                low, high = report.bracket
                inside = low <= report.omega_max <= high
                print(
                    f"{len(model.coordinates):8d} {read:8.2f} {spent:8.2f}     {inside}, "
                    f"{report.omega_max:.6g} in {low:.6g} … {high:.6g} rad/s"
                )


if __name__ == "__main__":
    main([int(word) for word in sys.argv[1:]] or [100, 1000, 10000, 100000])
