#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cost of studies compared with bare runs, with several workers, and for very many cases.

usage: python tests/benchmarks/studies.py [--cases N] [--planned N] [--workers N] [--folder FOLDER]

Columns of ten drums under 12 s of a record, one for each friction angle, run in two ways: as bare
runs (the engine with its output, one after another in one process, and in several simultaneous
processes), and as studies with one and with several workers.  Printed are wall time, processor time
of all processes, and the cost of a case without the start of programs, from a second measurement of
a few cases.  On a machine with other work, only processor times indicate the overhead.  The gain
by workers should be compared with the gain by simultaneous bare runs.

Then the time and memory to plan and to collect very many cases are measured.  Their results are
artificial, each with 14 numbers and a history.
"""

import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from layered_site import parse_options, processor_time

RECORD = Path(__file__).parents[2] / "inputs/records/LomaPrieta1989_USGS1002_APEEL2_133.smc"
RESULTS = ["largest_tilt_rad", "displacement[top].x.largest", "displacement[top].x"]
COLUMN = """&run title = 'Column of ten drums under a record' /
&control time_step = 1.0e-3, duration = 12.0, gravity = 0.0, -9.81 /
&contact normal_stiffness = 4.0e8 /
&material name = 'limestone', density = 2250.0, young_modulus = 17.0e9, poisson_ratio = 0.22 /
&joint name = 'drums', friction_angle = 35.0 /
&layers name = 'foundation', left = -1.0, bottom = -0.5, width = 2.0, thickness = 0.5 /
&drums name = 'drum', bottom = 0.0, width = 0.6, height = 0.5, count = 10 /
&motion name = 'quake', file = '{record}' /
&fixed_point x = -0.9, y = -0.4, motion_x = 'quake' /
&fixed_point x = 0.9, y = -0.4, motion_x = 'quake' /
&measured_point name = 'top', x = 0.0, y = 5.0, block = 'drum_10' /
&output file = 'column.nc', history_interval = 5, block_interval = 500 /
"""


def angles(count: int) -> dict[str, list[float]]:
    """Return the parameter of a study of `count` cases."""
    return {"joint.friction_angle": [20.0 + 20.0 * i / count for i in range(count)]}


def bare(file: Path, count: int, folder: Path) -> None:
    """Run the cases without a study."""
    import sitedda

    for i, angle in enumerate(angles(count)["joint.friction_angle"]):
        changes = {"joint.friction_angle": angle}
        with sitedda.Simulation(file, folder / f"{i}.nc", changes=changes) as run:
            while not run.advance(10000):
                pass
            run.finish()


def as_study(file: Path, count: int, folder: Path, workers: int) -> None:
    """Run the cases as a study."""
    import sitedda

    sitedda.study(file, angles(count), RESULTS, folder=folder, workers=workers)


def measured(*programs: list[str]) -> tuple[float, float]:
    """Return wall and processor time, s, of this program with several arguments simultaneously."""
    begun, used_before = time.perf_counter(), processor_time()
    job_process = [subprocess.Popen([sys.executable, __file__, *arguments])
                   for arguments in programs]  # fmt: skip
    if any([program.wait() for program in job_process]):
        sys.exit("a program has failed")
    return time.perf_counter() - begun, processor_time() - used_before


def compare(count: int, workers: int, folder: Path) -> None:
    """Measure bare runs one after another and simultaneously; studies with one and more workers."""
    file = folder / "column.nml"
    file.write_text(COLUMN.format(record=RECORD))
    rows = {}
    for label, mode, programs in (
        ("bare", "bare", 1),
        (f"bare, {workers} at once", "bare", workers),
        ("study, 1 worker", "1", 1),
        (f"study, {workers} workers", str(workers), 1),
    ):
        elapsed, start = (
            measured(*(["--mode", mode, "--file", str(file), "--cases", str(cases // programs),
                        "--folder", str(folder / f"{mode}_{cases}_{i}")]
                       for i in range(programs)))
            for cases in (count, workers)
        )  # fmt: skip
        cases = count - workers
        rows[label] = [(a - b) / cases for a, b in zip(elapsed, start, strict=True)]
        print(f"{label:18s} {elapsed[0]:7.1f} s wall time, {elapsed[1]:7.1f} s processor time; "
              f"each case beyond the first {workers} {1e3 * rows[label][0]:6.1f} and "
              f"{1e3 * rows[label][1]:6.1f} ms", flush=True)  # fmt: skip
    alone, together, one, several = rows.values()
    print(f"overhead of a case: {100 * (one[1] / alone[1] - 1):.1f} % of the processor time of its "
          "bare run")  # fmt: skip
    print(f"ratio of wall times, one to {workers}: bare runs {alone[0] / together[0]:.2f}, "
          f"workers {one[0] / several[0]:.2f}")  # fmt: skip


def many(count: int, folder: Path) -> None:
    """Plan and collect very many cases with artificial results."""
    for step in ("plan", "fill", "collect"):
        arguments = ["--mode", step, "--cases", str(count), "--folder", str(folder)]
        subprocess.run([sys.executable, __file__, *arguments], check=True)


def _plan(count: int, folder: Path):
    from sitedda.study.plan import make_plan

    file = folder / "column.nml"
    file.write_text(COLUMN.format(record=RECORD))
    return make_plan(file, angles(count), RESULTS, folder / "many")


def one_of_many(mode: str, count: int, folder: Path) -> None:
    """Run one step; print its time and peak memory."""
    plan, begun = _plan(count, folder), time.perf_counter()
    if mode == "plan":
        plan.write()
    elif mode == "fill":
        _fill(folder / "many")
        return
    else:
        from sitedda.study import collect

        table = collect(folder / "many", folder / "many.nc")
        print(f"table: {dict(table.sizes)}, {len(table.data_vars)} variables")
    wall, cpu = time.perf_counter() - begun, time.process_time()
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"{mode} of {count} cases: {wall:.1f} s wall time, {cpu:.1f} s processor time, peak "
          f"memory {peak:.0f} MiB", flush=True)  # fmt: skip


def _fill(study: Path) -> None:
    import numpy as np

    from sitedda.study.store import case_folder, write_result

    keys = json.loads((study / "study.json").read_text())["cases"]
    time_axis = np.arange(2401) * 0.005
    for number, key in enumerate(keys):
        history = np.sin(time_axis + number)
        numbers = {f"number_{i}": float(number + i) for i in range(14)}
        shape = {"dims": ["time"], "shape": [2401], "units": "m"}
        arrays = {"top": history, "top|time": time_axis}
        description = {"numbers": numbers, "warning": "", "seconds": 1.0, "shapes": {"top": shape}}
        write_result(case_folder(study, key), "complete", arrays=arrays, **description)


def main() -> None:
    """Read the command line and measure."""
    options = parse_options(__doc__, cases=1000, planned=10000, workers=2, folder=Path, file=Path,
                    mode="all")  # fmt: skip
    os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    with tempfile.TemporaryDirectory() as scratch:
        folder = options.folder or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        if options.mode == "bare":
            bare(options.file, options.cases, folder)
        elif options.mode.isdecimal():
            as_study(options.file, options.cases, folder, int(options.mode))
        elif options.mode != "all":
            one_of_many(options.mode, options.cases, folder)
        else:
            if options.cases:
                compare(options.cases, options.workers, folder)
            if options.planned:
                many(options.planned, folder)


if __name__ == "__main__":
    main()
