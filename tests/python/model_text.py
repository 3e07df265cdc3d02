# SPDX-License-Identifier: GPL-3.0-or-later
"""Namelist inputs written from Python, and two small models for most tests."""

import copy

from sitedda.groups import value_text

ROCK = {"name": "rock", "density": 2643.0, "young_modulus": 4.788e9, "poisson_ratio": 0.25}
BONDED = {"name": "bedding", "friction_angle": 50.0, "cohesion": 100.0e6,
          "tensile_strength": 50.0e6}  # fmt: skip
DRY = {"name": "bedding", "friction_angle": 35.0}


def group(name: str, /, **variables) -> tuple[str, dict]:
    """Return a group for `namelist`; names that are words of Python end with _."""
    return name, {variable.removesuffix("_"): value for variable, value in variables.items()}


def namelist(groups) -> str:
    """Return the text of groups (name, variables), one variable per line."""
    texts = [(n, "".join(f"   {k} = {value_text(v)}\n" for k, v in g.items() if v is not None))
             for n, g in groups]  # fmt: skip
    return "".join(f"&{name}\n{variables}/\n" for name, variables in texts)


def changed(groups, group: str, which: int = 0, **values) -> list:
    """Return a copy with changed variables of the `which`-th group of a name; None removes one."""
    groups = copy.deepcopy(list(groups))
    target = [have for name, have in groups if name == group][which]
    target.update(values)
    for variable in [variable for variable, value in values.items() if value is None]:
        del target[variable]
    return groups


def without(groups, group: str) -> list:
    """Return a copy without the groups of a name."""
    return [pair for pair in copy.deepcopy(list(groups)) if pair[0] != group]


def rectangle(left: float, bottom: float, width: float, height: float) -> list[float]:
    """Return the vertices of a rectangle, counter-clockwise, as in &block."""
    right, top = left + width, bottom + height
    return [left, bottom, right, bottom, right, top, left, top]


def tower(layers: int = 3, steps: int = 60, joint=None, **control) -> list:
    """Return layers of 15 m x 1 m on a base block with a short pulse as motion."""
    return [
        group("run", title="A small tower"),
        ("control", {"time_step": 1e-3, "steps": steps, **control}),
        group("contact", normal_stiffness=1.5e12),
        ("material", dict(ROCK)),
        ("joint", dict(joint or BONDED)),
        group("layers", name="base", bottom=-1.0, width=15.0, thickness=1.0),
        group("layers", name="layer", width=15.0, thickness=1.0, count=layers),
        group("motion", name="pulse", values=[0.0, 0.3, 0.5, 0.1, -0.4, -0.2, 0.0], time_step=0.01,
              quantity="acceleration"),
        *(
            group("fixed_point", x=x, y=y, motion_x="pulse")
            for y in (-0.25, -0.75)
            for x in (2.5, 12.5)
        ),
        group("measured_point", name="base", x=7.5, y=-0.5, block="base_1"),
        group("measured_point", name="surface", x=7.5, y=float(layers)),
        group("output", file="tower.nc", block_interval=20),
    ]  # fmt: skip


def flying_block(steps: int = 50, **control) -> list:
    """Return one free block, 2 m x 1 m, without neighbours."""
    return [
        ("control", {"time_step": 1e-3, "steps": steps, **control}),
        group("contact", normal_stiffness=1.0e9),
        ("material", dict(ROCK)),
        ("joint", dict(DRY)),
        group("block", name="brick", vertices=rectangle(0.0, 0.0, 2.0, 1.0)),
        group("measured_point", name="corner", x=2.0, y=1.0),
    ]
