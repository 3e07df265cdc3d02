# SPDX-License-Identifier: GPL-3.0-or-later
"""An input that the user edits, as text and as groups; each edit can be undone."""

import re
from pathlib import Path

import numpy as np

from ..base.errors import InputError
from ..input.groups import single_groups
from ..input.input_text import UNSET, ParsedGroup, find_groups, with_changes
from ..input.schema import GROUPS

MOST_TEXT = 8_000_000  # largest number of characters of an input
_VERSIONS = 400  # largest number of edits that can be undone
_MOST_GROUPS = 60  # largest number of groups of one kind that the forms show
_VALUES = 200  # number of values of the longest list that the forms show
_REFERENCE = re.compile(r"the name of a &(\w+)$")
_SET_ANGLE = 60  # angle between joint sets that the user adds, degrees
# Examples that replace those of the schema if these refer to parts of another model.
EXAMPLES = {
    "motion": "&motion name = 'shaking', quantity = 'acceleration', time_step = 0.1, "
    "values = 0, 1, 0, -1, 0, 1, 0, -1, 0 /",
    "stage": "&stage name = 'shaking', duration = 2 /",
    "fixed_point": "&fixed_point x = 1, y = 1 /",
}
_GROUP_AT_LINE = re.compile(r"group &(\w+) \(line (\d+)\)")


class Document:
    """An edited namelist text.

    `file`: file of the text, which need not exist; names of files in the text are relative to its
    folder.
    """

    def __init__(self, text: str, file):
        self.file = Path(file)
        self.text = text
        self.version = 0
        self._past: list[str] = []
        self._future: list[str] = []
        self._last: str | None = None  # last edited variable: edits of a slider are undone together

    # --- edits --------------------------------------------------------------------------------

    def write(self, text: str) -> None:
        """Replace the text."""
        self._replace_text(text, "text")

    def set(self, group: str, number: int, variable: str, value: str | None) -> None:
        """Set or remove a variable.

        `group`, `number`: kind of the group, and its number among the groups of this kind, from 1;
        `value`: value as in the input; None removes the variable.
        """
        index = "" if group in single_groups() else f"[{number}]"
        path = f"{group}{index}.{variable}"
        text, _ = with_changes(self.text, [(path, value)], self.file)
        find_groups(text, self.file, ("block",))  # rejects a value of another type
        self._replace_text(text, path)

    def add(self, group: str) -> None:
        """Add a group with the values of its example and a unique name."""
        kind = GROUPS.get(group)
        if kind is None:
            raise InputError(f"there is no group &{group}")
        groups = self.groups()
        peers = [peer for peer in groups if peer.name == group]
        if peers and not kind.repeats:
            raise InputError(f"&{group} exists already")
        example = EXAMPLES.get(group) or kind.example or f"&{group} /"
        line = _refer_to_existing(example, kind, groups)
        start = peers[-1].end if peers else self._insertion_point(kind, groups)
        line = _make_angle_unique(_make_name_unique(line, peers), peers)
        self._replace_text(f"{self.text[:start]}\n{line}{self.text[start:]}", "")

    def _insertion_point(self, kind, groups: list[ParsedGroup]) -> int:
        """Return the position after the last group that precedes this kind in the schema."""
        order = list(GROUPS)
        kinds = order[: order.index(kind.name)]
        ends = [existing.end for existing in groups if existing.name in kinds]
        return max(ends, default=len(self.text.rstrip()))

    def take_out(self, group: str, number: int) -> None:
        """Remove a group, and its lines if they contain nothing else."""
        peers = [peer for peer in self.groups() if peer.name == group]
        if not 0 < number <= len(peers):
            raise InputError(f"there is no &{group} number {number}")
        start, end = peers[number - 1].start, peers[number - 1].end
        line = self.text.rfind("\n", 0, start) + 1
        line_end = re.compile(r"[ \t]*\n").match(self.text, end)
        if not self.text[line:start].strip() and line_end:
            start, end = line, line_end.end()
        self._replace_text(self.text[:start] + self.text[end:], "")

    def undo(self) -> None:
        """Undo the last edit."""
        self._restore_text(self._past, self._future)

    def redo(self) -> None:
        """Redo the last edit that was undone."""
        self._restore_text(self._future, self._past)

    def _restore_text(self, source: list[str], target: list[str]) -> None:
        """Replace the text by the last one of `source`, and append the old text to `target`."""
        if source:
            target.append(self.text)
            self.text = source.pop()
            self.version += 1
            self._last = None

    def _replace_text(self, text: str, edited: str) -> None:
        """Replace the text; successive edits of one variable `edited` are undone together."""
        if len(text) > MOST_TEXT:
            raise InputError(f"the text has more than {MOST_TEXT:,} characters")
        if "\0" in text:
            raise InputError("the text contains a zero byte")
        if text == self.text:
            return
        if not edited or edited != self._last:
            self._past = [*self._past[1 - _VERSIONS :], self.text]
        self._future.clear()
        self._last = edited or None
        self.text = text
        self.version += 1

    def settle(self) -> None:
        """End a series of edits of a value; the next edit can be undone separately."""
        self._last = None

    # --- groups -------------------------------------------------------------------------------

    def groups(self) -> list[ParsedGroup]:
        """Return the groups of the text."""
        return find_groups(self.text, self.file)

    def described(self) -> dict:
        """Return text and groups as values for JSON; without groups if the text is invalid."""
        values = {
            "version": self.version,
            "file": self.file.name,
            "text": self.text,
            "undo": bool(self._past),
            "redo": bool(self._future),
        }
        try:
            return values | {"groups": _groups_as_values(self.groups())}
        except InputError:
            return values


