# SPDX-License-Identifier: GPL-3.0-or-later
"""Parse the text of an input into groups of values with the reader of the engine."""

import json
import re
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..base.core import api, checked
from ..base.errors import OutputError
from .schema import GROUPS, Variable

_VARIABLES = [variable for group in GROUPS.values() for variable in group.variables]
_NAME = re.compile(rb"\w*")
UNSET = -np.finfo(float).max  # mark of a missing value, as in the engine
_ONE = threading.Lock()  # the engine stores only one parsed text


@dataclass(frozen=True)
class Found:
    """A group in a text.

    Attributes
    ----------
    name : str
        In lower case; it may be unknown.
    line : int
        Number of its first line, from 1.
    start, end : int
        Indices of its first character and of the character after its slash.
    values : dict
        Values of its variables: texts, numbers, logical values, or lists and arrays of these;
        `UNSET` marks a missing value.
    """

    name: str
    line: int
    start: int
    end: int
    values: dict = field(default_factory=dict)

    def called(self) -> str:
        """Return kind and name of the group, for messages."""
        return f"&{self.name} {self.values['name']!r}" if "name" in self.values else f"&{self.name}"

    def place(self, file) -> str:
        """Return file, group and line, for messages."""
        return f"{file}, group &{self.name} (line {self.line})"


def find_groups(text: str, file="input", skipped: Sequence[str] = ()) -> list[Found]:
    """Return the groups of a text.

    Parameters
    ----------
    text : str
    file : path
        For messages.
    skipped : sequence of str
        Groups whose values are skipped.

    Raises
    ------
    InputError
        If the text contains other things than groups, an unknown variable, or an unreadable value;
        the message names the line.
    """
    data = _encode_for_engine(text)
    with _ONE:
        sizes = checked(api.parse_input, _encode_for_engine(file), data or b" ", " ".join(skipped))
        groups, values, numbers, letters = api.parsed_input(*np.maximum(sizes, 1))
    found, values = (
        [],
        _variable_pairs(values.T[: sizes[1]].tolist(), numbers, bytes(letters.astype("u1"))),
    )
    places = _character_indices(data, groups[1:3, : sizes[0]])
    for (line, first, _, count), (start, end) in zip(groups.T[: sizes[0]], places.T, strict=True):
        name = _NAME.match(data, first)[0].decode().lower()
        own = dict(one for _, one in zip(range(count), values, strict=False))
        found.append(Found(name, int(line), int(start) - 1, int(end), own))
    return found


def cited(message: str, file, place: Callable[[str, int], str]) -> str:
    """Replace line numbers of a generated text in a message by positions in the user's input."""
    where = rf"{re.escape(str(file))}, group &(\w+) \(line (\d+)\)"
    message = re.sub(where, lambda found: place(found[1], int(found[2])), message)
    other = r"the &(\w+) of line (\d+)"
    return re.sub(other, lambda found: f"that of {place(found[1], int(found[2]))}", message)


def with_changes(
    text: str, changes: Sequence[tuple[str, str | None]], file="input"
) -> tuple[str, list[Variable]]:
    """Return a text with changed variables, and these variables.

    Parameters
    ----------
    text : str
    changes : sequence of (str, str or None)
        Paths of variables and their values, as typed or as in the text of an input; None removes a
        variable.
    file : path
        For messages.

    Raises
    ------
    InputError
        If the text contains other things than groups, or a path is ambiguous or unknown.
    """
    if not changes:
        return text, []
    words = [
        [None if one is None else _encode_for_engine(one) for one in change] for change in changes
    ]
    lengths = [[-1 if one is None else len(one) for one in change] for change in words]
    joined = b"".join(one for change in words for one in change if one)
    with _ONE:
        variables, size = checked(
            api.make_changes,
            _encode_for_engine(file),
            _encode_for_engine(text) or b" ",
            joined,
            np.transpose(lengths),
        )
        letters = api.changed_text(size)
    new = letters.astype("u1").tobytes().decode("utf-8", "surrogateescape")
    return new, [_VARIABLES[position - 1] for position in variables]


def _encode_for_engine(text) -> bytes:
    """Return a text or path as bytes, as the engine expects them."""
    return str(text).encode("utf-8", "surrogateescape")


def _character_indices(data: bytes, places: np.ndarray) -> np.ndarray:
    """Convert byte indices to character indices."""
    if data.isascii():
        return places
    begins = np.frombuffer(data, dtype="u1") & 0xC0 != 0x80
    return np.concatenate([[0], np.cumsum(begins)])[places]


def _variable_pairs(
    rows: list, numbers: np.ndarray, letters: bytes
) -> Iterator[tuple[str, object]]:
    """Yield names and values of the variables that the engine has parsed."""
    n = at = 0
    for position, count in rows:
        if not count:  # a null value counts as missing
            continue
        variable = _VARIABLES[position - 1]
        given = numbers[n : n + count]
        n += count
        if variable.kind in ("name", "word", "text"):
            texts = []
            for length in given.tolist():
                length = max(0, int(length))
                texts.append(letters[at : at + length].decode("utf-8", "surrogateescape"))
                at += length
            yield variable.name, texts if variable.size else "".join(texts)
        elif variable.size:
            yield variable.name, given
        elif variable.kind == "logical":
            yield variable.name, bool(given[0])
        else:
            value = float(given[0])
            whole = variable.kind == "integer" and value.is_integer()
            yield variable.name, int(value) if whole else value


def groups_by_name(text: str) -> dict[str, list[dict]]:
    """Return the values of all groups by the kind of group."""
    groups: dict[str, list[dict]] = {}
    for one in find_groups(text):
        plain = {n: v.tolist() if hasattr(v, "tolist") else v for n, v in one.values.items()}
        groups.setdefault(one.name, []).append(plain)
    return groups


def input_values(attributes: Mapping) -> dict[str, list[dict]]:
    """Return the input values of an output: all groups except those of blocks.

    They include the defaults and derived values that the engine has written.

    Parameters
    ----------
    attributes : mapping
        Of the output.

    Raises
    ------
    OutputError
        If the attribute with the values is damaged.
    """
    try:
        found = json.loads(str(attributes.get("input_values", "") or "{}"))
    except (ValueError, RecursionError):
        found = None
    whole = isinstance(found, dict) and all(isinstance(groups, list) for groups in found.values())
    if not whole or any(not isinstance(one, dict) for groups in found.values() for one in groups):
        raise OutputError("the output is damaged: its attribute input_values is invalid")
    return found
