# SPDX-License-Identifier: GPL-3.0-or-later
"""Line-by-line parser of the Fortran tree: modules, used modules, procedures, arguments."""

import re
from dataclasses import dataclass, field
from pathlib import Path

_TYPE = r"integer|real|logical|\w+\s*\([^:]*?\)"
_PREFIX = rf"(?:(?:pure|impure|elemental|recursive|module|{_TYPE})\s+)*"
_PROCEDURE = re.compile(rf"\s*{_PREFIX}(?:subroutine|function)\s+(\w+)\s*(?:\((.*?)\))?", re.I)
_END = re.compile(r"\s*end\s+(subroutine|function)\b", re.I)
_INTERFACE = re.compile(r"\s*(abstract\s+)?interface\b", re.I)
_BINDING = re.compile(r"\s*(?:procedure|generic)\b[^:]*::(.*)", re.I)


@dataclass
class Procedure:
    """A procedure of the tree."""

    where: str  # file and line
    name: str
    arguments: list[str]
    documented: set[str] = field(default_factory=set)  # arguments with a comment, !< or !>
    lines: int = 0  # number of lines from its first statement to its end


@dataclass
class Source:
    """A file of the tree: its folder, modules, modules used, public names and procedures."""

    file: Path
    modules: set[str] = field(default_factory=set)
    used: set[str] = field(default_factory=set)
    public: set[str] = field(default_factory=set)
    procedures: list[Procedure] = field(default_factory=list)


def read_tree(folder: Path) -> list[Source]:
    """Return all Fortran files of a folder."""
    return [_read(file) for file in sorted(folder.rglob("*.f90"))]


def _read(file: Path) -> Source:
    source, open_procedures, foreign = Source(file), [], False
    for number, last, statement, documented in _statements(file.read_text().splitlines()):
        keyword = statement.split(None, 1)[0].lower().rstrip(":,") if statement.split() else ""
        if re.match(r"\s*(sub)?module\b(?!\s+procedure\b)", statement, re.I):
            source.modules.add(statement.split()[-1].lower())
        elif keyword == "use" and "intrinsic" not in statement.lower():
            source.used.add(re.match(r"\s*use\s+(?:::)?\s*(\w+)", statement, re.I)[1].lower())
        elif keyword == "public":
            source.public |= _names(statement.split("public", 1)[1].lstrip(" :"))
        elif match := _INTERFACE.match(statement):
            foreign = not match[1]
        elif re.match(r"\s*end\s+interface\b", statement, re.I):
            foreign = False
        elif _END.match(statement):
            procedure = open_procedures.pop()
            procedure.lines = last - procedure.lines + 1
            if not foreign:
                source.procedures.append(procedure)
        elif match := _PROCEDURE.match(statement):
            location = f"{file}:{number}"
            names = [name.strip().lower() for name in (match[2] or "").split(",") if name.strip()]
            open_procedures.append(Procedure(location, match[1].lower(), names, lines=number))
        elif open_procedures and "::" in statement and documented:
            open_procedures[-1].documented |= _names(statement.split("::", 1)[1])
        elif match := _BINDING.match(statement):
            source.public |= {part.split("=>")[-1].strip() for part in match[1].lower().split(",")}
    return source


def _statements(lines: list[str]):
    """Yield first and last line, statement, and whether a comment documents it."""
    statement, documented, first, before = "", False, 0, ""
    for number, line in enumerate(lines, 1):
        if line.lstrip().startswith("!"):
            before = line.lstrip() if not statement else before
            continue
        if not line.strip():
            before = ""
            continue
        code, note = _split(line)
        first = first if statement else number
        documented = documented or note.startswith("!<") or before.startswith("!>")
        statement = (statement + code.strip().removeprefix("&")).removesuffix("&")
        if code.rstrip().endswith("&"):
            continue
        yield first, number, statement, documented
        statement, documented, before = "", False, ""


def _split(line: str) -> tuple[str, str]:
    """Split a line into code and comment."""
    match = re.match(r"((?:[^'\"!]|'[^']*'|\"[^\"]*\")*)(.*)", line)
    return match[1], match[2]


def _names(text: str) -> set[str]:
    """Return the names in a list of declarations, without shapes and values."""
    while (flat := re.sub(r"\([^()]*\)", "", text)) != text:
        text = flat
    return {part.split("=")[0].strip().lower() for part in text.split(",")}


# --- Operands of .and. and .or., which are evaluated in any order or not at all ---

_FUNCTION = re.compile(rf"\s*{_PREFIX}function\s+(\w+)", re.I)
_ONLY = re.compile(r"\s*use\b[^!]*?\bonly\s*:(.*)", re.I)
_STATUS = re.compile(r"\b(?:present|allocated|associated)\s*\(\s*([\w%]+)\s*\)", re.I)
_COMPARED = re.compile(r"(.*?)(==|/=|<=|>=|<|>)(.*)")
_CALL = re.compile(r"(%?)\b(\w+)\s*\(")
_INTRINSIC = set(
    """abs aint all anint any cmplx count dot_product findloc huge iachar index int len len_trim max
    maxloc maxval merge min minloc minval mod modulo nint norm2 pack real reshape scan sign size
    spread sqrt sum transfer trim verify""".split()
)


