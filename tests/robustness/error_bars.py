#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Error bars of random sliding and rocking blocks, against runs with steps 8 times finer.

usage: error_bars.py [--pairs 120] [--seed 1] [-v]
       error_bars.py --inputs INPUT.nml ...
       error_bars.py --columns 20

A pair is a block and a time step.  A figure is displacement, slip or tilt (largest and at the end),
or the largest velocity.  It counts as inside if the run at Δt/8 lies within its bar, otherwise as
outside.  Figures that are reported not to converge are counted separately.

With --inputs, all figures of the inputs are counted: figures without a limit by the reported
reason, and whether the others have the run at Δt/8 within their bars.

With --columns, the surface of random linear columns is tested.  Its bars come from the exact
transfer function without other runs.  They are compared with the limit of runs at Δt/8 and Δt/16,
and for the amplification with the limit of the transfer functions of these steps.
"""

import argparse
import math
import random
import sys
import tempfile
import warnings
from pathlib import Path

import numpy as np

import sitedda
from sitedda.study.error_bars.figures import BEYOND, IMPACT, NOT_CONVERGED
from sitedda.study.error_bars.variants import facts_of, finer

SLIDING = ("largest_displacement_m", "residual_displacement_m", "largest_slip_m",
           "largest_velocity_m_s")  # fmt: skip
ROCKING = ("largest_displacement_m", "largest_tilt_rad", "largest_velocity_m_s")
FINER = 8


def model(rng: random.Random, rocks: bool) -> tuple[str, float]:
    """Return a block on a floor under one to three half waves of acceleration, and its Δt, s."""
    width = rng.uniform(0.4, 2.0)
    ratio = rng.uniform(3.0, 6.0) if rocks else rng.uniform(0.3, 0.8)
    friction = rng.uniform(40.0, 60.0) if rocks else rng.uniform(10.0, 30.0)
    threshold = 1.0 / ratio if rocks else math.tan(math.radians(friction))
    values, sign = [], 1.0
    for _ in range(rng.randint(1, 3)):
        count = rng.randint(10, 30)
        peak = sign * threshold * 9.81 * rng.uniform(1.2, 1.8)
        values += [peak * math.sin(math.pi * i / count) for i in range(count)]
        sign = -sign
    numbers = " ".join(f"{value:.6g}" for value in [*values, 0.0])
    step = rng.choice([0.5e-3, 1e-3, 2e-3])
    b, height = 0.5 * width, ratio * width
    text = f"""
&control time_step = {step}, duration = 2, gravity = 0, -9.81, settle = .true.,
         base_motion_x = 'push' /
&material density = {rng.uniform(1800, 2800)}, young_modulus = {rng.choice([1e9, 5e9, 2e10])},
          poisson_ratio = 0.2 /
&joint friction_angle = {friction}, restitution = {rng.choice([0.0, 0.3, 0.5])} /
&block name = 'floor', vertices = -10 -1 10 -1 10 0 -10 0 /
&block name = 'block', vertices = {-b} 0 {b} 0 {b} {height} {-b} {height} /
&fixed_point x = -10, y = -1, block = 'floor' /
&fixed_point x = 10, y = -1, block = 'floor' /
&fixed_point x = -10, y = 0, block = 'floor' /
&motion name = 'push', quantity = 'acceleration', drift_order = 0, time_step = 0.01,
        values = {numbers} 300*0 /
"""
    return text, step


def judged(file: Path, step: float, rocks: bool) -> dict[str, str]:
    """Return the outcome of each figure: 'inside', 'outside' or 'no bar'."""
    figures = sitedda.accuracy(file, workers=2)
    reference_values = sitedda.run(file, time_step=step / FINER).verdict.values
    verdicts = {}
    for name in ROCKING if rocks else SLIDING:
        if name not in figures.figures:
            continue
        figure = figures[name]
        error = abs(reference_values[name] - figure.finest)
        verdict = "inside" if error <= figure.bar else "outside"
        verdicts[name] = verdict if math.isfinite(figure.bar) else "no bar"
    return verdicts


def judge_inputs(files: list[Path]) -> int:
    """Count for each input; return status 1 if a figure is outside or too many have no limit."""
    failures = 0
    for file in files:
        figures = sitedda.accuracy(file, workers=2)
        changes = finer(facts_of(file, {}), FINER)
        reference_values = sitedda.run(file, changes=changes).verdict.values
        reasons = {name: figure.doubt.partition(":")[0].partition(" of ")[0]
                 for name, figure in figures.figures.items()}  # fmt: skip
        without_bar = {w: sum(v == w for v in reasons.values())
                       for w in (NOT_CONVERGED, IMPACT, BEYOND)}  # fmt: skip
        outside_bar = [
            f"{name} {figure}, but {reference_values.get(name, 0.0):.6g} at Δt/{FINER}"
            for name, figure in figures.figures.items()
            if reasons[name] not in without_bar
            and not abs(reference_values.get(name, 0.0) - figure.finest) <= figure.bar
        ]
        result_count = len(figures.figures)
        summary = ", ".join(f"{n} {reason}" for reason, n in without_bar.items() if n)
        inside_bar = result_count - sum(without_bar.values()) - len(outside_bar)
        print(f"{file.name}: {result_count} figures, {inside_bar} inside"
              f"{', ' + summary if summary else ''}, {len(outside_bar)} outside",
              flush=True)  # fmt: skip
        print("".join(f"  {line}\n" for line in outside_bar), end="", flush=True)
        failures += (
            len(outside_bar) > 0
            or 5 * (without_bar[NOT_CONVERGED] + without_bar[IMPACT]) > result_count
        )
    return int(failures > 0)


def column(rng: random.Random) -> tuple[str, float]:
    """Return bonded layers on a moving base, and the time step, s."""
    step, bottom, layers, materials = rng.choice([0.5e-3, 1e-3, 2e-3]), 0.0, "", ""
    for i in range(rng.randint(2, 4)):
        density, speed = rng.uniform(1700, 2600), rng.uniform(200, 900)
        modulus = 2.0 * 1.25 * density * speed**2
        materials += f"""&material name = 'm{i}', density = {density}, young_modulus = {modulus},
   poisson_ratio = 0.25, damping_ratio = {rng.uniform(0.01, 0.1)}, reference_frequency = 5.0 /
