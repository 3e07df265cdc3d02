# SPDX-License-Identifier: GPL-3.0-or-later
"""Values of groups that become blocks, checked by the schema."""

from __future__ import annotations

import re
from inspect import cleandoc
from typing import TYPE_CHECKING, ClassVar, dataclass_transform

import numpy as np

from ..base.errors import InputError

if TYPE_CHECKING:
    from .schema import Variable

LARGEST_COORDINATE = 1e9  # largest coordinate, m


def points_of(name: str, values, minimum: int) -> np.ndarray:
    """Return points, shape (n, 2), of a list x, y, x, y …, an array or a shapely polygon."""
    if hasattr(values, "exterior"):
        if len(values.interiors):
            raise InputError(f"{name}: the polygon has holes; give each as a separate hole")
        values = np.asarray(values.exterior.coords)[:-1, :2]
    elif hasattr(values, "coords"):
        values = np.asarray(values.coords)[:, :2]
    try:
        points = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"{name} must contain numbers x, y, x, y …") from None
    if points.size % 2 or (points.ndim == 2 and points.shape[1] != 2) or points.ndim > 2:
        raise InputError(f"{name} must contain pairs x, y; there are {points.size} numbers")
    points = points.reshape(-1, 2)
    if not (abs(points) <= LARGEST_COORDINATE).all():
        index = int(np.flatnonzero(~(abs(points) <= LARGEST_COORDINATE).all(axis=1))[0])
        raise InputError(
            f"{name}: point {index + 1} ({points[index, 0]:g}, {points[index, 1]:g}) lies beyond "
            f"{LARGEST_COORDINATE:g} m or is not a number"
        )
    if len(points) < minimum:
        raise InputError(f"{name}: {len(points)} points given, at least {minimum} are needed")
    return points


@dataclass_transform(kw_only_default=True)
class Values:
    """Values of a group that is converted into blocks; the schema defines a subclass per group."""

    group: ClassVar[str] = ""
    from_file: ClassVar[str] = ""  # variable whose points may be read from a file, if any
    variables: ClassVar[tuple[Variable, ...]] = ()
    needs: ClassVar[str] = ""

    def __init_subclass__(cls):
        attributes = [cleandoc(base.__doc__ or "") for base in (cls, cls.__base__)]
        if "Attributes" not in attributes[0]:
            cls.__doc__ = "\n\n".join([attributes[0], *attributes[1].split("\n\n")[1:]])

    def __init__(self, **given):
        variables_used = [
            variable for variable in self.variables if hasattr(type(self), variable.name)
        ]
        given_names = {name for name, value in given.items() if is_given(value)}
        for variable in variables_used:
            default = getattr(type(self), variable.name)
            setattr(self, variable.name, given.pop(variable.name, default))
        if given:
            raise TypeError(f"{type(self).__name__} has no {', '.join(given)}")
        for variable in variables_used:
            self._check_value(variable, getattr(self, variable.name))
        self._check_relations(given_names)
        self._check_values()

    def __repr__(self) -> str:
        """Return name and values as text."""
        values = ", ".join(f"{name}={value!r}" for name, value in vars(self).items())
        return f"{type(self).__name__}({values})"

    def _check_value(self, entry: Variable, value) -> None:
        """Check a value by its entry in the schema; convert points to an array."""
        name = entry.name
        if entry.default == "required" and (
            value is None or (isinstance(value, str) and not value)
        ):
            raise InputError(f"{name} is missing")
        if entry.kind == "points":
            setattr(self, name, points_of(name, () if value is None else value, 0))
        elif value is None:
            return
        elif entry.size == 2:
            setattr(self, name, points_of(name, value, 1)[0])
        elif entry.size:
            setattr(self, name, np.atleast_1d(np.asarray(value, dtype=float)))
        elif entry.kind == "word" and value not in entry.values.replace("'", "").split(", "):
            choices, _, last_choice = entry.values.rpartition(", ")
            raise InputError(f"{name} = {value!r} must be {choices} or {last_choice}")
        elif entry.kind == "name" and entry.values.startswith("at most"):
            limit = int(re.findall(r"\d+", entry.values)[0])
            if not 0 < len(value) <= limit:
                raise InputError(f"{name} = {value!r} must have 1 to {limit} characters, because "
                                 "block numbers are appended")  # fmt: skip
        elif entry.kind in ("real", "integer"):
            _check_number(name, value, entry.values)

    def _check_relations(self, variables: set[str]) -> None:
        """Raise InputError if a variable lacks others that it needs, or excludes another one.

        The schema defines the needed and the excluded variables.
        """
        for alternatives in filter(None, self.needs.split("; ")):
            if variables.isdisjoint(alternatives.split(" or ")):
                raise InputError(f"give {alternatives}")
        for variable in self.variables:
            if variable.name not in variables:
                continue
            for excluded in filter(variables.__contains__, variable.excludes.split(", ")):
                raise InputError(f"give either {variable.name} or {excluded}, not both")
            for alternatives in filter(None, variable.needs.split(", ")):
                if variables.isdisjoint(alternatives.split(" or ")):
                    raise InputError(f"{variable.name} needs {alternatives}")

    def _check_values(self) -> None:
        """Check relations between values that the schema does not express; see the subclasses."""


def is_given(value) -> bool:
    """Return whether a value is given: not None, a blank text or an empty list."""
    return value is not None and (not hasattr(value, "__len__") or len(value) > 0)


def _check_number(name: str, value: float, limits: str) -> None:
    """Raise InputError if a number violates limits, which are given in words of the schema."""
    low, high = -LARGEST_COORDINATE, LARGEST_COORDINATE
    failure = "is not a usable number"
    if limits == "above 0":
        low, failure = np.nextafter(0, 1), "must be a positive number"
    elif limits.startswith("at least"):
        low = _parse_limit(limits.split()[-1])
        failure = f"must be at least {low}" if low else "must not be negative"
    elif " to " in limits:
        low, high = map(_parse_limit, limits.split(" to "))
        failure = f"must lie between {low} and {high}"
    if not low <= value <= high:
        number = value if isinstance(value, int) else f"{value:g}"
        raise InputError(f"{name} = {number} {failure}")


def _parse_limit(text: str) -> float:
    """Convert a limit in the schema to an integer or a real number."""
    return int(text) if text.lstrip("-").isdigit() else float(text)
