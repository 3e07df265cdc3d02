# SPDX-License-Identifier: GPL-3.0-or-later
"""Reports of results: text for the terminal, and pages in HTML and Markdown."""

import math
from collections.abc import Iterable
from pathlib import Path

from sitedda.base.files import make_folder
from sitedda.report import Bullets, Page, Paragraph, Table, provenance, write_html, write_markdown
from sitedda.report.page import Part

from .case import Collection, Result, Row
from .comparison import Comparison, per_cent, show

_ROW_HEADS = ["quantity", "expected", "computed", "error", "allowed error", "verdict"]
_COMPARISON_HEADS = ["quantity", "source", "paper", "theory", "sitedda", "difference from paper",
                     "difference from theory", "explanation"]  # fmt: skip


def number(value) -> str:
    """Format a number with a readable number of digits."""
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


def format_error(value) -> str:
    """Format an error or a bound with three digits."""
    return "–" if value is None else f"{float(value):.3g}"


def row_cells(row: Row) -> list[str]:
    """Return a row as texts: quantity, expected, computed, error, allowed error, verdict."""
    unit = f" {row.unit}" if row.unit else ""
    expected = "" if row.expected is None else number(row.expected) + unit
    allowed = "" if row.allowed is None else format_error(row.allowed)
    computed, error = number(row.computed) + unit, format_error(row.error)
    if row.kind == "yes or no":
        answer = {0.0: "no", 1.0: "yes"}
        expected = "" if row.description else answer[row.expected]
        computed, error, allowed = row.description or answer[row.computed], "", ""
    elif row.kind == "at most":
        computed, error = format_error(row.computed) + unit, ""
    elif row.kind == "absolute":
        error, allowed = error + unit, allowed and allowed + unit
    verdict = "info" if row.allowed is None else "ok" if row.passed else "FAILS"
    return [row.quantity, expected, computed, error, allowed, verdict]


def terminal_text(result: Result) -> str:
    """Format a result for the terminal."""
    verdict = "ok" if result.passed else "FAILS"
    lines = [f"{result.case.name}: {verdict} ({result.seconds:.1f} s) — {result.case.title}"]
    if result.engine_error:
        lines.append(f"  error: {result.engine_error}")
    for row in result.rows:
        quantity, expected, computed, error, allowed, mark = row_cells(row)
        values = {"computed": computed, "expected": expected, "error": error, "allowed": allowed}
        text = ", ".join(f"{name} {value}" for name, value in values.items() if value)
        lines.append(f"  {mark:5s} {quantity}: {text}")
    return "\n".join(lines)


def write_report(collection: Collection, results: Iterable[Result], folder) -> Path:
    """Write a report as ``NAME.html``, and as ``NAME.md`` with pictures ``NAME/*.png``.

    The results are in the order of the report; the folder is created if it does not exist.

    Returns
    -------
    Path
        Path of the HTML page.
    """
    page = report_page(collection, results)
    folder, name = make_folder(folder), collection.name
    write_markdown(page, folder / f"{name}.md", name)
    return write_html(page, folder / f"{name}.html")


def report_page(collection: Collection, results: Iterable[Result]) -> Page:
    """Return the page of a report: summary, then each result; see `write_report`."""
    page, seconds = Page(collection.title, collection.lead), 0.0
    summary = page.add("Summary")
    case_lines, requirement_lines = [], []
    for result in results:
        seconds += result.seconds
        if result.outcome.comparisons:
            requirement_lines += [_requirement_cells(row) for row in result.rows]
        else:
            case_lines.append(_summary_cells(result))
        page.add(result.case.title, *_result_parts(result), anchor=result.case.name)
    if requirement_lines:
        summary.title, summary.anchor = "Requirements", "requirements"
        summary.parts.append(Table(["", "requirement", "result"], requirement_lines, markup=True))
    if case_lines:
        heads = ["case", "rows", "largest error / allowed error", "time (s)", "verdict"]
        summary.parts.append(Table(heads, case_lines))
    page.provenance = provenance(runs=f"{seconds:.0f} s")
    return page


def _requirement_cells(row: Row) -> list[str]:
    """Return verdict, requirement and result of a row as cells."""
    measured = row.description or f"{per_cent(row.error)}, allowed {per_cent(row.allowed)}"
    return ["met" if row.passed else "not met", row.quantity, measured]


def _summary_cells(result: Result) -> list[str]:
    """Return a result as cells: title, number of rows, largest error ratio, time, verdict."""
    bounded = [row for row in result.rows if row.allowed]
    worst = max((row.error / row.allowed for row in bounded), default=0.0)
    verdict = "ok" if result.passed else "FAILS"
    title = result.case.title
    return [title, str(len(result.rows)), f"{worst:.2g}", f"{result.seconds:.1f}", verdict]


def _result_parts(result: Result) -> list[Part]:
    """Return text, rows, comparison, pictures, tables and notes of a result."""
    case, outcome = result.case, result.outcome
    texts = [case.formula, *outcome.text]
    texts += [f"*Reference:* {case.reference}"] if case.reference else []
    parts: list[Part] = [Paragraph(text, markup=True) for text in texts if text]
    if result.engine_error:
        parts.append(Paragraph(f"error of the engine: {result.engine_error}"))
    if outcome.rows and not outcome.comparisons:
        parts.append(Table(_ROW_HEADS, [row_cells(row) for row in outcome.rows]))
    parts += outcome.pictures
    if outcome.comparisons:
        cells = [_comparison_cells(row) for row in outcome.comparisons]
        parts.append(Table(_COMPARISON_HEADS, cells, markup=True))
    for table in outcome.tables:
        cells = [[number(cell) for cell in line] for line in table.rows]
        parts.append(Table(table.heads, cells, table.title, markup=True))
    if outcome.notes:
        parts.append(Bullets(outcome.notes, "Differences and their causes", markup=True))
    return parts


def _comparison_cells(row: Comparison) -> list[str]:
    """Return a comparison as cells under the heads `_COMPARISON_HEADS`."""
    values = [show(value, row.digits) for value in (row.paper, row.theory, row.sitedda)]
    differences = [per_cent(value, sign=True) for value in (row.from_paper, row.from_theory)]
    return [row.quantity, row.source, *values, *differences, row.cause]
