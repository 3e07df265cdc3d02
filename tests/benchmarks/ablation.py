# SPDX-License-Identifier: GPL-3.0-or-later
"""Savings by each remedy and constant of the iteration: python tests/benchmarks/ablation.py BUILD

BUILD is a complete Meson build folder of this tree, with -Djoint_object=false. Each variant is the
engine without one remedy, or with one constant halved or doubled: only its file is recompiled and
linked with the objects of BUILD, which does not change. All variants run the same cases, each in
its own process with one thread. Printed for each variant are ratios to the unchanged engine over
all cases: open–close iterations, factors, applications of the preconditioner, processor time; and
cases that end differently or take five times as long. Counts do not depend on the machine; the time
does.
--quick selects the small cases, --hard 96 walls with long steps,
--only WORD … the variants whose names contain a WORD; --jobs N runs N cases simultaneously.
"""

import json
import os
import re
import resource
import shlex
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from threading import Lock

import xarray as xr
from common import ROOT, changed, parse_options
from compare import SINGLE, resting, settling, shaken
from speed_models import FRICTION_ANGLE, packing, touching_wall, wall

DYNAMICS, ALGEBRA = ROOT / "fortran" / "dynamics", ROOT / "fortran" / "algebra"
OPEN_CLOSE = DYNAMICS / "open_close.f90"
JOINT_CONTACT = ROOT / "fortran" / "contact" / "joint_contact.f90"
# Files of the iteration; the numbers among their parameters are varied, except `_FIXED`.
FILES = [
    OPEN_CLOSE,
    JOINT_CONTACT,
    *(DYNAMICS / f"{name}.f90" for name in (
        "line_search", "friction_bounds", "static_relaxation", "slide_forces",
        "damage_passes", "contact_terms", "local_iteration",
    )),
    ALGEBRA / "krylov" / "anderson.f90",
    ALGEBRA / "krylov" / "conjugate_gradients.f90",
    ALGEBRA / "cholesky" / "low_rank.f90",
    ALGEBRA / "solvers" / "lagged_solver.f90",
    ALGEBRA / "solvers" / "factor_solver.f90",
    ALGEBRA / "solvers" / "linear_solver.f90",
]  # fmt: skip
READING = Lock()  # netCDF supports one reader at a time
_FIXED = ("none", "is_clean", "is_dirty_force", "is_dirty_stiffness", "long")
_CONSTANT = re.compile(
    r"^\s+(?:integer|real\(wp\)), parameter :: (\w+) = ([0-9.]+)((?:e[-+]?\d+)?)(_wp)?\b", re.M
)


@dataclass(frozen=True)
class Remedy:
    """The text of a file with a remedy, and its replacement without the remedy."""

    file: Path
    old: str
    new: str


REMEDIES = {
    "prediction of d": Remedy(
        DYNAMICS / "time_step.f90",
        "call predict(simulation%blocks, simulation%system%d, next_step(simulation))\n",
        "simulation%system%d = 0.0_wp\n",
    ),
    "loose solves": Remedy(OPEN_CLOSE, "loose_residual = 1.0e-2_wp", "loose_residual = 0.0_wp"),
    "slide forces solved in part": Remedy(
        OPEN_CLOSE, "friction_reduction = 0.2_wp", "friction_reduction = 0.0_wp"
    ),
    "Anderson acceleration of slide forces": Remedy(
        DYNAMICS / "slide_forces.f90",
        "call accelerate(slides%memory, slides%force(:slides%n), slides%response(:slides%n))",
        "slides%force(:slides%n) = slides%response(:slides%n)",
    ),
    "Illinois": Remedy(DYNAMICS / "line_search.f90", "= 0.5_wp*slope_", "= 1.0_wp*slope_"),
    "line search": Remedy(
        OPEN_CLOSE, "alpha = 1.0_wp\n", "alpha = 1.0_wp\n      if (alpha > 0.0_wp) return\n"
    ),
    "stiffness retained by contact": Remedy(
        OPEN_CLOSE, "by_contact = iteration%shortened .or.", "by_contact = n < 0 .and."
    ),
    "fraction retained by all": Remedy(
        OPEN_CLOSE, "iteration%overshoots >= most_overshoots", "n < 0 .and. n >= 4"
    ),
    "outer iteration for friction bounds": Remedy(
        OPEN_CLOSE, "by_bounds = iteration%rounds > 0", "by_bounds = .false."
    ),
    "diverging friction sticks": Remedy(
        OPEN_CLOSE, "if (diverged > 0) then", "if (diverged > huge(1) - 1) then"
    ),
    "states kept within the tolerance": Remedy(
        OPEN_CLOSE, "keeps_states = most_changes <", "keeps_states = huge(1) <"
    ),
    "closing contacts slide first": Remedy(
        JOINT_CONTACT, "most_closings = 8", "most_closings = 8000"
    ),
    "static relaxation": Remedy(
        DYNAMICS / "static_relaxation.f90", "many_changes = 2000", "many_changes = huge(1)"
    ),
    "regions of their own": Remedy(
        DYNAMICS / "local_iteration.f90", "most_blocks = 0.4_wp", "most_blocks = 0.0_wp"
    ),
    "low-rank update": Remedy(
        ALGEBRA / "cholesky" / "low_rank.f90", "success = changes%n <=", "success = changes%n == 0*"
    ),
    "kept factor": Remedy(
        ALGEBRA / "solvers" / "lagged_solver.f90", "factor_cost = 8 ", "factor_cost = -1 "
    ),
}  # fmt: skip


