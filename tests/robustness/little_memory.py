#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Commands under many memory limits: each succeeds, or ends with one sentence and status 7.

usage: python tests/robustness/little_memory.py [--limits N] [--least MB] [--most MB]
"""

import shutil
import sys
import tempfile
from collections import Counter
from pathlib import Path

import numpy as np
from memory_limits import MEBI, limited
from options import parse_options

INPUTS = Path(__file__).parents[2] / "inputs"
COMMANDS = {
    "run": ["run", "-q", "--no-plot", "column.nml", "--set", "duration=0.05"],
    "check": ["check", "column.nml"],
    "view": ["view", "column.nml", "--no-open"],
    "draw": ["draw", "column.nml"],
}


def outcome(arguments: list[str], megabytes: int, folder: Path) -> str:
    """Return what is wrong with the end of a command; empty if nothing is wrong."""
    program = Path(sys.executable).with_name("sitedda")
    process = limited(program, megabytes * MEBI, *arguments, folder=folder)
    if process.returncode == 0 or (
        process.returncode == 7 and len(process.stderr.splitlines()) == 1
    ):
        return ""
    return f"status {process.returncode}: {process.stderr[-500:]}"


def failures(limits, commands=COMMANDS) -> list[str]:
    """Return commands and limits (MiB) with a wrong end."""
    failed_runs, counts = [], Counter()
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(INPUTS / "column.nml", folder)
        for megabytes in limits:
            for name, arguments in commands.items():
                wrong = outcome(arguments, int(megabytes), Path(folder))
                counts[name] += 1
                if wrong:
                    failed_runs.append(f"{name} at {megabytes} MiB: {wrong}")
                    print(failed_runs[-1], flush=True)
    print(", ".join(f"{name} {count}" for name, count in counts.items()))
    return failed_runs


def main() -> int:
    """Try evenly spaced limits; return 0 if all commands end correctly."""
    options = parse_options(__doc__, limits=60, least=150, most=900)
    failed = failures(np.linspace(options.least, options.most, options.limits).astype(int))
    print(f"{len(failed)} of {4 * options.limits} end incorrectly")
    return int(bool(failed))


if __name__ == "__main__":
    sys.exit(main())
