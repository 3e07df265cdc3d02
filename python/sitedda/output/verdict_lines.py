# SPDX-License-Identifier: GPL-3.0-or-later
"""Format the verdict of a run: sentence, table of results, warnings and counts."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from ..base.core import printing_rules, wrapped
from ..base.numbers import SHOWN, number, with_bar

if TYPE_CHECKING:
    from ..study.error_bars.figures import Accuracy

_COLUMNS = (20, 14, 14)  # smallest widths of name, largest value and final value
_DIED_OUT, WIDTH, CHECK_SAYS_MORE, NO_BARS = printing_rules()
_HEADS = ("", "largest", "at the end", "where, when")


class Doubt(NamedTuple):
    """A warning: topic and sentence, as in the lines of an output."""

    topic: str
    words: str

    @classmethod
    def lines(cls, text: str) -> list[Doubt]:
        """Return the warnings in a text, one per line."""
        return [cls(*line.split(": ", 1)) if ": " in line else cls("", line)
                for line in text.splitlines()]  # fmt: skip

    @property
    def is_from_check(self) -> bool:
        """Return whether the check of the model has reported this warning."""
        return self.topic == "check"

    def __str__(self) -> str:
        return ": ".join(filter(None, self))


@dataclass(frozen=True)
class ResultRow:
    """A row of the table of results.

    Attributes
    ----------
    name : str
    largest, end : str
        Keys of largest and final value in `Verdict.values`, or blank.
    unit : str
        Unit in which the values are shown, see `sitedda.base.numbers.SHOWN`.
    place : str
        Position and time of the largest value.
    """

    name: str
    largest: str
    end: str
    unit: str
    place: str


@dataclass(frozen=True)
class Verdict:
    """The results of a run in words.

    Attributes
    ----------
    values : dict of float
        Results by their name, which includes the unit: ``largest_displacement_m``; a measured point
        follows in brackets: ``pga_m_s2[top]``.
    clauses : list of str
        Clauses of the first sentence.
    figures : list of ResultRow
        The results that are not negligible.
    doubts : list of Doubt
        Warnings of the run, including those of the check of its model.
    steps : str
        Counts of the time stepping.
    bars : Accuracy or None
        Error bars of the results, if known.
    """

    values: dict[str, float] = field(default_factory=dict)
    clauses: list[str] = field(default_factory=list)
    figures: list[ResultRow] = field(default_factory=list)
    doubts: list[Doubt] = field(default_factory=list)
    steps: str = ""
    bars: Accuracy | None = None

    @property
    def happened(self) -> str:
        """Return the result in one sentence."""
        text = "; ".join(filter(None, self.clauses))
        return f"{text[:1].upper()}{text[1:]}." if text else ""

    @property
    def all_doubts(self) -> list[Doubt]:
        """Return all warnings; the warnings about error bars are last."""
        return self.doubts + (self.bars.doubts() if self.bars else [])

    @property
    def lines(self) -> list[tuple[str, str]]:
        """Return topic and text of all lines: sentence, results, warnings, counts."""
        results = [
            (line.name, "; ".join(filter(None, (large, end and f"{end} at the end", line.place))))
            for line, (_, large, end, _) in zip(self.figures, self.rows()[1:], strict=True)
        ]
        rows = [("what happened", self.happened), *results, *self.all_doubts, ("steps", self.steps)]
        return [(topic, text) for topic, text in rows if text]

    def rows(self) -> list[tuple[str, ...]]:
        """Return the table of results as texts, with its header first."""
        return [_HEADS, *((line.name, self._format_value(line.largest, line.unit),
                           self._end_text(line), line.place) for line in self.figures)]  # fmt: skip

    def _end_text(self, line: ResultRow) -> str:
        """Return the final value of a line as text; 0 if it is negligible."""
        end, largest = (abs(self.values.get(key, math.nan)) for key in (line.end, line.largest))
        if end < _DIED_OUT * largest:
            return f"0 {line.unit}".strip()
        return self._format_value(line.end, line.unit)

    def _format_value(self, key: str, unit: str) -> str:
        """Format the result of a key with error bar and unit; blank for a blank key."""
        if not key:
            return ""
        scale = SHOWN.get(unit, 1.0)
        bar = self.bars.figures.get(key) if self.bars else None
        value = self.values.get(key, math.nan)
        text = number(value * scale)
        if bar:  # if the error bar is not finite, the value of the run is shown
            magnitude = bar.finest if math.isfinite(bar.bar) else value
            text = with_bar(magnitude * scale, bar.bar * scale)
        return f"{text} {unit}".strip()

    def __str__(self) -> str:
        """Return the verdict as text: sentence, warnings of the check, table, others, counts."""
        check, rest = ("\n".join(f"doubt  {wrapped(str(doubt), 7)}" for doubt in self.all_doubts
                                 if doubt.is_from_check == is_from_check)
                       for is_from_check in (True, False))  # fmt: skip
        if check:
            check += f"\n{CHECK_SAYS_MORE}"
        table = _align_columns(self.rows()) if self.figures else ""
        paragraphs = (wrapped(self.happened), check, table, rest, wrapped(self.steps))
        return "\n\n".join(filter(None, paragraphs))

    def add_clause(self, clause: str, **values: float) -> None:
        """Add a clause to the first sentence, and its values."""
        self.clauses.append(clause)
        self.values.update({name: float(value) for name, value in values.items()})

    def add_result(self, name: str, key: str, value: float, unit: str, label: str, end=False):
        """Add a result to the table."""
        self.values[key] = float(value)
        self.figures.append(ResultRow(name, "" if end else key, key if end else "", unit, label))


def _align_columns(rows: list[tuple[str, ...]]) -> str:
    """Return rows as text with aligned columns, which have usual widths if possible."""
    widths = [max(width, 2 + max(len(row[i]) for row in rows)) for i, width in enumerate(_COLUMNS)]
    lines = []
    for row in rows:
        heading = "".join(f"{cell:{w}}" for cell, w in zip(row, widths, strict=False))
        lines += (heading + wrapped(row[3], len(heading),
                                    max(WIDTH, len(heading) + 20))).splitlines()  # fmt: skip
    return "\n".join(line.rstrip() for line in lines)
