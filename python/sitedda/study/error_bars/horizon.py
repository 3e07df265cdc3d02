# SPDX-License-Identifier: GPL-3.0-or-later
"""Predictability of a run from twins: its horizon, and the spread of results after the horizon.

A twin is the run with one block displaced by 1e-9 of its size.  Impacts, and slip that starts or
stops, make run and twin diverge exponentially.  The horizon of a result is the time at which run
and twin differ.  After the horizon the result is a random sample, even with small time steps.
"""

import math
from dataclasses import replace

import numpy as np

from ...base.numbers import number
from .figures import BEYOND, NOT_CONVERGED, YIELD, Band, Figure, is_count
from .variants import ENSEMBLE, RUN, TWIN

DIVERGED = 0.01  # difference at the horizon, as a fraction of the largest value of a result
ROUND_OFF = 1e-8  # differences below this fraction of the largest value are rounding errors
_LEAST_TIMES = 10  # smallest number of values to which the growth is fitted
FRACTILES = (16.0, 50.0, 84.0)  # fractiles of the twins of an ensemble, %
_HISTORY = "history_"
# Beginnings of names: results without a stored history use the history of another result.
_SAME_HORIZON = {"residual_": "largest_", "pga_below_50_hz_m_s2": "pga_m_s2", "sa_m_s2": "pga_m_s2",
           "pga_resolved_m_s2": "pgv_m_s", "sa_resolved_m_s2": "pgv_m_s",
           "arias_resolved_m_s": "arias_m_s"}  # fmt: skip


def horizon(time: np.ndarray, run: np.ndarray, twin: np.ndarray) -> float:
    """Return the last time before two histories diverge, s; inf if they do not diverge.

    `time`: s; `run`, `twin`: histories of a result in the run and in its twin; NaN if missing.
    """
    largest = np.nanmax(np.abs(run), initial=0.0)
    is_different = np.abs(run - twin) > DIVERGED * largest
    is_different |= np.isnan(run) != np.isnan(twin)
    if not is_different.any():
        return math.inf
    last_equal = max(int(np.argmax(is_different)) - 1, 0)
    growth = _fit_growth(time, np.abs(run - twin) / largest, last_equal + 1)
    return min(float(time[last_equal]), growth)


def _fit_growth(time: np.ndarray, difference: np.ndarray, end: int) -> float:
    """Return the time (s) at which a fitted exponential difference reaches `DIVERGED`.

    Unlike the first value above `DIVERGED`, the fitted function does not depend on a single impact.
    """
    largest_so_far = np.fmax.accumulate(difference[: end + 1])
    fitted = (largest_so_far > ROUND_OFF) & (largest_so_far < DIVERGED)
    if fitted.sum() < _LEAST_TIMES:
        return math.inf
    rate, intercept = np.polyfit(time[: end + 1][fitted], np.log(largest_so_far[fitted]), 1)
    return float((math.log(DIVERGED) - intercept) / rate) if rate > 0 else math.inf


def with_horizons(figures: dict[str, Figure], table) -> dict[str, Figure]:
    """Add horizon and spread of the ensemble to results.

    `table`: results and histories of all runs.
    """
    names = [str(name) for name in table.variant.values]
    complete = {n for n in names if str(table.sel(variant=n).status.values) == "complete"}
    twins = [n for n in names if n.startswith(ENSEMBLE) and n in complete]
    result = dict(figures)
    if TWIN in complete and "look" in table:
        divergence_times = _divergence_times(table)
        result = {n: replace(f, decided=_find_horizon(n, table, divergence_times))
                  for n, f in result.items()}  # fmt: skip
        # The initial displacement changes small results; the kinetic energy shows the divergence.
        divergence = divergence_times.get("energy_kinetic", math.inf)
        result = {n: _mark_undecided(f, _time_reached(n, table), divergence)
                  for n, f in result.items()}  # fmt: skip
    if twins:
        rows = table.sel(variant=twins)
        result = {n: _add_spread(f, rows[n].values) for n, f in result.items()}
    return result


def bands_of(table) -> dict[str, Band]:
    """Return the spread of each result over time in an ensemble of twins, by name.

    `table`: results and histories of all runs.
    """
    twins = [str(n) for n in table.variant.values if str(n).startswith(ENSEMBLE)]
    if not twins or "look" not in table:
        return {}
    rows = table.sel(variant=twins)
    result = {}
    for name in filter(lambda n: n.startswith(_HISTORY), table.data_vars):
        values = rows[name].transpose("variant", "look").values
        values = values[~np.isnan(values).all(axis=1)]
        if len(values):
            low, median, high = np.nanpercentile(values, FRACTILES, axis=0)
            result[name.removeprefix(_HISTORY)] = Band(rows.look.values, low, median, high)
    return result


def _divergence_times(table) -> dict[str, float]:
    """Return the time (s) at which run and twin diverge in each stored history."""
    run, twin, time = table.sel(variant=RUN), table.sel(variant=TWIN), table.look.values
    names = [name for name in table.data_vars if name.startswith(_HISTORY)]
    return {name.removeprefix(_HISTORY): horizon(time, run[name].values, twin[name].values)
            for name in names}  # fmt: skip


def _find_horizon(name: str, table, divergence_times: dict[str, float]) -> float:
    """Return the horizon of a result, s; without a stored history, the earliest horizon of all."""
    end = float(table.look.values[-1])
    if name in divergence_times:
        return min(divergence_times[name], end)
    run, twin = (float(table[name].sel(variant=v)) for v in (RUN, TWIN))
    if abs(run - twin) <= DIVERGED * abs(run) or math.isnan(run) and math.isnan(twin):
        return end
    history = next((name.replace(a, b) for a, b in _SAME_HORIZON.items() if name.startswith(a)), "")
    limit = divergence_times.get(history, math.inf)
    return min(limit if limit < end else min(divergence_times.values(), default=end), end)


def _time_reached(name: str, table) -> float:
    """Return the time at which a result first reached its final value, s."""
    history = f"{_HISTORY}{name}"
    if history not in table.data_vars:
        quantity = next((b for a, b in _SAME_HORIZON.items() if name.startswith(a)), "")
        history = f"{_HISTORY}{quantity}{name[name.find('[') :] if '[' in name else ''}"
        if name.startswith("residual_") or history not in table.data_vars:
            return float(table.look.values[-1])
    values = table[history].sel(variant=RUN).values
    return float(table.look.values[int(np.argmax(values >= values[-1]))])


def _mark_undecided(figure: Figure, time: float, divergence: float) -> Figure:
    """Mark a result that reached its final value after its horizon.

    Results that do not converge, or depend on k_n only, use `divergence`, the horizon of the run.
    """
    reason, colon, numbers = figure.doubt.partition(":")
    if is_count(figure.name):
        horizon = divergence if reason or figure.name.startswith("contacts_") else math.inf
    else:
        horizon = {NOT_CONVERGED: divergence, YIELD: divergence}.get(reason, figure.decided)
    if not time > horizon:
        return figure
    doubt = f"{BEYOND} of {number(horizon, 3)} s, a random sample"
    return replace(figure, doubt=f"{doubt}{colon}{numbers}" if reason == NOT_CONVERGED else doubt)


def _add_spread(figure: Figure, values: np.ndarray) -> Figure:
    """Add the fractiles of the values in an ensemble to a result."""
    values = values[np.isfinite(values)]
    if len(values) == 0:
        return figure
    low, median, high = (float(v) for v in np.percentile(values, FRACTILES))
    return replace(figure, low=low, median=median, high=high)
