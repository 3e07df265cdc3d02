#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Kill runs at random moments, resume them, and compare the outputs bitwise.

usage: python tests/robustness/kill.py [--kills N] [--seed S] [--signals KILL,TERM,USR1] [--quick]
       [--pages N] [--program PROGRAM] [--folder FOLDER]

Each case starts a run, sends it a signal at a random moment, and resumes it until it ends; one
resumed run in four is killed again.  The output must equal that of an uninterrupted run bitwise.
"spared" counts runs that end before their signal; "anew" counts runs that are killed before their
first checkpoint.  --pages N kills `sitedda view`, `report`, `movie` and `draw` N times (TERM, INT,
KILL); the older file or the complete new one must remain, and no other file except after KILL.
Ends with status 1 if any output differs.
"""

import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import interrupted as runs
from options import parse_options

INTERRUPTED = 6


ROW = (
    "{name:16s} {whole:7.2f} s {spared:7d} {kills:6d} {resumes:8d} {anew:6d} {identical:6d} of"
    " {cases}"
)
COUNTS = ("spared", "kills", "resumes", "anew", "identical", "cases")


def models(is_quick: bool) -> dict[str, str]:
    """Return inputs by name."""
    if is_quick:
        return {
            "layered site": runs.layered_site(6000, 100),
            "column": runs.column(0.5, 5),
            "wall": runs.wall(30, 2, bricks=6),
            "wall in stages": runs.staged_wall(10, 2, bricks=6),
            "wet wall": runs.wet_wall(10, 2, bricks=6),
        }
    return {
        "layered site": runs.layered_site(),
        "column": runs.column(),
        "wall of 200": runs.wall(300),
        "wall in stages": runs.staged_wall(100),
        "wet wall": runs.wet_wall(30, bricks=8),
    }


def attempt(program, command, folder, rng, run_time, signals, by_kill) -> tuple[int | None, str]:
    """Start the program once; return its status (None: killed) and its output."""
    running = runs.start(program, command, folder)
    if not by_kill:
        printed, errors = running.communicate()
        return running.returncode, printed + errors
    try:
        printed, errors = running.communicate(timeout=rng.uniform(0.0, run_time))
    except subprocess.TimeoutExpired:
        running.send_signal(rng.choice(signals))
        printed, errors = running.communicate()
    was_killed = running.returncode < 0 or running.returncode == INTERRUPTED
    return None if was_killed else running.returncode, printed + errors


def case(program, folder, rng, run_time, tally, signals, reference) -> None:
    """Kill a run once or more often, and count the outcomes."""
    for file in folder.glob("out.nc*"):
        file.unlink()
    command, kill = "run", True
    while True:
        status, message = attempt(program, command, folder, rng, run_time, signals, kill)
        if command == "resume":
            tally["resumes"] += 1
            tally["anew"] += "starting at time 0" in message
        if status == 0:
            break
        tally["cases"] += command == "run"
        if status is not None:
            print(f"{folder.name}: {command} ends with status {status}: {message}")
            return
        tally["kills"] += 1
        command, kill = "resume", rng.random() < 0.25
    if runs.same(folder.name, folder, reference):
        tally["spared" if command == "run" else "identical"] += 1


PAGES = {"view": "x.html", "report": "x.html", "movie": "x.gif", "draw": "x.png"}
PAGE_SIGNALS = (signal.SIGTERM, signal.SIGINT, signal.SIGKILL)


def kill_pages(folder: Path, output: Path, kills: int, rng: random.Random) -> list[str]:
    """Kill commands that show an output; return their forbidden remains."""
    wrong, count, durations = [], 0, dict.fromkeys(PAGES, 0.0)
    folder.mkdir()
    while count < kills:
        command = rng.choice(list(PAGES))
        target = folder / PAGES[command]
        arguments = [sys.executable, "-m", "sitedda", command, str(output), "-o", str(target)]
        arguments += ["--no-open"] if command == "view" else []
        arguments += ["-q", "--seconds", "2"] if command == "movie" else []
        if not durations[command]:
            begun = time.perf_counter()
            subprocess.run(arguments, check=True, stdout=subprocess.DEVNULL)
            durations[command] = time.perf_counter() - begun
        before = target.read_bytes()
        running = subprocess.Popen(arguments, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        number = rng.choice(PAGE_SIGNALS)
        try:
            running.communicate(timeout=durations[command] * rng.uniform(0.5, 1.0))
            continue
        except subprocess.TimeoutExpired:
            running.send_signal(number)
        _, message = running.communicate()
        count += 1
        left = [file.name for file in folder.glob(".new-*")]
        after = target.read_bytes()
        if after != before and not after.endswith((b"</html>\n", b";", b"IEND\xaeB`\x82")):
            wrong.append(f"{command}, {number.name}: half of {target.name}")
        if left and number != signal.SIGKILL:
            wrong.append(f"{command}, {number.name}: {left} remains: {message.decode()[-300:]}")
        for name in left:
            (folder / name).unlink()
    return wrong


def main() -> int:
    """Run the cases and print the table."""
    options = parse_options(
        __doc__, kills=100, seed=1, signals="KILL", quick=False, pages=0, program=str, folder=Path
    )
    program = runs.binary(options.program)
    signals = [signal.Signals[f"SIG{name}"] for name in options.signals.split(",")]
    rng = random.Random(options.seed)
    tallies = {}
    with tempfile.TemporaryDirectory() as scratch:
        selection = models(options.quick)
        for i, (name, text) in enumerate(selection.items()):
            folder = runs.prepare(Path(options.folder or scratch) / name.replace(" ", "_"), text)
            tally = tallies[name] = dict.fromkeys(COUNTS, 0)
            begun = time.perf_counter()
            reference = runs.reference_of(program, folder)
            run_time = tally["whole"] = time.perf_counter() - begun
            kills_so_far = options.kills * (i + 1) // len(selection)
            while sum(t["kills"] for t in tallies.values()) < kills_so_far:
                case(program, folder, rng, run_time, tally, signals, reference)
        wrong = kill_pages(Path(scratch) / "pages", reference, options.pages, rng)
        print(*wrong, f"pages: {options.pages} kills, {len(wrong)} wrong", sep="\n")
    print("model              whole    spared  kills  resumes   anew  identical")
    for name, tally in tallies.items():
        print(ROW.format(name=name, **tally))
    return int(bool(wrong) or any(t["identical"] < t["cases"] for t in tallies.values()))


if __name__ == "__main__":
    sys.exit(main())
