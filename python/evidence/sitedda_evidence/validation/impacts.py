# SPDX-License-Identifier: GPL-3.0-or-later
"""Restitution of joints: rebounds, Housner's impact times, and corner impacts."""

from dataclasses import dataclass

import numpy as np

from sitedda.report.style import BLUE, COLORS, INK, canvas

from .. import model as nml
from ..case import Outcome, Table, at_most, case, yes_or_no
from .rocking import run_tower, tower_text, zero_times

DENSITY = 2500.0  # kg/m³
STORED = ("kinetic", "strain", "contact", "support")


@case(
    "Restitution of a joint, at random phases of the step",
    "A block of 1 m × 1 m strikes a fixed block face to face at 1 m/s, without gravity. Its speed "
    "after the impact (m/s) equals the coefficient of restitution. The speed does not depend on "
    "the instant of impact within a step, on the stiffness of the block, or on Ω = ωΔt. With "
    "contact at two corners, ω² = 2 k_n/m.",
    "`docs/impacts.md`.",
)
def restitution(short: bool) -> Outcome:
    """Check that rebounds are within 0.02 of the restitution, and that energy never increases."""
    random = np.random.default_rng(16)
    count, omegas = (2, (0.05, 2.0, 300.0)) if short else (40, (0.05, 0.3, 2.0, 20.0, 300.0))
    rows, (figure, (axes,)) = [], canvas(1, size=(7, 4))
    for i, expected in enumerate((0.0, 0.2, 0.5, 0.8)):
        impacts = np.array([
            (omega, *_run_impact(omega, expected, random.random(), stiff))
            for omega in omegas
            for stiff in random.integers(0, 2, count)
        ])  # fmt: skip
        error = abs(impacts[:, 1] - expected).max()
        growth, audit = impacts[:, 2:].max(axis=0)
        rows += [
            at_most(f"e = {expected:g}: largest error of the restitution, {len(impacts)} impacts",
                error, 0.02),
            at_most(f"e = {expected:g}: largest relative gain of energy", growth, 1e-9),
            at_most(f"e = {expected:g}: energy residual / initial energy", audit, 1e-6),
        ]  # fmt: skip
        label = f"e = {expected:g}"
        axes.semilogx(impacts[:, 0], impacts[:, 1], "o", color=COLORS[i], label=label)
    axes.set(xlabel="Ω of the contact", ylabel="velocity after / before impact", ylim=(-0.1, 1))
    axes.legend(frameon=False, ncols=2)
    return Outcome(rows, figure)


def _run_impact(omega, restitution, phase, stiff) -> tuple[float, float, float]:
    """Return restitution, relative energy gain and audit of an impact at a phase of the step.

    `stiff`: the penalty is 40 E; otherwise it is far less than E.
    """
    time_step = 1e-3
    penalty = 0.5 * DENSITY * (omega / time_step) ** 2
    modulus = penalty / 40 if stiff else max(1e12, 1e3 * penalty)
    text = nml.text(
        nml.control(time_step, 12, gravity=(0.0, 0.0), max_displacement_ratio=0.05),
        nml.contact(penalty),
        nml.material("ground", DENSITY, modulus, 0.2),
        nml.material("stone", DENSITY, modulus, 0.2, velocity=(0.0, -1.0, 0.0)),
        nml.joint("joint", 30.0, restitution=restitution),
        nml.fixed_block("base", nml.rectangle(-3, -0.5, 6, 0.5), "ground"),
        nml.block("body", nml.rectangle(-0.5, (2 + phase) * time_step, 1.0, 1.0), "stone"),
    )
    with nml.simulation(text) as run:
        initial = sum(run.energies[name] for name in STORED)
        largest = initial
        while not run.done:
            run.advance(1)
            largest = max(largest, sum(run.energies[name] for name in STORED))
        return run.rates[1, 1], largest / initial - 1, abs(run.energies["balance"]) / initial


