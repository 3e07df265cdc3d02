# SPDX-License-Identifier: GPL-3.0-or-later
"""Models of random content: ground, rock and masonry with all kinds of groups."""

import random

import numpy as np
from model_text import group, namelist, rectangle

_WORDS = ("rock", "clay", "old masonry of the tower", "fill", "bedding plane", "drift $2",
          "_left", "Grauwacke, verwittert und geklüftet", "a", "crest of a slope")  # fmt: skip
_LAWS = (
    {},
    {"law": "mohr_coulomb", "cohesion": 2e4, "weakening_slip": 0.01, "dilation_angle": 6.0,
     "dilation_slip": 0.02},
    {"law": "barton_bandis", "jrc": 8.0, "jcs": 5e7, "normal_stiffness_per_area": 1e10,
     "max_closure": 1e-3},
    {"law": "plesha", "asperity_angle": 8.0, "asperity_wear": 1e-4},
    {"law": "cohesive", "cohesion": 2e5, "tensile_strength": 1e5, "fracture_energy": 50.0,
     "normal_stiffness_per_area": 1e11},
    {"law": "crushing", "crushing_strength": 5e6, "normal_stiffness_per_area": 1e11},
    {"law": "continuously_yielding", "initial_friction_angle": 50.0, "roughness": 1e-3},
    {"restitution": 0.2},
)  # fmt: skip


def random_model(seed: int) -> str:
    """Return the text of a model of a few dozen blocks that runs in a second.

    Parameters
    ----------
    seed : int
        Equal seeds give equal texts.
    """
    rng = random.Random(seed)
    return namelist(_KINDS[seed % len(_KINDS)](rng))


def _names(rng, kind: str, count: int) -> list[str]:
    return [f"{rng.choice(_WORDS)} {kind} {i + 1}" for i in range(count)]


def _begun(rng, stones, joints, size, weakest=20.0, **control) -> list:
    """Return title, control, springs, materials and joints of a model of blocks of a size (m)."""
    damped = rng.choice(({}, {}, {"damping_ratio": 0.03, "reference_frequency": 5.0},
                            {"rayleigh_beta": 1e-3}))  # fmt: skip
    title = " ".join(rng.choices(_WORDS, k=rng.randint(1, 5)))
    control = {"time_step": 1e-3, "steps": rng.choice([60, 150, 300]),
               "gravity": [0.0, -9.81], "analysis": "plane_strain",
               "integration": rng.choice(["dda", "midpoint", "theta"])} | control  # fmt: skip
    return [
        group("run", title=title),
        ("control", control),
        group("contact", normal_stiffness=1e10 * size),
        *(group("material", name=name, density=rng.uniform(1800, 2800), poisson_ratio=0.25,
                young_modulus=10 ** rng.uniform(8.5, 10.5), **damped) for name in stones),
        *(group("joint", name=name, friction_angle=rng.uniform(weakest, 45),
                **(rng.choice(_LAWS) if i else {})) for i, name in enumerate(joints)),
    ]  # fmt: skip


def _bricks(rng) -> list:
    """Return blocks in courses on a base block, shaken or not."""
    size = 10 ** rng.uniform(-0.5, 1.5)  # size of a block, m
    columns, rows = rng.randint(1, 7), rng.randint(1, 6)
    wide, tall = size * rng.uniform(0.6, 2.5), size
    box = (columns * wide, rows * tall)
    stones = _names(rng, "stone", rng.randint(1, 4))
    joints = _names(rng, "joint", rng.randint(1, 3))
    shaken = rng.random() < 0.6
    base = rng.choice(["points", "fixed", *["compliant"] * shaken])
    settle = base == "compliant" or rng.random() < 0.5
    groups = _begun(rng, stones, joints, size, 8.0, settle=settle)
    groups.append(group("block", name="ground", material=stones[0], joint=joints[0],
                        vertices=rectangle(-0.5 * wide, -tall, box[0] + wide, tall)))  # fmt: skip
    groups += _courses(rng, columns, rows, wide, tall, stones, joints)
    groups += _held(rng, base, box, tall, shaken)
    return groups + _more(rng, box, wide, tall) + [group("output", block_interval=10)]


def _courses(rng, columns, rows, wide, tall, stones, joints) -> list:
    """Return blocks in courses; some are missing at the top."""
    left_out, rows_of_blocks = rng.randint(0, columns - 1) * (rows > 1), []
    for row in range(rows):
        for column in range(columns - left_out * (row == rows - 1)):
            outline = rectangle(column * wide, row * tall, wide, tall)
            made_of = {"material": rng.choice(stones), "joint": rng.choice(joints)}
            name = f"brick {row + 1}.{column + 1}"
            rows_of_blocks.append(group("block", name=name, vertices=outline, **made_of))
    return rows_of_blocks


