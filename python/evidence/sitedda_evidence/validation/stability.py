# SPDX-License-Identifier: GPL-3.0-or-later
"""Limits of stability: toppling blocks on a slope and masonry arches, against limit analysis."""

import numpy as np
import shapely
from scipy.optimize import linprog

from sitedda.report.style import BLUE, GROUND, RED, STONE, bare, canvas, draw_blocks
from sitedda.stability import bisect

from .. import model as nml
from ..case import Outcome, Table, at_most, case, relative, true

DENSITY = 2500.0  # kg/m³


# ---------------------------------------------------------------- limit analysis


def stands(polygons, joints, friction: float) -> bool:
    """Whether equilibrium is possible: no tension, Coulomb friction, own weight (linprog).

    Parameters
    ----------
    polygons : list of ndarray
        Blocks, shape (n, 2), m.
    joints : list of (int, int, ndarray, ndarray)
        Block pushed, block pushed against (−1: held), end points of the joint (2, 2), and the
        unit normal towards the block pushed.
    friction : float
        Coefficient.

    Notes
    -----
    Two forces at the ends of each joint, each with normal part N ≥ 0 and shear part
    T = T⁺ − T⁻ with T⁺ + T⁻ ≤ μ N, hold all blocks (Livesley 1978).  This is the same choice
    of forces that the engine has: two contacts in each joint.
    """
    columns, sizes = [], 3 * len(polygons)
    shapes = [shapely.Polygon(polygon) for polygon in polygons]
    centres = shapely.get_coordinates(shapely.centroid(shapes))
    for first, second, ends, normal in joints:
        tangent = np.array([-normal[1], normal[0]])
        for point in ends:
            for direction in (normal + friction * tangent, normal - friction * tangent):
                column = np.zeros(sizes)
                for body, sign in ((first, 1.0), (second, -1.0)):
                    if body >= 0:
                        arm = point - centres[body]
                        moment = arm[0] * direction[1] - arm[1] * direction[0]
                        column[3 * body : 3 * body + 3] = sign * np.append(direction, moment)
                columns.append(column)
    weight = np.zeros(sizes)
    weight[1::3] = shapely.area(shapes)
    balance = {"A_eq": np.array(columns).T, "b_eq": weight}
    return linprog(np.zeros(len(columns)), **balance, bounds=(0, None)).status == 0


def _bisect_limit(stands, low: float, high: float) -> float:
    """Return the value above which something stands, between two values."""
    return 0.5 * sum(bisect(stands, high, low, 1e-6))


# ---------------------------------------------------------------- arch

RADIUS = 5.0  # m, of the centre line
ARCH_FRICTION = 60.0  # °, so that nothing slides


def voussoirs(count: int, thickness: float) -> list[np.ndarray]:
    """Equal straight-sided voussoirs of a semicircular arch, from the right springing."""
    angle = np.linspace(0.0, np.pi, count + 1)
    ray = np.column_stack([np.cos(angle), np.sin(angle)])
    inner, outer = (RADIUS - 0.5 * thickness) * ray, (RADIUS + 0.5 * thickness) * ray
    return [np.array([inner[i], outer[i], outer[i + 1], inner[i + 1]]) for i in range(count)]


def _arch_stands(count: int, thickness: float) -> bool:
    shapes = voussoirs(count, thickness)
    angle = np.linspace(0.0, np.pi, count + 1)
    joints = []
    for i in range(count + 1):
        ends = shapes[i][:2] if i < count else shapes[-1][2:]
        normal = np.array([-np.sin(angle[i]), np.cos(angle[i])])
        if i < count:
            joints.append((i, i - 1, ends, normal))
        else:
            joints.append((count - 1, -1, ends, -normal))
    return stands(shapes, joints, np.tan(np.radians(ARCH_FRICTION)))


@case(
    "Thickness at which a semicircular arch falls",
    "Limit analysis (linprog, no tension, friction 60°) of the same straight-sided voussoirs gives "
    "the least thickness over the radius of the centre line; the engine must stand 3 % above it "
    "and fall 3 % below. The continuum's limit is t/R = 0.1075.",
    "Heyman (1969), Int. J. Mech. Sci. 11; Livesley (1978); Makris & Alexakis (2013) for 0.1075.",
)
def arch(short: bool) -> Outcome:
    """15 and 27 voussoirs, 3 % above and below the limit."""
    rows, lines, drawn = [], [], []
    for count in (15,) if short else (15, 27):
        limit = _bisect_limit(lambda t, n=count: _arch_stands(n, t * RADIUS), 0.05, 0.2)
        lines.append((count, limit, 0.1075, limit / 0.1075 - 1))
        for side, falls in ((1.03, False), (0.97, True)):
            found = _arch_collapses(count, side * limit * RADIUS)
            label = f"{count} voussoirs, {side:g} of the limit t/R = {limit:.5f}: it falls"
            rows.append(true(label, falls, found["fell"]))
            label = f"{count} voussoirs, {side:g}: audit residual over the work of gravity"
            rows.append(at_most(label, found["audit"], 1e-6))
            if not falls:
                label = f"{count} voussoirs, {side:g}: kinetic energy at the end over m g R"
                rows.append(at_most(label, found["kinetic"], 1e-9))
            drawn.append((f"{count} voussoirs, {side:g} of the limit", found))
    table = Table(
        "Limit thickness over radius.",
        ("voussoirs", "limit analysis", "continuum", "relative difference"),
        lines,
    )
    return Outcome(rows, _draw_arch(drawn), [table])


