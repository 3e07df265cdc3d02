# SPDX-License-Identifier: GPL-3.0-or-later
"""Limits of slopes: sliding, toppling or stable blocks, and their limiting strength."""

import math
from typing import NamedTuple

import numpy as np
from shapely import Polygon

from sitedda.base.errors import ConvergenceError, SolverError
from sitedda.engine.simulation import Simulation
from sitedda.facade.model import Model
from sitedda.report.style import BLUE, RED, STONE, canvas
from sitedda.stability import bisect, mechanism, safety
from sitedda.stability.strength import released

from ..case import Outcome, Table, at_most, case, relative, yes_or_no
from ..model import GRAVITY, rectangle

LIMIT = 0.785544  # limiting tan φ of the 16 blocks
FORCES = (292.5, 825.7, 1556.0, 2826.7, 3922.1, 4594.8, 4837.0, 4637.4, 3978.0, 2825.5)
FORCES += (1412.6, 470.9)  # forces from block n on block n − 1, n = 13 … 2, kN/m
MODES = ("slides",) * 3 + ("topples",) * 10 + ("stable",) * 3  # modes of blocks 1 … 16


def goodman_bray(friction: float, bolt: float = 0.0) -> Model:
    """Return the 16 blocks of Goodman and Bray in axes of their base planes, which dip at 30°.

    Block 3 slides and block 4 topples without slip between them, so the shear springs determine
    the shear force there.  With springs stiffer than the normal ones, friction is mobilised, as
    limit equilibrium assumes; with k_n/k_s = 2.5, blocks move by centimetres near the limit.

    `friction`: tan φ of bases and sides; `bolt`: horizontal force on block 1, into the slope, N/m.
    """
    dip = math.radians(30.0)
    model = Model("Goodman and Bray, 16 blocks", time_step=1e-2)
    model.control(gravity=(GRAVITY * math.sin(dip), -GRAVITY * math.cos(dip)))
    model.contact(normal_stiffness=1e12, shear_ratio=0.1)
    model.material("rock", density=25000.0 / GRAVITY, young_modulus=1e13, poisson_ratio=0.2)
    model.joint("joint", friction_angle=math.degrees(math.atan(friction)))
    heights = [4.0 * n if n <= 10 else 40.0 - 6.0 * (n - 10) for n in range(1, 17)]
    steps = [(-10.0 * n, n - 1.0 + uphill) for n in range(1, 17) for uphill in (0.0, 1.0)]
    base = [(-170.0, -5.0), (10.0, -5.0), (10.0, 0.0), (0.0, 0.0), *steps, (-170.0, 16.0)]
    model.block(np.array(base), name="base")
    for n, height in enumerate(heights, 1):
        left, bottom = -10.0 * n, n - 1.0
        corners = [(left, bottom), (left + 10.0, bottom)]
        corners += [(left + 10.0, bottom + height), (left, bottom + height)]
        model.block(np.array(corners), name=f"block {n}")
    model.fixed_point(-169.0, -4.9)
    model.fixed_point(9.0, -4.9)
    if bolt:
        force = bolt * np.array([-math.cos(dip), -math.sin(dip)])
        model.load(-5.0, 2.0, "block 1", time=(0.0, 1e9), force_x=[force[0]] * 2,
            force_y=[force[1]] * 2)  # fmt: skip
    return model


class Rest(NamedTuple):
    """The equilibrium of a model."""

    forces: dict[tuple[int, int], float]  # normal force between two blocks, N/m
    polygons: list[np.ndarray]
    displacement: float  # largest displacement of a vertex, m


def rest_of(model: Model) -> Rest | None:
    """Add a static stage to a model and return its equilibrium; None if there is none."""
    with released(model, 1.0, None, 1.0, 1) as undeformed:  # the undeformed model
        starts = undeformed.polygons
    model.stage(name="rest", kind="static")
    try:
        with Simulation(model) as simulation:
            polygons, contacts = simulation.polygons, simulation.contacts
    except (ConvergenceError, SolverError):
        return None
    owner = np.repeat(np.arange(len(polygons)), [*map(len, polygons)])
    forces: dict[tuple[int, int], float] = {}
    columns = (contacts[name] for name in ("vertex", "edge", "normal_force"))
    for v, e, force in zip(*columns, strict=True):
        pair = tuple(sorted((int(owner[v]), int(owner[e]))))
        forces[pair] = forces.get(pair, 0.0) + float(force)
    displacement = max(abs(p - q).max() for p, q in zip(polygons, starts, strict=True))
    return Rest(forces, polygons, float(displacement))


