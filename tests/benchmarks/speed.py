# SPDX-License-Identifier: GPL-3.0-or-later
"""Speed of the engine: python tests/benchmarks/speed.py [--models NAME …] [--docs].

usage: speed.py [--models NAME …] [--threads N …] [--full] [--docs]   (full: all settings)

Stacks, running-bond walls and a packing of random polygons, with time steps of 1e-3 and 1e-5 s,
penalties of E and 100 E (times 1 m), one and two threads.  Phases: quiet steps (at rest without
contact changes), shaken steps, the first ten steps after sudden gravity on a wall with closed
joints, and settling steps.  Also the engine with SOR of the original DDA, and the same step in
plain numpy and scipy (`plain_step.py`), whose result must agree with that of the engine.

Each case runs in its own process.  Times are medians and percentiles of single steps, or of groups
of steps if a step takes microseconds.  --docs writes the table and the picture to docs/.
"""

import json
import os
import platform
import re
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict, dataclass
from pathlib import Path

from common import ROOT, parse_options, processor
from speed_models import MODELS, PERIOD, TOUCHING, YOUNG_MODULUS

DOCS = ROOT / "docs"
PHASES = ("search", "detect", "assemble", "factorise", "solve", "iterate", "update")
SETTLING, REST = 12, 15  # repetitions, steps between them; all rates are then set to zero
LEAD = 60  # steps of shaking before the shaken phase is measured
LONGEST = 4 * PERIOD  # steps of shaking
SUDDEN, SETTLED = 10, 60  # steps after gravity starts: end of the sudden, end of the settling phase
LIMIT = 400  # time limit of a case, s
QUIET_FROM = 50000  # blocks from which only the quiet phase is measured, without rivals
SHORT = 5e-4  # s: shorter steps are timed in groups
LATE = 0.99  # fraction of the steps that take at most the time `late`


@dataclass(frozen=True)
class Case:
    """One model with one setting."""

    model: str
    penalty: float = 100.0  # over Young's modulus · 1 m
    time_step: float = 1e-3
    threads: int = 1
    solver_asked: str = "auto"
    compared: bool = False  # compare with the plain step


SETTINGS = ((100.0, 1e-3), (100.0, 1e-5), (1.0, 1e-3), (1.0, 1e-5))
BUDGET = {"stack 15": 1.0, "wall 100000": 30.0}  # time of a phase, s; otherwise DEFAULT_BUDGET
DEFAULT_BUDGET = 4.0
SUDDEN_BUDGET = 10  # factor of these times for sudden and settling steps, which are few and slow


def cases(models: list[str], threads: list[int], all_sizes: bool) -> list[Case]:
    """Return all cases; large models and the small penalty only once unless `all_sizes`."""
    selection = []
    for model in models:
        settings = SETTINGS if all_sizes or model == "wall 1000" else SETTINGS[:2]
        if model in ("wall 821", "wall 100000") and not all_sizes:
            settings = SETTINGS[:1]
        for penalty, step in settings:
            for count in threads:
                compared = count == 1 and (penalty, step) == SETTINGS[0] and model in PLAIN
                selection.append(Case(model, penalty, step, count, compared=compared))
        if model in SOR:
            selection.append(Case(model, solver_asked="sor"))
    return selection


PLAIN = ("stack 15", "wall 100", "wall 1000", "wall 10000")
SOR = PLAIN[:3]


def main() -> None:
    options = parse_options(
        __doc__, models=list(MODELS), threads=[1, 2], full=False, docs=False, case=str
    )
    if options.case:
        print(json.dumps(measure(Case(**json.loads(options.case)))))
        return
    results = []
    print(machine())
    for case in cases(options.models, options.threads, options.full):
        results.append(asdict(case) | measured_apart(case))
        print(line(results[-1]), flush=True)
    import speed_report  # needs matplotlib

    print(speed_report.text(machine(), results))
    if options.docs:
        speed_report.write(DOCS, machine(), results)


def machine() -> str:
    """Return processor, its present speed, and versions, in one line."""
    import numpy as np

    import sitedda

    name = processor("model name") or platform.processor() or platform.machine()
    square, vector = np.ones((512, 512)), np.ones(30_000_000, np.float32)
    products = 2e-9 * 512**3 / best_time(lambda: square @ square)
    read_rate = 1e-9 * vector.nbytes / best_time(lambda: vector @ vector)
    speeds = (
        f"dgemm {products:.0f} GFlop/s, reads {read_rate:.0f} GB/s, load {os.getloadavg()[0]:.1f}"
    )
    return f"{name}, {os.cpu_count()} cores, {speeds}, sitedda {sitedda.__version__}"


def best_time(action) -> float:
    """Return the least time of a few repetitions, s."""
    times = []
    for _ in range(7):
        begun = time.perf_counter()
        action()
        times.append(time.perf_counter() - begun)
    return min(times)


def measured_apart(case: Case) -> dict:
    """Measure a case in its own process with its number of threads."""
    environment = os.environ | {
        "OMP_NUM_THREADS": str(case.threads),
        "OMP_WAIT_POLICY": "active",
        "OMP_PROC_BIND": "true",
        "OPENBLAS_NUM_THREADS": "1",
    }
    command = [sys.executable, __file__, "--case", json.dumps(asdict(case))]
    try:
        process = subprocess.run(
            command, env=environment, capture_output=True, text=True, timeout=LIMIT
        )
    except subprocess.TimeoutExpired:
        return {"error": f"not done within {LIMIT} s"}
    if process.returncode:
        output = process.stderr.strip() or f"ended with status {process.returncode}"
        return {"error": output.splitlines()[-1]}
    return json.loads(process.stdout.splitlines()[-1])