"""
        thickness, count = rng.uniform(1.0, 3.0), rng.randint(2, 6)
        layers += f"""&layers name = 'l{i}', left = 0, bottom = {bottom}, width = 10,
   thickness = {thickness}, count = {count}, material = 'm{i}' /
"""
        bottom += count * thickness
        lowest_layer = f"l{i}_{count}"
    pulse = " ".join(f"{rng.uniform(-2, 2):.4f}" for _ in range(rng.randint(40, 100)))
    text = f"""
&control time_step = {step}, duration = 6, analysis = 'plane_strain',
   integration = '{rng.choice(["dda", "midpoint"])}' /
&contact normal_stiffness = 1e13 /
{materials}&joint friction_angle = 45, cohesion = 1e9, tensile_strength = 1e9 /
&layers name = 'base', left = 0, bottom = -1, width = 10, thickness = 1, material = 'm0' /
{layers}&fixed_point x = 1, y = -0.5, motion_x = 'quake' /
&fixed_point x = 9, y = -0.5, motion_x = 'quake' /
&motion name = 'quake', quantity = 'acceleration', drift_order = 0, time_step = 0.02,
   values = 0 {pulse} 400*0 /
&measured_point name = 'base', x = 5, y = -0.5, block = 'base_1' /
&measured_point name = 'surface', x = 5, y = {bottom}, block = '{lowest_layer}' /
&amplification surface = 'surface', base = 'base', lowest = 0.5, highest = 15 /
"""
    return text, step


SURFACE = ("pgv_m_s[surface]", "pga_resolved_m_s2[surface]", "sa_resolved_m_s2[surface]",
           "amplification", "amplification_frequency_hz")  # fmt: skip


def _surface(file: Path, step: float, grid: np.ndarray) -> dict[str, float]:
    """Return figures of a run with a time step, and the peak of its transfer function."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", sitedda.PeakWarning)  # of motions that continue at the end
        values = dict(sitedda.run(file, time_step=step).verdict.values)
    grid = grid[grid <= 15.0]
    ratio = abs(sitedda.transfer(file, grid, time_step=step))
    return values | {"amplification": ratio.max(),
                    "amplification_frequency_hz": grid[ratio.argmax()]}  # fmt: skip


def judge_columns(count: int, seed: int) -> int:
    """Count figures; return status 1 if one is outside its bar or differs by more than 1 %."""
    outside_bar, largest_errors = 0, dict.fromkeys(SURFACE, 0.0)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "column.nml"
        for number in range(count):
            text, step = column(random.Random(1000 * seed + number))
            file.write_text(text)
            figures = sitedda.accuracy(file)
            grid = figures["amplification_frequency_hz"].finest * np.linspace(0.95, 1.05, 2001)
            coarse, fine = (_surface(file, step / divisor, grid) for divisor in (FINER, 2 * FINER))
            order = facts_of(file, {}).order
            reference_values = {n: fine[n] + (fine[n] - coarse[n]) / (2**order - 1)
                                for n in SURFACE}  # fmt: skip
            for name in SURFACE:
                error = abs(reference_values[name] - figures[name].finest)
                largest_errors[name] = max(largest_errors[name], error / reference_values[name])
                outside_bar += not error <= figures[name].bar
                if not error <= figures[name].bar:
                    print(
                        f"column {number}: {name} {figures[name]}, but {reference_values[name]:.6g}"
                    )
    total = count * len(SURFACE)
    print(f"{total - outside_bar} of {total} figures inside their bar")
    print("largest errors:", ", ".join(f"{n} {100 * v:.2g} %" for n, v in largest_errors.items()))
    return int(outside_bar > 0 or max(largest_errors.values()) > 0.01)


def main(arguments: list[str]) -> int:
    """Count figures; return status 1 if fewer than nine of ten are inside."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--pairs", type=int, default=120)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("-v", "--verbose", action="store_true")
    parser.add_argument("--columns", type=int, default=0)
    parser.add_argument("--inputs", type=Path, nargs="+")
    options = parser.parse_args(arguments)
    if options.inputs:
        return judge_inputs(options.inputs)
    if options.columns:
        return judge_columns(options.columns, options.seed)
    counts = {True: dict.fromkeys(("inside", "outside", "no bar"), 0)}
    counts[False] = dict(counts[True])
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "pair.nml"
        for number in range(options.pairs):
            rocks = bool(number % 2)
            text, step = model(random.Random(1000 * options.seed + number), rocks)
            file.write_text(text)
            verdicts = judged(file, step, rocks)
            for verdict in verdicts.values():
                counts[rocks][verdict] += 1
            if options.verbose and set(verdicts.values()) != {"inside"}:
                print(f"pair {number}: {verdicts}", flush=True)
    for rocks, counter in counts.items():
        listing = ", ".join(f"{n} {w}" for w, n in counter.items())
        print("rocking:" if rocks else "sliding:", listing)
    inside_bar, outside_bar, without_bar = (sum(c[w] for c in counts.values())
                                            for w in counts[True])  # fmt: skip
    print(f"{inside_bar} of {inside_bar + outside_bar + without_bar} figures inside their bar")
    return int(inside_bar < 0.9 * (inside_bar + outside_bar + without_bar))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
