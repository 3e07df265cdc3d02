# SPDX-License-Identifier: GPL-3.0-or-later
"""How fast the engine steps: python tests/benchmarks/speed.py [--models NAME …] [--docs].

usage: speed.py [--models NAME …] [--threads N …] [--full] [--docs]   (full: all settings)

Stacks, running-bond walls and a packing of random polygons, at time steps of 1e-3 and 1e-5 s and
penalties of E and 100 E (times 1 m), on one thread and on two: quiet steps (settled, nothing
changes), shaken ones, the first ten after gravity has come suddenly on a wall that touches
everywhere, and those in which it settles.  In the same run: the engine with the
original DDA's SOR, and the same step written plainly with numpy and scipy (`plain_step.py`), whose
result must agree with the engine's.

Every case runs in a process of its own.  Times are medians and percentiles of single steps, or of
stretches of steps where a step takes microseconds.  With --docs the table and the picture go to
docs/.
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

from layered_site import ROOT, asked, processor
from speed_models import MODELS, PERIOD, TOUCHING, YOUNG_MODULUS

DOCS = ROOT / "docs"
PHASES = ("search", "detect", "assemble", "factorise", "solve", "iterate", "update")
SETTLING, REST = 12, 15  # looks, steps between them: after each look all rates are set to zero
LEAD = 60  # steps of shaking before the shaken phase is measured
LONGEST = 4 * PERIOD  # steps of shaking
SUDDEN, SETTLED = 10, 60  # steps after gravity has come: the sudden ones, the last of the settling
LIMIT = 400  # s for a case
QUIET_FROM = 50000  # blocks from which no other phase is measured; nor is one of the rivals
SHORT = 5e-4  # s: steps shorter than this are timed in stretches
LATE = 0.99  # fraction of the steps that take no longer than the time of that name


@dataclass(frozen=True)
class Case:
    """One model with one setting."""

    model: str
    penalty: float = 100.0  # times Young's modulus times 1 m
    time_step: float = 1e-3
    threads: int = 1
    solver_asked: str = "auto"
    compared: bool = False  # with the plain step


SETTINGS = ((100.0, 1e-3), (100.0, 1e-5), (1.0, 1e-3), (1.0, 1e-5))
BUDGET = {"stack 15": 1.0, "wall 100000": 30.0}  # s for a phase, else DEFAULT_BUDGET
DEFAULT_BUDGET = 4.0
SUDDEN_BUDGET = 10  # times that: sudden and settling steps are few and long


def cases(models: list[str], threads: list[int], full: bool) -> list[Case]:
    """All cases of a run; large models and the weak penalty only once unless `full`."""
    chosen = []
    for model in models:
        settings = SETTINGS if full or model == "wall 1000" else SETTINGS[:2]
        if model in ("wall 821", "wall 100000") and not full:
            settings = SETTINGS[:1]
        for penalty, step in settings:
            for count in threads:
                compared = count == 1 and (penalty, step) == SETTINGS[0] and model in PLAIN
                chosen.append(Case(model, penalty, step, count, compared=compared))
        if model in SOR:
            chosen.append(Case(model, solver_asked="sor"))
    return chosen


PLAIN = ("stack 15", "wall 100", "wall 1000", "wall 10000")
SOR = PLAIN[:3]


def main() -> None:
    options = asked(__doc__, models=list(MODELS), threads=[1, 2], full=False, docs=False, case=str)
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
    """Processor, what it is able to do now, and versions, in one line."""
    import numpy as np

    import sitedda

    name = processor("model name") or platform.processor() or platform.machine()
    square, long = np.ones((512, 512)), np.ones(30_000_000, np.float32)
    products = 2e-9 * 512**3 / best_time(lambda: square @ square)
    reads = 1e-9 * long.nbytes / best_time(lambda: long @ long)
    able = f"dgemm {products:.0f} GFlop/s, reads {reads:.0f} GB/s, load {os.getloadavg()[0]:.1f}"
    return f"{name}, {os.cpu_count()} cores, {able}, sitedda {sitedda.__version__}"


def best_time(action) -> float:
    """Seconds, the best of a few."""
    times = []
    for _ in range(7):
        begun = time.perf_counter()
        action()
        times.append(time.perf_counter() - begun)
    return min(times)


def measured_apart(case: Case) -> dict:
    """Measure in a process of its own, with its number of threads."""
    environment = os.environ | {
        "OMP_NUM_THREADS": str(case.threads),
        "OMP_WAIT_POLICY": "active",
        "OMP_PROC_BIND": "true",
        "OPENBLAS_NUM_THREADS": "1",
    }
    command = [sys.executable, __file__, "--case", json.dumps(asdict(case))]
    try:
        done = subprocess.run(
            command, env=environment, capture_output=True, text=True, timeout=LIMIT
        )
    except subprocess.TimeoutExpired:
        return {"error": f"not done within {LIMIT} s"}
    if done.returncode:
        said = done.stderr.strip() or f"ended with status {done.returncode}"
        return {"error": said.splitlines()[-1]}
    return json.loads(done.stdout.splitlines()[-1])


def measure(case: Case) -> dict:
    """Measure the states of a model that the case requires."""
    import sitedda

    budget = BUDGET.get(case.model, DEFAULT_BUDGET)
    steps = steps_within(case, budget)
    rest = 10 * -(-(SETTLING * REST + steps + 10) // 10)
    model = MODELS[case.model]()
    result = {"blocks": len(model.polygons)}
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "model.nml"
        shaken = LEAD + min(steps, LONGEST) + 10
        penalty = case.penalty * YOUNG_MODULUS
        file.write_text(model.text(penalty, case.time_step, rest, shaken, case.solver_asked))
        with sitedda.Simulation(file) as run:
            if case.solver_asked == "auto":
                settle(run)
            result["quiet"] = watch(run, steps, budget)
            result["quiet"] |= beside(run, model, case, rest)
            result["solver"] = run.solver
            if case.solver_asked == "auto" and len(model.polygons) < QUIET_FROM:
                run.advance(rest - run.steps + LEAD)
                result["shaken"] = watch(run, min(steps, LONGEST), budget)
                result["shaken"] |= beside(run, model, case, rest)
            notes = [run.thread_notes]
        if (case.penalty, case.time_step) == SETTINGS[0] and case.solver_asked == "auto":
            result |= let_settle(case, file, budget, notes)
    result["disturbed"] = [note for note in notes if note]
    result["memory"] = most_memory()
    return result


def let_settle(case: Case, file: Path, budget: float, notes: list[str]) -> dict:
    """Gravity comes suddenly, and the wall settles; nothing for models that are no such walls."""
    import sitedda

    if case.model not in TOUCHING:
        return {}
    penalty = case.penalty * YOUNG_MODULUS
    file.write_text(TOUCHING[case.model]().text(penalty, case.time_step, 10, 10, "auto"))
    with sitedda.Simulation(file) as run:
        sudden = watch(run, SUDDEN, SUDDEN_BUDGET * budget, single=True)
        settling = watch(run, SETTLED - SUDDEN, SUDDEN_BUDGET * budget, single=True)
        notes.append(run.thread_notes)
    return {"sudden": sudden, "settling": settling}


def most_memory() -> float:
    """The most that this process has used, MB; ru_maxrss would include what it was forked from."""
    return int(re.search(r"VmHWM:\s*(\d+)", Path("/proc/self/status").read_text())[1]) / 1024


def beside(run, model, case: Case, rest: int) -> dict:
    """The plain step beside the engine's, where the case requires it."""
    if not case.compared:
        return {}
    import plain_step

    plain = plain_step.PlainStep(model, case.penalty * YOUNG_MODULUS, case.time_step)
    return plain_step.compare(run, plain, lambda step: model.shaking_at(max(0, step - rest)))


