# SPDX-License-Identifier: GPL-3.0-or-later
"""Microseconds per step of the main job on one core: python3 tests/benchmarks/layered_site.py

usage: layered_site.py [--native PROGRAM] [--repeat N] [--core N]        (core: the last one)

The native executable runs inputs/layered_site.nml (60,000 steps) on one core, without its
spectral amplification.  "Output included" writes a sample of each step; "output excluded" writes
the first and the last.  The time of a run of one step (start, input, record) is subtracted.
Wall time and processor time (user and system) are printed: the median and the least of several
repetitions, because disturbances only lengthen a run.  On a machine with other work,
processor time is more reliable.
"""

import os
import platform
import re
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tests" / "robustness"))

from interrupted import binary  # noqa: E402
from options import parse_options  # noqa: E402

INPUT = ROOT / "inputs" / "layered_site.nml"
STEPS = 60_000


def main() -> None:
    options = parse_options(__doc__, native=str, repeat=5, core=int)
    core = max(os.sched_getaffinity(0)) if options.core is None else options.core
    os.sched_setaffinity(0, {core})
    options.native = binary(options.native)
    print(machine(core))
    version = subprocess.run([options.native, "--version"], capture_output=True, check=True)
    print(f"{options.native}: {version.stdout.decode().strip()}")
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        (folder / "records").symlink_to(INPUT.parent / "records")
        start = measured(options, folder, 1, STEPS)
        report("output excluded", measured(options, folder, STEPS, STEPS), start)
        report("output included", measured(options, folder, STEPS, 1), start)
    print(f"start and input: {1e3 * min(start)[0]:.1f} ms")


def machine(core: int) -> str:
    """Return processor, system and load in one line."""
    speed = f"{float(processor('cpu MHz') or 'nan'):.0f} MHz"
    name = processor("model name") or platform.processor() or platform.machine()
    load = f"load {os.getloadavg()[0]:.1f}"
    return f"{name}, {speed}, core {core} of {os.cpu_count()}, {platform.platform()}, {load}"


def processor(entry: str) -> str:
    """Return the last value of an entry of /proc/cpuinfo, or ''."""
    matches = re.findall(rf"(?m)^{entry}\s*:\s*(.*)$", Path("/proc/cpuinfo").read_text())
    return matches[-1] if matches else ""


def measured(options, folder: Path, steps: int, interval: int) -> list[tuple[float, float]]:
    """Return the wall time and processor time of each repetition, s."""
    file = folder / "benchmark.nml"
    file.write_text(changed(INPUT.read_text(), steps, interval))
    command = [options.native, "run", str(file), "--quiet", "-o", str(folder / "benchmark.nc")]
    one_thread = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    times = []
    for _ in range(options.repeat):
        begun, used_before = time.perf_counter(), processor_time()
        subprocess.run(command, check=True, capture_output=True, env=os.environ | one_thread)
        times.append((time.perf_counter() - begun, processor_time() - used_before))
    return times


def processor_time() -> float:
    """Return the processor time of all ended child processes, s."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def changed(text: str, steps: int, interval: int) -> str:
    """Return the main job with other numbers of steps and samples, and without amplification."""
    text = re.sub(r"(?m)^&amplification.*$", "", text)
    for variable, value in (("steps", steps), ("history_interval", interval)):
        text, count = re.subn(rf"\b{variable}\s*=\s*\d+", f"{variable} = {value}", text)
        if count != 1:
            raise SystemExit(f"{INPUT}: expected one {variable}, found {count}")
    return text


def report(name: str, times: list, start: list) -> None:
    """Print wall time and processor time per step, without those of the start."""
    lines = []
    for kind, index in (("wall", 0), ("processor", 1)):
        micro = [1e6 * (run[index] - min(start)[index]) / STEPS for run in times]
        lines.append(f"{kind} {min(micro):.2f} (median {statistics.median(micro):.2f})")
    print(f"{name}: {', '.join(lines)} µs per step")


if __name__ == "__main__":
    main()