def read_statements(file: Path) -> list[tuple[int, str]]:
    """Return first line number and text of each statement, in lower case and without comments."""
    statements = _statements(file.read_text().splitlines())
    return [
        (line, re.sub(r"'[^']*'|\"[^\"]*\"", "''", code).lower()) for line, _, code, _ in statements
    ]


def functions_in_scope(statements, tree_functions: set[str], bound: set[str]) -> set[str]:
    """Return the functions of the tree that a file may call; bound ones with a % before."""
    own = {match[1] for _, code in statements if (match := _FUNCTION.match(code))}
    used = {
        name.split("=>")[0].strip()
        for _, code in statements
        if (match := _ONLY.match(code))
        for name in match[1].split(",")
    }
    return own | (used & tree_functions) | {"%" + name for name in bound}


def own_functions(statements) -> set[str]:
    """Return the functions that a file defines."""
    return {match[1] for _, code in statements if (match := _FUNCTION.match(code))}


def bound_names(statements) -> set[str]:
    """Return the names of procedures that are bound to types."""
    procedure_names = [match[1] for _, code in statements if (match := _BINDING.match(code))]
    return {part.split("=>")[0].strip() for names in procedure_names for part in names.split(",")}


def logical_operands(code: str) -> list[list[str]]:
    """Return the operands of each .and. and .or. of a statement, by pairs of brackets."""
    if match := re.match(r"\s*(?:else\s+)?(?:if|where|do\s+while)\s*(?=\()", code):
        end = _closing(code, match.end() + 1)
        return _operands(code[match.end() : end]) + _operands(code[end:])
    return _operands(code)


def _operands(code: str) -> list[list[str]]:
    groups: list[list[str]] = []
    open_groups = [[""]]
    for token in re.findall(r"\.and\.|\.or\.|[(),]|\.|[^(),.]+", code):
        if token in (".and.", ".or."):
            for group in open_groups[:-1]:
                group[-1] += token
            open_groups[-1].append("")
            continue
        if token in "),":
            groups.append(open_groups.pop())
        for group in open_groups:
            group[-1] += token
        if token in "(," or not open_groups:
            open_groups.append([""])
    return [group for group in groups + open_groups if len(group) > 1]


def _closing(code: str, at: int) -> int:
    """Return the index after the bracket that closes the one before an index."""
    depth = 1
    while depth and at < len(code):
        depth += {"(": 1, ")": -1}.get(code[at], 0)
        at += 1
    return at


def guards(operands: list[str], functions: set[str] = frozenset()) -> list[str]:
    """Return names that an expression tests in one operand, and uses unguarded in another operand.

    These are optional arguments and allocatables that are used, and compared scalars that are also
    an index or the bound of an array section.
    """
    names = []
    for i, operand in enumerate(operands):
        others = operands[:i] + operands[i + 1 :]
        for name in _STATUS.findall(operand):
            use = re.compile(rf"(?<![\w%]){re.escape(name)}(?!\w)")
            if any(use.search(_STATUS.sub("", other)) for other in others):
                names.append(name)
        names += [
            name
            for name in _compared(operand)
            if any(_has_index(other, name, functions) for other in others)
        ]
    return names


def _compared(operand: str) -> list[str]:
    """Return the plain names on either side of a comparison, unless they are on both sides."""
    plain = operand.replace(".not.", "").strip()
    while plain.startswith("(") and _closing(plain, 1) == len(plain):
        plain = plain[1:-1].strip()
    match = _COMPARED.fullmatch(plain)
    if not match:
        return []
    left, right = match[1].strip(), match[3].strip()
    return [
        name
        for name, other in ((left, right), (right, left))
        if re.fullmatch(r"[a-z]\w*", name) and not re.search(rf"(?<![\w%]){name}\b", other)
    ]


def _has_index(operand: str, name: str, functions: set[str]) -> bool:
    """Return whether a name is within brackets, except those of a function."""
    for match in _CALL.finditer(operand):
        arguments = operand[match.end() : _closing(operand, match.end()) - 1]
        plain = match[2] not in _INTRINSIC | functions
        if plain and re.search(rf"(?<![\w%]){name}(?!\w|\s*\()", arguments):
            return True
    return False


def functions_called(operands: list[str], scope: set[str]) -> set[str]:
    """Return the functions of the tree that operands call."""
    calls = (mark + name for operand in operands for mark, name in _CALL.findall(operand))
    return {name.removeprefix("%") for name in calls if name in scope}
