# SPDX-License-Identifier: GPL-3.0-or-later
"""Yielding soil: factors of safety of slopes and a cut, bearing capacity of a footing."""

import numpy as np

from sitedda.facade.model import Model
from sitedda.stability.reduction import Safety, safety

from ..case import Outcome, Table, at_most, case, curves, relative, yes_or_no

HEIGHT = 10.0  # H, m
WEIGHT = 2e4  # γ, N/m³
STIFF = 1e10  # Young's modulus at which soil yields at small strains, Pa
SMALL = 1e-3  # displacement at failure over the radius of the body, at small strains
CUT = 3.776  # γH/c at failure of the cut, by limit analysis
# Friction (degrees), settlement (m), steps, width and depth (half-widths), allowed error.
FOOTINGS = ((0.0, 3e-4, 60, (5.0, 3.0), 0.02), (30.0, 1.2e-3, 120, (8.0, 4.0), 0.03))


def _soil_body(outline, cells: int, poisson: float, sides, **strength) -> Model:
    """Return a body of one soil on a fixed base with rollers at `sides`."""
    model = Model()
    model.control(time_step=1.0, gravity=[0.0, -10.0], analysis="plane_strain")
    model.contact(normal_stiffness=STIFF)
    model.material(name="soil", density=WEIGHT / 10.0, young_modulus=STIFF, poisson_ratio=poisson,
                   law="mohr_coulomb", **strength)  # fmt: skip
    model.joint(name="joint", friction_angle=30.0)
    model.block(vertices=[HEIGHT * value for value in outline], name="ground")
    model.mesh(blocks="ground", size=HEIGHT / cells)
    model.boundary(kind="fixed", side="bottom")
    for side in sides:
        model.boundary(kind="roller", side=side)
    return model


def slope(cells: int) -> Model:
    """Return a slope of 2:1 on a firm base with φ = 20°, c = 0.05 γH, ψ = 0."""
    outline = [0, 0, 3.2, 0, 3.2, 1, 2, 1]
    strength = {"cohesion": 0.05 * WEIGHT * HEIGHT, "friction_angle": 20.0}
    return _soil_body(outline, cells, 0.3, ("right",), **strength)


def clay(cells: int) -> Model:
    """Return a slope of 2:1 in clay of c = ¼ γH, on a layer of this clay of the same height."""
    outline = [0, 0, 6, 0, 6, 2, 4, 2, 2, 1, 0, 1]
    strength = {"cohesion": 0.25 * WEIGHT * HEIGHT, "friction_angle": 0.0}
    return _soil_body(outline, cells, 0.3, ("left", "right"), **strength)


def cut(cells: int) -> Model:
    """Return a vertical cut in clay that is at its limit load by limit analysis."""
    outline = [-2, -1, 1, -1, 1, 0, 0, 0, 0, 1, -2, 1]
    strength = {"cohesion": WEIGHT * HEIGHT / CUT, "friction_angle": 0.0}
    return _soil_body(outline, cells, 0.49, ("left", "right"), **strength)


def factor(model: Model) -> Safety:
    """Return the factor of safety by strength reduction at small strains."""
    return safety(model, tolerance=4e-3, displacement=SMALL)


@case(
    "Slopes and a cut of soil that yields",
    "Factors of safety by strength reduction: 1.40 for a slope of 2:1 with φ = 20°, c = 0.05 γH;"
    " 1.47 for a slope of 2:1 in clay with c = ¼ γH on a layer of this clay of the same height; 1"
    " for a vertical cut in clay with c = γH/3.776.",
    "Griffiths & Lane (1999), Géotechnique 49, example 1 (charts: 1.380) and example 4 (their "
    "finite elements: 1.45; 1.47 is Taylor's, 1937); limit analysis for the cut.",
)
def slopes_that_yield(short: bool) -> Outcome:
    """Check each case with two sizes of cells; the short form is the cut with large cells."""
    rows, table = [], []
    cases = [("vertical cut", cut, 1.0, 0.06 if short else 0.03, 0.02, (4,) if short else (8, 16))]
    if not short:
        cases += [
            ("slope of clay", clay, 1.47, 0.03, 0.02, (8, 16)),
            ("slope with φ = 20°", slope, 1.40, 0.03, None, (10, 20)),
        ]
    for name, build, published, allowed, may_change, sizes in cases:
        results = [factor(build(cells)) for cells in sizes]
        finest = results[-1].factor
        label = f"factor of safety of the {name}, {sizes[-1]} cells over the height"
        rows.append(relative(label, published, finest, allowed))
        if not short:
            label = "relative change of this factor from cells of twice the size"
            rows.append(at_most(label, abs(finest / results[0].factor - 1), may_change))
        for cells, result in zip(sizes, results, strict=True):
            table.append((name, cells, result.low, result.high, published))
    head = ("case", "cells over the height", "stable", "unstable", "published")
    title = "Factor of safety: largest stable and smallest unstable divisor of the strength."
    return Outcome(rows, results[-1].draw().figure, [Table(title, head, table)])


