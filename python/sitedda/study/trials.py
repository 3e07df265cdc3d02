# SPDX-License-Identifier: GPL-3.0-or-later
"""Evaluate results of a model at values of its parameters, for searches of roots."""

import math
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from ..base.arguments import FINITE
from ..base.errors import InputError, InterruptedRun, NoRootError, SiteddaError
from ..input.changes import changed_input, with_files
from ..input.source import InputOfRun, opened_input
from .axes import short_names
from .quantities import Quantity, measure, quantities_of, split_value
from .tasks import task_of


def bracket_of(bracket) -> tuple[float, float]:
    """Return two different numbers in increasing order."""
    try:
        low, high = sorted(FINITE.check("between", value) for value in bracket)
    except (TypeError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"between = {bracket!r} must be two numbers") from None
    if low == high:
        raise InputError(f"between = {bracket!r}: the two numbers must differ")
    return low, high


class Trials:
    """Results of a model as functions of its parameters; evaluated results are stored."""

    target = 0.0  # target value of the first result

    def __init__(self, model, parameters: Sequence, results: Sequence, task, changes: Mapping):
        self.model, self.parameters, self.parameter = model, list(parameters), parameters[0]
        self.task = task_of(task)
        self.requested: list[Quantity] = []
        for result in results:
            self.requested += (quantities := quantities_of(result))
            if len(quantities) != 1:
                raise InputError(f"result = {result!r} must be one quantity")
        self.names = [item.label for item in self.requested]
        self.name = self.names[0]
        self.done: dict[tuple, tuple] = {}
        if not callable(model):
            with opened_input(model) as (file, text):
                text = with_files(text, lambda group: _absolute_name(group, file), file)
                self.text = changed_input(text, changes, file=file) if changes else text
                self.file = Path(file)

    def __call__(self, value: float) -> float:
        """Return the first result minus its target at a value of the first parameter."""
        return self.results((float(value),))[0] - self.target

    def results(self, values: tuple) -> tuple:
        """Return all results at values of the parameters."""
        if values not in self.done:
            self.done[values] = self._finite_results(values)
        return self.done[values]

    def tried_values(self) -> tuple:
        """Return value of the first parameter and first result of each run, in order."""
        return tuple((value[0], results[0]) for value, results in self.done.items())

    def _finite_results(self, values: tuple) -> tuple:
        """Run the model and return its results; raise NoRootError if one is not finite."""
        pairs = zip(self.parameters, values, strict=True)
        point = ", ".join(f"{name} = {value:.6g}" for name, value in pairs)
        try:
            numbers = self._run_model(values)
        except (InterruptedRun, InputError):
            raise
        except SiteddaError as error:
            raise self.failure("fails", f"the run with {point} fails: {error}") from error
        for name, number in zip(self.names, numbers, strict=True):
            if not math.isfinite(number):
                raise self.failure("no number", f"{name} is not a number at {point}")
        return numbers

    def failure(self, mode: str, reason: str, low=math.nan, high=math.nan) -> NoRootError:
        """Return the error of a search that has found no root."""
        history = self.tried_values() if len(self.parameters) == 1 else tuple(self.done.items())
        return NoRootError(f"no root: {reason}", mode, (low, high), history)

    def _run_model(self, values: tuple) -> tuple:
        """Run the model, task or function at values of the parameters; return the results."""
        from ..engine.simulation import completed_run

        if callable(self.model):
            names = short_names(self.parameters).values()
            value = self.model(**dict(zip(names, values, strict=True)))
            if len(self.names) > 1 and not isinstance(value, Mapping):
                value = self._name_numbers(value)
            return self._pick_numbers(split_value(self.name, value))
        changes = dict(zip(self.parameters, values, strict=True))
        text = changed_input(self.text, changes, file=self.file)
        with tempfile.TemporaryDirectory(prefix="sitedda-solve-") as folder:
            if callable(self.task):
                file = Path(folder) / "model.nml"
                file.write_text(text, "utf-8", "surrogateescape")
                return self._pick_numbers(split_value(self.name, self.task(file)))
            output = Path(folder) / "out.nc"
            with completed_run(InputOfRun(self.file, text), output, waits=True):
                pass
            numbers, _ = measure(output, self.requested, [])
        return self._pick_numbers(numbers)

    def _name_numbers(self, value) -> dict:
        """Return the sequence of numbers of a function as a dict with the names of the results."""
        try:
            return dict(zip(self.names, value, strict=True))
        except (TypeError, ValueError):
            raise InputError(f"the function must return {len(self.names)} numbers "
                             f"({', '.join(self.names)}), not {value!r}") from None  # fmt: skip

    def _pick_numbers(self, values: Mapping) -> tuple:
        return tuple(self._pick_number(name, values) for name in self.names)

    def _pick_number(self, name: str, values: Mapping) -> float:
        """Return the result of a name; a single number may have any name."""
        numbers = {n: v for n, v in values.items() if isinstance(v, float | int)}
        if name in numbers:
            return float(numbers[name])
        if len(numbers) == len(values) == len(self.names) == 1:
            return float(next(iter(numbers.values())))
        hint = f"; there are {', '.join(numbers)}" if numbers else "; append .last or .largest"
        raise InputError(f"result {name!r} is not a number{hint}")

    def errors_at(self, values: tuple, with_accuracy: bool) -> tuple[list[float], str]:
        """Return the errors of the results due to time step and penalty, and a warning."""
        from .error_bars import accuracy

        errors = [0.0] * len(self.names)
        basis = "the error bar includes only the width of the last bracket"
        if self.task != "run" or callable(self.model):
            return errors, basis
        if not with_accuracy:
            return errors, f"{basis}; accuracy = true includes errors due to time step and penalty"
        changes = dict(zip(self.parameters, values, strict=True))
        text = changed_input(self.text, changes, file=self.file)
        functions = {quantity.label: quantity.function or quantity.name
                     for quantity in self.requested}  # fmt: skip
        figures, warnings = accuracy(InputOfRun(self.file, text), functions, workers=1).figures, []
        for i, name in enumerate(self.names):
            if name not in figures:
                warnings.append(f"{basis}: the result has no error bar")
            elif not math.isfinite(figures[name].bar):
                warnings.append(f"{basis}: {name} {figures[name].doubt}")
            else:
                errors[i] = abs(figures[name].run - figures[name].finest) + figures[name].bar
                warnings.append(figures[name].doubt)
        return errors, "; ".join(filter(None, warnings))


def _absolute_name(group, file: Path) -> str:
    """Return the absolute path of the file that a group of an input names; blank if none."""
    name = group.values.get("file", "") if group.name != "output" else ""
    return str((Path(file).parent / name).resolve()) if name else ""
