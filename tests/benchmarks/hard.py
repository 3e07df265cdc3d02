# SPDX-License-Identifier: GPL-3.0-or-later
"""Hard walls of every joint law: python tests/benchmarks/hard.py BUILD [--laws WORD …]

usage: hard.py BUILD [--laws WORD …] [--adaptive] [--keep FOLDER] [--jobs N]

BUILD is a Meson build folder or a folder with an executable `sitedda-native`.  Walls of 20 to 120
bricks are shaken by 1 g, loaded by sudden gravity, or brought to rest and then shaken, with
friction angles of 12° to 70° and Δt of 1 to 20 ms.  Printed for each law: how many runs complete
with fixed and adaptive Δt, their iterations, factors and applications, their processor time, and
the messages of the other runs.  --adaptive also tests adaptive steps; --keep names a folder for
inputs of incomplete runs; --jobs is the number of simultaneous cases.
"""

import sys
import tempfile
from itertools import product
from pathlib import Path

import ablation
import numpy as np
from common import parse_options
from speed_models import GRAVITY, HEAD_JOINT, wall

ANGLES = (12, 20, 30, 40, 55, 70)
STEPS = {1: 60, 3: 40, 8: 25, 20: 15}  # ms: number of steps
STARTS = ("sudden", "shaken", "rest")
SIZES = (20, 35, 60, 90, 120)
PENALTY = 5.0e11  # N/m
SAMPLE = 5.0e-3  # sampling interval of the motion, s
_AREA = "normal_stiffness_per_area = 1e11, shear_stiffness_per_area = 4e10"
# Variables of &joint other than the friction angle, and additional groups.
LAWS = {
    "coulomb": ("", ""),
    "coulomb with cohesion": ("cohesion = 2e4, tensile_strength = 1e4", ""),
    "stiffness per area": (_AREA, ""),
    "3 points": ("contact_points = 3", ""),
    "5 points": ("contact_points = 5", ""),
    "mohr_coulomb": (
        f"law = 'mohr_coulomb', residual_friction_angle = {{low}}, cohesion = 2e4, {_AREA}", ""
    ),
    "mohr_coulomb that weakens": (
        f"law = 'mohr_coulomb', residual_friction_angle = {{low}}, weakening_slip = 2e-3, {_AREA}",
        "",
    ),
    "mohr_coulomb that dilates": (
        f"law = 'mohr_coulomb', dilation_angle = {{dilation}}, dilation_slip = 5e-3, {_AREA}", ""
    ),
    "barton_bandis": (
        "law = 'barton_bandis', jrc = 10.0, jcs = 5e7, normal_stiffness_per_area = 1e11,"
        " max_closure = 5e-4", ""
    ),
    "plesha": (
        "law = 'plesha', asperity_angle = {asperity}, asperity_wear = 1e-4,"
        " normal_stiffness_per_area = 4e10, shear_stiffness_per_area = 4e10", ""
    ),
    "cohesive": (
        f"law = 'cohesive', cohesion = 3e5, tensile_strength = 2e5, fracture_energy = 50, {_AREA}",
        "",
    ),
    "continuously_yielding": (
        "law = 'continuously_yielding', initial_friction_angle = {high}, roughness = 2e-3,"
        f" {_AREA}", ""
    ),
    "rate_state": (
        "law = 'rate_state', direct_effect = 0.01, evolution_effect = 0.015, state_distance = 1e-3,"
        f" reference_velocity = 1e-3, threshold_velocity = 1e-5, {_AREA}", ""
    ),
    "restitution": ("restitution = 0.0", ""),
    "bolts": ("", "bolts"),
}  # fmt: skip


def cases(law: str, adaptive: bool = False) -> dict[str, str]:
    """Return inputs by name."""
    table = {}
    for i, (start, ms, angle) in enumerate(product(STARTS, STEPS, ANGLES)):
        block_count = SIZES[i % len(SIZES)]
        text = model(law, start, block_count, ms * 1e-3, STEPS[ms], angle, adaptive)
        table[f"{law}: {start}, {block_count} at {ms} ms, {angle} degrees"] = text
    return table


