# SPDX-License-Identifier: GPL-3.0-or-later
"""Incremental dynamic analysis: one curve per record, and their fractiles."""

from dataclasses import dataclass

import numpy as np

from ..base.errors import InputError
from .maps import FRACTILES, label_of


@dataclass(frozen=True)
class Ida:
    """Curves of a response as a function of the intensity.

    Attributes
    ----------
    intensity : ndarray, shape (levels,)
    response : ndarray, shape (records, levels)
        NaN if the run failed.
    fractiles : ndarray, shape (3, levels)
        16, 50 and 84 % fractiles of the response at each intensity; NaN if no run is complete.
    threshold : float or None
        Limit of the response.
    capacity : ndarray, shape (records,)
        Intensity at which the response to a record first exceeds the threshold, interpolated
        linearly; inf if the response remains below, NaN if a run at a lower intensity failed.
    names : list of str
        Names of the records.
    labels : (str, str)
        Axis labels of response and intensity.
    """

    intensity: np.ndarray
    response: np.ndarray
    fractiles: np.ndarray
    threshold: float | None
    capacity: np.ndarray
    names: list[str]
    labels: tuple[str, str]

    @property
    def capacity_fractiles(self) -> np.ndarray:
        """Return the 16, 50 and 84 % fractiles of the capacities; inf if beyond all levels."""
        finite = np.sort(self.capacity[~np.isnan(self.capacity)])
        if not finite.size:
            return np.full(3, np.nan)
        ranks = np.clip(np.ceil(np.array(FRACTILES) * finite.size) - 1, 0, None).astype(int)
        return finite[ranks]

    def picture(self):
        """Draw the intensity (ordinate) over the response (abscissa); return the figure."""
        from ..report.style import BLUE, GREY, RED, canvas

        figure, (axes,) = canvas(1, size=(7.0, 5.0))
        for i, row in enumerate(self.response):
            axes.plot(row, self.intensity, "-", color=GREY, lw=0.9, alpha=0.7, marker=".", ms=3,
                      label="one record" if i == 0 else None)  # fmt: skip
        for level, row, style in zip(FRACTILES, self.fractiles, ("--", "-", "--"), strict=True):
            label = {0.5: "median", 0.16: "16 and 84 %"}.get(level)
            axes.plot(row, self.intensity, style, color=BLUE, lw=2.2, label=label)
        if self.threshold is not None:
            axes.axvline(self.threshold, color=RED, lw=1, label=f"threshold {self.threshold:g}")
        axes.set(xlabel=self.labels[0], ylabel=self.labels[1], ylim=(0, None), xlim=(0, None))
        axes.legend(frameon=False)
        return figure


def ida(table, quantity: str, intensity: str, record: str = "record", threshold=None) -> Ida:
    """Evaluate a study as an incremental dynamic analysis.

    Parameters
    ----------
    table : xarray.Dataset
        Results of a study.
    quantity : str
        Name of the response.
    intensity, record : str
        Dimensions of the table.
    threshold : float, optional
        Limit of the response, which defines the capacities.
    """
    values = table[quantity]
    if set(values.dims) != {intensity, record}:
        raise InputError(f"{quantity} has the dimensions {values.dims}, not {record!r} and "
                         f"{intensity!r}; select one value of each other dimension")  # fmt: skip
    response = values.transpose(record, intensity).values
    level = np.asarray(table[intensity].values, dtype=float)
    order = np.argsort(level)
    response, level = response[:, order], level[order]
    columns = np.isfinite(response).any(axis=0)
    fractiles = np.full((3, level.size), np.nan)
    fractiles[:, columns] = np.nanquantile(response[:, columns], FRACTILES, axis=0)
    capacity = [_capacity_intensity(row, level, threshold) for row in response]
    labels = (label_of(table, quantity), label_of(table, intensity))
    names = [str(name) for name in table[record].values]
    return Ida(level, response, fractiles, threshold, np.array(capacity), names, labels)


def _capacity_intensity(row: np.ndarray, level: np.ndarray, threshold: float | None) -> float:
    """Return the capacity (see `Ida`) for a record from its responses at the levels."""
    if threshold is None:
        return np.nan
    failures = np.flatnonzero(row > threshold)
    if not failures.size:
        return np.nan if np.any(np.isnan(row)) else np.inf
    first_failure = failures[0]
    if np.any(np.isnan(row[:first_failure])):
        return np.nan
    low, high = (
        (row[first_failure - 1], row[first_failure]) if first_failure else (0.0, row[first_failure])
    )
    lower = level[first_failure - 1] if first_failure else 0.0
    return float(lower + (level[first_failure] - lower) * (threshold - low) / (high - low))
