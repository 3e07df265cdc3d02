# SPDX-License-Identifier: GPL-3.0-or-later
"""Sensitivity of a result: tornado diagrams and Sobol' indices."""

from dataclasses import dataclass

import numpy as np

from ..base.errors import InputError
from ..base.numbers import axis_label


@dataclass(frozen=True)
class Tornado:
    """Results with one parameter at a time at its low and high value; the widest range first.

    Attributes
    ----------
    names : list of str
        Names of the parameters.
    low, high : ndarray, shape (parameters,)
        Results at the low and high value of each parameter.
    low_values, high_values : ndarray, shape (parameters,)
        Low and high value of each parameter.
    base : float
        Result at the base values of all parameters.
    quantity : str
        Name of the result.
    """

    names: list[str]
    low: np.ndarray
    high: np.ndarray
    low_values: np.ndarray
    high_values: np.ndarray
    base: float
    quantity: str

    @property
    def swing(self) -> np.ndarray:
        """Return the range of the three results (low, base, high) of each parameter."""
        rows = np.stack([self.low, self.high, np.full_like(self.low, self.base)])
        return np.ptp(rows, axis=0)

    def picture(self):
        """Draw the range of the result of each parameter as a bar; return the figure."""
        from ..report.style import BLUE, INK, ORANGE, canvas

        figure, (axes,) = canvas(1, size=(7.5, 1.2 + 0.5 * len(self.names)))
        y = np.arange(len(self.names))[::-1]
        for values, ends, color in (
            (self.low, self.low_values, BLUE),
            (self.high, self.high_values, ORANGE),
        ):
            axes.barh(y, values - self.base, left=self.base, color=color, height=0.6,
                      label="low value" if color == BLUE else "high value")  # fmt: skip
            for height, value, end in zip(y, values, ends, strict=True):
                is_left = value < self.base
                axes.annotate(f"{end:.4g}", (value, height), xytext=(-4 if is_left else 4, 0),
                              textcoords="offset points", ha="right" if is_left else "left",
                              va="center", fontsize=8)  # fmt: skip
        axes.axvline(self.base, color=INK, lw=1)
        axes.set_yticks(y, self.names)
        axes.margins(x=0.15)
        axes.set_xlabel(axis_label(self.quantity))
        axes.legend(frameon=False)
        return figure


def tornado(table, quantity: str, dim: str = "variation") -> Tornado:
    """Return the tornado diagram of a study with the design `one_at_a_time`.

    Raises
    ------
    InputError
        If the dimension has another design, or a case has no result.
    """
    names = _parameter_names(table, dim)
    values = table[quantity].values
    if values.ndim != 1 or values.size != 2 * len(names) + 1:
        raise InputError(f"dimension {dim!r} is not a design of one_at_a_time")
    _require_complete(table, quantity, dim)
    low, high = values[1::2], values[2::2]
    ends = np.array([[table[n].values[1 + 2 * i], table[n].values[2 + 2 * i]]
                     for i, n in enumerate(names)], dtype=float)  # fmt: skip
    diagram = Tornado(names, low, high, ends[:, 0], ends[:, 1], float(values[0]), quantity)
    order = np.argsort(-diagram.swing, kind="stable")
    return Tornado([names[i] for i in order], low[order], high[order], ends[order, 0],
                   ends[order, 1], diagram.base, quantity)  # fmt: skip


