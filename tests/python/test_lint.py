# SPDX-License-Identifier: GPL-3.0-or-later
"""Rules of the source: linters of both languages, layers, lengths, documented arguments."""

import ast
import re
import tomllib
from pathlib import Path

import pytest
from environment import captured, executable
from fortran_source import (
    bound_names,
    functions_called,
    functions_in_scope,
    guards,
    logical_operands,
    own_functions,
    read_statements,
    read_tree,
)

ROOT = Path(__file__).parents[2]
TREE = read_tree(ROOT / "fortran")
PROCEDURES = [procedure for source in TREE for procedure in source.procedures]
LONGEST = 50  # lines of a procedure
DOCUMENTED = 0.7  # fraction of all arguments; those of public procedures all are


@pytest.mark.parametrize(
    "command",
    [("ruff", "check"), ("ruff", "format", "--check"), ("fortitude", "check"), ("mypy",)],
    ids=" ".join,
)
def test_linters_find_nothing(command):
    process = captured([executable(command[0]), *command[1:]], cwd=ROOT)
    assert process.returncode == 0, process.stdout + process.stderr


def test_no_line_is_longer_than_the_limit():
    limit = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["ruff"]["line-length"]
    assert tomllib.loads((ROOT / "fortitude.toml").read_text())["check"]["line-length"] == limit
    kinds = ("*.f90", "*.inc", "*.c", "*.py", "*.in")
    files = [f for top in ("fortran", "python", "tests") for k in kinds for f in _files(top, k)]
    long = [
        f"{file.relative_to(ROOT)}:{number}"
        for file in files
        for number, line in enumerate(file.read_text().splitlines(), 1)
        if len(line) > limit
    ]
    assert not long


def test_prose_is_wrapped():
    """Code, formulas, tables, pictures, links and generated pages may be longer."""
    pages = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]
    generated = ("input_reference", "output_reference", "benchmarks", "ford", "gallery")
    long = [
        f"{page.relative_to(ROOT)}: {line}"
        for page in pages
        if page.stem not in generated
        for line in re.sub("```.*?```", "", page.read_text(), flags=re.DOTALL).splitlines()
        if len(line) > 110 and line.lstrip(" -*")[:1].isalpha() and "\\" not in line
    ]
    assert pages and not long


def test_f2py_can_read_the_interface():
    """Without the library that guesses encodings, f2py reads files as ASCII."""
    files = _files("python/sitedda/api", "*.f90")
    assert files and all(file.read_bytes().isascii() for file in files)


def _files(top: str, kind: str) -> list[Path]:
    return list((ROOT / top).rglob(kind))


def test_the_parser_reads_the_whole_tree():
    names = {name for source in TREE for name in source.modules}
    assert len(names) >= len(TREE) - 1  # all but the main program
    assert "dda_simulation" in names
    ends = sum(
        line.split()[:2] in (["end", "subroutine"], ["end", "function"])
        for source in TREE
        for line in source.file.read_text().splitlines()
    )
    assert 0 <= ends - len(PROCEDURES) < ends / 20  # the others declare C and LAPACK


def test_every_source_file_names_its_licence():
    """Each file has SPDX-License-Identifier in its first lines."""
    tag = "SPDX-License-Identifier: GPL-3.0-or-later"
    folders = ("fortran", "python", "tests")
    kinds = (".f90", ".inc", ".py", ".in")
    files = [f for name in folders for f in (ROOT / name).rglob("*") if f.suffix in kinds]
    assert len(files) > 300
    missing = [str(f) for f in files if tag not in "".join(f.open().readlines()[:3])]
    assert not missing


def check_layers(below: dict) -> None:
    """Check that dependencies have no cycles."""
    assert sum(map(len, below.values())) > len(below)
    while below:
        lowest = {one for one, to in below.items() if not (to - {one}) & set(below)}
        assert lowest, f"these depend on each other: {sorted(map(str, below))}"
        below = {one: to for one, to in below.items() if one not in lowest}


def test_folders_are_layers():
    """The lowest folder is the first one in the build file; the executable is above all."""
    text = (ROOT / "fortran" / "meson.build").read_text()
    folders = [*re.findall(r"^  '(\S+)': \[", text, re.M), "app"]
    level = {ROOT / "fortran" / folder: n for n, folder in enumerate(folders)}
    home = {module: source.file.parent for source in TREE for module in source.modules}
    upward = [(source.file.name, m) for source in TREE for m in source.used & set(home)
              if level[home[m]] > level[source.file.parent]]  # fmt: skip
    assert len(level) > 20 and not upward


def _imports() -> dict[tuple[str, ...], set[tuple[str, ...]]]:
    """Return the imports of each Python module within the package, except those for types."""
    top = ROOT / "python" / "sitedda"
    files = {file.relative_to(top).with_suffix("").parts: file for file in top.rglob("*.py")}
    used: dict[tuple[str, ...], set[tuple[str, ...]]] = {}
    for name, file in files.items():
        tree = ast.parse(file.read_text())
        conditions = [node for node in ast.walk(tree) if isinstance(node, ast.If)]
        types = [node for node in conditions if "TYPE_CH" in ast.dump(node.test)]
        skipped = {id(inner) for node in types for inner in ast.walk(node)}
        used[name] = set()
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and node.level and id(node) not in skipped:
                parts = (node.module or "").split(".") * bool(node.module)
                base = name[: -node.level] + tuple(parts)
                modules = [(*base, alias.name) for alias in node.names]
                packages = [module if module in files else base for module in modules]
                used[name] |= {
                    module if module in files else (*module, "__init__") for module in packages
                }
    return used


