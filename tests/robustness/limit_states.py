#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Static stages of random arches and walls with openings, against limit analysis.

usage: python tests/robustness/limit_states.py [--models N] [--monotone N] [--slow N] [--seed S]

Each model has its weight and a horizontal body force.  Its static stage must fall at 1.02 of the
upper limit, and rest at 0.98 of the lower one.  Between limits more than 1 % apart, the outcome is
printed without a verdict.  For the first models of a study, the outcome must be monotone from 0.90
to 1.10 of the limits, and a slowly increasing dynamic force must have the same outcome.  The output
proves rest: contact forces within friction balance each block, at points where blocks touch.
"""

import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import shapely

sys.path.insert(0, str(Path(__file__).parent))

from limit_models import DENSITY, GRAVITY, SEED, STIFFNESS, Assembly, assemblies  # noqa: E402
from options import parse_options  # noqa: E402

import sitedda  # noqa: E402
from sitedda.errors import ConvergenceError, SolverError  # noqa: E402
from sitedda.scene import Scene  # noqa: E402

BELOW, ABOVE = 0.98, 1.02
APART = 0.01  # relative to the upper limit: limits with a gap between them
UNBALANCED = 2e-6  # relative to the weight of a block; the engine allows half of it
ROUNDING = 1e-12  # m, rounding error of coordinates of a few metres
FALLEN = 0.05  # m, displacement of a fallen block
RAMP, HOLD = 2.0, 2.0  # s, duration of the increase and of the constant force


@dataclass(frozen=True)
class Outcome:
    """Whether a static stage comes to rest, remarks, and its duration in s."""

    at_rest: bool
    remarks: str
    seconds: float


def static_outcome(assembly: Assembly, factor: float) -> Outcome:
    """Run a static stage, and prove rest from the output."""
    model = assembly.model(factor)
    model.stage(name="rest", kind="static", displacement=FALLEN)
    begin = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder) / "rest.nc"
        try:
            model.run(output)
        except (ConvergenceError, SolverError) as trouble:
            return Outcome(False, str(trouble), time.perf_counter() - begin)
        seconds = time.perf_counter() - begin
        with sitedda.open_output(output) as data:
            wrong = doubts(assembly, factor, Scene.of(data))
    return Outcome(True, "; ".join(wrong), seconds)


def doubts(assembly: Assembly, factor: float, scene: Scene) -> list[str]:
    """Return contradictions to rest in the last frame; none if the proof holds."""
    frame = scene.frames - 1
    contacts, polygons = scene.contacts(frame), scene.polygons(frame)
    positions, normals = scene.contact_points(frame, contacts)
    normal, shear = contacts["normal_force"], contacts["shear_force"]
    faults = []
    excess_shear = float((abs(shear) - assembly.friction * normal).max())
    if normal.min() < 0 or excess_shear > 1e-6 * normal.max():
        faults.append(f"a shear force is beyond friction by {excess_shear:.3g} N/m")
    faults += _unbalanced(assembly, factor, scene, contacts)
    for v, e, n in zip(positions, contacts["edge"], normal, strict=True):
        distance = shapely.LinearRing(polygons[scene.owner[e]]).distance(shapely.Point(v))
        if n > 0 and not distance <= n / STIFFNESS + ROUNDING:
            faults.append(f"a contact of {n:.3g} N/m is {distance:.3g} m from the edge")
    return faults


def _unbalanced(assembly: Assembly, factor: float, scene: Scene, contacts: dict) -> list[str]:
    """Return blocks that contact forces and weight do not balance in the last frame."""
    positions, normals = scene.contact_points(scene.frames - 1, contacts)
    # Forces on the block of the vertex; shear resists its slip along the edge.  Shear acts on both
    # blocks at the vertex; the normal force acts on the other block at the foot of the vertex.
    normal_forces = contacts["normal_force"][:, None] * normals
    friction_forces = contacts["shear_force"][:, None] * np.column_stack(
        [normals[:, 1], -normals[:, 0]]
    )
    contact_points = positions - contacts["gap"][:, None] * normals
    edge = scene.owner[contacts["edge"]]
    vertex = scene.owner[contacts["vertex"]]
    residuals = []
    for i, polygon in enumerate(scene.polygons(scene.frames - 1)):
        if i in assembly.held:
            continue
        mass, centre = _mass(assembly.polygons[i])[0], _mass(polygon)[1]
        weight = mass * GRAVITY
        external_force = np.array([assembly.sense * factor * weight, -weight, 0.0])
        for selected, sign, at in (
            (vertex == i, 1.0, positions),
            (edge == i, -1.0, contact_points),
        ):
            for force, positions_of in ((normal_forces, at), (friction_forces, positions)):
                arm, own_forces = (positions_of - centre)[selected], sign * force[selected]
                moment = arm[:, 0] * own_forces[:, 1] - arm[:, 1] * own_forces[:, 0]
                external_force += np.append(own_forces.sum(axis=0), moment.sum())
        external_force[2] /= np.linalg.norm(polygon - centre, axis=1).max()
        if abs(external_force).max() > UNBALANCED * weight:
            residuals.append(
                f"block {i}: unbalanced force of {abs(external_force).max() / weight:.2g} weights"
            )
    return residuals


def _mass(polygon: np.ndarray) -> tuple[float, np.ndarray]:
    """Return the mass of a block (kg/m) and its centroid (m)."""
    outline = shapely.Polygon(polygon)
    return DENSITY * outline.area, shapely.get_coordinates(outline.centroid)[0]


def slow_outcome(assembly: Assembly, factor: float) -> Outcome:
    """Run to rest under the weight, then under a body force that increases and stays constant."""
    model = assembly.model()
    model.stage(name="weight", kind="static")
    model.stage(name="push", duration=RAMP + HOLD, time_step=2e-3)
    # In the frame of an accelerated base, a body force acts in the opposite direction.
    times = np.linspace(0.0, 1.0, 51)
    ramp = times**2 * (3 - 2 * times)
    values = -assembly.sense * factor * GRAVITY * np.append(ramp, np.ones(51))
    model.motion("push", quantity="acceleration", time_step=RAMP / 50, values=values,
        drift_order=0)  # fmt: skip
    model.control(base_motion_x="push")
    begin = time.perf_counter()
    with sitedda.Simulation(model) as run:
        start, displacement = run.coordinates[:, :2], 0.0
        while displacement < FALLEN and not run.advance(20):
            displacement = np.linalg.norm(run.coordinates[:, :2] - start, axis=1).max()
        displacement = np.linalg.norm(run.coordinates[:, :2] - start, axis=1).max()
    description = f"moved {displacement:.2g} m"
    return Outcome(bool(displacement < FALLEN), description, time.perf_counter() - begin)


@dataclass
class Tally:
    """Counts of a study."""

    models: int = 0
    sliding: int = 0
    between: int = 0
    wrong: int = 0

    def judge(self, label: str, outcome: Outcome, expects_rest: bool | None) -> None:
        """Print an outcome, and count it if it differs from `expects_rest` (None: not judged)."""
        verdict = "rests" if outcome.at_rest else "falls"
        is_wrong = expects_rest is not None and outcome.at_rest != expects_rest
        description = outcome.remarks if outcome.at_rest else ""
        if (
            outcome.at_rest
            and description
            and expects_rest is not False
            and not description.startswith("moved")
        ):
            is_wrong = True
        self.wrong += is_wrong
        remark = "WRONG" if is_wrong else "not judged" if expects_rest is None else ""
        print(f"    {label:24} {verdict} {outcome.seconds:6.2f} s  {remark} {description}",
              flush=True)  # fmt: skip


def study(models: int, monotone: int, slow: int, seed: int) -> Tally:
    """Test models; `monotone` and `slow` are numbers of first models with these tests."""
    tally = Tally()
    for assembly, limits in assemblies(models, seed):
        low, high = limits.lower.factor, limits.upper.factor
        tally.models += 1
        tally.sliding += limits.lower.slides
        mode = "slides" if limits.lower.slides else "turns"
        print(
            f"{assembly.name}: {len(assembly.polygons)} blocks, tan φ {assembly.friction:.3f}, "
            f"{assembly.sense:+d}, limits {low:.5f} and {high:.5f}, {mode}",
            flush=True,
        )
        tally.judge("0.98 of the lower", static_outcome(assembly, BELOW * low), True)
        if high - low > APART * high:
            tally.between += 1
            tally.judge("between", static_outcome(assembly, 0.5 * (low + high)), None)
        tally.judge("1.02 of the upper", static_outcome(assembly, ABOVE * high), False)
        if tally.models <= slow:
            tally.judge("slowly, 0.98", slow_outcome(assembly, BELOW * low), True)
            tally.judge("slowly, 1.02", slow_outcome(assembly, ABOVE * high), False)
        if tally.models <= monotone:
            expects_rest = True
            for fraction in np.arange(0.90, 1.101, 0.02):
                outcome = static_outcome(assembly, fraction * (low if fraction < 1.0 else high))
                expected = False if not expects_rest else True if fraction < 0.99 else None
                tally.judge(f"{fraction:.2f}", outcome, expected)
                expects_rest = outcome.at_rest
    return tally


def main() -> int:
    """Return status 1 if an outcome is wrong."""
    tally = study(**vars(parse_options(__doc__, models=60, monotone=3, slow=10, seed=SEED)))
    print(
        f"{tally.models} models, {tally.sliding} slide, {tally.models - tally.sliding} turn, "
        f"{tally.between} with a gap between limits; {tally.wrong} outcomes are wrong"
    )
    return int(tally.wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