def _masonry(rng) -> list:
    """Return a façade with a door, windows and ties on a bed of springs, shaken or settling."""
    stones, joints = _names(rng, "stone", 2), _names(rng, "joint", 2)
    width, height = rng.uniform(5, 9), rng.uniform(3, 5)
    heads = [rng.choice(["arch", "lintel"]) for _ in range(2)]
    wall = group("masonry_wall", name="facade", width=width, height=height, stone=0.8,
                 courses=rng.randint(7, 10), bond=rng.choice(["running", "rubble"]),
                 material=stones[1], joint=joints[1], seed=rng.randint(0, 99),
                 **rng.choice(({}, {"ties": [0.8 * height], "tie_stiffness": 5e7})))  # fmt: skip
    return [
        *_begun(rng, stones, joints, 1.0, settle=True, steps=60),
        wall,
        group("opening", name="door", wall="facade", left=0.15 * width, width=1.0, height=2.0,
              head=heads[0]),
        group("opening", name="window", wall="facade", left=0.6 * width, bottom=1.0, width=1.0,
              height=1.1, head=heads[1]),
        group("layers", name="footing", left=-0.5, bottom=-0.6, width=width + 1.0, thickness=0.6),
        group("measured_point", name="top of the left corner", x=0.1, y=height - 0.1),
        group("measured_point", name="top", x=width - 0.1, y=height - 0.1),
        *_held(rng, rng.choice(["points", "fixed"]), (width, height), 0.6, True),
        *_now_and_then(rng, 0.4, group("load", x=0.5 * width, y=height - 0.1, time=[0, 1],
                                          force_y=[0.0, -2e5])),
        group("output", block_interval=20),
    ]  # fmt: skip


def _arch(rng) -> list:
    """Return an arch or a colonnade on ground, stable or not."""
    stones, joints = _names(rng, "stone", 2), _names(rng, "joint", 2)
    size = rng.uniform(2, 6)
    arch = group("arch", radius=size, thickness=size * rng.uniform(0.06, 0.2),
                 voussoirs=rng.randint(7, 21), material=stones[1], joint=joints[1])  # fmt: skip
    columns = group("colonnade", columns=3, drums=rng.randint(2, 5), spacing=size, left=-size,
                    width=0.25 * size, height=1.2 * size, material=stones[1], joint=joints[1],
                    beam_height=rng.choice([0, 0.2 * size]))  # fmt: skip
    return [
        *_begun(rng, stones, joints, 1.0, settle=rng.random() < 0.4),
        group("layers", name="ground", left=-2 * size, bottom=-1.0, width=4 * size, thickness=1.0),
        rng.choice([arch, columns]),
        *_held(rng, "points", (size, size), 1.0, rng.random() < 0.7),
        group("measured_point", name="ground", x=0.0, y=-0.4),
        *_now_and_then(rng, 0.3, group("stop", tilt=10.0)),
        group("output", block_interval=10),
    ]


def _slope(rng) -> list:
    """Return a slope of two joint sets with a water table or flowing water, and bolts."""
    stones, joints = _names(rng, "stone", 2), _names(rng, "set", 2)
    height = rng.uniform(8, 40)
    face = rng.uniform(0.3, 0.9) * height
    water = rng.choice((
        [], [group("water", surface=[-height, 0.1 * height, face, 0.3 * height,
                                     2 * height, 0.7 * height])],
        [group("flow", aperture=3e-4, state=rng.choice(["steady", "transient"])),
         group("flow_boundary", side="right", head=0.6 * height)],
    ))  # fmt: skip
    bolt = group("bolt", name="anchor", from_=[0.8 * face, 0.6 * height],
                 to=[1.6 * height, 0.4 * height], axial_stiffness=1e8, pretension=2e5)  # fmt: skip
    ground = [-height, -0.4 * height, 2 * height, -0.4 * height, 2 * height, 0.0, -height, 0.0]
    return [
        *_begun(rng, stones, joints, 10.0, 38.0, settle=rng.random() < 0.5),
        group("region", name="ground", material=stones[0], outline=ground),
        group("region", name="slope", material=stones[1], joint=joints[0],
              outline=[0.0, 0.0, 2 * height, 0.0, 2 * height, height, face, height]),
        group("joint_set", joint=joints[0], region="slope", angle=rng.uniform(10, 32),
              spacing=0.25 * height),
        group("joint_set", joint=joints[1], region="slope", angle=rng.uniform(95, 110),
              spacing=0.3 * height, spacing_distribution="normal", spacing_deviation=0.05 * height),
        *water,
        *_now_and_then(rng, 0.5, bolt),
        *_held(rng, rng.choice(["points", "fixed"]), (height, height), 0.4 * height,
               rng.random() < 0.6),
        group("boundary", kind="roller", side="right"),
        group("measured_point", name="crest", x=face + 0.01 * height, y=0.999 * height),
        group("output", block_interval=20),
    ]  # fmt: skip


