# SPDX-License-Identifier: GPL-3.0-or-later
"""Axes of a study: changes of the input along each dimension of the table of results."""

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

import numpy as np

from ..base.errors import InputError

_NAME = re.compile(r"[A-Za-z]\w*")
RESERVED = frozenset(
    ("status", "message", "warning", "case", "seconds", "time", "frame", "period", "frequency")
)


@runtime_checkable
class Axis(Protocol):
    """One or more dimensions of a study.

    `coordinates`: dimensions, values and attributes of each coordinate: the arguments of
    `xarray.Variable`.
    """

    dims: dict[str, int]  # length of each dimension, in order
    coordinates: dict[str, tuple]

    def changes(self, index: tuple[int, ...]) -> dict:
        """Return the changes at an index along the dimensions: value of each variable."""
        ...


@dataclass
class Points:
    """A dimension along which several variables change together.

    Parameters
    ----------
    name : str
        Name of the dimension.
    values : mapping of sequences
        Values of each changed variable, such as ``joint[bed].friction_angle``, along the
        dimension; all sequences have the same length.
    labels : mapping of str, optional
        Name of the coordinate of each variable (default: derived from the variable).
    number : bool
        Whether the dimension has a coordinate of numbers from 0.
    """

    name: str
    values: Mapping[str, Sequence]
    labels: Mapping[str, str] = field(default_factory=dict)
    number: bool = True
    dims: dict[str, int] = field(init=False)
    coordinates: dict[str, tuple] = field(init=False)

    def __post_init__(self):
        checked_name(self.name)
        self.values = {path: list(values) for path, values in self.values.items()}
        lengths = {len(values) for values in self.values.values()}
        if len(lengths) != 1 or 0 in lengths:
            raise InputError(f"parameter {self.name!r}: give at least one value, and the same "
                             "number of values for each variable")  # fmt: skip
        self.dims = {self.name: lengths.pop()}
        self.labels = dict(short_names(self.values)) | dict(self.labels)
        self.coordinates = {
            self.labels[path]: ((self.name,), coordinate(values), {"changes": path})
            for path, values in self.values.items()
        }
        if self.number and self.name not in self.coordinates:
            self.coordinates[self.name] = ((self.name,), np.arange(self.dims[self.name]), {})

    def changes(self, index: tuple[int, ...]) -> dict:
        """Return the changes at an index: value of each variable."""
        return {path: values[index[0]] for path, values in self.values.items()}


def checked_name(name: str) -> str:
    """Return the name of a dimension; raise InputError if it is invalid or reserved."""
    if not _NAME.fullmatch(name) or name in RESERVED:
        text = "the table uses this name" if name in RESERVED else "use only letters, digits and _"
        raise InputError(f"{name!r} cannot name a parameter: {text}")
    return name


def coordinate(values: Sequence) -> np.ndarray:
    """Convert values of a parameter to an array of numbers, or of texts if any is not a number."""
    if all(isinstance(v, int | float | np.number) and not isinstance(v, bool) for v in values):
        return np.asarray(values)
    return np.array([v if isinstance(v, str) else str(v) for v in values], dtype=object)


def short_names(paths) -> dict[str, str]:
    """Return a short name of each variable: its last word, with more words if ambiguous.

    Example: ``{"material.clay.density": "density"}``.
    """
    for length in (1, 2, None):
        names = {path: _short_name(path, length) for path in paths}
        if max(Counter(names.values()).values(), default=1) == 1:
            break
    return names


def _short_name(path: str, length: int | None) -> str:
    """Return the last `length` words of the path of a variable as a name; None: all words."""
    parts = re.findall(r"\w+", path.replace("*", "all"))
    parts = parts if length is None else parts[-length:]
    name = "_".join(parts) or "parameter"
    return f"p_{name}" if not name[0].isalpha() or name in RESERVED else name


def axes_of(parameters) -> list[Axis]:
    """Convert the parameters of `study` to axes.

    `parameters`: each named list of values becomes a dimension; an `Axis` is used unchanged.
    """
    if isinstance(parameters, Axis):
        return _check_distinct([parameters])
    if isinstance(parameters, Mapping):
        return _check_distinct(_axes_of_mapping(parameters))
    return _check_distinct([axis for item in parameters for axis in axes_of(item)])


def _axes_of_mapping(parameters: Mapping) -> list[Axis]:
    """Return one axis for each parameter of a mapping; see `study`."""
    names = short_names([k for k, v in parameters.items() if not isinstance(v, Axis)])
    axes: list[Axis] = []
    for path, values in parameters.items():
        if isinstance(values, Axis):
            axes.append(values)
            continue
        variable, name = path, names[path]
        if isinstance(values, tuple) and len(values) == 2 and isinstance(values[0], str):
            name, (variable, values) = path, values
        points = {variable: _as_list(path, values)}
        axes.append(Points(name, points, {variable: name}, number=False))
    return axes


def _as_list(path: str, values) -> list:
    """Return the values of a parameter as a list; raise InputError for texts and scalars."""
    if isinstance(values, str) or not isinstance(values, Sequence | np.ndarray | range):
        raise InputError(f"parameter {path!r}: give a list of values, not {values!r}")
    return np.asarray(values).tolist() if isinstance(values, np.ndarray) else list(values)


def _check_distinct(axes: list[Axis]) -> list[Axis]:
    """Return the axes; raise an error if two dimensions or coordinates have the same name."""
    for kind in ("dims", "coordinates"):
        names = Counter(name for axis in axes for name in getattr(axis, kind))
        repeated_names = [name for name, count in names.items() if count > 1]
        if repeated_names:
            raise InputError(f"two parameters are called {repeated_names[0]!r}; rename one, as in "
                             f"{{'{repeated_names[0]}_2': ('group.variable', [...])}}")  # fmt: skip
    return axes


def seeds(path: str, count: int, first: int = 1) -> dict[str, list[int]]:
    """Return the parameter of a study that contains realisations of a random joint network.

    Parameters
    ----------
    path : str
        Variable of the seed, such as ``joint_set[bedding].seed`` or ``voronoi.seed``.
    count : int
        Number of seeds.
    first : int
        First seed.
    """
    return {path: list(range(first, first + count))}
