# SPDX-License-Identifier: GPL-3.0-or-later
"""Results of a run with their error bars, as values, table or warnings."""

import math
import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field

import numpy as np

from ...base.numbers import number, with_bar
from ...output.verdict_lines import Doubt
from .bars import SMALL, Bar
from .variants import STEPS

COUNTS = ("contacts_slipped", "contacts_opened", "bonds_broken", "blocks_fallen", "blocks_lost")
# Values without error bars: audit residual, period of the largest Sa, resolved frequency, times.
_NO_BAR = ("energy_balance_j_m", "sa_period_s", "resolved_frequency_hz", "first_block_", "end_s")
_ROUND_OFF = 1e-9  # final values below this fraction of the largest value are round-off
_NO_DRIFT = 1e-6  # residual drifts below this value are round-off
_IMPACT_GROWTH = 1.5  # smallest growth per halving of Δt that indicates a result without limit
_UNBOUNDED = ("force", "pga_", "sa_", "acceleration")  # results without limit in a rigid impact
_STIFFER = (*_UNBOUNDED, "strain", "arias_")  # results that increase with the penalty stiffness
_NUMBER = re.compile(r"\d[\d.e+-]*")
_TIMES = 200  # largest number of times of a stored band
BEYOND, IMPACT = "beyond the horizon", "grows as 1/Δt, an impact"
NOT_CONVERGED = "does not converge"
YIELD = "only the compression of contact springs"


@dataclass(frozen=True)
class Figure:
    """A result of a run and its error bar.

    Attributes
    ----------
    name : str
        Name as in ``Run.verdict.values``, with the unit.
    run : float
        Value of the run itself, with Δt.
    finest : float
        Value with Δt/4, or Δt/64 if the run is linear.
    bar : float
        Half the width of the error bar: the value for infinitely small steps and rigid contacts is
        assumed to be within `finest` ± `bar`; NaN if there is no bar.
    extrapolated : float
        Richardson extrapolation; NaN if the observed order is not that of the scheme.
    order : float
        Observed order of convergence; NaN if there is none.
    penalty : float
        Part of the bar due to the penalty stiffness; 0 if no joint has a penalty stiffness.
    doubt : str
        Reason why there is no error bar, or error that the bar does not include; otherwise blank.
    decided : float
        Time (s) until which the run and its twin (a block displaced by 1e-9 of its size) have the
        same result within 1 %, at most the end of the run; NaN without a twin.
    low, median, high : float
        16, 50 and 84 % fractiles of an ensemble of twins; NaN without an ensemble.
    """

    name: str
    run: float
    finest: float
    bar: float
    extrapolated: float
    order: float
    penalty: float
    doubt: str = ""
    decided: float = math.nan
    low: float = math.nan
    median: float = math.nan
    high: float = math.nan

    def __str__(self) -> str:
        """Return value ± bar, rounded to the digits that the bar justifies."""
        return with_bar(self.finest, self.bar)


@dataclass(frozen=True)
class Band:
    """The spread of a result over time in an ensemble of twins."""

    time: np.ndarray  # s; shape (times,)
    # `low`, `median`, `high`: 16, 50 and 84 % fractiles of the result; shape (times,)
    low: np.ndarray
    median: np.ndarray
    high: np.ndarray


