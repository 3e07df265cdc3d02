"""Results as text for the terminal and as one Markdown report with pictures."""

from __future__ import annotations

import math
import platform
from collections.abc import Iterable
from pathlib import Path

from .case import Result, Row, Table


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
    return "ok" if row.passed else "**FAILS**"


def markdown_table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A Markdown table of texts."""
    head = list(head)
    lines = [head, ["---"] * len(head), *rows]
    escaped = ([str(cell).replace("|", "\\|") for cell in line] for line in lines)
    return "\n".join("| " + " | ".join(line) + " |" for line in escaped) + "\n"


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
        mark = mark.strip("*")
        lines.append(f"  {mark:5s} {quantity}: " + ", ".join(part for part in parts if part))
    return "\n".join(lines)


def write_report(results: Iterable[Result], folder, version: str = "") -> Path:
    """Write ``report.md`` and one picture for each case.

    Parameters
    ----------
    results : iterable of Result
        In the order of the report; each is drawn as it comes.
    folder : path
        Made if it does not exist.
    version : str
        Of the engine.

    Returns
    -------
    Path
        The report.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    summary, chapters = [], []
    for result in results:
        summary.append(_summary_line(result))
        chapters.append(_chapter(result, folder))
    head = ["case", "rows", "worst error over allowed", "time (s)", "verdict"]
    text = [
        "# sitedda: validation",
        f"Engine {version}, {platform.system()} {platform.machine()}. Every figure below was "
        "computed by this run; expected values are closed forms or independent solutions (scipy).",
        markdown_table(head, summary),
        *chapters,
    ]
    file = folder / "report.md"
    file.write_text("\n\n".join(text) + "\n", encoding="utf-8")
    return file


def _summary_line(result: Result) -> list[str]:
    judged = [row for row in result.rows if row.allowed]
    worst = max((row.error / row.allowed for row in judged), default=0.0)
    verdict = "ok" if result.passed else "**FAILS**"
    name = f"[{result.case.title}](#{result.case.name})"
    return [name, str(len(result.rows)), f"{worst:.2g}", f"{result.seconds:.1f}", verdict]


def _chapter(result: Result, folder: Path) -> str:
    parts = [
        f'<a id="{result.case.name}"></a>\n\n## {result.case.title}',
        result.case.formula,
        f"*Reference:* {result.case.reference}",
    ]
    if result.trouble:
        parts.append(f"**The engine refused:** {result.trouble}")
    if result.rows:
        head = ["quantity", "expected", "got", "error", "allowed", ""]
        parts.append(markdown_table(head, (row_cells(row) for row in result.rows)))
        picture = f"{result.case.name}.png"
        result.outcome.figure.savefig(folder / picture, dpi=130)
        parts.append(f"![{result.case.title}]({picture})")
    parts += [_table_text(table) for table in result.outcome.tables]
    return "\n\n".join(parts)


def _table_text(table: Table) -> str:
    cells = ([number(cell) for cell in line] for line in table.rows)
    return f"{table.title}\n\n{markdown_table(table.head, cells)}"
