# SPDX-License-Identifier: GPL-3.0-or-later
"""Stiffnesses from measured modes."""

import math
import time
from dataclasses import replace
from importlib.util import find_spec

import numpy as np
import pandas as pd

from sitedda.calibration import calibrate, odds
from sitedda.calibration.measured import BAND
from sitedda.engine.checking import modes
from sitedda.facade.model import Model

from ..case import Outcome, Table, absolute, at_most, case
from ..paper.avdat import column
from ..runs import Task

_FIELD = pd.DataFrame({"low": [3.0, 4.2], "high": [3.8, 5.3]})  # bands as 90 %, Hz
_DRY = {"joint[dry].normal_stiffness_per_area": (1.7e8, 3.3e9)}  # 5e7 to 1e9 N/m a contact
_GROUND = {"boundary[sway].stiffness_per_area": (1e6, 1e8),
           "boundary[rise].stiffness_per_area": (1e7, 1e9)}  # fmt: skip


def avdat_column(width: float, depth: float, springs: bool) -> Model:
    """Return the ten drums of Avdat on a block that is fixed, or on springs."""
    model = column(6e8, width, depth, time_step=1e-3, steps=1)
    if not springs:
        model.boundary(kind="fixed", blocks="base", side="bottom")
        return model
    for name, axis, stiffness in (("sway", "x", 1e7), ("rise", "y", 1e8)):
        model.boundary(name=name, kind="springs", blocks="base", side="bottom", direction=axis,
                       stiffness_per_area=stiffness)  # fmt: skip
    return model


@case(
    "The second mode of the column at Avdat",
    "The measured frequency bands are 3.0 to 3.8 and 4.2 to 5.3 Hz. A plane column on a fixed base "
    "cannot have both frequencies. A heavy base on springs can; so can a column with another joint "
    "stiffness in the other direction.",
    "Bao, Hatzor, Yagoda-Biran et al. (2013), sections 3.1 and 3.2.",
)
def avdat_second_mode(short: bool) -> Outcome:
    """Compare the evidence of four hypotheses; fit the contact stiffness to the first mode."""
    fixed = avdat_column(3, 1, False)
    first, second = (calibrate(fixed, _FIELD[i : i + 1], _DRY) for i in (0, 1))
    results = {
        "fixed base": calibrate(fixed, _FIELD, _DRY),
        "base 3 m × 1 m on springs": calibrate(avdat_column(3, 1, True), _FIELD, _DRY | _GROUND),
        "base 4 m × 2 m on springs": calibrate(avdat_column(4, 2, True), _FIELD, _DRY | _GROUND),
    }
    results["other direction"] = replace(first, evidence=first.evidence + second.evidence,
                                       fit=pd.concat([first.fit, second.fit]))  # fmt: skip
    weights = odds(results)
    cells = [
        [name, " and ".join(f"{f:.2f}" for f in r.fit.frequency), f"{r.evidence:.1f}",
         f"{weights[name]:.2g}"]
        for name, r in results.items()
    ]  # fmt: skip
    contact = 0.3 * first.unknowns.iloc[0]  # two contacts in a joint of 0.6 m
    rows = [
        absolute("contact stiffness from the first mode", 2.12e8, contact["median"], 5e6, "N/m"),
        absolute("lower bound of this stiffness, 90 %", 1.66e8, contact.low, 8e6, "N/m"),
        absolute("upper bound of this stiffness, 90 %", 2.67e8, contact.high, 12e6, "N/m"),
        at_most("probability of the fixed base", weights["fixed base"], 1e-6),
        at_most("largest misfit with a base of 4 m × 2 m, standard deviations",
                abs(results["base 4 m × 2 m on springs"].fit.misfit).max(), 1.0),
    ]  # fmt: skip
    table = Table("Evidence and posterior probability of hypotheses with equal prior probability",
                  ["hypothesis", "frequencies (Hz)", "ln evidence", "probability"],
                  cells)  # fmt: skip
    return Outcome(rows, tables=[table])


_SPREAD = 3.0  # ratio of the median of a prior to its bounds of 90 %
MEDIANS = {
    "joint[bed].normal_stiffness_per_area": 3e9, "joint[bed].shear_stiffness_per_area": 1.2e9,
    "boundary[*].stiffness_per_area": 2e9, "material[stone].young_modulus": 2e9,
}  # Pa/m and Pa  # fmt: skip
_NOISE = 0.02  # relative error of a frequency
_COLUMNS = {True: 20, False: 200}  # number of columns, short or not
_COMPARED = {True: 1, False: 6}  # number of columns that are also solved by the sampler
_TOGETHER = 10  # number of columns per task