def _columns(rng) -> list:
    """Return a rocking column of drums, or a wall section with a core."""
    stones, joints = _names(rng, "stone", 2), _names(rng, "joint", 2)
    width = 10 ** rng.uniform(-1, 0.5)
    drums = group("drums", width=width, top_width=0.8 * width, height=width, material=stones[1],
                  count=rng.randint(1, 12), joint=joints[1])  # fmt: skip
    wall = group("multi_leaf_wall", left=-width, height=5 * width, leaf=0.6 * width,
                 core=0.8 * width, courses=6, ties=rng.choice([0, 2]), material=stones[1],
                 core_material=stones[0], joint=joints[1])  # fmt: skip
    return [
        *_begun(rng, stones, joints, width, settle=rng.random() < 0.5),
        group("layers", name="ground", left=-4 * width, bottom=-width, width=8 * width,
              thickness=width),
        rng.choice([drums, wall]),
        *_held(rng, "fixed", (width, width), width, True),
        group("measured_point", name="foot", x=0.0, y=0.1 * width),
        *_now_and_then(rng, 0.5, group("measured_point", name="ground", x=0, y=-0.5 * width)),
        group("output", block_interval=10),
    ]  # fmt: skip


def _site(rng) -> list:
    """Return meshed layered ground with a compliant base and free-field or tied sides."""
    stones, joints = _names(rng, "soil", 3), _names(rng, "joint", 1)
    size = rng.uniform(3, 8)
    groups = _begun(rng, stones, joints, size, settle=True)
    if rng.random() < 0.5:
        soil = next(i for i, (name, _) in enumerate(groups) if name == "material")
        groups[soil][1].pop("damping_ratio", None), groups[soil][1].pop("rayleigh_beta", None)
        groups[soil][1].pop("reference_frequency", None)
        groups[soil][1].update(law="hysteretic", curve="hyperbolic", reference_strain=1e-3,
                               damping_ratio=0.02)  # fmt: skip
    hill = [-6 * size, 0.0, -2 * size, 0.0, 0.0, rng.uniform(0, 2) * size, 2 * size, 0.0,
            6 * size, 0.0]  # fmt: skip
    return [
        *groups,
        group("ground", name="ground", left=-6 * size, right=6 * size, bottom=-4 * size,
              core=rectangle(-1.5 * size, -1.5 * size, 3 * size, size), core_material=stones[1],
              surface=hill, size=size, material=stones[0], motion_x="shake",
              base=rng.choice(["compliant", "fixed"]),
              sides=rng.choice(["free_field", "tied", "viscous"])),
        _motion(rng),
        group("measured_point", name="surface", x=0.0, y=-0.1 * size),
        group("measured_point", name="base", x=0.0, y=-3.9 * size),
        *_now_and_then(rng, 0.5, group("amplification", surface="surface", base="base",
                                          lowest=1.0, highest=20.0)),
        group("output", block_interval=20),
    ]  # fmt: skip


def _tunnel(rng) -> list:
    """Return a tunnel or an excavation in stressed rock, jointed or meshed, elastic or yielding."""
    stones, joints = _names(rng, "rock", 1), _names(rng, "set", 2)
    half = rng.uniform(10, 20)
    bored = rng.random() < 0.5
    groups = _begun(rng, stones, joints, 10.0, 30.0, steps=60 if bored else None)
    rock = next(values for name, values in groups if name == "material")
    rock.pop("damping_ratio", None), rock.pop("reference_frequency", None)
    outline = rectangle(-half, -half, 2 * half, 2 * half)
    jointed = rng.random() < 0.5
    if jointed:
        angles = rng.uniform(5, 30), rng.uniform(95, 120)
        cut = [group("joint_set", joint=joint, angle=angle, spacing=0.35 * half)
               for joint, angle in zip(joints, angles, strict=True)]  # fmt: skip
    else:
        cut = [group("mesh", regions="rock", size=0.25 * half)]
        if rng.random() < 0.6:
            rock.update(law="mohr_coulomb", cohesion=1e5, friction_angle=30.0)
    hollow = (
        [group("tunnel", centre=[0.0, 0.0], width=0.5 * half,
               shape=rng.choice(["circle", "horseshoe", "rectangle"]), sides=16)]
        if bored else
        [group("excavation", name="cut", outline=rectangle(-0.3 * half, -0.2 * half, 0.6 * half,
                                                           0.4 * half)),
         group("stage", name="in place", kind="static"),
         group("stage", name="excavated", kind="static", remove="cut_*",
               zero_displacements=rng.random() < 0.5)]
    )  # fmt: skip
    return [
        *groups,
        group("in_situ", k0=rng.uniform(0.4, 1.5)),
        group("region", name="rock", outline=outline),
        *cut,
        *hollow,
        *(group("boundary", kind="roller", side=side) for side in ("left", "right", "bottom")),
        group("measured_point", name="roof", x=0.0, y=0.6 * half),
        group("output", block_interval=20),
    ]  # fmt: skip


