# SPDX-License-Identifier: GPL-3.0-or-later
"""Messages of the page: JSON objects with a command and its fields, all of known kinds.

Other messages are refused in one sentence and not executed.
"""

import json

from ..base.errors import InputError

MOST = 9_000_000  # bytes of a message: a text of the largest size
_FEW = 20  # members of an object
_LONG = 4096  # characters of a value


def _text(value) -> bool:
    return isinstance(value, str) and len(value) <= _LONG and value.isprintable()


def _whole(value) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 < value < 2**31


def _value(value) -> bool:
    return value is None or (isinstance(value, str) and len(value) <= 20 * _LONG)


def _values(value) -> bool:
    return isinstance(value, dict) and 0 < len(value) <= _FEW and all(
        _text(name) and isinstance(one, str) and _text(one) for name, one in value.items()
    )  # fmt: skip


def _long_text(value) -> bool:
    return isinstance(value, str)


# The fields of each command, all of which it has.
COMMANDS = {
    "open": {"source": _text, "name": _text},
    "leave": {},
    "write": {"text": _long_text},
    "set": {"group": _text, "number": _whole, "variable": _text, "value": _value},
    "settle": {},
    "add": {"group": _text},
    "take_out": {"group": _text, "number": _whole},
    "record": {"number": _whole, "name": _text},
    "undo": {},
    "redo": {},
    "check": {},
    "rest": {},
    "run": {},
    "pause": {},
    "step": {"steps": _whole},
    "stop": {},
    "back": {},
    "change": {"values": _values},
    "stage": {"values": _values},
    "save": {"what": _text, "name": _text},
}


def read_message(data: str | bytes) -> tuple[str, dict]:
    """The command of a message and its fields.

    Raises
    ------
    InputError
        If it is not a message.
    """
    if not isinstance(data, str):
        raise InputError("a message is a text")
    if len(data) > MOST:
        raise InputError(f"a message has at most {MOST:,} characters")
    try:
        found = json.loads(data)
    except (ValueError, RecursionError):
        raise InputError("the message is not JSON") from None
    if not isinstance(found, dict) or not isinstance(found.get("do"), str):
        raise InputError("a message is an object with the command 'do'")
    command = found.pop("do")
    fields = COMMANDS.get(command)
    if fields is None:
        raise InputError(f"there is no command {command[:40]!r}")
    if found.keys() != fields.keys():
        raise InputError(f"{command} has the fields {', '.join(fields) or 'none'}")
    for name, good in fields.items():
        if not good(found[name]):
            raise InputError(f"{command}: {name} is not of its kind")
    return command, found
