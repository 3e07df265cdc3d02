# SPDX-License-Identifier: GPL-3.0-or-later
"""The groups of an input, their variables, and their text."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache

import numpy as np

from . import masonry
from .cutting import geometry
from .errors import InputError
from .namelist import value_text
from .schema import GROUPS, Variable

# Kinds of values: text, texts, number, numbers, points (x, y, x, y …), whole (number), logical.
_KINDS = {"name": "text", "word": "text", "text": "text", "real": "number", "integer": "whole"}
_KINDS |= {"logical": "logical", "points": "points"}

# What is turned into blocks before the engine reads it.
CUT = {
    "region": geometry.Region,
    "surface": geometry.Surface,
    "joint_line": geometry.JointLine,
    "joint_set": geometry.JointSet,
    "voronoi": geometry.Voronoi,
    "hole": geometry.Hole,
    "tunnel": geometry.Tunnel,
    "excavation": geometry.Excavation,
    "cutting": geometry.Cutting,
}
MASONRY = {
    "arch": masonry.Arch,
    "pier": masonry.Pier,
    "lintel": masonry.Lintel,
    "colonnade": masonry.Colonnade,
    "retaining_wall": masonry.RetainingWall,
    "multi_leaf_wall": masonry.MultiLeafWall,
}
# Groups whose points may come from a file: the variable that holds them.
FROM_FILE = {"region": "outline", "hole": "outline", "excavation": "outline"}
FROM_FILE |= {"surface": "points", "joint_line": "points"}


@cache
def single_groups() -> tuple[str, ...]:
    """Names of the groups that may appear only once in an input."""
    return tuple(name for name, group in GROUPS.items() if not group.repeats)


@cache
def variables() -> dict[str, dict[str, str]]:
    """The kind of each variable of each group."""
    return {name: {v.name: _kind(v) for v in group.variables} for name, group in GROUPS.items()}


def _kind(variable: Variable) -> str:
    many = "s" if variable.size and variable.kind != "points" else ""
    return _KINDS[variable.kind] + many


def is_made(name: str) -> bool:
    """Whether a group is turned into blocks before the engine reads the input."""
    return name in GROUPS and GROUPS[name].built


def nearest(word: str, known) -> str:
    """A hint at the most similar of the known words, or nothing."""
    close = get_close_matches(word, list(known), 1)
    return f"; did you mean {close[0]!r}?" if close else ""


def known_group(name: str) -> str:
    """The name of a group, if there is one."""
    if name not in variables():
        raise InputError(f"there is no group &{name}{nearest(name, variables())}")
    return name


def known_variable(group: str, name: str) -> str:
    """The kind of a variable of a group, if there is one."""
    known = variables()[group]
    if name not in known:
        hint = nearest(name, known) or f"; it has {', '.join(known)}"
        raise InputError(f"group &{group} has no variable {name!r}{hint}")
    return known[name]


def checked(group: str, name: str, value):
    """A value as a variable holds it; arrays become arrays of their own that cannot change."""
    kind = known_variable(group, name)
    try:
        return _CONVERT[kind](value)
    except InputError as error:
        raise InputError(f"&{group}: {name}: {error}") from None
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"&{group}: {name} = {value!r} is no {_WORDS[kind]}") from None


def _text(value) -> str:
    if not isinstance(value, str) and not hasattr(value, "__fspath__"):
        raise TypeError
    value = str(value)
    if "\0" in value or "\n" in value:
        raise InputError("a text must be one line")
    return value


def _texts(value) -> tuple[str, ...]:
    return (_text(value),) if isinstance(value, str) else tuple(_text(one) for one in value)


def _number(value) -> float:
    if isinstance(value, str | bool | np.bool_) or np.ndim(value):
        raise TypeError
    value = float(value)
    if not np.isfinite(value):
        raise InputError(f"{value} is not a usable number")
    return value


def _whole(value) -> int:
    number = _number(value)
    if number != int(number):
        raise ValueError
    return int(value)


def _numbers(value) -> np.ndarray:
    if np.iscomplexobj(value):
        raise TypeError
    array = np.array(value, dtype=float).ravel()
    if not np.isfinite(array).all():
        raise InputError(f"value {int(np.flatnonzero(~np.isfinite(array))[0]) + 1} is no number")
    array.flags.writeable = False
    return array


def _points(value) -> np.ndarray:
    array = _numbers(geometry.points_of("points", value, 1))
    return array.reshape(-1, 2)


def _logical(value) -> bool:
    if not isinstance(value, bool | np.bool_):
        raise TypeError
    return bool(value)


_CONVERT = {"text": _text, "texts": _texts, "number": _number, "numbers": _numbers}
_CONVERT |= {"points": _points, "whole": _whole, "logical": _logical}
_WORDS = {"text": "text", "texts": "list of texts", "number": "number", "whole": "whole number"}
_WORDS |= {
    "logical": "logical value",
    "numbers": "list of numbers",
    "points": "list of points x, y",
}


# --- Text ----------------------------------------------------------------------------------------


def group_text(name: str, values: dict) -> str:
    """A group on one line."""
    return f"&{name} " + ", ".join(f"{k} = {_value_text(v)}" for k, v in values.items()) + " /\n"


def _value_text(value) -> str:
    return value_text(value.ravel().tolist() if isinstance(value, np.ndarray) else value)


@dataclass(frozen=True)
class Found:
    """A group in a text.

    Attributes
    ----------
    name : str
    line : int
        Where it begins, from 1.
    start, end : int
        Its first character and the one after its slash.
    body : str
        Between its name and its slash, comments taken out.
    """

    name: str
    line: int
    start: int
    end: int
    body: str

    def place(self, file) -> str:
        """Where it stands, for messages."""
        return f"{file}, group &{self.name} (line {self.line})"


_QUOTED = r"'(?:[^']|'')*'|\"(?:[^\"]|\"\")*\""
_MARKS = re.compile(rf"{_QUOTED}|![^\n]*|[&/]")
_COMMENT = re.compile(rf"({_QUOTED})|![^\n]*")
_ASSIGNMENT = re.compile(rf"{_QUOTED}|([A-Za-z]\w*)\s*(\([^()]*\)|%\s*\w+)?\s*=")
_ITEM = re.compile(rf"\s*(?:(\d+)\*)?({_QUOTED}|[^\s,'\"]+)\s*(,?)")


def find_groups(text: str) -> Iterator[Found]:
    """The groups of a namelist text; the engine judges what stands between them."""
    line, counted, start = 1, 0, None
    for mark in _MARKS.finditer(text):
        if mark[0] == "&" and start is None:
            start = mark.start()
        elif mark[0] == "/" and start is not None:
            line += text.count("\n", counted, start)
            counted = start
            name = re.match(r"\w*", text[start + 1 : mark.end()])[0]
            body = text[start + 1 + len(name) : mark.start()]
            body = _COMMENT.sub(lambda found: found[1] or "", body)
            yield Found(name.lower(), line, start, mark.end(), body)
            start = None


def read_values(found: Found, file) -> dict:
    """The variables of a group and their values.

    Raises
    ------
    InputError
        If a variable is not known, or a value cannot be read; the message names the place.
    """
    try:
        known_group(found.name)
        values = {}
        given = [match for match in _ASSIGNMENT.finditer(found.body) if match[1]]
        begin = given[0].start() if given else len(found.body)
        if found.body[:begin].strip(" \t\r\n,"):
            raise InputError(f"{found.body[:begin].strip()[:40]!r} is no variable")
        ends = [match.start() for match in given[1:]] + [len(found.body)]
        for match, end in zip(given, ends, strict=False):
            name = match[1].lower()
            if match[2]:
                raise InputError(f"{name}{match[2]}: give the whole array, without an index")
            if name in values:
                raise InputError(f"{name} is given twice")
            values[name] = _read(found.name, name, found.body[match.end() : end])
        return values
    except InputError as error:
        raise InputError(f"{found.place(file)}: {error}") from None


def _read(group: str, name: str, text: str):
    """The value of a variable from its text."""
    kind = known_variable(group, name)
    if kind in ("numbers", "points"):
        quick = text.strip().rstrip(",")
        if not re.search(r"[^-+.\d\seE,]|,\s*,", quick):
            try:
                return checked(group, name, [float(one) for one in quick.replace(",", " ").split()])
            except ValueError:
                pass
    items, at = [], 0
    text = text.rstrip(" \t\r\n")
    while at < len(text):
        item = _ITEM.match(text, at)
        if not item:
            raise InputError(
                f"{name}: a value is left out or cannot be read: {text.strip()[:40]!r}"
            )
        count = int(item[1] or 1)
        if count > 1_000_000:
            raise InputError(f"{name}: {count} equal values are too many")
        items += [_item(name, item[2], kind)] * count
        at = item.end()
    if not items:
        raise InputError(f"{name} has no value")
    if kind in ("text", "number", "whole", "logical"):
        if len(items) > 1:
            raise InputError(f"{name} holds one value, {len(items)} are given")
        return checked(group, name, items[0])
    return checked(group, name, items)


def _item(name: str, text: str, kind: str):
    if text[0] in "'\"":
        if not kind.startswith("text"):
            raise InputError(f"{name}: {text[:40]} is no number")
        return text[1:-1].replace(text[0] * 2, text[0]).rstrip(" ")
    if kind == "logical":
        if not re.match(r"\.?[tf]", text, re.I):
            raise InputError(f"{name}: {text[:40]} is neither .true. nor .false.")
        return text.lstrip(".")[0] in "tT"
    if kind.startswith("text"):
        raise InputError(f"{name}: {text[:40]} must stand in quotes")
    try:
        if kind == "whole" and re.fullmatch(r"[-+]?\d+", text):
            return int(text)
        return float(re.sub("[dDqQ]", "e", text))
    except ValueError:
        raise InputError(f"{name}: {text[:40]!r} is no number") from None
