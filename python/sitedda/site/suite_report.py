# SPDX-License-Identifier: GPL-3.0-or-later
"""Figure and page of a suite of motions."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from ..report import Bullets, Facts, Page, Picture, Table, provenance, write_html
from ..report.layout import headline
from ..report.style import BLUE, FAINT, RED, empty_figure

_MOST = 400  # largest number of curves of cases in a panel


def suite_figure(suite, level: int = 0) -> Figure:
    """Draw amplification and Sa of each analysis: cases, median, and ± σ as a band."""
    table = suite.table.isel(level=level)
    statistics = suite.statistics.isel(level=level)
    names = list(table.analysis.values)
    figure = empty_figure((4.4 * len(names) + 0.6, 7.2))
    axes = figure.subplots(2, len(names), sharex=True, sharey="row", squeeze=False)
    rows = (("amplification", "", "surface/reference Sa"), ("sa", "sa_", "surface Sa (m/s²)"))
    for column, name in enumerate(names):
        for row, (quantity, prefix, label) in enumerate(rows):
            panel, periods = axes[row, column], table.period.values
            cases = table[quantity].sel(analysis=name).transpose("profile", "motion", "period")
            values = cases.values.reshape(-1, periods.size)
            _draw_panel(panel, periods, values, statistics.sel(analysis=name), prefix)
            panel.set(xscale="log", yscale="log")
            for axis in (panel.xaxis, panel.yaxis):
                axis.set(major_locator=LogLocator(subs=(1, 2, 3, 5)), major_formatter="{x:g}",
                         minor_formatter=NullFormatter())  # fmt: skip
            if column == 0:
                panel.set_ylabel(label)
        median = statistics["median"].sel(analysis=name)
        converged = statistics.converged.sel(analysis=name).values
        weak = median[converged < 0.9]  # periods at which over 10 % of the cases do not converge
        if weak.size:
            axes[0, column].plot(weak.period, weak, "x", color=RED, label="not converged")
            axes[0, column].legend(frameon=False, fontsize=8)
        axes[0, column].set_title(name, loc="left", fontsize=11)
        axes[1, column].set_xlabel("period (s)")
    axes[0, 0].legend(frameon=False, fontsize=8)
    counted = f"{table.sizes['profile']} profiles, {table.sizes['motion']} motions, 5 % damping"
    headline(figure, "Suite of motions", counted)
    return figure


def _draw_panel(axes, period, cases, statistics, prefix: str) -> None:
    """Draw the cases, median and band of an analysis."""
    stride = max(1, len(cases) // _MOST)
    axes.plot(period, cases[::stride].T, color=FAINT, lw=0.4, alpha=0.35)
    median = statistics[f"{prefix}median"].values
    factor = np.exp(np.nan_to_num(statistics[f"{prefix}sigma_ln"].values))
    axes.fill_between(
        period, median / factor, median * factor, color=BLUE, alpha=0.2, lw=0, label="± σ"
    )
    axes.plot(period, median, color=BLUE, lw=2.2, label="median")


def write_suite_page(suite, file) -> Path:
    """Write the page of a suite."""
    table = suite.table
    sizes = ", ".join(f"{table.sizes[d]} {d}" for d in ("profile", "motion", "level", "analysis"))
    page = Page("Site response of a suite of motions", f"{table.status.size} cases ({sizes}).")
    if suite.doubts:
        page.add("Doubts", Bullets(suite.doubts))
    tables: dict[str, list[Table]] = {}
    for analysis, level, part in suite.parts():
        heads, *rows = suite.rows_of(part)
        tables.setdefault(level, []).append(Table(heads, rows, analysis))
    for number, (level, below) in enumerate(tables.items()):
        picture = Picture(suite.plot(number), f"Amplification and Sa, {level}", f"suite_{number}")
        page.add(level[0].upper() + level[1:], picture, *below)
    shortest = float(table.period[0])
    peaks = table.reference.isel(level=0, period=0)
    page.add("Motions", Facts([(str(n), f"Sa at {shortest:.3g} s: {value:.4g} m/s²")
                               for n, value in peaks.to_series().items()]))  # fmt: skip
    page.provenance = provenance()
    return write_html(page, file)
