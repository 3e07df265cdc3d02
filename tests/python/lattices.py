# SPDX-License-Identifier: GPL-3.0-or-later
"""Layered ground of square blocks on a compliant base, for tests of its sides."""

import numpy as np

import sitedda

DENSITY, SPEED, POISSON = 1800.0, 200.0, 0.25
MODULUS = 2 * DENSITY * SPEED**2 * (1 + POISSON)
ROCK = {"density": 2200.0, "shear_velocity": 800.0, "pressure_velocity": 1500.0}


def lattice(
    sides: str, along="x", columns=10, rows=3, order=1, acceleration=1.0, hill=(), body="",
    damping=None, **control,
):  # fmt: skip
    """Layers of square blocks of 1 m on a compliant base under a pulse; a hill has one more layer.

    With a name `body` they are its cells, otherwise glued blocks.  `sides` is 'free', 'tied',
    'free_field' or 'viscous'; the lowest layer is the stiffest.
    """
    control = {"time_step": 1e-3, "duration": 0.15, "analysis": "plane_strain"} | control
    model = sitedda.Model("lattice", **control)
    model.contact(normal_stiffness=40 * MODULUS, force_tolerance=1e-14)
    model.joint("glue", friction_angle=40.0, cohesion=1e12, tensile_strength=1e12)
    cell = {"body": body} if body else {}
    for j in range(rows):
        name = f"layer_{j}"
        model.material(name, density=DENSITY + 100 * j, young_modulus=MODULUS * (2 - 0.5 * j),
                       poisson_ratio=POISSON, **(damping or {}))  # fmt: skip
        for i in range(columns)[::order]:
            model.block(_square(i, j), name=f"b_{i}_{j}", material=name, **cell)
    for i in hill:
        model.block(_square(i, rows), name=f"hill_{i}", material=name, **cell)
    time = np.arange(0.0, 0.06, 1e-3)
    pulse = acceleration * np.sin(np.pi * time / 0.06) ** 2 * np.sin(2 * np.pi * time / 0.06)
    model.motion("rock", pulse, 1e-3, "acceleration", drift_order=0)
    model.boundary("base", "compliant", side="bottom", **{f"motion_{along}": "rock"}, **ROCK)
    if sides == "tied":
        model.boundary(kind="tied")
    if sides in ("free_field", "viscous"):
        for side in ("left", "right"):
            model.boundary(kind=sides, side=side)
    return model


def _square(i: int, j: int) -> list[float]:
    return [i, j, i + 1, j, i + 1, j + 1, i, j + 1]


def moved(model, columns: int = 10, rows: int = 3) -> np.ndarray:
    """Displacements of the blocks at every tenth step, shape (n, rows, columns, 2), m."""
    displacements = []
    with sitedda.Simulation(model) as simulation:
        names = list(simulation.block_names)
        order = [names.index(f"b_{i}_{j}") for j in range(rows) for i in range(columns)]
        first = simulation.coordinates.copy()
        at_end = False
        while not at_end:
            at_end = simulation.advance(10)
            change = (simulation.coordinates - first)[order, :2]
            displacements.append(change.reshape(rows, columns, 2))
    return np.array(displacements)