def cases(is_quick: bool) -> dict[str, tuple]:
    """Return the function that writes the input of each case, and the number of steps."""
    table = {}
    for ms, steps in ((1, 120), (5, 60)):
        for blocks in (200, 400, 800) if is_quick else (200, 300, 400, 600, 800, 1000):
            name = f"{blocks} at {ms} ms"
            table[f"shaken {name}"] = (partial(shaken, blocks, ms * 1e-3), steps)
            if is_quick and blocks == 800:
                continue
            fewer_steps = steps // 4
            table[f"settling {name}"] = (partial(settling, touching_wall, blocks, ms * 1e-3),
                                         fewer_steps)  # fmt: skip
            table[f"packing {name}"] = (partial(settling, packing, blocks, ms * 1e-3), fewer_steps)
    for blocks in (1000,) if is_quick else (1000, 3000, 10_000):
        table[f"sudden {blocks}"] = (partial(settling, touching_wall, blocks, 1e-3), 5)
        table[f"rest {blocks}"] = (partial(resting, blocks), 1)
    if not is_quick:
        table["quiet 3000"] = (partial(settling, wall, 3000, 1e-3), 60)
        table["shaken 10000"] = (partial(shaken, 10_000, 1e-3), 160)
    return table


def hard_cases() -> dict[str, tuple]:
    """Walls with long steps and friction angles from small to large."""
    table = {}
    for ms, steps in ((10, 60), (20, 30)):
        for blocks in (110, 150, 200, 250, 300, 350, 400, 450):
            for angle in (15, 25, 35, 45, 60, 75):
                name = f"shaken {blocks} at {ms} ms, {angle} degrees"
                table[name] = (partial(with_friction, blocks, ms * 1e-3, angle), steps)
    return table


def with_friction(blocks: int, time_step: float, angle: int) -> str:
    """Return the input of a shaken wall with this friction angle."""
    return shaken(blocks, time_step).replace(
        f"friction_angle = {FRICTION_ANGLE} ", f"friction_angle = {angle} "
    )


@dataclass
class Engine:
    """An executable whose variants differ in one file."""

    build: Path
    folder: Path

    def variant(self, source: Path, text: str) -> Path:
        """Build the executable with this text instead of a source file."""
        name = source.relative_to(ROOT)
        commands = json.loads((self.build / "compile_commands.json").read_text())
        (command,) = (
            c["command"] for c in commands
            if c["file"].endswith(str(name)) and "sitedda_engine" in c["output"]
        )  # fmt: skip
        changed_file, object_file = self.folder / source.name, self.folder / "changed.o"
        changed_file.write_text(text)
        arguments = shlex.split(command)
        arguments[arguments.index("-o") + 1] = str(object_file)
        arguments[arguments.index("-c") + 1] = str(changed_file)
        arguments = [f"-J{self.folder}" if w.startswith("-J") else w for w in arguments]
        folder_of_modules = next((w[2:] for w in shlex.split(command) if w.startswith("-J")), ".")
        subprocess.run(
            [*arguments, f"-I{folder_of_modules}"], cwd=self.build, check=True, capture_output=True
        )
        files = subprocess.run(
            ["ninja", "-t", "commands", "sitedda-native"], cwd=self.build, check=True,
            capture_output=True, text=True,
        ).stdout.splitlines()  # fmt: skip
        arguments = shlex.split(files[-1])
        program = self.folder / "native"
        arguments[arguments.index("-o") + 1] = str(program)
        # Before the library, which contains the original.
        arguments.insert(arguments.index("-o") + 2, str(object_file))
        subprocess.run(arguments, cwd=self.build, check=True, capture_output=True)
        return program