def strip(cells, sink, size=(5.0, 3.0), angle=0.0, young=1e8, poisson=0.49, steps=60, **control):
    """Return a smooth strip footing of half-width 1 m on square cells of clay, c = 100 kPa."""
    model = Model()
    usual = {"time_step": 0.05, "steps": steps, "gravity": [0.0, 0.0]}
    model.control(analysis="plane_strain", **{"integration": "backward_euler"} | usual | control)
    model.contact(normal_stiffness=young)
    model.material(name="clay", density=2000.0, young_modulus=young, poisson_ratio=poisson,
                   law="mohr_coulomb", cohesion=1e5, friction_angle=angle,
                   dilation_angle=angle)  # fmt: skip
    model.joint(name="joint", friction_angle=30.0)
    values = -sink * np.arange(steps + 2) / steps
    model.motion(name="down", values=values.tolist(), quantity="displacement", time_step=0.05)
    columns, rows = (round(cells * length) for length in size)
    h = 1.0 / cells
    for j in range(rows):
        for i in range(columns):
            x, y, name = i * h, j * h - size[1], f"c{i}_{j}"
            corners = [x, y, x + h, y, x + h, y + h, x, y + h]
            model.block(vertices=corners, body="clay", name=name)
            if j == 0:
                for coordinate in (x, x + h):
                    model.fixed_point(x=coordinate, y=y, block=name)
            if i in (0, columns - 1):
                for coordinate in (y, y + h):
                    model.fixed_point(x=x + h * (i > 0), y=coordinate, block=name, direction="x")
            if j == rows - 1 and i < cells:
                for coordinate in (x, x + h):
                    model.fixed_point(x=coordinate, y=y + h, block=name, direction="y",
                        motion_y="down")  # fmt: skip
    return model


def bearing(history, sink):
    """Return pressure below the footing / cohesion in each step."""
    work = history.energy_input.values
    return np.diff(work) / (sink / (work.size - 1)) / 1e5


def prandtl(angle):
    """Return N_c = (N_q − 1) cot φ, N_q = e^(π tan φ) tan²(45° + φ/2)."""
    slope = np.tan(np.radians(angle))
    if slope == 0:
        return 2 + np.pi
    return (np.exp(np.pi * slope) * np.tan(np.radians(45 + angle / 2)) ** 2 - 1) / slope


@case(
    "The bearing capacity of a strip footing",
    "A smooth footing on soil without weight has N_c = (N_q − 1) cot φ, N_q = e^(π tan φ) "
    "tan²(45° + φ/2); without friction N_c = 2 + π. Strains remain small.",
    "Prandtl (1920); Reissner (1924).",
)
def footing(short: bool) -> Outcome:
    """Check the final pressure with four cells per half-width, and that no energy is gained."""
    rows, lines = [], []
    for angle, sink, steps, size, error in FOOTINGS:
        history = strip(4, sink, size, angle, young=1e10, steps=steps).run().history
        pressure, name = bearing(history, sink), f"φ = {angle:g}°"
        dissipated = history.energy_plastic.values
        balance = np.abs(history.energy_balance.values).max() / dissipated[-1]
        rows += [
            relative(f"{name}: N_c at the end", prandtl(angle), pressure[-1], error),
            relative(f"{name}: N_c after ½ of the settlement; expected: at the end", pressure[-1],
                pressure[pressure.size // 2], 0.01),
            relative(f"{name}: N_c after ¾ of the settlement; expected: at the end", pressure[-1],
                pressure[3 * pressure.size // 4], 5e-3),
            yes_or_no(f"{name}: the dissipation by yielding never decreases", True,
                bool(np.all(np.diff(dissipated) >= 0))),
            at_most(f"{name}: energy residual / dissipation by yielding", balance, 1e-9),
            at_most(f"{name}: median number of open–close iterations per step",
                np.median(history.iterations), 15),
        ]  # fmt: skip
        settled = 1e3 * sink * np.arange(1, pressure.size + 1) / pressure.size
        lines.append((settled, pressure, {"label": name}))
    return Outcome(rows, curves("settlement (mm)", "pressure / cohesion", *lines))
