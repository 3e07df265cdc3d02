# SPDX-License-Identifier: GPL-3.0-or-later
"""Check messages of the page: JSON objects with a command and its fields.

Messages with other commands, fields or types are rejected with an error.
"""

import json

from ..base.errors import InputError

LONGEST_MESSAGE = 9_000_000  # largest size of a message, bytes; sufficient for the longest input
_MOST_MEMBERS = 20  # largest number of members of an object
_SHORT_TEXT = 4096  # largest number of characters of a short text


def _is_short_text(value) -> bool:
    return isinstance(value, str) and len(value) <= _SHORT_TEXT and value.isprintable()


def _is_positive_integer(value) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 < value < 2**31


def _is_text_or_none(value) -> bool:
    return value is None or (isinstance(value, str) and len(value) <= 20 * _SHORT_TEXT)


def _is_dict_of_texts(value) -> bool:
    return isinstance(value, dict) and 0 < len(value) <= _MOST_MEMBERS and all(
        _is_short_text(name) and _is_short_text(text) for name, text in value.items()
    )  # fmt: skip


# The fields of each command; all are required.
COMMANDS = {
    "open": {"source": _is_short_text, "name": _is_short_text},
    "leave": {},
    "write": {"text": lambda value: isinstance(value, str)},
    "set": {
        "group": _is_short_text,
        "number": _is_positive_integer,
        "variable": _is_short_text,
        "value": _is_text_or_none,
    },
    "settle": {},
    "add": {"group": _is_short_text},
    "take_out": {"group": _is_short_text, "number": _is_positive_integer},
    "record": {"number": _is_positive_integer, "name": _is_short_text},
    "undo": {},
    "redo": {},
    "check": {},
    "rest": {},
    "run": {},
    "pause": {},
    "step": {"steps": _is_positive_integer},
    "stop": {},
    "back": {},
    "change": {"values": _is_dict_of_texts},
    "stage": {"values": _is_dict_of_texts},
    "save": {"what": _is_short_text, "name": _is_short_text},
}


def read_message(data: str | bytes) -> tuple[str, dict]:
    """Return the command of a message and its fields."""
    if not isinstance(data, str):
        raise InputError("a message must be a text")
    if len(data) > LONGEST_MESSAGE:
        raise InputError(f"a message can have at most {LONGEST_MESSAGE:,} characters")
    try:
        fields_given = json.loads(data)
    except (ValueError, RecursionError):
        raise InputError("the message is not JSON") from None
    if not isinstance(fields_given, dict) or not isinstance(fields_given.get("do"), str):
        raise InputError("a message must be an object with the command 'do'")
    command = fields_given.pop("do")
    fields = COMMANDS.get(command)
    if fields is None:
        raise InputError(f"there is no command {command[:40]!r}")
    if fields_given.keys() != fields.keys():
        raise InputError(f"{command} has the fields {', '.join(fields) or 'none'}")
    for name, is_valid in fields.items():
        if not is_valid(fields_given[name]):
            raise InputError(f"{command}: the field {name} has an invalid value")
    return command, fields_given
