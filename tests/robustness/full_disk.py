#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Run with a full disk at many moments, then resume with free space.

usage: python tests/robustness/full_disk.py [--cases N] [--program PROGRAM] [--quick]
       [--folder FOLDER]

A limit on file sizes, or a small file system in memory if the system permits it, interrupts the
writing of journal, checkpoint or output.  Each run must end with status 5 and one message, or
complete.  Resumed with free space, it must give the bits of an uninterrupted run.  Ends with status
1 otherwise.
"""

import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

from interrupted import binary, finish, layered_site, prepare, reference_of, same, wall
from options import parse_options

FILE_ERROR = 5


def limited(size: int):
    """Return a function that limits the size of files of a process."""

    def limit() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))

    return limit


def judge(kind, status, err, program, folder, reference) -> bool:
    """Return whether the run with a full disk ended correctly and the resumed run is complete."""
    is_reported = re.fullmatch(r".*out\.nc.*(File too large|No space left).*\n", err)
    if status not in (0, FILE_ERROR) or (status and not is_reported):
        print(f"{kind}: status {status}: {err}")
        return False
    if status:
        status, printed, err = finish(program, "resume", folder)
        if status:
            print(f"{kind}: resume ends with status {status}: {err}")
            return False
    return same(kind, folder, reference)


def by_file_size(program, folder, reference, cases) -> list[bool]:
    """Test limits from zero to the size of the output, closer together where files begin."""
    largest = reference.stat().st_size
    results = []
    for i in range(cases):
        size = int(largest * 1.05 * (i / max(1, cases - 1)) ** 2)
        for file in folder.glob("out.nc*"):
            file.unlink()
        status, _, err = finish(program, "run", folder, preexec_fn=limited(size))
        results.append(judge(f"limit {size}", status, err, program, folder, reference))
    return results


def by_file_system(program, folder, reference, cases) -> list[bool]:
    """Test file systems of several sizes; the resumed run has a larger one."""
    results = []
    largest = 4 * reference.stat().st_size
    for i in range(cases):
        size = 65536 + int(largest * i / cases)
        disk = folder / "disk"
        disk.mkdir(exist_ok=True)
        mounted = ["mount", "-t", "tmpfs", "-o", f"size={size}", "none", str(disk)]
        if subprocess.run(mounted, capture_output=True, check=False).returncode:
            return results
        try:
            shutil.copy(folder / "model.nml", disk)
            (disk / "records").symlink_to((folder / "records").resolve())
            status, _, err = finish(program, "run", disk)
            command = ["mount", "-o", f"remount,size={size + 2 * largest}", str(disk)]
            subprocess.run(command, check=True)
            results.append(judge(f"disk of {size}", status, err, program, disk, reference))
        finally:
            subprocess.run(["umount", str(disk)], check=True)
    return results


def main() -> int:
    """Run the cases and print how many passed."""
    options = parse_options(__doc__, cases=40, quick=False, program=str, folder=Path)
    program = binary(options.program)
    failed = 0
    models = {"layered site": layered_site(20000, 200), "wall": wall(100, 5, bricks=8)}
    if options.quick:
        models = {"layered site": layered_site(2000, 50)}
    with tempfile.TemporaryDirectory() as scratch:
        for name, text in models.items():
            folder = prepare(Path(options.folder or scratch) / name.replace(" ", "_"), text)
            reference = reference_of(program, folder)
            for kind, cases in (("file size", by_file_size), ("file system", by_file_system)):
                results = cases(program, folder, reference, options.cases)
                failed += results.count(False)
                print(f"{name:14s} {kind:12s} {results.count(True)} of {len(results)}")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
