# SPDX-License-Identifier: GPL-3.0-or-later
"""Information for an editor at a position of an input: completions, meaning, errors."""

import re
from dataclasses import dataclass
from pathlib import Path

from ..base.errors import SiteddaError
from ..engine.simulation import Simulation
from ..input.groups import variables
from ..input.schema import GROUPS, Group, Variable
from ..input.source import InputOfRun

_NAME = re.compile(r"\w+")
_TOKEN = re.compile(r"!.*|'[^']*(?:'|$)|\"[^\"]*(?:\"|$)|&\w*|\w[\w.+-]*|[/=(),]|\S", re.MULTILINE)
_PLACE = r"{file}, group &(\w+) \(line (\d+)\)"


@dataclass(frozen=True)
class Problem:
    """An error of an input: line and columns (from 0), and the message of the engine."""

    line: int
    start: int
    end: int
    message: str


@dataclass(frozen=True)
class Offer:
    """A completion: word, kind ('group', 'variable' or 'value') and meaning."""

    word: str
    kind: str
    meaning: str


@dataclass(frozen=True)
class _Position:
    """Group and variable at a position, earlier variables of the group, and kind of token."""

    group: Group | None = None
    variable: Variable | None = None
    given: frozenset[str] = frozenset()
    comment: bool = False
    text: bool = False


def offers(text: str, line: int, column: int) -> list[Offer]:
    """Return the completions at a position.

    Parameters
    ----------
    text : str
        The input.
    line, column : int
        From 0.
    """
    at = _context_at(text, _text_offset(text, line, column))
    if at.comment:
        return []
    if at.variable is not None:
        return [Offer(word if not at.text else word.strip("'"), "value", at.variable.meaning)
                for word in _listable_values(at.variable)]  # fmt: skip
    if at.group is None:
        return [Offer(f"&{g.name}", "group", g.meaning) for g in GROUPS.values()]
    return [Offer(v.name, "variable", _variable_summary(v)) for v in at.group.variables
            if v.name not in at.given]  # fmt: skip


def hover(text: str, line: int, column: int) -> str:
    """Return meaning, unit, default and values of the name at a position, as Markdown.

    Parameters
    ----------
    text : str
        The input.
    line, column : int
        From 0.
    """
    row = text.split("\n")[line] if line < text.count("\n") + 1 else ""
    found = next((m for m in _NAME.finditer(row) if m.start() <= column <= m.end()), None)
    if found is None:
        return ""
    start = _text_offset(text, line, found.start())
    word, at = found[0].lower(), _context_at(text, start)
    if row[found.start() - 1 : found.start()] == "&" and word in GROUPS:
        group = GROUPS[word]
        return f"**&{word}**: {group.meaning}\n\n```\n{group.example}\n```"
    if at.group is None or at.comment or at.text:
        return ""
    variable = next((v for v in at.group.variables if v.name == word), None)
    return "" if variable is None else f"**{variable.name}**: {_variable_summary(variable)}"


def problems(text: str, file) -> list[Problem]:
    """Return the errors of an input; the engine reports only the first one.

    Parameters
    ----------
    text : str
        The input, saved or not.
    file : path
        File of the input; names of other files are relative to its folder.
    """
    try:
        Simulation(InputOfRun(Path(file), text)).close()
    except SiteddaError as error:
        return [_locate_problem(text, str(error), file)]
    return []


def _locate_problem(text: str, message: str, file) -> Problem:
    """Return a message with its position: the variable, else the group, else the first line."""
    rows = text.split("\n")
    place = re.search(_PLACE.format(file=re.escape(str(file))), message)
    if place is None:
        return Problem(0, 0, len(rows[0]), message)
    known = variables().get(place[1].lower(), {})
    named = [word for word in _NAME.findall(message[place.end() :]) if word in known]
    first = min(int(place[2]), len(rows)) - 1
    for word in named[:1]:
        for number in range(first, len(rows)):
            if found := re.search(rf"(?i)\b{word}\b(?=[\s(\d:,)]*=)", rows[number].split("!")[0]):
                return Problem(number, found.start(), found.end(), message)
    return Problem(first, 0, len(rows[first]), message)


def _text_offset(text: str, line: int, column: int) -> int:
    """Return the index of a character from its line and column, all from 0."""
    rows = text.split("\n")
    return sum(len(row) + 1 for row in rows[:line]) + column


def _context_at(text: str, offset: int) -> _Position:
    """Return group and variable at an index of a text, from the tokens before this index."""
    group, variable, given, last = None, None, set(), ""
    for token in _TOKEN.finditer(text):
        if token.start() >= offset:
            break
        word, inside = token[0], token.end() >= offset
        if word[0] == "!" and inside:
            return _Position(comment=True)
        if word[0] in "'\"" and inside and (token.end() > offset or word[-1:] != word[0]):
            return _Position(group, variable, frozenset(given), text=True)
        if word[0] == "&" and not inside:
            group, variable, given = GROUPS.get(word[1:].lower()), None, set()
        elif word == "/":
            group, variable = None, None
        elif word == "=" and group is not None:
            variable = next((v for v in group.variables if v.name == last), None)
            given.add(last)
        if _NAME.fullmatch(word):
            last = word.lower()
            variable = variable if inside and variable is not None else None
    return _Position(group, variable, frozenset(given))


def _listable_values(variable: Variable) -> list[str]:
    """Return the possible values of a variable as text, if it has a finite number of them."""
    if variable.kind == "logical":
        return [".true.", ".false."]
    return re.findall(r"'[^']*'", variable.values) if variable.kind == "word" else []


def _variable_summary(variable: Variable) -> str:
    """Return meaning, kind, unit, values, default and condition of a variable as text."""
    kind = variable.kind + (f", at most {variable.size}" if variable.size else "")
    parts = [f"{variable.meaning} ({kind}{', ' + variable.unit if variable.unit else ''})"]
    parts += [f"values: {variable.values}"] if variable.values else []
    parts += [
        variable.default if variable.default == "required" else f"default: {variable.default}"
    ]
    return "; ".join(parts + ([f"if {variable.when}"] if variable.when else []))
