# SPDX-License-Identifier: GPL-3.0-or-later
"""Figures of a run with their error bars, as sentence or table."""

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
_REST = 1e-9  # fraction of the largest value of a run below which one at its end is round-off
_NO_DRIFT = 1e-6
_BLOW = 1.5  # growth per halving of the steps of a figure without limit
_OF_BLOWS = ("force", "pga_", "sa_", "acceleration")  # figures without limit in a rigid impact
_STIFFER = (*_OF_BLOWS, "strain", "arias_")  # figures that stiff contacts raise
_NUMBER = re.compile(r"\d[\d.e+-]*")
_TIMES = 200  # of a stored band
BEYOND, BLOW, OPEN = "beyond the horizon", "grows as 1/Δt, a blow", "does not converge"
YIELD = "only the compression of contact springs"


@dataclass(frozen=True)
class Figure:
    """A number of a run and its error bar.

    Attributes
    ----------
    name : str
        As in ``Run.verdict.values``, with its unit.
    run : float
        Of the run itself, at Δt.
    finest : float
        At Δt/4; of a linear run at Δt/64.
    bar : float
        The truth, of infinitely small steps and stiff contacts, is taken to lie within `finest` ±
        `bar`; NaN if there is no bar.
    extrapolated : float
        By Richardson, from the three steps; NaN where their order is not that of the scheme.
    order : float
        p of the changes; NaN if there is none.
    penalty : float
        Part of the bar due to the penalty stiffness; 0 if no joint has one.
    doubt : str
        Why there is no bar, or what it leaves out; else blank.
    decided : float
        Time until which a twin of the run, a block of which is displaced by 1e-9 of its size, has
        the same figure within 1 %, s; that of the end if always; NaN if there is no twin.
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
        """The run's own number lies within the bar."""
        return abs(self.run - self.finest) <= self.bar

    def __str__(self) -> str:
        """Number ± bar, in as many digits as the bar leaves."""
        return with_bar(self.finest, self.bar)


