# SPDX-License-Identifier: GPL-3.0-or-later
"""Cohesive joints between bodies: notched beams that peel, and beams that break in bending."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import sitedda

sys.path.append(str(Path(__file__).parents[1] / "python"))
from test_bodies import cells_of  # noqa: E402

SUPPORT = 5e9  # N/m, of the pins: their stretch tells the force


def two_bodies(boxes, size, on_crack, steps, duration, material, **law) -> sitedda.Model:
    """Bodies in two boxes, with a joint 'crack' on the sides of cells that `on_crack` names."""
    model = sitedda.Model()
    model.control(time_step=duration / steps, steps=steps, gravity=[0.0, 0.0],
                  analysis="plane_stress", integration="theta")  # fmt: skip
    model.contact(normal_stiffness=SUPPORT / 100)
    model.material(name="stone", rayleigh_beta=0.0, **material)
    model.joint(name="free", friction_angle=30.0)
    model.joint(name="crack", friction_angle=30.0, law="cohesive", **law)
    for name, box in boxes.items():
        for cell in cells_of(box, size):
            sides = zip(cell, np.roll(cell, -1, axis=0), strict=True)
            joints = ["crack" if on_crack(*side) else "free" for side in sides]
            model.block(vertices=np.ravel(cell).tolist(), body=name, material="stone",
                        joint="free", edge_joints=joints)  # fmt: skip
    model.output(block_interval=steps)
    return model


@pytest.mark.parametrize(("ratio", "strength"), [(0.25, 1.760), (1.0, 1.387)])
def test_a_beam_in_three_point_bending(ratio, strength, tmp_path):
    """6M/D² over T of a span of 4 D, D over l = EG/T²: linear softening, published elements."""
    depth, deep, tension, young = 0.2, 8, 3e6, 30e9
    size, span = depth / deep, 4 * depth
    energy = depth / ratio * tension**2 / young
    end = span / 2 + depth / 4
    boxes = {"left": (-end, 0, 0, depth), "right": (0, 0, end, depth)}
    model = two_bodies(
        boxes, size, lambda a, b: max(abs(a[0]), abs(b[0])) < 1e-9, 1600, 0.2,
        {"density": 2400.0, "young_modulus": young, "poisson_ratio": 0.2, "rayleigh_alpha": 600.0},
        tensile_strength=tension, cohesion=10 * tension, fracture_energy=energy,
        shear_fracture_energy=1000 * energy, normal_stiffness_per_area=200 * young / depth,
    )  # fmt: skip
    load = 4 * strength * tension * depth**2 / 6 / span
    down = -3 * (1.3 * load * span**3 / (48 * young * depth**3 / 12) + 1.5 * load / SUPPORT)
    model.motion("drive", [0.0, down], 0.2, "displacement")
    for name, sign in (("left", -1), ("right", 1)):
        model.fixed_point(x=sign * size / 2, y=depth, block=name, direction="y", motion_y="drive")
        model.fixed_point(x=sign * span / 2, y=0.0, block=name,
                          direction="xy" if sign < 0 else "y")  # fmt: skip
        model.measured_point(f"pin_{name}", sign * span / 2, 0.0, name)
    history = model.run(output=tmp_path / "out.nc").history
    pins = -SUPPORT * history.displacement.sel(axis="y").values.sum(axis=1)
    moment = pins.max() / 2 * (span / 2 - size / 2)
    assert 6 * moment / depth**2 / tension == pytest.approx(strength, rel=0.02)
    turnover = float(history.energy_fracture[-1])
    assert abs(history.energy_balance.values).max() < 1e-6 * turnover
