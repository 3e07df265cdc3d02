#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Print the line coverage of fortran/ by the Fortran suites and the Python tests together.

usage: python tests/robustness/line_coverage.py [FOLDER]

Builds with gcov into FOLDER (kept; without it a temporary folder), runs all suites and
tests/python, and compares the unreached lines with the reasons in unreached_lines.md.
Ends with status 1 below 95 % or if a line has no reason.  Requires gcov and the test packages.
"""

import json
import os
import re
import subprocess
import sys
import tempfile
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
REASONS = Path(__file__).with_name("unreached_lines.md")
LEAST = 95.0  # percent
OPTIONS = "tester=true b_coverage=true buildtype=debug optimization=0 warning_level=0".split()
PROCEDURE = re.compile(
    r"^\s*(?!end\b)(?:[\w()=]+\s+)*(?:subroutine|function|program)\s+(\w+)", re.I
)


def build(folder: Path) -> None:
    """Build package, executable and suites with counters of lines."""
    if not (folder / "venv").exists():
        subprocess.run([sys.executable, "-m", "venv", folder / "venv"], check=True)
    settings = [f"-Csetup-args=-D{option}" for option in OPTIONS]
    pip = [folder / "venv" / "bin" / "pip", "install", "-q", f"-Cbuild-dir={folder / 'build'}"]
    subprocess.run([*pip, *settings, f"{ROOT}[test]"], check=True)


def run_tests(folder: Path) -> None:
    """Run all suites, then the Python tests; print failures, and continue."""
    for data_file in folder.rglob("*.gcda"):
        data_file.unlink()
    quiet = {"OMP_NUM_THREADS": "2", "OPENBLAS_NUM_THREADS": "1", "OMP_WAIT_POLICY": "passive"}
    quiet["FUZZ_TIME_LIMIT"] = "60"  # slower without optimisation and with counters
    quiet["GCOV_ERROR_FILE"] = os.devnull  # counters cannot be written in tests of a full disk
    path = f"{folder / 'venv' / 'bin'}{os.pathsep}{os.environ['PATH']}"
    quiet["SITEDDA_TEST_DATA"] = str(ROOT / "tests" / "data")
    environment = os.environ | quiet | {"PATH": path}
    suites = [folder / "build" / "tests" / "fortran" / "tester"]
    python = [folder / "venv" / "bin" / "python", "-m", "pytest", "-q", "-p", "no:cacheprovider"]
    # These complete runs are slow without optimisation and reach no other lines.
    slow = ["--ignore", ROOT / "tests" / "python" / "input" / "test_every_input.py"]
    for command in (suites, [*python, *slow, ROOT / "tests" / "python"]):
        options = {"cwd": folder, "env": environment, "capture_output": True, "text": True}
        process = subprocess.run(command, **options)
        print(process.stdout.strip().splitlines()[-1])
        if process.returncode:
            print(f"failed ({process.returncode}): {command[-1]}")


def line_counts(folder: Path) -> dict[Path, dict[int, int]]:
    """Return how often each line of fortran/ was executed."""
    counts: dict[Path, dict[int, int]] = defaultdict(dict)
    for data in sorted((folder / "build").rglob("*.gcda")):
        command = ["gcov", "--json-format", "--stdout", data]
        process = subprocess.run(command, cwd=folder / "build", capture_output=True, text=True)
        for record in process.stdout.splitlines():
            for entry in json.loads(record)["files"]:
                file = (folder / "build" / entry["file"]).resolve()
                if file.is_relative_to(ROOT / "fortran"):
                    lines = counts[file.relative_to(ROOT)]
                    for line in entry["lines"]:
                        number = line["line_number"]
                        lines[number] = max(lines.get(number, 0), line["count"])
    return counts


def reasons() -> dict[tuple[str, str], str]:
    """Return (file, procedure) -> reason of unreached lines, from unreached_lines.md."""
    rows = (row.split("|")[1:] for row in REASONS.read_text().splitlines() if row[:3] == "| `")
    return {
        (row[0].strip(" `"), name.strip(" `")): row[2].strip()
        for row in rows
        for name in row[1].split(",")
    }


def procedures_of(file: Path) -> list[str]:
    """Return the name of the procedure of each line."""
    names, name = [""], ""
    for text in (ROOT / file).read_text().splitlines():
        match = PROCEDURE.match(text.split("!")[0])
        name = match[1] if match else name
        names.append(name)
    return names


def report(counts: dict[Path, dict[int, int]]) -> int:
    """Print a row for each folder, and each line without a reason; return the exit status."""
    floors: dict[str, list[int]] = defaultdict(lambda: [0, 0])
    explanations, unexplained, used_reasons = reasons(), [], set()
    for file, lines in sorted(counts.items()):
        names, texts = procedures_of(file), (ROOT / file).read_text().splitlines()
        floor = floors[file.parts[1]]
        for number, count in sorted(lines.items()):
            if texts[number - 1].strip().startswith("end module"):
                continue  # copies of types, which the compiler generates
            floor[0] += count > 0
            floor[1] += 1
            location = (str(Path(*file.parts[1:])), names[number])
            if count == 0 and location in explanations:
                used_reasons.add(location)
            elif count == 0:
                text = texts[number - 1].strip()
                unexplained.append(f"{file}:{number} ({names[number]}): {text}")
    for name, (reached_lines, lines) in floors.items():
        percent = 100 * reached_lines / lines
        print(f"{name:10} {reached_lines:6} of {lines:6} lines {percent:6.1f} %")
    reached_lines, lines = (sum(floor[i] for floor in floors.values()) for i in (0, 1))
    percentage = 100 * reached_lines / lines
    print(f"{'all':10} {reached_lines:6} of {lines:6} lines {percentage:6.2f} %, least {LEAST}")
    explained_count = lines - reached_lines - len(unexplained)
    print(f"{explained_count} lines not reached are explained, {len(unexplained)} are not")
    print(*unexplained, sep="\n")
    for location in sorted(set(explanations) - used_reasons):
        print(f"unreached_lines.md explains {location[0]}, {location[1]}, which is reached")
    return int(percentage < LEAST or bool(unexplained))


def main() -> int:
    """Build, run, count, and compare."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(sys.argv[1] if len(sys.argv) > 1 else temporary).resolve()
        folder.mkdir(parents=True, exist_ok=True)
        build(folder)
        run_tests(folder)
        return report(line_counts(folder))


if __name__ == "__main__":
    sys.exit(main())