@dataclass(frozen=True)
class Accuracy:
    """The results of a run with their error bars.

    Attributes
    ----------
    figures : dict of Figure
        Results by their names.
    runs : dict of str
        Reason for the early end, or warning, of each run; otherwise blank.
    end : float
        Time of the end of the run, s.
    bands : dict of Band
        Spread over time of each result, by its name; empty without an ensemble.
    cause : str
        Cause of missing convergence; blank if all results converge.
    """

    figures: dict[str, Figure]
    runs: dict[str, str] = field(default_factory=dict)
    end: float = math.nan
    bands: dict[str, Band] = field(default_factory=dict)
    cause: str = ""

    def rows(self) -> list[tuple[str, ...]]:
        """Return the rows of a table: a header, then one row per result; omit blank columns."""
        rows = [_HEAD, *(_table_row(figure, self.end) for figure in self.figures.values())]
        columns = [i for i in range(len(_HEAD)) if i < 3 or any(row[i] for row in rows[1:])]
        return [tuple(row[i] for i in columns) for row in rows]

    def __str__(self) -> str:
        """Return a table of the results, and the warnings of the runs."""
        rows = self.rows()
        to_left = (0, rows[0].index("") if "" in rows[0] else -1)
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        lines = [
            "  ".join(
                f"{cell:{'<' if i in to_left else '>'}{widths[i]}}" for i, cell in enumerate(row)
            )
            for row in rows
        ]
        lines += [f"{NOT_CONVERGED}: {self.cause}"] if self.cause else []
        lines += self._distinct_warnings()
        return "\n".join(line.rstrip() for line in lines)

    def __getitem__(self, name: str) -> Figure:
        """Return a result by its name."""
        return self.figures[name]

    def draw(self):
        """Draw the bands over time; return the figure (see `sitedda.study.error_bars.picture`)."""
        from .picture import bands_picture

        return bands_picture(self)

    def doubts(self) -> list[Doubt]:
        """Return warnings; results with the same warning share one."""
        groups: dict[str, list[str]] = {}
        for name, figure in self.figures.items():
            if figure.doubt:
                text = figure.doubt.partition(":")[0]
                groups.setdefault(BEYOND if text.startswith(BEYOND) else text, []).append(name)
        if late_results := groups.pop(BEYOND, []):
            horizons = (self.figures[name].doubt.removeprefix(BEYOND).split()[1]
                        for name in late_results)  # fmt: skip
            earliest = min(horizons, key=float)
            groups[f"{BEYOND} (first: {earliest} s), random samples"] = late_results
        texts = [f"{text}: {', '.join(names)}" for text, names in groups.items()]
        texts += [f"cause of missing convergence: {self.cause}"] if self.cause else []
        texts += self._distinct_warnings()
        return [Doubt("bars", text) for text in texts]

    def _distinct_warnings(self) -> list[str]:
        """Return the warnings of the runs; list runs together that differ only in numbers."""
        groups: dict[str, list[tuple[str, str]]] = {}
        for name, text in self.runs.items():
            for line in text.splitlines():
                groups.setdefault(_NUMBER.sub("", line), []).append((name, line))
        return [f"run{'s' * (len(runs) > 1)} {', '.join(name for name, _ in runs)}: {runs[0][1]}"
                for runs in groups.values()]  # fmt: skip

    def to_dict(self) -> dict:
        """Return dicts and lists of numbers and texts, for example for JSON."""
        return {
            "figures": {name: asdict(figure) for name, figure in self.figures.items()},
            "runs": self.runs,
            "end_s": self.end,
            "cause": self.cause,
            "bands": {
                name: {key: row[:: -(-len(band.time) // _TIMES)].tolist()
                       for key, row in vars(band).items()}
                for name, band in self.bands.items()
            },
        }  # fmt: skip


_HEAD = ("result", "this run", "value ± bar", "extrapolated", "16 %", "median", "84 %",
         "predictable until", "")  # fmt: skip


def _table_row(figure: Figure, end: float) -> tuple[str, ...]:
    """Return the cells of a result; `end` is the end of the run, s."""
    numbers = (figure.extrapolated, figure.low, figure.median, figure.high)
    cells = ("" if math.isnan(value) else number(value, 5) for value in numbers)
    horizon = "" if math.isnan(figure.decided) else "the end"
    if figure.decided < end:
        horizon = f"t = {number(figure.decided, 3)} s"
    return figure.name, number(figure.run), str(figure), *cells, horizon, figure.doubt


def is_figure(name: str, values: Mapping[str, float]) -> bool:
    """Return whether a result can have an error bar: not audit residuals, times or round-off.

    `values`: all numbers of the verdict.
    """
    if name.startswith(_NO_BAR) or not math.isfinite(values[name]):
        return False
    if name == "residual_drift":
        return abs(values[name]) >= _NO_DRIFT
    largest = values.get(name.replace("residual_", "largest_"), 1.0)
    return abs(values[name]) > _ROUND_OFF * abs(largest)


def is_count(name: str) -> bool:
    """Return whether a result is a count, which is 0 if missing."""
    return name.startswith(COUNTS)


def figure_of(name: str, numbers: tuple[float, ...], bar: Bar, penalty: float,
              steps: tuple[int, ...] = STEPS) -> Figure:  # fmt: skip
    """Return a result with its error bar and warnings.

    `numbers`: values with three time steps.
    `bar`: error bar of these values.
    `penalty`: error due to the penalty stiffness; 0 without penalty, NaN if unknown.
    `steps`: divisors of Δt in these runs.
    """
    warning, half_width = "", bar.half + penalty
    if is_count(name) and all(map(math.isfinite, numbers)):
        spread = max(numbers) - min(numbers)
        warning = "the count depends on the time step" if spread else ""
        return Figure(name, numbers[0], numbers[-1], spread, math.nan, math.nan, 0.0, warning)
    if not all(map(math.isfinite, numbers)):
        warning = "no error bar: some runs do not have this result"
    elif math.isnan(penalty):
        warning = "no error bar: the run with 4 k_n does not have this result"
    elif penalty >= abs(numbers[-1]) and not any(map(name.__contains__, _STIFFER)):
        warning = YIELD
    elif not bar.converges:
        a, b, c = map(abs, numbers)
        is_growing = b > _IMPACT_GROWTH * a and c > _IMPACT_GROWTH * b
        reason = IMPACT if is_growing and any(map(name.__contains__, _UNBOUNDED)) else NOT_CONVERGED
        steps_text = ", ".join("Δt" if divisor == 1 else f"Δt/{divisor}" for divisor in steps)
        warning = f"{reason}: {', '.join(map(number, numbers))} at {steps_text}"
    elif penalty > max(bar.half, 10 * SMALL * abs(numbers[-1])):
        warning = "the error bar is due to the penalty stiffness"
    return Figure(name, numbers[0], numbers[-1], half_width, bar.extrapolated, bar.order, penalty,
                  warning)  # fmt: skip
