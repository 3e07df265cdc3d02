# SPDX-License-Identifier: GPL-3.0-or-later
"""Back-analysis: find parameter values at which results of a run have target values.

For one parameter, the method ITP (Oliveira and Takahashi 2020, ACM Transactions on Mathematical
Software 47, 5) shrinks a bracket. It never needs more runs than bisection, and usually half as
many. `solving_systems.py` solves for several parameters.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

import numpy as np

from ..base.arguments import FINITE, TOLERANCE
from ..base.errors import InputError, NoRootError
from ..input.changes import changed_input, merged
from ..input.source import InputOfRun
from .quantities import check_names, quantities_of
from .tasks import task_of
from .trials import Trials, bracket_of

INTERVALS = 8  # number of intervals into which a bracket without a change of sign is divided
_SHRINKING, _POWER = 0.2, 2.0  # κ₁ and κ₂ of ITP; its n₀ is 1
_JUMP = 0.5  # a result jumps if three bisections retain this fraction of its change (smooth: 1/8)
_FLAT = 1e-12  # changes below this fraction of a result count as 0


@dataclass(frozen=True)
class Root:
    """A root: the parameter value at which a result has the target value.

    Attributes
    ----------
    parameter, result : str
    target : float
        The target value.
    value : float
        Value of the parameter, in its unit.
    bar : float
        The root is assumed to be within `value` ± `bar`.  The bar is the half width of the bracket
        plus, if known, the error of the result due to time step and penalty, divided by `slope`.
    low, high : float
        Ends of the last bracket.
    reached : float
        Result at `value`.
    slope : float
        Derivative of the result with respect to the parameter, within the bracket.
    crossings : int
        Number of observed crossings of the target in the first bracket.
    jumps : bool
        Whether the result jumps past the target in the bracket.
    trials : tuple of (float, float)
        Parameter values and results of all runs, in order.
    doubt : str
        Errors that the bar does not include; empty if there are none.
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
        """Return a sentence with the root and warnings."""
        from ..base.numbers import with_bar

        text = f"{self.parameter} = {with_bar(self.value, self.bar)}"
        if self.jumps:
            text += f": at this value, {self.result} jumps past {self.target:g}"
        else:
            text += f", at which {self.result} = {self.target:g} ({len(self.trials)} runs)"
        if self.crossings > 1:
            text += f"; this is the lowest of {self.crossings} roots"
        return text + (f"; {self.doubt}" if self.doubt else "")

    def to_dict(self) -> dict:
        """Return the numbers of the root, and a text ``warning``."""
        values = {"root": self.value, "root_bar": self.bar, "root_low": self.low,
                 "root_high": self.high, "reached": self.reached, "slope": self.slope,
                 "crossings": self.crossings, "jumps": int(self.jumps),
                 "runs": len(self.trials)}  # fmt: skip
        note = f"the lowest of {self.crossings} roots" if self.crossings > 1 else ""
        return values | {"warning": "; ".join(filter(None, [note, self.doubt]))}


def solve_for(
    model,
    parameter: str | Sequence[str],
    result,
    target: float | Sequence[float],
    *,
    between: Sequence,
    tolerance: float = 1e-3,
    task: str | Callable = "run",
    accuracy: bool = True,
    jumps: bool = False,
    changes: Mapping | None = None,
    **variables,
):
    """Find the value of a parameter at which a result has a target value; or several at once.

    Parameters
    ----------
    model : path, Model or callable
        Model to run, or a function of the parameter that returns a number.
    parameter : str
        Variable to change, such as ``joint[plane].friction_angle``.  For a sequence of variables,
        `result`, `target` and `between` must be sequences of the same length, and a function must
        return this number of values.
    result : str or callable
        Result of the run (see `sitedda.study.measure`) or of the task, or a function of a
        `sitedda.Run`.
    target : float
        Target value of the result, in its unit.
    between : (float, float)
        Bracket of the root.  If the result is on the same side of the target at both ends, the
        bracket is divided into eight intervals, and the lowest root is returned.
    tolerance : float
        Width of the last bracket as a fraction of its larger end.
    task : 'run', 'safety' or callable
        See `sitedda.study.study`.
    accuracy : bool
        Whether the error bar includes the errors of the result due to time step and penalty, from
        further runs at the root (`sitedda.accuracy`); not available with a task or function.
    jumps : bool
        Whether a jump of the result past the target counts as a root (one parameter only).
    changes, **variables
        Changes of the input for all runs, see `Simulation`.

    Returns
    -------
    Root or Roots
        Roots if there are several parameters.

    Raises
    ------
    NoRootError
        If there is no root.  Its ``mode`` is 'outside' (no solution within the ranges), 'flat' (a
        parameter does not change the result), 'dependent' (the results do not change
        independently), 'jump' (the result jumps past the target), 'fails' (a run fails) or 'no
        number' (a result is not finite).
    InputError
        If an argument is invalid.
    """
    TOLERANCE.check("tolerance", tolerance)
    changes = merged(changes, variables)
    if not isinstance(parameter, str):
        from .solving_systems import solve_system

        return solve_system(model, parameter, result, target, between, tolerance, task, accuracy,
                            changes)  # fmt: skip
    low, high = bracket_of(between)
    target = FINITE.check("target", target)
    trials = Trials(model, [parameter], [result], task, changes)
    trials.target = target
    search = _Bracket(trials, tolerance * max(abs(low), abs(high), abs(high - low)))
    crossings = search.find(low, high)
    search.shrink_to_tolerance(tolerance)
    value, jump = search.locate_root(jumps)
    half_width = max(value - search.low, search.high - value)
    error, doubt = ([0.0], "") if jump else trials.errors_at((value,), accuracy)
    bar, history = half_width + abs(error[0] / search.slope), trials.tried_values()
    return Root(
        parameter, trials.name, target, value, bar, search.low, search.high, trials(value) + target,
        search.slope, crossings, jump, history, doubt,
    )  # fmt: skip


