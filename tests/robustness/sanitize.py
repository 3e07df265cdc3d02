#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Test suites, hostile files and short runs under checks for hidden errors.

usage: python tests/robustness/sanitize.py [checked] [sanitized] [valgrind]      (default: all)

checked     no optimisation, -fcheck=all, traps for invalid, division by zero and overflow
sanitized   address and undefined-behaviour sanitizers, leaks included
valgrind    memcheck of a short layered site, leaks included; no suppressions are needed

Each builds into a temporary folder.  Requires meson and ninja; valgrind for the third (apt-get
install valgrind).  Ends with status 1 if errors are found.
"""

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(HERE))

from fuzz import fuzz  # noqa: E402

CHECKS = "-fcheck=all,no-array-temps -ffpe-trap=invalid,zero,overflow"
SETUPS = {
    "checked": ["-Dbuildtype=custom", "-Ddebug=true", "-Doptimization=0",
                f"-Dfortran_args={CHECKS}"],
    "sanitized": ["-Dbuildtype=debug", "-Doptimization=1", "-Db_sanitize=address,undefined",
                  "-Db_lundef=false"],
    "valgrind": ["-Dbuildtype=debug", "-Doptimization=1", "-Dnative_arch=false"],
}  # fmt: skip
HOSTILE = {"input": 500, "record": 500}  # number of files for each probe
COMPLAINT = re.compile(r"runtime error|AddressSanitizer|LeakSanitizer|^==\d+== [^E]", re.MULTILINE)
QUIET = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "OMP_WAIT_POLICY": "passive"}
SANITIZERS = {
    "ASAN_OPTIONS": "detect_leaks=1:halt_on_error=1",
    "UBSAN_OPTIONS": "print_stacktrace=1:halt_on_error=1",
    "SITEDDA_TEST_DATA": str(ROOT / "tests" / "data"),
}


def call(*command, folder: Path) -> tuple[int, str]:
    """Return status and complete output of a command."""
    process = subprocess.run([str(argument) for argument in command], cwd=folder,
                             env=os.environ | QUIET | SANITIZERS, stdout=subprocess.PIPE,
                             stderr=subprocess.STDOUT, encoding="utf-8", errors="replace",
                             check=False)  # fmt: skip
    return process.returncode, process.stdout


def build(kind: str, folder: Path) -> None:
    """Make a native build with tester and probe."""
    options = ["-Dpython=false", "-Dtester=true", "-Dwarning_level=0", *SETUPS[kind]]
    for command in (["meson", "setup", folder, ROOT, *options], ["ninja", "-C", folder]):
        status, output = call(*command, folder=ROOT)
        if status:
            sys.exit(f"{kind}: the build failed\n{output[-3000:]}")


def short_site(folder: Path) -> Path:
    """Return the layered site with few steps."""
    text = (ROOT / "inputs" / "layered_site.nml").read_text()
    text = re.sub(r"^\s*(steps|duration)\s*=.*$", "   steps = 20", text, flags=re.MULTILINE)
    text = text.replace("records/", f"{ROOT}/inputs/records/")
    file = folder / "short_site.nml"
    file.write_text(text)
    return file


def run(kind: str, folder: Path) -> list[str]:
    """Run all checks of one kind; return the errors."""
    build(kind, folder)
    native = [folder / "sitedda-native", "run", short_site(folder), "--output", folder / "site.nc"]
    if kind == "valgrind":
        options = "-q --error-exitcode=9 --leak-check=full --errors-for-leak-kinds=definite".split()
        return judge("layered site", *call("valgrind", *options, *native, folder=folder))
    faults = judge("suites", *call(folder / "tests" / "fortran" / "tester", folder=folder))
    faults += judge("layered site", *call(*native, folder=folder))
    for name_of_kind, count in HOSTILE.items():
        probe = [str(folder / "tests" / "fortran" / "probe")]
        tally = fuzz(probe, name_of_kind, range(count), limit=30.0, limit_memory=kind == "checked")
        print(f"{kind}: {count} hostile {name_of_kind}s: {tally}")
        faults += tally.failures
    return faults


def judge(kind: str, status: int, output: str) -> list[str]:
    """Print and return the errors that a command reports."""
    lines = output.strip().splitlines()
    print(f"{kind}: status {status}, {lines[-1] if lines else ''}")
    has_failed = status != 0 or COMPLAINT.search(output)
    return [f"{kind}: status {status}\n{output[-3000:]}"] if has_failed else []


def main() -> int:
    """Run all requested kinds."""
    kinds = sys.argv[1:] or list(SETUPS)
    if set(kinds) - set(SETUPS):
        sys.exit(__doc__)
    faults = []
    for kind in kinds:
        with tempfile.TemporaryDirectory() as folder:
            faults += run(kind, Path(folder))
    print(*faults, sep="\n")
    print(f"{len(faults)} errors found")
    return min(len(faults), 1)


if __name__ == "__main__":
    sys.exit(main())
