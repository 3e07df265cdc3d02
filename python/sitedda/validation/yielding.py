# SPDX-License-Identifier: GPL-3.0-or-later
"""Slopes and cuts of soil that yields, against published factors of safety."""

from ..build.model import Model
from ..stability.safety import Safety, safety
from .case import Outcome, Table, at_most, case, relative

HEIGHT = 10.0  # m, H
WEIGHT = 2e4  # N/m³, γ
STIFF = 1e10  # Pa: the strength is reached at small strains
SMALL = 1e-3  # of the radius of the body: a displacement that is failure at small strains
CUT = 3.776  # γH/c by limit analysis


def _soil(outline, cells: int, poisson: float, sides, **strength) -> Model:
    """A body of one soil on a held base, between rollers."""
    model = Model()
    model.control(time_step=1.0, gravity=[0.0, -10.0], analysis="plane_strain")
    model.contact(normal_stiffness=STIFF)
    model.material(
        name="soil", density=WEIGHT / 10.0, young_modulus=STIFF, poisson_ratio=poisson,
        law="mohr_coulomb", **strength,
    )  # fmt: skip
    model.joint(name="joint", friction_angle=30.0)
    model.block(vertices=[HEIGHT * value for value in outline], name="ground")
    model.mesh(blocks="ground", size=HEIGHT / cells)
    model.boundary(kind="fixed", side="bottom")
    for side in sides:
        model.boundary(kind="roller", side=side)
    return model


def slope(cells: int) -> Model:
    """2:1 on a firm base, φ = 20°, c = .05 γH, ψ = 0."""
    outline = [0, 0, 3.2, 0, 3.2, 1, 2, 1]
    return _soil(
        outline, cells, 0.3, ("right",), cohesion=0.05 * WEIGHT * HEIGHT, friction_angle=20.0
    )


def clay(cells: int) -> Model:
    """2:1 on as much of the same clay as it is high, c = ¼ γH."""
    outline = [0, 0, 6, 0, 6, 2, 4, 2, 2, 1, 0, 1]
    return _soil(
        outline, cells, 0.3, ("left", "right"), cohesion=0.25 * WEIGHT * HEIGHT, friction_angle=0.0
    )


def cut(cells: int) -> Model:
    """A vertical cut of clay, of the strength at which limit analysis has it fail."""
    outline = [-2, -1, 1, -1, 1, 0, 0, 0, 0, 1, -2, 1]
    return _soil(
        outline, cells, 0.49, ("left", "right"), cohesion=WEIGHT * HEIGHT / CUT,
        friction_angle=0.0,
    )  # fmt: skip


def factor(model: Model) -> Safety:
    """By strength reduction at small strains."""
    return safety(model, tolerance=4e-3, displacement=SMALL)


@case(
    "Slopes and a cut of soil that yields",
    "Factors of safety by strength reduction, F: 1.40 of a slope of 2:1 with φ = 20°, c = .05 γH; "
    "1.47 of a slope of 2:1 in clay of c = ¼ γH over as much clay; 1 of a vertical cut of clay of "
    "c = γH/3.776.",
    "Griffiths & Lane (1999), Géotechnique 49, example 1 (charts: 1.380) and example 4 (their "
    "finite elements: 1.45; 1.47 is Taylor's, 1937); limit analysis for the cut.",
)
def slopes_that_yield(short: bool) -> Outcome:
    """Two sizes of cells each; the short form is the cut with large ones."""
    rows, table = [], []
    cases = [("vertical cut", cut, 1.0, 0.06 if short else 0.03, 0.02, (4,) if short else (8, 16))]
    if not short:
        cases += [
            ("slope of clay", clay, 1.47, 0.03, 0.02, (8, 16)),
            ("slope, φ = 20°", slope, 1.40, 0.03, None, (10, 20)),
        ]
    for name, build, published, allowed, may_change, sizes in cases:
        found = [factor(build(cells)) for cells in sizes]
        last = found[-1].factor
        label = f"{name}, {sizes[-1]} cells over the height: factor of safety"
        rows.append(relative(label, published, last, allowed))
        if not short:
            label = f"{name}: change from cells of twice the size"
            rows.append(at_most(label, abs(last / found[0].factor - 1), may_change))
        for cells, one in zip(sizes, found, strict=True):
            table.append((name, cells, one.low, one.high, published))
    head = ("", "cells over the height", "stands at", "fails at", "published")
    return Outcome(rows, found[-1].draw().figure, [Table("Strength divided by.", head, table)])
