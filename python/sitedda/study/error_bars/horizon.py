# SPDX-License-Identifier: GPL-3.0-or-later
"""Predictability of a run from twins: its horizon, and the spread of figures beyond it.

A twin is the run with one block displaced by 1e-9 of its size.  Impacts and slip that starts or
stops let the two part exponentially; from the time on at which a figure of the twin is another one,
no time step, however small, gives *the* figure: it is one of a distribution.
"""

import math
from dataclasses import replace

import numpy as np

from ...base.numbers import number
from .figures import BEYOND, OPEN, YIELD, Band, Figure, is_count
from .variants import ENSEMBLE, RUN, TWIN

APART = 0.01  # of the largest value of a figure: difference at the horizon
BEGUN = 1e-8  # of it: differences below are rounding
_LEAST_LOOKS = 10  # for a fit of the growth
SHARES = (16.0, 50.0, 84.0)  # %, of the twins of an ensemble
_HISTORY = "history_"
# Figures without a stored history use that of another one.
_FOLLOW = {"residual_": "largest_", "pga_below_50_hz_m_s2": "pga_m_s2", "sa_m_s2": "pga_m_s2",
           "pga_resolved_m_s2": "pgv_m_s", "sa_resolved_m_s2": "pgv_m_s",
           "arias_resolved_m_s": "arias_m_s"}  # fmt: skip


def horizon(time: np.ndarray, run: np.ndarray, twin: np.ndarray) -> float:
    """The last time at which two histories have not yet parted, s; inf if they never do.

    Parameters
    ----------
    time : ndarray, shape (looks,)
    run, twin : ndarray, shape (looks,)
        A figure of the run and of its twin; NaN where it is not there.
    """
    largest = np.nanmax(np.abs(run), initial=0.0)
    apart = np.abs(run - twin) > APART * largest
    apart |= np.isnan(run) != np.isnan(twin)
    if not apart.any():
        return math.inf
    first = max(int(np.argmax(apart)) - 1, 0)
    return min(float(time[first]), _by_growth(time, np.abs(run - twin) / largest, first + 1))


def _by_growth(time: np.ndarray, apart: np.ndarray, end: int) -> float:
    """When a difference that grows exponentially is `APART`, by a line fitted to its logarithm.

    The first time at which it is hangs on the step in which one impact is or is not.
    """
    grown = np.fmax.accumulate(apart[: end + 1])
    use = (grown > BEGUN) & (grown < APART)
    if use.sum() < _LEAST_LOOKS:
        return math.inf
    rate, start = np.polyfit(time[: end + 1][use], np.log(grown[use]), 1)
    return float((math.log(APART) - start) / rate) if rate > 0 else math.inf


def with_horizons(figures: dict[str, Figure], table) -> dict[str, Figure]:
    """Figures with the time until which they are decided, and with the spread of the ensemble.

    Parameters
    ----------
    figures : dict of Figure
    table : xarray.Dataset
        Of the runs, with their histories.
    """
    names = [str(name) for name in table.variant.values]
    done = {n for n in names if str(table.sel(variant=n).status.values) == "complete"}
    twins = [n for n in names if n.startswith(ENSEMBLE) and n in done]
    found = dict(figures)
    if TWIN in done and "look" in table:
        parted = _parted(table)
        found = {n: replace(f, decided=_decided(n, table, parted)) for n, f in found.items()}
        # A displaced block alters small figures at once; kinetic energy differs where motions part.
        first = parted.get("energy_kinetic", math.inf)
        found = {n: _horizon_words(f, _time_reached(n, table), first) for n, f in found.items()}
    if twins:
        rows = table.sel(variant=twins)
        found = {n: _spread(f, rows[n].values) for n, f in found.items()}
    return found


def bands_of(table) -> dict[str, Band]:
    """Spread of each figure over time in an ensemble of twins, by name.

    Parameters
    ----------
    table : xarray.Dataset
        Of the runs, with their histories.
    """
    twins = [str(n) for n in table.variant.values if str(n).startswith(ENSEMBLE)]
    if not twins or "look" not in table:
        return {}
    rows = table.sel(variant=twins)
    found = {}
    for name in filter(lambda n: n.startswith(_HISTORY), table.data_vars):
        values = rows[name].transpose("variant", "look").values
        values = values[~np.isnan(values).all(axis=1)]
        if len(values):
            low, median, high = np.nanpercentile(values, SHARES, axis=0)
            found[name.removeprefix(_HISTORY)] = Band(rows.look.values, low, median, high)
    return found


def _parted(table) -> dict[str, float]:
    """When the run and its twin part, by the name of the history."""
    run, twin, time = table.sel(variant=RUN), table.sel(variant=TWIN), table.look.values
    names = [name for name in table.data_vars if name.startswith(_HISTORY)]
    return {name.removeprefix(_HISTORY): horizon(time, run[name].values, twin[name].values)
            for name in names}  # fmt: skip


def _decided(name: str, table, parted: dict[str, float]) -> float:
    """Horizon of one figure; the earliest of all if it has no stored history."""
    end = float(table.look.values[-1])
    if name in parted:
        return min(parted[name], end)
    run, twin = (float(table[name].sel(variant=v)) for v in (RUN, TWIN))
    if abs(run - twin) <= APART * abs(run) or math.isnan(run) and math.isnan(twin):
        return end
    other = next((name.replace(a, b) for a, b in _FOLLOW.items() if name.startswith(a)), "")
    own = parted.get(other, math.inf)
    return min(own if own < end else min(parted.values(), default=end), end)


def _time_reached(name: str, table) -> float:
    """When a figure got the value that it has at the end of the run, s."""
    history = f"{_HISTORY}{name}"
    if history not in table.data_vars:
        other = next((b for a, b in _FOLLOW.items() if name.startswith(a)), "")
        history = f"{_HISTORY}{other}{name[name.find('[') :] if '[' in name else ''}"
        if name.startswith("residual_") or history not in table.data_vars:
            return float(table.look.values[-1])
    values = table[history].sel(variant=RUN).values
    return float(table.look.values[int(np.argmax(values >= values[-1]))])


def _horizon_words(figure: Figure, reached: float, first: float) -> Figure:
    """Mark a figure as reached after the twins have diverged.

    One without a limit, or that 4 k_n changes as much, is judged by the `first` of all partings,
    others by their own.
    """
    words, between, numbers = figure.doubt.partition(":")
    if is_count(figure.name):
        until = first if words or figure.name.startswith("contacts_") else math.inf
    else:
        until = {OPEN: first, YIELD: first}.get(words, figure.decided)
    if not reached > until:
        return figure
    where = f"{BEYOND} of {number(until, 3)} s, one of a distribution"
    return replace(figure, doubt=f"{where}{between}{numbers}" if words == OPEN else where)


def _spread(figure: Figure, values: np.ndarray) -> Figure:
    values = values[np.isfinite(values)]
    if len(values) == 0:
        return figure
    low, median, high = (float(v) for v in np.percentile(values, SHARES))
    return replace(figure, low=low, median=median, high=high)
