# SPDX-License-Identifier: GPL-3.0-or-later
"""A study as a TOML file."""

import tomllib
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field, fields
from pathlib import Path

import numpy as np

from ..base.errors import InputError
from ..base.files import is_below, plain_text
from ..base.reading import read_bounded
from ..input.groups import nearest
from .axes import Axis, axes_of
from .figures import check_figures
from .plan import Plan, make_plan
from .pushing import PushTo
from .records import Records
from .sampling import latin_hypercube, one_at_a_time, saltelli, sobol
from .slurm import Slurm
from .solving import SolveFor
from .workers import check_limits

_TASKS: dict[str, type] = {"solve": SolveFor, "pushover": PushTo}  # tables that say what is done
_KNOWN = {
    "": ("model", "folder", "table", "task", "results", "time_limit", "memory", "fixed",
         "parameters", "sample", "records", "solve", "pushover", "slurm", "figures"),
    **{name: tuple(one.name for one in fields(kind)) for name, kind in _TASKS.items()},
    "sample": ("method", "count", "seed", "parameters"),
    "records": ("files", "synthetic", "levels", "measure", "motion", "period", "damping", "format",
                "quantity", "unit", "time_step"),
    "records.synthetic": ("count", "first_seed", "spectrum", "duration", "time_step", "periods",
                          "damping"),
    "slurm": ("program", "each", "time", "memory", "options"),
}  # fmt: skip
_LARGEST = 2**24  # bytes of a file of a study
_SAMPLES = {"latin_hypercube": latin_hypercube, "sobol": sobol, "saltelli": saltelli}


@dataclass
class Settings:
    """What a file says of a study.

    Attributes
    ----------
    plan : Plan
    table : Path
        Where the table is written.
    slurm : Slurm
    limits : dict
        ``time_limit`` (s) and ``memory`` (bytes) of a case.
    figures : list of dict
        Of the report.
    """

    plan: Plan
    table: Path
    slurm: Slurm = field(default_factory=Slurm)
    limits: dict = field(default_factory=dict)
    figures: list = field(default_factory=list)


def read_settings(file, folder=None) -> Settings:
    """Read a study; file names in it are relative to its folder.

    Parameters
    ----------
    file : path
    folder : path, optional
        Of the study, in place of what the file says; it may be anywhere.

    Raises
    ------
    InputError
        If a name in it is not known or a value cannot be; the message names file and table.
    """
    file = Path(file)
    try:
        values = tomllib.loads(read_bounded(file, _LARGEST).decode("utf-8"))
    except RecursionError:
        raise InputError(f"{file}: nested too deeply") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as trouble:
        raise InputError(f"{file}: {trouble}") from None
    try:
        _check_texts("", values)
        return _settings(values, file, folder)
    except (InputError, TypeError) as error:
        raise InputError(f"{file}: {error}") from None


def _settings(values: dict, file: Path, folder: Path | None) -> Settings:
    _check_names(values, "")
    if not isinstance(values.get("model"), str):
        raise InputError("model is missing: the namelist file that the study is of")
    here = file.parent
    folder = folder or here / _below(here, "folder", values.get("folder", f"{file.stem}_study"))
    plan = make_plan(
        here / values["model"],
        _axes(values, here),
        values.get("results"),
        folder,
        values.get("fixed"),
        _task(values),
    )
    table = folder / "table.nc"
    if "table" in values:
        table = here / _below(here, "table", values["table"])
    slurm = dict(values.get("slurm", {}))
    _check_names(slurm, "slurm")
    return Settings(
        plan,
        table.absolute(),
        Slurm.of_study(slurm),
        _limits(values),
        check_figures(values.get("figures", []), plan),
    )


def _task(values: dict):
    """What is done with each case: 'run', 'safety', or what a table [solve] or [pushover] says."""
    given = [name for name in _TASKS if name in values]
    if not given:
        return values.get("task", "run")
    table = given[0]
    if len(given) > 1:
        raise InputError(f"[{table}] and [{given[1]}] are two tasks: leave out one")
    if "task" in values or "results" in values:
        raise InputError(f"[{table}] has its own task and result: leave out task and results")
    told = dict(values[table])
    _check_names(told, table)
    for one in fields(_TASKS[table]):
        if one.default is MISSING and one.name not in told:
            raise InputError(f"[{table}] {one.name} is missing")
    if "between" in told:
        told["between"] = tuple(told["between"])
    return _TASKS[table](**told).checked()


def _limits(values: dict) -> dict:
    """Of a case, ``time_limit`` (s) and ``memory`` (bytes, MB in the file)."""
    time_limit, memory = values.get("time_limit", np.inf), values.get("memory")
    check_limits(memory, time_limit)
    return {"time_limit": time_limit, "memory": None if memory is None else 1e6 * memory}


