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

_FEWEST = 20  # smallest number of plane runs, to which nine slopes are fitted
_TERMS = 12  # largest number of controls
_MISSED = 0.1  # smallest unexplained σ / σ of ln AF of a column that adds a control of its own
_PRODUCT = 0.5  # size of a product of components / product of their sizes
_WORTH = 1.2  # smallest ratio of numbers of runs, without / with columns, for their use
_HEADS = {"point": "point", "period": "period (s)", "median": "median ratio", "sampling": "± %",
          "total": "total ± %", "sigma_ln": "σ_ln", "sigma_error": "±", "aggravation": "2-D/1-D",
          "aggravation_sampling": "± %", "saving": "saving"}  # fmt: skip
_RICHARDSON = 4 / 3  # error of second order / change due to half the cells or steps


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
        divided by the runs made.
    """

    table: xr.Dataset

    def __str__(self) -> str:
        table, rows = self.table, self._rows
        rows[["sampling", "total", "aggravation_sampling"]] *= 100
        lines = [f"{table.attrs['runs']} plane runs, {table.attrs['columns']} columns, "
                 f"intervals of {100 * table.attrs['level']:g} %",
                 rows[list(_HEADS)].to_string(index=False, header=list(_HEADS.values()),
                                              float_format="{:.4g}".format)]  # fmt: skip
        unreduced = int((table.saving < _WORTH).sum())
        if unreduced:
            lines.append("the columns (control variates) do not reduce the number of plane runs "
                         f"for {unreduced} of {table.saving.size} results")  # fmt: skip
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

    1. Controls b are up to 12 principal components of ln AF of the columns at all points and
       periods, and products of components, made orthonormal over all columns, and ln AF of the
       column itself if these miss a tenth of it.
    2. Samples of the plane runs are drawn with probabilities p = (1 + (1 + |b|²)/(1 + terms))/2
       over the number of columns, so that profiles with unusual columns are not missed
       (Cohen and Migliorati 2017).
    3. ln AF of the plane runs is regressed on the controls with weights 1/p.  The controls have
       the mean 0, so the estimate is the intercept (control variates: Peherstorfer, Willcox and
       Gunzburger 2016).  Its variance is that of the jackknife (HC3: MacKinnon and White 1985),
       which includes the error of the slopes.
    4. If this saves less than 1/6 of the runs, the weighted mean of the plane runs is used.

    Parameters
    ----------
    plane : callable
        AF of a plane model by the number of the sample, shape (points, periods).
    column : callable
        AF of the columns below the points, for the same random numbers.
    points, periods : sequence
        Names, and s.
    runs, columns : int
        Numbers of samples; plane runs use some of the samples of the columns.
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

    Cohen, A. & Migliorati, G. (2017). Optimal weighted least-squares methods. SMAI Journal of
    Computational Mathematics 3, 181-203.
    """
    if not _FEWEST <= runs <= columns:
        raise InputError(f"runs = {runs}, columns = {columns}: give {_FEWEST} runs or more, and at "
                         "least as many columns")  # fmt: skip
    if not 1 <= finer_runs <= runs:
        raise InputError(f"finer_runs = {finer_runs}: give 1 ... {runs}")
    if not 0 < level < 1:
        raise InputError(f"level = {level:g}: give a confidence between 0 and 1")
    shape = (len(points), len(np.atleast_1d(periods)))
    factors = np.array([np.reshape(column(i), shape) for i in range(columns)], dtype=float)
    _check_amplification("column", range(columns), factors)
    control = np.log(factors)
    samples = draw_samples(control, runs, np.random.default_rng(1))
    logs = _log_amplification(plane, samples, shape, folder, workers)
    changes = {}
    for name, model in (finer or {}).items():
        path = None if folder is None else Path(folder) / name.replace(" ", "_")
        changes[name] = (_log_amplification(model, samples[:finer_runs], shape, path, workers)
                         - logs[:finer_runs])  # fmt: skip
    return term_of(logs, control, samples, points, periods, changes, level)


def draw_samples(control: NDArray, runs: int, generator: np.random.Generator) -> NDArray[np.int_]:
    """Draw the samples of plane runs by ln AF of columns, shape (columns, points, periods)."""
    probabilities = _chances(_controls(control))
    return generator.choice(len(probabilities), size=runs, p=probabilities)


