#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Damage checkpoints and journals at random, and try to resume the runs.

usage: python tests/robustness/damage.py [--cases N] [--seed S] [--program PROGRAM]
       [--folder FOLDER]

A damaged checkpoint must be refused with a message (status 5), or the run must continue from the
previous checkpoint and end with identical bits.  A damaged checkpoint with a matching checksum
(only possible on purpose) must not crash or hang the engine.  Ends with status 1 otherwise.
"""

import lzma
import random
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

from interrupted import binary, difference, finish, prepare, reference_of, start, wall
from mutations import mutated_checkpoint
from options import parse_options

REFUSED = 5
HEAD, TAIL = 16, 16  # bytes of a checkpoint before and after its state
LONGEST = 30.0  # time limit of one case, s


def crc64(data: bytes) -> bytes:
    """Return the CRC-64/XZ at the end of a checkpoint, taken from the index of an .xz file."""
    file = lzma.compress(data, check=lzma.CHECK_CRC64, preset=0)
    index = 4 * (1 + int.from_bytes(file[-8:-4], "little"))  # bytes, in front of a footer of 12
    return file[-20 - index : -12 - index]


def interrupted_run(program: str, folder: Path) -> None:
    """Leave intact files of an interrupted run: a checkpoint, the previous one and a journal."""
    running = start(program, "run", folder)
    while not (folder / "out.nc.checkpoint.previous").exists():
        if running.poll() is not None:
            raise SystemExit(f"the run ended before it could be stopped: {running.communicate()}")
    running.terminate()
    running.communicate()


def case(program, folder, copies, reference, rng) -> tuple[str, str]:
    """Damage one file and resume; return the kind of damage, and what is wrong with the outcome."""
    for file in folder.glob("out.nc*"):
        file.unlink()
    for file in copies.iterdir():
        shutil.copy(file, folder)
    kind = rng.choices(("alone", "with previous", "journal", "forged"), (60, 15, 10, 15))[0]
    name = "out.nc.journal" if kind == "journal" else "out.nc.checkpoint"
    complete = (folder / name).read_bytes()
    seed = rng.randrange(2**31)
    if kind == "forged":
        state = mutated_checkpoint(seed, complete[HEAD:-TAIL])
        content = complete[:HEAD] + state + len(state).to_bytes(8, "little")
        (folder / name).write_bytes(content + crc64(content))
    else:
        (folder / name).write_bytes(mutated_checkpoint(seed, complete))
    if kind in ("alone", "forged"):
        (folder / "out.nc.checkpoint.previous").unlink()
    return kind, outcome(program, folder, kind, reference)


def outcome(program, folder, kind, reference) -> str:
    """Return what is wrong with a resumed run; empty if nothing is wrong."""
    try:
        status, output, err = finish(program, "resume", folder, timeout=LONGEST)
    except subprocess.TimeoutExpired:
        return "hangs"
    if status < 0 or "Fortran runtime error" in err or "SIG" in err:
        return f"crashes: {status} {err}"
    if kind == "forged":
        return ""
    if status == REFUSED and kind in ("alone", "journal"):
        return "" if len(err.strip().splitlines()) == 1 else f"says {err}"
    if status:
        return f"status {status}: {err}"
    if kind == "alone":
        return "a damaged checkpoint is accepted"
    if kind == "with previous" and "checkpoint.previous, because" not in output:
        return f"does not report the use of the previous checkpoint: {output}"
    wrong = difference(folder / "out.nc", reference)
    return f"{wrong} differs" if wrong else ""


def main() -> int:
    """Run the cases and count their outcomes."""
    options = parse_options(__doc__, cases=1000, seed=1, program=str, folder=Path)
    program = binary(options.program)
    rng = random.Random(options.seed)
    counts, failures = Counter(), 0
    with tempfile.TemporaryDirectory() as scratch:
        folder = prepare(Path(options.folder or scratch) / "run", wall(2000, 2, bricks=1))
        reference = reference_of(program, folder)
        interrupted_run(program, folder)
        copies = folder.with_name("kept")
        copies.mkdir(exist_ok=True)
        for file in folder.glob("out.nc*"):
            file.rename(copies / file.name)
        for i in range(options.cases):
            kind, wrong = case(program, folder, copies, reference, rng)
            counts[kind] += 1
            if wrong:
                failures += 1
                print(f"case {i}: {kind}: {wrong}")
    print(", ".join(f"{count} {kind}" for kind, count in sorted(counts.items())))
    print(f"{options.cases - failures} of {options.cases} are correct")
    return int(failures > 0)


if __name__ == "__main__":
    sys.exit(main())
