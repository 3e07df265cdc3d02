# SPDX-License-Identifier: GPL-3.0-or-later
"""The value of a parameter at which a result of a run has a target value: back-analysis.

A bracket is shrunk by the method ITP (Oliveira and Takahashi 2020, ACM Transactions on Mathematical
Software 47, 5), which never needs more runs than bisection and usually half of them.
"""

import math
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

import numpy as np

from ..base.arguments import FINITE, TOLERANCE
from ..base.errors import InputError, InterruptedRun, NoRootError, SiteddaError
from ..input.changes import changed_input, with_files
from ..input.source import InputOfRun, opened_input
from .axes import short_names
from .quantities import Quantity, check_names, measure, quantities_of, returned
from .tasks import task_of

INTERVALS = 8  # subdivisions of a bracket without a change of sign
_SHRINKING, _POWER = 0.2, 2.0  # κ₁ and κ₂ of ITP; its n₀ is 1
_JUMP = 0.5  # fraction of a difference left after three halvings (an eighth if continuous)
_FLAT = 1e-12  # fraction of a result: a smaller change counts as none


@dataclass(frozen=True)
class Root:
    """The root: where a result has the target value.

    Attributes
    ----------
    parameter, result : str
    target : float
        The target value.
    value : float
        Of the parameter, in its unit.
    bar : float
        The root is taken to lie within `value` ± `bar`: half of the bracket and, where the figure
        has one, the error of the result by time step and penalty over `slope`.
    low, high : float
        The bracket.
    reached : float
        The result at `value`.
    slope : float
        Change of the result with the parameter, within the bracket.
    crossings : int
        How often the result was seen to cross the target in the whole bracket.
    jumps : bool
        The result jumps past the target in the bracket.
    trials : tuple of (float, float)
        Values that were tried, and the results, in order.
    doubt : str
        Errors that the bar omits; empty if there are none.
    """

    parameter: str
    result: str
    target: float
    value: float
    bar: float
    low: float
    high: float
    reached: float
    slope: float
    crossings: int
    jumps: bool
    trials: tuple[tuple[float, float], ...] = field(repr=False)
    doubt: str = ""

    def __str__(self) -> str:
        """The root in a sentence, with doubts."""
        from ..base.numbers import with_bar

        words = f"{self.parameter} = {with_bar(self.value, self.bar)}"
        if self.jumps:
            words += f": {self.result} jumps past {self.target:g} there"
        else:
            words += f" for {self.result} = {self.target:g} ({len(self.trials)} runs)"
        if self.crossings > 1:
            words += f"; the lowest of {self.crossings} that were seen"
        return words + (f"; {self.doubt}" if self.doubt else "")

    def to_dict(self) -> dict:
        """Numbers, and a ``warning`` in words."""
        found = {"root": self.value, "root_bar": self.bar, "root_low": self.low,
                 "root_high": self.high, "reached": self.reached, "slope": self.slope,
                 "crossings": self.crossings, "jumps": int(self.jumps),
                 "runs": len(self.trials)}  # fmt: skip
        more = f"the lowest of {self.crossings} roots" if self.crossings > 1 else ""
        return found | {"warning": "; ".join(filter(None, [more, self.doubt]))}


