# SPDX-License-Identifier: GPL-3.0-or-later
"""Results of a run with their error bars, as sentences or table."""

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
# Values without error bars: residual of the audit, times and periods of a largest value.
_NOT = ("energy_balance_j_m", "sa_period_s", "resolved_frequency_hz", "first_block_", "end_s")
_REST = 1e-9  # final values below this fraction of the largest value are round-off
_NO_DRIFT = 1e-6
_BLOW = 1.5  # growth per halving of Δt of a result without a limit
_OF_BLOWS = ("force", "pga_", "sa_", "acceleration")  # without a limit in a rigid impact
_STIFFER = (*_OF_BLOWS, "strain", "arias_")  # results that increase with the penalty stiffness
_NUMBER = re.compile(r"\d[\d.e+-]*")
_TIMES = 200  # largest number of times of a stored band
BEYOND, BLOW, OPEN = "beyond the horizon", "grows as 1/Δt, an impact", "does not converge"
YIELD = "only the compression of contact springs"


@dataclass(frozen=True)
class Figure:
    """A result of a run and its error bar.

    Attributes
    ----------
    name : str
        As in ``Run.verdict.values``, with its unit.
    run : float
        Value of the run itself, at Δt.
    finest : float
        Value at Δt/4; of a linear run at Δt/64.
    bar : float
        Half the width of the error bar: the value for infinitely small steps and rigid contacts is
        assumed to lie within `finest` ± `bar`; NaN if there is no bar.
    extrapolated : float
        By Richardson, from the three steps; NaN where their order is not that of the scheme.
    order : float
        p of the changes; NaN if there is none.
    penalty : float
        Part of the bar due to the penalty stiffness; 0 if no joint has one.
    doubt : str
        Why there is no error bar, or which error it omits; otherwise blank.
    decided : float
        Time, s, until which a twin of the run, with a block displaced by 1e-9 of its size, has the
        same result within 1 %; the end of the run if always; NaN without a twin.
    low, median, high : float
        16, 50 and 84 % of the twins of an ensemble; NaN without one.
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

    @property
    def is_inside(self) -> bool:
        """Return whether the result of the run itself lies within the bar."""
        return abs(self.run - self.finest) <= self.bar

    def __str__(self) -> str:
        """Return number ± bar, in the digits that the bar justifies."""
        return with_bar(self.finest, self.bar)


@dataclass(frozen=True)
class Band:
    """The spread of a result over time in an ensemble of twins.

    Attributes
    ----------
    time : ndarray, shape (looks,)
        s
    low, median, high : ndarray, shape (looks,)
        16, 50 and 84 % of them.
    """

    time: np.ndarray
    low: np.ndarray
    median: np.ndarray
    high: np.ndarray


@dataclass(frozen=True)
class Accuracy:
    """The results of a run with their error bars.

    Attributes
    ----------
    figures : dict of Figure
        By name.
    runs : dict of str
        For each run, why it ended early, or its warning, or blank.
    end : float
        Time of the end of the run, s.
    bands : dict of Band
        Of figures over time, by their names; empty without an ensemble.
    cause : str
        Cause of missing convergence; blank if all results converge.
    """

    figures: dict[str, Figure]
    runs: dict[str, str] = field(default_factory=dict)
    end: float = math.nan
    bands: dict[str, Band] = field(default_factory=dict)
    cause: str = ""

    def rows(self) -> list[tuple[str, ...]]:
        """Return the results as texts under their headers, without blank columns."""
        rows = [_HEAD, *(_table_row(figure, self.end) for figure in self.figures.values())]
        kept = [i for i in range(len(_HEAD)) if i < 3 or any(row[i] for row in rows[1:])]
        return [tuple(row[i] for i in kept) for row in rows]

    def __str__(self) -> str:
        """Return a table, and the runs that ended early."""
        rows = self.rows()
        left = (0, rows[0].index("") if "" in rows[0] else -1)
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        lines = [
            "  ".join(
                f"{cell:{'<' if i in left else '>'}{widths[i]}}" for i, cell in enumerate(row)
            )
            for row in rows
        ]
        lines += [f"{OPEN}: {self.cause}"] if self.cause else []
        lines += self._distinct_sentences()
        return "\n".join(line.rstrip() for line in lines)

    def __getitem__(self, name: str) -> Figure:
        """Return a result by its name."""
        return self.figures[name]

    def draw(self):
        """Draw bands over time, see `sitedda.study.error_bars.picture`; return the figure."""
        from .picture import bands_picture

        return bands_picture(self)

    def doubts(self) -> list[Doubt]:
        """Return warnings on several results: no bar, a horizon, runs that ended early."""
        groups: dict[str, list[str]] = {}
        for name, figure in self.figures.items():
            if figure.doubt:
                words = figure.doubt.partition(":")[0]
                groups.setdefault(BEYOND if words.startswith(BEYOND) else words, []).append(name)
        if late := groups.pop(BEYOND, []):
            ends = (self.figures[name].doubt.removeprefix(BEYOND).split()[1] for name in late)
            first = min(ends, key=float)
            groups[f"{BEYOND} (first: {first} s), random samples"] = late
        found = [f"{words}: {', '.join(names)}" for words, names in groups.items()]
        found += [f"what {OPEN}: {self.cause}"] if self.cause else []
        found += self._distinct_sentences()
        return [Doubt("bars", words) for words in found]

    def _distinct_sentences(self) -> list[str]:
        """Return the distinct sentences of runs, in the words of the first run."""
        same: dict[str, list[tuple[str, str]]] = {}
        for name, words in self.runs.items():
            for line in words.splitlines():
                same.setdefault(_NUMBER.sub("", line), []).append((name, line))
        return [f"run{'s' * (len(said) > 1)} {', '.join(name for name, _ in said)}: {said[0][1]}"
                for said in same.values()]  # fmt: skip

    def to_dict(self) -> dict:
        """Return plain values, for example for JSON."""
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


_HEAD = ("figure", "this run", "value ± bar", "extrapolated", "16 %", "median", "84 %",
         "decided until", "")  # fmt: skip


def _table_row(figure: Figure, end: float) -> tuple[str, ...]:
    numbers = (figure.extrapolated, figure.low, figure.median, figure.high)
    more = ("" if math.isnan(value) else number(value, 5) for value in numbers)
    until = "" if math.isnan(figure.decided) else "the end"
    if figure.decided < end:
        until = f"t = {number(figure.decided, 3)} s"
    return figure.name, number(figure.run), str(figure), *more, until, figure.doubt


def is_figure(name: str, values: Mapping[str, float]) -> bool:
    """Return whether a number gets an error bar: not of the audit, not final round-off.

    Parameters
    ----------
    name : str
    values : mapping of float
        All numbers of the run.
    """
    if name.startswith(_NOT) or not math.isfinite(values[name]):
        return False
    if name == "residual_drift":
        return abs(values[name]) >= _NO_DRIFT
    largest = values.get(name.replace("residual_", "largest_"), 1.0)
    return abs(values[name]) > _REST * abs(largest)


def is_count(name: str) -> bool:
    """Return whether a name is a count, which is 0 if a run omits it."""
    return name.startswith(COUNTS)


def figure_of(name: str, numbers: tuple[float, ...], bar: Bar, penalty: float,
              steps: tuple[int, ...] = STEPS) -> Figure:  # fmt: skip
    """Return a result with its error bar and warnings.

    Parameters
    ----------
    name : str
    numbers : tuple of float
        At three time steps.
    bar : Bar
        Of these.
    penalty : float
        Error by the penalty stiffness; 0 without penalty, NaN if unknown.
    steps : tuple of int
        Divisors of Δt.
    """
    doubt, half = "", bar.half + penalty
    if is_count(name) and all(map(math.isfinite, numbers)):
        spread = max(numbers) - min(numbers)
        doubt = "counts differ between time steps" if spread else ""
        return Figure(name, numbers[0], numbers[-1], spread, math.nan, math.nan, 0.0, doubt)
    if not all(map(math.isfinite, numbers)):
        doubt = "no error bar: some runs do not have this result"
    elif math.isnan(penalty):
        doubt = "no error bar: the run with 4 k_n does not have this result"
    elif penalty >= abs(numbers[-1]) and not any(map(name.__contains__, _STIFFER)):
        doubt = YIELD
    elif not bar.converges:
        a, b, c = map(abs, numbers)
        grows = b > _BLOW * a and c > _BLOW * b
        why = BLOW if grows and any(map(name.__contains__, _OF_BLOWS)) else OPEN
        at = ", ".join("Δt" if times == 1 else f"Δt/{times}" for times in steps)
        doubt = f"{why}: {', '.join(map(number, numbers))} at {at}"
    elif penalty > max(bar.half, 10 * SMALL * abs(numbers[-1])):
        doubt = "the error bar is due to the penalty stiffness"
    return Figure(name, numbers[0], numbers[-1], half, bar.extrapolated, bar.order, penalty, doubt)