def run(program: Path, file: Path, before: dict | str = "") -> dict | str:
    """Return the counts of one run, or its error message."""
    output = program.with_name(file.with_suffix(".nc").name)
    command = [str(program), "run", str(file), "--quiet", "-o", str(output)]
    process = subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
        env=os.environ | SINGLE,
    )  # fmt: skip
    if isinstance(before, dict):
        limit = 1 + int(5 * before["seconds"])
        resource.prlimit(process.pid, resource.RLIMIT_CPU, (limit, limit))
    text = process.stderr.read().strip()
    _, status, resources = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if os.WIFSIGNALED(status):
        return "takes too long"
    if status:
        return text.splitlines()[-1][:70] if text else f"status {process.returncode}"
    with READING, xr.open_dataset(output) as data:
        solver_counts = list(map(int, re.findall(r"\d+", data.attrs["solver"])))
        iterations = int(data.iterations.sum())
    output.unlink()
    return {"iterations": iterations, "factors": solver_counts[1], "applications": solver_counts[2],
            "seconds": resources.ru_utime + resources.ru_stime}  # fmt: skip


def written(texts: dict[str, str], folder: Path) -> dict[str, Path]:
    """Write the inputs; return their files by name."""
    files = {name: folder / f"{i}.nml" for i, name in enumerate(texts)}
    for name, file in files.items():
        file.write_text(texts[name])
    return files


def measured(program: Path, files: dict[str, Path], jobs: int, before: dict) -> dict:
    """Return the result of `run` for each input; `before` has the results of another engine."""
    with ThreadPoolExecutor(jobs) as pool:
        results = pool.map(lambda name: run(program, files[name], before.get(name, "")), files)
        return dict(zip(files, results, strict=True))


def variants(prefixes: list[str]) -> dict[str, tuple[Path, str]]:
    """Return file and new text of each variant whose name contains one of the words."""
    table = {}
    for name, remedy in REMEDIES.items():
        text = remedy.file.read_text()
        if remedy.old not in text:
            raise SystemExit(f"{remedy.file}: expected {remedy.old!r}")
        table[f"without: {name}"] = (remedy.file, text.replace(remedy.old, remedy.new))
    for file in FILES:
        text = file.read_text()
        for match in _CONSTANT.finditer(text):
            name, number, power, kind = match.groups()
            if name in _FIXED or float(number) == 0:
                continue
            for suffix, factor in (("halved", 0.5), ("doubled", 2.0)):
                value = float(number) * factor
                literal = f"{value!r}{power}_wp" if kind else str(max(1, int(value)))
                label = f"{file.stem}: {name} {suffix}"
                start, end = match.span(2)[0], match.end()
                table[label] = (file, text[:start] + literal + text[end:])
    return {k: v for k, v in table.items() if any(w in k for w in prefixes)}


def row(name: str, results: dict, before: dict) -> str:
    """Return a table row: ratios over the cases that both engines complete, and the others."""
    common_cases = [c for c in before if {type(before[c]), type(results[c])} == {dict}]
    ratios = []
    for key in ("iterations", "factors", "applications", "seconds"):
        sum_of_cases = sum(before[c][key] for c in common_cases)
        ratios.append(
            sum(results[c][key] for c in common_cases) / sum_of_cases
            if sum_of_cases
            else float("nan")
        )
    changes = [
        f"{c}: {results[c]}" for c in before if c not in common_cases and results[c] != before[c]
    ]
    numbers = " | ".join(f"{ratio:.3f}" for ratio in ratios)
    return f"| {name} | {numbers} | {'; '.join(changes)} |"


def main() -> None:
    """Run the unchanged engine, then all variants."""
    options = parse_options(__doc__, "build", quick=False, hard=False, only=[""], jobs=1)
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        selection = hard_cases() if options.hard else cases(options.quick)
        texts = {name: changed(text(), steps, 1) for name, (text, steps) in selection.items()}
        files = written(texts, folder)
        engine = Engine(options.build.resolve(), folder)
        build_folder = folder / "own"
        build_folder.mkdir()
        (build_folder / "native").symlink_to(options.build.resolve() / "sitedda-native")
        before = measured(build_folder / "native", files, options.jobs, {})
        for name, result in before.items():
            print(f"{name:30s} {result}", flush=True)
        print("\n| variant | iterations | factors | applications | time | ends differently |")
        print("| --- | --- | --- | --- | --- | --- |")
        for name, (file, text) in variants(options.only).items():
            results = measured(engine.variant(file, text), files, options.jobs, before)
            print(row(name, results, before), flush=True)


if __name__ == "__main__":
    sys.exit(main())