def solve_for(
    model,
    parameter: str,
    result: str | Callable,
    target: float,
    *,
    between: Sequence[float],
    tolerance: float = 1e-3,
    task: str | Callable = "run",
    accuracy: bool = True,
    jumps: bool = False,
    changes: Mapping | None = None,
    **more,
) -> Root:
    """Find the value of a parameter at which a result has a target value.

    Parameters
    ----------
    model : path, Model or callable
        Model to run; or a function of the parameter that returns a number.
    parameter : str
        Variable to change, such as ``joint[plane].friction_angle``.
    result : str or callable
        A number of the run, see `sitedda.study.measure`, or a function of a `sitedda.Run`; of a
        task one of its numbers.
    target : float
        Its target value, in its unit.
    between : (float, float)
        Values of the parameter that the root lies between.  Where the result is on the same side of
        the target at both, eight parts are looked at, and the lowest root is taken.
    tolerance : float
        Width of the last bracket over its larger end.
    task : 'run', 'safety' or callable
        See `sitedda.study.study`.
    accuracy : bool
        The bar counts the errors of the result by time step and penalty, from runs with smaller
        steps at the root (`sitedda.accuracy`); of a task or a function it does not.
    jumps : bool
        If the result jumps past the target, the jump is the root.
    changes, **more
        Variables to change in the input first, see `Simulation`.

    Raises
    ------
    NoRootError
        If there is none; its ``mode`` says why: 'outside' (all results lie on one side of the
        target), 'flat' (the parameter does not change the result), 'jump' (the result jumps past
        it), 'fails' (a run within the bracket cannot be carried out), 'no number'.
    InputError
        If an argument cannot be used.
    """
    low, high = _bracket(between)
    TOLERANCE.check("tolerance", tolerance)
    target = FINITE.check("target", target)
    trials = _Trials(model, parameter, result, target, task, dict(changes or {}) | more)
    found = _Bracket(trials, tolerance * max(abs(low), abs(high), abs(high - low)))
    crossings = found.find(low, high)
    found.shrink(tolerance)
    value, jump = found.settle(jumps)
    half = max(value - found.low, found.high - value)
    doubt = "" if task == "run" and not callable(model) else "the bar has only the bracket"
    error = 0.0
    if jump:
        doubt = ""
    elif not doubt and accuracy:
        error, doubt = trials.error_at(value)
    elif not doubt:
        doubt = "the bar has only the bracket: accuracy = true adds time step and penalty"
    bar, tried = half + abs(error / found.slope), tuple(trials.done.items())
    return Root(
        parameter, trials.name, target, value, bar, found.low, found.high, trials.done[value],
        found.slope, crossings, jump, tried, doubt,
    )  # fmt: skip


def _bracket(between) -> tuple[float, float]:
    """Two different numbers in order."""
    try:
        low, high = sorted(FINITE.check("between", value) for value in between)
    except (TypeError, ValueError) as trouble:
        if isinstance(trouble, InputError):
            raise
        raise InputError(f"between = {between!r} must be two numbers") from None
    if low == high:
        raise InputError(f"between = {between!r}: the two numbers must differ")
    return low, high


@dataclass(frozen=True)
class SolveFor:
    """`solve_for` as the task of a study: of the input of each case.

    Attributes
    ----------
    parameter, result, target, between, tolerance, task, accuracy, jumps
        Those of `solve_for`.
    """

    parameter: str
    result: str
    target: float
    between: tuple[float, float]
    tolerance: float = 1e-3
    task: str | Callable = "run"
    accuracy: bool = False
    jumps: bool = False
    results: ClassVar = ("root", "root_bar", "root_low", "root_high", "reached", "slope",
                         "crossings", "jumps", "runs")  # fmt: skip

    def checked(self) -> "SolveFor":
        """Itself, if a search could begin with it."""
        _bracket(self.between)
        TOLERANCE.check("tolerance", self.tolerance)
        FINITE.check("target", self.target)
        if not isinstance(self.parameter, str) or not isinstance(self.result, str):
            raise InputError("[solve] parameter and result are names")
        quantities_of(self.result)
        task_of(self.task)
        return self

    def check(self, file) -> None:
        """Check that an input has parameter and result, before the search is begun."""
        trials = _Trials(file, self.parameter, self.result, self.target, self.task, {})
        text = changed_input(trials.text, {self.parameter: self.between[0]}, file=file)
        if self.task == "run":
            check_names(InputOfRun(trials.file, text), [trials.wanted])

    def __call__(self, file) -> dict:
        """Numbers of the root of an input, see `Root.to_dict`."""
        return solve_for(Path(file), **vars(self)).to_dict()


