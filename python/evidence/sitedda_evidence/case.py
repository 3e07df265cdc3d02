# SPDX-License-Identifier: GPL-3.0-or-later
"""Cases that compare computed with expected results, in tables and pictures."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from matplotlib.figure import Figure

from sitedda.base.errors import InputError, SiteddaError
from sitedda.report import Picture
from sitedda.report.style import add_legends, canvas

from .comparison import Comparison
from .runs import Task, run_all

Tasks = Callable[[bool], list[Task]]


@dataclass(frozen=True)
class Row:
    """A computed result and its expected value."""

    quantity: str  # name of the result
    expected: float | None  # theoretical value; None if only a bound is known
    computed: float  # result of the engine
    error: float  # relative error, absolute error or the result itself, see `kind`
    allowed: float | None  # largest allowed error; None if the row is only for information
    kind: str  # "relative" (a ratio), "absolute" or "at most" (both in `unit`), or "yes or no"
    unit: str = ""  # unit of `expected` and `computed`
    description: str = ""  # description of the result, if a number is not sufficient

    @property
    def passed(self) -> bool:
        """Return whether the error is within its bound; a row without a bound always passes."""
        return self.allowed is None or self.error <= self.allowed


def relative(quantity, expected, computed, allowed, unit="") -> Row:
    """Return a row judged by its relative error."""
    error = abs(computed - expected) / abs(expected)
    return Row(quantity, expected, computed, error, allowed, "relative", unit)


def absolute(quantity, expected, computed, allowed, unit="") -> Row:
    """Return a row judged by its absolute error."""
    return Row(quantity, expected, computed, abs(computed - expected), allowed, "absolute", unit)


def at_most(quantity, computed, allowed, unit="") -> Row:
    """Return a row judged by a bound on the result itself."""
    return Row(quantity, None, computed, computed, allowed, "at most", unit)


def yes_or_no(quantity, expected: bool, computed: bool, description: str = "") -> Row:
    """Return a row that passes if a yes-or-no result is as expected."""
    error = float(expected != computed)
    return Row(quantity, float(expected), float(computed), error, 0.0, "yes or no", "", description)


def requirement(quantity: str, is_met: bool, description: str) -> Row:
    """Return a row that passes if a requirement is met, with a description of the result."""
    return yes_or_no(quantity, True, is_met, description)


@dataclass(frozen=True)
class Table:
    """A table of results without a verdict, such as a convergence study."""

    title: str
    heads: Sequence[str]
    rows: Sequence[Sequence[object]]


@dataclass
class Outcome:
    """The result of a case: judged rows and the contents of its report."""

    rows: list[Row] = field(default_factory=list)
    figure: Figure | None = None  # its caption is the title of the case
    tables: list[Table] = field(default_factory=list)
    text: list[str] = field(default_factory=list)  # model, printed values and assumptions
    comparisons: list[Comparison] = field(default_factory=list)
    pictures: list[Picture] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)  # differences and their causes

    def compare(self, *values, within: float | None = None) -> None:
        """Add a comparison with a published value, see `Comparison`.

        `within` also adds a row: the largest error relative to theory, or absolute if that is 0.
        """
        comparison = Comparison(*values)
        self.comparisons.append(comparison)
        if within is not None:
            kind = relative if comparison.theory else absolute
            row = kind(comparison.quantity, comparison.theory, comparison.sitedda, within)
            self.rows.append(row)

    def require(self, *values) -> None:
        """Add a row for a condition that must be true, see `requirement`."""
        self.rows.append(requirement(*values))

    def tabulate(self, *values) -> None:
        """Add a table, see `Table`."""
        self.tables.append(Table(*values))


def picture(name: str, caption: str, draw_on: Callable[..., None], *values) -> Picture:
    """Return a picture; the function `draw_on` draws values on an empty figure."""
    figure = Figure()
    draw_on(figure, *values)
    return Picture(figure, caption, name)


def curves(x_label: str, y_label: str, *lines) -> Figure:
    """Return a figure of curves; each line is (x, y, keywords of matplotlib)."""
    figure, (axis,) = canvas(1, size=(6.0, 3.4))
    for x, y, style in lines:
        axis.plot(x, y, **style)
    axis.set(xlabel=x_label, ylabel=y_label)
    return figure


@dataclass(frozen=True)
class Collection:
    """A collection of cases for a command and its report."""

    name: str  # file name of the page without ending
    title: str
    lead: str  # first paragraph
    cases: dict[str, Case] = field(default_factory=dict)

    def add(self, title: str, formula: str, reference: str, tasks: Tasks | None = None) -> Callable:
        """Register a function as a case; the ending ``_case`` is not part of the name."""

        def register(function: Callable) -> Callable:
            name = function.__name__.removesuffix("_case")
            if name in self.cases:
                raise ValueError(f"there are two cases {name!r}")
            self.cases[name] = Case(name, title, formula, reference, function, tasks)
            return function

        return register

    def run(
        self,
        names: Iterable[str] = (),
        short: bool = False,
        progress: Callable[[int, int], None] | None = None,
        cores: int = 2,
    ) -> Iterator[Result]:
        """Run the tasks of cases in parallel, then the cases in the order of the report.

        `names`: names of cases; none: all cases.
        `short`: run fewer variants and smaller models of the same physics, as in tests.
        `progress`: called with the number of completed tasks and the number of tasks.
        `cores`: number of processes for tasks.
        """
        selection = set(names) or set(self.cases)
        if unknown := sorted(selection - set(self.cases)):
            all_names = ", ".join(self.cases)
            raise InputError(f"there is no case {', '.join(unknown)}; the cases are {all_names}")
        cases = [case for name, case in self.cases.items() if name in selection]
        tasks = [replace(task, key=(case.name, task.key))
                 for case in cases if case.tasks for task in case.tasks(short)]  # fmt: skip
        results = run_all(tasks, progress, cores) if tasks else {}
        for case in cases:
            yield case.run(short, {key: value for (name, key), value in results.items()
                                   if name == case.name})  # fmt: skip


@dataclass(frozen=True)
class Case:
    """A case with a known solution."""

    name: str
    title: str
    formula: str  # expected result and its derivation, Markdown
    reference: str  # source of the formula
    # Function of ``short``, or of the results of the tasks by key; it returns an `Outcome`
    function: Callable[..., Outcome]
    tasks: Tasks | None = None  # function of ``short`` that returns a list of `Task`

    def run(self, short: bool = False, task_results: Mapping | None = None) -> Result:
        """Run the case; an error of the engine becomes a failed result.

        `short`: see `Collection.run`.
        `task_results`: results of its tasks by key.
        """
        begin = time.perf_counter()
        try:
            argument = dict(task_results or {}) if self.tasks else short
            outcome, engine_error = self.function(argument), ""
        except SiteddaError as error:
            outcome, engine_error = Outcome(), str(error)
        if outcome.figure:
            add_legends(outcome.figure)
            outcome.pictures.insert(0, Picture(outcome.figure, self.title, self.name))
        return Result(self, outcome, time.perf_counter() - begin, engine_error)


@dataclass(frozen=True)
class Result:
    """The result of a case; `engine_error` is the error of the engine, if any."""

    case: Case
    outcome: Outcome
    seconds: float
    engine_error: str = ""

    @property
    def passed(self) -> bool:
        """Return whether all rows passed and the engine raised no error."""
        return not self.engine_error and all(row.passed for row in self.outcome.rows)

    @property
    def rows(self) -> list[Row]:
        """Return the rows of the outcome."""
        return self.outcome.rows


VALIDATION = Collection(
    "report",
    "Validation",
    "This run computed all results. Expected values are closed forms or independent solutions "
    "(scipy).",
)
PAPER = Collection(
    "paper",
    "The paper's results, reproduced",
    "sitedda reproduces each table and figure of “Site response analysis with two-dimensional"
    " numerical discontinuous deformation analysis method” (2013) that contains a result. Values"
    " and formulas of the paper are cited with their figure, table or section. The run that wrote"
    " this report computed all other values.",
)
case = VALIDATION.add


def study(title: str, tasks: Tasks) -> Callable:
    """Register a function as a case of the paper."""
    return PAPER.add(title, "", "", tasks)


def observed_order(steps: Sequence[float], errors: Sequence[float]) -> list[float]:
    """Return the order of convergence between successive steps; ``nan`` for the first step.

    `steps`: time steps or sizes, in any unit; `errors`: absolute error at each step.
    """
    orders = [math.nan]
    for i in range(1, len(steps)):
        positive = errors[i] > 0 and errors[i - 1] > 0
        ratio = math.log(errors[i] / errors[i - 1]) if positive else math.nan
        orders.append(ratio / math.log(steps[i] / steps[i - 1]))
    return orders


def convergence(title: str, head: str, steps: Sequence[float], errors: Sequence[float]) -> Table:
    """Return a table of steps, errors and orders of convergence."""
    rows = zip(steps, errors, observed_order(steps, errors), strict=True)
    return Table(title, (head, "error", "order"), list(rows))
