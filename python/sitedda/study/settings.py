# SPDX-License-Identifier: GPL-3.0-or-later
"""Read a study from a TOML file."""

import tomllib
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field, fields
from pathlib import Path

import numpy as np

from ..base.arguments import DAMPING_RATIO, FINITE, POSITIVE, Range
from ..base.errors import InputError, located
from ..base.files import is_below, plain_text
from ..base.reading import read_bounded
from ..input.groups import nearest
from .axes import Axis, Points, axes_of
from .figures import check_figures
from .plan import Plan, make_plan
from .pushing import PushTo
from .records import Records
from .sampling import latin_hypercube, one_at_a_time, read_points, saltelli, sobol
from .slurm import Slurm
from .solving import SolveFor
from .workers import check_limits

_TASKS: dict[str, type] = {"solve": SolveFor, "pushover": PushTo}  # tables that define the task
_CASES, _SEED = Range(1, 1e6, whole=True), Range(0, 2**53, whole=True)
_NUMBERS = [float]
_NAMES = str | list | dict
_TYPE_NAMES: dict = {str: "a text", dict: "a table", list: "a list", bool: "true or false",
                     _NAMES: "a name, a list or a table of names"}  # fmt: skip
_OF_TYPE: dict = {str: str, bool: bool, int: FINITE, float: FINITE}
# The names in each table and the types or ranges of their values; None: checked elsewhere.
_KEYS: dict[str, dict] = {
    "": {"model": str, "folder": str, "table": str, "task": str, "results": _NAMES,
         "time_limit": None, "memory": None, "fixed": dict, "parameters": dict, "sample": dict,
         "records": dict, "solve": dict, "pushover": dict, "slurm": dict, "figures": list},
    **{name: {one.name: _OF_TYPE.get(one.type) for one in fields(kind)}
       for name, kind in _TASKS.items()},
    "parameter": {"from": FINITE, "to": FINITE, "count": _CASES, "spacing": str, "values": list,
                  "changes": str},
    "sample": {"method": str, "count": _CASES, "seed": _SEED, "parameters": dict, "file": str},
    "records": {"files": list, "synthetic": dict, "levels": _NUMBERS, "measure": str,
                "motion": str, "period": POSITIVE, "damping": DAMPING_RATIO, "format": str,
                "quantity": str, "unit": str, "time_step": POSITIVE},
    "records.synthetic": {"count": _CASES, "first_seed": _SEED, "spectrum": dict,
                          "duration": POSITIVE, "time_step": POSITIVE, "periods": _NUMBERS,
                          "damping": DAMPING_RATIO},
    "spectrum": {"eurocode8": dict, "periods": _NUMBERS, "values": _NUMBERS},
    "eurocode8": {"peak": POSITIVE, "ground": str, "kind": Range(1, 2, whole=True)},
    "slurm": dict.fromkeys(("program", "each", "time", "memory", "options")),
}  # fmt: skip
_LARGEST = 2**24  # largest size of a study file, bytes
_SAMPLES = {"latin_hypercube": latin_hypercube, "sobol": sobol, "saltelli": saltelli}


@dataclass
class Settings:
    """Settings of a study from a file."""

    plan: Plan
    table: Path  # file of the table
    slurm: Slurm = field(default_factory=Slurm)
    limits: dict = field(default_factory=dict)  # `time_limit` (s) and `memory` (bytes) of a case
    figures: list = field(default_factory=list)  # figures of the report


def read_settings(file, folder=None) -> Settings:
    """Read a study file; file names in it are relative to its folder.

    `folder`: folder of the study; it replaces the one in the file and may be anywhere.
    """
    file = Path(file)
    try:
        values = tomllib.loads(read_bounded(file, _LARGEST).decode("utf-8"))
    except RecursionError:
        raise InputError(f"{file}: its tables or lists are nested too deeply") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as trouble:
        raise InputError(f"{file}: {trouble}") from None
    with located(file, TypeError, ValueError, ArithmeticError):
        _check_values("", values)
        return _parse_settings(values, file, folder)