@case(
    "Goodman and Bray's toppling slope of 16 blocks",
    "Limit equilibrium from block to block, downwards: toppling requires the support `P_{n-1} = "
    "[P_n (M_n - Δx tan φ) + ½ W (y sin α - Δx cos α)]/L_n`, sliding requires `P_{n-1} = P_n - "
    "W (cos α tan φ - sin α)/(1 - tan²φ)`; the larger force acts. A slope with Δx = 10 m and steps "
    "of 1 m on planes at 30° requires tan φ = 0.785544. Then blocks 16–14 are stable, 13–4 topple "
    "and 3–1 slide. With tan φ = 0.65, stability requires a horizontal bolt force of 2013 kN/m at "
    "block 1.",
    "Goodman and Bray (1976), Toppling of rock slopes.",
)
def goodman_bray_case(short: bool) -> Outcome:
    """Check limit, forces, modes and bolt force."""
    rows = [
        yes_or_no("the slope stands with tan φ 1 % above the limit", True,
            is_stable(goodman_bray(1.01 * LIMIT))),
        yes_or_no("the slope stands with tan φ 1 % below the limit", False,
            is_stable(goodman_bray(0.99 * LIMIT))),
    ]  # fmt: skip
    result = safety(goodman_bray(LIMIT), tolerance=0.02 if short else 1e-3)
    at_limit = rest_of(goodman_bray(LIMIT * 1.001))
    if not short:
        rows.append(relative("factor of safety at the limit", 1.0, result.factor, 0.01))
    for n, force in zip(range(13, 1, -1), FORCES, strict=True):
        computed = at_limit.forces.get((n - 1, n), 0.0) / 1e3 if at_limit else np.nan
        rows.append(relative(f"normal force between blocks {n} and {n - 1}", force, computed, 0.05,
            "kN/m"))  # fmt: skip
    modes = result.mechanism.verdicts[1:]
    differences = sum(a != b for a, b in zip(modes, MODES, strict=True))
    rows.append(at_most("number of blocks whose mode differs from the published mode", differences,
        0))  # fmt: skip
    if not short:
        bracket = bisect(lambda bolt: is_stable(goodman_bray(0.65, bolt)), 2.5e6, 1.5e6, 1e-3)
        rows.append(relative("smallest bolt force, tan φ = 0.65", 2013.0, sum(bracket) / 2e3, 0.02,
            "kN/m"))  # fmt: skip
    figure, axes = canvas(1, size=(9, 4))
    result.mechanism.draw(axes[0])
    return Outcome(rows, figure)


def is_stable(model: Model, allowed: float = 0.1) -> bool:
    """Return whether a model is in equilibrium and no vertex has moved by `allowed`, m."""
    equilibrium = rest_of(model)
    return equilibrium is not None and equilibrium.displacement < allowed


def single_block(friction: float, slope: float, width: float, height: float) -> Model:
    """Return a block on a slope, in axes of the slope.

    `friction`, `slope`: degrees; `width`, `height`: m.
    """
    dip = math.radians(slope)
    model = Model("Single block on a slope", time_step=1e-2)
    model.control(gravity=(10.0 * math.sin(dip), -10.0 * math.cos(dip)))
    model.contact(normal_stiffness=1e8, shear_ratio=1.0)
    model.material("rock", density=2000.0, young_modulus=1e10, poisson_ratio=0.2)
    model.joint("joint", friction_angle=friction)
    reach = 5.0 * (width + height)
    model.block(rectangle(-reach, -width, 3.0 * reach, width), name="base")
    model.block(rectangle(0.0, 0.0, width, height), name="block")
    model.fixed_point(-reach, 0.0, "base")
    model.fixed_point(2.0 * reach, -width, "base")
    return model


def limit_verdict(friction: float, slope: float, width: float, height: float):
    """Return the verdict on a single block, and its distance from a limit as a ratio minus 1.

    The block is stable if tan φ and b/h exceed tan α.  Otherwise it slides if tan φ < b/h, because
    the resultant then passes through its base; if not, it topples.
    """
    phi, alpha = (math.tan(math.radians(angle)) for angle in (friction, slope))
    ratio = width / height
    if phi > alpha and ratio > alpha:
        return "stable", min(phi, ratio) / alpha - 1.0
    if phi < alpha and phi < ratio:
        return "slides", min(alpha, ratio) / phi - 1.0
    return "topples", min(alpha, phi) / ratio - 1.0


