# SPDX-License-Identifier: GPL-3.0-or-later
"""Check the figures that a study file requests, before the first case is run."""

import inspect
import math
from collections.abc import Callable, Mapping

import numpy as np

from ..base.errors import InputError, located
from ..input.groups import nearest
from .axes import RESERVED
from .dynamic_analysis import ida
from .fragility_curve import fragility_of
from .maps import bands, parameter_map
from .quantities import NAMES
from .sensitivity import sobol_indices, tornado

KINDS: dict[str, Callable] = {
    "fragility": fragility_of, "ida": ida, "tornado": tornado, "sobol": sobol_indices,
    "map": parameter_map, "bands": bands,
}  # fmt: skip
_DIMENSIONS = ("intensity", "record", "dim", "x", "y")
_NUMBERS = ("threshold", "level", "confidence", "seed", "design")


def known_kind(kind) -> str:
    """Return a kind of figure; raise InputError if there is no such kind."""
    if not isinstance(kind, str) or kind not in KINDS:
        raise InputError(f"[[figures]] kind = {kind!r} is not {', '.join(KINDS)}"
                         f"{nearest(str(kind), KINDS)}")  # fmt: skip
    return kind


def arguments_of(kind: str, values: Mapping) -> inspect.BoundArguments:
    """Return the bound arguments of the function of a kind of figure; the table is None."""
    signature = inspect.signature(KINDS[kind])
    try:
        return signature.bind(None, **values)
    except TypeError:
        names = list(signature.parameters)[1:]
        unknown = next((name for name in values if name not in names), None)
        fault = f"there is no key {unknown!r}" if unknown else "a key is missing"
        raise InputError(f"kind {kind!r}: {fault}; its keys are {', '.join(names)}") from None


def check_figures(figures, plan) -> list[dict]:
    """Return the figures of a study file; check that the results of the study will suffice.

    `figures`: the tables [[figures]] of the file; `plan`: the plan of the study.
    """
    if not isinstance(figures, list) or not all(isinstance(item, Mapping) for item in figures):
        raise InputError("figures must be a list of tables [[figures]]")
    for number, values in enumerate(figures, 1):
        with located(f"figure {number}"):
            _check_figure(dict(values), plan)
    return [dict(values) for values in figures]


def _check_figure(values: dict, plan) -> None:
    """Check kind, title, selection and arguments of a figure."""
    kind = known_kind(values.pop("kind", None))
    if not isinstance(title := values.pop("title", ""), str):
        raise InputError(f"title = {title!r} is not a text")
    select = values.pop("select", {})
    if not isinstance(select, Mapping):
        raise InputError(f"select = {select!r}: give dimensions and values, as {{scale = 1.0}}")
    for name, value in select.items():
        _check_selection(name, value, plan)
    arguments = arguments_of(kind, values)
    arguments.apply_defaults()
    for name, value in list(arguments.arguments.items())[1:]:
        _check_argument(name, value, select, plan)


def _check_argument(name: str, value, select: Mapping, plan) -> None:
    """Check the type, range or existence of one argument of a figure."""
    if name in _NUMBERS:
        optional = value is None and name in ("threshold", "level", "design")
        if not optional and (isinstance(value, bool) or not isinstance(value, int | float)
                             or not math.isfinite(value)):  # fmt: skip
            raise InputError(f"{name} = {value!r} is not a number")
        if name == "confidence" and not 0 < value < 1:
            raise InputError(f"confidence = {value!r} must be between 0 and 1")
        if name == "seed" and (value < 0 or value != int(value)):
            raise InputError(f"seed = {value!r} must be a whole number of 0 or more")
        return
    if not isinstance(value, str):
        raise InputError(f"{name} = {value!r} is not a name")
    if name in _DIMENSIONS:
        _check_dimension(name, value, plan)
        if value in select and not isinstance(select[value], list):
            raise InputError(f"{name} = {value!r}: `select` gives this dimension only one "
                             "value; choose another dimension or a list of values")  # fmt: skip
        return
    names, stem = _known_results(plan), value.partition("[")[0].partition(".")[0]
    if names and not names & {value, stem}:
        raise InputError(f"{name} = {value!r} is not a result of the study{nearest(value, names)}")


def _check_dimension(key: str, name: str, plan) -> None:
    """Check that a dimension exists in the study or in an array result."""
    is_of_results = key in ("x", "y", "select") and (name in RESERVED or _uses_functions(plan))
    if name not in plan.dims and not is_of_results:
        raise InputError(f"{key}: there is no dimension {name!r}{nearest(name, plan.dims)}; the "
                         f"study has {', '.join(plan.dims)}")  # fmt: skip


def _check_selection(name: str, value, plan) -> None:
    """Check that the values of a dimension that a figure selects exist."""
    _check_dimension("select", name, plan)
    if name not in plan.dims:
        return
    coordinates = np.arange(plan.dims[name])
    for axis in plan.axes:
        dims, values, _ = axis.coordinates.get(name, ((), (), {}))
        if tuple(dims) == (name,):
            coordinates = np.asarray(values)
    for choice in value if isinstance(value, list) else [value]:
        if not any(
            choice == coordinate and not isinstance(choice, bool)
            for coordinate in coordinates.tolist()
        ):
            listing = ", ".join(map(str, coordinates[:8])) + (" …" if len(coordinates) > 8 else "")
            raise InputError(f"select: {name} has no value {choice!r}; it has {listing}")


def _uses_functions(plan) -> bool:
    """Return whether functions compute results, so that their names and dimensions are unknown."""
    knows_results = plan.task == "run" or getattr(plan.task, "results", ())
    return callable(plan.model) or not knows_results or any(q.function for q in plan.quantities)


def _known_results(plan) -> set[str]:
    """Return the names of results without points and units; an empty set if they are unknown.

    The attribute ``results`` of a function contains the names of its results.
    """
    task_results = {name for function in (plan.task, plan.model)
                    for name in getattr(function, "results", ())}  # fmt: skip
    if task_results or _uses_functions(plan):
        return task_results
    groups = {function.name for function in plan.quantities} & {"verdict", "figures", "histories"}
    names = {function.label for function in plan.quantities}
    if groups:
        names |= NAMES | {f"history_{name}" for name in NAMES | {"energy_kinetic"}}
    return names
