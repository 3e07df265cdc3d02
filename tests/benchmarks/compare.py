# SPDX-License-Identifier: GPL-3.0-or-later
"""Two engines alternately: compare.py BEFORE AFTER [--pairs N] [--cases WORD …] [--wet]

BEFORE and AFTER are executables `sitedda-native` of two commits.  Each pair runs both on the same
input in alternating order, on one thread.  Processor times are compared, because the speed of a
machine with other work varies within minutes.  For quiet and small models, and for the largest
shaken one, the time of a short run is subtracted from that of a long one; otherwise the whole run
counts.  Printed are the ratio BEFORE/AFTER, its median and range, and the least times.
With --wet the joints of BEFORE contain undrained water: compare.py E E --wet --cases "quiet 1000"
prints the cost of water, without that of its output.
"""

import os
import re
import statistics
import subprocess
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from common import INPUT, changed, parse_options, processor_time
from speed_models import YOUNG_MODULUS, Model, touching_wall, wall

import sitedda

SINGLE = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "OMP_WAIT_POLICY": "passive"}
RECORD = INPUT.parent / "records" / "LomaPrieta1989_USGS1002_APEEL2_133.smc"
STRONG, SHAKING = 6.5, 6.0  # s: start of the record for walls, and duration
LONG = 10_000  # steps, more than a case takes
PENALTY = 100 * YOUNG_MODULUS  # N/m
WATER = "&flow aperture = 1e-3, state = 'undrained', state_at_rest = 'undrained' /\n"


@dataclass(frozen=True)
class Case:
    """The function that writes the input, and steps of the run and of the run to be subtracted."""

    text: Callable[[], str]
    steps: int
    less: int = 0  # 0: no run is subtracted


def layered(layers: int) -> str:
    """Return the input of the main job, or of its deposit with fewer layers."""
    text = INPUT.read_text()
    for number in ("count = {} ", "y = {}.0", "'layer_{}'"):
        old_count, new_count = number.format(15), number.format(layers)
        if old_count not in text:
            raise SystemExit(f"{INPUT}: expected {old_count!r}")
        text = text.replace(old_count, new_count)
    return text


def settling(make: Callable[[int], Model], blocks: int, time_step: float) -> str:
    """Return the input of a model with about `blocks` blocks under its weight."""
    text = make(blocks).text(PENALTY, time_step, LONG, 0, "auto")
    return text + "&output history_interval = 1 /\n"


def resting(blocks: int) -> str:
    """Return the input of a wall of touching bricks with a static stage."""
    text = settling(touching_wall, blocks, 1e-3)
    return text.replace("&control ", "&control settle = .true., ", 1)


def shaken(blocks: int, time_step: float) -> str:
    """Return the input of a wall under twice the base motion of the main job."""
    record = sitedda.read_record(RECORD, format="smc").acceleration
    strong_motion = record.sel(time=slice(STRONG, STRONG + SHAKING))
    motion = (
        "&motion name = 'shaking', quantity = 'acceleration', drift_order = 0"
        f", time_step = {float(record.time[1])!r}\n   values = "
        + ", ".join(f"{2 * value:.3f}" for value in strong_motion.values)
    )
    return re.sub(r"(?ms)^&motion.*? /$", f"{motion} /", settling(wall, blocks, time_step))


def cases() -> dict[str, Case]:
    """Return all cases by name."""
    table = {
        "main job": Case(partial(layered, 15), 22000, 2000),
        "column 11": Case(partial(layered, 10), 22000, 2000),
        "quiet 1000": Case(partial(settling, wall, 1000, 1e-3), 660, 60),
        "quiet 10000": Case(partial(settling, wall, 10000, 1e-3), 90, 10),
        "shaken 10000": Case(partial(shaken, 10000, 1e-3), 82, 22),
    }
    for blocks in (200, 400, 800, 1000):
        for milliseconds, steps in ((1, 400), (5, 80)):
            name, step = f"{blocks} at {milliseconds} ms", milliseconds * 1e-3
            table[f"shaken {name}"] = Case(partial(shaken, blocks, step), steps)
            table[f"settling {name}"] = Case(partial(settling, touching_wall, blocks, step), 60)
    for blocks in (1000, 10000, 100000):
        table[f"sudden {blocks}"] = Case(partial(settling, touching_wall, blocks, 1e-3), 10)
        table[f"rest {blocks}"] = Case(partial(resting, blocks), 1)
    return table


def main() -> None:
    """Measure alternately, then print."""
    table = cases()
    options = parse_options(__doc__, "before", "after", pairs=5, cases=[str], wet=False)
    engines = (options.before.resolve(), options.after.resolve())
    prefixes = options.cases or list(table)
    selection = [
        name for name in table if any(f"{name} ".startswith(f"{prefix} ") for prefix in prefixes)
    ]
    if not selection:
        raise SystemExit(f"no case begins with {prefixes}; known are {', '.join(table)}")
    for name in selection:
        case = table[name]
        try:
            report(name, measured(engines, case, options.pairs, options.wet))
        except subprocess.CalledProcessError as failure:
            print(f"{name:22} fails with {failure.cmd[0]}", flush=True)


def measured(engines, case: Case, pairs: int, with_water: bool) -> list[tuple[float, float]]:
    """Return seconds of both engines in each pair; the first may have water in its joints."""
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        (folder / RECORD.parent.name).symlink_to(RECORD.parent)
        text = case.text()
        files = []
        for water in (WATER if with_water else "", ""):
            inputs = [folder / f"{len(water)}_{steps}.nml" for steps in (case.steps, case.less)]
            for file, steps in zip(inputs, (case.steps, case.less), strict=True):
                file.write_text(changed(text, steps, steps if with_water else 1) + water)
            files.append(inputs)
        runs = list(zip(engines, files, strict=True))
        times = []
        for pair in range(pairs):
            seconds = {}
            for i in (1, 0) if pair % 2 else (0, 1):
                engine, (long_run, short) = runs[i]
                seconds[i] = taken_by(engine, long_run)
                if case.less:
                    seconds[i] -= taken_by(engine, short)
            times.append((seconds[0], seconds[1]))
    return times


def taken_by(engine: Path, file: Path) -> float:
    """Return the processor time of one run, s."""
    command = [str(engine), "run", str(file), "--quiet", "-o", str(file.with_suffix(".nc"))]
    before = processor_time()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env=os.environ | SINGLE)
    return processor_time() - before


def report(name: str, times: list[tuple[float, float]]) -> None:
    """Print the ratio and the least times."""
    ratios = sorted(before / after for before, after in times)
    shortest = [min(column) for column in zip(*times, strict=True)]
    print(
        f"{name:22} {statistics.median(ratios):.2f} [{ratios[0]:.2f}, {ratios[-1]:.2f}]"
        f"   least {shortest[0]:.3f} and {shortest[1]:.3f} s",
        flush=True,
    )


if __name__ == "__main__":
    main()
