# SPDX-License-Identifier: GPL-3.0-or-later
"""Models of random content: blocks, materials, joints, bolts, water, loads, points, motions."""

import random

import numpy as np
from model_text import group, namelist, rectangle

_WORDS = ("rock", "clay", "old masonry of the tower", "fill", "bedding plane", "drift $2",
          "_left", "Grauwacke, verwittert und geklüftet", "a", "crest of a slope")  # fmt: skip


def random_model(seed: int) -> str:
    """The text of a model of a few dozen blocks that runs in a second.

    Parameters
    ----------
    seed : int
        The same one gives the same text.
    """
    chance = random.Random(seed)
    size = 10 ** chance.uniform(-0.5, 1.5)  # m, of a block
    columns, rows = chance.randint(1, 7), chance.randint(1, 6)
    wide, tall = size * chance.uniform(0.6, 2.5), size
    box = (columns * wide, rows * tall)
    stones = _names(chance, "stone", chance.randint(1, 4))
    joints = _names(chance, "joint", chance.randint(1, 3))
    shaken = chance.random() < 0.6
    base = chance.choice(["points", "fixed", *["compliant"] * shaken])
    settle = base == "compliant" or chance.random() < 0.5
    groups = [group("run", title=" ".join(chance.choices(_WORDS, k=chance.randint(1, 5)))),
              group("control", time_step=1e-3, steps=chance.choice([60, 150, 300]),
                    gravity=[0.0, -9.81], analysis="plane_strain", settle=settle),
              group("contact", normal_stiffness=1e10 * size)]  # fmt: skip
    groups += [group("material", name=name, density=chance.uniform(1800, 2800), poisson_ratio=0.25,
                     young_modulus=10 ** chance.uniform(8.5, 10.5)) for name in stones]  # fmt: skip
    groups += [group("joint", name=name, friction_angle=chance.uniform(8, 45)) for name in joints]
    groups.append(group("block", name="ground", material=stones[0], joint=joints[0],
                        vertices=rectangle(-0.5 * wide, -tall, box[0] + wide, tall)))  # fmt: skip
    groups += _wall(chance, columns, rows, wide, tall, stones, joints)
    if shaken:
        groups.append(_motion(chance))
    held = {"motion_x": "shake"} if shaken else {}
    groups += _held(base, box, tall, held)
    return namelist(groups + _more(chance, box, wide, tall) + [group("output", block_interval=10)])


def _names(chance, kind: str, count: int) -> list[str]:
    return [f"{chance.choice(_WORDS)} {kind} {i + 1}" for i in range(count)]


def _wall(chance, columns, rows, wide, tall, stones, joints) -> list:
    """Blocks in courses, some of them left out at the top."""
    left_out, found = chance.randint(0, columns - 1) * (rows > 1), []
    for row in range(rows):
        for column in range(columns - left_out * (row == rows - 1)):
            outline = rectangle(column * wide, row * tall, wide, tall)
            made_of = {"material": chance.choice(stones), "joint": chance.choice(joints)}
            name = f"brick {row + 1}.{column + 1}"
            found.append(group("block", name=name, vertices=outline, **made_of))
    return found


def _motion(chance) -> tuple:
    """An acceleration whose displacement drifts, as those of records do."""
    time = np.arange(60) * 0.01
    values = chance.uniform(1, 8) * np.sin(2 * np.pi * chance.uniform(2, 8) * time) + 1.0
    return group("motion", name="shake", values=values.round(3).tolist(), time_step=0.01,
                 quantity="acceleration")  # fmt: skip


def _held(base: str, box, tall, held: dict) -> list:
    if base != "points":
        return [group("boundary", name="base", kind=base, side="bottom", **held)]
    return [group("fixed_point", x=x, y=-0.6 * tall, **held) for x in (0.0, box[0])]


def _more(chance, box, wide, tall) -> list:
    """Points, bolts, water, loads, a mesh: each of them now and then."""
    found = []
    for i, name in enumerate(chance.sample(_WORDS, chance.randint(0, 6))):
        x, y = chance.uniform(0.02, 0.98) * box[0], chance.uniform(-0.9 * tall, box[1] - tall)
        found.append(group("measured_point", name=f"{name} {i}", x=x, y=y))
    if chance.random() < 0.4:
        for i in range(chance.randint(1, 3)):
            x = chance.uniform(0.1, 0.9) * box[0]
            found.append(group("bolt", name=f"bolt {i}", from_=[x, 0.4 * tall], to=[x, -0.5 * tall],
                               axial_stiffness=1e8, pretension=1e4))  # fmt: skip
    if chance.random() < 0.5:
        level = chance.uniform(-0.5, 0.5) * tall
        found.append(group("water", surface=[-0.4 * wide, level, box[0] + 0.4 * wide, level]))
    if chance.random() < 0.4:
        found.append(group("load", x=0.5 * box[0], y=0.5 * tall, time=[0.0, 1.0],
                           force_y=[0.0, -1e5 * tall]))  # fmt: skip
    if chance.random() < 0.3:
        found.append(group("mesh", blocks="ground", size=0.5 * tall))
    return found