@case(
    "A block on a slope: stable, slides or topples",
    "With tan δ = b/h, the block is stable if φ > α and δ > α, and slides if φ < α and φ < δ. "
    "Otherwise it topples. Random φ and α are from 5 to 60°, δ from 8 to 70°.",
    "Goodman and Bray (1976); Sagaseta (1986) for φ < α.",
)
def single_block_case(short: bool) -> Outcome:
    """Check the verdicts on random blocks and on published examples."""
    random = np.random.default_rng(17)
    trials = []
    for _ in range(12 if short else 200):
        friction, slope = random.uniform(5.0, 60.0, 2)
        angle = math.radians(random.uniform(8.0, 70.0))
        block = (friction, slope, 10.0, 10.0 / math.tan(angle))
        expected, margin = limit_verdict(*block)
        computed = mechanism(single_block(*block)).verdicts[1]
        trials.append((friction, slope, math.degrees(angle), expected, computed, margin))
    errors = [trial for trial in trials if trial[3] != trial[4]]
    rows = [
        at_most("number of wrong verdicts more than 1 % from a limit",
            sum(w[5] > 0.01 for w in errors), 0),
    ]  # fmt: skip
    for block, expected in (
        ((40.1, 40.0, 10.0, 10.0), "stable"),
        ((20.0, 40.0, 10.0, 5.0), "slides"),
        ((40.0, 40.0, 10.0, 25.0), "topples"),
    ):
        computed = mechanism(single_block(*block)).verdicts[1]
        rows.append(yes_or_no(f"φ = {block[0]:g}°, slope {block[1]:g}°, height {block[3]:g} m:"
            f" {expected}", True, computed == expected))  # fmt: skip
    figure, axes = canvas(1, size=(5.6, 4.6))
    for verdict, color in (("stable", STONE), ("slides", BLUE), ("topples", RED)):
        points = np.array([trial[:3] for trial in trials if trial[4] == verdict]).reshape(-1, 3)
        axes[0].plot(points[:, 0] - points[:, 1], points[:, 2] - points[:, 1], "o", ms=4, mec="0.3",
                     mew=0.3, color=color, label=verdict)  # fmt: skip
    axes[0].axhline(0.0, color="0.6", lw=0.8)
    axes[0].axvline(0.0, color="0.6", lw=0.8)
    axes[0].set(xlabel="φ − α (°)", ylabel="δ − α (°)")
    title = "Wrong verdicts" if errors else "No wrong verdict"
    head = ("φ (°)", "α (°)", "δ (°)", "expected", "computed", "distance from the limit")
    return Outcome(rows, figure, [Table(title, head, errors)])


def wet_wedge(friction: float, head: float) -> Model:
    """Return a block on a plane at 35° with water of a height (m) in the crack behind it.

    At `WET_HEAD`, uplift is 0.4 MN/m and thrust of water in the crack is 0.2 MN/m.
    """
    dip = math.radians(35.0)
    foot = WET_LENGTH * np.array([math.cos(dip), math.sin(dip)])
    top, toe = foot + [0.0, 8.0], -3.0 * np.array([math.cos(dip), math.sin(dip)])
    block = np.array([(0.0, 0.0), foot, top, (2.0, top[1])])
    area = Polygon(block).area
    model = Model("Block on a plane with water", time_step=1e-3, gravity=(0.0, -10.0))
    model.contact(normal_stiffness=1e11, shear_ratio=1.0)
    model.material("rock", density=WET_WEIGHT / 10.0 / area, young_modulus=1e12, poisson_ratio=0.2)
    model.joint("plane", friction_angle=friction)
    corners = [toe, (toe[0], -12.0), (25.0, -12.0), (25.0, top[1]), top, foot]
    model.block(np.array(corners), name="base")
    model.block(block, name="block")
    for position in ((25.0, -12.0), (25.0, top[1]), (toe[0], -12.0)):
        model.fixed_point(*position, "base")
    if head > 0.0:
        level = foot[1] + head
        model.water(along=[*top, *foot, 0.0, 0.0], head=[level, level, 0.0])
    return model


def wet_factor(friction: float, head: float) -> float:
    """Return the exact factor of safety, (W cos ψ − U − V sin ψ) tan φ/(W sin ψ + V cos ψ)."""
    dip, uplift, thrust = math.radians(35.0), 0.5 * WATER * head * WET_LENGTH, 0.5 * WATER * head**2
    resistance = WET_WEIGHT * math.cos(dip) - uplift - thrust * math.sin(dip)
    load = WET_WEIGHT * math.sin(dip) + thrust * math.cos(dip)
    return resistance * math.tan(math.radians(friction)) / load


WATER, WET_WEIGHT = 9810.0, 2.5e6  # unit weight of water (N/m³), weight of the block (N/m)
WET_HEAD = math.sqrt(0.4e6 / WATER)  # V = ½ γ z² = 0.2 MN/m
WET_LENGTH = 0.8e6 / (WATER * WET_HEAD)  # length A of the plane, m: U = ½ γ z A = 0.4 MN/m


