#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Substitute for sbatch: runs the tasks of a job array here, in sequence or in random order.

usage: slurm_stand_in.py SCRIPT

STAND_IN_SEED: seed of a random order; STAND_IN_SIDE: number of simultaneous tasks.
"""

import os
import random
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path


def install(folder: Path) -> Path:
    """Write an sbatch into a folder for PATH, and return the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    program = folder / "sbatch"
    program.write_text(f'#!/bin/sh\nexec {sys.executable} {Path(__file__).resolve()} "$@"\n')
    program.chmod(0o755)
    return folder


def tasks_of(script: str) -> list[int]:
    """Return the indices of the job array of a script."""
    first, last = re.search(r"^#SBATCH --array=(\d+)-(\d+)$", script, re.MULTILINE).groups()
    return list(range(int(first), int(last) + 1))


def run_task(script: Path, index: int) -> int:
    """Run a task as Slurm does; repeat it while it is interrupted."""
    numbers = {"SLURM_ARRAY_TASK_ID": str(index), "SLURM_ARRAY_JOB_ID": "7"}
    return subprocess.run(["bash", str(script)], env=os.environ | numbers, check=False).returncode


def main() -> int:
    """Run the job array."""
    script = Path(sys.argv[1])
    tasks = tasks_of(script.read_text())
    if "STAND_IN_SEED" in os.environ:
        random.Random(int(os.environ["STAND_IN_SEED"])).shuffle(tasks)
    with ThreadPoolExecutor(int(os.environ.get("STAND_IN_SIDE", "1"))) as pool:
        statuses = list(pool.map(lambda index: run_task(script, index), tasks))
    print("Submitted batch job 7")
    print(f"{len(tasks)} tasks, {sum(map(bool, statuses))} not to their end")
    return 0


if __name__ == "__main__":
    sys.exit(main())
