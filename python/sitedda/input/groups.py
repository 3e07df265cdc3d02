# SPDX-License-Identifier: GPL-3.0-or-later
"""The groups of an input, their variables, and their text."""

from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from functools import cache

import numpy as np

from ..base.errors import InputError, located
from .input_text import UNSET, ParsedGroup
from .schema import GROUPS, Variable
from .values import points_of

# Kinds of values: text, texts, number, numbers, points (x, y, x, y …), whole (number), logical.
_KINDS = {"name": "text", "word": "text", "text": "text", "real": "number", "integer": "whole"}
_KINDS |= {"logical": "logical", "points": "points"}
_LARGEST = 2**53 - 1  # largest whole number that is exact as a floating-point number


@cache
def single_groups() -> tuple[str, ...]:
    """Return the names of the groups that may appear only once in an input."""
    return tuple(name for name, group in GROUPS.items() if not group.repeats)


@cache
def variable_kinds() -> dict[str, dict[str, str]]:
    """Return the kind of each variable of each group."""
    return {name: {v.name: _variable_kind(v) for v in group.variables}
            for name, group in GROUPS.items()}  # fmt: skip


@cache
def _sizes() -> dict[str, dict[str, int]]:
    """Return the largest length of each variable of each group; 0 for scalars."""
    return {name: {v.name: int(v.size or 0) for v in group.variables}
            for name, group in GROUPS.items()}  # fmt: skip


def _variable_kind(variable: Variable) -> str:
    """Return the kind of the values of a variable, see `_KINDS`."""
    if not variable.size or variable.kind == "points":
        return _KINDS[variable.kind]
    return "texts" if _KINDS[variable.kind] == "text" else "numbers"


def is_made(name: str) -> bool:
    """Return whether a group is converted into blocks before the engine reads the input."""
    return name in GROUPS and GROUPS[name].built


def nearest(name: str, names) -> str:
    """Return a hint that names the most similar known word, or an empty text."""
    matches = get_close_matches(name, list(names), 1)
    return f"; did you mean {matches[0]!r}?" if matches else ""


def known_group(name: str) -> str:
    """Return the name of a group in lower case; raise an error if it is unknown."""
    if name not in variable_kinds():
        raise InputError(f"there is no group &{name}{nearest(name, variable_kinds())}")
    return name


def known_variable(group: str, name: str) -> str:
    """Return the kind of a variable of a group; raise an error if it is unknown."""
    kinds = variable_kinds()[group]
    if name not in kinds:
        hint = nearest(name, kinds) or f"; its variables are {', '.join(kinds)}"
        raise InputError(f"group &{group} has no variable {name!r}{hint}")
    return kinds[name]


def checked(group: str, name: str, value):
    """Check and convert a value of a variable; arrays are copied and made read-only."""
    kind = known_variable(group, name)
    try:
        converted = _CONVERT[kind](value)
        if isinstance(converted, np.ndarray) and (group, name) != ("motion", "values"):
            _check_length(converted, _sizes()[group][name])
        return converted
    except InputError as error:
        raise InputError(f"&{group}: {name}: {error}") from None
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"&{group}: {name} = {value!r} is not a {_KIND_NAMES[kind]}") from None


def _check_length(values: np.ndarray, limit: int) -> None:
    """Raise an error if a list is longer than the engine can read."""
    if len(values) > limit:
        noun = "values" if values.ndim == 1 else "points"
        raise InputError(f"{len(values)} {noun} are given, but at most {limit} are possible")


def _as_text(value) -> str:
    """Return a value or path as a text of one line."""
    if not isinstance(value, str) and not hasattr(value, "__fspath__"):
        raise TypeError
    value = str(value)
    if "\0" in value or "\n" in value:
        raise InputError("a text must be one line")
    try:
        value.encode("utf-8", "surrogateescape")
    except UnicodeEncodeError as error:
        raise InputError(f"character {error.start + 1} of {value!r} is not valid") from None
    return value


def _as_texts(value) -> tuple[str, ...]:
    """Return a text or a sequence of texts as a tuple of texts."""
    return (_as_text(value),) if isinstance(value, str) else tuple(_as_text(item) for item in value)


def _as_number(value) -> float:
    """Return a scalar as a finite number."""
    if isinstance(value, str | bool | np.bool_) or np.ndim(value):
        raise TypeError
    value = float(value)
    if not np.isfinite(value):
        raise InputError(f"{value} is not a usable number")
    return value


def _as_integer(value) -> int:
    """Return a scalar as a whole number."""
    number = _as_number(value)
    if number != int(number):
        raise ValueError
    if abs(number) > _LARGEST:
        raise InputError(f"{value} is too large to be stored exactly: at most {_LARGEST}")
    return int(value)


def _as_numbers(value) -> np.ndarray:
    """Return numbers as a read-only array of one dimension."""
    if np.iscomplexobj(value):
        raise TypeError
    array = np.array(value, dtype=float).ravel()
    if not np.isfinite(array).all():
        raise InputError(f"value {int(np.flatnonzero(~np.isfinite(array))[0]) + 1} is not a number")
    array.flags.writeable = False
    return array


def _as_points(value) -> np.ndarray:
    """Return points as a read-only array, shape (n, 2)."""
    return _as_numbers(points_of("points", value, 1)).reshape(-1, 2)


def _as_logical(value) -> bool:
    """Return a logical value; reject numbers and texts."""
    if not isinstance(value, bool | np.bool_):
        raise TypeError
    return bool(value)


_CONVERT = {"text": _as_text, "texts": _as_texts, "number": _as_number, "numbers": _as_numbers}
_CONVERT |= {"points": _as_points, "whole": _as_integer, "logical": _as_logical}
_KIND_NAMES = {"text": "text", "texts": "list of texts", "number": "number",
               "whole": "whole number"}  # fmt: skip
_KIND_NAMES |= {"logical": "logical value", "numbers": "list of numbers",
                "points": "list of points x, y"}  # fmt: skip


# --- Text ----------------------------------------------------------------------------------------


def group_text(name: str, values: Mapping) -> str:
    """Return a group as one line of text; variables that are None are omitted."""
    entries = [f"{k} = {value_text(v)}" for k, v in values.items() if v is not None]
    return f"&{name} {', '.join(entries)} /\n"


def value_text(value) -> str:
    """Format a text, number, logical value or sequence of these as in an input."""
    if isinstance(value, np.ndarray):
        if value.dtype.kind == "f":  # fast path for block vertices, which make up most of a text
            return ", ".join(map(repr, value.ravel().tolist()))
        value = value.ravel().tolist()
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
    raise TypeError(f"a namelist cannot contain {value!r}")


def read_values(group: ParsedGroup, file) -> dict:
    """Check the values of a group and return them by variable, as in a `Model`."""
    with located(group.place(file)):
        known_group(group.name)
        for name, value in group.values.items():
            if isinstance(value, np.ndarray) and (value == UNSET).any():
                raise InputError(f"{name}: a value is missing")
        return {name: checked(group.name, name, value) for name, value in group.values.items()}
