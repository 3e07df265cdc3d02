# SPDX-License-Identifier: GPL-3.0-or-later
"""What a validation case is: measured figures beside expected ones, tables and a picture."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from matplotlib.figure import Figure

from ..base.errors import SiteddaError
from ..report.style import add_legends

CASES: dict[str, Case] = {}


@dataclass(frozen=True)
class Row:
    """One figure that was measured.

    Attributes
    ----------
    quantity : str
        What was measured.
    expected : float or None
        What theory says; None where only a bound is known.
    got : float
        What the engine gave.
    error : float
        Relative error, absolute error or the measured figure itself, see `kind`.
    allowed : float or None
        Largest error; None for a row that is shown for comparison only.
    kind : str
        ``"relative"`` (a ratio), ``"absolute"`` (in `unit`) or ``"at most"`` (in `unit`).
    unit : str
        Unit of `expected` and `got`.
    """

    quantity: str
    expected: float | None
    got: float
    error: float
    allowed: float | None
    kind: str
    unit: str = ""

    @property
    def passed(self) -> bool:
        """The error is within what is allowed; a row without a bound always passes."""
        return self.allowed is None or self.error <= self.allowed


def relative(quantity, expected, got, allowed, unit="") -> Row:
    """A row judged by its relative error."""
    return Row(
        quantity, expected, got, abs(got - expected) / abs(expected), allowed, "relative", unit
    )


def absolute(quantity, expected, got, allowed, unit="") -> Row:
    """A row judged by its absolute error."""
    return Row(quantity, expected, got, abs(got - expected), allowed, "absolute", unit)


def at_most(quantity, got, allowed, unit="") -> Row:
    """A row judged by a bound on the figure itself."""
    return Row(quantity, None, got, got, allowed, "at most", unit)


def true(quantity, expected: bool, got: bool) -> Row:
    """A row that is right or wrong: it stands, it slides, the bits are the same."""
    return Row(quantity, float(expected), float(got), float(expected != got), 0.0, "yes or no")


@dataclass(frozen=True)
class Table:
    """Figures without a verdict, such as a convergence study."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[object]]


@dataclass
class Outcome:
    """What a case function returns."""

    rows: list[Row]
    figure: Figure
    tables: list[Table] = field(default_factory=list)


@dataclass(frozen=True)
class Case:
    """A case of the field with a known answer.

    Attributes
    ----------
    name, title : str
    formula : str
        What is expected and how it follows, Markdown.
    reference : str
        Where it is from.
    function : callable
        Takes ``short`` (bool) and returns an `Outcome`.
    """

    name: str
    title: str
    formula: str
    reference: str
    function: Callable[[bool], Outcome]

    def run(self, short: bool = False) -> Result:
        """Run the case; an error of the engine becomes a failed result.

        Parameters
        ----------
        short : bool
            The form that tests use: fewer variants, smaller models, the same physics.
        """
        begin = time.perf_counter()
        try:
            outcome, trouble = self.function(short), ""
            add_legends(outcome.figure)
        except SiteddaError as error:
            outcome, trouble = Outcome([], Figure()), str(error)
        return Result(self, outcome, time.perf_counter() - begin, trouble)


@dataclass(frozen=True)
class Result:
    """A case that was run."""

    case: Case
    outcome: Outcome
    seconds: float
    trouble: str = ""

    @property
    def passed(self) -> bool:
        """All rows passed and the engine raised no error."""
        return not self.trouble and all(row.passed for row in self.outcome.rows)

    @property
    def rows(self) -> list[Row]:
        """Rows of the outcome."""
        return self.outcome.rows


def case(title: str, formula: str, reference: str) -> Callable:
    """Register a function as a case of its name, without ``_case`` at its end."""

    def register(function: Callable[[bool], Outcome]) -> Callable[[bool], Outcome]:
        name = function.__name__.removesuffix("_case")
        if name in CASES:
            raise ValueError(f"there are two cases {name!r}")
        CASES[name] = Case(name, title, formula, reference, function)
        return function

    return register


def observed_order(steps: Sequence[float], errors: Sequence[float]) -> list[float]:
    """Order of convergence between neighbours of a series, ``nan`` for the first.

    Parameters
    ----------
    steps : sequence of float
        Step or size, of any unit.
    errors : sequence of float
        Error at each of them, absolute value.
    """
    orders = [math.nan]
    for i in range(1, len(steps)):
        both = errors[i] > 0 and errors[i - 1] > 0
        ratio = math.log(errors[i] / errors[i - 1]) if both else math.nan
        orders.append(ratio / math.log(steps[i] / steps[i - 1]))
    return orders