@case(
    "A block on a plane with water in and under it",
    "The factor of safety is (W cos ψ - U - V sin ψ) tan φ/(W sin ψ + V cos ψ). With ψ = 35°, W ="
    " 2.5 MN/m, uplift U = 0.4 MN/m and thrust V = 0.2 MN/m, it is 0.9596 for φ = 45° (dry 1.428)"
    " and 0.5540 for φ = 30°. Also computed is the head in the crack at which it is 1 for φ = 45°.",
    "Hoek and Bray (1981), Rock slope engineering.",
)
def wet_wedge_case(short: bool) -> Outcome:
    """Check factors of safety and the limit of the head."""
    rows = []
    cases = ((45.0, WET_HEAD), (45.0, 0.0), (30.0, WET_HEAD))
    for friction, head in cases[:1] if short else cases:
        result = safety(wet_wedge(friction, head), tolerance=2e-3 if short else 2e-4)
        expected = wet_factor(friction, head)
        label = f"factor of safety, φ = {friction:g}°, {'wet' if head else 'dry'}"
        rows.append(relative(label, expected, result.factor, 0.005))
    limit = bisect(lambda z: wet_factor(45.0, z) > 1.0, 1.0, 8.0, 1e-9)[0]
    bracket = bisect(lambda z: is_stable(wet_wedge(45.0, z)), 5.0, 7.0, 4e-3 if short else 1e-4)
    rows.append(relative("limit of the water head in the crack, φ = 45°", limit, sum(bracket) / 2,
        0.005, "m"))  # fmt: skip
    figure, axes = canvas(1, size=(6, 4))
    result.mechanism.draw(axes[0])
    return Outcome(rows, figure)


def bolted_block(force: float, angle: float) -> Model:
    """Return a block of 100 kN/m on a plane at 40°, φ = 30°, with a bolt of constant force (N/m).

    The angle (degrees) is that between bolt and plane; the axes are those of the plane.
    """
    dip, radians = math.radians(40.0), math.radians(angle)
    model = Model("Bolted block", time_step=1e-3)
    model.control(gravity=(10.0 * math.sin(dip), -10.0 * math.cos(dip)))
    model.contact(normal_stiffness=1e10, shear_ratio=1.0)
    model.material("rock", density=2500.0, young_modulus=1e12, poisson_ratio=0.2)
    model.joint("plane", friction_angle=30.0)
    model.block([(-40, -15), (30, -15), (30, 0), (-40, 0)], name="base")
    model.block([(-20, 0), (-16, 0), (-16, 1), (-20, 1)], name="wall")
    model.block([(0, 0), (4, 0), (4, 1), (0, 1)], name="block")
    for x in (-40.0, 30.0):
        model.fixed_point(x, -15.0, "base")
    for x in (-20.0, -16.0):
        model.fixed_point(x, 0.5, "wall")
    head = np.array([2.0, 0.3])
    foot = head - 18.5 * np.array([math.cos(radians), math.sin(radians)])
    model.bolt("bolt", head, foot, "block", "base" if angle else "wall", axial_stiffness=1e3,
               pretension=force, yield_force=force)  # fmt: skip
    return model


@case(
    "The smallest bolt force that holds a block on a plane",
    "The smallest force at an angle ε to the plane is T = W (sin α - cos α tan φ)/(cos ε + sin ε "
    "tan φ). With W = 100 kN/m, α = 40° and φ = 30° it is 20.0512 kN/m at ε = 0. Its minimum is "
    "17.3648 kN/m at ε = φ.",
    "Statics.",
)
def bolted_block_case(short: bool) -> Outcome:
    """Check the required force at several angles, and the angle of the smallest force."""
    dip, tangent = math.radians(40.0), math.tan(math.radians(30.0))
    angles = (0.0, 30.0) if short else (0.0, 10.0, 20.0, 26.0, 30.0, 34.0, 40.0, 50.0)
    rows, forces = [], []
    for angle in angles:
        radians = math.radians(angle)
        expected = 100.0 * (math.sin(dip) - math.cos(dip) * tangent)
        expected /= math.cos(radians) + math.sin(radians) * tangent
        bracket = bisect(lambda force, angle=angle: is_stable(bolted_block(force, angle)), 25e3,
                         15e3, 4e-3 if short else 1e-4)  # fmt: skip
        forces.append(sum(bracket) / 2e3)
        rows.append(relative(f"smallest bolt force, ε = {angle:g}°", expected, forces[-1], 0.005,
            "kN/m"))  # fmt: skip
    best_angle = angles[int(np.argmin(forces))]
    rows.append(at_most("|ε − φ| at the minimum of the bolt force", abs(best_angle - 30.0), 0.0,
        "°"))  # fmt: skip
    figure, axes = canvas(1, size=(5.6, 3.6))
    axes[0].plot(angles, forces, "o-", color=BLUE)
    axes[0].axvline(30.0, color=RED, lw=0.8, ls="--")
    axes[0].set(xlabel="angle to the plane (°)", ylabel="smallest force (kN/m)")
    return Outcome(rows, figure)
