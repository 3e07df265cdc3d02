#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Commands under many limits of memory: each ends well, or in one sentence with status 7.

usage: python tests/robustness/little_memory.py [--limits N] [--least MB] [--most MB]
"""

import shutil
import sys
import tempfile
from collections import Counter
from pathlib import Path

import numpy as np
from memory_limits import MEBI, limited
from options import asked

INPUTS = Path(__file__).parents[2] / "inputs"
COMMANDS = {
    "run": ["run", "-q", "--no-plot", "column.nml", "--set", "duration=0.05"],
    "check": ["check", "column.nml"],
    "view": ["view", "column.nml", "--no-open"],
    "draw": ["draw", "column.nml"],
}


def outcome(words: list[str], megabytes: int, folder: Path) -> str:
    """What is wrong with how a command ends; blank if nothing is."""
    program = Path(sys.executable).with_name("sitedda")
    done = limited(program, megabytes * MEBI, *words, folder=folder)
    if done.returncode == 0 or (done.returncode == 7 and len(done.stderr.splitlines()) == 1):
        return ""
    return f"status {done.returncode}: {done.stderr[-500:]}"


def failures(limits, commands=COMMANDS) -> list[str]:
    """Commands and limits (MiB) that end otherwise."""
    found, counts = [], Counter()
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(INPUTS / "column.nml", folder)
        for megabytes in limits:
            for name, words in commands.items():
                wrong = outcome(words, int(megabytes), Path(folder))
                counts[name] += 1
                if wrong:
                    found.append(f"{name} at {megabytes} MiB: {wrong}")
                    print(found[-1], flush=True)
    print(", ".join(f"{name} {count}" for name, count in counts.items()))
    return found


def main() -> int:
    """Try limits, evenly spread; 0 if all end as they should."""
    options = asked(__doc__, limits=60, least=150, most=900)
    found = failures(np.linspace(options.least, options.most, options.limits).astype(int))
    print(f"{len(found)} of {4 * options.limits} end otherwise")
    return int(bool(found))


if __name__ == "__main__":
    sys.exit(main())