def _below(here: Path, what: str, name) -> str:
    """A name that a study gives to what is written, which stays in its folder."""
    if not isinstance(name, str) or not name:
        raise InputError(f"{what} = {name!r} is not a file name")
    if not is_below(here, name):
        option = {"folder": "--folder", "table": "--output"}[what]
        raise InputError(f"{what} = {name!r} is not at or below the folder of the study; if it is "
                         f"meant, name it with {option}")  # fmt: skip
    return name


def _check_texts(where: str, values) -> None:
    """No text of a study holds a line end or another control character."""
    if isinstance(values, str):
        plain_text(where, values)
    elif isinstance(values, Mapping):
        for name, value in values.items():
            plain_text("a name", name)
            _check_texts(f"{where}.{name}" if where else name, value)
    elif isinstance(values, list):
        for value in values:
            _check_texts(where, value)


def _axes(values: dict, here: Path) -> list[Axis]:
    axes: list = []
    parameters = {path: _values(path, v) for path, v in values.get("parameters", {}).items()}
    if parameters:
        axes.append(parameters)
    if "sample" in values:
        axes.append(_sample(values["sample"]))
    if "records" in values:
        axes.append(_records(values["records"], here))
    if not axes and not any(name in values for name in _TASKS):
        raise InputError("nothing varies: give [parameters], [sample], [records], [solve] or "
                         "[pushover]")  # fmt: skip
    return axes_of(axes)


def _values(path: str, values):
    """A list, or ``{from, to, count, spacing}``; with ``changes`` under a name of its own."""
    if not isinstance(values, Mapping):
        return values
    values = dict(values)
    changes = values.pop("changes", None)
    known = ("from", "to", "count", "spacing", "values")
    for name in values:
        if name not in known:
            raise InputError(f"parameter {path!r}: there is no {name!r}{nearest(name, known)}")
    found = values.get("values")
    if found is None:
        if not all(name in values for name in ("from", "to", "count")):
            raise InputError(f"parameter {path!r}: give a list, or from, to and count")
        space = {"linear": np.linspace, "log": np.geomspace}.get(values.get("spacing", "linear"))
        if space is None:
            raise InputError(f"parameter {path!r}: spacing is 'linear' or 'log'")
        found = space(values["from"], values["to"], int(values["count"])).tolist()
        if isinstance(values["from"], int) and all(one.is_integer() for one in found):
            found = list(map(int, found))  # seeds and counts
    return (changes, found) if changes else found


def _sample(values: dict):
    _check_names(values, "sample")
    method, parameters = values.get("method", "latin_hypercube"), values.get("parameters", {})
    if method == "one_at_a_time":
        return one_at_a_time(parameters)
    if method not in _SAMPLES:
        known = ", ".join([*_SAMPLES, "one_at_a_time"])
        raise InputError(f"[sample] method = {method!r}: use {known}")
    if "count" not in values:
        raise InputError("[sample] count is missing")
    return _SAMPLES[method](values["count"], parameters, values.get("seed", 0))


def _records(values: dict, here: Path) -> Records:
    _check_names(values, "records")
    values = dict(values)
    if "levels" not in values:
        raise InputError("[records] levels are missing")
    records = [here / name for name in values.pop("files", [])]
    if "synthetic" in values:
        records += _synthetic(values.pop("synthetic"))
    return Records(records, **values)


def _synthetic(values: dict) -> list:
    from .fitted_motion import eurocode8, synthetic

    _check_names(values, "records.synthetic")
    values = dict(values)
    spectrum = values.pop("spectrum", None)
    if not isinstance(spectrum, Mapping):
        raise InputError("[records.synthetic] spectrum is missing: {eurocode8 = {peak = 2.0}} or "
                         "{periods = [...], values = [...]}")  # fmt: skip
    if "eurocode8" in spectrum:
        target = eurocode8(**spectrum["eurocode8"])
    elif {"periods", "values"} <= set(spectrum):
        target = (spectrum["periods"], spectrum["values"])
    else:
        raise InputError("[records.synthetic] spectrum: give eurocode8, or periods and values")
    first, count = values.pop("first_seed", 1), values.pop("count", 1)
    if "periods" in values:
        values["periods"] = tuple(values["periods"])
    return synthetic(range(first, first + count), target, **values)


def _check_names(values: Mapping, table: str) -> None:
    for name in values:
        if name not in _KNOWN[table]:
            where = f"[{table}] " if table else ""
            raise InputError(f"{where}there is no {name!r}{nearest(name, _KNOWN[table])}")
