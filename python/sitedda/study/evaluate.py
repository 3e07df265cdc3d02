# SPDX-License-Identifier: GPL-3.0-or-later
"""Run a study of a function in memory; each task of the executor has many cases."""

from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, wait

import numpy as np

from .arrays import Array
from .distribute import workers_of
from .plan import Plan, plain
from .quantities import split_value
from .table import coordinate_values

_WORKERS = 32  # number of workers of an executor if unknown
_TASKS_EACH = 8  # number of tasks per worker; several tasks balance the load


def evaluate(plan: Plan, executor, progress: Callable | None = None):
    """Call the function of a plan for all cases; return the table of results.

    `progress`: called with the numbers of ended and failed cases.

    Result: results, and ``status`` and ``message`` of each case.
    """
    cases = [{name: plain(value) for name, value in values.items()} for values in plan.changes()]
    workers = workers_of(executor) or _WORKERS
    size = max(1, -(-len(cases) // (workers * _TASKS_EACH)))
    first_cases = range(0, len(cases), size)
    futures = {executor.submit(call_each, plan.model, cases[i : i + size]): i for i in first_cases}
    rows: list = [None] * len(cases)
    count, failures, pending = 0, 0, set(futures)
    while pending:
        finished, pending = wait(pending, return_when=FIRST_COMPLETED)
        for future in finished:
            results = future.result()
            rows[futures[future] : futures[future] + len(results)] = results
            count, failures = (count + len(results),
                               failures + sum(bool(message) for _, message in results))  # fmt: skip
        if progress:
            progress(count, failures)
    return _make_table(plan, rows)


def call_each(function: Callable, cases: Sequence[dict]) -> list[tuple[dict, str]]:
    """Call a function for each case; return its values and the message of its failure, if any."""
    results = []
    for values in cases:
        try:
            results.append((split_value("value", function(**values)), ""))
        except Exception as error:  # an error fails only this case
            results.append(({}, f"{type(error).__name__}: {error}"))
    return results


def _make_table(plan: Plan, rows: list):
    """Return the dataset of a study from values and message of each case."""
    import xarray as xr

    dims, shape = tuple(plan.dims), tuple(plan.dims.values())
    messages = np.array([message for _, message in rows], dtype=object)
    status = np.where(messages == "", "complete", "failed").astype(object)
    variables = {
        "status": (dims, status.reshape(shape)),
        "message": (dims, messages.reshape(shape)),
    }
    coordinates = {
        name: (tuple(names), coordinate_values([plain(v) for v in values]), attributes)
        for axis in plan.axes
        for name, (names, values, attributes) in axis.coordinates.items()
    }
    for name in dict.fromkeys(name for values, _ in rows for name in values):
        sample = next(values[name] for values, _ in rows if name in values)
        results = sample if isinstance(sample, Array) else Array(np.asarray(sample), (), {})
        column = np.full((len(rows), *results.values.shape), np.nan)
        for i, (values, _) in enumerate(rows):
            if name in values:
                column[i] = getattr(values[name], "values", values[name])
        variables[name] = ((*dims, *results.dims), column.reshape(*shape, *results.values.shape))
        coordinates |= {d: ((d,), c, {}) for d, c in results.coordinates.items()}
    return xr.Dataset(variables, coordinates, {"model": str(getattr(plan.model, "__name__", ""))})