def _arch_collapses(count: int, thickness: float, time_step: float = 2e-3, duration: float = 8.0):
    """Apply gravity to an arch; return whether its crown sank by the thickness."""
    shapes = voussoirs(count, thickness)
    springing = RADIUS + 0.5 * thickness + 0.5
    ground = np.array([[-springing, -1], [springing, -1], [springing, 0], [-springing, 0]])
    text = nml.text(
        nml.control(time_step, round(duration / time_step)),
        nml.contact(1e13),
        nml.material("stone", DENSITY, nml.STIFF),
        nml.joint("rough", ARCH_FRICTION),
        nml.held("ground", ground),
        *(nml.block(f"v{i}", shape) for i, shape in enumerate(shapes)),
    )
    crown, time, sink = count // 2 + 1, [], []
    with nml.simulation(text) as opened:
        start = opened.coordinates[crown, 1]
        while not opened.done:
            opened.advance(10)
            time.append(opened.time)
            sink.append(start - opened.coordinates[crown, 1])
            if sink[-1] > thickness:
                break
        energies, polygons = opened.energies, opened.polygons
    weight = DENSITY * nml.GRAVITY * np.pi * RADIUS * thickness
    return {
        "fell": sink[-1] > thickness,
        "kinetic": energies["kinetic"] / (weight * RADIUS),
        "audit": abs(energies["balance"] / energies["gravity"]),
        "time": np.array(time),
        "sink": np.array(sink) / thickness,
        "polygons": polygons,
        "start": shapes,
    }


def _draw_arch(drawn):
    figure, axes = canvas(len(drawn), 2, size=(3.4 * len(drawn), 5), height_ratios=[3, 2])
    for i, (label, found) in enumerate(drawn):
        top, below = axes[i], axes[i + len(drawn)]
        draw_blocks(top, found["start"], "none", edge="0.6", lw=0.4)
        draw_blocks(top, found["polygons"], [GROUND, *[STONE] * len(found["start"])])
        top.set_title(label, fontsize=9)
        bare(top)
        color = RED if found["fell"] else BLUE
        below.semilogy(found["time"], np.maximum(np.abs(found["sink"]), 1e-12), color=color)
        below.set(xlabel="time (s)", ylim=(1e-10, 2))
    axes[len(drawn)].set_ylabel("sinking of the crown / thickness")
    return figure


# ---------------------------------------------------------------- toppling

COLUMN, STEP, FALL, DIP, CREST = 10.0, 1.0, 5.0, 30.0, 9  # m, m, m, °, block from 0
GAP = 1e-6  # m, on each side of a column
HEIGHTS = np.array([4.0 * n for n in range(1, 11)] + [40.0 - 6.0 * n for n in range(1, 7)])


def goodman_bray(friction: float) -> float:
    """Return the toe force (N/m) required in Goodman & Bray's example; ≤ 0 if stable.

    Blocks from the top down: toppling requires P = [P' (M − Δx μ) + ½ W (y sin ψ − Δx cos ψ)]/L,
    sliding for P = P' − W (μ cos ψ − sin ψ)/(1 − μ²), from a force P' from above; the greater one
    is passed on.  L is how high the block pushes on the next below, M how high it is pushed.
    """
    mu, psi = np.tan(np.radians(friction)), np.radians(DIP)
    passed = 0.0
    for n in reversed(range(len(HEIGHTS))):
        y = HEIGHTS[n]
        weight = DENSITY * nml.GRAVITY * COLUMN * y
        high = y if n < CREST else y - FALL
        low = y - FALL if n <= CREST else y
        slide = passed - weight * (mu * np.cos(psi) - np.sin(psi)) / (1 - mu**2)
        topple = -np.inf
        if low > 0:
            turn = 0.5 * weight * (y * np.sin(psi) - COLUMN * np.cos(psi))
            topple = (passed * (high - COLUMN * mu) + turn) / low
        passed = max(topple, slide, 0.0)
    return passed


def _slope_columns() -> tuple[list[np.ndarray], np.ndarray]:
    """Return the sixteen columns and the stepped base, rotated by the dip."""
    turn = np.radians(DIP)
    shapes = [
        nml.rectangle(n * COLUMN + GAP, n * STEP, COLUMN - 2 * GAP, height)
        for n, height in enumerate(HEIGHTS)
    ]
    count = len(HEIGHTS)
    right = COLUMN * count + 20.0
    stairs = [(-60.0, -20.0), (right, -20.0), (right, STEP * count)]
    for n in reversed(range(count)):
        stairs += [((n + 1) * COLUMN, (n + 1) * STEP), ((n + 1) * COLUMN, n * STEP)]
    stairs.append((-60.0, 0.0))
    return [nml.turned(shape, turn) for shape in shapes], nml.turned(stairs, turn)