def _dam(rng) -> list:
    """Return a dam on jointed rock with a reservoir, water in joints, with or without a motion."""
    stones, joints = _names(rng, "stone", 2), _names(rng, "joint", 2)
    tall = rng.uniform(10, 50)
    level = rng.uniform(0.6, 0.95) * tall
    rock = [-tall, -0.4 * tall, 2 * tall, -0.4 * tall, 2 * tall, 0.0, 0.8 * tall, 0.0, 0.0, 0.0,
            -tall, 0.0]  # fmt: skip
    dam = [0.0, 0.0, 0.8 * tall, 0.0, 0.15 * tall, 0.9 * tall, 0.15 * tall, tall, 0.0, tall]
    added = rng.random() < 0.5
    return [
        *_begun(rng, stones, joints, 20.0, 40.0, settle=True),
        group("region", name="rock", material=stones[0], joint=joints[0], outline=rock),
        group("joint_set", joint=joints[0], region="rock", angle=8.0, spacing=0.2 * tall),
        group("joint_set", joint=joints[0], region="rock", angle=98.0, spacing=0.4 * tall),
        group("block", name="dam", material=stones[1], joint=joints[1], vertices=dam),
        group("traction", name="reservoir", along=[0.0, 0.0, 0.0, tall], level=level,
              added_mass=added or None),
        group("traction", name="floor", along=[-tall, 0.0, 0.0, 0.0], level=level),
        group("flow", aperture=3e-4, state=rng.choice(["undrained", "transient"])),
        group("flow_boundary", side="left", head=level),
        group("flow_boundary", along=[0.8 * tall, 0, 2 * tall, 0, 2 * tall, -0.4 * tall], head=0.0),
        *_held(rng, "fixed", (tall, tall), tall, rng.random() < 0.7),
        *(group("boundary", kind="roller", side=side) for side in ("left", "right")),
        group("measured_point", name="crest", x=0.05 * tall, y=0.98 * tall),
        *_now_and_then(rng, 0.5, group("measured_joint", name="base", blocks="dam")),
        group("output", block_interval=20),
    ]  # fmt: skip


_KINDS = (_bricks, _masonry, _arch, _slope, _columns, _site, _tunnel, _dam)


def _now_and_then(rng, often: float, *groups) -> tuple:
    return groups if rng.random() < often else ()


def _motion(rng) -> tuple:
    """Return an acceleration whose displacement drifts, like that of a record."""
    time = np.arange(60) * 0.01
    values = rng.uniform(1, 8) * np.sin(2 * np.pi * rng.uniform(2, 8) * time) + 1.0
    return group("motion", name="shake", values=values.round(3).tolist(), time_step=0.01,
                 quantity="acceleration")  # fmt: skip


def _held(rng, base: str, box, tall, shaken: bool) -> list:
    """Return supports of the lowest blocks, and their motion."""
    along = {"motion_x": "shake"} if shaken else {}
    motion = [_motion(rng)] * shaken
    if base != "points":
        return [*motion, group("boundary", name="base", kind=base, side="bottom", **along)]
    return [*motion, *(group("fixed_point", x=x, y=-0.6 * tall, **along) for x in (0.0, box[0]))]


def _more(rng, box, wide, tall) -> list:
    """Return some of: points, bolts, water, loads, a mesh."""
    groups = []
    for i, name in enumerate(rng.sample(_WORDS, rng.randint(0, 6))):
        x, y = rng.uniform(0.02, 0.98) * box[0], rng.uniform(-0.9 * tall, box[1] - tall)
        groups.append(group("measured_point", name=f"{name} {i}", x=x, y=y))
    if rng.random() < 0.4:
        for i in range(rng.randint(1, 3)):
            x = rng.uniform(0.1, 0.9) * box[0]
            ends = {"from_": [x, 0.4 * tall], "to": [x, -0.5 * tall]}
            tie = {"axial_stiffness": 1e8, "pretension": 1e4}
            groups.append(group("bolt", name=f"bolt {i}", **ends, **tie))
    if rng.random() < 0.5:
        level = rng.uniform(-0.5, 0.5) * tall
        groups.append(group("water", surface=[-0.4 * wide, level, box[0] + 0.4 * wide, level]))
    load = group("load", x=0.5 * box[0], y=0.5 * tall, time=[0.0, 1.0], force_y=[0.0, -1e5 * tall])
    groups += _now_and_then(rng, 0.4, load)
    return [*groups, *_now_and_then(rng, 0.3, group("mesh", blocks="ground", size=0.5 * tall))]
