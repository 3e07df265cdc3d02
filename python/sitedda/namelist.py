# SPDX-License-Identifier: GPL-3.0-or-later
"""Namelist text: groups written from Python values, and values replaced in a text that is kept."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

# A quoted text, a comment, or a character that may end a value.
_TOKEN = re.compile(r"'[^']*'?|\"[^\"]*\"?|![^\n]*|[&/\n]")
_ASSIGNMENT = re.compile(r"'[^']*'?|\"[^\"]*\"?|![^\n]*|([A-Za-z]\w*)\s*(?:\([^()]*\)\s*)?=")


class Verbatim(str):
    """A value in the words of a namelist, which stay as they are."""


def value_text(value) -> str:
    """A value as a namelist holds it: text, number, logical, or a sequence of them."""
    if isinstance(value, Verbatim):
        return str(value)
    if isinstance(value, str):
        return "'" + value.replace("'", "''") + "'"
    if isinstance(value, bool | np.bool_):
        return ".true." if value else ".false."
    if isinstance(value, int | np.integer):
        return str(int(value))
    if isinstance(value, float | np.floating):
        return repr(float(value))
    if isinstance(value, Iterable) and not isinstance(value, Mapping | bytes):
        return ", ".join(map(value_text, value))
    raise TypeError(f"a namelist cannot hold {value!r}")


def group_text(name: str, values: Mapping) -> str:
    """One group with its variables; those that are None are left out."""
    lines = [
        f"   {variable} = {value_text(value)}"
        for variable, value in values.items()
        if value is not None
    ]
    return "\n".join([f"&{name}", *lines, "/"]) + "\n"


def namelist_text(groups: Iterable[tuple[str, Mapping]]) -> str:
    """The text of pairs (name of the group, its variables)."""
    return "".join(group_text(name, values) for name, values in groups)


@dataclass
class Group:
    """A group of a namelist text.

    Attributes
    ----------
    name : str
        In lower case.
    text : str
        From its ``&`` to its closing slash.
    """

    name: str
    text: str

    def _assignments(self) -> Iterator[tuple[str, int, int, int]]:
        """Name of each variable, where its assignment begins, its value begins, and ends."""
        found = [match for match in _ASSIGNMENT.finditer(self.text) if match[1]]
        ends = [*(match.start() for match in found[1:]), len(self.text) - 1][: len(found)]
        for match, end in zip(found, ends, strict=True):
            yield match[1].lower(), match.start(), match.end(), end

    def get(self, variable: str) -> str | None:
        """The text of a variable's value without quotes and comments; None if it is not given."""
        for name, _, begin, end in self._assignments():
            if name == variable:
                value = _TOKEN.sub(lambda m: "" if m[0][0] in "!\n" else m[0], self.text[begin:end])
                value = value.strip().rstrip(",").rstrip()
                quote = value[:1]
                return value[1:-1].strip() if quote in ("'", '"') else value
        return None

    def set(self, variable: str, value) -> None:
        """Give a variable another value, or none; every line of the text keeps its number."""
        new = "" if value is None else f"{variable} = {value_text(value)}"
        places = [item for item in self._assignments() if item[0] == variable]
        for count, (_, start, begin, end) in reversed(list(enumerate(places))):
            whole = self.text[begin:end]
            given = whole[: _length(whole)]
            lines = "".join(re.findall(r"\r?\n", given))
            kept = "" if count else new
            self.text = self.text[:start] + kept + lines + whole[len(given) :] + self.text[end:]
        if new and not places:
            self.text = f"{self.text[:-1].rstrip(' ')} {new} /"


def _length(text: str) -> int:
    """Length of a value without the blanks, line ends and comments that follow it."""
    length = at = 0
    for token in [*_TOKEN.finditer(text), None]:
        between = text[at : token.start() if token else len(text)].rstrip()
        length = at + len(between) if between else length
        if token is None:
            break
        at = token.end()
        if token[0][0] not in "!\n":
            length = at
    return length


@dataclass
class Namelist:
    """A namelist text, cut into its groups and what stands between them.

    Attributes
    ----------
    groups : list of Group
        In the order of the text.
    """

    groups: list[Group]
    _between: list[str]

    @classmethod
    def of(cls, text: str) -> Namelist:
        """The groups of a text; what follows a group that is not closed is left as it is."""
        groups, between, at = [], [], 0
        while (span := _next_group(text, at)) is not None:
            begin, end = span
            name = re.match(r"\w*", text[begin + 1 : end])[0].lower()
            groups.append(Group(name, text[begin:end]))
            between.append(text[at:begin])
            at = end
        return cls(groups, [*between, text[at:]])

    def named(self, name: str) -> list[Group]:
        """All groups of a name."""
        return [group for group in self.groups if group.name == name]

    def add(self, name: str) -> Group:
        """A new group without variables, at the end of the text."""
        group = Group(name, f"&{name} /")
        tail = self._between[-1]
        self._between[-1] = tail if tail.endswith("\n") or not tail else tail + "\n"
        self._between.append("\n")
        self.groups.append(group)
        return group

    def __str__(self) -> str:
        """The text."""
        pairs = zip(self._between, (group.text for group in self.groups), strict=False)
        return "".join(part for pair in pairs for part in pair) + self._between[-1]


def _next_group(text: str, at: int) -> tuple[int, int] | None:
    """Where the next group begins and where its closing slash ends; None if there is none."""
    begin = None
    for token in _TOKEN.finditer(text, at):
        if token[0] == "&":
            if begin is not None:
                return None
            begin = token.start()
        elif token[0] == "/" and begin is not None:
            return begin, token.end()
    return None
