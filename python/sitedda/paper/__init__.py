# SPDX-License-Identifier: GPL-3.0-or-later
"""Every result of the paper, reproduced: runs, rows beside the printed values, figures, report.

``sitedda paper`` does all studies; ``sitedda paper layers`` one of them.

The paper: "Site response analysis with two-dimensional numerical discontinuous deformation analysis
method" (2013).
"""

import time
from collections.abc import Callable, Iterable
from pathlib import Path

from ..base.files import make_folder
from ..report import write_html, write_markdown
from . import avdat, cantilever, discussion, layers, shear_wave
from .report import paper_page
from .rows import Picture, Requirement, Row, Study, Table
from .runs import run_all

__all__ = ["STUDIES", "Picture", "Requirement", "Row", "Study", "Table", "reproduce", "run_studies"]

STUDIES = {study.NAME: study for study in (cantilever, shear_wave, layers, avdat, discussion)}


def run_studies(
    names: Iterable[str] = (),
    progress: Callable[[int, int], None] | None = None,
    quick: bool = False,
    cores: int = 2,
) -> list[Study]:
    """Run studies and return their results, in the paper's order.

    Parameters
    ----------
    names : iterable of str
        Of `STUDIES`; none: all.
    progress : callable, optional
        Called with how many runs are done and how many there are.
    quick : bool
        Leave out the sensitivities that no requirement needs.
    cores : int
        Processes.

    Raises
    ------
    ValueError
        If there is no study of a name.
    """
    wanted = list(names) or list(STUDIES)
    unknown = [name for name in wanted if name not in STUDIES]
    if unknown:
        raise ValueError(f"there is no study {unknown[0]!r}; known are {', '.join(STUDIES)}")
    chosen = [study for name, study in STUDIES.items() if name in wanted]
    results = run_all((task for study in chosen for task in study.tasks(quick)), progress, cores)
    return [study.study(results) for study in chosen]


def reproduce(
    names: Iterable[str] = (),
    folder: Path | str = "paper_report",
    progress: Callable[[int, int], None] | None = None,
) -> list[Study]:
    """Run studies and write ``paper.html``, ``paper.md`` and ``paper/*.png`` into a folder.

    Parameters
    ----------
    names : iterable of str
        Of `STUDIES`; none: all.
    folder : path
        Made if it is missing.
    progress : callable, optional
        Called with how many runs are done and how many there are.

    Returns
    -------
    list of Study
        Rows, requirements and the rest of what the report shows.
    """
    start = time.monotonic()
    folder = Path(folder)
    studies = run_studies(names, progress)
    page = paper_page(studies, time.monotonic() - start)
    make_folder(folder)
    write_html(page, folder / "paper.html")
    write_markdown(page, folder / "paper.md", "paper")
    return studies