def _slope_stands(friction: float) -> bool:
    """Limit analysis of the columns: bases and touching sides."""
    turn = np.radians(DIP)
    shapes, _ = _slope_columns()
    up, down = nml.turned([[0, 1], [-1, 0]], turn)
    joints = []
    for n, height in enumerate(HEIGHTS):
        base = nml.turned([[n * COLUMN, n * STEP], [(n + 1) * COLUMN, n * STEP]], turn)
        joints.append((n, -1, base, up))
        if n + 1 < len(HEIGHTS):
            top = min(n * STEP + height, (n + 1) * STEP + HEIGHTS[n + 1])
            side = np.array([[(n + 1) * COLUMN, (n + 1) * STEP], [(n + 1) * COLUMN, top]])
            joints.append((n, n + 1, nml.turned(side, turn), down))
    return stands(shapes, joints, np.tan(np.radians(friction)))


@case(
    "Toppling slope of Goodman & Bray",
    "Sixteen columns of 10 m on a stepped base that dips 30°, slope 56.6°: Goodman & Bray's sums "
    "of toppling and sliding blocks ask for φ = 38.15° (tan φ = 0.7855). Limit analysis (linprog) "
    "of the same columns stands beside: it may place each force where it helps most.",
    "Goodman & Bray (1976), ASCE Rock Engineering for Foundations and Slopes; Wyllie & Mah (2004), "
    "Rock Slope Engineering, §9.4.",
)
def toppling(short: bool) -> Outcome:
    """Stands and falls 5 % of tan φ on each side; the engine's own limit by bisection."""
    limit = _bisect_limit(lambda phi: goodman_bray(phi) <= 1e-9, 30.0, 44.0)
    lower = _bisect_limit(_slope_stands, 20.0, 44.0)
    mu = np.tan(np.radians(limit))
    rows = [relative("Goodman & Bray's limit as printed", 0.7855, mu, 2e-3)]
    drawn = []
    for side, falls in ((1.05, False), (0.95, True)):
        found = _run_slope(np.degrees(np.arctan(side * mu)))
        rows.append(true(f"{side:g} of tan φ = {mu:.4f}: it falls", falls, found["fell"]))
        label = f"{side:g}: audit residual over the work of gravity"
        rows.append(at_most(label, found["audit"], 1e-6))
        drawn.append((f"{side:g} of the limit", found))
    tables = []
    if not short:
        rests = lambda one: not _run_slope(np.degrees(np.arctan(one)))["fell"]  # noqa: E731
        own = 0.5 * sum(bisect(rests, 1.05 * mu, 0.95 * mu, 4e-3))
        rows.append(relative("limit of the engine by bisection, tan φ", mu, own, 3e-2))
        by_analysis = np.tan(np.radians(lower))
        lines = [("Goodman & Bray", mu), ("limit analysis", by_analysis), ("engine", own)]
        tables = [Table("Least tan φ with which the slope stands.", ("by", "tan φ"), lines)]
    return Outcome(rows, _draw_slope(drawn), tables)


def _run_slope(friction: float, time_step: float = 2e-3, duration: float = 10.0) -> dict:
    """Apply gravity to the slope; return whether a column moved by more than 1 m."""
    shapes, ground = _slope_columns()
    text = nml.text(
        nml.control(time_step, round(duration / time_step)),
        nml.contact(1e12),
        nml.material("rock", DENSITY, 1e14),
        nml.joint("joint", friction),
        nml.held("ground", ground, points=[ground[0], ground[1], ground[2], ground[-1]]),
        *(nml.block(f"c{n}", shape) for n, shape in enumerate(shapes)),
    )
    with nml.simulation(text) as slope:
        start, moved = slope.coordinates[1:, :2], 0.0
        while not slope.done and moved < 2.0:
            slope.advance(25)
            moved = np.linalg.norm(slope.coordinates[1:, :2] - start, axis=1).max()
        return {
            "fell": moved > 1.0,
            "moved": moved,
            "audit": abs(slope.energies["balance"] / slope.energies["gravity"]),
            "time": slope.time,
            "polygons": slope.polygons,
            "start": shapes,
            "friction": friction,
        }


def _draw_slope(drawn):
    figure, axes = canvas(len(drawn), size=(6 * len(drawn), 5))
    for one, (label, found) in zip(axes, drawn, strict=True):
        draw_blocks(one, found["start"], "none", edge="0.6")
        draw_blocks(one, found["polygons"], [GROUND, *[STONE] * len(found["start"])])
        one.set_title(
            f"{label}, φ {found['friction']:.1f}°: moved {found['moved']:.2g} m "
            f"in {found['time']:.0f} s",
            fontsize=10,
        )
        bare(one)
    return figure
