# SPDX-License-Identifier: GPL-3.0-or-later
"""What a user waits for besides the steps: python tests/benchmarks/startup.py [FOLDER]

Import, help, and the main job by Python over that by the executable; the programs are those in
FOLDER, by default those beside this Python.  `--before FOLDER` takes the programs of another
environment in turns with them.  Medians of the clock and of the processors, since the machine may
be busy.
"""

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from layered_site import processor_time

ROOT = Path(__file__).resolve().parents[2]
SINGLE = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
RUN = ("run", str(ROOT / "inputs" / "layered_site.nml"), "-q", "-o", "out.nc")
COMMANDS = {
    "import sitedda": ("python", "-c", "import sitedda"),
    "sitedda --help": ("sitedda", "--help"),
    "main job, Python with its picture": ("sitedda", *RUN),
    "main job, Python without": ("sitedda", *RUN, "--no-plot"),
    "main job, executable": ("sitedda-native", *RUN),
}


def main() -> None:
    """Measure in turns, then print."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("programs", nargs="?", type=Path, default=Path(sys.executable).parent)
    parser.add_argument("--before", type=Path, help="programs to compare with")
    parser.add_argument("--repeat", type=int, default=7)
    options = parser.parse_args()
    places = [options.programs] + ([options.before] if options.before else [])
    times = {(place, name): [] for name in COMMANDS for place in places}
    for _ in range(options.repeat):
        for (place, name), found in times.items():
            found.append(seconds(place, COMMANDS[name]))
    for (place, name), found in times.items():
        clock, processor = map(statistics.median, zip(*found, strict=True))
        print(f"{name:34} {clock:7.3f} s, processors {processor:7.3f} s   {place}")


def seconds(place: Path, command) -> tuple[float, float]:
    """Of the clock and of the processors."""
    with tempfile.TemporaryDirectory() as folder:
        begun, worked = time.perf_counter(), processor_time()
        program = [str((place / command[0]).absolute()), *command[1:]]
        subprocess.run(
            program, cwd=folder, env=os.environ | SINGLE, check=True, capture_output=True
        )
        return time.perf_counter() - begun, processor_time() - worked


if __name__ == "__main__":
    main()
