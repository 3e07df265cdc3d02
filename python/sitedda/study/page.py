# SPDX-License-Identifier: GPL-3.0-or-later
"""Report of a study: parameters, results, failures and requested figures."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from ..base.errors import InputError
from ..base.numbers import counted, number, title_and_unit, with_bar
from ..report import Facts, Page, Paragraph, Picture, Table, provenance, write_html
from .figures import KINDS, arguments_of, known_kind
from .table import BAR, counts

_MOST_ROWS = 60  # largest number of rows of a table
_ROUNDING = 1e-12  # results below this value (SI units) are shown as 0
_HEADS = {"ida": "Incremental dynamic analysis", "map": "Result over two parameters"}  # or kind


def write_report(table, file, figures: Sequence[Mapping] = ()) -> Path:
    """Write the report of a study to one HTML file.

    Parameters
    ----------
    table : xarray.Dataset
        Results of a study.
    file : path
    figures : sequence of mapping
        ``kind``: 'fragility', 'ida', 'tornado', 'sobol', 'map' or 'bands'; ``title``: heading;
        ``select``: values of dimensions to select; arguments of `fragility_of`, `ida`, `tornado`,
        `sobol_indices`, `parameter_map` or `bands`.
    """
    return write_html(report_page(table, figures), file)


def report_page(table, figures: Sequence[Mapping] = ()) -> Page:
    """Return the page of a study, see `write_report`."""
    sizes = " × ".join(f"{table.sizes[d]} {d}" for d in table.status.dims)
    summary = ", ".join(f"{number} {status}" for status, number in sorted(counts(table).items()))
    introduction = f"{counted(table.status.size, 'case', 'cases')} ({sizes}): {summary}."
    page = Page(f"Study of {table.attrs.get('model', '')}".strip(), introduction)
    page.add("Parameters", _parameter_table(table))
    sentences = [_add_figure(page, table, dict(values)) for values in figures]
    page.lead = " ".join([*(f"{sentence}." for sentence in sentences if sentence), page.lead])
    page.add("Results", _number_table(table))
    for title, cases, column in (("Failed cases", table.status.values == "failed", "message"),
                                 ("Warnings", table.warning.values != "" if "warning" in table
                                  else np.zeros(table.status.shape, bool), "warning")):  # fmt: skip
        if np.any(cases):
            page.add(title, _text_table(table, cases, column))
    fixed = str(table.attrs.get("fixed", ""))
    page.provenance = provenance(
        model=str(table.attrs.get("model", "")),
        changed_in_all_cases="" if fixed == "{}" else fixed,
        computed_by=str(table.attrs.get("program", "")),
    )
    return page


def _parameter_table(table) -> Table:
    """Tabulate name, changed variable, unit and values of each parameter."""
    rows = []
    for name, coordinate in table.coords.items():
        if set(coordinate.dims) <= set(table.status.dims) and coordinate.dims:
            values = np.asarray(coordinate.values).ravel()
            listing = ", ".join(map(_format_value, values[:8])) + " …" * (values.size > 8)
            changes, unit = (str(coordinate.attrs.get(key, "")) for key in ("changes", "units"))
            rows.append([name, changes, unit.replace("^2", "²"), str(values.size), listing])
    return Table(["parameter", "variable of the input", "unit", "count", "values"], rows)


def _number_table(table) -> Table:
    """Tabulate smallest, median and largest value of each result over all cases."""
    rows = []
    for name, result in table.data_vars.items():
        if result.dims != table.status.dims or result.dtype.kind != "f":
            continue
        name = str(name)
        if name.endswith(BAR) and name.removesuffix(BAR) in table:
            continue
        values = result.values[np.isfinite(result.values)]
        if not values.size:
            continue
        stats = [*map(_format_value, (values.min(), np.median(values), values.max()))]
        if f"{name}{BAR}" in table:
            bars = table[f"{name}{BAR}"].values[np.isfinite(result.values)]
            for end, index in ((0, values.argmin()), (2, values.argmax())):
                stats[end] = with_bar(values[index], bars[index])
        title, unit = title_and_unit(name)
        rows.append([title, unit, *stats, str(values.size)])
    return Table(["quantity", "unit", "least", "median", "largest", "cases"], rows)


def _text_table(table, cases: np.ndarray, column: str) -> Table:
    """Tabulate a text, such as the message, of the cases that `cases` selects."""
    rows = []
    for index in list(zip(*np.nonzero(cases), strict=True))[:_MOST_ROWS]:
        settings = [_format_value(table[d].values[i]) if d in table.coords else str(i)
                 for d, i in zip(table.status.dims, index, strict=True)]  # fmt: skip
        rows.append([*settings, str(table[column].values[index])])
    return Table([*map(str, table.status.dims), column], rows)


def _add_figure(page: Page, table, values: dict) -> str:
    """Add a figure to the page; return its conclusion (only fragility figures have one)."""
    kind = known_kind(values.pop("kind", None))
    title = values.pop("title", "") or _HEADS.get(kind, kind.capitalize())
    select = values.pop("select", {})
    arguments_of(kind, values)
    try:
        selected = table.sel(**select)
        figure = KINDS[kind](selected, **values)
    except KeyError as trouble:
        raise InputError(f"[[figures]] of kind {kind!r}: the table has no {trouble}") from None
    except InputError as error:  # the page contains the message instead of the picture
        page.add(title, Paragraph(f"Not drawn: {error}."))
        return ""
    except (TypeError, ValueError, IndexError) as trouble:
        raise InputError(f"[[figures]] of kind {kind!r}: {trouble}") from None
    caption = f"{kind}: {title_and_unit(str(values.get('quantity', '')))[0]}"
    facts = [(name, text) for name, text in _describe_figure(figure) if text]
    page.add(title, Picture(figure.picture(), caption, kind), Facts(facts))
    return getattr(figure, "words", "")


def _describe_figure(figure) -> list[tuple[str, str]]:
    """Return the numbers of a figure as names and texts."""
    if hasattr(figure, "dispersion"):
        low, high = figure.median_interval
        lowest, highest = figure.dispersion_interval
        unit = figure.unit.replace("^2", "²")
        return [
            ("median", f"{figure.median:.3g} {unit} ({low:.3g} … {high:.3g})"),
            ("dispersion β", f"{figure.dispersion:.3g} ({lowest:.3g} … {highest:.3g})"),
            ("confidence", f"{figure.confidence:.0%}"),
            ("warning", figure.doubt),
        ]
    if hasattr(figure, "failures"):
        low, high = figure.bounds
        rows = zip(figure.intensity, figure.failures, figure.trials, low, high, strict=True)
        levels = [(f"{figure.name} {x:.4g}",
                   f"{k:g} of {n:g} fail; probability of failure {a:.2g} … {b:.2g}")
                  for x, k, n, a, b in rows]  # fmt: skip
        return [*levels, ("no curve", figure.why), ("warning", figure.doubt)]
    if hasattr(figure, "capacity"):
        text = ", ".join(_format_value(v) for v in figure.capacity_fractiles)
        return [("capacity, fractiles 16, 50, 84 %", text if figure.threshold is not None else "")]
    if hasattr(figure, "total"):
        text = "index of first order {:.4f}, total index {:.4f}"
        return [(name, text.format(first, total)) for name, first, total in
                zip(figure.names, figure.first, figure.total, strict=True)]  # fmt: skip
    if hasattr(figure, "swing"):
        return [(name, f"{change:.4g}") for name, change in
                zip(figure.names, figure.swing, strict=True)]  # fmt: skip
    return []


def _format_value(value) -> str:
    if not isinstance(value, float | np.floating):
        return str(value)
    return number(0.0 if abs(value) < _ROUNDING else value, 5)
