#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Static stages of loaded arches, bridges and walls, against limit analysis.

usage: python tests/robustness/limit_loads.py [--models N] [--first I] [--seed S]
       [--below 0.98] [--above 1.02]

Models have loads, bolts and water beside their weight, and joints with cohesion, bonds or a
compressive strength.  A horizontal body force or a load on one block increases.  The static stage
must rest at `below` times the lower limit L, and fall at `above` times the upper limit U.  Because
bonds of the engine break, L of joints with tensile strength is that of dry joints.  Independent
arithmetic verifies both programmes: forces within strength balance all blocks, and the power of
the mechanism yields U, or L with the friction of these forces.
"""

import sys
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))

from limit_models import GRAVITY, LEAST, MOST, SEED, Assembly, arch, bridge, wall  # noqa: E402
from limit_states import ABOVE, BELOW, FALLEN, _mass  # noqa: E402
from options import count_wrong, parse_options  # noqa: E402

import sitedda  # noqa: E402
from sitedda.errors import ConvergenceError, InputError, SolverError  # noqa: E402
from sitedda.stability import Limit, Limits  # noqa: E402

WATER = 9810.0  # N/m³
MOST_LIVE = 10.0  # times the weight, largest variable load
YIELDS = 1e-5  # m, elongation of a bolt at its yield force
EXACT = 1e-6  # tolerance of forces, relative to the largest
CRUSHED = 1e-3  # tolerance of moments of crushing joints over their length
BOUND = 1e-3  # relative tolerance of U: its programme also minimises forces
CLOSED = 1e-5  # relative to the largest velocity: insufficient dilation of slip


@dataclass(frozen=True)
class Loaded:
    """An assembly under loads."""

    bare: Assembly
    joint: dict = field(default_factory=dict)  # variables of its joint other than friction
    dead: list = field(default_factory=list)  # permanent loads: block, position (m), force (N/m)
    live: tuple | None = None  # the variable load; None: a variable horizontal body force
    bolts: list = field(default_factory=list)  # two blocks, and yield force (N/m) of each bolt
    level: np.ndarray | None = None  # ends of a phreatic line, shape (2, 2), m

    def model(self, factor: float = 1.0) -> sitedda.Model:
        """Return the model at a factor of the variable load."""
        model = self.bare.model(0.0 if self.live else factor)
        model["joint.dry"](**self.joint)
        model.contact(normal_stiffness=1e11)
        model["material.stone"](young_modulus=1e13)
        live = [(self.live[0], self.live[1], factor * self.live[2])] if self.live else []
        for name, loads in (("dead", self.dead), ("live", live)):
            for block, (x, y), force in loads:
                model.load(x, y, f"block_{block}", name=name, time=(0, 1),
                           force_x=[force[0]] * 2, force_y=[force[1]] * 2)  # fmt: skip
        for i, (a, b, yield_force) in enumerate(self.bolts):
            ends = [_mass(self.bare.polygons[k])[1] for k in (a, b)]
            model.bolt(f"bolt_{i}", *ends, f"block_{a}", f"block_{b}", yield_force=yield_force,
                       axial_stiffness=yield_force / YIELDS)  # fmt: skip
        if self.level is not None:
            model.water(surface=self.level.ravel())
        return model

    def limits(self) -> Limits:
        """Return the limits of the linear programmes."""
        if self.live:
            return sitedda.limit_analysis(self.model(), load="live")
        return sitedda.limit_analysis(self.model(0.0), direction=(self.bare.sense, 0.0))

    def wrenches(self) -> tuple[np.ndarray, np.ndarray]:
        """Return permanent and variable loads about centroids, shape (blocks, 3), N/m and N."""
        dead, live = np.zeros((2, len(self.bare.polygons), 3))
        for i, polygon in enumerate(self.bare.polygons):
            mass, centre = _mass(polygon)
            dead[i, 1] -= mass * GRAVITY
            if self.live is None:
                live[i, 0] = mass * GRAVITY * self.bare.sense
            if self.level is not None:
                dead[i] += _pressed(polygon, centre, self.level)
        for rows, loads in ((dead, self.dead), (live, [self.live] if self.live else [])):
            for i, position, force in loads:
                rows[i] += _wrench(position - _mass(self.bare.polygons[i])[1], force)
        return dead, live

    @property
    def words(self) -> str:
        """A description of the blocks, joints and loads."""
        return ", ".join([
            f"{len(self.bare.polygons)} blocks, tan φ {self.bare.friction:.3f}",
            *(f"{name} {value:.3g}" for name, value in self.joint.items() if name != "law"),
            f"{len(self.dead)} loads, {len(self.bolts)} bolts",
            *(["water"] if self.level is not None else []),
            "a load grows" if self.live else "a body force grows",
        ])  # fmt: skip


def _wrench(arm: np.ndarray, force: np.ndarray) -> np.ndarray:
    return np.array([*force, arm[0] * force[1] - arm[1] * force[0]])


def _pressed(polygon: np.ndarray, centre: np.ndarray, level: np.ndarray) -> np.ndarray:
    """Force and moment of water below a phreatic line on the edges of a block."""
    total = np.zeros(3)
    for a, b in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        p, q = (WATER * (np.interp(x, *level.T) - y) for x, y in (a, b))
        if max(p, q) <= 0.0:
            continue
        if min(p, q) < 0.0:  # integrate over the part below the line
            dry = a + (b - a) * p / (p - q)
            a, b, p, q = (dry, b, 0.0, q) if p < 0.0 else (a, dry, p, 0.0)
        inward = np.array([a[1] - b[1], b[0] - a[0]])
        centroid = a + (b - a) * (p + 2 * q) / (3 * (p + q))
        total += _wrench(centroid - centre, 0.5 * (p + q) * inward)
    return total


def random_model(rng: np.random.Generator, number: int) -> Loaded:
    """Return an arch, bridge or wall with dry, cohesive, bonded or crushing joints, in turn."""
    make = (arch, bridge, wall)[number % 3]
    bare = make(rng, f"{make.__name__} {number + 1}")
    free = [i for i in range(len(bare.polygons)) if i not in bare.held]
    weight = GRAVITY * sum(_mass(bare.polygons[i])[0] for i in free)
    size = float(np.sqrt(np.median([abs(_mass(p)[0]) for p in bare.polygons]) / 2500.0))
    cohesion = rng.uniform(0.005, 0.05) * weight / size
    joint = (
        {},
        {"law": "mohr_coulomb", "cohesion": cohesion, "residual_cohesion": cohesion},
        {"cohesion": cohesion, "tensile_strength": rng.uniform(0.05, 0.3) * cohesion},
        {"law": "crushing", "crushing_strength": rng.uniform(3, 20) * weight / size},
    )[number % 4]

    def load(fraction: float, direction=(0.0, -1.0)) -> tuple:
        block = free[int(len(free) * rng.uniform(0.15, 0.35))]
        return block, _mass(bare.polygons[block])[1], fraction * weight * np.array(direction)

    dead = [load(rng.uniform(0.01, 0.1)) for _ in range(int(rng.integers(0, 3)))]
    live = None
    if make is bridge or rng.random() < 0.4:
        live = load(1.0, (0.0, -1.0) if make is not wall else (bare.sense, 0.0))
    bolts = [(*map(int, rng.choice(free, 2, replace=False)), rng.uniform(0.01, 0.1) * weight)
             for _ in range(int(rng.integers(0, 3)))]  # fmt: skip
    vertices = np.vstack(bare.polygons)
    (left, low), (right, top) = vertices.min(0) * (1 - 1e-9), vertices.max(0) * (1 - 1e-9)
    level = None
    if rng.random() < 0.5:
        level = low + (top - low) * rng.uniform(0.1, 0.6, 2)
        level = np.array([[left, level[0]], [right, level[1]]])
    return Loaded(bare, joint, dead, live, bolts, level)


def judged(models: int, first: int = 0, seed: int = SEED):
    """Yield models and their limits; L of bonded joints is that of dry joints."""
    for number in range(first, models):
        rng = np.random.default_rng([seed, number])
        while True:
            loaded = random_model(rng, number)
            try:
                limits = loaded.limits()
                if "tensile_strength" in loaded.joint:
                    limits = replace(limits, lower=replace(loaded, joint={}).limits().lower)
            except (InputError, ConvergenceError):
                continue
            limit = MOST_LIVE if loaded.live else MOST
            if LEAST <= limits.lower.factor and limits.upper.factor < limit:
                yield loaded, limits
                break


def _strength(loaded: Loaded, name: str) -> float:
    return loaded.joint.get(name, np.inf if name == "crushing_strength" else 0.0)


def _joints(limit: Limit):
    """Yield the indices of both ends of each joint, and its length; single corners: one, and 0."""
    i = 0
    while i < len(limit.points):
        pair = i + 1 < len(limit.points) and (limit.blocks[i] == limit.blocks[i + 1]).all()
        pair = pair and np.allclose(limit.normals[i], limit.normals[i + 1])
        ends = [i, i + 1] if pair else [i]
        yield ends, float(np.linalg.norm(limit.points[ends[-1]] - limit.points[i]))
        i += len(ends)


def unbalanced(loaded: Loaded, limit: Limit) -> float:
    """Return the largest unbalanced or excessive force over the largest force of a joint."""
    dead, live = loaded.wrenches()
    forces = dead + limit.factor * live
    centres = [_mass(polygon)[1] for polygon in loaded.bare.polygons]
    tangents = np.column_stack([-limit.normals[:, 1], limit.normals[:, 0]])
    force = limit.normal_force[:, None] * limit.normals + limit.shear_force[:, None] * tangents
    for (a, b), position, force_pair in zip(limit.blocks, limit.points, force, strict=True):
        forces[a] -= _wrench(position - centres[a], force_pair)
        forces[b] += _wrench(position - centres[b], force_pair)
    excess = [0.0]
    for i, (a, b, yield_force) in enumerate(loaded.bolts):
        bolt_force = limit.bolt_force[f"bolt_{i}"]
        direction = (centres[b] - centres[a]) / np.linalg.norm(centres[b] - centres[a])
        forces[a, :2] += bolt_force * direction
        forces[b, :2] -= bolt_force * direction
        excess += [bolt_force - yield_force, -bolt_force]
    cohesion, tension = (_strength(loaded, n) for n in ("cohesion", "tensile_strength"))
    crushing = _strength(loaded, "crushing_strength")
    for ends, length in _joints(limit):
        normal, shear = limit.normal_force[ends], abs(limit.shear_force[ends])
        excess += [*(-normal - tension * length / 2),
                   *(shear - cohesion * length / 2 - loaded.bare.friction * normal)]  # fmt: skip
        if np.isfinite(crushing) and length:
            compression = normal.sum()
            eccentricity = abs(normal[0] - normal[1]) - compression * (
                1 - compression / crushing / length
            )
            excess.append(eccentricity * EXACT / CRUSHED)
    free = [i for i in range(len(centres)) if i not in loaded.bare.held]
    return max(abs(forces[free]).max(), max(excess)) / abs(limit.normal_force).max()


def bound(loaded: Loaded, limit: Limit, dilates: bool = True) -> tuple[float, float]:
    """Return the upper bound of the mechanism, and its lack of dilation over its velocity.

    Joints and bolts dissipate at most their largest power over all forces within strength; without
    dilation, over those with the given normal forces.  The variable load has the rest of this power
    after the permanent loads.
    """
    displacements, centres = limit.displacement, [_mass(p)[1] for p in loaded.bare.polygons]
    dead, live = loaded.wrenches()

    def displacement_at(i: int, position: np.ndarray) -> np.ndarray:
        arm = position - centres[i]
        return displacements[i, :2] + displacements[i, 2] * np.array([-arm[1], arm[0]])

    dissipation, lack = 0.0, 0.0
    cohesion, tension = (_strength(loaded, n) for n in ("cohesion", "tensile_strength"))
    crushing, friction = _strength(loaded, "crushing_strength"), loaded.bare.friction
    for ends, length in _joints(limit):
        (a, b), normal = limit.blocks[ends[0]], limit.normals[ends[0]]
        openings = [displacement_at(b, limit.points[k]) - displacement_at(a, limit.points[k])
                    for k in ends]  # fmt: skip
        opening = np.array([vector @ normal for vector in openings])
        slip = abs(openings[0] @ [-normal[1], normal[0]])
        if np.isfinite(crushing) and length:
            # N (μ s − o) + |M| |θ| with |M| = N (L − N/σ_c)/2, largest at N = N*.
            rotation = abs(opening[0] - opening[1]) / length
            power_factor = friction * slip - opening.min()
            yield_force = crushing * min(max(power_factor, 0.0) / max(rotation, 1e-300), length)
            yield_force = yield_force if dilates else limit.normal_force[ends].sum()
            dissipation += yield_force * power_factor - rotation * yield_force**2 / (2 * crushing)
            continue
        if not dilates:
            lack = max(lack, float(-opening.min()))
            dissipation += len(ends) * cohesion * length / 2 * slip
            dissipation += limit.normal_force[ends] @ (friction * slip - opening)
            continue
        lack = max(lack, float((friction * slip - opening).max()))
        tensile_force = min(tension, cohesion / friction) * length / 2
        dissipation += sum(
            (cohesion * length / 2 - friction * tensile_force) * slip + tensile_force * opening
        )
    for a, b, yield_force in loaded.bolts:
        direction = (centres[b] - centres[a]) / np.linalg.norm(centres[b] - centres[a])
        elongation = direction @ (displacements[b, :2] - displacements[a, :2])
        dissipation += yield_force * max(0.0, elongation)
    return (dissipation - np.sum(dead * displacements)) / np.sum(live * displacements), lack


def rests(loaded: Loaded, factor: float) -> bool:
    """Return whether the static stage rests without large displacements."""
    model = loaded.model(factor)
    model.stage(name="rest", kind="static", displacement=FALLEN)
    try:
        sitedda.Simulation(model).close()
    except (ConvergenceError, SolverError):
        return False
    return True


def wrong(loaded: Loaded, limits: Limits, below: float = BELOW, above: float = ABOVE) -> list[str]:
    """Return contradictions to the limits, in words."""
    faults = []
    for name, limit in (("L", limits.lower), ("U", limits.upper)):
        model = loaded if name == "U" or "tensile_strength" not in loaded.joint else (
            replace(loaded, joint={}))  # fmt: skip
        if (excess := unbalanced(model, limit)) > EXACT:
            faults.append(f"forces of {name} are unbalanced by {excess:.2g}")
        factor, lack = bound(model, limit, name == "U")
        if abs(factor / limit.factor - 1) > BOUND or lack > CLOSED:
            faults.append(f"the mechanism has {name} {factor:.6g} and lacks dilation {lack:.2g}")
    if not rests(loaded, below * limits.lower.factor):
        faults.append(f"falls at {below:g} L")
    if rests(loaded, above * limits.upper.factor):
        faults.append(f"rests at {above:g} U")
    return faults


def main() -> int:
    """Return status 1 if an outcome is wrong."""
    options = parse_options(__doc__, models=40, first=0, seed=SEED, below=BELOW, above=ABOVE)

    def cases():
        for loaded, result in judged(options.models, options.first, options.seed):
            faults = wrong(loaded, result, options.below, options.above)
            limits = f"L {result.lower.factor:.5f}, U {result.upper.factor:.5f}"
            yield "; ".join([f"{loaded.bare.name}: {loaded.words}: {limits}", *faults]), not faults

    return count_wrong(cases())


if __name__ == "__main__":
    sys.exit(main())
