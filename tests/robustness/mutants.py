#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Change the engine in one place at a time, and test whether the tests detect the change.

usage: python tests/robustness/mutants.py FOLDER [--seed N] [--mutants N] [--first I]
       [--limit SECONDS] [--list]

A mutant is the engine with one change: a named constant doubled or halved, a number of a formula
doubled or halved, or one sign or factor of a formula inverted (a third of each), drawn from all
places of fortran/ except `EXCLUDED`.  Each is built in FOLDER, a copy of the tree that is kept, so
that only dependants of the changed file are compiled.  The Fortran suites and the Python tests run,
the most relevant tests first, until one fails or LIMIT seconds have passed (--limit 0: no limit;
--first: index of the first mutant; --list: print the mutants only).  Tests that killed a mutant are
repeated on the unchanged engine: a test that fails there has killed nothing.  Ends with status 1
if less than `LEAST` of the mutants are killed.
"""

import math
import os
import random
import re
import shutil
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path

from options import parse_options

ROOT = Path(__file__).resolve().parents[2]
LEAST = 35 / 40  # least fraction of killed mutants
REFUSED = "the compiler rejects it: no mutant"
HANG = 600  # s: a suite or test that takes longer has detected the mutant
SEARCHES = r"""dynamics/(line_search|static_relaxation|slide_forces|friction_bounds|damage_passes
|cycles)\.f90|dynamics/open_close\.f90:retain""".replace("\n", "")
WAYS = r"""dynamics/(open_close|time_step|contact_terms|contact_search)\.f90
|course/(equilibrium|running_maxima)\.f90|elements/strain_points\.f90|soil/shear_column\.f90
|checks/(modes|reduced_model|unresolved|omega_max)\.f90""".replace("\n", "")
# Excluded places with reason: "folder/file.f90:constant or procedure:kind value".
EXCLUDED = {
    "messages, files, system calls: no formula of a model": r"(base|app|platform|facade)/",
    "methods for the same result: a solution with a large residual is refused": r"algebra/",
    "path of an iteration, not its solution: see tests/benchmarks/ablation.py": (
        rf"({SEARCHES})|({WAYS}).*:(constant|number) "
    ),
    "thresholds of rounding or infinity, far from values of models": (
        r".*:(constant|number) (\d\.0e-([6-9]|1\d)_wp|1\.0e[6-9]_wp)"
    ),
    "integers that name states and columns, or are sizes of tables": (
        r".*:(?!m(ax|in|ost)_|least_|bending_cells|reported_|few_|many_)\w+:constant \d+(_long)?$"
    ),
    "bounds that models, memory or iterations do not reach": (
        r".*:(m(ax|ost)_(blocks|away|samples|points|pairs|names(?!_listed)|comments|vectors"
        r"|expansions|passes|halvings|header\w*|columns|springs|steps|rounds|iterations|vertices"
        r"|cells|fits|distance|period|value|step_ratio)\w*"
        r"|(largest|longest|farthest|usable|never|many|few|buffer|step|library|call|worth|unknown"
        r"|band_margin)\w*):constant"
    ),
    "limits between a series and its formula: both exact": r".*:(small|small_step):constant",
    "practically rigid: more stiffness changes nothing": r".*:(rigid|unyielding|rigidity):constant",
    "path of a search or fit, or more than it requires": (
        r".*:(stride|stiffest|golden|ray_fraction|half_edge|both_sides|sum_weight|min_weight"
        r"|small_misfit|target_misfit|first_force_ratio|slack|gain_allowed|zero_gap"
        r"|steepest\w*):constant"
    ),
    "pairs to be examined: more than those in contact": r"contact/neighbours\.f90",
    "corners of cells: distances of edge ends are far from 1e-6": r"model/weld\.f90:end_tolerance:",
    "positions in files: with a wrong one there is no output": (
        r"output/(journal|output_file|output_reader|contact_table|frame|sample|output_place)\.f90"
        r"|input/(block_file|classic_header|input_text|input_value|input_group)\.f90"
        r"|records/text_(lines|numbers)\.f90|state/"
    ),
}
UNUSED = ("test_lint", "test_ablation", "test_package", "test_handbook", "test_live_page")
NUMBER = r"(?<![\w.])(?<!epsilon\()(?<!huge\()(?<!tiny\()(\d+\.?\d*(?:e[-+]?\d+)?_wp)\b"
VALUE = r"(\d[\d.]*(?:e[-+]?\d+)?(?:_\w+)?)\b"
CONSTANT = re.compile(rf"(\w+)(?:\([\w, ]+\))? = [-\[]*(?:\w+\()?{VALUE}")
OPERATOR = re.compile(r"(?<=[\w)]) ([+-]) (?=[\w(])|(?<=[\w)])(?<!\*)([*/])(?![*/)=])(?=[\w(])")
PROCEDURE = re.compile(r"^\s*(?!end\b)(?:[\w()]+\s+)*(?:subroutine|function)\s+(\w+)")
TURNED = {"+": "-", "-": "+", "*": "/", "/": "*"}


@dataclass(frozen=True)
class Mutant:
    """One place of a file, and its changed text."""

    file: str
    line: int
    start: int
    old: str
    new: str
    kind: str
    name: str = field(compare=False)

    def __str__(self) -> str:
        return f"{self.file}:{self.line} {self.name}: {self.old} -> {self.new}"

    def text(self) -> str:
        """Return the changed text of the file."""
        lines = (ROOT / "fortran" / self.file).read_text().splitlines(keepends=True)
        line = lines[self.line - 1]
        assert line[self.start :].startswith(self.old)
        lines[self.line - 1] = line[: self.start] + self.new + line[self.start + len(self.old) :]
        return "".join(lines)


def places() -> Iterator[tuple[str, int, re.Match, int, str, str]]:
    """Yield file, line, match, its group, kind and name of each place that could be changed."""
    for path in sorted((ROOT / "fortran").rglob("*.f90")):
        file, name = str(path.relative_to(ROOT / "fortran")), ""
        for line, text in enumerate(path.read_text().splitlines(), 1):
            code = text.partition("!")[0]
            if match := PROCEDURE.match(code):
                name = match[1]
            if "'" in text.partition("!<")[0] or '"' in code:
                continue  # texts
            if "parameter ::" in code:
                for match in CONSTANT.finditer(code):
                    yield file, line, match, 2, "constant", match[1]
            elif "::" not in code and re.search(r"\S", code):
                for match in re.finditer(NUMBER, code):
                    if float(match[1][:-3]):
                        yield file, line, match, 1, "number", name
                if " = " in code and "wp)" not in code.partition(" = ")[0]:
                    for match in OPERATOR.finditer(code, code.index(" = ") + 3):
                        yield file, line, match, 1 if match[1] else 2, "operator", name


def reason(location: str) -> str:
    """Return the reason why a place is excluded, or ''."""
    return next((why for why, pattern in EXCLUDED.items() if re.match(pattern, location)), "")


def draw(seed: int, count: int) -> tuple[list[Mutant], Counter]:
    """Return `count` mutants, and numbers of excluded places by reason.

    Selects the places with the smallest hashes of seed and source line, which do not depend on
    changes elsewhere.
    """
    kinds: dict[str, list[tuple[str, Mutant]]] = {}
    left_out: Counter = Counter()
    for file, line, match, group, kind, name in places():
        if exclusion := reason(f"{file}:{name}:{kind} {match[group]}"):
            left_out[exclusion] += 1
            continue
        digest = sha256(f"{seed} {file} {match.string} {match.start(group)}".encode()).hexdigest()
        old_text, factor = match[group], 2.0 if digest[-1] in "02468ace" else 0.5
        new_text = TURNED[old_text] if kind == "operator" else times(old_text, factor)
        if new_text == old_text:  # zero
            continue
        mutant = Mutant(file, line, match.start(group), old_text, new_text, kind, name)
        kinds.setdefault(kind, []).append((digest, mutant))
    ordered = [sorted(kinds[kind], key=lambda pair: pair[0]) for kind in sorted(kinds)]
    return [ordered[i % len(ordered)].pop(0)[1] for i in range(count)], left_out


def times(number: str, factor: float) -> str:
    """Return a number of the source, doubled or halved."""
    digits, _, kind = number.partition("_")
    value = float(digits) * factor
    return (repr(value) if "." in digits else str(int(value) or 1)) + f"_{kind}" * bool(kind)


@dataclass
class Engine:
    """A copy of the tree with its build."""

    folder: Path

    def __post_init__(self) -> None:
        self.build = self.folder / "build"
        if not self.build.exists():
            file_list = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True,
                                       text=True)  # fmt: skip
            for name in file_list.stdout.splitlines():
                (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(ROOT / name, self.folder / name)
            command = ["meson", "setup", self.build, "-Dtester=true", "-Dnative_arch=true"]
            subprocess.run(command, cwd=self.folder, check=True, capture_output=True)
        self.python = self.folder / "venv" / "bin" / "python"
        if not self.python.exists():
            self.make_environment()

    def make_environment(self) -> None:
        """Make a virtual environment like the present one, with the executable of the copy."""
        python_folder, programs = Path(sys.prefix), Path(sys.executable).parent
        self.python.parent.mkdir(parents=True)
        (self.folder / "venv" / "lib").symlink_to(python_folder / "lib")
        shutil.copy(python_folder / "pyvenv.cfg", self.folder / "venv")
        for program in programs.iterdir():
            (self.python.parent / program.name).symlink_to(program)
        native = self.python.parent / "sitedda-native"
        native.unlink(missing_ok=True)
        native.symlink_to(self.build / "sitedda-native")

    def make(self, *targets: str) -> bool:
        """Build the targets, or all, and install; return whether the source compiles."""
        process = self.run("ninja", "-C", self.build, *targets)
        if process.returncode == 0 and not targets:
            destination = f"--destdir={self.folder / 'installed'}"
            self.run("meson", "install", "-C", self.build, "--no-rebuild", "--quiet", destination)
        return process.returncode == 0

    def run(self, *command, limit: float | None = None) -> subprocess.CompletedProcess:
        """Run a command in the copy, with its package and programs before others."""
        package = next(self.folder.glob("installed/**/sitedda/__init__.py"), self.folder).parents[1]
        extra = {
            "PYTHONPATH": str(package),
            "PATH": f"{self.python.parent}{os.pathsep}{os.environ['PATH']}",
            "SITEDDA_TEST_DATA": str(self.folder / "tests" / "data"),
            "OPENBLAS_NUM_THREADS": "1",
            "OMP_WAIT_POLICY": "passive",
        }
        return subprocess.run(
            [str(argument) for argument in command], cwd=self.folder, env=os.environ | extra,
            timeout=limit, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False,
        )  # fmt: skip


def tests_of(file: str) -> list[Path]:
    """Return all Python test files, most similar to the words of a file and its comments first."""
    source = (ROOT / "fortran" / file).read_text()
    mutated_words = words_of(f"{Path(file).stem} " * 9 + " ".join(re.findall(r"!.*", source)))
    paths = [path for path in (ROOT / "tests").glob("**/test_*.py") if path.stem not in UNUSED]
    texts = {path: words_of(f"{path.stem} " * 9 + path.read_text()) for path in paths}
    in_tests = Counter(term for counts in texts.values() for term in counts)

    def common_words(path: Path) -> float:
        counts = texts[path]
        rare = {w: math.log(1 + counts[w]) * math.log(len(texts) / in_tests[w]) for w in counts}
        size = math.sqrt(sum(value**2 for value in rare.values()))
        return (sum(math.log(1 + mutated_words[w]) * rare[w]
                    for w in mutated_words if w in rare) / size)  # fmt: skip

    return [path.relative_to(ROOT) for path in sorted(texts, key=common_words, reverse=True)]


def words_of(text: str) -> Counter:
    """Return how often each longer word occurs in a text; plurals count as singulars."""
    return Counter(term.rstrip("s") for term in re.findall(r"[a-z]{4,}", text.lower()))


def killer(engine: Engine, mutant: Mutant, limit: float) -> str:
    """Return what detected the mutant, or '' if nothing did."""
    if not engine.make("tests/fortran/tester"):
        return REFUSED
    try:
        process = engine.run(engine.build / "tests" / "fortran" / "tester", limit=HANG)
    except subprocess.TimeoutExpired:
        return "the Fortran suites take too long"
    if process.returncode:
        output = re.search(r"^.*FAIL.*$", process.stdout, re.M)
        return f"Fortran suites: {output[0].strip() if output else process.returncode}"
    engine.make()
    begun = time.monotonic()
    for path in tests_of(mutant.file):
        if limit and time.monotonic() - begun > limit:
            return ""
        try:
            process = engine.run(engine.python, "-m", "pytest", "-xq", "-p", "no:cacheprovider",
                                 path, limit=HANG)  # fmt: skip
        except subprocess.TimeoutExpired:
            return f"{path} takes too long"
        if process.returncode not in (0, 5):
            output = re.search(r"^(FAILED|ERROR) (\S+)", process.stdout, re.M)
            return output[2] if output else f"{path} ends with {process.returncode}"
    return ""


def unchanged_fails(engine: Engine, killers: set[str]) -> set[str]:
    """Return those of the tests that fail without a mutant."""
    pytest_names = [name for name in killers if name.startswith("tests/") and "::" in name]
    command = (engine.python, "-m", "pytest", "-q")
    return {n for n in pytest_names if engine.run(*command, n).returncode}


def main() -> int:
    """Draw, build, test, and count."""
    options = parse_options(__doc__, "folder", seed=random.randrange(10**6), mutants=40, first=0,
                    limit=300.0, list=False)  # fmt: skip
    mutants, left_out = draw(options.seed, options.mutants)
    print(f"seed {options.seed}, {len(mutants)} mutants; places left out:")
    for why, count in left_out.items():
        print(f"{count:6} {why}")
    if options.list:
        print(*mutants, sep="\n")
        return 0
    engine = Engine(options.folder.resolve())
    killers = {}
    for mutant in mutants[options.first :]:
        file = engine.folder / "fortran" / mutant.file
        text = file.read_text()
        file.write_text(mutant.text())
        try:
            killers[mutant] = killer(engine, mutant, options.limit)
        finally:
            file.write_text(text)
        end = "killed  " if killers[mutant] else "SURVIVED"
        print(f"{end} {mutant} | {killers[mutant]}", flush=True)
    engine.make()
    wrong = unchanged_fails(engine, set(killers.values()))
    killers = {mutant: by for mutant, by in killers.items() if by != REFUSED}
    killed = sum(bool(by) and by not in wrong for by in killers.values())
    print(*(f"also fails without a mutant: {name}" for name in sorted(wrong)), sep="\n")
    print(f"{killed} of {len(killers)} killed, at least {LEAST:.1%} required (seed {options.seed})")
    return int(killed < LEAST * len(killers))


if __name__ == "__main__":
    sys.exit(main())
