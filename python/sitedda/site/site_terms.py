# SPDX-License-Identifier: GPL-3.0-or-later
"""Amplification of plane models with its error: many columns as control of few plane runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..base.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

_FEWEST = 20  # least number of plane runs, to which nine slopes are fitted
_WORTH = 1.2  # least saving of runs over plain sampling
_RICHARDSON = 4 / 3  # error of second order over the change by half the cells or steps


@dataclass(frozen=True)
class SiteTerm:
    """ln AF of plane models over random profiles, with an error budget.

    Attributes
    ----------
    table : xarray.Dataset
        Over ``point`` and ``period``: ``median``, ``sigma_ln``, ``aggravation`` (the median over
        that of the columns); ``sampling``, ``sigma_error`` and ``aggravation_sampling``, half of
        their confidence intervals (of the medians in ln); ``total``, which adds the errors of
        ``discretisation``; ``saving``, the runs that plain sampling needs for the same interval
        over the runs made (1: plain sampling was used).
    """

    table: xr.Dataset

    def __str__(self) -> str:
        table, lines = self.table, []
        lines.append(f"{table.attrs['runs']} plane runs, {table.attrs['columns']} columns, "
                     f"intervals of {100 * table.attrs['level']:g} %")  # fmt: skip
        lines.append(f"{'point':12s}{'period (s)':>11}{'median AF':>11}{'± %':>6}{'total ± %':>11}"
                     f"{'σ_ln':>8}{'±':>7}{'2-D/1-D':>9}{'± %':>6}{'saving':>8}")  # fmt: skip
        for row in self._rows.to_dict("records"):
            lines.append(
                f"{row['point']!s:12s}{row['period']:11.4g}{row['median']:11.4g}"
                f"{100 * row['sampling']:6.1f}{100 * row['total']:11.1f}"
                f"{row['sigma_ln']:8.3f}{row['sigma_error']:7.3f}"
                f"{row['aggravation']:9.3f}{100 * row['aggravation_sampling']:6.1f}"
                f"{row['saving']:8.1f}"
            )
        useless = int((table.saving == 1).sum())
        if useless:
            lines.append(f"columns save no runs for {useless} of {table.saving.size} results: "
                         "plain sampling was used")  # fmt: skip
        return "\n".join(lines)

    def to_csv(self, file) -> Path:
        """Write the table to a CSV file with a row for each point and period."""
        from ..base.files import write

        return write(Path(file), self._rows.to_csv(index=False, float_format="%.6g"), "a table")

    @property
    def _rows(self):
        """Return a pandas table with a row for each point and period."""
        return self.table.drop_dims("error").to_dataframe().reset_index()


def site_term(
    plane: Callable[[int], NDArray],
    column: Callable[[int], NDArray],
    points,
    periods,
    *,
    runs: int = 100,
    columns: int = 10_000,
    finer: Mapping[str, Callable[[int], NDArray]] | None = None,
    finer_runs: int = 5,
    level: float = 0.95,
    folder=None,
    workers: int | None = None,
) -> SiteTerm:
    """Estimate amplification over random profiles from few plane runs and many columns.

    ln AF of the plane runs is regressed on ln AF of their columns at this and the neighbouring
    periods, and on its squares and products; the mean of the regression over all columns is the
    estimate
    (control variates: Peherstorfer, Willcox and Gunzburger 2016).  Where that needs more than
    1/1.2 of the runs of plain sampling, plain sampling is used.

    Parameters
    ----------
    plane : callable
        AF of a plane model by the number of the sample, shape (points, periods).
    column : callable
        AF of the columns below the points, for the same random numbers.
    points, periods : sequence
        Names, and s.
    runs, columns : int
        Numbers of samples; plane runs use the first samples of the columns.
    finer : mapping of callable, optional
        Plane models with half the time step, half the cells, …, by names of these errors.
    finer_runs : int
        Number of samples of each of these models.
    level : float
        Level of confidence.
    folder : path, optional
        Folder of the plane runs; existing ones are not computed again.
    workers : int, optional
        Processes.

    Raises
    ------
    InputError
        If there are too few runs, or a run fails.

    References
    ----------
    Peherstorfer, B., Willcox, K. & Gunzburger, M. (2016). Optimal model management for
    multifidelity Monte Carlo estimation. SIAM Journal on Scientific Computing 38(5), A3163-A3194.
    """
    if not _FEWEST <= runs <= columns:
        raise InputError(f"runs = {runs}, columns = {columns}: give {_FEWEST} runs or more, and at "
                         "least as many columns")  # fmt: skip
    if not 0 < level < 1:
        raise InputError(f"level = {level:g}: give a confidence between 0 and 1")
    shape = (len(points), len(np.atleast_1d(periods)))
    found = _log_amplification(plane, runs, shape, folder, workers)
    control = np.log([np.asarray(column(i), dtype=float).reshape(shape) for i in range(columns)])
    errors = {}
    for name, model in (finer or {}).items():
        at = None if folder is None else Path(folder) / name.replace(" ", "_")
        change = _log_amplification(model, finer_runs, shape, at, workers) - found[:finer_runs]
        errors[name] = _RICHARDSON * np.abs(change.mean(axis=0))
    return term_of(found, control, points, periods, errors, level)


def term_of(
    found: NDArray[np.float64], control: NDArray[np.float64], points, periods,
    errors: Mapping[str, NDArray[np.float64]] | None = None, level: float = 0.95,
) -> SiteTerm:  # fmt: skip
    """Return the term of ln AF of plane runs and columns, shape (samples, points, periods).

    The first columns are those of the plane runs; `errors` of ln AF have shape (points, periods).
    """
    import xarray as xr

    shape, errors = found.shape[1:], errors or {}
    rows = [
        _estimate(found[:, i, j], control[:, i, max(j - 1, 0) : j + 2], min(j, 1), level)
        for i, j in np.ndindex(shape)
    ]
    dims = ("point", "period")
    data: dict = {name: (dims, np.reshape([row[name] for row in rows], shape)) for name in rows[0]}
    parts = np.array([*errors.values()]).reshape(len(errors), *shape)
    data["discretisation"] = (("error", *dims), parts)
    data["total"] = (dims, data["sampling"][1] + parts.sum(axis=0))
    at = {"point": list(points), "period": np.atleast_1d(periods), "error": list(errors)}
    sizes = {"runs": len(found), "columns": len(control), "level": level}
    return SiteTerm(xr.Dataset(data, at, sizes))


def _log_amplification(model, count: int, shape, folder, workers) -> NDArray[np.float64]:
    """Return ln AF of the first samples, shape (count, points, periods)."""
    from ..study.api import study

    done = study(model, {"sample": range(count)}, folder=folder, workers=workers)
    if (done.status != "complete").any():
        words = next(one for one in done.message.values if one)
        raise InputError(f"a plane run fails: {words}")
    return np.log(done["value"].values.reshape(count, *shape))


def _estimate(found, control, own: int, level: float) -> dict[str, float]:
    """Mean and σ of a row of plane runs, by the columns at its period and those beside it."""
    from scipy.special import stdtrit

    number, spread = found.size, control.std(axis=0)
    scaled = (control - control.mean(axis=0)) / np.maximum(spread, 1e-12)
    first, second = np.triu_indices(spread.size)
    basis = np.hstack([scaled, scaled[:, first] * scaled[:, second]])
    basis -= basis.mean(axis=0)
    here, free = basis[:number], number - basis.shape[1] - 1
    away = here.mean(axis=0)
    moments = (here - away).T @ (here - away)
    inverse = np.linalg.pinv(moments, rcond=1e-8, hermitian=True)
    slope = inverse @ (here - away).T @ found
    rest = found - found.mean() - (here - away) @ slope
    scatter = float(rest @ rest) / free
    every = basis.T @ basis / len(basis)
    explained = float(slope @ every @ slope)
    weight = 1 / number - (here - away) @ inverse @ away
    leverage = 1 / number + np.einsum("ij,jk,ik->i", here - away, inverse, here - away)
    # also the variance by HC3 (MacKinnon and White 1985), since the relation may not be quadratic
    sampled = max(scatter * float(weight @ weight),
                  float(np.sum((weight * rest / np.maximum(1 - leverage, 1e-3)) ** 2)))  # fmt: skip
    plain = float(found.var(ddof=1))
    side = [float(stdtrit(one, (1 + level) / 2)) for one in (free, number - 1)]
    half = side[0] * np.sqrt(sampled + explained / len(basis))
    needed = side[1] ** 2 * plain / half**2  # number of runs that plain sampling would need
    mean, below = float(found.mean() - away @ slope), float(control[:, own].mean())
    slope[own] -= spread[own]
    beside = float(slope @ every @ slope) / len(basis)
    slope[own] += spread[own]
    sigma = np.sqrt(explained + scatter)
    bent = every @ slope
    wide = 2 * scatter**2 / free + 4 * scatter * float(bent @ inverse @ bent)
    wide += 2 * explained**2 / len(basis)
    if needed < _WORTH * number:
        half, sigma, mean = side[1] * np.sqrt(plain / number), np.sqrt(plain), found.mean()
        wide, sampled, beside = 2 * plain**2 / (number - 1), plain / number, 0.0
        needed, side[0] = number, side[1]
    return {
        "median": float(np.exp(mean)),
        "sampling": float(half),
        "sigma_ln": float(sigma),
        "sigma_error": float(side[0] * np.sqrt(wide) / (2 * sigma)),
        "aggravation": float(np.exp(mean - below)),
        "aggravation_sampling": float(side[0] * np.sqrt(sampled + beside)),
        "saving": float(needed / number),
    }