def steps_within(case: Case, budget: float) -> int:
    """How many quiet steps to plan for: counted, not timed, so that every run is the same."""
    blocks = int(case.model.split()[1])
    cost = 1.5e-6 * blocks * (1000 if case.solver_asked == "sor" else 1)
    return max(3, min(20000, int(budget / cost / (1 if blocks > 50 else 4))))


def settle(run) -> None:
    """Let the stress waves of the start die away."""
    for _ in range(SETTLING):
        run.advance(REST)
        run.rates = 0.0 * run.rates


def watch(run, most: int, budget: float, single: bool = False) -> dict:
    """Times of a step, mean times of its phases and mean counts, within a budget of time.

    Two steps are taken before, and short ones in stretches, unless `single`.
    """
    stretch = 1
    if not single:
        begun = time.perf_counter()
        run.advance(2)
        if (time.perf_counter() - begun) / 2 < SHORT:
            stretch = max(1, most // 40)
        most -= 3
    times, counts, phases = [], run.counts, run.phase_times()
    begun = time.perf_counter()
    while not times or (
        (len(times) + 1) * stretch <= most and time.perf_counter() - begun < budget
    ):
        start = time.perf_counter()
        run.advance(stretch)
        times.append((time.perf_counter() - start) / stretch)
    steps = len(times) * stretch
    later, more = run.phase_times(), run.counts
    return {
        "step": statistics.median(times),
        "mean": statistics.fmean(times),
        "late": sorted(times)[int(LATE * (len(times) - 1))],
        "worst": max(times),
        "steps": steps,
        "phases": {name: (later[name] - phases[name]) / steps for name in PHASES},
        "counts": {name: (more[name] - counts[name]) / steps for name in counts},
    }


def line(result: dict) -> str:
    """One case in one line."""
    import speed_report

    name = f"{result['model']:12s} {result['penalty']:4g} E {result['time_step']:g} s"
    name += f" {result['threads']} thr {result['solver_asked']:4s}"
    if "error" in result:
        return f"{name}  {result['error']}"
    for phase in speed_report.STATES:
        if phase not in result:
            continue
        it = result[phase]
        name += f" | {phase} {1e3 * it['step']:9.4f} ms, 99 % {1e3 * it['late']:9.4f}"
        name += f" oc {it['counts']['iterations']:.1f} cg {it['counts']['solver_iterations']:.0f}"
        if "plain" in it:
            name += f" plain {1e3 * it['plain']:.1f} ms ({it['plain_iterations']:.0f} its)"
            name += f" for {1e3 * it['own']:.3f}"
            if it["difference"] is not None:
                name += f", differs by {it['difference']:.0e}"
    return f"{name} | {result['memory']:.0f} MB"


if __name__ == "__main__":
    main()
