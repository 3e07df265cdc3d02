#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Change the engine in one place at a time and see whether the tests notice.

usage: python tests/robustness/mutants.py FOLDER [--seed N] [--mutants N] [--first I]
       [--limit SECONDS] [--list]

A mutant is the engine with one named constant or one number of a formula doubled or halved, or one
sign or factor of a formula turned round: a third of each, drawn among all places of fortran/ but
those of `EXCLUDED`.  Each is built in FOLDER (a copy of the tree, kept, so that only what depends
on the changed file is compiled), then tested by the Fortran suites and by the Python tests, those
first that speak of what the file is about, until one fails or LIMIT seconds of testing have passed
(--limit 0: all; --first: where to go on; --list builds nothing).  What killed mutants runs on the
unchanged engine at the end: a test that fails there, too, has killed nothing.  Ends with status 1
below `LEAST` of them killed.
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

from options import asked

ROOT = Path(__file__).resolve().parents[2]
LEAST = 35 / 40  # of the mutants, killed
REFUSED = "the compiler refuses it: no mutant"
HANG = 600  # s: a suite or a test that takes longer has noticed
SEARCHES = r"""dynamics/(line_search|static_relaxation|slide_forces|friction_bounds|damage_passes
|cycles)\.f90|dynamics/open_close\.f90:retain""".replace("\n", "")
WAYS = r"""dynamics/(open_close|time_step|contact_terms|contact_search)\.f90
|course/(equilibrium|running_maxima)\.f90|elements/strain_points\.f90|soil/shear_column\.f90
|checks/(modes|reduced_model|unresolved|omega_max)\.f90""".replace("\n", "")
# Places that are not changed, and why: "folder/file.f90:constant or procedure:kind value".
EXCLUDED = {
    "words, files, calls of the system: no formula of a model": r"(base|app|platform|facade)/",
    "ways to the same numbers: a solution with a large residual is refused": r"algebra/",
    "how an iteration gets to its solution, not which one: tests/benchmarks/ablation.py": (
        rf"({SEARCHES})|({WAYS}).*:(constant|number) "
    ),
    "what counts as rounding or as endless: far from all that a model has": (
        r".*:(constant|number) (\d\.0e-([6-9]|1\d)_wp|1\.0e[6-9]_wp)"
    ),
    "whole numbers that name states and columns, or are sizes of tables": (
        r".*:(?!most_|least_|enough|wanted_|few_|many_)\w+:constant \d+(_long)?$"
    ),
    "a bound beyond any model, of memory, or of an iteration that ends before": (
        r".*:(most_(blocks|away|samples|points|pairs|names|comments|vectors|expansions|passes"
        r"|halvings|header\w*|columns|springs|steps|rounds|iterations|vertices|cells|fits)"
        r"|(largest|longest|farthest|usable|never|many|few|buffer|step|library|call|worth|unknown"
        r"|beyond)\w*):constant"
    ),
    "where a series takes over from its formula: both hold": r".*:(small|small_step):constant",
    "so stiff that more changes nothing": r".*:(rigid|unyielding|rigidity):constant",
    "how a search or a fit gets to its end, or more than it needs": (
        r".*:(stride|stiffest|golden|aside|half|both_sides|sum_weight|least_weight|small_misfit"
        r"|wanted_misfit|first_share|slack|gain_allowed|short_way|steepest\w*):constant"
    ),
    "which pairs are looked at: more than touch": r"contact/neighbours\.f90",
    "corners of cells, as edges end within 1e-6 of each other or not": r"model/weld\.f90:near:",
    "places in files: a wrong one is no output at all": (
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
    """One place of a file, and what stands there instead."""

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
        """The file with it."""
        lines = (ROOT / "fortran" / self.file).read_text().splitlines(keepends=True)
        one = lines[self.line - 1]
        assert one[self.start :].startswith(self.old)
        lines[self.line - 1] = one[: self.start] + self.new + one[self.start + len(self.old) :]
        return "".join(lines)


def places() -> Iterator[tuple[str, int, re.Match, int, str, str]]:
    """File, line, what was found there (group), kind, name of each place that could be changed."""
    for path in sorted((ROOT / "fortran").rglob("*.f90")):
        file, name = str(path.relative_to(ROOT / "fortran")), ""
        for line, text in enumerate(path.read_text().splitlines(), 1):
            code = text.partition("!")[0]
            if found := PROCEDURE.match(code):
                name = found[1]
            if "'" in text.partition("!<")[0] or '"' in code:
                continue  # words
            if "parameter ::" in code:
                for found in CONSTANT.finditer(code):
                    yield file, line, found, 2, "constant", found[1]
            elif "::" not in code and re.search(r"\S", code):
                for found in re.finditer(NUMBER, code):
                    if float(found[1][:-3]):
                        yield file, line, found, 1, "number", name
                if " = " in code and "wp)" not in code.partition(" = ")[0]:
                    for found in OPERATOR.finditer(code, code.index(" = ") + 3):
                        yield file, line, found, 1 if found[1] else 2, "operator", name


def reason(place: str) -> str:
    """Why a place is not changed, or ''."""
    return next((why for why, pattern in EXCLUDED.items() if re.match(pattern, place)), "")


def draw(seed: int, count: int) -> tuple[list[Mutant], Counter]:
    """So many mutants, and how many places were left out for each reason.

    The places with the smallest hashes of seed and source line: a change elsewhere changes no draw.
    """
    kinds: dict[str, list[tuple[str, Mutant]]] = {}
    left_out: Counter = Counter()
    for file, line, found, group, kind, name in places():
        if why := reason(f"{file}:{name}:{kind} {found[group]}"):
            left_out[why] += 1
            continue
        chance = sha256(f"{seed} {file} {found.string} {found.start(group)}".encode()).hexdigest()
        old, factor = found[group], 2.0 if chance[-1] in "02468ace" else 0.5
        new = TURNED[old] if kind == "operator" else times(old, factor)
        mutant = Mutant(file, line, found.start(group), old, new, kind, name)
        kinds.setdefault(kind, []).append((chance, mutant))
    ordered = [sorted(kinds[kind], key=lambda pair: pair[0]) for kind in sorted(kinds)]
    return [ordered[i % len(ordered)].pop(0)[1] for i in range(count)], left_out


def times(number: str, factor: float) -> str:
    """A number of the source, doubled or halved."""
    digits, _, kind = number.partition("_")
    value = float(digits) * factor
    return (repr(value) if "." in digits else str(int(value) or 1)) + f"_{kind}" * bool(kind)


@dataclass
class Engine:
    """A copy of the tree, built."""

    folder: Path

    def __post_init__(self) -> None:
        self.build = self.folder / "build"
        if not self.build.exists():
            listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True)
            for name in listed.stdout.splitlines():
                (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(ROOT / name, self.folder / name)
            command = ["meson", "setup", self.build, "-Dtester=true", "-Dnative_arch=true"]
            subprocess.run(command, cwd=self.folder, check=True, capture_output=True)
        self.python = self.folder / "venv" / "bin" / "python"
        if not self.python.exists():
            self.make_environment()

    def make_environment(self) -> None:
        """The environment of this program, with the executable of the copy instead of its own."""
        own, programs = Path(sys.prefix), Path(sys.executable).parent
        self.python.parent.mkdir(parents=True)
        (self.folder / "venv" / "lib").symlink_to(own / "lib")
        shutil.copy(own / "pyvenv.cfg", self.folder / "venv")
        for program in programs.iterdir():
            (self.python.parent / program.name).symlink_to(program)
        native = self.python.parent / "sitedda-native"
        native.unlink(missing_ok=True)
        native.symlink_to(self.build / "sitedda-native")

    def make(self, *targets: str) -> bool:
        """Build these targets, or all, and install; whether the compiler took the source."""
        made = self.run("ninja", "-C", self.build, *targets)
        if made.returncode == 0 and not targets:
            into = f"--destdir={self.folder / 'installed'}"
            self.run("meson", "install", "-C", self.build, "--no-rebuild", "--quiet", into)
        return made.returncode == 0

    def run(self, *command, limit: float | None = None) -> subprocess.CompletedProcess:
        """A command within the copy, with its package and programs before all others."""
        package = next(self.folder.glob("installed/**/sitedda/__init__.py"), self.folder).parents[1]
        own = {
            "PYTHONPATH": str(package),
            "PATH": f"{self.python.parent}{os.pathsep}{os.environ['PATH']}",
            "SITEDDA_TEST_DATA": str(self.folder / "tests" / "data"),
            "OPENBLAS_NUM_THREADS": "1",
            "OMP_WAIT_POLICY": "passive",
        }
        return subprocess.run(
            [str(word) for word in command], cwd=self.folder, env=os.environ | own, timeout=limit,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False,
        )  # fmt: skip


def tests_of(file: str) -> list[Path]:
    """All Python test files, those first whose words are most those of a file and its comments."""
    source = (ROOT / "fortran" / file).read_text()
    about = words_of(f"{Path(file).stem} " * 9 + " ".join(re.findall(r"!.*", source)))
    paths = [path for path in (ROOT / "tests").glob("**/test_*.py") if path.stem not in UNUSED]
    texts = {path: words_of(f"{path.stem} " * 9 + path.read_text()) for path in paths}
    in_tests = Counter(word for words in texts.values() for word in words)

    def likeness(path: Path) -> float:
        words = texts[path]
        rare = {w: math.log(1 + words[w]) * math.log(len(texts) / in_tests[w]) for w in words}
        size = math.sqrt(sum(value**2 for value in rare.values()))
        return sum(math.log(1 + about[w]) * rare[w] for w in about if w in rare) / size

    return [path.relative_to(ROOT) for path in sorted(texts, key=likeness, reverse=True)]


def words_of(text: str) -> Counter:
    """How often a text has each of its longer words, plurals as one."""
    return Counter(word.rstrip("s") for word in re.findall(r"[a-z]{4,}", text.lower()))


def killer(engine: Engine, mutant: Mutant, limit: float) -> str:
    """What noticed, or '' where nothing did."""
    if not engine.make("tests/fortran/tester"):
        return REFUSED
    try:
        done = engine.run(engine.build / "tests" / "fortran" / "tester", limit=HANG)
    except subprocess.TimeoutExpired:
        return "the Fortran suites take too long"
    if done.returncode:
        said = re.search(r"^.*FAIL.*$", done.stdout, re.M)
        return f"Fortran suites: {said[0].strip() if said else done.returncode}"
    engine.make()
    begun = time.monotonic()
    for path in tests_of(mutant.file):
        if limit and time.monotonic() - begun > limit:
            return ""
        try:
            done = engine.run(engine.python, "-m", "pytest", "-xq", "-p", "no:cacheprovider", path,
                              limit=HANG)  # fmt: skip
        except subprocess.TimeoutExpired:
            return f"{path} takes too long"
        if done.returncode not in (0, 5):
            said = re.search(r"^(FAILED|ERROR) (\S+)", done.stdout, re.M)
            return said[2] if said else f"{path} ends with {done.returncode}"
    return ""


def unchanged_fails(engine: Engine, killers: set[str]) -> set[str]:
    """Those of the tests that fail without a mutant."""
    own = [name for name in killers if name.startswith("tests/") and "::" in name]
    return {n for n in own if engine.run(engine.python, "-m", "pytest", "-q", n).returncode}


def main() -> int:
    """Draw, build, test, count."""
    options = asked(__doc__, "folder", seed=random.randrange(10**6), mutants=40, first=0,
                    limit=300.0, list=False)  # fmt: skip
    mutants, left_out = draw(options.seed, options.mutants)
    print(f"seed {options.seed}, {len(mutants)} mutants; places left out:")
    for why, count in left_out.items():
        print(f"{count:6} {why}")
    if options.list:
        print(*mutants, sep="\n")
        return 0
    engine = Engine(options.folder.resolve())
    found = {}
    for mutant in mutants[options.first :]:
        file = engine.folder / "fortran" / mutant.file
        own = file.read_text()
        file.write_text(mutant.text())
        try:
            found[mutant] = killer(engine, mutant, options.limit)
        finally:
            file.write_text(own)
        end = "killed  " if found[mutant] else "SURVIVED"
        print(f"{end} {mutant} | {found[mutant]}", flush=True)
    engine.make()
    wrong = unchanged_fails(engine, set(found.values()))
    found = {mutant: by for mutant, by in found.items() if by != REFUSED}
    killed = sum(bool(by) and by not in wrong for by in found.values())
    print(*(f"fails without a mutant, too: {name}" for name in sorted(wrong)), sep="\n")
    print(f"{killed} of {len(found)} killed, at least {LEAST:.1%} wanted (seed {options.seed})")
    return int(killed < LEAST * len(found))


if __name__ == "__main__":
    sys.exit(main())
