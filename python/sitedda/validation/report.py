# SPDX-License-Identifier: GPL-3.0-or-later
"""Results as text for the terminal and as one report with pictures."""

import math
from collections.abc import Iterable
from pathlib import Path

from ..base.files import make_folder
from ..report import Page, Paragraph, Picture, Table, provenance, write_html
from ..report.page import Part
from .case import Result, Row


def number(value) -> str:
    """A figure with as many digits as one wants to read."""
    if value is None:
        return "–"
    if isinstance(value, str):
        return value
    value = float(value)
    if math.isnan(value):
        return "–"
    if value == 0 or (value == round(value) and abs(value) < 1e6):
        return f"{value:.0f}"
    return f"{value:.7g}" if 1e-3 <= abs(value) < 1e6 else f"{value:.3e}"


def small(value) -> str:
    """An error or a bound with three digits."""
    return "–" if value is None else f"{float(value):.3g}"


def row_cells(row: Row) -> list[str]:
    """Quantity, expected, got, error, allowed and verdict."""
    unit = f" {row.unit}" if row.unit else ""
    if row.kind == "yes or no":
        answer = {0.0: "no", 1.0: "yes"}
        return [row.quantity, answer[row.expected], answer[row.got], "", "", _verdict(row)]
    expected = "" if row.expected is None else number(row.expected) + unit
    if row.kind == "at most":
        return [row.quantity, expected, small(row.got) + unit, "", _bound(row), _verdict(row)]
    suffix = unit if row.kind == "absolute" else ""
    return [
        row.quantity,
        expected,
        number(row.got) + unit,
        small(row.error) + suffix,
        _bound(row) + (suffix if row.allowed is not None else ""),
        _verdict(row),
    ]


def _bound(row: Row) -> str:
    return "" if row.allowed is None else small(row.allowed)


def _verdict(row: Row) -> str:
    if row.allowed is None:
        return "shown"
    return "ok" if row.passed else "FAILS"


def terminal_text(result: Result) -> str:
    """A result for the terminal."""
    verdict = "ok" if result.passed else "FAILS"
    lines = [f"{result.case.name}: {verdict} ({result.seconds:.1f} s) — {result.case.title}"]
    if result.trouble:
        lines.append(f"  error: {result.trouble}")
    for row in result.rows:
        quantity, expected, got, error, allowed, mark = row_cells(row)
        parts = [
            f"got {got}",
            f"expected {expected}" if expected else "",
            f"error {error}" if error else "",
            f"allowed {allowed}" if allowed else "",
        ]
        lines.append(f"  {mark:5s} {quantity}: " + ", ".join(part for part in parts if part))
    return "\n".join(lines)


def write_report(results: Iterable[Result], folder) -> Path:
    """Write ``report.html``: one file with all pictures.

    Parameters
    ----------
    results : iterable of Result
        In the order of the report; each is drawn as it comes.
    folder : path
        Made if it does not exist.

    Returns
    -------
    Path
        The report.
    """
    folder = make_folder(folder)
    page = Page(
        "Validation",
        "Every figure was computed by this run; expected values are closed forms or independent "
        "solutions (scipy).",
    )
    summary = page.add("Summary")
    lines = []
    for result in results:
        lines.append(_summary_line(result))
        page.add(result.case.title, *_chapter(result), anchor=result.case.name)
    heads = ["case", "rows", "worst error over allowed", "time (s)", "verdict"]
    summary.parts.append(Table(heads, lines))
    page.provenance = provenance()
    return write_html(page, folder / "report.html")


def _summary_line(result: Result) -> list[str]:
    judged = [row for row in result.rows if row.allowed]
    worst = max((row.error / row.allowed for row in judged), default=0.0)
    verdict = "ok" if result.passed else "FAILS"
    title = result.case.title
    return [title, str(len(result.rows)), f"{worst:.2g}", f"{result.seconds:.1f}", verdict]


def _chapter(result: Result) -> list[Part]:
    case = result.case
    parts: list[Part] = [
        Paragraph(case.formula, markup=True),
        Paragraph(f"*Reference:* {case.reference}", markup=True),
    ]
    if result.trouble:
        parts.append(Paragraph(f"The engine refused: {result.trouble}"))
    if result.rows:
        heads = ["quantity", "expected", "got", "error", "allowed", "verdict"]
        parts.append(Table(heads, [row_cells(row) for row in result.rows]))
        parts.append(Picture(result.outcome.figure, case.title, case.name))
    for table in result.outcome.tables:
        cells = [[number(cell) for cell in line] for line in table.rows]
        parts.append(Table(table.head, cells, table.title))
    return parts