def model(
    law: str, start: str, blocks: int, step: float, steps: int, angle: int, adaptive: bool
) -> str:
    """The input of a wall."""
    base_model = wall(blocks, 0.0 if start == "sudden" else HEAD_JOINT)
    if start != "shaken":
        base_model.stress[:] = 0.0
    variables, groups = LAWS[law]
    law_text = variables.format(
        low=0.7 * angle,
        high=0.5 * (89 + angle),
        dilation=min(15, 0.5 * angle),
        asperity=min(20, 0.3 * angle, 0.3 * (89 - angle)),
    )
    time = np.arange(0.0, steps * step + 2 * SAMPLE, SAMPLE)
    acceleration = (start != "sudden") * GRAVITY * np.sin(2 * np.pi * 4.0 * time)
    lines = [
        f"&control time_step = {step!r}, steps = {steps}, gravity = 0.0, {-GRAVITY}",
        f"   settle = .{'true' if start == 'rest' else 'false'}., base_motion_x = 'shaking'",
        f"   time_step_control = '{'adaptive' if adaptive else 'fixed'}' /",
        f"&contact normal_stiffness = {PENALTY!r} /",
        "&output history_interval = 1 /",
        f"&joint friction_angle = {float(angle)}{', ' if law_text else ''}{law_text} /",
        f"&motion name = 'shaking', quantity = 'acceleration', time_step = {SAMPLE}",
        f"   drift_order = 0, values = {', '.join(f'{a:.6f}' for a in acceleration)} /",
        *base_model.block_lines(),
    ]
    if groups == "bolts":
        lines.append(bolts(base_model))
    return "\n".join(lines) + "\n"


def bolts(model) -> str:
    """Return vertical pretensioned bolts through the whole wall, which yield."""
    width = model.polygons[0][1, 0] - 0.5
    return "\n".join(
        f"&bolt name = 'b{i}', from = {0.3 + i * 2.0}, -0.1, to = {0.3 + i * 2.0},"
        f" {model.top - 0.1}, axial_stiffness = 1e8, pretension = 2e4, yield_force = 3e4 /"
        for i in range(int(width // 2))
    )


def measured(folder: Path, texts: dict[str, str], jobs: int) -> dict:
    """Return counts of each run with the executable of a folder, or its error message."""
    limits = dict.fromkeys(texts, {"seconds": 4})
    return ablation.measured(folder / "native", ablation.written(texts, folder), jobs, limits)


def row(law: str, fixed: dict, adaptive: dict | None) -> str:
    """A row of the table."""
    complete_runs = [r for r in fixed.values() if isinstance(r, dict)]
    sums = [sum(r[k] for r in complete_runs) for k in ("iterations", "factors", "applications")]
    cells = f"| {law} | {len(complete_runs)} of {len(fixed)} |"
    if adaptive is not None:
        cells += f" {sum(isinstance(r, dict) for r in adaptive.values())} of {len(adaptive)} |"
    seconds = sum(r["seconds"] for r in complete_runs)
    return cells + " {} / {} / {} | {:.1f} |".format(*sums, seconds)


def main() -> None:
    """Run all cases and print the table."""
    options = parse_options(__doc__, "build", laws=[""], adaptive=False, keep=Path, jobs=1)
    print(f"| law | ends |{' adaptive |' * options.adaptive} it / F / S | s |")
    for law in LAWS:
        if not any(part in law for part in options.laws):
            continue
        with tempfile.TemporaryDirectory() as folder:
            own = Path(folder)
            (own / "native").symlink_to(options.build.resolve() / "sitedda-native")
            texts = cases(law)
            fixed = measured(own, texts, options.jobs)
            adaptive = None
            if options.adaptive:
                adaptive = measured(own, cases(law, True), options.jobs)
        print(row(law, fixed, adaptive), flush=True)
        for name, outcome in [*fixed.items(), *(adaptive or {}).items()]:
            if isinstance(outcome, str):
                print(f"    {name}: {outcome}", flush=True)
                if options.keep:
                    copy = options.keep / (name.replace(" ", "_").replace(":", "") + ".nml")
                    options.keep.mkdir(parents=True, exist_ok=True)
                    copy.write_text(texts[name])


if __name__ == "__main__":
    sys.exit(main())
