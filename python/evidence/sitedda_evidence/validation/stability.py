# SPDX-License-Identifier: GPL-3.0-or-later
"""Limits of stability of toppling blocks and arches, compared with limit analysis."""

import numpy as np
import shapely
from scipy.optimize import linprog

from sitedda.report.style import BLUE, GROUND, RED, STONE, bare, canvas, draw_blocks
from sitedda.stability import bisect

from .. import model as nml
from ..case import Outcome, Table, at_most, case, relative, true

DENSITY = 2500.0  # kg/m³


def stands(polygons, joints, friction: float) -> bool:
    """Return whether blocks under their weight can be in equilibrium without tension (linprog).

    Parameters
    ----------
    polygons : list of ndarray
        Blocks, shape (n, 2), m.
    joints : list of (int, int, ndarray, ndarray)
        First block, second block (−1: fixed), end points of the joint (2, 2), and unit normal
        towards the first block.
    friction : float
        Coefficient of friction.

    Notes
    -----
    As in the engine, each joint transmits two forces at its ends, with N ≥ 0, T = T⁺ − T⁻ and
    T⁺ + T⁻ ≤ μ N (Livesley 1978).
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
    """Return the value above which a model stands, by bisection between two values."""
    return 0.5 * sum(bisect(stands, high, low, 1e-6))


RADIUS = 5.0  # radius of the centre line, m
ARCH_FRICTION = 60.0  # friction angle without sliding, degrees


def voussoirs(count: int, thickness: float) -> list[np.ndarray]:
    """Return the equal straight-sided voussoirs of a semicircular arch, from the right end."""
    angle = np.linspace(0.0, np.pi, count + 1)
    ray = np.column_stack([np.cos(angle), np.sin(angle)])
    inner, outer = (RADIUS - 0.5 * thickness) * ray, (RADIUS + 0.5 * thickness) * ray
    return [np.array([inner[i], outer[i], outer[i + 1], inner[i + 1]]) for i in range(count)]


def _is_arch_possible(count: int, thickness: float) -> bool:
    """Return whether limit analysis finds an equilibrium of an arch."""
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
    """Check arches of 15 and 27 voussoirs, 3 % above and below the limit."""
    rows, lines, drawn = [], [], []
    for count in (15,) if short else (15, 27):
        limit = _bisect_limit(lambda t, n=count: _is_arch_possible(n, t * RADIUS), 0.05, 0.2)
        lines.append((count, limit, 0.1075, limit / 0.1075 - 1))
        for side, falls in ((1.03, False), (0.97, True)):
            found = _run_arch(count, side * limit * RADIUS)
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
    return Outcome(rows, _draw_arches(drawn), [table])


def _run_arch(count: int, thickness: float, time_step: float = 2e-3, duration: float = 8.0):
    """Run an arch under gravity; return whether its crown sank by the thickness, and histories."""
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


def _draw_arches(drawn):
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


COLUMN, STEP, FALL, DIP, CREST = 10.0, 1.0, 5.0, 30.0, 9  # lengths in m, dip in degrees, index
GAP = 1e-6  # gap on each side of a column, m
HEIGHTS = np.array([4.0 * n for n in range(1, 11)] + [40.0 - 6.0 * n for n in range(1, 7)])


def goodman_bray(friction: float) -> float:
    """Return the toe force (N/m) required in Goodman & Bray's example; ≤ 0 if stable.

    From the top down, a block under the force P' of the block above requires the larger support
    of toppling, P = [P' (M − Δx μ) + ½ W (y sin ψ − Δx cos ψ)]/L, and sliding, P = P' − W (μ cos ψ
    − sin ψ)/(1 − μ²).  M and L are the heights at which P' and P act.
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
    """Return the polygons of the 16 columns and of the stepped base, rotated by the dip, m."""
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


def _is_slope_possible(friction: float) -> bool:
    """Return whether limit analysis finds an equilibrium of the columns."""
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
    """Check both sides of the limit, 5 % of tan φ apart, and the limit of the engine."""
    limit = _bisect_limit(lambda phi: goodman_bray(phi) <= 1e-9, 30.0, 44.0)
    lower = _bisect_limit(_is_slope_possible, 20.0, 44.0)
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
    return Outcome(rows, _draw_slopes(drawn), tables)


def _run_slope(friction: float, time_step: float = 2e-3, duration: float = 10.0) -> dict:
    """Run the slope under gravity; return whether a column moved by more than 1 m, and states."""
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


def _draw_slopes(drawn):
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
