# SPDX-License-Identifier: GPL-3.0-or-later
"""Measured modes as a table: frequencies with errors, damping and shapes."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd

from ..base.arguments import DAMPING_RATIO, FINITE, POSITIVE, Range
from ..base.errors import InputError, located
from ..base.reading import read_numbers

BAND = 1.6449  # number of standard deviations on either side of the median that contain 90 %
_LARGEST = 2**22  # largest size of a table of modes, bytes
_SHAPE_DEVIATION = 0.05  # standard deviation of each component of a shape of unit length
_ORDER_TOLERANCE = 4.0  # allowed wrong order of frequencies, standard deviations
_NUMBER = Range(1, 1000, whole=True)
_COLUMNS = {
    "frequency": POSITIVE, "deviation": POSITIVE, "low": POSITIVE, "high": POSITIVE,
    "mode": _NUMBER, "damping": DAMPING_RATIO, "damping_deviation": DAMPING_RATIO,
    "shape_deviation": POSITIVE,
}  # fmt: skip


def measured_modes(source) -> pd.DataFrame:
    """Return measured modes as a table with a row for each.

    Parameters
    ----------
    source : path, DataFrame or mapping of sequences
        A CSV file, whose lines that begin with # are comments, or its columns: ``frequency`` and
        ``deviation`` (standard deviation, Hz), or ``low`` and ``high``, a range that contains 90 %;
        optionally ``mode`` (number of the model's mode from 1; otherwise by the shape, or the same
        place in the list), ``damping`` (ratio), ``damping_deviation``, components of the shape to
        any scale, ``POINT.x`` and ``POINT.y``, and ``shape_deviation``, the standard deviation of
        each component of a shape of unit length (0.05).  Empty cells are not measured.

    Returns
    -------
    DataFrame
        With all columns but ``low`` and ``high``; the index is the place of a mode for messages.

    Raises
    ------
    InputError
        If a column is unknown or a value is invalid; the message names file and line.
    """
    if isinstance(source, str | Path):
        names, rows = read_numbers(source, _LARGEST)
        lines = [f"{source}, line {line}" for line, _ in rows]
        table, prefix = pd.DataFrame([row for _, row in rows], lines, names), f"{source}: "
    else:
        try:
            table, prefix = pd.DataFrame(source), ""
        except (TypeError, ValueError) as error:
            raise InputError(f"the measured modes are not a table: {error}") from None
        table.index = [label if isinstance(label, str) else f"mode {i}"
                       for i, label in enumerate(table.index, 1)]  # fmt: skip
    if not table.columns.is_unique:
        name = table.columns[table.columns.duplicated()][0]
        raise InputError(f"{prefix}column {name!r} is repeated")
    shapes = [name for name in table if name not in _COLUMNS]
    for name in shapes:
        if str(name)[-2:] not in (".x", ".y"):
            raise InputError(f"{prefix}column {name!r} is not known; columns are "
                             f"{', '.join(_COLUMNS)}, POINT.x and POINT.y")  # fmt: skip
    if table.empty:
        raise InputError(f"{prefix}there is no measured mode")
    columns = [name for name in _COLUMNS if name not in ("low", "high")]
    rows = [_complete_row(label_of_row, row.dropna()) for label_of_row, row in table.iterrows()]
    result = pd.DataFrame(rows, table.index).reindex(columns=columns + shapes)
    return result.fillna({"shape_deviation": _SHAPE_DEVIATION})


def _complete_row(line: str, row: pd.Series) -> dict[str, float]:
    """Return the values of a row of a table, with frequency and deviation from low and high."""
    with located(line):
        values = {n: _COLUMNS.get(n, FINITE).check(n, value) for n, value in row.items()}
    low, high = values.pop("low", None), values.pop("high", None)
    if low and high:
        if not low < high:
            raise InputError(f"{line}: low = {low:g} must be below high = {high:g}")
        if "frequency" in values or "deviation" in values:
            raise InputError(f"{line}: `low` and `high` are given, and also `frequency` or "
                             "`deviation`; give one pair only")  # fmt: skip
        values |= {"frequency": (low + high) / 2, "deviation": (high - low) / (2 * BAND)}
    for name in ("frequency", "deviation"):
        if name not in values:
            raise InputError(f"{line}: {name} is missing: give `frequency` and `deviation`, "
                             "or `low` and `high`")  # fmt: skip
    return values


class Observations:
    """Measured modes as arrays, related to the points of a model."""

    table: pd.DataFrame  # table of `measured_modes`
    log_omega: np.ndarray  # ln ω (rad/s)
    error: np.ndarray  # relative standard deviation of the frequencies
    rows: list[np.ndarray]  # rows of `Family.points` of each component of a shape; empty: no shape
    shapes: list[np.ndarray]  # the shapes, of unit length
    shape_error: np.ndarray  # standard deviation of their components
    number: np.ndarray  # modes of the model from 0; −1: by the shape
    count: int  # number of model modes among which the measured modes are sought

    def __init__(self, table: pd.DataFrame, points: list[str]):
        """Find the points of shapes in a model; raise InputError if a point is missing."""
        self.table, self.rows, self.shapes, number = table, [], [], []
        self.log_omega = np.log(2 * np.pi * table.frequency.to_numpy())
        self.error = (table.deviation / table.frequency).to_numpy()
        self.shape_error = table.shape_deviation.to_numpy()
        numbers = table["mode"].fillna(0).astype(int)
        for i, (line, row) in enumerate(shapes_of(table).iterrows()):
            shape = row.dropna()
            for name in shape.index:
                if name[:-2] not in points:
                    raise InputError(f"{line}: the shape has {name}, but the measured points of "
                                     f"the model are {', '.join(points)}")  # fmt: skip
            if shape.size == 1:
                shape = shape[:0]  # a single component fits any shape
            if shape.size and not shape.any():
                raise InputError(f"{line}: the shape is zero")
            rows = [2 * points.index(n[:-2]) + (n[-1] == "y") for n in shape.index]
            self.rows.append(np.array(rows, dtype=int))
            values = shape.to_numpy() / shape.abs().max()
            self.shapes.append(values / np.linalg.norm(values))
            number.append(numbers.iloc[i] - 1 if numbers.iloc[i] or rows else i)
        self.number = np.array(number)
        self._check_order()
        self.count = max(max(number) + 1, len(table)) + (3 if min(number) < 0 else 0)

    def check_count(self, count: int) -> None:
        """Raise InputError if a model has fewer modes than are measured or numbered."""
        highest = int(np.argmax(self.number))
        if count <= self.number[highest] or count < len(self.table):
            raise InputError(f"{self.table.index[highest]}: mode {self.number[highest] + 1} and "
                             f"{len(self.table)} measured modes, but the model has only {count} "
                             "modes with stiffness")  # fmt: skip

    def _check_order(self) -> None:
        """Raise InputError if a number is repeated, or frequencies contradict the numbers."""
        order = [i for i in np.argsort(self.number, kind="stable") if self.number[i] >= 0]
        for i, j in pairwise(order):
            a, b = self.table.iloc[i], self.table.iloc[j]
            if self.number[i] == self.number[j]:
                raise InputError(f"{b.name}: two measured modes match mode {self.number[i] + 1} "
                                 "of the model: give both a number")  # fmt: skip
            gap = (a.frequency - b.frequency) / np.hypot(a.deviation, b.deviation)
            if gap > _ORDER_TOLERANCE and self.table["mode"].iloc[[i, j]].isna().any():
                raise InputError(
                    f"{b.name}: frequency = {b.frequency:g} of mode {self.number[j] + 1} is "
                    f"below the {a.frequency:g} Hz of mode {self.number[i] + 1}: sort the modes, "
                    "or number them"
                )


def shapes_of(table: pd.DataFrame) -> pd.DataFrame:
    """Return the components of the shapes of measured modes."""
    return table[[name for name in table if name not in _COLUMNS]]