def drums_on_springs(width: float, height: float, count: int, towers: int = 1) -> Model:
    """Return equal separate towers of drums on springs, with a point in each drum."""
    model = Model("column", time_step=1e-3, steps=1)
    model.contact(normal_stiffness=1e9)
    model.material("stone", density=2200, young_modulus=2e9, poisson_ratio=0.2)
    model.joint("bed", friction_angle=35, normal_stiffness_per_area=3e9,
                shear_stiffness_per_area=1.2e9)  # fmt: skip
    for k in range(towers):
        model.drums(name=f"t{k}", centre=3.0 * k, width=width, height=height, count=count)
        for i in range(count):
            model.measured_point(f"p{k}_{i}", 3.0 * k, height * (i + 0.5), f"t{k}_{i + 1}")
        model.boundary(kind="springs", blocks=f"t{k}_1", side="bottom", stiffness_per_area=2e9)
    return model


def random_column(seed: int, unknowns: tuple[int, int], measured: tuple[int, int]) -> tuple:
    """Return a random column, its priors, true values, and modes with noisy frequencies."""
    random = np.random.default_rng(seed)
    width, height = random.uniform(0.5, 3.0), random.uniform(0.3, 1.5)
    model = drums_on_springs(width, height, int(random.integers(2, 13)))
    names = random.choice(list(MEDIANS), random.integers(*unknowns, endpoint=True), replace=False)
    priors = {n: (MEDIANS[n] / _SPREAD, MEDIANS[n] * _SPREAD) for n in names.tolist()}
    true = {n: MEDIANS[n] * _SPREAD ** (random.standard_normal() / BAND) for n in priors}
    exact = modes(model, int(random.integers(*measured, endpoint=True)), changes=true).frequency
    noisy = exact * np.exp(_NOISE * random.standard_normal(exact.size))
    return model, {"frequency": noisy, "deviation": _NOISE * noisy}, priors, true


def _check_coverage(first: int, count: int) -> dict:
    """Return whether each band contains the true value; also return the processor time, s."""
    begin, contained = time.process_time(), []
    for seed in range(first, first + count):
        model, measured, priors, true = random_column(seed, (1, 4), (2, 5))
        unknowns = calibrate(model, measured, priors, discrepancy=0.0, seed=seed).unknowns
        value = np.array(list(true.values()))
        contained += ((unknowns.low <= value) & (value <= unknowns.high)).tolist()
    return {"inside": contained, "seconds": time.process_time() - begin}


def _compare_samplers(seed: int) -> float:
    """Return the largest relative difference of medians and bounds between both samplers."""
    model, measured, priors, _ = random_column(seed, (1, 2), (4, 5))
    laplace, ensemble = (
        calibrate(model, measured, priors, discrepancy=0.0, samples=4000, sampler=sampler).unknowns
        for sampler in ("laplace", "ensemble")
    )
    determined = laplace.deviation < 0.5 * math.log(_SPREAD) / BAND
    differences = (ensemble / laplace - 1).loc[determined, ["low", "median", "high"]]
    return float(differences.abs().to_numpy().max(initial=0.0))


def _coverage_tasks(short: bool) -> list[Task]:
    queue = [Task(("bands", first), _check_coverage, {"first": first, "count": _TOGETHER}, 4.0)
            for first in range(0, _COLUMNS[short], _TOGETHER)]  # fmt: skip
    if find_spec("emcee"):
        queue += [Task(("sampler", s), _compare_samplers, {"seed": s}, 4.0)
                 for s in range(_COMPARED[short])]  # fmt: skip
    return queue


@case(
    "Calibrated columns: how often the bands contain the true values",
    "Random columns of 2 to 12 drums have 1 to 4 unknown stiffnesses, drawn from their priors, and "
    "2 to 5 frequencies with 2 % noise. Of the 90 % bands, 90 % contain the true value. For "
    "unknowns that the modes determine, Laplace's approximation and emcee agree.",
    "Simulation-based calibration: Cook, Gelman & Rubin (2006), J. Comput. Graph. Stat. 15(3).",
    _coverage_tasks,
)
def calibration_coverage(results: dict) -> Outcome:
    """Check the coverage and the agreement of both samplers; tabulate the cost."""
    parts = [result for (kind, _), result in results.items() if kind == "bands"]
    contained = np.concatenate([result["inside"] for result in parts])
    columns = _TOGETHER * len(parts)
    allowed = 0.02 if columns == _COLUMNS[False] else 3 * math.sqrt(0.09 / contained.size)
    rows = [absolute(f"fraction of bands with the true value, {contained.size} unknowns,"
                     f" {columns} columns",
                     0.9, float(contained.mean()), allowed)]  # fmt: skip
    seconds = 100 / columns * sum(result["seconds"] for result in parts)
    cost = Table("Computing time", ["columns", "processor time (s)"], [[100, f"{seconds:.0f}"]])
    if differences := [result for (kind, _), result in results.items() if kind == "sampler"]:
        rows.append(at_most(f"largest relative difference of Laplace and emcee, {len(differences)}"
            " columns", max(differences), 0.05))  # fmt: skip
    return Outcome(rows, tables=[cost])
