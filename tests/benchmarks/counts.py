#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Instructions of five models against the counts in counts.json: counts.py [--write].

Builds the executable for any x86-64 processor in a temporary folder, and counts the instructions
of the steps of each model by callgrind, on one thread: those of a run minus those of a shorter
run.  Ends with status 1 if a model needs more than 2 % more instructions than the file states.
Counts of another compiler differ; --write replaces the file by the present counts.
Requires meson, ninja and valgrind (apt-get install valgrind).
"""

import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from common import INPUT, ROOT, changed, parse_options
from compare import SINGLE, cases

FILE = Path(__file__).with_suffix(".json")
STEPS = {  # steps of the run, and of the shorter run
    "main job": (1500, 500),
    "column 11": (1500, 500),
    "quiet 1000": (40, 10),
    "shaken 400 at 1 ms": (60, 20),
    "settling 400 at 1 ms": (30, 10),
}
TOLERANCE = 0.02  # permitted increase


def count(engine: Path, file: Path) -> int:
    """Return the number of instructions of a run."""
    command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={os.devnull}", str(engine)]
    command += ["run", str(file), "--quiet", "-o", str(file.with_suffix(".nc"))]
    # Without this variable, OpenBLAS chooses its kernels by the processor.
    environment = os.environ | SINGLE | {"OPENBLAS_CORETYPE": "Haswell"}
    run = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    return read_count(run.stderr)


def read_count(report: str) -> int:
    """Return the number of instructions in a report of callgrind."""
    return int(re.search(r"I\s+refs:\s+([\d,]+)", report)[1].replace(",", ""))


def count_steps(engine: Path, folder: Path) -> dict[str, int]:
    """Return the number of instructions per step of all models."""
    (folder / "records").symlink_to(INPUT.parent / "records")
    counts, table = {}, cases()
    for name, steps in STEPS.items():
        totals = []
        for number in steps:
            file = folder / f"{number}.nml"
            file.write_text(changed(table[name].text(), number, 1))
            totals.append(count(engine, file))
        counts[name] = (totals[0] - totals[1]) // (steps[0] - steps[1])
        print(f"{name}: {counts[name]:,} instructions per step", flush=True)
    return counts


def build(folder: Path) -> Path:
    """Build the executable without instructions of this processor; return it."""
    options = ["-Dpython=false", "-Dnative_arch=false"]
    for command in (["meson", "setup", folder, ROOT, *options], ["ninja", "-C", folder]):
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return folder / "sitedda-native"


def compiler() -> str:
    """Return the version of gfortran."""
    command = ["gfortran", "-dumpfullversion"]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()


def excesses(counts: dict[str, int], stated: dict[str, int]) -> list[str]:
    """Return a line for each model with too many instructions, or that the file does not state."""
    lines = []
    for name, number in counts.items():
        if name not in stated:
            lines.append(f"{name}: {FILE.name} states no count; --write adds it")
        elif number > (1 + TOLERANCE) * stated[name]:
            excess = number / stated[name] - 1
            lines.append(f"{name}: {number:,} instructions per step, {excess:.1%} more than stated")
    return lines


def main() -> int:
    """Count, then compare or write."""
    options = parse_options(__doc__, write=False)
    kept = json.loads(FILE.read_text())
    if not options.write and kept["compiler"] != compiler():
        sys.exit(f"{FILE.name} holds counts of gfortran {kept['compiler']}; this is {compiler()}")
    with tempfile.TemporaryDirectory() as folder:
        counts = count_steps(build(Path(folder) / "build"), Path(folder))
    if options.write:
        FILE.write_text(json.dumps({"compiler": compiler(), "counts": counts}, indent=1) + "\n")
        return 0
    lines = excesses(counts, kept["counts"])
    print(*lines, f"{len(lines)} of {len(counts)} models are slower", sep="\n")
    return min(len(lines), 1)


if __name__ == "__main__":
    sys.exit(main())