@dataclass(frozen=True)
class SobolIndices:
    """Sobol' indices: fractions of the variance of a result that parameters cause.

    Attributes
    ----------
    names : list of str
        Names of the parameters.
    first, total : ndarray, shape (parameters,)
        Fraction due to each parameter alone, and including its interactions.
    first_interval, total_interval : ndarray, shape (parameters, 2)
        Confidence intervals by bootstrap.
    confidence : float
        Confidence level of the intervals.
    quantity : str
        Name of the result.
    """

    names: list[str]
    first: np.ndarray
    total: np.ndarray
    first_interval: np.ndarray
    total_interval: np.ndarray
    confidence: float
    quantity: str

    def picture(self):
        """Draw the indices with their confidence intervals; return the figure."""
        from ..report.style import BLUE, INK, ORANGE, canvas

        figure, (axes,) = canvas(1, size=(7.0, 4.2))
        x = np.arange(len(self.names))
        for values, ends, shift, color, label in (
            (self.first, self.first_interval, -0.2, BLUE, "first order"),
            (self.total, self.total_interval, 0.2, ORANGE, "total"),
        ):
            error = np.maximum(abs(ends.T - values), 0.0)
            axes.bar(x + shift, values, 0.38, yerr=error, color=color, label=label,
                     error_kw={"ecolor": INK, "lw": 1})  # fmt: skip
        axes.set_xticks(x, self.names)
        axes.set(ylabel="fraction of the variance", title=axis_label(self.quantity))
        axes.axhline(0, color=INK, lw=0.8)
        axes.legend(frameon=False)
        return figure


def sobol_indices(table, quantity: str, dim: str = "sample", confidence=0.95, seed=0):
    """Return the Sobol' indices of a study with the design `saltelli`.

    `scipy.stats.sobol_indices` uses the estimators of Saltelli et al. (2010) and Jansen (1999).

    Parameters
    ----------
    table : xarray.Dataset
        Results of a study.
    quantity : str
        Name of the result.
    dim : str
        Dimension of the design.
    confidence : float
        Confidence level of the intervals.
    seed : int
        Seed of the bootstrap.

    Raises
    ------
    InputError
        If the dimension has another design, a case has no result, or all results are equal.
    """
    from scipy import stats

    names = _parameter_names(table, dim)
    values = np.asarray(table[quantity].values, dtype=float)
    width = len(names)
    if values.ndim != 1 or values.size % (width + 2):
        raise InputError(f"dimension {dim!r} is not a design of saltelli")
    _require_complete(table, quantity, dim)
    if np.ptp(values) == 0:
        raise InputError(f"{quantity} is the same in all cases: its variance is 0")
    rows = values.reshape(width + 2, -1)
    blocks = {"f_A": rows[:1], "f_B": rows[1:2], "f_AB": rows[2:, None, :]}
    indices = stats.sobol_indices(func=blocks, n=rows.shape[1])
    rng = np.random.Generator(np.random.PCG64(seed))
    intervals = _bootstrap_intervals(rows, rng, confidence)
    return SobolIndices(names, indices.first_order, indices.total_order, intervals[0], intervals[1],
                        confidence, quantity)  # fmt: skip


def _bootstrap_intervals(
    rows: np.ndarray, rng, confidence: float, repetitions: int = 200
) -> np.ndarray:
    """Return bootstrap intervals of first and total indices, shape (2, parameters, 2)."""
    indices = np.empty((repetitions, 2, len(rows) - 2))
    for i in range(repetitions):
        a, b, *f_ab = rows[:, rng.integers(rows.shape[1], size=rows.shape[1])]
        centre = np.mean([a, b])
        variance = np.var([a, b])
        a, b, f_ab = a - centre, b - centre, np.array(f_ab) - centre
        indices[i, 0] = np.mean(b * (f_ab - a), axis=1) / variance
        indices[i, 1] = 0.5 * np.mean((a - f_ab) ** 2, axis=1) / variance
    intervals = np.quantile(indices, [0.5 - confidence / 2, 0.5 + confidence / 2], axis=0)
    return np.moveaxis(intervals, 0, -1)


def _parameter_names(table, dim: str) -> list[str]:
    """Return the names of the parameters that vary along a dimension."""
    if dim not in table.sizes:
        raise InputError(f"the table has no dimension {dim!r}; it has {', '.join(table.sizes)}")
    return [name for name, item in table.coords.items() if item.dims == (dim,) and name != dim]


def _require_complete(table, quantity: str, dim: str) -> None:
    """Raise InputError if a case has no value of a quantity."""
    missing = int(np.sum(~np.isfinite(table[quantity].values)))
    if missing:
        raise InputError(f"{missing} of {table.sizes[dim]} cases have no {quantity}; sensitivity "
                         "analysis requires all cases")  # fmt: skip