def _parse_settings(values: dict, file: Path, folder: Path | None) -> Settings:
    """Convert the values of a study file to settings."""
    _check_names(values, "")
    if "model" not in values:
        raise InputError("model is missing: give the name of the input file")
    parent = file.parent
    name = values.get("folder", f"{file.stem}_study")
    folder = folder or parent / _path_in_folder(parent, "folder", name)
    axes, results = _parse_axes(values, parent), values.get("results")
    model, fixed = parent / values["model"], values.get("fixed")
    plan = make_plan(model, axes, results, folder, fixed, _parse_task(values))
    table = folder / "table.nc"
    if "table" in values:
        table = parent / _path_in_folder(parent, "table", values["table"])
    time_limit, memory = values.get("time_limit", np.inf), values.get("memory")
    check_limits(memory, time_limit)
    slurm = dict(values.get("slurm", {}))
    _check_names(slurm, "slurm")
    limits = {"time_limit": time_limit, "memory": None if memory is None else 1e6 * memory}
    figures = check_figures(values.get("figures", []), plan)
    return Settings(plan, table.absolute(), Slurm.of_study(slurm), limits, figures)


def _parse_task(values: dict):
    """Return the task of the cases: 'run', 'safety', or a table [solve] or [pushover]."""
    tasks = [name for name in _TASKS if name in values]
    if not tasks:
        return values.get("task", "run")
    table = tasks[0]
    if len(tasks) > 1:
        raise InputError(f"[{table}] and [{tasks[1]}] are two tasks: remove one")
    if "task" in values or "results" in values:
        advice = "remove the keys `task` and `results`"
        raise InputError(f"[{table}] defines the task and its results: {advice}")
    options = dict(values[table])
    _check_names(options, table)
    for entry in fields(_TASKS[table]):
        if entry.default is MISSING and entry.name not in options:
            raise InputError(f"[{table}] {entry.name} is missing")
    if isinstance(options.get("between"), list):
        options["between"] = tuple(options["between"])
    return _TASKS[table](**options).checked()


def _path_in_folder(parent: Path, key: str, name) -> str:
    """Return the path of a file that a study writes; raise InputError if outside of `parent`."""
    if not name:
        raise InputError(f"{key} = {name!r} is not a file name")
    if not is_below(parent, name):
        option = {"folder": "--folder", "table": "--output"}[key]
        raise InputError(f"{key} = {name!r} is outside of the folder of the study file; "
                         f"to write there, remove {key} and use the option {option}")  # fmt: skip
    return name


def _check_values(path: str, values) -> None:
    """Check that texts contain no control characters, and that numbers are finite.

    Limits may be infinite; figures are checked separately.
    """
    if isinstance(values, str):
        plain_text(path, values)
    elif isinstance(values, float) and not np.isfinite(values):
        if path == "time_limit" or path.startswith("figures."):
            return
        raise InputError(f"{path} = {values} is not a finite number")
    elif isinstance(values, Mapping):
        for name, value in values.items():
            plain_text("a name", name)
            _check_values(f"{path}.{name}" if path else name, value)
    elif isinstance(values, list):
        for value in values:
            _check_values(path, value)


def _parse_axes(values: dict, parent: Path) -> list[Axis]:
    """Return the axes of [parameters], [sample] and [records]."""
    axes: list = []
    parameters = {path: _parse_values(path, v) for path, v in values.get("parameters", {}).items()}
    if parameters:
        axes.append(parameters)
    if "sample" in values:
        axes.append(_parse_sample(values["sample"], parent))
    if "records" in values:
        axes.append(_parse_records(values["records"], parent))
    if not axes and not any(name in values for name in _TASKS):
        raise InputError("nothing varies: give [parameters], [sample], [records], [solve] or "
                         "[pushover]")  # fmt: skip
    return axes_of(axes)


def _parse_values(path: str, values):
    """Return the values of a parameter from a list or table, and the variable that it changes."""
    if not isinstance(values, Mapping):
        return values
    _check_names(values, "parameter", f"parameter {path!r}: ")
    changes = values.get("changes")
    numbers = values.get("values")
    if numbers is None:
        if not all(name in values for name in ("from", "to", "count")):
            raise InputError(f"parameter {path!r}: give a list, or `from`, `to` and `count`")
        space = {"linear": np.linspace, "log": np.geomspace}.get(values.get("spacing", "linear"))
        if space is None:
            raise InputError(f"parameter {path!r}: spacing must be 'linear' or 'log'")
        if space is np.geomspace and values["from"] * values["to"] <= 0:
            limits = "`from` and `to` of the same sign"
            raise InputError(f"parameter {path!r}: spacing = 'log' requires {limits}")
        limits = float(values["from"]), float(values["to"])
        numbers = space(*limits, int(values["count"])).tolist()
        if isinstance(values["from"], int) and all(number.is_integer() for number in numbers):
            numbers = list(map(int, numbers))  # seeds and counts must be integers
    return (changes, numbers) if changes else numbers