@dataclass(frozen=True)
class SolveFor:
    """The task [solve] of a study: `solve_for` with the input of each case."""

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
        """Return the settings; raise InputError if one is invalid."""
        bracket_of(self.between)
        TOLERANCE.check("tolerance", self.tolerance)
        FINITE.check("target", self.target)
        if not isinstance(self.parameter, str) or not isinstance(self.result, str):
            raise InputError("[solve] parameter and result must be names")
        quantities_of(self.result)
        task_of(self.task)
        return self

    def check(self, file) -> None:
        """Check before the search that parameter and result exist in an input."""
        trials = Trials(file, [self.parameter], [self.result], self.task, {})
        text = changed_input(trials.text, {self.parameter: self.between[0]}, file=file)
        if self.task == "run":
            check_names(InputOfRun(trials.file, text), trials.requested)

    def __call__(self, file) -> dict:
        """Solve for the parameter of an input; return the numbers of `Root.to_dict`."""
        return solve_for(Path(file), **vars(self)).to_dict()


class _Bracket:
    """A bracket of parameter values in which the result crosses the target."""

    def __init__(self, trials: Trials, scale: float):
        self.trials = trials
        self.low = self.high = self.below = self.above = self.slope = math.nan
        self.scale = scale

    def find(self, low: float, high: float) -> int:
        """Set the bracket to the lowest interval with a change of sign; count such intervals."""
        points = [low, high]
        if self.trials(low) * self.trials(high) > 0:
            points = np.linspace(low, high, INTERVALS + 1).tolist()
        differences = [self.trials(point) for point in points]
        signs = np.sign(differences)
        crossings = np.flatnonzero(signs[:-1] * signs[1:] <= 0)
        if len(crossings) == 0:
            raise self._no_root_error(low, high)
        index = int(crossings[0])
        self.low, self.high = points[index], points[index + 1]
        self.below, self.above = differences[index], differences[index + 1]
        return len(crossings) - int(np.sum(signs[1:-1] == 0))

    def _no_root_error(self, low: float, high: float) -> NoRootError:
        """Return the error that the result does not cross the target in a range."""
        trials = self.trials
        results = [result for _, result in trials.tried_values()]
        lowest, highest = min(results), max(results)
        interval = f"for {trials.parameter} from {low:g} to {high:g} ({len(results)} runs)"
        if highest - lowest <= _FLAT * max(abs(lowest), abs(highest)):
            text = f"{trials.name} does not depend on {trials.parameter}:"
            return trials.failure("flat", f"{text} it is {lowest:g} {interval}")
        side = "above" if trials.target > highest else "below"
        text = (f"{trials.name} is between {lowest:g} and {highest:g} {interval}; the target "
                 f"{trials.target:g} is {side} all these values")  # fmt: skip
        return trials.failure("outside", text)

    def take_value(self, value: float) -> None:
        """Replace an end of the bracket by a value, so that the sign still changes within."""
        difference = self.trials(value)
        if difference == 0.0 or (difference > 0) == (self.above > 0 or self.below < 0):
            self.high, self.above = value, difference
        else:
            self.low, self.below = value, difference

    def shrink_to_tolerance(self, tolerance: float) -> None:
        """Shrink the bracket by the method ITP to a relative tolerance."""
        half_width = 0.5 * tolerance * (max(abs(self.low), abs(self.high)) or self.scale)
        initial = self.high - self.low
        steps = max(0, math.ceil(math.log2(max(initial / (2 * half_width), 1.0)))) + 1
        for step in range(steps + 1):
            width = self.high - self.low
            if width <= 2 * half_width or 0.0 in (self.below, self.above):
                return
            centre, secant = 0.5 * (self.low + self.high), self.secant_value()
            sign = math.copysign(1.0, centre - secant)
            correction = _SHRINKING / initial * width**_POWER
            trial = secant + sign * correction if correction <= abs(centre - secant) else centre
            radius = max(0.0, half_width * 2.0 ** (steps - step) - 0.5 * width)
            self.take_value(trial if abs(trial - centre) <= radius else centre - sign * radius)

    def secant_value(self) -> float:
        """Return the value at which a straight line between the ends reaches the target."""
        fraction = self.below / (self.below - self.above)
        return self.low + fraction * (self.high - self.low)

    def locate_root(self, jumps: bool) -> tuple[float, bool]:
        """Return the root, and whether it is a jump; without `jumps`, a jump is an error."""
        state = self.low, self.high, self.below, self.above
        jump_before = abs(self.above - self.below)
        self.slope = (self.above - self.below) / (self.high - self.low)
        if 0.0 in (self.below, self.above):
            self.low = self.high = self.low if self.below == 0.0 else self.high
            return self.low, False
        value = self.secant_value()
        if abs(self.trials(value)) <= _JUMP * jump_before / 4:
            return value, False
        for _ in range(3):
            self.take_value(0.5 * (self.low + self.high))
        jump = abs(self.above - self.below) > _JUMP * jump_before
        low, high, lower, upper = self.low, self.high, self.below, self.above
        trials = self.trials
        if jump and not jumps:
            text = (f"{trials.name} jumps from {lower + trials.target:g} to "
                     f"{upper + trials.target:g} between {trials.parameter} = {low:.8g} and "
                     f"{high:.8g}, past the target {trials.target:g}; jumps = True accepts the "
                     "jump as a root")  # fmt: skip
            raise trials.failure("jump", text, low, high)
        value = 0.5 * (low + high) if jump else self.secant_value()
        trials(value)
        if not jump:
            self.low, self.high, self.below, self.above = state
        return value, jump