@case(
    "Rocking block: impact times and shortest overturning pulse with e = 0",
    "Housner: p² = 3g/4R; an impact multiplies the angular velocity by 1 − 1.5 sin² α. A block of "
    "0.25 m x 1.0 m that is released at α/2 hits at 0.34917, 0.91745, 1.39964 and 1.81777 s; a "
    "block of twice the size √2 times later. The shortest rectangular pulses of the base that "
    "overturn it are 0.290795 and 0.107748 s for a/(g tan α) = 1.5 and 3. The penalty varies by "
    "three decades, Δt by one.",
    "Housner (1963), Bull. Seism. Soc. Am. 53(2).",
)
def rocking_times(short: bool) -> Outcome:
    """Check the first four impact times and the overturning pulse, all within 2 %."""
    theory = np.array([0.34917, 0.91745, 1.39964, 1.81777])
    penalties = (1e8, 1e11) if short else (1e8, 1e9, 1e10, 1e11)
    steps = (1e-3,) if short else (1e-3, 3e-4, 1e-4)
    rows, table = [], []
    figure, (axes,) = canvas(1, size=(8, 4))
    for penalty in penalties:
        for time_step in steps:
            time, angle, audit = _run_rocking(penalty, time_step)
            times = np.array(zero_times(time, angle)[:4])
            error = abs(times / theory - 1).max() if len(times) == 4 else np.inf
            name = f"k_n {penalty:g} N/m, Δt {1e3 * time_step:g} ms"
            rows.append(at_most(f"{name}: largest relative error of four impact times", error,
                0.02))  # fmt: skip
            rows.append(at_most(f"{name}: energy residual / work", audit, 1e-6))
            table.append((penalty, time_step, *times))
        axes.plot(time, angle, lw=1, color=BLUE)
    for t in theory:
        axes.axvline(t, color=INK, lw=0.8, ls="--")
    axes.set(xlabel="time (s)", ylabel="angle (rad)", title="dashed: Housner's impacts")
    if not short:
        times = np.array(zero_times(*_run_rocking(1e10, 5e-4, scale=2.0)[:2])[:4])
        error = abs(times / (np.sqrt(2) * theory) - 1).max()
        rows.append(at_most("twice the size: largest relative error of four impact times", error,
            0.02))  # fmt: skip
    for ratio, pulse in ((3.0, 0.107748),) if short else ((1.5, 0.290795), (3.0, 0.107748)):
        for fraction, falls in ((0.98, False), (1.02, True)):
            options = {"duration": 2.5, "angle": 0.0, "pulse": (ratio, fraction * pulse)}
            _, angle, _ = _run_rocking(1e10, 5e-4, **options)
            fell = bool(abs(angle).max() > 1.0)
            rows.append(yes_or_no(f"overturns under {fraction:g} of the shortest pulse, a/(g tan"
                f" α) = {ratio:g}", falls, fell))  # fmt: skip
    head = ("k_n (N/m)", "Δt (s)", "first (s)", "second", "third", "fourth")
    return Outcome(rows, figure, [Table("Impact times.", head, table)])


def _run_rocking(penalty, time_step, duration=1.9, angle=None, pulse=None, scale=1.0):
    """Return time (s), angle (rad) and audit of a block released at an angle or under a pulse."""
    width, height = 0.25 * scale, 1.0 * scale
    slender = np.arctan2(width, height)
    angle = 0.5 * slender if angle is None else angle
    duration *= np.sqrt(scale)
    base = pulse and (lambda t: pulse[0] * nml.GRAVITY * np.tan(slender) * (t < pulse[1]))
    text = tower_text(time_step, duration, angle, base, penalty, 0.25 * time_step, (width, height),
                      1e12, 0.0, max_displacement_ratio=0.02)  # fmt: skip
    time, angles, energies = run_tower(text, angle, limit=1.2)
    work = sum(abs(energies[name]) for name in ("kinetic", "gravity", "input", "impact"))
    return time, angles, abs(energies["balance"]) / work


@case(
    "A corner that hits the ground, with friction",
    "A rigid block hits rigid ground with a corner: v⁺ = v⁻ + M⁻¹(n p + t q), where nᵀv and tᵀv"
    " are the normal and tangential velocities of the corner. The impact law is nᵀv⁺ = −e nᵀv⁻,"
    " and either tᵀv⁺ = 0 with |q| ≤ μ p (stick), or q = −μ p s with s = sign tᵀv⁺ (slip). If the"
    " energy would increase (Kane's paradox), e is halved. In half of the cases μ is within 2 % of"
    " the limit between stick and slip. The phase of the step, the stiffness and the scheme are"
    " random. With e = 0 an impact takes two steps, whose total effect must equal that of one"
    " step.",
    "Newton's restitution with Coulomb's law on impulses (Moreau 1988; Jean 1999); "
    "`docs/impacts.md`.",
)
def corner_impacts(short: bool) -> Outcome:
    """Check the velocity after each impact, within 1e-3 of the speed before impact."""
    random, count = np.random.default_rng(97), 40 if short else 200
    impacts = []
    while len(impacts) < count:
        corner = _Corner.random_corner(random, near_limit=len(impacts) % 2 == 1)
        if corner is not None:
            impacts.append((corner, *corner.impact_error(random)))
    figure, (axes,) = canvas(1, size=(7, 4))
    rows, table = [], []
    for i, kind in enumerate(("stick", "slip")):
        errors = np.array([error for corner, error, _ in impacts if corner.kind == kind])
        tilt = [np.degrees(corner.tilt) for corner, *_ in impacts if corner.kind == kind]
        axes.semilogy(tilt, errors, "o", color=COLORS[i], label=f"{kind}, {len(errors)}")
        table.append((kind, len(errors), f"{np.median(errors):.1e}", f"{errors.max():.1e}"))
        name = f"{kind}: largest velocity error / speed before impact"
        rows.append(at_most(name, float(errors.max()), 1e-3))
        rows.append(yes_or_no(f"{kind}: number of impacts is at least a quarter of all", True,
            4 * len(tilt) >= count))  # fmt: skip
    audit = max(audit for *_, audit in impacts)
    rows.append(at_most("energy residual / initial energy", audit, 1e-6))
    axes.set(xlabel="tilt of the block (degrees)", ylabel="velocity error / speed before impact")
    head = ("outcome", "impacts", "median error", "largest error")
    return Outcome(rows, figure, [Table("Corner impacts.", head, table)])