@dataclass(frozen=True)
class Band:
    """Spread of a figure over time in an ensemble of twins.

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
    """The figures of a run with their bars.

    Attributes
    ----------
    figures : dict of Figure
        By name.
    runs : dict of str
        Of each run that was made what ended it before its time or what it warned of, or blank.
    end : float
        Time of the end of the run, s.
    bands : dict of Band
        Of figures over time, by their names; empty without an ensemble.
    cause : str
        Of figures that do not converge; blank if all do.
    """

    figures: dict[str, Figure]
    runs: dict[str, str] = field(default_factory=dict)
    end: float = math.nan
    bands: dict[str, Band] = field(default_factory=dict)
    cause: str = ""

    def rows(self) -> list[tuple[str, ...]]:
        """The figures as texts under their heads, without columns that are blank."""
        rows = [_HEAD, *(_row(figure, self.end) for figure in self.figures.values())]
        kept = [i for i in range(len(_HEAD)) if i < 3 or any(row[i] for row in rows[1:])]
        return [tuple(row[i] for i in kept) for row in rows]

    def __str__(self) -> str:
        """A table, and the runs that ended early."""
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
        """A figure by its name."""
        return self.figures[name]

    def draw(self):
        """Bands over time, see `sitedda.study.error_bars.picture`; a matplotlib figure."""
        from .picture import bands_picture

        return bands_picture(self)

    def doubts(self) -> list[Doubt]:
        """Doubts common to several figures: no bar, a horizon, runs that ended early."""
        groups: dict[str, list[str]] = {}
        for name, figure in self.figures.items():
            if figure.doubt:
                words = figure.doubt.partition(":")[0]
                groups.setdefault(BEYOND if words.startswith(BEYOND) else words, []).append(name)
        if late := groups.pop(BEYOND, []):
            ends = (self.figures[name].doubt.removeprefix(BEYOND).split()[1] for name in late)
            first = min(ends, key=float)
            groups[f"{BEYOND}, the first of {first} s, each one of a distribution"] = late
        found = [f"{words}: {', '.join(names)}" for words, names in groups.items()]
        found += [f"what {OPEN}: {self.cause}"] if self.cause else []
        found += self._distinct_sentences()
        return [Doubt("bars", words) for words in found]

    def _distinct_sentences(self) -> list[str]:
        """Sentences of runs, each once, in the words of the first run."""
        same: dict[str, list[tuple[str, str]]] = {}
        for name, words in self.runs.items():
            for line in words.splitlines():
                same.setdefault(_NUMBER.sub("", line), []).append((name, line))
        return [f"run{'s' * (len(said) > 1)} {', '.join(name for name, _ in said)}: {said[0][1]}"
                for said in same.values()]  # fmt: skip

    def to_dict(self) -> dict:
        """Plain values, such as for JSON."""
        return {
            "figures": {name: asdict(figure) for name, figure in self.figures.items()},
            "runs": self.runs,
            "end_s": self.end,
            "cause": self.cause,
            "bands": {name: _thinned(band) for name, band in self.bands.items()},
        }


def _thinned(band: Band) -> dict[str, list[float]]:
    """A band at no more times than a picture shows."""
    kept = slice(None, None, -(-len(band.time) // _TIMES))
    return {name: values[kept].tolist() for name, values in vars(band).items()}


_HEAD = ("figure", "this run", "value ± bar", "extrapolated", "16 %", "median", "84 %",
         "decided until", "")  # fmt: skip


def _row(figure: Figure, end: float) -> tuple[str, ...]:
    numbers = (figure.extrapolated, figure.low, figure.median, figure.high)
    more = ("" if math.isnan(value) else number(value, 5) for value in numbers)
    until = "" if math.isnan(figure.decided) else "the end"
    if figure.decided < end:
        until = f"t = {number(figure.decided, 3)} s"
    return figure.name, number(figure.run), str(figure), *more, until, figure.doubt


def is_figure(name: str, values: Mapping[str, float]) -> bool:
    """Whether a number gets a bar: not one of the audit, nor round-off at rest.

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
    """A number of things, which is 0 where a run does not name it."""
    return name.startswith(COUNTS)


def figure_of(name: str, numbers: tuple[float, ...], bar: Bar, penalty: float,
              steps: tuple[int, ...] = STEPS) -> Figure:  # fmt: skip
    """A figure from its bar.

    Parameters
    ----------
    name : str
    numbers : tuple of float
        At three time steps.
    bar : Bar
        Of these.
    penalty : float
        Error by the penalty stiffness; 0 without one, NaN where it is not known.
    steps : tuple of int
        Divisors of Δt.
    """
    doubt, half = "", bar.half + penalty
    if is_count(name) and all(map(math.isfinite, numbers)):
        spread = max(numbers) - min(numbers)
        doubt = "counts differ between time steps" if spread else ""
        return Figure(name, numbers[0], numbers[-1], spread, math.nan, math.nan, 0.0, doubt)
    if not all(map(math.isfinite, numbers)):
        doubt = "no bar: not all runs have it"
    elif math.isnan(penalty):
        doubt = "no bar: the run with 4 k_n does not have it"
    elif penalty >= abs(numbers[-1]) and not any(map(name.__contains__, _STIFFER)):
        doubt = YIELD
    elif not bar.converges:
        a, b, c = map(abs, numbers)
        grows = b > _BLOW * a and c > _BLOW * b
        why = BLOW if grows and any(map(name.__contains__, _OF_BLOWS)) else OPEN
        at = ", ".join("Δt" if times == 1 else f"Δt/{times}" for times in steps)
        doubt = f"{why}: {', '.join(map(number, numbers))} at {at}"
    elif penalty > max(bar.half, 10 * SMALL * abs(numbers[-1])):
        doubt = "the bar is of the penalty stiffness"
    return Figure(name, numbers[0], numbers[-1], half, bar.extrapolated, bar.order, penalty, doubt)
