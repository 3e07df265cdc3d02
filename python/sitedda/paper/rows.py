# SPDX-License-Identifier: GPL-3.0-or-later
"""What a study of the paper gives: rows, requirements, tables and pictures."""

from collections.abc import Callable
from dataclasses import dataclass, field

from matplotlib.figure import Figure

Value = float | tuple[float, float] | str | None


@dataclass(frozen=True)
class Row:
    """One result of the paper beside theory and run.

    Attributes
    ----------
    quantity : str
        What is compared, with its unit.
    place : str
        Where it stands in the paper.
    paper : float, (float, float), str or None
        Printed value, range of values, or words; None if the paper prints none.
    theory : float, str or None
        From a closed form or the exact discrete theory.
    sitedda : float or str
        Measured on the run.
    why : str
        What explains the difference.
    digits : int
        Significant digits shown.
    """

    quantity: str
    place: str
    paper: Value
    theory: Value
    sitedda: Value
    why: str = ""
    digits: int = 4

    @property
    def from_paper(self) -> float | None:
        """Relative difference of the run from the paper; 0 inside a printed range."""
        return deviation(self.sitedda, self.paper)

    @property
    def from_theory(self) -> float | None:
        """Relative difference of the run from the theory."""
        return deviation(self.sitedda, self.theory)


@dataclass(frozen=True)
class Requirement:
    """A line of what the reproduction must reach.

    Attributes
    ----------
    text : str
        What is asked for.
    reached : bool
        Whether the run reaches it.
    measured : str
        What was measured, with its limit.
    """

    text: str
    reached: bool
    measured: str

    @classmethod
    def within(cls, text: str, value: float, reference: float, limit: float) -> "Requirement":
        """A value within a relative limit of a reference."""
        off = abs(value - reference) / abs(reference)
        return cls(text, off <= limit, f"{per_cent(off)}, allowed {per_cent(limit)}")


@dataclass(frozen=True)
class Table:
    """A table of the report: title, column heads and cells that are already text."""

    title: str
    heads: list[str]
    cells: list[list[str]]


@dataclass(frozen=True)
class Picture:
    """A figure of the paper drawn anew.

    Attributes
    ----------
    name : str
        File name without ending.
    caption : str
        What it shows, with the figure of the paper.
    draw_on : callable
        Takes an empty figure.
    """

    name: str
    caption: str
    draw_on: Callable[[Figure], None]

    def draw(self) -> Figure:
        """The figure, drawn."""
        figure = Figure()
        self.draw_on(figure)
        return figure


@dataclass
class Study:
    """All that one study gives.

    Attributes
    ----------
    name, title : str
        Name on the command line and heading.
    text : list of str
        Paragraphs that go before the rows: what is modelled, printed and assumed.
    rows, requirements, tables, pictures : list
        See the classes.
    notes : list of str
        What disagrees and why.
    """

    name: str
    title: str
    text: list[str] = field(default_factory=list)
    rows: list[Row] = field(default_factory=list)
    requirements: list[Requirement] = field(default_factory=list)
    tables: list[Table] = field(default_factory=list)
    pictures: list[Picture] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


def deviation(value: Value, reference: Value) -> float | None:
    """Relative difference of a value from a number or from the nearer end of a range."""
    if isinstance(value, str | tuple) or value is None or isinstance(reference, str | None):
        return None
    low, high = reference if isinstance(reference, tuple) else (reference, reference)
    nearest = min(max(value, low), high)
    return (value - nearest) / abs(nearest) if nearest else None


def per_cent(fraction: float | None, sign: bool = False) -> str:
    """A fraction as text in per cent, from 10 on as a factor; `sign`: with + if above 0."""
    if fraction is None:
        return "–"
    if abs(fraction) < 5e-7:
        return "0 %"
    if abs(fraction) >= 10:
        return f"× {1 + fraction:.3g}"
    digits = 3 if abs(fraction) >= 0.0995 else 2
    return _plain(f"{100 * fraction:{'+' if sign else ''}.{digits}g}") + " %"


def show(value: Value, digits: int = 4) -> str:
    """A value of a row as text."""
    if value is None:
        return "–"
    if isinstance(value, str):
        return value
    if isinstance(value, tuple):
        return " – ".join(show(v, digits) for v in value)
    return _plain(f"{value:.{digits}g}")


def _plain(text: str) -> str:
    """Exponents as powers of ten."""
    mantissa, e, exponent = text.partition("e")
    return f"{mantissa}·10^{int(exponent)}" if e else mantissa
