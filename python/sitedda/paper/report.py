# SPDX-License-Identifier: GPL-3.0-or-later
"""One report of all studies, as HTML in one file and as Markdown with pictures beside it."""

from ..report import Bullets, Page, Paragraph, Picture, Section, Table, provenance
from ..report.page import Part
from .rows import Row, Study, per_cent, show

_LEAD = (
    "Every table and figure of “Site response analysis with two-dimensional numerical discontinuous"
    " deformation analysis method” (2013) that holds a result, run anew with sitedda. Paper values"
    " and formulas of the theory are data with their place in the paper; everything else is"
    " computed by the run that wrote this report."
)
_HEADS = ["quantity", "place", "paper", "theory", "sitedda", "to paper", "to theory",
          "what explains it"]  # fmt: skip


def paper_page(studies: list[Study], seconds: float) -> Page:
    """The report of studies.

    Parameters
    ----------
    studies : list of Study
    seconds : float
        How long the runs took, s.
    """
    reached = [
        ["reached" if asked.reached else "not reached", asked.text, asked.measured]
        for study in studies
        for asked in study.requirements
    ]
    page = Page("The paper's results, reproduced", _LEAD)
    heads = ["", "requirement", "measured"]
    page.add("What it must reach", Table(heads, reached, markup=True), anchor="requirements")
    page.sections += [_section(study) for study in studies]
    page.provenance = provenance(runs=f"{seconds:.0f} s")
    return page


def _section(study: Study) -> Section:
    parts: list[Part] = [Paragraph(text, markup=True) for text in study.text]
    parts += [Picture(p.draw(), p.caption, p.name) for p in study.pictures]
    parts.append(Table(_HEADS, [_cells(row) for row in study.rows], markup=True))
    parts += [Table(table.heads, table.cells, table.title, markup=True) for table in study.tables]
    if study.notes:
        parts.append(Bullets(study.notes, "What differs, and why", markup=True))
    return Section(study.title, parts, study.name)


def _cells(row: Row) -> list[str]:
    return [
        row.quantity,
        row.place,
        show(row.paper, row.digits),
        show(row.theory, row.digits),
        show(row.sitedda, row.digits),
        per_cent(row.from_paper, sign=True),
        per_cent(row.from_theory, sign=True),
        row.why,
    ]
