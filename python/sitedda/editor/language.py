# SPDX-License-Identifier: GPL-3.0-or-later
"""Information for an editor at a position of an input: completions, meaning, errors."""

import re
from dataclasses import dataclass
from pathlib import Path

from ..base.errors import SiteddaError
from ..engine.simulation import Simulation
from ..input.groups import variable_kinds
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

    `text`: the input; `line`, `column`: from 0.
    """
    spot = _context_at(text, _text_offset(text, line, column))
    if spot.comment:
        return []
    if spot.variable is not None:
        return [Offer(value if not spot.text else value.strip("'"), "value", spot.variable.meaning)
                for value in _listable_values(spot.variable)]  # fmt: skip
    if spot.group is None:
        return [Offer(f"&{g.name}", "group", g.meaning) for g in GROUPS.values()]
    return [Offer(v.name, "variable", _variable_summary(v)) for v in spot.group.variables
            if v.name not in spot.given]  # fmt: skip


def hover(text: str, line: int, column: int) -> str:
    """Return meaning, unit, default and values of the name at a position, as Markdown.

    `text`: the input; `line`, `column`: from 0.
    """
    row = text.split("\n")[line] if line < text.count("\n") + 1 else ""
    match = next((m for m in _NAME.finditer(row) if m.start() <= column <= m.end()), None)
    if match is None:
        return ""
    start = _text_offset(text, line, match.start())
    name, context = match[0].lower(), _context_at(text, start)
    if row[match.start() - 1 : match.start()] == "&" and name in GROUPS:
        group = GROUPS[name]
        return f"**&{name}**: {group.meaning}\n\n```\n{group.example}\n```"
    if context.group is None or context.comment or context.text:
        return ""
    variable = next((v for v in context.group.variables if v.name == name), None)
    return "" if variable is None else f"**{variable.name}**: {_variable_summary(variable)}"


def problems(text: str, file) -> list[Problem]:
    """Return the errors of an input; the engine reports only the first one.

    `text`: the input, saved or not; `file`: file of the input; names of other files are relative to
    its folder.
    """
    try:
        Simulation(InputOfRun(Path(file), text)).close()
    except SiteddaError as error:
        return [_locate_problem(text, str(error), file)]
    return []


def _locate_problem(text: str, message: str, file) -> Problem:
    """Return a message with its position: the variable, else the group, else the first line."""
    rows = text.split("\n")
    match = re.search(_PLACE.format(file=re.escape(str(file))), message)
    if match is None:
        return Problem(0, 0, len(rows[0]), message)
    names = variable_kinds().get(match[1].lower(), {})
    mentioned = [name for name in _NAME.findall(message[match.end() :]) if name in names]
    start = min(int(match[2]), len(rows)) - 1
    for name in mentioned[:1]:
        for number in range(start, len(rows)):
            code = rows[number].split("!")[0]
            if occurrence := re.search(rf"(?i)\b{name}\b(?=[\s(\d:,)]*=)", code):
                return Problem(number, occurrence.start(), occurrence.end(), message)
    return Problem(start, 0, len(rows[start]), message)


def _text_offset(text: str, line: int, column: int) -> int:
    """Return the index of a character from its line and column, all from 0."""
    rows = text.split("\n")
    return sum(len(row) + 1 for row in rows[:line]) + column


def _context_at(text: str, offset: int) -> _Position:
    """Return group and variable at an index of a text, from the tokens before this index."""
    group, variable, used, previous = None, None, set(), ""
    for token in _TOKEN.finditer(text):
        if token.start() >= offset:
            break
        item, at_cursor = token[0], token.end() >= offset
        if item[0] == "!" and at_cursor:
            return _Position(comment=True)
        if item[0] in "'\"" and at_cursor and (token.end() > offset or item[-1:] != item[0]):
            return _Position(group, variable, frozenset(used), text=True)
        if item[0] == "&" and not at_cursor:
            group, variable, used = GROUPS.get(item[1:].lower()), None, set()
        elif item == "/":
            group, variable = None, None
        elif item == "=" and group is not None:
            variable = next((v for v in group.variables if v.name == previous), None)
            used.add(previous)
        if _NAME.fullmatch(item):
            previous = item.lower()
            variable = variable if at_cursor and variable is not None else None
    return _Position(group, variable, frozenset(used))


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
    required = variable.default == "required"
    parts.append("required" if required else f"default: {variable.default}")
    return "; ".join(parts + ([f"if {variable.when}"] if variable.when else []))