def test_python_packages_are_layers():
    below: dict[str, set[str]] = {}
    for name, used in _imports().items():
        below.setdefault(name[0], set()).update(imported[0] for imported in used)
    del below["__init__"], below["__main__"]  # the face of the package
    check_layers(below)


def test_python_modules_are_layers():
    """Names that a package collects from its modules do not count."""
    used = {name: to for name, to in _imports().items() if name != ("__init__",)}
    for name, to in used.items():
        to -= {(*name[:depth], "__init__") for depth in range(len(name))}
    check_layers({name: to & set(used) for name, to in used.items()})


CORE = ("api", "base", "input", "engine", "output", "facade/run.py", "commands")  # of the package
LARGEST_CORE = 8500  # lines, without the modules that are generated from the schemas


def test_the_core_is_small():
    """Commands of other packages are modules of these packages."""
    top = ROOT / "python" / "sitedda"
    files = [f for name in CORE for f in (top / name).rglob("*") if f.suffix in (".py", ".f90")]
    files += [top / name for name in CORE if (top / name).is_file()]
    assert len(files) > 40
    assert sum(len(file.read_text().splitlines()) for file in files) <= LARGEST_CORE


def test_no_procedure_is_longer_than_the_limit():
    assert not [f"{p.where} {p.name}: {p.lines} lines" for p in PROCEDURES if p.lines > LONGEST]


def test_arguments_of_public_procedures_are_documented():
    missing = [
        f"{p.where} {p.name}: {', '.join(sorted(set(p.arguments) - p.documented))}"
        for source in TREE
        for p in source.procedures
        if p.name in source.public and set(p.arguments) - p.documented
    ]
    assert not missing, f"{len(missing)} procedures:\n" + "\n".join(missing[:40])


def test_most_arguments_are_documented():
    count = sum(len(p.arguments) for p in PROCEDURES)
    documented = sum(len(set(p.arguments) & p.documented) for p in PROCEDURES)
    assert documented >= DOCUMENTED * count, f"{documented} of {count}"


# Arrays and texts with names of functions.
NAMES_OF_ARRAYS = {"columns", "label", "normal_force"}


@pytest.fixture(scope="module")
def logical_expressions():
    """Yield position, operands and called functions of each expression with .and. or .or."""
    files = [f for kind in ("*.f90", "*.inc", "*.in") for f in _files("fortran", kind)]
    files = {file: read_statements(file) for file in [*files, *_files("python", "*.f90")]}
    functions = set().union(*map(own_functions, files.values()))
    bound = set().union(*map(bound_names, files.values()))
    expressions = []
    for file, statements in files.items():
        scope = functions_in_scope(statements, functions, bound)
        expressions += [
            (f"{file.relative_to(ROOT)}:{line}", operands, functions_called(operands, scope))
            for line, code in statements
            for operands in logical_operands(code)
        ]
    return expressions


def test_no_operand_guards_another_one(logical_expressions):
    """Fortran may evaluate the operands of .and. and .or. in any order, or all of them."""
    assert len(logical_expressions) > 500
    guarded = [
        (location, names) for location, *one in logical_expressions if (names := guards(*one))
    ]
    assert not guarded


def test_operands_call_only_functions_without_preconditions(logical_expressions):
    """Other conditions must be nested; functions without preconditions are marked ``! total``."""
    lines = "\n".join(source.file.read_text() for source in TREE)
    total = set(re.findall(r"\bfunction (\w+) *\(.*! total$", lines, re.MULTILINE))
    allowed = total | NAMES_OF_ARRAYS
    violations = {
        location: calls - allowed for location, _, calls in logical_expressions if calls - allowed
    }
    assert not violations
    assert total <= set().union(*(calls for _, _, calls in logical_expressions))


@pytest.mark.parametrize(
    "code",
    [
        "if (present(a) .and. a > 0) then",
        "if (.not. allocated(x%list) .or. size(x%list) == 0) return",
        "if (i > 0 .and. list(i) == 2) n = n + 1",
        "if (i < 1 .or. list(max(2, 3), i) == 2) n = n + 1",
        "if (n == 0 .or. (ok .and. all(t(:n) > 0))) n = n + 1",
        "if (text /= '' .and. text(len(text):) /= 'x') n = 1",
    ],
)
def test_an_operand_that_guards_another_is_found(code):
    assert any(guards(operands) for operands in logical_operands(code))


@pytest.mark.parametrize(
    "code",
    [
        "if (present(a) .and. b > 0) then",
        "if (allocated(error) .or. allocated(x%error)) return",
        "if (i > 0 .and. abs(i) < 7 .and. list(k) == 2) n = n + 1",
        "if (present(a)) b = b .and. a",
        "where (list == i .or. flag(:)) list = 0",
    ],
)
def test_independent_operands_are_accepted(code):
    assert not any(guards(operands) for operands in logical_operands(code))
