# SPDX-License-Identifier: GPL-3.0-or-later
"""The plan of a study: cases with their inputs and keys, and the manifest."""

import json
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ..base import core as engine
from ..base.errors import InputError, SiteddaError, located
from ..base.files import make_folder, plain_text
from ..base.reading import read_bounded
from ..input.changes import changed_input, flat_changes, with_files
from ..input.input_text import ParsedGroup
from ..input.source import opened_input
from .axes import Axis, axes_of
from .quantities import DEFAULT, Quantity, quantities_of
from .store import (
    INPUT,
    MANIFEST,
    OUTPUT,
    PART,
    case_folder,
    checksum,
    file_checksum,
    function_name,
    keep_file,
    read_manifest,
)
from .store import write_whole as write
from .tasks import task_of

_LARGEST = 2**28  # largest size (bytes) of a file that an input names, as in the engine
_FORMAT = 1


@dataclass
class Plan:
    """Definition of a study: model, axes, results, folder and cases."""

    model: Any  # model to change, or function to call
    axes: list[Axis]
    quantities: list[Quantity]  # results of each case
    task: str | Callable = "run"  # ``'run'``, or a function of the path of the input of a case
    fixed: dict = field(default_factory=dict)  # changes of the input in all cases
    folder: Path | None = None
    keys: list[str] = field(default_factory=list)  # of the cases; the last dimension varies fastest

    @property
    def dims(self) -> dict[str, int]:
        """Return the length of each dimension."""
        return {name: size for axis in self.axes for name, size in axis.dims.items()}

    @property
    def count(self) -> int:
        """Return the number of cases."""
        return int(np.prod(list(self.dims.values()), dtype=int))

    def changes(self) -> Iterator[dict]:
        """Yield the changes of each case, in order."""
        for index in np.ndindex(*self.dims.values()):
            values, start = dict(self.fixed), 0
            for axis in self.axes:
                values |= axis.changes(index[start : start + len(axis.dims)])
                start += len(axis.dims)
            yield values

    def write(self) -> "Plan":
        """Write inputs and manifest into the folder of the study; keep existing cases."""
        plain_text("folder", str(self.folder))
        make_folder(self.folder)
        if callable(self.model):
            self.keys = self._write_calls()
        else:
            self.keys = self._write_inputs()
        write(self.folder / MANIFEST, json.dumps(self._make_manifest()), PART)
        return self

    def _write_inputs(self) -> list[str]:
        """Write the input of each case, and the files that it names; return the keys."""
        files = _StudyFiles(self.folder)
        with opened_input(self.model) as (file, text):
            base = files.text_with_copies(text, Path(file))
        base = changed_input(base, {"output.file": OUTPUT})
        head = (str(_FORMAT), engine.version(), build(), _task_name(self.task))
        keys = []
        for number, changes in enumerate(self.changes()):
            with located(f"case {number}"):
                text = changed_input(base, files.with_copies(changes))
            keys.append(checksum(*head, text))
            folder = case_folder(self.folder, keys[-1])
            if not (folder / INPUT).exists():
                make_folder(folder)
                write(folder / INPUT, text)
        return keys

    def _write_calls(self) -> list[str]:
        """Write the arguments of the function in each case; return the keys."""
        keys = []
        for changes in self.changes():
            text = json.dumps(changes, default=plain)
            keys.append(checksum(str(_FORMAT), build(), function_name(self.model), text))
            folder = make_folder(case_folder(self.folder, keys[-1]))
            write(folder / "values.json", text)
        return keys

    def _make_manifest(self) -> dict:
        """Return the description of the study that `collect` and other clients read."""
        coordinates = {
            name: {"dims": list(dims), "values": [plain(v) for v in values], "attrs": attrs}
            for axis in self.axes
            for name, (dims, values, attrs) in axis.coordinates.items()
        }
        return {
            "format": _FORMAT,
            "program": f"sitedda {engine.version()}",
            "build": build(),
            "model": model_name(self.model),
            "task": _task_name(self.task),
            "dims": self.dims,
            "coordinates": coordinates,
            "fixed": {name: plain(value) for name, value in self.fixed.items()},
            "quantities": [item.name for item in self.quantities],
            "cases": self.keys,
        }


def make_plan(model, parameters, results=None, folder=None, fixed=None, task="run") -> Plan:
    """Return the plan of a study; see `sitedda.study.study` for the arguments."""
    if isinstance(model, str | os.PathLike):
        model = Path(model)
    task = task_of(task)
    if callable(model) and task != "run":
        raise InputError("a model that is a function cannot have a task")
    default = DEFAULT if task == "run" and not callable(model) else ()
    quantities = quantities_of(default if results is None else results)
    if quantities and not default:
        raise InputError("a function computes the results: omit the argument `results`")
    axes = axes_of(parameters)
    path = None if folder is None else Path(folder).absolute()
    return Plan(model, axes, quantities, task, dict(flat_changes(fixed or {})), path)


def plan_of_folder(folder) -> Plan:
    """Return the plan of the study in a folder, without axes and functions."""
    folder = Path(folder).absolute()
    manifest = read_manifest(folder)
    names = [name for name in manifest["quantities"] if ":" not in name]
    return Plan(manifest["model"], [], quantities_of(names), folder=folder, keys=manifest["cases"])


def model_name(model) -> str:
    """Return the name of the model in a manifest."""
    if callable(model):
        return function_name(model).partition(" ")[0]
    return str(model) if isinstance(model, Path) else getattr(model, "title", "") or "model"


def _task_name(task) -> str:
    return task if isinstance(task, str) else function_name(task)


@cache
def build() -> str:
    """Return the checksum of the engine library, which distinguishes builds of a version."""
    from .. import _core

    return file_checksum(_core.__file__)


def plain(value):
    """Convert a value to types that JSON allows."""
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray | list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, str | int | float | bool | None):
        return value
    return str(value)


class _StudyFiles:
    """Copies of the files that the inputs of a study name, in the folder of the study."""

    def __init__(self, study: Path):
        self.study = study
        self.names: dict[Path | int, str] = {}

    def with_copies(self, changes: Mapping) -> dict:
        """Copy the files that changes name; return changes that name the copies."""
        return {
            path: self._copy_name(value, path) if _is_file_variable(path) and value else value
            for path, value in changes.items()
        }

    def text_with_copies(self, text: str, file: Path) -> str:
        """Copy the files that an input names; return its text with the names of the copies."""

        def name_of(group: ParsedGroup) -> str:
            name = group.values.get("file") if group.name != "output" else ""
            return self._copy_name(file.parent / name, f"&{group.name}") if name else ""

        return with_files(text, name_of, file)

    def _copy_name(self, file, source: str) -> str:
        """Copy a file, or write a `Record`, unless this has been done; return the new name."""
        key = id(file) if hasattr(file, "data") else Path(file)
        if key not in self.names:
            with located(source, SiteddaError):
                data = file.data if hasattr(file, "data") else read_bounded(key, _LARGEST)
            self.names[key] = keep_file(self.study, data, getattr(key, "suffix", ".txt"))
        return self.names[key]


def _is_file_variable(path: str) -> bool:
    return path.strip().lower().endswith(".file") and not path.lower().startswith("output")


@contextmanager
def folder_or_temporary(folder) -> Iterator[Path]:
    """Yield the folder of a study, or a temporary one."""
    import tempfile

    if folder is not None:
        yield Path(folder).absolute()
        return
    with tempfile.TemporaryDirectory(prefix="sitedda-study-") as name:
        yield Path(name)