class _Trials:
    """Results of one model, by the value of its parameter."""

    def __init__(self, model, parameter: str, result, target: float, task, changes: Mapping):
        self.model, self.parameter, self.target = model, parameter, target
        self.task = task_of(task)
        self.wanted = self._quantity(result)
        self.name = self.wanted.label
        self.done: dict[float, float] = {}
        if not callable(model):
            with opened_input(model) as (file, text):
                text = with_files(text, lambda group: _whole_name(group, file), file)
                self.text = changed_input(text, changes, file=file) if changes else text
                self.file = Path(file)

    def _quantity(self, result) -> Quantity:
        wanted = quantities_of(result)
        if len(wanted) != 1:
            raise InputError(f"result = {result!r} must be one quantity")
        return wanted[0]

    def __call__(self, value: float) -> float:
        """The result less the target."""
        value = float(value)
        if value not in self.done:
            self.done[value] = self._checked(value)
        return self.done[value] - self.target

    def _checked(self, value: float) -> float:
        where = f"{self.parameter} = {value:.6g}"
        try:
            found = self._measured(value)
        except (InterruptedRun, InputError):
            raise
        except SiteddaError as error:
            raise self.failure("fails", f"the run with {where} fails: {error}") from error
        if not math.isfinite(found):
            raise self.failure("no number", f"{self.name} is not a number with {where}")
        return found

    def failure(self, mode: str, words: str, low=math.nan, high=math.nan) -> NoRootError:
        """The error of a search that has not found a root."""
        return NoRootError(f"no root: {words}", mode, (low, high), tuple(self.done.items()))

    def _measured(self, value: float) -> float:
        if callable(self.model):
            name = next(iter(short_names([self.parameter]).values()))
            return self._number(returned(self.name, self.model(**{name: value})))
        text = changed_input(self.text, {self.parameter: value}, file=self.file)
        with tempfile.TemporaryDirectory(prefix="sitedda-solve-") as folder:
            if callable(self.task):
                file = Path(folder) / "model.nml"
                file.write_text(text, "utf-8", "surrogateescape")
                return self._number(returned(self.name, self.task(file)))
            output = Path(folder) / "out.nc"
            _run(InputOfRun(self.file, text), output)
            numbers, _ = measure(output, [self.wanted], [])
        return self._number(numbers)

    def _number(self, values: Mapping) -> float:
        numbers = {n: v for n, v in values.items() if isinstance(v, float | int)}
        if self.name in numbers:
            return float(numbers[self.name])
        if len(numbers) == 1 and len(values) == 1:
            return float(next(iter(numbers.values())))
        known = f"; there are {', '.join(numbers)}" if numbers else ", as with .last or .largest"
        raise InputError(f"result {self.name!r} is not one number{known}")

    def error_at(self, value: float) -> tuple[float, str]:
        """Error of the result at a value by time step and penalty, and omitted errors."""
        from .error_bars import accuracy

        text = changed_input(self.text, {self.parameter: value}, file=self.file)
        wanted = {self.name: self.wanted.function or self.wanted.name}
        figures = accuracy(InputOfRun(self.file, text), wanted, workers=1).figures
        if self.name not in figures:
            return 0.0, "the bar has only the bracket: the result has none"
        figure = figures[self.name]
        if not math.isfinite(figure.bar):
            return 0.0, f"the bar has only the bracket: {self.name} {figure.doubt}"
        return abs(figure.run - figure.finest) + figure.bar, figure.doubt


def _whole_name(group, file: Path) -> str:
    """The name of a file of a group, from anywhere."""
    name = group.values.get("file", "") if group.name != "output" else ""
    return str((Path(file).parent / name).resolve()) if name else ""


def _run(source, output: Path) -> None:
    """Run a case to its end; a signal ends the search."""
    from ..base.stop import SIGNALS, Stop
    from ..engine.simulation import Simulation, run_to_end

    with Stop(SIGNALS, program=True) as stop, Simulation(source, output) as simulation:
        if not run_to_end(simulation, None, stop):
            raise InterruptedRun("interrupted")
        simulation.finish()


