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
_PARSER_LOCK = threading.Lock()  # the engine stores only one parsed text


@dataclass(frozen=True)
class ParsedGroup:
    """A group in a text.

    `start`, `end`: indices of its first character and of the character after its slash.
    `values`: values of its variables: texts, numbers, logical values, or lists and arrays of these;
    `UNSET` marks a missing value.
    """

    name: str  # in lower case; it may be unknown
    line: int  # number of its first line, from 1
    start: int
    end: int
    values: dict = field(default_factory=dict)

    def called(self) -> str:
        """Return kind and name of the group, for messages."""
        return f"&{self.name} {self.values['name']!r}" if "name" in self.values else f"&{self.name}"

    def place(self, file) -> str:
        """Return file, group and line, for messages."""
        return f"{file}, group &{self.name} (line {self.line})"


def find_groups(
    text: str, file="input", skipped_variables: Sequence[str] = ()
) -> list[ParsedGroup]:
    """Return the groups of a text.

    Parameters
    ----------
    text : str
    file : path
        For messages.
    skipped_variables : sequence of str
        Groups whose values are skipped.

    Raises
    ------
    InputError
        If the text contains other things than groups, an unknown variable, or an unreadable value;
        the message names the line.
    """
    data = _encode_for_engine(text)
    with _PARSER_LOCK:
        sizes = checked(api.parse_input, _encode_for_engine(file), data or b" ",
                        " ".join(skipped_variables))  # fmt: skip
        groups, values, numbers, letters = api.parsed_input(*np.maximum(sizes, 1))
    result, values = (
        [],
        _variable_pairs(values.T[: sizes[1]].tolist(), numbers, bytes(letters.astype("u1"))),
    )
    indices = _character_indices(data, groups[1:3, : sizes[0]])
    for (line, begin, _, count), (start, end) in zip(groups.T[: sizes[0]], indices.T, strict=True):
        name = _NAME.match(data, begin)[0].decode().lower()
        group_values = dict(pair for _, pair in zip(range(count), values, strict=False))
        result.append(ParsedGroup(name, int(line), int(start) - 1, int(end), group_values))
    return result


def cited(message: str, file, source: Callable[[str, int], str]) -> str:
    """Replace line numbers of a generated text in a message by positions in the user's input."""
    pattern = rf"{re.escape(str(file))}, group &(\w+) \(line (\d+)\)"
    message = re.sub(pattern, lambda match: source(match[1], int(match[2])), message)
    reference = r"the &(\w+) of line (\d+)"
    return re.sub(reference, lambda match: f"that of {source(match[1], int(match[2]))}", message)


def with_changes(
    text: str, changes: Sequence[tuple[str, str | None]], file="input"
) -> tuple[str, list[Variable]]:
    """Return a text with changed variables, and these variables.

    `changes`: paths of variables and their values, as typed or as in the text of an input; None
    removes a variable.
    `file`: for messages.
    """
    if not changes:
        return text, []
    encoded = [
        [None if item is None else _encode_for_engine(item) for item in change]
        for change in changes
    ]
    lengths = [[-1 if item is None else len(item) for item in change] for change in encoded]
    buffer = b"".join(item for change in encoded for item in change if item)
    with _PARSER_LOCK:
        variables, size = checked(
            api.make_changes,
            _encode_for_engine(file),
            _encode_for_engine(text) or b" ",
            buffer,
            np.transpose(lengths),
        )
        letters = api.changed_text(size)
    changed = letters.astype("u1").tobytes().decode("utf-8", "surrogateescape")
    return changed, [_VARIABLES[position - 1] for position in variables]


def _encode_for_engine(text) -> bytes:
    """Return a text or path as bytes, as the engine expects them."""
    return str(text).encode("utf-8", "surrogateescape")


def _character_indices(data: bytes, indices: np.ndarray) -> np.ndarray:
    """Convert byte indices to character indices."""
    if data.isascii():
        return indices
    is_start = np.frombuffer(data, dtype="u1") & 0xC0 != 0x80
    return np.concatenate([[0], np.cumsum(is_start)])[indices]


def _variable_pairs(
    rows: list, numbers: np.ndarray, letters: bytes
) -> Iterator[tuple[str, object]]:
    """Yield names and values of the variables that the engine has parsed."""
    n = start = 0
    for position, count in rows:
        if not count:  # a null value counts as missing
            continue
        variable = _VARIABLES[position - 1]
        reals = numbers[n : n + count]
        n += count
        if variable.kind in ("name", "word", "text"):
            texts = []
            for length in reals.tolist():
                length = max(0, int(length))
                texts.append(letters[start : start + length].decode("utf-8", "surrogateescape"))
                start += length
            yield variable.name, texts if variable.size else "".join(texts)
        elif variable.size:
            yield variable.name, reals
        elif variable.kind == "logical":
            yield variable.name, bool(reals[0])
        else:
            value = float(reals[0])
            is_whole = variable.kind == "integer" and value.is_integer()
            yield variable.name, int(value) if is_whole else value


def groups_by_name(text: str) -> dict[str, list[dict]]:
    """Return the values of all groups by the kind of group."""
    groups: dict[str, list[dict]] = {}
    for group in find_groups(text):
        values = {n: v.tolist() if hasattr(v, "tolist") else v for n, v in group.values.items()}
        groups.setdefault(group.name, []).append(values)
    return groups


def input_values(attributes: Mapping) -> dict[str, list[dict]]:
    """Return the input values of an output: all groups except those of blocks.

    They include the defaults and derived values that the engine has written.

    `attributes`: of the output.
    """
    try:
        values = json.loads(str(attributes.get("input_values", "") or "{}"))
    except (ValueError, RecursionError):
        values = None
    valid = isinstance(values, dict) and all(isinstance(groups, list) for groups in values.values())
    if not valid or any(
        not isinstance(item, dict) for groups in values.values() for item in groups
    ):
        raise OutputError("the output is damaged: its attribute input_values is invalid")
    return values