@dataclass
class _Corner:
    """An impact of the lowest corner of a tilted rigid block.

    `before`, `after`: velocity of the centre of mass (m/s) and angular velocity (rad/s).
    """

    size: np.ndarray
    tilt: float
    friction: float
    restitution: float
    before: np.ndarray
    after: np.ndarray
    kind: str

    @classmethod
    def random_corner(cls, random, near_limit: bool) -> "_Corner | None":
        """Return a random impact; None if the corner is slow or several solutions exist."""
        size, tilt = random.uniform(0.3, 2.0, 2), np.radians(random.uniform(3.0, 87.0))
        before = np.array([random.uniform(-1, 1), -random.uniform(0.3, 1.5), random.uniform(-1, 1)])
        restitution = float(random.choice([0.0, 0.0, 0.3, 0.8]))
        body = cls(size, tilt, random.uniform(0.05, 1.0), restitution, before, before, "")
        rows, softness = body.contact()
        normal, direction = rows @ before
        if near_limit:
            p, q = np.linalg.solve(softness, [-(1 + restitution) * normal, -direction])
            body.friction = abs(q / p) * random.uniform(0.98, 1.02)
        if normal > -0.1 or not 0.02 < body.friction < 2.0:
            return None
        for fraction in (1.0, 0.5, 0.25, 0.125, 0.0):
            answers = body.impulses(fraction * restitution)
            if len(answers) != 1:
                return None
            (body.kind, impulse), speed = answers[0], rows @ before
            if impulse @ (2 * speed + softness @ impulse) <= 0.0:  # twice the transferred energy
                break
        body.after = before + body.softness @ rows.T @ impulse
        return body

    @property
    def softness(self) -> np.ndarray:
        """Return the inverse M⁻¹ of the mass matrix, shape (3, 3)."""
        mass = DENSITY * np.prod(self.size)
        return np.diag([1 / mass, 1 / mass, 12 / (mass * np.sum(self.size**2))])

    def outline(self) -> np.ndarray:
        """Return the vertices relative to the centre of mass, m."""
        return nml.rotated(nml.rectangle(*(-0.5 * self.size), *self.size), self.tilt)

    def contact(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the rows n, t of the velocity of the lowest corner, and its 2 × 2 compliance."""
        outline = self.outline()
        x, y = outline[np.argmin(outline[:, 1])]
        rows = np.array([[0.0, 1.0, x], [1.0, 0.0, -y]])
        return rows, rows @ self.softness @ rows.T

    def impulses(self, restitution: float) -> list[tuple[str, np.ndarray]]:
        """Return all solutions of the impact law: stick or slip, and impulses p, q."""
        rows, softness = self.contact()
        speed = rows @ self.before
        change = -(1 + restitution) * speed[0]
        stick = np.linalg.solve(softness, [change, -speed[1]])
        solutions = [("stick", stick)] if abs(stick[1]) <= self.friction * stick[0] else []
        for sign in (-1.0, 1.0):
            ray = np.array([1.0, -sign * self.friction])
            slip = change / (softness[0] @ ray) * ray
            if slip[0] > 0.0 and sign * (speed + softness @ slip)[1] > 0.0:
                solutions.append(("slip", slip))
        return solutions

    def impact_error(self, random) -> tuple[float, float]:
        """Return the velocity error of the engine over the speed before impact, and the audit."""
        time_step, omega = 2e-5, 10 ** random.uniform(-1, 1.5)
        penalty = DENSITY * np.prod(self.size) * (omega / time_step) ** 2
        modulus = min(1e17, 1e2 * penalty)
        outline = self.outline()
        outline[:, 1] -= outline[:, 1].min()
        outline[:, 1] -= (2 + random.random()) * time_step * (self.contact()[0] @ self.before)[0]
        scheme = str(random.choice(["dda", "midpoint", "theta"]))
        text = nml.text(
            nml.control(time_step, 8, (0.0, 0.0), integration=scheme, max_displacement_ratio=0.05),
            nml.contact(penalty),
            nml.material("ground", DENSITY, modulus, 0.2),
            nml.material("stone", DENSITY, modulus, 0.2, velocity=self.before),
            nml.joint("joint", np.degrees(np.arctan(self.friction)), restitution=self.restitution),
            nml.fixed_block("base", nml.rectangle(-6.0, -1.0, 12.0, 1.0), "ground"),
            nml.block("body", outline, "stone"),
        )
        with nml.simulation(text) as run:
            initial = run.energies["kinetic"]
            run.advance(8)
            error = run.rates[1, :3] - self.after
            audit = abs(run.energies["balance"]) / initial
        error[2] *= 0.5 * np.hypot(*self.size)
        return float(np.linalg.norm(error) / np.linalg.norm(self.before[:2])), float(audit)