def term_of(
    logs: NDArray[np.float64], control: NDArray[np.float64], samples: NDArray[np.int_], points,
    periods, changes: Mapping[str, NDArray[np.float64]] | None = None, level: float = 0.95,
) -> SiteTerm:  # fmt: skip
    """Return the term of ln AF of plane runs and columns, shape (samples, points, periods).

    The plane runs are those of `samples` of the columns; `changes` are those of ln AF of the first
    runs by finer models.
    """
    import xarray as xr

    shape, changes = logs.shape[1:], changes or {}
    terms = _controls(control)
    weights = 1 / _chances(terms)[samples] / len(control)
    terms = terms[:, : len(logs) // 2 - 1]
    rows = []
    for i, j in np.ndindex(shape):
        values = control[:, i, j]
        residual = values - values.mean() - terms @ (terms.T @ values) / len(values)
        own_terms = [residual / residual.std()] if residual.std() > _MISSED * values.std() else []
        all_terms = np.column_stack([terms, *own_terms])
        by_columns, plain = (_estimate(logs[:, i, j], basis, samples, weights, values, level)
                             for basis in (all_terms, all_terms[:, :0]))  # fmt: skip
        useful = plain["sampling"] ** 2 > _WORTH * by_columns["sampling"] ** 2
        rows.append(by_columns if useful else plain)
    dims = ("point", "period")
    data: dict = {name: (dims, np.reshape([row[name] for row in rows], shape)) for name in rows[0]}
    parts = np.array([
        _RICHARDSON * np.abs(np.average(change, axis=0, weights=weights[: len(change)]))
        for change in changes.values()
    ]).reshape(-1, *shape)  # fmt: skip
    data["discretisation"] = (("error", *dims), parts)
    data["total"] = (dims, data["sampling"][1] + parts.sum(axis=0))
    axes = {"point": list(points), "period": np.atleast_1d(periods), "error": list(changes)}
    sizes = {"runs": len(logs), "columns": len(control), "level": level}
    return SiteTerm(xr.Dataset(data, axes, sizes))


def _log_amplification(model, samples, shape, folder, workers) -> NDArray[np.float64]:
    """Return ln AF of samples, which may repeat, shape (samples, points, periods)."""
    from ..study.api import study

    distinct, inverse = np.unique(samples, return_inverse=True)
    table = study(model, {"sample": distinct.tolist()}, folder=folder, workers=workers)
    if (table.status != "complete").any():
        message = next(text for text in table.message.values if text)
        raise InputError(f"a plane run fails: {message}")
    factors = table["value"].values.reshape(-1, *shape)
    _check_amplification("plane run", distinct, factors)
    return np.log(factors)[inverse]


def _check_amplification(kind: str, samples, factors: NDArray[np.float64]) -> None:
    """Raise InputError if a factor of a sample is not finite and above 0."""
    is_invalid = ~((factors > 0) & (factors < np.inf)).all(axis=(1, 2))
    if is_invalid.any():
        raise InputError(f"{kind} {samples[is_invalid.argmax()]} has an amplification that is not "
                         "finite and above 0: check its layers")  # fmt: skip


def _controls(control) -> NDArray[np.float64]:
    """Return the controls of all columns, orthonormal and with mean 0, shape (columns, terms).

    They do not depend on the number of runs, so more runs include those of fewer runs.
    """
    columns = control.reshape(len(control), -1)
    components, size = _orthonormal(columns / np.maximum(columns.std(axis=0), 1e-12))
    components, size = components[:, :_TERMS], size[:_TERMS] / size[:1]
    first, second = np.triu_indices(size.size)
    terms = np.hstack([components, components[:, first] * components[:, second]])
    order = np.argsort(-np.append(size, _PRODUCT * size[first] * size[second]), kind="stable")
    return _orthonormal(terms[:, order[:_TERMS]])[0]


def _orthonormal(values) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return principal components with mean 0 and variance 1, and their sizes."""
    vectors, size, _ = np.linalg.svd(values - values.mean(axis=0), full_matrices=False)
    is_nonzero = size > 1e-8 * size.max(initial=1e-12)
    return np.sqrt(len(values)) * vectors[:, is_nonzero], size[is_nonzero]


def _chances(terms) -> NDArray[np.float64]:
    """Return the probability of each sample: half by its leverage, half equal."""
    leverage = (1 + np.sum(terms**2, axis=1)) / (1 + terms.shape[1])
    return (1 + leverage) / (2 * len(terms))


def _estimate(logs, terms, samples, weights, control, level: float) -> dict[str, float]:
    """Return mean and σ of plane runs by controls `terms`; `control` is ln AF of the columns."""
    from scipy.special import ndtri, stdtrit

    runs, columns, total = len(logs), len(terms), weights.sum()
    design = np.column_stack([np.ones(runs), terms[samples]])
    projection = np.linalg.pinv(design.T @ (weights[:, None] * design)) @ (weights * design.T)
    mean, *slope = projection @ logs
    residual = logs - design @ (projection @ logs)
    leverage = np.sum(design.T * projection, axis=0)
    loo_residual = residual / np.maximum(1 - leverage, 1e-3)  # of a fit without the same run
    variance = np.sum((projection[0] * loo_residual) ** 2)
    explained, scatter = np.sum(np.square(slope)), weights @ (residual * loo_residual) / total
    quantile = float(stdtrit(runs - design.shape[1], (1 + level) / 2))
    half_width = quantile * np.sqrt(variance + (explained + scatter) / columns)
    plain_variance = weights @ (logs - weights @ logs / total) ** 2 / total
    sigma = np.sqrt(explained + scatter)
    # Influence of each run on σ².
    influence = 2 * (slope @ projection[1:]) * loo_residual
    influence += weights / total * (residual * loo_residual - scatter)
    sigma_variance = np.sum(influence**2) + 2 * sigma**4 / columns
    column_variance = (np.var(terms @ slope - control) + scatter) / columns
    return {
        "median": np.exp(mean),
        "sampling": half_width,
        "sigma_ln": sigma,
        "sigma_error": quantile * np.sqrt(sigma_variance) / (2 * sigma),
        "aggravation": np.exp(mean - control.mean()),
        "aggravation_sampling": quantile * np.sqrt(variance + column_variance),
        "saving": ndtri((1 + level) / 2) ** 2 * plain_variance / half_width**2 / runs,
    }