def measure(case: Case) -> dict:
    """Measure the phases of a model that the case requires."""
    import sitedda

    budget = BUDGET.get(case.model, DEFAULT_BUDGET)
    steps = steps_within(case, budget)
    settling_steps = 10 * -(-(SETTLING * REST + steps + 10) // 10)
    model = MODELS[case.model]()
    result = {"blocks": len(model.polygons)}
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "model.nml"
        shaking_steps = LEAD + min(steps, LONGEST) + 10
        penalty = case.penalty * YOUNG_MODULUS
        file.write_text(model.text(penalty, case.time_step, settling_steps, shaking_steps,
                                   case.solver_asked))  # fmt: skip
        with sitedda.Simulation(file) as run:
            if case.solver_asked == "auto":
                settle(run)
            result["quiet"] = watch(run, steps, budget)
            result["quiet"] |= beside(run, model, case, settling_steps)
            result["solver"] = run.solver
            if case.solver_asked == "auto" and len(model.polygons) < QUIET_FROM:
                run.advance(settling_steps - run.steps + LEAD)
                result["shaken"] = watch(run, min(steps, LONGEST), budget)
                result["shaken"] |= beside(run, model, case, settling_steps)
            notes = [run.thread_notes]
        if (case.penalty, case.time_step) == SETTINGS[0] and case.solver_asked == "auto":
            result |= let_settle(case, file, budget, notes)
    result["disturbed"] = [note for note in notes if note]
    result["memory"] = most_memory()
    return result


def let_settle(case: Case, file: Path, budget: float, notes: list[str]) -> dict:
    """Measure sudden and settling steps of a wall with closed joints; {} for other models."""
    import sitedda

    if case.model not in TOUCHING:
        return {}
    penalty = case.penalty * YOUNG_MODULUS
    file.write_text(TOUCHING[case.model]().text(penalty, case.time_step, 10, 10, "auto"))
    with sitedda.Simulation(file) as run:
        first_phase = watch(run, SUDDEN, SUDDEN_BUDGET * budget, one_by_one=True)
        second_phase = watch(run, SETTLED - SUDDEN, SUDDEN_BUDGET * budget, one_by_one=True)
        notes.append(run.thread_notes)
    return {"sudden": first_phase, "settling": second_phase}


def most_memory() -> float:
    """Return the peak memory of this process, MB; ru_maxrss would include its parent process."""
    return int(re.search(r"VmHWM:\s*(\d+)", Path("/proc/self/status").read_text())[1]) / 1024


def beside(run, model, case: Case, settling_steps: int) -> dict:
    """Compare with the plain step if the case requires it."""
    if not case.compared:
        return {}
    import plain_step

    reference = plain_step.PlainStep(model, case.penalty * YOUNG_MODULUS, case.time_step)
    return plain_step.compare(
        run, reference, lambda step: model.shaking_at(max(0, step - settling_steps))
    )


def steps_within(case: Case, budget: float) -> int:
    """Return the number of quiet steps to plan, without timing, so that all runs are equal."""
    blocks = int(case.model.split()[1])
    cost = 1.5e-6 * blocks * (1000 if case.solver_asked == "sor" else 1)
    return max(3, min(20000, int(budget / cost / (1 if blocks > 50 else 4))))


def settle(run) -> None:
    """Let the stress waves of the start decay."""
    for _ in range(SETTLING):
        run.advance(REST)
        run.rates = 0.0 * run.rates


def watch(run, most_steps: int, budget: float, one_by_one: bool = False) -> dict:
    """Return times of a step, mean times of its phases and mean counts, within a time budget.

    Two steps precede, and short steps are timed in groups, unless `one_by_one`.
    """
    group = 1
    if not one_by_one:
        begun = time.perf_counter()
        run.advance(2)
        if (time.perf_counter() - begun) / 2 < SHORT:
            group = max(1, most_steps // 40)
        most_steps -= 3
    times, counts, phases = [], run.counts, run.phase_times()
    begun = time.perf_counter()
    while not times or (
        (len(times) + 1) * group <= most_steps and time.perf_counter() - begun < budget
    ):
        start = time.perf_counter()
        run.advance(group)
        times.append((time.perf_counter() - start) / group)
    steps = len(times) * group
    end_times, end_counts = run.phase_times(), run.counts
    return {
        "step": statistics.median(times),
        "mean": statistics.fmean(times),
        "late": sorted(times)[int(LATE * (len(times) - 1))],
        "worst": max(times),
        "steps": steps,
        "phases": {name: (end_times[name] - phases[name]) / steps for name in PHASES},
        "counts": {name: (end_counts[name] - counts[name]) / steps for name in counts},
    }


def line(result: dict) -> str:
    """Return one case in one line."""
    import speed_report

    name = f"{result['model']:12s} {result['penalty']:4g} E {result['time_step']:g} s"
    name += f" {result['threads']} thr {result['solver_asked']:4s}"
    if "error" in result:
        return f"{name}  {result['error']}"
    for phase in speed_report.STATES:
        if phase not in result:
            continue
        row = result[phase]
        name += f" | {phase} {1e3 * row['step']:9.4f} ms, 99 % {1e3 * row['late']:9.4f}"
        name += f" oc {row['counts']['iterations']:.1f} cg {row['counts']['solver_iterations']:.0f}"
        if "plain" in row:
            name += f" plain {1e3 * row['plain']:.1f} ms ({row['plain_iterations']:.0f} its)"
            name += f" for {1e3 * row['own']:.3f}"
            if row["difference"] is not None:
                name += f", differs by {row['difference']:.0e}"
    return f"{name} | {result['memory']:.0f} MB"


if __name__ == "__main__":
    main()