class _Bracket:
    """Values of the parameter between which the result crosses the target."""

    def __init__(self, trials: _Trials, scale: float):
        self.trials = trials
        self.low = self.high = self.below = self.above = self.slope = math.nan
        self.scale = scale

    def find(self, low: float, high: float) -> int:
        """Take the ends, or the lowest of their parts with a change of sign; how many there are."""
        places = [low, high]
        if self._same_side(places):
            places = np.linspace(low, high, INTERVALS + 1).tolist()
        differences = [self.trials(place) for place in places]
        signs = np.sign(differences)
        crossed = np.flatnonzero(signs[:-1] * signs[1:] <= 0)
        if len(crossed) == 0:
            raise self._no_root(low, high)
        first = int(crossed[0])
        self.low, self.high = places[first], places[first + 1]
        self.below, self.above = differences[first], differences[first + 1]
        return len(crossed) - int(np.sum(signs[1:-1] == 0))

    def _same_side(self, places) -> bool:
        one, other = (self.trials(place) for place in places)
        return one * other > 0

    def _no_root(self, low: float, high: float) -> NoRootError:
        trials = self.trials
        results = list(trials.done.values())
        least, most = min(results), max(results)
        where = f"for {trials.parameter} from {low:g} to {high:g} ({len(results)} runs)"
        if most - least <= _FLAT * max(abs(least), abs(most)):
            words = f"{trials.name} is {least:g} whatever {trials.parameter} is, {where}"
            return trials.failure("flat", words)
        side = "above" if trials.target > most else "below"
        words = (f"{trials.name} lies between {least:g} and {most:g} {where}; the target "
                 f"{trials.target:g} is {side} all")  # fmt: skip
        return trials.failure("outside", words)

    def take(self, value: float) -> None:
        """Shrink to the side of a value on which the sign changes."""
        difference = self.trials(value)
        if difference == 0.0 or (difference > 0) == (self.above > 0 or self.below < 0):
            self.high, self.above = value, difference
        else:
            self.low, self.below = value, difference

    def shrink(self, tolerance: float) -> None:
        """Narrow it by ITP."""
        half = 0.5 * tolerance * (max(abs(self.low), abs(self.high)) or self.scale)
        first = self.high - self.low
        most = max(0, math.ceil(math.log2(max(first / (2 * half), 1.0)))) + 1
        for step in range(most + 1):
            width = self.high - self.low
            if width <= 2 * half or 0.0 in (self.below, self.above):
                return
            middle, secant = 0.5 * (self.low + self.high), self.secant()
            toward = math.copysign(1.0, middle - secant)
            shift = _SHRINKING / first * width**_POWER
            near = secant + toward * shift if shift <= abs(middle - secant) else middle
            radius = max(0.0, half * 2.0 ** (most - step) - 0.5 * width)
            self.take(near if abs(near - middle) <= radius else middle - toward * radius)

    def secant(self) -> float:
        """Position at which a line between the ends has the target value."""
        share = self.below / (self.below - self.above)
        return self.low + share * (self.high - self.low)

    def settle(self, jumps: bool) -> tuple[float, bool]:
        """The root, and whether the result jumps there; the bracket stays on both sides."""
        kept = self.low, self.high, self.below, self.above
        before = abs(self.above - self.below)
        self.slope = (self.above - self.below) / (self.high - self.low)
        if 0.0 in (self.below, self.above):
            self.low = self.high = self.low if self.below == 0.0 else self.high
            return self.low, False
        value = self.secant()
        if abs(self.trials(value)) <= _JUMP * before / 4:
            return value, False
        for _ in range(3):
            self.take(0.5 * (self.low + self.high))
        jump = abs(self.above - self.below) > _JUMP * before
        low, high, one, other = self.low, self.high, self.below, self.above
        trials = self.trials
        if jump and not jumps:
            words = (f"{trials.name} jumps from {one + trials.target:g} to "
                     f"{other + trials.target:g} between {trials.parameter} = {low:.8g} and "
                     f"{high:.8g}, past the target {trials.target:g}; jumps = True takes the "
                     "place of the jump")  # fmt: skip
            raise trials.failure("jump", words, low, high)
        value = 0.5 * (low + high) if jump else self.secant()
        trials(value)
        if not jump:
            self.low, self.high, self.below, self.above = kept
        return value, jump