def _parse_sample(values: dict, parent: Path):
    """Return the axis of [sample]: a design, or rows of a file with further random parameters."""
    _check_names(values, "sample")
    method, parameters = values.get("method", "latin_hypercube"), values.get("parameters", {})
    if method == "one_at_a_time":
        return one_at_a_time(parameters)
    if method not in _SAMPLES:
        methods = ", ".join([*_SAMPLES, "one_at_a_time"])
        raise InputError(f"[sample] method = {method!r}: use {methods}")
    if "file" in values:
        if method != "latin_hypercube":
            raise InputError("[sample] file requires method = 'latin_hypercube'")
        points = read_points(parent / values["file"], values.get("count"))
        if not parameters:
            return points
        sample = latin_hypercube(points.dims[points.name], parameters, values.get("seed", 0))
        return Points(points.name, {**points.values, **sample.values})
    if "count" not in values:
        raise InputError("[sample] `count` is missing")
    return _SAMPLES[method](values["count"], parameters, values.get("seed", 0))


def _parse_records(values: dict, parent: Path) -> Records:
    _check_names(values, "records")
    values = dict(values)
    if "levels" not in values:
        raise InputError("[records] `levels` is missing")
    records = [parent / name for name in values.pop("files", [])]
    if "synthetic" in values:
        records += _parse_synthetic(values.pop("synthetic"))
    return Records(records, **values)


def _parse_synthetic(values: dict) -> list:
    """Return the synthetic records of [records.synthetic]."""
    from ..stability.code_spectra import eurocode8
    from .fitted_motion import synthetic

    _check_names(values, "records.synthetic")
    values = dict(values)
    spectrum = values.pop("spectrum", None)
    if spectrum is None:
        raise InputError("[records.synthetic] spectrum is missing: {eurocode8 = {peak = 2.0}} or "
                         "{periods = [...], values = [...]}")  # fmt: skip
    _check_names(spectrum, "spectrum")
    if "eurocode8" in spectrum:
        _check_names(spectrum["eurocode8"], "eurocode8")
        target = eurocode8(**spectrum["eurocode8"])
    elif {"periods", "values"} <= set(spectrum):
        target = (spectrum["periods"], spectrum["values"])
    else:
        raise InputError("[records.synthetic] spectrum: give eurocode8, or periods and values")
    first_seed, count = values.pop("first_seed", 1), values.pop("count", 1)
    if "periods" in values:
        if len(values["periods"]) != 2:
            raise InputError("[records.synthetic] periods: give shortest and longest period, s")
        values["periods"] = tuple(values["periods"])
    return synthetic(range(first_seed, first_seed + count), target, **values)


def _check_names(values: Mapping, table: str, path: str | None = None) -> None:
    """Check the names in a table, and the types or ranges of their values; see `_KEYS`."""
    path = (f"[{table}] " if table else "") if path is None else path
    for name, value in values.items():
        if name not in _KEYS[table]:
            raise InputError(f"{path}there is no name {name!r}{nearest(name, _KEYS[table])}")
        kind = _KEYS[table][name]
        if isinstance(kind, Range):
            _check_number(path + name, kind, value)
        elif kind == _NUMBERS:
            if not isinstance(value, list):
                raise InputError(f"{path}{name} = {value!r} is not a list of numbers")
            for item in value:
                _check_number(path + name, FINITE, item)
        elif kind and not isinstance(value, kind):
            raise InputError(f"{path}{name} = {value!r} is not {_TYPE_NAMES[kind]}")


def _check_number(name: str, kind: Range, value) -> None:
    """Check that a value is a number in a range."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{name} = {value!r} is not a number")
    kind.check(name, value)
