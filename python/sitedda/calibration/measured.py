# SPDX-License-Identifier: GPL-3.0-or-later
"""Measured modes, read from a CSV file: frequencies with errors, damping and shapes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from ..base.arguments import DAMPING_RATIO, FINITE, POSITIVE, Range
from ..base.errors import InputError
from ..base.reading import read_numbers

BAND = 1.6449  # number of standard deviations on either side of the median that contain 90 %
_LARGEST = 2**22  # largest size of a table of modes, bytes
_SHAPE_DEVIATION = 0.05  # standard deviation of each component of a shape of unit length
_APART = 4.0  # standard deviations by which measured frequencies of modes may be in wrong order
_NUMBER = Range(1, 1000, whole=True)
_COLUMNS = {
    "frequency": POSITIVE, "deviation": POSITIVE, "low": POSITIVE, "high": POSITIVE,
    "mode": _NUMBER, "damping": DAMPING_RATIO, "damping_deviation": DAMPING_RATIO,
    "shape_deviation": POSITIVE,
}  # fmt: skip


@dataclass(frozen=True)
class MeasuredMode:
    """A measured mode.

    Attributes
    ----------
    frequency : float
        Hz.
    deviation : float
        Standard deviation of the frequency, Hz.
    shape : dict of float
        Displacements by ``POINT.x`` and ``POINT.y``, to any scale.
    shape_deviation : float
        Standard deviation of a component of the shape, which is scaled to unit length.
    mode : int
        Number of the model's mode from 1; 0: by its shape, or the same place in the list.
    damping, damping_deviation : float
        Damping ratio and its standard deviation; NaN: not measured.
    origin : str
        File and line, for messages.

    Raises
    ------
    InputError
        If a frequency or a deviation is not above 0, or a component is not finite.
    """

    frequency: float
    deviation: float
    shape: dict[str, float] = field(default_factory=dict)
    shape_deviation: float = _SHAPE_DEVIATION
    mode: int = 0
    damping: float = math.nan
    damping_deviation: float = math.nan
    origin: str = field(default="", compare=False, repr=False)

    def __post_init__(self):
        for name in ("frequency", "deviation", "shape_deviation"):
            POSITIVE.check(name, getattr(self, name))
        for name, value in self.shape.items():
            FINITE.check(name, value)


def measured_modes(source) -> list[MeasuredMode]:
    """Return measured modes from a CSV file or a sequence.

    Parameters
    ----------
    source : path or sequence of MeasuredMode
        The file has a row for each mode and a heading: ``frequency`` and ``deviation`` (Hz), or
        ``low`` and ``high``, a range that contains 90 %; optionally ``mode``, ``damping``,
        ``damping_deviation``, ``shape_deviation`` and components of the shape, ``POINT.x``,
        ``POINT.y``.  Lines that begin with # are comments.

    Raises
    ------
    InputError
        If a column is not known, or a value cannot be; the message names file and line.
    """
    if isinstance(source, Sequence) and not isinstance(source, str):
        return list(source)
    names, rows = read_numbers(source, _LARGEST)
    for name in names:
        if name not in _COLUMNS and name[-2:] not in (".x", ".y"):
            raise InputError(f"{source}: column {name!r} is not known; there are "
                             f"{', '.join(_COLUMNS)}, and POINT.x, POINT.y")  # fmt: skip
    found = []
    for line, values in rows:
        given = {n: v for n, v in zip(names, values, strict=True) if not math.isnan(v)}
        try:
            found.append(_mode_of(given, f"{source}, line {line}"))
        except InputError as trouble:
            raise InputError(f"{source}, line {line}: {trouble}") from None
    return found


def _mode_of(row: dict[str, float], origin: str) -> MeasuredMode:
    """Return the mode of a row of a table."""
    shape = {n: row[n] for n in row if n not in _COLUMNS}
    values: dict = {n: _COLUMNS[n].check(n, row[n]) for n in row if n in _COLUMNS}
    low, high = values.pop("low", None), values.pop("high", None)
    if low and high:
        if not low < high:
            raise InputError(f"low = {low:g} must be below high = {high:g}")
        if "frequency" in values or "deviation" in values:
            raise InputError(f"low = {low:g} and high = {high:g} are given, and frequency or "
                             "deviation: give one pair only")  # fmt: skip
        values |= {"frequency": (low + high) / 2, "deviation": (high - low) / (2 * BAND)}
    for name in ("frequency", "deviation"):
        if name not in values:
            raise InputError(f"{name} is missing: give frequency and deviation, or low and high")
    return MeasuredMode(shape=shape, origin=origin, **values)


class Observations:
    """Measured modes as arrays, related to the points of a model.

    Attributes
    ----------
    modes : sequence of MeasuredMode
    rows : list of ndarray of int
        Rows of `Family.points` of the components of each shape; empty: no shape.
    shapes : list of ndarray
        The shapes, of unit length.
    number : ndarray of int
        Modes of the model from 0; −1: by the shape.
    count : int
        Number of model modes among which the measured modes are sought.
    """

    def __init__(self, modes: Sequence[MeasuredMode], points: list[str]):
        """Find the points of shapes in a model; raise InputError if a point is missing."""
        self.modes, self.rows, self.shapes, number = modes, [], [], []
        for i, one in enumerate(modes):
            for name in one.shape:
                if name[:-2] not in points:
                    raise InputError(f"{self.place(i)}: the shape has {name}, but the measured "
                                     f"points of the model are {', '.join(points)}")  # fmt: skip
            named = one.shape if len(one.shape) > 1 else {}  # a single component fits any shape
            shape = np.array(list(named.values()))
            if named and not np.any(shape):
                raise InputError(f"{self.place(i)}: the shape is zero")
            shape = shape / max(abs(shape), default=1.0)
            rows = [2 * points.index(n[:-2]) + (n[-1] == "y") for n in named]
            self.rows.append(np.array(rows, dtype=int))
            self.shapes.append(shape / np.linalg.norm(shape) if named else shape)
            number.append(one.mode - 1 if one.mode or named else i)
        self._check_order(number)
        self.number = np.array(number)
        self.count = max(max(number) + 1, len(modes)) + (3 if min(number) < 0 else 0)

    def place(self, i: int) -> str:
        """Return where a measured mode was given, for messages."""
        return self.modes[i].origin or f"mode {i + 1}"

    def check_count(self, count: int) -> None:
        """Raise InputError if a model has fewer modes than are measured or numbered."""
        last = int(np.argmax(self.number))
        if count <= self.number[last] or count < len(self.modes):
            raise InputError(f"{self.place(last)}: mode {self.number[last] + 1} and "
                             f"{len(self.modes)} measured modes, but the model has only {count} "
                             "modes with stiffness")  # fmt: skip

    def _check_order(self, number: list[int]) -> None:
        """Raise InputError if a number is repeated, or frequencies contradict the numbers."""
        order = sorted((n, i) for i, n in enumerate(number) if n >= 0)
        for (n, i), (other, j) in pairwise(order):
            if n == other:
                raise InputError(f"{self.place(j)}: two measured modes match mode {n + 1} of the "
                                 "model: number both")  # fmt: skip
            one, two = self.modes[i], self.modes[j]
            apart = (one.frequency - two.frequency) / math.hypot(one.deviation, two.deviation)
            if apart > _APART and not (one.mode and two.mode):
                raise InputError(
                    f"{self.place(j)}: frequency = {two.frequency:g} of mode {other + 1} is below "
                    f"the {one.frequency:g} Hz of mode {n + 1}: sort the modes, or number them"
                )
