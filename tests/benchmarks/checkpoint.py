# SPDX-License-Identifier: GPL-3.0-or-later
"""Cost of checkpoints every 1,000 steps: python3 tests/benchmarks/checkpoint.py

The native executable runs the layered site (60,000 steps) and a wall of 1,000 blocks (200 steps)
alternately with and without checkpoints.  The cost of one checkpoint is that of many in a run over
their number, because the cost of a single one would be less than the scatter; the fraction of the
run time follows.  Processor time (user and system) and wall time are printed: the median of the
differences between successive runs.
"""

import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import layered_site as main_job
from interrupted import binary, layered_site, prepare, wall
from options import parse_options

TARGET = 2.0  # % of the run time


def spent(program: str, folder: Path) -> tuple[float, float]:
    """Return the processor and wall time of a run, s."""
    begun, used_before = time.perf_counter(), main_job.processor_time()
    arguments = [program, "run", "model.nml", "-q", "-o", "out.nc"]
    subprocess.run(arguments, cwd=folder, check=True, stdout=subprocess.DEVNULL)
    return main_job.processor_time() - used_before, time.perf_counter() - begun


def measure(
    program: str,
    plain_input: Path,
    checkpoint_input: Path,
    checkpoints: int,
    steps: int,
    rounds: int,
):
    """Yield times of a run and of one checkpoint, s, and their ratio, %, by both clocks."""
    pairs = [(spent(program, plain_input), spent(program, checkpoint_input)) for _ in range(rounds)]
    for clock in (0, 1):
        base = statistics.median(pair[0][clock] for pair in pairs)
        increase = statistics.median(pair[1][clock] - pair[0][clock] for pair in pairs)
        cost = increase / checkpoints
        yield base, cost, 100 * cost * (steps / 1000) / base


def main() -> int:
    """Measure both models and print the table."""
    options = parse_options(__doc__, rounds=9, program=str)
    program = binary(options.program)
    os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    models = {
        "layered site": (60_000, 100, lambda interval: layered_site(60_000, interval)),
        "wall of 1,000": (200, 5, lambda interval: wall(200, interval, bricks=100)),
    }
    largest_cost = 0.0
    print("model           clock      run without   one checkpoint   every 1,000 steps")
    for name, (steps, often, text) in models.items():
        with tempfile.TemporaryDirectory() as scratch:
            folders = [prepare(Path(scratch) / str(n), text(n)) for n in (0, often)]
            results = measure(program, *folders, steps // often, steps, options.rounds)
            for clock, (base, cost, fraction) in zip(("processor", "wall"), results, strict=True):
                print(
                    f"{name:14s}  {clock:9s} {base:9.2f} s {1e3 * cost:13.3f} ms {fraction:15.2f} %"
                )
                if clock == "processor":
                    largest_cost = max(largest_cost, fraction)
    print(f"target: less than {TARGET} %")
    return int(largest_cost >= TARGET)


if __name__ == "__main__":
    sys.exit(main())
