# SPDX-License-Identifier: GPL-3.0-or-later
"""Static stages end at rest below the limit of equilibrium, and beyond it never do."""

from __future__ import annotations

import math

import numpy as np
import pytest

import sitedda
from sitedda.masonry import Arch

GRAVITY = 9.81


def arch(friction: float, ratio: float, voussoirs: int, half: float, push: float) -> sitedda.Model:
    """An arch of radius 10 m and half angle `half` (degrees) under its weight and `push` of it."""
    model = sitedda.Model("Arch pushed", time_step=1e-3, gravity=(GRAVITY * push, -GRAVITY))
    model.material("stone", density=2500.0, young_modulus=1e10, poisson_ratio=0.2)
    model.joint("dry", friction_angle=math.degrees(math.atan(friction)))
    angle = math.radians(half)
    span, rise = 20.0 * math.sin(angle), 10.0 * (1.0 - math.cos(angle))
    shapes = Arch(span=span, rise=rise, thickness=10 * ratio, voussoirs=voussoirs, abutment=2.0)
    for stone in shapes.blocks():
        model.block(np.array(stone.polygon), name=stone.name)
        if stone.name.endswith(("left", "right")):
            for place in stone.polygon:
                inwards = 0.01 * (np.mean(stone.polygon, axis=0) - place)
                model.fixed_point(*(place + inwards), stone.name)
    model.stage(name="rest", kind="static")
    return model


def rests(model: sitedda.Model) -> bool:
    try:
        sitedda.Simulation(model).close()
    except sitedda.ConvergenceError as error:
        assert "does not settle" in str(error)
        return False
    return True


@pytest.mark.parametrize(
    "shape",
    [(0.61, 0.165, 15, 76.4), (0.46, 0.175, 19, 60.0), (0.87, 0.14, 18, 86.1), (0.51, 0.18, 9, 52)],
    ids=str,
)
def test_an_arch_rests_below_its_limit_alone(shape):
    """Pressed by the far sides of blocks that they had left, some rested beyond it."""
    limit = sitedda.limit_analysis(arch(*shape, push=0.0))
    assert limit.lower.factor == pytest.approx(limit.upper.factor, rel=0.01)
    shares = np.array([0.90, 0.94, 0.98, 1.02, 1.04, 1.06, 1.08, 1.10])
    found = [rests(arch(*shape, push=share * limit.upper.factor)) for share in shares]
    assert found == list(shares < 1.0)