def _groups_as_values(groups: list[ParsedGroup]) -> list[dict]:
    """Return at most `_MOST_GROUPS` groups of each kind, and the number of others, as JSON."""
    counts: dict[str, int] = {}
    result = []
    for group in groups:
        number = counts[group.name] = counts.get(group.name, 0) + 1
        if number <= _MOST_GROUPS:
            values = {name: _format_value(value) for name, value in group.values.items()}
            result.append({"name": group.name, "number": number, "line": group.line,
                           "values": values})  # fmt: skip
    for name, count in counts.items():
        if count > _MOST_GROUPS:
            result.append({"name": name, "number": 0, "more": count - _MOST_GROUPS, "values": {}})
    return result


def _format_value(value) -> str | None:
    """Format a value as in an input; return None for a list of more than `_VALUES` values."""
    if isinstance(value, bool):
        return ".true." if value else ".false."
    if isinstance(value, str):
        return value
    if isinstance(value, float):
        text = f"{value:.15g}"
        return text if float(text) == value else repr(value)
    if isinstance(value, list | np.ndarray):
        if len(value) > _VALUES:
            return None
        values = value.tolist() if isinstance(value, np.ndarray) else value
        return ", ".join("" if v == UNSET else _format_value(v) for v in values)
    return str(value)


def _refer_to_existing(example: str, kind, groups: list[ParsedGroup]) -> str:
    """Make an example refer to existing groups; return its line."""
    for variable in kind.variables:
        match = _REFERENCE.match(variable.values)
        if match is None:
            continue
        names = [g.values.get("name") for g in groups if g.name == match[1]]
        placeholder = re.search(rf",? {variable.name} = '([^']*)'", example)
        if placeholder is None or placeholder[1] in names:
            continue
        text = placeholder[0].replace(placeholder[1], names[0]) if names and names[0] else ""
        example = example.replace(placeholder[0], text).replace(f"&{kind.name},", f"&{kind.name}")
    return example


def _make_name_unique(example: str, peers: list[ParsedGroup]) -> str:
    """Number the name in an example if one of `peers` has this name; return its line."""
    names = {group.values.get("name") for group in peers}
    match = re.search(r"name = '([^']*)'", example)
    if match is None or match[1] not in names:
        return example
    number = next(i for i in range(2, len(names) + 3) if f"{match[1]}_{i}" not in names)
    return example.replace(match[0], f"name = '{match[1]}_{number}'", 1)


def _make_angle_unique(example: str, peers: list[ParsedGroup]) -> str:
    """Rotate the joint set of an example by multiples of 60° to a new angle; return its line."""
    match = re.search(r"\bangle = ([-\d.]+)", example)
    if match is None:
        return example
    angles = [float(group.values["angle"]) % 180 for group in peers if "angle" in group.values]
    candidates = (float(match[1]) + rotation for rotation in range(0, 180, _SET_ANGLE))
    angle = next((a for a in candidates if a % 180 not in angles), float(match[1]))
    return example.replace(match[0], f"angle = {angle:g}", 1)


def locate_error(message: str, text: str, file) -> dict:
    """Return the group, line, number and variable that a message of the engine names, if any."""
    match = _GROUP_AT_LINE.search(message)
    if match is None:
        return {}
    name, line = match[1], int(match[2])
    location = {"group": name, "line": line}
    try:
        peers = [peer for peer in find_groups(text, file) if peer.name == name]
    except InputError:
        return location
    number = next((i for i, peer in enumerate(peers, 1) if peer.line == line), 0)
    variables = [peer.name for peer in GROUPS[name].variables] if name in GROUPS else []
    terms = re.findall(r"\w+", message[match.end() :])
    variable = next((term for term in terms if term in variables), "")
    return location | {"number": number, "variable": variable}
