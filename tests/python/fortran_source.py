# SPDX-License-Identifier: GPL-3.0-or-later
"""The Fortran tree read line by line: modules, what they use, procedures and their arguments."""

from __future__ import annotations

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
    """A procedure of the tree.

    Attributes
    ----------
    where : str
        File and line.
    name : str
    arguments : list of str
    documented : set of str
        Arguments that a comment stands beside (``!<``) or before (``!>``).
    lines : int
        From its first statement to its end.
    """

    where: str
    name: str
    arguments: list[str]
    documented: set[str] = field(default_factory=set)
    lines: int = 0


@dataclass
class Source:
    """A file of the tree: its folder, modules, modules used, public names and procedures."""

    file: Path
    modules: set[str] = field(default_factory=set)
    used: set[str] = field(default_factory=set)
    public: set[str] = field(default_factory=set)
    procedures: list[Procedure] = field(default_factory=list)


def read_tree(folder: Path) -> list[Source]:
    """All Fortran files of a folder."""
    return [_read(file) for file in sorted(folder.rglob("*.f90"))]


def _read(file: Path) -> Source:
    source, open_procedures, foreign = Source(file), [], False
    for number, last, statement, documented in _statements(file.read_text().splitlines()):
        word = statement.split(None, 1)[0].lower().rstrip(":,") if statement.split() else ""
        if word == "module" and not re.match(r"\s*module\s+procedure\b", statement, re.I):
            source.modules.add(statement.split()[1].lower())
        elif word == "use" and "intrinsic" not in statement.lower():
            source.used.add(re.match(r"\s*use\s+(?:::)?\s*(\w+)", statement, re.I)[1].lower())
        elif word == "public":
            source.public |= _names(statement.split("public", 1)[1].lstrip(" :"))
        elif match := _INTERFACE.match(statement):
            foreign = not match[1]
        elif re.match(r"\s*end\s+interface\b", statement, re.I):
            foreign = False
        elif _END.match(statement):
            done = open_procedures.pop()
            done.lines = last - done.lines + 1
            if not foreign:
                source.procedures.append(done)
        elif match := _PROCEDURE.match(statement):
            where = f"{file}:{number}"
            names = [name.strip().lower() for name in (match[2] or "").split(",") if name.strip()]
            open_procedures.append(Procedure(where, match[1].lower(), names, lines=number))
        elif open_procedures and "::" in statement and documented:
            open_procedures[-1].documented |= _names(statement.split("::", 1)[1])
        elif match := _BINDING.match(statement):
            source.public |= {part.split("=>")[-1].strip() for part in match[1].lower().split(",")}
    return source


def _statements(lines: list[str]):
    """First and last line, statement, and whether a comment documents it."""
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
    """Code and comment of a line."""
    match = re.match(r"((?:[^'\"!]|'[^']*'|\"[^\"]*\")*)(.*)", line)
    return match[1], match[2]


def _names(text: str) -> set[str]:
    """Names of a list of declarations, without shapes and values."""
    while (flat := re.sub(r"\([^()]*\)", "", text)) != text:
        text = flat
    return {part.split("=")[0].strip().lower() for part in text.split(",")}
