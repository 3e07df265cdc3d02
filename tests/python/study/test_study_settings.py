# SPDX-License-Identifier: GPL-3.0-or-later
"""Values of a study file have the right type and are finite, or are refused in a sentence."""

import copy
import json
import math
import tomllib
from functools import reduce
from pathlib import Path

import pytest
from model_text import changed, tower

import sitedda
from sitedda.errors import InputError
from sitedda.study.settings import read_settings
from sitedda.study.tasks import TASKS, task_of

STUDIES = sorted((Path(__file__).parents[3] / "inputs" / "studies").glob("*.toml"))
BAD = [math.inf, math.nan, -1, 0, 10**30, "a", True, [], {}, [1.0], ["a", "b"]]
PUSHED = {"model": "m.nml", "pushover": {"point": "top", "sense": 1, "displacement": 0.1,
                                         "steps": 5, "limits": False}}  # fmt: skip
SHORT = {"count": 1, "duration": 2.0, "periods": [0.05, 1.0]}  # a quick synthetic record


def as_toml(value) -> str:
    """Return a value as TOML on one line."""
    if isinstance(value, dict):
        rows = (f"{json.dumps(name)} = {as_toml(item)}" for name, item in value.items())
        return "{" + ", ".join(rows) + "}"
    if isinstance(value, list):
        return f"[{', '.join(map(as_toml, value))}]"
    return json.dumps(value) if isinstance(value, str | bool) else repr(value)


def places(value, path=()):
    """Yield the keys of all values in a table, also of nested ones."""
    items = value.items() if isinstance(value, dict) else enumerate(value)
    for key, item in items:
        yield (*path, key)
        if isinstance(item, dict | list):
            yield from places(item, (*path, key))


def with_value(table: dict, path, new) -> str:
    """Return the text of a table in which one value is replaced."""
    table = copy.deepcopy(table)
    reduce(lambda inner, key: inner[key], path[:-1], table)[path[-1]] = new
    return "\n".join(f"{name} = {as_toml(item)}" for name, item in table.items())


@pytest.mark.parametrize("study", [*STUDIES, "pushed"], ids=lambda one: getattr(one, "stem", one))
def test_any_value_is_read_or_refused_in_one_sentence(study, tmp_path):
    table = PUSHED if study == "pushed" else tomllib.loads(study.read_text())
    if "records" in table:
        table["records"]["synthetic"] |= SHORT
        table["records"]["levels"] = [1.0, 2.0]
    file = tmp_path / "s.toml"
    for path in places(table):
        for invalid_value in BAD:
            file.write_text(with_value(table, path, invalid_value))
            try:
                read_settings(file)
            except InputError as error:
                message = str(error).removeprefix(f"{file}: ")
                raw = ("object", "ufunc", "unhashable", "operand", "index out", "NoneType")
                assert message != str(error) and "\n" not in message and len(message) < 300, message
                assert not any(phrase in message for phrase in raw), (path, invalid_value, message)
            else:
                finite = not isinstance(invalid_value, float) or math.isfinite(invalid_value)
                assert finite or path == ("time_limit",), (path, invalid_value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[parameters]\na = {from = 0, to = 1, count = 3, spacing = 'log'}", "of the same sign"),
        ("[parameters]\na = {from = 1, to = 2, count = 2.5}", "count = 2.5 must be a whole"),
        ("[parameters]\na = [1.0, inf]", "parameters.a = inf is not a finite"),
        ("[sample]\ncount = 'a'", r"\[sample\] count = 'a' is not a number"),
        ("[records]\nlevels = 2.0", r"levels = 2.0 is not a list of numbers"),
        ("[records]\nlevels = [1.0]\n[records.synthetic]\nduration = inf", "duration = inf"),
        ("[pushover]\npoint = 'top'\nlimits = 1", "limits = 1 is not true or false"),
        ("results = 3\n[parameters]\na = [1]", "results = 3 is not a name, a list or"),
    ],
)
def test_invalid_values_are_named(text, message, tmp_path):
    file = tmp_path / "s.toml"
    file.write_text(f"model = 'm.nml'\n{text}\n")
    with pytest.raises(InputError, match=message):
        read_settings(file)


@pytest.mark.parametrize(
    ("task", "expected", "unknown"),
    [
        ("safety", "stands_at", "stand_at"),
        ("accuracy", "largest_tilt_rad_bar", "largest_tilt_bar"),
        ("accuracy", "pga_m_s2[top]_bar", "pga[top]_bar"),
    ],
)
def test_figures_of_tasks_use_names_of_their_results(
    task, expected, unknown, tmp_path, write_input
):
    write_input(tower())
    file = tmp_path / "s.toml"
    text = f"model = 'model.nml'\ntask = '{task}'\n[parameters]\n'motion.scale' = [1.0, 2.0]\n"
    figure = "[[figures]]\nkind = 'fragility'\nthreshold = 1\nintensity = 'scale'\nquantity = "
    file.write_text(f"{text}{figure}'{expected}'\n")
    assert read_settings(file).figures
    file.write_text(f"{text}{figure}'{unknown}'\n")
    with pytest.raises(InputError, match="not a result of the study"):
        read_settings(file)
    file.write_text(f"{text}{figure}'{expected}'\n".replace("'scale'", "'scales'"))
    with pytest.raises(InputError, match="no dimension 'scales'"):
        read_settings(file)


def test_results_of_tasks_have_known_names(write_input, tmp_path):
    file = write_input(changed(tower(steps=5), "control", gravity=[0.0, -9.81]))
    for task in TASKS:
        table = sitedda.study(file, {"material.density": [2500.0]}, task=task,
                              folder=tmp_path / task, executor=None)  # fmt: skip
        names = {name.partition("[")[0] for name, column in table.items() if column.dtype == float}
        assert len(names) > 2 and names - {"seconds"} <= set(task_of(task).results)
