#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Run with less memory than required, in steps: each run must succeed, or report its requirement.

usage: python tests/robustness/memory_limits.py [--least MIB] [--most MIB] [--step MIB]
       [--solvers NAME …] [--cores NAME …] [--blocks N] [--program PROGRAM]

The limit on the address space of a process (ulimit -v) increases from run to run of a wall.  A run
must end with status 0, or with status 7 and one message; below some limit the system cannot load
the program and reports this.  Runs that end with a signal, a limit on processor time, or a message
of a compiler or library are printed, and the status is then 1.  --cores names processors whose
kernels OpenBLAS uses (OPENBLAS_CORETYPE): without AVX-512, all its products need a buffer.
"""

import collections
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent / "python")]

from environment import executable  # noqa: E402
from model_text import DRY, ROCK, group, namelist  # noqa: E402
from options import parse_options  # noqa: E402

MEBI = 2**20
SOLVERS = ["direct", "lagged", "jacobi"]
# Threads reserve random amounts of address space.
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
PROCESSOR_TIME = 60  # s; a run takes less than 1 s
NOT_LOADED = 127  # status of the dynamic linker
DONE, REFUSED, NOT_STARTED = "done", "refused", "not loaded"


def wall(blocks: int, solver: str, steps: int = 1) -> str:
    """Return a wall at rest, as wide as it is high."""
    side = int(blocks**0.5)
    return namelist(
        [
            group("control", time_step=1e-4, steps=steps, solver=solver),
            ("material", dict(ROCK)),
            ("joint", dict(DRY)),
            group("wall", brick_length=1.0, brick_height=0.5, bricks=side, courses=side),
            group("fixed_point", x=0.5, y=0.25),
        ]
    )


def limited(program, limit: int, *arguments, folder, core="") -> subprocess.CompletedProcess:
    """Run with `limit` bytes of address space, with kernels of a processor."""

    def limit_process() -> None:
        resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
        resource.setrlimit(resource.RLIMIT_CPU, (PROCESSOR_TIME, PROCESSOR_TIME))

    environment = os.environ | ONE_THREAD | ({"OPENBLAS_CORETYPE": core} if core else {})
    return subprocess.run([program, *arguments], cwd=folder, env=environment,
                          preexec_fn=limit_process, capture_output=True, text=True)  # fmt: skip


def outcome(process: subprocess.CompletedProcess) -> str:
    """Return the end of a run: one of the correct ends, or what is wrong, in words."""
    lines = process.stderr.splitlines()
    if process.returncode == 0 and not lines:
        return DONE
    if process.returncode == 7 and len(lines) == 1 and "GB of memory" in lines[0]:
        return REFUSED
    if process.returncode == NOT_LOADED and "shared libraries" in process.stderr:
        return NOT_STARTED
    return f"status {process.returncode}: {process.stderr.strip() or 'no message'}"


def sweep(program, limits, solver: str, blocks: int, folder: Path, core: str = "") -> list[str]:
    """Return the outcomes of runs of a wall under increasing limits (bytes)."""
    input_file = folder / "wall.nml"
    input_file.write_text(wall(blocks, solver))
    outcomes = []
    for limit in limits:
        process = limited(program, limit, "run", input_file.name, "-q", folder=folder, core=core)
        outcomes.append(outcome(process))
        if outcomes[-1] != DONE and (folder / "wall.nc").exists():
            outcomes[-1] += ", but there is an output"
        for left in folder.glob("wall.nc*"):
            left.unlink()
    return outcomes


def is_sound(outcomes: list[str]) -> bool:
    """Return whether all outcomes are correct, and more memory never worsens one."""
    order = [NOT_STARTED, REFUSED, DONE]
    return all(outcome in order for outcome in outcomes) and outcomes == sorted(
        outcomes, key=order.index
    )


def main() -> int:
    """Test solvers and processors, and print what is wrong."""
    options = parse_options(__doc__, least=100, most=360, step=1, solvers=SOLVERS,
                    cores=["Haswell", "SkylakeX"], blocks=2500, program=str)  # fmt: skip
    program = Path(options.program or executable("sitedda-native")).resolve()
    limits = [mib * MEBI for mib in range(options.least, options.most + 1, options.step)]
    has_failed = False
    with tempfile.TemporaryDirectory() as folder:
        for core in options.cores:
            for solver in options.solvers:
                outcomes = sweep(program, limits, solver, options.blocks, Path(folder), core)
                counts = collections.Counter(outcome.partition(":")[0] for outcome in outcomes)
                summary = ", ".join(f"{count} {kind}" for kind, count in counts.items())
                print(f"{core:10s} {solver:7s} {len(outcomes)} limits: {summary}", flush=True)
                has_failed = has_failed or not is_sound(outcomes)
                for limit, outcome in zip(limits, outcomes, strict=True):
                    if outcome not in (DONE, REFUSED, NOT_STARTED):
                        print(f"  {limit // MEBI} MiB: {outcome}", flush=True)
    return int(has_failed)


if __name__ == "__main__":
    sys.exit(main())
